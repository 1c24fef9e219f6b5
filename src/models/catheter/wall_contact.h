// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact between a wire and the ghost surface of a wall, and its effect on the wall.
//
// The broad phase runs every few steps: it lists the triangles that a segment may touch until its
// next run. The narrow phase runs in each sub-step after the free motion of both (near_wall.h). Its
// contacts enter the wire's Newton step, in which a pushed point of the wall gives way like the
// free particles that carry it, with the compliance
//
//   h² Σ_p b_p w_p S_p,   S_p = Σ b_p of all contacts that bear on particle p
//
// This is exact if neighbouring contacts push alike, and too soft otherwise. So the next Newton
// step starts from the found forces and the wall's response to them, and adds the difference.
// Finally the particles move by −h² w b F, and their velocities change accordingly, so that
// momentum is conserved.

#pragma once

#include <pliant/models/pbd.h>

#include <cstdint>
#include <span>
#include <vector>

#include "catheter/near_wall.h"
#include "catheter/wire.h"
#include "pbd/ghost_surface.h"

namespace pliant::catheter {

class WallContact {
  public:
    /// @pre GhostSurface::check accepts them
    WallContact(const TetMesh& mesh, const TriangleMesh& ghost,
                std::span<const Embedded> ghost_positions, const WallContactSettings& settings);

    /// Call it before a step that may be undone.
    void keep() {
        m_kept_age = m_age;
        m_is_new = false;
    }
    /// Call it after a failed step, with wire and body restored.
    /// @returns false if contact must be found again
    bool take_back() {
        m_age = m_kept_age;
        return !m_is_new;
    }

    /// Updates the movable nodes of the ghost: those with a particle that isn't held.
    void wake(const PbdBody& body, const TaskArena& arena);
    /// Updates all positions of the ghost, after the body was repositioned.
    void see_all(const PbdBody& body, const TaskArena& arena) { m_ghost.update(body, arena); }
    /// Runs the broad phase if needed, once per step of this duration. Its result is reused while
    /// motion is small.
    void look(const Wire& wire, const PbdBody& body, double duration_s, const TaskArena& arena);
    /// Finds the contacts of a sub-step of h seconds, after wire and body have moved.
    std::span<WireContact> gather(const Wire& wire, const PbdBody& body, double h,
                                  const TaskArena& arena);
    /// Updates the wall's response to the last forces, between two Newton steps.
    void yield(double h);
    /// Applies the forces to the body, after the wire has been solved.
    Status apply(PbdBody& body, double h);

    /// Largest present penetration of the ghost surface by the wire outside of the guide; negative:
    /// the distance, if it is within the range of `look`. @param skipped  [segment]: excluded
    double depth(const Wire& wire, const PbdBody& body, std::span<const std::uint8_t> skipped,
                 const TaskArena& arena);
    std::span<const WireContact> contacts() const { return m_contacts; }
    double push_force() const;    ///< total contact force on the wall [µN]
    double largest_push() const;  ///< the largest of one contact [µN]
    /// Largest displacement of a particle by the last sub-step's contacts [mm].
    double pushed_mm() const { return m_pushed_mm; }
    const pbd::GhostSurface& ghost() const { return m_ghost; }

  private:
    struct Bearing {  ///< bearing of a contact on a particle
        std::int32_t particle;
        double weight, inverse_mass;
    };
    bool may_keep(const Wire& wire, double duration_s);
    void look_anew(const Wire& wire, const PbdBody& body, double duration_s,
                   const TaskArena& arena);
    double update_near(const PbdBody& body, const TaskArena& arena);
    bool is_outrun(const Wire& wire) const;
    double moved(const Wire& wire, std::int32_t segment) const;
    template <class Work>
    void for_outside(const Wire& wire, const TaskArena& arena, const Work& work);
    void find_near_nodes();
    void rest_on(const NearWall::Found& found, const PbdBody& body, double h);
    void find_compliances(double h);
    void sum_up();
    std::span<const Bearing> bearings(std::size_t contact) const {
        const auto begin = std::size_t(m_bearing_starts[contact]),
                   end = std::size_t(m_bearing_starts[contact + 1]);
        return std::span<const Bearing>(m_bearings).subspan(begin, end - begin);
    }

    WallContactSettings m_settings;
    pbd::GhostSurface m_ghost;
    std::vector<std::int32_t> m_awake, m_near_nodes;
    /// [node]: turn at which it, or its neighbourhood, was last listed
    std::vector<std::uint32_t> m_seen, m_ringed;
    std::uint32_t m_turn = 0;
    std::vector<NearWall> m_near;  ///< [segment − m_first]
    std::int32_t m_first = 0;
    int m_age = 0, m_kept_age = 0;        ///< of the broad phase, in steps
    bool m_is_new = false;                ///< persistent state changed since keep()
    std::vector<double> m_moves;          ///< [segment − m_first]: motion allowed by `look` [mm]
    std::vector<double> m_depths;         ///< [segment − m_first]
    std::vector<Vec3d> m_positions_seen;  ///< positions of the wire in `look`
    double m_pushed_mm = 0;
    double m_wall_moved = 0;  ///< largest displacement of a node near the wire since then
    std::vector<WireContact> m_contacts;
    std::vector<std::int32_t> m_bearing_starts;
    std::vector<Bearing> m_bearings;    ///< of the contacts, concatenated
    std::vector<double> m_share;        ///< [particle]: S_p
    std::vector<Vec3d> m_push;          ///< [particle]: Σ b F
    std::vector<std::int32_t> m_borne;  ///< particles with nonzero values of the two
};

}  // namespace pliant::catheter
