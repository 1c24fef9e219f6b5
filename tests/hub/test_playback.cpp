// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A recorded session that is watched, forward, backward and at another speed. The oracle are the
// checksums while it was recorded.
// Covers: hub/playback_feed.cpp, session/timeline.cpp.

#include <gtest/gtest.h>
#include <pliant/serve.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "hub/test_client.h"
#include "session/timeline.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

class Watched : public ::testing::Test {
  protected:
    /// Records strokes, an undo, a threshold and relaxation. @returns the checksums of the volume
    /// before, after each and at the end
    std::vector<Json> record() {
        auto server = Server::start(
            {.phantom_size = {32, 32, 32}, .session = m_session, .checkpoint_s = 0}, m_arena);
        EXPECT_TRUE(server.ok()) << server.error().message;
        TestClient client(server->port(), server->link());
        client.enter();
        std::vector<Json> sums = {client.checked_checksum()["volume"]};
        const auto act = [&](Json command) {
            // So that the times of two commands differ.
            std::this_thread::sleep_for(std::chrono::milliseconds(250));
            EXPECT_EQ(client.command(std::move(command))["t"], "done");
            sums.push_back(client.checked_checksum()["volume"]);
        };
        act(push(0, 1));
        act(push(8, 2));
        act({{"do", "undo"}});
        act({{"do", "iso"}, {"iso_hu", -400}});
        act({{"do", "cut"}, {"line", {{-5, -5, 0.3}, {5, -5, 0.3}}}, {"depth", {0, 10, 0}}});
        act(push(-8, 3));
        return sums;
    }
    static Json push(double x, int stroke) {
        return {{"do", "push"},
                {"point", {x, 0, 0}},
                {"push", {0, 2, 0}},
                {"radius", 4},
                {"stroke", stroke}};
    }
    /// Jumps to a time. @returns the checksum there
    static Json at(TestClient& client, double ms) {
        const Json answer = client.command({{"do", "replay"}, {"at_ms", ms}, {"playing", false}});
        EXPECT_EQ(answer["t"], "done") << answer;
        const Json news = client.until([&](const Json& t) {
            return t["t"] == "replay" && t["seeking"] == false && t["at_ms"] == std::round(ms);
        });
        EXPECT_TRUE(news.is_object()) << ms;
        return client.checked_checksum()["volume"];
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
    const std::filesystem::path m_session = m_folder / "s.pls";
};

TEST_F(Watched, EachTimeHasTheStateThatWasRecorded) {
    const std::vector<Json> sums = record();
    const std::string recorded = bytes_of(m_session);
    auto server = Server::start({.replay = m_session}, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient client(server->port(), server->link());
    client.enter();
    EXPECT_EQ(client.welcome["features"].back(), "replay");
    EXPECT_EQ(client.checked_checksum()["volume"], sums[0]);
    const Json marks = client.marks;
    ASSERT_EQ(marks.size(), 6U) << marks;
    EXPECT_EQ(marks[0]["do"], "push");
    EXPECT_EQ(marks[2]["do"], "undo");
    EXPECT_EQ(marks[4]["do"], "cut");
    for (std::size_t n = 1; n < marks.size(); ++n)
        EXPECT_GE(double(marks[n]["at_ms"]) - double(marks[n - 1]["at_ms"]), 150) << marks;
    const auto time = [&](std::size_t n) { return double(marks[n]["at_ms"]); };

    // Forward, backward, and to the begin and the end.
    for (const std::size_t n : {1U, 2U, 3U, 2U, 6U, 1U, 5U, 4U}) {
        const double ms = n < marks.size() ? time(n) - 20 : 1e9;
        if (ms < 1e9) {
            EXPECT_EQ(at(client, ms), sums[n]) << n;
        }
    }
    EXPECT_EQ(at(client, 0), sums[0]);
    // A client that seeks is told first that the scene is not there yet, also while it plays.
    for (const bool plays : {false, true}) {
        at(client, time(5));
        if (plays) client.command({{"do", "replay"}, {"playing", true}, {"speed", 0.01}});
        client.say({{"do", "replay"}, {"at_ms", time(1)}, {"id", 1000}});
        const Json first = client.until([&](const Json& t) {
            return t["t"] == "done" || (t["t"] == "replay" && t["at_ms"] == std::round(time(1)));
        });
        EXPECT_EQ(first["t"], "replay") << plays;
        EXPECT_EQ(first["seeking"], true) << plays;
        EXPECT_EQ(client.answer(1000)["t"], "done");
    }
    // Played to its end.
    client.command({{"do", "replay"}, {"playing", true}, {"speed", 20}});
    const Json end = client.until([](const Json& t) {
        return t["t"] == "replay" && t["playing"] == false && t["at_ms"] == t["length_ms"];
    });
    ASSERT_TRUE(end.is_object());
    EXPECT_GE(double(end["length_ms"]), 1000);
    EXPECT_EQ(client.checked_checksum()["volume"], sums.back());
    // Nothing is written.
    EXPECT_EQ(bytes_of(m_session), recorded);
}

TEST_F(Watched, NobodyChangesIt) {
    record();
    auto server = Server::start({.replay = m_session}, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient client(server->port(), server->link());
    client.enter();
    EXPECT_EQ(client.command(push(0, 1))["code"], "watched");
    EXPECT_EQ(client.command({{"do", "undo"}})["code"], "watched");
    EXPECT_EQ(client.command({{"do", "haptics"}, {"wish", "end"}})["code"], "watched");
    EXPECT_EQ(client.command({{"do", "replay"}, {"speed", 1000}})["code"], "out_of_range");
    TestClient viewer(server->port(), server->view_link());
    viewer.enter();
    EXPECT_EQ(viewer.command({{"do", "replay"}, {"playing", true}})["code"], "view_only");
    RawConnection upload(server->port());
    EXPECT_EQ(status_of(upload.post("/open?token=" + token_of(server->link()), "x")), "403");
    const auto both = Server::start({.file = "a.nrrd", .replay = m_session}, m_arena);
    ASSERT_FALSE(both.ok());
    EXPECT_EQ(both.error().message,
              "replay: expected neither a scan nor a session beside it, found a.nrrd");
    // A live scene has no time.
    auto live = Server::start({.phantom_size = {16, 16, 16}}, m_arena);
    ASSERT_TRUE(live.ok());
    TestClient other(live->port(), live->link());
    other.enter();
    EXPECT_EQ(other.command({{"do", "replay"}, {"playing", true}})["code"], "nothing");
}

TEST(Timeline, SpreadsRecordsBetweenTheTimesThatAreKnown) {
    using namespace serve;
    const std::vector<SessionRecord> records = {SessionCommand{1, PushCommand{}, false},
                                                SessionSweeps{2},
                                                SessionWait{100},
                                                SessionSweeps{3},
                                                SessionWait{5000},
                                                SessionSweeps{1},
                                                SessionSweeps{1}};
    EXPECT_EQ(times_of(records), (std::vector<double>{0, 50, 100, 100, 5100, 5100, 5150, 5200}));
    const std::span<const SessionRecord> all(records);
    const std::vector<double> untimed = times_of(all.first(2));
    EXPECT_EQ(untimed, (std::vector<double>{0, kUntimed_ms, 2 * kUntimed_ms}));
    EXPECT_EQ(times_of(all.first(0)), std::vector<double>{0});
}

}  // namespace
}  // namespace pliant::test
