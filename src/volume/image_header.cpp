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

Status check_data_file(const fs::path& path, const ImageHeader& header, const fs::path& file) {
    std::error_code error;
    const bool beside = file != path;
    const std::string what = beside ? "its data file " + file.string() : "the file";
    if (beside && !fs::is_regular_file(file, error))
        return Error{ErrorCode::NotFound, path.string() + ": " + what + " is missing"};
    const std::uint64_t length = fs::file_size(file, error);
    if (error) return unreadable(path, what + " can't be read (" + error.message() + ")");
    const DataPlace& data = header.data;
    const std::uint64_t values = std::uint64_t(voxel_count(header.grid)) *
                                 std::uint64_t(header.components) / data.files.size();
    std::uint64_t least = values * size_of(header.component);
    if (data.encoding == DataEncoding::Deflated) least /= kMaxCompressionRatio;
    if (data.encoding == DataEncoding::Text) least = 2 * values - 1;
    least += data.start + data.byte_skip;
    if (length < least)
        return unreadable(path, "ends early: " + what + " has " + std::to_string(length) +
                                    " bytes, expected at least " + std::to_string(least));
    return Ok{};
}

Status check_data_files(const fs::path& path, const ImageHeader& header) {
    const std::size_t count = header.data.files.size();
    const std::uint64_t values =
        std::uint64_t(voxel_count(header.grid)) * std::uint64_t(header.components);
    if (count == 0 || values % count != 0)
        return unreadable(path, "names " + std::to_string(count) +
                                    " data files, expected a number that divides " +
                                    text_of_sizes(header.sizes) + " voxels");
    for (const fs::path& file : header.data.files)
        if (Status status = check_data_file(path, header, file); !status) return status;
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

bool is_itk_key(std::string_view key) {
    return key.starts_with("NRRD_") || key.starts_with("ITK_");
}

std::vector<std::string> numbered_names(std::string_view text) {
    const auto words = split(text, ' ');
    const std::size_t percent = text.find('%');
    if (words.size() < 4 || percent == text.npos || words[0].find('%') == words[0].npos) return {};
    const std::string_view before = words[0].substr(0, words[0].find('%'));
    std::string_view rest = words[0].substr(before.size() + 1);
    const std::size_t end = rest.find_first_not_of("0123456789");
    if (end == rest.npos || (rest[end] != 'd' && rest[end] != 'i' && rest[end] != 'u')) return {};
    const char fill = rest.starts_with('0') ? '0' : ' ';
    const auto width = whole_number_from(rest.substr(0, end)).value_or(0);
    const std::string_view after = rest.substr(end + 1);
    const auto first = whole_number_from(words[1]), last = whole_number_from(words[2]),
               step = whole_number_from(words[3]);
    if (!first || !last || !step || *step == 0 || width > 32 ||
        (*last - *first) / *step >= kMaxDataFiles)
        return {};
    std::vector<std::string> names;
    for (std::int64_t n = *first; *step > 0 ? n <= *last : n >= *last; n += *step) {
        std::string number = std::to_string(n);
        if (number.size() < std::size_t(width))
            number.insert(0, std::size_t(width) - number.size(), fill);
        names.push_back(std::string(before) + number + std::string(after));
    }
    return names;
}

void set_axes(Grid& grid, const Vec3d (&steps_mm)[3]) {
    for (int a = 0; a < 3; ++a) {
        grid.spacing_mm[a] = norm(steps_mm[a]);
        grid.direction.columns[a] = (1 / grid.spacing_mm[a]) * steps_mm[a];
    }
}

Status check_size(const fs::path& path, const std::vector<std::int64_t>& sizes) {
    const std::string found = "size is " + text_of_sizes(sizes);
    if (sizes.size() != 3)
        return unsupported(path, "holds a " + std::to_string(sizes.size()) + "-D image (" +
                                     text_of_sizes(sizes) + "), expected 3-D");
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
    const auto& sizes = header.sizes;
    if (Status status = check_size(path, sizes); !status) return status;
    if (header.components != components)
        return unsupported(path, "holds " + std::to_string(header.components) +
                                     " numbers per voxel, expected " + std::to_string(components));
    header.grid.size = {std::int32_t(sizes[0]), std::int32_t(sizes[1]), std::int32_t(sizes[2])};
    if (Status status = check_grid(path, header.grid); !status) return status;
    return check_data_files(path, header);
}

}  // namespace pliant
