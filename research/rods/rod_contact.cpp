// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact is projected after the sub-steps of rod and wall. A touch is a point p of the rod's axis
// and a point q of a ghost triangle; p is a node (a sphere) or between two (a capsule):
//
//   C = (p − q)·n − radius ≥ 0,  Δp = w_p λ n,  Δq = −w_q λ n,  λ ≥ 0
//
// The sliding of the rod's surface along the wall since the previous sub-step is undone up to
// friction · λ. Friction acts at the rod's surface, so it also rotates the segment. That conserves
// angular momentum, and a twisted wire feels the wall.
//
// n points to the side of the ghost that faces the lumen, even if p is beyond it. The search
// distance includes the largest motion in the sub-step, so no contact is missed.

#include <pliant/research/rod.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/errors.h"
#include "pbd/ghost_surface.h"
#include "pbd/segment_triangle.h"

namespace pliant {
namespace {

using pbd::GhostSurface;
using pbd::NearestPair;

constexpr std::size_t kMaxParticles = 12;  ///< per triangle: three nodes in tetrahedra
constexpr std::size_t kTouches = 32;       ///< per segment, preallocated

struct Touch {
    std::int32_t segment, triangle;
    double along, depth;
    Vec3d position, normal;
    Vec3d lever;                            ///< from the axis to the contact point
    std::int32_t particles[kMaxParticles];  ///< indices of the affected particles
    double weights[kMaxParticles];
    int count;
    double weight;  ///< effective inverse mass of both sides along the normal
    double turn_weight;
    double push;  ///< λ
    Vec3d drag;   ///< friction's λ
};

struct WallParticle {
    std::int32_t particle;
    double inverse_mass;
    Vec3d moved;  ///< free motion since the previous step
    Vec3d position, by;
};

Status check(const RodContactSettings& s) {
    if (!(std::isfinite(s.radius) && s.radius > 0))
        return invalid("radius: expected a number above 0, found " + std::to_string(s.radius));
    if (!(std::isfinite(s.friction) && s.friction >= 0))
        return invalid("friction: expected 0 or more, found " + std::to_string(s.friction));
    if (s.iterations < 1)
        return invalid("iterations: expected 1 or more, found " + std::to_string(s.iterations));
    if (s.rounds < 1)
        return invalid("rounds: expected 1 or more, found " + std::to_string(s.rounds));
    return Ok{};
}

/// Barycentric weights of a point in the triangle's plane.
}  // namespace

struct RodContact::Impl {
    Impl(const TetMesh& mesh, const TriangleMesh& triangles, std::span<const Embedded> rides,
         const RodContactSettings& s)
        : settings(s),
          particle_count(mesh.nodes_mm.size()),
          ghost(mesh, triangles, rides, 0.5 * s.radius),
          number_of(mesh.nodes_mm.size(), -1) {
        wall.reserve(mesh.nodes_mm.size());
        near.reserve(triangles.cells.size());
    }

    RodContactSettings settings;
    std::size_t particle_count;
    GhostSurface ghost;
    std::vector<std::int32_t> number_of;            ///< [particle]: index in `wall`, or −1
    std::vector<WallParticle> wall;                 ///< particles that bear touches
    std::vector<Vec3d> rod_before, rod, rod_start;  ///< [node]: before the step, now, at the start
                                                    ///< of the round
    std::vector<Vec3d> turned;                      ///< [segment]: rotation in the step
    std::vector<Vec3d> turned_by;                   ///< [segment]: rotation by contact
    std::vector<std::int32_t> near;
    std::vector<Touch> touches;
    std::vector<WallTouch> reported;
    double depth_left = 0;

    Status step_once(Rod& rod_, PbdBody& body, const TaskArena& arena);
    void find(double wall_moved);
    void add(std::int32_t segment, std::int32_t triangle, const NearestPair& pair, double reach);
    void weigh(Touch& touch, const Rod& rod_, const PbdBody& body, double h);
    Vec3d rod_point(const Touch& t, const std::vector<Vec3d>& at) const {
        const auto s = std::size_t(t.segment);
        return (1 - t.along) * at[s] + t.along * at[s + 1];
    }
    Vec3d wall_point(const Touch& t) const {
        Vec3d sum{0, 0, 0};
        for (int k = 0; k < t.count; ++k)
            sum = sum + t.weights[k] * wall[std::size_t(t.particles[k])].position;
        return sum;
    }
    double depth(const Touch& t) const {
        return settings.radius - dot(rod_point(t, rod) - wall_point(t), t.normal);
    }
    void apply(const Touch& t, Vec3d impulse, const Rod& rod_);
    void project(Touch& t, const Rod& rod_);
    Status round(Rod& rod_, PbdBody& body, double h, bool last);
};

/// Finds segments (or their nodes) and triangles that are too near.
void RodContact::Impl::find(double wall_moved) {
    touches.clear();
    const std::size_t segments = rod.size() - 1;
    for (std::size_t s = 0; s < segments; ++s) {
        const Vec3d a = rod[s], b = rod[s + 1];
        const double moved = std::max(norm(a - rod_before[s]), norm(b - rod_before[s + 1]));
        const double reach = settings.radius + moved + wall_moved;
        Vec3d low, high;
        for (int c = 0; c < 3; ++c) {
            low[c] = std::min(a[c], b[c]) - reach;
            high[c] = std::max(a[c], b[c]) + reach;
        }
        ghost.near(low, high, near);
        for (const std::int32_t t : near) {
            const auto& nodes = ghost.triangles()[std::size_t(t)];
            const Vec3d p[3] = {ghost.positions()[std::size_t(nodes[0])],
                                ghost.positions()[std::size_t(nodes[1])],
                                ghost.positions()[std::size_t(nodes[2])]};
            bool apart = false;
            for (int c = 0; c < 3; ++c)
                apart |= std::max({p[0][c], p[1][c], p[2][c]}) < low[c] ||
                         std::min({p[0][c], p[1][c], p[2][c]}) > high[c];
            if (apart) continue;
            const auto node = [&](Vec3d x, double along) {
                const auto nearest = mesh::nearest_on_triangle(x, p[0], p[1], p[2]);
                add(std::int32_t(s), t, {along, x, nearest.position, nearest.feature}, reach);
            };
            node(a, 0);
            if (s + 1 == segments) node(b, 1);
            const NearestPair pair = pbd::nearest_pair(a, b, p[0], p[1], p[2]);
            if (pair.along > 0 && pair.along < 1) add(std::int32_t(s), t, pair, reach);
        }
    }
    std::sort(touches.begin(), touches.end(), [](const Touch& a, const Touch& b) {
        if (a.depth != b.depth) return a.depth > b.depth;
        if (a.segment != b.segment) return a.segment < b.segment;
        if (a.triangle != b.triangle) return a.triangle < b.triangle;
        return a.along < b.along;
    });
}

void RodContact::Impl::add(std::int32_t segment, std::int32_t triangle, const NearestPair& pair,
                           double reach) {
    const Vec3d d = pair.on_segment - pair.on_triangle;
    const double distance = norm(d);
    if (!(distance < reach)) return;
    const Vec3d out = ghost.normal(triangle, pair.feature);
    Vec3d normal = out;
    const double side = dot(d, out);
    if (side > 0 || out == Vec3d{0, 0, 0}) {
        if (!(distance > 0 && distance < settings.radius)) return;
        normal = (1 / distance) * d;
    }
    // Adjacent triangles find the same corner or edge.
    for (std::size_t n = touches.size(); n-- > 0 && touches[n].segment == segment;)
        if (touches[n].along == pair.along && touches[n].position == pair.on_triangle) return;
    Touch t{};
    t.segment = segment;
    t.triangle = triangle;
    t.along = pair.along;
    t.position = pair.on_triangle;
    t.normal = normal;
    t.lever = -d;
    t.depth = settings.radius - dot(d, normal);
    touches.push_back(t);
}

void RodContact::Impl::weigh(Touch& t, const Rod& rod_, const PbdBody& body, double h) {
    const auto& nodes = ghost.triangles()[std::size_t(t.triangle)];
    const auto position = [&](std::size_t k) { return ghost.positions()[std::size_t(nodes[k])]; };
    const auto weights =
        mesh::weights_on_triangle(t.position, position(0), position(1), position(2));
    t.count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const pbd::Ride& ride = ghost.ride(nodes[k]);
        for (std::size_t c = 0; c < 4; ++c) {
            if (ride.weights[c] == 0) continue;
            std::int32_t& number = number_of[std::size_t(ride.particles[c])];
            if (number < 0) {
                number = std::int32_t(wall.size());
                const std::int32_t p = ride.particles[c];
                wall.push_back(
                    {p, body.inverse_mass(p), h * body.velocity(p), body.position(p), {0, 0, 0}});
            }
            int at = 0;
            while (at < t.count && t.particles[at] != number) ++at;
            if (at == t.count) {
                t.particles[t.count] = number;
                t.weights[t.count++] = 0;
            }
            t.weights[at] += weights[k] * ride.weights[c];
        }
    }
    t.weight = (1 - t.along) * (1 - t.along) * rod_.inverse_mass(t.segment) +
               t.along * t.along * rod_.inverse_mass(t.segment + 1);
    for (int k = 0; k < t.count; ++k)
        t.weight += t.weights[k] * t.weights[k] * wall[std::size_t(t.particles[k])].inverse_mass;
    t.turn_weight = dot(t.lever, t.lever) * rod_.inverse_inertia();
    t.push = 0;
    t.drag = {0, 0, 0};
}

/// Applies an impulse to the rod and its opposite to the wall.
void RodContact::Impl::apply(const Touch& t, Vec3d impulse, const Rod& rod_) {
    const auto s = std::size_t(t.segment);
    rod[s] = rod[s] + (1 - t.along) * rod_.inverse_mass(t.segment) * impulse;
    rod[s + 1] = rod[s + 1] + t.along * rod_.inverse_mass(t.segment + 1) * impulse;
    for (int k = 0; k < t.count; ++k) {
        WallParticle& p = wall[std::size_t(t.particles[k])];
        const Vec3d by = (-t.weights[k] * p.inverse_mass) * impulse;
        p.position = p.position + by;
        p.by = p.by + by;
    }
    turned_by[s] = turned_by[s] + rod_.inverse_inertia() * cross(t.lever, impulse);
}

void RodContact::Impl::project(Touch& t, const Rod& rod_) {
    if (!(t.weight > 0)) return;
    const double push = std::max(0.0, t.push + depth(t) / t.weight);
    if (push != t.push) apply(t, (push - t.push) * t.normal, rod_);
    t.push = push;
    if (settings.friction == 0) return;
    const auto s = std::size_t(t.segment);
    Vec3d slid =
        rod_point(t, rod) - rod_point(t, rod_before) + cross(turned[s] + turned_by[s], t.lever);
    for (int k = 0; k < t.count; ++k) {
        const WallParticle& p = wall[std::size_t(t.particles[k])];
        slid = slid - t.weights[k] * (p.moved + p.by);
    }
    slid = slid - dot(slid, t.normal) * t.normal;
    Vec3d drag = t.drag - (1 / (t.weight + t.turn_weight)) * slid;
    const double size = norm(drag), most = settings.friction * t.push;
    if (size > most) drag = (most / size) * drag;
    apply(t, drag - t.drag, rod_);
    t.drag = drag;
}

Status RodContact::Impl::round(Rod& rod_, PbdBody& body, double h, bool last) {
    for (Touch& t : touches) weigh(t, rod_, body, h);
    rod_start = rod;
    std::fill(turned_by.begin(), turned_by.end(), Vec3d{0, 0, 0});
    for (int n = 0; n < settings.iterations; ++n)
        for (Touch& t : touches) project(t, rod_);
    for (std::size_t n = 0; n < rod.size(); ++n) {
        const Vec3d by = rod[n] - rod_start[n];
        if (by != Vec3d{0, 0, 0}) rod_.displace(std::int32_t(n), by);
    }
    for (std::size_t s = 0; s < turned_by.size(); ++s) {
        if (turned_by[s] == Vec3d{0, 0, 0}) continue;
        rod_.displace_segment(std::int32_t(s), turned_by[s]);
        turned[s] = turned[s] + turned_by[s];
    }
    Status status = Ok{};
    for (const WallParticle& p : wall) {
        number_of[std::size_t(p.particle)] = -1;
        if (p.by == Vec3d{0, 0, 0} || !status.ok()) continue;
        status = body.set_state(p.particle, p.position, body.velocity(p.particle) + (1 / h) * p.by);
    }
    for (const Touch& t : touches) {
        if (last) depth_left = std::max(depth_left, depth(t));
        if (t.push > 0)
            reported.push_back({t.segment, t.along, t.triangle, t.position, t.normal,
                                (1 / (h * h)) * (t.push * t.normal + t.drag)});
    }
    wall.clear();
    return status;
}

Status RodContact::Impl::step_once(Rod& rod_, PbdBody& body, const TaskArena& arena) {
    const auto segments = std::size_t(rod_.settings().segments);
    const double h = rod_.settings().time_step;
    const auto read = [&](std::vector<Vec3d>& to) {
        to.resize(segments + 1);
        for (std::size_t n = 0; n <= segments; ++n) to[n] = rod_.position(std::int32_t(n));
    };
    if (rod_before.size() != segments + 1) read(rod_before);
    if (const Status s = rod_.step(1); !s.ok()) return s;
    if (const Status s = body.step(1, arena); !s.ok()) return s;
    read(rod);
    touches.reserve(kTouches * segments);
    reported.reserve(kTouches * segments);
    turned.resize(segments);
    turned_by.resize(segments);
    for (std::size_t s = 0; s < segments; ++s) turned[s] = h * rod_.spin(std::int32_t(s));
    reported.clear();
    depth_left = 0;
    double wall_moved = 0;
    for (int n = 0; n < settings.rounds; ++n) {
        wall_moved += ghost.update(body, arena);
        find(wall_moved);
        if (touches.empty()) break;
        if (const Status s = round(rod_, body, h, n + 1 == settings.rounds); !s.ok()) return s;
    }
    rod_before = rod;
    return Ok{};
}

RodContact::RodContact(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
RodContact::~RodContact() = default;
RodContact::RodContact(RodContact&&) noexcept = default;
RodContact& RodContact::operator=(RodContact&&) noexcept = default;

Result<RodContact> RodContact::create(const TetMesh& mesh, const TriangleMesh& ghost,
                                      std::span<const Embedded> ghost_positions,
                                      const RodContactSettings& settings) {
    if (const Status s = check(settings); !s.ok()) return s.error();
    if (const Status s = GhostSurface::check(mesh, ghost, ghost_positions); !s.ok())
        return s.error();
    return RodContact(std::make_unique<Impl>(mesh, ghost, ghost_positions, settings));
}

Status RodContact::step(std::int32_t count, Rod& rod, PbdBody& body, const TaskArena& arena) {
    if (count < 0) return invalid("step: expected 0 steps or more, found " + std::to_string(count));
    if (std::size_t(body.particle_count()) != m_impl->particle_count)
        return invalid("step: expected a body of " + std::to_string(m_impl->particle_count) +
                       " particles, found " + std::to_string(body.particle_count()));
    if (rod.settings().time_step != body.settings().time_step)
        return invalid("time_step: expected the same for rod and body, found " +
                       std::to_string(rod.settings().time_step) + " and " +
                       std::to_string(body.settings().time_step));
    if (rod.settings().sub_steps != 1 || body.settings().sub_steps != 1)
        return invalid("sub_steps: expected 1 for rod and body, found " +
                       std::to_string(rod.settings().sub_steps) + " and " +
                       std::to_string(body.settings().sub_steps));
    for (std::int32_t n = 0; n < count; ++n)
        if (const Status s = m_impl->step_once(rod, body, arena); !s.ok()) return s;
    return Ok{};
}

std::span<const WallTouch> RodContact::touches() const {
    return m_impl->reported;
}
double RodContact::depth_left() const {
    return m_impl->depth_left;
}

}  // namespace pliant
