// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/research/rod.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include "base/errors.h"
#include "base/text.h"
#include "rods/rod_solver.h"

namespace pliant {
namespace {

using R = RodSettings;

constexpr Setting<R> kRod[] = {
    setting<&R::segments>({.name = "segments", .range = {1, 1e6}, .text = "rigid segments"}),
    setting<&R::length>(
        {.name = "length", .range = {.low = 0}, .above_low = true, .text = "of the whole rod"}),
    setting<&R::mass>(
        {.name = "mass", .range = {.low = 0}, .above_low = true, .text = "of the whole rod"}),
    setting<&R::bend_stiffness>(
        {.name = "bend_stiffness", .range = {.low = 0}, .above_low = true, .text = "EI"}),
    setting<&R::twist_stiffness>(
        {.name = "twist_stiffness", .range = {.low = 0}, .above_low = true, .text = "GJ"}),
    setting<&R::stretch_stiffness>(
        {.name = "stretch_stiffness", .range = {.low = 0}, .above_low = true, .text = "EA"}),
    setting<&R::shear_stiffness>(
        {.name = "shear_stiffness", .range = {.low = 0}, .above_low = true, .text = "GA"}),
    setting<&R::tip_segments>(
        {.name = "tip_segments", .range = {0, 1e6}, .text = "segments that steering bends"}),
    setting<&R::base>({.name = "base", .text = "position of its first end"}),
    setting<&R::time_step>({.name = "time_step",
                            .range = {.low = 0},
                            .above_low = true,
                            .text = "duration of a step"}),
    setting<&R::sub_steps>(
        {.name = "sub_steps", .range = {.low = 1}, .text = "sub-steps of a step"}),
    setting<&R::iterations>(
        {.name = "iterations", .range = {.low = 1}, .text = "Newton iterations in a sub-step"}),
    setting<&R::gravity>({.name = "gravity", .text = "acceleration of all segments"}),
    setting<&R::damping>({.name = "damping",
                          .range = {.low = 0},
                          .text = "of velocities [1/time]; at most one over the sub-step"}),
};

Status check_settings(const RodSettings& s) {
    if (Status status = check(s, rod_rows()); !status.ok()) return status;
    if (s.tip_segments > s.segments)
        return invalid("tip_segments: expected 0 to " + std::to_string(s.segments) + ", found " +
                       std::to_string(s.tip_segments));
    if (s.damping * s.time_step > s.sub_steps)
        return invalid("damping: expected 0 to " + short_text(s.sub_steps / s.time_step) +
                       ", one over the sub-step, found " + short_text(s.damping));
    return Ok{};
}

/// Returns a unit quaternion, or an error.
Result<Rotation> checked(const char* what, Rotation q) {
    const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    if (!pbd::is_of_length_1(q))
        return invalid(std::string(what) + ": expected a rotation of length 1, found " +
                       short_text(length));
    return Rotation{q.w / length, q.x / length, q.y / length, q.z / length};
}

}  // namespace

SettingRows<RodSettings> rod_rows() noexcept {
    return kRod;
}

struct Rod::Impl : pbd::RodSolver {
    using pbd::RodSolver::RodSolver;
};

Rod::Rod(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
Rod::~Rod() = default;
Rod::Rod(Rod&&) noexcept = default;
Rod& Rod::operator=(Rod&&) noexcept = default;

Result<Rod> Rod::create(const RodSettings& settings) {
    if (const Status s = check_settings(settings); !s.ok()) return s.error();
    RodSettings good = settings;
    const auto frame = checked("frame", settings.frame);
    if (!frame.ok()) return frame.error();
    good.frame = *frame;
    return attempt([&]() -> Result<Rod> { return Rod(std::make_unique<Impl>(good)); });
}

const RodSettings& Rod::settings() const {
    return m_impl->settings;
}

Status Rod::set_base(Vec3d position, Rotation frame) {
    if (!is_finite(position)) return invalid("set_base: expected a position of three numbers");
    const auto good = checked("set_base", frame);
    if (!good.ok()) return good.error();
    m_impl->x[0] = position;
    m_impl->base_frame = *good;
    return Ok{};
}

Status Rod::hold_tip(Vec3d position, Rotation frame) {
    if (!is_finite(position)) return invalid("hold_tip: expected a position of three numbers");
    const auto good = checked("hold_tip", frame);
    if (!good.ok()) return good.error();
    Impl& rod = *m_impl;
    rod.tip_frame = *good;
    rod.x[rod.count] = position;
    rod.v[rod.count] = {0, 0, 0};
    rod.w_node[rod.count] = 0;
    rod.resize_blocks(rod.count + 1);
    return Ok{};
}
void Rod::release_tip() {
    Impl& rod = *m_impl;
    if (!rod.tip_is_held()) return;
    rod.w_node[rod.count] = 2 * rod.settings.segments / rod.settings.mass;
    rod.resize_blocks(rod.count);
}

Status Rod::steer(double angle, double direction) {
    if (!std::isfinite(angle) || !std::isfinite(direction))
        return invalid("steer: expected two numbers");
    const auto tip = std::size_t(m_impl->settings.tip_segments);
    if (tip == 0) return invalid("steer: expected a rod with tip_segments above 0");
    // Bending towards the first axis is a rotation about the second one.
    const double share = angle / double(tip);
    for (std::size_t i = m_impl->count - tip; i < m_impl->count; ++i)
        m_impl->rest[i] = {-share * std::sin(direction), share * std::cos(direction), 0};
    return Ok{};
}

Status Rod::load(std::int32_t node, Vec3d force) {
    if (node < 0 || node > m_impl->settings.segments)
        return invalid("load: expected a node up to " + std::to_string(m_impl->settings.segments) +
                       ", found " + std::to_string(node));
    if (!is_finite(force)) return invalid("load: expected a force of three numbers");
    m_impl->force[std::size_t(node)] = force;
    return Ok{};
}
Status Rod::load_moment(std::int32_t segment, Vec3d moment) {
    if (segment < 0 || segment >= m_impl->settings.segments)
        return invalid("load_moment: expected a segment below " +
                       std::to_string(m_impl->settings.segments) + ", found " +
                       std::to_string(segment));
    if (!is_finite(moment)) return invalid("load_moment: expected a moment of three numbers");
    m_impl->moment[std::size_t(segment)] = moment;
    return Ok{};
}

Status Rod::step(std::int32_t count) {
    if (count < 0) return invalid("step: expected 0 steps or more, found " + std::to_string(count));
    Impl& rod = *m_impl;
    for (std::int32_t n = 0; n < count; ++n) {
        rod.good_x = rod.x;
        rod.good_q = rod.q;
        rod.good_v = rod.v;
        rod.good_spin = rod.spin;
        for (std::int32_t s = 0; s < rod.settings.sub_steps; ++s) rod.sub_step();
        if (rod.is_good()) continue;
        rod.x = rod.good_x;
        rod.q = rod.good_q;
        rod.v = rod.good_v;
        rod.spin = rod.good_spin;
        return Error{ErrorCode::LimitExceeded,
                     "step: a position or velocity is no longer finite; expected more sub-steps, "
                     "iterations or damping"};
    }
    return Ok{};
}

Vec3d Rod::position(std::int32_t node) const {
    PLIANT_ASSERT(node >= 0 && node <= m_impl->settings.segments);
    return m_impl->x[std::size_t(node)];
}
Rotation Rod::orientation(std::int32_t segment) const {
    PLIANT_ASSERT(segment >= 0 && segment < m_impl->settings.segments);
    return m_impl->q[std::size_t(segment)];
}
Vec3d Rod::velocity(std::int32_t node) const {
    PLIANT_ASSERT(node >= 0 && node <= m_impl->settings.segments);
    return m_impl->v[std::size_t(node)];
}
Vec3d Rod::spin(std::int32_t segment) const {
    PLIANT_ASSERT(segment >= 0 && segment < m_impl->settings.segments);
    return m_impl->spin[std::size_t(segment)];
}
double Rod::inverse_mass(std::int32_t node) const {
    PLIANT_ASSERT(node >= 0 && node <= m_impl->settings.segments);
    return m_impl->w_node[std::size_t(node)];
}
double Rod::inverse_inertia() const {
    return m_impl->w_turn;
}
void Rod::displace(std::int32_t node, Vec3d by) {
    PLIANT_ASSERT(node >= 0 && node <= m_impl->settings.segments);
    const auto n = std::size_t(node);
    m_impl->x[n] = m_impl->x[n] + by;
    if (n > 0) m_impl->v[n] = m_impl->v[n] + (1 / m_impl->h) * by;
}
void Rod::displace_segment(std::int32_t segment, Vec3d turned_by) {
    PLIANT_ASSERT(segment >= 0 && segment < m_impl->settings.segments);
    const auto i = std::size_t(segment);
    m_impl->q[i] = rotation_by(turned_by) * m_impl->q[i];
    m_impl->spin[i] = m_impl->spin[i] + (1 / m_impl->h) * turned_by;
}
Vec3d Rod::base_force() const {
    const double scale = 1 / (m_impl->h * m_impl->h);
    return scale * m_impl->pull(m_impl->lambda, 0, pbd::kNodeBefore);
}
Vec3d Rod::base_moment() const {
    const double scale = 1 / (m_impl->h * m_impl->h);
    return scale * m_impl->pull(m_impl->lambda, 0, pbd::kTurnBefore);
}
Vec3d Rod::turn(std::int32_t segment) const {
    PLIANT_ASSERT(segment >= 0 && segment < m_impl->settings.segments);
    return m_impl->turn_of(std::size_t(segment));
}
double Rod::elastic_energy() const {
    double energy = 0;
    for (std::size_t i = 0; i < m_impl->right.size(); ++i) {
        const pbd::BlockVector soft = m_impl->compliance(i);
        const Vec3d strain = m_impl->strain_of(i), bend = m_impl->turn_of(i) - m_impl->rest_of(i);
        for (int r = 0; r < 3; ++r)
            energy += 0.5 * (strain[r] * strain[r] / soft[std::size_t(r)] +
                             bend[r] * bend[r] / soft[std::size_t(r) + 3]);
    }
    return energy;
}

}  // namespace pliant
