// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A guidewire or catheter as a Cosserat rod: places of nodes and orientations of the segments
// between them [Kugelstadt2016], with the compliance of a material [Macklin2016], solved directly
// for the whole rod [Deul2018].
//
//   base ●──────●──────●──────●   nodes x₀ … x_n; segment i, from x_i to x_{i+1}, has orientation
//         q₀     q₁     q₂        q_i, whose third axis is along it; the base holds x₀ and a frame
//
//   auto rod = Rod::create({.segments = 50, .length = 1, .bend_stiffness = 1});
//   rod->set_base({0, 0, 0.01}, rotation_by({0, 0, 1}));  // pushed and turned
//   rod->steer(0.5, 0);                                // the tip wants to bend
//   rod->step(100);
//
// Any consistent units will do; docs/pbd.md has the energy.

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
/// About a vector by its length.
Rotation rotation_by(Vec3d vector);
/// First b, then a.
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
/// The inverse of rotation_by, of length 0…π.
Vec3d rotation_vector(Rotation rotation);

struct RodSettings {
    std::int32_t segments = 50;
    double length = 1;
    double mass = 1;
    double bend_stiffness = 1;       ///< EI
    double twist_stiffness = 1;      ///< GJ
    double stretch_stiffness = 1e4;  ///< EA
    double shear_stiffness = 1e4;    ///< GA
    std::int32_t tip_segments = 0;   ///< that steering bends
    /// Where it lies at first: straight from the base along the frame's third axis.
    Vec3d base{0, 0, 0};
    Rotation frame{};

    double time_step = 0.01;
    std::int32_t sub_steps = 1;
    std::int32_t iterations = 2;  ///< of Newton's method, in each sub-step
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

    /// Where the base is from now on, and the frame that the first segment is joined to.
    Status set_base(Vec3d place, Rotation frame);
    /// The last node and the frame that the last segment is joined to, as at the base: a ring is a
    /// rod whose ends are held together. From now on, until it is released.
    Status hold_tip(Vec3d place, Rotation frame);
    void release_tip();
    /// The rest shape of the tip: all in all bent by `angle`, towards the axis that is `direction`
    /// from the first one about the rod.
    Status steer(double angle, double direction);
    /// Force on a node and moment on a segment, instead of those before.
    Status load(std::int32_t node, Vec3d force);
    Status load_moment(std::int32_t segment, Vec3d moment);

    /// @returns LimitExceeded, with the rod as it was before the last step, where a place is no
    ///          number any more
    Status step(std::int32_t count);

    Vec3d position(std::int32_t node) const;
    Rotation orientation(std::int32_t segment) const;
    Vec3d velocity(std::int32_t node) const;
    /// Of a segment, in the world. [rad/time]
    Vec3d spin(std::int32_t segment) const;
    double inverse_mass(std::int32_t node) const;  ///< 0 at the base and at a held tip
    double inverse_inertia() const;                ///< of a segment, about every axis
    /// What a constraint from outside does at the end of a sub-step: the node moves, and its
    /// velocity changes as if it had moved so during the sub-step; a segment turns in the same way.
    void displace(std::int32_t node, Vec3d by);
    void displace_segment(std::int32_t segment, Vec3d turned_by);

    /// Of the rod on what holds its base.
    Vec3d base_force() const;
    Vec3d base_moment() const;
    /// How far segment and segment − 1 (or the base) are turned against each other, in the frame of
    /// the former one: two bends and the twist. [rad]
    Vec3d turn(std::int32_t segment) const;
    /// Of stretch, shear, bend and twist.
    double elastic_energy() const;

  private:
    struct Impl;
    explicit Rod(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
