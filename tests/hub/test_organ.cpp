// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// An organ's mesh as a scene: its scan against the distance to its surface, pushed, undone,
// recorded and replayed.
// Covers: organs/make_organs.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/network_file.h>
#include <pliant/models/organs.h>
#include <pliant/models/scene_files.h>
#include <pliant/serve.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <thread>

#include "hub/read_frames.h"
#include "hub/test_client.h"
#include "protocol/frames.h"
#include "protocol/half.h"
#include "session/scene.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::serve {
namespace {

using test::Json;
using test::Random;
using test::TemporaryFolder;
using test::TestClient;

/// An ellipsoid with half axes of 40, 30 and 25 mm.
TetMesh ellipsoid(const TaskArena& arena) {
    const auto level = [](Vec3d x) { return 25 * (1 - norm(Vec3d{x.x / 40, x.y / 30, x.z / 25})); };
    auto mesh = stuff_isosurface(
        level, {.begin_mm = {-42, -32, -27}, .end_mm = {42, 32, 27}, .cell_mm = 6}, arena);
    EXPECT_TRUE(mesh.ok()) << mesh.error().message;
    return std::move(*mesh);
}

/// Springs of a mesh, held at the back.
NetworkFile springs_of(const TetMesh& mesh, double modulus_pa) {
    auto parts = springs_of_elastic_tetrahedra(
        mesh.nodes_mm, mesh.cells,
        {.stiffness = modulus_pa, .density = 1e-3, .bulk = 2 * modulus_pa});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.y > 25;
    NetworkFile network{.mesh = "organ.vtu", .parts = std::move(*parts)};
    return network;
}

class OrganScene : public ::testing::Test {
  protected:
    OrganScene() {
        const TetMesh mesh = ellipsoid(m_arena);
        EXPECT_TRUE(write_network(m_folder / "soft.json", springs_of(mesh, 3000)).ok());
        EXPECT_TRUE(write_network(m_folder / "stiff.json", springs_of(mesh, 12000)).ok());
        EXPECT_TRUE(write_vtu(m_folder / "organ.vtu", mesh).ok());
        EXPECT_TRUE(write_surface(m_folder / "organ.stl", boundary_triangles(mesh)).ok());
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
};

TEST_F(OrganScene, ItsScanIsTissueInsideAndAirOutside) {
    const TetMesh mesh = ellipsoid(m_arena);
    const auto made = make_organs(organ_file_of_mesh((m_folder / "organ.vtu").string()), m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    const Volume* const scan = &made->scan;
    const auto surface = SurfaceDistance::create(boundary_triangles(mesh));
    ASSERT_TRUE(surface.ok());
    const double voxel = scan->grid.spacing_mm.x;
    Random random(5);
    int inside = 0, outside = 0;
    for (int n = 0; n < 20'000; ++n) {
        const Vec3i at{int(random.whole(0, scan->grid.size.x - 1)),
                       int(random.whole(0, scan->grid.size.y - 1)),
                       int(random.whole(0, scan->grid.size.z - 1))};
        const double away = surface->signed_mm(
            world_from_voxel(scan->grid, {double(at.x), double(at.y), double(at.z)}));
        const double value = double(scan->at(at));
        if (away > voxel) {
            ++outside;
            ASSERT_EQ(value, -1000);
        } else if (away < -voxel) {
            ++inside;
            ASSERT_GE(value, 30);
            ASSERT_LE(value, 90);
        } else if (std::abs(away) > 0.05 * voxel) {
            ASSERT_EQ(value > -470, away < 0) << value << " at " << away;
        }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(outside, 1000);
}

TEST_F(OrganScene, IsPushedCarriedAndTakenBack) {
    for (const char* name : {"organ.vtu", "organ.stl"}) {
        SCOPED_TRACE(name);
        auto scene = Scene::open({.file = (m_folder / name).string()}, m_arena, m_arena);
        ASSERT_TRUE(scene.ok()) << scene.error().message;
        Scene& organ = **scene;
        EXPECT_EQ(organ.tissue().traits().model, "body");
        const std::uint64_t rest = hash_volume(organ.deformed());
        const PushCommand push{.push = {{0, -30, 0}, {0, 8, 0}, 8}, .stroke = 1};
        const Outcome outcome = organ.carry_out(1, push);
        ASSERT_TRUE(outcome.ok()) << outcome.message;
        EXPECT_NE(outcome.status, PushStatus::Rejected);
        ASSERT_TRUE(organ.update().ok());
        // Air is where the front was; the back is held.
        const auto value = [&](Vec3d p) {
            const Vec3d ijk = voxel_from_world(organ.deformed().grid, p);
            return double(organ.deformed().at(
                {int(std::lround(ijk.x)), int(std::lround(ijk.y)), int(std::lround(ijk.z))}));
        };
        EXPECT_LT(value({0, -27, 0}), -800);
        EXPECT_GT(value({0, -10, 0}), 0);
        EXPECT_GT(value({0, 28, 0}), 0);
        ASSERT_TRUE(organ.carry_out(1, UndoCommand{}).ok());
        ASSERT_TRUE(organ.update().ok());
        EXPECT_EQ(hash_volume(organ.deformed()), rest);
    }
}

TEST_F(OrganScene, IsServedRecordedAndReplayed) {
    const auto session = m_folder / "s.pls";
    Json sums;
    {
        auto server =
            Server::start({.file = (m_folder / "organ.stl").string(), .session = session}, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient client(server->port(), server->link());
        client.enter();
        EXPECT_EQ(client.state["tissue"]["model"], "own");
        EXPECT_EQ(client.command({{"do", "relax"}, {"on", false}})["t"], "done");
        const Json rest = client.checked_checksum();
        EXPECT_EQ(client.command({{"do", "push"},
                                  {"point", {0, -30, 0}},
                                  {"push", {0, 5, 0}},
                                  {"radius", 8},
                                  {"stroke", 1}})["t"],
                  "done");
        sums = client.checked_checksum();
        EXPECT_NE(sums["volume"], rest["volume"]);
    }
    for (const int threads : {1, 3}) {
        const auto replayed = replay_session(session, TaskArena(threads));
        ASSERT_TRUE(replayed.ok()) << replayed.error().message;
    }
}

TEST_F(OrganScene, APageLearnsItsBodiesTheToolsThatItTakesAndTheirSize) {
    auto server = Server::start({.file = (m_folder / "organ.vtu").string()}, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient client(server->port(), server->link());
    const Json welcome = client.enter();
    const Json& tissue = client.state["tissue"];
    const TetMesh mesh = ellipsoid(m_arena);
    EXPECT_EQ(tissue["bodies"], "organ: " + std::to_string(mesh.cells.size()) +
                                    " tetrahedra, neo-Hookean, 15 kPa, ν 0.45");
    EXPECT_EQ(tissue["particles"], mesh.nodes_mm.size());
    // Lattice cells of 6 mm: edges of that along the axes, shorter ones across.
    EXPECT_GT(tissue["edge_mm"], 3);
    EXPECT_LT(tissue["edge_mm"], 6.5);
    EXPECT_NEAR(double(tissue["time_step_ms"]), 1000.0 / 60, 1e-9);
    EXPECT_NEAR(double(welcome["volume"]["tool_mm"]), 1.5 * double(tissue["edge_mm"]), 1e-3);
    EXPECT_EQ(welcome["volume"]["values"]["window"], 400);
    const auto takes = [&](const char* command) {
        const Json& list = client.state["tissue"]["takes"];
        return std::find(list.begin(), list.end(), command) != list.end();
    };
    EXPECT_TRUE(takes("push") && takes("slide"));
    EXPECT_FALSE(takes("carve"));
    EXPECT_EQ(client.state["tissue"]["has_own"], true);
    // Another model of the same scan, and back.
    EXPECT_EQ(client.command({{"do", "tissue"}, {"model", "chainmail"}})["t"], "done");
    client.checked_checksum();
    EXPECT_EQ(client.state["tissue"]["model"], "chainmail");
    EXPECT_EQ(client.state["tissue"]["has_own"], true);
    EXPECT_TRUE(takes("carve"));
    EXPECT_EQ(client.command({{"do", "tissue"}, {"model", "own"}})["t"], "done");
    client.checked_checksum();
    EXPECT_EQ(client.state["tissue"]["model"], "own");
}

TEST_F(OrganScene, SeveralBodiesAreLabelsInCubesOfTwoSigns) {
    // Two boxes that touch each other at x = 0.
    const auto box = [](double from) {
        TetMesh mesh = five_tet_block({6, 6, 6}, 5);
        for (Vec3d& p : mesh.nodes_mm) p = p + Vec3d{from, -15, -15};
        return mesh;
    };
    ASSERT_TRUE(write_vtu(m_folder / "left.vtu", box(-30)).ok());
    ASSERT_TRUE(write_vtu(m_folder / "right.vtu", box(0)).ok());
    std::ofstream(m_folder / "two.toml") << "[[body]]\nname = \"left\"\nmesh = \"left.vtu\"\n"
                                            "[[body]]\nname = \"right\"\nmesh = \"right.vtu\"\n";
    auto server = Server::start({.file = (m_folder / "two.toml").string()}, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient client(server->port(), server->link());
    client.enter();
    client.overlay_format = kFormatLabels;
    client.overlay.assign(client.voxels.size(), 0xffff);
    client.say({{"do", "labels"}, {"id", 900}, {"on", true}});
    EXPECT_EQ(client.answer(900)["t"], "done");
    const Json list = client.until("labels");
    EXPECT_EQ(list["name"], "bodies");
    ASSERT_EQ(list["labels"].size(), 2U);
    for (int n = 0; n < 2; ++n) {
        EXPECT_EQ(list["labels"][std::size_t(n)]["name"], n == 0 ? "left" : "right");
        EXPECT_EQ(list["labels"][std::size_t(n)]["body"], n + 1);
        EXPECT_NEAR(double(list["labels"][std::size_t(n)]["centre_mm"][0]), n == 0 ? -15 : 15, 1);
    }
    client.checked_checksum();
    auto scene = Scene::open({.file = (m_folder / "two.toml").string()}, m_arena, m_arena);
    ASSERT_TRUE(scene.ok());
    const auto loaded = (*scene)->loaded();
    ASSERT_NE(loaded->bodies, nullptr);
    const Grid& grid = loaded->bodies->grid;
    ASSERT_GT(loaded->bodies->stripe_mm, 2.9 * grid.spacing_mm.x);
    std::map<int, int> counts;
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) {
                const Vec3d p = world_from_voxel(grid, {double(i), double(j), double(k)});
                const auto number =
                    int(float_from_half(client.overlay[voxel_index(grid, {i, j, k})]));
                ++counts[number];
                const bool inside =
                    std::abs(p.x) < 29.5 && std::abs(p.y) < 14.5 && std::abs(p.z) < 14.5;
                if (inside && std::abs(p.x) > 0.1) {
                    ASSERT_EQ(std::abs(number), p.x < 0 ? 1 : 2) << p.x << ' ' << p.y << ' ' << p.z;
                }
                if (number == 0) continue;
                int cubes = 0;
                for (int a = 0; a < 3; ++a)
                    cubes +=
                        int(std::floor((p[a] - grid.origin_mm[a]) / loaded->bodies->stripe_mm));
                ASSERT_EQ(number < 0, cubes % 2 == 1);
            }
    for (const int number : {-2, -1, 0, 1, 2}) EXPECT_GT(counts[number], 1000) << number;
    // One body has no labels.
    auto one = Scene::open({.file = (m_folder / "organ.vtu").string()}, m_arena, m_arena);
    ASSERT_TRUE(one.ok());
    EXPECT_EQ((*one)->loaded()->bodies, nullptr);
}

TEST_F(OrganScene, LabelsOfAMapKnowTheBodiesThatCarryThem) {
    const Grid grid{.size = {6, 2, 1}, .spacing_mm = {1, 1, 1}};
    // Body 1, body 2 and the surroundings, which are body 3; two labels, and voxels without one.
    LabelMap bodies{.grid = grid,
                    .labels = {{.name = "a", .body = 1},
                               {.name = "b", .body = 2},
                               {.name = "surroundings", .body = 3, .is_shown = false}},
                    .numbers = {1, 1, 2, 2, 3, 0, 1, 1, 2, 2, 3, 0},
                    .stripe_mm = 4};
    LabelMap map{.grid = grid,
                 .labels = {{.value = 5}, {.value = 7}},
                 .numbers = {1, 1, 2, 2, 0, 0, 1, 0, 2, 2, 0, 0}};
    mark_bodies(map, bodies);
    EXPECT_EQ(map.stripe_mm, 4);
    ASSERT_EQ(map.labels.size(), 3u);
    EXPECT_EQ(map.labels[0].body, 1);
    EXPECT_EQ(map.labels[1].body, 2);
    EXPECT_EQ(map.labels[2].body, 3);
    EXPECT_FALSE(map.labels[2].is_shown);
    EXPECT_EQ(map.labels[2].voxels, 2);
    EXPECT_EQ(map.numbers, (std::vector<std::uint16_t>{1, 1, 2, 2, 3, 0, 1, 0, 2, 2, 3, 0}));
}

TEST_F(OrganScene, IsCutRecordedAndReplayed) {
    const auto session = m_folder / "cut.pls";
    {
        auto server =
            Server::start({.file = (m_folder / "organ.stl").string(), .session = session}, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient client(server->port(), server->link());
        client.enter();
        EXPECT_EQ(client.command({{"do", "relax"}, {"on", false}})["t"], "done");
        const Json rest = client.checked_checksum();
        const Json cut = client.command(
            {{"do", "cut"}, {"line", {{2, -35, -30}, {2, 5, -30}}}, {"depth", {0, 0, 60}}});
        EXPECT_EQ(cut["t"], "done") << cut;
        EXPECT_GT(cut["cut_links"], 100);
        EXPECT_EQ(client.checked_checksum()["volume"], rest["volume"]) << "a closed cut";
        const Json pulled = client.command({{"do", "push"},
                                            {"point", {20, -20, 0}},
                                            {"push", {6, 0, 0}},
                                            {"radius", 10},
                                            {"stroke", 1}});
        EXPECT_EQ(pulled["t"], "done") << pulled;
        const Json open = client.checked_checksum();
        EXPECT_NE(open["volume"], rest["volume"]);
        for (int n = 0; n < 2; ++n) EXPECT_EQ(client.command({{"do", "undo"}})["t"], "done");
        EXPECT_EQ(client.checked_checksum()["tissue"], rest["tissue"]);
        for (int n = 0; n < 2; ++n) EXPECT_EQ(client.command({{"do", "redo"}})["t"], "done");
        EXPECT_EQ(client.checked_checksum()["volume"], open["volume"]);
    }
    for (const int threads : {1, 2}) {
        const auto replayed = replay_session(session, TaskArena(threads));
        ASSERT_TRUE(replayed.ok()) << replayed.error().message;
    }
}

TEST_F(OrganScene, TheForceOnAToolFollowsTheTissueUntilItIsFree) {
    auto server = Server::start({.file = (m_folder / "organ.stl").string()}, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient client(server->port(), server->link());
    client.enter();
    client.say({{"do", "tool"},
                {"kind", "sphere"},
                {"position", {0, -30, 0}},
                {"direction", {0, 1, 0}},
                {"radius", 8}});
    const auto is_felt = [&](auto holds) {
        for (int n = 0; n < 500; ++n) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            client.say({{"do", "ping"}, {"id", 6}});
            if (client.until("pong").is_null()) return false;
            const auto tools = read_tools(client.tools);
            if (tools && tools->size() == 1 && holds(tools->front().force_n)) return true;
        }
        return false;
    };
    const Json done = client.command({{"do", "push"},
                                      {"point", {0, -30, 0}},
                                      {"push", {0, 5, 0}},
                                      {"radius", 8},
                                      {"stroke", 1}});
    ASSERT_EQ(done["t"], "done");
    const auto at_first = float(double(done["force_n"][1]));
    EXPECT_LT(at_first, 0) << "against the push";
    // It is nearly right at once, and changes while the tissue comes to rest.
    EXPECT_TRUE(is_felt([&](Vec3f f) {
        return f.y < 0 && f.y != at_first && std::abs(f.y - at_first) < 0.05F * std::abs(at_first);
    })) << at_first;
    client.command({{"do", "undo"}});
    EXPECT_TRUE(is_felt([](Vec3f f) { return f == Vec3f{0, 0, 0}; }));
}

TEST_F(OrganScene, ANetworkMovesItAndTheForceFollowsItsStiffness) {
    std::vector<double> forces;
    for (const char* name : {"soft.json", "stiff.json"}) {
        SCOPED_TRACE(name);
        auto scene = Scene::open(
            {.file = (m_folder / "organ.vtu").string(), .network = (m_folder / name).string()},
            m_arena, m_arena);
        ASSERT_TRUE(scene.ok()) << scene.error().message;
        Scene& organ = **scene;
        EXPECT_EQ(organ.tissue().traits().model, "network");
        const Outcome cut = organ.carry_out(1, CutCommand{{{{0, -35, 0}, {0, 5, 0}}, {0, 0, 9}}});
        EXPECT_EQ(cut.error_code, "other_tissue");
        const std::uint64_t rest = hash_volume(organ.deformed());
        const PushCommand push{.push = {{0, -30, 0}, {0, 8, 0}, 8}, .stroke = 1};
        const Outcome outcome = organ.carry_out(1, push);
        ASSERT_TRUE(outcome.ok()) << outcome.message;
        EXPECT_NE(outcome.status, PushStatus::Rejected);
        ASSERT_TRUE(organ.update().ok());
        const auto value = [&](Vec3d p) {
            const Vec3d ijk = voxel_from_world(organ.deformed().grid, p);
            return double(organ.deformed().at(
                {int(std::lround(ijk.x)), int(std::lround(ijk.y)), int(std::lround(ijk.z))}));
        };
        EXPECT_LT(value({0, -27, 0}), -800);
        EXPECT_GT(value({0, -10, 0}), 0);
        EXPECT_GT(value({0, 28, 0}), 0);
        const auto tools = organ.tissue().figures();
        EXPECT_FALSE(tools.empty());
        forces.push_back(outcome.force_n ? norm(*outcome.force_n) : 0);
        ASSERT_TRUE(organ.carry_out(1, UndoCommand{}).ok());
        ASSERT_TRUE(organ.update().ok());
        EXPECT_EQ(hash_volume(organ.deformed()), rest);
    }
    EXPECT_GT(forces[0], 0.05);
    EXPECT_NEAR(forces[1] / forces[0], 4, 0.8);
}

TEST_F(OrganScene, ANetworkIsServedRecordedReplayedAndTiedToItsSession) {
    const auto session = m_folder / "n.pls";
    const ServerSettings settings{.file = (m_folder / "organ.vtu").string(),
                                  .network = (m_folder / "soft.json").string(),
                                  .session = session};
    {
        auto server = Server::start(settings, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient client(server->port(), server->link());
        client.enter();
        EXPECT_EQ(client.state["tissue"]["model"], "own");
        EXPECT_EQ(client.command({{"do", "relax"}, {"on", false}})["t"], "done");
        const Json rest = client.checked_checksum();
        EXPECT_EQ(client.command({{"do", "push"},
                                  {"point", {0, -30, 0}},
                                  {"push", {0, 5, 0}},
                                  {"radius", 8},
                                  {"stroke", 1}})["t"],
                  "done");
        EXPECT_NE(client.checked_checksum()["volume"], rest["volume"]);
    }
    for (const int threads : {1, 3}) {
        const auto replayed = replay_session(session, TaskArena(threads));
        ASSERT_TRUE(replayed.ok()) << replayed.error().message;
    }
    // The same scan without the network, or with another in its file, is another session.
    ServerSettings without = settings;
    without.network.clear();
    EXPECT_FALSE(Server::start(without, m_arena).ok());
    const TetMesh mesh = ellipsoid(m_arena);
    ASSERT_TRUE(write_network(m_folder / "soft.json", springs_of(mesh, 3001)).ok());
    EXPECT_FALSE(replay_session(session, TaskArena(1)).ok());
    ServerSettings missing = settings;
    missing.session.clear();
    missing.network = (m_folder / "none.json").string();
    const auto refused = Server::start(missing, m_arena);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "network");
}

TEST_F(OrganScene, FaultsNameTheFile) {
    const TetMesh mesh = ellipsoid(m_arena);
    TriangleMesh open = boundary_triangles(mesh);
    open.cells.pop_back();
    ASSERT_TRUE(write_surface(m_folder / "open.stl", open).ok());
    const auto message = [&](const char* name) {
        const auto organ = make_organs(organ_file_of_mesh((m_folder / name).string()), m_arena);
        return organ.ok() ? "loaded" : organ.error().message;
    };
    const std::string path = (m_folder / "open.stl").string();
    EXPECT_EQ(message("open.stl").rfind(path + ": ", 0), 0U) << message("open.stl");
    EXPECT_NE(message("missing.vtu"), "loaded");
    m_folder.write("points.vtk",
                   "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\n");
    EXPECT_FALSE(is_mesh_file(m_folder / "points.vtk"));
    EXPECT_TRUE(is_mesh_file("a.STL"));
    EXPECT_FALSE(is_mesh_file("a.nrrd"));
}

}  // namespace
}  // namespace pliant::serve
