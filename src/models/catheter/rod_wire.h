// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Wire with the energy of the rod in docs/method/pbd.md, and with contact in the same Newton step.
//
// One step of implicit Euler minimises
//
//   ½ (x − x̃)ᵀ M/h² (x − x̃) + stretch, shear, bend and twist + contact
//
// by Gauss–Newton in positions and rotations: a chain of 6 × 6 blocks, one per segment and its end
// node. A contact on a segment couples only the two nodes of that segment, so it fits into the
// chain. For this reason the unknowns are not the multipliers, as in pbd/rod.cpp. Without contact,
// both make the same step.

#pragma once

#include <pliant/models/catheter.h>

#include <optional>

#include "catheter/chain.h"
#include "catheter/wire.h"

namespace pliant::catheter {

/// Loads and hold of the tip, beside contact.
struct WireRig {
    Vec3d force{0, 0, 0};   ///< [µN]
    Vec3d moment{0, 0, 0};  ///< [µN mm]
    std::optional<TipHold> hold{};
};

class RodWire : public Wire {
  public:
    /// Straight, with all but `inserted_mm` in the guide.
    RodWire(const WireSettings& settings, double inserted_mm);

    /// Sets what acts on the tip from the next step on.
    void rig_tip(const std::optional<WireRig>& rig) { m_rig = rig; }
    /// Sets the rest shape of the tip: total bends towards the first and the second axis.
    void bend_tip(double first_rad, double second_rad);
    void predict(double h);
    void solve(std::span<WireContact> contacts);
    void finish();

    /// Frame of the tip: the third axis points ahead, the tip bends about the first two.
    Rotation tip_frame() const { return m_q.back(); }
    Vec3d turn(std::int32_t segment) const;
    /// Force [µN] and moment [µN mm] of the wire on the guide.
    Vec3d base_force() const;
    Vec3d base_moment() const;
    double elastic_energy() const;  ///< [nJ = µN mm]
    double kinetic_energy() const;
    bool is_good() const;
    /// Writes or reads the state between two steps.
    void exchange(StateNumbers& state);

  private:
    void hold();
    void add_segment(std::size_t i);
    void add_joint(std::size_t i);
    double touch(WireContact& c) const;
    void add_contact(WireContact& c);
    void add_rig(std::size_t last);
    Vec3d stretch_force(std::size_t i) const;
    Rotation before(std::size_t i) const;
    Vec3d bend_moment(std::size_t i, Vec3d turned) const;

    std::optional<WireRig> m_rig;
    double m_inertia = 0;
    std::vector<Vec3d> m_predicted_x, m_spin, m_rest;
    std::vector<double> m_mass;
    std::vector<Rotation> m_q, m_old_q, m_predicted_q;
    ScratchChain<6> m_chain;
};

}  // namespace pliant::catheter
