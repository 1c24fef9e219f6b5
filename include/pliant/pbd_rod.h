// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A guidewire or catheter as a Cosserat rod: positions of nodes and orientations of the segments
// between them [Kugelstadt2016], with the compliance of a material [Macklin2016], and a direct
// solution for the whole rod [Deul2018].
//
//   base ●──────●──────●──────●   nodes x₀ … x_n; segment i, from x_i to x_{i+1}, has orientation
//         q₀     q₁     q₂        q_i, whose third axis points along it; base: x₀ and a frame
//
//   auto rod = Rod::create({.segments = 50, .length = 1, .bend_stiffness = 1});
//   rod->set_base({0, 0, 0.01}, rotation_by({0, 0, 1}));  // pushed and turned
//   rod->steer(0.5, 0);                                // bends the rest shape of the tip
//   rod->step(100);
//
// Any consistent units apply; docs/pbd.md has the energy.

#pragma once

#include <pliant/result.h>
#include <pliant/vec.h>

#include <cstdint>
#include <memory>

#pragma GCC visibility push(default)
namespace pliant {

/// A rotation, w + xi + yj + zk of length 1.
struct Rotation {
    double w = 1, x = 0, y = 0, z = 0;
};
/// Rotation about a vector by its length.
Rotation rotation_by(Vec3d vector);
/// Product: first b, then a.
constexpr Rotation operator*(Rotation a, Rotation b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
constexpr Vec3d rotated(Rotation q, Vec3d v) {
    const Vec3d u{q.x, q.y, q.z};
    const Vec3d t = 2.0 * cross(u, v);
    return v + q.w * t + cross(u, t);
}
/// Inverse of rotation_by, of length 0…π.
Vec3d rotation_vector(Rotation rotation);

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

class Rod {
  public:
    /// @returns InvalidArgument that names the setting
    static Result<Rod> create(const RodSettings& settings);
    ~Rod();
    Rod(Rod&&) noexcept;
    Rod& operator=(Rod&&) noexcept;

    const RodSettings& settings() const;

    /// Moves the base, and the frame to which the first segment is joined.
    Status set_base(Vec3d place, Rotation frame);
    /// Holds the last node, and joins the last segment to a frame, until release_tip(). A ring is a
    /// rod with both ends held together.
    Status hold_tip(Vec3d place, Rotation frame);
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

}  // namespace pliant
#pragma GCC visibility pop
