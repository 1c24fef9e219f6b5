// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sampling goes by blocks of 8³ voxels. One look at each shape from the block's centre says whether
// it is absent, covers the whole block (then all below it is hidden), or must be looked at voxel by
// voxel; most blocks are left with a few layers.

#include "volume/phantom_scene.h"

#include <array>

namespace pliant::phantom {
namespace {

constexpr std::int32_t kBlock = 8;

/// The eight sub-boxes of a voxel, and the sizes that decide whether a surface can be near.
struct Footprint {
    std::array<Vec3d, 8> offsets;  ///< world, centres of the sub-boxes; bit a: upper on axis a
    double reach_mm;               ///< from the voxel's centre to its corner
    double block_reach_mm;         ///< the same of a whole block
    double sub_width_mm;           ///< of a sub-box, mean over the axes

    explicit Footprint(const Grid& grid) {
        const Vec3d h = grid.spacing_mm;
        for (int corner = 0; corner < 8; ++corner)
            offsets[std::size_t(corner)] = world_from_lattice_vector(
                grid, {(corner & 1 ? 0.25 : -0.25) * h.x, (corner & 2 ? 0.25 : -0.25) * h.y,
                       (corner & 4 ? 0.25 : -0.25) * h.z});
        reach_mm = 0.5 * norm(h);
        block_reach_mm = kBlock * reach_mm;
        sub_width_mm = (h.x + h.y + h.z) / 6;
    }
};

struct ActiveLayer {
    const Layer* layer;
    bool covers;  ///< the whole block
};

/// Share of the voxel around x that the layer fills.
double coverage(const Layer& layer, Vec3d x, const Footprint& footprint) {
    const double centre = layer.distance(x);
    const double reach = layer.slope * footprint.reach_mm;
    if (centre >= reach) return 0;
    if (centre <= -reach) return 1;
    std::array<double, 8> d;
    for (std::size_t c = 0; c < 8; ++c) d[c] = layer.distance(x + footprint.offsets[c]);
    Vec3d gradient{(d[1] - d[0]) + (d[3] - d[2]) + (d[5] - d[4]) + (d[7] - d[6]),
                   (d[2] - d[0]) + (d[3] - d[1]) + (d[6] - d[4]) + (d[7] - d[5]),
                   (d[4] - d[0]) + (d[5] - d[1]) + (d[6] - d[2]) + (d[7] - d[3])};
    gradient = 0.25 * gradient;
    // Where both faces of a sheet pass through the voxel the differences cancel: then the sheet's
    // sides are taken as steep as a true distance.
    if (norm(gradient) < 0.3 * footprint.sub_width_mm) gradient = {footprint.sub_width_mm, 0, 0};
    double share = 0;
    for (double value : d) share += plane_share(value, gradient);
    return share / 8;
}

/// The layers that a block can see, topmost first.
void find_active(const Scene& scene, Vec3d centre, double reach_mm,
                 std::vector<ActiveLayer>& active) {
    active.clear();
    for (auto layer = scene.layers.rbegin(); layer != scene.layers.rend(); ++layer) {
        const double distance = layer->distance(centre);
        const double reach = layer->slope * reach_mm;
        if (distance > reach) continue;
        const bool covers = distance < -reach;
        active.push_back({&*layer, covers});
        if (covers) return;
    }
}

double composite(const std::vector<ActiveLayer>& active, Vec3d x, const Footprint& footprint) {
    double value = 0, left = 1;
    for (const ActiveLayer& a : active) {
        const double share = a.covers ? 1.0 : coverage(*a.layer, x, footprint);
        if (share <= 0) continue;
        value += left * share * a.layer->hu(x);
        left *= 1 - share;
        if (left < 1e-9) return value;
    }
    return value + left * kAirHu;
}

void fill_block(const Scene& scene, const Grid& grid, const Footprint& footprint, Box3i block,
                std::vector<ActiveLayer>& active, std::span<std::int16_t> voxels) {
    const Vec3d middle{block.begin.x + 0.5 * (kBlock - 1), block.begin.y + 0.5 * (kBlock - 1),
                       block.begin.z + 0.5 * (kBlock - 1)};
    find_active(scene, world_from_voxel(grid, middle), footprint.block_reach_mm, active);
    for (std::int32_t k = block.begin.z; k < block.end.z; ++k)
        for (std::int32_t j = block.begin.y; j < block.end.y; ++j)
            for (std::int32_t i = block.begin.x; i < block.end.x; ++i) {
                const Vec3d x = world_from_voxel(grid, {double(i), double(j), double(k)});
                const double hu = composite(active, x, footprint);
                voxels[voxel_index(grid, {i, j, k})] =
                    std::int16_t(std::clamp(std::floor(hu + 0.5), -32768.0, 32767.0));
            }
}

}  // namespace

double plane_share(double value, Vec3d gradient) {
    double a = std::abs(gradient.x), b = std::abs(gradient.y), c = std::abs(gradient.z);
    const double greatest = std::max({a, b, c});
    if (greatest <= 0) return value < 0 ? 1.0 : value > 0 ? 0.0 : 0.5;
    // Keeps the division sound; the share changes by less than 0.1 %.
    const double least = 1e-3 * greatest;
    a = std::max(a, least), b = std::max(b, least), c = std::max(c, least);
    const double level = 0.5 * (a + b + c) - value;
    if (level <= 0) return 0;
    if (level >= a + b + c) return 1;
    const auto cube = [](double t) { return t > 0 ? t * t * t : 0.0; };
    const double sum = cube(level) - cube(level - a) - cube(level - b) - cube(level - c) +
                       cube(level - a - b) + cube(level - a - c) + cube(level - b - c);
    return clamp01(sum / (6 * a * b * c));
}

void sample_scene(const Scene& scene, const Grid& grid, const TaskArena& arena,
                  const Progress& progress, std::span<std::int16_t> voxels) {
    const auto blocks = [](std::int32_t size) { return (size + kBlock - 1) / kBlock; };
    const Vec3i count{blocks(grid.size.x), blocks(grid.size.y), blocks(grid.size.z)};
    const Footprint footprint(grid);
    for (std::int32_t bk = 0; bk < count.z; ++bk) {
        arena.for_each(std::int64_t(count.x) * count.y, 4,
                       [&](std::int64_t begin, std::int64_t end) {
                           std::vector<ActiveLayer> active;
                           for (std::int64_t b = begin; b < end; ++b) {
                               const Vec3i first{kBlock * std::int32_t(b % count.x),
                                                 kBlock * std::int32_t(b / count.x), kBlock * bk};
                               const Vec3i last{std::min(first.x + kBlock, grid.size.x),
                                                std::min(first.y + kBlock, grid.size.y),
                                                std::min(first.z + kBlock, grid.size.z)};
                               fill_block(scene, grid, footprint, {first, last}, active, voxels);
                           }
                       });
        if (progress) progress(double(bk + 1) / count.z);
    }
}

Vec3d walk_to_surface(const Field& distance, Vec3d origin_mm, Vec3d direction, double reach_mm) {
    const Vec3d u = normalized(direction);
    constexpr double kStep_mm = 0.02;
    double t = 0;
    while (t < reach_mm && distance(origin_mm + t * u) > 0) t += kStep_mm;
    return origin_mm + std::min(t, reach_mm) * u;
}

}  // namespace pliant::phantom
