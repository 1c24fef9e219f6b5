// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The voxels that can change, against plain loops over elements; and voxels that stay open between
// updates are written whenever necessary.
// Covers: resample/scatter.cpp, resample/strip_nodes.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "chainmail/check.h"
#include "resample/lattices.h"
#include "resample/scatter.h"
#include "support/random.h"

namespace pliant::test {
namespace {

Volume noise(Random& random, Vec3i size) {
    return make_volume(size, {1, 1, 1},
                       [&](Vec3d) { return std::int16_t(random.whole(-900, 900)); });
}

Box3i random_box(Random& random, Vec3i size, int largest) {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const int length = random.whole(1, std::min(largest, size[a]));
        box.begin[a] = random.whole(0, size[a] - length);
        box.end[a] = box.begin[a] + length;
    }
    return box;
}

template <class Holds>
bool any_around(Vec3i p, int way, const Holds& holds) {
    for (int c = 0; c < 8; ++c)
        if (holds(p + way * Vec3i{c & 1, c >> 1 & 1, c >> 2})) return true;
    return false;
}

TEST(Changeable, CellsAndVoxelsAreThoseOfPlainLoops) {
    std::int64_t changeable = 0;
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const int size = seed % 3 == 0 ? 8 : random.whole(2, 19);
        SCOPED_TRACE("bricks of " + std::to_string(size));
        const TaskArena arena(1 + int(seed % 2));
        const Volume volume = noise(random, {random.whole(8, 30), random.whole(8, 30), 20});
        Lattice lattice(volume, {draeger_law({})}, size, false);
        for (int n = random.whole(1, 5); n > 0; --n)
            displace(lattice, random_box(random, volume.grid.size, 12), [&](Vec3d) {
                // Occasionally only one component moves, or none.
                return double(random.whole(0, 2)) *
                       Vec3d{random.real(0, 0.1), 0, random.real(0, 0.1)};
            });
        for (int n = random.whole(0, 9); n > 0; --n)
            edit(lattice, random_box(random, volume.grid.size, 1).begin, kVoid);
        Motion motion;
        motion.snapshot.take(lattice, {}, arena);
        motion.touched.find(motion.snapshot, size, arena);

        const auto is_altered = [&](Vec3i element) {
            return lattice.displacement_at(element) != Vec3<Fixed>{0, 0, 0} ||
                   lattice.is_void(element);
        };
        const auto is_touched = [&](Vec3i cell) { return any_around(cell, 1, is_altered); };
        const auto can_change = [&](Vec3i voxel) {
            return !any_around(voxel, -1, [&](Vec3i cell) { return !is_touched(cell); });
        };
        const BitLayout<int> layout{size};
        const auto bit = [&](const BitWord* bits, Vec3i p) {
            return (layout.row(bits, p.y, p.z) >> p.x & 1) != 0;
        };
        const Box3i voxels{{-size, -size, -size}, volume.grid.size + Vec3i{size, size, size}};
        const Box3i bricks{{-1, -1, -1}, bricks_of({{0, 0, 0}, voxels.end}, size).end};
        for_each_in(bricks, [&](Vec3i brick) {
            const BitWord* cells = motion.touched.cells(brick);
            AnyBrickBits bits;
            const Share share = motion.touched.changeable(brick, bits.data());
            std::int64_t here = 0;
            for_each_in({{0, 0, 0}, {size, size, size}}, [&](Vec3i p) {
                const Vec3i at = size * brick + p;
                ASSERT_EQ(cells && bit(cells, p), is_touched(at)) << at.x << ' ' << at.y;
                ASSERT_EQ(bit(bits.data(), p), can_change(at)) << at.x << ' ' << at.y;
                here += bit(bits.data(), p);
            });
            EXPECT_TRUE(share != Share::All || here == std::int64_t(size) * size * size);
            EXPECT_EQ(share == Share::None, here == 0);
            changeable += here;
        });
    }
    EXPECT_GT(changeable, 10000);
}

TEST(Changeable, WhatRestsAndMovesAgainIsWrittenEachTime) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(1 + int(seed % 2));
        const Volume volume = noise(random, {75, 30, 30});
        // So far apart that no brick is dirty because of both.
        const Box3i positions[3] = {
            {{3, 4, 5}, {15, 25, 20}}, {{33, 4, 5}, {41, 25, 20}}, {{59, 3, 3}, {72, 20, 25}}};
        Lattice lattice(volume, {draeger_law({})}, 8, false);
        Volume deformed = volume;
        Scatter scatter(volume, arena);
        for (int update = 0; update < 30; ++update) {
            for (const Box3i& place : positions) {
                if (random.whole(0, 2) == 0) continue;
                const double x = random.real(-1, 1), slope = random.real(-0.05, 0.05);
                const double scale = random.whole(0, 3) == 0 ? 0 : 1;
                displace(lattice, place, [&](Vec3d p) {
                    return scale * Vec3d{x + slope * p.y, slope * p.x, 0.1};
                });
            }
            scatter.look(lattice, Mapping::Cells, deformed);
            scatter.write(lattice, Mapping::Cells, deformed, nullptr, {});
            const Deformed once = deform_by_field(volume, lattice, Mapping::Cells, false, arena);
            ASSERT_EQ(deformed.voxels, once.volume.voxels) << "update " << update;
        }
    }
}

TEST(Changeable, WhatTheKernelLeavesOutIsWrittenToo) {
    // Cells five or more voxels wide, none of them folded: along x the tissue is stretched over a
    // short distance, and compressed over a long one.
    const TaskArena arena(2);
    Random random(7);
    const Volume volume = noise(random, {80, 24, 24});
    const Lattice lattice = displaced_lattice(volume, {{8, 6, 6}, {64, 18, 18}}, [](Vec3d p) {
        return Vec3d{std::min(5.5 * (p.x - 8), 22 - 0.45 * (p.x - 12)), 0, 0};
    });
    const auto no_limits = [](Vec3i) { return ElementLimits{}; };
    ASSERT_EQ(check_lattice(lattice, no_limits, arena).folded_cells, 0);
    const Deformed deformed = deform_by_field(volume, lattice, Mapping::Cells, false, arena);
    const Deformed twin = deform_by_field(volume, lattice, Mapping::CellsScalar, false, arena);
    EXPECT_GT(deformed.written_voxels, 5000);
    EXPECT_EQ(deformed.gap_voxels, 0);
    std::int64_t far = 0;
    for_each_in(voxel_box(volume.grid),
                [&](Vec3i p) { far += std::abs(deformed.volume.at(p) - twin.volume.at(p)) > 1; });
    EXPECT_EQ(far, 0);
}

}  // namespace
}  // namespace pliant::test
