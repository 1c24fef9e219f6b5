// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/research/graph.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "chains/graph_limits.h"

namespace pliant {
namespace {

/// Largest limit of a whole link: two halves, and never binding.
constexpr Fixed kMaxLimit = 2 * kMaxHalfLimit;

Fixed whole_limit_units(double mm) {
    const double units = std::floor(mm * kUnitsPerMm);
    return units < kMaxLimit ? Fixed(units) : kMaxLimit;
}

Error bad(const std::string& what, std::int64_t index, const std::string& expected) {
    return {ErrorCode::InvalidArgument,
            "graph: " + what + " " + std::to_string(index) + ": expected " + expected};
}

Status check_elements(std::span<const ChainElement> elements) {
    if (elements.empty() || elements.size() > std::size_t(INT32_MAX))
        return Error{
            ErrorCode::InvalidArgument,
            "graph: expected 1 to 2147483647 elements, found " + std::to_string(elements.size())};
    for (std::size_t n = 0; n < elements.size(); ++n) {
        if (!is_finite(elements[n].rest_mm))
            return bad("element", std::int64_t(n), "a rest position of three numbers");
        if (!(elements[n].max_movement_mm >= 0))
            return bad("element", std::int64_t(n), "a movement limit of 0 mm or more");
    }
    return Ok{};
}

Status check_ends(std::int64_t index, std::int32_t a, std::int32_t b, std::size_t element_count) {
    const auto is_there = [&](std::int32_t e) { return e >= 0 && std::size_t(e) < element_count; };
    if (!is_there(a) || !is_there(b) || a == b)
        return bad("link", index,
                   "two different elements between 0 and " + std::to_string(element_count - 1) +
                       ", found " + std::to_string(a) + " and " + std::to_string(b));
    return Ok{};
}

}  // namespace

HalfLink half_link(const ElementLimits& limits, Vec3d offset_mm) {
    HalfLink half{};
    for (int a = 0; a < 3; ++a) {
        const double along = std::abs(offset_mm[a]);
        double sheared = 0;
        for (int b = 0; b < 3; ++b)
            if (b != a) sheared += std::abs(offset_mm[b]) * limits.shear[b];
        const bool up = offset_mm[a] > 0;
        const double low = along * (up ? limits.compress : limits.stretch)[a] + sheared;
        const double high = along * (up ? limits.stretch : limits.compress)[a] + sheared;
        half.low[a] = limit_units_from_mm(low / 2);
        half.high[a] = limit_units_from_mm(high / 2);
    }
    return half;
}

Status check_materials(std::span<const ElementLimits> materials) {
    if (materials.empty() || materials.size() > 256)
        return Error{ErrorCode::InvalidArgument,
                     "materials: expected 1 to 256, found " + std::to_string(materials.size())};
    for (std::size_t n = 0; n < materials.size(); ++n) {
        const ElementLimits& m = materials[n];
        const auto complain = [&](const char* field) {
            return Error{ErrorCode::InvalidArgument, "materials[" + std::to_string(n) + "]." +
                                                         field + ": expected numbers of 0 or more"};
        };
        for (int a = 0; a < 3; ++a) {
            if (!(m.compress[a] >= 0 && m.compress[a] <= 1))
                return Error{
                    ErrorCode::InvalidArgument,
                    "materials[" + std::to_string(n) + "].compress: expected fractions 0 to 1"};
            if (!(m.stretch[a] >= 0)) return complain("stretch");
            if (!(m.shear[a] >= 0)) return complain("shear");
        }
        if (!(m.max_movement_mm >= 0)) return complain("max_movement_mm");
    }
    return Ok{};
}

Status check_push(const ChainGraph& graph, std::span<const std::int32_t> elements, Vec3d push_mm) {
    if (!is_finite(push_mm) || norm(push_mm) > kMaxMovementMm)
        return about("push", ErrorCode::InvalidArgument,
                     "expected three numbers and a length up to 500 mm");
    for (const std::int32_t e : elements)
        if (e < 0 || e >= graph.element_count())
            return bad("push of element", e,
                       "an element below " + std::to_string(graph.element_count()));
    return Ok{};
}

Result<ChainGraph> ChainGraph::create(std::vector<ChainElement> elements,
                                      std::span<const ChainLink> links) {
    if (const Status status = check_elements(elements); !status.ok()) return status.error();
    ChainGraph graph;
    graph.m_first.assign(elements.size() + 1, 0);
    for (std::size_t n = 0; n < links.size(); ++n) {
        const ChainLink& link = links[n];
        const Status ends = check_ends(std::int64_t(n), link.a, link.b, elements.size());
        if (!ends.ok()) return ends.error();
        for (int a = 0; a < 3; ++a)
            if (!(link.low_mm[a] <= 0 && link.high_mm[a] >= 0))
                return bad("link", std::int64_t(n), "limits with low <= 0 <= high");
        ++graph.m_first[std::size_t(link.a) + 1];
        ++graph.m_first[std::size_t(link.b) + 1];
    }
    for (std::size_t e = 0; e < elements.size(); ++e) graph.m_first[e + 1] += graph.m_first[e];
    std::vector<std::int64_t> next(graph.m_first.begin(), graph.m_first.end() - 1);
    graph.m_neighbours.resize(2 * links.size());
    for (const ChainLink& link : links) {
        Vec3i low{}, high{};
        for (int a = 0; a < 3; ++a) {
            low[a] = -whole_limit_units(-link.low_mm[a]);
            high[a] = whole_limit_units(link.high_mm[a]);
        }
        graph.m_neighbours[std::size_t(next[std::size_t(link.a)]++)] = {link.b, low, high};
        graph.m_neighbours[std::size_t(next[std::size_t(link.b)]++)] = {link.a, -high, -low};
    }
    for (ChainElement& element : elements)
        element.max_movement_mm = std::min(element.max_movement_mm, kMaxMovementMm);
    graph.m_elements = std::move(elements);
    return graph;
}

Result<ChainGraph> ChainGraph::create(std::span<const Vec3d> rest_mm,
                                      std::span<const ElementLimits> materials,
                                      std::span<const std::uint8_t> material_of,
                                      std::span<const ChainEdge> edges) {
    if (const Status status = check_materials(materials); !status.ok()) return status.error();
    if (!material_of.empty() && material_of.size() != rest_mm.size())
        return Error{ErrorCode::InvalidArgument, "graph: expected a material for each of the " +
                                                     std::to_string(rest_mm.size()) +
                                                     " elements, found " +
                                                     std::to_string(material_of.size())};
    std::vector<ChainElement> elements;
    elements.reserve(rest_mm.size());
    const auto limits_of = [&](std::size_t e) -> const ElementLimits& {
        return materials[material_of.empty() ? 0 : material_of[e]];
    };
    for (std::size_t e = 0; e < rest_mm.size(); ++e) {
        if (!material_of.empty() && material_of[e] >= materials.size())
            return bad("element", std::int64_t(e),
                       "a material below " + std::to_string(materials.size()));
        elements.push_back({rest_mm[e], limits_of(e).max_movement_mm, limits_of(e).fixed});
    }
    if (const Status status = check_elements(elements); !status.ok()) return status.error();
    std::vector<ChainLink> links;
    links.reserve(edges.size());
    for (std::size_t n = 0; n < edges.size(); ++n) {
        const auto [a, b] = edges[n];
        const Status ends = check_ends(std::int64_t(n), a, b, elements.size());
        if (!ends.ok()) return ends.error();
        const Vec3d offset = rest_mm[std::size_t(b)] - rest_mm[std::size_t(a)];
        const HalfLink one = half_link(limits_of(std::size_t(a)), offset);
        const HalfLink other = half_link(limits_of(std::size_t(b)), offset);
        links.push_back(
            {a, b, -mm_from_units(one.low + other.low), mm_from_units(one.high + other.high)});
    }
    return create(std::move(elements), links);
}

LinkState check_links(const ChainGraph& graph, std::span<const Vec3d> displacement_mm,
                      double tolerance_mm) {
    LinkState state;
    for (std::int32_t i = 0; i < graph.element_count(); ++i)
        for (const ChainNeighbour& link : graph.neighbours(i)) {
            if (link.element < i) continue;  // each link is visited from one end
            const Vec3d difference =
                displacement_mm[std::size_t(link.element)] - displacement_mm[std::size_t(i)];
            double worst = 0;
            for (int a = 0; a < 3; ++a)
                worst = std::max({worst, mm_from_units(link.low[a]) - difference[a],
                                  difference[a] - mm_from_units(link.high[a])});
            state.violated_links += worst > tolerance_mm;
            state.max_violation_mm = std::max(state.max_violation_mm, worst);
        }
    return state;
}

}  // namespace pliant
