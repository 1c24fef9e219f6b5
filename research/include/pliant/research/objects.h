// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Several lattices in one space: tissue, free fragments, walls. Objects never interpenetrate.
//
//      wall │      fragment (free)        tissue (held by its fixed elements)
//           │      +--+--+--+             +--+--+--+--+--+
//           │      |  |  |  | → push      |  |  |  |  |  |
//           │      +--+--+--+             +--+--+--+--+--+
//
// Each solid element (neither void nor air) is a box around the element's position, with its
// lattice's spacing and without rotation. A push of one object stops exactly where the first of its
// boxes meets a box of another object or a wall: the time of each impact is computed without trial
// steps [Gibson1996, 3.5 backtracks instead].

#pragma once

#include <pliant/chainmail.h>

#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

/// A plane across one of the space's axes.
struct Wall {
    Vec3d point_mm{0, 0, 0};  ///< any point of the plane, LPS
    int axis = 0;             ///< 0, 1, 2: of the objects' grids
    int side = 1;             ///< elements stay on the side of larger (+1) or smaller (−1)
                              ///< coordinates
};

struct ObjectPushReport {
    PushReport push;               ///< limited_by is Wall after a collision with an object or wall
    int object = -1;               ///< the object that was met, or −1
    int wall = -1;                 ///< the wall that was met, or −1
    Vec3i element{0, 0, 0};        ///< element of the pushed object in contact
    Vec3i other_element{0, 0, 0};  ///< element of the other object in contact
};

/// All objects have the same directions. Their spacing, size and position may differ. Lattices are
/// bounded; values below [air] threshold_hu are void.
/// Thread safety: concurrent reads.
class ObjectSpace {
  public:
    /// Keeps a reference: the arena must outlive it.
    explicit ObjectSpace(const TaskArena& arena);
    ~ObjectSpace();
    ObjectSpace(ObjectSpace&&) noexcept;
    ObjectSpace& operator=(ObjectSpace&&) noexcept;

    /// @param free  the object has no fixed elements and may go anywhere: a push beyond the limits
    ///              of its links moves the whole object
    /// @returns its number, from 0 on; InvalidArgument if a setting is invalid, the directions
    ///          differ from those of the other objects, or it overlaps an object or wall
    Result<int> add_object(Volume volume, const ChainMailSettings& settings, bool free);
    /// @returns its number, from 0 on; InvalidArgument if an object lies behind it
    Result<int> add_wall(const Wall& wall);

    /// As ChainMail::push, with the point in the object's current position; up to 300 mm after
    /// scaling.
    Result<ObjectPushReport> push(int object, const Push& push);
    Result<ObjectPushReport> push_elements(int object, std::span<const Vec3i> elements,
                                           Vec3d push_mm);

    int object_count() const;
    int wall_count() const;
    /// The rest position, from which its displacements count, moves along if the object is free.
    const ChainMail& object(int object) const;
    bool is_solid(int object, Vec3i ijk) const;
    /// Displacement of an element since the object was added [mm, LPS].
    Vec3d displacement_mm(int object, Vec3i ijk) const;
    /// Current position of an element [mm, LPS].
    Vec3d position_mm(int object, Vec3i ijk) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
