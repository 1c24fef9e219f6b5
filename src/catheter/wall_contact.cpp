// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "catheter/wall_contact.h"

#include <algorithm>
#include <cmath>

#include "pbd/segment_triangle.h"

namespace pliant::catheter {
namespace {

/// Further than what moves in a step: triangles within this count for the depth [mm].
constexpr double kLook = 1;
/// A contact that is this much open may close in the wire's solve [mm].
constexpr double kOpen = 0.2;
/// Of one node or segment, contacts with normals that differ by more than this cosine.
constexpr double kAlike = 0.95;
constexpr std::size_t kMostOfOne = 4;
/// Of a segment, looked at for the depth.
constexpr int kPlaces = 3;

}  // namespace

WallContact::WallContact(const TetMesh& mesh, const TriangleMesh& ghost,
                         std::span<const Embedded> ghost_places,
                         const WallContactSettings& settings)
    : m_settings(settings),
      m_ghost(mesh, ghost, ghost_places, 0.5),
      m_seen(ghost.nodes_mm.size(), 0),
      m_share(mesh.nodes_mm.size(), 0),
      m_push(mesh.nodes_mm.size(), Vec3d{0, 0, 0}) {}

void WallContact::wake(const PbdBody& body) {
    m_ghost.update(body, m_awake);
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

void WallContact::look(const Wire& wire, const PbdBody& body, double duration_s) {
    m_ghost.update(body, m_awake);
    m_pairs.clear();
    m_near_nodes.clear();
    ++m_turn;
    const auto& x = wire.places();
    // With the one that may come out of the guide in this step.
    for (std::int32_t s = std::max(0, wire.first() - 1); s < wire.segments(); ++s) {
        const Vec3d b = x[std::size_t(s) + 1], a = s < wire.first() ? b : begin_of(wire, s);
        const double moves = duration_s * std::max(norm(wire.velocities()[std::size_t(s)]),
                                                   norm(wire.velocities()[std::size_t(s) + 1]));
        const double reach = m_settings.radius_mm + m_settings.skin_mm + kLook + moves;
        Vec3d low, high;
        for (int c = 0; c < 3; ++c) {
            low[c] = std::min(a[c], b[c]) - reach;
            high[c] = std::max(a[c], b[c]) + reach;
        }
        m_ghost.near(low, high, m_found_triangles);
        const std::size_t from = m_pairs.size();
        for (const std::int32_t t : m_found_triangles) {
            const auto& nodes = m_ghost.triangles()[std::size_t(t)];
            bool apart = false;
            for (int c = 0; c < 3; ++c) {
                const auto at = [&](std::size_t k) {
                    return m_ghost.places()[std::size_t(nodes[k])][c];
                };
                apart |= std::max({at(0), at(1), at(2)}) < low[c] ||
                         std::min({at(0), at(1), at(2)}) > high[c];
            }
            if (apart || is_far(a, b, nodes, reach)) continue;
            m_pairs.push_back({s, t, 0, true});
            // The normals of corners and edges need the triangles around.
            for (const std::int32_t n : nodes)
                for (const std::int32_t u : m_ghost.ring(n))
                    for (const std::int32_t m : m_ghost.triangles()[std::size_t(u)]) {
                        if (m_seen[std::size_t(m)] == m_turn) continue;
                        m_seen[std::size_t(m)] = m_turn;
                        m_near_nodes.push_back(m);
                    }
        }
        rank(a, b, std::span<Pair>(m_pairs).subspan(from));
    }
    m_ranked_places = x;
    m_wall_moved = 0;
}

/// By the ball around the triangle's middle.
bool WallContact::is_far(Vec3d a, Vec3d b, const std::array<std::int32_t, 3>& triangle,
                         double reach) const {
    const auto p = [&](std::size_t k) { return m_ghost.places()[std::size_t(triangle[k])]; };
    const Vec3d middle = (1.0 / 3) * (p(0) + p(1) + p(2)), u = b - a;
    double ball = 0;
    for (std::size_t k = 0; k < 3; ++k) ball = std::max(ball, norm(p(k) - middle));
    const double t = std::clamp(dot(middle - a, u) / std::max(1e-12, dot(u, u)), 0.0, 1.0);
    return norm(middle - (a + t * u)) > reach + ball;
}

/// Of what is outside of the guide: the wall doesn't feel what is in it.
Vec3d WallContact::begin_of(const Wire& wire, std::int32_t segment) {
    const auto s = std::size_t(segment);
    const double along = segment == wire.first() ? wire.guide_end() : 0;
    return (1 - along) * wire.places()[s] + along * wire.places()[s + 1];
}

/// Nearest first; and which are so far that they can't be touched yet.
void WallContact::rank(Vec3d a, Vec3d b, std::span<Pair> of_segment) const {
    if (of_segment.empty()) return;
    int feature = 0;
    Vec3d off{0, 0, 0};
    double least = 1e300;
    std::int32_t nearest = 0;
    for (Pair& pair : of_segment) {
        const auto p = corners(pair);
        const auto near = pbd::nearest_pair(a, b, p[0], p[1], p[2]);
        const Vec3d d = near.on_segment - near.on_triangle;
        pair.distance = norm(d);
        if (!(pair.distance < least)) continue;
        least = pair.distance;
        feature = near.feature;
        off = d;
        nearest = pair.triangle;
    }
    std::sort(of_segment.begin(), of_segment.end(), [](const Pair& p, const Pair& q) {
        return p.distance != q.distance ? p.distance < q.distance : p.triangle < q.triangle;
    });
    // A wire that has gone through the wall looks at all of it, to find its way back.
    const bool is_inside =
        least > 0.5 * m_settings.radius_mm && dot(off, m_ghost.normal(nearest, feature)) >= 0;
    for (Pair& pair : of_segment) pair.is_deep = !is_inside;
}

std::array<Vec3d, 3> WallContact::corners(const Pair& pair) const {
    const auto& t = m_ghost.triangles()[std::size_t(pair.triangle)];
    return {m_ghost.places()[std::size_t(t[0])], m_ghost.places()[std::size_t(t[1])],
            m_ghost.places()[std::size_t(t[2])]};
}

bool WallContact::is_nearest(Vec3d on_wire, double distance,
                             std::span<const Pair> of_segment) const {
    return std::all_of(of_segment.begin(), of_segment.end(), [&](const Pair& other) {
        const auto p = corners(other);
        return norm(on_wire - mesh::nearest_on_triangle(on_wire, p[0], p[1], p[2]).place) >=
               distance - 1e-9;
    });
}

void WallContact::consider(const Wire& wire, const Pair& pair, std::span<const Pair> of_segment,
                           double along, Vec3d on_wire, Vec3d on_wall, int feature) {
    const Vec3d d = on_wire - on_wall;
    const double distance = norm(d);
    if (distance > m_settings.radius_mm + m_settings.skin_mm + kLook) return;
    const Vec3d out = m_ghost.normal(pair.triangle, feature);
    double height = distance;
    if (out != Vec3d{0, 0, 0} && dot(d, out) < 0) height = -distance;
    // Beyond a ridge are triangles that are seen from behind; only the nearest one knows the side.
    if (height < 0 && !is_nearest(on_wire, distance, of_segment)) return;
    if (!(distance > 1e-9) && out == Vec3d{0, 0, 0}) return;
    // The direction in between is right wherever there is a distance to speak of.
    const Vec3d normal = distance > 1e-3 || out == Vec3d{0, 0, 0} ? (1 / height) * d : out;
    Found f;
    f.gap = height - m_settings.radius_mm - m_settings.skin_mm;
    if (f.gap > kOpen) return;
    f.place = on_wall;
    f.triangle = pair.triangle;
    WireContact& c = f.contact;
    c.segment = pair.segment;
    c.along = along;
    c.normal = normal;
    c.lever = -m_settings.radius_mm * normal;
    c.least = dot(normal, on_wall) + m_settings.radius_mm + m_settings.skin_mm;
    c.friction = m_settings.friction;
    const auto s = std::size_t(pair.segment);
    c.sticks = (1 - along) * wire.places_before()[s] + along * wire.places_before()[s + 1];
    m_found.push_back(f);
}

/// Of those from here on: the deepest first, then such that point elsewhere.
void WallContact::keep_some(std::size_t from) {
    const auto begin = m_found.begin() + std::ptrdiff_t(from);
    std::sort(begin, m_found.end(), [](const Found& a, const Found& b) {
        return a.gap != b.gap ? a.gap < b.gap : a.triangle < b.triangle;
    });
    std::size_t kept = from;
    for (std::size_t n = from; n < m_found.size() && kept < from + kMostOfOne; ++n) {
        bool is_new = true;
        for (std::size_t k = from; k < kept; ++k)
            is_new &= dot(m_found[k].contact.normal, m_found[n].contact.normal) < kAlike;
        if (is_new) m_found[kept++] = m_found[n];
    }
    m_found.resize(std::min(kept, m_found.size()));
}

/// By how much a segment and a triangle have come nearer since `look`, at most.
double WallContact::moved(const Wire& wire, std::int32_t segment) const {
    const auto s = std::size_t(segment);
    const auto of = [&](std::size_t n) { return norm(wire.places()[n] - m_ranked_places[n]); };
    return m_wall_moved + std::max(of(s), of(s + 1));
}

std::span<WireContact> WallContact::gather(const Wire& wire, const PbdBody& body, double h) {
    m_wall_moved += m_ghost.update(body, m_near_nodes);
    m_found.clear();
    const auto& x = wire.places();
    const double touching = m_settings.radius_mm + m_settings.skin_mm + kOpen;
    for (std::size_t begin = 0, end; begin < m_pairs.size(); begin = end) {
        const std::int32_t s = m_pairs[begin].segment;
        for (end = begin; end < m_pairs.size() && m_pairs[end].segment == s;) ++end;
        if (s < wire.first()) continue;
        const Vec3d a = begin_of(wire, s), b = x[std::size_t(s) + 1];
        const bool is_first = s == wire.first();
        const double before = is_first ? wire.guide_end() : 0;
        const auto of_segment = std::span<const Pair>(m_pairs).subspan(begin, end - begin);
        const double most = touching + moved(wire, s);
        const auto may_touch = [&](const Pair& p) { return p.is_deep || p.distance <= most; };
        // The segment's second node, and what is in between; its first node is the one before's.
        std::size_t from = m_found.size();
        for (const Pair& pair : of_segment) {
            if (!may_touch(pair)) break;
            const auto p = corners(pair);
            const auto nearest = mesh::nearest_on_triangle(b, p[0], p[1], p[2]);
            consider(wire, pair, of_segment, 1, b, nearest.place, nearest.feature);
        }
        keep_some(from);
        from = m_found.size();
        for (const Pair& pair : of_segment) {
            if (!may_touch(pair)) break;
            const auto p = corners(pair);
            const auto near = pbd::nearest_pair(a, b, p[0], p[1], p[2]);
            if ((near.along > 0.02 || is_first) && near.along < 0.98)
                consider(wire, pair, of_segment, before + (1 - before) * near.along,
                         near.on_segment, near.on_triangle, near.feature);
        }
        keep_some(from);
    }
    bear(body, h);
    return m_contacts;
}

/// What each contact rests on, how soft that is, and where it goes by itself.
void WallContact::bear(const PbdBody& body, double h) {
    m_contacts.clear();
    m_bearings.clear();
    m_bearing_starts.clear();
    for (const std::int32_t p : m_borne) m_share[std::size_t(p)] = 0;
    m_borne.clear();
    for (const Found& f : m_found) {
        const auto& t = m_ghost.triangles()[std::size_t(f.triangle)];
        const auto place = [&](std::size_t k) { return m_ghost.places()[std::size_t(t[k])]; };
        const auto weights = mesh::weights_on_triangle(f.place, place(0), place(1), place(2));
        const std::size_t start = m_bearings.size();
        m_bearing_starts.push_back(std::int32_t(start));
        Vec3d moved{0, 0, 0};
        for (std::size_t k = 0; k < 3; ++k) {
            const pbd::Ride& ride = m_ghost.ride(t[k]);
            for (std::size_t c = 0; c < 4; ++c) {
                if (ride.weights[c] == 0) continue;
                const std::int32_t p = ride.particles[c];
                const double weight = weights[k] * ride.weights[c];
                auto at = std::find_if(m_bearings.begin() + std::ptrdiff_t(start), m_bearings.end(),
                                       [&](const Bearing& b) { return b.particle == p; });
                if (at == m_bearings.end())
                    m_bearings.push_back({p, weight});
                else
                    at->weight += weight;
                moved = moved + weight * h * body.velocity(p);
            }
        }
        m_contacts.push_back(f.contact);
        m_contacts.back().sticks = f.contact.sticks + moved;
        m_contacts.back().sticking_mm = m_settings.sticking_mm_s * h;
        if (f.gap > 0) continue;
        for (std::size_t n = start; n < m_bearings.size(); ++n) {
            double& share = m_share[std::size_t(m_bearings[n].particle)];
            if (share == 0) m_borne.push_back(m_bearings[n].particle);
            share += std::abs(m_bearings[n].weight);
        }
    }
    m_bearing_starts.push_back(std::int32_t(m_bearings.size()));
    for (std::size_t c = 0; c < m_contacts.size(); ++c) {
        double soft = 0;
        for (auto n = std::size_t(m_bearing_starts[c]); n < std::size_t(m_bearing_starts[c + 1]);
             ++n) {
            const Bearing& b = m_bearings[n];
            const double weight = std::abs(b.weight);
            soft += weight * body.inverse_mass(b.particle) *
                    std::max(weight, m_share[std::size_t(b.particle)]);
        }
        m_contacts[c].compliance = m_settings.compliance + h * h * soft;
    }
}

/// Forces on particles.
void WallContact::sum_up() {
    for (const std::int32_t p : m_borne) m_share[std::size_t(p)] = 0;
    m_borne.clear();
    for (std::size_t c = 0; c < m_contacts.size(); ++c) {
        const Vec3d force = m_contacts[c].force;
        if (force == Vec3d{0, 0, 0}) continue;
        for (auto n = std::size_t(m_bearing_starts[c]); n < std::size_t(m_bearing_starts[c + 1]);
             ++n) {
            const Bearing& b = m_bearings[n];
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

void WallContact::yield(const PbdBody& body, double h) {
    sum_up();
    for (std::size_t c = 0; c < m_contacts.size(); ++c) {
        WireContact& contact = m_contacts[c];
        contact.pushed = dot(contact.force, contact.normal);
        // The surfaces' own compliance is what may be left between them.
        contact.yielded = (-m_settings.compliance * contact.pushed) * contact.normal;
        for (auto n = std::size_t(m_bearing_starts[c]); n < std::size_t(m_bearing_starts[c + 1]);
             ++n) {
            const Bearing& b = m_bearings[n];
            if (m_share[std::size_t(b.particle)] == 0) continue;
            contact.yielded = contact.yielded - (h * h * b.weight * body.inverse_mass(b.particle)) *
                                                    m_push[std::size_t(b.particle)];
        }
    }
}

Status WallContact::apply(PbdBody& body, double h) {
    sum_up();
    for (const std::int32_t p : m_borne) {
        const double w = body.inverse_mass(p);
        if (w == 0) continue;
        const Vec3d by = (-h * h * w) * m_push[std::size_t(p)];
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

double WallContact::depth(const Wire& wire, const PbdBody& body) {
    m_wall_moved += m_ghost.update(body, m_near_nodes);
    const auto& x = wire.places();
    double most = -kLook;
    for (std::size_t begin = 0, end; begin < m_pairs.size(); begin = end) {
        const std::int32_t segment = m_pairs[begin].segment;
        for (end = begin; end < m_pairs.size() && m_pairs[end].segment == segment;) ++end;
        if (segment < wire.first()) continue;
        const auto s = std::size_t(segment);
        const double nearer = moved(wire, segment);
        const Vec3d first = begin_of(wire, segment);
        for (int k = segment == wire.first() ? 0 : 1; k <= kPlaces; ++k) {
            const double along = double(k) / kPlaces;
            const Vec3d p = (1 - along) * first + along * x[s + 1];
            // The nearest triangle says on which side a place is.
            double least = 1e300;
            std::int32_t triangle = 0;
            mesh::NearestOnTriangle nearest{};
            for (std::size_t n = begin; n < end && m_pairs[n].distance - nearer < least; ++n) {
                const auto c = corners(m_pairs[n]);
                const auto found = mesh::nearest_on_triangle(p, c[0], c[1], c[2]);
                const double distance = norm(p - found.place);
                if (!(distance < least)) continue;
                least = distance;
                triangle = m_pairs[n].triangle;
                nearest = found;
            }
            const bool beyond =
                dot(p - nearest.place, m_ghost.normal(triangle, nearest.feature)) < 0;
            most = std::max(most, m_settings.radius_mm - (beyond ? -least : least));
        }
    }
    return most;
}

}  // namespace pliant::catheter
