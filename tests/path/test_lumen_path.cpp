// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: path/descent.cpp.

#include <gtest/gtest.h>
#include <pliant/render.h>
#include <pliant/scan_files.h>

#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "render/analytic_volumes.h"
#include "support/random.h"

namespace pliant {
namespace {

/// The wall is nowhere on the way, by the exact crossings of the ray caster.
void expect_inside(const Volume& volume, const LumenPath& path, const LumenPathSettings& s,
                   const TaskArena& arena) {
    const RayCaster caster(volume, arena);
    ASSERT_GE(path.points_mm.size(), 1u);
    ASSERT_EQ(path.points_mm.size(), path.radius_mm.size());
    double length = 0;
    for (std::size_t n = 1; n < path.points_mm.size(); ++n) {
        const Vec3d a = path.points_mm[n - 1], d = path.points_mm[n] - a;
        length += norm(d);
        ASSERT_LE(norm(d), s.spacing_mm + norm(volume.grid.spacing_mm));
        if (!(norm(d) > 0)) continue;
        const auto wall = caster.first_hit(a, d, s.iso_hu, s.polarity);
        EXPECT_TRUE(!wall || wall->distance_mm >= norm(d) * (1 - 1e-9)) << "segment " << n;
    }
    EXPECT_NEAR(length, path.length_mm, 1e-9 * (1 + length));
}

/// Greatest distance of the points that are further than this from both ends to a curve.
template <class Distance>
double worst_distance(const LumenPath& path, double ends_mm, const Distance& distance) {
    double worst = 0;
    for (const Vec3d& p : path.points_mm)
        if (norm(p - path.points_mm.front()) > ends_mm && norm(p - path.points_mm.back()) > ends_mm)
            worst = std::max(worst, distance(p));
    return worst;
}

TEST(LumenPath, FollowsTheAxisOfAStraightTube) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const Grid grid = test::odd_grid({60, 50, 40});  // 0.8, 1.1, 1.7 mm
        const Vec3d middle = test::centre_mm(grid);
        const Vec3d axis = normalized(random.vector(1));
        const double radius = random.real(4, 8);
        const bool air = seed % 2;
        const Volume volume = test::make_volume<std::int16_t>(grid, [&](Vec3d x) {
            const double v = test::tube_hu(x, middle, axis, radius);
            return air ? v : -v;
        });
        LumenPathSettings settings;
        settings.iso_hu = air ? -480 : 480;
        settings.polarity = air ? Polarity::Rising : Polarity::Falling;
        // From beside the axis.
        const Vec3d side = normalized(cross(axis, {0.3, 0.5, 0.8}));
        const auto path = find_lumen_path(volume, middle - 16.0 * axis + 0.6 * radius * side,
                                          middle + 16.0 * axis, settings, arena);
        ASSERT_TRUE(path) << path.error().message;
        expect_inside(volume, *path, settings, arena);
        const double worst = worst_distance(*path, 8, [&](Vec3d x) {
            const Vec3d d = x - middle;
            return norm(d - dot(d, axis) * axis);
        });
        EXPECT_LT(worst, 0.45);  // smallest spacing: 0.8 mm
        const double found = path->radius_mm[path->radius_mm.size() / 2];
        EXPECT_GT(found, radius - worst - 0.05);
        EXPECT_LT(found, radius + 0.05);
    }
}

/// A ring around an axis along z.
struct Ring {
    Vec3d middle;
    double radius, tube;
    double distance(Vec3d x) const {
        const Vec3d d = x - middle;
        return std::hypot(std::hypot(d.x, d.y) - radius, d.z);
    }
    Vec3d at(double angle) const {
        return middle + Vec3d{radius * std::cos(angle), radius * std::sin(angle), 0};
    }
    Volume volume(const Grid& grid) const {
        return test::make_volume<float>(grid, [&](Vec3d x) {
            return -1000 + 1040 * std::clamp(0.5 + 0.5 * (distance(x) - tube), 0.0, 1.0);
        });
    }
};

TEST(LumenPath, FollowsTheMiddleOfARingOnItsShorterSide) {
    const Grid grid = test::plain_grid({60, 60, 24}, {1, 1, 1.3});
    const Ring ring{test::centre_mm(grid), 20, 5};
    const Volume volume = ring.volume(grid);
    const TaskArena arena(2);
    LumenPathSettings settings;
    settings.iso_hu = -480;
    settings.spacing_mm = 1;
    const double turn = 0.9 * std::numbers::pi;
    const auto path = find_lumen_path(volume, ring.at(0.2), ring.at(0.2 + turn), settings, arena);
    ASSERT_TRUE(path) << path.error().message;
    expect_inside(volume, *path, settings, arena);
    EXPECT_LT(worst_distance(*path, 0, [&](Vec3d x) { return ring.distance(x); }), 0.5);
    EXPECT_NEAR(path->length_mm, 20 * turn, 0.03 * 20 * turn);
    for (const Vec3d& x : path->points_mm)
        EXPECT_GT(dot(x - ring.middle, ring.at(0.2 + 0.5 * turn) - ring.middle), 0);
    EXPECT_EQ(path->points_mm.front(), ring.at(0.2));
    EXPECT_LT(norm(path->points_mm.back() - ring.at(0.2 + turn)), 1e-9);
}

TEST(LumenPath, IsTheSameForAnyNumberOfThreads) {
    const Grid grid = test::plain_grid({60, 60, 24}, {1, 1, 1.3});
    const Ring ring{test::centre_mm(grid), 20, 5};
    const Volume volume = ring.volume(grid);
    const auto one = find_lumen_path(volume, ring.at(0), ring.at(2), {}, TaskArena(1));
    for (int threads : {2, 4}) {
        const auto many = find_lumen_path(volume, ring.at(0), ring.at(2), {}, TaskArena(threads));
        ASSERT_TRUE(one && many);
        EXPECT_EQ(one->points_mm, many->points_mm);
        EXPECT_EQ(one->radius_mm, many->radius_mm);
    }
}

/// Voxels of the lumen that are connected to one of them by faces.
std::vector<std::uint8_t> connected(const Volume& volume, const LumenPathSettings& s, Vec3i seed) {
    const auto is_lumen = [&](Vec3i p) {
        return (double(volume.at(p)) < s.iso_hu) == (s.polarity == Polarity::Rising);
    };
    std::vector<std::uint8_t> seen(voxel_count(volume.grid));
    std::vector<Vec3i> waiting{seed};
    seen[voxel_index(volume.grid, seed)] = 1;
    while (!waiting.empty()) {
        const Vec3i p = waiting.back();
        waiting.pop_back();
        for (int side = 0; side < 6; ++side) {
            Vec3i q = p;
            q[side / 2] += side % 2 ? 1 : -1;
            if (!contains(voxel_box(volume.grid), q) || seen[voxel_index(volume.grid, q)] ||
                !is_lumen(q))
                continue;
            seen[voxel_index(volume.grid, q)] = 1;
            waiting.push_back(q);
        }
    }
    return seen;
}

TEST(LumenPath, IsFoundWhereThereIsOneAndNeverLeavesTheLumen) {
    const TaskArena arena(2);
    int found = 0, missing = 0;
    for (std::uint64_t seed = 1; seed <= 150; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        Grid grid = test::odd_grid({random.whole(2, 40), random.whole(2, 20), random.whole(2, 20)});
        for (int a = 0; a < 3; ++a) grid.spacing_mm[a] = random.real(0.5, 2);
        const Vec3d k = random.vector(0.6), l = random.vector(0.6);
        const double noise = random.real(0, 800);
        const Volume volume = test::make_volume<std::int16_t>(grid, [&](Vec3d x) {
            return 500 * (std::sin(dot(k, x)) + std::cos(dot(l, x))) + random.real(-noise, noise);
        });
        LumenPathSettings s;
        s.iso_hu = random.real(-200, 200);
        s.polarity = random.whole(0, 1) ? Polarity::Rising : Polarity::Falling;
        s.spacing_mm = random.real(0.5, 4);
        std::vector<Vec3i> lumen;
        for (int n = 0; n < int(voxel_count(grid)); ++n) {
            const Vec3i p{n % grid.size.x, n / grid.size.x % grid.size.y,
                          n / (grid.size.x * grid.size.y)};
            if ((double(volume.at(p)) < s.iso_hu) == (s.polarity == Polarity::Rising))
                lumen.push_back(p);
        }
        if (lumen.empty()) continue;
        const auto any = [&] { return lumen[std::size_t(random.whole(0, int(lumen.size()) - 1))]; };
        const Vec3i from = any(), to = any();
        const auto world = [&](Vec3i p) {
            return world_from_voxel(grid, {double(p.x), double(p.y), double(p.z)});
        };
        const auto path = find_lumen_path(volume, world(from), world(to), s, arena);
        const bool is_one = connected(volume, s, from)[voxel_index(grid, to)];
        // The trilinear lumen may have a way where faces of voxels have none, but not the reverse.
        ASSERT_TRUE(path || !is_one) << path.error().message;
        ++(path ? found : missing);
        if (path)
            expect_inside(volume, *path, s, arena);
        else
            EXPECT_EQ(path.error().code, ErrorCode::NotFound) << path.error().message;
    }
    EXPECT_GT(found, 50);
    EXPECT_GT(missing, 10);
}

class LumenPathErrors : public ::testing::Test {
  protected:
    Result<LumenPath> find(Vec3d from, Vec3d to) {
        return find_lumen_path(volume, from, to, settings, arena);
    }
    const TaskArena arena{2};
    const Grid grid = test::plain_grid({80, 30, 30});
    // Two tubes along x, with radius 5 mm.
    const Volume volume = test::make_volume<std::int16_t>(grid, [](Vec3d x) {
        return std::min(test::tube_hu(x, {0, 8, 8}, {1, 0, 0}, 5),
                        test::tube_hu(x, {0, 22, 22}, {1, 0, 0}, 5));
    });
    LumenPathSettings settings;
};

TEST_F(LumenPathErrors, AnEndInTheTissueSaysHowFarTheLumenIs) {
    const auto path = find({5, 8, 8}, {60, 8, 16});
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(path.error().message,
              "to: expected a position in the lumen, found 60, 8, 16 in the tissue, 4 mm from "
              "the nearest lumen at -500 HU");
    settings.reach_mm = 4.1;
    const auto reached = find({5, 8, 8}, {60, 8, 16});
    ASSERT_TRUE(reached);
    EXPECT_EQ(reached->points_mm.back(), (Vec3d{60, 8, 12}));
}

TEST_F(LumenPathErrors, NamesTheEndAndTheReason) {
    EXPECT_EQ(find({5, 8, 8}, {60, 22, 22}).error().code, ErrorCode::NotFound);
    EXPECT_EQ(find({-4, 8, 8}, {60, 8, 8}).error().message,
              "from: expected a position in the scan, found -4, 8, 8");
    EXPECT_EQ(find({std::nan(""), 8, 8}, {60, 8, 8}).error().code, ErrorCode::InvalidArgument);
    settings.iso_hu = -3000;
    EXPECT_NE(find({5, 8, 8}, {60, 8, 8}).error().message.find("no lumen within 30 mm"),
              std::string::npos);
}

TEST_F(LumenPathErrors, EndsAtItsLimits) {
    settings.max_voxels = 33'000;  // one tile
    EXPECT_EQ(find({5, 8, 8}, {60, 8, 8}).error().code, ErrorCode::LimitExceeded);
    EXPECT_TRUE(find({5, 8, 8}, {14, 8, 8}));
    settings.max_voxels = 1 << 30;
    settings.give_up = [] { return true; };
    EXPECT_EQ(find({5, 8, 8}, {60, 8, 8}).error().code, ErrorCode::LimitExceeded);
}

TEST_F(LumenPathErrors, BothEndsMayBeOnePlace) {
    const auto path = find({5, 8, 8}, {5, 8, 8});
    ASSERT_TRUE(path) << path.error().message;
    EXPECT_EQ(path->length_mm, 0);
}

TEST(LumenPath, LeadsThroughOpenSpaceWithoutAnyWall) {
    const Volume volume = test::make_volume<std::int16_t>(test::plain_grid({70, 40, 40}),
                                                          [](Vec3d) { return -1000; });
    const auto path = find_lumen_path(volume, {3, 3, 3}, {66, 37, 30}, {}, TaskArena(2));
    ASSERT_TRUE(path) << path.error().message;
    EXPECT_NEAR(path->length_mm, norm(Vec3d{63, 34, 27}), 3);
}

/// The positions of a markups file, which is in LPS.
std::vector<Vec3d> read_positions(const std::filesystem::path& file) {
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    const std::string all = text.str(), key = "\"position\":";
    std::vector<Vec3d> points;
    for (std::size_t at = all.find(key); at != std::string::npos; at = all.find(key, at + 1)) {
        std::istringstream numbers(all.substr(all.find('[', at) + 1, 120));
        Vec3d p{};
        char comma;
        numbers >> p.x >> comma >> p.y >> comma >> p.z;
        points.push_back(p);
    }
    return points;
}

/// Distance of a point from a polyline.
double distance_to(const std::vector<Vec3d>& line, Vec3d p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t n = 1; n < line.size(); ++n) {
        const Vec3d a = line[n - 1], d = line[n] - a;
        const double t = std::clamp(dot(p - a, d) / dot(d, d), 0.0, 1.0);
        nearest = std::min(nearest, norm(a + t * d - p));
    }
    return nearest;
}

TEST(LumenPath, LeadsThroughTheAirwaysOfAChestAsAnotherProgramsWayDoes) {
    const std::filesystem::path folder = PLIANT_SHARED_DATA;
    if (!std::filesystem::exists(folder / "thorax_ct_256.nrrd"))
        GTEST_SKIP() << "needs " << folder / "thorax_ct_256.nrrd";
    const auto scan = read_volume(folder / "thorax_ct_256.nrrd");
    ASSERT_TRUE(scan.ok());
    const auto other = read_positions(folder / "thorax_airway_path_left.mrk.json");
    ASSERT_GT(other.size(), 40u);
    const TaskArena arena(2);
    const LumenPathSettings settings;
    const auto path = find_lumen_path(*scan, other.front(), other.back(), settings, arena);
    ASSERT_TRUE(path) << path.error().message;
    expect_inside(*scan, *path, settings, arena);
    double worst = 0, sum = 0;
    for (const Vec3d& p : other) {
        const double off = distance_to(path->points_mm, p);
        worst = std::max(worst, off);
        sum += off;
    }
    EXPECT_LT(sum / double(other.size()), 1);
    EXPECT_LT(worst, 4.5);
}

}  // namespace
}  // namespace pliant
