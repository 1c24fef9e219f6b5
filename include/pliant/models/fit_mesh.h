// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Identification of a mass-spring network on the tetrahedra of an organ's mesh, against linear
// elastic finite elements on the same tetrahedra or against measured displacements.
//
// @code
//   auto fitted = fit_mesh({.mesh = mesh, .held = back, .loads = {load}}, arena);
//   auto found = fit(fitted->problem, GaussNewton{}, arena);
//   write_network("fit.json", network_of(*fitted, *found, {}));
// @endcode
//
// Each region (tissue) has a shear modulus µ; the stiffness of a link is (√2/5)·µ·length, summed
// over the edge's tetrahedra in the region [Lloyd2007]. So the identified values are moduli, and
// don't depend on the mesh's size. An edge on the border of two regions has a link of each.

#pragma once

#include <pliant/mesh.h>
#include <pliant/models/fit.h>
#include <pliant/models/network_file.h>

#include <cstdint>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A tissue: the material of the finite elements, and the start of its groups.
struct FitRegion {
    std::string name{};  ///< in the names of its groups: "links NAME"
    double young_modulus_pa = 15e3;
    double poisson_ratio = 0.45;
};

struct FitMeasurement {
    Vec3d position_mm{0, 0, 0};  ///< at rest, in the mesh or near it
    Vec3d displacement_mm{0, 0, 0};
};

struct FitMeshLoad {
    std::string name{};
    std::vector<std::int32_t> nodes{};
    Vec3d force_n{0, 0, 0};                  ///< total force, spread evenly over the nodes
    std::vector<FitMeasurement> measured{};  ///< empty: finite elements are the reference
    double weight = 1;
    bool held_out = false;
};

/// The network uses mm, g, s: stiffness in g/s² = mN/m, cost in mm, masses in g.
struct FitMesh {
    TetMesh mesh;
    std::vector<FitRegion> regions{FitRegion{}};
    std::vector<std::int32_t> region_of{};  ///< [tetrahedron]; empty: the first
    std::vector<std::int32_t> held{};       ///< nodes that don't move
    std::vector<FitMeshLoad> loads{};
    double density_kg_per_m3 = 1000;
    bool volume_energy = false;  ///< groups "volume NAME"
    double range = 10;           ///< bounds of the values: start/range and start·range
    FitSettings settings{};
};

struct FitMeshProblem {
    FitProblem problem;
    TetMesh mesh;
    std::vector<std::int32_t> region_of;  ///< [tetrahedron]
    /// µ = 0.4·E without volume energy; µ and λ − µ with it. Exact for regular tetrahedra. Methods
    /// start there.
    std::vector<double> closed_form;
};

/// @returns InvalidArgument that names the field: a mesh that check_mesh refuses, a measurement
///          farther from the mesh than its mean edge, a Poisson's ratio of at most 1/4 with a
///          volume energy
Result<FitMeshProblem> fit_mesh(const FitMesh& mesh, const TaskArena& arena);

// Damping from creep: displacements under a constant load over time.

/// A displacement of a node at a time after the load began to act.
struct CreepSample {
    double time_s = 0;
    std::int32_t node = 0;
    Vec3d displacement_mm{0, 0, 0};
};

struct FitCreep {
    std::size_t load = 0;  ///< case of the problem
    std::vector<CreepSample> samples{};
    double low_per_s = 1e-2, high_per_s = 1e6;  ///< bounds of the damping
    std::int32_t steps = 400;                   ///< of the trapezoidal rule, up to the last sample
    double noise_mm = 0;                        ///< above 0: the interval is computed
};

struct CreepResult {
    double damping_per_s = 0;  ///< of each node's motion, relative to its mass
    FitBound at_bound = FitBound::None;
    FitInterval interval{};
    double rms_mm = 0;  ///< residual, root mean square of a component
    std::int64_t evaluations = 0;
};

/// Fits the nodes' damping, damping·mass, such that the network with the given values creeps as
/// measured. Small displacements: M ü + D u̇ + K u = F at the rest shape.
/// @returns InvalidArgument for a load, node or time that doesn't exist, or no samples
Result<CreepResult> fit_creep(const FitMeshProblem& fitted, std::span<const double> values,
                              const FitCreep& creep, const TaskArena& arena);

/// The network of identified values. @param intervals  [group]; empty: unknown
/// @param creep  its damping; null: none
NetworkFile network_of(const FitMeshProblem& fitted, const FitResult& found,
                       std::span<const FitInterval> intervals, const CreepResult* creep = nullptr);

}  // namespace pliant
#pragma GCC visibility pop
