// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant morph`: its files, and its answers to bad input.
// Covers: pliant/run_morph.cpp, pliant/morph_points.cpp.

#include <gtest/gtest.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "morph/shapes.h"
#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

class MorphTest : public ProgramInFolder {
  protected:
    static constexpr Vec3d kShift{7.5, -5, 2.5};

    void SetUp() override {
        Grid grid = cube_grid();
        grid.origin_mm = {20, 30, -80};  // no voxel is in the shape at both (x, y) and (−x, −y)
        const Vec3d centre{95, 95, 0}, radii{55, 40, 50};
        const auto in = [&](Vec3d c) {
            return shape(grid, [=](Vec3d x) { return in_ellipsoid(x, c, radii); });
        };
        ASSERT_TRUE(write_volume(m_folder / "from.nrrd", in(centre)).ok());
        ASSERT_TRUE(write_volume(m_folder / "to.nii.gz", in(centre + kShift)).ok());
        write("known.csv",
              "from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n"
              "90,90,0,97.5,85,2.5\n120,90,5,127.5,85,7.5\n95,110,-20,102.5,105,-17.5\n"
              "80,100,30,87.5,95,32.5\n");
        write("query.csv", "name,from_x_mm,from_y_mm,from_z_mm\na,100,100,10\r\nb,110,95,-10\n");
    }
    std::vector<std::string> predicted() const {
        std::istringstream text(bytes_of(m_folder / "out.csv"));
        std::vector<std::string> lines;
        for (std::string line; std::getline(text, line);) lines.push_back(line);
        return lines;
    }
    /// Distance of a predicted point of a line with the prefix from another one.
    static double off(const std::string& line, const std::string& prefix, Vec3d expected) {
        EXPECT_EQ(line.rfind(prefix, 0), 0u) << line;
        std::string rest = line.substr(prefix.size());
        std::replace(rest.begin(), rest.end(), ',', ' ');
        std::istringstream in(rest);
        Vec3d p{0, 0, 0};
        in >> p.x >> p.y >> p.z;
        return norm(p - expected);
    }
    void expect_bad(const std::string& arguments, const std::string& expected) {
        const auto before = names();
        EXPECT_EQ(run("morph " + arguments), 2) << arguments;
        EXPECT_NE(said().find(expected), std::string::npos) << said();
        const std::string text = said();
        EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
        EXPECT_EQ(names(), before);
    }
};

TEST_F(MorphTest, Predicts_points_from_points_from_shapes_and_from_both) {
    for (const char* input :
         {"--points known.csv", "from.nrrd to.nii.gz", "from.nrrd to.nii.gz --points known.csv"}) {
        ASSERT_EQ(run(std::string("morph ") + input + " --predict query.csv --out out.csv"), 0)
            << said();
        const auto lines = predicted();
        ASSERT_EQ(lines.size(), 3u);
        EXPECT_EQ(lines[0], "name,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm");
        EXPECT_LT(off(lines[1], "a,100,100,10,", {107.5, 95, 12.5}), 0.4);
        EXPECT_LT(off(lines[2], "b,110,95,-10,", {117.5, 90, -7.5}), 0.4);
        EXPECT_NE(out().find("no fold"), std::string::npos) << out();
    }
}

TEST_F(MorphTest, Writes_fields_a_moved_scan_and_a_report) {
    ASSERT_EQ(run("morph from.nrrd to.nii.gz --points known.csv --displacement u.nii.gz "
                  "--transform t.nrrd --jacobian j.nrrd --scan from.nrrd --volume moved.nrrd "
                  "--report r.json"),
              0)
        << said();
    const auto u = read_vector_field(m_folder / "u.nii.gz"),
               t = read_vector_field(m_folder / "t.nrrd");
    ASSERT_TRUE(u.ok() && t.ok());
    EXPECT_EQ(t->kind, FieldKind::Resampling);
    const std::size_t middle = voxel_index(u->grid, {30, 26, 32});
    const Vec3f forward = u->vectors_mm[middle], back = t->vectors_mm[middle];
    EXPECT_LT(norm(Vec3d{forward.x, forward.y, forward.z} - kShift), 0.4);
    EXPECT_LT(norm(Vec3d{back.x, back.y, back.z} + kShift), 0.4);
    const auto jacobian = read_volume(m_folder / "j.nrrd"),
               moved = read_volume(m_folder / "moved.nrrd"),
               to = read_labels(m_folder / "to.nii.gz");
    ASSERT_TRUE(jacobian.ok() && moved.ok() && to.ok());
    EXPECT_NEAR(jacobian->at({30, 26, 32}), 1, 0.05);
    int wrong = 0;
    for (int k = 0; k < 64; ++k)
        for (int j = 0; j < 52; ++j)
            for (int i = 0; i < 64; ++i)
                wrong += (moved->at({i, j, k}) > 0) != (to->at({i, j, k}) > 0);
    EXPECT_LT(wrong, 1500);  // of 30,000 in the shape
    const Json report = Json::parse(bytes_of(m_folder / "r.json"));
    EXPECT_EQ(report["points"], 4);
    EXPECT_EQ(report["parts"], 1);
    EXPECT_EQ(report["axes"], "lps");
    EXPECT_EQ(report["folded_cells"], 0);
    EXPECT_GE(report["least_volume"].get<double>(), 0.05);
    EXPECT_LT(report["point_residual_mm"].get<double>(), 0.4);
}

TEST_F(MorphTest, Points_that_lie_in_the_organ_as_ras_are_taken_so) {
    write("ras.csv", "from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n-100,-100,10,0,0,0\n");
    ASSERT_EQ(run("morph from.nrrd to.nii.gz --predict ras.csv --out out.csv"), 0) << said();
    EXPECT_NE(out().find("points taken as RAS"), std::string::npos) << out();
    // Columns that are there are replaced.
    EXPECT_LT(off(predicted().at(1), "-100,-100,10,", {-107.5, -95, 12.5}), 0.4);
    ASSERT_EQ(run("morph from.nrrd to.nii.gz --predict ras.csv --out out.csv --axes lps"), 0);
    EXPECT_EQ(out().find("RAS"), std::string::npos) << out();
    ASSERT_EQ(run("morph from.nrrd to.nii.gz --predict ras.csv --out out.csv --axes ras"), 0);
    EXPECT_LT(off(predicted().at(1), "-100,-100,10,", {-107.5, -95, 12.5}), 0.4);
}

TEST_F(MorphTest, Closed_surfaces_are_shapes_and_labels_have_moduli) {
    const auto octahedron = [](Vec3d c) {
        std::string text = "OFF\n6 8 0\n";
        for (int sign : {1, -1})
            for (int a = 0; a < 3; ++a) {
                Vec3d p = c;
                p[a] += sign * 60;
                for (int b = 0; b < 3; ++b) text += std::to_string(p[b]) + (b < 2 ? " " : "\n");
            }
        return text + "3 0 1 2\n3 1 3 2\n3 3 4 2\n3 4 0 2\n3 1 0 5\n3 3 1 5\n3 4 3 5\n3 0 4 5\n";
    };
    write("from.off", octahedron({100, 100, 0}));
    write("to.off", octahedron({108, 95, 3}));
    write("open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    ASSERT_EQ(run("morph from.off to.off --predict query.csv --out out.csv"), 0) << said();
    EXPECT_LT(off(predicted().at(1), "a,100,100,10,", {108, 95, 13}), 0.6);
    ASSERT_EQ(run("morph from.nrrd to.nii.gz --moduli 1=5 --predict query.csv --out out.csv"), 0)
        << said();
    EXPECT_LT(off(predicted().at(1), "a,100,100,10,", {107.5, 95, 12.5}), 0.4);
    const std::string tail = " --predict query.csv --out out.csv";
    expect_bad("open.off to.off" + tail, "open.off: ");
    expect_bad("from.nrrd to.nii.gz --moduli 4=5" + tail,
               "--moduli: expected labels of from (1), found 4");
    expect_bad("from.nrrd to.nii.gz --moduli 1=0" + tail,
               "--moduli: expected 0.001 to 1000 of label 1, found 0");
    expect_bad("from.nrrd to.nii.gz --moduli 1:5" + tail,
               "--moduli: expected LABEL=RATIO, such as 7=20, found '1:5'");
    expect_bad("--points known.csv --moduli 1=5" + tail,
               "--moduli: expected label maps that have the labels, found none");
}

TEST_F(MorphTest, Bad_input_is_named_and_writes_nothing) {
    write("short.csv", "from_x_mm,from_y_mm,from_z_mm\n1,2,3\n4,5\n");
    write("text.csv", "from_x_mm,from_y_mm,from_z_mm\n1,2,x\n");
    write("empty.csv", "from_x_mm,from_y_mm,from_z_mm\n");
    write("none.csv", "");
    const std::string tail = " --predict query.csv --out out.csv";
    expect_bad("from.nrrd" + tail, "TO: expected a label map of the other phase, found none");
    expect_bad(tail, "expected label maps, points or both, found neither");
    expect_bad("from.nrrd to.nii.gz", "or another output, found none");
    expect_bad("from.nrrd to.nii.gz --predict query.csv", "--out: expected a name");
    expect_bad("from.nrrd to.nii.gz --out out.csv", "--predict: expected the points to move");
    expect_bad("--points known.csv --volume v.nrrd", "--volume: expected --scan");
    expect_bad("--points query.csv" + tail,
               "query.csv: line 1: expected a column to_x_mm, found name,from_x_mm");
    expect_bad("--points known.csv --predict short.csv --out out.csv",
               "short.csv: line 3: expected 3 fields, found 4,5");
    expect_bad("--points known.csv --predict text.csv --out out.csv",
               "text.csv: line 2, from_z_mm: expected a number, found 'x'");
    expect_bad("--points known.csv --predict empty.csv --out out.csv",
               "empty.csv: expected a point or more, found none");
    expect_bad("--points known.csv --predict none.csv --out out.csv",
               "none.csv: expected a first line with the columns' names, found an empty file");
    expect_bad("--points known.csv --predict query.csv --out query.csv",
               "--out: expected a file of its own, found query.csv, which is an input");
    expect_bad("--points known.csv --displacement u.png", "--displacement: expected a name that");
    expect_bad("--points known.csv --poisson-ratio 0.5" + tail, "--poisson-ratio: expected");
    expect_bad("--points missing.csv" + tail, "missing.csv");
    expect_bad("from.nrrd missing.nrrd" + tail, "missing.nrrd");
    write("mirror.csv",
          "from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n"
          "0,0,0,0,0,0\n10,0,0,-10,0,0\n0,10,0,0,10,0\n0,0,10,0,0,10\n");
    expect_bad("--points mirror.csv" + tail, "mirror.csv: expected a motion without a fold");
}

}  // namespace
}  // namespace pliant::test
