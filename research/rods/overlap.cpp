// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Two passes, as in [Teschner2003]: nodes are hashed by their grid cell, then each tetrahedron
// visits all cells that its box intersects. Slots have a time stamp, so that the table need not be
// cleared. Unlike in the paper, nodes store their grid cell: nodes of other cells with the same
// hash are skipped without a test, and no pair is found twice.

#include <pliant/research/overlap.h>
#include <pliant/result.h>

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr std::uint32_t kPrimes[3] = {73856093, 19349663, 83492791};
/// Clamp of the grid cell along an axis.
constexpr double kFarthest = 1e9;
/// Numbers of slots: primes, larger than the number of nodes by a factor that keeps collisions
/// rare.
constexpr std::size_t kSlots[] = {9973,    19997,   49999,   99991,    199999,   499979,  999983,
                                  1999993, 4999999, 9999991, 19999999, 49999991, 99999989};

struct Box {
    Vec3d low, high;
};
Box box_of(const std::array<Vec3d, 4>& corners) {
    Box box{corners[0], corners[0]};
    for (const Vec3d& p : corners)
        for (int a = 0; a < 3; ++a) {
            box.low[a] = std::min(box.low[a], p[a]);
            box.high[a] = std::max(box.high[a], p[a]);
        }
    return box;
}

}  // namespace

OverlapSearch::OverlapSearch(const TetMesh& mesh)
    : m_cells(mesh.cells), m_nodes(mesh.nodes_mm.size()) {
    double sum = 0;
    for (const auto& cell : m_cells)
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b)
                sum +=
                    norm(mesh.nodes_mm[std::size_t(cell[a])] - mesh.nodes_mm[std::size_t(cell[b])]);
    if (sum > 0 && std::isfinite(sum)) m_per_length = 6 * double(m_cells.size()) / sum;
    const auto* slots =
        std::lower_bound(std::begin(kSlots), std::end(kSlots) - 1, 2 * m_nodes.size());
    m_heads.assign(*slots, -1);
    m_stamps.assign(*slots, 0);
}

Vec3i OverlapSearch::cell_of(Vec3d position) const {
    Vec3i cell{0, 0, 0};
    for (int a = 0; a < 3; ++a)
        cell[a] = int(std::floor(std::clamp(position[a] * m_per_length, -kFarthest, kFarthest)));
    return cell;
}

std::size_t OverlapSearch::slot_of(Vec3i cell) const {
    const std::uint32_t hash = std::uint32_t(cell.x) * kPrimes[0] ^
                               std::uint32_t(cell.y) * kPrimes[1] ^
                               std::uint32_t(cell.z) * kPrimes[2];
    return hash % m_heads.size();
}

std::span<const NodeInCell> OverlapSearch::find(std::span<const Vec3d> positions) {
    PLIANT_ASSERT(positions.size() == m_nodes.size());
    m_found.clear();
    ++m_stamp;
    for (std::size_t n = 0; n < positions.size(); ++n) {
        if (!is_finite(positions[n])) continue;
        const Vec3i cell = cell_of(positions[n]);
        const std::size_t slot = slot_of(cell);
        if (m_stamps[slot] != m_stamp) m_heads[slot] = -1;
        m_stamps[slot] = m_stamp;
        m_nodes[n] = {cell, m_heads[slot]};
        m_heads[slot] = std::int32_t(n);
    }
    for (std::size_t c = 0; c < m_cells.size(); ++c) test(std::int32_t(c), positions);
    return m_found;
}

void OverlapSearch::test(std::int32_t cell, std::span<const Vec3d> positions) {
    const auto& nodes = m_cells[std::size_t(cell)];
    std::array<Vec3d, 4> corners;
    for (std::size_t n = 0; n < 4; ++n) corners[n] = positions[std::size_t(nodes[n])];
    const Box box = box_of(corners);
    if (!is_finite(box.low) || !is_finite(box.high)) return;
    const auto first = m_found.size();
    const auto test_node = [&](std::int32_t n) {
        if (std::find(nodes.begin(), nodes.end(), n) == nodes.end() &&
            is_inside_tetrahedron(positions[std::size_t(n)], corners))
            m_found.push_back({cell, n});
    };
    const Vec3i low = cell_of(box.low), high = cell_of(box.high);
    double count = 1;
    for (int a = 0; a < 3; ++a) count *= double(high[a]) - low[a] + 1;
    if (count > double(positions.size())) {  // an elongated box: more cells than nodes
        for (std::size_t n = 0; n < positions.size(); ++n) test_node(std::int32_t(n));
        return;
    }
    for (int k = low.z; k <= high.z; ++k)
        for (int j = low.y; j <= high.y; ++j)
            for (int i = low.x; i <= high.x; ++i) {
                const std::size_t slot = slot_of({i, j, k});
                if (m_stamps[slot] != m_stamp) continue;
                for (std::int32_t n = m_heads[slot]; n >= 0; n = m_nodes[std::size_t(n)].next) {
                    const Vec3i& at = m_nodes[std::size_t(n)].cell;
                    if (at.x == i && at.y == j && at.z == k) test_node(n);
                }
            }
    std::sort(m_found.begin() + std::ptrdiff_t(first), m_found.end());
}

}  // namespace pliant
