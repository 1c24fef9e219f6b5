// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissues of one's own, the example's, in the server: pushed or driven, undone, recorded, replayed.
// Covers: hub/hub.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/serve.h>

#include <functional>

#include "hub/test_client.h"
#include "own_tissue/jelly.h"
#include "own_tissue/needle.h"
#include "protocol/messages.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

TEST(OwnTissue, IsServedUndoneRecordedAndReplayed) {
    const TaskArena arena(2);
    const TemporaryFolder folder;
    const auto session = folder / "jelly.pls";
    const Json push = {{"do", "push"}, {"point", {0, 0, 0}}, {"push", {0, 4, 0}}, {"radius", 3}};
    {
        auto server = Server::start({.phantom_size = {32, 32, 32},
                                     .session = session,
                                     .own_tissue = example::Jelly::create},
                                    arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient client(server->port(), server->link());
        client.enter();
        const std::vector<std::uint16_t> at_rest = client.voxels;
        EXPECT_EQ(client.command(push)["status"], "applied");
        client.checked_checksum();
        EXPECT_NE(client.voxels, at_rest);
        const Json cut = {{"do", "cut"}, {"line", {{0, 0, 0}, {1, 0, 0}}}, {"depth", {0, 0, 1}}};
        EXPECT_EQ(
            client.command(cut)["message"],
            "cut: expected the tissue chainmail, elastic, springs of a scan or a body, found own");
        client.command({{"do", "undo"}});
        client.checked_checksum();
        EXPECT_EQ(client.voxels, at_rest);
        client.command(push);
        // Another model, and back: at rest.
        EXPECT_EQ(client.command({{"do", "tissue"}, {"model", "chainmail"}})["t"], "done");
        EXPECT_EQ(client.command({{"do", "tissue"}, {"model", "own"}})["t"], "done");
        client.checked_checksum();
        EXPECT_EQ(client.voxels, at_rest);
        EXPECT_EQ(client.command(push)["status"], "applied");
    }
    const auto replayed = replay_session(session, arena, {.own_tissue = example::Jelly::create});
    ASSERT_TRUE(replayed.ok()) << replayed.error().message;
    EXPECT_GT(replayed->marks, 0);
    const std::int64_t releases = replayed->commands - 7;  // one, if the client was seen to leave
    EXPECT_TRUE(releases == 0 || releases == 1) << replayed->commands;
    // A program without that tissue has no such model.
    EXPECT_FALSE(replay_session(session, arena).ok());
}

TEST(OwnTissue, OfAServerWithoutOneIsRefusedInALine) {
    const TaskArena arena(1);
    auto server = Server::start({.phantom_size = {16, 16, 16}}, arena);
    ASSERT_TRUE(server.ok());
    TestClient client(server->port(), server->link());
    client.enter();
    EXPECT_EQ(client.command({{"do", "tissue"}, {"model", "own"}})["message"],
              "tissue: model: expected chainmail, springs, elastic, found own");
}

TEST(OwnTissue, WithACatheterIsDrivenUndoneRecordedAndReplayed) {
    const TaskArena arena(2);
    const TemporaryFolder folder;
    const auto session = folder / "needle.pls";
    std::string hash;
    {
        auto server = Server::start({.phantom_size = {32, 32, 32},
                                     .session = session,
                                     .own_tissue = example::Needle::create},
                                    arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient client(server->port(), server->link());
        client.enter();
        const std::vector<std::uint16_t> at_rest = client.voxels;
        ASSERT_TRUE(client.state.contains("vessel"));
        EXPECT_EQ(client.state["vessel"]["inserted_mm"], 0);
        EXPECT_EQ(client.state["vessel"]["length_mm"], 40);
        const Json push = {
            {"do", "push"}, {"point", {0, 0, 0}}, {"push", {0, 4, 0}}, {"radius", 3}};
        EXPECT_EQ(client.command(push)["code"], "other_tissue");
        EXPECT_EQ(client.command({{"do", "vessel"}, {"on", true}})["t"], "done");
        const auto drive = [&](double mm_s, const std::function<bool(const Json&)>& until) {
            const Json done = client.command({{"do", "catheter"}, {"insert_mm_s", mm_s}});
            EXPECT_EQ(done["t"], "done");
            // The state may be here already, and takes its time where others use the machine.
            bool is_there = until(client.state["vessel"]);
            for (int n = 0; n < 5 && !is_there; ++n)
                is_there = !client
                                .until([&](const Json& m) {
                                    return m["t"] == "state" && until(m["vessel"]);
                                })
                                .is_null();
            EXPECT_TRUE(is_there) << client.state.dump();
        };
        drive(20, [](const Json& v) { return v["inserted_mm"] > 5 && v["force_n"] > 0.2; });
        drive(0, [](const Json& v) { return v["insert_mm_s"] == 0; });
        client.checked_checksum();
        EXPECT_NE(client.voxels, at_rest);
        // An empty wall, and a wire of two points.
        EXPECT_EQ(client.surface.size(), 32 + 8);
        ASSERT_FALSE(client.vessels.empty());
        EXPECT_EQ(client.vessels.back().size(), 32 + 12 + 2 * 12);
        // A step of undo is the whole motion.
        EXPECT_EQ(client.command({{"do", "undo"}})["t"], "done");
        client.checked_checksum();
        EXPECT_EQ(client.voxels, at_rest);
        EXPECT_EQ(client.command({{"do", "redo"}})["t"], "done");
        hash = client.checked_checksum()["tissue"];
        EXPECT_NE(client.voxels, at_rest);
    }
    const auto replayed = replay_session(session, arena, {.own_tissue = example::Needle::create});
    ASSERT_TRUE(replayed.ok()) << replayed.error().message;
    EXPECT_EQ(serve::hex_text(replayed->tissue_hash, 16), hash);
}

TEST(OwnTissue, ItsCatheterIsHeldByADevice) {
    const TaskArena arena(2);
    auto server =
        Server::start({.phantom_size = {32, 32, 32}, .own_tissue = example::Needle::create}, arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient client(server->port(), server->link());
    client.enter();
    const Json start = {{"do", "haptics"},       {"wish", "start"},   {"device", "virtual:free"},
                        {"position", {0, 0, 0}}, {"look", {0, 1, 0}}, {"up", {0, 0, 1}}};
    EXPECT_EQ(client.command(start)["t"], "done");
    const Json held =
        client.until([](const Json& m) { return m.value("holds", "") == "catheter"; });
    EXPECT_FALSE(held.is_null());
}

}  // namespace
}  // namespace pliant::test
