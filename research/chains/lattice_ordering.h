// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Base of orderings that need the lattice's directions.
//
// Directions 0…5 are +i, −i, +j, −j, +k, −k. Gibson's front and back are here ±i, right and left
// ±j, top and bottom ±k.

#pragma once

#include <array>

#include "chains/published_ordering.h"

namespace pliant {

inline constexpr int kWays = 6;
constexpr int axis_of(int direction) {
    return direction / 2;
}
constexpr int opposite(int direction) {
    return direction ^ 1;
}

class LatticeOrdering : public PublishedOrdering {
  protected:
    /// Allowed positions of a candidate relative to its sponsor.
    struct Region {
        Vec3d low, high;
    };
    enum class Regions {
        MeanOfEnds,  ///< half of each end's range, as everywhere in Pliant
        OfSponsor,   ///< the sponsor's range, with the shears of [Draeger2005, 3.5.4]
    };

    /// @pre check_chain_lattice(lattice)
    LatticeOrdering(const ChainLattice& lattice, Regions regions);

    bool has_neighbour(std::int32_t element, int direction) const {
        return m_sides[std::size_t(element)] >> direction & 1;
    }
    /// @pre has_neighbour
    std::int32_t neighbour(std::int32_t element, int direction) const {
        return element + m_step[std::size_t(direction)];
    }
    Region region(std::int32_t sponsor, std::int32_t candidate, int direction) const {
        const Region& own = share(sponsor, direction);
        if (m_regions == Regions::OfSponsor) return own;
        const Region& other = share(candidate, direction);
        return {own.low + other.low, own.high + other.high};
    }

  private:
    const Region& share(std::int32_t element, int direction) const {
        const std::size_t material = m_material.empty() ? 0 : m_material[std::size_t(element)];
        return m_shares[kWays * material + std::size_t(direction)];
    }

    Regions m_regions;
    std::array<std::int32_t, kWays> m_step{};  ///< step in the numbering of the elements
    std::vector<std::uint8_t> m_sides;         ///< [element]: a bit for each neighbour
    std::vector<std::uint8_t> m_material;
    std::vector<Region> m_shares;  ///< [material][direction]
};

}  // namespace pliant
