// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Networks of lattices and of the sheet with six neighbours.

#include <pliant/models/springs.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "base/errors.h"
#include "springs/cell_volume.h"

namespace pliant {
namespace {

/// One of each pair of opposite directions.
std::vector<Vec3i> forward_steps(LatticeLinks links) {
    const int longest = links == LatticeLinks::Edges           ? 1
                        : links == LatticeLinks::EdgesAndFaces ? 2
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

/// Fraction of the possible cells around a link that exist: halved for each axis perpendicular to
/// the link at whose border the link lies.
double share_of_cells(Vec3i size, Vec3i from, Vec3i step) {
    double share = 1;
    for (int a = 0; a < 3; ++a)
        if (step[a] == 0 && size[a] > 1 && (from[a] == 0 || from[a] == size[a] - 1)) share /= 2;
    return share;
}

Status check(const SpringLattice& lattice) {
    const Vec3i size = lattice.size;
    if (size.x < 1 || size.y < 1 || size.z < 1 ||
        std::int64_t(size.x) * size.y > std::int64_t(100'000'000) / size.z)
        return invalid("lattice size: expected 1 to 100000000 nodes, found " +
                       std::to_string(size.x) + " x " + std::to_string(size.y) + " x " +
                       std::to_string(size.z));
    for (int a = 0; a < 3; ++a) {
        if (!(std::isfinite(lattice.spacing[a]) && lattice.spacing[a] > 0))
            return invalid("lattice spacing: expected lengths above 0");
        if (!(std::isfinite(lattice.stiffness[a]) && lattice.stiffness[a] >= 0))
            return invalid("lattice stiffness: expected 0 or more for each axis, found " +
                           std::to_string(lattice.stiffness[a]));
    }
    return Ok{};
}

}  // namespace

SpringMaterial closed_form(double young_modulus, double poisson_ratio, double spacing) {
    const double mu = young_modulus / (2 * (1 + poisson_ratio));
    const double lambda =
        young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio));
    return {mu * spacing, lambda - mu};
}

Result<SpringParts> springs_of_lattice(const SpringLattice& lattice) noexcept {
    return attempt([&]() -> Result<SpringParts> {
        if (const Status status = check(lattice); !status.ok()) return status.error();
        const Grid grid{.size = lattice.size};
        const Vec3d h = lattice.spacing;
        SpringParts parts;
        parts.nodes.reserve(voxel_count(grid));
        for (int k = 0; k < lattice.size.z; ++k)
            for (int j = 0; j < lattice.size.y; ++j)
                for (int i = 0; i < lattice.size.x; ++i)
                    parts.nodes.push_back({.rest = {h.x * i, h.y * j, h.z * k},
                                           .mass = lattice.node_mass,
                                           .damping = lattice.node_damping});
        const auto each_node = [&](const auto& visit) {
            for (int k = 0; k < lattice.size.z; ++k)
                for (int j = 0; j < lattice.size.y; ++j)
                    for (int i = 0; i < lattice.size.x; ++i) visit(Vec3i{i, j, k});
        };
        const std::vector<Vec3i> steps = forward_steps(lattice.links);
        parts.links.reserve(parts.nodes.size() * steps.size());
        each_node([&](Vec3i from) {
            for (const Vec3i step : steps) {
                if (!contains(voxel_box(grid), from + step)) continue;
                const Vec3d r{h.x * step.x, h.y * step.y, h.z * step.z};
                double stiffness = 0;
                for (int a = 0; a < 3; ++a)
                    stiffness += r[a] * r[a] / dot(r, r) * lattice.stiffness[a];
                const double share =
                    lattice.shared_by_cells ? share_of_cells(lattice.size, from, step) : 1;
                parts.links.push_back({.a = std::int32_t(voxel_index(grid, from)),
                                       .b = std::int32_t(voxel_index(grid, from + step)),
                                       .stiffness = share * stiffness,
                                       .damping = share * lattice.link_damping,
                                       .rest_length = norm(r)});
            }
        });
        if (std::min({lattice.size.x, lattice.size.y, lattice.size.z}) > 1)
            each_node([&](Vec3i p) {
                if (p.x + 1 == lattice.size.x || p.y + 1 == lattice.size.y ||
                    p.z + 1 == lattice.size.z)
                    return;
                const auto at = [&](int x, int y, int z) {
                    return std::int32_t(voxel_index(grid, {p.x + x, p.y + y, p.z + z}));
                };
                parts.cells.push_back(
                    {.nodes = {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0), at(0, 0, 1),
                               at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)},
                     .bulk = lattice.bulk});
            });
        if (lattice.density > 0) spread_masses(parts, lattice.density);
        return parts;
    });
}

Result<SpringParts> springs_of_sheet(const SpringSheet& sheet) noexcept {
    return attempt([&]() -> Result<SpringParts> {
        if (sheet.columns < 1 || sheet.rows < 1 ||
            std::int64_t(sheet.columns) * sheet.rows > std::int64_t(100'000'000))
            return invalid("sheet: expected 1 to 100000000 nodes, found " +
                           std::to_string(sheet.columns) + " x " + std::to_string(sheet.rows));
        if (!(std::isfinite(sheet.spacing) && sheet.spacing > 0))
            return invalid("sheet spacing: expected a length above 0");
        SpringParts parts;
        const double height = std::sqrt(0.75) * sheet.spacing;
        for (int row = 0; row < sheet.rows; ++row)
            for (int column = 0; column < sheet.columns; ++column)
                parts.nodes.push_back(
                    {.rest = {sheet.spacing * (column + 0.5 * (row % 2)), height * row, 0},
                     .mass = sheet.node_mass,
                     .damping = sheet.node_damping});
        for (int row = 0; row < sheet.rows; ++row)
            for (int column = 0; column < sheet.columns; ++column) {
                const auto add = [&](int to_column, int to_row) {
                    if (to_column < 0 || to_column >= sheet.columns || to_row >= sheet.rows) return;
                    parts.links.push_back({.a = column + sheet.columns * row,
                                           .b = to_column + sheet.columns * to_row,
                                           .stiffness = sheet.stiffness,
                                           .damping = sheet.link_damping,
                                           .rest_length = sheet.spacing});
                };
                add(column + 1, row);
                add(column - 1 + row % 2, row + 1);
                add(column + row % 2, row + 1);
            }
        return parts;
    });
}

}  // namespace pliant
