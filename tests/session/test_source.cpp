// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scene's scan, and the defaults that follow from its values.

#include "session/source.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "session/scene.h"
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
    const auto fixed_nodes = [&](std::int16_t dark, std::int16_t bright, double fixed_hu) {
        const auto scene = made(Scene::open({.file = write_ball(dark, bright)}, m_arena));
        serve::TissueCommand springs;
        springs.choice.model = serve::TissueModel::Springs;
        springs.choice.nodes = 8;
        springs.choice.springs.fixed_hu = fixed_hu;
        if (!scene->carry_out(1, springs).ok()) return std::int64_t(-1);
        for (const NamedValue& value : scene->tissue().report())
            if (value.name == "springs.fixed_nodes") return std::get<std::int64_t>(value.value);
        return std::int64_t(-1);
    };
    const double missing = SpringDeformationSettings{}.fixed_hu;
    const std::int64_t ct = fixed_nodes(-1000, 40, missing);
    EXPECT_GT(ct, 0);
    EXPECT_EQ(fixed_nodes(20, 7000, missing), ct);
    EXPECT_EQ(fixed_nodes(20, 7000, 5000), -1);  // the user's bone: no node could move
}

}  // namespace
}  // namespace pliant::test
