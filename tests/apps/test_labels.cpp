// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps of the program: layers, and labels that move with the scan.
// Covers: pliant/run_deform.cpp, formats/read_labels.cpp.

#include <gtest/gtest.h>
#include <pliant/scan_files.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

class LabelsTest : public ProgramInFolder {};

TEST_F(LabelsTest, LabelsMoveWithTheScan) {
    ASSERT_EQ(run("phantom cube --size 48 --out cube.nrrd"), 0) << said();
    auto labels = read_volume(m_folder / "cube.nrrd");
    ASSERT_TRUE(labels.ok());
    const Grid grid = labels->grid;
    std::vector<std::int16_t> values(voxel_count(grid));
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = std::int16_t(n % 7 + n / 1000);
    labels->voxels = values;
    labels->key_values = {{"Segment0_Name", "liver"}, {"Segment0_Extent", "0 1 0 1 0 1"}};
    ASSERT_TRUE(write_volume(m_folder / "map.nrrd", *labels).ok());
    write("free.toml", "[material]\nbone_threshold_hu = 3000\n[air]\nenabled = false\n");
    for (const char* model :
         {"--config free.toml", "--model springs --cell-mm 5 --fixed-hu 3000 --steps 3"}) {
        SCOPED_TRACE(model);
        ASSERT_EQ(
            run("deform cube.nrrd --push 0,0,0:0,6,0 --tool sphere:5 --labels map.nrrd " +
                std::string(model) + " --labels-out moved.nrrd --transform t.nrrd --out r.nrrd"),
            0)
            << said();
        const auto moved = read_volume(m_folder / "moved.nrrd");
        const auto transform = read_vector_field(m_folder / "t.nrrd");
        ASSERT_TRUE(moved.ok() && transform.ok());
        EXPECT_EQ(moved->key_values, (KeyValues{{"Segment0_Name", "liver"}}));
        int changed = 0, wrong = 0;
        for (int k = 0; k < grid.size.z; ++k)
            for (int j = 0; j < grid.size.y; ++j)
                for (int i = 0; i < grid.size.x; ++i) {
                    const Vec3i p{i, j, k};
                    const Vec3f u = transform->vectors_mm[voxel_index(grid, p)];
                    const Vec3d source = voxel_from_world(
                        grid, world_from_voxel(grid, {double(i), double(j), double(k)}) +
                                  Vec3d{double(u.x), double(u.y), double(u.z)});
                    const Vec3i nearest{int(std::lround(source.x)), int(std::lround(source.y)),
                                        int(std::lround(source.z))};
                    const float expected =
                        contains(voxel_box(grid), nearest) ? labels->at(nearest) : 0;
                    wrong += moved->at(p) != expected;
                    changed += moved->at(p) != labels->at(p);
                }
        EXPECT_EQ(wrong, 0);
        EXPECT_GT(changed, 100);
    }
}

TEST_F(LabelsTest, OfALayerHaveTheNamesOfItsSegments) {
    // Two organs that overlap, each 1 in a layer of its own.
    Volume scan{
        {.size = {40, 48, 32}, .spacing_mm = {1.5, 1.5, 2}}, VoxelArray<std::int16_t>(), {}};
    VoxelArray<std::int16_t> values(voxel_count(scan.grid));
    std::string layers;
    for (int k = 0; k < 32; ++k)
        for (int j = 0; j < 48; ++j)
            for (int i = 0; i < 40; ++i) {
                const bool in_scan = i > 2 && i < 37 && j > 2 && j < 44 && k > 1 && k < 30;
                const bool inside = j >= 10 && j < 40 && k >= 6 && k < 26;
                values[voxel_index(scan.grid, {i, j, k})] = in_scan ? 40 : -1000;
                layers += char(inside && i >= 6 && i < 18);
                layers += char(inside && i >= 14 && i < 32);
            }
    scan.voxels = std::move(values);
    ASSERT_TRUE(write_volume(m_folder / "scan.nrrd", scan).ok());
    write("over.seg.nrrd",
          "NRRD0004\ntype: uchar\ndimension: 4\nspace: left-posterior-superior\nsizes: 2 40 48 "
          "32\nspace directions: none (1.5,0,0) (0,1.5,0) (0,0,2)\nkinds: list domain domain "
          "domain\nencoding: raw\nspace origin: (0,0,0)\nSegment0_Name:=first "
          "organ\nSegment0_LabelValue:=1\nSegment0_Layer:=0\nSegment1_Name:=second "
          "organ\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n\n" +
              layers);
    const std::string push =
        " --bodies 1 --push 20,35,30:0,0,3 --tool sphere:10 --steps 1 --report o.json";
    EXPECT_EQ(run("body scan.nrrd --labels over.seg.nrrd" + push), 2);
    EXPECT_NE(said().find("over.seg.nrrd#0 (first organ), over.seg.nrrd#1 (second organ)"),
              std::string::npos)
        << said();
    for (const auto& [layer, name] :
         {std::pair("0", "first organ: "), std::pair("1", "second organ: ")}) {
        ASSERT_EQ(run("body scan.nrrd --labels over.seg.nrrd#" + std::string(layer) + push), 0)
            << said();
        const Json report = Json::parse(bytes_of(m_folder / "o.json"));
        EXPECT_EQ(std::string(report["notes"][0]).substr(0, std::string(name).size()), name);
    }
}

}  // namespace
}  // namespace pliant::test
