// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue of one's own, the example's, in the server: pushed, undone, recorded, replayed.

#include <gtest/gtest.h>
#include <pliant/serve.h>
#include <pliant/session.h>

#include "hub/test_client.h"
#include "own_tissue/jelly.h"
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
        EXPECT_EQ(client.command(cut)["message"],
                  "cut: expected the tissue chainmail, springs of a scan or a body, found own");
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
              "tissue: model: expected chainmail, springs, found own");
}

}  // namespace
}  // namespace pliant::test
