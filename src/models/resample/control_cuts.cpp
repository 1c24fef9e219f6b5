// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/control_cuts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>

#include "base/errors.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

constexpr double kUnitsPerVoxel = 1 << 20;
/// Largest distance of a corner from voxel 0 [voxels].
constexpr double kFarthest = 1e5;

Position position_of(Vec3d voxel) {
    return {std::llround(voxel.x * kUnitsPerVoxel), std::llround(voxel.y * kUnitsPerVoxel),
            std::llround(voxel.z * kUnitsPerVoxel)};
}

Position position_of(Vec3i voxel) {
    return position_of(Vec3d{double(voxel.x), double(voxel.y), double(voxel.z)});
}

bool are_apart(Position low, Position high, Position other_low, Position other_high) {
    for (int a = 0; a < 3; ++a)
        if (low[a] > other_high[a] || high[a] < other_low[a]) return true;
    return false;
}

Position least(Position p, Position q) {
    return {std::min(p.x, q.x), std::min(p.y, q.y), std::min(p.z, q.z)};
}
Position most(Position p, Position q) {
    return {std::max(p.x, q.x), std::max(p.y, q.y), std::max(p.z, q.z)};
}

Vec3i corner(int c) {
    return {c & 1, c >> 1 & 1, c >> 2};
}

}  // namespace

std::int32_t ControlCuts::node_at(Vec3i n) const {
    return std::int32_t(dense_index(n, m_control.size));
}

Vec3i ControlCuts::position_of(std::int32_t node) const {
    const Vec3i n = m_control.size;
    return {node % n.x, node / n.x % n.y, node / (n.x * n.y)};
}

Position ControlCuts::voxel_of(Vec3i node) const {
    Vec3i voxel;
    for (int a = 0; a < 3; ++a) voxel[a] = m_control.first[a] + m_control.cell[a] * node[a];
    return pliant::position_of(voxel);
}

bool ControlCuts::crosses_one_of(std::span<const std::int32_t> triangles, Position from,
                                 Position to) const {
    const Position low = least(from, to), high = most(from, to);
    return std::any_of(triangles.begin(), triangles.end(), [&](std::int32_t t) {
        const Box& box = m_boxes[std::size_t(t)];
        // The blade is moved by an infinitely small vector: touching boxes may cross.
        return !are_apart(low, high, box.low, box.high) &&
               crosses(m_triangles[std::size_t(t)], from, to);
    });
}

bool ControlCuts::is_between(Vec3d from, Vec3d to) const {
    const Position a = pliant::position_of(from), b = pliant::position_of(to);
    const Position low = least(a, b), high = most(a, b);
    for (std::size_t t = 0; t < m_triangles.size(); ++t)
        if (!are_apart(low, high, m_boxes[t].low, m_boxes[t].high) && crosses(m_triangles[t], a, b))
            return true;
    return false;
}

const std::int32_t* ControlCuts::corners(Vec3i cell, Vec3i at) const {
    if (m_cells.empty()) return nullptr;
    const std::int32_t n = m_cell_at[dense_index(cell, m_control.size - Vec3i{1, 1, 1})];
    if (n < 0) return nullptr;
    return &m_cells[std::size_t(n)].corners[8 * dense_index(at, m_control.cell + Vec3i{1, 1, 1})];
}

/// Cells that may be crossed, with the triangles that may do so.
void ControlCuts::find_cells() {
    const Vec3i cells = m_control.size - Vec3i{1, 1, 1};
    m_cell_at.assign(dense_count(cells), -1);
    for (std::size_t t = 0; t < m_boxes.size(); ++t) {
        Box3i near;
        for (int a = 0; a < 3; ++a) {
            const auto cell_of = [&](std::int64_t at) {
                const double voxel = double(at) / kUnitsPerVoxel - m_control.first[a];
                return std::clamp(voxel / m_control.cell[a], -2.0, double(cells[a]) + 1);
            };
            near.begin[a] = std::max(0, int(std::floor(cell_of(m_boxes[t].low[a]))) - 1);
            near.end[a] = std::min(cells[a], int(std::floor(cell_of(m_boxes[t].high[a]))) + 2);
        }
        if (is_empty(near)) continue;
        for_each_in(near, [&](Vec3i cell) {
            if (are_apart(voxel_of(cell), voxel_of(cell + Vec3i{1, 1, 1}), m_boxes[t].low,
                          m_boxes[t].high))
                return;
            std::int32_t& at = m_cell_at[dense_index(cell, cells)];
            if (at < 0) {
                m_cells.push_back({.cell = cell, .triangles = {}});
                at = std::int32_t(m_cells.size()) - 1;
            }
            m_cells[std::size_t(at)].triangles.push_back(std::int32_t(t));
        });
    }
}

/// One ghost for each connected group of the neighbours from which a node is hidden.
void ControlCuts::find_ghosts() {
    std::map<std::int32_t, std::set<std::int32_t>> hidden;
    for (const CrossedCell& crossed : m_cells)
        for (int c = 0; c < 8; ++c)
            for (int d = c + 1; d < 8; ++d) {
                const Vec3i p = crossed.cell + corner(c), q = crossed.cell + corner(d);
                if (!crosses_one_of(crossed.triangles, voxel_of(p), voxel_of(q))) continue;
                hidden[node_at(p)].insert(node_at(q));
                hidden[node_at(q)].insert(node_at(p));
            }
    const auto distance = [&](std::int32_t p, std::int32_t q) {
        const Vec3i away = position_of(p) - position_of(q);
        return Vec3i{std::abs(away.x), std::abs(away.y), std::abs(away.z)};
    };
    const auto sees = [&](std::int32_t p, std::int32_t q) {
        const Vec3i away = distance(p, q);
        if (std::max({away.x, away.y, away.z}) > 1) return false;
        const auto found = hidden.find(p);
        return found == hidden.end() || !found->second.contains(q);
    };
    for (const auto& [node, others] : hidden) {
        std::vector<std::int32_t> left(others.begin(), others.end());
        while (!left.empty()) {
            std::vector<std::int32_t> group{left.front()};
            left.erase(left.begin());
            for (std::size_t n = 0; n < group.size(); ++n)
                std::erase_if(left, [&](std::int32_t other) {
                    if (!sees(group[n], other)) return false;
                    group.push_back(other);
                    return true;
                });
            std::sort(group.begin(), group.end());
            for (const std::int32_t other : group)
                m_ghost_of[{node, other}] = std::int32_t(m_ghosts.size());
            // The nearest ones: along edges, or else along diagonals.
            const auto steps = [&, node = node](std::int32_t other) {
                const Vec3i away = distance(node, other);
                return away.x + away.y + away.z;
            };
            int fewest = 3;
            for (const std::int32_t other : group) fewest = std::min(fewest, steps(other));
            std::erase_if(group, [&](std::int32_t other) { return steps(other) > fewest; });
            m_ghosts.push_back({node, std::move(group)});
        }
    }
}

void ControlCuts::look_from_elements(CrossedCell& crossed) const {
    const Vec3i wide = m_control.cell + Vec3i{1, 1, 1};
    const auto nodes = std::int32_t(dense_count(m_control.size));
    crossed.corners.resize(8 * dense_count(wide));
    crossed.edits.assign(dense_count(wide), 0);
    std::array<std::int32_t, 8> corner_nodes;
    std::array<Position, 8> corner_positions;
    for (int c = 0; c < 8; ++c) {
        corner_nodes[std::size_t(c)] = node_at(crossed.cell + corner(c));
        corner_positions[std::size_t(c)] = voxel_of(crossed.cell + corner(c));
    }
    for_each_in({{0, 0, 0}, wide}, [&](Vec3i at) {
        const std::size_t n = dense_index(at, wide);
        const Position from = corner_positions[0] + pliant::position_of(at);
        std::array<bool, 8> seen;
        for (std::size_t c = 0; c < 8; ++c)
            seen[c] = !crosses_one_of(crossed.triangles, from, corner_positions[c]);
        for (std::size_t c = 0; c < 8; ++c) {
            std::int32_t& follows = crossed.corners[8 * n + c];
            follows = corner_nodes[c];
            // Beside the end of a cut a node may be hidden from elements alone: no ghost, then.
            for (int steps = 1; steps <= 3 && !seen[c] && follows < nodes; ++steps)
                for (std::size_t d = 0; d < 8 && follows < nodes; ++d) {
                    if (!seen[d] || std::popcount(c ^ d) != steps) continue;
                    const auto ghost = m_ghost_of.find({corner_nodes[c], corner_nodes[d]});
                    if (ghost != m_ghost_of.end()) follows = nodes + ghost->second;
                }
        }
        for (int a = 0; a < 3; ++a) {
            if (at[a] == m_control.cell[a]) continue;
            Vec3i next = at;
            ++next[a];
            if (crosses_one_of(crossed.triangles, from,
                               corner_positions[0] + pliant::position_of(next)))
                crossed.edits[n] = std::uint8_t(crossed.edits[n] | kCutX << a);
        }
    });
}

void ControlCuts::collect_edits(int brick_size) {
    const Vec3i wide = m_control.cell + Vec3i{1, 1, 1};
    const auto elements =
        std::size_t(brick_size) * std::size_t(brick_size) * std::size_t(brick_size);
    for (const CrossedCell& crossed : m_cells)
        for_each_in({{0, 0, 0}, wide}, [&](Vec3i at) {
            const std::uint8_t flags = crossed.edits[dense_index(at, wide)];
            if (flags == 0) return;
            Vec3i brick, local;
            for (int a = 0; a < 3; ++a) {
                const int voxel = m_control.first[a] + m_control.cell[a] * crossed.cell[a] + at[a];
                brick[a] = voxel / brick_size;
                local[a] = voxel % brick_size;
            }
            BrickEdits& edits = m_edits[brick];
            edits.resize(elements);
            std::uint8_t& own = edits[dense_index(local, {brick_size, brick_size, brick_size})];
            own = std::uint8_t(own | flags);
        });
}

Result<ControlCuts> ControlCuts::create(const Grid& scan, const ControlGrid& control,
                                        std::span<const CutTriangle> triangles_mm, int brick_size,
                                        const TaskArena& arena) {
    ControlCuts cuts;
    cuts.m_control = control;
    cuts.m_triangles_mm.assign(triangles_mm.begin(), triangles_mm.end());
    for (const CutTriangle& triangle_mm : triangles_mm) {
        Triangle triangle;
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3d voxel = voxel_from_world(scan, triangle_mm[c]);
            if (!(norm(voxel) <= kFarthest))
                return about("cut", ErrorCode::InvalidArgument,
                             "expected points within 100000 voxels, found others");
            triangle[c] = pliant::position_of(voxel);
        }
        cuts.m_boxes.push_back({least(least(triangle[0], triangle[1]), triangle[2]),
                                most(most(triangle[0], triangle[1]), triangle[2])});
        cuts.m_triangles.push_back(triangle);
    }
    cuts.find_cells();
    cuts.find_ghosts();
    arena.for_each(std::int64_t(cuts.m_cells.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n)
            cuts.look_from_elements(cuts.m_cells[std::size_t(n)]);
    });
    cuts.collect_edits(brick_size);
    return cuts;
}

}  // namespace pliant
