// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a ChainMail is made of. Each capability has a source file of its own, which defines its
// members of ChainMail and of this.

#pragma once

#include <pliant/chainmail.h>

#include <span>
#include <utility>

#include "chainmail/allowance.h"
#include "chainmail/drag.h"
#include "chainmail/lattice.h"
#include "chainmail/propagation.h"

namespace pliant {

PushReport report_of_step(std::int64_t grabbed, StepLimit own, StepLimit reached,
                          std::int64_t moved);
Error too_large(const ChainMailSettings& settings);

/// @returns InvalidArgument that names the setting
Result<MaterialMap> make_materials(const Volume& volume, const ChainMailSettings& settings);

struct ChainMail::Impl {
    Impl(const Volume& v, const ChainMailSettings& s, MaterialMap materials, const TaskArena& a)
        : volume(v),
          settings(s),
          lattice(v, std::move(materials), s.brick_size, s.bounded),
          arena(a) {}

    Result<PushReport> push(std::span<const Vec3i> elements, Vec3d push_mm);
    const SweepKernels& kernels() const;
    Status set_materials(const ChainMailSettings& changed);
    bool propagate(std::span<const ElementRef> grabbed, Vec3<Fixed> shift);
    /// The elements that a push at this place moves.
    Result<std::vector<Vec3i>> elements_at(const Push& push) const;
    /// Makes bricks for them in grabbed_elements. @returns false if all are void
    bool take_hold(std::span<const Vec3i> elements);
    Vec3d lattice_mm_from_world(Vec3d push_mm) const;
    int max_bricks() const;
    /// @param[out] done  the part of the shift that was done
    Result<PushReport> push_grabbed(std::span<const ElementRef> elements, Vec3<Fixed> shift,
                                    Vec3<Fixed>* done);
    /// Drops the bricks of a push that stayed at rest.
    void drop_unmoved();

    const Volume& volume;
    ChainMailSettings settings;
    Lattice lattice;
    Allowance allowance;  ///< of links that were outside of their limits when these changed
    const TaskArena& arena;
    // Memory of a push, kept for the next.
    SweepWork work;
    std::vector<ElementRef> grabbed_elements;

    Result<GrabReport> grab(std::span<const Vec3i> elements, double reach_mm);
    Result<PushReport> drag_to(Vec3d offset_mm);
    Result<PushReport> drag_by(Vec3<Fixed> step, Vec3<Fixed>& done);
    /// Whether the fields of a pick are of use: not with rounded limits, and not while links are
    /// outside of their limits, which depend on the present state then.
    bool can_use_fields() const;
    Status pick();
    void let_go();

    std::vector<Vec3i> held;           ///< elements of the drag; empty: none
    Vec3<Fixed> drag_offset{0, 0, 0};  ///< of them since they were grabbed
    Fixed drag_reach = 0;
    bool has_fields = false;
    Drag drag;
};

}  // namespace pliant
