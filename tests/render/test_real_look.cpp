// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: render/real_look.cpp, render/noise_tile.cpp.

#include "render/real_look.h"

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/hash.h"
#include "render/analytic_volumes.h"
#include "render/colour.h"
#include "render/exposure.h"
#include "render/noise_tile.h"

namespace pliant {
namespace {

using render::NoiseTile;
using test::make_volume;
using test::plain_grid;

Endoscope real_from_the_front() {
    Endoscope e;
    e.eye_mm = {40, 2, 40};
    e.look = {0, 1, 0};
    e.up = {0, 0, 1};
    e.style = Style::Real;
    return e;
}

/// Tissue of one value beyond a plane y = wall_mm, with an edge one voxel wide.
Volume wall_at(double wall_mm, double tissue_hu = 0) {
    return make_volume<std::int16_t>(plain_grid({81, 121, 81}), [=](Vec3d p) {
        return -1000 + (1000 + tissue_hu) * std::clamp(p.y - wall_mm + 0.5, 0.0, 1.0);
    });
}

const Rgb8& pixel_at(const Image& image, int x, int y) {
    return image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
}

/// Hue [degrees] and saturation 0…1 of a colour.
struct HueSaturation {
    double hue, saturation;
};
HueSaturation hue_of(Vec3d c) {
    const double most = std::max({c.x, c.y, c.z}), range = most - std::min({c.x, c.y, c.z});
    const double hue = most == c.x   ? (c.y - c.z) / range
                       : most == c.y ? 2 + (c.z - c.x) / range
                                     : 4 + (c.x - c.y) / range;
    return {60 * (hue < 0 ? hue + 6 : hue), range / most};
}

TEST(NoiseTile, InterpolatesItsLatticeAndRepeats) {
    std::mt19937 random(26);
    std::uniform_real_distribution<double> place(-40, 40);
    const NoiseTile& tile = NoiseTile::instance();
    double sum = 0;
    for (int n = 0; n < 2000; ++n) {
        const Vec3d q{place(random), place(random), place(random)};
        const NoiseTile::Value v = tile.at(q);
        EXPECT_GE(v.value, 0);
        EXPECT_LE(v.value, 1);
        sum += double(v.value);
        const NoiseTile::Value again = tile.at(q + Vec3d{16, -32, 48});
        EXPECT_NEAR(v.value, again.value, 1e-5);
    }
    EXPECT_NEAR(sum / 2000, 0.5, 0.02);
    // At lattice points the value is the lattice's: a multiple of 1/512, and flat.
    const NoiseTile::Value corner = tile.at({3, 7, 11});
    EXPECT_EQ(std::round(512 * double(corner.value)), 512 * double(corner.value));
    EXPECT_EQ(corner.slope, (Vec3f{0, 0, 0}));
}

TEST(NoiseTile, HasTheSlopeOfItsValues) {
    std::mt19937 random(27);
    std::uniform_real_distribution<double> place(0, 16);
    const NoiseTile& tile = NoiseTile::instance();
    double worst = 0;
    for (int n = 0; n < 2000; ++n) {
        const Vec3d q{place(random), place(random), place(random)};
        for (int a = 0; a < 3; ++a) {
            Vec3d before = q, after = q;
            before[a] -= 0.125;
            after[a] += 0.125;
            const double change = 4 * double(tile.at(after).value - tile.at(before).value);
            worst = std::max(worst, std::abs(change - double(tile.at(q).slope[a])));
        }
    }
    EXPECT_LT(worst, 0.3);  // of slopes up to 1.5: both are interpolated, four samples a cell
}

// viewer/test/test_real.ts has the same numbers.
TEST(NoiseTile, IsTheTileOfThePage) {
    const auto& samples = NoiseTile::instance().samples();
    const auto at = [&](std::size_t i, std::size_t j, std::size_t k) {
        return samples[(k * 64 + j) * 64 + i];
    };
    EXPECT_EQ(at(0, 0, 0).value, 0.068359375f);
    EXPECT_EQ(at(5, 22, 63).value, 0.35149574279785156f);
    EXPECT_EQ(at(5, 22, 63).slope.x, 0.00611114501953125f);
}

TEST(RealLook, KeepsItsBrightnessWhileTheWallComesNearer) {
    // Metered: the same wall from 8, 16 and 32 mm is as bright; without it, it would be 16 times as
    // dark.
    TaskArena arena(2);
    double first = 0;
    for (const double far_mm : {8.0, 16.0, 32.0}) {
        const Volume volume = wall_at(2 + far_mm);
        Endoscope e = real_from_the_front();
        e.field_of_view_deg = 40;
        const Image image = RayCaster(volume, arena).endoscope_view(e, 64, 64);
        double sum = 0;
        for (int y = 22; y < 42; ++y)
            for (int x = 22; x < 42; ++x) sum += pixel_at(image, x, y).r;
        if (first == 0) first = sum;
        EXPECT_NEAR(sum / first, 1, 0.12) << far_mm << " mm";
    }
}

TEST(RealLook, MetersByTheInverseSquare) {
    TaskArena arena(1);
    const auto exposure_at = [&](double far_mm) {
        const Volume volume = wall_at(2 + far_mm);
        const render::VolumeRays rays(volume, arena);
        Endoscope e = real_from_the_front();
        e.field_of_view_deg = 2;  // all rays are about as long
        const render::Camera camera(e, 64, 64);
        return render::metered_exposure(render::EyeRays(rays, e.eye_mm, e.iso_hu, e.polarity),
                                        camera, FieldStop::Round);
    };
    for (const double far_mm : {6.0, 12.0, 24.0, 40.0})
        EXPECT_NEAR(exposure_at(far_mm) / (far_mm * far_mm + 9), 0.75, 0.005) << far_mm;
    EXPECT_NEAR(exposure_at(60) / (45.0 * 45 + 9), 0.75, 0.005) << "lamps can do no more";
    EXPECT_NEAR(exposure_at(1) / (5.0 * 5 + 9), 0.75, 0.005) << "and dim no further";
}

TEST(RealLook, MetersThePictureThatIsShown) {
    // A wall 10 mm ahead; beyond the round field of a wide picture, the space is open.
    TaskArena arena(1);
    const Volume volume = make_volume<std::int16_t>(plain_grid({81, 121, 81}), [](Vec3d p) {
        return p.y > 12 && std::abs(p.x - 40) < 9 ? 0 : -1000;
    });
    const render::VolumeRays rays(volume, arena);
    Endoscope e = real_from_the_front();
    const render::Camera camera(e, 128, 64);
    const render::EyeRays eye_rays(rays, e.eye_mm, e.iso_hu, e.polarity);
    const auto exposure = [&](FieldStop stop) {
        return render::metered_exposure(eye_rays, camera, stop);
    };
    EXPECT_EQ(exposure(FieldStop::Round), exposure(FieldStop::Octagon));
    EXPECT_GT(exposure(FieldStop::Full), 1.5 * exposure(FieldStop::Round));
}

TEST(RealLook, IsBlackBeyondTheFieldStop) {
    TaskArena arena(2);
    const Volume volume = wall_at(20);
    Endoscope e = real_from_the_front();
    const auto lit = [&](FieldStop stop, double u, double v) {
        e.field_stop = stop;
        const Image image = RayCaster(volume, arena).endoscope_view(e, 120, 80);
        return pixel_at(image, int(60 + 40 * u), int(40 - 40 * v)) != Rgb8{0, 0, 0};
    };
    EXPECT_TRUE(lit(FieldStop::Round, 0, 0.95));
    EXPECT_FALSE(lit(FieldStop::Round, 0.75, 0.75));
    EXPECT_FALSE(lit(FieldStop::Round, 1.2, 0));
    EXPECT_TRUE(lit(FieldStop::Octagon, 0.9, 0.35));
    EXPECT_FALSE(lit(FieldStop::Round, 0.95, 0.35));
    EXPECT_FALSE(lit(FieldStop::Octagon, 0.8, 0.8));
    EXPECT_TRUE(lit(FieldStop::Full, 1.4, 0.9));
}

/// Mean of the linear light of the middle of a picture.
Vec3d middle_of(const Image& image) {
    Vec3d sum{0, 0, 0};
    const int low = image.width / 4, high = 3 * image.width / 4;
    for (int y = low; y < high; ++y)
        for (int x = low; x < high; ++x)
            sum = sum + render::linear_from_srgb(pixel_at(image, x, y));
    return (1.0 / ((high - low) * (high - low))) * sum;
}

TEST(RealLook, TakesItsColourFromTheTissueBehindTheWall) {
    TaskArena arena(2);
    const auto colour = [&](double hu) {
        const Volume volume = wall_at(20, hu);
        return hue_of(
            middle_of(RayCaster(volume, arena).endoscope_view(real_from_the_front(), 80, 80)));
    };
    const HueSaturation mucosa = colour(40), fat = colour(-80), cartilage = colour(250);
    EXPECT_GT(mucosa.saturation, fat.saturation);
    EXPECT_GT(fat.hue, mucosa.hue + 4) << "fat is yellower";
    EXPECT_LT(cartilage.saturation, mucosa.saturation - 0.08) << "cartilage is paler";
}

TEST(RealLook, MakesNoYellowRimsWhereAWallIsThin) {
    // A sheet between two lumina never reaches tissue's values: it passes through fat's on both
    // sides. Its colour is not fat's.
    TaskArena arena(2);
    const auto sheet = [&](double half_mm) {
        const Volume volume = make_volume<std::int16_t>(plain_grid({81, 60, 81}), [=](Vec3d p) {
            return -1000 + 1040 * std::clamp(half_mm + 0.5 - std::abs(p.y - 22.3), 0.0, 1.0);
        });
        return hue_of(
            middle_of(RayCaster(volume, arena).endoscope_view(real_from_the_front(), 80, 80)));
    };
    const double fat =
        hue_of(
            middle_of(
                RayCaster(wall_at(20, -80), arena).endoscope_view(real_from_the_front(), 80, 80)))
            .hue;
    for (double half_mm = 0.4; half_mm < 3; half_mm += 0.2)
        EXPECT_LT(sheet(half_mm).hue, fat - 2) << 2 * half_mm << " mm thick";
}

TEST(RealLook, ShowsACutThatNothingHoldsOpen) {
    // The wall stays as it is: all that is there of the cut is raw tissue.
    TaskArena arena(2);
    const Volume volume = wall_at(20, 40);
    auto tissue = ChainMail::create(volume, {}, arena);
    ASSERT_TRUE(tissue.ok());
    ASSERT_TRUE(tissue->cut({{{40, 18, 25}, {40, 18, 55}}, {0, 12, 0}}).ok());
    const auto deformed = deform_volume(*tissue, Mapping::Cells, true);
    ASSERT_TRUE(deformed.ok());
    const auto rest = RestField::create(*tissue, *deformed);
    ASSERT_TRUE(rest.ok());
    Endoscope e = real_from_the_front();
    const RayCaster caster(deformed->volume, arena);
    const Image whole = caster.endoscope_view(e, 160, 160);
    e.rest = &*rest;
    const Image cut = caster.endoscope_view(e, 160, 160);
    const auto colour = [](const Image& image, int x) {  // about the middle line, across the cut
        Vec3d sum{0, 0, 0};
        for (int y = 70; y < 90; ++y)
            sum = sum + 0.05 * render::linear_from_srgb(pixel_at(image, x, y));
        return sum;
    };
    double darkest = 1;
    int at = 0;
    for (int x = 60; x < 100; ++x)
        if (colour(cut, x).x < darkest) {
            darkest = colour(cut, x).x;
            at = x;
        }
    EXPECT_NEAR(at, 80, 3) << "the slit is where the tissue was cut";
    EXPECT_LT(darkest, 0.35 * colour(whole, at).x);
    // Lips of flesh, 1.5 mm beside it: redder than the mucosa, on average a good deal.
    double redness = 0;
    for (const int side : {-1, 1}) {
        const Vec3d lip = colour(cut, at + side * 8), before = colour(whole, at + side * 8);
        EXPECT_GT(lip.x, 1.5 * darkest);
        const double gain = lip.x / lip.y * before.y / before.x;
        EXPECT_GT(gain, 1.1);
        redness += 0.5 * gain;
    }
    EXPECT_GT(redness, 1.25);
    EXPECT_EQ(pixel_at(cut, 20, 80), pixel_at(whole, 20, 80)) << "elsewhere nothing changes";
}

TEST(RealLook, ShadesACarvedHollowLikeASmoothOne) {
    // Carving takes out whole voxels. The same hollow with an edge of one voxel has no terraces.
    TaskArena arena(2);
    const Vec3d centre{40, 21, 40};
    constexpr double kRadius = 7;
    const Volume volume = wall_at(20, 40);
    const Volume smooth = make_volume<std::int16_t>(plain_grid({81, 121, 81}), [&](Vec3d p) {
        const double wall = std::clamp(p.y - 20 + 0.5, 0.0, 1.0);
        return -1000 +
               1040 * std::min(wall, std::clamp(norm(p - centre) - kRadius + 0.5, 0.0, 1.0));
    });
    auto tissue = ChainMail::create(volume, {}, arena);
    ASSERT_TRUE(tissue.ok());
    ASSERT_TRUE(tissue->carve({centre, centre, kRadius}).ok());
    const auto deformed = deform_volume(*tissue, Mapping::Cells, true);
    ASSERT_TRUE(deformed.ok());
    const auto rest = RestField::create(*tissue, *deformed);
    ASSERT_TRUE(rest.ok());
    const RayCaster carved(deformed->volume, arena), even(smooth, arena);
    Endoscope e = real_from_the_front();
    e.rest = &*rest;
    const Image a = carved.endoscope_view(e, 160, 160), b = even.endoscope_view(e, 160, 160);
    double sum = 0;  // of the differences in the hollow
    int count = 0;
    for (int y = 60; y < 100; ++y)
        for (int x = 60; x < 100; ++x, ++count)
            sum += std::abs(double(pixel_at(a, x, y).r) - double(pixel_at(b, x, y).r));
    EXPECT_LT(sum / count, 5.5) << "of 255; 7.4 with the normals of the voxels";
}

TEST(RealLook, IsTheSameForAnyThreadCount) {
    const Volume volume = make_volume<std::int16_t>(plain_grid({60, 60, 60}), [](Vec3d p) {
        return 600 * std::sin(p.x * 0.4) * std::cos(p.y * 0.3) + 500 * std::sin(p.z * 0.35);
    });
    Endoscope e = real_from_the_front();
    e.eye_mm = {30, 30, 30};
    e.iso_hu = 100;
    std::uint64_t expected = 0;
    for (const int threads : {1, 2, 4}) {
        TaskArena arena(threads);
        const Image image = RayCaster(volume, arena).endoscope_view(e, 133, 97);
        Hash64 hash;
        hash.add(std::span<const Rgb8>(image.pixels));
        if (threads == 1) expected = hash.value();
        EXPECT_EQ(hash.value(), expected) << threads << " threads";
    }
}

}  // namespace
}  // namespace pliant
