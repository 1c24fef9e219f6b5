// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant body`: the labelled organs of a scan, and a mesh alone; its files and its errors.
// Covers: pliant/run_body.cpp.

#include <gtest/gtest.h>
#include <pliant/core/files.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/pbd.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <filesystem>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

class BodyProgram : public ProgramInFolder {
  protected:
    /// Two organs, 5 and 7, in fat, with air in front and bone behind.
    void write_scan() {
        const Grid grid{.size = {36, 30, 24}, .spacing_mm = {2, 2, 2}};
        VoxelArray<std::int16_t> values(voxel_count(grid)), numbers(voxel_count(grid));
        for (int k = 0; k < grid.size.z; ++k)
            for (int j = 0; j < grid.size.y; ++j)
                for (int i = 0; i < grid.size.x; ++i) {
                    const std::size_t at = voxel_index(grid, {i, j, k});
                    const bool inside = j >= 8 && j < 20 && k >= 6 && k < 18;
                    numbers[at] = std::int16_t(inside && i >= 6 && i < 18    ? 5
                                               : inside && i >= 18 && i < 30 ? 7
                                                                             : 0);
                    values[at] = std::int16_t(j < 3         ? -1000
                                              : j >= 27     ? 800
                                              : numbers[at] ? 60
                                                            : -90);
                }
        Volume scan{grid, std::move(values), {}}, labels{grid, std::move(numbers), {}};
        ASSERT_TRUE(write_volume(m_folder / "scan.nrrd", scan).ok());
        ASSERT_TRUE(write_volume(m_folder / "labels.nrrd", labels).ok());
    }
    const std::string m_push = " --push 24,28,24:0,1,0 --tool sphere:8 --steps 2 ";
};

TEST_F(BodyProgram, EachOrganOfTheLabelsIsABodyAndIsPushed) {
    write_scan();
    ASSERT_EQ(run("body scan.nrrd --labels labels.nrrd --bodies" + m_push +
                  "--out moved.vtu --volume moved.nrrd --report r.json"),
              0)
        << said();
    const Json report = Json::parse(bytes_of(m_folder / "r.json"));
    EXPECT_EQ(report["status"], "applied");
    ASSERT_EQ(report["notes"].size(), 3u) << report["notes"];
    EXPECT_EQ(report["notes"][0].get<std::string>().find("label 5: "), 0u);
    EXPECT_EQ(report["notes"][1].get<std::string>().find("label 7: "), 0u);
    EXPECT_GT(report["moved_elements"], 0);
    const auto moved = read_mesh(m_folder / "moved.vtu");
    ASSERT_TRUE(moved.ok()) << moved.error().message;
    EXPECT_EQ(moved->tetrahedra.size(), report["body"]["tetrahedra"]);
    // The tool's nodes moved with it.
    const MeshData::Field* displacement = moved->field("displacement_mm");
    ASSERT_TRUE(displacement);
    double farthest = 0;
    for (std::size_t n = 1; n < displacement->values.size(); n += 3)
        farthest = std::max(farthest, displacement->values[n]);
    EXPECT_NEAR(farthest, 1, 0.2);
}

TEST_F(BodyProgram, LengthsOfAMeshMayBeMetresOrCentimetres) {
    const auto write_box = [&](const std::string& name, double edge) {
        TriangleMesh box;
        for (int n = 0; n < 8; ++n)
            box.nodes_mm.push_back(
                {n & 1 ? edge : 0, n & 2 ? 0.75 * edge : 0, n & 4 ? 0.5 * edge : 0});
        box.cells = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
        ASSERT_TRUE(write_surface(m_folder / name, box).ok());
    };
    write_box("mm.obj", 40);
    write_box("cm.obj", 4);
    write_box("m.obj", 0.04);
    const std::string push = " --push 20,2,10:0,1,0 --tool sphere:8 --steps 1 --out ";
    ASSERT_EQ(run("body mm.obj" + push + "mm.vtu"), 0) << said();
    const auto whole = read_tetrahedra(m_folder / "mm.vtu");
    ASSERT_TRUE(whole.ok());
    for (const std::string unit : {"cm", "m"}) {
        ASSERT_EQ(run("body " + unit + ".obj --units " + unit + push + unit + ".vtu"), 0) << said();
        const auto moved = read_tetrahedra(m_folder / (unit + ".vtu"));
        ASSERT_TRUE(moved.ok());
        ASSERT_EQ(moved->nodes_mm.size(), whole->nodes_mm.size());
        for (std::size_t n = 0; n < moved->nodes_mm.size(); ++n)
            ASSERT_LT(norm(moved->nodes_mm[n] - whole->nodes_mm[n]), 1e-3);
    }
    m_folder.write("scene.toml", "[organs]\nunits = \"m\"\n[[body]]\nmesh = \"m.obj\"\n");
    ASSERT_EQ(run("body scene.toml" + push + "scene.vtu"), 0) << said();
    EXPECT_EQ(run("body scene.toml --units km" + push + "x.vtu"), 2);
    write_scan();
    EXPECT_EQ(run("body scan.nrrd --labels labels.nrrd --units m" + push + "x.vtu"), 2);
    EXPECT_NE(said().find("--units: expected a mesh or a scene of organs"), std::string::npos)
        << said();
}

TEST_F(BodyProgram, ABodyOfSpringsHasItsTimeStepAndItsNodes) {
    ASSERT_TRUE(write_vtu(m_folder / "block.vtu", five_tet_block({4, 4, 4}, 5), {}).ok());
    write("s.toml",
          "[[body]]\nmesh = \"block.vtu\"\nlaw = \"springs\"\nheld_mm = [[-1, -1, -1], [21, 21, "
          "1]]\n");
    ASSERT_EQ(run("body s.toml --push 10,10,20:0,0,-1 --tool sphere:6 --steps 2 --report r.json"),
              0)
        << said();
    EXPECT_NE(out().find("125 nodes (25 fixed), "), std::string::npos) << out();
    EXPECT_NE(out().find(", 2 steps of 16.7 ms"), std::string::npos) << out();
    const Json report = Json::parse(bytes_of(m_folder / "r.json"));
    EXPECT_EQ(report["network"]["network_nodes"], 125);
    EXPECT_EQ(report["network"]["fixed_nodes"], 25);
    EXPECT_NEAR(report["network"]["time_step_ms"].get<double>(), 1000.0 / 60, 1e-9);
}

TEST_F(BodyProgram, FaultsNameTheOptionOrTheFile) {
    write_scan();
    const auto fault = [&](const std::string& arguments) {
        EXPECT_EQ(run("body scan.nrrd " + arguments + m_push + "--out x.vtu"), 2) << arguments;
        EXPECT_FALSE(std::filesystem::exists(m_folder / "x.vtu")) << arguments;
        return said();
    };
    EXPECT_NE(fault("--bodies 5").find("--bodies: expected --labels"), std::string::npos);
    EXPECT_NE(fault("--labels labels.nrrd --bodies liver")
                  .find("--bodies: expected whole numbers above 0, found 'liver'"),
              std::string::npos);
    EXPECT_NE(fault("--labels labels.nrrd --bodies 500")
                  .find("expected labels of this map (5, 7), found 500"),
              std::string::npos)
        << said();
    EXPECT_NE(fault("").find("scan.nrrd: expected an organ's mesh"), std::string::npos);
}

}  // namespace
}  // namespace pliant::test
