// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pressed.h"

#include <pliant/research/rod.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "value_of.h"

namespace pliant::results {
namespace {

constexpr double kInner_mm = 4, kThickness_mm = 3, kLength_mm = 40;
constexpr double kStep_s = 2e-4, kDensity_g_mm3 = 5e-3;
constexpr int kSegments = 15;
constexpr double kWire_mm = 30, kTip_mm = 14;

bool is_outer(Vec3d p) {
    return std::hypot(p.x, p.y) > kInner_mm + kThickness_mm - 0.2;
}
bool is_inner(Vec3d p) {
    return std::hypot(p.x, p.y) < kInner_mm + 0.2;
}

Rod pressing_rod() {
    return value_of(Rod::create({.segments = kSegments,
                                 .length = kWire_mm,
                                 .mass = 0.2,
                                 .bend_stiffness = 7e6,
                                 .twist_stiffness = 7e6,
                                 .stretch_stiffness = 1e8,
                                 .shear_stiffness = 1e8,
                                 .tip_segments = int(kSegments * kTip_mm / kWire_mm),
                                 .base = {0, 0, 2},
                                 .time_step = kStep_s,
                                 .iterations = 2,
                                 .damping = 50}));
}

double thinnest_of(const VesselWall& wall, std::span<const Vec3d> positions) {
    double thinnest = 1e9;
    const auto& rest = wall.mesh.nodes_mm;
    for (std::size_t a = 0; a < rest.size(); ++a) {
        if (!is_inner(rest[a]) || rest[a].z < 5 || rest[a].z > kLength_mm - 5) continue;
        for (std::size_t b = 0; b < rest.size(); ++b)
            if (is_outer(rest[b])) thinnest = std::min(thinnest, norm(positions[a] - positions[b]));
    }
    return thinnest;
}

void count_cells(const TetMesh& mesh, PressedRun& run) {
    const auto volume = [](const std::array<Vec3d, 4>& p) {
        return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]);
    };
    int near = 0;
    for (const auto& cell : mesh.cells) {
        std::array<Vec3d, 4> p, rest;
        for (std::size_t n = 0; n < 4; ++n) {
            p[n] = run.wall_mm[std::size_t(cell[n])];
            rest[n] = mesh.nodes_mm[std::size_t(cell[n])];
        }
        const double ratio = volume(p) / volume(rest);
        if (ratio <= 0) ++run.inverted;
        if (norm(p[0] - run.wire_mm.back()) > 4) continue;
        run.mean_near_tip += std::abs(ratio - 1);
        ++near;
    }
    if (near > 0) run.mean_near_tip /= near;
}

}  // namespace

PressedVessel pressed_vessel() {
    PressedVessel vessel;
    const CentrePoint way[] = {{{0, 0, 0}, kInner_mm}, {{0, 0, kLength_mm}, kInner_mm}};
    vessel.wall = value_of(swept_tube(
        way, {.thickness_mm = kThickness_mm, .layers = 4, .sectors = 40, .ring_mm = 0.75}));
    vessel.parts =
        value_of(pbd_of_mesh(vessel.wall.mesh, {.density = kDensity_g_mm3, .bends = true}));
    for (PbdDistance& d : vessel.parts.distances) d.stiffness = kStretch;
    for (PbdBend& b : vessel.parts.bends) b.stiffness = kBend;
    for (PbdVolume& v : vessel.parts.volumes) v.stiffness = kVolume;
    for (std::size_t n = 0; n < vessel.parts.positions.size(); ++n) {
        const Vec3d p = vessel.parts.positions[n];
        if (p.z < 0.1 || p.z > kLength_mm - 0.1) vessel.parts.inverse_masses[n] = 0;
        if (is_outer(p))
            vessel.parts.attachments.push_back({.nodes = {std::int32_t(n), 0, 0, 0}, .target = p});
    }
    return vessel;
}

PressedRun run_pressed(const PressedVessel& vessel, bool volumes, double tip_deg,
                       const TaskArena& arena, int steps) {
    PbdParts parts = vessel.parts;
    if (!volumes) parts.volumes.clear();
    auto body = value_of(PbdBody::create(
        std::move(parts),
        {.time_step = kStep_s, .sub_steps = 1, .damping = 50, .method = PbdMethod::Stiffness}));
    Rod rod = pressing_rod();
    auto contact =
        value_of(RodContact::create(vessel.wall.mesh, vessel.wall.ghost,
                                    vessel.wall.ghost_positions, {.radius = kPressingRadius_mm}));
    const int bending = steps * 5 / 8;
    for (int n = 1; n <= steps; ++n) {
        if (n <= bending && n % 10 == 0)
            must(rod.steer(tip_deg * std::numbers::pi / 180 * n / bending, 0));
        must(contact.step(1, rod, body, arena));
    }
    PressedRun run;
    run.wall_mm.resize(vessel.parts.positions.size());
    body.get_positions(run.wall_mm);
    for (int n = 0; n <= kSegments; ++n) run.wire_mm.push_back(rod.position(n));
    run.change = volume_change(vessel.parts, run.wall_mm);
    count_cells(vessel.wall.mesh, run);
    for (std::size_t n = 0; n < run.wall_mm.size(); ++n)
        run.moved_mm = std::max(run.moved_mm, norm(run.wall_mm[n] - vessel.parts.positions[n]));
    run.thinnest_mm = thinnest_of(vessel.wall, run.wall_mm);
    return run;
}

}  // namespace pliant::results
