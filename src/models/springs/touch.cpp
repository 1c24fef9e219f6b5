// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/touch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mesh/box_tree.h"
#include "mesh/triangle_distance.h"

namespace pliant {
namespace {

constexpr std::size_t kPatchTriangles = 32;
/// Distance between a tool and touched triangles, as a fraction of the mean edge.
constexpr double kGapShare = 1e-4;
constexpr int kRounds = 48;          ///< of pushing triangles out of a tool's way
constexpr int kNormalRounds = 16;    ///< of these, along their normals
constexpr double kEdgeSlack = 1e-6;  ///< barycentric: a crossing at an edge is one of both sides

/// A cubic by its coefficients.
struct Cubic {
    double c[4];
    double at(double t) const { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); }
};

/// Times that divide [0, 1] into parts on which a cubic is monotonic. @returns their number
int monotonic_parts(const Cubic& f, double (&times)[4]) {
    const double a = 3 * f.c[3], b = 2 * f.c[2], c = f.c[1];
    double roots[2];
    int count = 0;
    const double discriminant = b * b - 4 * a * c;
    if (discriminant > 0) {
        const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
        if (a != 0) roots[count++] = q / a;
        if (q != 0) roots[count++] = c / q;
        if (count == 2 && roots[0] > roots[1]) std::swap(roots[0], roots[1]);
    }
    int end = 0;
    times[end++] = 0;
    for (int n = 0; n < count; ++n)
        if (roots[n] > times[end - 1] && roots[n] < 1) times[end++] = roots[n];
    times[end++] = 1;
    return end;
}

mesh::Bounds grown(mesh::Bounds box, double by) {
    box.low = box.low - Vec3d{by, by, by};
    box.high = box.high + Vec3d{by, by, by};
    return box;
}

bool overlap(const mesh::Bounds& a, const mesh::Bounds& b) {
    for (int c = 0; c < 3; ++c)
        if (a.low[c] > b.high[c] || b.low[c] > a.high[c]) return false;
    return true;
}

Vec3d normal_of(const std::array<Vec3d, 3>& x) {
    const Vec3d n = cross(x[1] - x[0], x[2] - x[0]);
    const double length = norm(n);
    return length > 0 ? (1 / length) * n : Vec3d{0, 0, 0};
}

/// Way from a triangle's nearest point to a tool's centre on its outer side.
struct Approach {
    double distance;
    Vec3d normal;  ///< unit
};
Approach approach(Vec3d p, const std::array<Vec3d, 3>& x, double tiny) {
    const Vec3d away = p - mesh::nearest_on_triangle(p, x[0], x[1], x[2]).position;
    const double distance = norm(away);
    return {distance, distance > tiny ? (1 / distance) * away : normal_of(x)};
}

}  // namespace

std::optional<Crossing> find_crossing(Vec3d from, Vec3d to, const std::array<Vec3d, 3>& at_begin,
                                      const std::array<Vec3d, 3>& at_end) {
    // f(t) = (x1 − x0) × (x2 − x0) · (p − x0), positive on the outer side.
    const Vec3d a = at_begin[1] - at_begin[0], b = at_begin[2] - at_begin[0],
                w = from - at_begin[0];
    const Vec3d da = (at_end[1] - at_end[0]) - a, db = (at_end[2] - at_end[0]) - b,
                dw = (to - at_end[0]) - w;
    const Vec3d n0 = cross(a, b), n1 = cross(a, db) + cross(da, b), n2 = cross(da, db);
    const Cubic f{{dot(n0, w), dot(n1, w) + dot(n0, dw), dot(n2, w) + dot(n1, dw), dot(n2, dw)}};
    double times[4];
    const int count = monotonic_parts(f, times);
    for (int n = 0; n + 1 < count; ++n) {
        double low = times[n], high = times[n + 1];
        if (!(f.at(low) > 0 && f.at(high) <= 0)) continue;
        for (int k = 0; k < 60 && high - low > 1e-15; ++k) {
            const double middle = 0.5 * (low + high);
            (f.at(middle) > 0 ? low : high) = middle;
        }
        std::array<Vec3d, 3> x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = at_begin[k] + high * (at_end[k] - at_begin[k]);
        const auto weights = mesh::weights_on_triangle(from + high * (to - from), x[0], x[1], x[2]);
        if (weights[0] >= -kEdgeSlack && weights[1] >= -kEdgeSlack && weights[2] >= -kEdgeSlack)
            return Crossing{high, weights};
    }
    return {};
}

TriangleTouch::TriangleTouch(const SpringNetwork& network,
                             std::vector<std::array<std::int32_t, 3>> triangles)
    : m_triangles(std::move(triangles)) {
    m_order.resize(m_triangles.size());
    std::iota(m_order.begin(), m_order.end(), 0);
    split(network, m_order);
    const auto nodes = network.nodes();
    for (const auto& t : m_triangles) {
        bool has_fixed = false;
        for (std::size_t k = 0; k < 3; ++k) {
            m_nodes.push_back(t[k]);
            has_fixed |= nodes[std::size_t(t[k])].fixed;
            m_mean_edge +=
                norm(nodes[std::size_t(t[k])].rest - nodes[std::size_t(t[(k + 1) % 3])].rest);
        }
        m_has_fixed.push_back(has_fixed);
    }
    for (const SpringNode& node : nodes) m_is_fixed.push_back(node.fixed);
    m_mean_edge /= 3.0 * double(m_triangles.size());
    m_gap = kGapShare * m_mean_edge;
    std::sort(m_nodes.begin(), m_nodes.end());
    m_nodes.erase(std::unique(m_nodes.begin(), m_nodes.end()), m_nodes.end());
    m_before.resize(nodes.size());
    for (std::size_t n = 0; n < nodes.size(); ++n) m_before[n] = nodes[n].rest;
    m_after = m_before;
    m_shifts.assign(nodes.size(), {0, 0, 0});
    m_shift_counts.assign(nodes.size(), 0);
    m_near.reserve(m_triangles.size());
    m_followed.reserve(m_triangles.size());
    m_touched_nodes.reserve(m_nodes.size());
}

/// Divides triangles into patches by halving along their longest extent.
void TriangleTouch::split(const SpringNetwork& network, std::span<std::int32_t> triangles) {
    if (triangles.size() <= kPatchTriangles) {
        const std::int32_t begin = m_patches.empty() ? 0 : m_patches.back().end;
        const auto first = m_patch_nodes.size();
        for (const std::int32_t t : triangles)
            m_patch_nodes.insert(m_patch_nodes.end(), m_triangles[std::size_t(t)].begin(),
                                 m_triangles[std::size_t(t)].end());
        const auto nodes = m_patch_nodes.begin() + std::ptrdiff_t(first);
        std::sort(nodes, m_patch_nodes.end());
        m_patch_nodes.erase(std::unique(nodes, m_patch_nodes.end()), m_patch_nodes.end());
        m_patches.push_back({begin, begin + std::int32_t(triangles.size()), std::int32_t(first),
                             std::int32_t(m_patch_nodes.size())});
        return;
    }
    const auto centre = [&](std::int32_t f) {
        Vec3d sum{0, 0, 0};
        for (const std::int32_t n : m_triangles[std::size_t(f)])
            sum = sum + network.nodes()[std::size_t(n)].rest;
        return sum;
    };
    const std::size_t middle = mesh::halve(triangles, centre);
    split(network, triangles.first(middle));
    split(network, triangles.subspan(middle));
}

std::array<Vec3d, 3> TriangleTouch::corners(std::span<const Vec3d> x, std::int32_t triangle) const {
    const auto& t = m_triangles[std::size_t(triangle)];
    return {x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])]};
}

void TriangleTouch::nodes_of(const TouchTool& tool, std::vector<std::int32_t>& nodes) const {
    nodes.clear();
    for (const std::int32_t t : tool.triangles)
        nodes.insert(nodes.end(), m_triangles[std::size_t(t)].begin(),
                     m_triangles[std::size_t(t)].end());
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    std::erase_if(nodes, [&](std::int32_t n) { return m_is_fixed[std::size_t(n)] != 0; });
}

void TriangleTouch::look(const SpringTissue& tissue) {
    for (const std::int32_t n : m_nodes)
        m_before[std::size_t(n)] = m_after[std::size_t(n)] = tissue.position(n);
}

void TriangleTouch::look_again(const SpringTissue& tissue) {
    for (const std::int32_t n : m_nodes) {
        m_before[std::size_t(n)] = m_after[std::size_t(n)];
        m_after[std::size_t(n)] = tissue.position(n);
    }
}

/// Finds the triangles whose way comes near a box. @param[out] m_near  ascending
void TriangleTouch::find_near(const mesh::Bounds& around, double margin) {
    m_near.clear();
    m_margin = margin;
    const mesh::Bounds box = grown(around, margin);
    const auto add = [&](std::int32_t n, mesh::Bounds& to) {
        to.add(m_before[std::size_t(n)]);
        to.add(m_after[std::size_t(n)]);
    };
    for (const Patch& patch : m_patches) {
        mesh::Bounds whole;
        for (std::int32_t k = patch.nodes_begin; k < patch.nodes_end; ++k)
            add(m_patch_nodes[std::size_t(k)], whole);
        if (!overlap(whole, box)) continue;
        for (std::int32_t k = patch.begin; k < patch.end; ++k) {
            const std::int32_t t = m_order[std::size_t(k)];
            mesh::Bounds own;
            for (const std::int32_t n : m_triangles[std::size_t(t)]) add(n, own);
            if (overlap(own, box)) m_near.push_back(t);
        }
    }
    std::sort(m_near.begin(), m_near.end());
}

/// Translates a triangle, which is then in contact.
void TriangleTouch::shift(TouchTool& tool, std::int32_t triangle, Vec3d by) {
    for (const std::int32_t n : m_triangles[std::size_t(triangle)])
        m_after[std::size_t(n)] = m_after[std::size_t(n)] + by;
    m_margin -= norm(by);
    const auto at = std::lower_bound(tool.triangles.begin(), tool.triangles.end(), triangle);
    if (at == tool.triangles.end() || *at != triangle) tool.triangles.insert(at, triangle);
}

bool TriangleTouch::is_at(const TouchTool& tool, std::int32_t triangle,
                          std::span<const Vec3d> x) const {
    return approach(tool.position, corners(x, triangle), 0).distance <= tool.radius + 2 * m_gap;
}

/// Lets touched triangles follow a tool along their normals, inwards with it, outwards as far as
/// they press on it. Those that don't, or that the tool has left, are released.
void TriangleTouch::follow(TouchTool& tool, Vec3d way, SpringTissue& tissue) {
    m_touched_nodes.clear();
    std::erase_if(tool.triangles, [&](std::int32_t t) {
        if (m_has_fixed[std::size_t(t)] || !is_at(tool, t, m_before)) return true;
        const Approach a = approach(tool.position, corners(m_before, t), 1e-3 * m_gap);
        const auto reaction = tissue.reaction(m_triangles[std::size_t(t)], ReactionLaw::Held);
        if (!reaction.ok()) return true;
        const double force = dot(reaction->force, a.normal);
        if (!(force > 0)) return true;
        double along = dot(way, a.normal);
        if (along > 0) {
            const double softening = -dot(a.normal, reaction->stiffness * a.normal);
            if (softening > 0) along = std::min(along, force / softening);
        }
        for (const std::int32_t n : m_triangles[std::size_t(t)]) {
            if (m_shift_counts[std::size_t(n)]++ == 0) m_touched_nodes.push_back(n);
            m_shifts[std::size_t(n)] = m_shifts[std::size_t(n)] + along * a.normal;
        }
        return false;
    });
    for (const std::int32_t n : m_touched_nodes) {
        m_after[std::size_t(n)] = m_after[std::size_t(n)] +
                                  (1.0 / m_shift_counts[std::size_t(n)]) * m_shifts[std::size_t(n)];
        m_shifts[std::size_t(n)] = {0, 0, 0};
        m_shift_counts[std::size_t(n)] = 0;
    }
}

/// The triangle in m_near that a centre crosses first; −1: none.
std::int32_t TriangleTouch::first_crossed(Vec3d from, Vec3d to, Crossing& crossing) {
    std::int32_t first = -1;
    for (const std::int32_t t : m_near) {
        const auto found = find_crossing(from, to, corners(m_before, t), corners(m_after, t));
        if (!found || (first >= 0 && found->time >= crossing.time)) continue;
        first = t;
        crossing = *found;
    }
    return first;
}

/// Translates a crossed triangle by the depth of the tool behind it.
/// @param along_normal  false: by the way of the crossed point to the tool
/// @returns false if it has a fixed node
bool TriangleTouch::push_out_of_way(TouchTool& tool, std::int32_t triangle,
                                    const Crossing& crossing, bool along_normal) {
    if (m_has_fixed[std::size_t(triangle)]) return false;
    const auto x = corners(m_after, triangle);
    const Vec3d normal = normal_of(x);
    const double clear = tool.radius + m_gap;
    const double depth = clear - dot(tool.position - x[0], normal);
    if (along_normal && depth > 0) {
        shift(tool, triangle, -depth * normal);
        return true;
    }
    Vec3d crossed{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) crossed = crossed + crossing.weights[k] * x[k];
    shift(tool, triangle, tool.position - clear * normal - crossed);
    return true;
}

/// Translates triangles out of a tool whose centre is on their outer side.
/// @param[out] has_pushed  set if one was in it
TriangleTouch::Blocked TriangleTouch::push_out_of_sphere(TouchTool& tool, Vec3d from,
                                                         bool& has_pushed) {
    const double clear = tool.radius + m_gap, tiny = 1e-3 * m_gap;
    for (const std::int32_t t : m_near) {
        const Approach a = approach(tool.position, corners(m_after, t), tiny);
        if (a.distance >= clear - 0.5 * m_gap) continue;
        if (m_has_fixed[std::size_t(t)]) {
            // A tool that is too near already may leave.
            if (a.distance < approach(from, corners(m_before, t), tiny).distance)
                return Blocked::Yes;
            continue;
        }
        shift(tool, t, -(clear - a.distance) * a.normal);
        has_pushed = true;
    }
    return Blocked::No;
}

/// Moves triangles out of the way of a tool that came from a position.
/// @returns false if one can't be moved, or they get into each other's way
bool TriangleTouch::clear(TouchTool& tool, Vec3d from) {
    mesh::Bounds around;
    around.add(from);
    around.add(tool.position);
    around = grown(around, tool.radius + 2 * m_gap);
    m_margin = -1;
    Crossing crossing{};
    for (int round = 0; round < kRounds; ++round) {
        if (m_margin < 0) find_near(around, 0.5 * m_mean_edge);
        if (const std::int32_t t = first_crossed(from, tool.position, crossing); t >= 0) {
            if (!push_out_of_way(tool, t, crossing, round < kNormalRounds)) return false;
            continue;
        }
        bool has_pushed = false;
        if (push_out_of_sphere(tool, from, has_pushed) == Blocked::Yes) return false;
        if (!has_pushed) return true;
    }
    find_near(around, 0);
    return first_crossed(from, tool.position, crossing) < 0;
}

bool TriangleTouch::move(TouchTool& tool, Vec3d way, SpringTissue& tissue) {
    const Vec3d from = tool.position;
    follow(tool, way, tissue);
    m_followed = tool.triangles;
    tool.position = from + way;
    if (clear(tool, from)) return true;
    tool.position = from;
    tool.triangles = m_followed;
    take_back();
    return false;
}

void TriangleTouch::take_back() {
    for (const std::int32_t n : m_nodes) m_after[std::size_t(n)] = m_before[std::size_t(n)];
}

void TriangleTouch::keep_clear(TouchTool& tool) {
    std::erase_if(tool.triangles, [&](std::int32_t t) { return !is_at(tool, t, m_after); });
    if (clear(tool, tool.position)) return;
    // Triangles that go back to their positions before the step can't cross the tool. One more goes
    // back in each round.
    mesh::Bounds around;
    around.add(tool.position);
    around = grown(around, m_gap);
    for (;;) {
        find_near(around, 0);
        Crossing crossing{};
        const std::int32_t t = first_crossed(tool.position, tool.position, crossing);
        if (t < 0) return;
        for (const std::int32_t n : m_triangles[std::size_t(t)])
            m_after[std::size_t(n)] = m_before[std::size_t(n)];
        shift(tool, t, {0, 0, 0});
    }
}

double TriangleTouch::clearance(const TouchTool& tool, double within) {
    mesh::Bounds around;
    around.add(tool.position);
    find_near(grown(around, tool.radius), within);
    double least = std::numeric_limits<double>::infinity();
    for (const std::int32_t t : m_near)
        least = std::min(least, approach(tool.position, corners(m_after, t), 0).distance);
    least -= tool.radius;
    return least <= within ? least : std::numeric_limits<double>::infinity();
}

}  // namespace pliant
