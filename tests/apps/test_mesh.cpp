// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant mesh`: from a scan, a centreline and a surface; its output and its errors.
// Covers: pliant/run_mesh.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh_files.h>
#include <pliant/models/vessel.h>
#include <pliant/scan_files.h>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

class MeshTest : public ProgramInFolder {};

TEST_F(MeshTest, ACentrelineGetsAWallThatCanBeJudged) {
    const std::vector<Vec3d> nodes{{0, 0, 0}, {0, 0, 20}};
    const std::vector<double> radius{4, 4};
    const std::vector<std::vector<std::int32_t>> lines{{0, 1}};
    ASSERT_TRUE(write_lines(m_folder / "c.vtp", nodes, lines, {{}, {{"Radius", radius}}}).ok());
    ASSERT_EQ(run("mesh c.vtp --out w.vtu --ghost g.stl --json"), 0) << said();
    const Json made = Json::parse(out());
    EXPECT_EQ(made["boundary_euler"], 0);
    EXPECT_EQ(made["ends"], 2);
    EXPECT_GE(made["layers"], 2);
    EXPECT_GE(made["dihedral_min_deg"], 10.7);
    // The same as the library's, and the file holds it.
    const TaskArena arena(1);
    const auto wall = wall_around_centreline({{{{nodes[0], 4}, {nodes[1], 4}}}}, {}, arena);
    const auto read = read_tetrahedra(m_folder / "w.vtu");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->cells, wall->mesh.cells);
    EXPECT_EQ(read->nodes_mm, wall->mesh.nodes_mm);
    const auto ghost = read_surface(m_folder / "g.stl");
    ASSERT_TRUE(ghost.ok());
    EXPECT_EQ(ghost->cells.size(), wall->ghost.cells.size());
    ASSERT_EQ(run("mesh w.vtu --json"), 0) << said();
    const Json judged = Json::parse(out());
    EXPECT_EQ(judged["tetrahedra"], made["tetrahedra"]);
    EXPECT_EQ(judged["volume_mm3"], made["volume_mm3"]);
    ASSERT_EQ(run("mesh c.vtp --sweep --sectors 12 --out s.vtu"), 0) << said();
    EXPECT_NE(out().find("inverted            0"), std::string::npos);

    // A surface that is open where the tube is: its ghost.
    ASSERT_TRUE(write_surface(m_folder / "g.ply", wall->ghost).ok());
    ASSERT_EQ(run("mesh g.ply --thickness 1 --out again.vtu --json"), 0) << said();
    EXPECT_EQ(Json::parse(out())["ends"], 2);
    ASSERT_EQ(run("mesh g.ply"), 0);
    EXPECT_NE(out().find("Euler               0"), std::string::npos);
}

TEST_F(MeshTest, ASurfaceAndLabelsGetASolid) {
    // A box of labels in a volume, and the surface of the same solid.
    Volume labels{{.size = {24, 20, 16}, .spacing_mm = {2, 2, 3}}, VoxelArray<std::int16_t>(), {}};
    VoxelArray<std::int16_t> numbers(voxel_count(labels.grid));
    for (int k = 4; k < 12; ++k)
        for (int j = 5; j < 15; ++j)
            for (int i = 6; i < 18; ++i) numbers[voxel_index(labels.grid, {i, j, k})] = 5;
    labels.voxels = std::move(numbers);
    ASSERT_TRUE(write_volume(m_folder / "l.nrrd", labels).ok());
    ASSERT_EQ(run("mesh l.nrrd --labels 5 --smooth 0 --solid --tetrahedra 4000 --out s.vtu "
                  "--surface f.stl --json"),
              0)
        << said();
    const Json made = Json::parse(out());
    EXPECT_GT(made["tetrahedra"], 2000);
    EXPECT_LT(made["tetrahedra"], 8000);
    EXPECT_GE(made["dihedral_min_deg"], 10.7);
    EXPECT_EQ(made["boundary_euler"], 2);
    EXPECT_NEAR(double(made["corners_mm"][0][1]), 9, 0.5);
    EXPECT_NEAR(double(made["corners_mm"][1][2]), 34.5, 0.5);
    EXPECT_NEAR(double(made["volume_mm3"]), 8 * 10 * 12 * 12, 0.05 * 8 * 10 * 12 * 12);

    const auto filled = read_surface(m_folder / "f.stl");
    ASSERT_TRUE(filled.ok()) << filled.error().message;
    EXPECT_NEAR(enclosed_volume_mm3(*filled), double(made["surface_mm3"]), 1);
    for (const char* of_walls : {"--ghost g.vtp", "--thickness 3", "--layers 3", "--sweep",
                                 "--ends c.vtp", "--ghost-cell 2", "--seed 0,0,0"}) {
        const std::string solid = "mesh l.nrrd --labels 5 --solid --out u.vtu ";
        EXPECT_EQ(run(solid + of_walls), 2) << of_walls;
        EXPECT_FALSE(std::filesystem::exists(m_folder / "u.vtu")) << of_walls;
    }

    const auto read = read_tetrahedra(m_folder / "s.vtu");
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_TRUE(write_surface(m_folder / "s.stl", boundary_triangles(*read)).ok());
    ASSERT_EQ(run("mesh s.stl --solid --cell 4 --out t.vtu"), 0) << said();
    EXPECT_NE(out().find("inverted            0"), std::string::npos) << out();
    EXPECT_NE(out().find("cells               4 mm"), std::string::npos) << out();
    ASSERT_EQ(run("mesh t.vtu"), 0) << said();
    EXPECT_NE(out().find("corners             1"), std::string::npos) << out();
    EXPECT_EQ(run("mesh s.stl --solid --out u.vtu --surface f.stl"), 2);
    EXPECT_NE(said().find("--surface: expected a scan"), std::string::npos) << said();

    EXPECT_EQ(run("mesh l.nrrd --solid --out t.vtu"), 2);
    EXPECT_NE(said().find("--labels: expected the solid's labels"), std::string::npos) << said();
    TriangleMesh open = boundary_triangles(*read);
    open.cells.pop_back();
    ASSERT_TRUE(write_surface(m_folder / "o.stl", open).ok());
    EXPECT_EQ(run("mesh o.stl --solid --out u.vtu"), 2);
    EXPECT_EQ(said().find("pliant: o.stl: "), 0U) << said();
    EXPECT_FALSE(std::filesystem::exists(m_folder / "u.vtu"));
}

TEST_F(MeshTest, AScanGetsAWallOfItsLumen) {
    ASSERT_EQ(run("phantom vessel --size 96 --out v.nrrd"), 0) << said();
    ASSERT_EQ(run("mesh v.nrrd --seed=-6,3,-36 --window 160,320 --thickness 1.2 --out w.vtu "
                  "--surface l.obj --json"),
              0)
        << said();
    const Json report = Json::parse(out());
    EXPECT_GE(report["ends"], 3);
    EXPECT_GE(report["layers"], 2);
    EXPECT_EQ(report["inverted"], 0);
    const auto surface = read_surface(m_folder / "l.obj");
    ASSERT_TRUE(surface.ok()) << surface.error().message;
    EXPECT_TRUE(check_closed(*surface).ok());
    EXPECT_EQ(run("mesh v.nrrd --out w2.vtu"), 2);
    EXPECT_EQ(said(),
              "pliant: expected --seed with --window, or --labels, for the lumen in a "
              "scan\n");
    EXPECT_EQ(run("mesh v.nrrd --seed=500,0,0 --window 160,320 --out w2.vtu"), 2);
    EXPECT_NE(said().find("lies outside of the scan"), std::string::npos);
    EXPECT_FALSE(exists("w2.vtu"));
}

TEST_F(MeshTest, ASurfaceThatFacesInwardsIsNoted) {
    const std::string nodes = "v 0 0 0\nv 6 0 0\nv 0 6 0\nv 0 0 6\n";
    write("out.obj", nodes + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    write("in.obj", nodes + "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n");
    ASSERT_EQ(run("mesh out.obj"), 0) << said();
    EXPECT_NE(out().find("triangles           4, 4 nodes, 1 piece\n"), std::string::npos) << out();
    EXPECT_NE(out().find("encloses            36.0 mm3\n"), std::string::npos) << out();
    ASSERT_EQ(run("mesh in.obj"), 0) << said();
    EXPECT_NE(out().find("encloses            36.0 mm3, its triangles face inwards\n"),
              std::string::npos)
        << out();
}

TEST_F(MeshTest, WhatCantBeUsedIsSaidInOneLine) {
    // The second tetrahedron is folded into the first one.
    TetMesh mesh{{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}, {3, 3, 3}},
                 {{0, 1, 2, 3}, {1, 2, 3, 4}}};
    ASSERT_TRUE(write_vtu(m_folder / "t.vtu", mesh).ok());
    EXPECT_EQ(run("mesh t.vtu"), 2);
    EXPECT_EQ(said(), "pliant: t.vtu: mesh: found 1 inverted or flat tetrahedra, expected none\n");
    m_folder.write("a.obj",
                   "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 -1\n"
                   "f 1 2 3\nf 1 2 4\nf 1 2 5\n");
    EXPECT_EQ(run("mesh a.obj --out w.vtu"), 2);
    EXPECT_EQ(said().find("pliant: a.obj: vessel wall: the surface has"), 0u) << said();
    EXPECT_EQ(run("mesh a.obj --out w.stl"), 2);
    EXPECT_EQ(said(), "pliant: --out: expected a file that ends in .vtu, found 'w.stl'\n");
    EXPECT_EQ(run("mesh missing.vtp"), 2);
    EXPECT_EQ(said(), "pliant: missing.vtp: expected a file, found none\n");
    for (const char* arguments : {"mesh missing.nrrd", "mesh missing.xyz --solid --out w.vtu"}) {
        EXPECT_EQ(run(arguments), 2);
        EXPECT_NE(said().find(": no such file or folder\n"), std::string::npos) << said();
    }
    m_folder.write("ball.xyz", "0 0 0\n");
    for (const char* arguments : {"mesh ball.xyz", "mesh ball.xyz --solid --out w.vtu"}) {
        EXPECT_EQ(run(arguments), 2);
        EXPECT_EQ(said(),
                  "pliant: ball.xyz: '.xyz' is an ending of neither a mesh nor a scan, expected "
                  ".vtp, .vtu, .vtk, .msh, .stl, .obj, .ply, .off or .mesh, or a scan\n");
    }
    EXPECT_FALSE(exists("w.vtu"));
}

TEST_F(MeshTest, WhatWasPutRightIsNoted) {
    m_folder.write("t.off",
                   "OFF\n5 5 0\n0 0 0\n0.01 0 0\n0 0.01 0\n0 0 0.01\n0.01 0 0.00000001\n"
                   "3 0 2 1\n3 0 4 3\n3 1 2 3\n3 0 3 2\n3 0 3 2\n");
    ASSERT_EQ(run("mesh t.off --units m"), 0) << said();
    EXPECT_NE(out().find("encloses            166.7 mm3\n"), std::string::npos) << out();
    EXPECT_NE(
        out().find("note                corners within 0.00017 mm of each other were joined: 0 "
                   "open edges instead of 4\n"
                   "note                1 repeated triangle was dropped\n"),
        std::string::npos)
        << out();
    ASSERT_EQ(run("mesh t.off --json"), 0) << said();
    EXPECT_EQ(Json::parse(out())["notes"][0],
              "the mesh is 0.0173 mm across: lengths are in millimetres, and --units m "
              "converts metres");
    EXPECT_EQ(run("mesh t.off --units km"), 2);
}

}  // namespace
}  // namespace pliant::test
