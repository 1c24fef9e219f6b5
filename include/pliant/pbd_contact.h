// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A rod in a vessel: the whole rod, as capsules around its segments, touches the triangles of the
// ghost surface, which ride on the tetrahedra of the wall. The rod bends, the wall gives way.
//
//     ░░░░░░░░░░░░░░░░░  wall: particles and constraints
//     ─────▲───────────  ghost: triangles that face the lumen
//      (══●════●═)       rod: what is less than its radius from the ghost is moved apart,
//                        both sides by their masses, and held back along it by friction
//
//   auto contact = RodContact::create(wall.mesh, wall.ghost, wall.ghost_places,
//                                     {.radius = 0.5, .friction = 0.1});
//   rod.set_base(…);
//   contact->step(1, rod, body, arena);                 // instead of rod.step and body.step
//   for (const WallTouch& t : contact->touches()) …t.force
//
// The rod begins in the lumen, or beyond one of its open ends.

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
    double friction = 0;          ///< Coulomb's
    std::int32_t iterations = 8;  ///< over all touches
    std::int32_t rounds = 2;      ///< of looking for touches, in each step
};

/// Where the rod touches the wall.
struct WallTouch {
    std::int32_t segment = 0;
    double along = 0;  ///< 0 at the segment's first node, 1 at its second
    std::int32_t triangle = 0;
    Vec3d place{0, 0, 0};   ///< on the ghost surface
    Vec3d normal{0, 0, 0};  ///< from the wall to the rod's axis
    Vec3d force{0, 0, 0};   ///< on the rod, friction with it
};

class RodContact {
  public:
    /// The body is made of the mesh's nodes, in their order.
    /// @returns InvalidArgument that names the setting, triangle or node
    static Result<RodContact> create(const TetMesh& mesh, const TriangleMesh& ghost,
                                     std::span<const Embedded> ghost_places,
                                     const RodContactSettings& settings);
    ~RodContact();
    RodContact(RodContact&&) noexcept;
    RodContact& operator=(RodContact&&) noexcept;

    /// Steps of both, each followed by contact. Both have the same time step and one sub-step.
    /// @returns InvalidArgument where they don't, or the body isn't the mesh's; LimitExceeded where
    ///          a place is no number any more: the rod may then be a step ahead of the body
    Status step(std::int32_t count, Rod& rod, PbdBody& body, const TaskArena& arena);

    /// Of the last step, those that bear a force. One that was found in two rounds is there twice,
    /// with what each added.
    std::span<const WallTouch> touches() const;
    /// Of the last step: how far the rod's surface was left beyond the ghost surface where it was
    /// found to touch.
    double depth_left() const;

  private:
    struct Impl;
    explicit RodContact(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
