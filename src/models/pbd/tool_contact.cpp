// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/tool_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/surface_winding.h"

namespace pliant::pbd {
namespace {

/// Motion in a stride and by projections, as a share of the radius, within which triangles are
/// found.
constexpr double kToolReach = 0.5;
/// Least effective inverse mass of a point, as a share of its lightest node's: near fixed nodes of
/// a triangle, its free nodes would move by many times the depth otherwise.
constexpr double kLeastShare = 0.05;
constexpr int kMaxSamples = 32;  ///< of an axis that overlaps the body

mesh::Bounds box_around(const BodyTool& tool, double by) {
    mesh::Bounds box;
    box.add(tool.from);
    box.add(tool.to);
    return grown(box, by);
}

NearestPair pair_of(const BodySurface& surface, std::span<const Vec3d> x, const BodyTool& tool,
                    std::int32_t triangle) {
    const auto& t = surface.triangles()[std::size_t(triangle)];
    return nearest_pair(tool.from, tool.to, x[std::size_t(t[0])], x[std::size_t(t[1])],
                        x[std::size_t(t[2])]);
}

/// Distance of the axis from the surface; above the radius if it is at least that.
double clearance(const BodySurface& surface, const PatchBoxes& boxes, std::span<const Vec3d> x,
                 const BodyTool& tool) {
    double least = std::numeric_limits<double>::infinity();
    const mesh::Bounds around = box_around(tool, tool.radius);
    for (std::size_t p = 0; p < surface.patches().size(); ++p) {
        if (!overlap(around, boxes.box(p))) continue;
        for (std::int32_t t = surface.patches()[p].begin; t < surface.patches()[p].end; ++t)
            least = std::min(least, std::sqrt(distance2(pair_of(surface, x, tool, t))));
    }
    return least;
}

double signed_distance_at(const BodySurface& surface, const PatchBoxes& boxes,
                          std::span<const Vec3d> x, Vec3d p, SurfacePoint& nearest) {
    std::size_t first = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < surface.patches().size(); ++k)
        if (const double d = boxes.box(k).distance_squared(p); d < least) {
            least = d;
            first = k;
        }
    nearest = {};
    nearest.distance2 = std::numeric_limits<double>::infinity();
    surface.nearest_in_patch(first, p, x, nearest);
    for (std::size_t k = 0; k < surface.patches().size(); ++k)
        if (k != first && boxes.box(k).distance_squared(p) < nearest.distance2)
            surface.nearest_in_patch(k, p, x, nearest);
    return surface.signed_distance(p, nearest, x);
}

}  // namespace

BodyTool tool_at(const BodyTool& start, const BodyTool& end, double share) {
    return {(1 - share) * start.from + share * end.from, (1 - share) * start.to + share * end.to,
            start.radius};
}

ToolDepth depth_of(const BodySurface& surface, const PatchBoxes& boxes, std::span<const Vec3d> x,
                   const BodyTool& tool, double tolerated) {
    ToolDepth found;
    SurfacePoint nearest;
    const double clear = clearance(surface, boxes, x, tool);
    found.depth = std::max(0.0, tool.radius - clear);
    found.crosses = clear == 0;
    if (found.depth <= tolerated) {
        mesh::Bounds all;
        for (std::size_t p = 0; p < surface.patches().size(); ++p) all.add(boxes.box(p));
        if (all.distance_squared(tool.from) > 0 ||
            signed_distance_at(surface, boxes, x, tool.from, nearest) >= 0)
            return found;
    }
    const double length = norm(tool.to - tool.from);
    const int samples =
        length > 0 ? int(std::clamp(std::ceil(length / tool.radius), 1.0, double(kMaxSamples))) : 0;
    double inmost = std::numeric_limits<double>::infinity(), least = inmost;
    Vec3d inmost_at{0, 0, 0}, inwards{0, 0, 0}, outwards{0, 0, 0};
    for (int n = 0; n <= samples; ++n) {
        const Vec3d p = tool.from + (samples > 0 ? double(n) / samples : 0) * (tool.to - tool.from);
        const double d = signed_distance_at(surface, boxes, x, p, nearest), size = std::abs(d);
        const Vec3d away = size > 0 ? (1 / size) * (p - nearest.position)
                                    : surface.normal(nearest.triangle, nearest.feature, x);
        if (d < inmost) {
            inmost = d;
            inmost_at = p;
            inwards = away;
        }
        if (size < least) {
            least = size;
            outwards = away;
        }
    }
    if (inmost < 0 && mesh::surface_winding(surface.triangles(), x, inmost_at) > 0.5) {
        found.depth = tool.radius - inmost;
        found.out = -inwards;
    } else if (found.depth > tolerated) {
        found.out = outwards;
    }
    return found;
}

void ToolContact::look(const BodySurface& surface, const PatchBoxes& boxes,
                       std::span<const Vec3d> x, std::span<const ToolMotion> tools, double share) {
    m_rows.clear();
    m_tools.clear();
    for (std::size_t n = 0; n < tools.size(); ++n) {
        m_tools.push_back(tool_at(tools[n].start, tools[n].end, share));
        if (tools[n].is_stuck) continue;
        const mesh::Bounds around = box_around(m_tools[n], (1 + kToolReach) * m_tools[n].radius);
        for (std::size_t p = 0; p < surface.patches().size(); ++p) {
            if (!overlap(around, boxes.box(p))) continue;
            for (std::int32_t t = surface.patches()[p].begin; t < surface.patches()[p].end; ++t) {
                mesh::Bounds box;
                for (const std::int32_t m : surface.triangles()[std::size_t(t)])
                    box.add(x[std::size_t(m)]);
                if (overlap(around, box)) m_rows.push_back({std::int32_t(n), t, 0, {0, 0, 0}});
            }
        }
    }
}

double ToolContact::project(const BodySurface& surface, SurfaceMotion& motion,
                            std::span<ToolMotion> tools, int strides) {
    double deepest = 0;
    for (Row& row : m_rows) {
        const BodyTool& tool = m_tools[std::size_t(row.tool)];
        const NearestPair pair = pair_of(surface, motion.x, tool, row.triangle);
        const Vec3d d = pair.on_segment - pair.on_triangle;
        const double distance = norm(d), depth = tool.radius - distance;
        if (!(distance > 0) || (depth <= 0 && row.push == 0)) continue;
        const auto& t = surface.triangles()[std::size_t(row.triangle)];
        const auto at = [&](std::size_t k) { return std::size_t(t[k]); };
        const auto weights = mesh::weights_on_triangle(pair.on_triangle, motion.x[at(0)],
                                                       motion.x[at(1)], motion.x[at(2)]);
        double weight = 0, lightest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            weight += weights[k] * weights[k] * motion.tool_w[at(k)];
            lightest = std::max(lightest, motion.tool_w[at(k)]);
        }
        weight = std::max(weight, kLeastShare * lightest);
        if (!(weight > 0 && std::isfinite(weight))) continue;
        deepest = std::max(deepest, depth / tool.radius);
        const auto apply = [&](Vec3d impulse) {
            for (std::size_t k = 0; k < 3; ++k)
                if (motion.tool_w[at(k)] > 0)
                    motion.move(t[k], (-weights[k] * motion.tool_w[at(k)]) * impulse);
            tools[std::size_t(row.tool)].impulse = tools[std::size_t(row.tool)].impulse + impulse;
        };
        const Vec3d normal = (1 / distance) * d;
        const double push = std::max(0.0, row.push + depth / weight);
        apply((push - row.push) * normal);
        row.push = push;
        if (motion.friction == 0) continue;
        const ToolMotion& whole = tools[std::size_t(row.tool)];
        Vec3d slid = ((1 - pair.along) / strides) * (whole.end.from - whole.start.from) +
                     (pair.along / strides) * (whole.end.to - whole.start.to);
        for (std::size_t k = 0; k < 3; ++k)
            slid = slid - weights[k] * (motion.x[at(k)] - motion.before[at(k)]);
        slid = slid - dot(slid, normal) * normal;
        Vec3d drag = row.drag - (1 / weight) * slid;
        const double size = norm(drag), most = motion.friction * row.push;
        if (size > most) drag = (most / size) * drag;
        apply(drag - row.drag);
        row.drag = drag;
    }
    return deepest;
}

std::int64_t ToolContact::touches() const {
    return std::count_if(m_rows.begin(), m_rows.end(), [](const Row& row) { return row.push > 0; });
}

}  // namespace pliant::pbd
