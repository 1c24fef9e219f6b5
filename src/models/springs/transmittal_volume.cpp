// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Forces of the cells' volume energy on a group.

#include "springs/transmittal.h"

namespace pliant {
namespace {

constexpr std::int64_t kCellPacksPerTask = 16, kNodesPerTask = 512, kNodesPerCopy = 16384;

}  // namespace

void Transmittal::see_positions(std::int64_t first, std::int64_t last, const Three& positions,
                                const TaskArena& arena) {
    const struct {
        double* to;
        const double* from[3];
    } job{m_seen.data() + 4 * first,
          {positions[0].data() + first, positions[1].data() + first, positions[2].data() + first}};
    arena.for_each(last - first, kNodesPerCopy, [&job](std::int64_t begin, std::int64_t end) {
        for (std::int64_t l = begin; l < end; ++l)
            for (int c = 0; c < 3; ++c) job.to[4 * l + c] = job.from[c][l];
    });
}

void Transmittal::add_volume_forces(std::size_t group, const TaskArena& arena) {
    const SweepPlan& plan = m_plan->plan;
    const std::int64_t first = (plan.groups[group].begin_pack + 1) * kPack;
    // Earlier groups have already moved.
    if (group == 0)
        see_positions(0, std::int64_t(plan.local_count()), m_x, arena);
    else
        see_positions((plan.groups[group - 1].begin_pack + 1) * kPack, first, m_two_before, arena);
    const struct {
        const SweepPlan& plan;
        VolumeKernel kernel;
        std::int64_t first_pack, first_node;
        VolumeArrays arrays;
    } job{plan,
          m_volume_kernel,
          plan.first_cell_pack[group],
          first,
          {m_seen.data(),
           m_corner_force.data(),
           {m_load[0].data(), m_load[1].data(), m_load[2].data()},
           {m_force[0].data(), m_force[1].data(), m_force[2].data()}}};
    arena.for_each(plan.first_cell_pack[group + 1] - job.first_pack, kCellPacksPerTask,
                   [&job](std::int64_t begin, std::int64_t end) {
                       job.kernel.cells(job.plan, job.arrays, job.first_pack + begin,
                                        job.first_pack + end);
                   });
    arena.for_each(
        std::int64_t(plan.groups[group].end_pack - plan.groups[group].begin_pack) * kPack,
        kNodesPerTask, [&job](std::int64_t begin, std::int64_t end) {
            job.kernel.nodes(job.plan, job.arrays, job.first_node + begin, job.first_node + end);
        });
}

}  // namespace pliant
