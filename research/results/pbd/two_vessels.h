// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Two vessels as in [Teschner2003], and the nodes in their tetrahedra by all pairs.

#pragma once

#include <pliant/mesh.h>
#include <pliant/models/pbd.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

namespace pliant::results {

/// Without bounding boxes, so that nothing can be missed.
inline std::vector<NodeInCell> all_pairs(const TetMesh& mesh, std::span<const Vec3d> positions) {
    std::vector<NodeInCell> found;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const auto& cell = mesh.cells[c];
        const Vec3d o = positions[std::size_t(cell[0])];
        Mat3d edges{};
        for (std::size_t n = 0; n < 3; ++n)
            edges.columns[n] = positions[std::size_t(cell[n + 1])] - o;
        if (!(std::abs(determinant(edges)) > 0)) continue;
        const Mat3d inverse = pliant::inverse(edges);
        for (std::size_t n = 0; n < positions.size(); ++n) {
            const Vec3d beta = inverse * (positions[n] - o);
            if (beta.x >= 0 && beta.y >= 0 && beta.z >= 0 && beta.x + beta.y + beta.z <= 1 &&
                std::count(cell.begin(), cell.end(), std::int32_t(n)) == 0)
                found.push_back({std::int32_t(c), std::int32_t(n)});
        }
    }
    return found;
}

/// A vessel along z of hexahedra, six tetrahedra each; its nodes are slightly perturbed.
template <class Random>
void add_vessel(TetMesh& mesh, Random& random, int around, int across, int along, Vec3d middle,
                Rotation turn) {
    const auto first = std::int32_t(mesh.nodes_mm.size());
    for (int k = 0; k <= along; ++k)
        for (int r = 0; r <= across; ++r)
            for (int a = 0; a < around; ++a) {
                const double radius = 4 + 2.0 * r / across;
                const double angle = 2 * std::numbers::pi * a / around;
                const Vec3d p{radius * std::cos(angle), radius * std::sin(angle), k - 0.5 * along};
                mesh.nodes_mm.push_back(middle + rotated(turn, p + random.vector(0.05)));
            }
    const auto node = [&](int r, int a, int k) {
        return first + a % around + around * (r + (across + 1) * k);
    };
    constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int k = 0; k < along; ++k)
        for (int r = 0; r < across; ++r)
            for (int a = 0; a < around; ++a)
                for (const auto& path : kPaths) {
                    int at[3] = {r, a, k};
                    std::array<std::int32_t, 4> cell{node(at[0], at[1], at[2])};
                    for (std::size_t n = 0; n < 3; ++n) {
                        ++at[path[n]];
                        cell[n + 1] = node(at[0], at[1], at[2]);
                    }
                    mesh.cells.push_back(cell);
                }
}

}  // namespace pliant::results
