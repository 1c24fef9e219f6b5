// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a ChainMail is made of. Each capability has a source file of its own, which defines its
// members of ChainMail and of this.

#pragma once

#include <pliant/chainmail.h>

#include <span>
#include <utility>

#include "chainmail/allowance.h"
#include "chainmail/lattice.h"

namespace pliant {

/// @returns InvalidArgument that names the setting
Result<MaterialMap> make_materials(const Volume& volume, const ChainMailSettings& settings);

struct ChainMail::Impl {
    Impl(const Volume& v, const ChainMailSettings& s, MaterialMap materials, const TaskArena& a)
        : volume(v),
          settings(s),
          lattice(v, std::move(materials), s.brick_size, s.bounded),
          arena(a) {}

    Result<PushReport> push(std::span<const Vec3i> elements, Vec3d push_mm);
    Status set_materials(const ChainMailSettings& changed);
    bool propagate(std::span<const ElementRef> grabbed, Vec3<Fixed> shift);
    Result<PushReport> push_grabbed(std::span<const ElementRef> grabbed, Vec3<Fixed> shift);

    const Volume& volume;
    ChainMailSettings settings;
    Lattice lattice;
    Allowance allowance;  ///< of links that were outside of their limits when these changed
    const TaskArena& arena;
};

}  // namespace pliant
