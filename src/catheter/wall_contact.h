// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Where a wire touches the ghost surface of a wall, and what the wall gets of it.
//
// Once a step: which triangles are so near to a segment that they may be touched during the step.
// In each sub-step, after both have moved freely: the nearest points of those pairs; of those of
// one node, and of the inside of one segment, a few that point differently. They go into the wire's
// Newton step, in which a wall's point that is pushed gives way like the free particles that it
// rides on: with a compliance of
//
//   h² Σ_p b_p w_p S_p,   S_p = Σ b_p of all contacts that bear on particle p
//
// which is exact where neighbouring contacts push alike and too soft elsewhere. So the next Newton
// step begins with the forces that have been found and with the wall as these would move it, and
// adds what is missing. In the end the particles move by −h² w b F and their velocities with them,
// so that momentum is kept.

#pragma once

#include <pliant/pbd.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "catheter/wire.h"
#include "pbd/ghost_surface.h"

namespace pliant::catheter {

struct WallContactSettings {
    double radius_mm = 0.9;
    double skin_mm = 0.05;       ///< the wire is held that far from the wall
    double friction = 0.1;       ///< Coulomb's
    double compliance = 1e-7;    ///< of the surfaces themselves [mm/µN]
    double sticking_mm_s = 0.5;  ///< slower than this, friction is less than Coulomb's
};

class WallContact {
  public:
    /// @pre GhostSurface::check accepts them
    WallContact(const TetMesh& mesh, const TriangleMesh& ghost,
                std::span<const Embedded> ghost_places, const WallContactSettings& settings);

    /// Which of the ghost's nodes may move from now on: those with a particle that isn't held.
    void wake(const PbdBody& body);
    /// Where all of the ghost's nodes are: after the body was put elsewhere.
    void see_all(const PbdBody& body, const TaskArena& arena) { m_ghost.update(body, arena); }
    /// Once a step, which lasts this long.
    void look(const Wire& wire, const PbdBody& body, double duration_s);
    /// In each sub-step of h seconds, after wire and body have been moved.
    std::span<WireContact> gather(const Wire& wire, const PbdBody& body, double h);
    /// Between two Newton steps: where the wall would go with the forces of the last one.
    void yield(const PbdBody& body, double h);
    /// After the wire has been solved.
    Status apply(PbdBody& body, double h);

    /// How far the surface of the wire that is outside of the guide is beyond the ghost surface at
    /// most, as both are now; below 0: the distance in between, where it is less than what `look`
    /// looked at.
    double depth(const Wire& wire, const PbdBody& body);
    std::span<const WireContact> contacts() const { return m_contacts; }
    double push_force() const;  ///< all that the wall is pushed with [µN]
    const pbd::GhostSurface& ghost() const { return m_ghost; }

  private:
    struct Pair {
        std::int32_t segment, triangle;
        double distance;  ///< when `look` saw them
        bool is_deep;     ///< the segment isn't in the lumen: its pairs are all looked at
    };
    struct Bearing {  ///< of a contact on a particle
        std::int32_t particle;
        double weight;
    };
    struct Found {
        WireContact contact;
        double gap;
        Vec3d place;
        std::int32_t triangle;
    };
    std::array<Vec3d, 3> corners(const Pair& pair) const;
    bool is_far(Vec3d a, Vec3d b, const std::array<std::int32_t, 3>& triangle, double reach) const;
    void rank(Vec3d a, Vec3d b, std::span<Pair> of_segment) const;
    static Vec3d begin_of(const Wire& wire, std::int32_t segment);
    double moved(const Wire& wire, std::int32_t segment) const;
    bool is_nearest(Vec3d on_wire, double distance, std::span<const Pair> of_segment) const;
    void consider(const Wire& wire, const Pair& pair, std::span<const Pair> of_segment,
                  double along, Vec3d on_wire, Vec3d on_wall, int feature);
    void keep_some(std::size_t from);
    void bear(const PbdBody& body, double h);
    void sum_up();

    WallContactSettings m_settings;
    pbd::GhostSurface m_ghost;
    std::vector<std::int32_t> m_awake, m_near_nodes, m_found_triangles;
    std::vector<std::uint32_t> m_seen;  ///< [node]: when it was last put on a list
    std::uint32_t m_turn = 0;
    std::vector<Pair> m_pairs;  ///< by segment, then nearest first
    std::vector<Vec3d> m_ranked_places;
    double m_wall_moved = 0;  ///< of any node near the wire, at most, since m_pairs
    std::vector<Found> m_found;
    std::vector<WireContact> m_contacts;
    std::vector<std::int32_t> m_bearing_starts;
    std::vector<Bearing> m_bearings;
    std::vector<double> m_share;        ///< [particle]: S_p
    std::vector<Vec3d> m_push;          ///< [particle]: Σ b F
    std::vector<std::int32_t> m_borne;  ///< particles of which the two aren't 0
};

}  // namespace pliant::catheter
