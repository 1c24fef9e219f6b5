// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "catheter/rod_wire.h"

#include <algorithm>
#include <cmath>

#include "pbd/rotations.h"

namespace pliant::catheter {
namespace {

using pbd::crossing;
using pbd::inverse_of;
using pbd::log_derivative;
using pbd::outer;
using pbd::scaled;
using pbd::sum;
using pbd::turn_by;
using pbd::turn_of;
using pbd::unit;

/// Limit of a rotation in one Newton step [rad]; only a wire far from rest reaches it.
constexpr double kMaxTurn = 0.5;
/// Springs of a held tip: it gives way by 10⁻⁴ mm to 1 N, and by 10⁻⁶ rad to 1 N mm.
constexpr double kHold = 1e10, kHoldTurn = 1e12;  // [µN/mm], [µN mm]

}  // namespace

RodWire::RodWire(const WireSettings& settings, double inserted_mm) : Wire(settings, inserted_mm) {
    const double l = settings.segment_mm, mass = settings.mass_g_mm * l;
    m_inertia = mass * l * l / 12;
    m_mass.assign(m_count + 1, mass);
    m_mass.front() = m_mass.back() = 0.5 * mass;
    m_q.assign(m_count, settings.frame);
    m_spin.assign(m_count, {0, 0, 0});
    m_rest.assign(m_count, {0, 0, 0});
    m_predicted_x = m_x;
    m_old_q = m_predicted_q = m_q;
    m_chain.reserve(m_count);
}

void RodWire::bend_tip(double first_rad, double second_rad) {
    const auto tip = std::size_t(m_settings.tip_segments);
    if (tip == 0) return;
    // Bending towards the first axis is a rotation about the second one.
    const double share = 1 / double(tip);
    for (std::size_t i = m_count - tip; i < m_count; ++i)
        m_rest[i] = {-share * second_rad, share * first_rad, 0};
}

/// Places the nodes in the guide along its axis, with its rotation. Nodes that entered off the axis
/// are led there smoothly.
void RodWire::hold() {
    const Vec3d axis = rotated(m_settings.frame, {0, 0, 1});
    const Rotation frame = m_settings.frame * rotation_by({0, 0, m_turned});
    const double keep = std::exp(-m_h / kSettle);
    for (std::size_t n = 0; n <= std::size_t(m_first); ++n) {
        const double at = fed_mm(n);
        Vec3d beside = m_x[n] - m_settings.entry;
        beside = keep * (beside - dot(beside, axis) * axis);
        m_x[n] = m_settings.entry + at * axis + beside;
        if (n == std::size_t(m_first)) break;
        const Vec3d off = rotation_vector(inverse_of(frame) * m_q[n]);
        m_q[n] = frame * rotation_by(keep * off);
    }
}

void RodWire::predict(double h) {
    m_h = h;
    m_old_x = m_x;
    m_old_q = m_q;
    hold();
    const double keep = std::max(0.0, 1 - m_settings.damping * h);
    for (std::size_t n = std::size_t(m_first) + 1; n <= m_count; ++n)
        m_x[n] = m_x[n] + (h * keep) * m_v[n];
    for (auto i = std::size_t(m_first); i < m_count; ++i)
        m_q[i] = unit(turn_by((h * keep) * m_spin[i]) * m_q[i]);
    m_predicted_x = m_x;
    m_predicted_q = m_q;
}

/// Reference frame of a segment's joint: the previous segment, or the guide.
Rotation RodWire::before(std::size_t i) const {
    return i > 0 ? m_q[i - 1] : m_settings.frame * rotation_by({0, 0, m_turned});
}

Vec3d RodWire::turn(std::int32_t segment) const {
    const auto i = std::size_t(segment);
    return turn_of(inverse_of(before(i)) * m_q[i]);
}

/// R D Γ: the segment's force on its nodes.
Vec3d RodWire::stretch_force(std::size_t i) const {
    const Vec3d e = (1 / m_settings.segment_mm) * (m_x[i + 1] - m_x[i]);
    return m_settings.stretch * (e - rotated(m_q[i], {0, 0, 1}));
}
/// B (r − r₀)/l, in the frame of the previous segment. @param turned  r
Vec3d RodWire::bend_moment(std::size_t i, Vec3d turned) const {
    const Vec3d off = turned - m_rest[i];
    const double l = m_settings.segment_mm;
    return {m_settings.bend[i] / l * off.x, m_settings.bend[i] / l * off.y,
            m_settings.twist[i] / l * off.z};
}

/// ½ l |e − R e₃|² EA, e = (x₊ − x₋)/l: with GA = EA the energy is isotropic.
void RodWire::add_segment(std::size_t i) {
    const std::size_t k = i - std::size_t(m_first);
    const double l = m_settings.segment_mm, s = m_settings.stretch;
    const Vec3d axis = rotated(m_q[i], {0, 0, 1});
    const Vec3d f = stretch_force(i);
    // ∂(R e₃)/∂θ = −[axis]ₓ, so the strain e − R e₃ has the derivative [axis]ₓ, whose square is
    // −(1 − axis axisᵀ).
    Chain<6>::Block& d = m_chain.diagonal[k];
    d.add_same(0, 0, s / l);
    d.add_crossing(0, 3, s * axis);
    d.add_same(3, 3, l * s);
    d.add_outer(3, 3, -l * s, axis);
    m_chain.add_right(k, 0, -f);
    m_chain.add_right(k, 3, l * cross(axis, f));
    if (k == 0) return;
    Chain<6>::Block& u = m_chain.upper[k - 1];
    m_chain.diagonal[k - 1].add_same(0, 0, s / l);
    u.add_same(0, 0, -s / l);
    u.add_crossing(0, 3, -s * axis);
    m_chain.add_right(k - 1, 0, f);
}

/// With P = R L(r)ᵀ, L the derivative of the logarithm: adds P B Pᵀ/l for the rotations, and P m.
/// With L = 1 − ½[r]ₓ + s[r]ₓ², P Pᵀ is (1 − k r²) + k Rr (Rr)ᵀ with k = 2s − ¼ − s² r².
void RodWire::add_joint(std::size_t i) {
    const std::size_t k = i - std::size_t(m_first);
    const Rotation frame = before(i);
    const double l = m_settings.segment_mm, b = m_settings.bend[i] / l, t = m_settings.twist[i] / l;
    const Vec3d r = turn_of(inverse_of(frame) * m_q[i]);
    const double r2 = dot(r, r), s = pbd::log_curvature(r2), by_r = 2 * s - 0.25 - s * s * r2;
    const Vec3d moment = rotated(frame, pbd::log_transposed(r, s, bend_moment(i, r)));
    const Vec3d third = rotated(frame, pbd::log_transposed(r, s, {0, 0, 1})),
                rr = rotated(frame, r);
    const Mat3d m = sum(scaled(b * (1 - by_r * r2), kIdentity3),
                        sum(outer(b * by_r * rr, rr), outer((t - b) * third, third)));
    m_chain.diagonal[k].add(3, 3, m);
    m_chain.add_right(k, 3, -moment);
    if (k == 0) return;
    m_chain.diagonal[k - 1].add(3, 3, m);
    m_chain.upper[k - 1].add(3, 3, scaled(-1, m));
    m_chain.add_right(k - 1, 3, moment);
}

/// @returns stiffness of the friction
double RodWire::touch(WireContact& c) const {
    c.force = {0, 0, 0};
    if (c.segment < m_first) return 0;
    const auto i = std::size_t(c.segment);
    const Vec3d position = (1 - c.along) * m_x[i] + c.along * m_x[i + 1];
    const Vec3d turned = turn_of(m_q[i] * inverse_of(m_old_q[i]));
    return c.touch(position, position - c.sticks - c.yielded + cross(turned, c.lever));
}

void RodWire::add_contact(WireContact& c) {
    const double drag = touch(c);
    if (c.force == Vec3d{0, 0, 0}) return;
    const std::size_t k = std::size_t(c.segment) - std::size_t(m_first);
    const double a = 1 - c.along, b = c.along;
    const Mat3d m =
        sum(scaled(1 / c.compliance - drag, outer(c.normal, c.normal)), scaled(drag, kIdentity3));
    const Mat3d s = scaled(-1, crossing(c.lever)), ms = m * s;
    Chain<6>::Block& d = m_chain.diagonal[k];
    d.add(0, 0, scaled(b * b, m));
    d.add(0, 3, scaled(b, ms));
    d.add(3, 3, transposed(s) * ms);
    m_chain.add_right(k, 0, b * c.force);
    m_chain.add_right(k, 3, cross(c.lever, c.force));
    if (k == 0) return;
    m_chain.diagonal[k - 1].add(0, 0, scaled(a * a, m));
    m_chain.upper[k - 1].add(0, 0, scaled(a * b, m));
    m_chain.upper[k - 1].add(0, 3, scaled(a, ms));
    m_chain.add_right(k - 1, 0, a * c.force);
}

/// Loads the tip, and holds it by springs.
void RodWire::add_rig(std::size_t last) {
    const std::size_t k = last - std::size_t(m_first);
    m_chain.add_right(k, 0, m_rig->force);
    m_chain.add_right(k, 3, m_rig->moment);
    if (!m_rig->hold) return;
    const Rotation frame = m_rig->hold->frame;
    Vec3d way = m_rig->hold->position_mm - m_x[last + 1];
    m_chain.diagonal[k].add_same(0, 0, kHold);
    if (m_rig->hold->slides) {
        const Vec3d along = rotated(frame, {0, 0, 1});
        way = way - dot(way, along) * along;
        m_chain.diagonal[k].add_outer(0, 0, -kHold, along);
    }
    m_chain.add_right(k, 0, kHold * way);
    m_chain.diagonal[k].add_same(3, 3, kHoldTurn);
    m_chain.add_right(k, 3, kHoldTurn * turn_of(frame * inverse_of(m_q[last])));
}

void RodWire::solve(std::span<WireContact> contacts) {
    const auto first = std::size_t(m_first);
    if (first >= m_count) return;
    const double per_h2 = 1 / (m_h * m_h);
    m_chain.reset(m_count - first);
    for (std::size_t i = first; i < m_count; ++i) {
        const std::size_t k = i - first;
        const double m = per_h2 * m_mass[i + 1], j = per_h2 * m_inertia;
        m_chain.diagonal[k].add_same(0, 0, m);
        m_chain.diagonal[k].add_same(3, 3, j);
        m_chain.add_right(k, 0, m * (m_predicted_x[i + 1] - m_x[i + 1]));
        m_chain.add_right(k, 3, j * turn_of(m_predicted_q[i] * inverse_of(m_q[i])));
        add_segment(i);
        add_joint(i);
    }
    for (WireContact& c : contacts) add_contact(c);
    if (m_rig) add_rig(m_count - 1);
    m_chain.solve();
    for (std::size_t i = first; i < m_count; ++i) {
        m_x[i + 1] = m_x[i + 1] + m_chain.solution(i - first, 0);
        const Vec3d by = m_chain.solution(i - first, 3);
        const double size = norm(by);
        m_q[i] = unit(turn_by(size > kMaxTurn ? (kMaxTurn / size) * by : by) * m_q[i]);
    }
    // Forces at the final positions, which the wall receives.
    for (WireContact& c : contacts) touch(c);
}

void RodWire::finish() {
    const double per_h = 1 / m_h;
    for (std::size_t n = 0; n <= m_count; ++n) m_v[n] = per_h * (m_x[n] - m_old_x[n]);
    for (std::size_t i = 0; i < m_count; ++i)
        m_spin[i] = per_h * turn_of(m_q[i] * inverse_of(m_old_q[i]));
}

Vec3d RodWire::base_force() const {
    return m_first < segments() ? stretch_force(std::size_t(m_first)) : Vec3d{0, 0, 0};
}
Vec3d RodWire::base_moment() const {
    if (m_first >= segments()) return {0, 0, 0};
    const auto i = std::size_t(m_first);
    const Vec3d r = turn(m_first);
    return rotated(before(i), transposed(log_derivative(r)) * bend_moment(i, r));
}

double RodWire::elastic_energy() const {
    double energy = 0;
    const double l = m_settings.segment_mm;
    for (auto i = std::size_t(m_first); i < m_count; ++i) {
        const Vec3d f = stretch_force(i), r = turn(std::int32_t(i));
        energy +=
            0.5 * (l / m_settings.stretch * dot(f, f) + dot(r - m_rest[i], bend_moment(i, r)));
    }
    return energy;
}

double RodWire::kinetic_energy() const {
    double energy = 0;
    for (auto i = std::size_t(m_first); i < m_count; ++i)
        energy += 0.5 * (m_mass[i + 1] * dot(m_v[i + 1], m_v[i + 1]) +
                         m_inertia * dot(m_spin[i], m_spin[i]));
    return energy;
}

bool RodWire::is_good() const {
    return std::all_of(m_x.begin(), m_x.end(), is_finite) &&
           std::all_of(m_v.begin(), m_v.end(), is_finite) &&
           std::all_of(m_spin.begin(), m_spin.end(), is_finite);
}

void RodWire::exchange(StateNumbers& state) {
    Wire::exchange(state);
    state.positions(m_spin);
    state.positions(m_rest);
    for (Rotation& q : m_q) state.turn(q);
}

}  // namespace pliant::catheter
