// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vector kernels against the scalar versions, bit by bit, on every instruction set.

#include "render/shade.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <limits>
#include <random>

#include "render/analytic_volumes.h"
#include "render/colour.h"
#include "render/real_look.h"

namespace pliant {
namespace {

using render::LookHit;
using test::make_volume;
using test::odd_grid;
using test::plain_grid;

constexpr std::uint64_t kShadeSeed = 20261127;

/// Calls body(name) with each instruction set of this machine.
template <class Body>
void on_every_target(const Body& body) {
    int targets = 0;
    for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1, ++targets) {
        hwy::SetSupportedTargetsForTest(rest & -rest);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        body(hwy::TargetName(rest & -rest));
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_GT(targets, 0);
}

class Random {
  public:
    explicit Random(std::uint64_t seed) : m_engine(seed) {}
    double between(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(m_engine);
    }
    Vec3d unit() {
        std::normal_distribution<double> normal;
        return normalized(Vec3d{normal(m_engine), normal(m_engine), normal(m_engine)});
    }

  private:
    std::mt19937_64 m_engine;
};

/// Hits in and around a grid, and some of them exactly at voxels.
std::vector<LookHit> random_hits(Random& random, const Grid& grid, std::size_t count) {
    std::vector<LookHit> hits(count);
    for (LookHit& hit : hits) {
        Vec3d ijk;
        for (int a = 0; a < 3; ++a) ijk[a] = random.between(-3, grid.size[a] + 2.0);
        if (random.between(0, 1) < 0.1)
            for (int a = 0; a < 3; ++a) ijk[a] = std::round(ijk[a]);
        hit = {random.between(0.1, 100), world_from_voxel(grid, ijk), random.unit(), random.unit()};
    }
    return hits;
}

template <class T>
void expect_scalar_bits(const Grid& grid, Random& random, double contrast, const char* what) {
    const TaskArena arena(1);
    const Volume volume = make_volume<T>(
        grid, [&](Vec3d) { return contrast > 0 ? random.between(-contrast, contrast) : 40.0; });
    const render::VolumeRays rays(volume, arena);
    for (const Polarity polarity : {Polarity::Rising, Polarity::Falling}) {
        Endoscope e;
        e.eye_mm = world_from_voxel(grid, {1, 1, 1});
        e.style = Style::Real;
        e.polarity = polarity;
        e.iso_hu = random.between(-600, 300);
        e.lining = Lining(int(random.between(0, 4)));
        const render::EyeRays eye_rays(rays, e.eye_mm, e.iso_hu, polarity);
        const render::RealLook look(rays, eye_rays, e, render::Camera(e, 64, 64));
        const auto hits = random_hits(random, grid, 61);
        std::vector<Vec3d> expected, normals;
        for (const LookHit& hit : hits) {
            expected.push_back(look.shade(hit));
            normals.push_back(rays.normal(hit.point_mm, hit.direction, polarity));
        }
        on_every_target([&](const char* target) {
            std::vector<Vec3d> light(hits.size());
            look.shade(hits, light.data());
            auto found = hits;
            rays.normals(found, polarity);
            for (std::size_t n = 0; n < hits.size(); ++n) {
                ASSERT_EQ(light[n], expected[n]) << target << ", " << what << ", hit " << n;
                ASSERT_EQ(found[n].normal, normals[n]) << target << ", " << what << ", hit " << n;
            }
        });
    }
}

TEST(Shade, GivesTheBitsOfTheScalarVersion) {
    Random random(kShadeSeed);
    for (const double contrast : {0.0, 300.0, 2000.0}) {
        expect_scalar_bits<std::int16_t>(odd_grid({17, 12, 9}), random, contrast, "16 bits");
        expect_scalar_bits<float>(odd_grid({17, 12, 9}), random, contrast, "floats");
    }
    for (const Vec3i size : {Vec3i{1, 5, 5}, {2, 2, 2}, {7, 1, 6}, {6, 5, 1}, {1, 1, 1}}) {
        expect_scalar_bits<std::int16_t>(plain_grid(size), random, 900, "thin, 16 bits");
        expect_scalar_bits<float>(plain_grid(size), random, 900, "thin, floats");
    }
}

TEST(Shade, GivesTheBitsOfTheScalarVersionForMovedAndRawTissue) {
    Random random(kShadeSeed);
    TaskArena arena(1);
    const Volume scan = make_volume<std::int16_t>(plain_grid({41, 41, 41}), [](Vec3d p) {
        return -1000 + 1040 * std::clamp(p.y - 15.5, 0.0, 1.0);
    });
    auto tissue = ChainMail::create(scan, {}, arena);
    ASSERT_TRUE(tissue.ok());
    ASSERT_TRUE(tissue->push({{20, 15, 20}, {0, 4, 1}, 3}).ok());
    ASSERT_TRUE(tissue->carve({{30, 16, 30}, {32, 16, 30}, 3}).ok());
    const auto deformed = deform_volume(*tissue, Mapping::Cells, true);
    ASSERT_TRUE(deformed.ok());
    const auto rest = RestField::create(*tissue, *deformed);
    ASSERT_TRUE(rest.ok());
    const render::VolumeRays rays(deformed->volume, arena);
    Endoscope e;
    e.eye_mm = {20, 3, 20};
    e.style = Style::Real;
    e.rest = &*rest;
    const render::EyeRays eye_rays(rays, e.eye_mm, e.iso_hu, e.polarity);
    const render::RealLook look(rays, eye_rays, e, render::Camera(e, 64, 64));
    const auto hits = random_hits(random, scan.grid, 3000);
    std::vector<Vec3d> expected;
    int moved = 0, raw = 0;
    for (const LookHit& hit : hits) {
        expected.push_back(look.shade(hit));
        const auto here = rest->at(rays.to_voxel(hit.point_mm));
        moved += here.offset_mm != Vec3f{0, 0, 0};
        raw += here.raw > 0;
    }
    EXPECT_GT(moved, 100);
    EXPECT_GT(raw, 20);
    on_every_target([&](const char* target) {
        std::vector<Vec3d> light(hits.size());
        look.shade(hits, light.data());
        for (std::size_t n = 0; n < hits.size(); ++n)
            ASSERT_EQ(light[n], expected[n]) << target << ", hit " << n;
    });
}

TEST(Srgb, TableIsTheFormula) {
    Random random(kShadeSeed);
    for (int n = 0; n < 300000; ++n) {
        const double uniform = random.between(-0.1, 1.1);
        for (const double light : {uniform, 0.01 * uniform, n / 300000.0})
            ASSERT_EQ(render::srgb_from_linear(light), render::srgb_by_formula(light)) << light;
    }
    for (int code = 0; code < 256; ++code) {  // the values of the other direction
        const double light = render::linear_from_srgb(std::uint8_t(code));
        EXPECT_EQ(render::srgb_from_linear(light), code);
    }
    EXPECT_EQ(render::srgb_from_linear(std::numeric_limits<double>::infinity()), 255);
    EXPECT_EQ(render::srgb_from_linear(std::numeric_limits<double>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace pliant
