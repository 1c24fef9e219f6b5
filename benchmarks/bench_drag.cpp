// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Drags with the fields of their pick at hand, and the pick. One item is an element that moves, or
// that the fields of the pick reach. The reference pushes the same elements by the same step.

#include <pliant/chainmail.h>

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

/// One frame that goes all the way out.
void drag_frame(benchmark::State& state) {
    Drag drag(state);
    drag.grab();
    const std::int64_t items = moved_by(drag.dragged.drag_to(drag.push.push_mm));
    const Turns turns = run_interleaved(
        state, "a push of the same elements", [&] { drag.rest(), drag.grab(); },
        [&] { moved_by(drag.dragged.drag_to(drag.push.push_mm)); },
        [&] { moved_by(drag.pushed.push(drag.push)); });
    turns.count(double(items));
    add_floor(state, drag.arena, kFrameBytes);
}

/// The grab before it, which belongs to no frame.
void drag_pick(benchmark::State& state) {
    Drag drag(state);
    const std::int64_t items = drag.grab();
    const Turns turns = run_interleaved(
        state, "a push as far as the pick reaches", [&] { drag.rest(); }, [&] { drag.grab(); },
        [&] { moved_by(drag.pushed.push(drag.push)); });
    turns.count(double(items));
    add_floor(state, drag.arena, kPushBytes);
}

const bool registered = register_contacts("drag_frame", drag_frame, {0, 1, 2, 3, 4}) &&
                        register_contacts("drag_pick", drag_pick, {0, 1, 2, 3, 4});

}  // namespace
}  // namespace pliant::bench
