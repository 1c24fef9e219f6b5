// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/image_header.h"

#include "base/errors.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace fs = std::filesystem;

std::string_view name_of(ImageFormat format) {
    switch (format) {
        case ImageFormat::Nrrd:
            return "NRRD";
        case ImageFormat::MetaImage:
            return "MetaImage";
        case ImageFormat::Nifti:
            return "NIfTI";
        case ImageFormat::Vti:
            return "VTI";
        case ImageFormat::Vtk:
            return "VTK";
    }
    return {};
}

std::string_view name_of(Component component) {
    constexpr std::string_view kNames[] = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                           "uint32", "int64", "uint64", "float32", "float64"};
    return kNames[int(component)];
}

void note_lean(const Grid& grid, std::vector<std::string>& notes) {
    constexpr double kRounding = 1e-4;  // of numbers with five digits
    constexpr double kDegrees = 57.29577951308232;
    const auto& c = grid.direction.columns;
    double lean = 0;
    for (std::size_t a = 0; a < 3; ++a) lean = std::max(lean, std::abs(dot(c[a], c[(a + 1) % 3])));
    if (lean > kRounding)
        notes.push_back("axes lean by " + short_text(kDegrees * std::asin(lean)) +
                        " degrees; taken as perpendicular");
}

bool is_itk_key(std::string_view key) {
    return key.starts_with("NRRD_") || key.starts_with("ITK_");
}

Status check_counts(const fs::path& path, const std::vector<std::int64_t>& sizes) {
    const std::string found = "size is " + text_of_sizes(sizes);
    double count = 1;
    for (const std::int64_t size : sizes) {
        if (size < 1) return unreadable(path, found + ", expected voxels along each axis");
        count *= double(size);
        if (size > kMaxAxisSize || count > double(kMaxVoxelCount))
            return Error{ErrorCode::LimitExceeded,
                         path.string() + ": " + found + ", expected at most " +
                             std::to_string(kMaxAxisSize) + " voxels along an axis and " +
                             std::to_string(kMaxVoxelCount) + " in all"};
    }
    return Ok{};
}

Status check_size(const fs::path& path, const std::vector<std::int64_t>& sizes) {
    if (sizes.size() != 3)
        return unsupported(path, "holds a " + std::to_string(sizes.size()) + "-D image (" +
                                     text_of_sizes(sizes) + "), expected 3-D");
    return check_counts(path, sizes);
}

Status check_frame(const fs::path& path, std::int64_t frames,
                   const std::optional<std::int64_t>& frame) {
    const std::string valid = frames == 1 ? "0" : "0…" + std::to_string(frames - 1);
    if (!frame && frames > 1)
        return Error{ErrorCode::InvalidArgument, path.string() + ": holds " +
                                                     std::to_string(frames) +
                                                     " images, choose one with --frame " + valid};
    if (!frame || (*frame >= 0 && *frame < frames)) return Ok{};
    return Error{ErrorCode::InvalidArgument, "--frame: found " + std::to_string(*frame) +
                                                 ", expected " + valid + " for " + path.string()};
}

Status check_spacing(const fs::path& path, int axis, double spacing_mm) {
    if (spacing_mm >= kMinSpacingMm && spacing_mm <= kMaxSpacingMm) return Ok{};
    return unreadable(path, "spacing of axis " + std::to_string(axis + 1) + " is " +
                                text_of(spacing_mm) + " mm, expected " + text_of(kMinSpacingMm) +
                                " to " + text_of(kMaxSpacingMm));
}

Status check_origin(const fs::path& path, Vec3d origin_mm) {
    for (int a = 0; a < 3; ++a)
        if (!(std::abs(origin_mm[a]) <= kMaxOriginMm))
            return unreadable(path, "origin is (" + text_of(origin_mm) +
                                        ") mm, expected three numbers within " +
                                        text_of(kMaxOriginMm));
    return Ok{};
}

Status check_grid(const fs::path& path, const Grid& grid, bool may_lean) {
    for (int a = 0; a < 3; ++a)
        if (Status status = check_spacing(path, a, grid.spacing_mm[a]); !status) return status;
    if (Status status = check_origin(path, grid.origin_mm); !status) return status;
    if (is_perpendicular(grid.direction)) return Ok{};
    const auto& c = grid.direction.columns;
    const std::string found = "axes point along (" + text_of(c[0]) + "), (" + text_of(c[1]) +
                              "), (" + text_of(c[2]) + "), expected ";
    constexpr double kMinVolume = 0.1;  // of the cell that unit vectors span: 84 degrees of shear
    const double volume = std::abs(determinant(grid.direction));
    if (!(volume >= kMinVolume && volume < 2))
        return unsupported(path, found + "directions that span the space");
    if (may_lean) return Ok{};
    return unsupported(path,
                       found + "perpendicular directions (--straighten resamples sheared scans)");
}

void take_axes(ImageHeader& header) {
    auto& sizes = header.sizes;
    while (!sizes.empty() && sizes.size() < 3) sizes.push_back(1);
    while (sizes.size() > 3 && sizes.back() == 1) sizes.pop_back();
    if (sizes.size() != 4 || header.components != 1) return;
    header.components = sizes[3];
    header.has_frames = true;
    header.data.voxels_before_component = 1;
    for (std::size_t a = 0; a < 3; ++a)
        header.data.voxels_before_component *= std::uint64_t(std::max<std::int64_t>(0, sizes[a]));
    sizes.resize(3);
}

Status check_header(const fs::path& path, int components, ImageHeader& header, bool may_lean) {
    const auto& sizes = header.sizes;
    if (Status status = check_size(path, sizes); !status) return status;
    const bool frames = header.has_frames || (header.is_list && components == 1);
    const std::int64_t found = frames ? 1 : header.components;
    if (found != components)
        return unsupported(path, "holds " + std::to_string(found) +
                                     " numbers per voxel, expected " + std::to_string(components));
    header.grid.size = {std::int32_t(sizes[0]), std::int32_t(sizes[1]), std::int32_t(sizes[2])};
    return check_grid(path, header.grid, may_lean);
}

}  // namespace pliant
