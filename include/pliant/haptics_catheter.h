// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter in the hand: the device is a rail on which the hand holds the base of the wire.
//
//     hand ●──/\/\/──■═══════ guide ═══════╗────────● tip        forward: into the vessel
//          x   k_c   s                     ╚
//
// What the device goes along the rail is inserted, what it turns about it is rotated. Between the
// hand at x and the wire's base at s is a virtual coupling k_c; the base goes to where the coupling
// holds the wire's own force F, which it expects to change with s as it last did, by k_w:
//
//   k_c (x − s*) = F + k_w (s* − s)              the hand feels F + k_w (s* − s), and between two
//                                                solutions k = k_c k_w/(k_c + k_w) ≤ k_c
//
// So a wire that goes freely isn't felt, one that is stuck is as stiff as the coupling, and at rest
// the hand feels F itself, the force at the wire's base. docs/haptics.md, "Catheters".

#pragma once

#include <pliant/catheter.h>
#include <pliant/haptics.h>

#pragma GCC visibility push(default)
namespace pliant {

struct CatheterFeelSettings {
    Vec3d forward{0, 0, -1};    ///< along the rail, in the scene; unit
    double coupling_n_m = 300;  ///< k_c; the servo caps it at what the device can do
    double length_mm = 600;     ///< of the wire: no more can be inserted
    double most_mm_s = 100;     ///< faster hands feel the coupling
    double most_deg_s = 720;
    double follow_s = 1.0 / 30;  ///< of the simulation, in which the base goes to s*
};

class CatheterFeel {
  public:
    /// @returns InvalidArgument that names the setting
    static Result<CatheterFeel> create(const CatheterFeelSettings& settings);

    /// The hand takes hold of the wire: from here on its ways are the wire's.
    void take_hold(Vec3d tool_mm, double roll_rad, const CatheterMeasures& now);
    void let_go() { m_holds = false; }
    bool holds() const { return m_holds; }

    struct Motion {
        double insert_mm_s = 0, rotate_deg_s = 0;
    };
    /// What the hand does to the wire until this is asked again. @pre holds()
    /// @param now  what the simulation has come to
    Motion follow(Vec3d tool_mm, double roll_rad, const CatheterMeasures& now);
    /// What the hand feels; of one that holds nothing: no force.
    HapticModel model(Vec3d tool_mm, const CatheterMeasures& now) const;

    /// How far the hand is ahead of the wire's base.
    double ahead_mm(Vec3d tool_mm, const CatheterMeasures& now) const;
    /// k_w.
    double wire_n_m() const { return 1000 * m_wire_n_mm; }

  private:
    /// What becomes of a hand ahead of the wire's base.
    struct Pull {
        double way_mm = 0;  ///< that the base is to go
        double felt_n = 0, stiffness_n_mm = 0;
    };
    explicit CatheterFeel(const CatheterFeelSettings& settings) : m_settings(settings) {}
    Pull pull(Vec3d tool_mm, const CatheterMeasures& now) const;
    void learn(const CatheterMeasures& now);

    CatheterFeelSettings m_settings;
    bool m_holds = false, m_moves = false;    ///< the wire; its base is on its way
    Vec3d m_first_mm{0, 0, 0};                ///< where the hand took hold
    double m_start_mm = 0, m_start_deg = 0;   ///< of the wire, then
    double m_roll_deg = 0, m_turned_deg = 0;  ///< of the hand: as read last; since then
    double m_time_s = 0, m_span_s = 0;        ///< of the last follow(), and until the next
    double m_wire_n_mm = 0;                   ///< k_w
    double m_known_mm = 0, m_known_n = 0;     ///< F at some s before
};

}  // namespace pliant
#pragma GCC visibility pop
