// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The program as a user starts it: exit status, standard error, files.
// Covers: pliant/main.cpp, pliant/run_*.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/pbd.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

struct Finished {
    int status;
    std::string out, err;
};

class ProgramTest : public ProgramInSharedFolder {
  protected:
    static void SetUpTestSuite() {
        ProgramInSharedFolder::SetUpTestSuite();
        ASSERT_EQ(run("phantom cube --size 48 --out cube.nrrd").status, 0);
        ASSERT_EQ(run("phantom airway --size 64 --out airway.nrrd").status, 0);
    }
    static Finished run(const std::string& arguments) {
        const int status = ProgramInSharedFolder::run(arguments);
        return {status, out(), said()};
    }
    /// The airway's first landmark, as --push takes it.
    static std::string carina() {
        const auto volume = read_volume(file("airway.nrrd"));
        if (volume.ok())
            for (const auto& [key, value] : volume->key_values)
                if (key == "landmark carina") return value.substr(5, value.find(" eye") - 5);
        ADD_FAILURE() << "the airway has no carina";
        return "0,0,0:0,0,0";
    }

    static Json deform_report(const std::string& arguments) {
        const Finished done = run("deform " + arguments + " --out r.nrrd --report r.json");
        EXPECT_EQ(done.status, 0) << done.err;
        return Json::parse(bytes_of(file("r.json")));
    }
};

constexpr const char* kSoft = "[material]\nbone_threshold_hu = 3000\n";

TEST_F(ProgramTest, LabelsDecideWhatGivesWay) {
    auto labels = read_volume(file("cube.nrrd"));
    ASSERT_TRUE(labels.ok());
    labels->voxels = std::vector<std::int16_t>(voxel_count(labels->grid), 1);
    ASSERT_TRUE(write_volume(file("ones.nrrd"), *labels).ok());
    std::ofstream(file("free.toml")) << kSoft << "[air]\nenabled = false\n";
    std::ofstream(file("held.toml")) << kSoft << "[[label]]\nvalues = 1\nlaw = \"fixed\"\n";
    const std::string push = "cube.nrrd --push 0,0,0:0,6,0 --tool sphere:5 --config ";
    const Json freely = deform_report(push + "free.toml");
    EXPECT_EQ(freely["status"], "applied");
    EXPECT_EQ(freely["no_fold_certified"], true);
    EXPECT_NEAR(freely["certificate"]["tissue"], 0.6, 1e-5);
    const Json held = deform_report(push + "held.toml --labels ones.nrrd");
    const Json springs = deform_report(push + "held.toml --labels ones.nrrd --model springs");
    EXPECT_EQ(springs["limited_by"], "bone");
    EXPECT_EQ(held["status"], "rejected");
    EXPECT_EQ(held["limited_by"], "bone");
    EXPECT_EQ(held["no_fold_certified"], false);
    // The same labels with their rows reversed, and elsewhere.
    Volume turned = *labels;
    Grid& grid = turned.grid;
    grid.origin_mm = world_from_voxel(grid, {grid.size.x - 1.0, 0, 0});
    grid.direction.columns[0] = -1.0 * grid.direction.columns[0];
    ASSERT_TRUE(write_volume(file("turned.nrrd"), turned).ok());
    EXPECT_EQ(deform_report(push + "held.toml --labels turned.nrrd")["limited_by"], "bone");
    grid.origin_mm.x += 5000;
    ASSERT_TRUE(write_volume(file("far.nrrd"), turned).ok());
    const struct {
        const char *arguments, *expected;
    } wrong[] = {
        {"held.toml --labels far.nrrd", "--labels: expected a label map with labels inside"},
        {"free.toml --labels-out moved.nrrd", "--labels-out: expected --labels, the map"},
        {"held.toml --labels none.nrrd", "none.nrrd"},
        {"held.toml", "--labels: expected a label volume for [[label]], found none"},
        {"free.toml --labels ones.nrrd", "--labels: expected [[label]] tables in --config"},
        {"held.toml --labels ones.nrrd --directions cube.nrrd", "--directions: cube.nrrd"},
    };
    for (const auto& c : wrong) {
        const Finished done = run("deform " + push + c.arguments + " --out wrong.nrrd");
        EXPECT_EQ(done.status, 2) << c.arguments;
        EXPECT_NE(done.err.find(c.expected), std::string::npos) << done.err;
        EXPECT_FALSE(fs::exists(file("wrong.nrrd")));
    }
}

TEST_F(ProgramTest, DeformWritesEverythingThatItPromises) {
    std::ofstream(file("soft.toml")) << kSoft;
    const Finished done =
        run("deform cube.nrrd --push 0,0,0:0,6,0 --tool sphere:5 --config soft.toml --out d.nrrd "
            "--displacement u.nrrd --transform t.nrrd --report d.json --png d.png");
    ASSERT_EQ(done.status, 0) << done.err;
    EXPECT_EQ(done.err, "");
    EXPECT_NE(done.out.find("applied"), std::string::npos);
    const Json report = Json::parse(bytes_of(file("d.json")));
    for (const char* key :
         {"status", "limited_by", "step_fraction", "moved_elements", "max_violation_mm",
          "folded_cells", "solve_ms", "resample_ms", "dirty_box_ijk", "resident_bricks",
          "bytes_per_resident_element", "peak_memory_mb", "hash"})
        EXPECT_TRUE(report.contains(key)) << key;
    EXPECT_EQ(report["status"], "applied");
    EXPECT_EQ(report["limited_by"], "none");
    EXPECT_EQ(report["step_fraction"], 1);
    EXPECT_EQ(report["folded_cells"], 0);
    EXPECT_LT(report["max_violation_mm"], 1e-4);
    EXPECT_GT(report["moved_elements"], 100);
    const auto before = read_volume(file("cube.nrrd")), after = read_volume(file("d.nrrd"));
    ASSERT_TRUE(before.ok() && after.ok());
    EXPECT_EQ(before->grid, after->grid);
    EXPECT_EQ(before->key_values, after->key_values);
    // Only voxels of the dirty box changed.
    const auto box = report["dirty_box_ijk"];
    std::int64_t changed = 0;
    for (int z = 0; z < 48; ++z)
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x) {
                if (before->at({x, y, z}) == after->at({x, y, z})) continue;
                ++changed;
                const int p[] = {x, y, z};
                for (std::size_t a = 0; a < 3; ++a) {
                    ASSERT_GE(p[a], box[0][a].get<int>());
                    ASSERT_LT(p[a], box[1][a].get<int>());
                }
            }
    EXPECT_EQ(bytes_of(file("d.png")).substr(1, 3), "PNG");
    const auto u = read_vector_field(file("u.nrrd")), t = read_vector_field(file("t.nrrd"));
    ASSERT_TRUE(u.ok() && t.ok());
    EXPECT_EQ(u->kind, FieldKind::Modeling);
    EXPECT_EQ(t->kind, FieldKind::Resampling);
    const Vec3f at_tool = u->vectors_mm[voxel_index(u->grid, {24, 24, 24})];
    EXPECT_NEAR(at_tool.y, 6, 1e-4);
}

TEST_F(ProgramTest, ResultIsTheSameForAnyThreadsSolverAndBrickSize) {
    std::ofstream(file("soft.toml")) << kSoft;
    std::ofstream(file("small.toml")) << kSoft << "[lattice]\nbrick_size = 5\n";
    // Oblique: a push along an axis keeps to the cells' edges, where both mappings agree.
    const std::string place = carina().substr(0, carina().find(':'));
    const std::string push =
        "airway.nrrd --push=" + place + ":3,1.5,-1 --push=" + place + ":-0.5,1,1 --tool sphere:6";
    const auto hash = [&](const std::string& more) { return deform_report(push + more)["hash"]; };
    const Json first = hash(" --config soft.toml --threads 1");
    EXPECT_EQ(hash(" --config soft.toml --threads 2"), first);
    EXPECT_EQ(hash(" --config soft.toml --threads 4"), first);
    EXPECT_EQ(hash(" --config small.toml"), first);
    EXPECT_NE(hash(" --config soft.toml --mapping tetrahedra"), first);
    // Limits are rounded, unless the settings or a solver of the box say otherwise.
    const Json box = hash(" --config soft.toml --solver heap");
    EXPECT_NE(box, first);
    EXPECT_EQ(hash(" --config soft.toml --solver sweep"), box);
    const auto with_limits = [&](const std::string& limits) {
        std::ofstream(file("limits.toml")) << kSoft << "limits = \"" << limits << "\"\n";
        return hash(" --config limits.toml");
    };
    EXPECT_EQ(with_limits("box"), box);
    EXPECT_EQ(with_limits("rounded"), first);
    std::ofstream(file("divod.conf")) << "offset=0.2\n";
    EXPECT_EQ(hash(" --config divod.conf"), hash(" --config divod.conf --solver heap"));
}

TEST_F(ProgramTest, BoneRejectsThePushAndTheScanStaysAsItWas) {
    const Json report = deform_report("cube.nrrd --push 0,0,0:0,6,0");
    EXPECT_EQ(report["status"], "rejected");
    EXPECT_EQ(report["limited_by"], "bone");
    EXPECT_EQ(report["step_fraction"], 0);
    EXPECT_EQ(report["moved_elements"], 0);
    EXPECT_TRUE(report["dirty_box_ijk"].is_null());
    EXPECT_EQ(read_volume(file("cube.nrrd"))->voxels, read_volume(file("r.nrrd"))->voxels);
}

TEST_F(ProgramTest, PushScaleAndMovementLimitOfTheSettingsCount) {
    std::ofstream(file("scaled.toml")) << kSoft << "max_movement_mm = 5\n[push]\nscale = 2\n";
    const Json report = deform_report("cube.nrrd --push 0,0,0:0,6,0 --config scaled.toml");
    EXPECT_EQ(report["status"], "limited");
    EXPECT_EQ(report["limited_by"], "movement");
    const double w = 2000 / 4095.0;
    EXPECT_NEAR(report["step_fraction"], 5 * (1 - w * w) / 12, 1e-3);
}

TEST_F(ProgramTest, SpringsDeformWithTheSameOutputs) {
    const std::string push =
        "cube.nrrd --model springs --fixed-hu 3000 --cell-mm 6 --push 0,0,0:1,3,0 ";
    const Json report =
        deform_report(push +
                      "--displacement su.nrrd --transform st.nrrd --jacobian sj.nrrd "
                      "--png s.png --threads 1");
    for (const char* key :
         {"status", "limited_by", "step_fraction", "moved_elements", "max_violation_mm",
          "folded_cells", "solve_ms", "resample_ms", "dirty_box_ijk", "resident_bricks",
          "bytes_per_resident_element", "peak_memory_mb", "hash"})
        EXPECT_TRUE(report.contains(key)) << key;
    EXPECT_EQ(report["model"], "springs");
    EXPECT_EQ(report["status"], "applied");
    EXPECT_EQ(report["springs"]["settled"], true);
    EXPECT_EQ(report["folded_cells"], 0);
    EXPECT_GT(report["springs"]["steps"], 10);
    EXPECT_LT(report["springs"]["force_n"][1], 0);
    // The forward field is the push where the tool is, and the transform leads back there.
    const auto before = read_volume(file("cube.nrrd")), after = read_volume(file("r.nrrd"));
    const auto forward = read_vector_field(file("su.nrrd"));
    const auto back = read_vector_field(file("st.nrrd"));
    ASSERT_TRUE(before.ok() && after.ok() && forward.ok() && back.ok());
    const auto nearest = [&](Vec3d x_mm) {
        const Vec3d p = voxel_from_world(before->grid, x_mm);
        return voxel_index(before->grid,
                           {int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))});
    };
    const Vec3f there = forward->vectors_mm[nearest({0, 0, 0})];
    EXPECT_NEAR(there.x, 1, 1e-5);
    EXPECT_NEAR(there.y, 3, 1e-5);
    const Vec3f home = back->vectors_mm[nearest({1, 3, 0})];
    EXPECT_NEAR(home.y, -3, 0.7);
    EXPECT_TRUE(fs::exists(file("s.png")));
    // The same for any number of threads; otherwise with fewer layers, let go, or stopped early.
    const auto hash = [&](const std::string& more) { return deform_report(push + more)["hash"]; };
    EXPECT_EQ(hash("--threads 4"), report["hash"]);
    EXPECT_NE(hash("--depth 1"), report["hash"]);
    EXPECT_NE(hash("--steps 3"), report["hash"]);
    EXPECT_EQ(deform_report(push + "--release")["moved_elements"], 0);
    const Json stiff = deform_report(push + "--poisson-ratio 0.45");
    EXPECT_EQ(stiff["springs"]["poisson_ratio"], 0.45);
    EXPECT_NE(stiff["hash"], report["hash"]);
    const Json found = deform_report(push + "--depth auto:0.05");
    EXPECT_GT(found["springs"]["depth"], 1);
    EXPECT_LT(found["springs"]["depth"], 10);
    EXPECT_EQ(hash("--depth auto:0.05 --threads 3"), found["hash"]);
    const Json cut = deform_report(push + "--cut \"-9,-3,-9;9,-3,-9:0,0,18\"");
    EXPECT_GT(cut["cut_links"], 50);
    EXPECT_LT(cut["springs"]["force_n"][1], 0) << "the push before the cut goes on";
    EXPECT_NE(cut["hash"], report["hash"]);
    const Json small = deform_report(push + "--region -18,-18,-18:18,18,18 --young-pa 500");
    EXPECT_LT(small["moved_elements"], report["moved_elements"]);
    EXPECT_EQ(small["springs"]["young_modulus_pa"], 500);
}

TEST_F(ProgramTest, BodiesAndRigidTissueDeformWithTheSameOutputs) {
    TetMesh block = five_tet_block({6, 6, 6}, 3);
    for (Vec3d& node : block.nodes_mm) node = node - Vec3d{9, 9, 9};
    ASSERT_TRUE(write_vtu(file("block.vtu"), block, {}).ok());
    const std::string push =
        "cube.nrrd --model body --mesh block.vtu --fixed-hu 3000 --reach-mm 6 "
        "--tool sphere:4 --push 0,0,6:1,2,0 --steps 20 ";
    const Json report = deform_report(push + "--displacement bu.nrrd --png b.png --threads 1");
    EXPECT_EQ(report["model"], "body");
    EXPECT_EQ(report["solver"], "position-based");
    EXPECT_EQ(report["status"], "applied");
    EXPECT_EQ(report["max_violation_mm"], 0);
    const Json& body = report["body"];
    EXPECT_EQ(body["particles"], 7 * 7 * 7);
    EXPECT_EQ(body["tetrahedra"], 6 * 6 * 6 * 5);
    EXPECT_EQ(body["fixed_particles"], 0);
    EXPECT_GT(body["carried_voxels"], 1000);
    EXPECT_EQ(body["steps"], 20);
    EXPECT_EQ(body["force_n"].size(), 3);
    EXPECT_FALSE(report.contains("no_fold_certified"));
    EXPECT_GT(report["moved_elements"], 1000);
    const auto forward = read_vector_field(file("bu.nrrd"));
    ASSERT_TRUE(forward.ok());
    const Vec3d p = voxel_from_world(forward->grid, {0, 0, 6});
    const Vec3f moved = forward->vectors_mm[voxel_index(
        forward->grid, {int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))})];
    EXPECT_NEAR(moved.y, 2, 0.1);
    EXPECT_EQ(deform_report(push + "--threads 4")["hash"], report["hash"]);
    EXPECT_NE(deform_report(push + "--release")["hash"], report["hash"]);

    const Json rigid = deform_report("cube.nrrd --model rigid --push 0,0,0:1,3,0 ");
    EXPECT_EQ(rigid["status"], "rejected");
    EXPECT_EQ(rigid["limited_by"], "bone");
    EXPECT_EQ(rigid["moved_elements"], 0);
    EXPECT_EQ(rigid["dirty_box_ijk"], nullptr);
    EXPECT_FALSE(rigid.contains("rigid"));
}

TEST_F(ProgramTest, BadInputIsOneLineStatusTwoAndNoFile) {
    std::ofstream(file("cut.nrrd")) << bytes_of(file("cube.nrrd")).substr(0, 900);
    std::ofstream(file("bad.toml")) << "[material]\noffset = 2\n";
    const struct {
        const char* arguments;
        const char* named;
    } cases[] = {
        {"study run s.toml", "study: expected the Python package"},
        {"deform none.nrrd --push 0,0,0:1,0,0 --out x.nrrd", "none.nrrd"},
        {"deform cut.nrrd --push 0,0,0:1,0,0 --out x.nrrd", "cut.nrrd"},
        {"deform cube.nrrd --push 0,0:1,0,0 --out x.nrrd", "--push"},
        {"deform cube.nrrd --push 0,0,0 --out x.nrrd", "--push"},
        {"deform cube.nrrd --push 0,0,0:a,0,0 --out x.nrrd", "--push"},
        {"deform cube.nrrd --push nan,0,0:1,0,0 --out x.nrrd", "--push"},
        {"deform cube.nrrd --push 900,0,0:1,0,0 --out x.nrrd", "--push"},
        {"deform cube.nrrd --push 0,0,0:1e9,0,0 --out x.nrrd", "--push"},
        {"deform cube.nrrd --out x.nrrd", "--push"},
        {"deform cube.nrrd --slide 0,0,0:1,0,0 --out x.nrrd", "--slide: expected --tool sphere"},
        {"deform cube.nrrd --slide 0,0:1,0,0 --tool sphere:4 --out x.nrrd", "--slide"},
        {"deform cube.nrrd --slide 900,0,0:1,0,0 --tool sphere:4 --out x.nrrd", "--slide"},
        {"deform cube.nrrd --slide 0,0,0:0,0,0 --tool sphere:4 --out x.nrrd", "--slide"},
        {"deform cube.nrrd --push 0,0,0:1,0,0", "--out"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.png", "--out"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out cube.nrrd", "--out"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd --transform x.nrrd", "--transform"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out no/x.nrrd", "no/x.nrrd"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd --report no/x.json", "no/x.json"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd --tool cone:3", "--tool"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd --tool sphere:-3", "--tool"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd --config bad.toml", "bad.toml"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd --config none.toml", "none.toml"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd --solver guess", "--solver"},
        {"deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd --threads -2", "--threads"},
        {"deform cube.nrrd --elastic 10,0.45 --push 0,0,0:1,0,0 --out x.nrrd",
         "--elastic: expected --model elastic, which replaces it"},
        {"deform cube.nrrd --model jelly --push 0,0,0:1,0,0 --out x.nrrd", "--model"},
        {"deform cube.nrrd --depth 3 --push 0,0,0:1,0,0 --out x.nrrd", "--depth: expected --model"},
        {"deform cube.nrrd --cell-mm 3 --push 0,0,0:1,0,0 --out x.nrrd",
         "--cell-mm: expected --model springs too, found chainmail"},
        {"deform cube.nrrd --fixed-hu 3 --push 0,0,0:1,0,0 --out x.nrrd",
         "--fixed-hu: expected --model springs or body too, found chainmail"},
        {"deform cube.nrrd --model body --push 0,0,0:1,0,0 --out x.nrrd", "--mesh: expected"},
        {"deform cube.nrrd --model body --mesh none.vtu --push 0,0,0:1,0,0 --out x.nrrd",
         "--mesh: none.vtu"},
        {"deform cube.nrrd --model rigid --steps 3 --push 0,0,0:1,0,0 --out x.nrrd",
         "--steps: expected --model springs or body or elastic, found rigid"},
        {"deform cube.nrrd --model rigid --cut \"0,0,0;1,0,0:0,0,1\" --out x.nrrd",
         "--cut: expected --model chainmail or elastic or springs or body, found rigid"},
        {"deform cube.nrrd --model springs --relax 3 --push 0,0,0:1,0,0 --out x.nrrd", "--relax"},
        {"deform cube.nrrd --model springs --solver heap --push 0,0,0:1,0,0 --out x.nrrd",
         "--solver"},
        {"deform cube.nrrd --model springs --carve 0,0,0:1 --out x.nrrd", "--carve"},
        {"deform cube.nrrd --model springs --out x.nrrd", "--push"},
        {"deform cube.nrrd --model springs --cell-mm 0 --push 0,0,0:1,0,0 --out x.nrrd",
         "--cell-mm: expected above 0"},
        {"deform cube.nrrd --model springs --cell-mm 90 --push 0,0,0:1,0,0 --out x.nrrd",
         "--cell-mm: expected at most"},
        {"deform cube.nrrd --model springs --depth -1 --push 0,0,0:1,0,0 --out x.nrrd",
         "--depth: expected"},
        {"deform cube.nrrd --model springs --young-pa 0 --push 0,0,0:1,0,0 --out x.nrrd",
         "--young-modulus-pa: expected 1 to 1e9 Pa, found 0"},
        {"deform cube.nrrd --model springs --poisson-ratio 0.2 --push 0,0,0:1,0,0 --out x.nrrd",
         "--poisson-ratio: expected 0.25 to 0.499, found 0.2"},
        {"deform cube.nrrd --model springs --depth auto:0 --push 0,0,0:1,0,0 --out x.nrrd",
         "--depth: expected a length above 0 mm"},
        {"deform cube.nrrd --depth auto --push 0,0,0:1,0,0 --out x.nrrd",
         "--depth: expected --model springs too"},
        {"deform cube.nrrd --model springs --region 0,0:1,1 --push 0,0,0:1,0,0 --out x.nrrd",
         "--region"},
        {"deform cube.nrrd --model springs --region 900,0,0:990,9,9 --push 0,0,0:1,0,0 --out "
         "x.nrrd",
         "--region: expected a box"},
        {"deform cube.nrrd --model springs --push 900,0,0:1,0,0 --out x.nrrd", "--push"},
        {"deform cube.nrrd --model springs --steps -1 --push 0,0,0:1,0,0 --out x.nrrd", "--steps"},
        {"info none.nrrd", "none.nrrd"},
        {"info cut.nrrd", "cut.nrrd"},
        {"phantom dragon --out x.nrrd", "dragon"},
        {"phantom cube --size 1 --out x.nrrd", "--size"},
        {"phantom cube --size 64 --out no/x.nrrd", "no/x.nrrd"},
        {"render none.nrrd --out x.png", "none.nrrd"},
        {"render cube.nrrd --out x.png --view inside", "--view"},
        {"render cube.nrrd --out x.png --size 5x5", "--size"},
        {"render cube.nrrd --out no/x.png", "no/x.png"},
        {"render cube.nrrd --out x.png --view fluoroscopy --noise -1", "--noise"},
        {"render cube.nrrd --out x.png --view fluoroscopy --border -1", "--border"},
        {"render cube.nrrd --out x.png --view fluoroscopy --seed x", "--seed"},
        {"render cube.nrrd", "--out"},
        {"render cube.nrrd --path none.mrk.json", "--movie"},
        {"render cube.nrrd --path none.mrk.json --movie x.mp4", "none.mrk.json"},
        {"render cube.nrrd --keyframes none.json --movie x.mp4", "none.json"},
        {"render cube.nrrd --keyframes none.json --out x.png", "--keyframes and --movie"},
        {"render cube.nrrd --path cube.nrrd --movie x.mp4", "JSON"},
        {"fly", "fly"},
        {"", "ubcommand"},
    };
    for (const auto& c : cases) {
        const Finished done = run(c.arguments);
        EXPECT_EQ(done.status, 2) << c.arguments;
        EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 1) << c.arguments << "\n"
                                                                         << done.err;
        EXPECT_NE(done.err.find(c.named), std::string::npos) << c.arguments << "\n" << done.err;
        EXPECT_FALSE(fs::exists(file("x.nrrd"))) << c.arguments;
        EXPECT_FALSE(fs::exists(file("x.png"))) << c.arguments;
    }
    for (const auto& entry : fs::directory_iterator(file("")))
        EXPECT_FALSE(entry.path().filename().string().starts_with(".pliant")) << entry.path();
}

TEST_F(ProgramTest, CutsCarvingsAndPushesAreDoneInTheOrderGiven) {
    // The push is in the air beside the cube, which is to carry it.
    std::ofstream(file("no_air.toml")) << "[air]\nenabled = false\n";
    const std::string cut = " --cut '-40,-60,-60;-40,0,-60:0,0,60'",
                      push = " --push=-43,-40,-40:1,0.3,0";
    const auto report = [&](const std::string& actions) {
        const Finished done = run("deform cube.nrrd --config no_air.toml" + actions +
                                  " --out o.nrrd --report o.json");
        EXPECT_EQ(done.status, 0) << done.err;
        return Json::parse(bytes_of(file("o.json")));
    };
    const Json first = report(cut + push), last = report(push + cut);
    EXPECT_GT(first["cut_links"], 100);
    EXPECT_GT(last["cut_links"], 100);
    EXPECT_NE(first["hash"], last["hash"]);
    EXPECT_LT(first["moved_elements"], last["moved_elements"]) << "the cut stops the push";
    const Json both =
        report(" --carve=-30,-40,-40:5" + push + " --carve='-30,-40,-40;-20,-40,-40:5'" + cut);
    EXPECT_GT(both["carved_elements"], 20);
    EXPECT_EQ(both["pushes"].size(), 1u);
    EXPECT_LE(both["max_violation_mm"], 0);
}

TEST_F(ProgramTest, TissueSlidesOffTheSphereAsInTheLibrary) {
    std::ofstream(file("soft.toml")) << kSoft;
    // Along the cube's face, and into it by up to 2 mm.
    const std::string slide =
        "cube.nrrd --slide=-12,-40,0:24,6,0 --tool sphere:6 "
        "--config soft.toml --png s.png";
    const auto expected = [&](bool relaxed) {
        const TaskArena arena(2);
        const auto volume = read_volume(file("cube.nrrd"));
        ChainMailSettings settings;
        settings.bone_threshold_hu = 3000;
        settings.limits = LinkLimits::Rounded;
        auto tissue = ChainMail::create(*volume, settings, arena);
        const Push way{{-12, -40, 0}, {24, 6, 0}, 6};
        EXPECT_TRUE(slide_sphere(*tissue, way).ok());
        const Vec3d end_mm = way.point_mm + way.push_mm;
        if (relaxed) {
            EXPECT_TRUE(tissue->relax({.max_sweeps = 3, .tools = {{end_mm, end_mm, 6}}}).ok());
        }
        char text[17];
        std::snprintf(text, sizeof text, "%016llx",
                      static_cast<unsigned long long>(
                          hash_volume(deform_volume(*tissue).value().volume) ^ tissue->hash()));
        return std::string(text);
    };
    const Json slid = deform_report(slide);
    EXPECT_EQ(slid["hash"], expected(false));
    EXPECT_EQ(slid["status"], "applied");
    EXPECT_EQ(slid["step_fraction"], 1);
    EXPECT_EQ(slid["pushes"].size(), 0u);
    ASSERT_EQ(slid["slides"].size(), 1u);
    EXPECT_GT(slid["slides"][0]["contacts"], 3);
    EXPECT_EQ(slid["slides"][0]["way_fraction"], 1);
    EXPECT_EQ(slid["slides"][0]["way_mm"], Json::array({24, 6, 0}));
    EXPECT_EQ(slid["slides"][0]["inside_elements"], 0);
    EXPECT_LT(slid["max_movement_mm"], 6) << "tissue goes aside, not along";
    const Json relaxed = deform_report(slide + " --relax-sweeps 3");
    EXPECT_EQ(relaxed["hash"], expected(true));
    EXPECT_NE(relaxed["hash"], deform_report(slide + " --relax-sweeps 3 --release")["hash"]);
    // Bone ends the way, and the summary says so.
    const Json ended = deform_report("cube.nrrd --slide=0,-40,0:0,12,0 --tool sphere:6");
    EXPECT_EQ(ended["status"], "limited");
    EXPECT_EQ(ended["limited_by"], "bone");
    EXPECT_EQ(ended["step_fraction"], ended["slides"][0]["way_fraction"]);
    EXPECT_LT(ended["step_fraction"], 0.7);
}

TEST_F(ProgramTest, RelaxationFollowsTheActionsWithTheToolHeldOrGone) {
    std::ofstream(file("soft.toml")) << kSoft << "yield = 0.25\n[air]\nenabled = false\n";
    const std::string push = "cube.nrrd --push 0,0,0:0,6,0 --tool sphere:5 --config soft.toml";
    const Json pushed = deform_report(push);
    EXPECT_FALSE(pushed.contains("relax_sweeps"));
    const Json held = deform_report(push + " --relax-sweeps 4");
    EXPECT_EQ(held["relax_sweeps"], 4);
    EXPECT_EQ(held["relax_settled"], false);
    EXPECT_TRUE(held["relax_ms"].is_number());
    EXPECT_EQ(held["energy_unit"], "mm^2 * weight");
    EXPECT_LT(held["energy_after"], held["energy_before"]);
    EXPECT_NE(held["hash"], pushed["hash"]);
    EXPECT_EQ(held["max_violation_mm"], 0);
    EXPECT_NEAR(held["max_movement_mm"], 6, 1e-5) << "what the tool holds stays";
    const Json released = deform_report(push + " --relax 60000 --release");
    EXPECT_EQ(released["relax_settled"], true);
    EXPECT_LT(released["energy_after"], 0.1 * double(held["energy_after"]));
    // The imprint of the yield limit is left.
    EXPECT_NEAR(released["max_movement_mm"], 0.75 * 6, 0.3);
    const Finished wrong = run("deform " + push + " --release --out wrong.nrrd");
    EXPECT_EQ(wrong.status, 2);
    EXPECT_NE(wrong.err.find("--release: expected --relax"), std::string::npos) << wrong.err;
}

TEST_F(ProgramTest, SavedStateGoesOnWhereItWasLeft) {
    // The push is in the air beside the cube, which is to carry it.
    std::ofstream(file("no_air.toml")) << "[air]\nenabled = false\n";
    const std::string cut = " --cut '-40,-60,-60;-40,0,-60:0,0,60'",
                      push = " --push=-43,-40,-40:1,0.3,0";
    EXPECT_EQ(run("deform cube.nrrd" + cut + push + " --out a.nrrd --report a.json").status, 0);
    EXPECT_EQ(run("deform cube.nrrd" + cut + " --out b.nrrd --save-state b.plst").status, 0);
    const Finished loaded =
        run("deform cube.nrrd --load-state b.plst" + push + " --out c.nrrd --report c.json");
    EXPECT_EQ(loaded.status, 0) << loaded.err;
    EXPECT_EQ(Json::parse(bytes_of(file("a.json")))["hash"],
              Json::parse(bytes_of(file("c.json")))["hash"]);
    const Finished other = run("deform airway.nrrd --load-state b.plst --out refused.nrrd");
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("b.plst: expected a state of this scan"), std::string::npos);
    EXPECT_FALSE(fs::exists(file("refused.nrrd")));
}

TEST_F(ProgramTest, RendersTheScanOfASavedState) {
    const std::string deformation = " --tool sphere:4 --push=-6.9,-4.6,19:-5,0,0 --carve 0,5,18:4";
    const std::string camera = " --view endoscope --size 64x48 --eye 0.3,-1.8,38 --look 0,0,-1";
    const Finished moved =
        run("deform airway.nrrd" + deformation + " --out moved.nrrd --save-state moved.plst");
    ASSERT_EQ(moved.status, 0) << moved.err;
    const auto picture = [&](const std::string& scan, const std::string& more) {
        const Finished done = run("render " + scan + camera + more + " --out view.png");
        EXPECT_EQ(done.status, 0) << done.err;
        return bytes_of(file("view.png"));
    };
    const std::string loaded = picture("airway.nrrd", " --load-state moved.plst");
    EXPECT_TRUE(loaded == picture("moved.nrrd", ""));
    EXPECT_TRUE(loaded != picture("airway.nrrd", ""));
    // The style real has the positions at rest and raw faces, which the deformed scan alone has
    // not.
    EXPECT_TRUE(picture("airway.nrrd", " --load-state moved.plst --style real") !=
                picture("moved.nrrd", " --style real"));
    const Finished other =
        run("render cube.nrrd --load-state moved.plst" + camera + " --out refused.png");
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("moved.plst: expected a state of this scan"), std::string::npos);
    EXPECT_FALSE(fs::exists(file("refused.png")));
}

TEST_F(ProgramTest, FailureLeavesOldOutputsAlone) {
    std::ofstream(file("kept.nrrd")) << "old";
    const Finished done =
        run("deform cube.nrrd --push 900,0,0:1,0,0 --out kept.nrrd --report kept.json");
    EXPECT_EQ(done.status, 2);
    EXPECT_EQ(bytes_of(file("kept.nrrd")), "old");
    EXPECT_FALSE(fs::exists(file("kept.json")));
}

TEST_F(ProgramTest, RotatedAndLeftHandedPhantomsDeformTheSameInTheWorld) {
    // One shape, sampled on the plain grid and on a left-handed one that is turned by a quarter.
    ASSERT_EQ(
        run("phantom airway --size 64 --direction 0,-1,0,1,0,0,0,0,-1 --out turned.nrrd").status,
        0);
    const auto plain = read_volume(file("airway.nrrd")), turned = read_volume(file("turned.nrrd"));
    ASSERT_TRUE(plain.ok() && turned.ok());
    EXPECT_GT(determinant(plain->grid.direction), 0);
    const std::string more = " --push=" + carina() + " --tool sphere:5 --displacement ";
    ASSERT_EQ(run("deform airway.nrrd --out a.nrrd" + more + "ua.nrrd").status, 0);
    ASSERT_EQ(run("deform turned.nrrd --out b.nrrd" + more + "ub.nrrd").status, 0);
    const auto a = read_vector_field(file("ua.nrrd")), b = read_vector_field(file("ub.nrrd"));
    const auto va = read_volume(file("a.nrrd")), vb = read_volume(file("b.nrrd"));
    ASSERT_TRUE(a.ok() && b.ok() && va.ok() && vb.ok());
    double worst_mm = 0, worst_hu = 0, largest_mm = 0;
    for (int z = 0; z < 64; ++z)
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                const Vec3d world = world_from_voxel(a->grid, {double(x), double(y), double(z)});
                const Vec3d there = voxel_from_world(b->grid, world);
                const Vec3i p{int(std::lround(there.x)), int(std::lround(there.y)),
                              int(std::lround(there.z))};
                const Vec3f ua = a->vectors_mm[voxel_index(a->grid, {x, y, z})];
                const Vec3f d = ua - b->vectors_mm[voxel_index(b->grid, p)];
                worst_mm = std::max(worst_mm, norm(Vec3d{d.x, d.y, d.z}));
                largest_mm = std::max(largest_mm, norm(Vec3d{ua.x, ua.y, ua.z}));
                worst_hu = std::max(worst_hu, std::abs(double(va->at({x, y, z}) - vb->at(p))));
            }
    EXPECT_GT(largest_mm, 1);
    EXPECT_LT(worst_mm, 1e-4);
    EXPECT_LE(worst_hu, 1);
}

TEST_F(ProgramTest, RenderDrawsEveryView) {
    for (const char* view : {"four-up", "endoscope", "blended", "axial", "coronal", "sagittal"}) {
        const Finished done =
            run("render airway.nrrd --size 96x96 --out v.png --view " + std::string(view));
        EXPECT_EQ(done.status, 0) << done.err;
        EXPECT_GT(fs::file_size(file("v.png")), 500u) << view;
        fs::remove(file("v.png"));
    }
}

TEST_F(ProgramTest, FluoroscopyHasTheNoiseFieldAndBorderThatItIsAskedFor) {
    const auto drawn = [](const std::string& options) {
        const Finished done =
            run("render airway.nrrd --view fluoroscopy --size 64x64 --out f.png " + options);
        EXPECT_EQ(done.status, 0) << done.err;
        return bytes_of(file("f.png"));
    };
    const std::string first = drawn("");
    EXPECT_TRUE(drawn("--noise 1 --seed 0 --field round") == first);
    EXPECT_FALSE(drawn("--seed 1") == first);
    EXPECT_FALSE(drawn("--field full") == first);
    EXPECT_TRUE(drawn("--noise 0 --seed 1") == drawn("--noise 0"));
    EXPECT_FALSE(drawn("--noise 0 --border 0 --width 300") == drawn("--noise 0 --width 300"));
}

TEST_F(ProgramTest, RenderFliesAlongACurveInEitherCoordinateSystem) {
    const auto write_path = [&](const char* name, const char* system, std::int64_t sign) {
        std::ofstream out(file(name));
        out << R"({"markups": [{"type": "Curve", "coordinateUnits": "mm", "coordinateSystem": ")"
            << system << R"(", "controlPoints": [)";
        for (int n = 0; n < 4; ++n)
            out << (n ? ", " : "") << R"({"position": [)" << sign * 2 << ", " << sign * (3 + n)
                << ", " << 4 - 2 * n << R"(], "positionStatus": "defined"})";
        out << "]}]}";
    };
    write_path("lps.mrk.json", "LPS", 1);
    write_path("ras.mrk.json", "RAS", -1);
    const std::string common = "render airway.nrrd --view endoscope --size 48x40 --speed 50 ";
    EXPECT_EQ(run(common + "--path lps.mrk.json --movie a/").status, 0);
    EXPECT_EQ(run(common + "--path ras.mrk.json --movie b/").status, 0);
    // Three times √5 mm, smoothed or not, by 2 mm a frame.
    for (const char* name : {"00000.png", "00001.png", "00002.png", "00003.png"}) {
        ASSERT_TRUE(fs::exists(file("a") / name)) << name;
        EXPECT_EQ(bytes_of(file("a") / name), bytes_of(file("b") / name)) << name;
    }
    EXPECT_FALSE(fs::exists(file("a") / "00004.png"));
    EXPECT_NE(bytes_of(file("a") / "00000.png"), bytes_of(file("a") / "00003.png"));
    write_path("odd.mrk.json", "XYZ", 1);
    const Finished odd = run(common + "--path odd.mrk.json --movie c/");
    EXPECT_EQ(odd.status, 2);
    EXPECT_NE(odd.err.find("coordinateSystem: expected LPS or RAS, found \"XYZ\""),
              std::string::npos)
        << odd.err;
    EXPECT_FALSE(fs::exists(file("c")));
    // Points of it, half a millimetre apart, would fill the memory.
    write_path("far.mrk.json", "LPS", 1'000'000'000);
    const Finished far = run(common + "--path far.mrk.json --movie c/");
    EXPECT_EQ(far.status, 2);
    EXPECT_NE(far.err.find("controlPoints: expected a way of up to 100 m"), std::string::npos)
        << far.err;
}

TEST_F(ProgramTest, HelpOfEveryCommandHasAnExample) {
    for (const char* command :
         {"info", "convert", "phantom", "deform", "body", "render", "mesh", "path", "fit", "vessel",
          "serve", "replay", "bench", "haptics", "materials", "morph", "conformance"}) {
        const Finished done = run(std::string(command) + " --help");
        EXPECT_EQ(done.status, 0);
        EXPECT_NE(done.out.find("Example"), std::string::npos) << command;
    }
    EXPECT_EQ(run("--help").status, 0);
    EXPECT_EQ(run("--version").status, 0);
}

TEST_F(ProgramTest, BenchComparesTheSolversWithTheHeap) {
    const Finished done =
        run("bench chainmail --compare --json --size 12 --pull 2 --heterogeneous --rounds 1");
    ASSERT_EQ(done.status, 0) << done.err;
    std::istringstream lines(done.out);
    std::set<std::string> solvers;
    for (std::string line; std::getline(lines, line);) {
        const Json row = Json::parse(line);
        solvers.insert(row.at("solver").get<std::string>());
        EXPECT_EQ(row.at("material"), "heterogeneous");
        EXPECT_GT(row.at("moved_elements"), 0);
        EXPECT_EQ(row.at("max_distance_voxels"), 0) << line;
        EXPECT_EQ(row.at("complete"), true) << line;
    }
    EXPECT_EQ(solvers, (std::set<std::string>{"exact-heap", "exact-plain-sweep", "exact-sweep"}));
    const Finished table = run("bench chainmail --compare --size 8 --homogeneous --rounds 1");
    EXPECT_EQ(table.status, 0);
    EXPECT_NE(table.out.find("exact-heap"), std::string::npos);
    EXPECT_EQ(run("bench chainmail").status, 2);
    EXPECT_EQ(run("bench elastic --compare").status, 2);
}

TEST_F(ProgramTest, FitFindsTheStiffnessThatItsReportNames) {
    const std::string small = "fit --size 5,5,5 --spacing 20 --threads 2 ";
    const Finished done = run(small +
                              "--load +z:0,0,-10 --held-out +z:10,0,0:0.25,0.25 --damping 3 "
                              "--method closed-form --method gauss-newton --method annealing "
                              "--evaluations 60 --seed 5 --report fit.json");
    ASSERT_EQ(done.status, 0) << done.err;
    EXPECT_NE(done.out.find("not identifiable: damping"), std::string::npos) << done.out;
    const Json report = Json::parse(bytes_of(file("fit.json")));
    ASSERT_EQ(report["methods"].size(), 3u);
    const Json &closed = report["methods"][0], &newton = report["methods"][1];
    EXPECT_NEAR(closed["values"]["links"].get<double>(), 0.4 * 6e5 * 0.02, 1e-6);
    EXPECT_LE(newton["cost"].get<double>(), closed["cost"].get<double>());
    const Json& annealed = report["methods"][2];
    EXPECT_NEAR(annealed["values"]["links"].get<double>() / newton["values"]["links"].get<double>(),
                1, 0.2);
    EXPECT_LE(newton["cost"].get<double>(), annealed["cost"].get<double>());
    EXPECT_EQ(annealed["evaluations"], 61 + 32);
    EXPECT_FALSE(newton["directions"][0]["identifiable"].get<bool>());
    EXPECT_TRUE(newton["directions"][1]["identifiable"].get<bool>());
    EXPECT_TRUE(newton["cases"][1]["held_out"].get<bool>());
    EXPECT_GT(newton["cases"][1]["still_average_percent"].get<double>(),
              newton["cases"][1]["average_percent"].get<double>());
    EXPECT_TRUE(newton["at_bound"].empty());
    EXPECT_FALSE(closed.contains("note"));
    // Flat cells: values end on their bounds, and the closed form doesn't hold.
    const Finished flat =
        run("fit --size 5,5,5 --spacing 10,10,5 --young 12000 --poisson 0.4 --volume --by-cells "
            "--groups directions --load +z:0,0,-0.05:0.3,0.4 --load +z:0.05,0,0:0.6,0.6 "
            "--load +z:0,0.05,0:0.6,0.6 --report flat.json");
    ASSERT_EQ(flat.status, 0) << flat.err;
    EXPECT_NE(flat.out.find("at its lower bound"), std::string::npos) << flat.out;
    EXPECT_NE(flat.out.find("derived for cubic cells"), std::string::npos) << flat.out;
    const Json flat_report = Json::parse(bytes_of(file("flat.json")));
    EXPECT_TRUE(flat_report["methods"][0].contains("note"));
    EXPECT_EQ(flat_report["methods"][1]["at_bound"]["edges x"]["bound"], "lower");
    // The same from a file; the command line takes precedence.
    std::ofstream(file("fit.toml")) << "size = \"9,9,9\"\nspacing = 20\nload = [\"+z:0,0,-10\"]\n"
                                       "method = \"gauss-newton\"\nvolume = false\n";
    const Finished again = run("fit fit.toml --size 5,5,5 --report again.json");
    ASSERT_EQ(again.status, 0) << again.err;
    const Json from_file = Json::parse(bytes_of(file("again.json")));
    ASSERT_EQ(from_file["methods"].size(), 1u);
    EXPECT_EQ(from_file["methods"][0]["values"]["links"], newton["values"]["links"]);
}

TEST_F(ProgramTest, FitSaysWhatIsWrong) {
    std::ofstream(file("bad.toml")) << "yuong = 3\n";
    const std::pair<const char*, const char*> cases[] = {
        {"fit bad.toml", "unknown setting 'yuong'"},
        {"fit missing.toml", "missing.toml"},
        {"fit --size 4,4", "--size: expected three numbers"},
        {"fit --load z:1,2,3", "--load: expected FACE:"},
        {"fit --size 4,4,4 --load -z:0,0,1", "held"},
        {"fit --size 4,4,4 --links edges --load +z:1,0,0", "move without a force"},
        {"fit --size 4,4,4 --volume --poisson 0.2", "poisson_ratio"},
        {"fit --method bobyqa", "--method"},
        {"fit --size 4,4,4 --report no/such/folder/r.json", "no/such/folder"}};
    for (const auto& [arguments, text] : cases) {
        const Finished done = run(arguments);
        EXPECT_EQ(done.status, 2) << arguments;
        EXPECT_NE(done.err.find(text), std::string::npos) << arguments << ": " << done.err;
        EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 1) << done.err;
    }
}

TEST_F(ProgramTest, HapticsCheckReportsThePeriodsAndIsPlayedAgain) {
    const Finished done = run("haptics check --minutes 0.01 --json --out h.json --record h.txt");
    ASSERT_EQ(done.status, 0) << done.err;
    const Json report = Json::parse(done.out);
    EXPECT_EQ(report, Json::parse(bytes_of(file("h.json"))));
    EXPECT_EQ(report["device"], "virtual");
    EXPECT_GT(report["periods"], 50);
    for (const char* key : {"period_us", "compute_us", "idle_period_us"})
        EXPECT_GE(report[key]["max"], report[key]["p50"]) << key;
    EXPECT_EQ(report["real_time"], report["note"] == "");
    const Finished again = run("haptics check --minutes 0.005 --device replay:h.txt");
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_NE(again.out.find("replay at 1000 Hz"), std::string::npos) << again.out;
    const Finished wrong = run("haptics check --device ./libmaker.so");
    EXPECT_EQ(wrong.status, 2);
    EXPECT_NE(wrong.err.find("--device: haptic device './libmaker.so': expected"),
              std::string::npos)
        << wrong.err;
    EXPECT_EQ(std::count(wrong.err.begin(), wrong.err.end(), '\n'), 1) << wrong.err;
}

TEST_F(ProgramTest, FoldersEndlessFilesAndBadNamesAreRefusedByName) {
    fs::create_directory(file("folder"));
    fs::create_symlink("loop.nrrd", file("loop.nrrd"));
    const std::string push = "deform cube.nrrd --push 0,0,0:0,6,0 --out ";
    const std::string long_name(296, 'x');
    const std::pair<std::string, std::string> cases[] = {
        {"replay folder", "folder: is a folder, expected a session"},
        {"replay /dev/zero", "/dev/zero: is no regular file, expected a session"},
        {"serve cube.nrrd --no-open --session folder", "folder: is a folder, expected a session"},
        {"render cube.nrrd --path folder --movie m/", "folder: is a folder, expected"},
        {"render cube.nrrd --keyframes folder --movie m/", "folder: is a folder, expected"},
        {"render cube.nrrd --keyframes /dev/zero --movie m/", "/dev/zero: is no regular file"},
        {push + "r.nrrd --config folder", "folder: is a folder, expected a settings file"},
        {push + "r.nrrd --config /dev/zero", "/dev/zero: is no regular file, expected a settings"},
        {push + "loop.nrrd", "loop.nrrd: can't be written"},
        {push + long_name + ".nrrd", "x.nrrd: can't be written"},
    };
    for (const auto& [arguments, expected] : cases) {
        const Finished done = run(arguments);
        EXPECT_EQ(done.status, 2) << arguments;
        EXPECT_NE(done.err.find(expected), std::string::npos) << arguments << ": " << done.err;
    }
    for (const auto& entry : fs::directory_iterator(file("")))
        EXPECT_FALSE(entry.path().filename().string().starts_with(".pliant-")) << entry.path();
}

}  // namespace
}  // namespace pliant::test
