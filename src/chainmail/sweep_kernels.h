// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of the sweep, twice: plain loops for any brick size, and vector instructions for
// bricks of 8³. Both work on whole numbers and give the same bits; tests compare them on every
// instruction set that the machine has.
//
// A brick's array w holds size³ places. Side 0…5 is −x, +x, −y, +y, −z, +z; the size² values of a
// side's face are ordered by its two other axes, the lower one first:
//
//     sides ±x: y + size·z      sides ±y: x + size·z      sides ±z: x + size·y

#pragma once

#include <array>
#include <cstdint>

#include "chainmail/fixed_point.h"
#include "chainmail/material.h"

namespace pliant {

inline constexpr int kMaxBrickSize = 32;

/// Lags of the links inside a brick, by link axis, each in an array by the link's lower element:
/// forward, how far the upper end may lag behind the lower one; backward, the other way round.
/// Arrays of axis 0 are as SweepKernels::arrange_x leaves them.
struct InsideLags {
    std::array<const Fixed*, 3> forward, backward;
};
/// The same where all links along an axis are alike.
struct UniformLags {
    std::array<Fixed, 3> forward, backward;
};
/// The elements behind a face. Null raised: not reached, they are at sign·u. Null u: all that are
/// not reached are at the floor; at rest that is 0.
struct FaceBehind {
    const Fixed* raised;
    const Fixed* u;
    Fixed sign;
    Fixed floor = 0;
};

/// One component of a brick that moves: to max(u, raised − left) or min(u, left − raised).
struct MovingComponent {
    Fixed* u;
    const Fixed* raised;  ///< null: this component stays
    Fixed left;
    Fixed sign;
};
/// What a move did to a brick. Bounds are of the components that don't stay.
struct MoveResult {
    int moved = 0;  ///< elements
    std::array<Fixed, 3> u_min{0, 0, 0}, u_max{0, 0, 0};
};

struct SweepKernels {
    /// out[n] = column[ids[n]]. @pre count is size³ or size²
    void (*gather)(const Fixed* column, const MaterialId* ids, int count, Fixed* out);
    /// out[n] = values of a side's face.
    void (*copy_face)(const Fixed* values, int size, int side, Fixed* out);
    /// out[n] += column[id of the n-th element of a side's face].
    void (*add_face)(const Fixed* column, const MaterialId* ids, int size, int side, Fixed* out);
    /// lags[i] = halves[i] + halves[i + stride], as far as there are links.
    void (*add_halves)(const Fixed* halves, int size, int axis, Fixed* lags);
    /// Brings the lags of links along x into the order that `relax` wants them in.
    void (*arrange_x)(Fixed* lags, int size);
    /// Raises w to the least fixed point above it. @param dirty  slices (bits by z) that may not be
    /// at the fixed point of their own links; links between slices are always looked at
    void (*relax)(Fixed* w, int size, const InsideLags& lags, std::uint32_t dirty);
    void (*relax_uniform)(Fixed* w, int size, const UniformLags& lags, std::uint32_t dirty);
    /// Raises the face of w on a side to what the neighbour there asks for.
    /// @returns the slices that changed
    std::uint32_t (*take)(Fixed* w, int size, int side, const Fixed* neighbour, const Fixed* lags);
    /// @returns the largest raise above the place before the push that w asks of the elements
    ///          behind a side; 0 if none of them would rise above that
    Fixed (*offer)(const Fixed* w, int size, int side, const Fixed* lags, const FaceBehind& behind);
    /// Raises w to what the face of the neighbour on a side asks for, where each step away from it
    /// lags by the same: w(n) = max(w(n), face − (n + 1)·lag), at least 0.
    /// @param is_first  w isn't written yet, and counts as 0. @pre w ≥ 0
    void (*carry)(Fixed* w, int size, int side, const Fixed* neighbour, Fixed lag, bool is_first);
    /// Moves count elements. @param from_rest  all u count as 0, whatever is there; @pre it is 0
    /// for components that stay. Then the last one that moves may be raised where its u is.
    MoveResult (*move)(const std::array<MovingComponent, 3>& components, int count, bool from_rest);
    /// Largest value. @pre count is size³ or size²
    Fixed (*largest)(const Fixed* values, int count);
};

/// Plain loops, any size.
const SweepKernels& plain_sweep_kernels();
/// Vector instructions, the best that this processor has. @pre size is 8
const SweepKernels& vector_sweep_kernels();

}  // namespace pliant
