// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Deformations that are written by hand, against dense arrays, and against a ChainMail's.
// Covers: field/field*.cpp, field/writable_field.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/deformation.h>
#include <pliant/resample.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "field/fixed_point.h"
#include "support/each_allocation.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// Displacements and edits of elements, by ijk.
struct Dense {
    std::map<std::tuple<int, int, int>, Vec3d> u_mm;
    std::map<std::tuple<int, int, int>, int> edits;

    Vec3d displacement_mm(Vec3i e) const {
        const auto found = u_mm.find({e.x, e.y, e.z});
        return found == u_mm.end() ? Vec3d{0, 0, 0} : found->second;
    }
    int edit(Vec3i e) const {
        const auto found = edits.find({e.x, e.y, e.z});
        return found == edits.end() ? 0 : found->second;
    }
};

template <class Visit>
void for_each_of(const Box3i& box, const Visit& visit) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x) visit(Vec3i{x, y, z});
}

Box3i random_box(Random& random) {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        box.begin[a] = random.whole(-12, 30);
        box.end[a] = box.begin[a] + random.whole(1, 14);
    }
    return box;
}

Grid random_grid(Random& random) {
    return {.size = {random.whole(9, 40), random.whole(9, 40), random.whole(9, 40)},
            .spacing_mm = {random.real(0.3, 2), random.real(0.3, 2), random.real(0.3, 2)},
            .origin_mm = random.vector(100),
            .direction = random.rotation(random.whole(0, 1) == 1)};
}

void expect_equal(const Deformation& deformation, const Dense& dense) {
    // Bounds of all that random_box can reach.
    Box3i moved{{99, 99, 99}, {-99, -99, -99}};
    for_each_of({{-13, -13, -13}, {46, 46, 46}}, [&](Vec3i e) {
        const Vec3d expected = dense.displacement_mm(e);
        ASSERT_LE(norm(deformation.displacement_mm(e) - expected), 2 / kUnitsPerMm);
        ASSERT_EQ(deformation.is_void(e), (dense.edit(e) & kVoid) != 0);
        for (int a = 0; a < 3; ++a) {
            Vec3i next = e;
            next[a] += 1;
            const bool linked =
                !(dense.edit(e) & (kCutX << a)) && !((dense.edit(e) | dense.edit(next)) & kVoid);
            ASSERT_EQ(deformation.is_linked(e, a), linked);
        }
        if (norm(expected) < 2 / kUnitsPerMm) return;
        for (int a = 0; a < 3; ++a) {
            moved.begin[a] = std::min(moved.begin[a], e[a]);
            moved.end[a] = std::max(moved.end[a], e[a] + 1);
        }
    });
    if (moved.begin.x < 99)
        EXPECT_EQ(deformation.moved_box(), moved);
    else
        EXPECT_EQ(deformation.moved_box(), Box3i{});
}

TEST(Deformation, WritesAndEditsAreThoseOfDenseArrays) {
    for (int round = 0; round < 12; ++round) {
        const std::uint64_t seed = 20261125 + std::uint64_t(round);
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        auto deformation = Deformation::create(random_grid(random)).value();
        Dense dense;
        for (int step = 0; step < 8; ++step) {
            const std::uint64_t version = deformation.version();
            const Box3i box = random_box(random);
            if (random.whole(0, 2) < 2) {
                std::vector<Vec3d> u;
                const bool to_rest = random.whole(0, 3) == 0;
                for_each_of(box, [&](Vec3i e) {
                    u.push_back(to_rest ? Vec3d{0, 0, 0} : random.vector(20));
                    dense.u_mm[{e.x, e.y, e.z}] = u.back();
                });
                ASSERT_TRUE(deformation.write(box, u).ok());
            } else {
                std::vector<std::uint8_t> flags;
                for_each_of(box, [&](Vec3i e) {
                    flags.push_back(std::uint8_t(random.whole(0, 3) ? 0 : random.whole(0, 15)));
                    dense.edits[{e.x, e.y, e.z}] = flags.back();
                });
                ASSERT_TRUE(deformation.edit(box, flags).ok());
            }
            EXPECT_GT(deformation.version(), version);
        }
        expect_equal(deformation, dense);
        deformation.reset();
        expect_equal(deformation, {});
        EXPECT_EQ(deformation.hash(), Deformation::create(deformation.grid())->hash());
    }
}

TEST(Deformation, HashesAreEqualWhateverTheOrderOfTheWrites) {
    Random random(7);
    const Grid grid = random_grid(random);
    auto at_once = Deformation::create(grid).value(), in_parts = Deformation::create(grid).value();
    const Box3i box{{2, 3, 1}, {25, 22, 20}};
    const auto u = [](Vec3i e) { return Vec3d{0.1 * e.x, std::sin(e.y), -0.3 * e.z}; };
    ASSERT_TRUE(at_once.displace(box, u).ok());
    EXPECT_NE(at_once.hash(), in_parts.hash());
    for (const auto& [from, to] : {std::pair(11, 20), {1, 4}, {4, 11}})
        ASSERT_TRUE(in_parts.displace({{2, 3, from}, {25, 22, to}}, u).ok());
    EXPECT_EQ(at_once.hash(), in_parts.hash());
}

/// A scan with a deformation of one's own.
struct ByHand : MovingScan {
    ByHand(const Volume& v, const TaskArena& a)
        : scan(v), threads(a), moved(Deformation::create(v.grid).value()) {}
    const Volume& volume() const override { return scan; }
    const Deformation& deformation() const override { return moved; }
    const TaskArena& arena() const override { return threads; }
    const Volume& scan;
    const TaskArena& threads;
    Deformation moved;
};

TEST(Deformation, IsResampledLikeTheChainMailThatItWasCopiedFrom) {
    for (const std::uint64_t seed : {3u, 4u, 5u}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(2);
        Volume scan;
        scan.grid = random_grid(random);
        std::vector<std::int16_t> voxels(voxel_count(scan.grid));
        for (auto& v : voxels) v = std::int16_t(random.whole(-300, 250));
        scan.voxels = voxels;
        auto tissue = ChainMail::create(scan, {}, arena).value();
        const Vec3i n = scan.grid.size;
        const Vec3d middle = world_from_voxel(scan.grid, {n.x / 2.0, n.y / 2.0, n.z / 2.0});
        ASSERT_TRUE(
            tissue.push({.point_mm = middle, .push_mm = random.vector(3), .sphere_radius_mm = 3})
                .ok());
        ASSERT_TRUE(tissue.carve({.from_mm = middle, .to_mm = middle, .radius_mm = 1.5}).ok());

        ByHand copy(scan, arena);
        const Deformation& from = tissue.deformation();
        const Box3i box = from.moved_box();
        ASSERT_TRUE(
            copy.moved.displace(box, [&](Vec3i e) { return from.displacement_mm(e); }).ok());
        std::vector<std::uint8_t> edits;
        for_each_of(box, [&](Vec3i e) { edits.push_back(from.is_void(e) ? kVoid : 0); });
        ASSERT_TRUE(copy.moved.edit(box, edits).ok());

        EXPECT_EQ(copy.moved.hash(), tissue.hash());
        const Deformed a = deform_volume(tissue).value(), b = deform_volume(copy).value();
        EXPECT_EQ(a.volume.voxels, b.volume.voxels);
        EXPECT_GT(a.written_voxels, 0);
        EXPECT_EQ(a.gap_voxels, b.gap_voxels);
        const DeformationState state = state_of(copy).value(), twin = tissue.state();
        EXPECT_EQ(state.moved_elements, twin.moved_elements);
        EXPECT_EQ(state.carved_elements, twin.carved_elements);
        EXPECT_EQ(state.folded_cells, twin.folded_cells);
    }
}

TEST(Deformation, ItsStateIsACountOverAllElementsAndCells) {
    std::int64_t folded = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(2);
        Volume scan;
        scan.grid = random_grid(random);
        scan.grid.direction = kIdentity3;
        scan.voxels = std::vector<std::int16_t>(voxel_count(scan.grid));
        ByHand tissue(scan, arena);
        const Box3i box = random_box(random);
        const double most_mm = random.real(0.2, 1);
        ASSERT_TRUE(tissue.moved.displace(box, [&](Vec3i) { return random.vector(most_mm); }).ok());
        std::vector<std::uint8_t> flags;
        for_each_of(box, [&](Vec3i) {
            flags.push_back(std::uint8_t(random.whole(0, 30) ? 0 : random.whole(1, 15)));
        });
        if (seed % 2) {
            ASSERT_TRUE(tissue.moved.edit(box, flags).ok());
        }
        const Deformation& moved = tissue.moved;
        DeformationState expected;
        const Vec3i around{2, 2, 2};
        for_each_of({box.begin - around, box.end + around}, [&](Vec3i e) {
            const double mm = norm(moved.displacement_mm(e));
            expected.moved_elements += mm > 0;
            expected.max_movement_mm = std::max(expected.max_movement_mm, mm);
            expected.carved_elements += moved.is_void(e);
            std::array<Vec3d, 8> p;
            bool is_torn = false;
            for (int c = 0; c < 8; ++c) {
                const Vec3i offset{c & 1, c >> 1 & 1, c >> 2};
                for (int a = 0; a < 3; ++a) {
                    p[std::size_t(c)][a] =
                        scan.grid.spacing_mm[a] * offset[a] + moved.displacement_mm(e + offset)[a];
                    is_torn |= offset[a] == 0 && !moved.is_linked(e + offset, a);
                }
            }
            bool is_folded = false;
            for (int c = 0; c < 8; ++c) {
                Mat3d edges;  // at this corner, each towards a higher index
                for (int a = 0; a < 3; ++a)
                    edges.columns[a] = p[std::size_t(c | 1 << a)] - p[std::size_t(c & ~(1 << a))];
                is_folded |= determinant(edges) <= 0;
            }
            expected.folded_cells += is_folded && !is_torn;
        });
        if (seed % 2)
            for (const std::uint8_t f : flags)
                for (const int cut : {kCutX, kCutY, kCutZ}) expected.cut_links += (f & cut) != 0;
        const DeformationState state = state_of(tissue).value();
        folded += state.folded_cells;
        EXPECT_EQ(state.folded_cells, expected.folded_cells);
        EXPECT_EQ(state.moved_elements, expected.moved_elements);
        EXPECT_EQ(state.carved_elements, expected.carved_elements);
        EXPECT_EQ(state.cut_links, expected.cut_links);
        EXPECT_NEAR(state.max_movement_mm, expected.max_movement_mm, 1e-12);
    }
    EXPECT_GT(folded, 100);
}

TEST(Deformation, TakesNoMoreThan14BytesAnElement) {
    Volume scan;
    scan.grid.size = {64, 64, 64};
    scan.voxels = std::vector<std::int16_t>(voxel_count(scan.grid));
    const TaskArena arena(1);
    ByHand tissue(scan, arena);
    ASSERT_TRUE(tissue.moved.displace(voxel_box(scan.grid),
                                      [](Vec3i) {
                                          return Vec3d{1, 2, 3};
                                      })
                    .ok());
    EXPECT_LE(state_of(tissue)->bytes_per_resident_element, 14);
}

TEST(Deformation, EachEditedElementCountsInTheHash) {
    std::set<std::uint64_t> hashes;
    constexpr int kSide = 10;  // more than a brick
    for (int n = 0; n < kSide * kSide * kSide; ++n) {
        auto deformation = Deformation::create({.size = {kSide, kSide, kSide}}).value();
        const Vec3i e{n % kSide, n / kSide % kSide, n / kSide / kSide};
        const std::uint8_t edits[] = {kVoid};
        ASSERT_TRUE(deformation.edit({e, e + Vec3i{1, 1, 1}}, edits).ok());
        hashes.insert(deformation.hash());
    }
    hashes.insert(Deformation::create({.size = {kSide, kSide, kSide}})->hash());
    EXPECT_EQ(hashes.size(), std::size_t(kSide * kSide * kSide + 1));
}

TEST(Deformation, BadInputIsRefusedInOneLineAndChangesNothing) {
    EXPECT_EQ(Deformation::create({.size = {4, 0, 4}}).error().message,
              "deformation: expected a grid of at least one voxel along each axis, found 0");
    auto deformation = Deformation::create({.size = {9, 9, 9}}).value();
    const Box3i box{{0, 0, 0}, {2, 1, 1}};
    ASSERT_TRUE(deformation.write(box, std::vector<Vec3d>{{1, 0, 0}, {2, 0, 0}}).ok());
    const std::uint64_t before = deformation.hash();
    EXPECT_EQ(deformation.write(box, std::vector<Vec3d>(3)).error().message,
              "deformation: expected displacements of 2 elements, found 3");
    EXPECT_EQ(deformation.edit(box, std::vector<std::uint8_t>(1)).error().message,
              "deformation: expected edits of 2 elements, found 1");
    for (const double wrong : {501.0, std::numeric_limits<double>::quiet_NaN()}) {
        const auto status = deformation.write(box, std::vector<Vec3d>{{0, 0, 0}, {0, wrong, 0}});
        EXPECT_EQ(status.error().code, ErrorCode::InvalidArgument);
        EXPECT_EQ(status.error().message.find('\n'), std::string::npos);
    }
    EXPECT_EQ(deformation.hash(), before);
}

TEST(Deformation, AWriteWithoutMemoryChangesNothing) {
    const auto make = [] {
        auto made =
            std::make_unique<Deformation>(Deformation::create({.size = {40, 40, 40}}).value());
        EXPECT_TRUE(made->displace({{0, 0, 0}, {9, 9, 9}},
                                   [](Vec3i) {
                                       return Vec3d{1, 0, 0};
                                   })
                        .ok());
        return made;
    };
    const auto hash = [](const Deformation& deformation) { return deformation.hash(); };
    const std::vector<Vec3d> u(20 * 20 * 20, Vec3d{0, 3, 0});
    const std::vector<std::uint8_t> cuts(20 * 20 * 20, std::uint8_t(kCutX));
    const Box3i box{{4, 4, 4}, {24, 24, 24}};
    EXPECT_GT(fail_each_allocation(
                  make, [&](Deformation& d) { return d.write(box, u); }, hash)
                  .failed,
              3);
    EXPECT_GT(fail_each_allocation(
                  make, [&](Deformation& d) { return d.edit(box, cuts); }, hash)
                  .failed,
              3);
}

}  // namespace
}  // namespace pliant::test
