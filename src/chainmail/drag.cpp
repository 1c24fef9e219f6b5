// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/drag.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <new>

namespace pliant {
namespace {

constexpr std::int64_t kBricksPerTask = 32;

Fixed sign_of(Fixed step) {
    return step < 0 ? -1 : 1;
}

}  // namespace

bool Drag::pick(Lattice& lattice, std::span<const ElementRef> grabbed, Fixed reach,
                const SweepKernels& kernels, const TaskArena& arena, int max_bricks,
                SweepWork& work) {
    m_reach = reach;
    m_offset = m_lowest = m_highest = {0, 0, 0};
    m_bricks.clear();
    m_place_of.clear();
    m_used = 0;
    for (const Fixed sign : {1, -1}) {
        const Vec3<Fixed> shift{sign * reach, sign * reach, sign * reach};
        const bool fits =
            propagate_by_sweeps(lattice, grabbed, shift, kernels, arena, max_bricks, work);
        if (fits) keep(lattice, work, sign);
        discard_raises(lattice, work);
        if (!fits) {
            lattice.drop_still_bricks(work.touched);
            let_go(lattice);
            return false;
        }
        if (work.shared) break;
    }
    look_at_bricks(lattice, kernels, arena);
    return true;
}

void Drag::keep(const Lattice& lattice, const SweepWork& work, Fixed sign) {
    m_place_of.resize(std::size_t(lattice.brick_index_bound()), -1);
    for (const int index : work.touched) {
        int& place = m_place_of[std::size_t(index)];
        if (place < 0) {
            place = int(m_bricks.size());
            m_bricks.push_back({index, {}, {}});
        }
        keep_brick(lattice, m_bricks[std::size_t(place)], work, sign);
    }
}

void Drag::keep_brick(const Lattice& lattice, FieldBrick& field, const SweepWork& work,
                      Fixed sign) {
    const Brick& brick = lattice.brick(field.index);
    if (work.shared) {
        if (brick.reached[0]) field.raised.fill(brick.raised[0]);
        return;
    }
    const auto count = std::size_t(lattice.elements_per_brick());
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        if (!brick.reached[c]) continue;
        const Fixed* raised = brick.raised[c];
        if (sign > 0) {
            Fixed* copy = take_memory(count);
            std::copy_n(raised, count, copy);
            raised = copy;
        }
        field.raised[direction_of(a, sign)] = raised;
    }
}

Fixed* Drag::take_memory(std::size_t count) {
    if (m_used == m_memory.size()) {
        m_array_bytes = (count * sizeof(Fixed) + 63) / 64 * 64;
        m_memory.emplace_back(static_cast<Fixed*>(std::aligned_alloc(64, m_array_bytes)));
        if (!m_memory.back()) throw std::bad_alloc();
    }
    return m_memory[m_used++].get();
}

void Drag::look_at_bricks(Lattice& lattice, const SweepKernels& kernels, const TaskArena& arena) {
    m_bone = {};
    m_reach_elements = 0;
    std::mutex mutex;
    const auto look = [&](std::int64_t begin, std::int64_t end) {
        std::array<Fixed, 6> bone{};
        std::int64_t reached = 0;
        for (std::int64_t k = begin; k < end; ++k) {
            FieldBrick& field = m_bricks[std::size_t(k)];
            // Everybody else may read the displacements of every brick that is there.
            Brick& brick = lattice.brick(field.index);
            if (brick.is_unplaced) lattice.place_at_rest(brick);
            for (std::size_t d = 0; d < 6; ++d) {
                const Fixed* raised = field.raised[d];
                if (d > 0 && raised == field.raised[d - 1])
                    field.highest[d] = field.highest[d - 1];
                else if (raised)
                    field.highest[d] = kernels.largest(raised, lattice.elements_per_brick());
            }
            bound_travel(lattice, brick, field, bone);
            reached += count_reached(lattice, brick, field);
        }
        const std::lock_guard lock(mutex);
        for (std::size_t d = 0; d < 6; ++d) m_bone[d] = std::max(m_bone[d], bone[d]);
        m_reach_elements += reached;
    };
    arena.for_each(std::int64_t(m_bricks.size()), kBricksPerTask, std::ref(look));
}

void Drag::bound_travel(const Lattice& lattice, const Brick& brick, const FieldBrick& field,
                        std::array<Fixed, 6>& bone) const {
    if (!(brick.traits & kFixedTrait)) return;
    const std::uint8_t* traits = lattice.materials().traits();
    for (int n = 0; n < lattice.elements_per_brick(); ++n) {
        if (!(traits[brick.material[n]] & kFixedTrait)) continue;
        for (std::size_t d = 0; d < 6; ++d) {
            if (!field.raised[d]) continue;
            const Fixed u = brick.u[d / 2][n];
            bone[d] = std::max(bone[d], field.raised[d][n] - (d % 2 ? u : -u));
        }
    }
}

std::int64_t Drag::count_reached(const Lattice& lattice, const Brick& brick,
                                 const FieldBrick& field) const {
    const int count = lattice.elements_per_brick();
    static thread_local std::vector<unsigned char> reached;
    reached.assign(std::size_t(count), 0);
    for (std::size_t d = 0; d < 6; ++d) {
        const Fixed* raised = field.raised[d];
        if (!raised || (d > 0 && raised == field.raised[d - 1])) continue;
        const Fixed* u = brick.u[d / 2];
        const Fixed sign = d % 2 ? 1 : -1;
        for (int n = 0; n < count; ++n) reached[std::size_t(n)] |= raised[n] > sign * u[n];
    }
    return std::count(reached.begin(), reached.end(), 1);
}

bool Drag::covers(Vec3<Fixed> step) const {
    for (int a = 0; a < 3; ++a) {
        const std::int64_t to = std::int64_t(m_offset[a]) + step[a];
        if (std::max<std::int64_t>(m_highest[a], to) - std::min<std::int64_t>(m_lowest[a], to) >
            m_reach)
            return false;
    }
    return true;
}

BrickMotion Drag::motion_of(const Brick& brick, const FieldBrick& field, Vec3<Fixed> step,
                            Vec3d* farthest) const {
    BrickMotion motion{};
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        const Fixed sign = sign_of(step[a]);
        const std::size_t d = direction_of(a, sign);
        MovingComponent& component = motion[c];
        component = {brick.u[c], nullptr, m_reach - sign * (m_offset[a] + step[a]), sign};
        const Fixed highest = field.highest[d] - component.left;
        const Fixed lowest = sign > 0 ? brick.u_min[a] : -brick.u_max[a];
        if (step[a] != 0 && field.raised[d] && highest > lowest) component.raised = field.raised[d];
        if (!farthest) continue;
        (*farthest)[a] = std::max(-double(brick.u_min[a]), double(brick.u_max[a]));
        if (component.raised) (*farthest)[a] = std::max((*farthest)[a], double(highest));
    }
    return motion;
}

namespace {

bool moves(const BrickMotion& motion) {
    return motion[0].raised || motion[1].raised || motion[2].raised;
}

}  // namespace

StepLimit Drag::limit(const Lattice& lattice, Vec3<Fixed> step, const TaskArena& arena) const {
    StepLimit limit;
    for (int a = 0; a < 3; ++a) {
        const Fixed sign = sign_of(step[a]);
        const Fixed bone = m_bone[direction_of(a, sign)];
        const Fixed raise = bone - (m_reach - sign * (m_offset[a] + step[a]));
        if (step[a] != 0 && bone > 0 && raise > 0)
            tighten(limit, {1 - raise / std::abs(double(step[a])), LimitedBy::Bone});
    }
    std::mutex mutex;
    const auto look = [&](std::int64_t begin, std::int64_t end) {
        StepLimit own;
        for (std::int64_t k = begin; k < end; ++k) {
            const FieldBrick& field = m_bricks[std::size_t(k)];
            const Brick& brick = lattice.brick(field.index);
            Vec3d farthest{0, 0, 0};
            const BrickMotion motion = motion_of(brick, field, step, &farthest);
            if (moves(motion) && !stays_inside(brick, farthest))
                tighten(own, limit_of_brick(lattice, brick, motion, step, false));
        }
        const std::lock_guard lock(mutex);
        tighten(limit, own);
    };
    arena.for_each(std::int64_t(m_bricks.size()), 16 * kBricksPerTask, std::ref(look));
    return limit;
}

std::int64_t Drag::move(Lattice& lattice, Vec3<Fixed> step, Vec3<Fixed> done,
                        const SweepKernels& kernels, const TaskArena& arena) {
    std::atomic<std::int64_t> moved = 0;
    const auto move_some = [&](std::int64_t begin, std::int64_t end) {
        std::int64_t own = 0;
        for (std::int64_t k = begin; k < end; ++k) {
            const FieldBrick& field = m_bricks[std::size_t(k)];
            Brick& brick = lattice.brick(field.index);
            const BrickMotion motion = motion_of(brick, field, step, nullptr);
            if (moves(motion)) own += move_brick(lattice, brick, motion, step, done, kernels);
        }
        moved += own;
    };
    arena.for_each(std::int64_t(m_bricks.size()), kBricksPerTask, std::ref(move_some));
    for (int a = 0; a < 3; ++a) {
        m_offset[a] += done[a];
        m_lowest[a] = std::min(m_lowest[a], m_offset[a]);
        m_highest[a] = std::max(m_highest[a], m_offset[a]);
    }
    return moved;
}

void Drag::let_go(Lattice& lattice) {
    for (const FieldBrick& field : m_bricks) lattice.drop_still_bricks({&field.index, 1});
    m_bricks.clear();
    m_reach = 0;
}

std::size_t Drag::bytes() const {
    return m_bricks.size() * sizeof(FieldBrick) + m_used * m_array_bytes;
}

}  // namespace pliant
