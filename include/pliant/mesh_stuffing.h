// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tetrahedra inside of a level set: isosurface stuffing [Labelle2007]. A body-centred cubic lattice
// covers the solid. Lattice nodes near the surface are warped onto it, the other edges that cross
// it are cut, and a stencil replaces each tetrahedron:
//
//        +────────+           nodes of the cubes and centres of the cubes;
//       /|  ·    /|           long edges join cubes' corners, or centres of neighbours,
//      / |    · / |           short edges a centre with its cube's eight corners
//     +────────+  |
//
// All dihedral angles are between 10.7° and 164.8° for every function. Sharp edges of the solid are
// rounded off; parts thinner than a cell may be lost.
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

/// Positive inside of the solid, zero on its surface, continuous. Called from many threads.
using LevelFunction = std::function<double(Vec3d x_mm)>;

struct StuffingSettings {
    Vec3d begin_mm{0, 0, 0}, end_mm{0, 0, 0};  ///< box around the solid
    double cell_mm = 1;                        ///< edge of the lattice's cubes
    /// A node is warped to the intersection of one of its edges with the surface if that is nearer
    /// than this fraction of the edge. The angle bounds hold for these two values.
    double alpha_long = 0.24999, alpha_short = 0.41189;
    /// The function has a Lipschitz constant of 1, as distances do: points far from the surface are
    /// then not evaluated.
    bool changes_as_distance = false;
    std::int64_t most_cells = std::int64_t(1) << 25;
};

/// Stuffs a level set. The result is equal for any number of threads. The boundary's nodes lie on
/// the surface (to 1e-9 of a cell).
/// @returns InvalidArgument for settings out of range, a function that isn't finite, a solid that
///          reaches the box's border or is empty; LimitExceeded
Result<TetMesh> stuff_isosurface(const LevelFunction& level, const StuffingSettings& settings,
                                 const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
