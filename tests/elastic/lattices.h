// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Lattices for tests of the elastic scan, and their forces by Gauss points.

#pragma once

#include <pliant/models/elastic_scan.h>
#include <pliant/volume.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "elastic/levels.h"
#include "elastic/stiffness_map.h"

namespace pliant::test {

/// A scan whose voxels have a modulus of value · 0.01 kPa, without held sides or bone.
inline ElasticScanSettings plain_settings(double nu) {
    ElasticScanSettings settings;
    settings.moduli_kpa = {{0, 0}, {10000, 100}};
    settings.poisson_ratio = nu;
    settings.held_above_hu = 20000;
    settings.held_sides.emplace();
    return settings;
}

inline Volume scan_of(Vec3i size, Vec3d spacing_mm, const std::function<int(Vec3i)>& value) {
    Volume scan;
    scan.grid = {size, spacing_mm};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) voxels.push_back(std::int16_t(value({i, j, k})));
    scan.voxels = std::move(voxels);
    return scan;
}

/// Displacement of a voxel [mm].
inline Vec3d displacement(const ElasticLevels& levels, Vec3i voxel) {
    float u[3];
    levels.displacement_row(voxel, 1, {&u[0], &u[1], &u[2]});
    return {double(u[0]), double(u[1]), double(u[2])};
}

using Corners = std::array<Vec3d, 8>;

/// Forces of a box's corners by 2 × 2 × 2 Gauss points: deviatoric strain at the point, volumetric
/// strain of the cell's mean [Hughes1980].
inline Corners gauss_forces(Vec3d h, double lambda, double mu, const Corners& u) {
    const auto sign = [](std::size_t c, int a) { return c >> a & 1 ? 1.0 : -1.0; };
    const double volume = h.x * h.y * h.z;
    struct Point {
        Corners gradient;  ///< of each corner's shape function
    };
    std::array<Point, 8> points;
    Corners mean{};
    for (std::size_t g = 0; g < 8; ++g) {
        for (std::size_t c = 0; c < 8; ++c)
            for (int a = 0; a < 3; ++a) {
                double value = sign(c, a) / h[a] / 4;
                for (int b = 0; b < 3; ++b)
                    if (b != a) value *= 1 + sign(c, b) * sign(g, b) / std::sqrt(3.0);
                points[g].gradient[c][a] = value;
                mean[c][a] += value / 8;
            }
    }
    double dilatation = 0;
    for (std::size_t c = 0; c < 8; ++c) dilatation += dot(mean[c], u[c]);
    Corners forces{};
    const double bulk = lambda + 2.0 / 3 * mu;
    for (std::size_t c = 0; c < 8; ++c) forces[c] = volume * bulk * dilatation * mean[c];
    for (const Point& point : points) {
        double d[3][3] = {};  // ∂u_a/∂x_b
        for (std::size_t c = 0; c < 8; ++c)
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) d[a][b] += u[c][a] * point.gradient[c][b];
        const double third = (d[0][0] + d[1][1] + d[2][2]) / 3;
        for (std::size_t c = 0; c < 8; ++c)
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) {
                    const double deviator = (d[a][b] + d[b][a]) / 2 - (a == b ? third : 0);
                    forces[c][a] += volume / 8 * 2 * mu * deviator * point.gradient[c][b];
                }
    }
    return forces;
}

}  // namespace pliant::test
