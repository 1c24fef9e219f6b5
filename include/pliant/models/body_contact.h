// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of deformable solids with tools (spheres and capsules), and of the solids with each
// other.
//
//        ( ● )→            tool: surface triangles stay outside of its radius; it moves linearly
//     ──────╲   ╱──────    over the steps
//     ░░░░░░░╲_╱░░░░░░░    a piece: tetrahedra with one number
//     ─────────────────
//     ▒▒▒▒▒▒▒▒▒▒▒▒▒▒▒▒▒    another piece: nodes of each stay outside of the other's triangles
//
// @code
//   auto contact = BodyContact::create(mesh, {}, {.friction = 0.1});
//   const BodyTool from{{0, 0, 9}, {0, 0, 9}, 2}, to{{0, 0, 8}, {0, 0, 8}, 2};
//   contact->step(10, body, {&from, 1}, {&to, 1}, arena);       // instead of body.step
//   Vec3d force = contact->force(0);
// @endcode
//
// A step depends on the body's positions, velocities and masses, and on the tools. Nothing else is
// stored, so no call is needed after the body's state was set. docs/method/pbd.md has the method.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/mesh.h>
#include <pliant/models/pbd.h>
#include <pliant/result.h>

#include <cstdint>
#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

/// A capsule; a sphere if both ends are equal.
struct BodyTool {
    Vec3d from{0, 0, 0}, to{0, 0, 0};  ///< axis
    double radius = 1;
};

struct BodyContactSettings {
    double friction = 0;           ///< Coulomb friction coefficient, of tools and pieces
    std::int32_t iterations = 20;  ///< over all touches of a sub-step, at most
    double gap = 0;                ///< minimum distance of pieces that aren't nearer at rest
    /// Speed [length/time] at which overlaps that exist before a step are resolved, for example of
    /// a tool that starts inside of a solid.
    double recovery_speed = 50;
    /// Factor by which nodes that a tool touches are heavier during the body's solution, which
    /// doesn't include contact: forces of stiff bodies in long sub-steps are too low otherwise
    /// (docs/method/pbd.md).
    double touched_mass = 4;
};
SettingRows<BodyContactSettings> body_contact_rows() noexcept;

/// Thread safety: concurrent reads.
class BodyContact {
  public:
    /// Prepares contact with a body that consists of the mesh's nodes, in their order.
    /// @param mesh    at rest
    /// @param pieces  [tetrahedron]: number of its solid; empty: connected tetrahedra are a solid,
    ///                in the order of their first nodes
    /// @returns InvalidArgument that names the setting, cell or piece; LimitExceeded if memory is
    ///          short
    static Result<BodyContact> create(const TetMesh& mesh, std::span<const std::int32_t> pieces,
                                      const BodyContactSettings& settings) noexcept;
    ~BodyContact();
    BodyContact(BodyContact&&) noexcept;
    BodyContact& operator=(BodyContact&&) noexcept;

    /// Advances the body, with contact after each step. Each tool moves linearly from its first to
    /// its second position during all of the steps.
    /// @pre the body has one sub-step
    /// @returns InvalidArgument for another body, tools that aren't finite, or a tool that moves by
    ///          more than 1000 radii in a step; LimitExceeded as PbdBody::step. On an error nothing
    ///          has changed
    Status step(std::int32_t count, PbdBody& body, std::span<const BodyTool> tools_at_start,
                std::span<const BodyTool> tools_at_end, const TaskArena& arena) noexcept;

    /// Force of the body on a tool: mean over the steps of the last call. 0 for other tools.
    Vec3d force(std::size_t tool) const noexcept;
    /// Force of the other pieces on a piece, with its number: mean over the steps of the last call.
    Vec3d piece_force(std::int32_t piece) const noexcept;
    /// Largest penetration after the last step: of tools and of pieces.
    double depth_left() const noexcept;
    /// Contacts that bear a force in the last step: pairs of a tool and a triangle, and of a node
    /// and another piece.
    std::int64_t touches() const noexcept;

  private:
    struct Impl;
    explicit BodyContact(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
