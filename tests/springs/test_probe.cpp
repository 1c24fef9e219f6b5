// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of a tool with the triangles of a network, compared with brute force over all triangles.
// Covers: springs/touch.cpp.

#include <gtest/gtest.h>
#include <pliant/research/spring_probe.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <queue>
#include <set>

#include "springs/touch.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

struct Surface {
    std::vector<Vec3d> nodes;
    Triangles triangles;
};

/// An octahedron whose triangles are divided n times, on a sphere. Outward.
Surface ball(double radius, int divisions) {
    Surface s{
        {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
    for (int d = 0; d < divisions; ++d) {
        std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
        const auto middle = [&](std::int32_t a, std::int32_t b) {
            const auto [at, is_new] =
                middles.try_emplace({std::min(a, b), std::max(a, b)}, std::int32_t(s.nodes.size()));
            if (is_new)
                s.nodes.push_back(normalized(s.nodes[std::size_t(a)] + s.nodes[std::size_t(b)]));
            return at->second;
        };
        Triangles finer;
        for (const auto& [a, b, c] : s.triangles) {
            const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        s.triangles = std::move(finer);
    }
    for (Vec3d& node : s.nodes) node = radius * node;
    return s;
}

/// Links along the edges, and one of each node to a fixed node at its rest position.
SpringParts parts_of(const Surface& s, double home = 0.3) {
    auto parts = springs_of_triangles(s.nodes, s.triangles, {.stiffness = 1, .node_damping = 2});
    const auto count = std::int32_t(s.nodes.size());
    for (std::int32_t n = 0; n < count; ++n) {
        parts->nodes.push_back({.rest = s.nodes[std::size_t(n)], .fixed = true});
        parts->links.push_back({.a = n, .b = count + n, .stiffness = home, .rest_length = 0});
    }
    return std::move(*parts);
}

/// @param time_step  a fraction of the bound at rest: spikes drawn by a fast tool return fast
SpringTissue tissue_of(SpringParts parts, std::int32_t depth = 6, double time_step = 0.25) {
    auto made = SpringTissue::create(*SpringNetwork::create(std::move(parts)),
                                     {.depth = depth, .time_step = time_step});
    return std::move(*made);
}

/// By the solid angles of all triangles, with the cosine rule on their sides.
double brute_winding(const SpringTissue& tissue, const Triangles& triangles, Vec3d p) {
    double sum = 0;
    for (const auto& t : triangles) {
        Vec3d d[3];
        for (std::size_t k = 0; k < 3; ++k) d[k] = normalized(tissue.position(t[k]) - p);
        // L'Huilier's theorem.
        double side[3];
        for (int k = 0; k < 3; ++k) {
            const Vec3d a = d[(k + 1) % 3], b = d[(k + 2) % 3];
            side[k] = 2 * std::asin(std::min(1.0, 0.5 * norm(a - b)));
        }
        const double half = 0.5 * (side[0] + side[1] + side[2]);
        const double product = std::tan(0.5 * half) * std::tan(0.5 * (half - side[0])) *
                               std::tan(0.5 * (half - side[1])) * std::tan(0.5 * (half - side[2]));
        const double angle = 4 * std::atan(std::sqrt(std::max(0.0, product)));
        sum += dot(d[0], cross(d[1], d[2])) > 0 ? angle : -angle;
    }
    return sum / (4 * std::numbers::pi);
}

/// Distance of a point from a triangle by nested search: independent of its regions.
double brute_distance(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    const auto along_edge = [&](Vec3d u, Vec3d v) {
        const Vec3d e = v - u;
        return norm(p - u - std::clamp(dot(p - u, e) / dot(e, e), 0.0, 1.0) * e);
    };
    double least = std::min({along_edge(a, b), along_edge(b, c), along_edge(c, a)});
    const Vec3d n = cross(b - a, c - a);
    const Vec3d q = p - (dot(p - a, n) / dot(n, n)) * n;
    if (dot(cross(b - a, q - a), n) >= 0 && dot(cross(c - b, q - b), n) >= 0 &&
        dot(cross(a - c, q - c), n) >= 0)
        least = std::min(least, norm(p - q));
    return least;
}

double brute_clearance(const SpringTissue& tissue, const Triangles& triangles, Vec3d p) {
    double least = 1e300;
    for (const auto& t : triangles)
        least = std::min(least, brute_distance(p, tissue.position(t[0]), tissue.position(t[1]),
                                               tissue.position(t[2])));
    return least;
}

const TaskArena arena{1};

// A closed surface around a point where a tool's point may never be: fast tools, slow tools, tools
// at rest while tissue returns.
TEST(Probe, ATipIsNeverInsideWhateverItsSpeedAndDirection) {
    const Surface s = ball(50, 3);  // 258 nodes, edges of about 12
    for (const unsigned seed : {1u, 2u, 3u}) {
        Random random(seed);
        SpringTissue tissue = tissue_of(parts_of(s), 6, 0.02);
        auto probe = SpringProbe::create(tissue.network(), s.triangles);
        ASSERT_TRUE(probe.ok()) << probe.error().message;
        Vec3d at = 80.0 * normalized(random.vector(1));
        ASSERT_TRUE(probe->place(tissue, at).ok());
        int touched = 0, free = 0, left = 0;
        for (int n = 0; n < 300; ++n) {
            const double length = random.ratio(0.1, 40);
            // Mostly into the ball, from anywhere.
            Vec3d way = random.vector(1) - (random.whole(0, 3) > 0 ? 1.0 / norm(at) : 0) * at;
            Vec3d to = at + (length / norm(way)) * way;
            if (norm(to) > 90) to = (90 / norm(to)) * to;
            const auto moved = probe->move(tissue, to, random.whole(1, 60), arena);
            ASSERT_TRUE(moved.ok()) << moved.error().message << " seed " << seed << " move " << n;
            at = moved->position;
            EXPECT_EQ(at, to);
            EXPECT_EQ(moved->way_share, 1);
            const double winding = brute_winding(tissue, s.triangles, at);
            ASSERT_LT(winding, 0.5) << "seed " << seed << " move " << n;
            (probe->triangles().empty() ? free : touched)++;
            const double clearance = brute_clearance(tissue, s.triangles, at);
            EXPECT_NEAR(probe->clearance(tissue, 500), clearance, 1e-9);
            // In contact, the tip is on a triangle, unless others have just drawn that away.
            left += !probe->triangles().empty() && clearance > 0.01;
        }
        EXPECT_LE(left, touched / 20) << seed;
        EXPECT_GT(touched, 100) << seed;
        EXPECT_GT(free, 10) << seed;
    }
}

TEST(Probe, ASphereStaysOutsideAndItsOverlapIsSmall) {
    const Surface s = ball(50, 3);
    Random random(7);
    SpringTissue tissue = tissue_of(parts_of(s), 6, 0.02);
    auto probe = SpringProbe::create(tissue.network(), s.triangles, {.radius = 9});
    ASSERT_TRUE(probe.ok());
    Vec3d at{0, 0, 75};
    ASSERT_TRUE(probe->place(tissue, at).ok());
    std::size_t most = 0;
    for (int n = 0; n < 200; ++n) {
        const Vec3d way = random.vector(1) - 0.7 / norm(at) * at;
        Vec3d to = at + (random.ratio(0.1, 20) / norm(way)) * way;
        if (norm(to) < 30) to = (30 / norm(to)) * to;
        const auto moved = probe->move(tissue, to, 30, arena);
        ASSERT_TRUE(moved.ok()) << moved.error().message;
        at = moved->position;
        ASSERT_LT(brute_winding(tissue, s.triangles, at), 0.5) << n;
        EXPECT_GT(brute_clearance(tissue, s.triangles, at), 9 - 0.01) << n;
        most = std::max(most, probe->triangles().size());
    }
    EXPECT_GT(most, 4u);
}

TEST(Probe, ACrossedTriangleIsTheOneThatBruteForceFinds) {
    Random random(5);
    int crossed = 0;
    for (int n = 0; n < 20000; ++n) {
        std::array<Vec3d, 3> begin, end;
        for (std::size_t k = 0; k < 3; ++k) {
            begin[k] = random.vector(1);
            end[k] = begin[k] + random.vector(0.7);
        }
        const Vec3d from = random.vector(1), to = from + random.vector(1.5);
        const auto found = find_crossing(from, to, begin, end);
        // The side of the point and its position in the triangle in small steps of the time.
        constexpr int kSteps = 400;
        bool passes = false;
        double before = 0;
        for (int k = 0; k <= kSteps; ++k) {
            const double t = double(k) / kSteps;
            const auto at = [&](std::size_t c) { return begin[c] + t * (end[c] - begin[c]); };
            const Vec3d p = from + t * (to - from), a = at(0), b = at(1), c = at(2);
            const Vec3d normal = cross(b - a, c - a);
            const double side = dot(p - a, normal);
            const bool is_over = dot(cross(b - a, p - a), normal) > 0.02 * dot(normal, normal) &&
                                 dot(cross(c - b, p - b), normal) > 0.02 * dot(normal, normal) &&
                                 dot(cross(a - c, p - c), normal) > 0.02 * dot(normal, normal);
            passes |= k > 0 && before > 0 && side <= 0 && is_over;
            before = side;
        }
        if (passes) {
            ++crossed;
            ASSERT_TRUE(found) << n;
        }
        if (!found) continue;
        Vec3d in{0, 0, 0};
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_GE(found->weights[k], -1e-5);
            in = in + found->weights[k] * (begin[k] + found->time * (end[k] - begin[k]));
        }
        EXPECT_LT(norm(in - (from + found->time * (to - from))), 1e-9) << n;
    }
    EXPECT_GT(crossed, 300);
}

TEST(Probe, TheThreeNodesOfTheHitTriangleMoveByTheDepthAndStartTheSearch) {
    const Surface s = ball(50, 3);
    SpringTissue tissue = tissue_of(parts_of(s), 3);
    auto probe = SpringProbe::create(tissue.network(), s.triangles);
    // Above the middle of a triangle, down along its normal.
    const auto& t = s.triangles[100];
    const auto rest = [&](std::size_t k) { return s.nodes[std::size_t(t[k])]; };
    const Vec3d normal = normalized(cross(rest(1) - rest(0), rest(2) - rest(0)));
    const Vec3d middle = (1.0 / 3) * (rest(0) + rest(1) + rest(2));
    ASSERT_TRUE(probe->place(tissue, middle + 1.0 * normal).ok());
    ASSERT_TRUE(probe->move(tissue, middle - 1.0 * normal, 1, arena).ok());
    ASSERT_EQ(probe->triangles().size(), 1u);
    EXPECT_EQ(probe->triangles()[0], 100);
    const std::set<std::int32_t> corners(t.begin(), t.end());
    EXPECT_EQ(std::set<std::int32_t>(probe->nodes().begin(), probe->nodes().end()), corners);
    for (const std::int32_t n : t) {
        EXPECT_NEAR(norm(tissue.displacement(n) + 1.0 * normal), 0, 0.01) << n;
        EXPECT_NEAR(norm(cross(tissue.displacement(n), normal)), 0, 1e-12) << n;
    }
    // Layers by plain search over the edges.
    std::vector<int> layer(tissue.network().nodes().size(), -1);
    std::queue<std::int32_t> waiting;
    for (const std::int32_t n : t) {
        layer[std::size_t(n)] = 0;
        waiting.push(n);
    }
    for (; !waiting.empty(); waiting.pop())
        for (const auto& triangle : s.triangles)
            if (std::count(triangle.begin(), triangle.end(), waiting.front()) > 0)
                for (const std::int32_t n : triangle)
                    if (layer[std::size_t(n)] < 0) {
                        layer[std::size_t(n)] = layer[std::size_t(waiting.front())] + 1;
                        waiting.push(n);
                    }
    const auto order = transmittal_order(tissue.network(), probe->nodes(), 3);
    ASSERT_TRUE(order.ok());
    ASSERT_EQ(order->layers.size(), 5u);
    std::size_t reached = 0;
    for (std::size_t l = 0; l < 4; ++l)
        for (auto k = order->layers[l]; k < order->layers[l + 1]; ++k, ++reached)
            EXPECT_EQ(layer[std::size_t(order->nodes[std::size_t(k)])], int(l));
    EXPECT_EQ(reached, std::size_t(std::count_if(layer.begin(), layer.end(),
                                                 [](int l) { return l >= 0 && l <= 3; })));
    // Nodes beyond the depth stay.
    ASSERT_TRUE(probe->move(tissue, middle - 1.5 * normal, 50, arena).ok());
    int moved = 0;
    for (std::size_t n = 0; n < s.nodes.size(); ++n) {
        const bool moves = tissue.displacement(std::int32_t(n)) != Vec3d{0, 0, 0};
        EXPECT_EQ(moves, layer[n] <= 3) << n;
        moved += moves;
    }
    EXPECT_EQ(moved, std::int32_t(reached));
}

TEST(Probe, AtEquilibriumTheReactionIsThatOfAllSupportsTogether) {
    const Surface s = ball(50, 3);
    SpringTissue tissue = tissue_of(parts_of(s), 64);
    auto probe = SpringProbe::create(tissue.network(), s.triangles, {.radius = 8});
    ASSERT_TRUE(probe->place(tissue, {3, 2, 70}).ok());
    ASSERT_TRUE(probe->move(tissue, {3, 2, 50}, 3000, arena).ok());
    for (int n = 0; n < 20; ++n) ASSERT_TRUE(probe->move(tissue, {3, 2, 50}, 200, arena).ok());
    const auto reaction = tissue.reaction(probe->nodes(), ReactionLaw::Held);
    ASSERT_TRUE(reaction.ok());
    Vec3d supports{0, 0, 0};  // of the links to fixed nodes, on the tissue
    for (const SpringLink& link : tissue.network().links())
        if (link.rest_length == 0)
            supports = supports - 0.3 * (tissue.position(link.a) - tissue.position(link.b));
    EXPECT_GT(reaction->force.z, 1);
    EXPECT_LT(norm(reaction->force - supports), 1e-6 * norm(supports));
    // A tool that leaves lets go without having been pulled.
    ASSERT_TRUE(probe->move(tissue, {3, 2, 90}, 1, arena).ok());
    EXPECT_TRUE(probe->triangles().empty());
    EXPECT_TRUE(probe->nodes().empty());
}

TEST(Probe, ASlowReturnIsFollowedUntilTheForceIsZero) {
    const Surface s = ball(50, 3);
    SpringTissue tissue = tissue_of(parts_of(s));
    auto probe = SpringProbe::create(tissue.network(), s.triangles);
    ASSERT_TRUE(probe->place(tissue, {4, 3, 55}).ok());
    ASSERT_TRUE(probe->move(tissue, {4, 3, 40}, 500, arena).ok());
    double last = norm(tissue.reaction(probe->nodes(), ReactionLaw::Held)->force);
    EXPECT_GT(last, 1);
    for (double z = 40; z < 60; z += 0.05) {
        ASSERT_TRUE(probe->move(tissue, {4, 3, z}, 20, arena).ok());
        if (probe->nodes().empty()) {
            EXPECT_GT(z, 47);
            break;
        }
        const Vec3d force = tissue.reaction(probe->nodes(), ReactionLaw::Held)->force;
        EXPECT_GT(force.z, -0.02) << z;  // never a pull
        EXPECT_LT(norm(force), last + 0.02) << z;
        last = norm(force);
    }
    EXPECT_TRUE(probe->nodes().empty());
    EXPECT_LT(last, 0.2);
}

TEST(Probe, ATriangleWithAFixedNodeStopsTheTool) {
    const Surface s = ball(50, 2);
    SpringParts parts = parts_of(s);
    for (std::size_t n = 0; n < s.nodes.size(); ++n) parts.nodes[n].fixed = s.nodes[n].z > 0;
    for (const double radius : {0.0, 5.0}) {
        // Home links of two fixed nodes join nothing that moves.
        SpringTissue tissue = tissue_of(parts);
        auto probe = SpringProbe::create(tissue.network(), s.triangles, {.radius = radius});
        ASSERT_TRUE(probe->place(tissue, {2, 1, 70}).ok());
        const auto moved = probe->move(tissue, {2, 1, -70}, 4, arena);
        ASSERT_TRUE(moved.ok());
        EXPECT_LT(moved->way_share, 0.2);
        EXPECT_GT(moved->way_share, 0.05);
        EXPECT_LT(brute_winding(tissue, s.triangles, moved->position), 0.5);
        EXPECT_GT(moved->position.z, 40 + radius);
        EXPECT_TRUE(probe->triangles().empty());
        const auto back = probe->move(tissue, {2, 1, 70}, 4, arena);
        EXPECT_EQ(back->way_share, 1);
    }
}

TEST(Probe, BadInputIsRefusedInALine) {
    const Surface s = ball(50, 1);
    SpringTissue tissue = tissue_of(parts_of(s));
    const auto refuses = [&](const Triangles& triangles, const SpringProbeSettings& settings,
                             const char* text) {
        const auto made = SpringProbe::create(tissue.network(), triangles, settings);
        ASSERT_FALSE(made.ok()) << text;
        EXPECT_EQ(made.error().message, text);
    };
    refuses({}, {}, "triangles: expected 1 or more, found 0");
    refuses({{0, 1, 99}}, {}, "triangles: expected nodes below 36, found 99 in triangle 0");
    refuses({{0, 1, 2}, {3, 1, 3}}, {},
            "triangles: expected three different nodes, found a node twice in triangle 1");
    refuses(s.triangles, {.radius = -1}, "radius: expected 0 or more, found -1");
    refuses(s.triangles, {.stride = NAN}, "stride: expected 0 or more, found nan");
    auto probe = SpringProbe::create(tissue.network(), s.triangles);
    ASSERT_TRUE(probe->place(tissue, {0, 0, 60}).ok());
    EXPECT_FALSE(probe->place(tissue, {1, 2, 3}).ok());
    EXPECT_EQ(probe->position(), (Vec3d{0, 0, 60}));
    EXPECT_FALSE(probe->move(tissue, {0, 0, NAN}, 1, arena).ok());
    EXPECT_FALSE(probe->move(tissue, {0, 0, 1e9}, 1, arena).ok());
    EXPECT_FALSE(probe->move(tissue, {0, 0, 61}, 0, arena).ok());
    EXPECT_EQ(probe->position(), (Vec3d{0, 0, 60}));
}

TEST(Probe, AStepThatFailsLeavesTheToolWhereItWas) {
    const Surface s = ball(50, 2);
    SpringTissue tissue = tissue_of(parts_of(s));
    auto probe = SpringProbe::create(tissue.network(), s.triangles);
    ASSERT_TRUE(probe->place(tissue, {2, 1, 60}).ok());
    ASSERT_TRUE(probe->move(tissue, {2, 1, 47}, 100, arena).ok());
    const std::vector<std::int32_t> nodes(probe->nodes().begin(), probe->nodes().end());
    ASSERT_FALSE(nodes.empty());
    const std::uint64_t hash = tissue.hash();
    // A load that tears a node away.
    ASSERT_TRUE(tissue.load(std::array{5}, std::array{Vec3d{0, 0, -1e6}}).ok());
    ASSERT_FALSE(probe->move(tissue, {2, 1, 44}, 1, arena).ok());
    EXPECT_EQ(probe->position(), (Vec3d{2, 1, 47}));
    EXPECT_EQ(std::vector<std::int32_t>(probe->nodes().begin(), probe->nodes().end()), nodes);
    EXPECT_EQ(tissue.hash(), hash);
}

}  // namespace
}  // namespace pliant::test
