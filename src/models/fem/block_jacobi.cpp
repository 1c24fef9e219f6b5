// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/block_jacobi.h"

namespace pliant {
namespace {

constexpr std::int64_t kBlocksPerTask = 2048;

}  // namespace

/// Inverse by elimination, axis by axis; held components are removed first.
SymmetricBlock free_inverse(const Block3& block, std::uint8_t held) {
    double a[3][3] = {}, inverse[3][3] = {};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const bool both_free = !(held >> i & 1) && !(held >> j & 1);
            a[i][j] = both_free ? block[3 * i + j] : i == j;
            inverse[i][j] = i == j;
        }
    for (int p = 0; p < 3; ++p) {
        const double scale = 1 / a[p][p];
        for (int j = 0; j < 3; ++j) {
            a[p][j] *= scale;
            inverse[p][j] *= scale;
        }
        for (int i = 0; i < 3; ++i) {
            if (i == p) continue;
            const double factor = a[i][p];
            for (int j = 0; j < 3; ++j) {
                a[i][j] -= factor * a[p][j];
                inverse[i][j] -= factor * inverse[p][j];
            }
        }
    }
    for (int i = 0; i < 3; ++i)
        if (held >> i & 1) inverse[i][i] = 0;
    return {inverse[0][0],
            inverse[1][1],
            inverse[2][2],
            (inverse[1][2] + inverse[2][1]) / 2,
            (inverse[2][0] + inverse[0][2]) / 2,
            (inverse[0][1] + inverse[1][0]) / 2};
}

BlockJacobi::BlockJacobi(const Stiffness& stiffness, const HeldNodes& held, const TaskArena& arena,
                         std::int64_t first)
    : m_count(held.axes.size()), m_values(6 * m_count) {
    arena.for_each(
        std::int64_t(m_count), kBlocksPerTask, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t n = begin; n < end; ++n)
                set_block(std::size_t(n), stiffness.diagonal_block(std::int32_t(first + n)),
                          held.axes[std::size_t(n)]);
        });
}

BlockJacobi::BlockJacobi(const BlockJacobi& other, const HeldNodes& old_held,
                         const Stiffness& stiffness, const HeldNodes& held)
    : BlockJacobi(other) {
    for (std::size_t n = 0; n < m_count; ++n)
        if (held.axes[n] != old_held.axes[n])
            set_block(n, stiffness.diagonal_block(std::int32_t(n)), held.axes[n]);
}

void BlockJacobi::set_block(std::size_t node, const Block3& block, std::uint8_t held) {
    const SymmetricBlock inverse = free_inverse(block, held);
    for (std::size_t e = 0; e < 6; ++e) m_values[e * m_count + node] = inverse[e];
}

void BlockJacobi::renew(const NodeVector& from, double factor, double keep, NodeVector& to,
                        const TaskArena& arena) const {
    const double *xx = entry(0), *yy = entry(1), *zz = entry(2), *yz = entry(3), *zx = entry(4),
                 *xy = entry(5);
    const double *x = from.component(0), *y = from.component(1), *z = from.component(2);
    double *px = to.component(0), *py = to.component(1), *pz = to.component(2);
    arena.for_each(from.node_count(), kBlocksPerTask, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) {
            const double vx = xx[n] * x[n] + xy[n] * y[n] + zx[n] * z[n];
            const double vy = xy[n] * x[n] + yy[n] * y[n] + yz[n] * z[n];
            const double vz = zx[n] * x[n] + yz[n] * y[n] + zz[n] * z[n];
            px[n] = factor * vx + keep * px[n];
            py[n] = factor * vy + keep * py[n];
            pz[n] = factor * vz + keep * pz[n];
        }
    });
}

}  // namespace pliant
