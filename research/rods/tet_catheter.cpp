// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The sub-steps of a catheter's scene (catheter/scene_impl.h), without boxes and without the way
// back after a failed step.

#include <pliant/research/tet_catheter.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/text.h"
#include "base/units.h"
#include "catheter/contact_pace.h"
#include "catheter/scene_parts.h"
#include "catheter/wall_contact.h"
#include "pbd/volume_change.h"
#include "rods/tet_wire.h"

namespace pliant {
namespace {

using catheter::TetWire;
using catheter::WireSettings;

/// The tip has the shaft's ratio of GJ to EI.
WireSettings settings_of_body(const CatheterSettings& s) {
    WireSettings w = catheter::wire_settings(s);
    for (std::size_t n = 0; n < w.twist.size(); ++n)
        w.twist[n] = s.catheter.twist_n_mm2 / s.catheter.bend_n_mm2 * w.bend[n];
    return w;
}

Status check_twist(const CatheterShape& c, double segment_mm) {
    const auto bounds = catheter::twist_bounds(c.bend_n_mm2, c.radius_mm, segment_mm);
    if (c.twist_n_mm2 >= bounds.least && c.twist_n_mm2 <= bounds.most) return Ok{};
    return invalid("[catheter] twist_n_mm2: expected " + text_of(bounds.least) + " to " +
                   text_of(bounds.most) +
                   " with tetrahedra of this segment_mm, radius_mm and bend_n_mm2, found " +
                   text_of(c.twist_n_mm2));
}

}  // namespace

struct TetCatheter::Impl {
    Impl(const VesselWall& w, const CatheterSettings& s, PbdBody b)
        : wall(w),
          settings(s),
          wire(settings_of_body(s), s.catheter.radius_mm, s.entry.inserted_mm),
          body(std::move(b)),
          contact(w.mesh, w.ghost, w.ghost_positions,
                  {.radius_mm = s.catheter.radius_mm, .friction = s.catheter.friction}),
          pace(s.time_step_s / s.sub_steps),
          no_end(std::size_t(wire.segments()), 0),
          inserted(s.entry.inserted_mm) {}

    VesselWall wall;
    CatheterSettings settings;
    TetWire wire;
    PbdBody body;
    catheter::WallContact contact;
    catheter::ContactPace pace;
    std::vector<std::uint8_t> no_end;  ///< [segment]: none is beyond an open end
    double inserted, rotated = 0, depth = 0;
    std::int64_t steps = 0;

    Status sub_step(double h, const CatheterCommand& command, const TaskArena& arena) {
        constexpr double kRadians = std::numbers::pi / 180;
        inserted = std::clamp(inserted + h * command.insert_mm_s, 0.0, wire.length());
        rotated += h * command.rotate_deg_s;
        wire.feed(inserted, rotated * kRadians);
        wire.bend_tip(command.bend_first_deg * kRadians, command.bend_second_deg * kRadians);
        wire.predict(h);
        if (const Status s = body.set_time_step(h); !s.ok()) return s;
        if (const Status s = body.step(1, arena); !s.ok()) return s;
        const auto contacts = contact.gather(wire, body, h, arena);
        for (int i = 0; i < settings.iterations; ++i) {
            if (i > 0) contact.yield(h);
            wire.solve(contacts);
        }
        wire.finish();
        if (!wire.is_good())
            return Error{ErrorCode::LimitExceeded,
                         "step: a position of the wire is no longer finite"};
        return contact.apply(body, h);
    }

    Status step(const CatheterCommand& command, const TaskArena& arena) {
        if (steps == 0) contact.wake(body, arena);
        contact.look(wire, body, settings.time_step_s, arena);
        int left = pace.sub_steps(settings.time_step_s);
        double h = settings.time_step_s / left;
        while (left > 0) {
            if (const Status s = sub_step(h, command, arena); !s.ok()) return s;
            --left;
            if (pace.is_too_long_after(h, contact.pushed_mm()) && left > 0) {
                const double rest = left * h;
                left = pace.sub_steps(rest);
                h = rest / left;
            }
        }
        depth = contact.depth(wire, body, no_end, arena);
        ++steps;
        return Ok{};
    }
};

TetCatheter::TetCatheter(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
TetCatheter::~TetCatheter() = default;
TetCatheter::TetCatheter(TetCatheter&&) noexcept = default;
TetCatheter& TetCatheter::operator=(TetCatheter&&) noexcept = default;

Result<TetCatheter> TetCatheter::create(const VesselWall& wall,
                                        const CatheterSettings& wanted) noexcept {
    return attempt([&]() -> Result<TetCatheter> {
        if (const Status s = catheter::check(wanted); !s.ok()) return s.error();
        const double segment_mm = catheter::wire_settings(wanted).segment_mm;
        if (const Status s = check_twist(wanted.catheter, segment_mm); !s.ok()) return s.error();
        CatheterSettings settings = wanted;
        settings.local = false;
        settings.sub_steps =
            std::min(catheter::kMaxSubSteps, catheter::needed_sub_steps(wall, wanted));
        auto body = catheter::body_of(wall, settings);
        if (!body) return body.error();
        return TetCatheter(std::make_unique<Impl>(wall, settings, std::move(*body)));
    });
}

Status TetCatheter::step(const CatheterCommand& command, const TaskArena& arena) noexcept {
    return attempt([&] { return m_impl->step(command, arena); });
}

CatheterMeasures TetCatheter::measures() const {
    const Impl& i = *m_impl;
    std::vector<Vec3d> x(std::size_t(i.body.particle_count()));
    i.body.get_positions(x);
    const auto position = [&](std::int32_t n) { return x[std::size_t(n)]; };
    CatheterMeasures m;
    m.steps = i.steps;
    m.time_s = double(i.steps) * i.settings.time_step_s;
    m.inserted_mm = i.inserted;
    m.rotated_deg = i.rotated;
    m.force_n =
        -dot(i.wire.base_force(), normalized(i.settings.entry.direction)) / kMicronewtonsPerNewton;
    m.contact_n = i.contact.push_force() / kMicronewtonsPerNewton;
    m.depth_mm = i.depth;
    for (std::size_t n = 0; n < x.size(); ++n)
        m.wall_moved_mm = std::max(m.wall_moved_mm, norm(x[n] - i.wall.mesh.nodes_mm[n]));
    m.volume = pbd::volume_change_of(i.body.parts(), position);
    m.inverted = i.wire.inverted();
    for (const auto& cell : i.wall.mesh.cells) m.inverted += !(pbd::volume_at(cell, position) > 0);
    return m;
}

double TetCatheter::depth_mm() const {
    return m_impl->depth;
}
std::span<const Vec3d> TetCatheter::wire_positions() const {
    return m_impl->wire.positions();
}
std::int32_t TetCatheter::first_inserted() const {
    return m_impl->wire.first();
}
Rotation TetCatheter::tip_frame() const {
    return m_impl->wire.tip_frame();
}
TetMesh TetCatheter::mesh() const {
    return m_impl->wire.mesh();
}
const PbdBody& TetCatheter::body() const {
    return m_impl->body;
}

}  // namespace pliant
