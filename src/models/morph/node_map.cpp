// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "morph/node_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "resample/find_source.h"
#include "volume/boxes.h"

namespace pliant::morph {
namespace {

Vec3d times(Vec3d a, Vec3d b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// The cells of a map, as find_source.h asks.
struct Cells {
    const NodeMap& map;
    double reach;  ///< of the displacements [nodes]

    bool corners(Vec3i cell, std::array<Vec3d, 8>& points) const {
        return map.corners(cell, points);
    }
    bool is_whole(Vec3i) const { return true; }
    DisplacementBounds bounds() const { return {{-reach, -reach, -reach}, {reach, reach, reach}}; }
};

}  // namespace

NodeMap::NodeMap(const Grid& nodes, std::span<const Vec3d> displacements_mm) : m_grid(nodes) {
    const Vec3d h = nodes.spacing_mm, per_mm{1 / h.x, 1 / h.y, 1 / h.z};
    for (const Vec3d& u : displacements_mm)
        m_u.push_back(times(per_mm, lattice_from_world_vector(nodes, u)));
}

Vec3d NodeMap::node(Vec3i at) const {
    for (int a = 0; a < 3; ++a) at[a] = std::clamp(at[a], 0, m_grid.size[a] - 1);
    return m_u[voxel_index(m_grid, at)];
}

bool NodeMap::corners(Vec3i cell, std::array<Vec3d, 8>& points) const {
    for (int c = 0; c < 8; ++c) {
        const Vec3i step{c & 1, c >> 1 & 1, c >> 2};
        points[std::size_t(c)] = real_of(step) + node(cell + step);
    }
    return true;
}

Vec3d NodeMap::displacement_mm(Vec3d point_mm) const {
    Vec3d at = voxel_from_world(m_grid, point_mm);
    Vec3i low{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        at[a] = std::clamp(at[a], 0.0, double(m_grid.size[a] - 1));
        low[a] = std::min(int(at[a]), std::max(0, m_grid.size[a] - 2));
    }
    const Vec3d t = at - real_of(low);
    Vec3d sum{0, 0, 0};
    for (int c = 0; c < 8; ++c) {
        const double weight =
            (c & 1 ? t.x : 1 - t.x) * (c & 2 ? t.y : 1 - t.y) * (c & 4 ? t.z : 1 - t.z);
        if (weight != 0) sum = sum + weight * node(low + Vec3i{c & 1, c >> 1 & 1, c >> 2});
    }
    return world_from_lattice_vector(m_grid, times(m_grid.spacing_mm, sum));
}

Vec3d NodeMap::inverse_mm(Vec3d point_mm, Vec3d guess_mm) const {
    constexpr int kMaxSteps = 16;
    constexpr double kDone = 1e-9;  // [nodes]
    const Vec3d now = voxel_from_world(m_grid, point_mm);
    Vec3d rest = voxel_from_world(m_grid, point_mm + guess_mm);
    for (int step = 0; step < kMaxSteps; ++step) {
        Vec3i cell{0, 0, 0};
        Vec3d t{0, 0, 0};
        for (int a = 0; a < 3; ++a) {
            cell[a] = int(std::floor(std::clamp(rest[a], -1.0, double(m_grid.size[a]))));
            t[a] = rest[a] - cell[a];
        }
        std::array<Vec3d, 8> u;
        for (int c = 0; c < 8; ++c)
            u[std::size_t(c)] = node(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        // Trilinear interpolation axis by axis, with derivatives. Beyond the lattice the nodes are
        // equal, so that any t gives the same.
        std::array<Vec3d, 4> x, dx;
        for (std::size_t n = 0; n < 4; ++n) {
            dx[n] = u[2 * n + 1] - u[2 * n];
            x[n] = u[2 * n] + t.x * dx[n];
        }
        const Vec3d y0 = x[0] + t.y * (x[1] - x[0]), y1 = x[2] + t.y * (x[3] - x[2]);
        const Vec3d off = now - rest - (y0 + t.z * (y1 - y0));
        if (dot(off, off) < kDone * kDone) return world_from_voxel(m_grid, rest);
        const Vec3d low = dx[0] + t.y * (dx[1] - dx[0]), high = dx[2] + t.y * (dx[3] - dx[2]);
        const Vec3d slope_x = low + t.z * (high - low);
        const Vec3d slope_y = (1 - t.z) * (x[1] - x[0]) + t.z * (x[3] - x[2]);
        const Mat3d f{
            {Vec3d{1, 0, 0} + slope_x, Vec3d{0, 1, 0} + slope_y, Vec3d{0, 0, 1} + (y1 - y0)}};
        if (!(determinant(f) > 1e-6)) break;
        rest = rest + pliant::inverse(f) * off;
    }
    // Newton's steps went in a circle between cells.
    double reach = 0;
    for (const Vec3d& u : m_u)
        reach = std::max({reach, std::abs(u.x), std::abs(u.y), std::abs(u.z)});
    Cells cells{*this, reach + 1};
    const auto found = find_source(cells, now);
    return world_from_voxel(m_grid, found.value_or(rest));
}

double least_determinant(const std::array<Vec3d, 8>& corners) {
    // Edges along x at (y, z), along y at (x, z), along z at (x, y).
    std::array<Vec3d, 4> x, y, z;
    for (unsigned n = 0; n < 4; ++n) {
        const unsigned a = n & 1, b = n >> 1;
        x[n] = corners[1 + 2 * a + 4 * b] - corners[2 * a + 4 * b];
        y[n] = corners[a + 2 + 4 * b] - corners[a + 4 * b];
        z[n] = corners[a + 2 * b + 4] - corners[a + 2 * b];
    }
    // Each factor is linear in the coordinates across its edge. A product of two linear functions
    // of Bernstein coefficients p₀, p₁ and q₀, q₁ has p₀q₀, (p₀q₁ + p₁q₀) / 2, p₁q₁.
    std::array<double, 27> sum{};
    for (unsigned xy = 0; xy < 2; ++xy)
        for (unsigned xz = 0; xz < 2; ++xz)
            for (unsigned yx = 0; yx < 2; ++yx)
                for (unsigned yz = 0; yz < 2; ++yz) {
                    const Vec3d area = cross(x[xy + 2 * xz], y[yx + 2 * yz]);
                    for (unsigned zx = 0; zx < 2; ++zx)
                        for (unsigned zy = 0; zy < 2; ++zy)
                            sum[(yx + zx) + 3 * (xy + zy) + 9 * (xz + yz)] +=
                                dot(area, z[zx + 2 * zy]);
                }
    double least = std::numeric_limits<double>::infinity();
    for (unsigned n = 0; n < 27; ++n) {
        // Pairs that were summed: two of a middle coefficient, one of another.
        const double pairs = (n % 3 == 1 ? 2 : 1) * (n / 3 % 3 == 1 ? 2 : 1) * (n / 9 == 1 ? 2 : 1);
        least = std::min(least, sum[n] / pairs);
    }
    return least;
}

std::vector<NodeMap::Cell> NodeMap::cells_below(double limit, double& least,
                                                const TaskArena& arena) const {
    const Vec3i size = m_grid.size;
    std::vector<std::vector<Cell>> found(std::size_t(size.z + 1));
    std::vector<double> bounds(found.size(), std::numeric_limits<double>::infinity());
    arena.for_each(size.z + 1, 1, [&](std::int64_t begin, std::int64_t end) {
        std::array<Vec3d, 8> points;
        for (int k = int(begin) - 1; k < int(end) - 1; ++k)
            for (int j = -1; j < size.y; ++j)
                for (int i = -1; i < size.x; ++i) {
                    corners({i, j, k}, points);
                    const double bound = least_determinant(points);
                    const auto n = std::size_t(k + 1);
                    bounds[n] = std::min(bounds[n], bound);
                    if (!(bound >= limit)) found[n].push_back({{i, j, k}, bound});
                }
    });
    least = *std::min_element(bounds.begin(), bounds.end());
    std::vector<Cell> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    return all;
}

}  // namespace pliant::morph
