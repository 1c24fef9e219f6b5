// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "morph/parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include "base/errors.h"
#include "morph/mask_depth.h"

namespace pliant::morph {
namespace {

constexpr double kVoxelMm = 3;               ///< of the sampled maps, about
constexpr double kSmoothMm = 3;              ///< standard deviation of a mask's smoothing
constexpr std::size_t kSurfacePoints = 160;  ///< of a sample
/// A pair of lungs has at least this volume, which two kidneys don't have.
constexpr double kLungsMm3 = 700e3;
/// The gap between lungs is wider at the heart by this factor or more.
constexpr double kHeartGap = 1.15;

/// A label map at voxels of about kVoxelMm: every n-th voxel along each axis.
struct Sampled {
    Grid grid;
    std::vector<int> labels;
};

Sampled sampled(const Volume& map) {
    Vec3i step{1, 1, 1};
    Grid grid = map.grid;
    for (int a = 0; a < 3; ++a) {
        step[a] = std::max(1, int(std::lround(kVoxelMm / map.grid.spacing_mm[a])));
        grid.size[a] = (map.grid.size[a] + step[a] - 1) / step[a];
        grid.spacing_mm[a] *= step[a];
    }
    Sampled s{grid, {}};
    s.labels.reserve(voxel_count(grid));
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) {
                const float v = map.at({i * step.x, j * step.y, k * step.z});
                s.labels.push_back(v > 0.5f && v < 1e6f ? int(v + 0.5f) : 0);
            }
    return s;
}

Mask mask_of(const Sampled& map, int label) {
    Mask mask{map.grid, {}};
    mask.in.reserve(map.labels.size());
    for (const int value : map.labels) mask.in.push_back(value == label);
    return mask;
}

std::vector<Vec3d> centres_of(const Mask& mask) {
    std::vector<Vec3d> centres;
    const Vec3i size = mask.grid.size;
    std::size_t n = 0;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                if (mask.in[n++])
                    centres.push_back(
                        world_from_voxel(mask.grid, {double(i), double(j), double(k)}));
    return centres;
}

double voxel_mm3(const Grid& grid) {
    return grid.spacing_mm.x * grid.spacing_mm.y * grid.spacing_mm.z;
}

Vec3d centroid_of(const std::vector<Vec3d>& points) {
    Vec3d sum{0, 0, 0};
    for (const Vec3d& p : points) sum = sum + p;
    return (1 / double(points.size())) * sum;
}

/// Width of the gap between two lungs in front of and behind a y [mm]: sums and counts.
struct Gap {
    std::array<double, 2> width{}, count{};

    /// @param left  the lung of smaller x
    void add(const std::vector<Vec3d>& left, const std::vector<Vec3d>& right) {
        constexpr double kCellMm = 5;
        using Key = std::pair<int, int>;
        const auto key = [&](Vec3d p) {
            return Key(int(std::floor(p.y / kCellMm)), int(std::floor(p.z / kCellMm)));
        };
        std::map<Key, std::pair<double, double>> inner;
        const double none = std::numeric_limits<double>::infinity();
        double middle = 0;
        for (const Vec3d& p : left) {
            auto& edge = inner.try_emplace(key(p), -none, none).first->second;
            edge.first = std::max(edge.first, p.x);
            middle += p.y;
        }
        for (const Vec3d& p : right) {
            auto& edge = inner.try_emplace(key(p), -none, none).first->second;
            edge.second = std::min(edge.second, p.x);
            middle += p.y;
        }
        middle /= double(left.size() + right.size());
        for (const auto& [at, edge] : inner) {
            if (std::isinf(edge.first) || std::isinf(edge.second)) continue;
            const std::size_t side = (at.first + 0.5) * kCellMm < middle ? 0 : 1;
            width[side] += edge.second - edge.first;
            ++count[side];
        }
    }
};

/// Whether two parts are lungs, by the gap between them, which is wide at the heart.
void find_lungs(Parts& parts) {
    if (parts.list.size() != 2) return;
    const Part &a = parts.list[0], &b = parts.list[1];
    const Vec3d apart = centroid_of(b.voxels_from) - centroid_of(a.voxels_from);
    if (!(apart.x > std::abs(apart.y) && apart.x > std::abs(apart.z))) return;
    if (std::max(a.volume_from_mm3 + b.volume_from_mm3, a.volume_to_mm3 + b.volume_to_mm3) <
        kLungsMm3)
        return;
    Gap gap;
    gap.add(a.voxels_from, b.voxels_from);
    gap.add(a.voxels_to, b.voxels_to);
    if (gap.count[0] == 0 || gap.count[1] == 0) return;
    const double low = gap.width[0] / gap.count[0], high = gap.width[1] / gap.count[1];
    if (!(low > 0) || !(high > 0)) return;
    if (low > kHeartGap * high) parts.back = 1;
    if (high > kHeartGap * low) parts.back = -1;
    parts.are_lungs = parts.back != 0;
}

Part part_of(const Mask& from, const Mask& to) {
    Part part;
    part.voxels_from = centres_of(from);
    part.voxels_to = centres_of(to);
    part.volume_from_mm3 = double(part.voxels_from.size()) * voxel_mm3(from.grid);
    part.volume_to_mm3 = double(part.voxels_to.size()) * voxel_mm3(to.grid);
    const Surface whole = surface_of(from);
    for (const std::size_t n : thinned(whole.points, kSurfacePoints)) {
        part.from.points.push_back(whole.points[n]);
        part.from.normals.push_back(whole.normals[n]);
    }
    part.to = surface_of(to);
    part.sample_to = thinned(part.to.points, kSurfacePoints);
    return part;
}

std::set<int> labels_in(const Sampled& map) {
    std::set<int> labels;
    int last = 0;
    for (const int label : map.labels)
        if (label != last) labels.insert(last = label);
    labels.erase(0);
    return labels;
}

/// Gives voxels of the labels to the parts that reach them first, face by face.
void join(Sampled& map, const std::set<int>& labels, const std::vector<int>& parts) {
    if (labels.empty()) return;
    const Vec3i size = map.grid.size;
    const std::ptrdiff_t step[3] = {1, size.x, std::ptrdiff_t(size.x) * size.y};
    std::vector<std::size_t> edge, next;
    for (std::size_t n = 0; n < map.labels.size(); ++n)
        if (std::binary_search(parts.begin(), parts.end(), map.labels[n])) edge.push_back(n);
    for (; !edge.empty(); std::swap(edge, next)) {
        next.clear();
        for (const std::size_t n : edge) {
            const Vec3i at{int(n % std::size_t(size.x)), int(n / std::size_t(size.x)) % size.y,
                           int(n / std::size_t(step[2]))};
            for (int a = 0; a < 3; ++a)
                for (const int side : {-1, 1}) {
                    if (at[a] + side < 0 || at[a] + side >= size[a]) continue;
                    const auto m = std::size_t(std::ptrdiff_t(n) + side * step[a]);
                    if (!labels.count(map.labels[m])) continue;
                    map.labels[m] = map.labels[n];
                    next.push_back(m);
                }
        }
    }
}

/// Moduli of a part's voxels by the labels of a map.
std::vector<double> moduli_at(const std::vector<Vec3d>& voxels, const Sampled& map,
                              std::span<const MorphModulus> moduli) {
    std::vector<double> found;
    found.reserve(voxels.size());
    for (const Vec3d& p : voxels) {
        const Vec3d at = voxel_from_world(map.grid, p);
        const int label = map.labels[voxel_index(
            map.grid, {int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))})];
        const auto own = std::find_if(moduli.begin(), moduli.end(),
                                      [&](const MorphModulus& m) { return m.label == label; });
        found.push_back(own == moduli.end() ? 1 : own->relative);
    }
    return found;
}

std::string list_of(const std::set<int>& labels) {
    std::string text;
    for (const int label : labels) {
        if (text.size() > 40) return text + ", …";
        text += (text.empty() ? "" : ", ") + std::to_string(label);
    }
    return text.empty() ? "none" : text;
}

}  // namespace

Result<Parts> find_parts(const Volume& from, const Volume& to, std::span<const MorphModulus> moduli,
                         const TaskArena& arena) {
    if (const Status s = check_volume(from, "from"); !s.ok()) return s.error();
    if (const Status s = check_volume(to, "to"); !s.ok()) return s.error();
    Sampled maps[2];
    const auto both = [&](const auto& work) {
        arena.for_each(2, 1, [&](std::int64_t begin, std::int64_t end) {
            for (; begin < end; ++begin) work(std::size_t(begin));
        });
    };
    both([&](std::size_t n) { maps[n] = sampled(n == 0 ? from : to); });
    const std::set<int> at_from = labels_in(maps[0]), at_to = labels_in(maps[1]);
    std::vector<int> labels;
    std::set_intersection(at_from.begin(), at_from.end(), at_to.begin(), at_to.end(),
                          std::back_inserter(labels));
    if (labels.empty())
        return expected_error("to", "a label of from (" + list_of(at_from) + ")", list_of(at_to));
    std::set<int> inside, seen;  // labels within parts, labels with moduli
    for (const MorphModulus& one : moduli) {
        if (!seen.insert(one.label).second)
            return expected_error("moduli", "one modulus of each label",
                                  "two of label " + std::to_string(one.label));
        if (!at_from.count(one.label))
            return expected_error("moduli", "labels of from (" + list_of(at_from) + ")",
                                  std::to_string(one.label));
        if (!(one.relative >= 1e-3 && one.relative <= 1e3))
            return expected_error("moduli", "0.001 to 1000 of label " + std::to_string(one.label),
                                  toml_text(one.relative));
        if (!at_to.count(one.label)) inside.insert(one.label);
    }
    const Sampled original = moduli.empty() ? Sampled{} : maps[0];
    join(maps[0], inside, labels);
    std::vector<Mask> masks[2];
    both([&](std::size_t n) {
        for (const int label : labels) masks[n].push_back(mask_of(maps[n], label));
        if (labels.size() == 1) masks[n] = split(masks[n][0]);
    });
    if (masks[0].size() != masks[1].size())
        both([&](std::size_t n) { masks[n] = {mask_of(maps[n], labels[0])}; });
    Parts parts;
    parts.list.resize(masks[0].size());
    arena.for_each(std::int64_t(parts.list.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (; begin < end; ++begin)
            parts.list[std::size_t(begin)] =
                part_of(masks[0][std::size_t(begin)], masks[1][std::size_t(begin)]);
    });
    if (!moduli.empty())
        for (Part& part : parts.list) part.moduli = moduli_at(part.voxels_from, original, moduli);
    // A piece that is too small has no surface after the smoothing.
    std::erase_if(parts.list, [](const Part& part) {
        return part.from.points.size() < 12 || part.sample_to.size() < 12;
    });
    if (parts.list.empty())
        return expected_error("from", "a part larger than a few voxels of 3 mm", "smaller ones");
    if (labels.size() == 1) find_lungs(parts);
    return parts;
}

Surface surface_of(const Mask& mask) {
    Surface surface;
    const SmoothMask smooth(mask, kSmoothMm);
    const Vec3i size = smooth.size();
    const auto is_in = [&](Vec3i p) { return smooth.at(p) > 0.5f; };
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) {
                const Vec3i p{i, j, k};
                bool is_beside = false;  // another voxel that lies on the other side
                for (int a = 0; a < 3 && !is_beside; ++a)
                    for (const int step : {-1, 1}) {
                        Vec3i q = p;
                        q[a] += step;
                        if (q[a] >= 0 && q[a] < size[a]) is_beside |= is_in(p) != is_in(q);
                    }
                if (!is_beside) continue;
                const Vec3d slope = smooth.slope(p);  // [1/mm]
                const double steep = norm(slope);
                if (!(steep > 0.02)) continue;
                const Vec3d way = ((0.5 - smooth.at(p)) / (steep * steep)) * slope;
                if (!(norm(way) < 5)) continue;
                surface.points.push_back(smooth.world(p) +
                                         world_from_lattice_vector(mask.grid, way));
                surface.normals.push_back(
                    world_from_lattice_vector(mask.grid, (-1 / steep) * slope));
            }
    return surface;
}

std::vector<std::size_t> thinned(std::span<const Vec3d> points, std::size_t count) {
    std::vector<std::pair<std::uint64_t, std::size_t>> cells(points.size());
    const auto sort_into = [&](double size) {  // @returns the number of cells
        for (std::size_t n = 0; n < points.size(); ++n) {
            std::uint64_t key = 0;
            for (int a = 0; a < 3; ++a)
                key = key << 21 | (std::uint64_t(std::floor(points[n][a] / size) + (1 << 20)) &
                                   ((1u << 21) - 1));
            cells[n] = {key, n};
        }
        std::sort(cells.begin(), cells.end());
        std::size_t found = 0;
        for (std::size_t n = 0; n < cells.size(); ++n)
            found += n == 0 || cells[n].first != cells[n - 1].first;
        return found;
    };
    double low = 2, high = 60;
    for (int n = 0; n < 10; ++n) {
        const double size = 0.5 * (low + high);
        (sort_into(size) > count ? low : high) = size;
    }
    sort_into(high);
    std::vector<std::size_t> chosen;
    for (std::size_t begin = 0, end = 0; begin < cells.size(); begin = end) {
        Vec3d middle{0, 0, 0};
        for (; end < cells.size() && cells[end].first == cells[begin].first; ++end)
            middle = middle + points[cells[end].second];
        middle = (1 / double(end - begin)) * middle;
        std::size_t best = cells[begin].second;
        for (std::size_t n = begin; n < end; ++n)
            if (norm(points[cells[n].second] - middle) < norm(points[best] - middle))
                best = cells[n].second;
        chosen.push_back(best);
    }
    return chosen;
}

}  // namespace pliant::morph
