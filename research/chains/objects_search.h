// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Search of the elements of an object in a box of space. The lattice is its own index: an element's
// position is its rest position plus a displacement within its brick's bounds, so the box maps to a
// range of bricks, and in each to a range of elements.

#pragma once

#include <functional>

#include "chains/objects_contact.h"
#include "field/brick_search.h"
#include "lattice/lattice.h"

namespace pliant {

/// A lattice with its position in space [units along the common axes].
struct PlacedLattice {
    const Lattice* lattice = nullptr;
    Position base{0, 0, 0};  ///< of element (0,0,0) at rest
    Position half{0, 0, 0};  ///< half of an element's box

    Position position_of(Vec3i ijk, Vec3<Fixed> u) const {
        return base + moved_position(rest_position(lattice->grid(), ijk), u);
    }
};

/// Half of the extents of an element's box: half of the spacing, minus a unit for rounding, so that
/// objects which share a border at rest don't overlap.
Position half_extents(const Grid& grid);

/// Positions of the solid elements of one brick.
struct SolidBrick {
    struct Element {
        Vec3i ijk;
        Position position;
        Vec3<Fixed> raise;  ///< by the whole push; zero if none was given
    };
    std::vector<Element> elements;
    PositionBox box;  ///< bounds of all positions, before and after the push
};

/// @param shift  of the solve in progress: selects the elements that it moves; null: all elements
SolidBrick solid_elements(const PlacedLattice& object, Vec3i coord, const Vec3<Fixed>* shift);

/// Visits the solid elements of an object whose positions may be in a box, and a few others.
class SolidSearch {
  public:
    explicit SolidSearch(const PlacedLattice& object)
        : m_object(object), m_search(*object.lattice) {}

    const PlacedLattice& object() const { return m_object; }
    void for_each_brick(const PositionBox& box,
                        const std::function<void(Vec3i coord)>& visit) const;
    template <class Visit>
    void for_each_element(Vec3i coord, const PositionBox& box, const Visit& visit) const {
        const Lattice& lattice = *m_object.lattice;
        Vec3i begin, end;
        if (!range_in(coord, box, begin, end)) return;
        const BrickEdits* edits = lattice.edits_of(coord);
        const int index = lattice.find_brick(coord);
        for (int z = begin.z; z < end.z; ++z)
            for (int y = begin.y; y < end.y; ++y)
                for (int x = begin.x; x < end.x; ++x) {
                    const auto n = std::size_t(lattice.index_in_brick({x, y, z}));
                    if (edits && ((*edits)[n] & kVoid)) continue;
                    Vec3<Fixed> u{0, 0, 0};
                    if (index >= 0) {
                        const auto& from = lattice.brick(index).u;
                        u = {from[0][n], from[1][n], from[2][n]};
                    }
                    visit(Vec3i{x, y, z}, m_object.position_of({x, y, z}, u));
                }
    }

  private:
    bool range_in(Vec3i coord, const PositionBox& box, Vec3i& begin, Vec3i& end) const;

    PlacedLattice m_object;
    BrickSearch m_search;
};

}  // namespace pliant
