// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Drags with precomputed fields, and the grab that computes them. One item is an element that
// moves, or that the fields reach. The reference pushes the same elements by the same step.

#include <pliant/chainmail.h>

#include <cmath>
#include <cstdlib>
#include <utility>

#include "contacts.h"
#include "interleaved.h"

namespace pliant::bench {
namespace {

struct Drag {
    Contact contact;
    TaskArena arena;
    ChainMail dragged, pushed;
    Push push;
    double reach_mm;  ///< along each axis

    explicit Drag(const benchmark::State& state)
        : contact(state),
          arena(contact.threads),
          dragged(tissue()),
          pushed(tissue()),
          push(contact.diagonal_push()),
          reach_mm(push.push_mm.x) {}

    ChainMail tissue() const {
        return std::move(ChainMail::create(
                             contact.volume(),
                             settings_of(contact.heterogeneous, ChainMailSolver::Sweep), arena))
            .value();
    }
    void rest() {
        dragged.reset();
        pushed.reset();
    }
    std::int64_t grab() {
        const auto report = dragged.grab(push, reach_mm);
        if (!report.ok() || report->grabbed_elements == 0) std::abort();
        return report->reach_elements;
    }
};

/// One frame of a drag through the whole reach.
void drag_frame(benchmark::State& state) {
    Drag drag(state);
    drag.grab();
    const std::int64_t items = moved_by(drag.dragged.drag_to(drag.push.push_mm));
    const Turns turns = run_interleaved(
        state, "a push of the same elements", [&] { drag.rest(), drag.grab(); },
        [&] { moved_by(drag.dragged.drag_to(drag.push.push_mm)); },
        [&] { moved_by(drag.pushed.push(drag.push)); }, drag.arena.thread_count());
    turns.count(double(items));
    add_floor(state, drag.arena, kFrameBytes);
}

/// The preceding grab, which is not part of a frame.
void drag_pick(benchmark::State& state) {
    Drag drag(state);
    const std::int64_t items = drag.grab();
    const Turns turns = run_interleaved(
        state, "a push as far as the pick reaches", [&] { drag.rest(); }, [&] { drag.grab(); },
        [&] { moved_by(drag.pushed.push(drag.push)); }, drag.arena.thread_count());
    turns.count(double(items));
    add_floor(state, drag.arena, kPushBytes);
}

/// Tissue of many values with airways, so that most bricks near the grab differ by direction.
Volume tissue_with_air(int side) {
    Volume volume;
    volume.grid.size = {side, side, side};
    std::vector<std::int16_t> values(voxel_count(volume.grid));
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const double tube = std::hypot(std::remainder(x + 6 * std::sin(0.07 * z), 40.0),
                                               std::remainder(y + 5 * std::sin(0.05 * x), 44.0));
                values[voxel_index(volume.grid, {x, y, z})] =
                    std::int16_t(tube < 6 ? -950 : 20 + (x * 7 + y * 13 + z * 5) % 120);
            }
    volume.voxels = std::move(values);
    return volume;
}

/// A grab in tissue with air; one item is an element of the reach. First: in new tissue, so that
/// bricks and materials are created as well. Deformed: after a drag to the side. The reference is
/// two pushes by the whole reach, all components forwards and backwards, which is equivalent to the
/// fields.
void pick_through_air(benchmark::State& state) {
    const TaskArena arena(int(state.range(2)));
    const Volume volume = tissue_with_air(int(state.range(0)));
    const bool first = state.range(1) == 0, deformed = state.range(1) == 2;
    const double middle = volume.grid.size.x / 2 + 0.5, reach_mm = volume.grid.size.x / 13.0;
    ChainMailSettings settings;
    settings.history_max_steps = 0;
    settings.offset = 0.12;
    settings.max_movement_mm = 500;
    const auto make = [&] { return std::move(ChainMail::create(volume, settings, arena)).value(); };
    ChainMail subject = make(), reference = make();
    const Push place{.point_mm = {middle, middle, middle}};
    const auto pick = [&] { return subject.grab(place, reach_mm).value(); };
    GrabReport grab = pick();
    const auto prepare = [&] {
        if (first) subject = make(), reference = make();
        subject.reset();
        if (!deformed) return;
        pick();
        moved_by(subject.drag_to({reach_mm / 3, -reach_mm / 4, 0}));
        subject.let_go();
    };
    const auto push_both_ways = [&] {
        for (const double way : {reach_mm, -reach_mm}) {
            reference.reset();
            moved_by(reference.push({.point_mm = place.point_mm, .push_mm = {way, way, way}}));
        }
    };
    const Turns turns = run_interleaved(
        state, "pushes by the whole reach, forth and back", prepare, [&] { grab = pick(); },
        push_both_ways, arena.thread_count());
    turns.count(double(grab.reach_elements));
    add_floor(state, arena, kPushBytes);
}

const bool registered = register_contacts("drag_frame", drag_frame, {0, 1, 2, 3, 4}) &&
                        register_contacts("drag_pick", drag_pick, {0, 1, 2, 3, 4});

BENCHMARK(pick_through_air)
    ->ArgNames({"side", "first/again/deformed", "threads"})
    ->ArgsProduct({{96, 220}, {0, 1, 2}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(5);

}  // namespace
}  // namespace pliant::bench
