// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "catheter/scene_parts.h"

#include <pliant/mesh.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "base/units.h"
#include "catheter/frame_along.h"
#include "vessel/wall.h"

namespace pliant::catheter {
namespace {

int segments_of(const CatheterShape& c) {
    return std::max(2, int(std::lround(c.length_mm / c.segment_mm)));
}

double mean_edge_mm(const TetMesh& mesh) {
    double edge = 0;
    for (const auto& cell : mesh.cells)
        edge += norm(mesh.nodes_mm[std::size_t(cell[0])] - mesh.nodes_mm[std::size_t(cell[1])]) /
                double(mesh.cells.size());
    return edge;
}

/// Volume constraints of stiffness 0 stay, for the measure of the volumes. A rigid wall has none.
Result<PbdParts> constraints_of(const TetMesh& mesh, const WallTissue& tissue) {
    const bool solids = tissue.model == WallModel::Solid,
               distances = tissue.model == WallModel::Distances;
    auto parts = pbd_of_mesh(mesh, {.density = tissue.density_g_mm3,
                                    .edges = distances && tissue.stretch_stiffness > 0,
                                    .volumes = distances,
                                    .bends = distances && tissue.bend_stiffness > 0,
                                    .solids = solids,
                                    .young_modulus = tissue.young_modulus_pa,
                                    .poisson_ratio = tissue.poisson_ratio});
    if (!parts) return parts.error();
    for (PbdDistance& d : parts->distances) d.stiffness = tissue.stretch_stiffness;
    for (PbdBend& b : parts->bends) b.stiffness = tissue.bend_stiffness;
    for (PbdVolume& v : parts->volumes) v.stiffness = tissue.volume_stiffness;
    return parts;
}

Result<PbdParts> parts_of(const VesselWall& wall, const WallTissue& tissue) {
    auto parts = constraints_of(wall.mesh, tissue);
    if (!parts) return parts.error();
    if (tissue.model == WallModel::Rigid) {
        parts->inverse_masses.assign(parts->inverse_masses.size(), 0);
        return parts;
    }
    const auto& positions = wall.mesh.nodes_mm;
    const double edge = mean_edge_mm(wall.mesh);
    for (const VesselEnd& end : wall.ends)
        for (std::size_t n = 0; n < positions.size(); ++n) {
            const Vec3d from = positions[n] - end.centre_mm;
            if (std::abs(dot(from, end.outward)) < edge && norm(from) < 3 * end.radius_mm + 5)
                parts->inverse_masses[n] = 0;
        }
    if (tissue.support_pa_per_mm == 0) return parts;
    // The outer surface is the boundary without the faces to the lumen.
    const auto closed = vessel::with_lids(wall.ghost);
    if (!closed) return closed.error();
    const auto lumen = SurfaceDistance::create(*closed);
    if (!lumen) return lumen.error();
    const auto faces = boundary_faces(wall.mesh);
    std::vector<double> area(positions.size(), 0);
    std::vector<std::uint8_t> inner(positions.size(), 0), seen(positions.size(), 0);
    for (const auto& f : faces)
        for (const std::int32_t n : f)
            if (!std::exchange(seen[std::size_t(n)], std::uint8_t(1)))
                inner[std::size_t(n)] =
                    lumen->nearest(positions[std::size_t(n)], 0.5 * edge).triangle >= 0;
    for (const auto& f : faces) {
        const Vec3d a = positions[std::size_t(f[0])], b = positions[std::size_t(f[1])],
                    c = positions[std::size_t(f[2])];
        if (inner[std::size_t(f[0])] && inner[std::size_t(f[1])] && inner[std::size_t(f[2])])
            continue;
        for (const std::int32_t n : f) area[std::size_t(n)] += 0.5 * norm(cross(b - a, c - a)) / 3;
    }
    for (std::size_t n = 0; n < positions.size(); ++n)
        if (area[n] > 0 && parts->inverse_masses[n] > 0)
            parts->attachments.push_back({.nodes = {std::int32_t(n), 0, 0, 0},
                                          .target = positions[n],
                                          .compliance = 1 / (tissue.support_pa_per_mm * area[n])});
    return parts;
}

}  // namespace

Status check(const CatheterSettings& s) {
    if (const Status ranges = check(s, catheter_rows()); !ranges) return ranges;
    const WallTissue& wall = s.wall;
    if (wall.model == WallModel::Distances &&
        wall.stretch_stiffness + wall.bend_stiffness + wall.volume_stiffness == 0)
        return expected_error("[wall] stretch_stiffness", "one of the three stiffnesses above 0",
                              "none");
    if (wall.alternates && wall.iterations % 2 != 0)
        return expected_error("[wall] iterations", "an even number beside alternates",
                              std::to_string(wall.iterations));
    const double length_mm = s.catheter.length_mm;
    if (s.catheter.tip_mm > length_mm)
        return expected_error("[catheter] tip_mm", "up to length_mm, " + text_of(length_mm),
                              text_of(s.catheter.tip_mm));
    if (s.entry.inserted_mm > length_mm)
        return expected_error("[entry] inserted_mm", "up to length_mm, " + text_of(length_mm),
                              text_of(s.entry.inserted_mm));
    if (s.reach_mm < 0 && s.reach_mm != -1)
        return expected_error("[simulation] reach_mm", "-1, or 0 to 1000 mm", text_of(s.reach_mm));
    if (!(norm(s.entry.direction) > 1e-9))
        return expected_error("[entry] direction", "a vector that isn't zero",
                              text_of(s.entry.direction));
    return Ok{};
}

Status check_entry(const VesselWall& wall, const CatheterEntry& entry, double segment_mm) {
    const auto lumen = vessel::with_lids(wall.ghost);
    if (!lumen) return lumen.error();
    if (!vessel::is_inside(*lumen, entry.position_mm))
        return invalid("[entry] place_mm: expected a position in the vessel's lumen, found " +
                       text_of(entry.position_mm) + " outside of it");
    const Vec3d ahead = normalized(entry.direction);
    const int pieces = int(std::ceil(entry.inserted_mm / segment_mm));
    for (int n = 1; n <= pieces; ++n) {
        const Vec3d p = entry.position_mm + (entry.inserted_mm * n / pieces) * ahead;
        if (!vessel::is_inside(*lumen, p))
            return invalid(
                "[entry] inserted_mm: expected the length inserted at first in the vessel's "
                "lumen, found " +
                text_of(p) + " outside of it");
    }
    return Ok{};
}

double contact_mm_per_n_of(const CatheterShape& c) {
    constexpr double kMost = 0.1, kShare_mm3 = 10;
    if (c.contact_mm_per_n > 0) return c.contact_mm_per_n;
    return std::min(kMost, kShare_mm3 / std::max(c.bend_n_mm2, c.tip_bend_n_mm2));
}

/// Number of sub-steps that a step needs. In a sub-step h, a free node of the tip moves by
/// h² EI/(l³ m) times its residual, limited to a factor of 3, and a wave in a wall of solids by
/// h √(E/ρ), limited to 1.3 edges.
std::int32_t needed_sub_steps(const VesselWall& wall, const CatheterSettings& s) {
    constexpr double kTip = 3, kEdges = 1.3, kMost = 1e9;
    const CatheterShape& c = s.catheter;
    const double l = c.length_mm / segments_of(c);
    const double tip = s.time_step_s * std::sqrt(c.tip_bend_n_mm2 * kMicronewtonsPerNewton /
                                                 (kTip * l * l * l * l * c.mass_g_mm));
    const bool has_waves = s.wall.model == WallModel::Solid;
    const double speed = has_waves ? std::sqrt(s.wall.young_modulus_pa / s.wall.density_g_mm3) : 0;
    const double wave = s.time_step_s * speed / (kEdges * mean_edge_mm(wall.mesh));
    return std::max(s.sub_steps, std::int32_t(std::min(kMost, std::ceil(std::max(tip, wave)))));
}

Result<PbdBody> body_of(const VesselWall& wall, const CatheterSettings& settings) {
    const WallTissue& tissue = settings.wall;
    auto parts = parts_of(wall, tissue);
    if (!parts) return invalid("wall: " + parts.error().message);
    return PbdBody::create(
        std::move(*parts),
        {.time_step = settings.time_step_s / settings.sub_steps,
         .sub_steps = 1,
         .iterations = tissue.iterations,
         .gravity = tissue.gravity_mm_s2,
         .damping = tissue.damping_per_s,
         .method = tissue.model == WallModel::Solid ? PbdMethod::Compliance : PbdMethod::Stiffness,
         .alternates = tissue.alternates,
         .repacks = settings.local});
}

WireSettings wire_settings(const CatheterSettings& s) {
    const CatheterShape& c = s.catheter;
    WireSettings w;
    w.segments = segments_of(c);
    w.segment_mm = c.length_mm / w.segments;
    w.mass_g_mm = c.mass_g_mm;
    w.damping = c.damping_per_s;
    w.tip_segments = int(std::lround(c.tip_mm / w.segment_mm));
    w.entry = s.entry.position_mm;
    w.frame = frame_along(s.entry.direction);
    const auto count = std::size_t(w.segments), tip = std::size_t(w.tip_segments);
    w.bend.assign(count, c.bend_n_mm2 * kMicronewtonsPerNewton);
    w.twist.assign(count, c.twist_n_mm2 * kMicronewtonsPerNewton);
    // The transition from stiff to soft is as long as the tip.
    for (std::size_t n = 0; n < std::min(count, 2 * tip); ++n) {
        const double share = n < tip ? 0 : double(n - tip + 1) / double(tip + 1);
        w.bend[count - 1 - n] =
            kMicronewtonsPerNewton *
            (c.tip_bend_n_mm2 * std::pow(c.bend_n_mm2 / c.tip_bend_n_mm2, share));
    }
    return w;
}

}  // namespace pliant::catheter
