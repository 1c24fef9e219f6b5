// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Takes steps of a body, and updates of its boxes, back where something else that goes with them
// has failed.

#pragma once

#include <pliant/pbd_boxes.h>

namespace pliant {

class PbdRollback {
  public:
    /// Gets the memory for keep().
    static void reserve(PbdBody& body);
    /// Remembers places, velocities, inverse masses and the time step. @pre reserve() was called
    static void keep(PbdBody& body) noexcept;
    /// As it was when keep() was called. Multipliers and attachment forces stay those of the last
    /// sub-step that was made. @pre keep() was called, and take_back() not since then
    static void take_back(PbdBody& body) noexcept;
    /// Sets the state of all particles.
    /// @pre finite numbers, as many as particles
    static void put_all(PbdBody& body, std::span<const Vec3d> positions,
                        std::span<const Vec3d> velocities) noexcept;

    /// Before an update that may have to be taken back. @pre create() made them, no copy
    static void keep(PbdBoxes& boxes) noexcept { boxes.keep(); }
    /// As they were when keep() was called, one update ago or none; the body isn't changed.
    static void take_back(PbdBoxes& boxes) noexcept { boxes.take_back(); }
};

}  // namespace pliant
