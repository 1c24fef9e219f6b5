// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "scene/scan_network.h"

#include <pliant/springs_builders.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/errors.h"

namespace pliant {
namespace {

constexpr double kAirBelow_hu = -500, kAirShare = 0.01;
/// Of the longest time step that is sure to be stable near rest; a bent network wants shorter ones.
constexpr double kStepShare = 0.6;
constexpr std::int64_t kMaxNodes = 1'000'000;

}  // namespace

std::string hundredths(double number) {
    std::string text = std::to_string(number);
    text.erase(std::min(text.size(), text.find('.') + 3));
    return text;
}

Status check_settings(const SpringDeformationSettings& s) {
    const auto expected = [](const char* name, const char* what, double found) -> Status {
        return invalid(std::string(name) + ": expected " + what + ", found " + hundredths(found));
    };
    if (!(s.cell_mm > 0 && s.cell_mm <= 1000))
        return expected("cell_mm", "a length above 0, up to 1000 mm", s.cell_mm);
    if (!(s.young_modulus_pa >= 1 && s.young_modulus_pa <= 1e9))
        return expected("young_modulus_pa", "1 to 1e9 Pa", s.young_modulus_pa);
    if (!std::isfinite(s.fixed_above_hu))
        return expected("fixed_above_hu", "a number", s.fixed_above_hu);
    if (!(s.fixed_share >= 0 && s.fixed_share <= 1))
        return expected("fixed_share", "0 to 1", s.fixed_share);
    if (!(s.damping_s >= 1e-4 && s.damping_s <= 1e4))
        return expected("damping_s", "0.0001 to 10000 s", s.damping_s);
    if (s.depth < 0) return expected("depth", "0 layers or more", s.depth);
    return Ok{};
}

Result<ControlGrid> control_grid(const Volume& volume, const SpringDeformationSettings& s) {
    const Box3i whole = voxel_box(volume.grid);
    const Box3i region = s.region == Box3i{} ? whole : s.region;
    if (is_empty(region) || !contains(whole, region.begin) ||
        !contains(whole, region.end - Vec3i{1, 1, 1}))
        return invalid("region: expected a box of voxels inside of the scan");
    ControlGrid grid;
    std::int64_t nodes = 1;
    for (int a = 0; a < 3; ++a) {
        const int steps = region.end[a] - region.begin[a] - 1;
        grid.cell[a] = std::max(1, int(std::lround(s.cell_mm / volume.grid.spacing_mm[a])));
        const int cells = steps / grid.cell[a];
        if (cells < 2)
            return invalid("cell_mm: expected at most " +
                           hundredths(std::max(0, steps / 2) * volume.grid.spacing_mm[a]) +
                           ", so that two cells fit into the region along axis " +
                           std::to_string(a) + ", found " + hundredths(s.cell_mm));
        grid.size[a] = cells + 1;
        grid.first[a] = region.begin[a] + (steps - cells * grid.cell[a]) / 2;
        nodes *= grid.size[a];
    }
    if (nodes > kMaxNodes)
        return Error{ErrorCode::LimitExceeded,
                     "cell_mm: expected cells so large that there are at most " +
                         std::to_string(kMaxNodes) + " nodes, found " + std::to_string(nodes)};
    return grid;
}

Result<SpringTissue> tissue_of(const Volume& volume, const ControlGrid& grid,
                               const SpringDeformationSettings& s) {
    SpringScan scan{.region = {grid.first, {}}, .size = grid.size};
    for (int a = 0; a < 3; ++a)
        scan.region.end[a] = grid.first[a] + grid.cell[a] * (grid.size[a] - 1) + 1;
    scan.fixed_above_hu = s.fixed_above_hu;
    scan.fixed_share = s.fixed_share;
    scan.young_modulus_pa = [young = s.young_modulus_pa](double hu) {
        return hu < kAirBelow_hu ? kAirShare * young : young;
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
