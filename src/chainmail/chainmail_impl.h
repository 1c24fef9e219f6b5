// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a ChainMail is made of. Each capability has a source file of its own, which defines its
// members of ChainMail and of this.

#pragma once

#include <pliant/chainmail.h>

#include <span>
#include <string>

#include "chainmail/history.h"
#include "chainmail/lattice.h"

namespace pliant {

/// Something outside of the lattice that may stop a push before the lattice's own limits do.
class StepGuard {
  public:
    struct Verdict {
        double fraction;
        Vec3<Fixed> done;  ///< of the shift
        LimitedBy limited_by;
    };
    virtual ~StepGuard() = default;
    /// @param bricks    hold the raises of the whole shift
    /// @param so_far    what the lattice's own limits allow
    virtual Verdict limit(std::span<const int> bricks, Vec3<Fixed> shift, Verdict so_far) = 0;
};

struct ChainMail::Impl {
    Impl(const Volume& v, const ChainMailSettings& s, const TaskArena& a)
        : volume(v),
          settings(s),
          law(s.custom_law ? s.custom_law : draeger_law(s)),
          lattice(v, {law}, s.brick_size, s.bounded),
          arena(a),
          history(lattice, a, s.history_max_steps, s.history_max_bytes()) {}

    Result<PushReport> push(std::span<const Vec3i> elements, Vec3d push_mm);
    bool propagate(std::span<const ElementRef> grabbed, Vec3<Fixed> shift);
    Result<PushReport> push_grabbed(std::span<const ElementRef> grabbed, Vec3<Fixed> shift);

    /// Between these two everything that changes the lattice is one step of the history. A drag
    /// begins when it grabs and ends when it lets go; steps inside of a step belong to it.
    void begin_step(std::string name) { history.begin(std::move(name)); }
    /// @returns see History::end
    int end_step() { return history.end(); }

    const Volume& volume;
    ChainMailSettings settings;
    MaterialLaw law;
    Lattice lattice;
    const TaskArena& arena;
    History history;
    StepGuard* guard = nullptr;  ///< for the time of a push
};

}  // namespace pliant
