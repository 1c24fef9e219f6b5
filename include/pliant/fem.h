// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Linear elasticity by finite elements, at rest: the reference that faster models are fitted to and
// measured against. Small displacements of isotropic, possibly mixed materials on 8-node
// hexahedra; docs/fem.md has the equations.
//
//   ElasticSolid solid{hex_mesh({.size = {10, 10, 10}}), {{.young_modulus_pa = 6e5,
//                                                          .poisson_ratio = 0.45}}};
//   auto solver = ElasticSolver::create(solid, supports, {}, arena);   // assembles, factors
//   auto at_rest = solver->solve({.forces = {{node, {0, 0, -10}}}});   // quick, again and again
//
// Lengths are in mm, moduli and stresses in Pa, forces in N.

#pragma once

#include <pliant/mesh.h>
#include <pliant/result.h>
#include <pliant/tasks.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct ElasticMaterial {
    double young_modulus_pa = 0;   ///< above 0
    double poisson_ratio = 0;      ///< −1 < ν < 0.5
    double density_kg_per_m3 = 0;  ///< for gravity only
};

struct ElasticSolid {
    HexMesh mesh;
    std::vector<ElasticMaterial> materials;
    std::vector<std::int32_t> material_of{};  ///< [cell]; empty: all have the first
};

/// The same on a regular lattice, where nothing but the displacement needs memory.
struct ElasticLattice {
    HexLattice lattice;
    std::vector<ElasticMaterial> materials;
    std::vector<std::int32_t> material_of{};  ///< [cell]; empty: all have the first
};

/// A node that is held, or brought to another place, along some axes.
struct Support {
    std::int32_t node = 0;
    std::array<bool, 3> held{true, true, true};  ///< x, y, z
    Vec3d displacement_mm{0, 0, 0};              ///< where held
};

struct NodalForce {
    std::int32_t node = 0;
    Vec3d force_n{0, 0, 0};
};

/// On a face, which need not lie on the boundary: traction − pressure · outward normal.
struct SurfaceLoad {
    HexFace face;
    Vec3d traction_pa{0, 0, 0};
    double pressure_pa = 0;
};

struct ElasticLoads {
    std::vector<NodalForce> forces{};
    std::vector<SurfaceLoad> surfaces{};
    Vec3d gravity_m_per_s2{0, 0, 0};
};

enum class HexElement {
    Trilinear,  ///< fully integrated, 2×2×2 [Choi2004, 3.2.2]; stiff in bending and near ν = ½
    IncompatibleModes,  ///< with nine inner modes [Wilson1973; Taylor1976]: bends as it should
};

enum class ElasticMethod {
    Cholesky,            ///< sparse LDLᵀ: for some 10³ nodes (20 000 at most) and many loads
    ConjugateGradients,  ///< little memory; on lattices with multigrid, and fast
};

struct ElasticSettings {
    HexElement element = HexElement::Trilinear;
    ElasticMethod method = ElasticMethod::Cholesky;
    // Of conjugate gradients:
    double tolerance = 1e-9;  ///< residual relative to the load, both in the 2-norm; above 0
    int max_iterations = 20000;
};

struct ElasticSolution {
    std::vector<Vec3d> displacement_mm;  ///< [node]
    std::vector<Vec3d> reaction_n;       ///< [node] of the supports on the solid; 0 where free
    double strain_energy_j = 0;
    int iterations = 0;            ///< 0 with Cholesky
    double relative_residual = 0;  ///< ‖f − K u‖ / ‖f‖ over what is free
};

/// Immutable; bit for bit the same answers for any number of threads.
class ElasticSolver {
  public:
    /// Any mesh. The arena must outlive the solver.
    /// @returns InvalidArgument that names what is wrong with the solid, the supports or the
    ///          settings: an inverted cell, a modulus, supports that leave a piece free to move
    static Result<ElasticSolver> create(ElasticSolid solid, std::vector<Support> supports,
                                        const ElasticSettings& settings, const TaskArena& arena);
    /// A regular lattice, without any matrix: conjugate gradients on trilinear elements.
    static Result<ElasticSolver> create(ElasticLattice solid, std::vector<Support> supports,
                                        const ElasticSettings& settings, const TaskArena& arena);
    ~ElasticSolver();
    ElasticSolver(ElasticSolver&&) noexcept;
    ElasticSolver& operator=(ElasticSolver&&) noexcept;

    /// @returns InvalidArgument that names the load (an unknown node, a force where a node is
    ///          held), LimitExceeded where the iterations don't suffice
    Result<ElasticSolution> solve(const ElasticLoads& loads) const;

    /// K u: the forces [N] that hold the solid in a displacement [mm], supports left aside.
    /// @pre one vector for each node
    std::vector<Vec3d> forces_n(std::span<const Vec3d> displacement_mm) const;

    /// Memory of the matrix and its factor, or of the lattice's materials.
    std::int64_t matrix_bytes() const;

  private:
    struct Impl;
    explicit ElasticSolver(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// Symmetric tensor; shear as in the tensor, half of the engineering strain.
struct SymmetricTensor {
    double xx = 0, yy = 0, zz = 0, yz = 0, zx = 0, xy = 0;
};

/// At one of a cell's 2×2×2 Gauss points.
struct ElasticState {
    Vec3d place_mm{0, 0, 0};
    SymmetricTensor strain;
    SymmetricTensor stress_pa;
};

/// Strain and stress at the Gauss points, eight for each cell, r fastest.
/// @returns InvalidArgument as ElasticSolver::create; also where the displacement's length is wrong
Result<std::vector<ElasticState>> elastic_states(const ElasticSolid& solid,
                                                 std::span<const Vec3d> displacement_mm,
                                                 HexElement element, const TaskArena& arena);

/// √(3/2 s:s) of the deviator s.
double von_mises(const SymmetricTensor& stress);

}  // namespace pliant
#pragma GCC visibility pop
