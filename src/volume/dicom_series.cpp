// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "volume/dicom_series.h"

#include "core/errors.h"
#include "volume/image_header.h"
#include "volume/itk_io.h"
#include "volume/text.h"
#include "volume/voxel_builder.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Slices closer than this are at the same place [mm].
constexpr double kSamePlaceMm = 1e-3;
/// Largest deviation of a gap between slices from the usual gap, as part of it.
constexpr double kMaxGapDeviation = 0.05;
/// Sideways shift of a slice that rounding explains [mm], and the lean that is taken for straight
/// [mm per mm, 0.06 degrees].
constexpr double kMaxShiftMm = 0.02;
constexpr double kMaxLean = 1e-3;
/// Difference between direction cosines that rounding explains.
constexpr double kSameDirection = 1e-4;

/// Whether the pixels are laid out in a way that exists, and are all there.
Status check_pixels(const DicomSlice& slice) {
    const DicomPixels& p = slice.pixels;
    const bool whole_bytes =
        p.bits_allocated == 8 || p.bits_allocated == 16 || p.bits_allocated == 32;
    // GDCM doesn't shift pixels that lie higher, as only old files may have them.
    if (!whole_bytes || p.bits_stored < 1 || p.bits_stored > p.bits_allocated ||
        p.high_bit + 1 != p.bits_stored)
        return unsupported(slice.path, "stores " + std::to_string(p.bits_stored) + " bits of " +
                                           std::to_string(p.bits_allocated) + " up to bit " +
                                           std::to_string(p.high_bit) +
                                           ", expected the lowest of 8, 16 or 32");
    const std::uint64_t expected = std::uint64_t(slice.rows) * std::uint64_t(slice.columns) *
                                   std::uint64_t(p.bits_allocated / 8);
    if (p.compressed || p.bytes >= expected) return Ok{};
    return Error{ErrorCode::Unreadable, slice.path.string() + ": has " + std::to_string(p.bytes) +
                                            " bytes of pixels, expected " +
                                            std::to_string(expected)};
}

Status check_slice(const DicomSlice& slice) {
    const auto missing = [&](const char* what) {
        return Error{ErrorCode::Unreadable,
                     slice.path.string() + ": has no usable " + what + ", expected one"};
    };
    if (slice.frames != 1)
        return unsupported(slice.path, "holds " + std::to_string(slice.frames) +
                                           " frames, expected one slice per file");
    if (slice.samples_per_pixel != 1)
        return unsupported(slice.path, "holds colour (" + std::to_string(slice.samples_per_pixel) +
                                           " samples per pixel), expected 1");
    if (!slice.slope || !std::isfinite(*slice.slope)) return missing("Rescale Slope");
    if (!slice.intercept || !std::isfinite(*slice.intercept)) return missing("Rescale Intercept");
    if (!slice.position || !is_finite(*slice.position)) return missing("Image Position (Patient)");
    // Before slices are sorted by it: products of larger ones may be no numbers.
    if (Status status = check_origin(slice.path, *slice.position); !status) return status;
    if (!slice.row || !is_finite(*slice.row) || !is_finite(*slice.column))
        return missing("Image Orientation (Patient)");
    if (!slice.spacing_mm || !is_finite(*slice.spacing_mm)) return missing("Pixel Spacing");
    return check_pixels(slice);
}

Status check_same_shape(const DicomSlice& first, const DicomSlice& slice) {
    const std::string names =
        first.path.filename().string() + " and " + slice.path.filename().string();
    const auto differ = [&](const char* what) {
        return unsupported(slice.path.parent_path(), std::string("the slices ") + names +
                                                         " differ in " + what +
                                                         ", expected one for the whole series");
    };
    if (slice.rows != first.rows || slice.columns != first.columns) return differ("size");
    if (norm(*slice.row - *first.row) > kSameDirection ||
        norm(*slice.column - *first.column) > kSameDirection)
        return differ("orientation");
    if (norm(*slice.spacing_mm - *first.spacing_mm) > 1e-4 * norm(*first.spacing_mm))
        return differ("pixel spacing");
    return Ok{};
}

/// How the slices, sorted, follow each other along the normal.
Status check_stack(const fs::path& folder, const std::vector<DicomSlice>& slices, Vec3d normal) {
    std::vector<double> gaps;
    for (std::size_t n = 1; n < slices.size(); ++n)
        gaps.push_back(dot(normal, *slices[n].position - *slices[n - 1].position));
    std::vector<double> sorted = gaps;
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2),
                     sorted.end());
    const double usual = sorted[sorted.size() / 2];
    for (std::size_t n = 0; n < gaps.size(); ++n) {
        const std::string between = "between " + slices[n].path.filename().string() + " and " +
                                    slices[n + 1].path.filename().string();
        if (gaps[n] < kSamePlaceMm)
            return unsupported(
                folder, "two slices are at the same place: " + slices[n].path.filename().string() +
                            " and " + slices[n + 1].path.filename().string());
        const double steps = gaps[n] / usual;
        if (std::abs(steps - 1) <= kMaxGapDeviation) continue;
        const double whole = std::round(steps);
        if (whole >= 2 && std::abs(steps - whole) <= kMaxGapDeviation * whole)
            return Error{ErrorCode::NotFound, folder.string() + ": slices are missing " + between +
                                                  " (" + text_of(whole - 1) + " of them)"};
        return unsupported(folder, "the slices are not equally spaced: " + text_of(gaps[n]) +
                                       " mm " + between + ", elsewhere " + text_of(usual) + " mm");
    }
    for (const DicomSlice& slice : slices) {
        const Vec3d way = *slice.position - *slices.front().position;
        const double along = dot(normal, way);
        const double shift = norm(way - along * normal);
        if (shift <= kMaxShiftMm + kMaxLean * along) continue;
        constexpr double kDegrees = 57.29577951308232;
        return unsupported(folder,
                           "the stack of slices leans by " +
                               text_of(std::round(10 * kDegrees * std::atan2(shift, along)) / 10) +
                               " degrees (gantry tilt), expected slices that lie straight "
                               "above each other");
    }
    return Ok{};
}

/// Headers of all DICOM images of a folder, by name. @param[out] others  files that are none
Result<std::vector<DicomSlice>> read_headers(const fs::path& folder, std::size_t& others) {
    std::error_code error;
    std::vector<fs::path> files;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (at->is_regular_file(error)) files.push_back(at->path());
    if (error)
        return Error{ErrorCode::Unreadable,
                     folder.string() + ": can't be listed (" + error.message() + ")"};
    std::sort(files.begin(), files.end());
    std::vector<DicomSlice> slices;
    for (const fs::path& file : files) {
        auto slice = read_dicom_slice(file);
        if (!slice) return slice.error();
        if (*slice) slices.push_back(std::move(**slice));
    }
    others = files.size() - slices.size();
    return slices;
}

}  // namespace

Result<Grid> stack_slices(const fs::path& folder, std::vector<DicomSlice>& slices) {
    for (const DicomSlice& slice : slices) {
        if (Status status = check_slice(slice); !status) return status.error();
        if (Status status = check_same_shape(slices.front(), slice); !status) return status.error();
    }
    if (slices.size() < 2)
        return unsupported(folder, "the series has " + std::to_string(slices.size()) +
                                       " slice, expected 2 or more");
    const DicomSlice first = slices.front();
    Grid grid;
    grid.direction = {{*first.row, *first.column, cross(*first.row, *first.column)}};
    if (!is_perpendicular(grid.direction))
        return unsupported(first.path, "Image Orientation (Patient) is (" + text_of(*first.row) +
                                           "), (" + text_of(*first.column) +
                                           "), expected perpendicular unit vectors");
    for (Vec3d& axis : grid.direction.columns) axis = normalized(axis);
    const Vec3d normal = grid.direction.columns[2];
    std::sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
        const double da = dot(normal, *a.position), db = dot(normal, *b.position);
        return da != db ? da < db : a.path < b.path;
    });
    if (Status status = check_stack(folder, slices, normal); !status) return status.error();
    const double height = dot(normal, *slices.back().position - *slices.front().position);
    grid.size = {first.columns, first.rows, std::int32_t(slices.size())};
    grid.spacing_mm = {first.spacing_mm->x, first.spacing_mm->y,
                       height / double(slices.size() - 1)};
    grid.origin_mm = *slices.front().position;
    if (Status status = check_grid(folder, grid); !status) return status.error();
    return grid;
}

Result<std::vector<DicomSlice>> choose_series(const fs::path& folder,
                                              std::vector<DicomSlice> slices,
                                              const std::string& series_uid) {
    std::map<std::string, std::vector<DicomSlice>> series;
    for (DicomSlice& slice : slices) series[slice.series_uid].push_back(std::move(slice));
    std::string list;
    for (const auto& [uid, members] : series) {
        list += (list.empty() ? "" : "; ") + shown(uid) + " (" + std::to_string(members.size()) +
                (members.size() == 1 ? " slice" : " slices");
        if (!members.front().description.empty()) list += ", " + members.front().description;
        list += ")";
    }
    if (!series_uid.empty()) {
        const auto found = series.find(series_uid);
        if (found != series.end()) return std::move(found->second);
        return Error{ErrorCode::NotFound, folder.string() + ": has no series " + shown(series_uid) +
                                              ", expected --series with " + list};
    }
    if (series.size() > 1)
        return Error{ErrorCode::InvalidArgument, folder.string() + ": holds " +
                                                     std::to_string(series.size()) +
                                                     " series, choose one with --series: " + list};
    return std::move(series.begin()->second);
}

Result<std::vector<DicomSeries>> list_series(const fs::path& folder) {
    std::size_t others = 0;
    const auto slices = read_headers(folder, others);
    if (!slices) return slices.error();
    std::map<std::string, DicomSeries> found;
    for (const DicomSlice& slice : *slices) {
        DicomSeries& series = found[slice.series_uid];
        if (series.slices++ == 0) series.description = slice.description;
    }
    std::vector<DicomSeries> list;
    for (auto& [uid, series] : found) {
        series.uid = uid;
        list.push_back(std::move(series));
    }
    return list;
}

Result<Volume> read_dicom_folder(const fs::path& folder, const ReadOptions& options,
                                 ReadNotes& notes) {
    std::size_t others = 0;
    auto slices = read_headers(folder, others);
    if (!slices) return slices.error();
    if (slices->empty())
        return Error{ErrorCode::NotFound,
                     folder.string() + ": holds no DICOM images (" + std::to_string(others) +
                         (others == 1 ? " file looked at)" : " files looked at)")};
    auto chosen = choose_series(folder, std::move(*slices), options.series_uid);
    if (!chosen) return chosen.error();
    auto grid = stack_slices(folder, *chosen);
    if (!grid) return grid.error();
    if (Status status = check_size(folder, {grid->size.x, grid->size.y, grid->size.z}); !status)
        return status.error();
    notes.format = "DICOM";
    const DicomPixels& pixels = chosen->front().pixels;
    notes.stored_type = (pixels.is_signed ? "int" : "uint") + std::to_string(pixels.bits_allocated);
    if (others)
        notes.notes.push_back(std::to_string(others) + (others == 1 ? " file" : " files") +
                              " of the folder left out: no DICOM image");
    VoxelBuilder voxels(voxel_count(*grid));
    for (const DicomSlice& slice : *chosen)
        if (Status status = itk_read_slice(slice.path, grid->size.x, grid->size.y, voxels); !status)
            return status.error();
    return Volume{*grid, voxels.finish(notes.notes), {}};
}

}  // namespace pliant
