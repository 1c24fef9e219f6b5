// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps of surfaces beside the signed distance to them.

#include <gtest/gtest.h>
#include <pliant/data/morph.h>
#include <pliant/mesh.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "support/random.h"

namespace pliant::test {
namespace {

/// An octahedron whose triangles are halved and whose nodes are moved onto radii that vary.
TriangleMesh bumpy_ball(Random& random, int halvings) {
    TriangleMesh mesh;
    mesh.nodes_mm = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.cells = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                  {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int n = 0; n < halvings; ++n) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int a, int b) {
            const auto [at, is_new] =
                middles.try_emplace({std::min(a, b), std::max(a, b)}, int(mesh.nodes_mm.size()));
            if (is_new)
                mesh.nodes_mm.push_back(
                    0.5 * (mesh.nodes_mm[std::size_t(a)] + mesh.nodes_mm[std::size_t(b)]));
            return at->second;
        };
        std::vector<std::array<std::int32_t, 3>> halved;
        for (const auto& c : mesh.cells) {
            const int ab = middle(c[0], c[1]), bc = middle(c[1], c[2]), ca = middle(c[2], c[0]);
            halved.insert(halved.end(),
                          {{c[0], ab, ca}, {c[1], bc, ab}, {c[2], ca, bc}, {ab, bc, ca}});
        }
        mesh.cells = std::move(halved);
    }
    for (Vec3d& p : mesh.nodes_mm) p = (random.real(14, 20) / norm(p)) * p;
    return mesh;
}

TEST(SurfaceLabels, AreTheInsideByTheSignedDistance) {
    const auto seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    for (int n = 0; n < 5; ++n) {
        const TriangleMesh ball = bumpy_ball(random, 1 + n % 3);
        const auto labels = labels_of_surface(ball, 1.3);
        ASSERT_TRUE(labels.ok()) << labels.error().message;
        const auto distance = SurfaceDistance::create(ball);
        ASSERT_TRUE(distance.ok());
        const Vec3i size = labels->grid.size;
        int inside = 0;
        for (int k = 0; k < size.z; ++k)
            for (int j = 0; j < size.y; ++j)
                for (int i = 0; i < size.x; ++i) {
                    const double mm = distance->signed_mm(
                        world_from_voxel(labels->grid, {double(i), double(j), double(k)}));
                    inside += mm < 0;
                    if (std::abs(mm) < 1e-9) continue;
                    ASSERT_EQ(labels->at({i, j, k}), mm < 0 ? 1 : 0) << i << " " << j << " " << k;
                }
        EXPECT_GT(inside, 1000);
    }
}

// Nodes, edges and faces lie on rays.
TEST(SurfaceLabels, RaysThroughNodesAndEdgesLeaveNoGap) {
    TriangleMesh octahedron;
    octahedron.nodes_mm = {{8, 0, 0}, {-8, 0, 0}, {0, 8, 0}, {0, -8, 0}, {0, 0, 8}, {0, 0, -8}};
    octahedron.cells = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                        {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    const auto labels = labels_of_surface(octahedron, 1);
    ASSERT_TRUE(labels.ok());
    const Vec3i size = labels->grid.size;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) {
                const Vec3d x = world_from_voxel(labels->grid, {double(i), double(j), double(k)});
                const double beyond = std::abs(x.x) + std::abs(x.y) + std::abs(x.z) - 8;
                if (beyond == 0) continue;
                EXPECT_EQ(labels->at({i, j, k}), beyond < 0 ? 1 : 0)
                    << x.x << " " << x.y << " " << x.z;
            }
}

TEST(SurfaceLabels, OpenSurfacesAndTooManyVoxelsAreRefused) {
    Random random(1);
    TriangleMesh ball = bumpy_ball(random, 1);
    EXPECT_EQ(labels_of_surface(ball, 0.011).error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(labels_of_surface(ball, std::nan("")).error().message,
              "spacing_mm: expected 0.01 to 100, found nan");
    ball.cells.pop_back();
    EXPECT_FALSE(labels_of_surface(ball).ok());
    EXPECT_FALSE(labels_of_surface({}).ok());
}

}  // namespace
}  // namespace pliant::test
