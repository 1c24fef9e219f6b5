// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Restricts the moves of relaxing elements to their movement limits and to the outside of tools.
//
// An element moves one component after the other. The path of each is a straight piece along an
// axis of the lattice. An element outside of a tool takes it only if the whole piece keeps the
// tool's radius from the tool's segment; one inside, only if it ends no deeper. Otherwise it tries
// half of the path, a quarter, and so on: after a few sweeps it touches the tool.

#pragma once

#include <pliant/models/relax.h>

#include <span>
#include <vector>

#include "lattice/lattice.h"
#include "relax/relax_kernel.h"

namespace pliant {

/// Squared distance of the segments p0 p1 and q0 q1 [Ericson2005, 5.1.9].
double squared_distance_of_segments(Vec3d p0, Vec3d p1, Vec3d q0, Vec3d q1);

/// Tools in millimetres along the lattice's axes, from voxel (0, 0, 0).
class ToolContact {
  public:
    ToolContact() = default;
    ToolContact(const Grid& grid, std::span<const RelaxTool> tools);

    /// Whether a point of the box may touch a tool.
    bool may_touch(Vec3d low_mm, Vec3d high_mm) const;
    /// Whether an element may move straight from one position to another.
    bool allows(Vec3d from_mm, Vec3d to_mm) const;
    bool empty() const { return m_tools.empty(); }

  private:
    std::vector<RelaxTool> m_tools;
};

/// Guard of one brick's elements.
class BrickGuard final : public MoveGuard {
  public:
    BrickGuard(const Lattice& lattice, const Brick& brick, const ToolContact& tools)
        : m_lattice(lattice), m_brick(brick), m_tools(tools) {}
    Vec3<Fixed> admit(int index, Vec3<Fixed> from, Vec3<Fixed> to) const override;

  private:
    Fixed halved_until_allowed(Vec3d rest_mm, Vec3<Fixed> from, int axis, Fixed to) const;

    const Lattice& m_lattice;
    const Brick& m_brick;
    const ToolContact& m_tools;
};

/// Whether moves of the brick's elements may meet a tool, from the displacements of the brick and
/// of its neighbours. @pre none of them has an imprint
bool may_meet_tool(const Lattice& lattice, const Brick& brick, const ToolContact& tools);

}  // namespace pliant
