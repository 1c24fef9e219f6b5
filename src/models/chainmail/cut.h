// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Search of the links that a blade cuts: the straight segment between the present positions of
// their two elements crosses one of the ribbon's triangles.
//
// Positions are along the lattice's axes, from element (0,0,0) at rest, in fixed-point units; ties
// are decided as in mesh/blade.h.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/result.h>
#include <pliant/tool.h>
#include <pliant/volume.h>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lattice/lattice.h"
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
    explicit BrickSearch(const Lattice& lattice);

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

    const Lattice& m_lattice;
    Vec3<Fixed> m_lowest{0, 0, 0}, m_highest{0, 0, 0};  ///< of all displacements
};

/// Rest position of an element.
Position rest_position(const Grid& grid, Vec3i ijk);
inline Position moved_position(Position rest, Vec3<Fixed> u) {
    return {rest.x + u.x, rest.y + u.y, rest.z + u.z};
}

/// Two triangles for each piece of the line; pieces along the depth vector have none.
/// @returns InvalidArgument if the line, the depth or the whole ribbon is degenerate
Result<std::vector<Triangle>> ribbon_of(const Grid& grid, const CutSurface& surface);

/// Cuts the links that cross one of the triangles; links at void elements don't count.
/// @param max_elements  limit of the number of elements to examine
/// @returns the number of links that were not cut before, or LimitExceeded with nothing changed
Result<std::int64_t> cut_links(Lattice& lattice, std::span<const Triangle> ribbon,
                               std::int64_t max_elements, const TaskArena& arena);

}  // namespace pliant
