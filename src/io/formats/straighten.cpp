// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/scan_files.h>

#include "formats/straighten.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <new>
#include <type_traits>
#include <utility>

#include "base/errors.h"
#include "base/memory_budget.h"
#include "base/text.h"
#include "formats/image_header.h"
#include "formats/voxel_builder.h"
#include "volume/grid_limits.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Tolerance of positions relative to a step, so that rounding adds no voxel.
constexpr double kRoundingSteps = 1e-6;

/// Maximum ratio of the voxels after and before, for results that aren't small.
constexpr double kMaxGrowth = 16, kSmallResult = 1 << 20;

/// Range of the grid along one axis of the slices.
struct GridSpan {
    double start_mm = 0;
    std::int64_t count = 0;
};

/// Whole steps that contain low…high; 0 mm is one of the positions.
GridSpan span_of(double low_mm, double high_mm, double step_mm) {
    const double first = std::floor(low_mm / step_mm + kRoundingSteps);
    const double last = std::ceil(high_mm / step_mm - kRoundingSteps);
    return {first * step_mm, std::int64_t(last - first) + 1};
}

/// Position of a height between two slices.
struct BetweenSlices {
    std::size_t below = 0, above = 0;
    double fraction = 0;  ///< 0: below, 1: above
};

/// @param from  slice to begin the search at
BetweenSlices find_slices(const std::vector<double>& heights_mm, double height_mm,
                          std::size_t from) {
    std::size_t below = from;
    while (below + 2 < heights_mm.size() && heights_mm[below + 1] <= height_mm) ++below;
    const std::size_t above = std::min(below + 1, heights_mm.size() - 1);
    const double gap = heights_mm[above] - heights_mm[below];
    const double fraction = gap > 0 ? (height_mm - heights_mm[below]) / gap : 0;
    return {below, above, std::clamp(fraction, 0.0, 1.0)};
}

double mix(double a, double b, double fraction) {
    return a + fraction * (b - a);
}

/// Neighbours of a continuous index; a voxel reaches half a step beyond its centre.
struct Neighbours {
    std::int64_t low = 0, high = 0;
    double fraction = 0;
    bool inside = false;
};
Neighbours neighbours_of(double index, std::int64_t count) {
    if (!(index >= -0.5 && index <= double(count) - 0.5)) return {};
    const double rounded = std::round(index);
    if (std::abs(index - rounded) < kRoundingSteps) index = rounded;
    index = std::clamp(index, 0.0, double(count - 1));
    const auto low = std::min(std::int64_t(index), count - 1);
    return {low, std::min(low + 1, count - 1), index - double(low), true};
}

/// Samples one row of the result.
template <class T>
class RowSampler {
  public:
    RowSampler(const T* values, Vec3i size, const SliceStack& stack, T fill)
        : m_values(values), m_size(size), m_stack(stack), m_fill(fill) {}

    /// @param x_mm, y_mm  of the row's first voxel in the plane of the slices
    void sample(const BetweenSlices& k, double x_mm, double y_mm, std::span<T> row) const {
        const double shift_i = mix(m_stack.shifts_i_mm[k.below], m_stack.shifts_i_mm[k.above],
                                   k.fraction),
                     shift_j = mix(m_stack.shifts_j_mm[k.below], m_stack.shifts_j_mm[k.above],
                                   k.fraction);
        const double j = (y_mm - shift_j) / m_stack.step_j_mm;
        const double start = (x_mm - shift_i - m_stack.lean_j_mm * j) / m_stack.step_i_mm;
        const Neighbours across = neighbours_of(j, m_size.y);
        for (std::size_t n = 0; n < row.size(); ++n) {
            const Neighbours along = neighbours_of(start + double(n), m_size.x);
            if (!across.inside || !along.inside) {
                row[n] = m_fill;
                continue;
            }
            if (touches_padding(k, along, across)) {
                row[n] = nearest(k, along, across);
                continue;
            }
            const double value =
                mix(in_slice(k.below, along, across), in_slice(k.above, along, across), k.fraction);
            if constexpr (std::is_same_v<T, std::int16_t>)
                row[n] = T(std::lround(value));
            else
                row[n] = T(value);
        }
    }

  private:
    std::size_t index(std::int64_t i, std::int64_t j, std::size_t k) const {
        return std::size_t(i) +
               std::size_t(m_size.x) * (std::size_t(j) + std::size_t(m_size.y) * k);
    }
    /// Whether a voxel that is blended is padding.
    bool touches_padding(const BetweenSlices& k, const Neighbours& i, const Neighbours& j) const {
        if (m_stack.padding.empty()) return false;
        for (const std::size_t slice : {k.below, k.fraction > 0 ? k.above : k.below})
            for (const std::int64_t row : {j.low, j.fraction > 0 ? j.high : j.low})
                for (const std::int64_t column : {i.low, i.fraction > 0 ? i.high : i.low})
                    if (m_stack.padding[index(column, row, slice)]) return true;
        return false;
    }
    T nearest(const BetweenSlices& k, const Neighbours& i, const Neighbours& j) const {
        return m_values[index(i.fraction < 0.5 ? i.low : i.high, j.fraction < 0.5 ? j.low : j.high,
                              k.fraction < 0.5 ? k.below : k.above)];
    }
    double in_slice(std::size_t k, const Neighbours& along, const Neighbours& across) const {
        const auto width = std::size_t(m_size.x);
        const T* const slice = m_values + k * width * std::size_t(m_size.y);
        const T* const low = slice + std::size_t(across.low) * width;
        const T* const high = slice + std::size_t(across.high) * width;
        return mix(mix(double(low[along.low]), double(low[along.high]), along.fraction),
                   mix(double(high[along.low]), double(high[along.high]), along.fraction),
                   across.fraction);
    }

    const T* m_values;
    Vec3i m_size;
    const SliceStack& m_stack;
    T m_fill;
};

/// Grid of the result.
Result<Grid> grid_of(const fs::path& path, const SliceStack& stack, Vec3i size) {
    const auto [low_i, high_i] =
        std::minmax_element(stack.shifts_i_mm.begin(), stack.shifts_i_mm.end());
    const auto [low_j, high_j] =
        std::minmax_element(stack.shifts_j_mm.begin(), stack.shifts_j_mm.end());
    const double lean = stack.lean_j_mm * (size.y - 1);
    const GridSpan i =
        span_of(*low_i + std::min(0.0, lean),
                *high_i + std::max(0.0, lean) + stack.step_i_mm * (size.x - 1), stack.step_i_mm);
    const GridSpan j = span_of(*low_j, *high_j + stack.step_j_mm * (size.y - 1), stack.step_j_mm);
    const double height = stack.heights_mm.back();
    // The first and the last slice stay where they are.
    const double gaps = std::max(1.0, std::round(height / stack.gap_mm));
    if (Status s = check_size(path, {i.count, j.count, std::int64_t(gaps) + 1}); !s)
        return s.error();
    // A few slices that are far apart would fill the memory.
    const double count = double(i.count) * double(j.count) * (gaps + 1),
                 own = double(size.x) * double(size.y) * double(size.z);
    if (count > kMaxGrowth * own && count > kSmallResult)
        return Error{ErrorCode::LimitExceeded, path.string() + ": straightened it would have " +
                                                   text_of(count) + " voxels, expected at most " +
                                                   text_of(kMaxGrowth) + " times its " +
                                                   text_of(own)};
    Grid grid;
    grid.size = {std::int32_t(i.count), std::int32_t(j.count), std::int32_t(gaps) + 1};
    grid.spacing_mm = {stack.step_i_mm, stack.step_j_mm, height / gaps};
    grid.direction = stack.axes;
    grid.origin_mm =
        stack.origin_mm + i.start_mm * stack.axes.columns[0] + j.start_mm * stack.axes.columns[1];
    if (Status s = check_grid(path, grid); !s) return s.error();
    return grid;
}

/// Value beyond the stack.
template <class T>
T fill_of(const VoxelArray<T>& voxels) {
    const T lowest = *std::min_element(voxels.begin(), voxels.end());
    return lowest < T(0) ? T(kAirHu) : lowest;
}

}  // namespace

double shear_degrees(const Grid& grid) {
    constexpr double kDegrees = 57.29577951308232;
    const auto& c = grid.direction.columns;
    double largest = 0;
    for (std::size_t a = 0; a < 3; ++a)
        largest = std::max(largest, std::abs(dot(normalized(c[a]), normalized(c[(a + 1) % 3]))));
    return kDegrees * std::asin(std::min(1.0, largest));
}

SliceStack stack_of(const Grid& grid) {
    std::array<Vec3d, 3> steps;
    for (std::size_t a = 0; a < 3; ++a)
        steps[a] = grid.spacing_mm[int(a)] * grid.direction.columns[a];
    SliceStack stack;
    stack.origin_mm = grid.origin_mm;
    auto& axes = stack.axes.columns;
    axes[0] = normalized(steps[0]);
    stack.step_i_mm = norm(steps[0]);
    stack.lean_j_mm = dot(steps[1], axes[0]);
    const Vec3d across = steps[1] - stack.lean_j_mm * axes[0];
    axes[1] = normalized(across);
    stack.step_j_mm = norm(across);
    axes[2] = cross(axes[0], axes[1]);
    if (dot(axes[2], steps[2]) < 0) axes[2] = -axes[2];
    stack.gap_mm = dot(steps[2], axes[2]);
    for (int k = 0; k < grid.size.z; ++k) {
        stack.heights_mm.push_back(k * stack.gap_mm);
        stack.shifts_i_mm.push_back(k * dot(steps[2], axes[0]));
        stack.shifts_j_mm.push_back(k * dot(steps[2], axes[1]));
    }
    return stack;
}

Result<Volume> straightened(const fs::path& path, const Volume& stacked, const SliceStack& stack,
                            const ReadOptions& options, std::vector<std::string>& notes) {
    auto grid = grid_of(path, stack, stacked.grid.size);
    if (!grid) return grid.error();
    const std::size_t count = voxel_count(*grid);
    if (!has_memory_for(count * (stacked.is_16_bit() ? 2 : 4))) throw std::bad_alloc();
    Volume result{*grid, {}, stacked.key_values};
    const Status done = std::visit(
        [&](const auto& values) -> Status {
            using T = typename std::decay_t<decltype(values)>::value_type;
            VoxelArray<T> voxels(count);
            const RowSampler<T> sampler(values.data(), stacked.grid.size, stack, fill_of(values));
            const auto width = std::size_t(grid->size.x);
            const Vec3d start = grid->origin_mm - stack.origin_mm;
            const double x_mm = dot(start, stack.axes.columns[0]),
                         y_mm = dot(start, stack.axes.columns[1]);
            BetweenSlices k;
            for (int slice = 0; slice < grid->size.z; ++slice) {
                if (Status s = go_on(path, options, double(slice) / grid->size.z); !s) return s;
                k = find_slices(stack.heights_mm, slice * grid->spacing_mm.z, k.below);
                for (int row = 0; row < grid->size.y; ++row)
                    sampler.sample(k, x_mm, y_mm + row * grid->spacing_mm.y,
                                   {voxels.data() + voxel_index(*grid, {0, row, slice}), width});
            }
            voxels.freeze();
            result.voxels = std::move(voxels);
            return Ok{};
        },
        stacked.voxels);
    if (!done) return done.error();
    notes.push_back("straightened: resampled from " + text_of_size(stacked.grid.size) + " to " +
                    text_of_size(grid->size) + " voxels");
    return result;
}

Result<Volume> straightened(const Volume& sheared, const std::string& name,
                            const std::function<bool()>& give_up) {
    if (is_perpendicular(sheared.grid.direction)) {
        if (Status s = check_volume(sheared, name); !s) return s.error();
        return sheared;
    }
    const fs::path path = name;
    const Vec3i size = sheared.grid.size;
    if (Status s = check_size(path, {size.x, size.y, size.z}); !s) return s.error();
    if (Status s = check_grid(path, sheared.grid, true); !s) return s.error();
    const auto count = std::visit([](const auto& v) { return v.size(); }, sheared.voxels);
    if (count != voxel_count(sheared.grid))
        return expected_error(name + ".voxels", std::to_string(voxel_count(sheared.grid)),
                              std::to_string(count));
    try {
        std::vector<std::string> unused;
        return straightened(path, sheared, stack_of(sheared.grid), {.give_up = give_up}, unused);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, name + ": not enough memory to straighten it"};
    }
}

}  // namespace pliant
