// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a ChainMail is made of. Each capability has a source file of its own, which defines its
// members of ChainMail and of this.

#pragma once

#include <pliant/chainmail.h>

#include <span>

#include "chainmail/lattice.h"
#include "chainmail/plastic.h"
#include "chainmail/relax.h"

namespace pliant {

struct ChainMail::Impl {
    Impl(const Volume& v, const ChainMailSettings& s, const TaskArena& a)
        : volume(v),
          settings(s),
          law(s.custom_law ? s.custom_law : draeger_law(s)),
          lattice(v, {law}, s.brick_size, s.bounded),
          arena(a),
          relaxation(lattice, plastic_rest, a) {}

    Result<PushReport> push(std::span<const Vec3i> elements, Vec3d push_mm);
    bool propagate(std::span<const ElementRef> grabbed, Vec3<Fixed> shift);
    Result<PushReport> push_grabbed(std::span<const ElementRef> grabbed, Vec3<Fixed> shift);

    const Volume& volume;
    ChainMailSettings settings;
    MaterialLaw law;
    Lattice lattice;
    const TaskArena& arena;
    PlasticRest plastic_rest;
    Relaxation relaxation;
};

}  // namespace pliant
