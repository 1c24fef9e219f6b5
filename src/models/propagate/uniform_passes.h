// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A push in tissue of one material at rest, without a search.
//
// Where all links along an axis have equal lags, a shortest path may take its steps along one axis
// after the other, so three passes suffice, one per axis:
//
//     grabbed  G          pass 1  . 1 G 1 .       pass 2  . 2 2 2 .       pass 3: the same
//                                                         . 1 G 1 .       along the third axis
//                                                         . 2 2 2 .
//
// A pass carries the raise of each line of bricks along the line, up and then down, as far as it
// raises anything. Lines share no bricks and run in parallel. A brick is reached once (twice
// between two that carry towards each other) and doesn't have to examine its other sides.
//
// Paths through other materials are not valid, so every brick that the raise might enter is
// examined. A pass continues into a brick if the last face is raised by more than its own half of a
// link's lag, since the other half is unknown. With axes in ascending order of lag no brick is
// missed, although only neighbours along the line of the pass are examined. Let a raised element e
// be that close to a brick C beside it, along axis b, and let the last step on the shortest path to
// e be along a later axis a. Before that step the raise was larger by lag_a, so the element beside
// it was raised by more than half_b + lag_a − lag_b ≥ half_a, and C was reached along axis a, or it
// holds that element.

#pragma once

#include <pliant/core/tasks.h>

#include <array>
#include <span>

#include "lattice/lattice.h"
#include "propagate/propagation.h"
#include "propagate/sweep_kernels.h"

namespace pliant {

class UniformPasses {
  public:
    UniformPasses(Lattice& lattice, const SweepKernels& kernels, SweepWork& work)
        : m_lattice(lattice), m_kernels(kernels), m_work(work) {}

    /// @pre work.shared; work.touched are the bricks with grabbed elements, which are raised there
    /// @returns false if there is other tissue, or more than max_bricks would be needed: the raise
    ///          so far is then a lower bound of the solution, and no brick without a raise was
    ///          added
    [[nodiscard]] bool run(const TaskArena& arena, int max_bricks);

  private:
    using Carry = SweepWork::Carry;
    using Source = SweepWork::Source;

    /// Whether a brick and its surroundings are of the passes' material and at rest.
    bool is_alike(const Brick& brick) const;
    /// The same for a brick that may be blank: a coarse test then suffices.
    bool may_be_alike(const Brick& brick) const;
    bool has_these_lags(MaterialId id) const;
    void relax_grabbed(Brick& brick) const;
    /// Sorts the reached bricks by lines along an axis.
    void list_sources(int axis);
    bool pass(int axis, const TaskArena& arena, int max_bricks);
    /// Lists the carries along the axis, and creates bricks for them.
    bool plan(int axis, int max_bricks);
    /// The same for one line and the direction of a side. @param line  in this direction
    bool plan_line(std::span<const Source> line, int side, int max_bricks);
    bool ends_at_border(const Brick& brick, int axis) const;
    Fixed highest_on_face(const Brick& brick, int side) const;
    bool carry_all(int axis, const TaskArena& arena);
    /// @returns false if the target brick is of another material
    bool carry(const Carry& step, int axis) const;
    void drop_unreached();

    Lattice& m_lattice;
    const SweepKernels& m_kernels;
    SweepWork& m_work;
    std::array<Fixed, 3> m_half{}, m_lag{};  ///< of the links along each axis
    bool m_is_alone = false;                 ///< all other bricks are created here
};

}  // namespace pliant
