// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tetrahedra between the zeros of a function: isosurface stuffing [Labelle2007]. A body-centred
// cubic lattice is laid over the solid; lattice nodes too near to the surface are warped onto it,
// the other edges that cross it are cut, and each tetrahedron is replaced by a stencil:
//
//        +────────+           nodes of the cubes and centres of the cubes;
//       /|  ·    /|           long edges join cubes' corners, or centres of neighbours,
//      / |    · / |           short edges a centre with its cube's eight corners
//     +────────+  |
//
// All dihedral angles are between 10.7° and 164.8°, whatever the function. Sharp edges of the solid
// are rounded off, parts thinner than a cell may be lost.
//
//   const auto ball = [](Vec3d x) { return 10 - norm(x); };
//   const auto mesh = stuff_isosurface(ball, {.begin_mm = {-11, -11, -11}, .end_mm = {11, 11, 11},
//                                             .cell_mm = 1}, arena);

#pragma once

#include <pliant/mesh.h>
#include <pliant/tasks.h>

#include <functional>

#pragma GCC visibility push(default)
namespace pliant {

/// Above zero inside the solid, zero on its surface, continuous. Called from many threads.
using LevelFunction = std::function<double(Vec3d x_mm)>;

struct StuffingSettings {
    Vec3d begin_mm{0, 0, 0}, end_mm{0, 0, 0};  ///< a box that holds the solid
    double cell_mm = 1;                        ///< edge of the lattice's cubes
    /// A node moves to where the surface crosses one of its edges nearer than this part of the
    /// edge. The bounds hold for these two.
    double alpha_long = 0.24999, alpha_short = 0.41189;
    /// The function changes by no more than the distance, as distances do: what is far from the
    /// surface is then not asked for.
    bool changes_as_distance = false;
    std::int64_t most_cells = std::int64_t(1) << 25;
};

/// The same for any number of threads. The boundary's nodes lie on the surface (to 1e-9 of a cell).
/// @returns InvalidArgument for settings outside of what they may be, a function that isn't finite,
///          a solid that reaches the box's border or has nothing inside; LimitExceeded
Result<TetMesh> stuff_isosurface(const LevelFunction& level, const StuffingSettings& settings,
                                 const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
