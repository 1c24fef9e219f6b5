// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A guidewire or catheter as a Cosserat rod: positions of nodes and orientations of the segments
// between them [Kugelstadt2016], with the compliance of a material [Macklin2016], and a direct
// solution for the whole rod [Deul2018].
//
//   base ●──────●──────●──────●   nodes x₀ … x_n; segment i, from x_i to x_{i+1}, has orientation
//         q₀     q₁     q₂        q_i, whose third axis points along it; base: x₀ and a frame
//
// @code
//   auto rod = Rod::create({.segments = 50, .length = 1, .bend_stiffness = 1});
//   rod->set_base({0, 0, 0.01}, rotation_by({0, 0, 1}));  // pushed and turned
//   rod->steer(0.5, 0);                          // bends the rest shape of the tip
//   rod->step(100);
// @endcode
//
// Any consistent units apply; docs/method/pbd.md has the energy.

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

struct RodSettings {
    std::int32_t segments = 50;
    double length = 1;
    double mass = 1;
    double bend_stiffness = 1;       ///< EI
    double twist_stiffness = 1;      ///< GJ
    double stretch_stiffness = 1e4;  ///< EA
    double shear_stiffness = 1e4;    ///< GA
    std::int32_t tip_segments = 0;   ///< segments that steering bends
    /// Initial state: straight from the base along the frame's third axis.
    Vec3d base{0, 0, 0};
    Rotation frame{};

    double time_step = 0.01;
    std::int32_t sub_steps = 1;
    std::int32_t iterations = 2;  ///< Newton iterations per sub-step
    Vec3d gravity{0, 0, 0};
    double damping = 0;  ///< of velocities, in 1/time
};
SettingRows<RodSettings> rod_rows() noexcept;

/// Thread safety: concurrent reads.
class Rod {
  public:
    /// @returns InvalidArgument that names the setting
    static Result<Rod> create(const RodSettings& settings);
    ~Rod();
    Rod(Rod&&) noexcept;
    Rod& operator=(Rod&&) noexcept;

    const RodSettings& settings() const;

    /// Moves the base, and the frame to which the first segment is joined.
    Status set_base(Vec3d position, Rotation frame);
    /// Holds the last node, and joins the last segment to a frame, until release_tip(). A ring is a
    /// rod with both ends held together.
    Status hold_tip(Vec3d position, Rotation frame);
    void release_tip();
    /// Sets the rest shape of the tip: a total bend of `angle`, towards the axis at `direction`
    /// from the first axis about the rod.
    Status steer(double angle, double direction);
    /// Set the force on a node and the moment on a segment; they replace the previous ones.
    Status load(std::int32_t node, Vec3d force);
    Status load_moment(std::int32_t segment, Vec3d moment);

    /// @returns LimitExceeded if a position is no longer finite; then the failed step changes
    ///          nothing
    Status step(std::int32_t count);

    Vec3d position(std::int32_t node) const;
    Rotation orientation(std::int32_t segment) const;
    Vec3d velocity(std::int32_t node) const;
    /// Angular velocity of a segment in the world [rad/time].
    Vec3d spin(std::int32_t segment) const;
    double inverse_mass(std::int32_t node) const;  ///< 0 at the base and at a held tip
    double inverse_inertia() const;                ///< of a segment, about every axis
    /// Applies an external constraint at the end of a sub-step: the node moves, and its velocity
    /// changes as if it had moved during the sub-step. displace_segment rotates a segment likewise.
    void displace(std::int32_t node, Vec3d by);
    void displace_segment(std::int32_t segment, Vec3d turned_by);

    /// Reaction of the rod on the support of its base.
    Vec3d base_force() const;
    Vec3d base_moment() const;
    /// Relative rotation of segment and segment − 1 (or the base), in the frame of the latter: two
    /// bends and the twist [rad].
    Vec3d turn(std::int32_t segment) const;
    /// Energy of stretch, shear, bend and twist.
    double elastic_energy() const;

  private:
    struct Impl;
    explicit Rod(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

// Contact between a rod and a vessel. The rod consists of capsules around its segments. It touches
// the triangles of the ghost surface, which are embedded in the tetrahedra of the wall. The rod
// bends and the wall gives way.
//
//     ░░░░░░░░░░░░░░░░░  wall: particles and constraints
//     ─────▲───────────  ghost: triangles that face the lumen
//      (══●════●═)       rod: points nearer than its radius to the ghost are separated, both sides
//                        in proportion to their inverse masses; friction acts along the ghost
//
// @code
//   auto contact = RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions,
//                                     {.radius = 0.5, .friction = 0.1});
//   rod.set_base({0, 0, 0.01}, rotation_by({0, 0, 1}));
//   contact->step(1, rod, body, arena);          // instead of rod.step and body.step
//   for (const WallTouch& t : contact->touches()) show(t.force);
// @endcode
//
// The rod starts in the lumen, or beyond one of its open ends.

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
    Vec3d position{0, 0, 0};  ///< on the ghost surface
    Vec3d normal{0, 0, 0};    ///< from the wall to the rod's axis
    Vec3d force{0, 0, 0};     ///< on the rod, including friction
};

/// Thread safety: concurrent reads.
class RodContact {
  public:
    /// Prepares contact with a body that consists of the mesh's nodes, in their order.
    /// @returns InvalidArgument that names the setting, triangle or node
    static Result<RodContact> create(const TetMesh& mesh, const TriangleMesh& ghost,
                                     std::span<const Embedded> ghost_positions,
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
