// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lumen as a closed surface, lids on its open ends: whether a wire begins inside, and where it
// has gone out through a lid. The ends are held, so lids stay where they are.
//
//     ─────────────┐
//   ●───●───●───●──┼─●───●   beyond the end
//     ─────────────┘lid

#pragma once

#include <pliant/vessel_wall.h>

#include <cstdint>
#include <span>
#include <vector>

#include "catheter/wire.h"

namespace pliant::catheter {

class OpenEnds {
  public:
    /// @returns InvalidArgument where openings of the ghost surface touch
    static Result<OpenEnds> create(const VesselWall& wall);

    /// Gets the memory for wires of so many segments.
    void reserve(std::int32_t segments) { m_is_beyond.reserve(std::size_t(segments)); }
    /// Walks along the part outside the guide, starting inside. @pre reserve() was called
    void follow(const Wire& wire) noexcept;
    /// [segment]: both of its ends are beyond an open end.
    std::span<const std::uint8_t> is_beyond() const { return m_is_beyond; }
    /// Number of the open end that the tip is beyond, from 1 on; 0: none.
    std::int32_t left() const { return m_left; }

  private:
    struct Lid {
        std::vector<Vec3d> rim;  ///< in the order of a lid that faces outwards
        Vec3d hub;
        double reach_mm;  ///< from the hub to the rim, at most
        std::int32_t end;
    };
    static int crossings(const Lid& lid, Vec3d from, Vec3d to);

    std::vector<Lid> m_lids;
    std::vector<std::uint8_t> m_is_beyond;
    std::int32_t m_left = 0;
};

}  // namespace pliant::catheter
