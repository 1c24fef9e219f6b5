// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A simulated force-feedback device and a simulated hand, for tests of stability without hardware.
//
//   VirtualDevice device({.damping_n_s_m = 0.5, .hand = active_hand({0, 0, 2}, 10)});
//   run_haptics(device, {.settings = {.max_stiffness_n_m = 800}, .update_periods = 33},
//               60'000, [](Vec3d tool_mm) { return model_of_contact(…); });
//   device.passivity_j();                            // never below 0: the hand gains no energy
//
// The device is one mass with viscous and Coulomb friction, isotropic. The servo sees its position
// quantised by the encoder, and holds its force for a period [Colgate1997, Abbott2005].

#pragma once

#include <pliant/haptics.h>

#include <functional>

#pragma GCC visibility push(default)
namespace pliant {

/// A hand that applies steady and sine forces, and is coupled to a target by a spring and a damper.
struct VirtualHand {
    double stiffness_n_m = 0, damping_n_s_m = 0;
    Vec3d target_mm{0, 0, 0};
    Vec3d steady_n{0, 0, 0};
    Vec3d sine_n{0, 0, 0};
    double frequency_hz = 0;
};
/// A relaxed grip that follows the target.
VirtualHand spring_hand(Vec3d target_mm, double stiffness_n_m = 300, double damping_n_s_m = 5);
/// A hand that applies a sinusoidal force.
VirtualHand active_hand(Vec3d amplitude_n, double frequency_hz);

struct VirtualDeviceSettings {
    double mass_kg = 0.1;
    double damping_n_s_m = 0.5;
    double coulomb_n = 0;   ///< friction independent of the speed
    double encoder_mm = 0;  ///< resolution of the position; 0: exact
    int sub_steps = 20;     ///< per period
    Vec3d position_mm{0, 0, 0};
    Vec3d velocity_mm_s{0, 0, 0};
    VirtualHand hand{};
};

class VirtualDevice {
  public:
    explicit VirtualDevice(const VirtualDeviceSettings& settings);

    /// Advances time under a constant force of the servo.
    void advance(Vec3d force_n, double seconds);
    /// Position quantised by the encoder.
    Vec3d seen_position_mm() const;

    Vec3d position_mm() const { return m_position_mm; }
    Vec3d velocity_mm_s() const { return m_velocity_mm_s; }
    double time_s() const { return m_time_s; }
    VirtualHand& hand() { return m_settings.hand; }
    const VirtualDeviceSettings& settings() const { return m_settings; }

    // Sums since the start [J].
    double kinetic_j() const;
    double work_of_servo_j() const { return m_work_of_servo_j; }
    double work_of_hand_j() const { return m_work_of_hand_j; }
    double lost_j() const { return m_lost_j; }  ///< dissipated by the device's friction
    /// Energy that the device and the displayed tissue have taken from the hand, without the
    /// device's kinetic energy: −(work of the servo) + losses. Negative: energy was generated.
    double passivity_j() const { return m_lost_j - m_work_of_servo_j; }
    double lowest_passivity_j() const { return m_lowest_passivity_j; }

  private:
    void kick(Vec3d servo_n, double seconds);
    void rub(double seconds);
    Vec3d hand_force_n() const;

    VirtualDeviceSettings m_settings;
    Vec3d m_position_mm, m_velocity_mm_s;
    double m_time_s = 0;
    double m_work_of_servo_j = 0, m_work_of_hand_j = 0, m_lost_j = 0, m_lowest_passivity_j = 0;
};

struct HapticRun {
    HapticSettings settings{};
    double rate_hz = 1000;
    int update_periods = 33;  ///< periods between two solutions of the tissue
    int delay_periods = 0;    ///< latency of a solution
};

/// Returns the tissue's model for a tool position in the scene [mm]; the caller fills in the
/// number.
using HapticTissue = std::function<HapticModel(Vec3d tool_mm)>;
/// Called after each period; false ends the run.
using HapticWatch = std::function<bool(const HapticReading& reading, const HapticModel* fresh,
                                       const HapticState& state, const HapticForce& force)>;

/// Runs servo, device and tissue in simulated time, period by period, on this thread.
/// @returns the last state of the servo
HapticState run_haptics(VirtualDevice& device, const HapticRun& run, std::int64_t periods,
                        const HapticTissue& tissue, const HapticWatch& watch = {});

}  // namespace pliant
#pragma GCC visibility pop
