// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scores of registrations, from exact pairs of points alone.

#include <pliant/data/truth.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "base/errors.h"
#include "volume/same_grid.h"

namespace pliant {
namespace {

using Displacement = std::function<Vec3d(std::size_t voxel, Vec3d point_mm)>;

Status check_grid_of(const Volume& volume, const Grid& grid, const char* name) {
    if (const Status s = check_volume(volume, name); !s.ok()) return s;
    if (!volume.is_16_bit() || !is_same_grid(volume.grid, grid))
        return expected_error(name, "16-bit values on the grid of the forward field", "others");
    return Ok{};
}

Status check_truth(const TruthData& truth) {
    if (const Status s = check_field(truth.forward, "forward"); !s.ok()) return s;
    if (const Status s = check_grid_of(truth.labels, truth.forward.grid, "labels"); !s.ok())
        return s;
    return check_grid_of(truth.fixed_mask, truth.forward.grid, "fixed_mask");
}

/// Row of a tissue voxel.
TruthRow row_of(TruthLabel label, bool has_moved) {
    switch (label) {
        case TruthLabel::Bone:
            return TruthRow::Bone;
        case TruthLabel::Wall:
            return has_moved ? TruthRow::Wall : TruthRow::Still;
        case TruthLabel::Interface:
            return has_moved ? TruthRow::Interface : TruthRow::Still;
        case TruthLabel::Cut:
            return has_moved ? TruthRow::Cut : TruthRow::Still;
        default:
            return has_moved ? TruthRow::Interior : TruthRow::Still;
    }
}

Vec3d vector_of(Vec3f v) {
    return {v.x, v.y, v.z};
}

using Distances = std::array<std::vector<float>, kTruthRows>;

TruthErrors& row(TruthScore& score, TruthRow r) {
    return score.rows[std::size_t(r)];
}

void score_voxels(const TruthData& truth, const Displacement& found, const TaskArena& arena,
                  TruthScore& score) {
    const Grid& grid = truth.forward.grid;
    const auto& labels = *std::get_if<VoxelArray<std::int16_t>>(&truth.labels.voxels);
    const auto& mask = *std::get_if<VoxelArray<std::int16_t>>(&truth.fixed_mask.voxels);
    std::vector<Distances> by_slice(std::size_t(grid.size.z));
    arena.for_each(grid.size.z, 1, [&](std::int64_t begin, std::int64_t end) {
        for (; begin < end; ++begin) {
            Distances& here = by_slice[std::size_t(begin)];
            for (int j = 0; j < grid.size.y; ++j)
                for (int i = 0; i < grid.size.x; ++i) {
                    const std::size_t n = voxel_index(grid, {i, j, int(begin)});
                    const auto label = TruthLabel(labels[n]);
                    if (label == TruthLabel::Air || mask[n] != std::int16_t(TruthMask::Exact))
                        continue;
                    const Vec3d u = vector_of(truth.forward.vectors_mm[n]);
                    const Vec3d point =
                        world_from_voxel(grid, {double(i), double(j), double(begin)});
                    here[std::size_t(row_of(label, norm(u) >= kTruthMovedMm))].push_back(
                        float(norm(found(n, point) - u)));
                }
        }
    });
    Distances all;
    for (std::size_t r = 0; r < all.size(); ++r) {
        std::size_t count = 0;
        for (const Distances& some : by_slice) count += some[r].size();
        all[r].reserve(count);
        for (const Distances& some : by_slice)
            all[r].insert(all[r].end(), some[r].begin(), some[r].end());
    }
    by_slice.clear();
    std::vector<float>& moved = all[std::size_t(TruthRow::Moved)];
    for (const TruthRow r :
         {TruthRow::Interior, TruthRow::Wall, TruthRow::Interface, TruthRow::Cut})
        moved.insert(moved.end(), all[std::size_t(r)].begin(), all[std::size_t(r)].end());
    for (std::size_t r = 0; r < all.size(); ++r) score.rows[r] = errors_of(all[r]);
}

void score_landmarks(const TruthData& truth, const std::function<Vec3d(std::size_t)>& moving_mm,
                     TruthScore& score) {
    std::vector<float> distances;
    for (std::size_t n = 0; n < truth.landmarks.size(); ++n)
        distances.push_back(float(norm(moving_mm(n) - truth.landmarks[n].moving_mm)));
    row(score, TruthRow::Landmarks) = errors_of(distances);
}

Result<TruthScore> score_displacements(const TruthData& truth, const Displacement& found,
                                       const std::function<Vec3d(Vec3d)>& at,
                                       const TaskArena& arena) {
    TruthScore score;
    score_voxels(truth, found, arena, score);
    score_landmarks(
        truth,
        [&](std::size_t n) {
            const Vec3d from = truth.landmarks[n].fixed_mm;
            return from + at(from);
        },
        score);
    return score;
}

/// Counts the folded voxels of soft tissue and bone.
Status count_folds(const TruthData& truth, const VectorField& found, TruthScore& score) {
    const Result<Volume> jacobian = jacobian_field(found);
    if (!jacobian.ok()) return jacobian.error();
    const Grid& grid = truth.labels.grid;
    const Grid& own = found.grid;
    std::int64_t count = 0;
    for (int k = 0; k < own.size.z; ++k)
        for (int j = 0; j < own.size.y; ++j)
            for (int i = 0; i < own.size.x; ++i) {
                const Vec3i p{i, j, k};
                Vec3i at = p;
                if (own != grid) {
                    const Vec3d v = voxel_from_world(
                        grid, world_from_voxel(own, {double(i), double(j), double(k)}));
                    bool is_near = true;  // converted to whole numbers only where they are small
                    for (int a = 0; a < 3; ++a) {
                        is_near &= v[a] > -1 && v[a] < grid.size[a];
                        if (is_near) at[a] = int(std::lround(v[a]));
                    }
                    if (!is_near || !contains(voxel_box(grid), at)) continue;
                }
                if (truth.labels.at(at) == float(TruthLabel::Air)) continue;
                ++count;
                score.folded_voxels += jacobian->at(p) <= 0;
            }
    score.folded_share = count ? double(score.folded_voxels) / double(count) : 0;
    return Ok{};
}

}  // namespace

TruthErrors errors_of(std::span<float> distances_mm) noexcept {
    TruthErrors errors;
    const std::size_t count = distances_mm.size();
    errors.count = std::int64_t(count);
    if (count == 0) return errors;
    double sum = 0;
    for (const float d : distances_mm) sum += double(d);
    errors.mean_mm = sum / double(count);
    const auto nth = [&](std::size_t n) {
        std::nth_element(distances_mm.begin(), distances_mm.begin() + std::ptrdiff_t(n),
                         distances_mm.end());
        return double(distances_mm[n]);
    };
    const auto rank = [&](double share) {
        return std::size_t(std::ceil(share * double(count))) - 1;
    };
    errors.median_mm = nth(rank(0.5));
    errors.p95_mm = nth(rank(0.95));
    errors.max_mm = double(*std::max_element(distances_mm.begin(), distances_mm.end()));
    return errors;
}

Result<TruthScore> score_field(const TruthData& truth, const VectorField& found,
                               const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<TruthScore> {
        if (const Status s = check_truth(truth); !s.ok()) return s.error();
        if (const Status s = check_field(found, "found"); !s.ok()) return s.error();
        const bool has_same_grid = is_same_grid(found.grid, truth.forward.grid);
        auto score = score_displacements(
            truth,
            [&](std::size_t n, Vec3d point) {
                return has_same_grid ? vector_of(found.vectors_mm[n]) : sample_field(found, point);
            },
            [&](Vec3d point) { return sample_field(found, point); }, arena);
        if (!score.ok()) return score;
        if (const Status s = count_folds(truth, found, *score); !s.ok()) return s.error();
        return score;
    });
}

Result<TruthScore> score_nothing(const TruthData& truth, const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<TruthScore> {
        if (const Status s = check_truth(truth); !s.ok()) return s.error();
        auto score = score_displacements(
            truth,
            [](std::size_t, Vec3d) {
                return Vec3d{0, 0, 0};
            },
            [](Vec3d) {
                return Vec3d{0, 0, 0};
            },
            arena);
        if (score.ok()) score->folded_share = 0;
        return score;
    });
}

Result<TruthScore> score_points(const TruthData& truth, std::span<const Vec3d> moving_mm) noexcept {
    return attempt([&]() -> Result<TruthScore> {
        if (moving_mm.size() != truth.landmarks.size())
            return expected_error(
                "points", std::to_string(truth.landmarks.size()) + " points, one for each landmark",
                std::to_string(moving_mm.size()));
        for (const Vec3d& point : moving_mm)
            if (!is_finite(point))
                return expected_error("points", "finite numbers", "one that is not");
        TruthScore score;
        score_landmarks(
            truth, [&](std::size_t n) { return moving_mm[n]; }, score);
        return score;
    });
}

}  // namespace pliant
