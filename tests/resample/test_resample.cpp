// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Resampling of the deformed lattice to the grid, against analytic results and the twelve
// tetrahedra.
// Covers: field/cell_block.cpp, field/tetrahedra.cpp, resample/fields.cpp,
// resample/node_kernel.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <array>
#include <bit>
#include <set>

#include "chainmail/chainmail_impl.h"
#include "field/tetrahedra.h"
#include "resample/lattices.h"
#include "resample/scatter.h"
#include "support/random.h"

namespace pliant::test {
namespace {

class ResampleTest : public ::testing::TestWithParam<Mapping> {
  protected:
    TaskArena arena{2};
};

std::string name_of(Mapping mapping) {
    return mapping == Mapping::Cells         ? "Cells"
           : mapping == Mapping::CellsScalar ? "CellsScalar"
                                             : "Tetrahedra";
}

INSTANTIATE_TEST_SUITE_P(Mappings, ResampleTest,
                         ::testing::Values(Mapping::Cells, Mapping::CellsScalar,
                                           Mapping::Tetrahedra),
                         [](const auto& mapping) { return name_of(mapping.param); });

TEST_P(ResampleTest, IdentityReturnsTheVolumeBitForBit) {
    Random random(3);
    const Volume volume = make_volume(
        {17, 12, 9}, {1, 1, 2}, [&](Vec3d) { return std::int16_t(random.whole(-1000, 3000)); });
    // Resident bricks without displacements.
    const Lattice lattice = displaced_lattice(volume, {{2, 2, 2}, {9, 9, 7}}, [](Vec3d) {
        return Vec3d{0, 0, 0};
    });
    const Deformed deformed = deform_by_field(volume, lattice, GetParam(), true, arena);
    EXPECT_EQ(deformed.volume.voxels, volume.voxels);
    EXPECT_TRUE(is_empty(deformed.dirty_box));
    EXPECT_EQ(deformed.written_voxels, 0);
}

TEST_P(ResampleTest, ShiftByWholeVoxelsIsExactAndAirComesIn) {
    Random random(4);
    const Volume volume = make_volume({20, 14, 11}, {0.8, 1.25, 2}, [&](Vec3d) {
        return std::int16_t(random.whole(-900, 3000));
    });
    const Lattice lattice = displaced_lattice(volume, {{-12, -12, -12}, {32, 26, 23}}, [](Vec3d) {
        return Vec3d{2 * 0.8, -1 * 1.25, 3 * 2.0};
    });
    const Deformed deformed = deform_by_field(volume, lattice, GetParam(), true, arena);
    EXPECT_EQ(deformed.dirty_box, voxel_box(volume.grid));
    EXPECT_EQ(deformed.gap_voxels, 0);
    for (int z = 0; z < 11; ++z)
        for (int y = 0; y < 14; ++y)
            for (int x = 0; x < 20; ++x) {
                const Vec3i from{x - 2, y + 1, z - 3};
                const float expected =
                    contains(voxel_box(volume.grid), from) ? volume.at(from) : float(kAirHu);
                ASSERT_EQ(deformed.volume.at({x, y, z}), expected);
            }
    EXPECT_NEAR(deformed.inverse_mm[0].z, -6, 1e-5);
}

TEST_P(ResampleTest, RandomAffineMapOfALinearFieldIsAnalytic) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Vec3d spacing{random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 3)};
        const Vec3d slope = random.vector(12);
        const auto field = [&](Vec3d p) { return 300 + dot(slope, p); };
        const Volume volume = make_volume(
            {26, 24, 22}, spacing, [&](Vec3d p) { return std::int16_t(std::lround(field(p))); });
        Mat3d gradient;
        for (auto& column : gradient.columns) column = random.vector(0.12);
        const Vec3d centre{13, 12, 11}, shift = random.vector(2);
        const Lattice lattice =
            displaced_lattice(volume, {{-16, -16, -16}, {42, 40, 38}}, [&](Vec3d p) {
                const Vec3d voxels = gradient * (p - centre) + shift;
                return Vec3d{voxels.x * spacing.x, voxels.y * spacing.y, voxels.z * spacing.z};
            });
        const Deformed deformed = deform_by_field(volume, lattice, GetParam(), true, arena);
        ASSERT_EQ(deformed.gap_voxels, 0);
        Mat3d map = gradient;
        for (int a = 0; a < 3; ++a) map.columns[a][a] += 1;
        int compared = 0;
        for (int z = 0; z < 22; ++z)
            for (int y = 0; y < 24; ++y)
                for (int x = 0; x < 26; ++x) {
                    const Vec3d p{double(x), double(y), double(z)};
                    const Vec3d from = centre + inverse(map) * (p - centre - shift);
                    bool inside = true;
                    for (int a = 0; a < 3; ++a)
                        inside &= from[a] >= 0 && from[a] <= volume.grid.size[a] - 1;
                    if (!inside) continue;
                    ++compared;
                    ASSERT_NEAR(deformed.volume.at({x, y, z}), field(from), 1.0)
                        << x << ' ' << y << ' ' << z;
                    const Vec3i size = deformed.dirty_box.end - deformed.dirty_box.begin;
                    const Vec3i q = Vec3i{x, y, z} - deformed.dirty_box.begin;
                    const Vec3f back =
                        deformed.inverse_mm[std::size_t(q.x + size.x * (q.y + size.y * q.z))];
                    ASSERT_NEAR(back.x, (from.x - p.x) * spacing.x, 1e-4);
                    ASSERT_NEAR(back.z, (from.z - p.z) * spacing.z, 1e-4);
                }
        EXPECT_GT(compared, 6000);
    }
}

TEST_P(ResampleTest, EveryVoxelIsWrittenByRandomPushes) {
    Random random(21);
    Volume volume = make_volume({40, 36, 30}, {1, 0.7, 1.6}, [&](Vec3d p) {
        return std::int16_t(std::lround(smooth_value(p)));
    });
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    for (int n = 0; n < 8; ++n) {
        ASSERT_TRUE(
            tissue
                .push({.point_mm = {random.real(0, 39), random.real(0, 24), random.real(0, 46)},
                       .push_mm = random.vector(8)})
                .ok());
        const Deformed deformed = deform_volume(tissue, GetParam()).value();
        EXPECT_EQ(deformed.gap_voxels, 0);
        EXPECT_GT(deformed.written_voxels, 0);
    }
}

TEST_P(ResampleTest, FoldedLatticeIsFilledWithoutGapsAndTheSameForEveryThreadCount) {
    const Volume volume =
        make_volume({32, 32, 32}, {1, 1, 1}, [](Vec3d p) { return float(smooth_value(p) + 0.25); });
    Random random(8);
    std::vector<Vec3d> offsets(32 * 32 * 32);
    for (auto& offset : offsets) offset = random.vector(0.9);
    const Lattice lattice = displaced_lattice(volume, {{6, 6, 6}, {26, 26, 26}}, [&](Vec3d p) {
        return offsets[voxel_index(volume.grid, {int(p.x), int(p.y), int(p.z)})];
    });
    std::set<std::uint64_t> hashes;
    for (const int threads : {1, 2, 4}) {
        const TaskArena other(threads);
        const Deformed deformed = deform_by_field(volume, lattice, GetParam(), false, other);
        EXPECT_EQ(deformed.gap_voxels, 0);
        hashes.insert(hash_volume(deformed.volume));
    }
    EXPECT_EQ(hashes.size(), 1u);
}

TEST(Resample, CellsAgreeWithTetrahedraOnSmoothData) {
    const TaskArena arena(2);
    const Volume volume = make_volume({48, 48, 40}, {0.9, 0.9, 1.3}, [](Vec3d p) {
        return std::int16_t(std::lround(smooth_value(p)));
    });
    Random random(31);
    for (int n = 0; n < 5; ++n) {
        ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
        ASSERT_TRUE(
            tissue
                .push({.point_mm = {random.real(12, 30), random.real(12, 30), random.real(12, 40)},
                       .push_mm = random.vector(4),
                       .sphere_radius_mm = 3})
                .ok());
        const Deformed cells = deform_volume(tissue, Mapping::Cells, true).value();
        const Deformed tetrahedra = deform_volume(tissue, Mapping::Tetrahedra).value();
        ASSERT_GT(cells.written_voxels, 1000);
        const VectorField back = inverse_field(cells).value();
        float largest = 0;
        for (int z = 0; z < 40; ++z)
            for (int y = 0; y < 48; ++y)
                for (int x = 0; x < 48; ++x) {
                    const Vec3f v = back.vectors_mm[voxel_index(volume.grid, {x, y, z})];
                    const Vec3d from = Vec3d{x + v.x / 0.9, y + v.y / 0.9, z + v.z / 1.3};
                    // Beyond the border the data are air, and not smooth.
                    if (std::min({from.x, from.y, from.z, 47 - from.x, 47 - from.y, 39 - from.z}) <
                        0)
                        continue;
                    largest = std::max(largest, std::abs(cells.volume.at({x, y, z}) -
                                                         tetrahedra.volume.at({x, y, z})));
                }
        EXPECT_LE(largest, 2) << "trial " << n;
    }
}

/// The cell at rest from which voxel p of the dirty box came, and the position in it.
struct RestPlace {
    Vec3d place;                       ///< [voxels]
    std::array<double, 8> values{};    ///< of the scan, at the corners
    std::array<Vec3d, 8> rest, moved;  ///< the corners [voxels]
    Vec3d bend{0, 0, 0};  ///< by how much the cell's trilinear and its piecewise linear map can
                          ///< differ: a quarter of each product of two coordinates, and less than
                          ///< half of that of all three
};

RestPlace rest_place(const ChainMail& tissue, const Deformed& deformed, Vec3i p) {
    const Volume& volume = tissue.volume();
    const Vec3i size = deformed.dirty_box.end - deformed.dirty_box.begin;
    const Vec3i q = p - deformed.dirty_box.begin;
    const Vec3f back = deformed.inverse_mm[std::size_t(q.x + size.x * (q.y + size.y * q.z))];
    RestPlace from{{p.x + double(back.x), p.y + double(back.y), p.z + double(back.z)}, {}, {}, {}};
    const Vec3i low{int(std::floor(from.place.x)), int(std::floor(from.place.y)),
                    int(std::floor(from.place.z))};
    std::array<Vec3d, 8> product{};  // coefficients of the products of coordinates in the set bits
    for (std::size_t c = 0; c < 8; ++c) {
        const Vec3i e = low + Vec3i{int(c & 1), int(c >> 1 & 1), int(c >> 2)};
        from.values[c] = volume.at(e);
        from.rest[c] = {double(e.x), double(e.y), double(e.z)};
        from.moved[c] = from.rest[c] + tissue.displacement_mm(e);
        for (std::size_t set = 0; set < 8; ++set)
            if ((set & c) == c)
                product[set] =
                    product[set] + (std::popcount(set ^ c) % 2 ? -1.0 : 1.0) * from.moved[c];
    }
    for (int a = 0; a < 3; ++a)
        from.bend[a] = std::abs(product[3][a]) / 4 + std::abs(product[5][a]) / 4 +
                       std::abs(product[6][a]) / 4 + std::abs(product[7][a]) / 2;
    return from;
}

TEST(Resample, OnRoughDataEachMappingReadsItsOwnInterpolantAtItsOwnInverse) {
    // Noise identifies the mixed values and their weights: trilinear ones, or a tetrahedron's.
    const TaskArena arena(2);
    Random random(32);
    const Volume volume = make_volume({40, 40, 40}, {1, 1, 1},
                                      [&](Vec3d) { return std::int16_t(random.whole(-100, 250)); });
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    ASSERT_TRUE(tissue.push({.point_mm = {20, 20, 20}, .push_mm = {3, 1, -2}}).ok());
    const Deformed cells = deform_volume(tissue, Mapping::Cells, true).value();
    const Deformed tetrahedra = deform_volume(tissue, Mapping::Tetrahedra, true).value();
    ASSERT_EQ(cells.dirty_box, tetrahedra.dirty_box);
    constexpr double kRounding = 0.51, kExact = 1e-4;
    double most_different = 0, most_bent = 0;
    const Box3i& box = cells.dirty_box;
    for (int a = 0; a < 3; ++a) ASSERT_TRUE(box.begin[a] > 1 && box.end[a] < 39) << "no air";
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x) {
                const Vec3i p{x, y, z};
                const Vec3d voxel{double(x), double(y), double(z)};
                const double a = cells.volume.at(p), b = tetrahedra.volume.at(p);
                const RestPlace trilinear = rest_place(tissue, cells, p);
                ASSERT_NEAR(a, sample_linear(volume, trilinear.place), kRounding);
                const RestPlace linear = rest_place(tissue, tetrahedra, p);
                const auto where = locate_in_tetrahedra(linear.rest, linear.place, 1e-6);
                ASSERT_TRUE(where);
                ASSERT_NEAR(b, combine(*where, linear.values), kRounding);
                const Vec3d miss = combine(*where, linear.moved) - voxel;
                const Vec3d apart = deformed_place(lattice_of(tissue), linear.place) - voxel;
                for (int axis = 0; axis < 3; ++axis) {
                    ASSERT_LE(std::abs(miss[axis]), kExact);
                    ASSERT_LE(std::abs(apart[axis]), linear.bend[axis] + kExact);
                    most_bent = std::max(most_bent, linear.bend[axis]);
                }
                most_different = std::max(most_different, std::abs(a - b));
            }
    EXPECT_GT(most_different, 20) << "the two are told apart";
    EXPECT_GT(most_bent, 0.1) << "and their maps differ";
}

TEST(Resample, DisplacementFieldIsInWorldCoordinates) {
    const TaskArena arena(1);
    Volume volume = make_volume({20, 20, 20}, {1, 1, 1}, [](Vec3d) { return std::int16_t(0); });
    volume.grid.direction = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    const Vec3d point = world_from_voxel(volume.grid, {10.5, 10.5, 10.5});
    ASSERT_TRUE(tissue.push({.point_mm = point, .push_mm = {1, 0.5, -0.25}}).ok());
    const VectorField field = displacement_field(tissue).value();
    EXPECT_EQ(field.kind, FieldKind::Modeling);
    const Vec3f u = field.vectors_mm[voxel_index(volume.grid, {10, 11, 10})];
    EXPECT_NEAR(u.x, 1, 1e-5);
    EXPECT_NEAR(u.y, 0.5, 1e-5);
    EXPECT_NEAR(u.z, -0.25, 1e-5);
    EXPECT_EQ(field.vectors_mm[0], (Vec3f{0, 0, 0}));
    const VectorField back =
        inverse_field(deform_volume(tissue, Mapping::Cells, true).value()).value();
    EXPECT_EQ(back.kind, FieldKind::Resampling);
    const Vec3f v = back.vectors_mm[voxel_index(volume.grid, {11, 10, 10})];
    EXPECT_LT(v.x, -0.2);
}

}  // namespace
}  // namespace pliant::test
