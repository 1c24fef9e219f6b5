// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A straight vessel along z, of hexahedra that are six tetrahedra each.

#pragma once

#include <pliant/mesh.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace pliant::bench {

struct Tube {
    int around = 32, across = 2, along = 60;  ///< hexahedra
    double inner = 6, outer = 7.5, length = 80;

    /// Nodes by angle, then radius, then height.
    std::int32_t node(int a, int r, int k) const {
        return std::int32_t(a % around + around * (r + (across + 1) * k));
    }
};

inline TetMesh tube_mesh(const Tube& t) {
    TetMesh mesh;
    for (int k = 0; k <= t.along; ++k)
        for (int r = 0; r <= t.across; ++r)
            for (int a = 0; a < t.around; ++a) {
                const double radius = t.inner + (t.outer - t.inner) * r / t.across;
                const double angle = 2 * std::numbers::pi * a / t.around;
                mesh.nodes_mm.push_back(
                    {radius * std::cos(angle), radius * std::sin(angle), t.length * k / t.along});
            }
    constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int k = 0; k < t.along; ++k)
        for (int r = 0; r < t.across; ++r)
            for (int a = 0; a < t.around; ++a)
                for (const auto& path : kPaths) {
                    int at[3] = {a, r, k};
                    std::array<std::int32_t, 4> cell{t.node(a, r, k)};
                    for (std::size_t n = 0; n < 3; ++n) {
                        ++at[path[n]];
                        cell[n + 1] = t.node(at[0], at[1], at[2]);
                    }
                    const auto p = [&](std::size_t n) {
                        return mesh.nodes_mm[std::size_t(cell[n])];
                    };
                    if (dot(cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0)) < 0)
                        std::swap(cell[2], cell[3]);
                    mesh.cells.push_back(cell);
                }
    return mesh;
}

}  // namespace pliant::bench
