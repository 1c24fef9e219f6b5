// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of tools with the surface of a body. A touch is the nearest pair of points p of the
// tool's axis and q of a triangle, whichever features of the triangle and the capsule they are on:
//
//   C = |p − q| − radius ≥ 0,  Δx_k = −w_k b_k λ n,  n = (p − q)/|p − q|,  λ ≥ 0
//
// n points out of the body as long as the axis stays outside. So a sub-step is divided into
// strides, in which tool and surface approach by at most half of a radius, and each of them ends
// with the surface at a radius from the axis. A tool that overlaps the body before a sub-step is
// replaced by one that is shifted out by the nearest way, except for the depth that may be resolved
// in a sub-step: it then comes in again, sub-step by sub-step.

#pragma once

#include <pliant/models/body_contact.h>

#include <cstdint>
#include <span>
#include <vector>

#include "pbd/body_surface.h"

namespace pliant::pbd {

/// State of the surface's nodes in a sub-step.
struct SurfaceMotion {
    std::vector<Vec3d> x;        ///< present positions
    std::vector<Vec3d> before;   ///< at the start of the stride
    std::vector<double> tool_w;  ///< inverse masses, as tools feel them
    double friction = 0;
    double tiny = 0;                       ///< length of a shift that touches need not follow
    std::vector<std::int64_t> shifted_at;  ///< [node]: number of its last shift beyond that
    std::int64_t shifts = 0;               ///< so far

    void move(std::int32_t node, Vec3d shift) {
        x[std::size_t(node)] = x[std::size_t(node)] + shift;
        if (dot(shift, shift) > tiny * tiny) shifted_at[std::size_t(node)] = ++shifts;
    }
};

/// A tool in a sub-step.
struct ToolMotion {
    BodyTool start, end;
    Vec3d impulse{0, 0, 0};  ///< on the tool [mass · length]
    bool is_stuck = false;   ///< its axis can't be brought outside of the body
};

/// The tool at a share 0…1 of its way.
BodyTool tool_at(const BodyTool& start, const BodyTool& end, double share);

/// Depth of a tool in the body: radius − signed distance of the axis, the way out, and whether the
/// axis passes through the surface.
struct ToolDepth {
    double depth = 0;
    Vec3d out{0, 0, 0};  ///< unit vector; 0 if the depth is at most the tolerated one
    bool crosses = false;
};
/// @param tolerated  depth at which the way out isn't needed
ToolDepth depth_of(const BodySurface& surface, const PatchBoxes& boxes, std::span<const Vec3d> x,
                   const BodyTool& tool, double tolerated);

class ToolContact {
  public:
    /// Finds the triangles near the tools at a share of their ways.
    void look(const BodySurface& surface, const PatchBoxes& boxes, std::span<const Vec3d> x,
              std::span<const ToolMotion> tools, double share);
    /// Calls use(node, weight) for the nodes that bear a touch.
    template <class Use>
    void for_touched(const BodySurface& surface, std::span<const Vec3d> x, double nearness,
                     const Use& use) const;
    /// Projects all touches once. @param strides  of the sub-step
    /// @returns the largest depth before that, as a share of the radius
    double project(const BodySurface& surface, SurfaceMotion& motion, std::span<ToolMotion> tools,
                   int strides);
    /// Calls use(node) for all nodes of the found triangles.
    template <class Use>
    void for_nodes(const BodySurface& surface, const Use& use) const {
        for (const Row& row : m_rows)
            for (const std::int32_t n : surface.triangles()[std::size_t(row.triangle)]) use(n);
    }
    std::int64_t touches() const;

  private:
    struct Row {
        std::int32_t tool, triangle;
        double push;  ///< λ
        Vec3d drag;   ///< friction's λ, on the tool
    };
    std::vector<BodyTool> m_tools;  ///< where they are
    std::vector<Row> m_rows;        ///< sorted by tool and triangle
};

}  // namespace pliant::pbd

#include "pbd/segment_triangle.h"

namespace pliant::pbd {

template <class Use>
void ToolContact::for_touched(const BodySurface& surface, std::span<const Vec3d> x, double nearness,
                              const Use& use) const {
    for (const Row& row : m_rows) {
        const BodyTool& tool = m_tools[std::size_t(row.tool)];
        const auto& t = surface.triangles()[std::size_t(row.triangle)];
        const Vec3d a = x[std::size_t(t[0])], b = x[std::size_t(t[1])], c = x[std::size_t(t[2])];
        const NearestPair pair = nearest_pair(tool.from, tool.to, a, b, c);
        if (!(norm(pair.on_segment - pair.on_triangle) < nearness * tool.radius)) continue;
        const auto weights = mesh::weights_on_triangle(pair.on_triangle, a, b, c);
        for (std::size_t k = 0; k < 3; ++k) use(t[k], weights[k]);
    }
}

}  // namespace pliant::pbd
