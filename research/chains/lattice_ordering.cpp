// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chains/lattice_ordering.h"

#include <pliant/volume.h>

#include "chains/graph_limits.h"

namespace pliant {
namespace {

Vec3i step_of(int direction) {
    Vec3i step{0, 0, 0};
    step[axis_of(direction)] = direction % 2 ? -1 : 1;
    return step;
}

/// Range that an element of the thesis allows to a neighbour. It measures in voxels: shear of a
/// link along k is widened by the z-scale, that of other links is not.
HalfLink thesis_region(const ElementLimits& limits, Vec3d spacing_mm, int direction) {
    const int b = axis_of(direction);
    const bool up = direction % 2 == 0;
    HalfLink region{};
    for (int a = 0; a < 3; ++a) {
        const double shear = (b == 2 ? spacing_mm.z : spacing_mm[a]) * limits.shear[b];
        const double low = spacing_mm[b] * (up ? limits.compress : limits.stretch)[b];
        const double high = spacing_mm[b] * (up ? limits.stretch : limits.compress)[b];
        region.low[a] = 2 * limit_units_from_mm((a == b ? low : shear) / 2);
        region.high[a] = 2 * limit_units_from_mm((a == b ? high : shear) / 2);
    }
    return region;
}

}  // namespace

LatticeOrdering::LatticeOrdering(const ChainLattice& lattice, Regions regions)
    : PublishedOrdering([&] {
          std::vector<Bounds> bounds(voxel_count({.size = lattice.size}));
          for (std::size_t e = 0; e < bounds.size(); ++e) {
              const ElementLimits& limits =
                  lattice.materials[lattice.material.empty() ? 0 : lattice.material[e]];
              bounds[e] = {float(std::min(limits.max_movement_mm, kMaxMovementMm)), limits.fixed};
          }
          return bounds;
      }()),
      m_regions(regions),
      m_material(lattice.material) {
    const Grid grid{.size = lattice.size};
    const Vec3d h = lattice.spacing_mm;
    for (const ElementLimits& limits : lattice.materials)
        for (int d = 0; d < kWays; ++d) {
            const Vec3i step = step_of(d);
            const HalfLink share =
                regions == Regions::OfSponsor
                    ? thesis_region(limits, h, d)
                    : half_link(limits, {h.x * step.x, h.y * step.y, h.z * step.z});
            m_shares.push_back({-mm_from_units(share.low), mm_from_units(share.high)});
        }
    const auto is_there = [&](Vec3i e) {
        return contains(voxel_box(grid), e) &&
               (lattice.present.empty() || lattice.present[voxel_index(grid, e)]);
    };
    for (int d = 0; d < kWays; ++d) {
        const Vec3i step = step_of(d);
        m_step[std::size_t(d)] = step.x + lattice.size.x * (step.y + lattice.size.y * step.z);
    }
    m_sides.reserve(voxel_count(grid));
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) {
                unsigned sides = 0;
                for (int d = 0; d < kWays; ++d)
                    if (is_there({i, j, k}) && is_there(Vec3i{i, j, k} + step_of(d)))
                        sides |= 1u << d;
                m_sides.push_back(std::uint8_t(sides));
            }
}

}  // namespace pliant
