// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/piece_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/triangle_distance.h"

namespace pliant::pbd {
namespace {

// In mean edges of the surface.
constexpr double kPieceReach = 1;       ///< penetrations up to this are found
constexpr double kPieceSlop = 1e-4;     ///< penetration without a force; above the error of floats
constexpr double kSameNormal = 0.7;     ///< least cosine
constexpr double kTinyDistance = 1e-6;  ///< nearer points have no direction of their own

}  // namespace

PieceContact::PieceContact(const BodySurface& surface, std::span<const Vec3d> rest, double gap)
    : m_gap(gap),
      m_reach(std::max(gap, kPieceReach * surface.mean_edge())),
      m_slop(kPieceSlop * surface.mean_edge()),
      m_tiny(kTinyDistance * surface.mean_edge()),
      m_near(surface.patches().size()) {
    const auto patches = surface.patches();
    std::vector<mesh::Bounds> boxes(patches.size());
    for (std::size_t p = 0; p < patches.size(); ++p)
        for (std::int32_t n = patches[p].nodes_begin; n < patches[p].nodes_end; ++n)
            boxes[p].add(rest[std::size_t(surface.patch_nodes()[std::size_t(n)])]);
    m_rest_starts.push_back(0);
    for (std::size_t n = 0; n < rest.size(); ++n) {
        const std::int32_t own = surface.pieces()[n];
        for (std::size_t begin = 0; begin < patches.size();) {
            const std::int32_t piece = patches[begin].piece;
            mesh::Bounds all;
            std::size_t end = begin;
            for (; end < patches.size() && patches[end].piece == piece; ++end) all.add(boxes[end]);
            if (own >= 0 && piece != own && !(all.distance_squared(rest[n]) > gap * gap)) {
                SurfacePoint best;
                best.distance2 = std::numeric_limits<double>::infinity();
                for (std::size_t p = begin; p < end; ++p)
                    if (boxes[p].distance_squared(rest[n]) < best.distance2)
                        surface.nearest_in_patch(p, rest[n], rest, best);
                const double found = surface.signed_distance(rest[n], best, rest);
                if (found < gap) m_rests.push_back({piece, found});
            }
            begin = end;
        }
        m_rest_starts.push_back(std::int32_t(m_rests.size()));
    }
    m_changed.reserve(patches.size());
    m_drifts.reserve(patches.size());
}

double PieceContact::limit_of(std::int32_t node, std::int32_t piece) const {
    for (auto r = std::size_t(m_rest_starts[std::size_t(node)]);
         r < std::size_t(m_rest_starts[std::size_t(node) + 1]); ++r)
        if (m_rests[r].piece == piece) return m_rests[r].gap - m_slop;
    return m_gap - m_slop;
}

void PieceContact::list(const BodySurface& surface, PatchBoxes& boxes) {
    m_drifts.assign(boxes.drifts().begin(), boxes.drifts().end());
    m_changed.clear();
    for (std::size_t p = 0; p < m_near.size(); ++p)
        if (boxes.changed()[p] != 0) m_changed.push_back(std::int32_t(p));
    if (m_changed.empty()) return;
    const auto patches = surface.patches();
    for (std::size_t a = 0; a < m_near.size(); ++a) {
        if (patches[a].owned_end == patches[a].nodes_begin) continue;
        Near& near = m_near[a];
        const mesh::Bounds reach = grown(boxes.box(a), m_reach);
        const auto is_near = [&](std::size_t b) {
            return patches[b].piece != patches[a].piece && overlap(reach, boxes.box(b));
        };
        bool has_changed = false;
        if (boxes.changed()[a] != 0) {
            has_changed = true;
            near.partners.clear();
            for (std::size_t b = 0; b < m_near.size(); ++b)
                if (is_near(b)) near.partners.push_back({std::int32_t(b), 0});
        } else {
            const std::size_t before = near.partners.size();
            has_changed = std::erase_if(near.partners, [&](const Partner& partner) {
                              return boxes.changed()[std::size_t(partner.patch)] != 0;
                          }) > 0;
            for (const std::int32_t b : m_changed)
                if (is_near(std::size_t(b))) near.partners.push_back({b, 0});
            has_changed |= near.partners.size() != before;
            if (has_changed)
                std::sort(near.partners.begin(), near.partners.end(),
                          [](const Partner& u, const Partner& v) { return u.patch < v.patch; });
        }
        if (has_changed) list_patch(surface, boxes, a);
    }
    boxes.clear_changed();
}

void PieceContact::list_patch(const BodySurface& surface, const PatchBoxes& boxes,
                              std::size_t patch) {
    Near& near = m_near[patch];
    near.pairs.clear();
    near.slack = -1;
    const Patch& own = surface.patches()[patch];
    const auto anchors = boxes.anchors();
    const double reach = m_reach + 2 * boxes.margin();
    for (std::int32_t k = own.nodes_begin; k < own.owned_end; ++k) {
        const std::int32_t n = surface.patch_nodes()[std::size_t(k)];
        if (surface.pieces()[std::size_t(n)] < 0) continue;
        const Vec3d p = anchors[std::size_t(n)];
        for (const Partner& partner : near.partners) {
            const auto b = std::size_t(partner.patch);
            if (boxes.box(b).distance_squared(p) > reach * reach) continue;
            for (std::int32_t t = surface.patches()[b].begin; t < surface.patches()[b].end; ++t) {
                mesh::Bounds box;
                for (const std::int32_t m : surface.triangles()[std::size_t(t)])
                    box.add(anchors[std::size_t(m)]);
                if (!(box.distance_squared(p) > reach * reach)) near.pairs.push_back({n, t});
            }
        }
    }
}

/// Whether nothing has moved enough for a touch.
bool PieceContact::is_quiet(const Near& near, const PatchBoxes& boxes, std::size_t patch) const {
    if (!(near.slack > 0)) return false;
    double most = 0;
    for (const Partner& partner : near.partners)
        most = std::max(most, boxes.drifts()[std::size_t(partner.patch)] - partner.drift);
    return boxes.drifts()[patch] - near.drift + most < near.slack;
}

void PieceContact::find(const BodySurface& surface, const PatchBoxes& boxes,
                        std::span<const Vec3d> start, std::span<const Vec3d> x,
                        std::vector<PieceTouch>& touches) {
    touches.clear();
    double most = 0;
    for (std::size_t n = 0; n < x.size(); ++n) {
        const Vec3d by = x[n] - start[n];
        most = std::max(most, dot(by, by));
    }
    const Moved moved{start, x, 2 * std::sqrt(most)};
    for (std::size_t patch = 0; patch < m_near.size(); ++patch) {
        Near& near = m_near[patch];
        if (near.pairs.empty() || is_quiet(near, boxes, patch)) continue;
        near.slack = std::numeric_limits<double>::infinity();
        near.drift = m_drifts[patch];
        for (Partner& partner : near.partners) partner.drift = m_drifts[std::size_t(partner.patch)];
        for (std::size_t begin = 0; begin < near.pairs.size();) {
            const std::int32_t node = near.pairs[begin].node,
                               piece = surface.piece_of(near.pairs[begin].triangle);
            std::size_t end = begin;
            while (end < near.pairs.size() && near.pairs[end].node == node &&
                   surface.piece_of(near.pairs[end].triangle) == piece)
                ++end;
            const double slack = search(surface, moved, node,
                                        std::span(near.pairs).subspan(begin, end - begin), touches);
            near.slack = std::min(near.slack, slack);
            begin = end;
        }
    }
}

SurfacePoint PieceContact::nearest(const BodySurface& surface, std::span<const Vec3d> x,
                                   std::int32_t node, std::span<const Pair> pairs) {
    const Vec3d p = x[std::size_t(node)];
    SurfacePoint best;
    best.distance2 = std::numeric_limits<double>::infinity();
    for (const Pair& pair : pairs) {
        const auto& t = surface.triangles()[std::size_t(pair.triangle)];
        const auto found = mesh::nearest_on_triangle(p, x[std::size_t(t[0])], x[std::size_t(t[1])],
                                                     x[std::size_t(t[2])]);
        const Vec3d d = p - found.place;
        if (dot(d, d) < best.distance2)
            best = {pair.triangle, found.feature, found.place, dot(d, d)};
    }
    return best;
}

/// Gradient of the signed distance. @param[out] side  1 outside, −1 inside
Vec3d PieceContact::normal_at(const BodySurface& surface, std::span<const Vec3d> x,
                              std::int32_t node, const SurfacePoint& point, double& side) const {
    const Vec3d out = surface.normal(point.triangle, point.feature, x),
                d = x[std::size_t(node)] - point.place;
    const double distance = std::sqrt(point.distance2);
    side = dot(d, out) < 0 ? -1 : 1;
    return distance > m_tiny ? (side / distance) * d : out;
}

/// Finds the touch of a node with a piece, if there is one. @returns C at the start
double PieceContact::search(const BodySurface& surface, const Moved& moved, std::int32_t node,
                            std::span<const Pair> pairs, std::vector<PieceTouch>& touches) const {
    const SurfacePoint first = nearest(surface, moved.start, node, pairs);
    const double distance = std::sqrt(first.distance2);
    if (distance > m_reach) return distance - m_reach;
    const double limit = limit_of(node, surface.piece_of(first.triangle));
    if (-distance - limit > moved.most) return -distance - limit;  // on either side
    double side = 0;
    const Vec3d normal = normal_at(surface, moved.start, node, first, side);
    const double c = side * distance - limit;
    if (c >= moved.most) return c;
    const auto add = [&](const SurfacePoint& point, std::span<const Vec3d> x, Vec3d along) {
        const auto& t = surface.triangles()[std::size_t(point.triangle)];
        PieceTouch touch{node, point.triangle, along, {}, limit};
        touch.weights = mesh::weights_on_triangle(point.place, x[std::size_t(t[0])],
                                                  x[std::size_t(t[1])], x[std::size_t(t[2])]);
        Vec3d apart = moved.x[std::size_t(node)];
        for (std::size_t k = 0; k < 3; ++k)
            apart = apart - touch.weights[k] * moved.x[std::size_t(t[k])];
        if (dot(apart, along) < limit) touches.push_back(touch);
    };
    if (moved.most < 0.5 * m_reach) {  // otherwise the pairs may lack the nearest triangle
        const SurfacePoint now = nearest(surface, moved.x, node, pairs);
        const Vec3d along = normal_at(surface, moved.x, node, now, side);
        if (dot(along, normal) > kSameNormal) {
            add(now, moved.x, along);
            return c;
        }
    }
    add(first, moved.start, normal);
    return c;
}

}  // namespace pliant::pbd
