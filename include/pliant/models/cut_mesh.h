// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts through tetrahedral meshes by virtual nodes [Molino2004], with polyhedra as material
// [Sifakis2007]. A blade splits the material of a tetrahedron, not the tetrahedron: each part is
// carried by a whole copy of it, whose nodes outside of the part are virtual.
//
//         b                    b              b'         ● node in the material of the copy
//         ●                    ●              ○          ○ virtual node
//        ╱ ╲                  ╱▒╲            ╱ ╲
//    ───╱───╲── blade   →    ╱▒▒▒╲          ╱   ╲        ▒ material
//      ╱     ╲              ╱     ╲        ╱▒▒▒▒▒╲
//     ●───────●            ○───────○      ●───────●
//     a       c            a'      c'     a       c
//
// No element is small, so a simulation's time step stays as it is.
//
// @code
//   const CutSurface blade{{{-1, 3.5, 4}, {11, 3.5, 4}}, {0, 0, 9}};
//   auto cut = cut_tetrahedra(mesh, mesh.nodes_mm, blade);
//   std::printf("%lld pieces\n", static_cast<long long>(cut->pieces));
//   auto again = cut_tetrahedra(*cut, cut->mesh.nodes_mm, {{{3, -1, 4}, {3, 11, 4}}, {0, 0, 9}});
// @endcode

#pragma once

#include <pliant/core/vec.h>
#include <pliant/mesh.h>
#include <pliant/result.h>
#include <pliant/tool.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Material of a copy: a closed polyhedron in barycentric coordinates of its tetrahedron.
struct CutPart {
    struct Point {
        std::array<double, 4> weights;  ///< of the tetrahedron's corners, sum 1
        std::int32_t corner;            ///< the corner that the point is, or −1
    };
    struct Face {
        std::int32_t begin, end;  ///< range of `loops`
        std::int32_t side;        ///< corner opposite to the tetrahedron's face, or −1: cut
    };
    /// An edge that a blade has crossed.
    struct Crossing {
        std::int32_t a, b;  ///< points
        double at;          ///< 0 at a, 1 at b
    };
    std::vector<Point> points;
    std::vector<std::int32_t> loops;  ///< points around each face, outward by the right hand
    std::vector<Face> faces;          ///< flat and convex
    std::vector<Crossing> begun;      ///< crossings that don't separate points of the part yet
};

/// A mesh with cuts. A copy has the corners of its tetrahedron in the same order, so material at
/// rest has the same barycentric coordinates in both. Nodes and tetrahedra keep their numbers; new
/// ones are appended. Thread safety: concurrent reads.
struct CutMesh {
    TetMesh mesh;                             ///< at rest
    std::vector<std::int32_t> node_of;        ///< [node] in the mesh before this cut
    std::vector<std::int32_t> cell_of;        ///< [tetrahedron] in the mesh before this cut
    std::vector<std::int32_t> uncut_node_of;  ///< [node] in the uncut mesh
    std::vector<std::int32_t> uncut_cell_of;  ///< [tetrahedron] in the uncut mesh
    /// [tetrahedron] its material's fraction of the uncut tetrahedron's volume
    std::vector<double> shares;
    std::vector<std::int32_t> next_copy;  ///< [tetrahedron] of the same uncut one, or −1
    std::vector<std::int32_t> part_of;    ///< [tetrahedron] index of `parts`; −1: whole
    std::vector<CutPart> parts;
    std::int64_t split_cells = 0;  ///< tetrahedra that this cut split
    std::int64_t pieces = 0;       ///< connected components

    /// Finds the copy that carries a material point. Its polyhedron has the largest winding number
    /// there, so exactly one copy of a tetrahedron carries each point.
    /// @param uncut_cell  a tetrahedron of the uncut mesh
    /// @param rest_mm     a point in that tetrahedron; points slightly outside are moved inside
    std::int32_t copy_of(std::int32_t uncut_cell, Vec3d rest_mm) const;
    /// Volume of the material that each node carries: a quarter of the material of each tetrahedron
    /// around it. The sum is the volume of the uncut mesh, to rounding.
    std::vector<double> node_volumes_mm3() const;
};

/// Parts with a smaller share aren't separate: their volume counts to another part of the same
/// tetrahedron.
inline constexpr double kSmallestShare = 1e-8;

/// Cuts a mesh along a ribbon, which is given in the mesh's present shape: each part is deformed
/// like its copy, affinely. The segments of the ribbon's line cut one after the other.
///
/// A segment cuts the edges of the material's polyhedra that it crosses. A part is split if its
/// points are no longer connected by uncut edges. A part in which the ribbon ends stays whole, but
/// its cut edges are kept, so that later cuts complete it. Ties are decided by moving the ribbon by
/// (ε, ε², ε³) [Edelsbrunner1990]. Nodes are copied for each connected component of the material
/// around them; material is connected through the common area of two faces.
/// @param positions_now  of the nodes
/// @returns InvalidArgument for a mesh that check_cells refuses, positions of another number or
///          that aren't finite, and a degenerate ribbon or one beyond 1e5 mm; LimitExceeded
Result<CutMesh> cut_tetrahedra(const TetMesh& rest, std::span<const Vec3d> positions_now,
                               const CutSurface& surface) noexcept;
/// Cuts a mesh that has been cut. @pre cut_tetrahedra returned it
Result<CutMesh> cut_tetrahedra(const CutMesh& before, std::span<const Vec3d> positions_now,
                               const CutSurface& surface) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
