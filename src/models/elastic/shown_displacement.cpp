// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "elastic/shown_displacement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace pliant {
namespace {

constexpr Fixed kStep = 1 << 10;   ///< displacements are multiples of 2⁻¹⁰ mm
constexpr double kStillMm = 0.02;  ///< smaller motion is not shown
constexpr Fixed kStill = Fixed(kStillMm * kUnitsPerMm);

/// To the nearest step, ties to even. @pre below 2²² steps
constexpr std::size_t kBricksPerChunk = 64;

/// The nearest step, of equal ones the even one. @pre below 2²² steps
Fixed rounded(float mm) {
    constexpr float kWhole = 0x1.8p23F;  // a sum with it has no fraction
    return Fixed(mm * float(kUnitsPerMm / kStep) + kWhole - kWhole) * kStep;
}

}  // namespace

bool ShownDisplacement::is_before(const Lag& a, const Lag& b) {
    return std::tuple(-a.units, a.coord.z, a.coord.y, a.coord.x) <
           std::tuple(-b.units, b.coord.z, b.coord.y, b.coord.x);
}

/// Displacements of some elements along x [mm]; bone has none.
void ShownDisplacement::find_row(const ElasticLevels& levels, const StiffnessMap& map, Vec3i first,
                                 int count, BrickRow& row) const {
    const Vec3i voxels = m_field.grid().size;
    const Vec3i at{first.x, std::min(first.y, voxels.y - 1), std::min(first.z, voxels.z - 1)};
    levels.displacement_row(at, count, {row[0].data(), row[1].data(), row[2].data()});
    for (int x = 0; x < count; ++x)
        if (map.is_bone({at.x + x, at.y, at.z}))
            for (auto& component : row) component[std::size_t(x)] = 0;
}

/// Displacements of a brick's elements. Beyond the scan's border they are those of the border.
void ShownDisplacement::fill(const ElasticLevels& levels, const StiffnessMap& map, Vec3i coord,
                             const std::array<Fixed*, 3>& u) const {
    const int size = m_field.brick_size();
    const Vec3i first = size * coord;
    const int count = std::min(size, m_field.grid().size.x - first.x);
    BrickRow row{};
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y) {
            find_row(levels, map, first + Vec3i{0, y, z}, count, row);
            for (auto& component : row)
                std::fill(component.begin() + count, component.end(),
                          component[std::size_t(count - 1)]);
            const std::size_t to = std::size_t(size) * std::size_t(y + size * z);
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t x = 0; x < std::size_t(size); ++x)
                    u[a][to + x] = rounded(row[a][x]);
        }
}

/// Finds how far a brick lags. @param[out] filled  its displacements on the lattices
void ShownDisplacement::measure(const ElasticLevels& levels, const StiffnessMap& map, Lag& lag,
                                std::vector<Fixed>& filled) const {
    const std::size_t count = filled.size() / 3;
    fill(levels, map, lag.coord, {filled.data(), filled.data() + count, filled.data() + 2 * count});
    const int index = m_field.find_brick(lag.coord);
    Fixed largest = 0, difference = 0;
    for (const Fixed u : filled) largest = std::max(largest, std::abs(u));
    // The picture is a function of the lattices alone: not of which bricks were shown before.
    if (largest <= kStill) {
        std::fill(filled.begin(), filled.end(), Fixed{0});
        largest = 0;
    }
    if (index < 0) {
        lag.units = largest;
        return;
    }
    for (std::size_t a = 0; a < 3; ++a) {
        const Fixed* const before = m_field.brick(index).u[a];
        for (std::size_t e = 0; e < count; ++e)
            difference = std::max(difference, std::abs(filled[a * count + e] - before[e]));
    }
    lag.units = difference;
}

/// How far a brick lags at nine rows of its elements.
Fixed ShownDisplacement::sampled_lag(const ElasticLevels& levels, const StiffnessMap& map,
                                     Vec3i coord) const {
    const int size = m_field.brick_size(), index = m_field.find_brick(coord);
    const Vec3i first = size * coord;
    const int count = std::min(size, m_field.grid().size.x - first.x);
    BrickRow row{};
    Fixed lag = 0;
    for (const int z : {0, size / 2, size - 1})
        for (const int y : {0, size / 2, size - 1}) {
            find_row(levels, map, first + Vec3i{0, y, z}, count, row);
            const std::size_t begin = std::size_t(size) * std::size_t(y + size * z);
            for (std::size_t a = 0; a < 3; ++a) {
                const Fixed* const before = index < 0 ? nullptr : m_field.brick(index).u[a] + begin;
                for (std::size_t x = 0; x < std::size_t(count); ++x)
                    lag = std::max(lag, std::abs(rounded(row[a][x]) - (before ? before[x] : 0)));
            }
        }
    return lag;
}

/// Keeps the bricks that lag most by samples. @returns false if none lags by a length that is shown
bool ShownDisplacement::keep_farthest(const ElasticLevels& levels, const StiffnessMap& map,
                                      std::size_t most, std::vector<Lag>& lags,
                                      const TaskArena& arena) const {
    std::vector<Lag> farthest = lags;
    arena.for_each(std::int64_t(farthest.size()), 64, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n)
            farthest[std::size_t(n)].units =
                sampled_lag(levels, map, farthest[std::size_t(n)].coord);
    });
    std::erase_if(farthest, [](const Lag& lag) { return lag.units < kStill; });
    if (farthest.empty()) return false;
    most = std::min(most, farthest.size());
    std::partial_sort(farthest.begin(), farthest.begin() + std::ptrdiff_t(most), farthest.end(),
                      is_before);
    farthest.resize(most);
    lags = std::move(farthest);
    return true;
}

/// Bricks that differ from the lattices: all, or the farthest if there are more than most.
std::vector<ShownDisplacement::Lag> ShownDisplacement::find_lags(const ElasticLevels& levels,
                                                                 const StiffnessMap& map,
                                                                 std::size_t most,
                                                                 const TaskArena& arena) {
    Box3i box = levels.moved_box(kStillMm);
    const int size = m_field.brick_size();
    std::vector<Lag> lags;
    Box3i bricks;
    for (int a = 0; a < 3; ++a) {
        bricks.begin[a] = box.begin[a] / size;
        bricks.end[a] = (box.end[a] + size - 1) / size;
    }
    for (int k = bricks.begin.z; k < bricks.end.z; ++k)
        for (int j = bricks.begin.y; j < bricks.end.y; ++j)
            for (int i = bricks.begin.x; i < bricks.end.x; ++i) lags.push_back({{i, j, k}, 0});
    for (const int index : m_field.resident_bricks())
        if (!contains(bricks, m_field.brick(index).coord))
            lags.push_back({m_field.brick(index).coord, 0});
    m_is_sampled = most < lags.size() && keep_farthest(levels, map, most, lags, arena);
    m_chunks.resize((lags.size() + kBricksPerChunk - 1) / kBricksPerChunk);
    arena.for_each(std::int64_t(m_chunks.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        std::vector<Fixed> memory(3 * std::size_t(m_field.elements_per_brick()));
        for (auto chunk = std::size_t(begin); chunk < std::size_t(end); ++chunk) {
            m_chunks[chunk].clear();
            const std::size_t last = std::min(lags.size(), kBricksPerChunk * (chunk + 1));
            for (std::size_t n = kBricksPerChunk * chunk; n < last; ++n) {
                Lag& lag = lags[n];
                measure(levels, map, lag, memory);
                if (lag.units == 0) continue;
                lag.chunk = chunk;
                lag.at = m_chunks[chunk].size();
                m_chunks[chunk].insert(m_chunks[chunk].end(), memory.begin(), memory.end());
            }
        }
    });
    std::erase_if(lags, [](const Lag& lag) { return lag.units == 0; });
    return lags;
}

void ShownDisplacement::edit(EditMap& bricks) {
    m_field.prepare_edits(bricks);
    m_field.exchange_edits(bricks);
    m_field.finish_edits(bricks);
}

bool ShownDisplacement::show(const ElasticLevels& levels, const StiffnessMap& map,
                             std::int64_t max_elements, const TaskArena& arena) {
    const bool all = max_elements == std::numeric_limits<std::int64_t>::max();
    const auto most =
        std::size_t(std::max<std::int64_t>(1, max_elements / m_field.elements_per_brick()));
    std::vector<Lag> lags = find_lags(levels, map, most, arena);
    const std::size_t found = lags.size() + m_is_sampled;  // others wait
    if (!all) {
        // Small ones wait until there is no other.
        const auto is_shown = [](const Lag& lag) { return lag.units >= kStill; };
        if (std::ranges::any_of(lags, is_shown))
            std::erase_if(lags, [&](const Lag& lag) { return !is_shown(lag); });
        const auto last = lags.begin() + std::ptrdiff_t(std::min(most, lags.size()));
        std::partial_sort(lags.begin(), last, lags.end(), is_before);
        lags.erase(last, lags.end());
    }
    std::vector<int> bricks;
    const std::uint64_t made = m_field.made_count();
    try {
        for (const Lag& lag : lags) bricks.push_back(m_field.ensure_brick(lag.coord));
    } catch (...) {
        m_field.drop_made_since(made);
        throw;
    }
    if (bricks.empty()) return found == 0;
    const std::uint64_t now = m_field.tick();
    const std::size_t count = std::size_t(m_field.elements_per_brick());
    arena.for_each(std::int64_t(bricks.size()), 64, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) {
            FieldBrick& brick = m_field.brick(bricks[std::size_t(n)]);
            const Lag& lag = lags[std::size_t(n)];
            const Fixed* from = m_chunks[lag.chunk].data() + lag.at;
            for (Fixed* const to : brick.u) {
                std::copy_n(from, count, to);
                from += count;
            }
            m_field.written(brick, now);
        }
    });
    m_field.drop_still_bricks(bricks);
    return lags.size() == found;
}

}  // namespace pliant
