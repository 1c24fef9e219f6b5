// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/cell_volume.h"
#include "springs/volume_sweep.h"

namespace pliant {
namespace {

void add_cells(const SweepPlan& plan, const VolumeArrays& a, std::int64_t begin, std::int64_t end) {
    const auto position = [&](std::int32_t local) {
        const double* const at = a.seen + 4 * std::size_t(local);
        return Vec3d{at[0], at[1], at[2]};
    };
    for (std::int64_t p = begin; p < end; ++p) {
        const CellPack pack = plan.cell_packs[std::size_t(p)];
        const double* const values = plan.cell_values.data() + 2 * kPack * p;
        for (int lane = 0; lane < kPack; ++lane) {
            SpringCell cell{.node_count = pack.node_count};
            const auto corner = [&](int n) { return std::size_t(pack.first + kPack * n + lane); };
            for (int n = 0; n < pack.node_count; ++n)
                cell.nodes[std::size_t(n)] = plan.cell_nodes[corner(n)];
            const Vec3d origin = position(cell.nodes[0]);
            Vec3d force[8];
            double volume = 0;
            for (int n = 0; n < pack.node_count; ++n) {
                force[n] = volume_gradient(cell, n, position);
                volume += dot(position(cell.nodes[std::size_t(n)]) - origin, force[n]);
            }
            const double pressure = values[lane] * (volume / 3 / values[kPack + lane] - 1);
            for (int n = 0; n < pack.node_count; ++n)
                for (int c = 0; c < 3; ++c)
                    a.corner_force[4 * corner(n) + std::size_t(c)] = -pressure * force[n][c];
        }
    }
}

void add_nodes(const SweepPlan& plan, const VolumeArrays& a, std::int64_t begin, std::int64_t end) {
    for (std::int64_t l = begin; l < end; ++l) {
        Vec3d sum{a.load[0][l], a.load[1][l], a.load[2][l]};
        for (std::int32_t k = plan.first_corner[std::size_t(l - kPack)];
             k < plan.first_corner[std::size_t(l - kPack + 1)]; ++k) {
            const double* const force =
                a.corner_force + 4 * std::size_t(plan.corners[std::size_t(k)]);
            sum = sum + Vec3d{force[0], force[1], force[2]};
        }
        for (int c = 0; c < 3; ++c) a.force[c][l] = sum[c];
    }
}

}  // namespace

VolumeKernel plain_volume_sweep() {
    return {add_cells, add_nodes};
}

}  // namespace pliant
