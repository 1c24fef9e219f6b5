// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force feedback of a catheter: the device is a rail on which the hand holds the base of the wire.
//
//     hand ●──/\/\/──■═══════ guide ═══════╗────────● tip        forward: into the vessel
//          x   k_c   s                     ╚
//
// Motion along the rail inserts the wire, rotation about the rail rotates it. A virtual coupling
// k_c joins the hand at x to the wire's base at s. The base moves to s*, where the coupling
// balances the wire's force F. F is extrapolated with the stiffness k_w of its last change:
//
//   k_c (x − s*) = F + k_w (s* − s)
//
// The hand feels F + k_w (s* − s). Between two solutions the stiffness is
//
//   k = k_c k_w/(k_c + k_w) ≤ k_c
//
// So a free wire isn't felt, and a stuck one is as stiff as the coupling. At rest the hand feels F,
// the force at the wire's base. docs/haptics.md, "Catheters".

#pragma once

#include <pliant/catheter.h>
#include <pliant/haptics.h>

#pragma GCC visibility push(default)
namespace pliant {

struct CatheterFeelSettings {
    Vec3d forward{0, 0, -1};    ///< direction of the rail in the scene; unit
    double coupling_n_m = 300;  ///< k_c; the servo caps it at the device's limit
    double length_mm = 600;     ///< length of the wire, the limit of insertion
    double most_mm_s = 100;     ///< at higher speeds the hand feels the coupling
    double most_deg_s = 720;
    double follow_s = 1.0 / 30;  ///< simulation time in which the base goes to s*
};

class CatheterFeel {
  public:
    /// @returns InvalidArgument that names the setting
    static Result<CatheterFeel> create(const CatheterFeelSettings& settings);

    /// Couples the hand to the wire at their current positions.
    void take_hold(Vec3d tool_mm, double roll_rad, const CatheterMeasures& now);
    void let_go() { m_holds = false; }
    bool holds() const { return m_holds; }

    struct Motion {
        double insert_mm_s = 0, rotate_deg_s = 0;
    };
    /// Speeds of the wire's base until the next call. @pre holds()
    /// @param now  current measures of the simulation
    Motion follow(Vec3d tool_mm, double roll_rad, const CatheterMeasures& now);
    /// Local model at the hand; without force if it holds no wire.
    HapticModel model(Vec3d tool_mm, const CatheterMeasures& now) const;

    /// Distance of the hand ahead of the wire's base.
    double ahead_mm(Vec3d tool_mm, const CatheterMeasures& now) const;
    /// Estimated stiffness k_w of the wire.
    double wire_n_m() const { return 1000 * m_wire_n_mm; }

  private:
    /// Response to the distance between the hand and the wire's base.
    struct Pull {
        double way_mm = 0;  ///< motion of the base to s*
        double felt_n = 0, stiffness_n_mm = 0;
    };
    explicit CatheterFeel(const CatheterFeelSettings& settings) : m_settings(settings) {}
    Pull pull(Vec3d tool_mm, const CatheterMeasures& now) const;
    void learn(const CatheterMeasures& now);

    CatheterFeelSettings m_settings;
    bool m_holds = false, m_moves = false;    ///< the hand holds the wire; the base is moving
    Vec3d m_first_mm{0, 0, 0};                ///< position of the hand at the start of the hold
    double m_start_mm = 0, m_start_deg = 0;   ///< of the wire at the start of the hold
    double m_roll_deg = 0, m_turned_deg = 0;  ///< of the hand: last reading; sum since the start
    double m_time_s = 0, m_span_s = 0;        ///< time of the last follow(), and its period
    double m_wire_n_mm = 0;                   ///< k_w
    double m_known_mm = 0, m_known_n = 0;     ///< F at an earlier s
};

}  // namespace pliant
#pragma GCC visibility pop
