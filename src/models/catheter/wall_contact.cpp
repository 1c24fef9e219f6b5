// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "catheter/wall_contact.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "mesh/triangle_distance.h"

namespace pliant::catheter {
namespace {

constexpr std::int64_t kSegmentGrain = 4;  ///< segments per task
/// Steps for which the broad phase is reused, unless a node has moved by more than kept_mm.
constexpr int kMaxKept = 20;

/// Distance of a segment in a step at its present speed.
double way_of(const Wire& wire, std::int32_t segment, double duration_s) {
    const auto& v = wire.velocities();
    const auto s = std::size_t(segment);
    return duration_s * std::max(norm(v[s]), norm(v[s + 1]));
}

}  // namespace

WallContact::WallContact(const TetMesh& mesh, const TriangleMesh& ghost,
                         std::span<const Embedded> ghost_positions,
                         const WallContactSettings& settings)
    : m_settings(settings),
      m_ghost(mesh, ghost, ghost_positions, 0.5),
      m_seen(ghost.nodes_mm.size(), 0),
      m_ringed(ghost.nodes_mm.size(), 0),
      m_share(mesh.nodes_mm.size(), 0),
      m_push(mesh.nodes_mm.size(), Vec3d{0, 0, 0}) {}

void WallContact::wake(const PbdBody& body, const TaskArena& arena) {
    m_is_new = true;
    m_ghost.update(body, m_awake, arena);
    m_awake.clear();
    for (std::size_t n = 0; n < m_seen.size(); ++n) {
        const pbd::Ride& ride = m_ghost.ride(std::int32_t(n));
        for (std::size_t k = 0; k < 4; ++k)
            if (ride.weights[k] != 0 && body.inverse_mass(ride.particles[k]) > 0) {
                m_awake.push_back(std::int32_t(n));
                break;
            }
    }
}

bool WallContact::may_keep(const Wire& wire, double duration_s) {
    const std::int32_t first = std::max(0, wire.first() - 1);
    if (m_near.empty() || first < m_first || ++m_age >= kMaxKept) return false;
    for (std::int32_t s = first; s < wire.segments(); ++s)
        if (moved(wire, s) + way_of(wire, s, duration_s) > m_settings.kept_mm) return false;
    return true;
}

void WallContact::look(const Wire& wire, const PbdBody& body, double duration_s,
                       const TaskArena& arena) {
    if (!may_keep(wire, duration_s)) look_anew(wire, body, duration_s, arena);
}

void WallContact::look_anew(const Wire& wire, const PbdBody& body, double duration_s,
                            const TaskArena& arena) {
    m_age = 0;
    m_is_new = true;
    m_ghost.update(body, m_awake, arena);
    // Includes the segment that may leave the guide in this step.
    m_first = std::max(0, wire.first() - 1);
    const std::int64_t count = wire.segments() - m_first;
    m_near.resize(std::size_t(count));
    m_moves.resize(std::size_t(count));
    const auto& x = wire.positions();
    const auto look_at = [&](std::int64_t from, std::int64_t to) {
        for (auto n = std::size_t(from); n < std::size_t(to); ++n) {
            const std::size_t s = n + std::size_t(m_first);
            const Vec3d begin =
                std::int32_t(s) < wire.first() ? x[s + 1] : outside_of(wire, std::int32_t(s)).begin;
            m_moves[n] = m_settings.kept_mm + way_of(wire, std::int32_t(s), duration_s);
            m_near[n].look(begin, x[s + 1], m_moves[n], m_settings, m_ghost);
        }
    };
    arena.for_each(count, kSegmentGrain, std::cref(look_at));
    if (!m_settings.is_rigid) {
        find_near_nodes();
        m_ghost.mark();
    }
    m_positions_seen = x;
    m_wall_moved = 0;
}

/// The normals of corners and edges need the adjacent triangles.
void WallContact::find_near_nodes() {
    m_near_nodes.clear();
    ++m_turn;
    for (const NearWall& near : m_near)
        for (const NearWall::Pair& pair : near.pairs())
            for (const std::int32_t n : m_ghost.triangles()[std::size_t(pair.triangle)]) {
                if (m_ringed[std::size_t(n)] == m_turn) continue;
                m_ringed[std::size_t(n)] = m_turn;
                for (const std::int32_t u : m_ghost.ring(n))
                    for (const std::int32_t m : m_ghost.triangles()[std::size_t(u)]) {
                        if (m_seen[std::size_t(m)] == m_turn) continue;
                        m_seen[std::size_t(m)] = m_turn;
                        m_near_nodes.push_back(m);
                    }
            }
}

/// Upper bound of the approach of a segment and a triangle since `look`.
double WallContact::moved(const Wire& wire, std::int32_t segment) const {
    const auto s = std::size_t(segment);
    const auto of = [&](std::size_t n) { return norm(wire.positions()[n] - m_positions_seen[n]); };
    return m_wall_moved + std::max(of(s), of(s + 1));
}

/// The grid of triangles may be incomplete after a failure.
double WallContact::update_near(const PbdBody& body, const TaskArena& arena) {
    if (m_settings.is_rigid) return 0;
    const bool was_new = m_is_new;
    m_is_new = true;
    const double moved = m_ghost.update(body, m_near_nodes, arena);
    m_is_new = was_new;
    return moved;
}

/// Whether a motion exceeds the bound of `look`: an impact, or a wall that gives way suddenly.
bool WallContact::is_outrun(const Wire& wire) const {
    if (wire.first() < m_first) return true;
    for (std::int32_t s = wire.first(); s < wire.segments(); ++s)
        if (moved(wire, s) > m_moves[std::size_t(s - m_first)] + kLook - kOpen) return true;
    return false;
}

/// Calls work(segment, number in m_near) for all segments with a part outside of the guide.
template <class Work>
void WallContact::for_outside(const Wire& wire, const TaskArena& arena, const Work& work) {
    const std::int64_t skipped = std::max(0, wire.first() - m_first);
    const auto some = [&](std::int64_t from, std::int64_t to) {
        for (std::int64_t n = from; n < to; ++n)
            work(outside_of(wire, std::int32_t(m_first + skipped + n)), std::size_t(skipped + n));
    };
    arena.for_each(std::int64_t(m_near.size()) - skipped, kSegmentGrain, std::cref(some));
}

std::span<WireContact> WallContact::gather(const Wire& wire, const PbdBody& body, double h,
                                           const TaskArena& arena) {
    m_wall_moved = update_near(body, arena);
    if (is_outrun(wire)) look_anew(wire, body, h, arena);
    for_outside(wire, arena, [&](const SegmentOutside& segment, std::size_t n) {
        m_near[n].find(segment, moved(wire, segment.number), m_settings, m_ghost);
    });
    m_contacts.clear();
    m_bearings.clear();
    m_bearing_starts.clear();
    for (const std::int32_t p : m_borne) m_share[std::size_t(p)] = 0;
    m_borne.clear();
    for (auto n = std::size_t(std::max(0, wire.first() - m_first)); n < m_near.size(); ++n)
        for (const NearWall::Found& found : m_near[n].found()) rest_on(found, body, h);
    m_bearing_starts.push_back(std::int32_t(m_bearings.size()));
    find_compliances(h);
    return m_contacts;
}

/// Computes the particles that bear a contact, and their unconstrained motion.
void WallContact::rest_on(const NearWall::Found& found, const PbdBody& body, double h) {
    const auto& t = m_ghost.triangles()[std::size_t(found.triangle)];
    const auto position = [&](std::size_t k) { return m_ghost.positions()[std::size_t(t[k])]; };
    const auto weights =
        mesh::weights_on_triangle(found.position, position(0), position(1), position(2));
    const std::size_t start = m_bearings.size();
    m_bearing_starts.push_back(std::int32_t(start));
    Vec3d moved{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
        const pbd::Ride& ride = m_ghost.ride(t[k]);
        for (std::size_t c = 0; c < 4; ++c) {
            if (ride.weights[c] == 0) continue;
            const std::int32_t p = ride.particles[c];
            const double weight = weights[k] * ride.weights[c];
            const auto at =
                std::find_if(m_bearings.begin() + std::ptrdiff_t(start), m_bearings.end(),
                             [&](const Bearing& b) { return b.particle == p; });
            if (at == m_bearings.end())
                m_bearings.push_back({p, weight, body.inverse_mass(p)});
            else
                at->weight += weight;
            moved = moved + weight * h * body.velocity(p);
        }
    }
    m_contacts.push_back(found.contact);
    m_contacts.back().sticks = found.contact.sticks + moved;
    m_contacts.back().sticking_mm = m_settings.sticking_mm_s * h;
    if (found.gap > 0) return;
    for (std::size_t n = start; n < m_bearings.size(); ++n) {
        double& share = m_share[std::size_t(m_bearings[n].particle)];
        if (share == 0) m_borne.push_back(m_bearings[n].particle);
        share += std::abs(m_bearings[n].weight);
    }
}

void WallContact::find_compliances(double h) {
    for (std::size_t c = 0; c < m_contacts.size(); ++c) {
        double soft = 0;
        for (const Bearing& b : bearings(c)) {
            const double weight = std::abs(b.weight);
            soft += weight * b.inverse_mass * std::max(weight, m_share[std::size_t(b.particle)]);
        }
        m_contacts[c].wall_compliance = h * h * soft;
        m_contacts[c].compliance = m_settings.compliance + m_contacts[c].wall_compliance;
    }
}

/// Sums up the forces on particles.
void WallContact::sum_up() {
    for (const std::int32_t p : m_borne) m_share[std::size_t(p)] = 0;
    m_borne.clear();
    for (std::size_t c = 0; c < m_contacts.size(); ++c) {
        const Vec3d force = m_contacts[c].force;
        if (force == Vec3d{0, 0, 0}) continue;
        for (const Bearing& b : bearings(c)) {
            double& share = m_share[std::size_t(b.particle)];
            if (share == 0) {
                m_borne.push_back(b.particle);
                m_push[std::size_t(b.particle)] = {0, 0, 0};
            }
            share = 1;
            m_push[std::size_t(b.particle)] = m_push[std::size_t(b.particle)] + b.weight * force;
        }
    }
}

void WallContact::yield(double h) {
    sum_up();
    for (std::size_t c = 0; c < m_contacts.size(); ++c) {
        WireContact& contact = m_contacts[c];
        contact.pushed = dot(contact.force, contact.normal);
        contact.dragged = contact.force - contact.pushed * contact.normal;
        // The surfaces' compliance allows this remaining gap.
        contact.yielded = (-m_settings.compliance * contact.pushed) * contact.normal;
        for (const Bearing& b : bearings(c)) {
            if (m_share[std::size_t(b.particle)] == 0) continue;
            contact.yielded = contact.yielded -
                              (h * h * b.weight * b.inverse_mass) * m_push[std::size_t(b.particle)];
        }
    }
}

Status WallContact::apply(PbdBody& body, double h) {
    sum_up();
    m_pushed_mm = 0;
    for (const std::int32_t p : m_borne) {
        const double w = body.inverse_mass(p);
        if (w == 0) continue;
        const Vec3d by = (-h * h * w) * m_push[std::size_t(p)];
        m_pushed_mm = std::max(m_pushed_mm, norm(by));
        if (const Status s =
                body.set_state(p, body.position(p) + by, body.velocity(p) + (1 / h) * by);
            !s.ok())
            return s;
    }
    return Ok{};
}

double WallContact::push_force() const {
    double sum = 0;
    for (const WireContact& c : m_contacts) sum += dot(c.force, c.normal);
    return sum;
}

double WallContact::largest_push() const {
    double most = 0;
    for (const WireContact& c : m_contacts) most = std::max(most, dot(c.force, c.normal));
    return most;
}

double WallContact::depth(const Wire& wire, const PbdBody& body,
                          std::span<const std::uint8_t> skipped, const TaskArena& arena) {
    m_wall_moved = update_near(body, arena);
    m_depths.assign(m_near.size(), -kLook);
    for_outside(wire, arena, [&](const SegmentOutside& segment, std::size_t n) {
        if (skipped[std::size_t(segment.number)]) return;
        m_depths[n] =
            m_near[n].depth(segment, moved(wire, segment.number), m_settings.radius_mm, m_ghost);
    });
    return m_depths.empty() ? -kLook : *std::max_element(m_depths.begin(), m_depths.end());
}

}  // namespace pliant::catheter
