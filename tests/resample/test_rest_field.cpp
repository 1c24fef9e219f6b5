// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The field of offsets to rest: against the lattice's own forward displacement, and for raw tissue
// against a search of all elements.
// Covers: resample/control_cuts.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>

#include "base/half.h"
#include "chainmail/chainmail_impl.h"
#include "resample/lattices.h"
#include "resample/random_tissue.h"
#include "support/random.h"

namespace pliant::test {
namespace {

std::vector<std::uint16_t> halves_of(const RestField& field) {
    std::vector<std::uint16_t> halves(4 * std::size_t(node_count({{0, 0, 0}, field.counts()})));
    field.copy({{0, 0, 0}, field.counts()}, halves);
    return halves;
}

Vec3i voxel_of(const RestField& field, Vec3i node) {
    const Vec3i n = field.grid().size;
    return {std::min(kRestStep * node.x, n.x - 1), std::min(kRestStep * node.y, n.y - 1),
            std::min(kRestStep * node.z, n.z - 1)};
}

template <class Visit>
void for_nodes(const RestField& field, const Visit& visit) {
    for (int k = 0; k < field.counts().z; ++k)
        for (int j = 0; j < field.counts().y; ++j)
            for (int i = 0; i < field.counts().x; ++i) {
                const Vec3i v = voxel_of(field, {i, j, k});
                const RestField::Sample sample =
                    field.at(double(kRestStep) * Vec3d{double(i), double(j), double(k)});
                visit(Vec3d{double(v.x), double(v.y), double(v.z)}, sample);
            }
}

Vec3d rest_of(const Grid& grid, Vec3d p, Vec3f u) {
    return voxel_from_world(grid, world_from_voxel(grid, p) - Vec3d{u.x, u.y, u.z});
}

/// Distance to the nearest carved element or cut link, from a search of all of them.
double brute_distance(const Lattice& lattice, Vec3d x) {
    double nearest = 1e9;
    for (const auto& [brick, edits] : lattice.all_edits())
        for (int n = 0; n < int(edits.size()); ++n) {
            if (!edits[std::size_t(n)]) continue;
            const Vec3i e = lattice.element_of(brick, n);
            double away = 0;
            for (int a = 0; a < 3; ++a) {
                const int end = e[a] + (edits[std::size_t(n)] >> a & 1);
                away = std::max(away, std::max(e[a] - x[a], x[a] - end));
            }
            nearest = std::min(nearest, away);
        }
    return nearest;
}

TEST(RestField, LeadsBackToTheElementsThatAreShown) {
    int moved = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(2);
        const Vec3i size{random.whole(30, 50), random.whole(30, 44), random.whole(20, 40)};
        const Volume volume = turned_noise(random, size, {1, random.real(0.6, 1.4), 1.3});
        ChainMail tissue = tissue_of(volume, arena, 8);
        for (int n = 0; n < 5; ++n)
            ASSERT_TRUE(tissue.push(random_push(random, volume.grid, 8)).ok());
        const Deformed deformed = deform_volume(tissue, Mapping::Cells, true).value();
        const RestField field = RestField::create(tissue, deformed).value();
        ASSERT_FALSE(field.at_rest());
        int wrong = 0;
        for_nodes(field, [&](Vec3d p, const RestField::Sample& sample) {
            EXPECT_EQ(sample.raw, 0);
            const Vec3d x = rest_of(volume.grid, p, sample.offset_mm);
            const Vec3d there = deformed_place(lattice_of(tissue), x);
            // Halves have 11 bits; the map may stretch their rounding.
            wrong += norm(there - p) > 0.05;
            moved += norm(x - p) > 0.5;
        });
        EXPECT_EQ(wrong, 0);
    }
    EXPECT_GT(moved, 300);
}

TEST(RestField, UpdatesGiveTheBitsOfAFieldThatIsMadeAnew) {
    int raw_nodes = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(1 + int(seed % 3));
        const Vec3i size{random.whole(30, 50), random.whole(30, 44), random.whole(20, 40)};
        const Volume volume = turned_noise(random, size, {1, random.real(0.6, 1.4), 0.9});
        ChainMail tissue = tissue_of(volume, arena, seed % 3 == 0 ? 5 : 8);
        LiveDeformation live = LiveDeformation::create(tissue).value();
        RestField field(volume.grid);
        const int begin = random.whole(0, 4);
        std::vector<std::uint16_t> before = halves_of(field);
        for (int step = 0; step < 14; ++step) {
            if (step == begin) {
                ASSERT_TRUE(live.keep_sources(true));
                const std::vector<Box3i> all{voxel_box(volume.grid)};
                ASSERT_TRUE(field.update(live, all).ok());
                before = halves_of(field);
            }
            if (step % 3 == 2)
                cut_or_carve(random, tissue);
            else if (step == 10)
                tissue.reset();
            else
                ASSERT_TRUE(tissue.push(random_push(random, volume.grid, 12)).ok());
            const LiveUpdate update = live.update().value();
            if (step < begin) continue;
            const auto changed = field.update(live, update.boxes);
            ASSERT_TRUE(changed.ok());
            const Deformed deformed = deform_volume(tissue, Mapping::Cells, true).value();
            const RestField anew = RestField::create(tissue, deformed).value();
            ASSERT_EQ(halves_of(field), halves_of(anew)) << "step " << step;
            ASSERT_EQ(field.at_rest(), anew.at_rest());
            // All changes lie in the boxes.
            const std::vector<std::uint16_t> now = halves_of(field);
            for (std::size_t n = 0; n < now.size(); ++n) {
                if (now[n] == before[n]) continue;
                const Vec3i c = field.counts();
                const int node = int(n / 4);
                const Vec3i at{node % c.x, node / c.x % c.y, node / c.x / c.y};
                ASSERT_TRUE(std::any_of(changed->begin(), changed->end(),
                                        [&](const Box3i& box) { return contains(box, at); }));
            }
            before = now;
            for (std::size_t n = 3; n < now.size(); n += 4) raw_nodes += now[n] != 0;
        }
    }
    EXPECT_GT(raw_nodes, 1000);
}

TEST(RestField, IsRawAtWhatWasCutOrCarvedAndNowhereElse) {
    int whole = 0, partly = 0, gaps = 0;
    for (std::uint64_t seed = 21; seed <= 24; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(2);
        const Volume volume = turned_noise(random, {40, 36, 33}, {1, 1, 1});
        ChainMail tissue = tissue_of(volume, arena, seed % 2 ? 5 : 8);
        for (int n = 0; n < 4; ++n) {
            cut_or_carve(random, tissue);
            ASSERT_TRUE(tissue.push(random_push(random, volume.grid, 8)).ok());
        }
        const Deformed deformed = deform_volume(tissue, Mapping::Cells, true).value();
        const RestField field = RestField::create(tissue, deformed).value();
        for_nodes(field, [&](Vec3d p, const RestField::Sample& sample) {
            const Vec3d x = rest_of(volume.grid, p, sample.offset_mm);
            const double away = brute_distance(lattice_of(tissue), x);
            const double raw = std::clamp((kRawReach - away) / kRestStep, 0.0, 1.0);
            if (sample.offset_mm == Vec3f{0, 0, 0} && sample.raw == 1 && raw < 1) {
                // An opened gap: its element has left.
                const Vec3d there = deformed_place(lattice_of(tissue), p);
                EXPECT_GT(norm(there - p), 1e-4);
                ++gaps;
                return;
            }
            ASSERT_NEAR(sample.raw, raw, 1e-3);
            whole += raw == 1;
            partly += raw > 0 && raw < 1;
        });
    }
    EXPECT_GT(whole, 100);
    EXPECT_GT(partly, 100);
}

TEST(RestField, ACutIsRawBeforeAnythingOpensItAndTheGapAfterwards) {
    const TaskArena arena(1);
    Random random(6);
    const Volume volume = turned_noise(random, {40, 40, 40}, {1, 1, 1});
    ChainMail tissue = tissue_of(volume, arena, 8);
    LiveDeformation live = LiveDeformation::create(tissue).value();
    ASSERT_TRUE(live.update().ok());
    ASSERT_TRUE(live.keep_sources(true));
    RestField field(volume.grid);
    const auto world = [&](double i, double j, double k) {
        return world_from_voxel(volume.grid, {i, j, k});
    };
    // The plane i = 20.5, across the whole scan.
    ASSERT_TRUE(tissue
                    .cut({.line_mm = {world(20.5, -9, -9), world(20.5, 49, -9)},
                          .depth_mm = world(0, 0, 58) - world(0, 0, 0)})
                    .ok());
    LiveUpdate update = live.update().value();
    EXPECT_TRUE(update.boxes.empty());  // the voxels are unchanged
    EXPECT_FALSE(field.update(live, update.boxes).value().empty());
    EXPECT_EQ(field.at({20, 20, 20}).raw, 1);
    EXPECT_FLOAT_EQ(field.at({16, 20, 20}).raw, 0.5F);
    EXPECT_EQ(field.at({12, 20, 20}).raw, 0);
    EXPECT_EQ(field.at({20, 20, 20}).offset_mm, (Vec3f{0, 0, 0}));
    // One side is pulled away.
    ASSERT_TRUE(tissue
                    .push({.point_mm = world(30, 20, 20),
                           .push_mm = world(12, 0, 0) - world(0, 0, 0),
                           .sphere_radius_mm = 8})
                    .ok());
    update = live.update().value();
    EXPECT_GT(update.gap_voxels, 100);
    ASSERT_TRUE(field.update(live, update.boxes).ok());
    EXPECT_EQ(field.at({24, 20, 20}).raw, 1);
    EXPECT_EQ(field.at({24, 20, 20}).offset_mm, (Vec3f{0, 0, 0}));
    const Deformed deformed = deform_volume(tissue, Mapping::Cells, true).value();
    EXPECT_EQ(halves_of(field), halves_of(RestField::create(tissue, deformed).value()));
    ASSERT_TRUE(tissue.undo().ok());
    ASSERT_TRUE(tissue.undo().ok());
    ASSERT_TRUE(field.update(live, live.update().value().boxes).ok());
    EXPECT_TRUE(field.at_rest());
}

TEST(RestField, StoresNothingAtRest) {
    const TaskArena arena(1);
    Random random(3);
    const Volume volume = turned_noise(random, {21, 20, 9}, {1, 1, 1});
    ChainMail tissue = tissue_of(volume, arena, 8);
    LiveDeformation live = LiveDeformation::create(tissue).value();
    ASSERT_TRUE(live.update().ok());
    ASSERT_TRUE(live.keep_sources(true));
    RestField field(volume.grid);
    EXPECT_EQ(field.counts(), (Vec3i{6, 6, 3}));
    EXPECT_TRUE(field.at_rest());
    const Vec3d middle = world_from_voxel(volume.grid, {10, 10, 4});
    ASSERT_TRUE(tissue.push({.point_mm = middle, .push_mm = {2, 0, 0}}).ok());
    ASSERT_TRUE(field.update(live, live.update().value().boxes).ok());
    EXPECT_FALSE(field.at_rest());
    EXPECT_EQ(field.halves().size(), 4U * 6 * 6 * 3);
    tissue.reset();
    ASSERT_TRUE(field.update(live, live.update().value().boxes).ok());
    EXPECT_TRUE(field.at_rest());
    EXPECT_EQ(field.at({10, 10, 4}).offset_mm, (Vec3f{0, 0, 0}));
}

TEST(RestField, IsTrilinearBetweenNodesAndConstantBeyondThem) {
    const TaskArena arena(1);
    Random random(4);
    const Volume volume = turned_noise(random, {22, 20, 9}, {1, 1, 1});
    ChainMail tissue = tissue_of(volume, arena, 8);
    const Vec3d middle = world_from_voxel(volume.grid, {10, 10, 4});
    ASSERT_TRUE(tissue.push({.point_mm = middle, .push_mm = {4, 1, 2}}).ok());
    const Deformed deformed = deform_volume(tissue, Mapping::Cells, true).value();
    const RestField field = RestField::create(tissue, deformed).value();
    const auto node = [&](int i, int j, int k) {
        const std::size_t n = 4 * (std::size_t(i) + 7 * (std::size_t(j) + 6 * std::size_t(k)));
        return float_from_half(field.halves()[n]);
    };
    ASSERT_EQ(field.counts(), (Vec3i{7, 6, 3}));
    EXPECT_EQ(field.at({8, 8, 4}).offset_mm.x, node(2, 2, 1));
    EXPECT_NEAR(field.at({10, 8, 4}).offset_mm.x, 0.5F * (node(2, 2, 1) + node(3, 2, 1)), 1e-6);
    EXPECT_NEAR(field.at({8, 9, 4}).offset_mm.x, 0.75F * node(2, 2, 1) + 0.25F * node(2, 3, 1),
                1e-6);
    EXPECT_EQ(field.at({8, 8, 100}).offset_mm.x, node(2, 2, 2));
    EXPECT_EQ(field.at({-5, 8, 4}).offset_mm.x, node(0, 2, 1));
    EXPECT_EQ(field.at({std::nan(""), 8, 4}).offset_mm.x, node(0, 2, 1));
}

TEST(RestField, WantsTheInverseOfTheSameGrid) {
    const TaskArena arena(1);
    Random random(5);
    const Volume volume = turned_noise(random, {20, 20, 20}, {1, 1, 1});
    ChainMail tissue = tissue_of(volume, arena, 8);
    const Vec3d middle = world_from_voxel(volume.grid, {10, 10, 10});
    ASSERT_TRUE(tissue.push({.point_mm = middle, .push_mm = {2, 0, 0}}).ok());
    Deformed deformed = deform_volume(tissue).value();
    EXPECT_EQ(RestField::create(tissue, deformed).error().code, ErrorCode::InvalidArgument);
    deformed = deform_volume(tissue, Mapping::Cells, true).value();
    deformed.volume.grid.size.x = 19;
    EXPECT_EQ(RestField::create(tissue, deformed).error().code, ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace pliant::test
