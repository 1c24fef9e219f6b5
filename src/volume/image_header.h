// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What the header of an image file says, read by Pliant itself before ITK sees the file.
//
// ITK decodes the voxels (byte order, compression, text, several data files), but what surrounds
// them is too precious to leave to it: it takes a direction that isn't a number for a missing one,
// repairs bad spacings, sorts key/value pairs, and asks for memory before it has looked at the
// length of the file. So the header is read here, every field of it is judged, the length of the
// data is compared with the file, and only then memory is asked for.

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

namespace pliant {

enum class ImageFormat { Nrrd, MetaImage, Nifti };

/// Type of a stored number.
enum class Component { Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64, Float32, Float64 };

std::string_view name_of(ImageFormat format);
std::string_view name_of(Component component);
std::size_t size_of(Component component);

enum class DataEncoding { Raw, Compressed, Text };

struct ImageHeader {
    ImageFormat format = ImageFormat::Nrrd;
    std::vector<std::int64_t> sizes;  ///< voxels along each axis of space (or time)
    std::int64_t components = 1;      ///< numbers per voxel
    Component component = Component::Int16;
    Grid grid;  ///< LPS; its size is set where sizes are three sensible numbers
    KeyValues key_values;
    std::vector<std::string> notes;

    std::filesystem::path data_file;  ///< empty: several files
    std::uint64_t data_offset = 0;    ///< bytes that come before the data, at least
    DataEncoding encoding = DataEncoding::Raw;

    /// From vectors in the file to LPS: the sign of each component.
    Vec3d vector_sign{1, 1, 1};
};

Result<ImageHeader> read_nrrd_header(const std::filesystem::path& path);
Result<ImageHeader> read_meta_header(const std::filesystem::path& path);
Result<ImageHeader> read_nifti_header(const std::filesystem::path& path);

/// Longest axis, and most voxels, that are read [voxels].
inline constexpr std::int64_t kMaxAxisSize = 1 << 16;
inline constexpr std::int64_t kMaxVoxelCount = std::int64_t(1) << 32;

/// Whether a grid is one to work on: two voxels or more along each axis, spacing, origin and
/// directions that are sensible numbers.
Status check_grid(const std::filesystem::path& path, const Grid& grid);
/// check_grid, and whether the file holds a 3-D image of that many components and all of its data.
/// Sets the grid's size.
Status check_header(const std::filesystem::path& path, int components, ImageHeader& header);

/// Sets the grid's spacing and direction from the steps to the next voxel [mm, LPS].
void set_axes(Grid& grid, const Vec3d (&steps_mm)[3]);
/// Whether the axes are perpendicular, to within what rounding in a file may do to them.
bool is_perpendicular(const Mat3d& direction);

}  // namespace pliant
