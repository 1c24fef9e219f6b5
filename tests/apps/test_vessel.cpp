// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant vessel`: there and back in a phantom, a replay, and errors.
// Covers: pliant/run_vessel.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/catheter.h>

#include <algorithm>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

class VesselTest : public ProgramInFolder {};

const char* kScene =
    "[vessel]\nphantom = \"bend\"\nthickness_mm = 1.5\nlayers = 1\n"
    "[catheter]\nlength_mm = 100\n"
    "[entry]\nplace_mm = [0, 0, 5]\ndirection = [0, 0, 1]\n"
    "[[script]]\ninsert_mm_s = 400\nuntil_inserted_mm = 75\n"
    "[[script]]\nrotate_deg_s = 90\nbend_deg = [30, 10]\nfor_s = 0.02\n"
    "[[script]]\nfollow = true\ninsert_mm_s = -400\nuntil_inserted_mm = 40\n";

TEST_F(VesselTest, GoesInAndOutAndPlaysTheSameAgain) {
    write("s.toml", kScene);
    ASSERT_EQ(run("vessel s.toml --report r.json --csv m.csv --frames f --every 60 "
                  "--record hand.log --json"),
              0)
        << said();
    const Json report = Json::parse(out());
    EXPECT_EQ(report, Json::parse(bytes_of(m_folder / "r.json")));
    EXPECT_NEAR(report["inserted_mm"].get<double>(), 40, 0.5);
    EXPECT_NEAR(report["rotated_deg"].get<double>(), 90 * 0.02, 1e-6);
    EXPECT_LE(report["largest_depth_mm"].get<double>(), 0.1);
    EXPECT_GT(report["farthest_way_mm"].get<double>(), 60);
    EXPECT_EQ(report["wall_model"], "solid");
    EXPECT_GE(report["most_sub_steps"], report["sub_steps"]);
    EXPECT_GT(report["pace"], 0);
    const auto steps = report["steps"].get<std::int64_t>();
    const std::string csv = bytes_of(m_folder / "m.csv");
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), steps + 1);
    EXPECT_EQ(csv.substr(0, 5), "step,");
    // Frames of one moment belong together.
    const auto wall = read_tetrahedra(m_folder / "f/wall_00001.vtu");
    ASSERT_TRUE(wall.ok()) << wall.error().message;
    EXPECT_EQ(wall->cells.size(), report["tetrahedra"].get<std::size_t>());
    EXPECT_TRUE(exists("f/ghost_00001.vtp") && exists("f/catheter.pvd"));
    const auto line = read_mesh(m_folder / "f/catheter_00001.vtp");
    ASSERT_TRUE(line.ok());
    EXPECT_EQ(line->lines.size(), 1u);

    ASSERT_EQ(run("vessel s.toml --replay hand.log --threads 2 --json"), 0) << said();
    EXPECT_EQ(Json::parse(out())["hash"], report["hash"]);
    // Another hand is found out.
    std::string log = bytes_of(m_folder / "hand.log");
    log.replace(log.find("0 400"), 5, "0 399");
    write("other.log", log);
    EXPECT_EQ(run("vessel s.toml --replay other.log"), 2);
    EXPECT_NE(said().find("other.log: plays differently"), std::string::npos);
}

TEST_F(VesselTest, ReportsTheLargestValuesOfAllSteps) {
    std::string scene = kScene;
    scene.resize(scene.find("[[script]]"));
    write("s.toml", scene + "[[script]]\ninsert_mm_s = 400\nuntil_inserted_mm = 56\n");
    ASSERT_EQ(run("vessel s.toml --every 1 --threads 1 --json"), 0) << said();
    const Json each = Json::parse(out());
    ASSERT_EQ(run("vessel s.toml --frames f --every 31 --threads 2 --json"), 0) << said();
    const Json some = Json::parse(out());
    for (const char* key : {"farthest_way_mm", "largest_depth_mm", "largest_wall_moved_mm",
                            "volume_error_mean", "volume_error_largest", "inverted_ever"})
        EXPECT_EQ(some[key], each[key]) << key;
    EXPECT_EQ(some["energy_every_steps"], 31);
    EXPECT_LE(some["largest_energy_mj"], each["largest_energy_mj"]);
    const double moved = some["largest_wall_moved_mm"];
    EXPECT_GE(moved, some["end_wall_moved_mm"]);
    EXPECT_GT(some["volume_error_largest"], some["volume_error_mean"]);
    // No frame has more.
    double farthest = 0, largest = 0;
    const auto rest = read_tetrahedra(m_folder / "f/wall_00000.vtu");
    ASSERT_TRUE(rest.ok());
    for (int n = 1;; ++n) {
        const std::string frame = "f/wall_0000" + std::to_string(n) + ".vtu";
        if (!exists(frame.c_str())) break;
        const auto now = read_tetrahedra(m_folder / frame);
        ASSERT_TRUE(now.ok());
        for (std::size_t k = 0; k < rest->nodes_mm.size(); ++k)
            farthest = std::max(farthest, norm(now->nodes_mm[k] - rest->nodes_mm[k]));
        for (const auto& c : rest->cells) {
            const auto volume = [&](const TetMesh& mesh) {
                const auto at = [&](std::size_t k) { return mesh.nodes_mm[std::size_t(c[k])]; };
                return dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0)));
            };
            largest = std::max(largest, std::abs(volume(*now) / volume(*rest) - 1));
        }
    }
    EXPECT_GT(farthest, 0);
    EXPECT_LE(farthest, moved + 1e-5);
    EXPECT_LE(largest, some["volume_error_largest"].get<double>() + 1e-4);
}

TEST_F(VesselTest, DrawsTheVesselAndTheCatheterAtTheEnd) {
    std::string scene = kScene;
    scene.resize(scene.find("[[script]]"));
    write("near.toml", scene + "[[script]]\nfor_s = 0.002\n");
    write("far.toml", scene + "[[script]]\ninsert_mm_s = 400\nuntil_inserted_mm = 40\n");
    ASSERT_EQ(run("vessel near.toml --png near.png --json"), 0) << said();
    const std::string hash = Json::parse(out())["hash"];
    ASSERT_EQ(run("vessel far.toml --png far.png"), 0) << said();
    EXPECT_EQ(bytes_of(m_folder / "far.png").substr(1, 3), "PNG");
    EXPECT_NE(bytes_of(m_folder / "far.png"), bytes_of(m_folder / "near.png"));
    ASSERT_EQ(run("vessel near.toml --json"), 0);
    EXPECT_EQ(Json::parse(out())["hash"], hash);
    EXPECT_EQ(run("vessel near.toml --png near.jpg"), 2);
    EXPECT_NE(said().find("--png: expected a name that ends in .png"), std::string::npos) << said();
}

TEST_F(VesselTest, RefusesTheFormerModelOfACatheter) {
    std::string scene = kScene;
    scene.replace(scene.find("length_mm = 100"), 15, "length_mm = 100\nmodel = \"tetrahedra\"");
    write("s.toml", scene);
    ASSERT_EQ(run("vessel s.toml"), 2);
    EXPECT_NE(said().find("s.toml: [catheter] model: expected \"rod\", as each catheter is, found "
                          "another"),
              std::string::npos)
        << said();
    scene.replace(scene.find("tetrahedra"), 10, "rod");
    write("s.toml", scene);
    EXPECT_EQ(run("vessel s.toml"), 0) << said();
}

TEST_F(VesselTest, TakesAWallOfThePapersConstraints) {
    std::string scene = kScene;
    scene +=
        "[wall]\nmodel = \"distances\"\nstretch_stiffness = 0.2\n"
        "gravity_mm_s2 = [0, 0, -9810]\n"
        "iterations = 2\nalternates = true\n";
    write("s.toml", scene);
    ASSERT_EQ(run("vessel s.toml --record hand.log --json"), 0) << said();
    const Json report = Json::parse(out());
    EXPECT_EQ(report["wall_model"], "distances");
    EXPECT_LE(report["largest_depth_mm"].get<double>(), 0.1);
    EXPECT_EQ(report["inverted_ever"], 0);
    ASSERT_EQ(run("vessel s.toml --replay hand.log --threads 2 --json"), 0) << said();
    EXPECT_EQ(Json::parse(out())["hash"], report["hash"]);
}

TEST_F(VesselTest, TakesTheTetrahedraOfAWall) {
    std::string frames = kScene;
    frames.resize(frames.find("[[script]]"));
    write("frames.toml", frames + "[[script]]\nfor_s = 0.001\n");
    ASSERT_EQ(run("vessel frames.toml --frames f"), 0) << said();
    // At rest but for a step, with its ends found at the rims and its way in the lumen.
    const std::string own = "[vessel]\nmesh = \"f/wall_00000.vtu\"\n";
    const std::string script =
        "[catheter]\nlength_mm = 100\n[[script]]\nfollow = true\ninsert_mm_s = 400\n"
        "until_way_mm = 70\n";
    for (const std::string ghost : {"", "ghost = \"f/ghost_00000.vtp\"\n"}) {
        write("s.toml", own + ghost + script);
        ASSERT_EQ(run("vessel s.toml --json"), 0) << said();
        const Json report = Json::parse(out());
        EXPECT_LE(report["largest_depth_mm"].get<double>(), 0.1);
        EXPECT_GT(report["farthest_way_mm"].get<double>(), 60);  // of a few steps
        EXPECT_EQ(report["warnings"].size(), 0u);
    }
    const auto refused = [&](const std::string& scene, const std::string& message) {
        write("s.toml", scene + script);
        EXPECT_EQ(run("vessel s.toml"), 2);
        const std::string line = said();
        EXPECT_NE(line.find(message), std::string::npos) << line;
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
    };
    refused("[vessel]\nmesh = \"none.vtu\"\n", "[vessel] mesh: ");
    refused(own + "ghost = \"none.vtp\"\n", "[vessel] ghost: ");
    refused(own + "layers = 2\n",
            "[vessel] layers: expected none beside mesh, which has its own tetrahedra, found one");
    refused("[vessel]\nphantom = \"bend\"\nghost = \"g.vtp\"\n",
            "[vessel] ghost: expected mesh beside it, found none");
    refused(own + "[entry]\nplace_mm = [0, 9, 5]\ndirection = [0, 0, 1]\n",
            "[entry] place_mm: expected a position in the vessel's lumen");
    refused(own + "[entry]\nend = 3\n", "[entry] end: expected one of the vessel's 2 open ends");
    TetMesh wall = *read_tetrahedra(m_folder / "f/wall_00000.vtu");
    for (Vec3d& p : wall.nodes_mm) p = 1e-3 * p;
    ASSERT_TRUE(write_vtu(m_folder / "metres.vtu", wall, {}).ok());
    refused("[vessel]\nmesh = \"metres.vtu\"\n",
            " mm across, expected 10 or more, the length of the shortest catheter; lengths are in "
            "millimetres: multiply metres by 1000");
}

TEST_F(VesselTest, WarnsOfATipThatHasLeftThroughAnOpenEnd) {
    std::string scene = kScene;
    scene.replace(scene.find("length_mm = 100"), 15, "length_mm = 180");
    scene.replace(scene.find("until_inserted_mm = 75"), 22, "until_inserted_mm = 165");
    write("s.toml", scene);
    ASSERT_EQ(run("vessel s.toml --json"), 0) << said();
    const Json report = Json::parse(out());
    EXPECT_EQ(report["left_end"], 2);
    ASSERT_EQ(report["warnings"].size(), 1u) << report["warnings"];
    EXPECT_EQ(report["warnings"][0], "the tip has left the vessel through open end 2");
    EXPECT_LE(report["largest_depth_mm"].get<double>(), 0.1);  // inside the vessel
    ASSERT_EQ(run("vessel s.toml"), 0) << said();
    EXPECT_NE(out().find("warning             the tip has left"), std::string::npos) << out();
}

TEST_F(VesselTest, SaysInOneLineWhatIsWrong) {
    const auto refused = [&](const std::string& from, const std::string& to,
                             const std::string& message, const std::string& more = "") {
        std::string scene = kScene;
        if (from.empty())
            scene += to;
        else
            scene.replace(scene.find(from), from.size(), to);
        write("s.toml", scene);
        EXPECT_EQ(run("vessel s.toml --report r.json " + more), 2);
        EXPECT_NE(said().find(message), std::string::npos) << said();
        const std::string line = said();
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
        EXPECT_FALSE(exists("r.json"));
    };
    refused("\"bend\"", "\"knot\"",
            "s.toml: [vessel] phantom: expected \"bend\", \"arch\" or \"aorta\", found \"knot\"");
    refused("layers = 1", "cell_mm = 2",
            "[vessel] cell_mm: expected none beside phantom, which is swept in layers, found one");
    refused("[0, 0, 5]", "[0, 9, 5]",
            "s.toml: [entry] place_mm: expected a position in the vessel's lumen, found 0, 9, 5 "
            "outside");
    refused("length_mm = 100", "length_mm = \"long\"",
            "[catheter] length_mm: expected a number, found \"long\"");
    refused("length_mm", "lenght_mm", "[catheter] lenght_mm: expected one of length_mm");
    refused("phantom = \"bend\"", "surface = \"none.vtp\"",
            "[[script]] 3 follow: expected a [way] to follow, found none");
    refused("phantom = \"bend\"\nthickness_mm = 1.5\nlayers = 1\n",
            "surface = \"none.vtp\"\n[way]\npoints_mm = [[0, 0, 0], [0, 0, 9]]\n", "none.vtp");
    refused("phantom = \"bend\"", "", "s.toml: [vessel]: expected one of phantom, mesh, surface");
    refused("[entry]", "[wall]\nmodel = \"steel\"\n[entry]",
            "[wall] model: expected \"solid\", \"distances\" or \"rigid\", found \"steel\"");
    refused("[entry]", "[wall]\nstretch_stiffness = 2\n[entry]",
            "[wall] stretch_stiffness: expected 0 to 1, found 2");
    refused("place_mm = [0, 0, 5]", "end = 7", "[entry] end: expected one of the vessel's 2");
    refused("[0, 0, 5]", "[0, 5]", "[entry] place_mm: expected one number or three, found [0, 5]");
    refused("for_s = 0.02", "", "[[script]] 2 for_s: expected this, until_inserted_mm");
    refused("until_inserted_mm = 75", "until_way_mm = 2000",
            "until_way_mm: expected up to 146, the length of the way, found 2000");
    refused("", "[[scripts]]\n", "[[scripts]] 1: expected [vessel], [wall]");
    refused("", "nonsense", "s.toml: line ");
    refused("", "", "--volume: expected a scene with [vessel] scan", "--volume v.nrrd");
    refused("", "", "hand.log: expected a log of the hand", "--replay hand.log");
    write("hand.log", "pliant vessel log 1\n0 1 2\n");
    refused("", "", "hand.log: line 2: expected a step and four numbers", "--replay hand.log");
    write("hand.log", "pliant vessel log 1\n0 1 2 3 4\n10000001 1 2 3 4\nend 10000002 12\n");
    refused("", "", "hand.log: line 3: step 10000001, expected up to 10000000",
            "--replay hand.log");
    write("hand.log", "pliant vessel log 1\n0 1 2 3 4\nend 1e12 12\n");
    refused("", "", "hand.log: line 3: step 1e+12, expected up to 10000000", "--replay hand.log");
    write("hand.log", "pliant vessel log 1\n0 1 2 3 4\nend 10000000 12\n");
    refused("", "",
            "hand.log: has 10000000 steps, expected up to [simulation] max_steps of s.toml, "
            "1000000",
            "--replay hand.log");
    EXPECT_EQ(run("vessel nowhere.toml"), 2);
    EXPECT_NE(said().find("nowhere.toml: expected a scene file that can be read"),
              std::string::npos);
}

TEST_F(VesselTest, BoundsTheStepsThatAScriptAsksFor) {
    const auto message = [&](const std::string& simulation, const std::string& script) {
        write("s.toml", "[vessel]\nphantom = \"bend\"\n[simulation]\n" + simulation + script);
        const auto file = read_vessel_file((m_folder / "s.toml").string());
        return file.ok() ? "" : file.error().message;
    };
    const std::string act = "\n[[script]]\ninsert_mm_s = 1\nfor_s = ";
    EXPECT_EQ(message("", act + "600" + act + "400"), "");
    EXPECT_EQ(message("", act + "600" + act + "400.002"),
              (m_folder / "s.toml").string() +
                  ": [[script]] for_s: asks for 1000002 steps in all, expected up to 1000000; "
                  "[simulation] max_steps raises that up to 10000000");
    EXPECT_EQ(message("max_steps = 20", act + "1000"), "") << "it ends after 20";
    EXPECT_EQ(message("time_step_s = 0.01", act + "10000"), "");
    EXPECT_EQ(message("max_steps = 10000000", act + "10000"), "");
    EXPECT_NE(message("max_steps = 10000000", act + "10001").find("asks for 10001000 steps"),
              std::string::npos);
    EXPECT_NE(message("max_steps = 10000001", act + "1")
                  .find("[simulation] max_steps: expected 1 to 10000000, found 10000001"),
              std::string::npos);
}

}  // namespace
}  // namespace pliant::test
