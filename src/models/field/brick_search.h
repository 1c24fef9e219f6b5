// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Positions of elements along the lattice's axes, from element (0,0,0) at rest, in fixed-point
// units; and the search of the bricks that can have elements in a box of the deformed space.

#pragma once

#include <cstdint>
#include <functional>

#include "field/field.h"
#include "mesh/blade.h"

namespace pliant {

/// Closed box of positions.
struct PositionBox {
    Position low, high;
};

/// Search of the bricks that can have elements in a box of the deformed space: the distance of
/// their rest position from the box is at most the largest displacement. Each is then tested with
/// its own bounds.
class BrickSearch {
  public:
    /// Takes the bounds of the present displacements.
    explicit BrickSearch(const Field& field);

    /// Number of bricks that for_each_brick examines.
    std::int64_t brick_count(const PositionBox& box) const;
    /// Visits the bricks that have a part in the box: an element or a link that starts in them.
    /// @param visit     coordinate, and bounds of all positions of the brick's elements and the
    ///                  next layer on the high sides
    /// @param may_meet  tests wider bounds, found without reading displacements; false skips the
    ///                  brick; empty: no brick is skipped
    void for_each_brick(const PositionBox& box,
                        const std::function<void(Vec3i, const PositionBox&)>& visit,
                        const std::function<bool(const PositionBox&)>& may_meet = {}) const;

  private:
    struct Range {
        Vec3i begin, end;
    };
    Range bricks_near(const PositionBox& box) const;

    const Field& m_field;
    Vec3<Fixed> m_lowest{0, 0, 0}, m_highest{0, 0, 0};  ///< of all displacements
};

/// Rest position of an element.
Position rest_position(const Grid& grid, Vec3i ijk);
inline Position moved_position(Position rest, Vec3<Fixed> u) {
    return {rest.x + u.x, rest.y + u.y, rest.z + u.z};
}

}  // namespace pliant
