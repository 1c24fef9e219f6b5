// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The triangles of the 256 cases are computed instead of tabulated: on every face of a cell, the
// edges that cross the threshold are joined in pairs. The joints form loops, and each loop is split
// into a fan. If all four edges of a face cross, the corners above are separated, which depends on
// the face alone: so neighbours agree, and the surface has no holes.

#include "iso_mesh.h"

#include <bit>
#include <cstdint>

namespace pliant::bench {
namespace {

/// Edge of a cell: its first corner (bits: x, y, z) and its axis.
struct Edge {
    int corner, axis;
    int other() const { return corner | 1 << axis; }
};

constexpr std::array<Edge, 12> kEdges = {{{0, 0},
                                          {2, 0},
                                          {4, 0},
                                          {6, 0},
                                          {0, 1},
                                          {1, 1},
                                          {4, 1},
                                          {5, 1},
                                          {0, 2},
                                          {1, 2},
                                          {2, 2},
                                          {3, 2}}};

int edge_between(int a, int b) {
    for (int e = 0; e < 12; ++e) {
        const Edge& edge = kEdges[std::size_t(e)];
        if ((edge.corner == a && edge.other() == b) || (edge.corner == b && edge.other() == a))
            return e;
    }
    return -1;
}

using Triangle = std::array<int, 3>;  // of edges

/// @param above  bit: corner
std::vector<Triangle> triangles_of(int above) {
    std::array<std::array<int, 2>, 12> joined;
    std::array<int, 12> joints{};
    const auto join = [&](int a, int b) {
        joined[std::size_t(a)][std::size_t(joints[std::size_t(a)]++)] = b;
        joined[std::size_t(b)][std::size_t(joints[std::size_t(b)]++)] = a;
    };
    const auto is_above = [&](int corner) { return (above >> corner & 1) != 0; };
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
        const int first = face % 2 << axis;
        const std::array<int, 4> corners = {first, first | u, first | u | v, first | v};
        std::vector<int> crossing;
        for (int i = 0; i < 4; ++i) {
            const int a = corners[std::size_t(i)], b = corners[std::size_t((i + 1) % 4)];
            if (is_above(a) != is_above(b)) crossing.push_back(edge_between(a, b));
        }
        if (crossing.size() == 2) join(crossing[0], crossing[1]);
        if (crossing.size() == 4) {  // edges 0–1–2–3 around the face; corner 1 is between 0 and 1
            const bool around_1 = is_above(corners[1]);
            join(crossing[0], crossing[around_1 ? 1 : 3]);
            join(crossing[2], crossing[around_1 ? 3 : 1]);
        }
    }
    std::vector<Triangle> triangles;
    std::array<bool, 12> seen{};
    for (int e = 0; e < 12; ++e) {
        if (seen[std::size_t(e)] || joints[std::size_t(e)] == 0) continue;
        std::vector<int> loop;
        for (int at = e; !seen[std::size_t(at)];) {
            seen[std::size_t(at)] = true;
            loop.push_back(at);
            const auto& next = joined[std::size_t(at)];
            at = seen[std::size_t(next[0])] ? next[1] : next[0];
        }
        for (std::size_t i = 2; i < loop.size(); ++i)
            triangles.push_back({loop[0], loop[i - 1], loop[i]});
    }
    return triangles;
}

template <class T>
IsoMesh march(const Grid& grid, const T* voxels, double iso) {
    std::array<std::vector<Triangle>, 256> cases;
    for (int above = 0; above < 256; ++above) cases[std::size_t(above)] = triangles_of(above);
    const Vec3i n = grid.size;
    const std::ptrdiff_t stride[3] = {1, n.x, std::ptrdiff_t(n.x) * n.y};
    std::ptrdiff_t offset[8];
    for (int c = 0; c < 8; ++c)
        offset[c] = (c & 1) + (c >> 1 & 1) * stride[1] + (c >> 2) * stride[2];
    IsoMesh mesh;
    // Points on the edges from the voxels of two slices, by axis.
    std::array<std::vector<std::int32_t>, 6> known;
    for (auto& slice : known) slice.assign(std::size_t(stride[2]), -1);
    for (int z = 0; z + 1 < n.z; ++z) {
        for (int axis = 0; axis < 3; ++axis) {
            std::swap(known[std::size_t(axis)], known[std::size_t(axis + 3)]);
            known[std::size_t(axis + 3)].assign(std::size_t(stride[2]), -1);
        }
        for (int y = 0; y + 1 < n.y; ++y)
            for (int x = 0; x + 1 < n.x; ++x) {
                const T* cell = voxels + x + y * stride[1] + z * stride[2];
                int above = 0;
                for (int c = 0; c < 8; ++c) above |= int(cell[offset[c]] >= iso) << c;
                for (const Triangle& edges : cases[std::size_t(above)]) {
                    std::array<unsigned, 3> triangle;
                    for (std::size_t i = 0; i < 3; ++i) {
                        const Edge e = kEdges[std::size_t(edges[i])];
                        const Vec3i p{x + (e.corner & 1), y + (e.corner >> 1 & 1), e.corner >> 2};
                        std::int32_t& point = known[std::size_t(e.axis + 3 * p.z)]
                                                   [std::size_t(p.x + p.y * stride[1])];
                        if (point < 0) {
                            const double a = double(cell[offset[e.corner]]);
                            const double b = double(cell[offset[e.other()]]);
                            Vec3d at{double(p.x), double(p.y), double(z + p.z)};
                            at[e.axis] += (iso - a) / (b - a);
                            const Vec3d mm = world_from_voxel(grid, at);
                            point = std::int32_t(mesh.points_mm.size());
                            mesh.points_mm.push_back({float(mm.x), float(mm.y), float(mm.z)});
                        }
                        triangle[i] = unsigned(point);
                    }
                    mesh.triangles.push_back(triangle);
                }
            }
    }
    return mesh;
}

}  // namespace

IsoMesh make_iso_mesh(const Volume& volume, double iso_hu) {
    return std::visit([&](const auto& voxels) { return march(volume.grid, voxels.data(), iso_hu); },
                      volume.voxels);
}

}  // namespace pliant::bench
