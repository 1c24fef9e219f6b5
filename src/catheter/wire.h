// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What is fed through a guide into a vessel, whatever it is made of: a chain of segments along its
// axis, which is all that contact with the wall has to know.
//
//     guide                  in the vessel
//   ═══●════●════●═╗
//      n    n+1  first ●────●────●────●   nodes up to `first` are in the guide and go where it says
//   ═══════════════╝
//
// A step of h seconds: predict, then Newton steps with what the predicted places touch, then
// finish.

#pragma once

#include <pliant/mesh.h>
#include <pliant/pbd_rod.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "catheter/state_numbers.h"
#include "core/hash.h"

namespace pliant::catheter {

struct WireSettings {
    std::int32_t segments = 100;
    double segment_mm = 3;
    double mass_g_mm = 2e-3;
    std::vector<double> bend;   ///< [segment]: EI of the joint before it [µN mm²]
    std::vector<double> twist;  ///< GJ, likewise
    double stretch = 1e9;       ///< EA [µN], and GA; of the rod
    double radius_mm = 0.9;     ///< where the nodes of tetrahedra are
    double damping = 0;         ///< of velocities [1/s]
    std::int32_t tip_segments = 0;
    Vec3d entry{0, 0, 0};  ///< the end of the guide; it leads straight there along the third axis
    Rotation frame{};
};

/// Somewhere on a segment the wire must stay on one side of a plane, and slides along it: a spring
/// that only pushes, and along the wall what Coulomb's friction allows.
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

    /// Finds the force. A way slid of `sticking_mm` or more has all of the friction.
    /// @param place  on the axis
    /// @param slid  where the wire touches, from where it would be if nothing slid nor turned
    /// @returns the stiffness of friction; 0 with a force of 0 where nothing pushes
    double touch(Vec3d place, Vec3d slid);
};

class Wire {
  public:
    virtual ~Wire() = default;
    virtual std::unique_ptr<Wire> copy() const = 0;
    /// Becomes like another one of the same kind and settings, without asking for memory.
    virtual void assign(const Wire& other) noexcept = 0;

    std::int32_t segments() const { return m_settings.segments; }
    std::int32_t first() const { return m_first; }  ///< the last node in the guide
    /// Where the guide ends on segment `first`, 0…1 along it.
    double guide_end() const;
    double length() const { return m_settings.segment_mm * m_settings.segments; }

    /// Where the guide holds it at the end of the next step.
    void feed(double inserted_mm, double turned_rad);
    /// The rest shape of the tip: bent towards the first and the second axis, all in all.
    virtual void bend_tip(double first_rad, double second_rad) = 0;

    virtual void predict(double h) = 0;
    virtual void solve(std::span<WireContact> contacts) = 0;
    virtual void finish() = 0;

    /// Of the nodes along the axis.
    const std::vector<Vec3d>& places() const { return m_x; }
    const std::vector<Vec3d>& places_before() const { return m_old_x; }
    const std::vector<Vec3d>& velocities() const { return m_v; }
    /// Its third axis points ahead, the first two are those of bends.
    virtual Rotation tip_frame() const = 0;
    /// Of the wire on the guide [µN], [µN mm].
    virtual Vec3d base_force() const = 0;
    virtual Vec3d base_moment() const = 0;
    virtual double elastic_energy() const = 0;  ///< [nJ = µN mm]
    virtual double kinetic_energy() const = 0;
    virtual bool is_good() const = 0;
    /// Places and velocities.
    virtual void add_to(Hash64& hash) const;
    /// Between two steps.
    virtual void exchange(StateNumbers& state);
    /// What it is made of, as it is now; empty where that is no tetrahedra.
    virtual TetMesh mesh() const { return {}; }

  protected:
    Wire(const WireSettings& settings, double inserted_mm);
    Wire(const Wire&) = default;
    Wire& operator=(const Wire&) = default;
    /// Along the axis, of a node in the guide.
    double fed_mm(std::size_t node) const {
        return m_inserted - m_settings.segment_mm * double(m_count - node);
    }

    WireSettings m_settings;
    std::size_t m_count;
    std::int32_t m_first = 0;
    double m_h = 1e-3, m_inserted = 0, m_turned = 0;
    std::vector<Vec3d> m_x, m_old_x, m_v;
};

/// What is off its place in the guide when it is drawn in comes back to it in about this time [s].
inline constexpr double kSettle = 0.02;

}  // namespace pliant::catheter
