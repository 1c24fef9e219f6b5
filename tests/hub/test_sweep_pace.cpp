// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A command ends a sweep under way, and the sweep goes on later.

#include "hub/sweep_pace.h"

#include <gtest/gtest.h>
#include <pliant/deformation.h>

#include <functional>

#include "hub/inbox.h"
#include "session/replay.h"

namespace pliant::serve {
namespace {

constexpr std::int64_t kParts = 1000;

/// A tissue whose sweep has many parts, as a large scan's. It calls `at` before each of them.
class SlowTissue final : public NodeTissue {
  public:
    struct Log {
        std::int64_t made = 0;  ///< parts of all sweeps
        std::function<void(std::int64_t)> at;
    };

    SlowTissue(const Volume& scan, const TaskArena& arena, Log& log)
        : m_scan(scan),
          m_arena(arena),
          m_log(log),
          m_deformation(Deformation::create(scan.grid).value()) {}

    TissueTraits traits() const noexcept override { return {.moves_by_itself = true}; }
    Result<PushReport> push(std::uint32_t, const Push&) noexcept override {
        PushReport report;
        report.status = PushStatus::Applied;
        report.moved_elements = 1;
        return report;
    }
    void release(std::uint32_t) noexcept override {}
    bool is_touched_by(std::uint32_t) const noexcept override { return false; }
    bool is_touched() const noexcept override { return false; }
    Result<Sweep> sweep() noexcept override { return sweep_part({}); }
    Result<Sweep> sweep_part(const SweepLimit& limit) noexcept override {
        std::int64_t made = 0;
        while (m_log.made % kParts + made < kParts) {
            if (m_log.at) m_log.at(m_log.made + made);
            // Time is over after ten parts.
            if (made >= limit.max_parts || limit.stop.stop_requested() ||
                (limit.max_ms < 50 && made >= 10))
                break;
            ++made;
        }
        m_log.made += made;
        Sweep sweep{.settled = false, .message = {}};
        if (m_log.made % kParts) sweep.parts = made;
        return sweep;
    }
    Status reset() noexcept override { return Ok{}; }
    void state(std::vector<double>& numbers) const override { numbers = {double(m_log.made)}; }
    Status set_state(std::span<const double>) noexcept override { return Ok{}; }

    const Volume& volume() const override { return m_scan; }
    const Deformation& deformation() const override { return m_deformation; }
    const TaskArena& arena() const override { return m_arena; }

  private:
    const Volume& m_scan;
    const TaskArena& m_arena;
    Log& m_log;
    Deformation m_deformation;
};

std::unique_ptr<Scene> open(const TaskArena& arena, SlowTissue::Log& log) {
    SceneSource source{.phantom = "cube", .phantom_size = {8, 8, 8}};
    source.own_tissue = std::make_shared<const MakeTissue>(
        [&log](const Volume& scan, const TaskArena& on) -> Result<std::unique_ptr<Tissue>> {
            return std::unique_ptr<Tissue>(std::make_unique<SlowTissue>(scan, on, log));
        });
    auto scene = Scene::open(source, arena);
    EXPECT_TRUE(scene.ok());
    const PushCommand push{.push = {{0, 0, 0}, {0, 0, 1}, 2}};
    EXPECT_TRUE((*scene)->carry_out(1, push).ok());
    return std::move(*scene);
}

Event command() {
    return {1, Message{1, PushCommand{}}};
}

TEST(SweepPace, CommandEndsASweepUnderWayAndItGoesOnLater) {
    const TaskArena arena(1);
    SlowTissue::Log log;
    const auto scene = open(arena, log);
    Inbox inbox;
    Recorder recorder(nullptr);
    SweepPace pace;
    log.at = [&](std::int64_t part) {
        if (part == 123) inbox.post(command());
    };
    auto stop = inbox.stop_at_command();
    auto sweeps = pace.relax(*scene, recorder, Clock::now(), stop.get_token());
    EXPECT_EQ(sweeps.made[0].count, 0);
    EXPECT_EQ(sweeps.made[0].parts, 10);
    EXPECT_EQ(sweeps.made[1].count, 0);
    EXPECT_EQ(sweeps.made[1].parts, 113);
    EXPECT_EQ(log.made, 123);
    // Those that wait allow a little each time.
    stop = inbox.stop_at_command();
    sweeps = pace.relax(*scene, recorder, Clock::now(), stop.get_token());
    EXPECT_EQ(sweeps.made[0].parts, 10);
    EXPECT_EQ(sweeps.made[1].parts, std::nullopt);
    inbox.take();
    stop = inbox.stop_at_command();
    EXPECT_FALSE(stop.stop_requested());
    sweeps = pace.relax(*scene, recorder, Clock::now(), stop.get_token());
    EXPECT_EQ(sweeps.made[0].parts, 10);
    EXPECT_EQ(sweeps.made[1].count, 1);
    EXPECT_EQ(log.made, kParts);
}

TEST(SweepPace, OtherMessagesEndNoSweep) {
    Inbox inbox;
    const auto stop = inbox.stop_at_command();
    inbox.post({1, Message{1, SeenMessage{}}});
    inbox.post({1, Message{2, PingMessage{}}});
    EXPECT_FALSE(stop.stop_requested());
    inbox.post(command());
    EXPECT_TRUE(stop.stop_requested());
}

TEST(SweepPace, RecordedPartsAreRepeated) {
    const TaskArena arena(1);
    SlowTissue::Log log;
    const auto scene = open(arena, log);
    const auto text = text_of(SessionRecord(SessionSweeps{.count = 2, .parts = 17}));
    const auto record = parse_session_record(text);
    ASSERT_TRUE(record.ok()) << text;
    ASSERT_TRUE(sweep_recorded(*scene, std::get<SessionSweeps>(*record)).ok());
    EXPECT_EQ(log.made, 2 * kParts + 17);
    const auto refused = [](const char* line) {
        const auto parsed = parse_session_record(line);
        return parsed.ok() ? std::string() : parsed.error().message;
    };
    EXPECT_NE(refused(R"({"do":"sweep","count":0})"), "");
    EXPECT_NE(refused(R"({"do":"sweep","count":1,"parts":-1})"), "");
    EXPECT_EQ(refused(R"({"do":"sweep","count":0,"parts":0})"), "");
}

}  // namespace
}  // namespace pliant::serve
