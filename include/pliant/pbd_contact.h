// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact between a rod and a vessel. The rod consists of capsules around its segments. It touches
// the triangles of the ghost surface, which are embedded in the tetrahedra of the wall. The rod
// bends and the wall gives way.
//
//     ░░░░░░░░░░░░░░░░░  wall: particles and constraints
//     ─────▲───────────  ghost: triangles that face the lumen
//      (══●════●═)       rod: points nearer than its radius to the ghost are separated, both sides
//                        in proportion to their inverse masses; friction acts along the ghost
//
//   auto contact = RodContact::create(wall.mesh, wall.ghost, wall.ghost_places,
//                                     {.radius = 0.5, .friction = 0.1});
//   rod.set_base(…);
//   contact->step(1, rod, body, arena);                 // instead of rod.step and body.step
//   for (const WallTouch& t : contact->touches()) …t.force
//
// The rod starts in the lumen, or beyond one of its open ends.

#pragma once

#include <pliant/mesh_quality.h>
#include <pliant/pbd.h>
#include <pliant/pbd_rod.h>

#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

struct RodContactSettings {
    double radius = 0.5;          ///< of the rod
    double friction = 0;          ///< Coulomb friction coefficient
    std::int32_t iterations = 8;  ///< over all touches
    std::int32_t rounds = 2;      ///< contact searches per step
};

/// A contact point.
struct WallTouch {
    std::int32_t segment = 0;
    double along = 0;  ///< 0 at the segment's first node, 1 at its second
    std::int32_t triangle = 0;
    Vec3d place{0, 0, 0};   ///< on the ghost surface
    Vec3d normal{0, 0, 0};  ///< from the wall to the rod's axis
    Vec3d force{0, 0, 0};   ///< on the rod, including friction
};

class RodContact {
  public:
    /// Prepares contact with a body that consists of the mesh's nodes, in their order.
    /// @returns InvalidArgument that names the setting, triangle or node
    static Result<RodContact> create(const TetMesh& mesh, const TriangleMesh& ghost,
                                     std::span<const Embedded> ghost_places,
                                     const RodContactSettings& settings);
    ~RodContact();
    RodContact(RodContact&&) noexcept;
    RodContact& operator=(RodContact&&) noexcept;

    /// Advances both, with contact after each step. Both have the same time step and one sub-step.
    /// @returns InvalidArgument if they differ, or the body isn't the mesh's; LimitExceeded if a
    ///          position is no longer finite: the rod may then be a step ahead of the body
    Status step(std::int32_t count, Rod& rod, PbdBody& body, const TaskArena& arena);

    /// Contacts of the last step that bear a force. A contact that two rounds found is listed
    /// twice, with the force of each round.
    std::span<const WallTouch> touches() const;
    /// Largest remaining penetration of the ghost surface over the contacts of the last step.
    double depth_left() const;

  private:
    struct Impl;
    explicit RodContact(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
