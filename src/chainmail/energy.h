// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The elastic energy, exactly: Σ over links of weight_ij · |e_j − e_i|², e = displacement −
// imprint, in whole numbers. Relaxation never lets it rise; a sum of doubles could not show that.

#pragma once

#include <pliant/tasks.h>

#include "chainmail/lattice.h"
#include "chainmail/plastic.h"

namespace pliant {

/// [units² · weight]: three components, 62 bits of a square, 16 of a weight, and room for 10¹²
/// links.
__extension__ using Energy = unsigned __int128;

Energy elastic_energy(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena);

inline double mm2_from_energy(Energy energy) {
    return double(energy) / (kUnitsPerMm * kUnitsPerMm);
}

}  // namespace pliant
