// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The control lattice over a scan: built along the grid's axes, then transformed to the world.

#include <pliant/models/springs.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "volume/value_unit.h"

namespace pliant {
namespace {

constexpr double kTissueYoung_pa = 15e3, kAirYoung_pa = 150, kAirBelow_hu = -500;
constexpr double kLinksAlone = 0.25;  ///< their Poisson's ratio

Error bad_lattice(const std::string& text) {
    return {ErrorCode::InvalidArgument, "control lattice " + text};
}

/// Voxels of one organ, or of none, around a node.
struct Around {
    double share = 0, mean = 0;
};

/// Index into the voxels around a node, and into the organs with none first.
std::size_t organ_of(const SpringScan& scan, Vec3i ijk) {
    const int organ = scan.organ_at && !scan.organs.empty() ? scan.organ_at(ijk) : -1;
    return organ >= 0 && std::size_t(organ) < scan.organs.size() ? std::size_t(organ) + 1 : 0;
}

/// The voxels that are nearer to a node than to its neighbours, by organ. @param[out] around
void look_around(const Volume& volume, const SpringScan& scan, Vec3d centre, Vec3d spacing,
                 const Box3i& region, std::vector<Around>& around) {
    Vec3i low, high;
    for (int a = 0; a < 3; ++a) {
        low[a] = std::clamp(int(std::ceil(centre[a] - spacing[a] / 2)), region.begin[a],
                            region.end[a] - 1);
        high[a] =
            std::clamp(int(std::floor(centre[a] + spacing[a] / 2)), low[a], region.end[a] - 1);
    }
    around.assign(scan.organs.size() + 1, {});
    for (int k = low.z; k <= high.z; ++k)
        for (int j = low.y; j <= high.y; ++j)
            for (int i = low.x; i <= high.x; ++i) {
                Around& own = around[organ_of(scan, {i, j, k})];
                own.share += 1;
                own.mean += double(volume.at({i, j, k}));
            }
    const Vec3i n = high - low + Vec3i{1, 1, 1};
    for (Around& own : around) {
        own.mean /= std::max(1.0, own.share);
        own.share /= double(n.x) * n.y * n.z;
    }
}

/// Elastic properties of a node, and whether it is fixed.
struct NodeElasticity {
    double stiffness = 0, bulk = 0;
    bool hard = false;
};

double fixed_hu_of(const SpringScan& scan, std::size_t organ) {
    return organ == 0 ? scan.fixed_hu : scan.organs[organ - 1].fixed_hu.value_or(scan.fixed_hu);
}

/// @param edge  of a cube with a cell's volume [mm]
Result<NodeElasticity> elasticity_of(const Volume& volume, const SpringScan& scan,
                                     const std::vector<Around>& around, double edge) {
    NodeElasticity node;
    double hard = 0;
    for (std::size_t n = 0; n < around.size(); ++n) {
        const auto [share, hu] = around[n];
        if (share == 0) continue;
        double young = scan.young_modulus_pa ? scan.young_modulus_pa(hu)
                       : hu < kAirBelow_hu   ? kAirYoung_pa
                                             : kTissueYoung_pa;
        double poisson = scan.poisson_ratio ? scan.poisson_ratio(hu) : kLinksAlone;
        if (n > 0) {
            young = scan.organs[n - 1].young_modulus_pa.value_or(young);
            poisson = scan.organs[n - 1].poisson_ratio.value_or(poisson);
        }
        const auto bad = [&, hu = hu](const char* name, const char* expected, double found) {
            return bad_lattice(std::string(name) + ": expected numbers " + expected + ", found " +
                               std::to_string(found) + " at " + std::to_string(hu) +
                               value_unit(volume));
        };
        if (!(std::isfinite(young) && young > 0)) return bad("young_modulus_pa", "above 0", young);
        if (!(poisson >= kLinksAlone && poisson < 0.5))
            return bad("poisson_ratio", "from 0.25, below 0.5", poisson);
        // The bulk is exactly 0 at 1/4.
        const SpringMaterial own = poisson == kLinksAlone ? SpringMaterial{0.4 * young * edge, 0}
                                                          : closed_form(young, poisson, edge);
        node.stiffness += share * own.stiffness;
        node.bulk += share * std::max(0.0, own.bulk);
        if (hu > fixed_hu_of(scan, n)) hard += share;
    }
    node.hard = hard > 0.5;
    return node;
}

/// [cell]: share of hard voxels. A voxel between two cells counts in the later one, or in the last.
std::vector<double> hard_shares(const Volume& volume, const SpringScan& scan, const Box3i& region,
                                Vec3d step) {
    const Vec3i cells = scan.size - Vec3i{1, 1, 1};
    std::vector<double> hard(std::size_t(cells.x) * std::size_t(cells.y) * std::size_t(cells.z));
    std::vector<std::int32_t> voxels(hard.size());
    std::vector<int> along[3];
    for (int a = 0; a < 3; ++a)
        for (int n = 0; n < region.end[a] - region.begin[a]; ++n)
            along[a].push_back(std::min(int((n + 1e-9) / step[a]), cells[a] - 1));
    for (int k = region.begin.z; k < region.end.z; ++k)
        for (int j = region.begin.y; j < region.end.y; ++j) {
            const int z = along[2][std::size_t(k - region.begin.z)];
            const int y = along[1][std::size_t(j - region.begin.y)];
            const auto row =
                std::size_t(cells.x) * (std::size_t(cells.y) * std::size_t(z) + std::size_t(y));
            for (int i = region.begin.x; i < region.end.x; ++i) {
                const auto c = row + std::size_t(along[0][std::size_t(i - region.begin.x)]);
                hard[c] +=
                    double(volume.at({i, j, k})) > fixed_hu_of(scan, organ_of(scan, {i, j, k}));
                ++voxels[c];
            }
        }
    for (std::size_t c = 0; c < hard.size(); ++c) hard[c] /= std::max(1, voxels[c]);
    return hard;
}

}  // namespace

Result<SpringParts> springs_of_scan(const Volume& volume, const SpringScan& scan) noexcept {
    return attempt([&]() -> Result<SpringParts> {
        if (const Status s = check_volume(volume); !s.ok()) return s.error();
        const Box3i whole = voxel_box(volume.grid);
        const Box3i region = scan.region == Box3i{} ? whole : scan.region;
        if (is_empty(region) || !contains(whole, region.begin) ||
            !contains(whole, region.end - Vec3i{1, 1, 1}))
            return bad_lattice("region: expected a box of voxels inside of the scan");
        const Vec3i voxels = region.end - region.begin;
        if (!(scan.fixed_share >= 0 && scan.fixed_share <= 1))
            return bad_lattice("fixed_share: expected 0 to 1, found " +
                               std::to_string(scan.fixed_share));
        Vec3d step;  // voxels between nodes
        for (int a = 0; a < 3; ++a) {
            if (scan.size[a] < 2 || scan.size[a] > voxels[a])
                return bad_lattice("size: expected 2 to " + std::to_string(voxels[a]) +
                                   " nodes along axis " + std::to_string(a) + ", found " +
                                   std::to_string(scan.size[a]));
            step[a] = double(voxels[a] - 1) / (scan.size[a] - 1);
        }
        const Vec3d h = volume.grid.spacing_mm;
        const Vec3d spacing{h.x * step.x, h.y * step.y, h.z * step.z};
        auto parts = springs_of_lattice({.size = scan.size,
                                         .spacing = spacing,
                                         .links = scan.links,
                                         .node_damping = scan.node_damping,
                                         .density = scan.density_g_mm3,
                                         .shared_by_cells = scan.shared_by_cells});
        if (!parts.ok()) return parts.error();
        const double edge = std::cbrt(spacing.x * spacing.y * spacing.z);
        const Grid nodes{.size = scan.size};
        std::vector<NodeElasticity> tissues(parts->nodes.size());
        std::vector<Around> around;
        for (int k = 0; k < scan.size.z; ++k)
            for (int j = 0; j < scan.size.y; ++j)
                for (int i = 0; i < scan.size.x; ++i) {
                    const Vec3d ijk{region.begin.x + step.x * i, region.begin.y + step.y * j,
                                    region.begin.z + step.z * k};
                    const std::size_t n = voxel_index(nodes, {i, j, k});
                    look_around(volume, scan, ijk, step, region, around);
                    const Result<NodeElasticity> tissue = elasticity_of(volume, scan, around, edge);
                    if (!tissue.ok()) return tissue.error();
                    tissues[n] = *tissue;
                    const bool at_border = i == 0 || j == 0 || k == 0 || i == scan.size.x - 1 ||
                                           j == scan.size.y - 1 || k == scan.size.z - 1;
                    SpringNode& node = parts->nodes[n];
                    node.rest = world_from_voxel(volume.grid, ijk);
                    node.fixed = tissue->hard || (scan.fixed_border && at_border);
                }
        if (scan.fixed_share < 1) {
            const std::vector<double> hard = hard_shares(volume, scan, region, step);
            for (std::size_t c = 0; c < hard.size(); ++c)
                if (hard[c] > scan.fixed_share)
                    for (const std::int32_t n : parts->cells[c].nodes)
                        parts->nodes[std::size_t(n)].fixed = true;
        }
        for (SpringLink& link : parts->links) {
            const double share = scan.shared_by_cells ? link.stiffness : 1;
            link.stiffness =
                share *
                (tissues[std::size_t(link.a)].stiffness + tissues[std::size_t(link.b)].stiffness) /
                2;
        }
        for (SpringCell& cell : parts->cells)
            for (const std::int32_t n : cell.nodes) cell.bulk += tissues[std::size_t(n)].bulk / 8;
        // A left-handed grid inverts cells: their bottoms and tops are exchanged.
        if (determinant(volume.grid.direction) < 0)
            for (SpringCell& cell : parts->cells)
                std::rotate(cell.nodes.begin(), cell.nodes.begin() + 4, cell.nodes.end());
        return parts;
    });
}

}  // namespace pliant
