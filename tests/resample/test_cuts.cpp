// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cut links and carved elements: the voxels written where the tissue is no longer connected.
// Covers: resample/open_map.cpp.

#include <gtest/gtest.h>
#include <pliant/resample.h>

#include "resample/lattices.h"
#include "resample/scatter.h"
#include "support/random.h"

namespace pliant::test {
namespace {

class CutTest : public ::testing::TestWithParam<Mapping> {
  protected:
    Deformed deform(const Lattice& lattice) {
        return deform_by_field(m_volume, lattice, GetParam(), false, m_arena);
    }
    /// Cuts all links from x = 15 to x = 16, for y and z in 8…24.
    void cut_plane(Lattice& lattice) {
        for (int z = 8; z < 24; ++z)
            for (int y = 8; y < 24; ++y) edit(lattice, {15, y, z}, kCutX);
    }

    TaskArena m_arena{2};
    Volume m_volume = make_volume({32, 32, 32}, {1, 1, 1},
                                  [](Vec3d p) { return std::int16_t(p.x < 15.5 ? 100 : 900); });
};

INSTANTIATE_TEST_SUITE_P(
    Mappings, CutTest, ::testing::Values(Mapping::Cells, Mapping::CellsScalar, Mapping::Tetrahedra),
    [](const auto& mapping) { return "Mapping" + std::to_string(int(mapping.param)); });

TEST_P(CutTest, ACutAtRestChangesNothing) {
    Lattice lattice(m_volume, {draeger_law({})}, 8, false);
    cut_plane(lattice);
    const Deformed deformed = deform(lattice);
    EXPECT_EQ(deformed.volume.voxels, m_volume.voxels);
    EXPECT_EQ(deformed.written_voxels, 0);
    EXPECT_EQ(deformed.dirty_box, Box3i{});
}

TEST_P(CutTest, ACarvedElementAtRestIsAirAndNothingElseChanges) {
    Lattice lattice(m_volume, {draeger_law({})}, 8, false);
    edit(lattice, {10, 11, 12}, kVoid);
    edit(lattice, {7, 8, 8}, kVoid);  // in a brick's corner
    const Deformed deformed = deform(lattice);
    EXPECT_EQ(deformed.gap_voxels, 2);
    for (int z = 0; z < 32; ++z)
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x) {
                const Vec3i p{x, y, z};
                const bool carved = p == Vec3i{10, 11, 12} || p == Vec3i{7, 8, 8};
                ASSERT_EQ(deformed.volume.at(p), carved ? float(kAirHu) : m_volume.at(p));
            }
}

TEST_P(CutTest, AnOpenedCutIsATrueGapAndNothingSmearsAcross) {
    // The block on the high side moves away by four whole voxels, so values stay unchanged.
    Lattice lattice = displaced_lattice(m_volume, {{16, 8, 8}, {24, 24, 24}}, [](Vec3d) {
        return Vec3d{4, 0, 0};
    });
    cut_plane(lattice);
    for (int z = 8; z < 24; ++z)
        for (int y = 8; y < 24; ++y) edit(lattice, {23, y, z}, kCutX);
    const Deformed deformed = deform(lattice);
    for (int y = 10; y < 22; ++y)
        for (int x = 8; x < 28; ++x) {
            const float expected = x <= 15 ? 100 : x < 20 ? kAirHu : 900;
            ASSERT_EQ(deformed.volume.at({x, y, 16}), expected) << x << ' ' << y;
        }
    EXPECT_GE(deformed.gap_voxels, 4 * 14 * 14);
}

TEST_P(CutTest, ACutWhoseSidesMoveTogetherStaysClosed) {
    const auto shift = [](Vec3d p) {
        const double fade = std::min({p.x - 4, p.y - 4, p.z - 4, 28 - p.x, 28 - p.y, 28 - p.z});
        return Vec3d{0, 0.15 * std::clamp(fade, 0.0, 4.0), 0};
    };
    const Lattice whole = displaced_lattice(m_volume, {{5, 5, 5}, {28, 28, 28}}, shift);
    Lattice cut = displaced_lattice(m_volume, {{5, 5, 5}, {28, 28, 28}}, shift);
    for (int z = 12; z < 20; ++z)
        for (int y = 12; y < 20; ++y) edit(cut, {15, y, z}, kCutX);
    const Deformed deformed = deform(cut);
    EXPECT_EQ(deformed.volume.voxels, deform(whole).volume.voxels);
    EXPECT_EQ(deformed.gap_voxels, 0);
}

TEST_P(CutTest, ABoundedLatticePulledFromTheBorderLeavesAir) {
    Lattice lattice(m_volume, {draeger_law({})}, 8, true);
    displace(lattice, {{0, 0, 0}, {12, 32, 32}}, [](Vec3d p) {
        return Vec3d{0.25 * (12 - p.x), 0, 0};
    });
    const Deformed deformed = deform(lattice);
    EXPECT_EQ(deformed.gap_voxels, 3 * 32 * 32);
    EXPECT_EQ(deformed.volume.at({2, 16, 16}), float(kAirHu));
    EXPECT_EQ(deformed.volume.at({3, 16, 16}), 100);
    EXPECT_EQ(deformed.volume.at({3, 0, 31}), 100);
}

TEST(Cuts, LiveUpdatesFollowCutsAndCarvingBitForBit) {
    const TaskArena arena(2);
    Random random(6);
    const Volume volume = make_volume({40, 40, 40}, {1, 1, 1},
                                      [&](Vec3d) { return std::int16_t(random.whole(0, 500)); });
    Lattice lattice(volume, {draeger_law({})}, 8, false);
    Volume live = volume;
    Scatter scatter(volume, arena);
    for (int step = 0; step < 20; ++step) {
        const Vec3i at{random.whole(8, 30), random.whole(8, 30), random.whole(8, 30)};
        if (step % 3 == 0)
            displace(lattice, {at - Vec3i{5, 5, 5}, at + Vec3i{5, 5, 5}},
                     [v = random.vector(1.5)](Vec3d) { return v; });
        else
            for (int n = 0; n < 20; ++n)
                edit(lattice, at + Vec3i{random.whole(-2, 2), random.whole(-2, 2), n % 4},
                     step % 3 == 1 ? kVoid : kCutX << random.whole(0, 2));
        if (step % 7 == 6) lattice.set_edits(lattice.brick_of(at), {});
        scatter.look(lattice, Mapping::Cells, live);
        scatter.write(lattice, Mapping::Cells, live, nullptr, {});
        const Deformed once = deform_by_field(volume, lattice, Mapping::Cells, false, arena);
        ASSERT_EQ(live.voxels, once.volume.voxels) << "step " << step;
    }
}

}  // namespace
}  // namespace pliant::test
