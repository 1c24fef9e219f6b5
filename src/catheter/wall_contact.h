// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Where a wire touches the ghost surface of a wall, and what the wall gets of it.
//
// Every few steps: which triangles are so near to a segment that they may be touched until then.
// In each sub-step, after both have moved freely, where they touch (near_wall.h). That goes into
// the wire's Newton step, in which a wall's point that is pushed gives way like the free particles
// that it rides on: with a compliance of
//
//   h² Σ_p b_p w_p S_p,   S_p = Σ b_p of all contacts that bear on particle p
//
// which is exact where neighbouring contacts push alike and too soft elsewhere. So the next Newton
// step begins with the forces that have been found and with the wall as these would move it, and
// adds what is missing. In the end the particles move by −h² w b F and their velocities with them,
// so that momentum is kept.

#pragma once

#include <pliant/pbd.h>

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
                std::span<const Embedded> ghost_places, const WallContactSettings& settings);

    /// Before a step that may have to be taken back.
    void keep() {
        m_kept_age = m_age;
        m_is_new = false;
    }
    /// After a step that failed, with wire and body as they were before it.
    /// @returns false where contact has to be found anew
    bool take_back() {
        m_age = m_kept_age;
        return !m_is_new;
    }

    /// Which of the ghost's nodes may move from now on: those with a particle that isn't held.
    void wake(const PbdBody& body, const TaskArena& arena);
    /// Where all of the ghost's nodes are: after the body was put elsewhere.
    void see_all(const PbdBody& body, const TaskArena& arena) { m_ghost.update(body, arena); }
    /// Once a step, which lasts this long. What was found before is kept while little has moved.
    void look(const Wire& wire, const PbdBody& body, double duration_s, const TaskArena& arena);
    /// In each sub-step of h seconds, after wire and body have been moved.
    std::span<WireContact> gather(const Wire& wire, const PbdBody& body, double h,
                                  const TaskArena& arena);
    /// Between two Newton steps: where the wall would go with the forces of the last one.
    void yield(double h);
    /// After the wire has been solved.
    Status apply(PbdBody& body, double h);

    /// How far the surface of the wire that is outside of the guide is beyond the ghost surface at
    /// most, as both are now; below 0: the distance in between, where it is less than what `look`
    /// looked at. @param skipped  [segment]: doesn't count
    double depth(const Wire& wire, const PbdBody& body, std::span<const std::uint8_t> skipped,
                 const TaskArena& arena);
    std::span<const WireContact> contacts() const { return m_contacts; }
    double push_force() const;  ///< all that the wall is pushed with [µN]
    /// How far the last sub-step's contacts have pushed any particle [mm].
    double pushed_mm() const { return m_pushed_mm; }
    const pbd::GhostSurface& ghost() const { return m_ghost; }

  private:
    struct Bearing {  ///< of a contact on a particle
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
    /// [node]: when it was last put on that list, and when those around it were
    std::vector<std::uint32_t> m_seen, m_ringed;
    std::uint32_t m_turn = 0;
    std::vector<NearWall> m_near;  ///< [segment − m_first]
    std::int32_t m_first = 0;
    int m_age = 0, m_kept_age = 0;     ///< of that, in steps
    bool m_is_new = false;             ///< whether state kept between steps changed since keep()
    std::vector<double> m_moves;       ///< [segment − m_first]: that `look` allowed for [mm]
    std::vector<double> m_depths;      ///< likewise
    std::vector<Vec3d> m_places_seen;  ///< of the wire, by `look`
    double m_pushed_mm = 0;
    double m_wall_moved = 0;  ///< of any node near the wire, at most, since then
    std::vector<WireContact> m_contacts;
    std::vector<std::int32_t> m_bearing_starts;
    std::vector<Bearing> m_bearings;    ///< of the contacts, one after the other
    std::vector<double> m_share;        ///< [particle]: S_p
    std::vector<Vec3d> m_push;          ///< [particle]: Σ b F
    std::vector<std::int32_t> m_borne;  ///< particles of which the two aren't 0
};

}  // namespace pliant::catheter
