// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Every vessel scene of scenes/, with a tip that is bent by 60° and not steered, pushed at 60 mm/s
// into eight directions: it stays in the vessel, or leaves it through an open end. The oracle is
// the distance to the ghost surface as it is now, closed with lids, by the search of the mesh room.
// Covers: catheter/scene.cpp, scene_files/vessel_scene.cpp.

#include <gtest/gtest.h>
#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <thread>

#include "support/catheter_depth.h"

namespace pliant::test {
namespace {

constexpr int kDirections = 8;
constexpr double kBend_deg = 60, kSpeed_mm_s = 60, kWay_mm = 60;

struct Fate {
    double depth_mm = -1e9;     ///< by the oracle
    double reported_mm = -1e9;  ///< by the scene
    double inserted_mm = 0;
    std::int64_t inverted = 0;
    int left_end = 0;
    std::string error;
};

Fate fate_of(const MadeVessel& vessel, int direction) {
    const TaskArena arena(1);
    Fate fate;
    auto scene = CatheterScene::create(vessel.wall, vessel.settings);
    if (!scene) {
        fate.error = scene.error().message;
        return fate;
    }
    const double angle = 2 * std::numbers::pi * direction / kDirections;
    const CatheterCommand command{.insert_mm_s = kSpeed_mm_s,
                                  .bend_first_deg = kBend_deg * std::cos(angle),
                                  .bend_second_deg = kBend_deg * std::sin(angle)};
    const Status status = scene->command(command);
    EXPECT_TRUE(status.ok());
    const double way = std::min(kWay_mm, vessel.settings.catheter.length_mm - 10);
    for (int n = 0; fate.inserted_mm < way && fate.left_end == 0; ++n) {
        if (const Status s = scene->step(1, arena); !s.ok()) {
            fate.error = s.error().message;
            return fate;
        }
        const CatheterMeasures m = scene->quick_measures();
        fate.reported_mm = std::max(fate.reported_mm, m.depth_mm);
        fate.inserted_mm = m.inserted_mm;
        fate.left_end = m.left_end;
        if (n % 25 != 24) continue;
        fate.depth_mm = std::max(fate.depth_mm, depth_beyond_wall(*scene));
        fate.inverted = std::max(fate.inverted, scene->measures().inverted);
    }
    return fate;
}

void expect_that_none_gets_out(const std::string& file) {
    const TaskArena arena(2);
    const auto scene = read_vessel_file(file);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    for (const std::string& name : {scene->surface, scene->scan})
        if (!name.empty() && !std::filesystem::exists(name)) GTEST_SKIP() << "no shared data";
    const auto vessel = make_vessel(*scene, arena);
    ASSERT_TRUE(vessel.ok()) << vessel.error().message;
    EXPECT_EQ(vessel->wall.refined_because, "") << "cell_mm: expected cells that carry the wall";
    const Status sound = check_wall(vessel->wall, scene->wall.layers);
    EXPECT_TRUE(sound.ok()) << sound.error().message;
    std::vector<Fate> fates(kDirections);
    std::atomic<int> next = 0;
    const auto work = [&] {
        for (int n = next++; n < kDirections; n = next++)
            fates[std::size_t(n)] = fate_of(*vessel, n);
    };
    std::thread beside(work);
    work();
    beside.join();
    for (int n = 0; n < kDirections; ++n) {
        const Fate& fate = fates[std::size_t(n)];
        std::printf(
            "%s, %3d degrees: %.4f mm beyond the wall (reported %.4f), %.0f mm inserted%s\n",
            std::filesystem::path(file).stem().c_str(), n * 360 / kDirections, fate.depth_mm,
            fate.reported_mm, fate.inserted_mm, fate.left_end ? ", out of an open end" : "");
        EXPECT_EQ(fate.error, "");
        EXPECT_LE(fate.depth_mm, 0.1);
        EXPECT_LE(fate.reported_mm, 0.1);
        EXPECT_EQ(fate.inverted, 0);
        EXPECT_GT(fate.inserted_mm, 20);
    }
}

class UnsteeredTips : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(UnsteeredTips, StayInTheVessel) {
    expect_that_none_gets_out(GetParam().string());
}

std::vector<std::filesystem::path> vessel_scenes() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(PLIANT_SCENES))
        if (entry.path().filename().string().starts_with("vessel_")) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

INSTANTIATE_TEST_SUITE_P(Scenes, UnsteeredTips, testing::ValuesIn(vessel_scenes()),
                         [](const auto& scene) { return scene.param.stem().string(); });

}  // namespace
}  // namespace pliant::test
