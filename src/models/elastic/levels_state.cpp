// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// States of the lattices as numbers: windows, displacements, and the cells that touch.

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "elastic/levels.h"
#include "field/fixed_point.h"

namespace pliant {

void ElasticLevels::copy_to(std::vector<double>& numbers) const {
    numbers.clear();
    for (const auto& level : m_levels) {
        for (int a = 0; a < 3; ++a) numbers.push_back(level->first[a]);
        for (int a = 0; a < 3; ++a) numbers.push_back(level->nodes[a]);
    }
    std::size_t end = numbers.size();
    numbers.resize(end + 3 * std::size_t(node_count()));
    for (const auto& level : m_levels)
        level->for_each_node([&](Vec3i, std::size_t at) {
            for (const float* const u : level->u) numbers[end++] = double(u[at]);
        });
    for (const auto& level : m_levels) {
        numbers.push_back(double(level->touching.size()));
        for (const TouchingCell& touches : level->touching) {
            for (int a = 0; a < 3; ++a) numbers.push_back(touches.cell[a]);
            for (const float u : touches.u) numbers.push_back(double(u));
        }
    }
}

/// Reads the cells of a level that touch. @returns false if they can't be
bool ElasticLevels::read_touching(std::span<const double>& numbers, Vec3i cells,
                                  std::vector<TouchingCell>& touching) {
    constexpr std::size_t kNumbers = 3 + 24;
    if (numbers.empty() || !(numbers[0] >= 0 && numbers[0] <= double(numbers.size()))) return false;
    const auto count = std::size_t(numbers[0]);
    if (double(count) != numbers[0] || numbers.size() < 1 + count * kNumbers) return false;
    numbers = numbers.subspan(1);
    touching.resize(count);
    for (TouchingCell& touches : touching) {
        for (int a = 0; a < 3; ++a) {
            const double at = numbers[std::size_t(a)];
            if (!(at >= 0 && at < cells[a])) return false;
            touches.cell[a] = int(at);
        }
        for (std::size_t n = 0; n < 24; ++n) {
            if (!(std::abs(numbers[3 + n]) <= kMaxMovementMm)) return false;
            touches.u[n] = float(numbers[3 + n]);
        }
        numbers = numbers.subspan(kNumbers);
    }
    return std::is_sorted(
        touching.begin(), touching.end(), [](const TouchingCell& a, const TouchingCell& b) {
            return std::tie(a.cell.z, a.cell.y, a.cell.x) < std::tie(b.cell.z, b.cell.y, b.cell.x);
        });
}

bool ElasticLevels::copy_from(std::span<const double> numbers) {
    const std::size_t head = 6 * m_levels.size();
    if (numbers.size() < head) return false;
    std::vector<Box3i> windows(m_levels.size());
    std::size_t count = head;
    for (std::size_t n = 0; n < windows.size(); ++n) {
        std::size_t nodes = 3;
        for (int a = 0; a < 3; ++a) {
            const double first = numbers[6 * n + std::size_t(a)];
            const double size = numbers[6 * n + 3 + std::size_t(a)];
            if (!(first >= 0 && size >= 2 && first + size <= m_map.cells(int(n))[a] + 1))
                return false;
            windows[n].begin[a] = int(first);
            windows[n].end[a] = int(first) + int(size);
            nodes *= std::size_t(size);
        }
        count += nodes;
    }
    if (!are_nested(windows) || numbers.size() < count) return false;
    for (const double u : numbers.subspan(head, count - head))
        if (!(std::abs(u) <= kMaxMovementMm)) return false;
    std::vector<std::vector<TouchingCell>> touching(windows.size());
    std::span<const double> rest = numbers.subspan(count);
    for (std::size_t n = 0; n < windows.size(); ++n)
        if (!read_touching(rest, windows[n].end - windows[n].begin - Vec3i{1, 1, 1}, touching[n]))
            return false;
    if (!rest.empty()) return false;
    m_held.clear();
    place(windows);
    for (std::size_t n = 0; n < windows.size(); ++n) m_levels[n]->touching.swap(touching[n]);
    stiffen();
    const double* next = numbers.data() + head;
    for (auto& level : m_levels)
        level->for_each_node([&](Vec3i, std::size_t at) {
            for (float* const u : level->u) u[at] = float(*next++);
        });
    return true;
}

double ElasticLevels::go_back(std::span<const double> earlier, double part) {
    std::size_t at = 6 * m_levels.size();
    for (std::size_t n = 0; n < m_levels.size(); ++n)
        for (std::size_t a = 0; a < 3; ++a)
            if (earlier[6 * n + a] != m_levels[n]->first[int(a)])
                return std::numeric_limits<double>::infinity();
    double largest = 0;
    for (auto& level : m_levels)
        level->for_each_node([&](Vec3i, std::size_t node) {
            for (float* const u : level->u) {
                const double difference = earlier[at++] - double(u[node]);
                largest = std::max(largest, std::abs(difference));
                if (part != 0) u[node] += float(part * difference);
            }
        });
    return largest;
}

}  // namespace pliant
