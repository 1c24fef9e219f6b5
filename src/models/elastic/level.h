// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One lattice of ElasticLevels: its nodes, cells and vectors, 128 bytes a node.

#pragma once

#include <pliant/core/tasks.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/aligned_array.h"
#include "elastic/stiffness_map.h"
#include "elastic/sweeps.h"

namespace pliant {

/// A node that a tool holds, at a voxel.
struct HeldNode {
    Vec3i node{0, 0, 0};             ///< voxel
    Vec3d displacement_mm{0, 0, 0};  ///< along the lattice's axes
    /// Direction in which it is held, a unit vector; none: in all.
    std::optional<Vec3d> only_along{};
    Vec3d force_un{0, 0, 0};  ///< on a node that slides, across that direction
};

struct SlidingNode {
    std::size_t at;
    Vec3d normal, force_un;
};

/// A cell of air whose walls touch, or of a cut that is pressed together: it resists deformation
/// beyond the one in which it began to.
struct TouchingCell {
    Vec3i cell{0, 0, 0};        ///< from the window's first
    std::array<float, 24> u{};  ///< [component][corner] displacements at that time [mm]
};

struct ElasticLevel {
    /// A window of a level at rest.
    /// @param first, nodes  in nodes of the whole level
    ElasticLevel(const StiffnessMap& map, int number, Vec3i first, Vec3i nodes,
                 const TaskArena& arena);

    int number;
    Vec3i shift;         ///< of the level
    Vec3i first, nodes;  ///< the window
    int stride;
    std::size_t plane;
    bool follows[3][2] = {};              ///< sides that follow the coarser lattice
    Box3i covered{{0, 0, 0}, {0, 0, 0}};  ///< cells under a finer window, from the window's first
    CellFactors factors;
    float spectrum;

    NodeRows u, r;                ///< displacement [mm], residual [µN]
    NodeRows p, q;                ///< direction and its product; in a cycle, q is the right side
    NodeRows e, s, t;             ///< correction, and steps to it
    std::array<float*, 6> block;  ///< D (LatticeSweep)
    CellRotations rotations;
    float* mu;                           ///< [cell] shear modulus [Pa]
    std::vector<CellKind> kind;          ///< [cell]; tissue must not fold
    std::vector<double> dots;            ///< [plane]
    std::vector<SlidingNode> slides;     ///< nodes held along a direction
    std::vector<Vec3i> held;             ///< nodes that tools hold
    std::vector<TouchingCell> touching;  ///< by plane, row and column
    std::vector<Vec3i> stiffened;        ///< cells whose modulus isn't the map's

    std::int64_t node_count() const { return std::int64_t(nodes.x) * nodes.y * nodes.z; }
    std::size_t array_size() const { return plane * std::size_t(nodes.z); }
    std::int64_t bytes() const { return std::int64_t(m_memory.size() * sizeof(float)); }
    std::size_t index(Vec3i local) const {
        return std::size_t(local.x) + std::size_t(stride) * std::size_t(local.y) +
               plane * std::size_t(local.z);
    }
    bool has(Vec3i local) const {
        return local.x >= 0 && local.y >= 0 && local.z >= 0 && local.x < nodes.x &&
               local.y < nodes.y && local.z < nodes.z;
    }
    bool is_held(std::size_t at) const { return std::bit_cast<std::uint32_t>(block[0][at]) == 0; }
    /// Whether the force on a node counts here, and not on a finer window alone.
    bool is_active(Vec3i local) const;
    LatticeSweep sweep(const StiffnessMap& map) const;
    NodeSweep planes(int begin, int end) const {
        return {plane * std::size_t(begin),
                plane * std::size_t(end),
                {block[0], block[1], block[2], block[3], block[4], block[5]}};
    }
    /// Clears held nodes of a row of count nodes.
    void clear_held(const NodeRows& rows, std::size_t at, std::size_t count) const {
        for (std::size_t i = at; i < at + count; ++i)
            if (is_held(i))
                for (float* const row : rows) row[i] = 0;
    }

    bool is_covered(Vec3i cell) const { return contains(covered, cell); }
    /// Cells of a coarser level under this window.
    Box3i box_in(const ElasticLevel& coarse) const;

    /// Reads a box of cells from the map again, from the window's first.
    void renew(const StiffnessMap& map, const Box3i& cells);
    /// Adds to the shear modulus of a cell [Pa], until loosen().
    void stiffen(const StiffnessMap& map, Vec3i cell, float mu_pa);
    /// Gives all cells the map's moduli again.
    void loosen(const StiffnessMap& map);
    /// Appends the cells of a plane, outside of tissue and finer windows, whose walls touch.
    void find_touching(int plane, std::vector<TouchingCell>& found) const;
    /// rows += factor · forces of the touching cells in the shape in which they began to touch.
    void add_touching(const StiffnessMap& map, const NodeRows& rows, float factor, bool turns,
                      bool to_held) const;

    void hold(const StiffnessMap& map, const HeldNode& node);
    void let_go(const StiffnessMap& map);

    Vec3i voxel_of(Vec3i local) const {
        Vec3i voxel;
        for (int a = 0; a < 3; ++a) voxel[a] = (first[a] + local[a]) << shift[a];
        return voxel;
    }
    /// The node at a voxel, if there is one.
    std::optional<Vec3i> local_of(Vec3i voxel) const;
    bool is_follower(Vec3i local) const;
    /// Whether a voxel lies in the window.
    bool has_voxel(Vec3i voxel) const;
    /// Writes the displacements of those of count voxels along x that lie in the window.
    void displacements(Vec3i voxel, int count, const NodeRows& to) const;
    /// Whether some cell of tissue of a plane, under no finer window, has a corner with a
    /// determinant of the deformation gradient below a limit. @param[out] cells  if not null
    bool has_folded(int plane, float limit, std::vector<Vec3i>* cells) const;
    /// Moves the nodes of folded cells, except those that never move, towards the mean of their
    /// neighbours until no cell is folded.
    /// @returns false if many rounds don't suffice
    bool untangle(const StiffnessMap& map, float limit);

    template <class Visit>  ///< visit(Vec3i local, std::size_t at)
    void for_each_node(const Visit& visit) const {
        for (int k = 0; k < nodes.z; ++k)
            for (int j = 0; j < nodes.y; ++j) {
                std::size_t at = index({0, j, k});
                for (int i = 0; i < nodes.x; ++i) visit(Vec3i{i, j, k}, at++);
            }
    }
    /// Visits nodes on sides that follow the coarser lattice, except held ones.
    template <class Visit>
    void for_each_follower(const Visit& visit) const {
        const auto is_on = [&](Vec3i n, int a) {
            return (n[a] == 0 && follows[a][0]) || (n[a] == nodes[a] - 1 && follows[a][1]);
        };
        for (int k = 0; k < nodes.z; ++k)
            for (int j = 0; j < nodes.y; ++j) {
                const Vec3i row{0, j, k};
                const bool whole = is_on(row, 1) || is_on(row, 2);
                for (int i = 0; i < nodes.x; i += whole ? 1 : nodes.x - 1) {
                    const Vec3i local{i, j, k};
                    if (!whole && !is_on(local, 0)) continue;
                    if (const std::size_t at = index(local); !is_held(at)) visit(local, at);
                }
            }
    }
    /// Visits the nodes between which a node of a finer level lies: visit(at, weight, is_first).
    template <class Visit>
    void with_parents(const ElasticLevel& fine, Vec3i local, const Visit& visit) const {
        Vec3i low;
        int odd = 0, count = 1;
        for (int a = 0; a < 3; ++a) {
            const int step = shift[a] - fine.shift[a], global = fine.first[a] + local[a];
            low[a] = (global >> step) - first[a];
            if (global & step) odd |= 1 << a, count *= 2;
        }
        for (int corner = 0; corner < 8; ++corner) {
            if (corner & ~odd) continue;
            const Vec3i parent = low + Vec3i{corner & 1, corner >> 1 & 1, corner >> 2};
            visit(index(parent), 1.0F / float(count), corner == 0);
        }
    }

  private:
    void find_blocks(const StiffnessMap& map, const TaskArena& arena);
    /// D of a row of nodes for its cells' moduli.
    void find_row(const StiffnessMap& map, int j, int k, int begin, int end);
    void read(const StiffnessMap& map, const Box3i& cells);
    void gradient_row(int j, int k, std::span<float> to) const;
    float least_corner(std::size_t at, float limit, float scale = 1) const;

    CornerBlocks m_corners;
    std::vector<std::uint8_t> m_turned;
    AlignedVector<float> m_memory;
};

}  // namespace pliant
