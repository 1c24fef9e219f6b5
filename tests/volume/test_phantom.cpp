// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "base/hash.h"
#include "support/random.h"

namespace pliant {
namespace {

PhantomSettings settings(std::string_view name, int size) {
    PhantomSettings s;
    s.name = name;
    s.size = {size, size, size};
    return s;
}

Phantom make(const PhantomSettings& s, int threads = 2) {
    auto phantom = make_phantom(s, TaskArena(threads));
    EXPECT_TRUE(phantom.ok()) << (phantom.ok() ? "" : phantom.error().message);
    return std::move(phantom).value();
}

/// The phantom in its default geometry, made once.
const Phantom& whole(const std::string& name) {
    static std::map<std::string, Phantom> made;
    const auto found = made.find(name);
    if (found != made.end()) return found->second;
    return made.emplace(name, make(settings(name, 128))).first->second;
}

double value_at(const Phantom& p, Vec3d x) {
    return sample_linear(p.volume, voxel_from_world(p.volume.grid, x));
}

const VoxelArray<std::int16_t>& voxels_of(const Phantom& p) {
    return std::get<0>(p.volume.voxels);
}

std::uint64_t hash_of(const Phantom& p) {
    Hash64 hash;
    hash.add(std::span<const std::int16_t>(voxels_of(p).data(), voxels_of(p).size()));
    return hash.value();
}

TEST(Phantom, HasTheNamesThatItSays) {
    ASSERT_EQ(phantom_names().size(), 6u);
    for (const std::string_view name : phantom_names()) {
        const Phantom p = make(settings(name, 12));
        EXPECT_TRUE(p.volume.is_16_bit());
        EXPECT_EQ(p.volume.grid.size, (Vec3i{12, 12, 12}));
        EXPECT_EQ(voxels_of(p).size(), 12u * 12u * 12u);
        EXPECT_FALSE(p.landmarks.empty());
    }
}

TEST(Phantom, IsTheSameForAnyNumberOfThreadsAndOnEveryMachine) {
    const std::map<std::string_view, std::uint64_t> golden = {
        {"cube", 0xbee7326d0341a8db},   {"layers", 0x7ce58928c3c6fef2},
        {"airway", 0xb0a6f97f1f65bf3a}, {"sinus", 0xe30ecd9645d08a7d},
        {"vessel", 0xe8961507bfcb5918}, {"knee", 0xe48261825f0a6be8}};
    ASSERT_EQ(phantom_names().size(), golden.size());
    for (const std::string_view name : phantom_names()) {
        const std::uint64_t one = hash_of(make(settings(name, 40), 1));
        EXPECT_EQ(one, hash_of(make(settings(name, 40), 2))) << name;
        EXPECT_EQ(one, hash_of(make(settings(name, 40), 4))) << name;
        EXPECT_EQ(one, golden.at(name)) << name << std::hex << " 0x" << one;
    }
}

TEST(Phantom, IsCentredOnTheOriginForAnyGeometry) {
    constexpr std::uint64_t kSeed = 3;
    test::Random random(kSeed);
    for (int n = 0; n < 6; ++n) {
        PhantomSettings s = settings("cube", 8);
        s.size = {random.whole(2, 12), random.whole(2, 12), random.whole(2, 12)};
        s.spacing_mm = {random.real(0.5, 20), n % 2 ? 0.0 : 3.0, 7};
        s.direction = random.rotation(n % 2 == 1);
        const Grid g = make(s).volume.grid;
        const Vec3d middle{0.5 * (g.size.x - 1), 0.5 * (g.size.y - 1), 0.5 * (g.size.z - 1)};
        EXPECT_LT(norm(world_from_voxel(g, middle)), 1e-9) << "seed " << kSeed;
        EXPECT_EQ(g.spacing_mm.x, s.spacing_mm.x);
        if (s.spacing_mm.y == 0) {
            EXPECT_DOUBLE_EQ(g.spacing_mm.y * g.size.y, 100.0);
        }
    }
}

TEST(Phantom, ALeftHandedCopyIsTheMirroredArray) {
    for (const std::string_view name : phantom_names()) {
        PhantomSettings s = settings(name, 20);
        s.size = {20, 23, 18};
        const Phantom right = make(s);
        s.direction = {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
        const Phantom left = make(s);
        for (int k = 0; k < 18; ++k)
            for (int j = 0; j < 23; ++j)
                for (int i = 0; i < 20; ++i)
                    ASSERT_NEAR(left.volume.at({i, j, k}), right.volume.at({19 - i, j, k}), 1)
                        << name << " " << i << " " << j << " " << k;
    }
}

TEST(Phantom, ShapesStayWhereTheyAreInTheWorld) {
    constexpr std::uint64_t kSeed = 4;
    test::Random random(kSeed);
    for (const std::string_view name : phantom_names()) {
        const Phantom& fine = whole(std::string(name));
        PhantomSettings s = settings(name, 60);
        s.size = {64, 70, 90};
        s.spacing_mm = {0.9, 0.7, 0.6};
        s.direction = random.rotation(true);
        const Phantom turned = make(s);
        int flat = 0, off = 0;
        for (int n = 0; n < 20000; ++n) {
            const Vec3d x = random.vector(18);
            const double v = value_at(fine, x);
            double spread = 0;
            for (int a = 0; a < 6; ++a) {
                Vec3d step{0, 0, 0};
                step[a / 2] = a % 2 ? 2.5 : -2.5;
                spread = std::max(spread, std::abs(value_at(fine, x + step) - v));
            }
            if (spread > 25) continue;
            ++flat;
            if (std::abs(value_at(turned, x) - v) > 25) ++off;
        }
        EXPECT_GT(flat, 300) << name;
        EXPECT_LT(off, 0.02 * flat) << name << ", seed " << kSeed;
    }
}

TEST(Phantom, TheCubeHasItsVolumeAndOneValue) {
    PhantomSettings s = settings("cube", 50);
    s.spacing_mm = {1.7, 2.3, 2.9};
    const Phantom p = make(s);
    double filled_mm3 = 0;
    for (const std::int16_t v : voxels_of(p)) {
        EXPECT_GE(v, kAirHu);
        EXPECT_LE(v, 1000);
        filled_mm3 += (v - kAirHu) / 2000.0 * (1.7 * 2.3 * 2.9);
    }
    EXPECT_NEAR(filled_mm3, 60.0 * 60 * 60, 0.01 * 60 * 60 * 60);
    EXPECT_EQ(value_at(p, {0, 0, 0}), 1000);
}

TEST(Phantom, ACubesEdgeIsAntiAliasedOverOneVoxel) {
    PhantomSettings s = settings("cube", 64);
    s.spacing_mm = {0.8, 1.1, 1.7};
    const Phantom p = make(s);
    const Grid& g = p.volume.grid;
    for (int axis = 0; axis < 3; ++axis)
        for (int n = 0; n < 64; ++n) {
            Vec3i at{32, 32, 32};
            at[axis] = n;
            const double x = world_from_voxel(g, {double(at.x), double(at.y), double(at.z)})[axis];
            const double h = g.spacing_mm[axis];
            const double share = std::clamp((30 - std::abs(x)) / h + 0.5, 0.0, 1.0);
            EXPECT_NEAR(p.volume.at(at), kAirHu + 2000 * share, 10) << axis << " " << x;
        }
}

TEST(Phantom, LayersAreSoftAboveAndStifferDownwards) {
    const Phantom& p = whole("layers");
    EXPECT_EQ(value_at(p, {0, 0, 15}), 0);
    EXPECT_NEAR(value_at(p, {20, 10, -6}), 1100, 2);
    EXPECT_NEAR(value_at(p, {-20, -10, -24}), 1400, 2);
    EXPECT_EQ(value_at(p, {0, 0, 40}), kAirHu);
    EXPECT_EQ(value_at(p, {45, 0, 0}), kAirHu);
    // No stiff rim around the soft half.
    for (double x = 30; x < 40; x += 0.1) EXPECT_LE(value_at(p, {x, 0, 15}), 0);
}

TEST(Phantom, TheKneeHasBonesApartAndCartilageBetween) {
    const Phantom& p = whole("knee");
    const auto mean = [&](Vec3d at) {
        double sum = 0;
        for (int n = -4; n <= 4; ++n) sum += value_at(p, at + Vec3d{0, 0.5 * n, 0});
        return sum / 9;
    };
    EXPECT_GT(value_at(p, {0, 2, 60}), 300) << "marrow of the femur";
    EXPECT_GT(value_at(p, {14.6, 2, 60}), 700) << "its shell";
    EXPECT_GT(mean({0, 4, -24}), 300) << "head of the tibia";
    EXPECT_GT(mean({0, -39, 16}), 300) << "patella";
    EXPECT_NEAR(value_at(p, {20, 4, -8.3}), 115, 60) << "between condyle and tibia";
    EXPECT_NEAR(mean({30, -24, 70}), 58, 30) << "muscle of the thigh";
    EXPECT_LT(mean({14, -46, -20}), -50) << "fat in front of the joint";
    EXPECT_EQ(value_at(p, {78, -70, 0}), kAirHu);
}

TEST(Phantom, ValuesAreThoseOfAScan) {
    for (const std::string name : {"airway", "sinus", "vessel", "knee"}) {
        const Phantom& p = whole(name);
        std::size_t air = 0, soft = 0, bone = 0;
        for (const std::int16_t v : voxels_of(p)) {
            ASSERT_GE(v, -1024) << name;
            ASSERT_LE(v, 3071) << name;
            air += v < -700;
            soft += v > -150 && v < 200;
            bone += v > 300;
        }
        const double all = double(voxels_of(p).size());
        EXPECT_GT(air / all, 0.02) << name;
        EXPECT_GT(soft / all, 0.2) << name;
        EXPECT_GT(bone / all, 0.002) << name;
        EXPECT_LT(bone / all, 0.2) << name;
    }
}

TEST(Phantom, LandmarksAreOnTissueAndSeenFromTheLumen) {
    int looked = 0;
    for (const std::string_view name : phantom_names()) {
        const Phantom& p = whole(std::string(name));
        const bool contrast = name == "vessel";
        const auto in_lumen = [&](double v) { return contrast ? v > 190 && v < 300 : v < -900; };
        for (const PhantomLandmark& l : p.landmarks) {
            SCOPED_TRACE(std::string(name) + " " + l.name);
            EXPECT_NEAR(norm(l.look), 1, 1e-9);
            EXPECT_GT(norm(l.push_mm), 1);
            EXPECT_TRUE(in_lumen(value_at(p, l.eye_mm))) << value_at(p, l.eye_mm);
            EXPECT_GT(value_at(p, l.push_point_mm), -500);
            if (contrast) {
                EXPECT_NE(value_at(p, l.push_point_mm), 250);
            }
            if (l.name == "plaque") continue;  // lies behind the wall
            // The way there is free up to the surface.
            const Vec3d way = l.push_point_mm - l.eye_mm;
            const double length = norm(way);
            for (double t = 0; t < length - 5; t += 0.25) {
                const double v = value_at(p, l.eye_mm + (t / length) * way);
                ASSERT_TRUE(contrast ? v > 160 && v < 300 : v < -500) << t;
            }
            EXPECT_GT(dot(way, l.look) / length, 0.8);
            ++looked;
        }
    }
    EXPECT_GE(looked, 10);
}

TEST(Phantom, WhatIsSaidToBeBoneIsAboveTheBoneThreshold) {
    const auto highest_near = [](const Phantom& p, const std::string& landmark) {
        double highest = -2000;
        for (const PhantomLandmark& l : p.landmarks)
            if (l.name == landmark) highest = value_at(p, l.push_point_mm);
        return highest;
    };
    EXPECT_GT(highest_near(whole("sinus"), "sphenoid_wall"), 320);
    EXPECT_GT(highest_near(whole("vessel"), "plaque"), 320);
    EXPECT_LT(highest_near(whole("sinus"), "septum"), 250);
    EXPECT_LT(highest_near(whole("airway"), "carina"), 250);
    // The contrast itself moves.
    const auto& vessel = whole("vessel");
    EXPECT_LT(value_at(vessel, vessel.landmarks[1].eye_mm), 300);
}

TEST(Phantom, TheCarinasWallsFaceOthersAcrossAFewMillimetresOfAir) {
    const Phantom& p = whole("airway");
    ASSERT_EQ(p.landmarks.front().name, "carina");
    const Vec3d tip = p.landmarks.front().push_point_mm;
    // across each of the main bronchi, from within the spur between them
    for (const Vec3d across : {normalized({-16, 0, 9}), normalized({15, 0, 11})}) {
        double enter = -1, leave = -1;
        for (double t = 0; t < 25 && leave < 0; t += 0.1) {
            const double v = value_at(p, tip + Vec3d{0, 0, -3} + t * across);
            if (enter < 0 && v < -500) enter = t;
            if (enter >= 0 && v > -500) leave = t;
        }
        EXPECT_GT(enter, 0.3);
        EXPECT_LT(enter, 5);
        EXPECT_GT(leave - enter, 4);
        EXPECT_LT(leave - enter, 15);
    }
}

TEST(Phantom, TheAirwaysWallIsClosedTowardsTheLung) {
    // A flood from the trachea below the threshold of the iso surface doesn't get into the lung.
    const Phantom& p = whole("airway");
    const Grid& g = p.volume.grid;
    std::vector<char> seen(voxel_count(g), 0);
    const Vec3d start = voxel_from_world(g, {0, 0, 26});
    std::vector<Vec3i> open{{int(start.x), int(start.y), int(start.z)}};
    std::size_t reached = 0;
    while (!open.empty()) {
        const Vec3i at = open.back();
        open.pop_back();
        if (!contains(voxel_box(g), at)) continue;
        const std::size_t n = voxel_index(g, at);
        if (seen[n] || voxels_of(p)[n] > -500) continue;
        seen[n] = 1;
        ++reached;
        for (int a = 0; a < 3; ++a)
            for (const int d : {-1, 1}) {
                Vec3i next = at;
                next[a] += d;
                open.push_back(next);
            }
    }
    EXPECT_GT(reached, 15000u);  // mm³: trachea and bronchi
    EXPECT_LT(reached, 60000u);
}

TEST(Phantom, KeyValuesSayWhatTheLandmarksSay) {
    for (const std::string_view name : phantom_names()) {
        const Phantom p = make(settings(name, 4));
        EXPECT_EQ(p.volume.key_values.front(),
                  (std::pair<std::string, std::string>{"phantom", std::string(name)}));
        std::size_t found = 0;
        for (const auto& [key, value] : p.volume.key_values) {
            if (!key.starts_with("landmark ")) continue;
            ASSERT_LT(found, p.landmarks.size());
            const PhantomLandmark& l = p.landmarks[found++];
            EXPECT_EQ(key, "landmark " + l.name);
            double n[12];
            ASSERT_EQ(std::sscanf(value.c_str(),
                                  "push %lf,%lf,%lf:%lf,%lf,%lf eye %lf,%lf,%lf look %lf,%lf,%lf",
                                  n, n + 1, n + 2, n + 3, n + 4, n + 5, n + 6, n + 7, n + 8, n + 9,
                                  n + 10, n + 11),
                      12)
                << value;
            EXPECT_LT(norm(Vec3d{n[0], n[1], n[2]} - l.push_point_mm), 0.01);
            EXPECT_LT(norm(Vec3d{n[3], n[4], n[5]} - l.push_mm), 0.01);
            EXPECT_LT(norm(Vec3d{n[6], n[7], n[8]} - l.eye_mm), 0.01);
            EXPECT_LT(norm(Vec3d{n[9], n[10], n[11]} - l.look), 0.001);
            EXPECT_EQ(value.find("-0.00,"), std::string::npos) << value;
        }
        EXPECT_EQ(found, p.landmarks.size());
    }
}

TEST(Phantom, ProgressRunsFromNothingToOne) {
    double last = 0;
    const auto phantom = make_phantom(settings("cube", 40), TaskArena(2), [&](double fraction) {
        EXPECT_GE(fraction, last);
        last = fraction;
    });
    ASSERT_TRUE(phantom.ok());
    EXPECT_EQ(last, 1);
}

TEST(Phantom, BadSettingsAreNamed) {
    const TaskArena arena(1);
    const auto expect_error = [&](const PhantomSettings& s, const std::string& word,
                                  ErrorCode code = ErrorCode::InvalidArgument) {
        const auto result = make_phantom(s, arena);
        ASSERT_FALSE(result.ok()) << word;
        EXPECT_EQ(result.error().code, code) << result.error().message;
        EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
        EXPECT_EQ(result.error().message.find('\n'), std::string::npos);
    };
    expect_error(settings("elbow", 8), "airway");
    PhantomSettings s = settings("cube", 8);
    s.size.y = 1;
    expect_error(s, "size.y");
    s.size.y = 4097;
    expect_error(s, "size.y");
    expect_error(settings("cube", 4096), "68719476736", ErrorCode::LimitExceeded);
    for (const double bad :
         {-1.0, 1e-9, 1e9, std::nan(""), std::numeric_limits<double>::infinity()}) {
        s = settings("cube", 8);
        s.spacing_mm.z = bad;
        expect_error(s, "spacing_mm.z");
    }
    s = settings("cube", 8);
    s.direction.columns[1] = {0, 2, 0};
    expect_error(s, "direction: column 2");
    s.direction.columns[1] = {std::nan(""), 1, 0};
    expect_error(s, "direction: column 2");
    s.direction.columns[1] = normalized({0.01, 1, 0});
    expect_error(s, "columns 1 and 2");
}

}  // namespace
}  // namespace pliant
