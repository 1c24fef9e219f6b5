// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A wire or catheter that is fed through a guide: the energy of docs/pbd.md's rod, with contact in
// the same Newton step.
//
//     guide                  in the vessel
//   ═══●════●════●═╗
//      n    n+1  first ●────●────●────●   nodes up to `first` are in the guide and go where it says
//   ═══════════════╝
//
// One step of implicit Euler minimises
//
//   ½ (x − x̃)ᵀ M/h² (x − x̃) + stretch, shear, bend and twist + contact
//
// by Gauss–Newton in places and turns: a chain of 6 × 6 blocks, one for each segment and the node
// at its end. A contact somewhere on a segment couples the two nodes of that segment and no others,
// so it fits into the chain; that is why the unknowns are not the multipliers, as they are in
// pbd/rod.cpp. Without contact, both make the same step.

#pragma once

#include <pliant/pbd_rod.h>

#include <cstdint>
#include <span>
#include <vector>

#include "catheter/six_chain.h"

namespace pliant::catheter {

struct WireSettings {
    std::int32_t segments = 100;
    double segment_mm = 3;
    double mass_g_mm = 2e-3;
    std::vector<double> bend;   ///< [segment]: EI of the joint before it [µN mm²]
    std::vector<double> twist;  ///< GJ, likewise
    double stretch = 1e9;       ///< EA [µN], and GA
    double damping = 0;         ///< of velocities [1/s]
    std::int32_t tip_segments = 0;
    Vec3d entry{0, 0, 0};  ///< the end of the guide; it leads straight there along the third axis
    Rotation frame{};
};

/// Somewhere on a segment the wire must stay on one side of a plane, and slides along it.
struct WireContact {
    std::int32_t segment = 0;
    double along = 0;        ///< 0…1
    Vec3d normal{0, 0, 0};   ///< to the side where the wire may be
    Vec3d lever{0, 0, 0};    ///< from the axis to where it touches
    double least = 0;        ///< normal · (place on the axis) is at least this
    double compliance = 0;   ///< [mm/µN]
    double friction = 0;     ///< Coulomb's
    Vec3d sticks{0, 0, 0};   ///< where the place on the axis would be if nothing slid nor turned
    double sticking_mm = 0;  ///< up to here friction grows with the way slid
    Vec3d force{0, 0, 0};    ///< on the wire [µN], after solve
    // What the last iteration has found: how hard it pushes, and how far the wall has given way.
    double pushed = 0;
    Vec3d yielded{0, 0, 0};
};

class Wire {
  public:
    /// All of it in the guide but `inserted_mm`, straight.
    Wire(const WireSettings& settings, double inserted_mm);

    std::int32_t segments() const { return m_settings.segments; }
    std::int32_t first() const { return m_first; }  ///< the last node in the guide
    /// Where the guide ends on segment `first`, 0…1 along it.
    double guide_end() const;
    double length() const { return m_settings.segment_mm * m_settings.segments; }

    /// Where the guide holds it at the end of the next step.
    void feed(double inserted_mm, double turned_rad);
    /// The rest shape of the tip: bent towards the first and the second axis, all in all.
    void bend_tip(double first_rad, double second_rad);

    /// A step of h seconds: predict, then Newton steps with what the predicted places touch, then
    /// finish.
    void predict(double h);
    void solve(std::span<WireContact> contacts);
    void finish();

    const std::vector<Vec3d>& places() const { return m_x; }
    const std::vector<Vec3d>& places_before() const { return m_old_x; }
    const std::vector<Vec3d>& velocities() const { return m_v; }
    const std::vector<Rotation>& orientations() const { return m_q; }
    Vec3d turn(std::int32_t segment) const;
    /// Of the wire on the guide [µN], [µN mm].
    Vec3d base_force() const;
    Vec3d base_moment() const;
    double elastic_energy() const;  ///< [nJ = µN mm]
    double kinetic_energy() const;
    bool is_good() const;

  private:
    void hold();
    void add_segment(std::size_t i);
    void add_joint(std::size_t i);
    double touch(WireContact& c) const;
    void add_contact(WireContact& c);
    Vec3d stretch_force(std::size_t i) const;
    Vec3d bend_moment(std::size_t i) const;

    WireSettings m_settings;
    std::size_t m_count;
    std::int32_t m_first = 0;
    double m_h = 1e-3, m_inserted = 0, m_turned = 0, m_inertia = 0;
    std::vector<Vec3d> m_x, m_old_x, m_predicted_x, m_v, m_spin, m_rest;
    std::vector<double> m_mass;
    std::vector<Rotation> m_q, m_old_q, m_predicted_q;
    SixChain m_chain;
};

}  // namespace pliant::catheter
