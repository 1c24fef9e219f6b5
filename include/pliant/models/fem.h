// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Static linear elasticity by finite elements: the reference for fitting and measuring faster
// models. Small displacements of isotropic or transversely isotropic, possibly mixed materials on
// 8-node hexahedra; docs/method/fem.md has the equations.
//
// @code
//   ElasticSolid solid{hex_mesh({.size = {10, 10, 10}}), {{.young_modulus_pa = 6e5,
//                                                          .poisson_ratio = 0.45}}};
//   auto solver = ElasticSolver::create(solid, supports, {}, arena);   // assembles, factors
//   auto at_rest = solver->solve({.forces = {{node, {0, 0, -10}}}});   // quick, again and again
//   auto moved = solver->with_supports(supports);   // others for the same solid
// @endcode
//
// Lengths are in mm, moduli and stresses in Pa, forces in N.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/mesh.h>
#include <pliant/result.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Hooke's law σ_ij = C_ijkl ε_kl [Choi2004, Eq. 3]. Isotropic, or transversely isotropic around a
/// fibre direction a: equal in all directions across the fibres.
///
///   ε_aa = σ_aa/E_a − ν_a/E_a (σ_bb + σ_cc)             E_a, ν_a, G_a: fibre_…
///   ε_bb = σ_bb/E − ν/E σ_cc − ν_a/E_a σ_aa              E, ν: across the fibres
///   2 ε_ab = σ_ab/G_a,   2 ε_bc = 2 (1 + ν)/E σ_bc       b, c: any two axes across
///
/// [Ting1996]. The energy is positive if all moduli are, −1 < ν < 1 and 2 ν_a² E/E_a < 1 − ν.
struct ElasticMaterial {
    double young_modulus_pa = 0;  ///< above 0; with fibres: across them
    double poisson_ratio = 0;  ///< −1 < ν < 0.5; with fibres: in the plane across, −1 < ν < 1
    double density_kg_per_m3 = 0;       ///< used by gravity only
    Vec3d fibre{0, 0, 0};               ///< direction of the fibres, of any length; 0: isotropic
    double fibre_young_modulus_pa = 0;  ///< along the fibres
    double fibre_poisson_ratio = 0;     ///< contraction across for extension along the fibres
    double fibre_shear_modulus_pa = 0;  ///< in planes that contain the fibres
};

struct ElasticSolid {
    HexMesh mesh;
    std::vector<ElasticMaterial> materials;
    std::vector<std::int32_t> material_of{};  ///< [cell]; empty: the first material
};

/// Solid on a regular lattice. Only the displacement needs memory.
struct ElasticLattice {
    HexLattice lattice;
    std::vector<ElasticMaterial> materials;   ///< isotropic
    std::vector<std::int32_t> material_of{};  ///< [cell]; empty: the first material
};

/// A node with prescribed displacements along some axes.
struct Support {
    std::int32_t node = 0;
    std::array<bool, 3> held{true, true, true};  ///< x, y, z
    Vec3d displacement_mm{0, 0, 0};              ///< prescribed along the held axes
};

struct NodalForce {
    std::int32_t node = 0;
    Vec3d force_n{0, 0, 0};
};

/// Load on a face, inside or on the boundary: traction − pressure · outward normal.
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
    IncompatibleModes,  ///< with nine inner modes [Wilson1973; Taylor1976]: accurate in bending
};

enum class ElasticMethod {
    Cholesky,            ///< sparse LDLᵀ: for some 10³ nodes (20 000 at most) and many loads
    ConjugateGradients,  ///< little memory; on lattices with multigrid, and fast
};

struct ElasticSettings {
    HexElement element = HexElement::Trilinear;
    ElasticMethod method = ElasticMethod::Cholesky;
    // Conjugate gradients:
    double tolerance = 1e-9;  ///< residual relative to the load, both in the 2-norm; above 0
    int max_iterations = 20000;
};
SettingRows<ElasticSettings> elastic_rows() noexcept;

/// Options of one solution by conjugate gradients. Cholesky checks them and has no use for them.
struct ElasticSolveOptions {
    /// [node] displacement from which the iterations start, such as that of the frame before; held
    /// components are ignored. Empty: zero.
    std::span<const Vec3d> initial_displacement_mm{};
    /// Above 0: the displacement after at most that many iterations is the answer, with its
    /// relative_residual. 0: max_iterations must suffice for the tolerance.
    int iteration_budget = 0;
};

struct ElasticSolution {
    std::vector<Vec3d> displacement_mm;  ///< [node]
    std::vector<Vec3d> reaction_n;       ///< [node] force of the supports on the solid; 0 at free
                                         ///< nodes
    double strain_energy_j = 0;
    int iterations = 0;            ///< 0 with Cholesky
    double relative_residual = 0;  ///< ‖f − K u‖ / ‖f‖ over the free components
};

/// Immutable. The answers are bit-identical for any number of threads.
/// Thread safety: immutable.
class ElasticSolver {
  public:
    /// Creates a solver for any mesh. The arena must outlive the solver.
    /// @returns InvalidArgument that names the fault of the solid, the supports or the settings: an
    ///          inverted cell, a modulus, supports that leave a rigid motion free
    static Result<ElasticSolver> create(ElasticSolid solid, std::vector<Support> supports,
                                        const ElasticSettings& settings, const TaskArena& arena);
    /// Creates a matrix-free solver for a regular lattice: conjugate gradients on trilinear
    /// elements.
    static Result<ElasticSolver> create(ElasticLattice solid, std::vector<Support> supports,
                                        const ElasticSettings& settings, const TaskArena& arena);
    ~ElasticSolver();
    ElasticSolver(ElasticSolver&&) noexcept;
    ElasticSolver& operator=(ElasticSolver&&) noexcept;

    /// Creates a solver of the same solid with other supports. The two share the mesh, the
    /// materials and the matrix, and what depends on the held components alone: with the same
    /// components and other displacements, Cholesky's factor too. Otherwise Cholesky factors again,
    /// and conjugate gradients renew the nodes that differ. Answers have the bits of a solver made
    /// by create().
    /// @returns an error of create()
    Result<ElasticSolver> with_supports(const std::vector<Support>& supports) const;

    /// @returns InvalidArgument that names the load (an unknown node, a force on a held node) or
    ///          the option, LimitExceeded if max_iterations don't suffice
    Result<ElasticSolution> solve(const ElasticLoads& loads,
                                  const ElasticSolveOptions& options = {}) const;

    /// Computes K u: the forces [N] that hold the solid in a displacement [mm], ignoring supports.
    /// @pre one vector for each node
    std::vector<Vec3d> forces_n(std::span<const Vec3d> displacement_mm) const;

    /// Memory of the matrix and its factor, or of the lattice's materials.
    std::int64_t matrix_bytes() const;

  private:
    struct Impl;
    explicit ElasticSolver(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// Symmetric tensor. Shear components are tensor components, half of the engineering strain.
struct SymmetricTensor {
    double xx = 0, yy = 0, zz = 0, yz = 0, zx = 0, xy = 0;
};

/// State at one of a cell's 2×2×2 Gauss points.
struct ElasticState {
    Vec3d position_mm{0, 0, 0};
    SymmetricTensor strain;
    SymmetricTensor stress_pa;
};

/// Strain and stress at the Gauss points, eight for each cell, r fastest.
/// @returns InvalidArgument as ElasticSolver::create, or if the displacement's length is wrong
Result<std::vector<ElasticState>> elastic_states(const ElasticSolid& solid,
                                                 std::span<const Vec3d> displacement_mm,
                                                 HexElement element, const TaskArena& arena);

/// Von Mises stress √(3/2 s:s), with s the deviator.
double von_mises(const SymmetricTensor& stress);

}  // namespace pliant
#pragma GCC visibility pop
