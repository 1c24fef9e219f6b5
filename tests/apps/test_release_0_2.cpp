// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files that the program of release 0.2 wrote (tests/data/0.2, made by tests/data/make_files.py)
// are read by this one, and have the same content: states give the same deformed voxels, fields the
// same vectors, settings the same numbers. docs/howto/migrate.md names those that are refused.
// Covers: pliant/run_deform.cpp, pliant/run_replay.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/models/organs.h>
#include <pliant/models/scene_files.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <variant>

#include "../../apps/pliant/keyframes.h"
#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

class Release02 : public ProgramInSharedFolder {
  protected:
    static void SetUpTestSuite() {
        ProgramInSharedFolder::SetUpTestSuite();
        std::filesystem::copy(PLIANT_RELEASES "/0.2", file(""),
                              std::filesystem::copy_options::overwrite_existing |
                                  std::filesystem::copy_options::recursive);
    }
    static Json expected(const std::string& name) {
        return Json::parse(bytes_of(file("expected.json")))[name];
    }
    static Json report() { return Json::parse(bytes_of(file("r.json"))); }

    static Volume volume(const std::string& name) {
        auto read = read_volume(file(name));
        EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
        return read.ok() ? std::move(*read) : Volume{};
    }
    static void expect_same_voxels(const std::string& a, const std::string& b) {
        const Volume first = volume(a), second = volume(b);
        EXPECT_EQ(first.grid, second.grid) << a << ", " << b;
        ASSERT_EQ(first.voxels.index(), second.voxels.index()) << a << ", " << b;
        EXPECT_TRUE(first.voxels == second.voxels) << a << ", " << b;
        const Volume rest = volume("scan.nrrd");
        EXPECT_FALSE(first.voxels == rest.voxels) << a << ": nothing has moved";
    }
    static void expect_same_field(const std::string& a, const std::string& b) {
        const auto first = read_vector_field(file(a)), second = read_vector_field(file(b));
        ASSERT_TRUE(first.ok() && second.ok()) << a << ", " << b;
        EXPECT_EQ(first->kind, second->kind);
        EXPECT_EQ(first->grid, second->grid);
        EXPECT_EQ(first->vectors_mm, second->vectors_mm) << a << ", " << b;
    }
};

TEST_F(Release02, StateOfChainMailGivesItsVoxelsAndFields) {
    ASSERT_EQ(run("deform scan.nrrd --load-state chainmail.plst --out now.nrrd --report r.json "
                  "--displacement u.nrrd --transform t.nrrd"),
              0)
        << said();
    EXPECT_EQ(report()["hash"], expected("chainmail")["hash"]);
    expect_same_voxels("now.nrrd", "chainmail.nrrd");
    expect_same_field("u.nrrd", "displacement.nrrd");
    expect_same_field("t.nrrd", "transform.nrrd");
}

TEST_F(Release02, StateOfChainMailHasItsSettings) {
    const TaskArena arena(1);
    const Volume scan = volume("scan.nrrd");
    auto tissue = ChainMail::create(scan, {}, arena);
    ASSERT_TRUE(tissue.ok());
    const Status loaded = tissue->load_state(file("chainmail.plst"));
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    const ChainMailSettings& kept = tissue->settings();
    EXPECT_EQ(kept.offset, 0.25);
    EXPECT_EQ(kept.yield, 0.5);
    EXPECT_EQ(kept.bone_threshold_hu, 700);
    EXPECT_EQ(kept.limits, LinkLimits::Box) << "the limits of 0.2";
    EXPECT_TRUE(kept.bounded);
    const LatticeState state = tissue->state();
    EXPECT_EQ(state.max_violation_mm, 0);
    EXPECT_GT(tissue->push({.point_mm = {15, 7, 23}, .push_mm = {0, 1, 0}})->moved_elements, 0);
}

TEST_F(Release02, StatesOfSpringsBodiesAndNetworksGiveTheirVoxels) {
    const std::pair<const char*, const char*> models[] = {
        {"springs", "--model springs --cell-mm 6"},
        {"body", "--model body --mesh organ.vtk"},
        {"network", "--model springs --network network.json"}};
    for (const auto& [name, options] : models) {
        const std::string of = name;
        ASSERT_EQ(run("deform scan.nrrd " + std::string(options) + " --load-state " + of +
                      ".plst --steps 0 --out now.nrrd --report r.json"),
                  0)
            << said();
        EXPECT_EQ(report()["hash"], expected(of)["hash"]) << of;
        expect_same_voxels("now.nrrd", of + ".nrrd");
    }
}

TEST_F(Release02, IdentifiedNetworkHasItsValues) {
    const auto network = read_network(file("network.json"));
    ASSERT_TRUE(network.ok()) << network.error().message;
    const Json values = expected("identified");
    ASSERT_EQ(network->groups.size(), values.size());
    for (const NetworkGroup& group : network->groups)
        EXPECT_EQ(group.value, double(values[group.name])) << group.name;
    EXPECT_EQ(network->mesh, "organ.vtk");
}

TEST_F(Release02, SessionIsReplayedToItsVoxels) {
    ASSERT_EQ(run("replay session.pls --json --out now.nrrd"), 0) << said();
    EXPECT_EQ(Json::parse(out()), expected("session"));
    expect_same_voxels("now.nrrd", "session.nrrd");
}

TEST_F(Release02, HandsLogDrivesTheCatheterToTheSamePlaces) {
    ASSERT_EQ(run("vessel vessel.toml --replay hand.log --report r.json"), 0) << said();
    const Json now = report(), before = expected("vessel");
    for (const char* name : {"hash", "inserted_mm", "largest_energy_mj"})
        EXPECT_EQ(now[name], before[name]) << name;
}

TEST_F(Release02, SettingsOfIdentificationGiveTheSameStiffness) {
    ASSERT_EQ(run("fit identification.toml --report r.json"), 0) << said();
    const Json found = report()["methods"][1]["values"], before = expected("box");
    ASSERT_EQ(found.size(), before.size());
    for (const auto& [name, value] : before.items())
        EXPECT_NEAR(double(found[name]), double(value), 1e-4 * double(value)) << name;
}

TEST_F(Release02, SceneOfAnOrganHasItsBody) {
    const auto scene = read_organ_file(file("organ.toml").string());
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    ASSERT_EQ(scene->bodies.size(), 1u);
    EXPECT_EQ(scene->bodies[0].name, "block");
    EXPECT_EQ(scene->bodies[0].young_modulus_pa, 5000);
    EXPECT_EQ(scene->bodies[0].held_back, 0.1);
    const TaskArena arena(1);
    const auto made = make_organs(*scene, arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
}

TEST_F(Release02, ElasticMaterialsAndCathetersOfTetrahedraAreRefusedInOneLine) {
    const auto refused = [&](const std::string& arguments) {
        EXPECT_EQ(run(arguments), 2) << arguments;
        const std::string line = said();
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
        return line;
    };
    const std::pair<const char*, const char*> cases[] = {
        {"--load-state ", "elastic.plst"}, {"--push 15,7,23:1,3,1 --config ", "elastic.toml"}};
    for (const auto& [options, name] : cases) {
        const std::string line =
            refused("deform scan.nrrd --out x.nrrd " + std::string(options) + name);
        EXPECT_NE(line.find(std::string(name) +
                            ": [material] elastic: expected [elastic] moduli_kpa and --model "
                            "elastic, which replace it"),
                  std::string::npos)
            << line;
        EXPECT_FALSE(std::filesystem::exists(file("x.nrrd")));
    }
    std::string scene = bytes_of(file("vessel.toml"));
    scene.insert(scene.find("[catheter]\n") + 11, "model = \"tetrahedra\"\n");
    std::ofstream(file("tetrahedra.toml")) << scene;
    const std::string line = refused("vessel tetrahedra.toml");
    EXPECT_NE(line.find("tetrahedra.toml: [catheter] model"), std::string::npos) << line;
}

TEST_F(Release02, SettingsHaveTheirNumbers) {
    const auto read = read_chainmail_settings(file("settings.toml"));
    ASSERT_TRUE(read.ok()) << read.error().message;
    ChainMailSettings wanted;
    wanted.range = {-1000, 2000};
    wanted.offset = 0.25;
    wanted.factor = {1, 0.9, 0.8};
    wanted.bone_threshold_hu = 700;
    wanted.max_movement_mm = 12;
    wanted.yield = 0.5;
    wanted.scale = 0.9;
    wanted.bounded = true;
    wanted.max_elements = 1'000'000;
    wanted.history_max_steps = 50;
    wanted.history_max_mb = 64;
    wanted.air_threshold_hu = -400;
    wanted.air_compress = 0.9;
    wanted.air_stretch = 40;
    wanted.air_shear = 30;
    for (const auto& row : chainmail_rows()) EXPECT_EQ(row.get(*read), row.get(wanted)) << row.name;
}

TEST_F(Release02, KeyframesHaveTheirCameras) {
    const auto frames = app::read_keyframes(file("keyframes.json").string());
    ASSERT_TRUE(frames.ok()) << frames.error().message;
    ASSERT_EQ(frames->size(), 3u);
    const app::Keyframe& last = frames->back();
    EXPECT_EQ(last.seconds, 3.5);
    EXPECT_EQ(last.eye_mm, (Vec3d{28, 16, 23}));
    EXPECT_EQ(last.look, (Vec3d{0, 0, 1}));
    EXPECT_EQ(last.up, (Vec3d{0, -1, 0}));
    EXPECT_EQ(last.field_of_view_deg, 72);
    EXPECT_EQ(last.iso_hu, -450);
    EXPECT_EQ(last.window_hu, 1200);
    EXPECT_EQ(last.level_hu, -100);
}

}  // namespace
}  // namespace pliant::test
