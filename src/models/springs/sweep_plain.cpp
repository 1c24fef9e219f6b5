// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <bit>
#include <cmath>

#include "springs/sweep.h"

namespace pliant {
namespace {

/// 1/√q for q > 0; finite for 0.
double reciprocal_root(double q) {
    double y = std::bit_cast<double>(kRootGuess - (std::bit_cast<std::uint64_t>(q) >> 1));
    double e = std::fma(-(q * y), y, 1.0);
    y *= std::fma(e, std::fma(e, kRoot2, kRoot1), kRoot0);
    e = std::fma(-(q * y), y, 1.0);
    return std::fma(e * y, std::fma(e, std::fma(e, 0.3125, 0.375), 0.5), y);
}

/// Adds one link of a lane. @param j  the other end @param block  of the lane
/// @param s  slot and lane
void add_link(const SweepPlan& plan, const SweepArrays& a, std::size_t i, std::size_t j,
              const double* block, std::size_t s, double (&sum)[3]) {
    const double dx = a.x[0][i] - a.x[0][j];
    const double dy = a.x[1][i] - a.x[1][j];
    const double dz = a.x[2][i] - a.x[2][j];
    const double q = std::fma(dz, dz, std::fma(dy, dy, dx * dx));
    const double y = reciprocal_root(q);
    double f = std::fma(block[kPack], y, -block[0]);
    if (plan.damped || plan.branched) {
        const auto moved = [&](int c) {
            return (a.x[c][i] - a.before[c][i]) - (a.x[c][j] - a.before[c][j]);
        };
        const double along = std::fma(dz, moved(2), std::fma(dy, moved(1), dx * moved(0)));
        f = std::fma(-(block[2 * kPack] * along * y), y, f);
    }
    if (plan.branched) {
        const double stretch = std::fma(q, y, -block[3 * kPack]);
        const double pull = std::fma(block[4 * kPack], stretch, -a.branch[s]);
        f = std::fma(-pull, y, f);
        a.next_branch[s] = std::fma(block[5 * kPack], a.branch[s], block[6 * kPack] * stretch);
    }
    sum[0] = std::fma(f, dx, sum[0]);
    sum[1] = std::fma(f, dy, sum[1]);
    sum[2] = std::fma(f, dz, sum[2]);
}

bool sweep(const SweepPlan& plan, const SweepArrays& a, std::int64_t begin, std::int64_t end,
           double farthest2) {
    bool all_near = true;
    for (std::int64_t pack = begin; pack < end; ++pack) {
        const PackSlots& slots = plan.packs[std::size_t(pack)];
        for (int lane = 0; lane < kPack; ++lane) {
            const auto i = std::size_t((pack + 1) * kPack + lane);
            double sum[3] = {a.force[0][i], a.force[1][i], a.force[2][i]};
            for (std::uint32_t s = slots.begin; s < slots.end; ++s) {
                const SweepSlot& slot = plan.slots[s];
                const double* block = plan.blocks.data() + slot.block * plan.block_size() + lane;
                const std::size_t at = kPack * std::size_t(s) + std::size_t(lane);
                const std::size_t j =
                    s < slots.rows_end ? std::size_t(std::int64_t(i) + slot.other)
                                       : std::size_t(plan.others[std::size_t(slot.other + lane)]);
                add_link(plan, a, i, j, block, at, sum);
            }
            double move[3];
            for (int c = 0; c < 3; ++c) {
                move[c] = std::fma(a.push[i], sum[c], a.keep[i] * (a.x[c][i] - a.before[c][i]));
                a.next[c][i] = a.x[c][i] + move[c];
            }
            const double far =
                std::fma(move[2], move[2], std::fma(move[1], move[1], move[0] * move[0]));
            all_near &= far <= farthest2;
        }
    }
    return all_near;
}

}  // namespace

SweepKernel plain_sweep() {
    return sweep;
}

}  // namespace pliant
