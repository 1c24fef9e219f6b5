// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rollback of a body's steps and of its boxes' updates, after a failure of another part of the
// step.

#pragma once

#include <pliant/models/pbd.h>

namespace pliant {

class PbdRollback {
  public:
    /// Allocates the memory for keep().
    static void reserve(PbdBody& body);
    /// Saves positions, velocities, inverse masses and the time step. @pre reserve() was called
    static void keep(PbdBody& body) noexcept;
    /// Restores the state of keep(). Multipliers and attachment forces stay those of the last
    /// sub-step. @pre keep() was called, and take_back() not since then
    static void take_back(PbdBody& body) noexcept;
    /// Sets the state of all particles.
    /// @pre finite numbers, as many as particles
    static void put_all(PbdBody& body, std::span<const Vec3d> positions,
                        std::span<const Vec3d> velocities) noexcept;

    /// Call it before an update that may be undone. @pre create() made the boxes, without a copy
    static void keep(PbdBoxes& boxes) noexcept { boxes.keep(); }
    /// Restores the state of keep(), at most one update ago; the body isn't changed.
    static void take_back(PbdBoxes& boxes) noexcept { boxes.take_back(); }
};

}  // namespace pliant
