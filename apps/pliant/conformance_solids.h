// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Solids of hexahedra for the cases of `pliant conformance`.

#pragma once

#include <pliant/models/fem.h>

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "conformance_value.h"

namespace pliant::app {

/// Gives the position of a place in the unit cube.
using Shape = std::function<Vec3d(Vec3d)>;
/// Whether a place of the unit cube counts.
using Where = std::function<bool(Vec3d)>;

/// Hexahedra that are the images of the unit cube's.
struct MappedSolid {
    MappedSolid(Vec3i cells, const Shape& shape);

    /// Holds the axes of all nodes of a part of the unit cube.
    void hold(const Where& where, std::array<bool, 3> axes);
    /// Loads the boundary faces whose corners are all in a part of the unit cube.
    void load(const Where& where, Vec3d traction_pa, double pressure_pa = 0);
    /// Spreads a total force over the boundary faces of a part evenly, by their area.
    void pull(const Where& where, Vec3d force_n);

    HexMesh mesh;
    std::vector<Vec3d> unit;  ///< [node] place in the unit cube
    std::vector<Support> supports{};
    ElasticLoads loads{};
};

/// @throws ConformanceFailure if the elements have no solution
ElasticSolution solve(const MappedSolid& solid, const ElasticMaterial& material, HexElement element,
                      const TaskArena& arena, ElasticMethod method = ElasticMethod::Cholesky);

/// Mean displacement of the nodes of a part [mm].
Vec3d mean_displacement(const MappedSolid& solid, const ElasticSolution& solution,
                        const Where& where);

/// Stress at a node [Pa]: a linear extrapolation from the Gauss points of each cell that has it,
/// averaged over these cells.
SymmetricTensor stress_at(const MappedSolid& solid, const ElasticSolution& solution,
                          const ElasticMaterial& material, HexElement element, std::int32_t node,
                          const TaskArena& arena);

inline constexpr double kMPa = 1e6;                           ///< [Pa]
inline constexpr std::array<bool, 3> kAll{true, true, true};  ///< axes
inline constexpr HexElement kElements[] = {HexElement::Trilinear, HexElement::IncompatibleModes};
std::string element_name(HexElement element);
std::string mesh_name(Vec3i cells);

}  // namespace pliant::app
