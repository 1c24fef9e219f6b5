// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A step: boxes near the wire wake up; which triangles are near; then sub-steps, in each of which
// wall and wire are moved freely and meet in the wire's Newton step.
//
// Units inside are g, mm, s: forces in µN, moduli in Pa, energies in nJ.

#pragma once

#include <pliant/catheter.h>
#include <pliant/pbd_boxes.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "catheter/contact_pace.h"
#include "catheter/open_ends.h"
#include "catheter/scene_parts.h"
#include "catheter/wall_contact.h"
#include "core/errors.h"

namespace pliant {

struct CatheterScene::Impl {
    static constexpr double kRadians = std::numbers::pi / 180;

    Impl(VesselWall w, const CatheterSettings& s, PbdBody b, catheter::OpenEnds e)
        : settings(s),
          wall(std::move(w)),
          made_wire(catheter::make_wire(s)),
          wire(*made_wire),
          body(std::move(b)),
          ends(std::move(e)),
          contact(wall.mesh, wall.ghost, wall.ghost_places,
                  {.radius_mm = s.catheter.radius_mm, .friction = s.catheter.friction}),
          pace(s.time_step_s / s.sub_steps) {
        inserted = s.entry.inserted_mm;
        if (settings.reach_mm < 0) settings.reach_mm = wide_reach_mm(wall, settings.wall);
    }

    CatheterSettings settings;
    VesselWall wall;
    std::unique_ptr<catheter::Wire> made_wire;
    catheter::Wire& wire;
    PbdBody body;
    catheter::OpenEnds ends;
    std::unique_ptr<PbdBoxes> boxes;
    catheter::WallContact contact;
    catheter::ContactPace pace;
    CatheterCommand command;
    double inserted = 0, rotated = 0, depth = 0;
    std::int64_t steps = 0;
    std::int32_t awake = -1;
    std::vector<Vec3d> places;

    /// With nothing of the former one: the body is elsewhere.
    void renew_contact(const TaskArena& arena) {
        contact = catheter::WallContact(
            wall.mesh, wall.ghost, wall.ghost_places,
            {.radius_mm = settings.catheter.radius_mm, .friction = settings.catheter.friction});
        contact.see_all(body, arena);
        contact.wake(body, arena);
    }

    Status wake_boxes(const TaskArena& arena) {
        if (!boxes) {
            if (awake < 0) contact.wake(body, arena);
            awake = std::int32_t(wall.mesh.cells.size());
            return Ok{};
        }
        const auto& x = wire.places();
        places.assign(x.begin() + wire.first(), x.end());
        const double reach = settings.reach_mm + settings.catheter.radius_mm;
        if (const Status s = boxes->update(places, reach, body); !s.ok()) return s;
        // Particles that have just begun to be blended in are held for this step still.
        if (awake != boxes->active_tetrahedra()) contact.wake(body, arena);
        awake = boxes->active_tetrahedra();
        return Ok{};
    }

    Status sub_step(double h, const TaskArena& arena) {
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
                         "step: a place of the wire is no number any more; expected more "
                         "sub_steps or iterations"};
        return contact.apply(body, h);
    }

    Status step(const TaskArena& arena) {
        if (const Status s = wake_boxes(arena); !s.ok()) return s;
        contact.look(wire, body, settings.time_step_s, arena);
        int left = pace.sub_steps(settings.time_step_s);
        double h = settings.time_step_s / left;
        while (left > 0) {
            if (const Status s = sub_step(h, arena); !s.ok()) return s;
            --left;
            if (pace.is_too_long_after(h, contact.pushed_mm()) && left > 0) {
                const double rest = left * h;
                left = pace.sub_steps(rest);
                h = rest / left;
            }
        }
        ends.follow(wire);
        depth = contact.depth(wire, body, ends.is_beyond(), arena);
        ++steps;
        return Ok{};
    }
};

}  // namespace pliant
