// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What the header of an image file says: NRRD, MetaImage or NIfTI. Each format has a reader of its
// own, which refuses, in one line, what makes no sense, before memory for the data is asked for. No
// data file is opened to read a header: whether they may be, the caller decides first.

#pragma once

#include <pliant/grid.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volume/grid_limits.h"

namespace pliant {

enum class ImageFormat { Nrrd, MetaImage, Nifti };

/// Type of a stored number.
enum class Component { Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64, Float32, Float64 };

std::string_view name_of(ImageFormat format);
std::string_view name_of(Component component);
std::size_t size_of(Component component);

enum class DataEncoding {
    Raw,
    Deflated,  ///< gzip or zlib
    Text
};

/// Where the data are: in one file or in several that follow each other, in equal parts.
struct DataPlace {
    std::vector<std::filesystem::path> files;
    std::int64_t expected_files = 0;  ///< that there must be; 0: any number that divides the voxels
    DataEncoding encoding = DataEncoding::Raw;
    std::uint64_t start = 0;       ///< bytes of each file before everything else
    std::int64_t line_skip = 0;    ///< lines to skip then
    std::uint64_t byte_skip = 0;   ///< bytes to skip then (before decompression)
    std::uint64_t inner_skip = 0;  ///< bytes to skip of what was decompressed
    bool at_end = false;   ///< raw data are the last bytes of each file, wherever they start
    bool swapped = false;  ///< numbers are in the other byte order
    /// Numbers of one component that follow each other before the next component's; 1 where the
    /// numbers of a voxel lie side by side.
    std::uint64_t voxels_before_component = 1;
    bool rescaled = false;  ///< a voxel is slope · number + intercept
    double slope = 1, intercept = 0;
};

struct ImageHeader {
    ImageFormat format = ImageFormat::Nrrd;
    std::vector<std::int64_t> sizes;      ///< voxels along each axis of space (or time)
    std::int64_t components = 1;          ///< numbers per voxel
    Component stored = Component::Int16;  ///< type of the numbers in the file
    Grid grid;  ///< LPS; its size is set where sizes are three sensible numbers
    KeyValues key_values;
    std::vector<std::string> notes;
    DataPlace data;
    /// From vectors in the file to LPS: the sign of each component.
    Vec3d vector_sign{1, 1, 1};
    bool turned_vectors = false;  ///< vectors are in a frame of their own
};

Result<ImageHeader> read_nrrd_header(const std::filesystem::path& path);
Result<ImageHeader> read_meta_header(const std::filesystem::path& path);
Result<ImageHeader> read_nifti_header(const std::filesystem::path& path);

/// Whether a grid is one to work on: two voxels or more along each axis, spacing, origin and
/// directions that are sensible numbers.
Status check_grid(const std::filesystem::path& path, const Grid& grid);
/// Whether it is a sensible distance between voxels. @param axis  0…2
Status check_spacing(const std::filesystem::path& path, int axis, double spacing_mm);
Status check_origin(const std::filesystem::path& path, Vec3d origin_mm);
/// Whether there are voxels along each axis, and not too many.
Status check_counts(const std::filesystem::path& path, const std::vector<std::int64_t>& sizes);
/// check_counts, and whether the image is 3-D.
Status check_size(const std::filesystem::path& path, const std::vector<std::int64_t>& sizes);
/// check_size, check_grid, and whether the file holds that many numbers per voxel. Sets the grid's
/// size.
#pragma GCC visibility push(default)  // for other components
Status check_header(const std::filesystem::path& path, int components, ImageHeader& header);
#pragma GCC visibility pop

/// Whether a key is one of those in which ITK keeps fields of the header; they are not passed on.
bool is_itk_key(std::string_view key);

/// Notes axes that pass for perpendicular, but lean by more than rounding explains.
void note_lean(const Grid& grid, std::vector<std::string>& notes);

}  // namespace pliant
