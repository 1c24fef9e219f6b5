// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A step: boxes near the wire wake up; which triangles are near; then sub-steps, in each of which
// wall and wire are moved freely and meet in the wire's Newton step.
//
// Units inside are g, mm, s: forces in µN, moduli in Pa, energies in nJ.

#include <pliant/catheter.h>
#include <pliant/pbd_boxes.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "catheter/frame_along.h"
#include "catheter/rod_wire.h"
#include "catheter/tet_wire.h"
#include "catheter/wall_contact.h"
#include "core/errors.h"
#include "core/hash.h"
#include "pbd/solver.h"

namespace pliant {
namespace {

using std::numbers::pi;

constexpr double kMicronewtons = 1e6;
constexpr double kNanojoules = 1e6;  ///< in a millijoule

std::string text_of(double value) {
    std::string text = std::to_string(value);
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
    return text;
}

struct Bound {
    const char* name;
    double value, least, most;
};

int segments_of(const CatheterShape& c) {
    return std::max(2, int(std::lround(c.length_mm / c.segment_mm)));
}

Status check_twist(const CatheterShape& c) {
    const auto bounds =
        catheter::twist_bounds(c.bend_n_mm2, c.radius_mm, c.length_mm / segments_of(c));
    if (c.twist_n_mm2 >= bounds.least && c.twist_n_mm2 <= bounds.most) return Ok{};
    return invalid("catheter.twist_n_mm2: expected " + text_of(bounds.least) + " to " +
                   text_of(bounds.most) +
                   " with tetrahedra of this segment_mm, radius_mm and bend_n_mm2, found " +
                   text_of(c.twist_n_mm2));
}

Status check(const CatheterSettings& s) {
    const Bound bounds[] = {{"catheter.length_mm", s.catheter.length_mm, 10, 3000},
                            {"catheter.segment_mm", s.catheter.segment_mm, 0.2, 20},
                            {"catheter.radius_mm", s.catheter.radius_mm, 0.1, 5},
                            {"catheter.bend_n_mm2", s.catheter.bend_n_mm2, 1e-3, 1e4},
                            {"catheter.twist_n_mm2", s.catheter.twist_n_mm2, 1e-3, 1e4},
                            {"catheter.tip_mm", s.catheter.tip_mm, 0, s.catheter.length_mm},
                            {"catheter.tip_bend_n_mm2", s.catheter.tip_bend_n_mm2, 1e-3, 1e4},
                            {"catheter.mass_g_mm", s.catheter.mass_g_mm, 1e-5, 1},
                            {"catheter.damping_per_s", s.catheter.damping_per_s, 0, 1000},
                            {"catheter.friction", s.catheter.friction, 0, 2},
                            {"wall.young_modulus_pa", s.wall.young_modulus_pa, 1e3, 1e8},
                            {"wall.poisson_ratio", s.wall.poisson_ratio, 0.01, 0.499},
                            {"wall.density_g_mm3", s.wall.density_g_mm3, 1e-4, 10},
                            {"wall.support_pa_per_mm", s.wall.support_pa_per_mm, 0, 1e6},
                            {"wall.damping_per_s", s.wall.damping_per_s, 0, 1000},
                            {"entry.inserted_mm", s.entry.inserted_mm, 0, s.catheter.length_mm},
                            {"box_mm", s.box_mm, 1, 1000},
                            {"reach_mm", s.reach_mm, 0, 1000},
                            {"time_step_s", s.time_step_s, 1e-5, 0.05},
                            {"sub_steps", double(s.sub_steps), 1, 1000},
                            {"iterations", double(s.iterations), 1, 100}};
    for (const Bound& b : bounds)
        if (!(b.value >= b.least && b.value <= b.most))
            return invalid(std::string(b.name) + ": expected " + text_of(b.least) + " to " +
                           text_of(b.most) + ", found " + text_of(b.value));
    if (!is_finite(s.entry.place_mm)) return invalid("entry.place_mm: expected three numbers");
    if (!is_finite(s.entry.direction) || !(norm(s.entry.direction) > 1e-9))
        return invalid("entry.direction: expected a vector that isn't zero");
    return s.catheter.model == CatheterModel::Tetrahedra ? check_twist(s.catheter) : Ok{};
}

/// The wall as neo-Hookean tissue on a foundation, held at its open ends.
Result<PbdParts> parts_of(const VesselWall& wall, const WallTissue& tissue) {
    auto parts = pbd_of_mesh(wall.mesh, {.density = tissue.density_g_mm3,
                                         .edges = false,
                                         .volumes = false,
                                         .solids = true,
                                         .young_modulus = tissue.young_modulus_pa,
                                         .poisson_ratio = tissue.poisson_ratio});
    if (!parts) return parts.error();
    const auto& places = wall.mesh.nodes_mm;
    double edge = 0;
    for (const auto& cell : wall.mesh.cells)
        edge += norm(places[std::size_t(cell[0])] - places[std::size_t(cell[1])]) /
                double(wall.mesh.cells.size());
    for (const VesselEnd& end : wall.ends)
        for (std::size_t n = 0; n < places.size(); ++n) {
            const Vec3d from = places[n] - end.centre_mm;
            if (std::abs(dot(from, end.outward)) < edge && norm(from) < 3 * end.radius_mm + 5)
                parts->inverse_masses[n] = 0;
        }
    if (tissue.support_pa_per_mm == 0) return parts;
    // The outer surface, which is the boundary without the ghost's side.
    std::vector<double> area(places.size(), 0);
    std::vector<std::uint8_t> inner(places.size(), 0);
    for (const Embedded& e : wall.ghost_places)
        for (std::size_t k = 0; k < 4; ++k)
            if (e.weights[k] > 0.999)
                inner[std::size_t(wall.mesh.cells[std::size_t(e.tetrahedron)][k])] = 1;
    for (const auto& f : boundary_faces(wall.mesh)) {
        const Vec3d a = places[std::size_t(f[0])], b = places[std::size_t(f[1])],
                    c = places[std::size_t(f[2])];
        if (inner[std::size_t(f[0])] && inner[std::size_t(f[1])] && inner[std::size_t(f[2])])
            continue;
        for (const std::int32_t n : f) area[std::size_t(n)] += 0.5 * norm(cross(b - a, c - a)) / 3;
    }
    for (std::size_t n = 0; n < places.size(); ++n)
        if (area[n] > 0 && parts->inverse_masses[n] > 0)
            parts->attachments.push_back({.nodes = {std::int32_t(n), 0, 0, 0},
                                          .target = places[n],
                                          .compliance = 1 / (tissue.support_pa_per_mm * area[n])});
    return parts;
}

catheter::WireSettings wire_settings(const CatheterSettings& s) {
    const CatheterShape& c = s.catheter;
    catheter::WireSettings w;
    w.segments = segments_of(c);
    w.segment_mm = c.length_mm / w.segments;
    w.mass_g_mm = c.mass_g_mm;
    w.damping = c.damping_per_s;
    w.tip_segments = int(std::lround(c.tip_mm / w.segment_mm));
    w.entry = s.entry.place_mm;
    w.frame = catheter::frame_along(s.entry.direction);
    w.radius_mm = c.radius_mm;
    const auto count = std::size_t(w.segments), tip = std::size_t(w.tip_segments);
    w.bend.assign(count, c.bend_n_mm2 * kMicronewtons);
    w.twist.assign(count, c.twist_n_mm2 * kMicronewtons);
    // From stiff to soft over as long a way as the tip.
    for (std::size_t n = 0; n < std::min(count, 2 * tip); ++n) {
        const double share = n < tip ? 0 : double(n - tip + 1) / double(tip + 1);
        w.bend[count - 1 - n] =
            kMicronewtons * (c.tip_bend_n_mm2 * std::pow(c.bend_n_mm2 / c.tip_bend_n_mm2, share));
    }
    if (c.model == CatheterModel::Tetrahedra)
        for (std::size_t n = 0; n < count; ++n)
            w.twist[n] = c.twist_n_mm2 / c.bend_n_mm2 * w.bend[n];
    return w;
}

std::unique_ptr<catheter::Wire> make_wire(const CatheterSettings& s) {
    if (s.catheter.model == CatheterModel::Tetrahedra)
        return std::make_unique<catheter::TetWire>(wire_settings(s), s.entry.inserted_mm);
    return std::make_unique<catheter::RodWire>(wire_settings(s), s.entry.inserted_mm);
}

}  // namespace

CatheterEntry entry_at(const VesselEnd& end, double inwards) {
    return {end.centre_mm - inwards * end.radius_mm * end.outward, -end.outward, 5};
}

struct CatheterScene::Impl {
    Impl(VesselWall w, const CatheterSettings& s, PbdBody b)
        : settings(s),
          wall(std::move(w)),
          made_wire(make_wire(s)),
          wire(*made_wire),
          body(std::move(b)),
          contact(wall.mesh, wall.ghost, wall.ghost_places,
                  {.radius_mm = s.catheter.radius_mm, .friction = s.catheter.friction}) {
        inserted = s.entry.inserted_mm;
    }

    CatheterSettings settings;
    VesselWall wall;
    std::unique_ptr<catheter::Wire> made_wire;
    catheter::Wire& wire;
    PbdBody body;
    std::unique_ptr<PbdBoxes> boxes;
    catheter::WallContact contact;
    CatheterCommand command;
    double inserted = 0, rotated = 0, depth = 0;
    std::int64_t steps = 0;
    std::int32_t awake = -1;
    std::vector<Vec3d> places;

    Status wake_boxes() {
        if (!boxes) {
            if (awake < 0) contact.wake(body);
            awake = std::int32_t(wall.mesh.cells.size());
            return Ok{};
        }
        const auto& x = wire.places();
        places.assign(x.begin() + wire.first(), x.end());
        const double reach = settings.reach_mm + settings.catheter.radius_mm;
        if (const Status s = boxes->update(places, reach, body); !s.ok()) return s;
        // Particles that have just begun to be blended in are held for this step still.
        if (awake != boxes->active_tetrahedra()) contact.wake(body);
        awake = boxes->active_tetrahedra();
        return Ok{};
    }

    Status step(const TaskArena& arena) {
        const double h = settings.time_step_s / settings.sub_steps;
        if (const Status s = wake_boxes(); !s.ok()) return s;
        contact.look(wire, body, settings.time_step_s);
        for (int n = 0; n < settings.sub_steps; ++n) {
            inserted = std::clamp(inserted + h * command.insert_mm_s, 0.0, wire.length());
            rotated += h * command.rotate_deg_s;
            wire.feed(inserted, rotated * pi / 180);
            wire.bend_tip(command.bend_first_deg * pi / 180, command.bend_second_deg * pi / 180);
            wire.predict(h);
            if (const Status s = body.step(1, arena); !s.ok()) return s;
            const auto contacts = contact.gather(wire, body, h);
            for (int i = 0; i < settings.iterations; ++i) {
                if (i > 0) contact.yield(body, h);
                wire.solve(contacts);
            }
            wire.finish();
            if (!wire.is_good())
                return Error{ErrorCode::LimitExceeded,
                             "step: a place of the wire is no number any more; expected more "
                             "sub_steps or iterations"};
            if (const Status s = contact.apply(body, h); !s.ok()) return s;
        }
        depth = contact.depth(wire, body);
        ++steps;
        return Ok{};
    }
};

CatheterScene::CatheterScene(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
CatheterScene::~CatheterScene() = default;
CatheterScene::CatheterScene(CatheterScene&&) noexcept = default;
CatheterScene& CatheterScene::operator=(CatheterScene&&) noexcept = default;

Result<CatheterScene> CatheterScene::create(VesselWall wall, const CatheterSettings& settings) {
    if (const Status s = check(settings); !s.ok()) return s.error();
    if (const Status s = pbd::GhostSurface::check(wall.mesh, wall.ghost, wall.ghost_places);
        !s.ok())
        return invalid("wall: " + s.error().message);
    auto parts = parts_of(wall, settings.wall);
    if (!parts) return invalid("wall: " + parts.error().message);
    auto body =
        PbdBody::create(std::move(*parts), {.time_step = settings.time_step_s / settings.sub_steps,
                                            .sub_steps = 1,
                                            .damping = settings.wall.damping_per_s,
                                            .packs_anew = settings.local});
    if (!body) return body.error();
    std::unique_ptr<PbdBoxes> boxes;
    if (settings.local) {
        auto made = PbdBoxes::create(wall.mesh, {.side = settings.box_mm});
        if (!made) return made.error();
        boxes = std::make_unique<PbdBoxes>(std::move(*made));
    }
    auto impl = std::make_unique<Impl>(std::move(wall), settings, std::move(*body));
    impl->boxes = std::move(boxes);
    return CatheterScene(std::move(impl));
}

const CatheterSettings& CatheterScene::settings() const {
    return m_impl->settings;
}
const VesselWall& CatheterScene::wall() const {
    return m_impl->wall;
}

Status CatheterScene::command(const CatheterCommand& c) {
    for (const double value : {c.insert_mm_s, c.rotate_deg_s, c.bend_first_deg, c.bend_second_deg})
        if (!std::isfinite(value)) return invalid("command: expected numbers");
    if (std::abs(c.insert_mm_s) > 1000)
        return invalid("command: insert_mm_s: expected -1000 to 1000, found " +
                       text_of(c.insert_mm_s));
    m_impl->command = c;
    return Ok{};
}

Status CatheterScene::step(std::int32_t count, const TaskArena& arena) {
    for (std::int32_t n = 0; n < count; ++n)
        if (const Status s = m_impl->step(arena); !s.ok()) return s;
    return Ok{};
}

CatheterMeasures CatheterScene::quick_measures() const {
    const Impl& i = *m_impl;
    CatheterMeasures m;
    m.steps = i.steps;
    m.time_s = double(i.steps) * i.settings.time_step_s;
    m.inserted_mm = i.inserted;
    m.rotated_deg = i.rotated;
    const Vec3d axis = normalized(i.settings.entry.direction);
    m.force_n = -dot(i.wire.base_force(), axis) / kMicronewtons;
    m.torque_n_mm = -dot(i.wire.base_moment(), axis) / kMicronewtons;
    m.contact_n = i.contact.push_force() / kMicronewtons;
    m.depth_mm = i.depth;
    m.wire_energy_mj = i.wire.elastic_energy() / kNanojoules;
    m.active_tetrahedra = std::max(0, i.awake);
    return m;
}

CatheterMeasures CatheterScene::measures() const {
    CatheterMeasures m = quick_measures();
    const Impl& i = *m_impl;
    const std::vector<Vec3d> now = wall_places();
    const auto& rest = i.wall.mesh.nodes_mm;
    double kinetic = i.wire.kinetic_energy(), elastic = 0;
    for (std::size_t n = 0; n < now.size(); ++n) {
        m.wall_moved_mm = std::max(m.wall_moved_mm, norm(now[n] - rest[n]));
        const double w = i.body.inverse_mass(std::int32_t(n));
        const Vec3d v = i.body.velocity(std::int32_t(n));
        if (w > 0) kinetic += 0.5 * dot(v, v) / w;
    }
    const double e = i.settings.wall.young_modulus_pa, nu = i.settings.wall.poisson_ratio;
    const double mu = e / (2 * (1 + nu)), lambda = e * nu / ((1 + nu) * (1 - 2 * nu));
    for (const auto& cell : i.wall.mesh.cells) {
        const auto edges = [&](const std::vector<Vec3d>& x) {
            const Vec3d from = x[std::size_t(cell[0])];
            return Mat3d{{x[std::size_t(cell[1])] - from, x[std::size_t(cell[2])] - from,
                          x[std::size_t(cell[3])] - from}};
        };
        bool moved = false;
        for (const std::int32_t n : cell) moved |= now[std::size_t(n)] != rest[std::size_t(n)];
        if (!moved) continue;
        const Mat3d at_rest = edges(rest), f = edges(now) * inverse(at_rest);
        const double j = determinant(f), volume = determinant(at_rest) / 6;
        m.inverted += j <= 0;
        double squares = 0;
        for (const Vec3d& c : f.columns) squares += dot(c, c);
        elastic += volume * 0.5 * (mu * (squares - 4 * j + j * j) + lambda * (j - 1) * (j - 1));
    }
    const TetMesh catheter = catheter_mesh();
    for (const auto& cell : catheter.cells)
        m.inverted += !(pbd::tetrahedron_volume(cell, catheter.nodes_mm) > 0);
    for (std::size_t a = 0; a < i.body.parts().attachments.size(); ++a) {
        const PbdAttachment& at = i.body.parts().attachments[a];
        const Vec3d off = now[std::size_t(at.nodes[0])] - at.target;
        elastic += 0.5 * dot(off, off) / at.compliance;
    }
    m.wall_energy_mj = elastic / kNanojoules;
    m.kinetic_energy_mj = kinetic / kNanojoules;
    m.volume = volume_change(i.body.parts(), now);
    return m;
}

std::span<const Vec3d> CatheterScene::wire_places() const {
    return m_impl->wire.places();
}
std::int32_t CatheterScene::first_inserted() const {
    return m_impl->wire.first();
}
Vec3d CatheterScene::tip_mm() const {
    return m_impl->wire.places().back();
}
Rotation CatheterScene::tip_frame() const {
    return m_impl->wire.tip_frame();
}
TetMesh CatheterScene::catheter_mesh() const {
    return m_impl->wire.mesh();
}
std::vector<Vec3d> CatheterScene::wall_places() const {
    std::vector<Vec3d> places(std::size_t(m_impl->body.particle_count()));
    m_impl->body.get_positions(places);
    return places;
}
std::vector<Vec3d> CatheterScene::ghost_places() const {
    const TetMesh now{wall_places(), m_impl->wall.mesh.cells};
    std::vector<Vec3d> places;
    for (const Embedded& e : m_impl->wall.ghost_places) places.push_back(place_of(e, now));
    return places;
}
const PbdBody& CatheterScene::body() const {
    return m_impl->body;
}
std::uint64_t CatheterScene::hash() const {
    Hash64 hash;
    m_impl->wire.add_to(hash);
    const std::uint64_t wall = m_impl->body.hash();
    hash.add(std::span<const std::uint64_t>(&wall, 1));
    return hash.value();
}

}  // namespace pliant
