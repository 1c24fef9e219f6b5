// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Nodes of a wire that is fed through a guide into a vessel: a chain of segments along its axis,
// which is all that contact needs (rod_wire.h moves them).
//
//     guide                  in the vessel
//   ═══●════●════●═╗
//      n    n+1  first ●────●────●────●   nodes up to `first` are in the guide and follow it
//   ═══════════════╝
//
// A step of h seconds: predict, find contacts at the predicted positions, Newton steps, finish.

#pragma once

#include <pliant/models/pbd.h>

#include <cstdint>
#include <span>
#include <vector>

#include "base/hash.h"
#include "catheter/state_numbers.h"

namespace pliant::catheter {

struct WireSettings {
    std::int32_t segments = 100;
    double segment_mm = 3;
    double mass_g_mm = 2e-3;
    std::vector<double> bend;   ///< [segment]: EI of the joint in front of it [µN mm²]
    std::vector<double> twist;  ///< [segment]: GJ [µN mm²]
    double stretch = 1e9;       ///< EA and GA [µN]
    double damping = 0;         ///< of velocities [1/s]
    std::int32_t tip_segments = 0;
    Vec3d entry{0, 0, 0};  ///< end of the guide, which leads there along the third axis
    Rotation frame{};
};

/// Contact at a point of a segment: the wire stays on one side of a plane and slides along it. A
/// unilateral spring, with Coulomb friction.
struct WireContact {
    std::int32_t segment = 0;
    double along = 0;       ///< 0…1
    Vec3d normal{0, 0, 0};  ///< towards the free side
    Vec3d lever{0, 0, 0};   ///< from the axis to the contact point
    double least = 0;       ///< lower bound of normal · (position on the axis)
    double compliance = 0;  ///< of the surfaces and of the wall [mm/µN]
    double wall_compliance = 0;
    double friction = 0;     ///< Coulomb friction coefficient
    Vec3d sticks{0, 0, 0};   ///< position on the axis without sliding and rotation
    double sticking_mm = 0;  ///< friction grows with the sliding distance up to here
    Vec3d force{0, 0, 0};    ///< on the wire [µN], after solve
    // State of the last iteration: normal force, friction, and displacement of the wall by both.
    double pushed = 0;
    Vec3d dragged{0, 0, 0};
    Vec3d yielded{0, 0, 0};

    /// Computes the force. Friction is complete from a sliding distance of `sticking_mm` on.
    /// @param position  position on the axis
    /// @param slid  sliding distance of the contact point, as a vector
    /// @returns stiffness of the friction; 0 with a force of 0 for an open contact
    double touch(Vec3d position, Vec3d slid);
};

class Wire {
  public:
    std::int32_t segments() const { return m_settings.segments; }
    std::int32_t first() const { return m_first; }  ///< index of the last node in the guide
    /// Position of the guide's end on segment `first`, 0…1.
    double guide_end() const;
    double length() const { return m_settings.segment_mm * m_settings.segments; }

    /// Sets the guide's position and rotation at the end of the next step.
    void feed(double inserted_mm, double turned_rad);

    /// Positions of the nodes along the axis.
    const std::vector<Vec3d>& positions() const { return m_x; }
    const std::vector<Vec3d>& positions_before() const { return m_old_x; }
    const std::vector<Vec3d>& velocities() const { return m_v; }
    /// Adds positions and velocities.
    void add_to(Hash64& hash) const;

  protected:
    Wire(const WireSettings& settings, double inserted_mm);
    /// Writes or reads the state between two steps.
    void exchange(StateNumbers& state);
    /// Coordinate of a node in the guide along its axis.
    double fed_mm(std::size_t node) const {
        return m_inserted - m_settings.segment_mm * double(m_count - node);
    }

    WireSettings m_settings;
    std::size_t m_count;
    std::int32_t m_first = 0;
    double m_h = 1e-3, m_inserted = 0, m_turned = 0;
    std::vector<Vec3d> m_x, m_old_x, m_v;
};

/// Time constant by which nodes drawn into the guide settle on its axis [s].
inline constexpr double kSettle = 0.02;

}  // namespace pliant::catheter
