// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of tools with the triangles of a network [Choi2004, 3.3]: which nodes a tool moves, and
// to which positions. Holding them and advancing the time is the caller's part:
//
//     look, move                  the tool's way; touched nodes go along
//     hold, step                  by the caller
//     look_again, keep_clear      nodes' ways; those that would pass over the tool are stopped
//
// A crossing of a tool's centre and a triangle is a root of a cubic, since both move linearly. A
// crossed triangle is translated by the depth of the tool behind it, along its normal. So a tool's
// centre stays on the outer side of all triangles, whatever the surface is folded into.

#pragma once

#include <pliant/models/springs.h>

#include <optional>
#include <span>
#include <vector>

#include "mesh/box_tree.h"

namespace pliant {

/// Passage of a point through a triangle from its outer to its inner side.
struct Crossing {
    double time;                    ///< 0…1
    std::array<double, 3> weights;  ///< barycentric, of the point in the triangle
};
/// All positions move linearly. @param at_begin, at_end  corners
std::optional<Crossing> find_crossing(Vec3d from, Vec3d to, const std::array<Vec3d, 3>& at_begin,
                                      const std::array<Vec3d, 3>& at_end);

class TriangleTouch {
  public:
    /// @pre the triangles name nodes that exist
    TriangleTouch(const SpringNetwork& network, std::vector<std::array<std::int32_t, 3>> triangles);

    std::span<const std::array<std::int32_t, 3>> triangles() const { return m_triangles; }
    double mean_edge() const { return m_mean_edge; }
    /// Positions that contact leads to, [node of the network]; only those of triangles are set.
    std::span<const Vec3d> positions() const { return m_after; }
    /// Nodes of a tool's triangles that aren't fixed, ascending. @param[out] nodes
    void nodes_of(const TouchTool& tool, std::vector<std::int32_t>& nodes) const;

    /// Takes the tissue's positions, at the beginning of a time step.
    void look(const SpringTissue& tissue);
    /// Takes them after a time step that began with positions().
    void look_again(const SpringTissue& tissue);
    /// Moves a tool. Triangles that pull at it are released first.
    /// @returns false, with the tool and positions() unchanged, if a triangle with a fixed node is
    ///          in its way
    bool move(TouchTool& tool, Vec3d way, SpringTissue& tissue);
    /// Returns to the positions at the beginning of the step.
    void take_back();
    /// Stops triangles that would have passed over a tool at rest.
    void keep_clear(TouchTool& tool);
    /// Distance of a tool's surface from the nearest triangle, on positions().
    double clearance(const TouchTool& tool, double within);

  private:
    struct Patch {
        std::int32_t begin, end;              ///< triangles, in m_order
        std::int32_t nodes_begin, nodes_end;  ///< in m_patch_nodes
    };
    enum class Blocked { No, Yes };

    void split(const SpringNetwork& network, std::span<std::int32_t> triangles);
    std::array<Vec3d, 3> corners(std::span<const Vec3d> x, std::int32_t triangle) const;
    void find_near(const mesh::Bounds& around, double margin);
    void shift(TouchTool& tool, std::int32_t triangle, Vec3d by);
    bool is_at(const TouchTool& tool, std::int32_t triangle, std::span<const Vec3d> x) const;
    void follow(TouchTool& tool, Vec3d way, SpringTissue& tissue);
    std::int32_t first_crossed(Vec3d from, Vec3d to, Crossing& crossing);
    bool push_out_of_way(TouchTool& tool, std::int32_t triangle, const Crossing& crossing,
                         bool along_normal);
    Blocked push_out_of_sphere(TouchTool& tool, Vec3d from, bool& has_pushed);
    bool clear(TouchTool& tool, Vec3d from);

    std::vector<std::array<std::int32_t, 3>> m_triangles;
    std::vector<std::int32_t> m_order;  ///< triangles by patches
    std::vector<Patch> m_patches;
    std::vector<std::int32_t> m_patch_nodes;
    std::vector<std::int32_t> m_nodes;      ///< of the triangles, ascending
    std::vector<std::uint8_t> m_has_fixed;  ///< [triangle]
    std::vector<std::uint8_t> m_is_fixed;   ///< [node of the network]
    double m_mean_edge = 0, m_gap = 0;      ///< m_gap: between a tool and touched triangles
    std::vector<Vec3d> m_before, m_after;   ///< [node of the network]
    // Memory of calls.
    std::vector<std::int32_t> m_near, m_touched_nodes, m_followed;
    double m_margin = 0;  ///< m_near is complete until triangles have been shifted by so much
    std::vector<Vec3d> m_shifts;
    std::vector<std::int32_t> m_shift_counts;
};

}  // namespace pliant
