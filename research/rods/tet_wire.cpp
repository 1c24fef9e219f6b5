// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "rods/tet_wire.h"

#include <algorithm>
#include <cmath>

#include "pbd/rotations.h"

namespace pliant::catheter {
namespace {

#include "catheter/chain_solve.inc"

struct PlainChainOps {
    static constexpr int kLanes = 1;

    static double load(const double* from) { return *from; }
    static void store(double v, double* to) { *to = v; }
    static double set(double v) { return v; }
    static double sub(double a, double b) { return a - b; }
    static double mul(double a, double b) { return a * b; }
};

/// Limit of a node's motion in one Newton step, as a fraction of a segment's length.
constexpr double kMaxMove = 0.5;
const auto kRingBars = bars_in_ring();
const std::array<std::array<Bar, kAcross>, 2> kBars{bars_across(false), bars_across(true)};
const std::array kCells{tetrahedra(false), tetrahedra(true)};

Vec3d middle_of(const std::vector<Vec3d>& nodes, std::size_t ring) {
    Vec3d sum{0, 0, 0};
    for (std::size_t k = 0; k < kRing; ++k) sum = sum + nodes[kRing * ring + k];
    return (1.0 / kRing) * sum;
}

/// Force of a bar on its second node.
Vec3d pull_of(Vec3d from, Vec3d to, double rest, double stiffness) {
    const Vec3d d = to - from;
    const double length = norm(d);
    return length > 0 ? (-stiffness * (length - rest) / length) * d : Vec3d{0, 0, 0};
}

}  // namespace

TetWire::TetWire(const WireSettings& settings, double radius_mm, double inserted_mm)
    : Wire(settings, inserted_mm), m_radius(radius_mm), m_held_mm(inserted_mm), m_held_rad(0) {
    const double r = radius_mm, l = settings.segment_mm;
    for (std::size_t i = 0; i < m_count; ++i)
        m_stiffness.push_back(stiffness_for(settings.bend[i], settings.twist[i], r, l));
    for (const bool odd : {false, true}) m_straight[odd] = m_bent[odd] = rest_of(odd, {0, 0, 0});
    const Corners x = corners_at_rest(r, l, {0, 0, 0});
    for (std::size_t n = 0; n < kInRing; ++n)
        m_ring[n] = norm(x[kRingBars[n][1]] - x[kRingBars[n][0]]);
    for (std::size_t n = 0; n < kRing * (m_count + 1); ++n)
        m_nodes.push_back(in_guide(n, fed_mm(n / kRing), 0));
    m_old_nodes = m_predicted = m_nodes;
    m_node_v.assign(m_nodes.size(), {0, 0, 0});
}

TetWire::Rest TetWire::rest_of(bool odd, Vec3d turned) const {
    const Corners x = corners_at_rest(m_radius, m_settings.segment_mm, turned);
    Rest rest;
    for (std::size_t n = 0; n < kAcross; ++n)
        rest.lengths[n] = norm(x[kBars[odd][n].b] - x[kBars[odd][n].a]);
    for (std::size_t n = 0; n < kTets; ++n) rest.volumes[n] = volume_of(kCells[odd][n], x);
    return rest;
}

const TetWire::Rest& TetWire::rest(std::size_t segment) const {
    const bool is_tip = segment + std::size_t(m_settings.tip_segments) >= m_count;
    return (is_tip ? m_bent : m_straight)[segment % 2];
}

void TetWire::bend_tip(double first_rad, double second_rad) {
    if (m_settings.tip_segments == 0) return;
    // Bending towards the first axis is a rotation about the second one.
    const double share = 1 / double(m_settings.tip_segments);
    for (const bool odd : {false, true})
        m_bent[odd] = rest_of(odd, {-share * second_rad, share * first_rad, 0});
}

Vec3d TetWire::in_guide(std::size_t node, double fed_mm, double turned_rad) const {
    const double angle = turned_rad + 0.5 * 3.14159265358979323846 * double(node % kRing);
    const double r = m_radius;
    return m_settings.entry +
           rotated(m_settings.frame, {r * std::cos(angle), r * std::sin(angle), fed_mm});
}

/// Places the nodes in the guide. Nodes that entered off their position are led there smoothly.
void TetWire::hold() {
    const double keep = std::exp(-m_h / kSettle);
    for (std::size_t n = 0; n < kRing * (std::size_t(m_first) + 1); ++n) {
        const double fed = fed_mm(n / kRing);
        const Vec3d off = m_nodes[n] - in_guide(n, fed - m_inserted + m_held_mm, m_held_rad);
        m_nodes[n] = in_guide(n, fed, m_turned) + keep * off;
    }
    m_held_mm = m_inserted;
    m_held_rad = m_turned;
}

void TetWire::find_axis() {
    for (std::size_t n = 0; n <= m_count; ++n) m_x[n] = middle_of(m_nodes, n);
}

void TetWire::predict(double h) {
    m_h = h;
    m_old_x = m_x;
    m_old_nodes = m_nodes;
    hold();
    const double keep = std::max(0.0, 1 - m_settings.damping * h);
    for (std::size_t n = kRing * (std::size_t(m_first) + 1); n < m_nodes.size(); ++n)
        m_nodes[n] = m_nodes[n] + (h * keep) * m_node_v[n];
    m_predicted = m_nodes;
    find_axis();
}

Corners TetWire::corners(const std::vector<Vec3d>& nodes, std::size_t segment) const {
    Corners x;
    std::copy_n(nodes.begin() + std::ptrdiff_t(kRing * segment), x.size(), x.begin());
    return x;
}

/// Adds a coupling of two nodes. Nodes in the guide are no unknowns.
void TetWire::add_pair(std::size_t a, std::size_t b, const Mat3d& m) {
    const std::size_t held = kRing * (std::size_t(m_first) + 1);
    if (a < held || b < held) return;
    const std::size_t row = (a - held) / kRing, column = (b - held) / kRing;
    if (row == column)
        m_chain.diagonal[row].add(3 * (a % kRing), 3 * (b % kRing), m);
    else if (row < column)
        m_chain.upper[row].add(3 * (a % kRing), 3 * (b % kRing), m);
}

void TetWire::add_force(std::size_t node, Vec3d force) {
    const std::size_t held = kRing * (std::size_t(m_first) + 1);
    if (node < held) return;
    m_chain.add_right((node - held) / kRing, 3 * (node % kRing), force);
}

/// Adds a bar. The second derivative across a compressed bar is left out, because it would be
/// negative.
void TetWire::add_bar(std::size_t a, std::size_t b, double rest, double stiffness) {
    const Vec3d d = m_nodes[b] - m_nodes[a],
                pull = pull_of(m_nodes[a], m_nodes[b], rest, stiffness);
    const double length = norm(d);
    if (!(length > 0)) return;
    const double across = stiffness * std::max(0.0, 1 - rest / length);
    const Vec3d n = (1 / length) * d;
    const Mat3d m = pbd::sum(pbd::scaled(stiffness - across, pbd::outer(n, n)),
                             pbd::scaled(across, kIdentity3));
    add_pair(a, a, m);
    add_pair(b, b, m);
    add_pair(a, b, pbd::scaled(-1, m));
    add_pair(b, a, pbd::scaled(-1, m));
    add_force(a, -pull);
    add_force(b, pull);
}

void TetWire::add_segment(std::size_t i) {
    const bool odd = i % 2;
    const SegmentStiffness& k = m_stiffness[i];
    const Rest& at_rest = rest(i);
    const std::size_t from = kRing * i;
    for (std::size_t n = 0; n < kAcross; ++n) {
        const Bar& bar = kBars[odd][n];
        add_bar(from + bar.a, from + bar.b, at_rest.lengths[n], bar.is_along ? k.along : k.aslant);
    }
    for (std::size_t n = 0; n < kInRing; ++n)
        add_bar(from + kRing + kRingBars[n][0], from + kRing + kRingBars[n][1], m_ring[n], k.ring);
    const Corners x = corners(m_nodes, i);
    for (std::size_t n = 0; n < kTets; ++n) {
        const auto& tet = kCells[odd][n];
        const auto g = volume_gradient(tet, x);
        const double v0 = at_rest.volumes[n], stiff = k.bulk / v0;
        const double pressure = stiff * (volume_of(tet, x) - v0);
        for (std::size_t a = 0; a < 4; ++a) {
            add_force(from + tet[a], -pressure * g[a]);
            for (std::size_t b = 0; b < 4; ++b)
                add_pair(from + tet[a], from + tet[b], pbd::scaled(stiff, pbd::outer(g[a], g[b])));
        }
    }
}

/// Weights of the segment's nodes: in a point on the axis, and in the contact point.
TetWire::Weights TetWire::weights(const WireContact& c) const {
    Weights w;
    const auto i = std::size_t(c.segment);
    const double r2 = m_radius * m_radius;
    for (std::size_t n = 0; n < 2 * kRing; ++n) {
        const std::size_t ring = i + n / kRing;
        const double share = n < kRing ? 1 - c.along : c.along;
        const Vec3d from = m_old_nodes[kRing * i + n] - m_old_x[ring];
        w.push[n] = share / kRing;
        w.friction[n] = share * (1.0 / kRing + 2 * dot(c.lever, from) / (kRing * r2));
    }
    return w;
}

/// @returns stiffness of the friction
double TetWire::touch(WireContact& c, const Weights& w) const {
    c.force = {0, 0, 0};
    if (c.segment < m_first) return 0;
    const auto i = std::size_t(c.segment);
    const Vec3d before = (1 - c.along) * m_old_x[i] + c.along * m_old_x[i + 1];
    Vec3d position{0, 0, 0}, slid = before - c.sticks - c.yielded;
    for (std::size_t n = 0; n < 2 * kRing; ++n) {
        const Vec3d x = m_nodes[kRing * i + n];
        position = position + w.push[n] * x;
        slid = slid + w.friction[n] * (x - m_old_nodes[kRing * i + n]);
    }
    return c.touch(position, slid);
}

void TetWire::add_contact(WireContact& c) {
    const Weights w = weights(c);
    const double drag = touch(c, w);
    if (c.force == Vec3d{0, 0, 0}) return;
    const std::size_t from = kRing * std::size_t(c.segment);
    const Mat3d normal = pbd::outer(c.normal, c.normal),
                along = pbd::scaled(drag, pbd::sum(kIdentity3, pbd::scaled(-1, normal)));
    const Vec3d push = dot(c.force, c.normal) * c.normal, slides = c.force - push;
    for (std::size_t a = 0; a < 2 * kRing; ++a) {
        add_force(from + a, w.push[a] * push + w.friction[a] * slides);
        for (std::size_t b = 0; b < 2 * kRing; ++b)
            add_pair(from + a, from + b,
                     pbd::sum(pbd::scaled(w.push[a] * w.push[b] / c.compliance, normal),
                              pbd::scaled(w.friction[a] * w.friction[b], along)));
    }
}

void TetWire::solve(std::span<WireContact> contacts) {
    const auto first = std::size_t(m_first);
    if (first >= m_count) return;
    const double mass = m_settings.mass_g_mm * m_settings.segment_mm / kRing;
    m_chain.reset(m_count - first);
    const std::size_t held = kRing * (first + 1);
    for (std::size_t n = held; n < m_nodes.size(); ++n) {
        const bool is_last = n / kRing == m_count;
        const double m = (is_last ? 0.5 : 1) * mass / (m_h * m_h);
        add_pair(n, n, pbd::scaled(m, kIdentity3));
        add_force(n, m * (m_predicted[n] - m_nodes[n]));
    }
    for (std::size_t i = first; i < m_count; ++i) add_segment(i);
    for (WireContact& c : contacts) add_contact(c);
    solve_chain_of<PlainChainOps>(m_chain.diagonal.data(), m_chain.upper.data(),
                                  m_chain.diagonal.size());
    const double most = kMaxMove * m_settings.segment_mm;
    for (std::size_t n = held; n < m_nodes.size(); ++n) {
        const Vec3d by = m_chain.solution((n - held) / kRing, 3 * (n % kRing));
        const double size = norm(by);
        m_nodes[n] = m_nodes[n] + (size > most ? most / size : 1.0) * by;
    }
    find_axis();
    // Forces at the final positions, which the wall receives.
    for (WireContact& c : contacts) touch(c, weights(c));
}

void TetWire::finish() {
    const double per_h = 1 / m_h;
    for (std::size_t n = 0; n < m_nodes.size(); ++n)
        m_node_v[n] = per_h * (m_nodes[n] - m_old_nodes[n]);
    for (std::size_t n = 0; n <= m_count; ++n) m_v[n] = middle_of(m_node_v, n);
}

}  // namespace pliant::catheter
