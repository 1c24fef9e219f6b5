// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// φ⁻¹ of points, by the three rooms that need it: a field's material points, a warp, the exact map
// of truth. All keep the promise of find_source.h.
// Covers: resample/material_points.cpp.

#include <gtest/gtest.h>
#include <pliant/data/warp.h>

#include <cstdio>
#include <optional>
#include <random>

#include "resample/find_source.h"
#include "resample/lattices.h"
#include "resample/material_points.h"
#include "support/random.h"
#include "truth/exact_map.h"
#include "volume/boxes.h"

namespace pliant::test {
namespace {

std::uint64_t drawn_seed() {
    const std::uint64_t seed = std::random_device()();
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    return seed;
}

/// A scan whose elements are displaced by hand.
class ByHand : public MovingScan {
  public:
    explicit ByHand(Random& random)
        : m_volume(
              make_volume({20, 18, 16}, {0.7, 1.1, 1.6}, [](Vec3d) { return std::int16_t(0); })) {
        m_volume.grid.direction = random.rotation(random.whole(0, 1) == 1);
        m_deformation.emplace(Deformation::create(m_volume.grid).value());
    }
    const Volume& volume() const override { return m_volume; }
    const Deformation& deformation() const override { return *m_deformation; }
    const TaskArena& arena() const override { return m_arena; }
    Deformation& change() { return *m_deformation; }

    /// Displaces the inner elements. @param u_of  displacement of an element [voxels]
    template <class Displacement>
    void displace(const Displacement& u_of) {
        const Grid& grid = m_volume.grid;
        EXPECT_TRUE(m_deformation
                        ->displace({{2, 2, 2}, {18, 16, 14}},
                                   [&](Vec3i e) {
                                       Vec3d u = u_of(e);
                                       for (int a = 0; a < 3; ++a) u[a] *= grid.spacing_mm[a];
                                       return world_from_lattice_vector(grid, u);
                                   })
                        .ok());
    }

  private:
    TaskArena m_arena{1};
    Volume m_volume;
    std::optional<Deformation> m_deformation;
};

/// A shear with noise, without folds: neighbours differ by less than a third of a voxel.
void shear(ByHand& scan, Random& random) {
    const Vec3d along = random.vector(0.9);
    scan.displace([&](Vec3i e) {
        const double far = std::min({e.x - 1, 18 - e.x, e.y - 1, 16 - e.y, e.z - 1, 14 - e.z});
        return 0.15 * far * along + random.vector(0.05);
    });
}

Vec3d random_point(Random& random) {
    return {random.real(-3, 22), random.real(-3, 20), random.real(-3, 18)};
}

TEST(FindSource, ThreeRoomsFindTheMaterialPointToTheirPromise) {
    Random random(drawn_seed());
    int moved = 0;
    for (int n = 0; n < 20; ++n) {
        ByHand scan(random);
        shear(scan, random);
        const Grid& grid = scan.volume().grid;
        MaterialPoints points(scan.deformation().field());
        const auto warp = Warp::create(scan);
        ASSERT_TRUE(warp.ok()) << warp.error().message;
        const truth::ExactMap map(scan.deformation(), scan.arena());
        ASSERT_EQ(map.folded_cells(), 0);
        for (int p = 0; p < 300; ++p) {
            Vec3d rest = random_point(random);
            // Corners, edges and faces of cells, too.
            for (int a = 0; a < 3; ++a)
                if (p & 1 << a) rest[a] = std::round(rest[a]);
            const Vec3d now = points.now(rest);
            moved += norm(now - rest) > 0.1;
            const auto by_field = points.rest(now);
            ASSERT_TRUE(by_field);
            EXPECT_LE(norm(*by_field - rest), kSourceError);
            const auto by_warp = warp->inverse(world_from_voxel(grid, now));
            ASSERT_TRUE(by_warp);
            EXPECT_LE(norm(voxel_from_world(grid, *by_warp) - rest), kSourceError);
            Vec3d by_truth{0, 0, 0};
            ASSERT_EQ(map.source_of(now, now, by_truth), TruthMask::Exact);
            EXPECT_LE(norm(by_truth - rest), kSourceError);
        }
    }
    EXPECT_GT(moved, 600);
}

/// Cells at rest, none of which is in a gap.
struct CellsAtRest {
    bool corners(Vec3i, std::array<Vec3d, 8>&) const { return false; }
    bool is_whole(Vec3i) const { return true; }
};

TEST(FindSource, AWalkReachesEachCellAtRest) {
    for (int n = 0; n < 27; ++n) {
        const Vec3d point{n % 3 - 0.5, n / 3 % 3 - 0.5, n / 9 - 0.5};
        for (const Vec3d from : {point, Vec3d{3.5, 0.5, 0.5}, Vec3d{0.5, -4.5, 9.5}}) {
            CellsAtRest cells;
            const auto found = walk_to_source(cells, point, from);
            ASSERT_TRUE(found.has_value()) << n;
            EXPECT_EQ(*found, point);
        }
    }
}

TEST(FindSource, APointBesideAFaceIsNotMovedOntoIt) {
    Random random(drawn_seed());
    ByHand scan(random);
    shear(scan, random);
    MaterialPoints points(scan.deformation().field());
    for (int n = 0; n < 2000; ++n) {
        Vec3d rest = random_point(random);
        rest[n % 3] = std::round(rest[n % 3]) + random.real(-1, 1) * 1e-7;
        const auto found = points.rest(points.now(rest));
        ASSERT_TRUE(found);
        EXPECT_LE(norm(*found - rest), kSourceError);
    }
}

/// Counts how a map of cells is asked.
struct CountedCells : FieldCells {
    explicit CountedCells(const Field& field) : FieldCells(field) {}
    DisplacementBounds bounds() {
        ++searches;
        return FieldCells::bounds();
    }
    int searches = 0;
};

TEST(FindSource, FromAnywhereInSteepAndFoldedCells) {
    Random random(drawn_seed());
    int searched = 0;
    for (int n = 0; n < 12; ++n) {
        ByHand scan(random);
        scan.displace([&](Vec3i) { return random.vector(n % 2 ? 1.5 : 0.6); });
        CountedCells cells(scan.deformation().field());
        MaterialPoints points(scan.deformation().field());
        for (int p = 0; p < 300; ++p) {
            const Vec3d now = points.now(random_point(random));
            const auto found = find_source(cells, now, random_point(random));
            // Newton's method may miss it in the only cell that holds it, if that is folded.
            if (!found) continue;
            EXPECT_LE(norm(points.now(*found) - now), 10 * kSourceError);
        }
        searched += cells.searches;
    }
    EXPECT_GT(searched, 20);
}

TEST(FindSource, NothingWhereAGapIsAndTheWayBackBesideIt) {
    Random random(drawn_seed());
    for (const bool is_moved : {false, true}) {
        ByHand scan(random);
        const Box3i hole{{8, 7, 6}, {11, 10, 9}};
        ASSERT_TRUE(scan.change()
                        .edit(hole, std::vector<std::uint8_t>(std::size_t(box_count(hole)), kVoid))
                        .ok());
        if (is_moved) {
            scan.displace([](Vec3i) { return Vec3d{0.25, -0.5, 0.125}; });
        }
        MaterialPoints points(scan.deformation().field());
        int gaps = 0;
        for (int n = 0; n < 2000; ++n) {
            const Vec3d rest{random.real(4, 15), random.real(4, 13), random.real(4, 11)};
            const Vec3i cell = floor_of(rest);
            bool is_gap = true;
            for (int a = 0; a < 3; ++a)
                is_gap &= cell[a] >= hole.begin[a] - 1 && cell[a] < hole.end[a];
            const auto found = points.rest(points.now(rest));
            EXPECT_EQ(found.has_value(), !is_gap);
            if (found) {
                EXPECT_LE(norm(*found - rest), kSourceError);
            }
            gaps += is_gap;
        }
        EXPECT_GT(gaps, 50);
    }
}

TEST(FindSource, SteepCellsThatNewtonsMethodLeavesFromTheMiddleAreSolvedFromACorner) {
    Random random(drawn_seed());
    int from_middle = 0, from_corners = 0;  // points that are not found
    for (int n = 0; n < 200000; ++n) {
        std::array<Vec3d, 8> corners;
        for (int c = 0; c < 8; ++c)
            corners[std::size_t(c)] =
                Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)} + random.vector(0.6);
        if (truth::state_of_shape(corners) != truth::CellState::Regular) continue;
        const TrilinearCell map(corners);
        // Far from the middle, and on faces.
        const Vec3d t = real_of({random.whole(0, 1), random.whole(0, 1), random.whole(0, 1)});
        from_middle += !map.locate(map.at(t), kOnFace);
        const auto found = map.locate_from_corners(map.at(t), kOnFace);
        from_corners += !found;
        if (found) {
            EXPECT_LE(norm(*found - t), 10 * kSourceError);
        }
    }
    EXPECT_GT(from_middle, 10);
    EXPECT_LT(10 * from_corners, from_middle);
}

}  // namespace
}  // namespace pliant::test
