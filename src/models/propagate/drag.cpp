// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "propagate/drag.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <mutex>

namespace pliant {
namespace {

constexpr std::int64_t kDraggedPerTask = 32;
/// Number of elements whose displacements, 6 MiB, the caches can hold until they are read again.
constexpr std::size_t kCachedElements = 1 << 19;
/// Value of FieldBrick::highest below all values of a field.
constexpr Fixed kNotReached = INT32_MIN;

Fixed sign_of(Fixed step) {
    return step < 0 ? -1 : 1;
}

}  // namespace

void DragTurns::remove(std::size_t at) {
    std::copy(m_turns.begin() + std::ptrdiff_t(at) + 1, m_turns.begin() + std::ptrdiff_t(m_count),
              m_turns.begin() + std::ptrdiff_t(at));
    --m_count;
}

void DragTurns::add(DragTurn turn) {
    if (m_is_lost) return;
    if (m_count > 0 && m_turns[m_count - 1].sign == turn.sign) --m_count;
    // Farther than the last turn in this direction: that one no longer matters, nor the one after
    // it if an earlier turn in the other direction went farther.
    while (m_count >= 2 && m_turns[m_count - 2].left >= turn.left) {
        remove(m_count - 2);
        if (m_count >= 2) --m_count;
    }
    m_turns[m_count++] = turn;
    m_is_lost = m_count > kMost;
}

bool Drag::pick(Lattice& lattice, std::span<const ElementRef> grabbed, Fixed reach,
                const SweepKernels& kernels, LookAtBrick look, const TaskArena& arena,
                int max_bricks, SweepWork& work) {
    m_reach = reach;
    m_offset = m_lowest = m_highest = {0, 0, 0};
    for (DragTurns& turns : m_turns) turns.clear();
    m_bricks.clear();
    m_arrays.clear();
    m_indices.clear();
    m_told_step = 0;
    if (!m_fields.solve(lattice, grabbed, reach, kernels, arena, max_bricks, work)) {
        lattice.drop_still_bricks(work.touched);
        return false;
    }
    for (const int index : work.touched) {
        m_bricks.push_back({&lattice.brick(index)});
        m_arrays.push_back(m_fields.of_brick(index));
        m_indices.push_back(index);
    }
    look_at_bricks(lattice, look, arena);
    return true;
}

void Drag::look_at_bricks(Lattice& lattice, LookAtBrick look, const TaskArena& arena) {
    m_bone = {};
    m_reach_elements = 0;
    std::mutex mutex;
    const auto look_at_some = [&](std::int64_t begin, std::int64_t end) {
        std::array<Fixed, 6> bone{};
        std::int64_t reached = 0;
        for (auto k = std::size_t(begin); k < std::size_t(end); ++k) {
            FieldBrick& field = m_bricks[k];
            // All other code may read the displacements of every existing brick.
            Brick& brick = *field.brick;
            if (brick.is_unplaced) lattice.place_at_rest(brick);
            field.least_movement = brick.least_movement;
            field.u_min = brick.u_min;
            field.u_max = brick.u_max;
            field.highest.fill(kNotReached);
            if (!m_arrays[k][0]) continue;
            const FieldArrays& arrays = m_arrays[k];
            field.was_at_rest = is_at_rest(brick) &&
                                std::all_of(arrays.begin(), arrays.end(),
                                            [&](const Fixed* array) { return array == arrays[0]; });
            FieldsOfBrick fields{{}, {}, m_fields.ahead(), is_at_rest(brick)};
            std::copy_n(m_arrays[k].begin(), kDirections, fields.of.begin());
            std::copy_n(brick.u.begin(), 3, fields.u.begin());
            const LookAtFields found = look(fields, lattice.elements_per_brick());
            field.highest = found.highest;
            reached += found.reached;
            bound_travel(lattice, brick, m_arrays[k], bone);
        }
        const std::lock_guard lock(mutex);
        for (std::size_t d = 0; d < 6; ++d) m_bone[d] = std::max(m_bone[d], bone[d]);
        m_reach_elements += reached;
    };
    arena.for_each(std::int64_t(m_bricks.size()), kDraggedPerTask, std::ref(look_at_some));
}

void Drag::bound_travel(const Lattice& lattice, const Brick& brick, const FieldArrays& fields,
                        std::array<Fixed, 6>& bone) const {
    if (!(brick.traits & kFixedTrait)) return;
    const std::uint8_t* traits = lattice.materials().traits();
    for (int n = 0; n < lattice.elements_per_brick(); ++n) {
        if (!(traits[brick.material[n]] & kFixedTrait)) continue;
        for (std::size_t d = 0; d < 6; ++d) {
            const Fixed u = brick.u[d / 2][n];
            bone[d] = std::max(bone[d], fields[d][n] + m_fields.ahead()[d] - (d % 2 ? u : -u));
        }
    }
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

Drag::Frame Drag::frame_of(Vec3<Fixed> step) const {
    Frame frame{};
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        frame.sign[c] = sign_of(step[a]);
        frame.direction[c] = direction_of(a, frame.sign[c]);
        const Fixed ahead = m_fields.ahead()[frame.direction[c]];
        frame.left[c] = m_reach - ahead - frame.sign[c] * (m_offset[a] + step[a]);
        frame.moves[c] = step[a] != 0;
    }
    return frame;
}

Fixed Drag::lowest_of(const FieldBrick& field, const Frame& frame, int axis) {
    return frame.sign[std::size_t(axis)] > 0 ? field.u_min[axis] : -field.u_max[axis];
}

unsigned Drag::moving(const FieldBrick& field, const Frame& frame) {
    unsigned axes = 0;
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        const std::int64_t highest = field.highest[frame.direction[c]];
        const bool moves = highest - frame.left[c] > lowest_of(field, frame, a);
        axes |= unsigned(moves && frame.moves[c]) << a;
    }
    return axes;
}

Vec3d Drag::farthest(const FieldBrick& field, const Frame& frame, unsigned axes) {
    Vec3d farthest{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        farthest[a] = std::max(-double(field.u_min[a]), double(field.u_max[a]));
        if (!(axes >> a & 1)) continue;
        const Fixed highest = field.highest[frame.direction[c]];
        farthest[a] = std::max(farthest[a], double(highest) - frame.left[c]);
    }
    return farthest;
}

BrickMotion Drag::motion_of(std::size_t index, const Frame& frame, unsigned axes) const {
    const FieldBrick& field = m_bricks[index];
    BrickMotion motion{};
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        const bool moves = axes >> a & 1;
        motion[c] = {field.brick->u[c], moves ? m_arrays[index][frame.direction[c]] : nullptr,
                     frame.left[c], frame.sign[c]};
    }
    return motion;
}

StepLimit Drag::limit(const Lattice& lattice, Vec3<Fixed> step, const TaskArena& arena) {
    const std::uint64_t observed = lattice.observed_step();
    if (m_told_step != observed)
        for (FieldBrick& field : m_bricks) field.is_told = false;
    m_told_step = observed;
    StepLimit limit;
    for (int a = 0; a < 3; ++a) {
        const Fixed sign = sign_of(step[a]);
        const Fixed bone = m_bone[direction_of(a, sign)];
        const Fixed raise = bone - (m_reach - sign * (m_offset[a] + step[a]));
        if (step[a] != 0 && bone > 0 && raise > 0)
            tighten(limit, {1 - raise / std::abs(double(step[a])), LimitedBy::Bone});
    }
    const Frame frame = frame_of(step);
    std::mutex mutex;
    const auto look = [&](std::int64_t begin, std::int64_t end) {
        StepLimit own;
        for (auto k = std::size_t(begin); k < std::size_t(end); ++k) {
            FieldBrick& field = m_bricks[k];
            const unsigned axes = moving(field, frame);
            if (axes && observed && !field.is_told) {
                lattice.before_move(*field.brick);
                field.is_told = true;
            }
            if (axes && !stays_inside(field.least_movement, farthest(field, frame, axes)))
                tighten(own, limit_of_brick(lattice, *field.brick, motion_of(k, frame, axes), step,
                                            false));
        }
        const std::lock_guard lock(mutex);
        tighten(limit, own);
    };
    arena.for_each(std::int64_t(m_bricks.size()), 16 * kDraggedPerTask, std::ref(look));
    return limit;
}

int Drag::move_brick(Lattice& lattice, std::size_t index, const Frame& frame, unsigned moving_axes,
                     std::size_t next, MoveDragged move_dragged) {
    FieldBrick& field = m_bricks[index];
    Brick& brick = *field.brick;
    std::array<DraggedComponent, 3> components;
    std::array<int, 3> axes;
    std::size_t count = 0;
    // A read from the caches is faster than an evaluation of the turns.
    const auto elements = std::size_t(lattice.elements_per_brick());
    bool known = field.was_at_rest && m_bricks.size() * elements > kCachedElements;
    for (int a = 0; a < 3; ++a) {
        if (!(moving_axes >> a & 1)) continue;
        const auto c = std::size_t(a);
        components[count] = {.u = brick.u[c],
                             .raised = m_arrays[index][frame.direction[c]],
                             .left = frame.left[c],
                             .sign = frame.sign[c],
                             .lowest = lowest_of(field, frame, a),
                             .next_u = m_bricks[next].brick->u[c],
                             .next_raised = m_arrays[next][frame.direction[c]],
                             .turns = m_turns[c].turns()};
        known &= !m_turns[c].is_lost();
        axes[count++] = a;
    }
    lattice.before_move(brick);
    const DraggedBrick dragged =
        move_dragged(std::span(components).first(count), lattice.elements_per_brick(), known);
    for (std::size_t k = 0; k < count; ++k) {
        const int a = axes[k];
        const Fixed highest = field.highest[frame.direction[std::size_t(a)]] - components[k].left;
        if (components[k].sign > 0) {
            field.u_min[a] = components[k].lowest;
            field.u_max[a] = std::max(field.u_max[a], highest);
        } else {
            field.u_max[a] = -components[k].lowest;
            field.u_min[a] = std::min(field.u_min[a], -highest);
        }
    }
    brick.u_min = field.u_min;
    brick.u_max = field.u_max;
    field.has_wide_bounds |= dragged.has_wide_bounds;
    if (dragged.moved > 0) brick.changed_at = lattice.clock();
    return dragged.moved;
}

std::int64_t Drag::move(Lattice& lattice, Vec3<Fixed> step, MoveDragged move_dragged,
                        const TaskArena& arena) {
    const Frame frame = frame_of(step);
    std::atomic<std::int64_t> moved = 0;
    const auto move_some = [&](std::int64_t begin, std::int64_t end) {
        std::int64_t own = 0;
        const auto last = std::size_t(end);
        unsigned axes = moving(m_bricks[std::size_t(begin)], frame);
        for (auto k = std::size_t(begin); k < last; ++k) {
            const unsigned next = k + 1 < last ? moving(m_bricks[k + 1], frame) : 0;
            if (k + 2 < last) __builtin_prefetch(m_bricks[k + 2].brick);
            if (axes) own += move_brick(lattice, k, frame, axes, next ? k + 1 : k, move_dragged);
            axes = next;
        }
        finish_moves();
        moved += own;
    };
    arena.for_each(std::int64_t(m_bricks.size()), kDraggedPerTask, std::ref(move_some));
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        if (frame.moves[c]) m_turns[c].add({frame.left[c], frame.sign[c]});
        m_offset[a] += step[a];
        m_lowest[a] = std::min(m_lowest[a], m_offset[a]);
        m_highest[a] = std::max(m_highest[a], m_offset[a]);
    }
    return moved;
}

void Drag::let_go(Lattice& lattice) noexcept {
    for (std::size_t k = 0; k < m_bricks.size(); ++k)
        if (m_bricks[k].has_wide_bounds) lattice.update_bounds(m_indices[k]);
    lattice.drop_still_bricks(m_indices);
    m_bricks.clear();
    m_arrays.clear();
    m_indices.clear();
    m_reach = 0;
}

std::size_t Drag::bytes() const {
    return m_bricks.size() * (sizeof(FieldBrick) + sizeof(FieldArrays)) + m_fields.bytes();
}

}  // namespace pliant
