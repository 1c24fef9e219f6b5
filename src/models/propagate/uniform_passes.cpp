// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "propagate/uniform_passes.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <tuple>

namespace pliant {
namespace {

/// Passes with fewer carries run on one thread.
constexpr std::size_t kFewCarries = 16;
constexpr std::int64_t kLinesPerTask = 4;

/// Position of a brick's line along an axis.
std::uint64_t line_of(Vec3i coord, int axis) {
    const auto p = std::uint32_t(coord[(axis + 1) % 3]), q = std::uint32_t(coord[(axis + 2) % 3]);
    return std::uint64_t(q) << 32 | p;
}

}  // namespace

bool UniformPasses::run(const TaskArena& arena, int max_bricks) {
    m_work.made.clear();
    if (m_work.touched.empty()) return true;
    const MaterialId id = m_lattice.brick(m_work.touched[0]).material[0];
    std::array<int, 3> order{0, 1, 2};
    for (int b = 0; b < 3; ++b) {
        const auto a = std::size_t(b);
        m_half[a] = m_lattice.materials().columns().shear[a][id];
        m_lag[a] = 2 * m_half[a];
    }
    m_is_alone = m_lattice.resident_brick_count() == int(m_work.touched.size());
    for (const int index : m_work.touched)
        if (!is_alike(m_lattice.brick(index))) return false;
    for (const int index : m_work.touched) relax_grabbed(m_lattice.brick(index));
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return m_lag[std::size_t(a)] < m_lag[std::size_t(b)]; });
    for (const int axis : order)
        if (!pass(axis, arena, max_bricks)) {
            drop_unreached();
            return false;
        }
    return true;
}

bool UniformPasses::pass(int axis, const TaskArena& arena, int max_bricks) {
    list_sources(axis);
    return plan(axis, max_bricks) && carry_all(axis, arena);
}

void UniformPasses::drop_unreached() {
    const auto unreached = [&](int index) { return !m_lattice.brick(index).reached[0]; };
    std::erase_if(m_work.touched, [&](int index) {
        if (!unreached(index)) return false;
        m_work.nodes[std::size_t(index)] = {};
        return true;
    });
    std::erase_if(m_work.made, std::not_fn(unreached));
    m_lattice.drop_still_bricks(m_work.made);
}

bool UniformPasses::is_alike(const Brick& brick) const {
    if ((brick.traits & (kMixedMaterials | kAsymmetric)) || brick.edits) return false;
    if (!has_these_lags(brick.material[0])) return false;
    if (m_is_alone) return true;
    return is_at_rest(brick) &&
           std::all_of(brick.neighbours.begin(), brick.neighbours.end(), [&](int neighbour) {
               return neighbour < 0 || is_at_rest(m_lattice.brick(neighbour));
           });
}

bool UniformPasses::has_these_lags(MaterialId id) const {
    const auto& halves = m_lattice.materials().columns().shear;
    return halves[0][id] == m_half[0] && halves[1][id] == m_half[1] && halves[2][id] == m_half[2];
}

void UniformPasses::relax_grabbed(Brick& brick) const {
    Fixed* w = brick.raised[0];
    m_kernels.relax_uniform(w, m_lattice.brick_size(), {m_lag, m_lag}, ~std::uint32_t(0));
    if (brick.traits & kPartlyBeyond) m_lattice.set_beyond(brick, w, 0);
}

void UniformPasses::list_sources(int axis) {
    auto& sources = m_work.sources;
    sources.clear();
    for (const int index : m_work.touched) {
        const Brick& brick = m_lattice.brick(index);
        if (brick.reached[0])
            sources.push_back({line_of(brick.coord, axis), brick.coord[axis], index});
    }
    const auto order = [](const Source& s) { return std::tie(s.line, s.position); };
    std::sort(sources.begin(), sources.end(),
              [&](const Source& p, const Source& q) { return order(p) < order(q); });
}

bool UniformPasses::plan(int axis, int max_bricks) {
    auto& sources = m_work.sources;
    m_work.carries.clear();
    m_work.line_begins.assign(1, 0);
    for (std::size_t begin = 0, end = 0; begin < sources.size(); begin = end) {
        while (end < sources.size() && sources[end].line == sources[begin].line) ++end;
        const std::span<Source> line(sources.data() + begin, end - begin);
        for (const int side : {2 * axis + 1, 2 * axis}) {
            if (!plan_line(line, side, max_bricks)) return false;
            std::reverse(line.begin(), line.end());
        }
        m_work.line_begins.push_back(m_work.carries.size());
    }
    return true;
}

bool UniformPasses::plan_line(std::span<const Source> line, int side, int max_bricks) {
    const Fixed half = m_half[std::size_t(side / 2)], lag = m_lag[std::size_t(side / 2)];
    const std::int64_t lag_of_brick = std::int64_t(m_lattice.brick_size()) * lag;
    std::int64_t highest = 0;  // on the face of `at` on the side
    int at = -1;
    for (std::size_t next_source = 0;;) {
        if (highest <= half) {
            if (next_source == line.size()) return true;
            at = line[next_source++].brick;
            highest = highest_on_face(m_lattice.brick(at), side);
            continue;
        }
        const Brick& brick = m_lattice.brick(at);
        int next = brick.neighbours[std::size_t(side)];
        if (next < 0) {
            if (m_lattice.is_beyond_border(coord_behind(brick, side))) {
                highest = 0;
                continue;
            }
            next = m_lattice.ensure_blank_brick(coord_behind(brick, side));
            m_work.made.push_back(next);
            if (m_lattice.resident_brick_count() > max_bricks) return false;
        }
        m_work.touch(next, m_lattice.brick_index_bound());
        if (!may_be_alike(m_lattice.brick(next))) return false;
        m_work.carries.push_back({at, next, side % 2 == 1, highest > lag});
        at = next;
        highest = std::max<std::int64_t>(0, highest - lag_of_brick);
        if (next_source < line.size() && line[next_source].brick == at) {
            const Fixed own = highest_on_face(m_lattice.brick(at), side);
            highest = std::max<std::int64_t>(highest, own);
            ++next_source;
        }
    }
}

bool UniformPasses::may_be_alike(const Brick& brick) const {
    if (!brick.is_blank) return is_alike(brick);
    return has_these_lags(m_lattice.material_at(m_lattice.element_of(brick.coord, 0)));
}

Fixed UniformPasses::highest_on_face(const Brick& brick, int side) const {
    if (side % 2 && ends_at_border(brick, side / 2)) return 0;
    const int size = m_lattice.brick_size(), face = size * size;
    const Fixed* w = brick.raised[0];
    if (side == 4) return m_kernels.largest(w, face);
    if (side == 5) return m_kernels.largest(w + (size - 1) * face, face);
    alignas(64) std::array<Fixed, std::size_t(kMaxBrickSize * kMaxBrickSize)> values;
    m_kernels.copy_face(w, size, side, values.data());
    return m_kernels.largest(values.data(), face);
}

bool UniformPasses::carry_all(int axis, const TaskArena& arena) {
    std::atomic<bool> all_alike = true;
    const auto carry_lines = [&](std::int64_t begin, std::int64_t end) {
        const auto last = m_work.line_begins[std::size_t(end)];
        bool alike = true;
        for (auto n = m_work.line_begins[std::size_t(begin)]; n < last; ++n)
            alike &= carry(m_work.carries[n], axis);
        if (!alike) all_alike = false;
    };
    const auto lines = std::int64_t(m_work.line_begins.size()) - 1;
    if (m_work.carries.size() < kFewCarries)
        carry_lines(0, lines);
    else
        arena.for_each(lines, kLinesPerTask, std::ref(carry_lines));
    return all_alike;
}

bool UniformPasses::carry(const Carry& step, int axis) const {
    Brick& to = m_lattice.brick(step.to);
    if (to.is_blank) {
        m_lattice.fill_in(to);
        if (!is_alike(to)) return false;
    }
    const Brick& from = m_lattice.brick(step.from);
    // An unreached brick is behind one of another material.
    if (!step.reaches || !from.reached[0]) return true;
    const int side = 2 * axis + (step.up ? 0 : 1);
    m_kernels.carry(to.raised[0], m_lattice.brick_size(), side, from.raised[0],
                    m_lag[std::size_t(axis)], !to.reached[0]);
    to.reached[0] = true;
    // At the border nothing enters from beyond, where the raise is 0 already.
    if (to.traits & kPartlyBeyond && step.up && ends_at_border(to, axis))
        m_lattice.set_beyond(to, to.raised[0], 0);
    return true;
}

bool UniformPasses::ends_at_border(const Brick& brick, int axis) const {
    return m_lattice.is_bounded() &&
           m_lattice.brick_size() * (brick.coord[axis] + 1) >= m_lattice.grid().size[axis];
}

}  // namespace pliant
