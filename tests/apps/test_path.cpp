// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant path`, and a flight along its output.
// Covers: pliant/run_path.cpp.

#include <gtest/gtest.h>
#include <pliant/render.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "../../apps/pliant/camera_path.h"
#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

class PathTest : public ProgramInSharedFolder {
  protected:
    static void SetUpTestSuite() {
        ProgramInSharedFolder::SetUpTestSuite();
        ASSERT_EQ(run("phantom airway --size 96 --out airway.nrrd"), 0);
    }
};

/// No wall between one eye of the flight and the next, by the ray caster's exact crossings.
void expect_flight_inside(const Volume& volume, const std::vector<Vec3d>& points, double iso_hu) {
    const TaskArena arena(2);
    const RayCaster caster(volume, arena);
    const auto poses = app::fly(points, 0.8);
    ASSERT_GT(poses.size(), 20u);
    EXPECT_LT(norm(poses.back().eye_mm - points.back()), 0.9);
    double nearest = 1e9;
    for (std::size_t n = 0; n + 1 < poses.size(); ++n) {
        const Vec3d eye = poses[n].eye_mm, d = poses[n + 1].eye_mm - eye;
        ASSERT_LT(double(sample_linear(volume, voxel_from_world(volume.grid, eye))), iso_hu) << n;
        const auto wall = caster.first_hit(eye, d, iso_hu, Polarity::Rising);
        EXPECT_TRUE(!wall || wall->distance_mm > norm(d)) << "pose " << n;
        const auto near = caster.nearest_surface(eye, 20, iso_hu);
        if (near) nearest = std::min(nearest, near->distance_mm);
        EXPECT_LT(std::abs(dot(poses[n].look, poses[n].up)), 1e-9);
    }
    EXPECT_GT(nearest, 1);
}

TEST(Flight, ThroughASmallSpecimenIsOneThroughABodyMadeSmaller) {
    std::vector<Vec3d> large, small;
    for (int n = 0; n < 40; ++n) {
        large.push_back({2.0 * n, 6 * std::sin(0.3 * n), n % 5 ? 1.0 : 0.0});
        small.push_back((1.0 / 64) * large.back());
    }
    const auto expected = app::fly(large, 0.8), found = app::fly(small, 0.8 / 64, 1.0 / 64);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t n = 0; n < found.size(); ++n) {
        EXPECT_LT(norm(64.0 * found[n].eye_mm - expected[n].eye_mm), 1e-9);
        EXPECT_LT(norm(found[n].look - expected[n].look), 1e-9);
    }
    // Without the scale, everything is smoothed away.
    EXPECT_GT(norm(64.0 * app::fly(small, 0.8 / 64)[30].eye_mm - expected[30].eye_mm), 0.5);
}

TEST_F(PathTest, TheWayThroughAPhantomIsACurveThatRenderFlies) {
    ASSERT_EQ(run("path airway.nrrd --from=0.3,-1.8,38 --to 22,1,-20 --out way.mrk.json --json"), 0)
        << said();
    const Json report = Json::parse(bytes_of(file(".out")));
    EXPECT_GT(report["length_mm"], 58);
    EXPECT_LT(report["length_mm"], 75);
    EXPECT_GT(report["radius_min_mm"], 0.5);  // of the ends, which are where they were asked for
    EXPECT_GT(report["radius_mean_mm"], 3);

    const Json curve = Json::parse(bytes_of(file("way.mrk.json")))["markups"][0];
    EXPECT_EQ(curve["type"], "Curve");
    EXPECT_EQ(curve["coordinateSystem"], "LPS");
    EXPECT_EQ(curve["controlPoints"].size(), report["points"]);
    EXPECT_EQ(curve["controlPoints"][0]["position"], (Json{0.3, -1.8, 38}));

    const auto points = app::read_camera_path(file("way.mrk.json").string());
    ASSERT_TRUE(points.ok());
    EXPECT_EQ(points->size(), report["points"]);
    const auto volume = read_volume(file("airway.nrrd"));
    ASSERT_TRUE(volume.ok());
    expect_flight_inside(*volume, *points, -500);
    EXPECT_EQ(run("render airway.nrrd --view endoscope --size 32x32 --path way.mrk.json "
                  "--speed 400 --movie frames/"),
              0)
        << said();
    EXPECT_TRUE(fs::exists(file("frames") / "00000.png"));
}

TEST_F(PathTest, BadInputIsOneLineAndNoFile) {
    const struct {
        const char* arguments;
        const char* named;
    } cases[] = {
        {"--from 0.3,-1.8,38 --to 40,40,40", "--to: expected a position in the lumen"},
        {"--from 900,0,0 --to 22,1,-20", "--from: expected a position in the scan"},
        {"--from 0.3,-1.8,38", "--to"},
        {"--from 0.3,-1.8 --to 22,1,-20", "--from"},
        {"--from 0.3,-1.8,38 --to 0.3,-1.8,38", "two different positions"},
        {"--from 0.3,-1.8,38 --to 22,1,-20 --polarity up", "--polarity"},
        {"--from 0.3,-1.8,38 --to 22,1,-20 --spacing 0", "--spacing"},
    };
    for (const auto& c : cases) {
        EXPECT_EQ(run("path airway.nrrd --out x.mrk.json " + std::string(c.arguments)), 2);
        const std::string text = said();
        EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
        EXPECT_NE(text.find(c.named), std::string::npos) << c.arguments << "\n" << text;
        EXPECT_FALSE(fs::exists(file("x.mrk.json")));
    }
    EXPECT_EQ(run("path airway.nrrd --from 0.3,-1.8,38 --to 22,1,-20 --out no/x.mrk.json"), 2);
    EXPECT_NE(said().find("no/x.mrk.json"), std::string::npos) << said();
    EXPECT_EQ(run("path --help"), 0);
    EXPECT_NE(bytes_of(file(".out")).find("Examples:"), std::string::npos);
}

class ChestFlight : public ::testing::Test {
  protected:
    void SetUp() override {
        const fs::path folder = PLIANT_SHARED_DATA;
        if (!fs::exists(folder / "thorax_ct_256.nrrd"))
            GTEST_SKIP() << "needs " << folder / "thorax_ct_256.nrrd";
        auto read = read_volume(folder / "thorax_ct_256.nrrd");
        ASSERT_TRUE(read.ok());
        scan = std::move(*read);
        auto points = app::read_camera_path((folder / "thorax_airway_path_left.mrk.json").string());
        ASSERT_TRUE(points.ok());
        way = std::move(*points);
    }
    Volume scan;
    std::vector<Vec3d> way;
};

TEST_F(ChestFlight, AlongTheGivenPathReachesItsEndInTheLumen) {
    expect_flight_inside(scan, way, -500);
}

TEST_F(ChestFlight, AlongTheWayThatWasFoundReachesItsEndInTheLumen) {
    const TaskArena arena(2);
    const auto path = find_lumen_path(scan, way.front(), way.back(), {}, arena);
    ASSERT_TRUE(path.ok()) << path.error().message;
    expect_flight_inside(scan, path->points_mm, -500);
}

/// Steps of any length in any direction, of a tip with a radius: a step that would make it touch
/// the wall, or pass it, is halved until it doesn't. It is never in the tissue nor beyond a wall.
TEST_F(ChestFlight, TenThousandRandomStepsWithCollisionStayInTheLumen) {
    constexpr double kTipMm = 1.5;
    const TaskArena arena(2);
    const RayCaster caster(scan, arena);
    std::mt19937 random(7);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> length(0, 6);
    Vec3d eye = way[10];
    int stopped = 0;
    double travelled = 0;
    for (int n = 0; n < 10'000; ++n) {
        const Vec3d direction = normalized({gauss(random), gauss(random), gauss(random)});
        const auto wall = caster.first_hit(eye, direction, -500, Polarity::Rising);
        double step = length(random);
        const auto is_free = [&] {
            // The scan's border is no wall, and beyond it there is none.
            const Vec3d ijk = voxel_from_world(scan.grid, eye + step * direction);
            for (int a = 0; a < 3; ++a)
                if (!(ijk[a] >= 0 && ijk[a] <= scan.grid.size[a] - 1)) return false;
            return (!wall || wall->distance_mm > step) &&
                   !caster.nearest_surface(eye + step * direction, kTipMm, -500);
        };
        for (int halved = 0; halved < 6 && !is_free(); ++halved) step *= 0.5;
        if (!is_free()) {
            ++stopped;
            continue;
        }
        eye = eye + step * direction;
        travelled += step;
        ASSERT_LT(double(sample_linear(scan, voxel_from_world(scan.grid, eye))), -500) << n;
    }
    EXPECT_GT(stopped, 100);
    EXPECT_GT(travelled, 1000);
}

}  // namespace
}  // namespace pliant::test
