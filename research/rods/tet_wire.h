// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter of tetrahedra [VesselPbd2016], fed and rotated at its base. Its tip bends about two
// perpendicular axes. So it has three rotations and a translation along the axis.
//
// The paper moves the tip, and the rest follows the contact forces. Here the whole body is solved.
// One step of implicit Euler minimises
//
//   ½ (x − x̃)ᵀ M/h² (x − x̃) + Σ ½ k (length − rest)² + Σ ½ K (V − V₀)²/V₀ + contact
//
// by Gauss–Newton in the positions of all nodes: a chain of 12 × 12 blocks, one per ring. The
// surface for contact is the round one through the rings' nodes. Normal force acts on the axis,
// friction at the contact point.

#pragma once

#include <pliant/mesh.h>

#include "catheter/chain.h"
#include "catheter/wire.h"
#include "rods/tet_segment.h"

namespace pliant::catheter {

class TetWire : public Wire {
  public:
    /// Straight, with all but `inserted_mm` in the guide. @pre settings within twist_bounds()
    /// @param radius_mm  distance of the nodes from the axis
    TetWire(const WireSettings& settings, double radius_mm, double inserted_mm);

    // Each as of RodWire.
    void bend_tip(double first_rad, double second_rad);
    void predict(double h);
    void solve(std::span<WireContact> contacts);
    void finish();

    Rotation tip_frame() const;
    Vec3d base_force() const;
    Vec3d base_moment() const;
    double elastic_energy() const;
    bool is_good() const;
    TetMesh mesh() const;           ///< in the present shape, including the part in the guide
    std::int64_t inverted() const;  ///< number of inverted tetrahedra

  private:
    static constexpr std::size_t kBlock = 3 * kRing;
    struct Rest {
        std::array<double, kAcross> lengths;
        std::array<double, kTets> volumes;
    };
    struct Weights {
        std::array<double, 2 * kRing> push, friction;
    };
    Rest rest_of(bool odd, Vec3d turned) const;
    const Rest& rest(std::size_t segment) const;
    Vec3d in_guide(std::size_t node, double fed_mm, double turned_rad) const;
    void hold();
    Corners corners(const std::vector<Vec3d>& nodes, std::size_t segment) const;
    Weights weights(const WireContact& c) const;
    double touch(WireContact& c, const Weights& w) const;
    void add_pair(std::size_t a, std::size_t b, const Mat3d& m);
    void add_force(std::size_t node, Vec3d force);
    void add_bar(std::size_t a, std::size_t b, double rest, double stiffness);
    void add_segment(std::size_t i);
    void add_contact(WireContact& c);
    Corners segment_forces(std::size_t i) const;
    void find_axis();

    double m_radius;
    std::vector<SegmentStiffness> m_stiffness;
    std::array<Rest, 2> m_straight, m_bent;  ///< for even and odd segments
    std::array<double, kInRing> m_ring;      ///< rest lengths
    double m_held_mm, m_held_rad;            ///< last position and rotation in the guide
    std::vector<Vec3d> m_nodes, m_old_nodes, m_predicted, m_node_v;
    Chain<kBlock> m_chain;
};

}  // namespace pliant::catheter
