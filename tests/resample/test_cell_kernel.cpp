// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vector kernel: the same bits from every instruction set of this machine, agreement with the
// scalar twin, and a correct inverse.

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>

#include "chainmail/chainmail_impl.h"
#include "chainmail/check.h"
#include "chainmail/instances.h"
#include "resample/lattices.h"
#include "resample/scatter.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// Selects one instruction set during its lifetime.
struct OnTarget {
    explicit OnTarget(std::int64_t target) { hwy::GetChosenTarget().Update(target); }
    ~OnTarget() { hwy::GetChosenTarget().DeInit(); }
};

std::vector<std::int64_t> all_targets() {
    std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
    if (targets.empty() || targets.back() != HWY_SCALAR) targets.push_back(HWY_SCALAR);
    return targets;
}

/// Displacements [voxels] of a volume's elements. Their random parts differ between neighbours by
/// up to a bound; all decrease to zero towards the border, as in a deformation.
std::vector<Vec3d> rough_displacements(const Volume& volume, Random& random, double roughness) {
    const Vec3d drift = random.vector(6);
    Mat3d gradient;
    for (auto& column : gradient.columns) column = random.vector(0.15);
    const Vec3i n = volume.grid.size;
    std::vector<Vec3d> u;
    for (int z = 0; z < n.z; ++z)
        for (int y = 0; y < n.y; ++y)
            for (int x = 0; x < n.x; ++x) {
                const Vec3d p{double(x), double(y), double(z)}, own = random.vector(roughness);
                double fade = 1;
                for (int a = 0; a < 3; ++a)
                    fade = std::min({fade, (p[a] - 2) / 12, (n[a] - 3 - p[a]) / 12});
                u.push_back(std::max(0.0, fade) * (drift + gradient * p + own));
            }
    return u;
}

/// The largest Σ_b |∂u_a/∂x_b| of any component a in any cell, each a bound over the cell. Below 1,
/// u is a contraction in the maximum norm, and X + u(X) can't fold.
double steepness_of(const Grid& grid, const std::vector<Vec3d>& u) {
    const Vec3i n = grid.size;
    double steepest = 0;
    for (int z = 0; z + 1 < n.z; ++z)
        for (int y = 0; y + 1 < n.y; ++y)
            for (int x = 0; x + 1 < n.x; ++x) {
                Vec3d sum{0, 0, 0};
                for (int b = 0; b < 3; ++b) {
                    Vec3d largest{0, 0, 0};
                    for (int edge = 0; edge < 4; ++edge) {
                        Vec3i from{x, y, z};
                        from[(b + 1) % 3] += edge & 1;
                        from[(b + 2) % 3] += edge >> 1;
                        Vec3i to = from;
                        ++to[b];
                        const Vec3d step = u[voxel_index(grid, to)] - u[voxel_index(grid, from)];
                        for (int a = 0; a < 3; ++a)
                            largest[a] = std::max(largest[a], std::abs(step[a]));
                    }
                    sum = sum + largest;
                }
                steepest = std::max({steepest, sum.x, sum.y, sum.z});
            }
    return steepest;
}

Lattice lattice_of(const Volume& volume, const std::vector<Vec3d>& u) {
    const Vec3d h = volume.grid.spacing_mm;
    return displaced_lattice(volume, voxel_box(volume.grid), [&](Vec3d p) {
        const Vec3d v = u[voxel_index(volume.grid, {int(p.x), int(p.y), int(p.z)})];
        return Vec3d{v.x * h.x, v.y * h.y, v.z * h.z};
    });
}

Lattice rough_lattice(const Volume& volume, Random& random, double roughness) {
    return lattice_of(volume, rough_displacements(volume, random, roughness));
}

/// The same, with a given steepness: below 1 it can't fold.
Lattice steep_lattice(const Volume& volume, Random& random, double roughness, double steepness) {
    std::vector<Vec3d> u = rough_displacements(volume, random, roughness);
    const double scale = steepness / steepness_of(volume.grid, u);
    for (Vec3d& v : u) v = scale * v;
    return lattice_of(volume, u);
}

Volume random_volume(Random& random) {
    // Named, because the order of evaluation of arguments is unspecified.
    const int nx = random.whole(33, 44), ny = random.whole(30, 41), nz = random.whole(28, 39);
    const double hx = random.real(0.6, 1.5), hy = random.real(0.6, 1.5), hz = random.real(0.8, 2.5);
    return make_volume({nx, ny, nz}, {hx, hy, hz},
                       [&](Vec3d) { return std::int16_t(random.whole(-1000, 2000)); });
}

std::int64_t folded_cells(const Lattice& lattice, const TaskArena& arena) {
    return check_lattice(
               lattice, [](Vec3i) { return ElementLimits{}; }, arena)
        .folded_cells;
}

/// |φ(X) − p| at each voxel p of the dirty box, the largest component [voxels]. Voxels at rest,
/// which are not written, count as well.
std::vector<double> misses_of(const Lattice& lattice, const Deformed& deformed) {
    const Vec3d h = lattice.grid().spacing_mm;
    std::vector<double> misses;
    auto back = deformed.inverse_mm.begin();
    const Box3i& box = deformed.dirty_box;
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x, ++back) {
                const Vec3d from{x + back->x / h.x, y + back->y / h.y, z + back->z / h.z};
                const Vec3d miss =
                    deformed_place(lattice, from) - Vec3d{double(x), double(y), double(z)};
                misses.push_back(std::max({std::abs(miss.x), std::abs(miss.y), std::abs(miss.z)}));
            }
    return misses;
}

double worst_inverse(const Lattice& lattice, const Deformed& deformed) {
    const std::vector<double> misses = misses_of(lattice, deformed);
    return misses.empty() ? 0 : *std::max_element(misses.begin(), misses.end());
}

void expect_same_bits_on_all_targets(const Volume& volume, const Lattice& lattice) {
    const std::vector<std::int64_t> targets = all_targets();
    ASSERT_GE(targets.size(), 2u);
    const TaskArena arena(2);
    const auto deform_on = [&](std::int64_t target) {
        const OnTarget chosen(target);
        return deform_by_field(volume, lattice, Mapping::Cells, true, arena);
    };
    const Deformed expected = deform_on(targets[0]);
    ASSERT_GT(expected.written_voxels, 5000);
    for (const std::int64_t target : targets) {
        const Deformed deformed = deform_on(target);
        EXPECT_EQ(hash_volume(deformed.volume), hash_volume(expected.volume))
            << hwy::TargetName(target);
        EXPECT_TRUE(deformed.inverse_mm == expected.inverse_mm) << hwy::TargetName(target);
    }
}

TEST(CellKernel, EveryTargetGivesTheSameBits) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Volume volume = random_volume(random);
        if (seed % 2)
            volume.voxels = std::vector<float>(std::get<0>(volume.voxels).begin(),
                                               std::get<0>(volume.voxels).end());
        const Lattice lattice = rough_lattice(volume, random, 0.04 * double(seed));
        expect_same_bits_on_all_targets(volume, lattice);
    }
}

TEST(CellKernel, AVoxelDoesNotDependOnThoseInItsVector) {
    // Cells without steps beside cells with several; vectors of other widths mix other cells.
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Volume volume = random_volume(random);
        volume.voxels = std::vector<float>(std::get<0>(volume.voxels).begin(),
                                           std::get<0>(volume.voxels).end());
        std::vector<Vec3d> u = rough_displacements(volume, random, 0);
        for (Vec3d& v : u) v = v + random.vector(random.whole(0, 15) == 0 ? 0.05 : 1e-6);
        const Lattice lattice = lattice_of(volume, u);
        expect_same_bits_on_all_targets(volume, lattice);
    }
}

TEST(CellKernel, AgreesWithItsScalarTwin) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = random_volume(random);
        const Lattice lattice = rough_lattice(volume, random, 0.02 * double(seed));
        const Deformed fast = deform_by_field(volume, lattice, Mapping::Cells, true, arena);
        const Deformed twin = deform_by_field(volume, lattice, Mapping::CellsScalar, true, arena);
        EXPECT_EQ(fast.dirty_box, twin.dirty_box);
        EXPECT_EQ(fast.written_voxels, twin.written_voxels);
        EXPECT_EQ(fast.gap_voxels, 0);
        EXPECT_EQ(twin.gap_voxels, 0);
        double furthest = 0;
        for (std::size_t i = 0; i < fast.inverse_mm.size(); ++i) {
            const Vec3f away = fast.inverse_mm[i] - twin.inverse_mm[i];
            furthest = std::max({furthest, std::abs(double(away.x)), std::abs(double(away.y)),
                                 std::abs(double(away.z))});
        }
        EXPECT_LT(furthest, 1e-3);
        const auto& a = std::get<0>(fast.volume.voxels);
        const auto& b = std::get<0>(twin.volume.voxels);
        int largest = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            largest = std::max(largest, std::abs(a[i] - b[i]));
        EXPECT_LE(largest, 1);
    }
}

TEST(CellKernel, TheInverseIsExactToATenThousandthOfAVoxel) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = random_volume(random);
        const double roughness = random.ratio(0.01, 4), steepness = random.real(0.3, 0.98);
        const Lattice lattice = steep_lattice(volume, random, roughness, steepness);
        ASSERT_EQ(folded_cells(lattice, arena), 0);
        const Deformed deformed = deform_by_field(volume, lattice, Mapping::Cells, true, arena);
        EXPECT_GT(deformed.written_voxels, 5000);
        EXPECT_EQ(deformed.gap_voxels, 0);
        EXPECT_LE(worst_inverse(lattice, deformed), 1e-4);
    }
}

TEST(CellKernel, WhereTheMapFoldsTheInverseIsAsGoodAsTheTwins) {
    // The inverse may not exist; then the twin has none either.
    const TaskArena arena(2);
    int missed = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = random_volume(random);
        const double roughness = random.ratio(0.01, 0.5), steepness = random.real(3, 6);
        const Lattice lattice = steep_lattice(volume, random, roughness, steepness);
        ASSERT_GT(folded_cells(lattice, arena), 0);
        const auto misses = [&](Mapping mapping) {
            return misses_of(lattice, deform_by_field(volume, lattice, mapping, true, arena));
        };
        const std::vector<double> kernel = misses(Mapping::Cells),
                                  twin = misses(Mapping::CellsScalar);
        ASSERT_EQ(kernel.size(), twin.size());
        for (std::size_t i = 0; i < kernel.size(); ++i) {
            ASSERT_LE(kernel[i], twin[i] + 1e-4) << "voxel " << i << " of the dirty box";
            missed += twin[i] > 1e-4;
        }
    }
    EXPECT_GT(missed, 0) << "no map is folded so much that both miss a voxel";
}

TEST(CellKernel, PushedRandomMaterialsLeaveNoHolesAndAnExactInverse) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Instance instance = random_instance(random, 14, 26, false);
        ChainMailSettings settings;
        settings.custom_law = instance.law;
        ChainMail tissue = std::move(ChainMail::create(instance.volume, settings, arena)).value();
        for (int n = 0; n < 3; ++n)
            ASSERT_TRUE(
                tissue.push_elements(random_grab(random, instance.volume.grid), random.vector(2.0))
                    .ok());
        const Deformed deformed = deform_volume(tissue, Mapping::Cells, true).value();
        EXPECT_EQ(deformed.gap_voxels, 0);
        if (tissue.state().folded_cells == 0) {
            EXPECT_LE(worst_inverse(lattice_of(tissue), deformed), 1e-4);
        }
    }
}

TEST(CellKernel, AnAxisAlignedMotionOfPartOfTheScanHasNoHoles) {
    // Faces at rest lie on grid points, which the half-open cells must divide among them.
    const TaskArena arena(2);
    const Volume volume = make_volume(
        {40, 40, 40}, {1, 1, 1}, [](Vec3d p) { return std::int16_t(7 * p.x + 3 * p.y - p.z); });
    for (int axis = 0; axis < 3; ++axis) {
        const Lattice lattice = displaced_lattice(volume, {{8, 8, 8}, {32, 32, 32}}, [&](Vec3d p) {
            Vec3d u{0, 0, 0};
            const double fade = std::min({p.x - 7, p.y - 7, p.z - 7, 32 - p.x, 32 - p.y, 32 - p.z});
            u[axis] = 0.25 * std::min(fade, 8.0);
            return u;
        });
        const Deformed deformed = deform_by_field(volume, lattice, Mapping::Cells, true, arena);
        EXPECT_EQ(deformed.gap_voxels, 0);
        EXPECT_LE(worst_inverse(lattice, deformed), 1e-4);
    }
}

}  // namespace
}  // namespace pliant::test
