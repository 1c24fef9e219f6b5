// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rows of bricks, their reach, and their nodes and cells, against plain loops over elements.
// Covers: resample/strip_nodes.cpp, resample/snapshot.cpp, resample/material_points.cpp,
// resample/find_source.h, resample/open_map.h.

#include "resample/strip_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "field/cell_block.h"
#include "resample/find_source.h"
#include "resample/lattices.h"
#include "resample/material_points.h"
#include "resample/open_map.h"
#include "resample/scatter.h"
#include "support/random.h"
#include "volume/boxes.h"

namespace pliant::test {
namespace {

Vec3i corner_of(int c) {
    return {c & 1, c >> 1 & 1, c >> 2};
}

Volume values(Random& random, Vec3i size) {
    return make_volume(size, {0.8, 1.25, 2},
                       [&](Vec3d) { return std::int16_t(random.whole(-900, 900)); });
}

Box3i random_box_in(Random& random, Vec3i size, int largest) {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const int length = random.whole(1, std::min(largest, size[a]));
        box.begin[a] = random.whole(0, size[a] - length);
        box.end[a] = box.begin[a] + length;
    }
    return box;
}

/// Displaced boxes, carved elements and cut links; some cuts have moved alike on both sides.
void change(Lattice& lattice, Random& random) {
    const Vec3i size = lattice.grid().size;
    for (int n = random.whole(1, 4); n > 0; --n) {
        const Vec3d u = random.vector(3);
        const double rough = random.whole(0, 1) ? 0 : 0.2;
        displace(lattice, random_box_in(random, size, 20),
                 [&](Vec3d) { return u + random.vector(rough); });
    }
    for (int n = random.whole(0, 30); n > 0; --n)
        edit(lattice, random_box_in(random, size, 1).begin,
             std::array{int(kVoid), int(kCutX), int(kCutY),
                        int(kCutZ)}[std::size_t(random.whole(0, 3))]);
}

/// Whether no corner is void, and no link along an edge is cut that its ends have stretched.
bool hangs_together(const Field& field, Vec3i cell) {
    constexpr int kCut[3] = {kCutX, kCutY, kCutZ};
    for (int c = 0; c < 8; ++c)
        if (field.is_void(cell + corner_of(c))) return false;
    for (int axis = 0; axis < 3; ++axis)
        for (int edge = 0; edge < 4; ++edge) {
            Vec3i low = cell;
            low[(axis + 1) % 3] += edge & 1;
            low[(axis + 2) % 3] += edge >> 1;
            Vec3i high = low;
            ++high[axis];
            const BrickEdits* edits = field.edits_of(field.brick_of(low));
            const int flags = edits ? (*edits)[std::size_t(field.index_in_brick(low))] : 0;
            if (flags & kCut[axis] && field.displacement_at(low) != field.displacement_at(high))
                return false;
        }
    return true;
}

TEST(StripNodes, ReachNodesAndCellsAreThoseOfPlainLoops) {
    constexpr int kFar = 1000;
    const std::array<Box3i, 1> everywhere{Box3i{{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}}};
    std::int64_t used = 0, broken = 0, beside = 0;
    for (std::uint64_t seed = 1; seed <= 16; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const int size = seed % 3 == 0 ? 8 : random.whole(2, 18);
        const TaskArena arena(1);
        const Volume volume = values(random, {random.whole(12, 30), random.whole(8, 20), 14});
        const bool bounded = random.whole(0, 1) == 1;
        Lattice lattice(volume, {draeger_law({})}, size, bounded);
        change(lattice, random);
        Motion motion;
        motion.snapshot.take(lattice, {}, arena);
        motion.touched.find(motion.snapshot, size, arena);

        const int bricks = std::max(1, 16 / size);
        const Vec3i last = volume.grid.size - Vec3i{1, 1, 1};
        StripNodes strip;
        for (int bz = -1; bz <= last.z / size; ++bz)
            for (int by = -1; by <= last.y / size; ++by)
                for (int bx = -bricks; bx <= last.x / size; bx += bricks) {
                    const Vec3i coord{bx, by, bz}, first = size * coord;
                    SCOPED_TRACE(std::to_string(bx) + ' ' + std::to_string(by) + ' ' +
                                 std::to_string(bz));
                    // All elements of the bricks that hold corners of the cells.
                    Vec3<Fixed> low = lattice.displacement_at(first), high = low;
                    for_each_in({first, first + size * Vec3i{bricks + 1, 2, 2}}, [&](Vec3i e) {
                        const Vec3<Fixed> u = lattice.displacement_at(e);
                        for (int a = 0; a < 3; ++a) {
                            low[a] = std::min(low[a], u[a]);
                            high[a] = std::max(high[a], u[a]);
                        }
                    });
                    const CellReach reach = motion.touched.reach(volume.grid, coord, bricks);
                    const Vec3i end = first + size * Vec3i{bricks, 1, 1};
                    for (int a = 0; a < 3; ++a) {
                        const double h = volume.grid.spacing_mm[a];
                        ASSERT_NEAR(reach.low[a], first[a] + mm_from_units(low[a]) / h, 1e-9);
                        ASSERT_NEAR(reach.high[a], end[a] + mm_from_units(high[a]) / h, 1e-9);
                    }
                    const bool any = strip.load(motion.snapshot, motion.touched, lattice, volume,
                                                coord, reach, everywhere);
                    bool is_touched = false;
                    for (int x = 0; x < bricks; ++x)
                        is_touched |= motion.touched.cells(coord + Vec3i{x, 0, 0}) != nullptr;
                    ASSERT_EQ(any, is_touched);
                    if (!any) continue;
                    ASSERT_FALSE(strip.is_wild());
                    ASSERT_EQ(strip.size(), size);
                    ASSERT_EQ(strip.cells(), size * bricks);
                    ASSERT_EQ(strip.first_element(), first);
                    int index = 0;
                    for_each_in({{0, 0, 0}, {size * bricks + 1, size + 1, size + 1}}, [&](Vec3i p) {
                        ASSERT_EQ(strip.index(p.x, p.y, p.z), index);
                        ASSERT_EQ(strip.local(index++), p);
                        ASSERT_EQ(strip.displacement(p), lattice.displacement_at(first + p));
                    });
                    const BitLayout<int> layout{size};
                    for_each_in({{0, 0, 0}, {size * bricks, size, size}}, [&](Vec3i p) {
                        const Vec3i cell = first + p;
                        const BitWord* cells =
                            motion.touched.cells(coord + Vec3i{p.x / size, 0, 0});
                        const bool touched =
                            cells && (layout.row(cells, p.y, p.z) >> p.x % size & 1) != 0;
                        bool beyond = false;
                        for (int a = 0; a < 3; ++a) beyond |= cell[a] < 0 || cell[a] >= last[a];
                        const bool whole = hangs_together(lattice, cell);
                        const bool expected = touched && whole && !(bounded && beyond);
                        const RowBits row = strip.use()[std::size_t(p.y + size * p.z)];
                        ASSERT_EQ((row >> p.x & 1) != 0, expected)
                            << cell.x << ' ' << cell.y << ' ' << cell.z;
                        used += expected;
                        broken += touched && !whole;
                        beside += touched && bounded && beyond;
                    });
                }
    }
    EXPECT_GT(used, 1000);
    EXPECT_GT(broken, 100);
    EXPECT_GT(beside, 100);
}

TEST(StripNodes, AStripIsWildIfItsNodesAreFarApartOrTheScanIsHuge) {
    const TaskArena arena(1);
    Random random(1);
    const Volume volume = values(random, {40, 20, 20});
    for (const int size : {3, 8, 20}) {
        SCOPED_TRACE("bricks of " + std::to_string(size));
        Lattice lattice(volume, {draeger_law({})}, size, false);
        displace(lattice, voxel_box(volume.grid), [&](Vec3d) { return random.vector(3); });
        Snapshot snapshot;
        snapshot.take(lattice, {}, arena);
        const int width = std::max(1, 16 / size) * size;
        const CellReach fits{{0, 0, 0}, {width + 64.0, size + 64.0, size + 64.0}};
        const auto frame = [&](const CellReach& reach, Vec3i scan) {
            return frame_of_strip(snapshot, {.size = scan}, size, {0, 0, 0}, reach);
        };
        // The node in the middle is the one to which the others are relative.
        EXPECT_EQ(frame(fits, volume.grid.size).base,
                  lattice.displacement_at({width / 2, size / 2, size / 2}));
        EXPECT_FALSE(frame(fits, volume.grid.size).is_wild);
        for (int a = 0; a < 3; ++a) {
            CellReach wild = fits;
            wild.high[a] += 1e-6;
            EXPECT_TRUE(frame(wild, volume.grid.size).is_wild);
            wild = fits;
            wild.low[a] -= 1e-6;
            EXPECT_TRUE(frame(wild, volume.grid.size).is_wild);
        }
        // Slices that the strip reaches, at most, times the voxels of each.
        const int side = int(std::sqrt(double(INT32_MAX) / (2 * size + 128)));
        EXPECT_FALSE(frame(fits, {side, side, 20}).is_wild);
        EXPECT_TRUE(frame(fits, {side + 1, side + 1, 20}).is_wild);
    }
}

TEST(FieldCells, CornersGapsAndBoundsAreThoseOfPlainLoops) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const int size = random.whole(2, 9);
        const Volume volume = values(random, {18, 15, 12});
        const Vec3d h = volume.grid.spacing_mm;
        Lattice lattice(volume, {draeger_law({})}, size, random.whole(0, 1) == 1);
        if (random.whole(0, 1)) {
            change(lattice, random);
        } else {  // one brick, all of which moves: others are at rest
            const Vec3d u = random.vector(6);
            displace(lattice, {{0, 0, 0}, {size, size, size}}, [&](Vec3d) { return u; });
        }
        FieldCells cells(lattice);
        const Box3i all{{-2, -2, -2}, volume.grid.size + Vec3i{2, 2, 2}};
        Vec3d low{0, 0, 0}, high{0, 0, 0};
        for_each_in(all, [&](Vec3i e) {
            for (int a = 0; a < 3; ++a) {
                const double u = mm_from_units(lattice.displacement_at(e)[a]) / h[a];
                low[a] = std::min(low[a], u);
                high[a] = std::max(high[a], u);
            }
        });
        for (int a = 0; a < 3; ++a) {
            EXPECT_NEAR(cells.bounds().min[a], low[a], 1e-12);
            EXPECT_NEAR(cells.bounds().max[a], high[a], 1e-12);
        }
        for_each_in({all.begin, all.end - Vec3i{1, 1, 1}}, [&](Vec3i cell) {
            std::array<Vec3d, 8> points;
            bool moves = false, whole = true;
            for (int c = 0; c < 8; ++c) {
                const Vec3i e = cell + corner_of(c);
                moves |= lattice.displacement_at(e) != Vec3<Fixed>{0, 0, 0};
                whole &= !lattice.is_void(e);
                for (int a = 0; a < 3; ++a) whole &= corner_of(c)[a] || lattice.is_linked(e, a);
            }
            ASSERT_EQ(cells.corners(cell, points), moves);
            ASSERT_EQ(cells.is_whole(cell), whole);
            for (int c = 0; moves && c < 8; ++c)
                for (int a = 0; a < 3; ++a)
                    ASSERT_NEAR(
                        points[std::size_t(c)][a],
                        corner_of(c)[a] +
                            mm_from_units(lattice.displacement_at(cell + corner_of(c))[a]) / h[a],
                        1e-12);
        });
    }
}

TEST(FieldCells, WriteNothingBeyondThemselves) {
    Random random(5);
    const Volume volume = values(random, {18, 15, 12});
    Lattice lattice(volume, {draeger_law({})}, 4, false);
    displace(lattice, voxel_box(volume.grid), [&](Vec3d) { return random.vector(1); });
    struct Guarded {
        FieldCells cells;
        std::array<std::uint64_t, 4> beyond;
    };
    constexpr std::uint64_t kMark = 0x123456789abcdef0;
    const std::unique_ptr<Guarded> made(
        new Guarded{FieldCells(lattice), {kMark, kMark, kMark, kMark}});
    std::array<Vec3d, 8> points;
    for_each_in(voxel_box(volume.grid), [&](Vec3i cell) { made->cells.corners(cell, points); });
    for (const std::uint64_t mark : made->beyond) EXPECT_EQ(mark, kMark);
}

TEST(FindSource, AUnitCellIsClosedAtBothEndsOfEachAxis) {
    const double places[] = {-0.5, -1e-9, 0, 0.5, 1, 1 + 1e-9, 1.5};
    for (const double x : places)
        for (const double y : places)
            for (const double z : places) {
                const bool inside = std::min({x, y, z}) >= 0 && std::max({x, y, z}) <= 1;
                EXPECT_EQ(is_in_unit_cell({x, y, z}), inside) << x << ' ' << y << ' ' << z;
                // A cell at rest, as a box: the same, with some room beside it.
                std::array<Vec3d, 8> points;
                for (int c = 0; c < 8; ++c) points[std::size_t(c)] = real_of(corner_of(c));
                const bool near = std::min({x, y, z}) >= -1e-9 && std::max({x, y, z}) <= 1 + 1e-9;
                EXPECT_EQ(is_near(points, {x, y, z}), near);
            }
}

TEST(OpenMap, StatesOfBothTurnsAreApart) {
    Turn turn;
    for (int n = 0; n < 4; ++n, turn = turn.other()) {
        const Turn next = turn.other();
        EXPECT_NE(turn.yes(), turn.no());
        EXPECT_EQ(turn.no(), next.yes());
        EXPECT_EQ(turn.yes(), next.no());
        EXPECT_EQ(turn.taken(), next.shared());
        for (const Open open : {turn.yes(), turn.shared()}) {
            EXPECT_TRUE(turn.is_open(open));
            EXPECT_FALSE(next.is_open(open));
        }
        for (const Open open : {turn.no(), turn.taken(), Open::Never})
            EXPECT_FALSE(turn.is_open(open));
        EXPECT_NE(turn.shared(), turn.yes());
        EXPECT_EQ(std::uint8_t(turn.shared()) ^ std::uint8_t(turn.yes()), 4);
    }
}

}  // namespace
}  // namespace pliant::test
