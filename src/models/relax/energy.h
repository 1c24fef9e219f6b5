// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Exact elastic energy: Σ over links of weight_ij · |e_j − e_i|², e = displacement − imprint, in
// whole numbers. Relaxation never increases it; a sum of doubles could not prove that.

#pragma once

#include <pliant/core/tasks.h>

#include <array>
#include <vector>

#include "lattice/lattice.h"
#include "relax/plastic.h"

namespace pliant {

/// [units² · weight]: three components, 62 bits of a square, 16 of a weight, and room for 10¹²
/// links.
__extension__ using Energy = unsigned __int128;

Energy elastic_energy(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena);

/// The same number, for repeated queries of a lattice: a brick keeps its share if neither it nor
/// its neighbours changed.
class EnergyMemory {
  public:
    Energy of(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena);

  private:
    /// Last changes of a brick and of its six neighbours, plus one; 0: no brick.
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
