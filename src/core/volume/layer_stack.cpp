// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Hierarchical sampling: blocks of 16³ voxels are halved down to 2³. At each level, one evaluation
// of each shape at the block's centre decides whether the shape is absent, covers the whole block
// (then lower layers are hidden), or must be evaluated in the halves. Single voxels evaluate only
// the few shapes with near surfaces.

#include "volume/layer_stack.h"

#include <array>

namespace pliant::phantom {
namespace {

constexpr std::int32_t kBlock = 16;
constexpr std::int32_t kMinBlock = 2;

/// A voxel's footprint with its eight sub-boxes.
struct Footprint {
    std::array<Vec3d, 8> offsets;  ///< world, centres of the sub-boxes; bit a: upper on axis a
    double reach_mm;               ///< half diagonal of the footprint
    double sub_width_mm;           ///< of a sub-box, mean over the axes
    double voxel_reach_mm;         ///< half diagonal of a voxel

    Footprint(const Grid& grid, double width_voxels) {
        const Vec3d h = width_voxels * grid.spacing_mm;
        for (int corner = 0; corner < 8; ++corner)
            offsets[std::size_t(corner)] = world_from_lattice_vector(
                grid, {(corner & 1 ? 0.25 : -0.25) * h.x, (corner & 2 ? 0.25 : -0.25) * h.y,
                       (corner & 4 ? 0.25 : -0.25) * h.z});
        reach_mm = 0.5 * norm(h);
        voxel_reach_mm = 0.5 * norm(grid.spacing_mm);
        sub_width_mm = (h.x + h.y + h.z) / 6;
    }
};

struct ActiveLayer {
    const Layer* layer;
    bool covers;  ///< covers the whole block
};

/// Fraction of a box around x inside of the layer, from the distances at the centres of its eight
/// parts. @param part  size relative to the footprint: 1, or ½ for one of its parts
/// @param centre  the distance at x
double filled_share(const Layer& layer, Vec3d x, double centre, const Footprint& footprint,
                    double part) {
    std::array<double, 8> d;
    double mean = 0;
    for (std::size_t c = 0; c < 8; ++c) {
        d[c] = layer.distance(x + part * footprint.offsets[c]);
        mean += 0.125 * d[c];
    }
    Vec3d gradient{(d[1] - d[0]) + (d[3] - d[2]) + (d[5] - d[4]) + (d[7] - d[6]),
                   (d[2] - d[0]) + (d[3] - d[1]) + (d[6] - d[4]) + (d[7] - d[5]),
                   (d[4] - d[0]) + (d[5] - d[1]) + (d[6] - d[2]) + (d[7] - d[3])};
    gradient = 0.25 * gradient;
    const double width_mm = part * footprint.sub_width_mm;
    double share = 0;
    // Sheets and threads are not locally plane: each part is evaluated separately.
    if (part == 1 && norm(gradient) < 0.8 * width_mm && std::abs(mean - centre) > 0.08 * width_mm) {
        const double reach = 0.5 * layer.slope * footprint.reach_mm;
        for (std::size_t c = 0; c < 8; ++c) {
            if (d[c] >= reach) continue;
            share += d[c] <= -reach
                         ? 1
                         : filled_share(layer, x + footprint.offsets[c], d[c], footprint, 0.5);
        }
        return share / 8;
    }
    // If both faces of a sheet pass through the box, the differences cancel; then the slope of a
    // true distance is assumed.
    if (norm(gradient) < 0.4 * width_mm) gradient = {width_mm, 0, 0};
    for (double value : d) share += plane_share(value, gradient);
    return share / 8;
}

/// Fraction of the footprint around x inside of the layer.
double coverage(const Layer& layer, Vec3d x, const Footprint& footprint) {
    const double centre = layer.distance(x);
    const double reach = layer.slope * footprint.reach_mm;
    if (centre >= reach) return 0;
    if (centre <= -reach) return 1;
    return filled_share(layer, x, centre, footprint, 1);
}

/// The layers that affect a block, topmost first.
void find_active(const std::vector<ActiveLayer>& above, Vec3d centre, double reach_mm,
                 std::vector<ActiveLayer>& active) {
    active.clear();
    for (const ActiveLayer& a : above) {
        bool covers = a.covers;
        if (!covers) {
            const double distance = a.layer->distance(centre);
            const double reach = a.layer->slope * reach_mm;
            if (distance > reach) continue;
            covers = distance < -reach;
        }
        active.push_back({a.layer, covers});
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

class Sampler {
  public:
    Sampler(const LayerStack& stack, const Grid& grid, std::span<std::int16_t> voxels)
        : m_grid(grid), m_footprint(grid, stack.footprint_voxels), m_voxels(voxels) {
        for (auto layer = stack.layers.rbegin(); layer != stack.layers.rend(); ++layer)
            m_all.push_back({&*layer, false});
    }

    /// @param scratch  one list per block size
    using Scratch = std::array<std::vector<ActiveLayer>, 4>;
    void fill(Vec3i begin, Scratch& scratch) const { fill(begin, kBlock, m_all, 0, scratch); }

  private:
    void fill(Vec3i begin, std::int32_t width, const std::vector<ActiveLayer>& above,
              std::size_t level, Scratch& scratch) const {
        const Vec3i size = m_grid.size;
        if (begin.x >= size.x || begin.y >= size.y || begin.z >= size.z) return;
        const double half = 0.5 * (width - 1);
        const Vec3d middle{begin.x + half, begin.y + half, begin.z + half};
        const double reach = (width - 1) * m_footprint.voxel_reach_mm + m_footprint.reach_mm;
        std::vector<ActiveLayer>& active = scratch[level];
        find_active(above, world_from_voxel(m_grid, middle), reach, active);
        if (width == kMinBlock || active.empty() || active.front().covers) {
            fill_voxels(begin, width, active);
            return;
        }
        const std::int32_t w = width / 2;
        for (int part = 0; part < 8; ++part)
            fill(begin + Vec3i{part & 1 ? w : 0, part & 2 ? w : 0, part & 4 ? w : 0}, w, active,
                 level + 1, scratch);
    }

    void fill_voxels(Vec3i begin, std::int32_t width,
                     const std::vector<ActiveLayer>& active) const {
        const Vec3i end{std::min(begin.x + width, m_grid.size.x),
                        std::min(begin.y + width, m_grid.size.y),
                        std::min(begin.z + width, m_grid.size.z)};
        for (std::int32_t k = begin.z; k < end.z; ++k)
            for (std::int32_t j = begin.y; j < end.y; ++j)
                for (std::int32_t i = begin.x; i < end.x; ++i) {
                    const Vec3d x = world_from_voxel(m_grid, {double(i), double(j), double(k)});
                    const double hu = composite(active, x, m_footprint);
                    m_voxels[voxel_index(m_grid, {i, j, k})] =
                        std::int16_t(std::clamp(std::floor(hu + 0.5), -32768.0, 32767.0));
                }
    }

    const Grid& m_grid;
    Footprint m_footprint;
    std::span<std::int16_t> m_voxels;
    std::vector<ActiveLayer> m_all;
};

}  // namespace

double plane_share(double value, Vec3d gradient) {
    double a = std::abs(gradient.x), b = std::abs(gradient.y), c = std::abs(gradient.z);
    const double greatest = std::max({a, b, c});
    if (greatest <= 0) return value < 0 ? 1.0 : value > 0 ? 0.0 : 0.5;
    // Avoids division by zero; the fraction changes by less than 0.1 %.
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

void sample_layers(const LayerStack& stack, const Grid& grid, const TaskArena& arena,
                   const Progress& progress, std::span<std::int16_t> voxels) {
    const auto blocks = [](std::int32_t size) { return (size + kBlock - 1) / kBlock; };
    const Vec3i count{blocks(grid.size.x), blocks(grid.size.y), blocks(grid.size.z)};
    const Sampler sampler(stack, grid, voxels);
    for (std::int32_t bk = 0; bk < count.z; ++bk) {
        arena.for_each(std::int64_t(count.x) * count.y, 2,
                       [&](std::int64_t begin, std::int64_t end) {
                           Sampler::Scratch scratch;
                           for (std::int64_t b = begin; b < end; ++b)
                               sampler.fill({kBlock * std::int32_t(b % count.x),
                                             kBlock * std::int32_t(b / count.x), kBlock * bk},
                                            scratch);
                       });
        if (progress) progress(double(bk + 1) / count.z);
    }
}

Vec3d walk_to_surface(const ScalarField& distance, Vec3d origin_mm, Vec3d direction,
                      double reach_mm) {
    const Vec3d u = normalized(direction);
    constexpr double kStep_mm = 0.02;
    double t = 0;
    while (t < reach_mm && distance(origin_mm + t * u) > 0) t += kStep_mm;
    return origin_mm + std::min(t, reach_mm) * u;
}

}  // namespace pliant::phantom
