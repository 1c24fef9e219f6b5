// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bricks of a field and the blocks of cells around them, against maps of single elements.
// Covers: field/field.cpp, field/cell_block.cpp, field/brick_search.cpp, field/tetrahedra.cpp.

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "field/brick_search.h"
#include "field/cell_block.h"
#include "field/field.h"
#include "field/fixed_point.h"
#include "field/tetrahedra.h"
#include "field/writable_field.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using Key = std::tuple<int, int, int>;

Key key(Vec3i c) {
    return {c.x, c.y, c.z};
}

Vec3i random_coord(Random& random, int low, int high) {
    return {random.whole(low, high), random.whole(low, high), random.whole(low, high)};
}

TEST(BrickIndex, FindsWhatAMapFinds) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Vec3i size{random.whole(1, 4), random.whole(1, 4), random.whole(1, 4)};
        BrickIndex index(size);
        std::map<Key, int> expected;
        const auto find = [&](Vec3i c) {
            const auto found = expected.find(key(c));
            return found == expected.end() ? -1 : found->second;
        };
        const auto is_inside = [&](Vec3i c) {
            return c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < size.x && c.y < size.y && c.z < size.z;
        };
        std::size_t outside = 0;
        for (int step = 0; step < 600; ++step) {
            const Vec3i c = random_coord(random, -3, 6);
            ASSERT_EQ(index.is_inside(c), is_inside(c));
            ASSERT_EQ(index.find(c), find(c));
            if (find(c) >= 0) {
                index.erase(c);
                expected.erase(key(c));
                outside -= !is_inside(c);
            } else {
                index.insert(c, step);
                expected[key(c)] = step;
                outside += !is_inside(c);
            }
            ASSERT_EQ(index.outside_count(), outside);
            const Vec3i at = random_coord(random, -4, 7);
            const auto neighbours = index.find_neighbours(at);
            for (int side = 0; side < 6; ++side) {
                Vec3i next = at;
                next[side / 2] += side % 2 ? 1 : -1;
                ASSERT_EQ(neighbours[std::size_t(side)], find(next)) << "side " << side;
            }
        }
    }
}

/// A field of random displacements of some bricks, in and beyond its grid.
WritableField random_field(Random& random, int brick_size, bool bounded) {
    const Grid grid{.size = random_coord(random, 5, 17),
                    .spacing_mm = {random.real(0.3, 2), random.real(0.3, 2), random.real(0.3, 2)}};
    WritableField field(grid, brick_size, bounded);
    for (int n = 0; n < 9; ++n) {
        const Vec3i coord = random_coord(random, -2, 3);
        FieldBrick& brick = field.brick(field.ensure_brick(coord));
        field.place_at_rest(brick);
        const std::size_t count = std::size_t(field.elements_per_brick());
        for (int k = 0; k < 5; ++k)
            brick.u[std::size_t(random.whole(0, 2))][random.next() % count] =
                units_from_mm(random.real(-3, 3));
        field.written(brick, field.tick());
    }
    return field;
}

TEST(Field, ElementsOfBricksAreNumberedAlongXYAndZ) {
    for (const int size : {2, 3, 4, 5, 8}) {
        const Grid grid{.size = {11, 7, 5}};
        const WritableField bounded(grid, size, true), endless(grid, size);
        EXPECT_EQ(bounded.elements_per_brick(), size * size * size);
        EXPECT_TRUE(bounded.may_have_gaps());
        EXPECT_FALSE(endless.may_have_gaps());
        for (int z = -9; z < 10; ++z)
            for (int y = -9; y < 10; ++y)
                for (int x = -9; x < 14; ++x) {
                    const Vec3i e{x, y, z}, brick = bounded.brick_of(e);
                    Vec3i local;
                    for (int a = 0; a < 3; ++a) {
                        local[a] = e[a] - size * brick[a];
                        ASSERT_TRUE(local[a] >= 0 && local[a] < size);
                    }
                    const int index = local.x + size * local.y + size * size * local.z;
                    ASSERT_EQ(bounded.index_in_brick(e), index);
                    ASSERT_EQ(bounded.element_of(brick, index), e);
                    const bool is_in = x >= 0 && y >= 0 && z >= 0 && x < 11 && y < 7 && z < 5;
                    ASSERT_EQ(bounded.is_void(e), !is_in);
                    ASSERT_FALSE(endless.is_void(e));
                    for (int a = 0; a < 3; ++a) {
                        Vec3i next = e;
                        next[a] += 1;
                        ASSERT_EQ(bounded.is_linked(e, a), is_in && !bounded.is_void(next));
                    }
                }
    }
}

TEST(Field, BricksHaveNeighboursBoundsAndAreDroppedAtRest) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        WritableField field = random_field(random, random.whole(2, 8), false);
        const auto expect_neighbours = [&] {
            field.for_each_brick([&](const FieldBrick& brick) {
                for (int side = 0; side < 6; ++side)
                    ASSERT_EQ(brick.neighbours[std::size_t(side)],
                              field.find_brick(coord_behind(brick, side)));
            });
        };
        expect_neighbours();
        const auto bricks = field.resident_bricks();
        ASSERT_EQ(int(bricks.size()), field.resident_brick_count());
        std::vector<Vec3i> in_order;
        for (const int n : bricks) {
            FieldBrick& brick = field.brick(n);
            in_order.push_back(brick.coord);
            Vec3<Fixed> low{brick.u[0][0], brick.u[1][0], brick.u[2][0]}, high = low;
            for (int e = 0; e < field.elements_per_brick(); ++e) {
                const Vec3<Fixed> u = field.displacement_at(field.element_of(brick.coord, e));
                for (int a = 0; a < 3; ++a) {
                    ASSERT_EQ(u[a], brick.u[std::size_t(a)][e]);
                    low[a] = std::min(low[a], u[a]);
                    high[a] = std::max(high[a], u[a]);
                }
            }
            EXPECT_EQ(brick.u_min, low);
            EXPECT_EQ(brick.u_max, high);
            if (random.whole(0, 1) == 0) continue;
            field.place_at_rest(brick);
            for (auto* u : brick.u) std::fill_n(u, field.elements_per_brick(), 0);
            field.written(brick, field.tick());
        }
        for (std::size_t n = 1; n < in_order.size(); ++n) {
            const Vec3i p = in_order[n - 1], q = in_order[n];
            EXPECT_LT(std::tie(p.z, p.y, p.x), std::tie(q.z, q.y, q.x));
        }
        field.drop_still_bricks();
        field.for_each_brick([](const FieldBrick& brick) { EXPECT_FALSE(is_at_rest(brick)); });
        expect_neighbours();
        for (int n = 0; n < 5; ++n) {  // dropped ones come back
            const Vec3i coord = random_coord(random, -2, 3);
            const int made = field.ensure_brick(coord);
            EXPECT_EQ(field.find_brick(coord), made);
            EXPECT_EQ(field.brick(made).coord, coord);
        }
        expect_neighbours();
        field.drop_all_bricks();
        EXPECT_EQ(field.resident_brick_count(), 0);
        EXPECT_TRUE(field.resident_bricks().empty());
    }
}

TEST(Field, EditsAreKeptWhereThereAreAny) {
    WritableField field(Grid{.size = {40, 8, 8}}, 8);
    const std::size_t none = field.resident_bytes();
    for (const std::uint8_t flag : {kCutX, kVoid}) {
        BrickEdits edits(512, 0);
        edits[511] = flag;
        field.set_edits({2, 0, 0}, edits);
        field.set_edits({0, 0, 0}, edits);
        EXPECT_EQ(field.all_edits().size(), 2u);
        EXPECT_EQ(field.resident_bytes(), none + 1024);
        field.set_edits({2, 0, 0}, BrickEdits(512, 0));
        EXPECT_EQ(field.all_edits().size(), 1u);
        EXPECT_EQ(field.edits_of({2, 0, 0}), nullptr);
        field.set_edits({0, 0, 0}, BrickEdits(512, 0));
        EXPECT_EQ(field.resident_bytes(), none);
    }
}

TEST(Field, DropsTheStillBricksThatWereMadeSinceACount) {
    for (const int older : {0, 1, 3}) {
        WritableField field(Grid{.size = {40, 8, 8}}, 8);
        for (int n = 0; n < older; ++n) (void)field.ensure_brick({n, 0, 0});
        const std::uint64_t count = field.made_count();
        const std::size_t bytes = field.resident_bytes();
        for (int n = 0; n < 4; ++n) (void)field.ensure_brick({n, 1, 0});
        EXPECT_EQ(field.resident_brick_count(), older + 4);
        EXPECT_GT(field.resident_bytes(), bytes + 4 * 3 * 512 * sizeof(Fixed) - 1);
        field.drop_made_since(count);
        EXPECT_EQ(field.resident_brick_count(), older);
        EXPECT_EQ(field.resident_bytes(), bytes);
        for (int n = 0; n < older; ++n) EXPECT_GE(field.find_brick({n, 0, 0}), 0);
    }
}

TEST(CellBlock, HoldsTheElementsOfABrickAndTheNextLayer) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const int size = random.whole(2, 8);
        const WritableField field = random_field(random, size, false);
        const Vec3d per_unit = voxels_per_unit(field.grid());
        const auto listed = cell_blocks(field);
        std::map<Key, int> times;
        for (const Vec3i c : listed) ++times[key(c)];
        for (int n = 0; n < 30; ++n) {
            const Vec3i coord = random_coord(random, -4, 4);
            CellBlock block;
            block.load(field, coord);
            EXPECT_EQ(block.size(), size);
            EXPECT_EQ(block.first_element(), size * coord);
            Vec3<Fixed> low{0, 0, 0}, high{0, 0, 0}, lowest, highest;
            for (int z = 0; z <= size; ++z)
                for (int y = 0; y <= size; ++y)
                    for (int x = 0; x <= size; ++x) {
                        const Vec3i e = size * coord + Vec3i{x, y, z};
                        const Vec3<Fixed> u = field.displacement_at(e);
                        const int index = block.index(x, y, z);
                        ASSERT_EQ(index, x + (size + 1) * (y + (size + 1) * z));
                        ASSERT_EQ(block.displacement(index), u);
                        ASSERT_EQ(block.is_moved(index), u != (Vec3<Fixed>{0, 0, 0}));
                        for (int a = 0; a < 3; ++a) {
                            low[a] = std::min(low[a], u[a]);
                            high[a] = std::max(high[a], u[a]);
                        }
                        if (x == size || y == size || z == size) continue;
                        const auto corners = block.corners(x, y, z);
                        const auto points = deformed_corners(block, corners, per_unit);
                        bool touched = false;
                        for (int c = 0; c < 8; ++c) {
                            const Vec3i offset{c & 1, c >> 1 & 1, c >> 2};
                            const Vec3<Fixed> v = field.displacement_at(e + offset);
                            touched |= v != Vec3<Fixed>{0, 0, 0};
                            const auto corner = std::size_t(c);
                            ASSERT_EQ(corners[corner],
                                      block.index(x + offset.x, y + offset.y, z + offset.z));
                            for (int a = 0; a < 3; ++a)
                                ASSERT_NEAR(
                                    points[corner][a],
                                    offset[a] + mm_from_units(v[a]) / field.grid().spacing_mm[a],
                                    1e-13);
                        }
                        ASSERT_EQ(block.is_touched(index), touched);
                    }
            bound_block(field, coord, lowest, highest);
            bool may_move = false;
            for (int c = 0; c < 8; ++c)
                may_move |= field.find_brick(coord + Vec3i{c & 1, c >> 1 & 1, c >> 2}) >= 0;
            EXPECT_EQ(times[key(coord)], may_move ? 1 : 0);
            for (int a = 0; a < 3; ++a) {
                EXPECT_LE(lowest[a], low[a]);
                EXPECT_GE(highest[a], high[a]);
                EXPECT_TRUE(may_move || (lowest[a] == 0 && highest[a] == 0));
            }
        }
    }
}

TEST(BrickSearch, VisitsEachBrickWithAnElementInTheBoxOnce) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const int size = random.whole(2, 8);
        const WritableField field = random_field(random, size, false);
        PositionBox box;
        const Vec3i first = random_coord(random, -12, 14);
        box.low = moved_position(rest_position(field.grid(), first), {random.whole(-9, 9), 0, 5});
        for (int a = 0; a < 3; ++a)
            box.high[a] = box.low[a] + std::int64_t(random.real(0, 5) * kUnitsPerMm);
        const BrickSearch search(field);
        std::map<Key, int> visits;
        search.for_each_brick(box, [&](Vec3i coord, const PositionBox& own) {
            ++visits[key(coord)];
            for (int a = 0; a < 3; ++a) {
                EXPECT_LE(own.low[a], box.high[a]);
                EXPECT_GE(own.high[a], box.low[a]);
            }
        });
        std::int64_t visited = 0;
        for (const auto& [coord, times] : visits) {
            EXPECT_EQ(times, 1);
            ++visited;
        }
        EXPECT_GE(search.brick_count(box), visited);
        int refused = 0;
        search.for_each_brick(
            box, [](Vec3i, const PositionBox&) { FAIL() << "every brick was refused"; },
            [&](const PositionBox&) { return ++refused < 0; });
        EXPECT_GE(refused, visited);
        for (int z = -30; z < 40; ++z)
            for (int y = -30; y < 40; ++y)
                for (int x = -30; x < 40; ++x) {
                    const Vec3i e{x, y, z};
                    const Position p =
                        moved_position(rest_position(field.grid(), e), field.displacement_at(e));
                    bool is_in = true;
                    for (int a = 0; a < 3; ++a) is_in &= box.low[a] <= p[a] && p[a] <= box.high[a];
                    ASSERT_TRUE(!is_in || visits.count(key(field.brick_of(e))) == 1);
                }
    }
}

TEST(BrickSearch, FindsTheBrickOfAnElementFarFromItsRestPosition) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const WritableField field = random_field(random, random.whole(2, 8), false);
        const BrickSearch search(field);
        field.for_each_brick([&](const FieldBrick& brick) {
            for (int n = 0; n < field.elements_per_brick(); ++n) {
                const Vec3i e = field.element_of(brick.coord, n);
                const Vec3<Fixed> u = field.displacement_at(e);
                if (u == Vec3<Fixed>{0, 0, 0}) continue;
                const Position p = moved_position(rest_position(field.grid(), e), u);
                PositionBox own;
                const auto is_found_at = [&](Position at) {
                    bool is_found = false;
                    search.for_each_brick({at, at}, [&](Vec3i coord, const PositionBox& box) {
                        if (coord != brick.coord) return;
                        is_found = true;
                        own = box;
                    });
                    return is_found;
                };
                ASSERT_TRUE(is_found_at(p));
                // Boxes are closed.
                const Position low = own.low, high = own.high;
                ASSERT_TRUE(is_found_at(low) && is_found_at(high));
                for (int a = 0; a < 3; ++a) {
                    Position below = low, above = high;
                    below[a] -= 1;
                    above[a] += 1;
                    ASSERT_FALSE(is_found_at(below) || is_found_at(above));
                }
            }
        });
    }
}

TEST(Tetrahedra, WeightsGiveThePointBackAndEndAtTheCellsFaces) {
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        std::array<Vec3d, 8> corners;
        for (int c = 0; c < 8; ++c)
            corners[std::size_t(c)] = Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)} +
                                      random.vector(seed % 2 ? 0.2 : 0);
        const Vec3d point{random.real(-0.2, 1.2), random.real(-0.2, 1.2), random.real(-0.2, 1.2)};
        const auto found = locate_in_tetrahedra(corners, point, 0);
        if (seed % 2 == 0) {
            bool is_in = true;
            for (int a = 0; a < 3; ++a) is_in &= point[a] >= 0 && point[a] <= 1;
            EXPECT_EQ(bool(found), is_in);
        }
        if (!found) continue;
        double sum = 0;
        for (const double w : found->weights) {
            EXPECT_GE(w, 0);
            sum += w;
        }
        EXPECT_NEAR(sum, 1, 1e-14);
        EXPECT_LE(norm(combine(*found, corners) - point), 1e-14);
    }
    std::array<Vec3d, 8> cube;
    for (int c = 0; c < 8; ++c)
        cube[std::size_t(c)] = {double(c & 1), double(c >> 1 & 1), double(c >> 2)};
    for (int a = 0; a < 3; ++a)
        for (const double face : {0.0, 1.0}) {
            Vec3d out{0.5, 0.4, 0.3};
            out[a] = face + (face == 0 ? -0.01 : 0.01);  // its centre has the weight −0.02
            EXPECT_TRUE(locate_in_tetrahedra(cube, out, 0.021));
            EXPECT_FALSE(locate_in_tetrahedra(cube, out, 0.019));
        }
}

}  // namespace
}  // namespace pliant::test
