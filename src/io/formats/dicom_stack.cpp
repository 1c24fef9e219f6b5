// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Names, slice numbers and slice thickness are not trusted. Slices are sorted by their position
// along their common normal,
//
//   n = row × column,   d = position · n,
//
// and the distance between them is that of their positions. Scanners round positions to 0.1 mm or
// more, so gaps and sideways shifts are evaluated over the whole stack. A straight line is fitted
// to the shifts. A stack is refused if the line leans by more than a fraction of a pixel in total
// (a tilted gantry), if a slice is off the line by that much, or if there are gaps or duplicates.

#include "base/errors.h"
#include "base/text.h"
#include "formats/dicom_series.h"
#include "formats/image_header.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Maximum relative deviation of a gap between slices from the usual gap.
constexpr double kMaxGapDeviation = 0.05;
/// Alternatively, maximum distance of a slice from its position in a regular stack [mm, fraction of
/// the gap].
constexpr double kMaxOffsetMm = 0.1, kMaxOffset = 0.2;
/// Sideways shift without a note [mm], tolerated lean [mm per mm, 0.06 degrees], and maximum shift
/// otherwise [pixels].
constexpr double kSmallShiftMm = 0.02, kMaxLean = 1e-3, kMaxShiftPixels = 0.25;

/// Whether all slices are at their positions in a regular stack, up to rounding.
bool is_regular(const std::vector<double>& heights) {
    const double gap = (heights.back() - heights.front()) / double(heights.size() - 1);
    for (std::size_t n = 0; n < heights.size(); ++n)
        if (std::abs(heights[n] - heights.front() - double(n) * gap) >
            std::min(kMaxOffsetMm, kMaxOffset * gap))
            return false;
    return true;
}

/// @param heights  of the slices, sorted, along the normal [mm]
double usual_gap(const std::vector<double>& heights) {
    std::vector<double> gaps;
    for (std::size_t n = 1; n < heights.size(); ++n) gaps.push_back(heights[n] - heights[n - 1]);
    const auto middle = gaps.begin() + std::ptrdiff_t(gaps.size() / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    return *middle;
}

/// Refuses two slices at one position.
Status check_apart(const fs::path& folder, const std::vector<DicomSlice>& slices,
                   const std::vector<double>& heights) {
    for (std::size_t n = 1; n < heights.size(); ++n)
        if (heights[n] - heights[n - 1] < kSameSliceMm)
            return unsupported(folder, "two slices are at the same position: " +
                                           slices[n - 1].name() + " and " + slices[n].name() +
                                           ", expected one at each position, or several volumes: "
                                           "as many at each, told apart by Temporal Position "
                                           "Identifier or Instance Number");
    return Ok{};
}

Status check_gaps(const fs::path& folder, const std::vector<DicomSlice>& slices,
                  const std::vector<double>& heights) {
    if (is_regular(heights)) return Ok{};
    const double usual = usual_gap(heights);
    for (std::size_t n = 0; n + 1 < heights.size(); ++n) {
        const std::string first = slices[n].name();
        const std::string second = slices[n + 1].name();
        const double gap = heights[n + 1] - heights[n], steps = gap / usual;
        if (std::abs(steps - 1) <= kMaxGapDeviation) continue;
        const std::string between = "between " + first + " and " + second;
        const double whole = std::round(steps);
        if (whole >= 2 && std::abs(steps - whole) <= kMaxGapDeviation * whole)
            return Error{ErrorCode::NotFound, folder.string() + ": slices are missing " + between +
                                                  " (" + text_of(whole - 1) +
                                                  " of them) (--straighten fills them)"};
        return unsupported(folder, "the slices are not equally spaced: " + text_of(gap) + " mm " +
                                       between + ", elsewhere " + text_of(usual) +
                                       " mm (--straighten resamples them)");
    }
    return Ok{};
}

/// Sideways shift of a stack: middle + lean·(height − mean height), fitted by least squares.
struct Lean {
    double mean_height_mm = 0;
    Vec3d middle_mm{}, per_mm{};

    Lean(const std::vector<double>& heights, const std::vector<Vec3d>& shifts) {
        const double count = double(heights.size());
        for (std::size_t n = 0; n < heights.size(); ++n) {
            mean_height_mm += heights[n] / count;
            middle_mm = middle_mm + (1 / count) * shifts[n];
        }
        double squares = 0;
        Vec3d products{};
        for (std::size_t n = 0; n < heights.size(); ++n) {
            const double height = heights[n] - mean_height_mm;
            squares += height * height;
            products = products + height * (shifts[n] - middle_mm);
        }
        if (squares > 0) per_mm = (1 / squares) * products;
    }
    Vec3d at(double height) const { return middle_mm + (height - mean_height_mm) * per_mm; }
};

Status check_straight(const fs::path& folder, const std::vector<DicomSlice>& slices, Vec3d normal,
                      const std::vector<double>& heights, std::vector<std::string>& notes) {
    std::vector<Vec3d> shifts;
    for (std::size_t n = 0; n < slices.size(); ++n) {
        const Vec3d way = slices[n].position - slices.front().position;
        shifts.push_back(way - (heights[n] - heights.front()) * normal);
    }
    const Lean lean(heights, shifts);
    const Vec3d spacing = slices.front().spacing_mm;
    const double height = heights.back() - heights.front();
    const double pixels_mm = kMaxShiftPixels * std::min(spacing.x, spacing.y);
    const double slope = norm(lean.per_mm);
    if (slope > kMaxLean && slope * height > pixels_mm) {
        constexpr double kDegrees = 57.29577951308232;
        return unsupported(folder, "the stack of slices leans by " +
                                       text_of(std::round(10 * kDegrees * std::atan(slope)) / 10) +
                                       " degrees (gantry tilt), expected slices that lie straight "
                                       "above each other (--straighten resamples them)");
    }
    const double allowed = std::max(pixels_mm, kSmallShiftMm + kMaxLean * height);
    double largest = 0;
    bool noted = false;
    for (std::size_t n = 0; n < slices.size(); ++n) {
        const double off = norm(shifts[n] - lean.at(heights[n]));
        if (off > allowed)
            return unsupported(folder, "the slice " + slices[n].name() +
                                           " is shifted sideways by " +
                                           text_of(std::round(100 * off) / 100) +
                                           " mm, expected slices that lie straight above each "
                                           "other (--straighten resamples them)");
        const double shift = norm(shifts[n]);
        largest = std::max(largest, shift);
        noted = noted || shift > kSmallShiftMm + kMaxLean * (heights[n] - heights.front());
    }
    if (noted)
        notes.push_back("slices are shifted sideways by up to " +
                        text_of(std::round(100 * largest) / 100) + " mm and taken for straight");
    return Ok{};
}

/// Positions of sorted slices as they are.
SliceStack irregular_stack(const std::vector<DicomSlice>& slices, const Mat3d& axes,
                           const std::vector<double>& heights) {
    SliceStack stack;
    stack.axes = axes;
    stack.origin_mm = slices.front().position;
    stack.step_i_mm = slices.front().spacing_mm.x;
    stack.step_j_mm = slices.front().spacing_mm.y;
    stack.heights_mm = heights;
    stack.gap_mm = usual_gap(heights);
    for (const DicomSlice& slice : slices) {
        const Vec3d way = slice.position - stack.origin_mm;
        stack.shifts_i_mm.push_back(dot(way, axes.columns[0]));
        stack.shifts_j_mm.push_back(dot(way, axes.columns[1]));
    }
    return stack;
}

/// Spacing of a single slice along its normal.
double thickness_of(const DicomSlice& slice, std::vector<std::string>& notes) {
    const bool known = slice.thickness_mm >= kMinSpacingMm && slice.thickness_mm <= kMaxSpacingMm;
    notes.push_back("one slice; " + (known ? "its thickness of " + text_of(slice.thickness_mm) +
                                                 " mm is taken as the spacing"
                                           : std::string("its spacing is taken as 1 mm")));
    return known ? slice.thickness_mm : 1;
}

/// Remedy by straightening, for the message that refuses a stack.
std::string mended(const std::string& message, const fs::path& folder) {
    std::string text = message.substr(std::min(message.size(), folder.string().size() + 2));
    return text.substr(0, std::min(text.find(", expected"), text.find(" (--straighten")));
}

}  // namespace

const char* difference_of(const DicomSlice& a, const DicomSlice& b) {
    if (a.rows != b.rows || a.columns != b.columns) return "size";
    if (norm(a.row - b.row) > kSameSliceAxes || norm(a.column - b.column) > kSameSliceAxes)
        return "orientation";
    if (norm(a.spacing_mm - b.spacing_mm) > 1e-4 * norm(a.spacing_mm)) return "pixel spacing";
    return nullptr;
}

Result<DicomStack> stack_slices(const fs::path& folder, std::vector<DicomSlice>& slices,
                                bool straighten, std::vector<std::string>& notes) {
    const DicomSlice first = slices.front();
    DicomStack stack;
    Grid& grid = stack.grid;
    grid.direction = {{first.row, first.column, cross(first.row, first.column)}};
    if (!is_perpendicular(grid.direction))
        return unsupported(first.path, "Image Orientation (Patient) is (" + text_of(first.row) +
                                           "), (" + text_of(first.column) +
                                           "), expected perpendicular unit vectors");
    for (Vec3d& axis : grid.direction.columns) axis = normalized(axis);
    const Vec3d normal = grid.direction.columns[2];
    std::sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
        const double da = dot(normal, a.position), db = dot(normal, b.position);
        if (da != db) return da < db;
        return a.path != b.path ? a.path < b.path : a.frame < b.frame;
    });
    const Vec3d start = slices.front().position;
    std::vector<double> heights;
    for (const DicomSlice& slice : slices) heights.push_back(dot(normal, slice.position - start));
    if (slices.size() > 1) {
        if (Status status = check_apart(folder, slices, heights); !status) return status.error();
        for (const Status& status : {check_gaps(folder, slices, heights),
                                     check_straight(folder, slices, normal, heights, notes)}) {
            if (status) continue;
            if (!straighten) return status.error();
            notes.push_back(mended(status.error().message, folder));
            stack.irregular = irregular_stack(slices, grid.direction, heights);
        }
    }
    grid.size = {first.columns, first.rows, std::int32_t(slices.size())};
    grid.spacing_mm = {first.spacing_mm.x, first.spacing_mm.y,
                       slices.size() > 1 ? heights.back() / double(slices.size() - 1)
                                         : thickness_of(first, notes)};
    grid.origin_mm = start;
    if (Status status = check_grid(folder, grid); !status) return status.error();
    return stack;
}

}  // namespace pliant
