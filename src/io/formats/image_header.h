// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The header of an image file: NRRD, MetaImage, NIfTI, VTI or VTK. Each format has its own reader,
// which refuses nonsense in one line before memory for the data is allocated. Reading a header
// opens no data file: the caller first decides whether it may be opened.

#pragma once

#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/number_type.h"
#include "volume/grid_limits.h"

namespace pliant {

enum class ImageFormat { Nrrd, MetaImage, Nifti, Vti, Vtk };

using Component = NumberType;  ///< of a stored number

std::string_view name_of(ImageFormat format);
std::string_view name_of(Component component);

enum class DataEncoding {
    Raw,
    Deflated,  ///< gzip or zlib
    Text,
    VtkArray  ///< an array of VTK's XML files, with its length in front, in base64 or blocks
};

/// Encoding of an array in VTK's XML files.
struct VtkArray {
    enum class Codec { None, Zlib, Lz4 };
    Codec codec = Codec::None;
    bool base64 = false;
    bool wide_counts = false;  ///< lengths have 64 bits, otherwise 32
};

/// Location of the data: one file, or several consecutive files with equal parts.
struct DataLocation {
    std::vector<std::filesystem::path> files;
    std::int64_t expected_files = 0;  ///< required number of files; 0: any number that divides the
                                      ///< voxels
    DataEncoding encoding = DataEncoding::Raw;
    std::uint64_t start = 0;       ///< skipped bytes at the start of each file
    std::int64_t line_skip = 0;    ///< then skipped lines
    std::uint64_t byte_skip = 0;   ///< then skipped bytes (before decompression)
    std::uint64_t inner_skip = 0;  ///< skipped decompressed bytes
    bool at_end = false;           ///< the data are the last (decompressed) bytes of each file
    bool swapped = false;          ///< numbers are in the other byte order
    /// Consecutive numbers of one component before the next component's; 1 if the numbers of a
    /// voxel are adjacent.
    std::uint64_t voxels_before_component = 1;
    VtkArray vtk{};
    bool rescaled = false;  ///< a voxel is slope · number + intercept
    double slope = 1, intercept = 0;
};

struct ImageHeader {
    ImageFormat format = ImageFormat::Nrrd;
    std::vector<std::int64_t> sizes;      ///< voxels along each axis of space (or time)
    std::int64_t components = 1;          ///< numbers per voxel
    bool has_frames = false;              ///< the components are the images of a 4-D file
    bool is_list = false;                 ///< they are these, or the numbers of a vector
    Component stored = Component::Int16;  ///< type of the numbers in the file
    Grid grid;                            ///< LPS; its size is set if sizes are three valid numbers
    KeyValues key_values;
    std::vector<std::string> notes;
    DataLocation data;
    /// Signs that convert the components of the file's vectors to LPS.
    Vec3d vector_sign{1, 1, 1};
    bool turned_vectors = false;  ///< vectors have a separate measurement frame
};

Result<ImageHeader> read_nrrd_header(const std::filesystem::path& path);
Result<ImageHeader> read_meta_header(const std::filesystem::path& path);
/// Whether MetaImage uses a name for a field of its own; such keys are not written.
bool is_meta_field(std::string_view name);
Result<ImageHeader> read_nifti_header(const std::filesystem::path& path);
/// Bytes between the header of a NIfTI file and its voxels, up to 1 MiB: its extensions.
/// @returns empty if there are none, and for other files
#pragma GCC visibility push(default)  // for other components
Result<std::string> nifti_extension(const std::filesystem::path& path);
#pragma GCC visibility pop
Result<ImageHeader> read_vti_header(const std::filesystem::path& path);
Result<ImageHeader> read_vtk_header(const std::filesystem::path& path);

/// Checks that a grid is usable: valid spacing, origin and directions.
/// @param may_lean  axes need not be perpendicular, but must span the space
Status check_grid(const std::filesystem::path& path, const Grid& grid, bool may_lean = false);
/// Checks the choice of an image in a file with several.
Status check_frame(const std::filesystem::path& path, std::int64_t frames,
                   const std::optional<std::int64_t>& frame);
/// Checks the range of a spacing. @param axis  0…2
Status check_spacing(const std::filesystem::path& path, int axis, double spacing_mm);
Status check_origin(const std::filesystem::path& path, Vec3d origin_mm);
/// Checks that there are voxels along each axis, and not too many.
Status check_counts(const std::filesystem::path& path, const std::vector<std::int64_t>& sizes);
/// Checks the counts, and that the image is 3-D.
Status check_size(const std::filesystem::path& path, const std::vector<std::int64_t>& sizes);
/// Takes the fourth axis of a file, the slowest one, for its images. Adds the missing axes of a 1-D
/// or 2-D image.
void take_axes(ImageHeader& header);
/// Checks size, grid, and the number of components per voxel; those of a 4-D file don't count. Sets
/// the grid's size.
#pragma GCC visibility push(default)  // for other components
Status check_header(const std::filesystem::path& path, int components, ImageHeader& header,
                    bool may_lean = false);
#pragma GCC visibility pop

/// Whether ITK uses a key for header fields; such keys are not passed on.
bool is_itk_key(std::string_view key);

/// Notes tolerated axes that lean by more than rounding.
void note_lean(const Grid& grid, std::vector<std::string>& notes);

}  // namespace pliant
