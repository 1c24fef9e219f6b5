// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Memory runs out. A command without memory is refused, and the scene is unchanged; a client
// without memory for its messages is dropped, and may come back. The server goes on, and its
// session records every command that was done.
// Covers: hub/hub.cpp, hub/device_feed.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>

#include <condition_variable>
#include <cstring>
#include <mutex>
#include <new>
#include <optional>
#include <thread>

#include "base/byte_order.h"
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

    void act(std::uint32_t client, const Action& action, std::int64_t fails_at) {
        SessionRecord record = SessionCommand{client, action, false};
        try {
            std::optional<FailingAllocation> failing;
            if (fails_at >= 0) failing.emplace(fails_at);
            std::get<SessionCommand>(record).refused = !scene.carry_out(client, action).ok();
        } catch (const std::bad_alloc&) {
            record = SessionBreak{client};
            ++ended;
        }
        records.push_back(std::move(record));
        note_lost();
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
    EXPECT_GT(ran_out, 50);  // sweeps and updates
    EXPECT_GT(ended, 50);
}

TEST(OutOfMemory, EachAllocationOfEachCommandLeavesTheTissueAsItWas) {
    const TaskArena arena(1);
    const Vec3d at{20, 20, 20};
    const std::vector<std::pair<const char*, Action>> commands = {
        {"push", PushCommand{.push = {at, {2, 1, 0}, 3}}},
        {"stroke", PushCommand{.push = {at, {0, 1, 2}, 3}, .stroke = 7}},
        {"slide", PushCommand{.push = {{20, 20, 2}, {0, 0, 4}, 2}, .slide = true}},
        {"grab", GrabCommand{.position = {at, {0, 0, 0}, 3}, .reach_mm = 10}},
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
            try {
                if (scene.carry_out(1, action).ok()) return Ok{};
            } catch (const std::bad_alloc&) {
                return Error{ErrorCode::LimitExceeded, {}};
            }
            return Error{ErrorCode::InvalidArgument, {}};
        };
        const auto state = [](Scene& scene) {
            return std::tuple(scene.tissue().hash(), scene.choice().model);
        };
        const test::Failures failures = test::fail_each_allocation(
            make, operation, state, {.all_up_to = 60, .of_the_rest = 20});
        EXPECT_GT(failures.failed, 0);
    }
}

/// The network of one client, which acknowledges all that it gets. Calls may find no memory.
class Line : public Outlet {
  public:
    explicit Line(Hub& hub) : m_hub(hub) {}
    void send(ConnectionId connection, std::vector<Outgoing> batch) override {
        fail(failing_sends);
        const std::lock_guard lock(m_mutex);
        m_messages.reserve(m_messages.size() + batch.size());
        if (connection == m_connection)
            for (Outgoing& message : batch) m_messages.push_back(std::move(message));
        m_wake.notify_all();
    }
    void close(ConnectionId connection, int code, const std::string&) override {
        fail(failing_closes);
        const std::lock_guard lock(m_mutex);
        if (connection == m_connection) m_closed = code;
        m_wake.notify_all();
    }
    void taken(ConnectionId) override { fail(failing_taken); }

    /// Connects the client, again with its secret. @returns the welcome
    Json come() {
        {
            const std::lock_guard lock(m_mutex);
            if (m_connection) m_hub.post({m_connection, Event::Closed{}});
            ++m_connection;
            m_closed = 0;
            m_messages.clear();
        }
        m_hub.post({m_connection, Event::Opened{true}});
        say(0, HelloMessage{.protocol = kProtocolVersion, .resume = m_secret});
        const Json welcome = until([](const Json& t) { return t["t"] == "welcome"; });
        if (!welcome.is_null()) m_secret = welcome["resume"];
        return welcome;
    }
    void say(std::uint32_t id, Action action) {
        m_hub.post({m_connection, Message{id, std::move(action)}});
    }
    /// Answer to a command; null if the connection was closed instead.
    Json answer(std::uint32_t id) {
        return until([&](const Json& t) { return t.contains("id") && t["id"] == id; });
    }
    Json command(std::uint32_t id, Action action) {
        say(id, std::move(action));
        return answer(id);
    }
    /// Code with which the connection was closed; 0: it is open.
    int closed() const { return m_closed; }

    std::atomic<int> failing_sends = 0, failing_closes = 0, failing_taken = 0;  ///< the next ones

  private:
    static void fail(std::atomic<int>& left) {
        if (left == 0) return;
        --left;
        throw std::bad_alloc();
    }
    template <class Is>
    Json until(const Is& is) {
        const auto end = Clock::now() + std::chrono::seconds(20);
        for (;;) {
            std::vector<Outgoing> messages;
            {
                std::unique_lock lock(m_mutex);
                if (!m_wake.wait_until(lock, end, [&] { return m_closed || !m_messages.empty(); }))
                    return {};
                if (m_closed) return {};
                messages.swap(m_messages);
            }
            m_hub.post({m_connection, Event::Written{}});
            Json found;
            for (const Outgoing& message : messages) {
                if (!message.is_text) {
                    see(*message.bytes);
                    continue;
                }
                const Json json = Json::parse(*message.bytes);
                if (is(json)) found = json;
            }
            if (!found.is_null()) return found;
        }
    }
    /// Tells that the last box of a step was seen.
    void see(const std::string& frame) {
        std::uint16_t format = 0;
        std::uint32_t step = 0;
        std::memcpy(&format, frame.data() + 6, sizeof(format));
        std::memcpy(&step, frame.data() + 8, sizeof(step));
        if (FrameType(frame[4]) == FrameType::Box && (frame[5] & kFrameLastOfStep) != 0)
            say(0, SeenMessage{little_endian(step), little_endian(format)});
    }

    Hub& m_hub;
    ConnectionId m_connection = 0;
    std::string m_secret;
    std::mutex m_mutex;
    std::condition_variable m_wake;
    std::vector<Outgoing> m_messages;
    std::atomic<int> m_closed = 0;
};

/// A server without a network, which records a session.
struct Owner {
    explicit Owner(double checkpoint_s = 0) {
        auto scene = Scene::open(kCube, arena).value();
        auto log = SessionLog::create(session, {kCube, scene->scan_hash()}).value();
        hub.emplace(std::move(scene), std::move(log), 200);
        if (checkpoint_s > 0) hub->keep_checkpoints(checkpoint_s, 0);
        line.emplace(*hub);
        thread = std::jthread([&](const std::stop_token& stop) { hub->run(stop, *line); });
    }
    /// Ends the server. @returns the report of a replay
    Result<ReplayReport> replay() {
        thread.request_stop();
        thread.join();
        return replay_session(session, arena);
    }

    const test::TemporaryFolder folder;
    const std::filesystem::path session = folder.path() / "s.pls";
    const TaskArena arena{1};
    std::optional<Hub> hub;
    std::optional<Line> line;
    std::jthread thread;
};

TEST(OutOfMemory, AClientWhoseBatchCannotBeSentIsDroppedAndComesBack) {
    Owner owner;
    Line& line = *owner.line;
    const Json first = line.come();
    ASSERT_EQ(line.command(1, soft())["t"], "done");
    line.failing_sends = 1;
    line.failing_closes = 3;  // it is tried again
    EXPECT_TRUE(line.command(2, PushCommand{.push = {{0, 0, 0}, {0, 3, 0}, 4}}).is_null());
    EXPECT_EQ(line.closed(), kCloseStalled);
    EXPECT_EQ(line.failing_closes, 0);
    const Json again = line.come();
    ASSERT_FALSE(again.is_null());
    EXPECT_EQ(again["client"], first["client"]);
    EXPECT_EQ(again["resumed"], false);
    // The push was made, although nobody was told.
    EXPECT_EQ(line.command(3, UndoCommand{})["t"], "done");
    EXPECT_EQ(line.command(4, ChecksumMessage{})["t"], "checksum");
    EXPECT_EQ(line.closed(), 0);
    const auto report = owner.replay();
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_GE(report->commands, 3);
    EXPECT_GE(report->marks, 2);
}

TEST(OutOfMemory, AnEventWithoutMemoryIsProcessedLater) {
    Owner owner;
    Line& line = *owner.line;
    line.failing_taken = 3;
    ASSERT_FALSE(line.come().is_null());
    line.failing_taken = 3;
    EXPECT_EQ(line.command(1, soft())["t"], "done");
    EXPECT_EQ(line.failing_taken, 0);
    EXPECT_EQ(line.closed(), 0);
}

TEST(OutOfMemory, AServerGoesOnAndItsSessionIsReplayed) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Owner owner(0.02);
        Line& line = *owner.line;
        const TaskArena arena(1);
        const auto positions = Scene::open(kCube, arena).value();
        ASSERT_FALSE(line.come().is_null());
        std::uint32_t id = 0;
        int refused = 0, done = 0, dropped = 0;
        ASSERT_EQ(line.command(++id, soft())["t"], "done");
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
            line.say(++id, action);
            {
                // Destructors of nlohmann::json allocate, and end the process where they can't: the
                // program keeps a reserve for small allocations.
                constexpr std::size_t kSmall = 1024;
                const FailingAllocation failing(random.whole(0, 12), kSmall);
                const auto end = Clock::now() + std::chrono::milliseconds(random.whole(2, 12));
                while (Clock::now() < end) std::this_thread::yield();
            }
            const Json answer = line.answer(id);
            if (answer.is_null()) {
                ASSERT_EQ(line.closed(), kCloseStalled) << "command " << n;
                ASSERT_FALSE(line.come().is_null()) << "command " << n;
                ++dropped;
                continue;
            }
            (answer["t"] == "error" ? refused : done) += 1;
            if (answer.value("code", "") == "limit" && answer["do"] != "overlay" &&
                answer["do"] != "rest") {
                EXPECT_NE(answer.value("message", "").find("out of memory"), std::string::npos)
                    << answer.dump();
            }
        }
        EXPECT_GT(done, 10);
        EXPECT_GT(refused + dropped, 10);
        Json sums;
        for (int n = 0; sums.is_null() && n < 3; ++n) {
            sums = line.command(++id, ChecksumMessage{});
            if (sums.is_null()) {
                ASSERT_FALSE(line.come().is_null());  // it was dropped late
            }
        }
        EXPECT_EQ(sums["t"], "checksum");
        const auto report = owner.replay();
        ASSERT_TRUE(report.ok()) << report.error().message;
        EXPECT_GE(report->marks, 2);  // that of the checksum, and the last one
    }
}

}  // namespace
}  // namespace pliant::serve
