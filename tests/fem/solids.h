// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Solids, supports and measures that several tests of finite elements share.

#pragma once

#include <gtest/gtest.h>
#include <pliant/models/fem.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/random.h"

namespace pliant::test {

/// Node numbers for which a position satisfies a condition.
template <class Condition>
std::vector<std::int32_t> nodes_where(const HexMesh& mesh, Condition&& condition) {
    std::vector<std::int32_t> nodes;
    for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n)
        if (condition(mesh.nodes_mm[n])) nodes.push_back(std::int32_t(n));
    return nodes;
}

inline std::vector<Support> hold_all(const std::vector<std::int32_t>& nodes) {
    std::vector<Support> supports;
    for (const std::int32_t n : nodes) supports.push_back({.node = n});
    return supports;
}

/// Boundary faces with all corners satisfying a condition.
template <class Condition>
std::vector<HexFace> faces_where(const HexMesh& mesh, Condition&& condition) {
    std::vector<HexFace> faces;
    for (const HexFace& f : boundary_faces(mesh)) {
        bool all = true;
        for (const int c : kHexFaceCorners[f.face]) {
            const auto node = std::size_t(mesh.cells[std::size_t(f.cell)][std::size_t(c)]);
            all = all && condition(mesh.nodes_mm[node]);
        }
        if (all) faces.push_back(f);
    }
    return faces;
}

/// A block with randomly shifted inner nodes, rotated as a whole.
inline HexMesh distorted_block(Vec3i size, Random& random) {
    HexMesh mesh = hex_mesh({size, {1, 1.2, 0.8}, {0, 0, 0}});
    for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n)
        mesh.nodes_mm[n] = mesh.nodes_mm[n] + random.vector(0.15);
    const Mat3d turn = random.rotation(false);
    for (Vec3d& x : mesh.nodes_mm) x = turn * x;
    return mesh;
}

struct LoadedSolid {
    HexMesh mesh;
    ElasticLoads loads;
    std::vector<Support> supports;
};

/// A block in pure shear: tractions in equilibrium; the supports only take the six rigid motions.
inline LoadedSolid sheared_block(double stress_pa) {
    LoadedSolid block{
        hex_mesh({{4, 4, 4}}), {}, {{0}, {3, {false, true, true}}, {12, {false, false, true}}}};
    for (const double side : {0.0, 3.0}) {
        const double traction = side > 0 ? stress_pa : -stress_pa;
        for (const HexFace& f : faces_where(block.mesh, [&](Vec3d x) { return x.x == side; }))
            block.loads.surfaces.push_back({f, {0, traction, 0}});
        for (const HexFace& f : faces_where(block.mesh, [&](Vec3d x) { return x.y == side; }))
            block.loads.surfaces.push_back({f, {traction, 0, 0}});
    }
    return block;
}

inline double largest(const std::vector<Vec3d>& vectors) {
    double most = 0;
    for (const Vec3d& v : vectors) most = std::max(most, norm(v));
    return most;
}
inline double largest_difference(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0;
    for (std::size_t n = 0; n < a.size(); ++n) most = std::max(most, norm(a[n] - b[n]));
    return most;
}
inline Vec3d sum_of(const std::vector<Vec3d>& vectors) {
    Vec3d sum{0, 0, 0};
    for (const Vec3d& v : vectors) sum = sum + v;
    return sum;
}

/// The value, or a failed test with its message.
template <class T>
T value_of(Result<T> result) {
    if (!result.ok()) throw std::runtime_error(result.error().message);
    return std::move(result).value();
}

}  // namespace pliant::test
