// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The set-up of [Choi2004, 4.3] with any numbers: a box of elastic material, held at a face and
// loaded at nodes of another face, by finite elements and as a lattice of springs.
//
//          +z, pressed            the four nodes around the middle of a face
//        ┌──▪▪──┐
//       ╱      ╱│                 size      nodes along x, y, z
//      ├──────┤ │                 spacing   between them, along each axis
//      │      │╱
//      └──────┘  −z, held
//
// The interface uses mm. The network uses m, kg, s: stiffness in N/m, bulk in Pa, damping in kg/s,
// cost in m.

#pragma once

#include <pliant/fem.h>
#include <pliant/fit.h>
#include <pliant/springs_builders.h>

#pragma GCC visibility push(default)
namespace pliant {

enum class BoxFace { LowX, HighX, LowY, HighY, LowZ, HighZ };

struct FitBoxLoad {
    std::string name{};
    Vec3d force_n{0, 0, -10};  ///< total force, spread evenly over the nodes
    BoxFace face = BoxFace::HighZ;
    double across = 0.5, along = 0.5;  ///< centre of the load on the face, 0…1 along its two axes
                                       ///< in their order
    std::int32_t nodes_across = 2;     ///< loaded nodes on either axis
    double weight = 1;
    bool held_out = false;
};

/// Partition of links and cells into groups.
enum class FitBoxGroups {
    Uniform,     ///< "links"
    Kinds,       ///< "edges", "face diagonals", "body diagonals"
    Directions,  ///< "edges x", …, "diagonals yz", …
};

struct FitBox {
    Vec3i size{10, 10, 10};
    Vec3d spacing_mm{100.0 / 9, 100.0 / 9, 100.0 / 9};
    double young_modulus_pa = 6e5;
    double poisson_ratio = 0.45;
    double density_kg_per_m3 = 1040;
    HexElement element = HexElement::Trilinear;  ///< of the reference
    BoxFace held = BoxFace::LowZ;
    std::vector<FitBoxLoad> loads{};

    LatticeLinks links = LatticeLinks::EdgesAndFaces;
    FitBoxGroups groups = FitBoxGroups::Uniform;
    bool volume_energy = false;    ///< group "volume"
    bool shared_by_cells = false;  ///< see SpringLattice
    bool damping = false;          ///< group "damping", of the nodes
    double damping_start_kg_s = 1;
    double range = 10;  ///< bounds of the values: start/range and start·range
    FitSettings settings{};
};

struct FitBoxProblem {
    FitProblem problem;
    /// k = 0.4·E·a without volume energy; µa and λ − µ with it. a is the edge of a cube with a
    /// cell's volume. Methods start there. It is derived for cubic cells, and inaccurate for
    /// others.
    std::vector<double> closed_form;
    bool cubic_cells = true;  ///< whether spacings differ by less than 1 %
};

/// @returns InvalidArgument that names the field; Poisson's ratio must be above 1/4 for a volume
///          energy
Result<FitBoxProblem> fit_box(const FitBox& box, const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
