// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/scan_network.h"

#include <pliant/models/springs.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "base/errors.h"
#include "base/text.h"
#include "material/labels.h"
#include "volume/value_unit.h"

namespace pliant {
namespace {

constexpr double kAirShare = 0.01;
constexpr double kAirPoisson = 0.25;  ///< air can leave: it resists no change of volume
constexpr double kPaPerKpa = 1000;
/// Fraction of the longest time step that is stable near rest; a bent network needs shorter ones.
constexpr double kStepShare = 0.6;
constexpr std::int64_t kMaxNodes = 1'000'000;

SpringOrgan organ_of(const LabelMaterial& material) {
    SpringOrgan organ;
    if (material.elastic) {
        organ.young_modulus_pa = kPaPerKpa * material.elastic->young_modulus_kpa;
        organ.poisson_ratio = material.elastic->poisson_ratio;
    }
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    organ.fixed_hu = material.law == LabelLaw::Immobile   ? -kInfinity
                     : material.law == LabelLaw::Constant ? kInfinity
                                                          : material.bone_threshold_hu;
    return organ;
}

/// Adds the tissues of [[label]] tables.
Status add_labels(const Grid& grid, const SpringDeformationSettings& s, SpringScan& scan) {
    const auto materials = std::make_shared<ChainMailSettings>();
    materials->label_materials = s.label_materials;
    for (LabelMaterial& material : materials->label_materials) material.along_direction = false;
    materials->labels = s.labels;
    if (const Status valid = check_labels(*materials, grid); !valid.ok()) return valid;
    for (std::size_t n = 0; n < s.label_materials.size(); ++n) {
        const SpringOrgan organ = scan.organs.emplace_back(organ_of(s.label_materials[n]));
        const double poisson = organ.poisson_ratio.value_or(s.poisson_ratio);
        if (!(poisson >= 0.25 && poisson < 0.5))
            return expected_error("[[label]] " + std::to_string(n + 1) + " elastic",
                                  "a Poisson's ratio from 0.25, below 0.5, for springs",
                                  short_text(poisson));
    }
    if (scan.organs.empty()) return Ok{};
    scan.organ_at = [map = std::make_shared<const LabelMap>(*materials)](Vec3i ijk) {
        return map->law_at(ijk);
    };
    return Ok{};
}

}  // namespace

Status take_materials(const ChainMailSettings& materials,
                      SpringDeformationSettings& settings) noexcept {
    return attempt([&]() -> Status {
        settings.label_materials = materials.label_materials;
        settings.labels = materials.labels;
        return Ok{};
    });
}

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
    scan.poisson_ratio = [poisson = s.poisson_ratio, air = s.air_threshold_hu](double value) {
        return value < air ? kAirPoisson : poisson;
    };
    if (const Status labelled = add_labels(volume.grid, s, scan); !labelled.ok())
        return labelled.error();
    auto parts = springs_of_scan(volume, scan);
    if (!parts.ok()) return parts.error();
    for (SpringNode& node : parts->nodes) node.damping = node.mass / s.damping_s;
    auto network = SpringNetwork::create(std::move(*parts));
    if (!network.ok()) return network.error();
    const double stable = network->stable_time_step();
    // Labels may hold all of a scan, for comparison; pushes are then limited by bone.
    if (!std::isfinite(stable) && s.label_materials.empty())
        return about("fixed_hu", ErrorCode::InvalidArgument,
                     "expected a value that leaves nodes free, found " + short_text(s.fixed_hu) +
                         value_unit(volume) + ", with which bone holds all of them");
    const double step = std::isfinite(stable) ? kStepShare * stable : s.damping_s;
    return SpringTissue::create(std::move(*network), {.depth = s.depth, .time_step = step});
}

}  // namespace pliant
