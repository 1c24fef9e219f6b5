// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The largest fraction of a push for which no object enters another one or a wall.

#pragma once

#include <optional>
#include <span>

#include "chainmail/chainmail_impl.h"
#include "chains/objects_search.h"

namespace pliant {

struct PlacedWall {
    int axis, side;
    std::int64_t at;  ///< [units along the axis]

    /// Distance from a box to the plane; negative if it is behind.
    std::int64_t gap(const Position& position, const Position& half) const {
        return side * (position[axis] - at) - half[axis];
    }
};

/// First contact of a push.
struct Contact {
    Ratio time = kAfter;
    int object = -1, wall = -1;
    Vec3i element{0, 0, 0}, other_element{0, 0, 0};
};

class ContactGuard final : public StepGuard {
  public:
    struct Other {
        int number;
        PlacedLattice lattice;
    };
    ContactGuard(const PlacedLattice& pushed, std::span<const Other> others,
                 std::span<const PlacedWall> walls, const TaskArena& arena);

    Verdict limit(std::span<const int> bricks, Vec3<Fixed> shift, Verdict so_far) override;
    /// The contact that stopped the push; nothing if it wasn't stopped, or by another limit.
    const std::optional<Contact>& contact() const { return m_contact; }

  private:
    /// Boxes that pass each other by less than a unit: rounding could make them overlap.
    struct NearMiss {
        Position distance, reach;
        Vec3<Fixed> raise;
        Ratio leave;
    };
    struct Found {
        Contact first;
        std::vector<NearMiss> near_misses;
    };
    void look_at_walls(const SolidBrick& solid, Vec3<Fixed> shift, Found& found) const;
    void look_at_object(const SolidBrick& solid, std::size_t other, Vec3<Fixed> shift,
                        Found& found) const;
    void meet(const SolidBrick::Element& own, std::size_t other, Vec3i other_element,
              const Position& other_position, Vec3<Fixed> shift, Found& found) const;

    PlacedLattice m_pushed;
    std::vector<int> m_numbers;
    std::vector<SolidSearch> m_others;
    std::vector<PlacedWall> m_walls;
    const TaskArena& m_arena;
    std::optional<Contact> m_contact;
};

/// An element of the one object that overlaps the other; nothing if there is none.
std::optional<Vec3i> find_overlap(const PlacedLattice& object, const PlacedLattice& other,
                                  const TaskArena& arena);
/// An element of the object that is behind the wall.
std::optional<Vec3i> find_behind(const PlacedLattice& object, const PlacedWall& wall);

/// Visits the elements that aren't void. @param visit  ijk, and its brick (−1: at rest) and index
void for_each_solid(const PlacedLattice& object,
                    const std::function<void(Vec3i, ElementRef)>& visit);

}  // namespace pliant
