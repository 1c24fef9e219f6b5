// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The elastic energy, exactly: Σ over links of weight_ij · |e_j − e_i|², e = displacement −
// imprint, in whole numbers. Relaxation never lets it rise; a sum of doubles could not show that.

#pragma once

#include <pliant/tasks.h>

#include <array>
#include <vector>

#include "chainmail/lattice.h"
#include "chainmail/plastic.h"

namespace pliant {

/// [units² · weight]: three components, 62 bits of a square, 16 of a weight, and room for 10¹²
/// links.
__extension__ using Energy = unsigned __int128;

Energy elastic_energy(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena);

/// The same number, of a lattice that is asked again and again: bricks of which neither they nor
/// their neighbours changed keep their share.
class EnergyMemory {
  public:
    Energy of(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena);

  private:
    /// When a brick and its six neighbours last changed, plus one; 0: not there.
    using Stamps = std::array<std::uint64_t, 7>;
    struct Share {
        Vec3i coord{0, 0, 0};
        Stamps stamps{};
        Energy energy = 0;
    };
    static Stamps stamps_of(const Lattice& lattice, const Brick& brick);

    std::vector<Share> m_shares;  ///< by brick index
    std::uint64_t m_links_version = 0, m_rest_version = 0;
};

inline double mm2_from_energy(Energy energy) {
    return double(energy) / (kUnitsPerMm * kUnitsPerMm);
}

}  // namespace pliant
