// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "volume/image_header.h"

#include "volume/text.h"

#include <cmath>
#include <system_error>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr double kMinSpacingMm = 1e-6;
constexpr double kMaxSpacingMm = 1e4;
constexpr double kMaxOriginMm = 1e8;
/// Cosine between axes that pass as perpendicular: 0.06 degrees.
constexpr double kMaxSkew = 1e-3;
/// A compressed byte stands for at most this many (deflate's own bound is 1032).
constexpr std::uint64_t kMaxCompressionRatio = 1040;

Error unreadable(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}
Error unsupported(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unsupported, path.string() + ": " + message};
}

Status check_sizes(const fs::path& path, int components, ImageHeader& header) {
    if (header.sizes.size() != 3)
        return unsupported(path, "holds a " + std::to_string(header.sizes.size()) + "-D image (" +
                                     text_of_sizes(header.sizes) + "), expected 3-D");
    if (header.components != components)
        return unsupported(path, "holds " + std::to_string(header.components) +
                                     " numbers per voxel, expected " + std::to_string(components));
    double count = 1;
    for (const std::int64_t size : header.sizes) {
        if (size < 1)
            return unreadable(path, "size is " + text_of_sizes(header.sizes) +
                                        ", expected voxels along each axis");
        count *= double(size);
        if (size > kMaxAxisSize || count > double(kMaxVoxelCount))
            return Error{ErrorCode::LimitExceeded,
                         path.string() + ": size is " + text_of_sizes(header.sizes) +
                             ", expected at most " + std::to_string(kMaxAxisSize) +
                             " voxels along an axis and " + std::to_string(kMaxVoxelCount) +
                             " in all"};
    }
    header.grid.size = {std::int32_t(header.sizes[0]), std::int32_t(header.sizes[1]),
                        std::int32_t(header.sizes[2])};
    return Ok{};
}

Status check_data_length(const fs::path& path, const ImageHeader& header) {
    if (header.data_file.empty()) return Ok{};
    std::error_code error;
    const bool beside = header.data_file != path;
    const std::string what = beside ? "its data file " + header.data_file.string() : "the file";
    if (beside && !fs::is_regular_file(header.data_file, error))
        return Error{ErrorCode::NotFound, path.string() + ": " + what + " is missing"};
    const std::uint64_t length = fs::file_size(header.data_file, error);
    if (error) return unreadable(path, what + " can't be read (" + error.message() + ")");
    const std::uint64_t values =
        std::uint64_t(voxel_count(header.grid)) * std::uint64_t(header.components);
    std::uint64_t least = values * size_of(header.component);
    if (header.encoding == DataEncoding::Compressed) least /= kMaxCompressionRatio;
    if (header.encoding == DataEncoding::Text) least = 2 * values - 1;
    if (length < header.data_offset + least)
        return unreadable(path, "ends early: " + what + " has " + std::to_string(length) +
                                    " bytes, expected at least " +
                                    std::to_string(header.data_offset + least) + " for " +
                                    text_of_sizes(header.sizes) + " voxels");
    return Ok{};
}

}  // namespace

std::string_view name_of(ImageFormat format) {
    switch (format) {
        case ImageFormat::Nrrd:
            return "NRRD";
        case ImageFormat::MetaImage:
            return "MetaImage";
        case ImageFormat::Nifti:
            return "NIfTI";
    }
    return {};
}

std::string_view name_of(Component component) {
    constexpr std::string_view kNames[] = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                           "uint32", "int64", "uint64", "float32", "float64"};
    return kNames[int(component)];
}

std::size_t size_of(Component component) {
    constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return kSizes[int(component)];
}

bool is_perpendicular(const Mat3d& direction) {
    const auto& c = direction.columns;
    for (int a = 0; a < 3; ++a) {
        if (!(std::abs(norm(c[a]) - 1) <= kMaxSkew)) return false;
        if (!(std::abs(dot(c[a], c[(a + 1) % 3])) <= kMaxSkew)) return false;
    }
    return true;
}

void set_axes(Grid& grid, const Vec3d (&steps_mm)[3]) {
    for (int a = 0; a < 3; ++a) {
        grid.spacing_mm[a] = norm(steps_mm[a]);
        grid.direction.columns[a] = (1 / grid.spacing_mm[a]) * steps_mm[a];
    }
}

Status check_grid(const fs::path& path, const Grid& grid) {
    for (int a = 0; a < 3; ++a) {
        if (grid.size[a] < 2)
            return unsupported(path, "has " + std::to_string(grid.size[a]) + " voxel along axis " +
                                         std::to_string(a + 1) + ", expected 2 or more");
        const double spacing = grid.spacing_mm[a];
        if (!(spacing >= kMinSpacingMm && spacing <= kMaxSpacingMm))
            return unreadable(path, "spacing of axis " + std::to_string(a + 1) + " is " +
                                        text_of(spacing) + " mm, expected " +
                                        text_of(kMinSpacingMm) + " to " + text_of(kMaxSpacingMm));
        if (!(std::abs(grid.origin_mm[a]) <= kMaxOriginMm))
            return unreadable(path, "origin is (" + text_of(grid.origin_mm) +
                                        ") mm, expected three numbers within " +
                                        text_of(kMaxOriginMm));
    }
    if (!is_perpendicular(grid.direction)) {
        const auto& c = grid.direction.columns;
        return unsupported(path, "axes point along (" + text_of(c[0]) + "), (" + text_of(c[1]) +
                                     "), (" + text_of(c[2]) +
                                     "), expected perpendicular directions");
    }
    return Ok{};
}

Status check_header(const fs::path& path, int components, ImageHeader& header) {
    if (Status status = check_sizes(path, components, header); !status) return status;
    if (Status status = check_grid(path, header.grid); !status) return status;
    return check_data_length(path, header);
}

}  // namespace pliant
