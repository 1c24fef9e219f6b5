// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "field/element_edits.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <string>
#include <tuple>
#include <utility>

#include "base/errors.h"
#include "field/brick_search.h"
#include "field/cell_block.h"
#include "field/fixed_point.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

/// Largest distance of a ribbon's points from the scan's origin [mm]: 2³⁷ units.
constexpr double kFarthestMm = 1e5;

/// A capsule along the lattice's axes [fixed-point units].
struct Capsule {
    Vec3d from, along;
    double radius;

    bool holds(Position p) const {
        const Vec3d away{double(p.x) - from.x, double(p.y) - from.y, double(p.z) - from.z};
        const double length = dot(along, along);
        const double t = length > 0 ? std::clamp(dot(away, along) / length, 0.0, 1.0) : 0;
        const Vec3d apart = away - t * along;
        return dot(apart, apart) <= radius * radius;
    }
    PositionBox box() const {
        PositionBox box{};
        for (int a = 0; a < 3; ++a) {
            const double low = from[a] + std::min(along[a], 0.0) - radius;
            const double high = from[a] + std::max(along[a], 0.0) + radius;
            box.low[a] = std::llround(std::floor(low));
            box.high[a] = std::llround(std::ceil(high));
        }
        return box;
    }
};

Result<Capsule> capsule_of(const Grid& grid, const CarveTool& tool) {
    const Vec3d from = lattice_from_world_vector(grid, tool.from_mm - grid.origin_mm);
    const Vec3d along = lattice_from_world_vector(grid, tool.to_mm - tool.from_mm);
    if (!(norm(from) <= 1e5 && norm(along) <= 1e5))
        return about("carve", ErrorCode::InvalidArgument,
                     "expected positions within 100000 mm of the scan, found others");
    if (!(tool.radius_mm > 0 && tool.radius_mm <= kMaxMovementMm))
        return about(
            "carve", ErrorCode::InvalidArgument,
            "expected a radius above 0, up to 500 mm, found " + std::to_string(tool.radius_mm));
    return Capsule{kUnitsPerMm * from, kUnitsPerMm * along, kUnitsPerMm * tool.radius_mm};
}

/// Cuts the links of one brick: holds positions of its elements and of the next layer on the high
/// sides.
class BrickCutter {
  public:
    BrickCutter(const Field& field, const ElementFacts& facts, Vec3i coord) : m_facts(facts) {
        m_block.load(field, coord);
        m_row = field.brick_size() + 1;
        const BrickEdits* edits = field.edits_of(coord);
        m_edits = edits ? *edits : BrickEdits(std::size_t(field.elements_per_brick()), 0);
        m_positions.reserve(std::size_t(m_row) * std::size_t(m_row) * std::size_t(m_row));
        for (int z = 0; z < m_row; ++z)
            for (int y = 0; y < m_row; ++y)
                for (int x = 0; x < m_row; ++x)
                    m_positions.push_back(moved_position(
                        rest_position(field.grid(), m_block.first_element() + Vec3i{x, y, z}),
                        m_block.displacement(m_block.index(x, y, z))));
        m_sides.resize(m_positions.size());
    }

    void cut(const Triangle& triangle) {
        const BladePlane plane(triangle);
        for (std::size_t n = 0; n < m_positions.size(); ++n)
            m_sides[n] = std::int8_t(plane.side(m_positions[n]));
        const int size = m_row - 1;
        for (int z = 0; z < size; ++z)
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x)
                    for (int b = 0; b < 3; ++b) cut_link(triangle, {x, y, z}, b);
    }

    std::int64_t cut_count() const { return m_count; }
    /// Whether any of them joined tissue of the scan.
    bool is_in_tissue() const { return m_in_tissue; }
    BrickEdits take_edits() { return std::move(m_edits); }

  private:
    void cut_link(const Triangle& triangle, Vec3i local, int b) {
        const int step = b == 0 ? 1 : b == 1 ? m_row : m_row * m_row;
        const auto p = std::size_t(m_block.index(local.x, local.y, local.z));
        const std::size_t q = p + std::size_t(step);
        if (m_sides[p] == m_sides[q]) return;
        const int size = m_row - 1;
        auto& flags = m_edits[std::size_t(local.x + size * (local.y + size * local.z))];
        if (flags & (kCutX << b)) return;
        if (!passes_inside(triangle, m_positions[p], m_positions[q])) return;
        const Vec3i e = m_block.first_element() + local;
        const Vec3i f = e + Vec3i{b == 0, b == 1, b == 2};
        if (m_facts.is_void(e) || m_facts.is_void(f)) return;
        flags = std::uint8_t(flags | kCutX << b);
        ++m_count;
        m_in_tissue = m_in_tissue || (m_facts.is_tissue(e) && m_facts.is_tissue(f));
    }

    const ElementFacts& m_facts;
    CellBlock m_block;
    int m_row = 0;
    BrickEdits m_edits;
    std::vector<Position> m_positions;
    std::vector<std::int8_t> m_sides;
    std::int64_t m_count = 0;
    bool m_in_tissue = false;
};

/// A brick, and a triangle that may cross one of its links.
struct Candidate {
    Vec3i coord;
    int triangle;
};

/// Whether the plane passes through the box, or can do so by a rounding error.
bool passes_through(const BladePlane& plane, const PositionBox& box) {
    double nearest = 0, size = 0;
    for (int a = 0; a < 3; ++a) {
        const double n = double(plane.normal[a]);
        const double middle = 0.5 * double(box.low[a] + box.high[a]) - double(plane.through[a]);
        nearest += n * middle;
        size += std::abs(n) * (0.5 * double(box.high[a] - box.low[a]) + 2);
    }
    return std::abs(nearest) <= size * (1 + 1e-9);
}

PositionBox box_of(const Triangle& t) {
    PositionBox box{t[0], t[0]};
    for (const Position& p : t)
        for (int a = 0; a < 3; ++a) {
            box.low[a] = std::min(box.low[a], p[a]);
            box.high[a] = std::max(box.high[a], p[a]);
        }
    return box;
}

/// Candidates, sorted by brick. @returns false if there are too many elements to examine
bool find_candidates(const Field& field, std::span<const Triangle> ribbon,
                     std::int64_t max_elements, std::vector<Candidate>& candidates) {
    const BrickSearch search(field);
    const std::int64_t max_bricks = max_elements / field.elements_per_brick() + 8;
    std::int64_t looked_at = 0;
    for (std::size_t t = 0; t < ribbon.size(); ++t) {
        const BladePlane plane(ribbon[t]);
        if (plane.is_flat()) continue;
        looked_at += search.brick_count(box_of(ribbon[t]));
        if (looked_at > 64 * max_bricks) return false;
        const auto visit = [&](Vec3i coord, const PositionBox& box) {
            if (passes_through(plane, box)) candidates.push_back({coord, int(t)});
        };
        search.for_each_brick(box_of(ribbon[t]), visit,
                              [&](const PositionBox& box) { return passes_through(plane, box); });
        if (std::int64_t(candidates.size()) > max_bricks) return false;
    }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& p, const Candidate& q) {
        return std::tie(p.coord.z, p.coord.y, p.coord.x, p.triangle) <
               std::tie(q.coord.z, q.coord.y, q.coord.x, q.triangle);
    });
    return true;
}

}  // namespace

Result<std::vector<Triangle>> ribbon_of(const Grid& grid, const CutSurface& surface) {
    if (surface.line_mm.size() < 2)
        return about("cut", ErrorCode::InvalidArgument,
                     "expected a line of two or more points, found " +
                         std::to_string(surface.line_mm.size()));
    const auto position_of = [&](Vec3d mm) {
        return Position{std::llround(mm.x * kUnitsPerMm), std::llround(mm.y * kUnitsPerMm),
                        std::llround(mm.z * kUnitsPerMm)};
    };
    const Vec3d depth_mm = lattice_from_world_vector(grid, surface.depth_mm);
    std::vector<Position> line;
    for (const Vec3d& point : surface.line_mm) {
        const Vec3d mm = lattice_from_world_vector(grid, point - grid.origin_mm);
        if (!(norm(mm) <= kFarthestMm && norm(depth_mm) <= kFarthestMm))
            return about("cut", ErrorCode::InvalidArgument,
                         "expected points and a depth within 100000 mm, found others");
        line.push_back(position_of(mm));
    }
    const Position depth = position_of(depth_mm);
    std::vector<Triangle> ribbon;
    for (std::size_t n = 0; n + 1 < line.size(); ++n) {
        const auto [first, second] = swept(line[n], line[n + 1], depth);
        if (BladePlane(first).is_flat()) continue;
        ribbon.push_back(first);
        ribbon.push_back(second);
    }
    if (ribbon.empty())
        return about("cut", ErrorCode::InvalidArgument,
                     "expected a depth that leads away from the line, found a surface of no "
                     "area");
    return ribbon;
}

Result<NewEdits> find_cuts(const Field& field, const ElementFacts& facts,
                           std::span<const Triangle> ribbon, const TaskArena& arena) {
    std::vector<Candidate> candidates;
    if (!find_candidates(field, ribbon, facts.max_elements, candidates))
        return about("cut", ErrorCode::LimitExceeded,
                     "the blade passes through more than " + std::to_string(facts.max_elements) +
                         " elements, expected a smaller one" + facts.remedy);
    std::vector<std::size_t> starts;  // start of each brick's candidates
    for (std::size_t n = 0; n < candidates.size(); ++n)
        if (n == 0 || candidates[n].coord != candidates[n - 1].coord) starts.push_back(n);
    starts.push_back(candidates.size());
    std::vector<BrickEdits> edits(starts.size() - 1);
    std::vector<std::int64_t> counts(edits.size(), 0);
    std::atomic<bool> in_tissue = false;
    arena.for_each(std::int64_t(edits.size()), 4, [&](std::int64_t begin, std::int64_t end) {
        for (auto k = std::size_t(begin); k < std::size_t(end); ++k) {
            BrickCutter cutter(field, facts, candidates[starts[k]].coord);
            for (std::size_t n = starts[k]; n < starts[k + 1]; ++n)
                cutter.cut(ribbon[std::size_t(candidates[n].triangle)]);
            counts[k] = cutter.cut_count();
            if (cutter.is_in_tissue()) in_tissue = true;
            if (counts[k] > 0) edits[k] = cutter.take_edits();
        }
    });
    NewEdits cuts{.in_tissue = in_tissue};
    for (std::size_t k = 0; k < edits.size(); ++k) {
        if (counts[k] > 0) cuts.bricks.emplace(candidates[starts[k]].coord, std::move(edits[k]));
        cuts.count += counts[k];
    }
    return cuts;
}

Result<NewEdits> find_carved(const Field& field, const ElementFacts& facts, const CarveTool& tool) {
    const auto capsule = capsule_of(field.grid(), tool);
    if (!capsule.ok()) return capsule.error();
    const BrickSearch search(field);
    if (search.brick_count(capsule->box()) > facts.max_elements / field.elements_per_brick() + 8)
        return about("carve", ErrorCode::LimitExceeded,
                     "the tool holds more than " + std::to_string(facts.max_elements) +
                         " elements, expected a smaller one" + facts.remedy);
    NewEdits carved;
    search.for_each_brick(capsule->box(), [&](Vec3i coord, const PositionBox&) {
        const BrickEdits* before = field.edits_of(coord);
        BrickEdits edits =
            before ? *before : BrickEdits(std::size_t(field.elements_per_brick()), 0);
        std::int64_t count = 0;
        for (std::size_t n = 0; n < edits.size(); ++n) {
            const Vec3i e = field.element_of(coord, int(n));
            if (!capsule->holds(
                    moved_position(rest_position(field.grid(), e), field.displacement_at(e))))
                continue;
            if (facts.is_void(e) || (tool.spare_fixed && facts.never_moves(e))) continue;
            edits[n] |= kVoid;
            ++count;
            carved.in_tissue = carved.in_tissue || facts.is_tissue(e);
        }
        carved.count += count;
        if (count > 0) carved.bricks.emplace(coord, std::move(edits));
    });
    return carved;
}

}  // namespace pliant
