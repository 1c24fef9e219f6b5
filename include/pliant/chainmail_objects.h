// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Several lattices in one space: tissue, free fragments, walls. Nothing passes through anything.
//
//      wall │      fragment (free)        tissue (held by what is fixed in it)
//           │      +--+--+--+             +--+--+--+--+--+
//           │      |  |  |  | → push      |  |  |  |  |  |
//           │      +--+--+--+             +--+--+--+--+--+
//
// Each solid element (not void, and not air) is a box: its lattice's spacing, without rotation,
// around the element's place. A push of one object goes on until the first of its boxes meets a box
// of another object or a wall, and not a unit farther: the time of each impact is computed, nothing
// is tried [Gibson1996, 3.5 backtracks instead].

#pragma once

#include <pliant/chainmail.h>

#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

/// A plane across one of the space's axes.
struct Wall {
    Vec3d point_mm{0, 0, 0};  ///< anywhere on it, LPS
    int axis = 0;             ///< 0, 1, 2: of the objects' grids
    int side = 1;             ///< elements stay on the side of larger (+1) or smaller (−1) places
};

struct ObjectPushReport {
    PushReport push;               ///< limited_by Object or Wall where that stopped it
    int object = -1;               ///< that was met, or −1
    int wall = -1;                 ///< that was met, or −1
    Vec3i element{0, 0, 0};        ///< of the pushed object, where it met something
    Vec3i other_element{0, 0, 0};  ///< of the other object
};

/// All objects have the same directions: what is an axis of one is an axis of all. Their spacing,
/// size and place may differ. Lattices are bounded; values below [air] threshold_hu are void.
class ObjectSpace {
  public:
    /// Keeps a reference: the arena must outlive it.
    explicit ObjectSpace(const TaskArena& arena);
    ~ObjectSpace();
    ObjectSpace(ObjectSpace&&) noexcept;
    ObjectSpace& operator=(ObjectSpace&&) noexcept;

    /// @param free  nothing in it is fixed, and it may go anywhere: a push beyond what its links
    ///              allow takes all of it along
    /// @returns its number, from 0 on; InvalidArgument if a setting is wrong, the directions are
    ///          not those of the others, or it overlaps something
    Result<int> add_object(Volume volume, const ChainMailSettings& settings, bool free);
    /// @returns its number, from 0 on; InvalidArgument if something is behind it
    Result<int> add_wall(const Wall& wall);

    /// As ChainMail::push, with the point where the object is now; up to 300 mm after scaling.
    Result<ObjectPushReport> push(int object, const Push& push);
    Result<ObjectPushReport> push_elements(int object, std::span<const Vec3i> elements,
                                           Vec3d push_mm);

    int object_count() const;
    int wall_count() const;
    /// Its displacements are from a rest place that moves along where the object is free.
    const ChainMail& object(int object) const;
    bool is_solid(int object, Vec3i ijk) const;
    /// How far an element is from where it was when the object was added [mm, LPS].
    Vec3d displacement_mm(int object, Vec3i ijk) const;
    /// Where it is now [mm, LPS].
    Vec3d place_mm(int object, Vec3i ijk) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
