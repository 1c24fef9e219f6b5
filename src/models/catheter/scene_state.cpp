// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// State of a catheter in its vessel as numbers, for undo and files.

#include "catheter/scene_impl.h"
#include "catheter/state_numbers.h"
#include "pbd/solver.h"

namespace pliant {
namespace {

/// The state that a step changes.
struct CatheterState {
    CatheterCommand command;
    double inserted = 0, rotated = 0, depth = 0, sub_step_s = 0;
    std::int64_t steps = 0;
    std::int32_t awake = 0;
    catheter::RodWire wire;
    std::vector<Vec3d> positions, velocities;
    std::vector<std::int32_t> boxes;

    void exchange(catheter::StateNumbers& state) {
        for (double* v : {&command.insert_mm_s, &command.rotate_deg_s, &command.bend_first_deg,
                          &command.bend_second_deg, &inserted, &rotated, &depth, &sub_step_s})
            state.value(*v);
        state.whole(steps);
        state.whole(awake);
        wire.exchange(state);
        state.positions(positions);
        state.positions(velocities);
        state.wholes_to_the_end(boxes);
    }
};

}  // namespace

std::vector<double> CatheterScene::state() const {
    const Impl& i = *m_impl;
    CatheterState state{.command = i.command,
                        .inserted = i.now.inserted,
                        .rotated = i.now.rotated,
                        .depth = i.now.depth,
                        .sub_step_s = i.now.pace.wanted_s(),
                        .steps = i.now.steps,
                        .awake = i.now.awake,
                        .wire = i.wire,
                        .positions = i.is_rigid() ? std::vector<Vec3d>() : wall_positions(),
                        .velocities = {},
                        .boxes = {}};
    for (std::int32_t n = 0; !i.is_rigid() && n < i.body.particle_count(); ++n)
        state.velocities.push_back(i.body.velocity(n));
    if (i.boxes) state.boxes = i.boxes->state();
    catheter::StateNumbers numbers;
    state.exchange(numbers);
    return numbers.take();
}

Status CatheterScene::restore(std::span<const double> numbers, const TaskArena& arena) noexcept {
    const Status status = attempt([&] { return put(numbers); });
    // Without memory, the next step finds contact.
    if (status.ok())
        (void)attempt([&]() -> Status {
            m_impl->renew_contact(arena);
            return Ok{};
        });
    return status;
}

Status CatheterScene::put(std::span<const double> numbers) {
    Impl& i = *m_impl;
    const auto count = i.is_rigid() ? 0 : std::size_t(i.body.particle_count());
    CatheterState state{.command = {},
                        .wire = i.wire,
                        .positions = std::vector<Vec3d>(count),
                        .velocities = std::vector<Vec3d>(count),
                        .boxes = {}};
    catheter::StateNumbers reading(numbers);
    state.exchange(reading);
    if (!reading.is_good() || !(state.inserted >= 0 && state.inserted <= i.wire.length()) ||
        state.boxes.empty() == (i.boxes != nullptr))
        return invalid("state: expected one of a scene with the same wall and catheter");
    if (const Status s = check_command(state.command); !s.ok()) return s;
    for (std::size_t n = 0; n < count; ++n)
        if (const Status s = pbd::check_state(state.positions[n], state.velocities[n]); !s.ok())
            return s;
    if (i.boxes)
        if (const Status s = i.boxes->restore(state.boxes, i.body); !s.ok()) return s;
    // The rest can't fail.
    if (!i.is_rigid()) PbdRollback::put_all(i.body, state.positions, state.velocities);
    i.wire = state.wire;
    i.command = state.command;
    i.now.pace.set_wanted_s(state.sub_step_s);
    i.now.inserted = state.inserted;
    i.now.rotated = state.rotated;
    i.now.depth = state.depth;
    i.now.contact = 0;
    i.now.steps = state.steps;
    i.now.sub_steps = 0;
    i.now.awake = state.awake;
    i.ends.follow(i.wire);
    i.now.left_end = i.ends.left();
    i.is_contact_old = true;
    return Ok{};
}

}  // namespace pliant
