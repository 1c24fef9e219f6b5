// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Real servers and real connections: several clients on one scene, which come and go.
// Covers: network/server.cpp, hub/camera_feed.cpp, hub/hub_*.cpp, hub/roster.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/volume.h>

#include <thread>

#include "hub/read_frames.h"
#include "hub/test_client.h"
#include "protocol/frames.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

class ServerTest : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        s_folder = new TemporaryFolder;
        const TaskArena arena;
        auto phantom = make_cube(arena);
        ASSERT_TRUE(phantom.ok());
        ASSERT_TRUE(write_volume(*s_folder / "cube.nrrd", phantom->volume).ok());
    }
    static void TearDownTestSuite() {
        delete s_folder;
        s_folder = nullptr;
    }
    static Result<Phantom> make_cube(const TaskArena& arena) {
        auto phantom = make_phantom({.name = "cube", .size = {48, 40, 44}}, arena);
        // Its values would count as bone.
        if (phantom.ok()) phantom->volume.key_values.emplace_back("bone_threshold_hu", "3000");
        return phantom;
    }
    static ServerSettings settings() { return {.file = (*s_folder / "cube.nrrd").string()}; }
    static Json push(Vec3d at, Vec3d by, double radius = 4) {
        return {{"do", "push"},
                {"point", {at.x, at.y, at.z}},
                {"push", {by.x, by.y, by.z}},
                {"radius", radius}};
    }

    static TemporaryFolder* s_folder;
    const TaskArena m_arena{2};
};

TemporaryFolder* ServerTest::s_folder = nullptr;

TEST_F(ServerTest, TwoClientsAgreeAfterBothPushed) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient a(server->port(), server->link()), b(server->port(), server->link());
    const Json welcome = a.enter({{"name", "Anna"}});
    EXPECT_EQ(welcome["role"], "control");
    EXPECT_EQ(welcome["protocol"], 2);
    EXPECT_EQ(welcome["volume"]["size"], Json({48, 40, 44}));
    b.enter({{"name", "Ben"}, {"lz4", true}});
    const Json before = a.checked_checksum();
    EXPECT_EQ(b.checked_checksum()["volume"], before["volume"]);
    Random random(77);
    for (int n = 0; n < 15; ++n) {
        const Json done = (n % 2 ? a : b).command(push(random.vector(8), random.vector(3)));
        EXPECT_EQ(done["t"], "done");
    }
    const Json of_a = a.checked_checksum(), of_b = b.checked_checksum();
    EXPECT_EQ(of_a["volume"], of_b["volume"]);
    EXPECT_EQ(of_a["tissue"], of_b["tissue"]);
    EXPECT_EQ(a.voxels, b.voxels);
    EXPECT_NE(of_a["volume"], before["volume"]);
    // A late client gets everything.
    TestClient late(server->port(), server->view_link());
    EXPECT_EQ(late.enter()["role"], "view");
    EXPECT_EQ(late.voxels, a.voxels);
    EXPECT_EQ(late.command(push({0, 0, 0}, {0, 1, 0}))["code"], "view_only");
    EXPECT_EQ(late.command({{"do", "undo"}})["code"], "view_only");
    // And everything can be taken back.
    while (a.command({{"do", "undo"}})["t"] == "done") {
    }
    EXPECT_EQ(b.checked_checksum()["volume"], before["volume"]);
    EXPECT_EQ(late.checked_checksum()["tissue"], before["tissue"]);
}

TEST_F(ServerTest, ALargeScanComesCoarseFirstIfThatIsWanted) {
    Volume scan;
    scan.grid.size = {163, 161, 162};  // more than 4 Mi
    std::vector<std::int16_t> values(voxel_count(scan.grid));
    Random random(4);
    for (auto& value : values) value = std::int16_t(random.whole(-1000, 1000));
    scan.voxels = values;
    ASSERT_TRUE(write_volume(*s_folder / "large.nrrd", scan, Encoding::Raw).ok());
    auto server = Server::start({.file = (*s_folder / "large.nrrd").string()}, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient a(server->port(), server->link()), b(server->port(), server->link());
    a.enter({{"coarse", true}});
    b.enter();
    EXPECT_TRUE(b.coarse.empty());
    EXPECT_EQ(a.voxels, b.voxels);
    std::vector<std::uint16_t> expected;
    for (int k = 0; k < 162; k += 4)
        for (int j = 0; j < 161; j += 4)
            for (int i = 0; i < 163; i += 4)
                expected.push_back(a.voxels[std::size_t(i + 163 * (j + 161 * k))]);
    EXPECT_EQ(a.coarse, expected);
}

TEST_F(ServerTest, ASmallScanComesAtOnce) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok());
    TestClient a(server->port(), server->link());
    a.enter({{"coarse", true}});
    EXPECT_TRUE(a.coarse.empty());
}

TEST_F(ServerTest, BytesFollowTheChange) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok());
    TestClient a(server->port(), server->link());
    a.enter();
    const std::int64_t snapshot = a.box_bytes;
    EXPECT_GE(snapshot, 48 * 40 * 44 * 2);
    EXPECT_LE(snapshot, 48 * 40 * 44 * 2 + 100 * 32);
    a.box_bytes = 0;
    EXPECT_GT(a.command(push({10, 0, 0}, {0, 0.3, 0}, 2))["moved_elements"], 0);
    a.checked_checksum();
    EXPECT_GT(a.box_bytes, 0);
    EXPECT_LT(a.box_bytes, snapshot / 3);
    // A command that changes no voxel sends none.
    a.box_bytes = 0;
    a.command({{"do", "iso"}, {"iso_hu", -300}});
    a.command(push({10, 0, 0}, {0, 0, 0}, 2));
    a.checked_checksum();
    EXPECT_EQ(a.box_bytes, 0);
}

TEST_F(ServerTest, ACutThatNothingOpensChangesTheTissueButNoVoxel) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok());
    TestClient a(server->port(), server->link());
    a.enter();
    const Json before = a.checked_checksum();
    const Json cut =
        a.command({{"do", "cut"}, {"line", {{-5, -5, 0.3}, {5, -5, 0.3}}}, {"depth", {0, 10, 0}}});
    ASSERT_GT(cut["cut_links"], 0);
    const Json after = a.checked_checksum();
    EXPECT_EQ(after["volume"], before["volume"]);
    EXPECT_NE(after["tissue"], before["tissue"]);
}

TEST_F(ServerTest, GrabsDragsCutsRelaxesAndShowsToolsToAll) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok());
    TestClient a(server->port(), server->link()), b(server->port(), server->view_link());
    a.enter();
    b.enter();
    const Json start = a.checked_checksum();
    EXPECT_GT(a.command({{"do", "grab"}, {"point", {0, 0, 0}}, {"radius", 5}})["grabbed_elements"],
              0);
    for (int n = 1; n <= 20; ++n) {
        const Json done = a.command({{"do", "drag"}, {"offset", {0, 0.1 * n, 0}}});
        ASSERT_EQ(done["t"], "done") << done;
    }
    b.until([&](const Json& text) { return text["t"] == "state" && text["holder"] != 0; });
    EXPECT_EQ(b.state["holder"], a.welcome["client"]);
    a.command({{"do", "let_go"}});
    EXPECT_EQ(a.command({{"do", "drag"}, {"offset", {0, 0, 0}}})["code"], "not_holding");
    EXPECT_GT(a.command({{"do", "cut"},
                         {"line", {{-5, -5, 0.3}, {5, -5, 0.3}}},
                         {"depth", {0, 10, 0}}})["cut_links"],
              0);
    EXPECT_GT(a.command({{"do", "carve"},
                         {"from", {8, 0, 0}},
                         {"to", {8, 0, 3}},
                         {"radius", 2}})["carved_elements"],
              0);
    a.command({{"do", "relax"}, {"on", true}});
    const Json settled = a.until([](const Json& text) {
        return text["t"] == "state" && text["relaxing"] == true && text["settled"] == true;
    });
    ASSERT_FALSE(settled.is_null());
    a.command({{"do", "relax"}, {"on", false}});
    a.command({{"do", "materials"}, {"offset", 0.35}});
    EXPECT_EQ(a.command({{"do", "materials"}, {"offset", 7}})["code"], "out_of_range");
    EXPECT_EQ(a.command(push({500, 0, 0}, {0, 1, 0}))["code"], "out_of_range");
    // Threshold by slider: one step.
    for (int n = 0; n < 10; ++n) a.command({{"do", "iso"}, {"iso_hu", -400 + n}});
    std::vector<std::string> undone;
    for (;;) {
        const Json done = a.command({{"do", "undo"}});
        if (done["t"] != "done") break;
        undone.push_back(done["message"]);
    }
    EXPECT_EQ(undone, (std::vector<std::string>{"threshold", "materials", "relax", "carve", "cut",
                                                "drag"}));
    EXPECT_EQ(a.checked_checksum()["volume"], start["volume"]);
    EXPECT_EQ(b.checked_checksum()["volume"], start["volume"]);
    while (a.command({{"do", "redo"}})["t"] == "done") {
    }
    EXPECT_EQ(a.checked_checksum()["volume"], b.checked_checksum()["volume"]);
    EXPECT_EQ(a.state["iso_hu"], -391);

    a.say({{"do", "tool"},
           {"kind", "endoscope"},
           {"position", {1, 2, 3}},
           {"direction", {0, 0, 1}},
           {"radius", 3}});
    a.say({{"do", "ping"}, {"id", 6}});
    a.until("pong");
    b.say({{"do", "ping"}, {"id", 6}});
    b.until("pong");
    b.checked_checksum();
    const auto tools = serve::read_tools(b.tools);
    ASSERT_TRUE(tools);
    ASSERT_EQ(tools->size(), 1U);
    EXPECT_EQ(tools->front().kind, serve::ToolKind::Endoscope);
    EXPECT_EQ(tools->front().position_mm, (Vec3f{1, 2, 3}));
}

TEST_F(ServerTest, ShowsWhatAToolFeelsUntilItLetsGo) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok());
    TestClient a(server->port(), server->link()), b(server->port(), server->view_link());
    a.enter();
    b.enter();
    a.say({{"do", "tool"},
           {"kind", "sphere"},
           {"position", {0, 0, 0}},
           {"direction", {0, 0, 1}},
           {"radius", 5}});
    const auto felt_y = [&](auto holds) {
        for (int n = 0; n < 200; ++n) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            b.say({{"do", "ping"}, {"id", 6}});
            if (b.until("pong").is_null()) return false;
            const auto tools = serve::read_tools(b.tools);
            if (tools && tools->size() == 1 && holds(tools->front().energy_per_mm.y)) return true;
        }
        return false;
    };
    EXPECT_GT(a.command({{"do", "grab"}, {"point", {0, 0, 0}}, {"radius", 5}})["grabbed_elements"],
              0);
    ASSERT_EQ(a.command({{"do", "drag"}, {"offset", {0, 2, 0}}})["t"], "done");
    EXPECT_TRUE(felt_y([](float y) { return y < 0; })) << "tissue pulls back";
    a.command({{"do", "let_go"}});
    EXPECT_TRUE(felt_y([](float y) { return y == 0; }));
}

TEST_F(ServerTest, ALostConnectionGoesOnWhereItEnded) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok());
    TestClient other(server->port(), server->link());
    other.enter();
    auto first = std::make_unique<TestClient>(server->port(), server->link());
    first->enter({{"name", "Anna"}});
    first->command(push({0, 0, 0}, {0, 1, 0}));
    first->checked_checksum();
    const Json welcome = first->welcome;
    const auto voxels = first->voxels;
    const std::uint32_t step = first->step;
    first.reset();
    other.command(push({10, 0, 0}, {0, 0.3, 0}, 2));

    TestClient again(server->port(), server->link());
    again.voxels = voxels;
    again.enter({{"resume", welcome["resume"]}, {"step", step}});
    EXPECT_EQ(again.welcome["resumed"], true);
    EXPECT_EQ(again.welcome["client"], welcome["client"]);
    EXPECT_EQ(again.welcome["name"], "Anna");
    again.checked_checksum();
    EXPECT_GT(again.box_bytes, 0);
    EXPECT_LT(again.box_bytes, 48 * 40 * 44);
    EXPECT_EQ(again.voxels, [&] {
        other.checked_checksum();
        return other.voxels;
    }());

    // The same client number, taken from another connection, without voxels.
    TestClient third(server->port(), server->link());
    third.enter({{"resume", welcome["resume"]}});
    EXPECT_EQ(third.welcome["resumed"], false);
    EXPECT_EQ(third.welcome["client"], welcome["client"]);
    EXPECT_EQ(again.wait_for_close(), 4005);
    EXPECT_EQ(third.voxels, other.voxels);
    // An unknown resume token.
    TestClient stranger(server->port(), server->link());
    stranger.enter({{"resume", "0123456789abcdef0123456789abcdef"}, {"step", step}});
    EXPECT_EQ(stranger.welcome["resumed"], false);
    EXPECT_NE(stranger.welcome["client"], welcome["client"]);
    EXPECT_EQ(stranger.voxels, other.voxels);
}

TEST_F(ServerTest, ASlowReaderSkipsStepsAndHoldsUpNobody) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok());
    TestClient quick(server->port(), server->link()), slow(server->port(), server->view_link());
    quick.enter();
    slow.enter();
    slow.sends_seen = false;
    slow.boxes = 0;
    for (int n = 0; n < 40; ++n)
        ASSERT_EQ(quick.command(push({0, 0, 0}, {0, n % 2 ? 1.0 : -1.0, 0}))["t"], "done");
    quick.checked_checksum();
    // It was sent three steps, and no more until it says that it has seen them.
    std::vector<std::uint32_t> seen;
    while (seen.size() < 3 && slow.until_up_to_date()) seen.push_back(slow.step);
    slow.say({{"do", "ping"}});
    slow.until("pong");
    EXPECT_EQ(slow.step, seen.back());
    EXPECT_LT(slow.step, quick.step);
    slow.sends_seen = true;
    for (const std::uint32_t step : seen) slow.say({{"do", "seen"}, {"step", step}});
    slow.checked_checksum();
    EXPECT_EQ(slow.voxels, quick.voxels);
    EXPECT_EQ(slow.step, quick.step);
}

TEST_F(ServerTest, ASessionGoesOnAfterTheServerEnded) {
    TemporaryFolder folder;
    ServerSettings with_session = settings();
    with_session.session = folder / "s.pls";
    Json before;
    {
        auto server = Server::start(with_session, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        EXPECT_FALSE(Server::start(with_session, m_arena).ok()) << "it is open";
        TestClient a(server->port(), server->link());
        a.enter();
        a.command(push({0, 0, 0}, {0, 2, 0}));
        a.command({{"do", "relax"}, {"on", true}});
        a.command(push({3, 0, 0}, {1, 2, 0}));
        a.until([](const Json& t) { return t["t"] == "state" && t["settled"] == true; });
        a.command({{"do", "relax"}, {"on", false}});
        a.command({{"do", "undo"}});
        a.command({{"do", "iso"}, {"iso_hu", -123}});
        before = a.checked_checksum();
    }
    {
        ServerSettings other = with_session;
        other.file.clear();
        auto server = Server::start(other, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        EXPECT_EQ(server->notes().size(), 1U);
        TestClient a(server->port(), server->link());
        a.enter();
        const Json after = a.checked_checksum();
        EXPECT_EQ(after["volume"], before["volume"]);
        EXPECT_EQ(after["tissue"], before["tissue"]);
        EXPECT_EQ(a.welcome["state"]["iso_hu"], -123);
        // History came along.
        EXPECT_EQ(a.command({{"do", "undo"}})["message"], "threshold");
        before = a.checked_checksum();
    }
    const auto report = replay_session(with_session.session, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(report->volume_hash));
    EXPECT_EQ(before["volume"], hash);
    // Of another scan.
    ServerSettings wrong = with_session;
    wrong.file = (folder / "other.nrrd").string();
    const auto refused = Server::start(wrong, m_arena);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("expected a session of"), std::string::npos);
}

TEST_F(ServerTest, RefusesPortsThatAreTaken) {
    auto server = Server::start(settings(), m_arena);
    ASSERT_TRUE(server.ok());
    ServerSettings same = settings();
    same.port = server->port();
    const auto second = Server::start(same, m_arena);
    ASSERT_FALSE(second.ok());
    EXPECT_TRUE(second.error().message.starts_with("port:")) << second.error().message;
    same.port = 70'000;
    EXPECT_FALSE(Server::start(same, m_arena).ok());
}

TEST_F(ServerTest, AFollowerHasTheLeadersCamera) {
    auto server = Server::start({.phantom_size = {16, 16, 16}}, m_arena);
    ASSERT_TRUE(server.ok());
    auto leads = std::make_unique<TestClient>(server->port(), server->link());
    TestClient& leader = *leads;
    TestClient follower(server->port(), server->view_link());
    leader.enter();
    follower.enter();
    const auto number = leader.welcome["client"].get<std::uint32_t>();
    const auto own = follower.welcome["client"].get<std::uint32_t>();
    const auto follow = [&](std::uint32_t client) {
        return follower.command({{"do", "follow"}, {"client", client}});
    };
    EXPECT_EQ(follow(own)["code"], "out_of_range");
    EXPECT_EQ(follow(99)["code"], "out_of_range");
    Json camera = {{"do", "camera"}, {"eye", {1, 2, 3}}, {"look", {0, 1, 0}}, {"up", {0, 0, 1}}};
    leader.say(camera);
    EXPECT_EQ(follow(number)["t"], "done");
    const auto next = [&] { return follower.until("camera"); };
    const Json first = next();
    EXPECT_EQ(first["client"], number);
    EXPECT_EQ(first["eye"], camera["eye"]);
    EXPECT_EQ(first["up"], camera["up"]);
    camera["eye"] = {4, 5, 6};
    leader.say(camera);
    EXPECT_EQ(next()["eye"], camera["eye"]);
    // No more of it after that.
    EXPECT_EQ(follow(0)["t"], "done");
    leader.say(camera);
    leader.say({{"do", "ping"}});
    leader.until("pong");
    EXPECT_EQ(follow(number)["t"], "done");
    EXPECT_EQ(next()["eye"], camera["eye"]);
    leader.say({{"do", "camera"}});
    EXPECT_FALSE(next().contains("eye"));
    // A leader that goes is gone for the follower too.
    leads.reset();
    const Json gone = next();
    EXPECT_EQ(gone["client"], number);
    EXPECT_FALSE(gone.contains("eye"));
    EXPECT_EQ(follow(number)["code"], "out_of_range");
}

}  // namespace
}  // namespace pliant::test
