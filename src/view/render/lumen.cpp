// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/lumen.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "render/voxel_field.h"
#include "volume/line_transform.h"

namespace pliant::render {
namespace {

constexpr double kMaxCells = 3e6;

Vec3i steps_for(const Grid& grid) {
    const Vec3d s = grid.spacing_mm;
    for (double pitch = std::min({s.x, s.y, s.z});; pitch *= 1.2) {
        Vec3i step{1, 1, 1};
        double cells = 1;
        for (int a = 0; a < 3; ++a) {
            step[a] = std::clamp(int(std::lround(std::min(pitch / s[a], 1e6))), 1,
                                 std::max(grid.size[a], 1));
            cells *= std::ceil(double(grid.size[a]) / step[a]);
        }
        if (cells <= kMaxCells) return step;
    }
}

template <class T>
float block_mean(const VoxelField<T>& field, Vec3i begin, Vec3i end) {
    double sum = 0;
    int count = 0;
    for (int z = begin.z; z < end.z; ++z)
        for (int y = begin.y; y < end.y; ++y)
            for (int x = begin.x; x < end.x; ++x, ++count) sum += double(*field.at({x, y, z}));
    return float(sum / std::max(count, 1));
}

/// A connected part of the mask.
struct Part {
    std::vector<std::size_t> cells;
    std::size_t border_cells = 0;
};

/// Flood fill: collects the cells connected to a seed by faces, and marks them (2).
Part collect(const CoarseVolume& coarse, std::vector<std::uint8_t>& mask, std::size_t seed) {
    Part part;
    part.cells.push_back(seed);
    mask[seed] = 2;
    for (std::size_t next = 0; next < part.cells.size(); ++next) {
        const Vec3i p = coarse.cell(part.cells[next]);
        bool border = false;
        for (int side = 0; side < 6; ++side) {
            Vec3i q = p;
            q[side / 2] += side % 2 ? 1 : -1;
            if (!contains({{0, 0, 0}, coarse.size}, q)) {
                border = true;
                continue;
            }
            const std::size_t i = coarse.index(q);
            if (mask[i] != 1) continue;
            mask[i] = 2;
            part.cells.push_back(i);
        }
        part.border_cells += border ? 1 : 0;
    }
    return part;
}

}  // namespace

CoarseVolume make_coarse(const Volume& volume, const TaskArena& arena) {
    CoarseVolume coarse;
    const Grid& grid = volume.grid;
    coarse.step = steps_for(grid);
    std::size_t count = 1;
    for (int a = 0; a < 3; ++a) {
        coarse.size[a] = (grid.size[a] + coarse.step[a] - 1) / coarse.step[a];
        coarse.spacing_mm[a] = grid.spacing_mm[a] * coarse.step[a];
        count *= std::size_t(coarse.size[a]);
    }
    coarse.mean_hu.resize(count);
    with_field(volume, [&](const auto& field) {
        arena.for_each(std::int64_t(count), 4096, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin; i < end; ++i) {
                const Vec3i c = coarse.cell(std::size_t(i)), s = coarse.step, n = grid.size;
                const Vec3i first{c.x * s.x, c.y * s.y, c.z * s.z};
                coarse.mean_hu[std::size_t(i)] =
                    block_mean(field, first,
                               {std::min(first.x + s.x, n.x), std::min(first.y + s.y, n.y),
                                std::min(first.z + s.z, n.z)});
            }
        });
    });
    return coarse;
}

Vec3d voxel_of_cell(const CoarseVolume& coarse, const Grid& grid, std::size_t cell) {
    const Vec3i c = coarse.cell(cell);
    Vec3d ijk{};
    for (int a = 0; a < 3; ++a) {
        const int begin = c[a] * coarse.step[a];
        ijk[a] = 0.5 * (begin + std::min(begin + coarse.step[a], grid.size[a]) - 1);
    }
    return ijk;
}

std::vector<std::uint8_t> lumen_mask(const CoarseVolume& coarse, double threshold_hu,
                                     Polarity polarity, bool allow_outside) {
    // A trachea cut by the scan's border takes well below 1 % of it; air around a body far more.
    constexpr double kOutsideShare = 0.015;
    const auto n = coarse.size;
    const double border = 2.0 * (double(n.x) * n.y + double(n.y) * n.z + double(n.z) * n.x);
    std::vector<std::uint8_t> mask(coarse.mean_hu.size());
    for (std::size_t i = 0; i < mask.size(); ++i)
        mask[i] = (double(coarse.mean_hu[i]) < threshold_hu) == (polarity == Polarity::Rising);
    if (allow_outside) return mask;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        if (mask[i] != 1) continue;
        const Part part = collect(coarse, mask, i);
        if (double(part.border_cells) <= kOutsideShare * border) continue;
        for (std::size_t cell : part.cells) mask[cell] = 0;
    }
    for (std::uint8_t& m : mask) m = m != 0;
    return mask;
}

std::vector<std::uint32_t> part_sizes(const CoarseVolume& coarse, std::vector<std::uint8_t> mask) {
    std::vector<std::uint32_t> sizes(mask.size());
    for (std::size_t i = 0; i < mask.size(); ++i) {
        if (mask[i] != 1) continue;
        const Part part = collect(coarse, mask, i);
        for (const std::size_t cell : part.cells) sizes[cell] = std::uint32_t(part.cells.size());
    }
    return sizes;
}

double share_behind_tissue(const CoarseVolume& coarse, Vec3i cell, double tissue_hu,
                           double thickness_mm) {
    static const std::vector<Vec3d> directions = sphere_directions(60);
    const Vec3d s = coarse.spacing_mm;
    const double step_mm = std::min({s.x, s.y, s.z});
    int behind = 0;
    for (const Vec3d way : directions) {
        double tissue_mm = 0;
        for (double t = step_mm; tissue_mm < thickness_mm; t += step_mm) {
            const Vec3i at{int(std::lround(cell.x + t * way.x / s.x)),
                           int(std::lround(cell.y + t * way.y / s.y)),
                           int(std::lround(cell.z + t * way.z / s.z))};
            if (!contains({{0, 0, 0}, coarse.size}, at)) break;
            if (double(coarse.mean_hu[coarse.index(at)]) >= tissue_hu) tissue_mm += step_mm;
        }
        behind += tissue_mm >= thickness_mm;
    }
    return double(behind) / double(directions.size());
}

std::vector<float> wall_distance_mm(const CoarseVolume& coarse,
                                    const std::vector<std::uint8_t>& mask, const TaskArena& arena) {
    std::vector<float> squares(mask.size());
    for (std::size_t i = 0; i < mask.size(); ++i)
        squares[i] = mask[i] ? std::numeric_limits<float>::infinity() : 0.0f;
    const auto n = coarse.size;
    const std::size_t stride[3] = {1, std::size_t(n.x), std::size_t(n.x) * std::size_t(n.y)};
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        arena.for_each(std::int64_t(n[u]) * n[v], 256, [&](std::int64_t begin, std::int64_t end) {
            LineTransform transform(n[axis]);
            for (std::int64_t line = begin; line < end; ++line) {
                const auto first =
                    std::size_t(line % n[u]) * stride[u] + std::size_t(line / n[u]) * stride[v];
                transform.run(squares.data() + first, stride[axis], n[axis],
                              coarse.spacing_mm[axis]);
            }
        });
    }
    for (float& s : squares) s = std::sqrt(s);
    return squares;
}

std::vector<Vec3d> sphere_directions(int count) {
    std::vector<Vec3d> directions;
    const double turn = std::numbers::pi * (3 - std::sqrt(5.0));  // the golden angle
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z);
        directions.push_back({r * std::cos(turn * i), r * std::sin(turn * i), z});
    }
    return directions;
}

}  // namespace pliant::render
