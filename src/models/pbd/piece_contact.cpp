// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/piece_contact.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "mesh/triangle_distance.h"

namespace pliant::pbd {
namespace {

// Lengths in mean edges of the surface.
constexpr double kPieceReach = 1;       ///< penetrations up to this are found
constexpr double kPieceSlop = 1e-4;     ///< penetration without a force; above the error of floats
constexpr double kTinyDistance = 1e-6;  ///< nearer points have no direction of their own
/// Penetration at the start with which a node still counts as level with a surface, and a motion by
/// which nothing gets from one side of a piece to the other.
constexpr double kLevel = 0.05;

constexpr double kSpan = 0.5;         ///< motion after which pairs are listed anew, in reaches
constexpr double kSpread = 0.05;      ///< … and anchors renewed
constexpr double kSameNormal = 0.7;   ///< least cosine
constexpr double kOtherSide = -0.5;   ///< largest cosine
constexpr std::int64_t kPatches = 8;  ///< per task

}  // namespace

PieceContact::PieceContact(const BodySurface& surface, std::span<const Vec3d> rest, double gap)
    : m_gap(gap),
      m_reach(std::max(gap, kPieceReach * surface.mean_edge())),
      m_slop(kPieceSlop * surface.mean_edge()),
      m_tiny(kTinyDistance * surface.mean_edge()),
      m_level(kLevel * surface.mean_edge()),
      m_bases(surface.patches().size()),
      m_motions(surface.patches().size()),
      m_shifts(surface.patches().size()),
      m_paired(surface.patches().size()),
      m_boxes(surface),
      m_partners(surface.patches().size()),
      m_runs(surface.patches().size()),
      m_runs_are_old(surface.patches().size(), true),
      m_moved(surface.patches().size()),
      m_found(surface.patches().size()) {
    for (std::size_t p = 0; p < m_found.size(); ++p)
        m_found[p].reserve(surface.owned_nodes_of(p).size());
    const auto patches = surface.patches();
    m_anchors.resize(std::size_t(patches.back().nodes_end));
    m_boxes.update(surface, rest);
    m_rest_starts.push_back(0);
    for (std::size_t n = 0; n < rest.size(); ++n) {
        const std::int32_t own = surface.pieces()[n];
        for (std::size_t begin = 0; begin < patches.size();) {
            const std::int32_t piece = patches[begin].piece;
            mesh::Bounds all;
            std::size_t end = begin;
            for (; end < patches.size() && patches[end].piece == piece; ++end)
                all.add(m_boxes.box(end));
            if (own >= 0 && piece != own && !(all.distance_squared(rest[n]) > gap * gap)) {
                SurfacePoint best;
                best.distance2 = std::numeric_limits<double>::infinity();
                for (std::size_t p = begin; p < end; ++p)
                    if (m_boxes.box(p).distance_squared(rest[n]) < best.distance2)
                        surface.nearest_in_patch(p, rest[n], rest, best);
                const double found = surface.signed_distance(rest[n], best, rest);
                if (found < gap) m_rests.push_back({piece, found});
            }
            begin = end;
        }
        m_rest_starts.push_back(std::int32_t(m_rests.size()));
    }
}

double PieceContact::limit_of(std::int32_t node, std::int32_t piece) const {
    for (auto r = std::size_t(m_rest_starts[std::size_t(node)]);
         r < std::size_t(m_rest_starts[std::size_t(node) + 1]); ++r)
        if (m_rests[r].piece == piece) return m_rests[r].gap - m_slop;
    return m_gap - m_slop;
}

void PieceContact::find(const BodySurface& surface, std::span<const Vec3d> start,
                        std::span<const Vec3d> x, const TaskArena& arena,
                        std::vector<PieceTouch>& touches) {
    touches.clear();
    const auto patches = surface.patches();
    if (patches.front().piece == patches.back().piece) return;
    const bool is_new = !m_is_known;
    m_is_known = false;
    if (is_new) {
        for (auto& partners : m_partners) partners.clear();
        std::fill(m_anchors.begin(), m_anchors.end(), Vec3d{0, 0, 0});
    }
    double farthest = 0;
    for (std::size_t n = 0; n < x.size(); ++n) {
        const Vec3d by = x[n] - start[n];
        farthest = std::max(farthest, dot(by, by));
    }
    // The lists of the start may lack the nearest triangle at the end then.
    const bool is_fast = 2 * std::sqrt(farthest) >= kSpan * m_reach;
    const Positions positions{start, x};
    const auto see = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t p = begin; p < end; ++p) move(surface, std::size_t(p), positions);
    };
    arena.for_each(std::int64_t(patches.size()), 4 * kPatches, std::cref(see));
    bool pairs_hold = !is_new;
    for (std::size_t p = 0; p < patches.size() && pairs_hold; ++p)
        pairs_hold = norm(way_between(m_paired[p], m_motions[p])) +
                         spread_between(m_paired[p], m_motions[p]) + (is_fast ? 0 : m_shifts[p]) <
                     kSpan * m_reach;
    if (!pairs_hold) pair_patches(surface, start);
    const auto some = [&](std::int64_t begin, std::int64_t end) {
        for (auto p = std::size_t(begin); p < std::size_t(end); ++p) {
            m_found[p].clear();
            see_partners(surface, p, start, is_fast);
            search_patch(surface, p, positions, is_fast, m_found[p]);
        }
    };
    arena.for_each(std::int64_t(patches.size()), kPatches, std::cref(some));
    for (const auto& found : m_found) touches.insert(touches.end(), found.begin(), found.end());
    m_is_known = true;
}

/// Finds the motion of a patch until the start and its shift in the sub-step. Renews anchors that
/// no longer follow it.
void PieceContact::move(const BodySurface& surface, std::size_t patch, const Positions& x) {
    const auto nodes = surface.nodes_of(patch);
    const auto anchors = std::span(m_anchors).subspan(
        std::size_t(surface.patches()[patch].nodes_begin), nodes.size());
    Motion& base = m_bases[patch];
    mesh::Bounds by;
    double farthest = 0;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const Vec3d p = x[kStart][std::size_t(nodes[k])];
        const Vec3d shift = x[kEnd][std::size_t(nodes[k])] - p;
        by.add(p - anchors[k]);
        farthest = std::max(farthest, dot(shift, shift));
    }
    m_shifts[patch] = std::sqrt(farthest);
    Motion& now = m_motions[patch];
    now = {base.way + 0.5 * (by.low + by.high), 0.5 * norm(by.high - by.low), base.lost};
    if (!(now.spread > kSpread * m_reach)) return;
    base = {now.way, 0, now.lost + now.spread};
    for (std::size_t k = 0; k < nodes.size(); ++k) anchors[k] = x[kStart][std::size_t(nodes[k])];
    now = base;
}

/// Finds the pairs of patches within reach, and keeps the lists of those that were known.
void PieceContact::pair_patches(const BodySurface& surface, std::span<const Vec3d> start) {
    m_boxes.update(surface, start);
    m_paired = m_motions;
    const auto patches = surface.patches();
    for (std::size_t a = 0; a < patches.size(); ++a) {
        if (surface.owned_nodes_of(a).empty()) continue;
        const mesh::Bounds around = grown(m_boxes.box(a), (1 + 2 * kSpan) * m_reach);
        m_before.clear();
        for (Partner& partner : m_partners[a]) m_before.push_back(std::move(partner));
        m_partners[a].clear();
        std::size_t kept = 0;
        auto old = m_before.begin();
        for (std::size_t b = 0; b < patches.size(); ++b) {
            if (patches[b].piece == patches[a].piece || !overlap(around, m_boxes.box(b))) continue;
            while (old != m_before.end() && std::size_t(old->patch) < b) ++old;
            if (old != m_before.end() && std::size_t(old->patch) == b) {
                m_partners[a].push_back(std::move(*old));
                ++kept;
            } else {
                m_partners[a].push_back(Partner{std::int32_t(b)});
            }
        }
        // Runs point to candidates, which stay where they are when a partner is moved.
        if (kept != m_before.size() || kept != m_partners[a].size()) m_runs_are_old[a] = true;
    }
}

/// Lists the triangles of a patch near each node of another one, nearest first.
void PieceContact::list(const BodySurface& surface, std::size_t patch, Partner& partner,
                        std::span<const Vec3d> x) {
    partner.candidates.clear();
    partner.starts.clear();
    const auto other = std::size_t(partner.patch);
    const Patch& triangles = surface.patches()[other];
    const auto nodes = surface.owned_nodes_of(patch);
    const double span = kSpan * m_reach, reach = m_reach + span;
    mesh::Bounds box;
    for (const std::int32_t n : surface.nodes_of(other)) box.add(x[std::size_t(n)]);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const Vec3d p = x[std::size_t(nodes[k])];
        if (surface.pieces()[std::size_t(nodes[k])] < 0 || box.distance_squared(p) > reach * reach)
            continue;
        // Room for all, so that later lists need no memory.
        partner.starts.reserve(nodes.size() + 1);
        partner.candidates.reserve(nodes.size() * std::size_t(triangles.end - triangles.begin));
        const std::size_t first = partner.candidates.size();
        partner.starts.resize(k + 1, std::int32_t(first));
        double least = m_reach;
        for (std::int32_t t = triangles.begin; t < triangles.end; ++t) {
            const auto& corners = surface.triangles()[std::size_t(t)];
            const Vec3d d = p - mesh::nearest_on_triangle(p, x[std::size_t(corners[0])],
                                                          x[std::size_t(corners[1])],
                                                          x[std::size_t(corners[2])])
                                    .position;
            const double distance = norm(d);
            least = std::min(least, distance);
            if (distance <= least + 2 * span)
                partner.candidates.push_back({t, float(distance * (1 - 1e-6))});
        }
        const auto begin = partner.candidates.begin() + std::ptrdiff_t(first);
        const auto end = std::remove_if(begin, partner.candidates.end(), [&](const Candidate& c) {
            return double(c.distance) > std::min(reach, least + 2 * span);
        });
        partner.candidates.erase(end, partner.candidates.end());
        std::sort(begin, partner.candidates.end(),
                  [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
    }
    if (partner.candidates.empty())
        partner.starts.clear();
    else
        partner.starts.resize(nodes.size() + 1, std::int32_t(partner.candidates.size()));
}

/// Renews the lists of a patch that no longer hold.
void PieceContact::see_partners(const BodySurface& surface, std::size_t patch,
                                std::span<const Vec3d> start, bool is_fast) {
    bool is_new = m_runs_are_old[patch];
    m_moved[patch].resize(m_partners[patch].size());
    for (std::size_t n = 0; n < m_partners[patch].size(); ++n) {
        Partner& partner = m_partners[patch][n];
        Moved& moved = m_moved[patch][n];
        const auto other = std::size_t(partner.patch);
        const auto look = [&] {
            const Motion &a = m_motions[patch], &b = m_motions[other];
            moved = {m_tiny + norm(way_between(partner.own, a) - way_between(partner.other, b)) +
                         spread_between(partner.own, a) + spread_between(partner.other, b),
                     m_shifts[other]};
        };
        look();
        const double until_end = is_fast ? 0 : m_shifts[patch] + moved.shift;
        if (partner.is_listed && moved.before + until_end < kSpan * m_reach) continue;
        partner.is_listed = false;
        list(surface, patch, partner, start);
        partner.own = m_motions[patch];
        partner.other = m_motions[other];
        look();
        partner.is_listed = is_new = true;
    }
    if (is_new) list_runs(surface, patch);
    m_runs_are_old[patch] = false;
}

/// Lists the candidates by piece and node, without the nodes that have none.
void PieceContact::list_runs(const BodySurface& surface, std::size_t patch) {
    const std::vector<Partner>& partners = m_partners[patch];
    const auto nodes = surface.owned_nodes_of(patch);
    std::vector<Run>& runs = m_runs[patch];
    runs.clear();
    runs.reserve(nodes.size() * partners.size());
    const auto piece_of = [&](const Partner& p) {
        return surface.patches()[std::size_t(p.patch)].piece;
    };
    for (std::size_t begin = 0, end = 0; begin < partners.size(); begin = end) {
        while (end < partners.size() && piece_of(partners[end]) == piece_of(partners[begin])) ++end;
        for (std::size_t k = 0; k < nodes.size(); ++k)
            for (std::size_t n = begin; n < end; ++n) {
                const Partner& partner = partners[n];
                if (partner.starts.empty() || partner.starts[k] == partner.starts[k + 1]) continue;
                const Candidate* const all = partner.candidates.data();
                const Candidate* const first = all + partner.starts[k];
                runs.push_back({piece_of(partner), nodes[k], std::int32_t(n), first->distance,
                                first, all + partner.starts[k + 1]});
            }
    }
}

void PieceContact::search_patch(const BodySurface& surface, std::size_t patch, const Positions& x,
                                bool is_fast, std::vector<PieceTouch>& touches) const {
    const std::vector<Run>& runs = m_runs[patch];
    for (std::size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
        const Run& first = runs[begin];
        while (end < runs.size() && runs[end].node == first.node && runs[end].piece == first.piece)
            ++end;
        const auto n = std::size_t(first.node);
        search(surface, x,
               {first.node, norm(x[kEnd][n] - x[kStart][n]),
                std::span(runs).subspan(begin, end - begin), m_moved[patch]},
               is_fast, touches);
    }
}

/// The nearest point of a piece, within reach. Equal distances: the first triangle.
SurfacePoint PieceContact::nearest(const BodySurface& surface, std::span<const Vec3d> x,
                                   const Near& near, Time time) const {
    const Vec3d p = x[std::size_t(near.node)];
    SurfacePoint best;
    double distance = m_reach;
    best.distance2 = m_reach * m_reach;
    for (const Run& run : near.runs) {
        const Moved& moved = near.moved[std::size_t(run.partner)];
        const double limit = moved.before + (time == kEnd ? near.shift + moved.shift : 0);
        if (double(run.least) - limit > distance) continue;
        for (const Candidate* c = run.begin; c < run.end; ++c) {
            if (double(c->distance) - limit > distance) break;
            const auto& t = surface.triangles()[std::size_t(c->triangle)];
            const auto found = mesh::nearest_on_triangle(
                p, x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])]);
            const Vec3d d = p - found.position;
            const double distance2 = dot(d, d);
            if (distance2 > best.distance2 ||
                (distance2 == best.distance2 && best.triangle >= 0 && c->triangle > best.triangle))
                continue;
            best = {c->triangle, found.feature, found.position, distance2};
            distance = std::sqrt(distance2);
        }
    }
    return best;
}

/// Gradient of the signed distance.
Vec3d PieceContact::normal_at(const BodySurface& surface, std::span<const Vec3d> x,
                              std::int32_t node, const SurfacePoint& point, double side) const {
    const double distance = std::sqrt(point.distance2);
    if (distance > m_tiny) return (side / distance) * (x[std::size_t(node)] - point.position);
    return surface.normal(point.triangle, point.feature, x);
}

/// Touch of a node at its nearest point at a time.
PieceTouch PieceContact::touch_of(const BodySurface& surface, const Positions& x, const Near& near,
                                  const SurfacePoint& point, Time time, double side) const {
    const auto& t = surface.triangles()[std::size_t(point.triangle)];
    PieceTouch touch{near.node,
                     point.triangle,
                     normal_at(surface, x[time], near.node, point, side),
                     {},
                     limit_of(near.node, surface.piece_of(point.triangle)),
                     {}};
    touch.weights =
        mesh::weights_on_triangle(point.position, x[time][std::size_t(t[0])],
                                  x[time][std::size_t(t[1])], x[time][std::size_t(t[2])]);
    touch.apart = x[kStart][std::size_t(near.node)];
    for (std::size_t k = 0; k < 3; ++k)
        touch.apart = touch.apart - touch.weights[k] * x[kStart][std::size_t(t[k])];
    return touch;
}

/// Finds the touch of a node with a piece, if there is one.
void PieceContact::search(const BodySurface& surface, const Positions& x, const Near& near,
                          bool is_fast, std::vector<PieceTouch>& touches) const {
    const Vec3d p = x[kEnd][std::size_t(near.node)], by = p - x[kStart][std::size_t(near.node)];
    // C at the end, linear from the start on.
    const auto lacks = [&](const PieceTouch& touch) {
        const auto& t = surface.triangles()[std::size_t(touch.triangle)];
        Vec3d apart = p;
        for (std::size_t k = 0; k < 3; ++k)
            apart = apart - touch.weights[k] * x[kEnd][std::size_t(t[k])];
        return dot(apart, touch.normal) < touch.limit;
    };
    SurfacePoint now;
    double motion2 = 0;  // relative to the nearest triangle
    if (!is_fast) {
        now = nearest(surface, x[kEnd], near, kEnd);
        if (now.triangle < 0) return;
        for (const std::int32_t n : surface.triangles()[std::size_t(now.triangle)]) {
            const Vec3d d = by - (x[kEnd][std::size_t(n)] - x[kStart][std::size_t(n)]);
            motion2 = std::max(motion2, dot(d, d));
        }
        const double limit = limit_of(near.node, surface.piece_of(now.triangle)),
                     distance = std::sqrt(now.distance2);
        const bool is_slow = motion2 <= std::max(m_level * m_level, now.distance2);
        if (is_slow && distance + limit <= 0) return;  // C ≥ 0 on either side
        const double side = surface.side(p, now, x[kEnd]);
        const bool is_clear = side * distance >= limit;
        if (is_slow && is_clear) return;
        const PieceTouch touch = touch_of(surface, x, near, now, kEnd, side);
        const bool is_level = dot(touch.apart, touch.normal) >= touch.limit - m_level;
        if (is_slow && is_level) {
            if (lacks(touch)) touches.push_back(touch);
            return;
        }
        const SurfacePoint first = nearest(surface, x[kStart], near, kStart);
        if (first.triangle < 0) {
            if (!is_clear && lacks(touch)) touches.push_back(touch);
            return;
        }
        const PieceTouch before =
            touch_of(surface, x, near, first, kStart,
                     surface.side(x[kStart][std::size_t(near.node)], first, x[kStart]));
        const double cosine = dot(touch.normal, before.normal);
        if (cosine > kSameNormal || (cosine > kOtherSide && (is_clear || is_level)) ||
            !lacks(before)) {
            if (!is_clear && lacks(touch)) touches.push_back(touch);
        } else {
            touches.push_back(before);
        }
        return;
    }
    const SurfacePoint first = nearest(surface, x[kStart], near, kStart);
    if (first.triangle < 0) return;
    const PieceTouch before =
        touch_of(surface, x, near, first, kStart,
                 surface.side(x[kStart][std::size_t(near.node)], first, x[kStart]));
    if (lacks(before)) touches.push_back(before);
}

}  // namespace pliant::pbd
