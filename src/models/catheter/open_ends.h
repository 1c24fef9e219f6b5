// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lumen closed by lids on its open ends: tests whether a wire starts inside, and where it
// leaves through a lid. The ends are fixed, so lids don't move.
//
//     ─────────────┐
//   ●───●───●───●──┼─●───●   beyond the end
//     ─────────────┘lid

#pragma once

#include <pliant/models/vessel.h>

#include <cstdint>
#include <span>
#include <vector>

#include "catheter/wire.h"

namespace pliant::catheter {

class OpenEnds {
  public:
    /// @returns InvalidArgument if openings of the ghost surface touch
    static Result<OpenEnds> create(const VesselWall& wall);

    /// Reserves memory for wires of up to `segments` segments.
    void reserve(std::int32_t segments) { m_is_beyond.reserve(std::size_t(segments)); }
    /// Follows the part of the wire outside of the guide, which starts inside. @pre reserve() was
    /// called
    void follow(const Wire& wire) noexcept;
    /// [segment]: both of its nodes are beyond an open end.
    std::span<const std::uint8_t> is_beyond() const { return m_is_beyond; }
    /// Number of the open end that the tip has left through, from 1 on; 0: none.
    std::int32_t left() const { return m_left; }

  private:
    struct Lid {
        std::vector<Vec3d> rim;  ///< in the order of an outward lid
        Vec3d hub;
        double reach_mm;  ///< largest distance from the hub to the rim
        std::int32_t end;
    };
    static int crossings(const Lid& lid, Vec3d from, Vec3d to);

    std::vector<Lid> m_lids;
    std::vector<std::uint8_t> m_is_beyond;
    std::int32_t m_left = 0;
};

}  // namespace pliant::catheter
