// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Forces of the cells' volume energy on a group: first per cell, then per node, so that sums have a
// fixed order for any number of threads.

#include "springs/cell_volume.h"
#include "springs/transmittal.h"

namespace pliant {
namespace {

constexpr std::int64_t kCellsPerTask = 128, kNodesPerTask = 512;

}  // namespace

void Transmittal::add_volume_forces(std::size_t group, const TaskArena& arena) {
    const SweepPlan& plan = m_plan->plan;
    const auto first_cell = plan.first_group_cell[group];
    // Earlier groups have already moved.
    const std::int32_t first_local = (plan.groups[group].begin_pack + 1) * kPack;
    const auto place = [this, first_local](std::int32_t l) {
        const auto n = std::size_t(l);
        const Three& x = l < first_local ? m_two_before : m_x;
        return Vec3d{x[0][n], x[1][n], x[2][n]};
    };
    const struct {
        Transmittal& own;
        const SweepPlan& plan;
        const decltype(place)& place_of;
        std::int32_t first;
    } job{*this, plan, place, first_cell};
    arena.for_each(
        plan.first_group_cell[group + 1] - first_cell, kCellsPerTask,
        [&job](std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin; i < end; ++i) {
                const auto c = std::size_t(job.plan.group_cells[std::size_t(job.first + i)]);
                const SweepCell& cell = job.plan.cells[c];
                Vec3d* const force = job.own.m_corner_force.data() + 8 * c;
                const Vec3d origin = job.place_of(cell.cell.nodes[0]);
                double volume = 0;
                for (int n = 0; n < cell.cell.node_count; ++n) {
                    force[n] = volume_gradient(cell.cell, n, job.place_of);
                    volume += dot(job.place_of(cell.cell.nodes[std::size_t(n)]) - origin, force[n]);
                }
                const double pressure = cell.cell.bulk * (volume / 3 / cell.rest_volume - 1);
                for (int n = 0; n < cell.cell.node_count; ++n) force[n] = -pressure * force[n];
            }
        });
    const struct {
        Transmittal& own;
        const SweepPlan& plan;
        std::int64_t first;
    } gather{*this, plan, std::int64_t(plan.groups[group].begin_pack + 1) * kPack};
    arena.for_each(
        std::int64_t(plan.groups[group].end_pack - plan.groups[group].begin_pack) * kPack,
        kNodesPerTask, [&gather](std::int64_t begin, std::int64_t end) {
            for (std::int64_t l = gather.first + begin; l < gather.first + end; ++l) {
                const auto n = std::size_t(l);
                Vec3d sum{gather.own.m_load[0][n], gather.own.m_load[1][n],
                          gather.own.m_load[2][n]};
                for (std::int32_t k = gather.plan.first_corner[n - kPack];
                     k < gather.plan.first_corner[n - kPack + 1]; ++k) {
                    const CellCorner& corner = gather.plan.corners[std::size_t(k)];
                    sum = sum +
                          gather.own.m_corner_force[std::size_t(8 * corner.cell + corner.corner)];
                }
                for (std::size_t c = 0; c < 3; ++c) gather.own.m_force[c][n] = sum[int(c)];
            }
        });
}

}  // namespace pliant
