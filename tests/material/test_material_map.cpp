// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The table of materials against its law, number by number, and the materials of elements against
// a plain count of the air around each of them.
// Covers: material/air.h, material/labels.cpp, material/material.cpp, material/material_map.cpp.

#include "material/material_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "field/fixed_point.h"
#include "material/air.h"
#include "material/labels.h"
#include "support/random.h"
#include "volume/boxes.h"

namespace pliant::test {
namespace {

MaterialLaw constant_law(const ElementLimits& limits) {
    return [limits](int) { return limits; };
}

TEST(MaterialTable, RefusesNumbersOutsideOfTheirRanges) {
    struct Case {
        const char* field;
        double low, high;  ///< the ends of the range
        double* number;    ///< in `limits`
    };
    constexpr double kNone = 1e9;
    ElementLimits limits;
    const Case cases[] = {
        {"compress.x", 0, 1, &limits.compress.x},
        {"compress.y", 0, 1, &limits.compress.y},
        {"compress.z", 0, 1, &limits.compress.z},
        {"stretch.x", 0, kNone, &limits.stretch.x},
        {"stretch.y", 0, kNone, &limits.stretch.y},
        {"stretch.z", 0, kNone, &limits.stretch.z},
        {"shear.x", 0, kNone, &limits.shear.x},
        {"shear.y", 0, kNone, &limits.shear.y},
        {"shear.z", 0, kNone, &limits.shear.z},
        {"yield", 0, 1, &limits.yield},
        {"max_movement_mm", 0, kNone, &limits.max_movement_mm},
    };
    const auto fault_with = [&](const Case& c, double value) {
        *c.number = value;
        const MaterialTable table({constant_law({}), constant_law(limits)}, {}, {1, 1, 1});
        *c.number = 0;
        return table.fault();
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.field);
        for (const double inside : {c.low, 0.5, c.high}) EXPECT_FALSE(fault_with(c, inside));
        for (const double beyond : {c.low - 1e-6, c.high + 1e-6, std::nan("")}) {
            if (beyond > kNone) continue;
            const auto fault = fault_with(c, beyond);
            ASSERT_TRUE(fault);
            EXPECT_EQ(fault->law, 1);
            EXPECT_EQ(fault->value_hu, kLowestValue);
            EXPECT_EQ(fault->text.rfind(std::string(c.field) + ": expected ", 0), 0u)
                << fault->text;
        }
    }
}

TEST(MaterialTable, IsSymmetricIfTheLimitsOfEachAxisAreEqual) {
    const auto is_symmetric = [](const ElementLimits& limits) {
        return MaterialTable({constant_law(limits)}, {}, {1, 1, 1}).is_symmetric();
    };
    const Vec3d equal{0.1, 0.2, 0.3};
    EXPECT_TRUE(is_symmetric({.compress = equal, .stretch = equal, .shear = equal}));
    for (int b = 0; b < 3; ++b) {
        Vec3d other = equal;
        other[b] = 0.4;
        EXPECT_FALSE(is_symmetric({.compress = other, .stretch = equal, .shear = equal}));
        EXPECT_FALSE(is_symmetric({.compress = equal, .stretch = other, .shear = equal}));
        EXPECT_FALSE(is_symmetric({.compress = equal, .stretch = equal, .shear = other}));
    }
}

/// Half of a fraction of a link [2⁻²⁰ mm], rounded down.
Fixed half(double spacing_mm, double fraction) {
    return Fixed(std::floor(spacing_mm * fraction * 0.5 * 1048576));
}

TEST(MaterialTable, HasTheHalvesOfTheLaw) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Vec3d spacing{random.real(0.3, 2), random.real(0.3, 2), random.real(0.3, 2)};
        // A few materials, by value; some axes and kinds are alike.
        std::vector<ElementLimits> materials(5);
        for (ElementLimits& m : materials) {
            for (int b = 0; b < 3; ++b) {
                m.shear[b] = b > 0 && random.whole(0, 1) ? m.shear[0] : random.real(0, 1);
                m.compress[b] = random.whole(0, 2) ? m.shear[b] : random.real(0, 1);
                m.stretch[b] = random.whole(0, 2) ? m.shear[b] : random.real(0, 3);
            }
            m.max_movement_mm = random.real(0, 40);
            m.fixed = random.whole(0, 3) == 0;
            m.yield = random.whole(0, 1) ? 0 : random.real(0, 1);
        }
        const auto law = [&](int value) { return materials[std::size_t(value & 3)]; };
        const MaterialTable table({law}, {materials[4]}, spacing);
        ASSERT_TRUE(table.fits() && !table.fault());
        EXPECT_EQ(table.law_size(), 5);
        EXPECT_EQ(table.size(), 6);
        EXPECT_EQ(table.id(0, -40000), table.id(0, -32767));
        EXPECT_EQ(table.id(0, 40000), table.id(0, 32767));
        bool symmetric = true;
        for (int value = -32767; value <= 32768; ++value) {
            const MaterialId id = value == 32768 ? table.other_id(0) : table.id(0, value);
            const ElementLimits& expected = value == 32768 ? materials[4] : law(value);
            const HalfLimits& found = table[id];
            unsigned traits = expected.fixed ? kFixedTrait : 0;
            for (int b = 0; b < 3; ++b) {
                const auto axis = std::size_t(b);
                ASSERT_EQ(found.compress[b], half(spacing[b], expected.compress[b]));
                ASSERT_EQ(found.stretch[b], half(spacing[b], expected.stretch[b]));
                ASSERT_EQ(found.shear[b], half(spacing[b], expected.shear[b]));
                ASSERT_EQ(table.columns().compress[axis][id], found.compress[b]);
                ASSERT_EQ(table.columns().stretch[axis][id], found.stretch[b]);
                ASSERT_EQ(table.columns().shear[axis][id], found.shear[b]);
                if (found.compress[b] != found.stretch[b] || found.stretch[b] != found.shear[b])
                    traits |= kAsymmetric;
                for (const auto* limits : {found.compress, found.stretch, found.shear})
                    if (limits[b] != limits[0]) traits |= kAnisotropic;
            }
            ASSERT_EQ(table.traits()[id], traits);
            symmetric = symmetric && !(traits & kAsymmetric);
            ASSERT_EQ(found.max_movement, Fixed(std::floor(expected.max_movement_mm * 1048576)));
            ASSERT_EQ(table.movements()[id], expected.fixed ? INT32_MAX : found.max_movement);
            ASSERT_EQ(found.fixed, expected.fixed);
            ASSERT_EQ(found.yield, Fixed(std::lround(expected.yield * 65536)));
        }
        EXPECT_EQ(table.is_symmetric(), symmetric);
        EXPECT_EQ(table.movements()[kVoidMaterial], INT32_MAX);
        EXPECT_FALSE(table[kVoidMaterial].fixed);
    }
}

TEST(MaterialTable, HoldsAsManyMaterialsAsItsNumbersCanName) {
    const auto limits_of = [](int value) {
        ElementLimits limits;
        limits.max_movement_mm = 1 + double(value + 32767) / 1024;
        return limits;
    };
    // A material for each value, and that of void elements: no number is left.
    const MaterialTable known({limits_of, constant_law(limits_of(7))}, {}, {1, 1, 1});
    EXPECT_TRUE(known.fits());
    EXPECT_EQ(known.id(1, 40), known.id(0, 7));
    EXPECT_NE(known.id(0, 40), known.id(0, 7));
    const MaterialTable further({limits_of, constant_law(limits_of(32768))}, {}, {1, 1, 1});
    EXPECT_FALSE(further.fits());
}

TEST(Labels, LawsAreNamedByTheirTables) {
    ChainMailSettings settings;
    settings.label_materials = {{.values = {1}}, {.values = {2}}, {.values = {3}}};
    settings.label_materials[1].along_direction = true;  // three laws
    EXPECT_EQ(law_name(settings, 0), "[material]");
    EXPECT_EQ(law_name(settings, 1), "[[label]] 1");
    for (const int law : {2, 3, 4}) EXPECT_EQ(law_name(settings, law), "[[label]] 2");
    EXPECT_EQ(law_name(settings, 5), "[[label]] 3");
}

TEST(MaterialMap, LabelsAtTheEndsOfTheirRangeHaveTheirMaterial) {
    Volume volume, labels;
    volume.grid.size = labels.grid.size = {6, 1, 1};
    volume.voxels = std::vector<std::int16_t>(6, 40);
    // Values beyond the range, and NaN, are no labels.
    labels.voxels = std::vector<float>{
        -32768, 65535, -32769, 65536, std::numeric_limits<float>::quiet_NaN(), 0};
    ChainMailSettings settings;
    settings.labels = std::make_shared<const Volume>(labels);
    settings.label_materials = {
        {.values = {-32768}, .law = LabelLaw::Constant, .stretch = {1, 2, 3}},
        {.values = {65535}, .law = LabelLaw::Constant, .stretch = {4, 5, 6}}};
    const MaterialMap map(volume, settings);
    const Vec3d own = draeger_limits(settings, 40).stretch;
    const Vec3d expected[] = {{1, 2, 3}, {4, 5, 6}, own, own, own, own};
    for (int x = 0; x < 6; ++x) EXPECT_EQ(map.limits_at({x, 0, 0}).stretch, expected[x]) << x;
}

TEST(MaterialMap, AirAndItsSkinAreThoseOfACount) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Volume volume;
        volume.grid.size = {random.whole(1, 21), random.whole(1, 18), random.whole(1, 18)};
        volume.background = random.whole(0, 1) ? -1000.0F : 40.0F;
        // Bands of air and tissue, with single elements of the other.
        const int band = random.whole(2, 9);
        std::vector<float> values(voxel_count(volume.grid));
        for_each_in(voxel_box(volume.grid), [&](Vec3i p) {
            const bool in_band = ((p.x / band + p.y / band + p.z / band) & 1) != 0;
            values[voxel_index(volume.grid, p)] =
                in_band != (random.whole(0, 40) == 0) ? -700.0F : float(random.whole(-50, 250));
        });
        if (random.whole(0, 1)) {
            values[std::size_t(random.whole(0, int(values.size()) - 1))] =
                std::numeric_limits<float>::quiet_NaN();
            volume.voxels = values;
        } else {
            volume.voxels = std::vector<std::int16_t>(values.begin(), values.end());
        }
        ChainMailSettings settings;
        settings.smallest_bone_mm3 = 0;
        const MaterialMap map(volume, settings);
        const auto value = [&](Vec3i p) {
            if (!contains(voxel_box(volume.grid), p)) return volume.background;
            const float found = values[voxel_index(volume.grid, p)];
            return std::isnan(found) ? volume.background : found;
        };
        const auto is_air = [&](Vec3i p) { return value(p) < -500; };
        const auto expected = [&](Vec3i p) {
            if (!is_air(p)) return map.table().id(0, int(value(p)));
            int skin = 0;
            for (int b = 0; b < 3; ++b) {
                int steps[2];  // to tissue, at most 5
                for (int side = 0; side < 2; ++side) {
                    Vec3i q = p;
                    for (steps[side] = 0; steps[side] < 5 && is_air(q); ++steps[side])
                        q[b] += side ? 1 : -1;
                }
                const auto [near, far] = std::minmax(steps[0], steps[1]);
                if (near <= 3 && far >= near + 2) skin |= 1 << b;
            }
            return map.table().other_id(skin);
        };
        for (const int size : {8, random.whole(2, 7), random.whole(9, 14)}) {
            const Vec3i last = volume.grid.size - Vec3i{1, 1, 1};
            std::vector<MaterialId> ids(std::size_t(size) * std::size_t(size) * std::size_t(size));
            const Box3i bricks{{-1, -1, -1},
                               {last.x / size + 2, last.y / size + 2, last.z / size + 2}};
            for_each_in(bricks, [&](Vec3i coord) {
                const Vec3i first = size * coord;
                Box3i part =
                    overlap({first, first + Vec3i{size, size, size}}, voxel_box(volume.grid));
                part = {part.begin - first, part.end - first};
                map.fill(first, size, part, ids.data());
                for_each_in({{0, 0, 0}, {size, size, size}}, [&](Vec3i local) {
                    const Vec3i p = first + local;
                    const auto n = std::size_t(local.x + size * (local.y + size * local.z));
                    ASSERT_EQ(ids[n], expected(p)) << p.x << ' ' << p.y << ' ' << p.z;
                    ASSERT_EQ(map.at(p), expected(p));
                    ASSERT_EQ(map.is_tissue(p), contains(voxel_box(volume.grid), p) && !is_air(p));
                });
            });
        }
    }
}

}  // namespace
}  // namespace pliant::test
