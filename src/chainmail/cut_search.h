// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which bricks can have elements in a box of the deformed space: those whose rest place is no
// farther from the box than anything has moved, looked at one by one with their own bounds.

#pragma once

#include <functional>

#include "chainmail/cut.h"

namespace pliant {

/// Closed box of places.
struct PlaceBox {
    Place low, high;
};

class BrickSearch {
  public:
    /// Looks at the displacements now.
    explicit BrickSearch(const Lattice& lattice);

    /// How many bricks for_each_brick looks at.
    std::int64_t brick_count(const PlaceBox& box) const;
    /// Visits the bricks that have a part in the box: an element or a link that starts in them.
    /// @param visit     coordinate, and bounds of all places of the brick's elements and the next
    ///                  layer on the high sides
    /// @param may_meet  says of wider bounds, found without looking at displacements, whether the
    ///                  brick is of interest at all; empty: all are
    void for_each_brick(const PlaceBox& box,
                        const std::function<void(Vec3i, const PlaceBox&)>& visit,
                        const std::function<bool(const PlaceBox&)>& may_meet = {}) const;

  private:
    struct Range {
        Vec3i begin, end;
    };
    Range bricks_near(const PlaceBox& box) const;

    const Lattice& m_lattice;
    Vec3<Fixed> m_lowest{0, 0, 0}, m_highest{0, 0, 0};  ///< of all displacements
};

}  // namespace pliant
