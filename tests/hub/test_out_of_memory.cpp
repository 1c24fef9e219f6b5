// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Memory runs out during commands. The scene is unchanged, the server goes on, and its session
// records every command that was done.

#include <gtest/gtest.h>
#include <pliant/session.h>

#include <condition_variable>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>

#include "hub/hub.h"
#include "hub/random_session.h"
#include "protocol/limits.h"
#include "session/replay.h"
#include "support/count_allocations.h"
#include "support/each_allocation.h"
#include "support/json.h"
#include "support/temporary_folder.h"

namespace pliant::serve {
namespace {

using test::FailingAllocation;
using test::Json;

std::string description_of(const Scene& scene) {
    SharedState state;
    scene.describe(state);
    return state_text(state) + std::to_string(scene.last_client()) + "," +
           std::to_string(scene.steps());
}

TissueCommand springs() {
    TissueCommand command;
    command.choice = {.model = "springs",
                      .nodes = 6,
                      .springs = {.cell_mm = 5, .fixed_hu = 3000},
                      .given = {"fixed_hu"}};
    return command;
}

/// Records as the hub does.
struct Recorder {
    Scene& scene;
    std::vector<SessionRecord> records{};
    int ran_out = 0, ended = 0, lost = 0;

    Outcome act(std::uint32_t client, const Action& action, std::int64_t fails_at) {
        SessionCommand record{client, action, false};
        Outcome outcome;
        if (fails_at >= 0) {
            const FailingAllocation failing(fails_at);
            outcome = scene.carry_out(client, action);
        } else {
            outcome = scene.carry_out(client, action);
        }
        record.refused = !outcome.ok();
        ran_out += outcome.ran_out;
        ended += outcome.ended_step;
        if (!outcome.ran_out)
            records.push_back(std::move(record));
        else if (outcome.ended_step)
            records.push_back(SessionBreak{client});
        note_lost();
        return outcome;
    }
    void sweep(std::int64_t fails_at) {
        bool ok = false;
        if (fails_at >= 0) {
            const FailingAllocation failing(fails_at);
            ok = scene.sweep().ok();
        } else {
            ok = scene.sweep().ok();
        }
        ran_out += !ok;
        if (ok) records.push_back(SessionSweeps{1});
        note_lost();
    }
    void update(std::int64_t fails_at) {
        const FailingAllocation failing(fails_at);
        ran_out += !scene.update().ok();
    }
    void mark() {
        ASSERT_TRUE(scene.update().ok());
        records.push_back(SessionMark{hash_volume(scene.deformed()), scene.tissue().hash()});
    }

  private:
    void note_lost() {
        if (!scene.take_lost()) return;
        ++lost;
        records.push_back(SessionLost{scene.steps()});
    }
};

TEST(OutOfMemory, RandomSessionsAreReplayedToTheSameScene) {
    int ran_out = 0, ended = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(1);
        const auto scene = open_scene(arena);
        Recorder recorder{*scene};
        recorder.records.push_back(SessionCommand{9, soft()});
        const auto fails_at = [&]() -> std::int64_t {
            return random.whole(0, 2) ? random.whole(0, random.whole(0, 1) ? 20 : 300) : -1;
        };
        for (int n = 0; n < 60; ++n) {
            Action action = random_action(*scene, random);
            if (random.whole(0, 5) == 0) action = UndoCommand{};
            if (random.whole(0, 8) == 0) action = RedoCommand{};
            if (random.whole(0, 15) == 0) action = ResetCommand{};
            if (random.whole(0, 15) == 0) action = springs();
            if (random.whole(0, 30) == 0) action = TissueCommand{};
            recorder.act(std::uint32_t(random.whole(1, 4)), action, fails_at());
            for (int k = 0; k < 3 && scene->wants_sweep(); ++k) recorder.sweep(fails_at());
            recorder.update(random.whole(0, 50));
            if (n % 6 == 0) recorder.mark();
        }
        recorder.mark();
        ran_out += recorder.ran_out;
        ended += recorder.ended;
        const auto again = Scene::open(kCube, arena);
        ASSERT_TRUE(again.ok());
        const Status replayed = replay_into(**again, recorder.records, Compare::All);
        ASSERT_TRUE(replayed.ok()) << replayed.error().message;
        ASSERT_EQ(description_of(**again), description_of(*scene));
    }
    EXPECT_GT(ran_out, 100);
    EXPECT_GT(ended, 10);
}

TEST(OutOfMemory, EachAllocationOfEachCommandLeavesTheTissueAsItWas) {
    const TaskArena arena(1);
    const Vec3d at{20, 20, 20};
    const std::vector<std::pair<const char*, Action>> commands = {
        {"push", PushCommand{.push = {at, {2, 1, 0}, 3}}},
        {"stroke", PushCommand{.push = {at, {0, 1, 2}, 3}, .stroke = 7}},
        {"slide", PushCommand{.push = {{20, 20, 2}, {0, 0, 4}, 2}, .slide = true}},
        {"grab", GrabCommand{.place = {at, {0, 0, 0}, 3}, .reach_mm = 10}},
        {"cut", CutCommand{{.line_mm = {at, at + Vec3d{5, 0, 0}}, .depth_mm = {0, 0, 6}}}},
        {"carve", CarveCommand{.tool = {.from_mm = at, .to_mm = at, .radius_mm = 2}}},
        {"reset", ResetCommand{}},
        {"undo", UndoCommand{}},
        {"iso", IsoCommand{.iso_hu = 321}},
        {"materials",
         [] {
             MaterialsCommand materials = soft();
             materials.values.emplace_back("offset", 0.15);
             return materials;
         }()},
        {"eye", EyeCommand{at, 2}},
        {"tissue", springs()},
    };
    const auto make = [&] {
        auto scene = open_scene(arena);
        EXPECT_TRUE(scene->carry_out(1, PushCommand{.push = {at, {3, 0, 0}, 3}}).ok());
        EXPECT_TRUE(scene->carry_out(1, PushCommand{.push = {at, {0, 3, 0}, 3}, .stroke = 7}).ok());
        return scene;
    };
    for (const auto& [name, action] : commands) {
        SCOPED_TRACE(name);
        const auto operation = [&](Scene& scene) -> Status {
            Outcome outcome = scene.carry_out(1, action);
            if (outcome.ok()) return Ok{};
            return Error{outcome.ran_out ? ErrorCode::LimitExceeded : ErrorCode::InvalidArgument,
                         {}};
        };
        const auto state = [](Scene& scene) {
            return std::tuple(scene.tissue().hash(), scene.choice().model);
        };
        const test::Failures failures = test::fail_each_allocation(
            make, operation, state, {.all_up_to = 60, .of_the_rest = 20});
        EXPECT_GT(failures.failed, 0);
    }
}

/// Keeps the hub's frames, as a network would.
class Texts : public Outlet {
  public:
    void send(ConnectionId, std::vector<Outgoing> batch) override {
        {
            const std::lock_guard lock(m_mutex);
            m_messages.reserve(m_messages.size() + batch.size());
            for (Outgoing& message : batch) m_messages.push_back(std::move(message));
            m_sent = true;
        }
        m_wake.notify_all();
    }
    void close(ConnectionId, int code, const std::string&) override { m_closed = code; }
    void taken(ConnectionId) override {}

    /// Answer to a command; acknowledges frames that are sent meanwhile.
    Json answer(Hub& hub, std::uint32_t id) {
        const auto end = Clock::now() + std::chrono::seconds(20);
        for (;;) {
            std::vector<Outgoing> messages;
            {
                std::unique_lock lock(m_mutex);
                if (!m_wake.wait_until(lock, end, [&] { return m_sent; })) return {};
                m_sent = false;
                messages.swap(m_messages);
            }
            hub.written(1);
            Json found;
            for (const Outgoing& message : messages) {
                if (!message.is_text) {
                    see(hub, *message.bytes);
                    continue;
                }
                const Json json = Json::parse(*message.bytes);
                if (json.contains("id") && json["id"] == id) found = json;
            }
            if (!found.is_null()) return found;
        }
    }
    int closed() const { return m_closed; }

  private:
    /// Tells that the last box of a step was seen.
    static void see(Hub& hub, const std::string& frame) {
        std::uint16_t format = 0;
        std::uint32_t step = 0;
        std::memcpy(&format, frame.data() + 6, sizeof(format));
        std::memcpy(&step, frame.data() + 8, sizeof(step));
        if (FrameType(frame[4]) == FrameType::Box && (frame[5] & kFrameLastOfStep) != 0)
            hub.received(1, {0, SeenMessage{step, format}});
    }

    std::mutex m_mutex;
    std::condition_variable m_wake;
    std::vector<Outgoing> m_messages;
    bool m_sent = false;
    std::atomic<int> m_closed = 0;
};

TEST(OutOfMemory, AServerGoesOnAndItsSessionIsReplayed) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const test::TemporaryFolder folder;
        const TaskArena arena(1);
        Random random(seed);
        auto scene = Scene::open(kCube, arena).value();
        const Scene* const positions = scene.get();  // of the scan, which stays
        auto log = SessionLog::create(folder.path() / "s.pls", {kCube, scene->scan_hash()}).value();
        Hub hub(std::move(scene), std::move(log), 200);
        hub.keep_checkpoints(0.02, 0);
        Texts texts;
        std::jthread owner([&](const std::stop_token& stop) { hub.run(stop, texts); });
        hub.opened(1, true);
        hub.received(1, {0, HelloMessage{.protocol = kProtocolVersion}});
        std::uint32_t id = 0;
        int refused = 0, done = 0;
        hub.received(1, {++id, soft()});
        ASSERT_EQ(texts.answer(hub, id)["t"], "done");
        for (int n = 0; n < 120; ++n) {
            Action action = random_action(*positions, random);
            switch (random.whole(0, 12)) {
                case 0:
                    action = UndoCommand{};
                    break;
                case 1:
                    action = springs();
                    break;
                case 2:
                    action = TissueCommand{};
                    break;
                case 3:
                    action = OverlayMessage{OverlayKind::Displacement};
                    break;
                case 4:
                    action = PathMessage{.from_mm = {5, 5, 5}, .to_mm = {30, 30, 30}};
                    break;
                case 5:
                    action = RestMessage{n % 3 > 0};
                    break;
                default:
                    break;
            }
            hub.received(1, {++id, action});
            {
                // Destructors of nlohmann::json allocate, and end the process where they can't: the
                // program keeps a reserve for small allocations.
                constexpr std::size_t kSmall = 1024;
                const FailingAllocation failing(random.whole(0, 12), kSmall);
                const auto end = Clock::now() + std::chrono::milliseconds(random.whole(2, 12));
                while (Clock::now() < end) std::this_thread::yield();
            }
            const Json answer = texts.answer(hub, id);
            ASSERT_FALSE(answer.is_null()) << "command " << n;
            (answer["t"] == "error" ? refused : done) += 1;
            if (answer.value("code", "") == "limit" && answer["do"] != "overlay" &&
                answer["do"] != "rest") {
                EXPECT_NE(answer.value("message", "").find("out of memory"), std::string::npos)
                    << answer.dump();
            }
        }
        EXPECT_GT(done, 10);
        EXPECT_GT(refused, 10);
        EXPECT_EQ(texts.closed(), 0);
        hub.received(1, {++id, ChecksumMessage{}});
        const Json sums = texts.answer(hub, id);
        EXPECT_EQ(sums["t"], "checksum");
        owner.request_stop();
        owner.join();
        const auto report = replay_session(folder.path() / "s.pls", arena);
        ASSERT_TRUE(report.ok()) << report.error().message;
        EXPECT_GE(report->marks, 2);  // that of the checksum, and the last one
    }
}

}  // namespace
}  // namespace pliant::serve
