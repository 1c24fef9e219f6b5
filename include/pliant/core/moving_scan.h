// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan that a tissue deforms: the part of a tissue that resampling, rendering and haptics need.
// It is defined apart from the volume and the deformation that it names, so that an interface made
// from it stays quick to compile.

#pragma once

#include <pliant/result.h>

#include <cstdint>

#pragma GCC visibility push(default)
namespace pliant {

class Deformation;
class TaskArena;
struct Volume;

/// A tissue of your own has a Deformation, writes to it when it moves, and returns it.
/// Thread safety: one thread.
class MovingScan {
  public:
    virtual ~MovingScan() = default;
    virtual const Volume& volume() const = 0;  ///< at rest
    virtual const Deformation& deformation() const = 0;
    virtual const TaskArena& arena() const = 0;
    /// Writes the tissue's present state to the deformation. Everything that reads the deformation
    /// (resampling, hashes, the server) calls it before. So a tissue that moves in many small steps
    /// writes once for each picture instead of once for each step.
    /// @returns Ok by default, for a tissue that writes whenever it moves
    virtual Status update_deformation() const { return Ok{}; }
    /// Writes a state near the present one, for a picture that has no time for all: those parts
    /// that lag most, with about this number of elements. deformation() is then that state, until
    /// the tissue moves or update_deformation() is called.
    /// @returns whether it is the present state; always, by default
    virtual Result<bool> approach_deformation(std::int64_t max_elements) const;
};

inline Result<bool> MovingScan::approach_deformation(std::int64_t) const {
    if (const Status s = update_deformation(); !s.ok()) return s.error();
    return true;
}

}  // namespace pliant
#pragma GCC visibility pop
