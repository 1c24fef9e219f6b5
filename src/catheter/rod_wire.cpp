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
using pbd::matrix_of;
using pbd::outer;
using pbd::sandwich;
using pbd::scaled;
using pbd::sum;
using pbd::unit;

/// Of a turn in one Newton step [rad]; only a wire that is far from rest wants more.
constexpr double kMostTurn = 0.5;

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
    m_chain.diagonal.reserve(m_count);
    m_chain.upper.reserve(m_count);
    m_chain.right.reserve(m_count);
}

void RodWire::bend_tip(double first_rad, double second_rad) {
    const auto tip = std::size_t(m_settings.tip_segments);
    if (tip == 0) return;
    // Towards the first axis is a turn about the second one.
    const double share = 1 / double(tip);
    for (std::size_t i = m_count - tip; i < m_count; ++i)
        m_rest[i] = {-share * second_rad, share * first_rad, 0};
}

/// In the guide: along its axis, turned as it says. What came in beside it is led there smoothly.
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
        m_q[i] = unit(rotation_by((h * keep) * m_spin[i]) * m_q[i]);
    m_predicted_x = m_x;
    m_predicted_q = m_q;
}

Vec3d RodWire::turn(std::int32_t segment) const {
    const auto i = std::size_t(segment);
    const Rotation before = i > 0 ? m_q[i - 1] : m_settings.frame * rotation_by({0, 0, m_turned});
    return rotation_vector(inverse_of(before) * m_q[i]);
}

/// R D Γ: what the segment pulls its nodes together with.
Vec3d RodWire::stretch_force(std::size_t i) const {
    const Vec3d e = (1 / m_settings.segment_mm) * (m_x[i + 1] - m_x[i]);
    return m_settings.stretch * (e - rotated(m_q[i], {0, 0, 1}));
}
/// B (r − r₀)/l, in the frame of the segment before.
Vec3d RodWire::bend_moment(std::size_t i) const {
    const Vec3d off = turn(std::int32_t(i)) - m_rest[i];
    const double l = m_settings.segment_mm;
    return {m_settings.bend[i] / l * off.x, m_settings.bend[i] / l * off.y,
            m_settings.twist[i] / l * off.z};
}

/// ½ l |e − R e₃|² EA, e = (x₊ − x₋)/l: with GA = EA the energy doesn't care about directions.
void RodWire::add_segment(std::size_t i) {
    const std::size_t k = i - std::size_t(m_first);
    const double l = m_settings.segment_mm, s = m_settings.stretch;
    const Vec3d axis = rotated(m_q[i], {0, 0, 1});
    const Vec3d f = stretch_force(i);
    // ∂(R e₃)/∂θ = −[axis]ₓ, so the strain e − R e₃ has the derivative [axis]ₓ.
    const Mat3d a = crossing(axis), along = scaled(s / l, kIdentity3), mixed = scaled(s, a);
    Chain<6>::Block& d = m_chain.diagonal[k];
    d.add(0, 0, along);
    d.add(3, 0, transposed(mixed));
    d.add(3, 3, scaled(l * s, transposed(a) * a));
    m_chain.right[k].add(0, -f);
    m_chain.right[k].add(3, -l * (transposed(a) * f));
    if (k == 0) return;
    m_chain.diagonal[k - 1].add(0, 0, along);
    m_chain.upper[k - 1].add(0, 0, scaled(-1, along));
    m_chain.upper[k - 1].add(0, 3, scaled(-1, mixed));
    m_chain.right[k - 1].add(0, f);
}

void RodWire::add_joint(std::size_t i) {
    const std::size_t k = i - std::size_t(m_first);
    const Rotation before = i > 0 ? m_q[i - 1] : m_settings.frame * rotation_by({0, 0, m_turned});
    const double l = m_settings.segment_mm, b = m_settings.bend[i] / l, t = m_settings.twist[i] / l;
    const Mat3d p =
        transposed(log_derivative(turn(std::int32_t(i))) * transposed(matrix_of(before)));
    const Mat3d stiff = sandwich(p, {b, b, t});
    const Vec3d moment = p * bend_moment(i);
    m_chain.diagonal[k].add(3, 3, stiff);
    m_chain.right[k].add(3, -moment);
    if (k == 0) return;
    m_chain.diagonal[k - 1].add(3, 3, stiff);
    m_chain.upper[k - 1].add(3, 3, scaled(-1, stiff));
    m_chain.right[k - 1].add(3, moment);
}

/// Along the normal a spring that only pushes; along the wall what Coulomb's friction allows: a way
/// slid of `sticking_mm` or more has all of it. @returns the stiffness of friction
double RodWire::touch(WireContact& c) const {
    c.force = {0, 0, 0};
    if (c.segment < m_first) return 0;
    const auto i = std::size_t(c.segment);
    const Vec3d place = (1 - c.along) * m_x[i] + c.along * m_x[i + 1];
    const double depth = c.least + dot(c.normal, c.yielded) - dot(c.normal, place);
    const double push = c.pushed + depth / c.compliance;
    if (!(push > 0)) return 0;
    const Vec3d turned = rotation_vector(m_q[i] * inverse_of(m_old_q[i]));
    Vec3d slid = place - c.sticks - c.yielded + cross(turned, c.lever);
    slid = slid - dot(slid, c.normal) * c.normal;
    const double drag =
        std::min(1 / c.compliance, c.friction * push / std::max(norm(slid), c.sticking_mm));
    c.force = push * c.normal - drag * slid;
    return drag;
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
    d.add(3, 0, scaled(b, transposed(ms)));
    d.add(3, 3, transposed(s) * ms);
    m_chain.right[k].add(0, b * c.force);
    m_chain.right[k].add(3, cross(c.lever, c.force));
    if (k == 0) return;
    m_chain.diagonal[k - 1].add(0, 0, scaled(a * a, m));
    m_chain.upper[k - 1].add(0, 0, scaled(a * b, m));
    m_chain.upper[k - 1].add(0, 3, scaled(a, ms));
    m_chain.right[k - 1].add(0, a * c.force);
}

void RodWire::solve(std::span<WireContact> contacts) {
    const auto first = std::size_t(m_first);
    if (first >= m_count) return;
    const double per_h2 = 1 / (m_h * m_h);
    m_chain.reset(m_count - first);
    for (std::size_t i = first; i < m_count; ++i) {
        const std::size_t k = i - first;
        const double m = per_h2 * m_mass[i + 1], j = per_h2 * m_inertia;
        for (std::size_t c = 0; c < 3; ++c) {
            m_chain.diagonal[k].at[c][c] += m;
            m_chain.diagonal[k].at[c + 3][c + 3] += j;
        }
        m_chain.right[k].add(0, m * (m_predicted_x[i + 1] - m_x[i + 1]));
        m_chain.right[k].add(3, j * rotation_vector(m_predicted_q[i] * inverse_of(m_q[i])));
        add_segment(i);
        add_joint(i);
    }
    for (WireContact& c : contacts) add_contact(c);
    m_chain.solve();
    for (std::size_t i = first; i < m_count; ++i) {
        const Chain<6>::Vector& by = m_chain.right[i - first];
        m_x[i + 1] = m_x[i + 1] + by.part(0);
        Vec3d turn_by = by.part(3);
        const double size = norm(turn_by);
        if (size > kMostTurn) turn_by = (kMostTurn / size) * turn_by;
        m_q[i] = unit(rotation_by(turn_by) * m_q[i]);
    }
    // Of the places as they have become, which is what the wall gets.
    for (WireContact& c : contacts) touch(c);
}

void RodWire::finish() {
    const double per_h = 1 / m_h;
    for (std::size_t n = 0; n <= m_count; ++n) m_v[n] = per_h * (m_x[n] - m_old_x[n]);
    for (std::size_t i = 0; i < m_count; ++i)
        m_spin[i] = per_h * rotation_vector(m_q[i] * inverse_of(m_old_q[i]));
}

Vec3d RodWire::base_force() const {
    return m_first < segments() ? stretch_force(std::size_t(m_first)) : Vec3d{0, 0, 0};
}
Vec3d RodWire::base_moment() const {
    if (m_first >= segments()) return {0, 0, 0};
    const auto i = std::size_t(m_first);
    const Rotation before = i > 0 ? m_q[i - 1] : m_settings.frame * rotation_by({0, 0, m_turned});
    return rotated(before, transposed(log_derivative(turn(m_first))) * bend_moment(i));
}

double RodWire::elastic_energy() const {
    double energy = 0;
    const double l = m_settings.segment_mm;
    for (auto i = std::size_t(m_first); i < m_count; ++i) {
        const Vec3d f = stretch_force(i);
        const Vec3d off = turn(std::int32_t(i)) - m_rest[i];
        energy += 0.5 * (l / m_settings.stretch * dot(f, f) + dot(off, bend_moment(i)));
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
    state.places(m_spin);
    state.places(m_rest);
    for (Rotation& q : m_q) state.turn(q);
}

}  // namespace pliant::catheter
