// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scene's scan, and the defaults that follow from its values.
// Covers: session/first_model.cpp, session/session_json.cpp.

#include "session/source.h"

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/vessel.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "protocol/commands.h"
#include "session/scene.h"
#include "session/session_log.h"
#include "support/made.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

using serve::LoadedScan;
using serve::Scene;

class SourceTest : public ::testing::Test {
  protected:
    /// A ball in a dark room, with a dark tube in it.
    std::string write_ball(std::int16_t dark, std::int16_t bright) const {
        constexpr int kSide = 40;
        std::vector<std::int16_t> values;
        for (int z = 0; z < kSide; ++z)
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) {
                    const bool tube = std::hypot(x - 19.5, y - 19.5) < 4 && std::abs(z - 19) < 15;
                    const bool ball = norm(Vec3d{x - 19.5, y - 19.5, z - 19.5}) < 18;
                    values.push_back(ball && !tube ? bright : dark);
                }
        NrrdFile file;
        file.sizes = "40 40 40";
        file.directions = "(3,0,0) (0,3,0) (0,0,3)";
        file.data = packed(values);
        return m_folder.write("ball.nrrd", file.bytes()).string();
    }
    LoadedScan load(const std::string& file) const {
        return made(serve::load_scan({.file = file}, m_arena));
    }
    TemporaryFolder m_folder;
    TaskArena m_arena{2};
};

TEST_F(SourceTest, AScanThatIsNoCtGetsSettingsForItsValues) {
    const LoadedScan mr = load(write_ball(20, 7000));
    EXPECT_EQ(mr.info.values.kind, ValueKind::Other);
    EXPECT_EQ(mr.volume.background, 20);
    EXPECT_NEAR(mr.iso_hu, 3510, 20);
    EXPECT_EQ(mr.polarity, Polarity::Rising);
    EXPECT_EQ(mr.settings.range, mr.info.values.range);
    EXPECT_GE(mr.settings.bone_threshold_hu, 7000);
    ASSERT_TRUE(mr.info.start);
    // In the tube.
    const Vec3d eye = voxel_from_world(mr.volume.grid, mr.info.start->eye_mm);
    EXPECT_LT(std::hypot(eye.x - 19.5, eye.y - 19.5), 4);
}

TEST_F(SourceTest, CtIsAsBefore) {
    const LoadedScan ct = load(write_ball(-1000, 40));
    EXPECT_EQ(ct.info.values.kind, ValueKind::Hounsfield);
    EXPECT_EQ(ct.volume.background, -1000);
    EXPECT_EQ(ct.iso_hu, -500);
    EXPECT_EQ(ct.settings.range, ChainMailSettings{}.range);
    EXPECT_EQ(ct.settings.bone_threshold_hu, 300);
}

TEST_F(SourceTest, AScanWithoutALumenIsSeenFromOutside) {
    NrrdFile file;
    file.data = packed(std::vector<std::int16_t>(24, 700));
    const LoadedScan block = load(m_folder.write("block.nrrd", file.bytes()).string());
    ASSERT_TRUE(block.info.start);
    EXPECT_LT(block.info.start->eye_mm.y, block.volume.grid.origin_mm.y);
}

TEST_F(SourceTest, ThePageIsToldTheKindAndTheDefaults) {
    const LoadedScan mr = load(write_ball(20, 7000));
    const auto json = nlohmann::json::parse(serve::volume_text(mr.info));
    const auto& values = json.at("values");
    EXPECT_EQ(values.at("kind"), "values without a unit");
    EXPECT_EQ(values.at("unit"), "");
    EXPECT_EQ(values.at("polarity"), "rising");
    EXPECT_EQ(values.at("background"), 20);
    EXPECT_EQ(values.at("iso"), mr.info.values.iso);
    EXPECT_EQ(values.at("window"), mr.info.values.window);
    EXPECT_EQ(json.at("length_scale"), 1);
}

TEST_F(SourceTest, SpringsOfAnMrAreHeldAsThoseOfCt) {
    const auto fixed_nodes = [&](std::int16_t dark, std::int16_t bright,
                                 std::optional<double> fixed_hu) {
        const auto scene = made(Scene::open({.file = write_ball(dark, bright)}, m_arena));
        serve::TissueCommand springs;
        springs.choice.model = "springs";
        springs.choice.nodes = 8;
        if (fixed_hu) {
            springs.choice.springs.fixed_hu = *fixed_hu;
            springs.choice.given = {"fixed_hu"};
        }
        if (!scene->carry_out(1, springs).ok()) return std::int64_t(-1);
        for (const NamedValue& value : scene->tissue().report())
            if (value.name == "springs.fixed_nodes") return std::get<std::int64_t>(value.value);
        return std::int64_t(-1);
    };
    const std::int64_t ct = fixed_nodes(-1000, 40, {});
    EXPECT_GT(ct, 0);
    EXPECT_EQ(fixed_nodes(20, 7000, {}), ct);
    EXPECT_EQ(fixed_nodes(20, 7000, 5000), -1);  // the user's bone: no node could move
    // The default of CT counts if it is given.
    EXPECT_EQ(fixed_nodes(20, 7000, SpringDeformationSettings{}.fixed_hu), -1);
}

serve::TissueChoice choice_of(const std::string& line) {
    const auto record = serve::parse_session_record(line);
    EXPECT_TRUE(record.ok()) << line;
    const auto& command = std::get<serve::SessionCommand>(*record);
    return std::get<serve::TissueCommand>(command.action).choice;
}

TEST_F(SourceTest, AConfigOfElasticChainMailIsRefused) {
    m_folder.write("c.toml", "[material]\nelastic = [40, 0.4]\n");
    const auto scene = Scene::open(
        {.file = write_ball(-1000, 40), .config = (m_folder / "c.toml").string()}, m_arena);
    ASSERT_FALSE(scene.ok());
    const std::string& message = scene.error().message;
    EXPECT_NE(message.find("c.toml: [material] elastic: expected [elastic] moduli_kpa and --model "
                           "elastic, which replace it"),
              std::string::npos)
        << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(SourceTest, ARecordedCommandOfElasticChainMailIsRefused) {
    const auto record =
        serve::parse_session_record(R"({"client":1,"do":"materials","elastic":[10,0.45]})");
    ASSERT_FALSE(record.ok());
    EXPECT_NE(record.error().message.find("materials: elastic: expected a tissue command with the "
                                          "model elastic, which replaces it"),
              std::string::npos)
        << record.error().message;
}

TEST_F(SourceTest, SessionsTellWhichSettingsWereGiven) {
    const auto read = serve::parse_message(
        R"({"do":"tissue","model":"springs","young_modulus_pa":15000,"fixed_hu":300})");
    const auto& springs = std::get<serve::TissueCommand>(std::get<serve::Message>(read).action);
    EXPECT_EQ(springs.choice.given, std::vector<std::string>{"fixed_hu"});
    const serve::TissueChoice back =
        choice_of(serve::text_of(serve::SessionRecord(serve::SessionCommand{1, springs})));
    EXPECT_EQ(back, springs.choice);
    // Older sessions have every setting; those with their defaults were not given.
    const serve::TissueChoice old = choice_of(
        R"({"client":1,"do":"tissue","model":"springs","nodes":8,"cell_mm":8,)"
        R"("young_modulus_pa":15000,"poisson_ratio":0.25,"air_threshold_hu":-500,"fixed_hu":400})");
    EXPECT_EQ(old.given, std::vector<std::string>{"fixed_hu"});
}

TEST_F(SourceTest, TheElasticScanFollowsTheScanTheFileAndTheCommand) {
    m_folder.write("c.toml", "[material]\noffset = 0.1\n[elastic]\npoisson_ratio = 0.3\n");
    const auto scene = made(Scene::open({.file = write_ball(-1000, 40),
                                         .config = (m_folder / "c.toml").string(),
                                         .model = "elastic"},
                                        m_arena));
    const auto used = [&] {
        serve::SharedState state;
        scene->describe(state);
        EXPECT_EQ(state.tissue.model, "elastic");
        return state.elastic;
    };
    ElasticScanSettings expected;
    suit_elastic({}, expected);
    expected.poisson_ratio = 0.3;
    EXPECT_EQ(used(), expected);
    const auto ask = [&](const std::string& fields) {
        const auto read =
            serve::parse_message(R"({"do":"tissue","model":"elastic")" + fields + "}");
        const auto& message = std::get<serve::Message>(read);
        const auto& tissue = std::get<serve::TissueCommand>(message.action);
        EXPECT_EQ(choice_of(serve::text_of(serve::SessionRecord(serve::SessionCommand{1, tissue}))),
                  tissue.choice);
        return scene->carry_out(1, tissue);
    };
    EXPECT_TRUE(ask(R"(,"held_above_hu":500,"held_sides":["-z"])").ok());
    expected.held_above_hu = 500;
    expected.held_sides = {"-z"};
    EXPECT_EQ(used(), expected);
    serve::SharedState state;
    scene->describe(state);
    const auto json = nlohmann::json::parse(serve::state_text(state)).at("tissue");
    EXPECT_EQ(json.at("held_sides"), nlohmann::json({"-z"}));
    EXPECT_EQ(json.at("moduli_kpa").at(0), nlohmann::json({-1000.0, 0.0}));
    // A refused choice leaves the tissue as it is.
    const auto refused = ask(R"(,"moduli_kpa":[[3,1],[2,1]])");
    EXPECT_NE(refused.message.find("expected ascending values"), std::string::npos);
    EXPECT_EQ(used(), expected);
    // A push has a force, and a checkpoint the choice.
    const auto pushed = scene->carry_out(
        1, serve::PushCommand{.push = {.point_mm = {59, 59, 59}, .push_mm = {3, 0, 0}}});
    ASSERT_TRUE(pushed.ok()) << pushed.message;
    ASSERT_TRUE(pushed.force_n.has_value());
    serve::SessionCheckpoint point;
    point.memo.tissue = state.tissue;
    const auto read = serve::parse_session_record(serve::text_of(serve::SessionRecord(point)));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(std::get<serve::SessionCheckpoint>(*read).memo.tissue, state.tissue);
}

TEST_F(SourceTest, AMistakeInTheElasticTableIsFoundWhenTheSceneIsOpened) {
    m_folder.write("c.toml", "[elastic]\npoisson_ratio = 0.6\n");
    const auto scene = Scene::open(
        {.file = write_ball(-1000, 40), .config = (m_folder / "c.toml").string()}, m_arena);
    ASSERT_FALSE(scene.ok());
    EXPECT_NE(scene.error().message.find("[elastic] poisson_ratio"), std::string::npos);
}

TEST_F(SourceTest, TheModelIsChosenByMeasuringUnlessChainMailHasSettings) {
    m_folder.write("both.toml", "[material]\noffset = 0.1\n[elastic]\npoisson_ratio = 0.3\n");
    m_folder.write("elastic.toml", "[elastic]\npoisson_ratio = 0.3\n");
    const std::string scan = write_ball(-1000, 40);
    const auto first = [&](const std::string& file, const std::string& config) {
        const auto scene =
            made(Scene::open({.file = file,
                              .config = config.empty() ? "" : (m_folder / config).string(),
                              .model = "auto"},
                             m_arena));
        EXPECT_EQ(scene->choice().model, scene->first_model().model);
        return scene->first_model();
    };
    for (const char* config : {"", "elastic.toml"}) {
        const serve::FirstModel measured = first(scan, config);
        EXPECT_NE(measured.reason.find("pictures a second here"), std::string::npos)
            << measured.reason;
        EXPECT_TRUE(measured.model == "elastic" || measured.model == "chainmail");
        EXPECT_EQ(measured.model == "chainmail",
                  measured.reason.find("expected 25") != std::string::npos);
    }
    EXPECT_EQ(first(scan, "both.toml").model, "chainmail");
    m_folder.write("bone.toml", "[elastic]\nheld_above_hu = 0\n");
    const serve::FirstModel bone = first(scan, "bone.toml");
    EXPECT_EQ(bone.model, "chainmail");
    EXPECT_NE(bone.reason.find("expected tissue that moves"), std::string::npos) << bone.reason;
    // A named model is recorded as it is, and nothing is measured.
    for (const char* model : {"", "chainmail", "elastic"}) {
        const auto named = made(Scene::open({.file = scan, .model = model}, m_arena));
        EXPECT_EQ(named->first_model().model, model);
        EXPECT_EQ(named->first_model().reason, "");
        EXPECT_EQ(named->choice().model, *model ? model : "chainmail");
    }
}

TEST_F(SourceTest, AnotherGhostOfAVesselIsAnotherScene) {
    std::vector<CentrePoint> way;
    for (double z = 0; z <= 40; z += 2) way.push_back({{0, 0, z}, 4});
    const VesselWall wall = made(swept_tube(way, {.thickness_mm = 1.5, .layers = 1}));
    const auto path = [&](const char* name) { return m_folder / name; };
    ASSERT_TRUE(write_vtu(path("wall.vtu"), wall.mesh, {}).ok());
    TriangleMesh ghost = wall.ghost;
    ASSERT_TRUE(write_surface(path("one.vtp"), ghost).ok());
    for (Vec3d& node : ghost.nodes_mm)
        if (node.z > 10 && node.z < 30) {
            node.x *= 0.99;
            node.y *= 0.99;
        }
    ASSERT_TRUE(write_surface(path("other.vtp"), ghost).ok());
    const auto hash = [&](const std::string& keys) {
        m_folder.write("s.toml",
                       "[vessel]\nmesh = \"wall.vtu\"\n" + keys + "[catheter]\nlength_mm = 60\n");
        return load(path("s.toml").string()).hash;
    };
    const std::string one = "ghost = \"one.vtp\"\n", other = "ghost = \"other.vtp\"\n";
    EXPECT_EQ(hash(one), hash(one));
    EXPECT_NE(hash(one), hash(other));
    EXPECT_NE(hash(""), hash(other));
    // So are the sweeps through the wall's constraints.
    EXPECT_NE(hash(""), hash("[wall]\niterations = 2\n"));
    EXPECT_NE(hash("[wall]\niterations = 2\n"),
              hash("[wall]\niterations = 2\nalternates = true\n"));
}

}  // namespace
}  // namespace pliant::test
