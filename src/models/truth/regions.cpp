// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "truth/regions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "material/material_map.h"
#include "volume/boxes.h"
#include "volume/line_transform.h"

namespace pliant::truth {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

}  // namespace

std::vector<float> distances_mm(const Grid& grid, const std::vector<std::uint8_t>& is_source,
                                const TaskArena& arena) {
    std::vector<float> squares(is_source.size());
    for (std::size_t n = 0; n < squares.size(); ++n) squares[n] = is_source[n] ? 0 : kFar;
    const std::size_t strides[3] = {1, std::size_t(grid.size.x),
                                    std::size_t(grid.size.x) * std::size_t(grid.size.y)};
    for (int axis = 0; axis < 3; ++axis) {
        const int b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
        const std::int64_t nb = grid.size[b];
        arena.for_each(nb * grid.size[c], 64, [&](std::int64_t begin, std::int64_t end) {
            LineTransform transform(grid.size[axis]);
            for (; begin < end; ++begin)
                transform.run(squares.data() + std::size_t(begin % nb) * strides[b] +
                                  std::size_t(begin / nb) * strides[c],
                              strides[axis], grid.size[axis], grid.spacing_mm[axis]);
        });
    }
    for (float& square : squares) square = std::sqrt(square);
    return squares;
}

Regions find_regions(const Volume& scan, const ChainMailSettings& materials, double band_mm,
                     bool with_distances, const TaskArena& arena) {
    const Grid& grid = scan.grid;
    Regions regions;
    regions.labels.resize(voxel_count(grid));
    std::vector<std::uint8_t> is_air(regions.labels.size(), 0), is_rigid(regions.labels.size(), 0);
    const MaterialMap map(scan, materials);
    std::visit(
        [&](const auto& voxels) {
            for_each_in(voxel_box(grid), [&](Vec3i p) {
                const std::size_t n = voxel_index(grid, p);
                const double value = double(voxels[n]);
                const bool air = materials.air_enabled && !(value >= materials.air_threshold_hu);
                const bool bone = value > materials.bone_threshold_hu && !map.is_small_bone(p);
                is_air[n] = air;
                is_rigid[n] = bone;
                regions.labels[n] = std::int16_t(air    ? TruthLabel::Air
                                                 : bone ? TruthLabel::Bone
                                                        : TruthLabel::Interior);
            });
        },
        scan.voxels);
    const std::vector<float> air_mm = distances_mm(grid, is_air, arena);
    // Tools keep away from the border.
    Box3i middle;
    for (int a = 0; a < 3; ++a) {
        const int margin = std::min(int(std::ceil(10 / grid.spacing_mm[a])), grid.size[a] / 6) + 1;
        middle.begin[a] = margin;
        middle.end[a] = grid.size[a] - margin;
    }
    const double beside_mm =
        1.01 * std::max({grid.spacing_mm.x, grid.spacing_mm.y, grid.spacing_mm.z});
    for_each_in(voxel_box(grid), [&](Vec3i p) {
        const std::size_t n = voxel_index(grid, p);
        if (regions.labels[n] != std::int16_t(TruthLabel::Interior)) return;
        if (double(air_mm[n]) <= band_mm) regions.labels[n] = std::int16_t(TruthLabel::Wall);
        if (!contains(middle, p)) return;
        (double(air_mm[n]) <= beside_mm ? regions.walls : regions.soft).push_back(std::uint32_t(n));
    });
    if (with_distances) {
        for_each_in(voxel_box(grid), [&](Vec3i p) {
            for (int a = 0; a < 3; ++a)
                if (p[a] == 0 || p[a] == grid.size[a] - 1) is_rigid[voxel_index(grid, p)] = 1;
        });
        regions.rigid_mm = distances_mm(grid, is_rigid, arena);
    }
    return regions;
}

Vec3d inward_normal(const Grid& grid, const std::vector<std::int16_t>& labels, Vec3i voxel) {
    Vec3d sum{0, 0, 0};
    const Vec3i reach{2, 2, 2};
    for_each_in(
        overlap({voxel - reach, voxel + reach + Vec3i{1, 1, 1}}, voxel_box(grid)), [&](Vec3i p) {
            if (labels[voxel_index(grid, p)] == std::int16_t(TruthLabel::Air)) return;
            const Vec3i d = p - voxel;
            sum = sum +
                  Vec3d{d.x * grid.spacing_mm.x, d.y * grid.spacing_mm.y, d.z * grid.spacing_mm.z};
        });
    const double length = norm(sum);
    if (length < 10 * grid.spacing_mm.x) return {0, 0, 0};
    return world_from_lattice_vector(grid, (1 / length) * sum);
}

void label_around(const Grid& grid, const std::vector<std::uint32_t>& voxels, double band_mm,
                  TruthLabel label, std::vector<std::int16_t>& labels) {
    Vec3i reach;
    for (int a = 0; a < 3; ++a) reach[a] = int(band_mm / grid.spacing_mm[a]);
    std::vector<Vec3i> ball;
    for_each_in({-reach, reach + Vec3i{1, 1, 1}}, [&](Vec3i d) {
        const Vec3d mm{d.x * grid.spacing_mm.x, d.y * grid.spacing_mm.y, d.z * grid.spacing_mm.z};
        if (dot(mm, mm) <= band_mm * band_mm) ball.push_back(d);
    });
    for (const std::uint32_t n : voxels) {
        const Vec3i p{int(n % std::uint32_t(grid.size.x)),
                      int(n / std::uint32_t(grid.size.x) % std::uint32_t(grid.size.y)),
                      int(n / std::uint32_t(grid.size.x) / std::uint32_t(grid.size.y))};
        for (const Vec3i d : ball) {
            if (!contains(voxel_box(grid), p + d)) continue;
            std::int16_t& to = labels[voxel_index(grid, p + d)];
            if (to != std::int16_t(TruthLabel::Air) && to != std::int16_t(TruthLabel::Bone))
                to = std::int16_t(label);
        }
    }
}

}  // namespace pliant::truth
