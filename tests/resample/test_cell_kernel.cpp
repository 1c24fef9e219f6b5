// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vector kernel: the same bits from every instruction set that this machine has, the scalar
// twin's answers, and an inverse that is one.

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>

#include "chainmail/check.h"
#include "chainmail/instances.h"
#include "resample/lattices.h"
#include "resample/scatter.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// Chooses one instruction set for as long as it lives.
struct OnTarget {
    explicit OnTarget(std::int64_t target) { hwy::GetChosenTarget().Update(target); }
    ~OnTarget() { hwy::GetChosenTarget().DeInit(); }
};

std::vector<std::int64_t> all_targets() {
    std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
    if (targets.empty() || targets.back() != HWY_SCALAR) targets.push_back(HWY_SCALAR);
    return targets;
}

/// Displacements that differ from element to element by up to a bound [voxels].
Lattice rough_lattice(const Volume& volume, Random& random, double roughness) {
    const Vec3d h = volume.grid.spacing_mm, drift = random.vector(6);
    Mat3d gradient;
    for (auto& column : gradient.columns) column = random.vector(0.15);
    const Vec3i n = volume.grid.size;
    return displaced_lattice(volume, {{3, 2, 4}, {n.x - 3, n.y - 4, n.z - 2}}, [&, n](Vec3d p) {
        // Fades out towards the border, as a deformation does.
        double fade = 1;
        for (int a = 0; a < 3; ++a)
            fade = std::min({fade, (p[a] - 2) / 12, (n[a] - 3 - p[a]) / 12});
        const Vec3d u = std::max(0.0, fade) * (drift + gradient * p + random.vector(roughness));
        return Vec3d{u.x * h.x, u.y * h.y, u.z * h.z};
    });
}

Volume random_volume(Random& random) {
    return make_volume({random.whole(33, 44), random.whole(30, 41), random.whole(28, 39)},
                       {random.real(0.6, 1.5), random.real(0.6, 1.5), random.real(0.8, 2.5)},
                       [&](Vec3d) { return std::int16_t(random.whole(-1000, 2000)); });
}

/// φ(X) for a place X of the lattice at rest [voxels].
Vec3d deformed_place(const Lattice& lattice, Vec3d x) {
    const Vec3i low{int(std::floor(x.x)), int(std::floor(x.y)), int(std::floor(x.z))};
    Vec3d place = x;
    for (int c = 0; c < 8; ++c) {
        const Vec3i corner{c & 1, c >> 1 & 1, c >> 2};
        double weight = 1;
        for (int a = 0; a < 3; ++a) {
            const double t = x[a] - low[a];
            weight *= corner[a] ? t : 1 - t;
        }
        const Vec3<Fixed> u = lattice.displacement_at(low + corner);
        for (int a = 0; a < 3; ++a)
            place[a] += weight * mm_from_units(u[a]) / lattice.grid().spacing_mm[a];
    }
    return place;
}

/// Largest distance |φ(X) − p| of all written voxels [voxels].
double worst_inverse(const Lattice& lattice, const Deformed& deformed) {
    const Vec3d h = lattice.grid().spacing_mm;
    double worst = 0;
    auto back = deformed.inverse_mm.begin();
    const Box3i& box = deformed.dirty_box;
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x, ++back) {
                if (*back == Vec3f{0, 0, 0}) continue;  // at rest
                const Vec3d from{x + back->x / h.x, y + back->y / h.y, z + back->z / h.z};
                const Vec3d miss =
                    deformed_place(lattice, from) - Vec3d{double(x), double(y), double(z)};
                worst = std::max({worst, std::abs(miss.x), std::abs(miss.y), std::abs(miss.z)});
            }
    return worst;
}

TEST(CellKernel, EveryTargetGivesTheSameBits) {
    const std::vector<std::int64_t> targets = all_targets();
    ASSERT_GE(targets.size(), 2u);
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Volume volume = random_volume(random);
        if (seed % 2)
            volume.voxels = std::vector<float>(std::get<0>(volume.voxels).begin(),
                                               std::get<0>(volume.voxels).end());
        const Lattice lattice = rough_lattice(volume, random, 0.04 * double(seed));
        const OnTarget first(targets[0]);
        const Deformed expected = deform_by_lattice(volume, lattice, Mapping::Cells, true, arena);
        ASSERT_GT(expected.written_voxels, 5000);
        for (const std::int64_t target : targets) {
            const OnTarget other(target);
            const Deformed deformed =
                deform_by_lattice(volume, lattice, Mapping::Cells, true, arena);
            EXPECT_EQ(hash_volume(deformed.volume), hash_volume(expected.volume))
                << hwy::TargetName(target);
            EXPECT_TRUE(deformed.inverse_mm == expected.inverse_mm) << hwy::TargetName(target);
        }
    }
}

TEST(CellKernel, AgreesWithItsScalarTwin) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = random_volume(random);
        const Lattice lattice = rough_lattice(volume, random, 0.02 * double(seed));
        const Deformed fast = deform_by_lattice(volume, lattice, Mapping::Cells, true, arena);
        const Deformed twin = deform_by_lattice(volume, lattice, Mapping::CellsScalar, true, arena);
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
    int unfolded = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = random_volume(random);
        const Lattice lattice = rough_lattice(volume, random, 0.02 * double(seed));
        const auto worst = [&](Mapping mapping) {
            return worst_inverse(lattice, deform_by_lattice(volume, lattice, mapping, true, arena));
        };
        // Where the map folds there may be no way to the inverse; then the twin has none either.
        const auto any = [](Vec3i) { return ElementLimits{}; };
        const bool folds = check_lattice(lattice, any, arena).folded_cells > 0;
        EXPECT_LE(worst(Mapping::Cells), folds ? worst(Mapping::CellsScalar) + 1e-4 : 1e-4);
        unfolded += !folds;
    }
    EXPECT_GE(unfolded, 3);
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
        const Deformed deformed = deform_volume(tissue, Mapping::Cells, true);
        EXPECT_EQ(deformed.gap_voxels, 0);
        if (tissue.state().folded_cells == 0) {
            EXPECT_LE(worst_inverse(tissue.lattice(), deformed), 1e-4);
        }
    }
}

TEST(CellKernel, AnAxisAlignedMotionOfPartOfTheScanHasNoHoles) {
    // Faces at rest lie on grid points, which the half-open cells must share out.
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
        const Deformed deformed = deform_by_lattice(volume, lattice, Mapping::Cells, true, arena);
        EXPECT_EQ(deformed.gap_voxels, 0);
        EXPECT_LE(worst_inverse(lattice, deformed), 1e-4);
    }
}

}  // namespace
}  // namespace pliant::test
