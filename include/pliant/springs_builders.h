// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Networks from lattices, meshes and scans.
//
//   auto parts = springs_of_lattice({.size = {10, 10, 10}, .stiffness = {2575, 2575, 2575}});
//   for (int n = 0; n < 100; ++n) parts->nodes[n].fixed = true;   // the bottom layer
//   auto network = SpringNetwork::create(std::move(*parts));
//
// For an isotropic material with Lamé constants λ and µ: a cubic lattice of spacing a, with edges
// and face diagonals of stiffness k, has C₁₂ = C₄₄ = k/a. So k = µa, and the volume energy adds the
// rest of λ: bulk = λ − µ (closed_form).

#pragma once

#include <pliant/springs_network.h>
#include <pliant/volume.h>

#include <functional>

#pragma GCC visibility push(default)
namespace pliant {

enum class LatticeLinks {
    Edges,             ///< 6 neighbours: no resistance to shear
    EdgesAndFaces,     ///< 18: edges and face diagonals
    EdgesFacesAndBody  ///< 26: edges, face and body diagonals
};

/// Stiffness and bulk modulus for a cubic lattice with edges and face diagonals.
struct SpringMaterial {
    double stiffness, bulk;
};
/// Computes k = µa and λ − µ. Below a Poisson's ratio of 1/4 the bulk is negative, which a network
/// refuses.
SpringMaterial closed_form(double young_modulus, double poisson_ratio, double spacing);

struct SpringLattice {
    Vec3i size{2, 2, 2};  ///< nodes along x, y, z; i fastest
    Vec3d spacing{1, 1, 1};
    LatticeLinks links = LatticeLinks::EdgesAndFaces;
    Vec3d stiffness{1, 1, 1};  ///< along x, y, z; a link along n has Σ n_a² stiffness_a
    double link_damping = 0, node_damping = 0;
    double node_mass = 1;
    double density = 0;  ///< above 0: masses are computed from the cells around a node
    double bulk = 0;     ///< of each cell
    /// Each cell has separate springs: a link in c of its possible cells has that share of its
    /// stiffness. A free surface is then as soft as the inside.
    bool shared_by_cells = false;
};
Result<SpringParts> springs_of_lattice(const SpringLattice& lattice) noexcept;

/// Equilateral triangles with six neighbours inside [Choi2004, Fig. 3], in the plane z = 0. Every
/// second row is shifted by half a spacing.
struct SpringSheet {
    std::int32_t columns = 2, rows = 2;
    double spacing = 1, stiffness = 1, link_damping = 0, node_damping = 0, node_mass = 1;
};
Result<SpringParts> springs_of_sheet(const SpringSheet& sheet) noexcept;

/// Properties of all nodes and links of a mesh.
struct SpringMesh {
    double stiffness = 1, link_damping = 0, node_damping = 0, node_mass = 1, density = 0;
    double bulk = 0;  ///< of each cell
};
/// Makes one link per edge. Surfaces have no density: node_mass applies.
Result<SpringParts> springs_of_triangles(std::span<const Vec3d> nodes,
                                         std::span<const std::array<std::int32_t, 3>> triangles,
                                         const SpringMesh& mesh) noexcept;
/// Makes one link per edge.
Result<SpringParts> springs_of_tetrahedra(std::span<const Vec3d> nodes,
                                          std::span<const std::array<std::int32_t, 4>> tetrahedra,
                                          const SpringMesh& mesh) noexcept;
/// Makes one link per edge, with mesh.stiffness as a shear modulus: the stiffness of a link is
/// (√2/5)·length·modulus, summed over the edge's tetrahedra. Exact for regular tetrahedra at
/// Poisson's ratio 1/4 [Lloyd2007], where it is (2√2/25)·E·length.
Result<SpringParts> springs_of_elastic_tetrahedra(
    std::span<const Vec3d> nodes, std::span<const std::array<std::int32_t, 4>> tetrahedra,
    const SpringMesh& mesh) noexcept;
/// Makes one link per edge and face diagonal of the hexahedra.
Result<SpringParts> springs_of_hexahedra(std::span<const Vec3d> nodes,
                                         std::span<const std::array<std::int32_t, 8>> hexahedra,
                                         const SpringMesh& mesh) noexcept;

/// A control lattice over a part of a scan [Choi2004, 4.2.2]. Nodes have world positions [mm, LPS]
/// and properties from the mean voxel value around them. Units: mm, g, s.
struct SpringScan {
    Box3i region{};          ///< voxels; empty: the whole scan
    Vec3i size{10, 10, 10};  ///< nodes along i, j, k; the outermost lie on the region's border
    LatticeLinks links = LatticeLinks::EdgesAndFaces;
    double fixed_hu = 300;  ///< nodes with a larger value are fixed
    /// Cells with a larger share of such voxels have fixed nodes, so that thin bones keep their
    /// position. 1: only the nodes' own values count.
    double fixed_share = 0.05;
    bool fixed_border = true;  ///< the outermost nodes are fixed
    /// Young's modulus at a value; empty: 15 kPa, and 1 % of it in air, below −500 HU. The
    /// stiffness of a link is 0.4·E·a with the mean E of its ends; a is the edge of a cube with a
    /// cell's volume.
    std::function<double(double hu)> young_modulus_pa{};
    double node_damping = 0;       ///< g/s
    double density_g_mm3 = 0.001;  ///< of all nodes, in air too: it determines the time step
};
Result<SpringParts> springs_of_scan(const Volume& volume, const SpringScan& scan) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
