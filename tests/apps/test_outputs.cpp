// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Where outputs go: streams and links, all of a command or none, every format that --help promises.
// Covers: pliant/*output*.cpp, base/staged_files.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>
#include <sys/stat.h>

#include <algorithm>
#include <thread>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

class OutputsTest : public ProgramInFolder {
  protected:
    void make_cube() const { ASSERT_EQ(run("phantom cube --size 24 --out c.nrrd"), 0) << said(); }
    void write_scene() const {
        write("s.toml",
              "[vessel]\nphantom = \"bend\"\nlayers = 1\n[catheter]\nlength_mm = 100\n"
              "[entry]\nplace_mm = [0, 0, 5]\ndirection = [0, 0, 1]\n"
              "[[script]]\ninsert_mm_s = 400\nuntil_inserted_mm = 12\n");
    }
};

TEST_F(OutputsTest, ReportsGoToStandardOutputAndPipes) {
    make_cube();
    const std::string push = "deform c.nrrd --push 0,0,0:1,0,0 --out o.nrrd --report ";
    for (const char* name : {"-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"}) {
        ASSERT_EQ(run(push + name), 0) << said();
        EXPECT_TRUE(Json::parse(out()).contains("status")) << "nothing else is there";
    }
    EXPECT_TRUE(fs::is_symlink("/dev/stdout") || fs::is_character_file("/dev/stdout"));
    ASSERT_EQ(run(push + "/dev/fd/3 3>three.json"), 0) << said();
    EXPECT_TRUE(Json::parse(bytes_of(m_folder / "three.json")).contains("status"));
    ASSERT_EQ(::mkfifo((m_folder / "pipe").c_str(), 0600), 0);
    std::string read;
    std::thread reader([&] { read = bytes_of(m_folder / "pipe"); });
    EXPECT_EQ(run(push + "pipe"), 0) << said();
    reader.join();
    EXPECT_TRUE(Json::parse(read).contains("status"));
    fs::remove(m_folder / "o.nrrd");
    EXPECT_EQ(run(push + "pipe"), 2);
    EXPECT_EQ(said(), "pliant: pipe: can't be written (no process reads it)\n");
    EXPECT_EQ(run(push + "/dev/fd/0 </dev/null"), 2);
    EXPECT_EQ(said(), "pliant: /dev/fd/0: can't be written (Bad file descriptor)\n");
    EXPECT_EQ(run(push + "/dev/fd/9 9>&-"), 2);
    EXPECT_EQ(names(), (Names{"c.nrrd", "pipe", "three.json"}));
}

TEST_F(OutputsTest, LinksStayAndTheirFilesAreWritten) {
    make_cube();
    fs::create_directory(m_folder / "far");
    fs::create_symlink("far/real.nrrd", m_folder / "link.nrrd");
    fs::create_symlink("far/real.json", m_folder / "link.json");
    for (int n = 0; n < 2; ++n) {
        ASSERT_EQ(run("deform c.nrrd --push 0,0,0:1,0,0 --out link.nrrd --report link.json --raw"),
                  0)
            << said();
        EXPECT_TRUE(fs::is_symlink(m_folder / "link.nrrd"));
        EXPECT_TRUE(Json::parse(bytes_of(m_folder / "far/real.json")).contains("status"));
    }
    EXPECT_EQ(names(), (Names{"c.nrrd", "far", "link.json", "link.nrrd"}));
    // A link to the input is the input.
    fs::create_symlink("c.nrrd", m_folder / "own.nrrd");
    EXPECT_EQ(run("deform c.nrrd --push 0,0,0:1,0,0 --out own.nrrd"), 2);
    EXPECT_NE(said().find("--out: expected a file of its own"), std::string::npos) << said();
}

TEST_F(OutputsTest, ConvertWritesTheSameScanInEveryFormat) {
    make_cube();
    const auto cube = read_volume(m_folder / "c.nrrd");
    ASSERT_TRUE(cube.ok());
    for (const char* name : {"o.nrrd", "o.nhdr", "o.mha", "o.mhd", "o.nii", "o.nii.gz"}) {
        EXPECT_EQ(run(std::string("convert c.nrrd ") + name), 0) << said();
        const auto again = read_volume(m_folder / name);
        ASSERT_TRUE(again.ok()) << again.error().message;
        EXPECT_EQ(again->voxels, cube->voxels) << name;
        EXPECT_EQ(again->grid.size, cube->grid.size) << name;
        EXPECT_LT(norm(world_from_voxel(again->grid, {9, 8, 7}) -
                       world_from_voxel(cube->grid, {9, 8, 7})),
                  1e-5)
            << name;
    }
    // Nothing is read for a name that can't be written, and nothing is written for a bad scan.
    EXPECT_EQ(run("convert none.nrrd o.dcm"), 2);
    EXPECT_NE(said().find("OUT: expected a name that ends in .nrrd"), std::string::npos) << said();
    EXPECT_EQ(run("convert none.nrrd new.nii"), 2);
    EXPECT_NE(said().find("none.nrrd: no such file"), std::string::npos) << said();
    EXPECT_FALSE(exists("new.nii"));
}

TEST_F(OutputsTest, AScanOfOneSliceIsDeformedAndStaysOne) {
    Volume slice;
    slice.grid.size = {40, 30, 1};
    slice.grid.spacing_mm = {1, 1, 3};
    slice.grid.origin_mm = {-20, -10, 7};
    auto& voxels = slice.voxels.emplace<0>(std::size_t(1200));
    for (std::size_t n = 0; n < 1200; ++n) voxels[n] = std::int16_t(n % 40 < 20 ? 40 : 80);
    ASSERT_TRUE(write_volume(m_folder / "flat.nii.gz", slice).ok());
    ASSERT_EQ(
        run("deform flat.nii.gz --push 0,5,7:6,0,0 --tool sphere:4 --out o.mha --report r.json"), 0)
        << said();
    const auto out = read_volume(m_folder / "o.mha");
    ASSERT_TRUE(out.ok()) << out.error().message;
    EXPECT_EQ(out->grid.size, slice.grid.size);
    EXPECT_EQ(out->grid.spacing_mm, slice.grid.spacing_mm);
    EXPECT_LT(norm(out->grid.origin_mm - slice.grid.origin_mm), 1e-12);
    // The edge at x = 0 moved with the sphere, by 6 mm, and less elsewhere.
    const auto edge_of_row = [&](int j) {
        int i = 0;
        while (i < 39 && out->at({i, j, 0}) < 60) ++i;
        return i;
    };
    EXPECT_EQ(edge_of_row(15), 26);
    EXPECT_GE(edge_of_row(0), 20);
    EXPECT_LT(edge_of_row(0), 26);
    EXPECT_EQ(run("info flat.nii.gz --json"), 0) << said();
    const Json info = Json::parse(this->out());
    EXPECT_EQ(info["size"], (std::vector<int>{40, 30, 1}));
    EXPECT_EQ(info["centre_mm"]["lps"], (std::vector<double>{-0.5, 4.5, 7}));
    EXPECT_EQ(info["centre_mm"]["ras"], (std::vector<double>{0.5, -4.5, 7}));
    EXPECT_EQ(info["bounds_mm"]["lps"],
              (std::vector<std::vector<double>>{{-20, -10, 7}, {19, 19, 7}}));
    EXPECT_EQ(info["bounds_mm"]["ras"],
              (std::vector<std::vector<double>>{{-19, -19, 7}, {20, 10, 7}}));
    EXPECT_EQ(run("render flat.nii.gz --view axial --out v.png"), 0) << said();
    // A picture is PNG, and its name says so.
    for (const std::string name : {"v.jpg", "v", "png"}) {
        EXPECT_EQ(run("render flat.nii.gz --view axial --out " + name), 2);
        EXPECT_EQ(said(), "pliant: --out: expected a name that ends in .png, found " + name + "\n");
        EXPECT_FALSE(std::filesystem::exists(m_folder / name));
    }
    EXPECT_EQ(run("render flat.nii.gz --view axial --out W.PNG"), 0) << said();
}

TEST_F(OutputsTest, FramesAndStraightenedScansAreRead) {
    Volume image;
    image.grid.size = {6, 5, 4};
    image.voxels = VoxelArray<std::int16_t>(std::vector<std::int16_t>(120, 7));
    ASSERT_TRUE(write_volume(m_folder / "a.nii", image).ok());
    std::string bytes = bytes_of(m_folder / "a.nii");
    bytes[40] = 4;
    bytes[48] = 2;
    for (int n = 0; n < 120; ++n) bytes += std::string("\x09\0", 2);
    write("a.nii", bytes);
    EXPECT_EQ(run("info a.nii"), 2);
    EXPECT_EQ(said(), "pliant: a.nii: holds 2 images, choose one with --frame 0…1\n");
    EXPECT_EQ(run("convert a.nii b.nrrd --frame 1"), 0) << said();
    EXPECT_EQ(read_volume(m_folder / "b.nrrd")->at({0, 0, 0}), 9);
    for (const char* command : {"info a.nii", "deform a.nii --push 2,2,2:1,0,0 --out o.nrrd",
                                "render a.nii --view axial --out v.png"})
        EXPECT_EQ(run(std::string(command) + " --frame 0"), 0) << said();
    write("s.nrrd",
          "NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\n"
          "sizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) (1,0,1)\nencoding: text\n"
          "space origin: (0,0,0)\n\n1 2 3 4 5 6 7 8\n");
    EXPECT_EQ(run("convert s.nrrd t.nrrd"), 2);
    EXPECT_NE(said().find("--straighten"), std::string::npos) << said();
    EXPECT_EQ(run("convert s.nrrd t.nrrd --straighten"), 0) << said();
    EXPECT_NE(out().find("note: straightened: resampled from 2 × 2 × 2 to 3 × 2 × 2 voxels"),
              std::string::npos)
        << out();
}

TEST_F(OutputsTest, EveryFormatThatHelpPromisesIsWritten) {
    make_cube();
    const std::string push = "deform c.nrrd --push 0,0,0:1,0,0 ";
    for (const char* name : {"o.nrrd", "o.nhdr", "o.mha", "o.mhd", "o.nii", "o.nii.gz", "o.vti"}) {
        EXPECT_EQ(run(push + "--out " + name), 0) << said();
        EXPECT_TRUE(exists(name)) << name;
    }
    EXPECT_EQ(
        bytes_of(m_folder / "o.vti").find("<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\""),
        0u);
    EXPECT_EQ(run(push + "--out o.vtk"), 2);
    EXPECT_NE(said().find("--out: expected a name that ends in .nrrd, .nhdr, .mha, .mhd, .nii, "
                          ".nii.gz or .vti, found o.vtk"),
              std::string::npos)
        << said();
    EXPECT_EQ(run(push + "--out o.nrrd --displacement u.nhdr --transform t.nhdr --jacobian j.nhdr "
                         "--strain e.nhdr --report r.json --png p.png --save-state s.plst"),
              0)
        << said();
    for (const char* name :
         {"u.nhdr", "u.raw.gz", "t.nhdr", "j.nhdr", "e.nhdr", "r.json", "p.png", "s.plst"})
        EXPECT_TRUE(exists(name)) << name;
    const std::vector<Vec3d> nodes{{0, 0, 0}, {0, 0, 20}};
    const std::vector<double> radius{4, 4};
    const std::vector<std::vector<std::int32_t>> lines{{0, 1}};
    ASSERT_TRUE(write_lines(m_folder / "c.vtp", nodes, lines, {{}, {{"Radius", radius}}}).ok());
    for (const char* ghost : {"g.vtp", "g.stl", "g.obj", "g.ply"}) {
        EXPECT_EQ(run("mesh c.vtp --out w.vtu --ghost " + std::string(ghost)), 0) << said();
        EXPECT_TRUE(exists(ghost)) << ghost;
    }
}

TEST_F(OutputsTest, StatusTwoMeansThatNothingWasWritten) {
    make_cube();
    write_scene();
    ASSERT_EQ(run("vessel s.toml --record s.log"), 0) << said();
    std::string log = bytes_of(m_folder / "s.log");
    log[log.find("end") + 8] ^= 1;
    write("other.log", log);
    write("camera.json", "{}");
    write(
        "way.mrk.json",
        R"({"markups": [{"controlPoints": [{"position": [0, 0, 0]}, {"position": [0, 0, 4]}]}]})");
    const std::vector<Vec3d> nodes{{0, 0, 0}, {0, 0, 20}};
    const std::vector<double> radius{4, 4};
    const std::vector<std::vector<std::int32_t>> lines{{0, 1}};
    ASSERT_TRUE(write_lines(m_folder / "c.vtp", nodes, lines, {{}, {{"Radius", radius}}}).ok());
    fs::create_directory(m_folder / "old");
    write("old/wall.pvd", "old");
    const Names before = names();
    const char* const cases[] = {
        "vessel s.toml --replay other.log --report r.json --csv m.csv --frames f --every 5",
        "vessel s.toml --replay other.log --report r.json --frames old --every 5",
        "vessel s.toml --report r.json --frames f/g/h --record no/folder/s.log",
        "vessel s.toml --report /dev/full --csv m.csv --frames f --record s2.log",
        "haptics check --minutes 0.005 --record h.txt --out no/folder/h.json",
        "haptics check --minutes 0.005 --record h.txt --out /dev/full",
        "mesh c.vtp --out w.vtu --ghost no/folder/g.stl",
        "mesh c.vtp --out w.vtu --ghost g.what",
        "render c.nrrd --path way.mrk.json --movie m/ --view endoscope --size 16x16 --threads 900",
        "render c.nrrd --keyframes camera.json --movie m/",
        "render c.nrrd --path way.mrk.json --movie m.what --size 16x16",
        "fit --size 3,3,3 --report no/folder/r.json",
    };
    for (const char* arguments : cases) {
        EXPECT_EQ(run(arguments), 2) << arguments;
        const std::string line = said();
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << arguments << ": " << line;
        EXPECT_EQ(line.find(".pliant-"), std::string::npos) << line;
        EXPECT_EQ(names(), before) << arguments;
        EXPECT_EQ(bytes_of(m_folder / "old/wall.pvd"), "old");
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(m_folder / "old"), {}), 1);
    // And the same in full.
    EXPECT_EQ(
        run("vessel s.toml --report r.json --csv m.csv --frames f/g --every 5 --record h.log"), 0)
        << said();
    EXPECT_TRUE(exists("r.json") && exists("m.csv") && exists("f/g/wall_00000.vtu") &&
                exists("f/g/wall.pvd") && exists("h.log"));
}

TEST_F(OutputsTest, NamesAreQuotedForTheShell) {
    for (const char* name : {"a scan's $(x).nrrd", "plain.nrrd"}) {
        const std::string quoted =
            std::string(name) == "plain.nrrd" ? name : "'a scan'\\''s $(x).nrrd'";
        ASSERT_EQ(run("phantom airway --size 24 --out " + quoted), 0) << said();
        EXPECT_NE(out().find("pliant deform "), std::string::npos) << out();
        ASSERT_EQ(run("info " + quoted), 0) << said();
        const std::string text = out();
        EXPECT_NE(text.find("pliant render " + quoted + " --out view.png"), std::string::npos)
            << text;
        EXPECT_NE(text.find("pliant info " + quoted + " --suggest-push"), std::string::npos)
            << text;
    }
}

}  // namespace
}  // namespace pliant::test
