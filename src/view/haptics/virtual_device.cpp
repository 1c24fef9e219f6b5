// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A mass in equal small steps: half kick, drift, half kick (leapfrog), with negligible energy error
// of the integrator; friction is exact. The work of each force is computed from its change of
// speed, so the sum of all work is the kinetic energy.

#include <pliant/view/haptics.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pliant {
namespace {

constexpr double kMetresPerMm = 1e-3;

double energy_of(double mass_kg, Vec3d velocity_mm_s) {
    return 0.5 * mass_kg * kMetresPerMm * kMetresPerMm * dot(velocity_mm_s, velocity_mm_s);
}

}  // namespace

VirtualHand spring_hand(Vec3d target_mm, double stiffness_n_m, double damping_n_s_m) {
    VirtualHand hand;
    hand.stiffness_n_m = stiffness_n_m;
    hand.damping_n_s_m = damping_n_s_m;
    hand.target_mm = target_mm;
    return hand;
}

VirtualHand active_hand(Vec3d amplitude_n, double frequency_hz) {
    VirtualHand hand;
    hand.sine_n = amplitude_n;
    hand.frequency_hz = frequency_hz;
    return hand;
}

VirtualDevice::VirtualDevice(const VirtualDeviceSettings& settings)
    : m_settings(settings),
      m_position_mm(settings.position_mm),
      m_velocity_mm_s(settings.velocity_mm_s) {}

Vec3d VirtualDevice::hand_force_n() const {
    const VirtualHand& hand = m_settings.hand;
    const double phase = 2 * std::numbers::pi * hand.frequency_hz * m_time_s;
    return hand.steady_n + std::sin(phase) * hand.sine_n +
           (kMetresPerMm * hand.stiffness_n_m) * (hand.target_mm - m_position_mm);
}

double VirtualDevice::kinetic_j() const {
    return energy_of(m_settings.mass_kg, m_velocity_mm_s);
}

void VirtualDevice::kick(Vec3d servo_n, double seconds) {
    const Vec3d hand_n = hand_force_n();
    const Vec3d before = m_velocity_mm_s;
    m_velocity_mm_s = before + (seconds / (m_settings.mass_kg * kMetresPerMm)) * (servo_n + hand_n);
    const Vec3d way_m = (0.5 * kMetresPerMm * seconds) * (before + m_velocity_mm_s);
    m_work_of_servo_j += dot(servo_n, way_m);
    m_work_of_hand_j += dot(hand_n, way_m);
}

void VirtualDevice::rub(double seconds) {
    const double own = m_settings.damping_n_s_m, hand = m_settings.hand.damping_n_s_m;
    if (own + hand > 0) {
        const double before = kinetic_j();
        m_velocity_mm_s = std::exp(-(own + hand) * seconds / m_settings.mass_kg) * m_velocity_mm_s;
        const double taken = before - kinetic_j();
        m_lost_j += own / (own + hand) * taken;
        m_work_of_hand_j -= hand / (own + hand) * taken;
    }
    const double speed = norm(m_velocity_mm_s);
    if (m_settings.coulomb_n > 0 && speed > 0) {
        const double before = kinetic_j();
        const double slower = m_settings.coulomb_n * seconds / (m_settings.mass_kg * kMetresPerMm);
        m_velocity_mm_s = std::max(0.0, 1 - slower / speed) * m_velocity_mm_s;
        m_lost_j += before - kinetic_j();
    }
}

void VirtualDevice::advance(Vec3d force_n, double seconds) {
    const double h = seconds / m_settings.sub_steps;
    for (int s = 0; s < m_settings.sub_steps; ++s) {
        kick(force_n, h / 2);
        rub(h / 2);
        m_position_mm = m_position_mm + h * m_velocity_mm_s;
        m_time_s += h;
        rub(h / 2);
        kick(force_n, h / 2);
    }
    m_lowest_passivity_j = std::min(m_lowest_passivity_j, passivity_j());
}

Vec3d VirtualDevice::seen_position_mm() const {
    const double step = m_settings.encoder_mm;
    if (!(step > 0)) return m_position_mm;
    Vec3d seen{};
    for (int a = 0; a < 3; ++a) seen[a] = step * std::round(m_position_mm[a] / step);
    return seen;
}

}  // namespace pliant
