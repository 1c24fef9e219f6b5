// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Edits in the stiffness map: after a change the map is the one that a new scan would have, and so
// are the lattices.
// Covers: elastic/stiffness_map.cpp, elastic/levels.cpp, elastic/levels_state.cpp.

#include <gtest/gtest.h>

#include "elastic/lattices.h"
#include "elastic/levels.h"
#include "field/writable_field.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr Vec3i kSize{27, 22, 19};

/// Edits of some voxels near a place.
EditMap edits_near(const Field& field, Vec3i place, Random& random) {
    EditMap bricks;
    for (int n = 0; n < 40; ++n) {
        Vec3i e;
        for (int a = 0; a < 3; ++a)
            e[a] = std::clamp(place[a] + random.whole(-4, 4), 0, kSize[a] - 1);
        const Vec3i coord = field.brick_of(e);
        auto [brick, is_new] = bricks.try_emplace(coord);
        if (is_new) {
            const BrickEdits* const before = field.edits_of(coord);
            brick->second = before ? *before : BrickEdits(512, 0);
        }
        brick->second[std::size_t(field.index_in_brick(e))] |=
            std::uint8_t(1 << random.whole(0, 3));
    }
    return bricks;
}

void exchange(WritableField& field, EditMap& bricks) {
    field.prepare_edits(bricks);
    field.exchange_edits(bricks);
    field.finish_edits(bricks);
}

std::vector<float> moduli(const StiffnessMap& map) {
    std::vector<float> all;
    for (int level = 0; level < map.level_count(); ++level) {
        const Vec3i cells = map.cells(level);
        std::vector<float> mu(std::size_t(cells.x) * std::size_t(cells.y) * std::size_t(cells.z));
        map.moduli(level, {{0, 0, 0}, cells}, std::size_t(cells.x), std::size_t(cells.y),
                   mu.data());
        all.insert(all.end(), mu.begin(), mu.end());
    }
    return all;
}

std::vector<bool> held_nodes(const StiffnessMap& map) {
    std::vector<bool> all;
    for (int level = 0; level < map.level_count(); ++level) {
        const Vec3i cells = map.cells(level);
        for (int k = 0; k <= cells.z; ++k)
            for (int j = 0; j <= cells.y; ++j)
                for (int i = 0; i <= cells.x; ++i) all.push_back(map.is_held(level, {i, j, k}));
    }
    return all;
}

TEST(Edits, AChangedMapIsTheOneOfANewScan) {
    const TaskArena arena(2);
    bool is_other_bone = false;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume scan =
            scan_of(kSize, {1, 1, 1.3}, [&](Vec3i) { return random.whole(0, 900); });
        ElasticScanSettings settings = plain_settings(0.4);
        settings.held_above_hu = 800;
        WritableField field(scan.grid);
        StiffnessMap map(scan, settings, arena, &field);
        ElasticLevels levels(map, 14, true, arena);
        const std::vector<float> before = moduli(map);
        const std::vector<bool> held_before = held_nodes(map);
        for (int n = 0; n < 3; ++n) {
            const Vec3i place{random.whole(0, 26), random.whole(0, 21), random.whole(0, 18)};
            EditMap bricks = edits_near(field, place, random);
            Box3i box{kSize, {0, 0, 0}};
            for (const auto& [coord, edits] : bricks)
                for (int a = 0; a < 3; ++a) {
                    box.begin[a] = std::min(box.begin[a], 8 * coord[a]);
                    box.end[a] = std::max(box.end[a], std::min(8 * coord[a] + 8, kSize[a]));
                }
            exchange(field, bricks);
            map.renew(box, arena);
            levels.renew(box);
            const StiffnessMap anew(scan, settings, arena, &field);
            EXPECT_EQ(moduli(map), moduli(anew));
            EXPECT_NE(moduli(map), before);
            EXPECT_EQ(held_nodes(map), held_nodes(anew));
            is_other_bone = is_other_bone || held_nodes(map) != held_before;
            ElasticLevels others(anew, 14, true, arena);
            for (ElasticLevels* const of : {&levels, &others}) {
                of->reset();
                of->hold(std::vector<HeldNode>{{{13, 11, 9}, {1, 0.5, -0.3}, {}}});
                (void)of->start();
                for (int k = 0; k < 3; ++k) (void)of->iterate();
            }
            std::vector<double> a, b;
            levels.copy_to(a);
            others.copy_to(b);
            EXPECT_EQ(a, b);
        }
    }
    EXPECT_TRUE(is_other_bone);
}

TEST(Edits, ACutCellIsSofterThanAirAndACarvedVoxelIsAir) {
    const TaskArena arena(1);
    const Volume scan = scan_of(kSize, {1, 1, 1}, [](Vec3i) { return 500; });
    WritableField field(scan.grid);
    EditMap bricks;
    BrickEdits& edits = bricks[{0, 0, 0}];
    edits.assign(512, 0);
    edits[std::size_t(field.index_in_brick({4, 4, 4}))] = kCutX;
    edits[std::size_t(field.index_in_brick({1, 1, 1}))] = kVoid;
    exchange(field, bricks);
    const StiffnessMap map(scan, plain_settings(0.4), arena, &field);
    const auto mu = [&](Vec3i cell) {
        float of_cell = 0;
        map.moduli(0, {cell, cell + Vec3i{1, 1, 1}}, 1, 1, &of_cell);
        return of_cell;
    };
    const float whole = mu({10, 10, 10});
    for (const Vec3i cell : {Vec3i{4, 4, 4}, {4, 3, 4}, {4, 3, 3}, {4, 4, 3}})
        EXPECT_EQ(mu(cell), StiffnessMap::kSlit * map.void_mu());
    EXPECT_NEAR(mu({3, 4, 4}) / whole, 1, 1e-6);
    EXPECT_NEAR(mu({5, 4, 4}) / whole, 1, 1e-6);
    EXPECT_NEAR(mu({0, 0, 0}) / whole, 7 / 8.0, 1e-6);
    EXPECT_NEAR(mu({1, 1, 1}) / whole, 7 / 8.0, 1e-6);
    EXPECT_FALSE(map.is_tissue({1, 1, 1}));
    EXPECT_TRUE(map.is_tissue({4, 4, 4}));
}

}  // namespace
}  // namespace pliant::test
