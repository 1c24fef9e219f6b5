// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Products of a lattice against forces by Gauss points; the same bits from the plain and the
// vectorised kernels, and for any planes.
// Covers: elastic/cell_factors.cpp, elastic/sweeps_vector.cpp, elastic/sweeps_plain.cpp.

#include <gtest/gtest.h>

#include <cstring>

#include "elastic/lattices.h"
#include "elastic/level.h"
#include "support/random.h"

namespace pliant::test {
namespace {

class Sweeps : public testing::TestWithParam<std::uint64_t> {
  protected:
    Sweeps() {
        Random random(GetParam());
        m_nu = random.real(0, 0.49);
        const Vec3i size{random.whole(2, 19), random.whole(2, 9), random.whole(2, 9)};
        const Vec3d spacing{random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)};
        m_scan = scan_of(size, spacing, [&](Vec3i) { return random.whole(50, 5000); });
        m_map.emplace(m_scan, plain_settings(m_nu), m_arena);
        const Vec3i nodes = m_map->cells(0) + Vec3i{1, 1, 1};
        m_level.emplace(*m_map, 0, Vec3i{0, 0, 0}, nodes, m_arena);
        m_level->for_each_node([&](Vec3i, std::size_t at) {
            for (std::size_t a = 0; a < 3; ++a) {
                m_level->s[a][at] = float(random.real(-0.3, 0.3));
                m_level->q[a][at] = float(random.real(-1, 1));
            }
        });
    }

    std::vector<float> result(const NodeRows& rows) const {
        std::vector<float> all;
        for (const float* const row : rows) all.insert(all.end(), row, row + m_level->array_size());
        return all;
    }
    LatticeSweep sweep(SweepPass pass, Turning turning) {
        LatticeSweep sweep = m_level->sweep(*m_map);
        sweep.pass = pass;
        sweep.turning = turning;
        sweep.x = m_level->s;
        sweep.out = m_level->t;
        sweep.residual = m_level->q;
        sweep.sum = m_level->e;
        sweep.alpha = 0.3F;
        sweep.beta = 0.7F;
        sweep.dots = m_level->dots.data();
        return sweep;
    }

    double m_nu = 0;
    TaskArena m_arena{1};
    Volume m_scan;
    std::optional<StiffnessMap> m_map;
    std::optional<ElasticLevel> m_level;
};

TEST_P(Sweeps, ForcesAreThoseOfGaussPoints) {
    ElasticLevel& level = *m_level;
    std::vector<Vec3d> expected(level.array_size(), Vec3d{0, 0, 0});
    double largest = 0;
    for (int k = 0; k + 1 < level.nodes.z; ++k)
        for (int j = 0; j + 1 < level.nodes.y; ++j)
            for (int i = 0; i + 1 < level.nodes.x; ++i) {
                const double mu = double(level.mu[level.index({i, j, k})]);
                const double lambda =
                    double(m_map->lambda_per_mu()) * std::max(mu - double(m_map->void_mu()), 0.0);
                Corners u;
                std::array<std::size_t, 8> at;
                for (std::size_t c = 0; c < 8; ++c) {
                    at[c] = level.index({i + int(c & 1), j + int(c >> 1 & 1), k + int(c >> 2)});
                    u[c] = {level.s[0][at[c]], level.s[1][at[c]], level.s[2][at[c]]};
                }
                const Corners forces = gauss_forces(m_scan.grid.spacing_mm, lambda, mu, u);
                for (std::size_t c = 0; c < 8; ++c) {
                    expected[at[c]] = expected[at[c]] + forces[c];
                    largest = std::max(largest, norm(forces[c]));
                }
            }
    AlignedVector<float> workspace(sweep_workspace(level.nodes, level.stride));
    sweep_planes(sweep(SweepPass::Store, Turning::None), 0, level.nodes.z, workspace.data());
    level.for_each_node([&](Vec3i, std::size_t at) {
        for (int a = 0; a < 3; ++a)
            ASSERT_NEAR(double(level.t[std::size_t(a)][at]), expected[at][a], 4e-6 * largest);
    });
}

TEST_P(Sweeps, PlainAndVectorKernelsGiveTheSameBitsForAnyPlanes) {
    ElasticLevel& level = *m_level;
    AlignedVector<float> workspace(sweep_workspace(level.nodes, level.stride));
    LatticeSweep turn = sweep(SweepPass::Store, Turning::Kept);
    turn_planes(turn, level.rotations, 4, 0, level.nodes.z);
    std::array<std::vector<float>, 4> turns;
    for (std::size_t n = 0; n < 4; ++n)
        turns[n].assign(level.rotations.turns[n], level.rotations.turns[n] + level.array_size());
    turn_planes_plain(turn, level.rotations, 4, 0, level.nodes.z);
    for (std::size_t n = 0; n < 4; ++n)
        EXPECT_EQ(std::memcmp(turns[n].data(), level.rotations.turns[n], 4 * turns[n].size()), 0);
    const std::vector<float> before = result(level.q), sum = result(level.e);
    const auto restore = [&] {
        for (std::size_t a = 0; a < 3; ++a) {
            std::memcpy(level.q[a], before.data() + a * level.array_size(), 4 * level.array_size());
            std::memcpy(level.e[a], sum.data() + a * level.array_size(), 4 * level.array_size());
        }
    };
    for (const SweepPass pass : {SweepPass::Store, SweepPass::Residual, SweepPass::Subtract,
                                 SweepPass::Smooth, SweepPass::Direction})
        for (const Turning turning : {Turning::None, Turning::Kept, Turning::Positions}) {
            LatticeSweep s = sweep(pass, turning);
            s.left_out = {{0, 0, 0}, {level.nodes.x / 2, level.nodes.y / 2, level.nodes.z / 2}};
            restore();
            sweep_planes_plain(s, 0, level.nodes.z, workspace.data());
            const auto out = result(level.t), residual = result(level.q), e = result(level.e);
            const auto dots = level.dots;
            restore();
            for (int k = 0; k < level.nodes.z; k += 2)
                sweep_planes(s, k, std::min(k + 2, level.nodes.z), workspace.data());
            EXPECT_EQ(result(level.t), out);
            EXPECT_EQ(result(level.q), residual);
            EXPECT_EQ(result(level.e), e);
            EXPECT_EQ(level.dots, dots);
        }
}

TEST_P(Sweeps, TheSpectrumOfALatticeIsBelowThatOfItsCells) {
    ElasticLevel& level = *m_level;
    AlignedVector<float> workspace(sweep_workspace(level.nodes, level.stride));
    double bound = 0;
    for (int turn = 0; turn < 60; ++turn) {
        LatticeSweep s = sweep(SweepPass::Store, Turning::None);
        sweep_planes(s, 0, level.nodes.z, workspace.data());
        begin_smoothing(level.planes(0, level.nodes.z), 1, level.t, level.p, level.e);
        const double numerator = dot_nodes(level.planes(0, level.nodes.z), level.p, level.t);
        bound = numerator / dot_nodes(level.planes(0, level.nodes.z), level.s, level.t);
        const double size = std::sqrt(dot_nodes(level.planes(0, level.nodes.z), level.p, level.p));
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t n = 0; n < level.array_size(); ++n)
                level.s[a][n] = level.p[a][n] / float(size);
    }
    EXPECT_LE(bound, double(level.spectrum));
    EXPECT_GE(bound, 0.2 * double(level.spectrum));
}

TEST_P(Sweeps, ARotatedLatticeHasNoForces) {
    ElasticLevel& level = *m_level;
    Random random(GetParam() + 100);
    // Up to 60°, which four steps from no rotation resolve.
    const Vec3d axis = random.vector(1);
    const double angle = random.real(0.2, 1.0);
    const Vec3d n = (1 / norm(axis)) * axis;
    const Vec3d& h = m_scan.grid.spacing_mm;
    level.for_each_node([&](Vec3i local, std::size_t at) {
        const Vec3d x{h.x * local.x, h.y * local.y, h.z * local.z};
        const Vec3d turned = std::cos(angle) * x + std::sin(angle) * cross(n, x) +
                             ((1 - std::cos(angle)) * dot(n, x)) * n;
        for (int a = 0; a < 3; ++a) level.s[std::size_t(a)][at] = float(turned[a] - x[a]);
    });
    AlignedVector<float> workspace(sweep_workspace(level.nodes, level.stride));
    const auto force = [&](Turning turning) {
        LatticeSweep s = sweep(SweepPass::Store, turning);
        turn_planes(s, level.rotations, 4, 0, level.nodes.z);
        sweep_planes(s, 0, level.nodes.z, workspace.data());
        double sum = 0;
        level.for_each_node([&](Vec3i, std::size_t at) {
            for (const float* const row : level.t) sum += double(row[at]) * double(row[at]);
        });
        return std::sqrt(sum);
    };
    EXPECT_LT(force(Turning::Positions), 2e-3 * force(Turning::None));
}

INSTANTIATE_TEST_SUITE_P(Seeds, Sweeps, testing::Range<std::uint64_t>(1, 9));

}  // namespace
}  // namespace pliant::test
