// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A step wakes boxes near the wire, runs the broad phase, then makes sub-steps. In each sub-step
// wall and wire move freely, and contact is solved in the wire's Newton step. If a step fails, the
// changed state is restored from copies in preallocated memory. Contact isn't copied: if it has
// changed, the next step finds it again.
//
// Internal units are g, mm, s: forces in µN, moduli in Pa, energies in nJ.

#pragma once

#include <pliant/models/catheter.h>
#include <pliant/models/pbd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "catheter/contact_pace.h"
#include "catheter/open_ends.h"
#include "catheter/rod_wire.h"
#include "catheter/scene_parts.h"
#include "catheter/wall_contact.h"
#include "pbd/rollback.h"

namespace pliant {

struct CatheterScene::Impl {
    static constexpr double kRadians = std::numbers::pi / 180;
    static constexpr double kMillimetresPerMicronewton = 1e-6;  ///< of 1 mm/N

    Impl(VesselWall w, const CatheterSettings& s, PbdBody b, catheter::OpenEnds e)
        : settings(s),
          wall(std::move(w)),
          wire(catheter::wire_settings(s), s.entry.inserted_mm),
          kept_wire(wire),
          body(std::move(b)),
          ends(std::move(e)),
          contact(wall.mesh, wall.ghost, wall.ghost_positions, contact_settings()),
          now{.pace = catheter::ContactPace(s.time_step_s / s.sub_steps),
              .inserted = s.entry.inserted_mm},
          kept(now) {
        if (settings.reach_mm < 0) settings.reach_mm = wide_reach_mm(wall, settings.wall);
        ends.reserve(wire.segments());
        if (!is_rigid()) PbdRollback::reserve(body);
    }

    /// State that a step changes, except wire, body, boxes and contact.
    struct Progress {
        catheter::ContactPace pace;
        double inserted = 0, rotated = 0, depth = 0;
        double contact = 0, largest_contact = 0;  ///< forces on the wall: all, one [µN]
        std::int64_t steps = 0;
        std::int32_t awake = -1;
        std::int32_t sub_steps = 0;  ///< of the last step
        std::int32_t left_end = 0;
    };

    CatheterSettings settings;
    VesselWall wall;
    catheter::RodWire wire, kept_wire;
    PbdBody body;
    catheter::OpenEnds ends;
    std::unique_ptr<PbdBoxes> boxes;
    catheter::WallContact contact;
    bool is_contact_old = false;  ///< contact belongs to another state, so the next step finds it
                                  ///< again
    CatheterCommand command;
    Progress now, kept;
    std::int32_t needed_sub_steps = 0;
    std::vector<Vec3d> positions;

    using Cell = std::array<std::int32_t, 4>;
    Vec3d rest_position(std::int32_t node) const { return wall.mesh.nodes_mm[std::size_t(node)]; }
    // Measures (scene.cpp).
    template <class Work>
    void with_positions(const Work& work) const;
    template <class Position>
    bool has_moved(const Cell& cell, const Position& position) const;
    template <class Position>
    std::int64_t inverted_in_wall(const Position& position) const;
    template <class Position>
    double wall_energy(const Position& position) const;

    bool is_rigid() const { return settings.wall.model == WallModel::Rigid; }
    catheter::WallContactSettings contact_settings() const {
        return {.radius_mm = settings.catheter.radius_mm,
                .friction = settings.catheter.friction,
                .compliance = settings.catheter.contact_mm_per_n * kMillimetresPerMicronewton,
                .is_rigid = is_rigid(),
                .kept_mm = is_rigid() ? 1.0 : 0.3};
    }

    /// Rebuilds contact from scratch after the body was repositioned.
    void renew_contact(const TaskArena& arena) {
        contact =
            catheter::WallContact(wall.mesh, wall.ghost, wall.ghost_positions, contact_settings());
        contact.see_all(body, arena);
        contact.wake(body, arena);
        is_contact_old = false;
    }

    Status wake_boxes(const TaskArena& arena) {
        if (!boxes) {
            if (now.awake < 0) contact.wake(body, arena);
            now.awake = is_rigid() ? 0 : std::int32_t(wall.mesh.cells.size());
            return Ok{};
        }
        const auto& x = wire.positions();
        positions.assign(x.begin() + wire.first(), x.end());
        const double reach = settings.reach_mm + settings.catheter.radius_mm;
        if (const Status s = boxes->update(positions, reach, body); !s.ok()) return s;
        // Particles at the start of their blend are still held in this step.
        if (now.awake != boxes->active_tetrahedra()) contact.wake(body, arena);
        now.awake = boxes->active_tetrahedra();
        return Ok{};
    }

    Status sub_step(double h, const TaskArena& arena) {
        now.inserted = std::clamp(now.inserted + h * command.insert_mm_s, 0.0, wire.length());
        now.rotated += h * command.rotate_deg_s;
        wire.feed(now.inserted, now.rotated * kRadians);
        wire.bend_tip(command.bend_first_deg * kRadians, command.bend_second_deg * kRadians);
        wire.predict(h);
        if (!is_rigid()) {
            if (const Status s = body.set_time_step(h); !s.ok()) return s;
            if (const Status s = body.step(1, arena); !s.ok()) return s;
        }
        const auto contacts = contact.gather(wire, body, h, arena);
        for (int i = 0; i < settings.iterations; ++i) {
            if (i > 0) contact.yield(h);
            wire.solve(contacts);
        }
        wire.finish();
        if (!wire.is_good())
            return Error{ErrorCode::LimitExceeded,
                         "step: a position of the wire is no longer finite; expected more "
                         "sub_steps or iterations"};
        return is_rigid() ? Status(Ok{}) : contact.apply(body, h);
    }

    Status sub_steps(const TaskArena& arena) {
        int left = now.pace.sub_steps(settings.time_step_s);
        double h = settings.time_step_s / left;
        now.sub_steps = 0;
        while (left > 0) {
            if (const Status s = sub_step(h, arena); !s.ok()) return s;
            --left;
            ++now.sub_steps;
            if (now.pace.is_too_long_after(h, contact.pushed_mm()) && left > 0) {
                const double rest = left * h;
                left = now.pace.sub_steps(rest);
                h = rest / left;
            }
        }
        return Ok{};
    }

    /// Makes a step; it may be incomplete on failure.
    Status go_on(const TaskArena& arena) {
        if (is_contact_old) renew_contact(arena);
        if (const Status s = wake_boxes(arena); !s.ok()) return s;
        contact.look(wire, body, settings.time_step_s, arena);
        if (const Status s = sub_steps(arena); !s.ok()) return s;
        ends.follow(wire);
        now.depth = contact.depth(wire, body, ends.is_beyond(), arena);
        now.contact = contact.push_force();
        now.largest_contact = contact.largest_push();
        now.left_end = ends.left();
        ++now.steps;
        return Ok{};
    }

    /// Makes a step or changes nothing.
    Status step(const TaskArena& arena) noexcept {
        kept = now;
        kept_wire = wire;
        if (!is_rigid()) PbdRollback::keep(body);
        if (boxes) PbdRollback::keep(*boxes);
        contact.keep();
        const Status status = attempt([&] { return go_on(arena); });
        if (!status.ok()) take_back();
        return status;
    }
    void take_back() noexcept {
        now = kept;
        wire = kept_wire;
        if (!is_rigid()) PbdRollback::take_back(body);
        if (boxes) PbdRollback::take_back(*boxes);
        if (!contact.take_back()) is_contact_old = true;
    }
};

}  // namespace pliant
