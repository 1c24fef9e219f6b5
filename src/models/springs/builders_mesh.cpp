// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Networks from meshes, given as plain arrays of nodes and cells.

#include <pliant/models/springs.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "springs/cell_volume.h"

#include "base/errors.h"

namespace pliant {
namespace {

/// A pair of corners of one cell, and the cell's contribution to the stiffness of their link.
struct Share {
    std::int32_t a, b;
    double stiffness;
};

SpringParts parts_of(std::span<const Vec3d> nodes, const SpringMesh& mesh) {
    SpringParts parts;
    for (const Vec3d rest : nodes)
        parts.nodes.push_back({.rest = rest, .mass = mesh.node_mass, .damping = mesh.node_damping});
    return parts;
}

template <std::size_t Corners>
Status check_cells(std::span<const Vec3d> nodes,
                   std::span<const std::array<std::int32_t, Corners>> cells) {
    for (std::size_t c = 0; c < cells.size(); ++c)
        for (const std::int32_t n : cells[c])
            if (n < 0 || std::size_t(n) >= nodes.size())
                return Error{ErrorCode::InvalidArgument,
                             "mesh: cell " + std::to_string(c) + ": expected nodes below " +
                                 std::to_string(nodes.size()) + ", found " + std::to_string(n)};
    return Ok{};
}

/// Adds one link per pair, in ascending order. @param summed  whether contributions add up
void add_links(std::vector<Share> shares, bool summed, const SpringMesh& mesh, SpringParts& parts) {
    for (Share& share : shares)
        if (share.a > share.b) std::swap(share.a, share.b);
    std::stable_sort(shares.begin(), shares.end(), [](const Share& p, const Share& q) {
        return p.a != q.a ? p.a < q.a : p.b < q.b;
    });
    for (std::size_t s = 0; s < shares.size(); ++s) {
        const Share& share = shares[s];
        if (s > 0 && shares[s - 1].a == share.a && shares[s - 1].b == share.b) {
            if (summed) parts.links.back().stiffness += share.stiffness;
            continue;
        }
        parts.links.push_back({.a = share.a,
                               .b = share.b,
                               .stiffness = share.stiffness,
                               .damping = mesh.link_damping});
    }
}

template <std::size_t Corners>
void add_cells(std::span<const std::array<std::int32_t, Corners>> cells, const SpringMesh& mesh,
               SpringParts& parts) {
    for (const auto& corners : cells) {
        SpringCell cell{.node_count = std::int32_t(Corners), .bulk = mesh.bulk};
        std::copy(corners.begin(), corners.end(), cell.nodes.begin());
        parts.cells.push_back(cell);
    }
    if (mesh.density > 0) spread_masses(parts, mesh.density);
}

template <std::size_t Corners>
std::vector<Share> all_pairs(std::span<const std::array<std::int32_t, Corners>> cells,
                             double stiffness) {
    std::vector<Share> shares;
    for (const auto& cell : cells)
        for (std::size_t p = 0; p < Corners; ++p)
            for (std::size_t q = p + 1; q < Corners; ++q)
                shares.push_back({cell[p], cell[q], stiffness});
    return shares;
}

}  // namespace

Result<SpringParts> springs_of_triangles(std::span<const Vec3d> nodes,
                                         std::span<const std::array<std::int32_t, 3>> triangles,
                                         const SpringMesh& mesh) noexcept {
    return attempt([&]() -> Result<SpringParts> {
        if (const Status status = check_cells(nodes, triangles); !status.ok())
            return status.error();
        SpringParts parts = parts_of(nodes, mesh);
        add_links(all_pairs(triangles, mesh.stiffness), false, mesh, parts);
        return parts;
    });
}

Result<SpringParts> springs_of_tetrahedra(std::span<const Vec3d> nodes,
                                          std::span<const std::array<std::int32_t, 4>> tetrahedra,
                                          const SpringMesh& mesh) noexcept {
    return attempt([&]() -> Result<SpringParts> {
        if (const Status status = check_cells(nodes, tetrahedra); !status.ok())
            return status.error();
        SpringParts parts = parts_of(nodes, mesh);
        add_links(all_pairs(tetrahedra, mesh.stiffness), false, mesh, parts);
        add_cells(tetrahedra, mesh, parts);
        return parts;
    });
}

Result<SpringParts> springs_of_elastic_tetrahedra(
    std::span<const Vec3d> nodes, std::span<const std::array<std::int32_t, 4>> tetrahedra,
    const SpringMesh& mesh) noexcept {
    return attempt([&]() -> Result<SpringParts> {
        if (const Status status = check_cells(nodes, tetrahedra); !status.ok())
            return status.error();
        SpringParts parts = parts_of(nodes, mesh);
        std::vector<Share> shares = all_pairs(tetrahedra, mesh.stiffness);
        for (Share& share : shares)
            share.stiffness *= std::sqrt(2.0) / 5 *
                               norm(nodes[std::size_t(share.a)] - nodes[std::size_t(share.b)]);
        add_links(std::move(shares), true, mesh, parts);
        add_cells(tetrahedra, mesh, parts);
        return parts;
    });
}

Result<SpringParts> springs_of_hexahedra(std::span<const Vec3d> nodes,
                                         std::span<const std::array<std::int32_t, 8>> hexahedra,
                                         const SpringMesh& mesh) noexcept {
    return attempt([&]() -> Result<SpringParts> {
        if (const Status status = check_cells(nodes, hexahedra); !status.ok())
            return status.error();
        constexpr int kPairs[24][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                       {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7},
                                       {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 5}, {1, 4},
                                       {1, 6}, {2, 5}, {2, 7}, {3, 6}, {3, 4}, {0, 7}};
        SpringParts parts = parts_of(nodes, mesh);
        std::vector<Share> shares;
        for (const auto& cell : hexahedra)
            for (const auto& pair : kPairs)
                shares.push_back(
                    {cell[std::size_t(pair[0])], cell[std::size_t(pair[1])], mesh.stiffness});
        add_links(std::move(shares), false, mesh, parts);
        add_cells(hexahedra, mesh, parts);
        return parts;
    });
}

}  // namespace pliant
