// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The fields of a pick: for each component and direction, the remainder of the reach at each
// element, independent of present positions. They depend on links, materials and the grabbed
// elements alone:
//
//   v_d(j) = max over grabbed s of ( start_d(s) − (lags on the shortest way from s to j) )
//
// where start_d is the reach for the grabbed element that is farthest along d, and less for an
// element behind it. An element is raised to v_d + ahead_d, where ahead_d is the position of the
// farthest element. Only raises above the element's own position matter. So v_d is exact only above
// its *floor*
//
//   floor_d(j) = sign·u(j) − ahead_d
//
// and is elsewhere at most the floor. A raise that is not above the floor can't rise above it
// farther on, because the present positions are within the limits.
//
// Where compress, stretch and shear of all links on the way are equal, all six fields are equal. A
// brick of such materials to which the neighbours offer equal fields has one array for all; the
// others have six, mostly near air. Then a visit to most bricks solves for one field instead of
// six, and a frame of the drag reads one array instead of three.

#pragma once

#include <pliant/core/tasks.h>

#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/memory.h"
#include "lattice/lattice.h"
#include "propagate/propagation.h"
#include "propagate/sweep_kernels.h"

namespace pliant {

inline constexpr std::size_t kDirections = 6;

/// Index of a direction: 2·axis, + 1 for the positive one.
inline std::size_t direction_of(int axis, Fixed sign) {
    return std::size_t(2 * axis + (sign > 0));
}

/// The fields of one brick, by direction; null: not reached. All six may be one.
using FieldArrays = std::array<Fixed*, kDirections>;

class DragFields {
  public:
    /// @param reach  [units] > 0  @pre nothing may exceed limits (Lattice::may_exceed_limits)
    /// @returns false if more than max_bricks would be needed. In both cases work.touched are the
    ///          bricks with fields
    [[nodiscard]] bool solve(Lattice& lattice, std::span<const ElementRef> grabbed, Fixed reach,
                             const SweepKernels& kernels, const TaskArena& arena, int max_bricks,
                             SweepWork& work);
    const FieldArrays& of_brick(int index) const { return m_bricks[std::size_t(index)].of; }
    /// For each direction, sign·u of the grabbed element that is farthest along it.
    const std::array<Fixed, kDirections>& ahead() const { return m_ahead; }
    /// Memory beside the bricks' own, of the arrays in use.
    std::size_t bytes() const { return m_used * m_array_bytes; }

  private:
    class Solver;
    struct BrickFields {
        FieldArrays of{};
        bool shared = false;  ///< one array for all
    };

    void clear(const Lattice& lattice);
    /// Memory for `count` arrays, side by side. Callable from any thread.
    Fixed* take_arrays(std::size_t count);

    std::vector<BrickFields> m_bricks;  ///< by brick index
    std::array<Fixed, kDirections> m_ahead{};
    std::mutex m_mutex;  ///< guards the memory
    std::vector<AlignedMemory<Fixed>> m_slabs;
    std::size_t m_used = 0, m_array_bytes = 0;
};

}  // namespace pliant
