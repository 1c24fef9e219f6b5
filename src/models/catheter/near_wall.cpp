// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "catheter/near_wall.h"

#include <algorithm>
#include <cmath>

#include "pbd/segment_triangle.h"

namespace pliant::catheter {
namespace {

using pbd::GhostSurface;

/// Contacts of one node or segment are distinct if the cosine of their normals is below this.
constexpr double kAlike = 0.95;
constexpr std::size_t kMaxOfOne = 4;
/// Sample points of a segment for the depth.
constexpr int kPositions = 3;

std::array<Vec3d, 3> corners_of(const GhostSurface& ghost, std::int32_t triangle) {
    const auto& t = ghost.triangles()[std::size_t(triangle)];
    return {ghost.positions()[std::size_t(t[0])], ghost.positions()[std::size_t(t[1])],
            ghost.positions()[std::size_t(t[2])]};
}

/// Rejection test by the bounding sphere of the triangle.
bool is_out_of_reach(Vec3d a, Vec3d b, const std::array<Vec3d, 3>& p, double reach) {
    const Vec3d middle = (1.0 / 3) * (p[0] + p[1] + p[2]), u = b - a;
    double ball2 = 0;
    for (const Vec3d& corner : p) ball2 = std::max(ball2, dot(corner - middle, corner - middle));
    const double t = std::clamp(dot(middle - a, u) / std::max(1e-12, dot(u, u)), 0.0, 1.0);
    return norm(middle - (a + t * u)) > reach + std::sqrt(ball2);
}

}  // namespace

SegmentOutside outside_of(const Wire& wire, std::int32_t segment) {
    const auto s = std::size_t(segment);
    const bool is_first = segment == wire.first();
    const double along = is_first ? wire.guide_end() : 0;
    const auto &x = wire.positions(), &before = wire.positions_before();
    return {segment,  is_first,
            along,    (1 - along) * x[s] + along * x[s + 1],
            x[s + 1], {before[s], before[s + 1]}};
}

void NearWall::look(Vec3d a, Vec3d b, double moves, const WallContactSettings& settings,
                    const GhostSurface& ghost) {
    const double reach = settings.radius_mm + settings.skin_mm + kLook + moves;
    Vec3d low, high;
    for (int c = 0; c < 3; ++c) {
        low[c] = std::min(a[c], b[c]) - reach;
        high[c] = std::max(a[c], b[c]) + reach;
    }
    ghost.near(low, high, m_triangles);
    m_pairs.clear();
    double least = 1e300;
    Vec3d off{0, 0, 0};
    std::int32_t nearest = 0;
    int feature = 0;
    for (const std::int32_t t : m_triangles) {
        const auto p = corners_of(ghost, t);
        bool apart = false;
        for (int c = 0; c < 3; ++c)
            apart |= std::max({p[0][c], p[1][c], p[2][c]}) < low[c] ||
                     std::min({p[0][c], p[1][c], p[2][c]}) > high[c];
        if (apart || is_out_of_reach(a, b, p, reach)) continue;
        const auto near = pbd::nearest_pair(a, b, p[0], p[1], p[2]);
        const Vec3d d = near.on_segment - near.on_triangle;
        const double distance = norm(d);
        m_pairs.push_back({t, distance});
        if (!(distance < least)) continue;
        least = distance;
        off = d;
        nearest = t;
        feature = near.feature;
    }
    std::sort(m_pairs.begin(), m_pairs.end(), [](const Pair& p, const Pair& q) {
        return p.distance != q.distance ? p.distance < q.distance : p.triangle < q.triangle;
    });
    // A wire that has penetrated the wall searches all triangles to find its way back.
    m_is_beyond = !m_pairs.empty() && !(least > 0.5 * settings.radius_mm &&
                                        dot(off, ghost.normal(nearest, feature)) >= 0);
}

bool NearWall::is_nearest(Vec3d on_wire, double distance, const GhostSurface& ghost) const {
    return std::all_of(m_pairs.begin(), m_pairs.end(), [&](const Pair& other) {
        const auto p = corners_of(ghost, other.triangle);
        return norm(on_wire - mesh::nearest_on_triangle(on_wire, p[0], p[1], p[2]).position) >=
               distance - 1e-9;
    });
}

/// Whether the spot is the first at its corner or edge: adjacent triangles find the same point.
bool NearWall::is_new(const Spot& spot, const GhostSurface& ghost) {
    if (spot.feature == 6) return true;
    const auto& t = ghost.triangles()[std::size_t(spot.triangle)];
    const auto k = std::size_t(spot.feature % 3);
    std::array<std::int32_t, 2> at{t[k], t[k]};
    if (spot.feature >= 3) at[1] = t[(k + 1) % 3];
    if (at[0] > at[1]) std::swap(at[0], at[1]);
    if (std::find(m_features.begin(), m_features.end(), at) != m_features.end()) return false;
    m_features.push_back(at);
    return true;
}

void NearWall::consider(const SegmentOutside& segment, const Spot& spot,
                        const WallContactSettings& settings, const GhostSurface& ghost) {
    const Vec3d d = spot.on_wire - spot.on_wall;
    const double distance = norm(d);
    // A point farther away is a candidate only for a segment beyond the wall.
    const double most = settings.radius_mm + settings.skin_mm + (m_is_beyond ? kLook : kOpen);
    if (distance > most || !is_new(spot, ghost)) return;
    const Vec3d out = ghost.normal(spot.triangle, spot.feature);
    double height = distance;
    if (out != Vec3d{0, 0, 0} && dot(d, out) < 0) height = -distance;
    // Beyond a ridge, triangles are seen from behind; only the nearest one determines the side.
    if (height < 0 && !is_nearest(spot.on_wire, distance, ghost)) return;
    if (!(distance > 1e-9) && out == Vec3d{0, 0, 0}) return;
    Found f;
    f.gap = height - settings.radius_mm - settings.skin_mm;
    if (f.gap > kOpen) return;
    // The connecting direction is accurate unless the distance is tiny.
    const Vec3d normal = distance > 1e-3 || out == Vec3d{0, 0, 0} ? (1 / height) * d : out;
    f.position = spot.on_wall;
    f.triangle = spot.triangle;
    WireContact& c = f.contact;
    c.segment = segment.number;
    c.along = spot.along;
    c.normal = normal;
    c.lever = -settings.radius_mm * normal;
    c.least = dot(normal, spot.on_wall) + settings.radius_mm + settings.skin_mm;
    c.friction = settings.friction;
    c.sticks = (1 - spot.along) * segment.before[0] + spot.along * segment.before[1];
    m_found.push_back(f);
}

/// Keeps a few of the spots from here on: the deepest first, then others with distinct normals.
void NearWall::keep_some(std::size_t from) {
    const auto begin = m_found.begin() + std::ptrdiff_t(from);
    std::sort(begin, m_found.end(), [](const Found& a, const Found& b) {
        return a.gap != b.gap ? a.gap < b.gap : a.triangle < b.triangle;
    });
    std::size_t kept = from;
    for (std::size_t n = from; n < m_found.size() && kept < from + kMaxOfOne; ++n) {
        bool is_new = true;
        for (std::size_t k = from; k < kept; ++k)
            is_new &= dot(m_found[k].contact.normal, m_found[n].contact.normal) < kAlike;
        if (is_new) m_found[kept++] = m_found[n];
    }
    m_found.resize(std::min(kept, m_found.size()));
}

void NearWall::find(const SegmentOutside& segment, double nearer,
                    const WallContactSettings& settings, const GhostSurface& ghost) {
    m_found.clear();
    const double most = settings.radius_mm + settings.skin_mm + kOpen + nearer;
    m_triangles.clear();
    for (const Pair& pair : m_pairs) {
        if (!m_is_beyond && pair.distance > most) break;
        m_triangles.push_back(pair.triangle);
    }
    std::sort(m_triangles.begin(), m_triangles.end());
    // The segment's second node and its interior; its first node belongs to the previous segment.
    m_features.clear();
    for (const std::int32_t t : m_triangles) {
        const auto p = corners_of(ghost, t);
        const auto nearest = mesh::nearest_on_triangle(segment.end, p[0], p[1], p[2]);
        consider(segment, {1, segment.end, nearest.position, t, nearest.feature}, settings, ghost);
    }
    keep_some(0);
    const std::size_t from = m_found.size();
    m_features.clear();
    for (const std::int32_t t : m_triangles) {
        const auto p = corners_of(ghost, t);
        const auto near = pbd::nearest_pair(segment.begin, segment.end, p[0], p[1], p[2]);
        if ((near.along > 0.02 || segment.is_first) && near.along < 0.98)
            consider(segment,
                     {segment.along + (1 - segment.along) * near.along, near.on_segment,
                      near.on_triangle, t, near.feature},
                     settings, ghost);
    }
    keep_some(from);
}

double NearWall::depth(const SegmentOutside& segment, double nearer, double radius_mm,
                       const GhostSurface& ghost) const {
    double most = -kLook;
    if (m_pairs.empty()) return most;
    for (int k = segment.is_first ? 0 : 1; k <= kPositions; ++k) {
        const double along = double(k) / kPositions;
        const Vec3d p = (1 - along) * segment.begin + along * segment.end;
        // The nearest triangle determines the side.
        double least = 1e300;
        std::int32_t triangle = 0;
        mesh::NearestOnTriangle nearest{};
        for (const Pair& pair : m_pairs) {
            if (!(pair.distance - nearer < least)) break;
            const auto c = corners_of(ghost, pair.triangle);
            const auto found = mesh::nearest_on_triangle(p, c[0], c[1], c[2]);
            const double distance = norm(p - found.position);
            if (!(distance < least)) continue;
            least = distance;
            triangle = pair.triangle;
            nearest = found;
        }
        const bool beyond = dot(p - nearest.position, ghost.normal(triangle, nearest.feature)) < 0;
        most = std::max(most, radius_mm - (beyond ? -least : least));
    }
    return most;
}

}  // namespace pliant::catheter
