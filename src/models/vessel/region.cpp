// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A lumen in a scan: voxels connected through faces, then a smooth surface around them. The binary
// region is blurred with a Gaussian, and its surface is the level one half: flat edges keep their
// position, and steps become slopes. The region is extended beyond the scan's border, which cuts it
// off flat.

#include <pliant/mesh.h>

#include <algorithm>
#include <cmath>

#include "base/errors.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

using Mask = std::vector<std::uint8_t>;

constexpr Vec3i kNeighbours[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                  {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

/// Flood fill from a voxel: changes mask from 1 to 2. @returns number of voxels
std::int64_t fill(const Grid& grid, Mask& mask, Vec3i seed) {
    std::vector<Vec3i> front{seed};
    mask[voxel_index(grid, seed)] = 2;
    std::int64_t count = 0;
    while (!front.empty()) {
        const Vec3i at = front.back();
        front.pop_back();
        ++count;
        for (const Vec3i& step : kNeighbours) {
            const Vec3i next = at + step;
            if (!contains(voxel_box(grid), next)) continue;
            auto& value = mask[voxel_index(grid, next)];
            if (value != 1) continue;
            value = 2;
            front.push_back(next);
        }
    }
    return count;
}

/// The blurred region in its bounding box.
struct Blurred {
    Vec3i begin, size;
    std::vector<float> values;

    float at(Vec3i p) const {  // voxels of the grid, clamped to the box
        Vec3i q{};
        for (int a = 0; a < 3; ++a) q[a] = std::clamp(p[a] - begin[a], 0, size[a] - 1);
        return values[std::size_t(q.x) +
                      std::size_t(size.x) *
                          (std::size_t(q.y) + std::size_t(size.y) * std::size_t(q.z))];
    }
    double linear(Vec3d ijk) const {
        const Vec3i low{int(std::floor(ijk.x)), int(std::floor(ijk.y)), int(std::floor(ijk.z))};
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            double weight = 1;
            Vec3i p = low;
            for (int a = 0; a < 3; ++a) {
                const double t = ijk[a] - low[a];
                const bool high = corner >> a & 1;
                p[a] += high;
                weight *= high ? t : 1 - t;
            }
            sum += weight * double(at(p));
        }
        return sum;
    }
};

Blurred blur(const Grid& grid, const Mask& mask, const Box3i& box, double sigma,
             const TaskArena& arena) {
    const int reach = int(std::ceil(3 * sigma)) + 1;
    Blurred b;
    for (int a = 0; a < 3; ++a) {
        b.begin[a] = std::max(0, box.begin[a] - reach);
        b.size[a] = std::min(grid.size[a], box.end[a] + reach) - b.begin[a];
    }
    b.values.resize(std::size_t(b.size.x) * std::size_t(b.size.y) * std::size_t(b.size.z));
    std::size_t n = 0;
    for (int k = 0; k < b.size.z; ++k)
        for (int j = 0; j < b.size.y; ++j)
            for (int i = 0; i < b.size.x; ++i)
                b.values[n++] = mask[voxel_index(grid, b.begin + Vec3i{i, j, k})] == 2;
    if (!(sigma > 0)) return b;
    std::vector<float> weights;
    double sum = 0;
    for (int w = -reach; w <= reach; ++w) {
        weights.push_back(float(std::exp(-0.5 * w * w / (sigma * sigma))));
        sum += double(weights.back());
    }
    for (float& w : weights) w = float(double(w) / sum);
    const std::size_t strides[3] = {1, std::size_t(b.size.x),
                                    std::size_t(b.size.x) * std::size_t(b.size.y)};
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3, length = b.size[axis];
        arena.for_each(b.size[v], 1, [&](std::int64_t begin, std::int64_t end) {
            std::vector<float> line(std::size_t(length), 0.F);
            for (std::int64_t at_v = begin; at_v < end; ++at_v)
                for (int at_u = 0; at_u < b.size[u]; ++at_u) {
                    float* const first = b.values.data() + std::size_t(at_u) * strides[u] +
                                         std::size_t(at_v) * strides[v];
                    for (int p = 0; p < length; ++p)
                        line[std::size_t(p)] = first[std::size_t(p) * strides[axis]];
                    for (int p = 0; p < length; ++p) {
                        float value = 0;
                        for (int w = -reach; w <= reach; ++w)
                            value += weights[std::size_t(w + reach)] *
                                     line[std::size_t(std::clamp(p + w, 0, length - 1))];
                        first[std::size_t(p) * strides[axis]] = value;
                    }
                }
        });
    }
    return b;
}

/// Openings at the scan's border: the connected parts of the region on each of the six faces.
std::vector<VesselEnd> ends_at_border(const Grid& grid, const Mask& mask) {
    std::vector<VesselEnd> ends;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const int layer = face % 2 ? grid.size[axis] - 1 : 0;
        Mask flat(std::size_t(grid.size[u]) * std::size_t(grid.size[v]));
        const Grid plane{.size = {grid.size[u], grid.size[v], 1}};
        const auto on_grid = [&](Vec3i p) {
            Vec3i q{};
            q[axis] = layer;
            q[u] = p.x;
            q[v] = p.y;
            return q;
        };
        for (int j = 0; j < grid.size[v]; ++j)
            for (int i = 0; i < grid.size[u]; ++i)
                flat[voxel_index(plane, {i, j, 0})] =
                    mask[voxel_index(grid, on_grid({i, j, 0}))] == 2;
        for (int j = 0; j < grid.size[v]; ++j)
            for (int i = 0; i < grid.size[u]; ++i) {
                if (flat[voxel_index(plane, {i, j, 0})] != 1) continue;
                const auto count = double(fill(plane, flat, {i, j, 0}));
                Vec3d sum{0, 0, 0};
                double farthest = 0;
                for (int pass = 0; pass < 2; ++pass)
                    for (int q = 0; q < grid.size[v]; ++q)
                        for (int p = 0; p < grid.size[u]; ++p) {
                            auto& value = flat[voxel_index(plane, {p, q, 0})];
                            if (value != 2) continue;
                            const Vec3i at = on_grid({p, q, 0});
                            const Vec3d x =
                                world_from_voxel(grid, {double(at.x), double(at.y), double(at.z)});
                            if (pass == 0) sum = sum + (1 / count) * x;
                            if (pass == 1) {
                                farthest = std::max(farthest, norm(x - sum));
                                value = 0;
                            }
                        }
                const Vec3d outward = (face % 2 ? 1.0 : -1.0) * grid.direction.columns[axis];
                const double step = std::max(grid.spacing_mm[u], grid.spacing_mm[v]);
                ends.push_back(
                    {sum - (1.5 * grid.spacing_mm[axis]) * outward, outward, farthest + step});
            }
    }
    return ends;
}

Result<Lumen> lumen_of(const Volume& volume, const Mask& mask, std::int64_t count, double smoothing,
                       const TaskArena& arena) {
    const Grid& grid = volume.grid;
    Box3i box{grid.size, {0, 0, 0}};
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) {
                if (mask[voxel_index(grid, {i, j, k})] != 2) continue;
                const Vec3i p{i, j, k};
                for (int a = 0; a < 3; ++a) {
                    box.begin[a] = std::min(box.begin[a], p[a]);
                    box.end[a] = std::max(box.end[a], p[a] + 1);
                }
            }
    const Blurred blurred = blur(grid, mask, box, smoothing, arena);
    const auto level = [&](Vec3d x) {
        const Vec3d ijk = voxel_from_world(grid, x);
        double inside = blurred.linear(ijk) - 0.5;
        for (int a = 0; a < 3; ++a)  // the border is half a voxel around the outermost centres
            inside = std::min({inside, ijk[a] + 0.5, grid.size[a] - 0.5 - ijk[a]});
        return inside;
    };
    StuffingSettings s;
    s.cell_mm = std::min({grid.spacing_mm.x, grid.spacing_mm.y, grid.spacing_mm.z});
    Vec3d low{1e300, 1e300, 1e300}, high = -low;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3d ijk{};
        for (int a = 0; a < 3; ++a)
            ijk[a] = corner >> a & 1 ? box.end[a] + smoothing : box.begin[a] - 1 - smoothing;
        const Vec3d x = world_from_voxel(grid, ijk);
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], x[a]);
            high[a] = std::max(high[a], x[a]);
        }
    }
    s.begin_mm = low;
    s.end_mm = high;
    auto solid = stuff_isosurface(level, s, arena);
    if (!solid) return solid.error();
    make_manifold(*solid);
    Lumen lumen;
    lumen.surface = boundary_triangles(*solid);
    lumen.ends = ends_at_border(grid, mask);
    lumen.voxels = count;
    lumen.region_mm3 = double(count) * grid.spacing_mm.x * grid.spacing_mm.y * grid.spacing_mm.z;
    return lumen;
}

/// Removes voxels farther than this from a path, with bounding boxes of its pieces for speed.
void keep_near(const Grid& grid, Mask& mask, std::span<const Vec3d> way, double within) {
    Mask near(mask.size(), 0);
    for (std::size_t n = 0; n < way.size(); ++n) {
        const Vec3d a = way[n], u = way[std::min(n + 1, way.size() - 1)] - a;
        Vec3d low{1e300, 1e300, 1e300}, high = -low;
        for (int corner = 0; corner < 16; ++corner) {
            const Vec3d from = corner & 8 ? a + u : a;
            Vec3d x = from;
            for (int c = 0; c < 3; ++c) x[c] += (corner >> c & 1 ? within : -within);
            const Vec3d ijk = voxel_from_world(grid, x);
            for (int c = 0; c < 3; ++c) {
                low[c] = std::min(low[c], ijk[c]);
                high[c] = std::max(high[c], ijk[c]);
            }
        }
        Vec3i begin{}, end{};
        for (int c = 0; c < 3; ++c) {
            const double size = grid.size[c];
            begin[c] = int(std::clamp(std::floor(low[c]), 0.0, size));
            end[c] = int(std::clamp(std::ceil(high[c]) + 1, 0.0, size));
        }
        const double length2 = dot(u, u);
        for (int k = begin.z; k < end.z; ++k)
            for (int j = begin.y; j < end.y; ++j)
                for (int i = begin.x; i < end.x; ++i) {
                    const Vec3d x = world_from_voxel(grid, {double(i), double(j), double(k)}) - a;
                    const double t = length2 > 0 ? std::clamp(dot(x, u) / length2, 0.0, 1.0) : 0;
                    if (norm(x - t * u) <= within) near[voxel_index(grid, {i, j, k})] = 1;
                }
    }
    for (std::size_t n = 0; n < mask.size(); ++n) mask[n] = mask[n] && near[n];
}

Status check_smoothing(double voxels) {
    if (voxels >= 0 && voxels <= 20) return Ok{};
    return vessel::wrong("smoothing_voxels is " + std::to_string(voxels) + ", expected 0 to 20");
}

Result<Lumen> find_region(const Volume& volume, const RegionSettings& settings,
                          const TaskArena& arena) {
    if (const Status s = check_volume(volume); !s.ok()) return s.error();
    if (const Status s = check_smoothing(settings.smoothing_voxels); !s) return s.error();
    if (!(settings.low < settings.high))
        return vessel::wrong("the window is " + std::to_string(settings.low) + " to " +
                             std::to_string(settings.high) + ", expected low below high");
    const Grid& grid = volume.grid;
    const Vec3d ijk = voxel_from_world(grid, settings.seed_mm);
    for (int a = 0; a < 3; ++a)
        if (!(ijk[a] >= -0.5 && ijk[a] < grid.size[a] - 0.5))
            return vessel::wrong("the seed (" + std::to_string(settings.seed_mm.x) + ", " +
                                 std::to_string(settings.seed_mm.y) + ", " +
                                 std::to_string(settings.seed_mm.z) + ") lies outside of the scan");
    const Vec3i seed{int(std::lround(ijk.x)), int(std::lround(ijk.y)), int(std::lround(ijk.z))};
    const auto wanted = [&](float value) {
        return double(value) >= settings.low && double(value) <= settings.high;
    };
    if (!wanted(volume.at(seed)))
        return vessel::wrong("the scan's value at the seed is " + std::to_string(volume.at(seed)) +
                             ", expected " + std::to_string(settings.low) + " to " +
                             std::to_string(settings.high));
    Mask mask(voxel_count(grid));
    std::visit(
        [&](const auto& voxels) {
            for (std::size_t n = 0; n < mask.size(); ++n) mask[n] = wanted(float(voxels.data()[n]));
        },
        volume.voxels);
    if (!settings.way_mm.empty()) {
        if (!(settings.within_mm > 0))
            return vessel::wrong("within_mm is " + std::to_string(settings.within_mm) +
                                 ", expected a number above 0");
        for (const Vec3d& p : settings.way_mm)
            if (!is_finite(p)) return vessel::wrong("way_mm: expected three numbers each");
        keep_near(grid, mask, settings.way_mm, settings.within_mm);
        if (!mask[voxel_index(grid, seed)])
            return vessel::wrong("the seed lies farther from the way than within_mm");
    }
    const std::int64_t count = fill(grid, mask, seed);
    const double ml =
        1e-3 * double(count) * grid.spacing_mm.x * grid.spacing_mm.y * grid.spacing_mm.z;
    if (settings.max_ml > 0 && ml > settings.max_ml)
        return Error{ErrorCode::LimitExceeded,
                     "the seed's region has " + std::to_string(std::lround(ml)) +
                         " ml, expected at most " + std::to_string(std::lround(settings.max_ml)) +
                         ": it leaks into other contrast or bone; a narrower window, or a way with "
                         "within_mm, keeps it in the vessel"};
    return lumen_of(volume, mask, count, settings.smoothing_voxels, arena);
}

Result<Lumen> find_labels(const Volume& labels, std::span<const int> wanted,
                          double smoothing_voxels, const TaskArena& arena) {
    if (const Status s = check_volume(labels, "labels"); !s) return s.error();
    if (const Status s = check_smoothing(smoothing_voxels); !s) return s.error();
    const Grid& grid = labels.grid;
    Mask mask(voxel_count(grid));
    std::visit(
        [&](const auto& voxels) {
            for (std::size_t n = 0; n < mask.size(); ++n) {
                const double value = double(voxels.data()[n]);  // may be any float, including NaN
                const bool whole = value > INT32_MIN && value < INT32_MAX;
                mask[n] =
                    whole && std::find(wanted.begin(), wanted.end(), int(value)) != wanted.end();
            }
        },
        labels.voxels);
    // The largest connected part.
    const Mask all = mask;
    std::int64_t most = 0;
    Vec3i seed{};
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) {
                if (mask[voxel_index(grid, {i, j, k})] != 1) continue;
                const std::int64_t count = fill(grid, mask, {i, j, k});
                if (count > most) {
                    most = count;
                    seed = {i, j, k};
                }
            }
    if (most == 0) return vessel::wrong("no voxel has one of the labels");
    mask = all;
    fill(grid, mask, seed);
    return lumen_of(labels, mask, most, smoothing_voxels, arena);
}

}  // namespace

Result<Lumen> lumen_of_region(const Volume& volume, const RegionSettings& settings,
                              const TaskArena& arena) noexcept {
    return attempt([&] { return find_region(volume, settings, arena); });
}

Result<Lumen> lumen_of_labels(const Volume& labels, std::span<const int> wanted,
                              double smoothing_voxels, const TaskArena& arena) noexcept {
    return attempt([&] { return find_labels(labels, wanted, smoothing_voxels, arena); });
}

}  // namespace pliant
