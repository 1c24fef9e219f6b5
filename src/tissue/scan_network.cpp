// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/scan_network.h"

#include <pliant/springs.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/errors.h"
#include "core/text.h"

namespace pliant {
namespace {

constexpr double kAirShare = 0.01;
/// Fraction of the longest time step that is stable near rest; a bent network needs shorter ones.
constexpr double kStepShare = 0.6;
constexpr std::int64_t kMaxNodes = 1'000'000;

}  // namespace

Result<ControlGrid> control_grid(const Volume& volume, const SpringDeformationSettings& s) {
    const Box3i whole = voxel_box(volume.grid);
    const Box3i region = s.region == Box3i{} ? whole : s.region;
    if (is_empty(region) || !contains(whole, region.begin) ||
        !contains(whole, region.end - Vec3i{1, 1, 1}))
        return about("region", ErrorCode::InvalidArgument,
                     "expected a box of voxels inside of the scan");
    ControlGrid grid;
    std::int64_t nodes = 1;
    for (int a = 0; a < 3; ++a) {
        const int steps = region.end[a] - region.begin[a] - 1;
        grid.cell[a] = std::max(1, int(std::lround(s.cell_mm / volume.grid.spacing_mm[a])));
        const int cells = steps / grid.cell[a];
        if (cells < 2)
            return about("cell_mm", ErrorCode::InvalidArgument,
                         "expected at most " +
                             short_text(std::max(0, steps / 2) * volume.grid.spacing_mm[a]) +
                             ", so that two cells fit into the region along axis " +
                             std::to_string(a) + ", found " + short_text(s.cell_mm));
        grid.size[a] = cells + 1;
        grid.first[a] = region.begin[a] + (steps - cells * grid.cell[a]) / 2;
        nodes *= grid.size[a];
    }
    if (nodes > kMaxNodes)
        return about("cell_mm", ErrorCode::LimitExceeded,
                     "expected cells so large that there are at most " + std::to_string(kMaxNodes) +
                         " nodes, found " + std::to_string(nodes));
    return grid;
}

Result<SpringTissue> tissue_of(const Volume& volume, const ControlGrid& grid,
                               const SpringDeformationSettings& s) {
    SpringScan scan{.region = {grid.first, {}}, .size = grid.size};
    for (int a = 0; a < 3; ++a)
        scan.region.end[a] = grid.first[a] + grid.cell[a] * (grid.size[a] - 1) + 1;
    scan.fixed_hu = s.fixed_hu;
    scan.fixed_share = s.fixed_share;
    scan.young_modulus_pa = [young = s.young_modulus_pa, air = s.air_threshold_hu](double value) {
        return value < air ? kAirShare * young : young;
    };
    auto parts = springs_of_scan(volume, scan);
    if (!parts.ok()) return parts.error();
    for (SpringNode& node : parts->nodes) node.damping = node.mass / s.damping_s;
    auto network = SpringNetwork::create(std::move(*parts));
    if (!network.ok()) return network.error();
    const double step = kStepShare * network->stable_time_step();
    return SpringTissue::create(std::move(*network), {.depth = s.depth, .time_step = step});
}

}  // namespace pliant
