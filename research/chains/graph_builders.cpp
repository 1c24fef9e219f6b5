// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Graphs of lattices and meshes.

#include <pliant/research/graph.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "base/text.h"
#include "chains/graph_limits.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

/// Steps to the larger element number: one for each pair of opposite directions.
std::vector<Vec3i> forward_steps(Neighbours neighbours) {
    const int longest = neighbours == Neighbours::Faces   ? 1
                        : neighbours == Neighbours::Edges ? 2
                                                          : 3;
    std::vector<Vec3i> steps;
    for (int z = 0; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) {
                const bool forward = z > 0 || (z == 0 && (y > 0 || (y == 0 && x > 0)));
                if (forward && std::abs(x) + std::abs(y) + z <= longest) steps.push_back({x, y, z});
            }
    return steps;
}

template <std::size_t Corners>
std::vector<ChainEdge> edges_of(std::span<const std::array<std::int32_t, Corners>> cells) {
    std::vector<ChainEdge> edges;
    edges.reserve(cells.size() * Corners * (Corners - 1) / 2);
    for (const auto& cell : cells)
        for (std::size_t p = 0; p < Corners; ++p)
            for (std::size_t q = p + 1; q < Corners; ++q)
                edges.push_back({std::min(cell[p], cell[q]), std::max(cell[p], cell[q])});
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
}

}  // namespace

Status check_chain_lattice(const ChainLattice& lattice) {
    const auto complain = [](const std::string& text) {
        return Error{ErrorCode::InvalidArgument, "lattice " + text};
    };
    const Vec3i size = lattice.size;
    if (size.x < 1 || size.y < 1 || size.z < 1 ||
        std::int64_t(size.x) * size.y > INT32_MAX / size.z)
        return complain("size: expected 1 to 2147483647 elements, found " + text_of_size(size));
    const auto count = dense_count(size);
    for (int a = 0; a < 3; ++a)
        if (!(lattice.spacing_mm[a] > 0 && lattice.spacing_mm[a] <= 1e3))
            return complain("spacing_mm: expected lengths above 0, up to 1000");
    if (!lattice.material.empty() && lattice.material.size() != count)
        return complain("material: expected one for each of " + text_of_size(size) +
                        " elements, found " + std::to_string(lattice.material.size()));
    if (!lattice.present.empty() && lattice.present.size() != count)
        return complain("present: expected one for each of " + text_of_size(size) +
                        " elements, found " + std::to_string(lattice.present.size()));
    if (const Status status = check_materials(lattice.materials); !status.ok()) return status;
    for (const std::uint8_t m : lattice.material)
        if (m >= lattice.materials.size())
            return complain("material: expected numbers below " +
                            std::to_string(lattice.materials.size()) + ", found " +
                            std::to_string(m));
    return Ok{};
}

Result<ChainGraph> graph_of_lattice(const ChainLattice& lattice, Neighbours neighbours) {
    if (const Status status = check_chain_lattice(lattice); !status.ok()) return status.error();
    const Grid grid{.size = lattice.size};
    const Vec3d h = lattice.spacing_mm;
    const std::vector<Vec3i> steps = forward_steps(neighbours);
    // Offsets are products, not differences of positions, so that equal links have equal limits.
    std::vector<HalfLink> halves;  // [material][step]
    for (const ElementLimits& limits : lattice.materials)
        for (const Vec3i step : steps)
            halves.push_back(half_link(limits, {h.x * step.x, h.y * step.y, h.z * step.z}));
    const auto material_of = [&](std::size_t e) {
        return std::size_t(lattice.material.empty() ? 0 : lattice.material[e]);
    };
    const auto is_there = [&](Vec3i e) {
        return contains(voxel_box(grid), e) &&
               (lattice.present.empty() || lattice.present[voxel_index(grid, e)]);
    };
    std::vector<ChainElement> elements;
    std::vector<ChainLink> links;
    elements.reserve(voxel_count(grid));
    links.reserve(voxel_count(grid) * steps.size());
    const auto add_element = [&](Vec3i ijk) {
        const std::size_t e = elements.size();
        const ElementLimits& limits = lattice.materials[material_of(e)];
        elements.push_back(
            {{h.x * ijk.x, h.y * ijk.y, h.z * ijk.z}, limits.max_movement_mm, limits.fixed});
        if (!is_there(ijk)) return;
        for (std::size_t s = 0; s < steps.size(); ++s) {
            if (!is_there(ijk + steps[s])) continue;
            const std::size_t f = voxel_index(grid, ijk + steps[s]);
            const HalfLink& one = halves[material_of(e) * steps.size() + s];
            const HalfLink& other = halves[material_of(f) * steps.size() + s];
            links.push_back({std::int32_t(e), std::int32_t(f), -mm_from_units(one.low + other.low),
                             mm_from_units(one.high + other.high)});
        }
    };
    for (int k = 0; k < lattice.size.z; ++k)
        for (int j = 0; j < lattice.size.y; ++j)
            for (int i = 0; i < lattice.size.x; ++i) add_element({i, j, k});
    return ChainGraph::create(std::move(elements), links);
}

std::vector<ChainEdge> edges_of_triangles(std::span<const std::array<std::int32_t, 3>> triangles) {
    return edges_of(triangles);
}

std::vector<ChainEdge> edges_of_tetrahedra(
    std::span<const std::array<std::int32_t, 4>> tetrahedra) {
    return edges_of(tetrahedra);
}

}  // namespace pliant
