// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lumen around a centreline: the union of spheres with linearly interpolated radii along its
// segments. For a point at distance y from a segment's line, at x along it, the nearest sphere is
// at x − y·tan α, where a perpendicular meets the envelope cone, with sin α = (difference of the
// radii) / length.

#include <pliant/models/vessel.h>

#include <algorithm>
#include <cmath>

#include "base/errors.h"
#include "base/hypot.h"
#include "mesh/box_tree.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

struct Segment {
    CentrePoint from, to;
    std::size_t branch;
};

double distance_to(const Segment& s, Vec3d p) {
    const Vec3d axis = s.to.position_mm - s.from.position_mm, way = p - s.from.position_mm;
    const double length = norm(axis), narrowing = s.from.radius_mm - s.to.radius_mm;
    const double at_from = norm(way) - s.from.radius_mm;
    if (length <= std::abs(narrowing))  // one end's sphere contains the other's
        return std::min(at_from, norm(p - s.to.position_mm) - s.to.radius_mm);
    const double x = dot(way, axis) / length;
    const double y = std::sqrt(std::max(0.0, dot(way, way) - x * x));
    const double slope = narrowing / std::sqrt(length * length - narrowing * narrowing);
    const double t = std::clamp((x - y * slope) / length, 0.0, 1.0);
    return hypot(x - t * length, y) - (s.from.radius_mm - t * narrowing);
}

Status check(const Centreline& centreline) {
    bool any = false;
    for (std::size_t b = 0; b < centreline.branches.size(); ++b) {
        const auto& branch = centreline.branches[b];
        const std::string name = "centreline: branch " + std::to_string(b);
        if (branch.size() < 2)
            return Error{
                ErrorCode::InvalidArgument,
                name + " has " + std::to_string(branch.size()) + " points, expected 2 or more"};
        for (std::size_t n = 0; n < branch.size(); ++n)
            if (!is_finite(branch[n].position_mm) || !std::isfinite(branch[n].radius_mm) ||
                !(branch[n].radius_mm > 0))
                return Error{ErrorCode::InvalidArgument,
                             name + ", point " + std::to_string(n) + ": radius " +
                                 std::to_string(branch[n].radius_mm) +
                                 " mm, expected a finite position and a radius above 0"};
        any = true;
    }
    if (!any)
        return Error{ErrorCode::InvalidArgument,
                     "centreline: found no branches, expected one or more"};
    return Ok{};
}

std::vector<Segment> segments_of(const Centreline& centreline) {
    std::vector<Segment> segments;
    for (std::size_t b = 0; b < centreline.branches.size(); ++b)
        for (std::size_t n = 0; n + 1 < centreline.branches[b].size(); ++n)
            segments.push_back({centreline.branches[b][n], centreline.branches[b][n + 1], b});
    return segments;
}

Result<Centreline> branches_of(const MeshData& mesh) {
    const MeshData::Field* radius = nullptr;
    for (const char* name : {"MaximumInscribedSphereRadius", "Radius", "radius"})
        if (!radius) radius = mesh.field(name);
    if (!radius || radius->components != 1)
        return Error{ErrorCode::InvalidArgument,
                     "centreline: found no numbers named MaximumInscribedSphereRadius, Radius or "
                     "radius at its points"};
    Centreline centreline;
    for (const auto& line : mesh.lines) {
        centreline.branches.emplace_back();
        for (const std::int32_t n : line)
            centreline.branches.back().push_back(
                {mesh.nodes_mm[std::size_t(n)], radius->values[std::size_t(n)]});
    }
    if (const Status s = check(centreline); !s) return s.error();
    return centreline;
}

}  // namespace

Result<Centreline> centreline_of(const MeshData& mesh) noexcept {
    return attempt([&] { return branches_of(mesh); });
}

std::vector<VesselEnd> ends_of(const Centreline& centreline, double inwards) {
    struct Tip {
        VesselEnd end;
        std::size_t branch;
    };
    std::vector<Tip> tips;
    for (std::size_t b = 0; b < centreline.branches.size(); ++b) {
        const auto& branch = centreline.branches[b];
        if (branch.size() < 2) continue;
        for (const bool last : {false, true}) {
            const auto at = [&](std::size_t n) { return branch[last ? branch.size() - 1 - n : n]; };
            const CentrePoint tip = at(0);
            // Averages the direction over about a radius, because single segments are noisy.
            std::size_t back = 1;
            while (back + 1 < branch.size() &&
                   norm(at(back).position_mm - tip.position_mm) < tip.radius_mm)
                ++back;
            const Vec3d way = tip.position_mm - at(back).position_mm;
            if (norm(way) > 0)
                tips.push_back({{tip.position_mm, normalized(way), tip.radius_mm}, b});
        }
    }
    // A tip deep in another branch is a junction. If several tips meet, tips with equal
    // directions are duplicates of one end; others are a junction too.
    const auto segments = segments_of(centreline);
    const auto is_end = [&](std::size_t t) {
        const VesselEnd& end = tips[t].end;
        const double near = 0.5 * end.radius_mm;
        std::vector<bool> meets(centreline.branches.size(), false);
        for (std::size_t u = 0; u < tips.size(); ++u) {
            if (u == t || norm(tips[u].end.centre_mm - end.centre_mm) > near) continue;
            meets[tips[u].branch] = true;
            if (dot(tips[u].end.outward, end.outward) < 0.5 || u < t) return false;
        }
        return std::none_of(segments.begin(), segments.end(), [&](const Segment& s) {
            return s.branch != tips[t].branch && !meets[s.branch] &&
                   distance_to(s, end.centre_mm) < -near;
        });
    };
    std::vector<VesselEnd> ends;
    for (std::size_t t = 0; t < tips.size(); ++t) {
        if (!is_end(t)) continue;
        VesselEnd end = tips[t].end;
        end.centre_mm = end.centre_mm - (inwards * end.radius_mm) * end.outward;
        ends.push_back(end);
    }
    return ends;
}

namespace {

Result<VesselWall> wall_around_branches(const Centreline& centreline, const WallSettings& settings,
                                        const TaskArena& arena) {
    if (const Status s = check(centreline); !s) return s.error();
    const auto segments = segments_of(centreline);
    std::vector<mesh::Bounds> boxes(segments.size());
    mesh::Bounds all;
    for (std::size_t n = 0; n < segments.size(); ++n) {
        for (const CentrePoint& p : {segments[n].from, segments[n].to}) {
            boxes[n].add(p.position_mm - Vec3d{p.radius_mm, p.radius_mm, p.radius_mm});
            boxes[n].add(p.position_mm + Vec3d{p.radius_mm, p.radius_mm, p.radius_mm});
        }
        all.add(boxes[n]);
    }
    const mesh::BoxTree tree(boxes);
    vessel::LumenShape lumen;
    lumen.distance_mm = [&](Vec3d x) {
        double least = std::numeric_limits<double>::infinity();
        tree.nearest(x, least, [&](std::int32_t n, double& limit) {
            least = std::min(least, distance_to(segments[std::size_t(n)], x));
            // Inside of a sphere, only boxes around the point can contain a deeper one.
            limit = least > 0 ? least * least : 0;
        });
        return least;
    };
    lumen.begin_mm = all.low;
    lumen.end_mm = all.high;
    lumen.ends = ends_of(centreline);
    return vessel::make_wall(lumen, settings, arena);
}

}  // namespace

Result<VesselWall> wall_around_centreline(const Centreline& centreline,
                                          const WallSettings& settings,
                                          const TaskArena& arena) noexcept {
    return attempt([&] { return wall_around_branches(centreline, settings, arena); });
}

}  // namespace pliant
