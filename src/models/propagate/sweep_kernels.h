// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of the sweep, in two versions: plain loops for any brick size, and vector
// instructions for bricks of 8³. Both use whole numbers and give the same bits; tests compare them
// on every instruction set of the machine.
//
// A brick's array w holds size³ positions. Side 0…5 is −x, +x, −y, +y, −z, +z; the size² values of
// a side's face are ordered by its two other axes, the lower one first:
//
//     sides ±x: y + size·z      sides ±y: x + size·z      sides ±z: x + size·y

#pragma once

#include <array>
#include <cstdint>

#include "material/limit_units.h"
#include "material/material.h"

namespace pliant {

/// Lags of the links inside a brick, by link axis, each in an array by the link's lower element.
/// Forward: largest lag of the upper end behind the lower one; backward: of the lower end behind
/// the upper one. Arrays of axis 0 are in the order of SweepKernels::arrange_x.
struct InsideLags {
    std::array<const Fixed*, 3> forward, backward;
};
/// The same if all links along an axis are equal.
struct UniformLags {
    std::array<Fixed, 3> forward, backward;
};
/// The elements behind a face. Null raised: not reached, they are at sign·u. Null u: elements that
/// are not reached are at the floor; at rest that is 0.
struct FaceBehind {
    const Fixed* raised;
    const Fixed* u;
    Fixed sign;
    Fixed floor = 0;
};

/// One moving component of a brick: u becomes max(u, raised − left) or min(u, left − raised).
struct MovingComponent {
    Fixed* u;
    const Fixed* raised;  ///< null: this component stays
    Fixed left;
    Fixed sign;
};
/// Result of a brick's move. Bounds are of the moving components.
struct MoveResult {
    int moved = 0;  ///< number of elements
    std::array<Fixed, 3> u_min{0, 0, 0}, u_max{0, 0, 0};
};

struct SweepKernels {
    /// out[n] = column[ids[n]]. @pre count is size³ or size²
    void (*gather)(const Fixed* column, const MaterialId* ids, int count, Fixed* out);
    /// out[n] = values of a side's face.
    void (*copy_face)(const Fixed* values, int size, int side, Fixed* out);
    /// out[n] += column[id of the n-th element of a side's face].
    void (*add_face)(const Fixed* column, const MaterialId* ids, int size, int side, Fixed* out);
    /// lags[i] = halves[i] + halves[i + stride], for existing links.
    void (*add_halves)(const Fixed* halves, int size, int axis, Fixed* lags);
    /// Permutes the lags of links along x into the order of `relax`.
    void (*arrange_x)(Fixed* lags, int size);
    /// Raises w to the least fixed point above it. @param dirty  slices (bits by z) that may not be
    /// at the fixed point of their own links; links between slices are always evaluated
    void (*relax)(Fixed* w, int size, const InsideLags& lags, std::uint32_t dirty);
    void (*relax_uniform)(Fixed* w, int size, const UniformLags& lags, std::uint32_t dirty);
    /// Raises the face of w on a side as the neighbour there requires.
    /// @returns the slices that changed
    std::uint32_t (*take)(Fixed* w, int size, int side, const Fixed* neighbour, const Fixed* lags);
    /// @returns the largest raise, above the positions before the push, that w requires of the
    ///          elements behind a side; 0 if none of them would rise
    Fixed (*offer)(const Fixed* w, int size, int side, const Fixed* lags, const FaceBehind& behind);
    /// Raises w as the face of the neighbour on a side requires, where each step away from it lags
    /// by the same: w(n) = max(w(n), face − (n + 1)·lag), at least 0.
    /// @param is_first  w isn't written yet, and counts as 0. @pre w ≥ 0
    void (*carry)(Fixed* w, int size, int side, const Fixed* neighbour, Fixed lag, bool is_first);
    /// Moves count elements. @param from_rest  all u count as 0, whatever they hold; @pre it is 0
    /// for components that stay. In this case the last moving component may have its raise in the
    /// memory of u.
    MoveResult (*move)(const std::array<MovingComponent, 3>& components, int count, bool from_rest);
    /// Largest value. @pre count is size³ or size²
    Fixed (*largest)(const Fixed* values, int count);
};

/// Plain loops, any size.
const SweepKernels& plain_sweep_kernels();
/// Vector instructions, the best that this processor supports. @pre size is 8
const SweepKernels& vector_sweep_kernels();

}  // namespace pliant
