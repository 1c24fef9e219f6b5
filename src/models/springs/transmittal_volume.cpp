// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Forces of the cells' volume energy.

#include "springs/transmittal.h"

namespace pliant {
namespace {

constexpr std::int64_t kCellPacksPerTask = 16, kNodesPerTask = 512, kNodesPerCopy = 16384;

}  // namespace

void Transmittal::add_volume_forces(const TaskArena& arena) {
    const SweepPlan& plan = m_plan->plan;
    const struct {
        double* to;
        const double* from[3];
    } copy{m_seen.data(), {m_x[0].data(), m_x[1].data(), m_x[2].data()}};
    arena.for_each(std::int64_t(plan.local_count()), kNodesPerCopy,
                   [&copy](std::int64_t begin, std::int64_t end) {
                       for (std::int64_t l = begin; l < end; ++l)
                           for (int c = 0; c < 3; ++c) copy.to[4 * l + c] = copy.from[c][l];
                   });
    const struct {
        const SweepPlan& plan;
        VolumeKernel kernel;
        VolumeArrays arrays;
    } job{plan,
          m_volume_kernel,
          {m_seen.data(),
           m_corner_force.data(),
           {m_load[0].data(), m_load[1].data(), m_load[2].data()},
           {m_force[0].data(), m_force[1].data(), m_force[2].data()}}};
    arena.for_each(std::int64_t(plan.cell_packs.size()), kCellPacksPerTask,
                   [&job](std::int64_t begin, std::int64_t end) {
                       job.kernel.cells(job.plan, job.arrays, begin, end);
                   });
    arena.for_each(plan.active_end - kPack, kNodesPerTask,
                   [&job](std::int64_t begin, std::int64_t end) {
                       job.kernel.nodes(job.plan, job.arrays, kPack + begin, kPack + end);
                   });
}

}  // namespace pliant
