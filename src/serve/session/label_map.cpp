// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/label_map.h"

#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "protocol/limits.h"

namespace pliant::serve {
namespace {

constexpr double kStripeVoxels = 3, kStripesPerScan = 60;
/// Dilation of the surroundings [voxels]; their mesh is coarser than the organs'.
constexpr int kGrowth = 2;
constexpr double kLowestTissue_hu = -300;
constexpr double kOnFace = 1e-9;  ///< of weights, so that no voxel falls between two tetrahedra

using Numbers = std::vector<std::uint16_t>;

/// Numbers the voxels of tissue in tetrahedra that have no number yet.
void fill(const TetMesh& mesh, const Volume& scan, std::uint16_t number, Numbers& numbers) {
    const Grid& grid = scan.grid;
    for (const auto& cell : mesh.cells) {
        Vec3d x[4], low, high;
        for (std::size_t n = 0; n < 4; ++n)
            x[n] = voxel_from_world(grid, mesh.nodes_mm[std::size_t(cell[n])]);
        low = high = x[0];
        for (const Vec3d& p : x)
            for (int a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], p[a]);
                high[a] = std::max(high[a], p[a]);
            }
        const Mat3d weights = inverse(Mat3d{{x[1] - x[0], x[2] - x[0], x[3] - x[0]}});
        Vec3i begin, end;
        for (int a = 0; a < 3; ++a) {
            begin[a] = std::max(0, int(std::ceil(low[a])));
            end[a] = std::min(grid.size[a], int(std::floor(high[a])) + 1);
        }
        for (int k = begin.z; k < end.z; ++k)
            for (int j = begin.y; j < end.y; ++j)
                for (int i = begin.x; i < end.x; ++i) {
                    std::uint16_t& here = numbers[voxel_index(grid, {i, j, k})];
                    if (here != 0 || double(scan.at({i, j, k})) < kLowestTissue_hu) continue;
                    const Vec3d w = weights * (Vec3d{double(i), double(j), double(k)} - x[0]);
                    if (std::min({w.x, w.y, w.z, 1 - w.x - w.y - w.z}) >= -kOnFace) here = number;
                }
    }
}

/// Gives voxels of tissue beside a number that number.
void grow(std::uint16_t number, const Volume& scan, Numbers& numbers) {
    const Grid& grid = scan.grid;
    const Vec3i size = grid.size;
    std::vector<std::size_t> found;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) {
                const std::size_t at = voxel_index(grid, {i, j, k});
                if (numbers[at] != 0 || double(scan.at({i, j, k})) < kLowestTissue_hu) continue;
                bool beside = false;
                for (int a = 0; a < 3; ++a)
                    for (const int step : {-1, 1}) {
                        Vec3i p{i, j, k};
                        p[a] += step;
                        if (p[a] >= 0 && p[a] < size[a])
                            beside |= numbers[voxel_index(grid, p)] == number;
                    }
                if (beside) found.push_back(at);
            }
    for (const std::size_t at : found) numbers[at] = number;
}

/// Numbers the voxels of the bodies that have labels, by the label at the nearest voxel.
Status fill_labels(const MadeOrgans& made, const Grid& grid, const TaskArena& arena,
                   Numbers& numbers) {
    std::map<int, std::uint16_t> number_of;
    for (std::size_t n = 0; n < made.organs.size(); ++n)
        for (const int label : made.organs[n].settings.labels)
            number_of[label] = std::uint16_t(n + 1);
    if (!made.labels || number_of.empty()) return Ok{};
    const auto labels = labels_on(*made.labels, grid, arena);
    if (!labels.ok()) return labels.error();
    std::visit(
        [&](const auto& voxels) {
            for (std::size_t n = 0; n < numbers.size(); ++n)
                if (const auto found = number_of.find(int(voxels[n])); found != number_of.end())
                    numbers[n] = found->second;
        },
        labels->voxels);
    return Ok{};
}

}  // namespace

void count_labels(LabelMap& map) {
    std::vector<Vec3d> sums(map.labels.size(), Vec3d{0, 0, 0});
    for (LabelInfo& label : map.labels) label.voxels = 0;
    std::size_t n = 0;
    for (int k = 0; k < map.grid.size.z; ++k)
        for (int j = 0; j < map.grid.size.y; ++j)
            for (int i = 0; i < map.grid.size.x; ++i) {
                const std::uint16_t number = map.numbers[n++];
                if (number == 0) continue;
                ++map.labels[number - 1].voxels;
                sums[number - 1] = sums[number - 1] + Vec3d{double(i), double(j), double(k)};
            }
    for (std::size_t l = 0; l < sums.size(); ++l) {
        LabelInfo& label = map.labels[l];
        if (label.voxels > 0)
            label.centre_mm = world_from_voxel(map.grid, (1.0 / double(label.voxels)) * sums[l]);
    }
}

Result<std::shared_ptr<const LabelMap>> map_bodies(const MadeOrgans& made, const Volume& scan,
                                                   const TaskArena& arena) {
    using Map = std::shared_ptr<const LabelMap>;
    if (made.organs.size() < 2 || made.organs.size() > kMaxLabels) return Map();
    auto map = std::make_shared<LabelMap>();
    map->name = "bodies";
    map->grid = scan.grid;
    map->numbers.assign(voxel_count(scan.grid), 0);
    if (const Status s = fill_labels(made, scan.grid, arena, map->numbers); !s.ok())
        return s.error();
    for (std::size_t n = 0; n < made.organs.size(); ++n) {
        const Organ& organ = made.organs[n];
        const bool is_rest = made.file.surroundings && n + 1 == made.organs.size();
        const bool has_labels = !organ.settings.labels.empty();
        if (!has_labels || !made.labels) fill(organ.mesh, scan, std::uint16_t(n + 1), map->numbers);
        if (is_rest)
            for (int k = 0; k < kGrowth; ++k) grow(std::uint16_t(n + 1), scan, map->numbers);
        map->labels.push_back({.value = has_labels ? organ.settings.labels.front()
                                        : is_rest  ? 0
                                                   : -int(n + 1),
                               .name = organ.name,
                               .body = int(n + 1),
                               .is_shown = !is_rest});
    }
    const Grid& g = scan.grid;
    double longest_mm = 0, voxel_mm = 0;
    for (int a = 0; a < 3; ++a) {
        longest_mm = std::max(longest_mm, g.size[a] * g.spacing_mm[a]);
        voxel_mm = std::max(voxel_mm, g.spacing_mm[a]);
    }
    map->stripe_mm = std::max(kStripeVoxels * voxel_mm, longest_mm / kStripesPerScan);
    count_labels(*map);
    return Map(std::move(map));
}

void mark_bodies(LabelMap& map, const LabelMap& bodies) {
    std::vector<std::map<int, std::int64_t>> counts(map.labels.size());
    for (std::size_t v = 0; v < map.numbers.size(); ++v)
        if (map.numbers[v] > 0 && bodies.numbers[v] > 0)
            ++counts[std::size_t(map.numbers[v]) - 1][bodies.numbers[v]];
    for (std::size_t l = 0; l < counts.size(); ++l) {
        const auto most =
            std::max_element(counts[l].begin(), counts[l].end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; });
        if (most != counts[l].end())
            map.labels[l].body = bodies.labels[std::size_t(most->first) - 1].body;
    }
    map.stripe_mm = bodies.stripe_mm;
    const LabelInfo& last = bodies.labels.back();
    if (last.is_shown || map.labels.size() >= kMaxLabels) return;
    map.labels.push_back({.name = last.name, .body = last.body, .is_shown = false});
    for (std::size_t v = 0; v < map.numbers.size(); ++v)
        if (map.numbers[v] == 0 && bodies.numbers[v] == bodies.labels.size())
            map.numbers[v] = std::uint16_t(map.labels.size());
    count_labels(map);
}

}  // namespace pliant::serve
