// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files of scans and vector fields. A reader maps voxels that are stored as they are in memory; an
// output appears at once, or not at all.
//
// @code
//   Result<Volume> scan = read_volume("ct.nrrd");
//   if (!scan) std::puts(scan.error().message.c_str());  // one line with the file's name
// @endcode

#pragma once

#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct ReadOptions {
    /// DICOM series to read: its UID ("none" if it has none), its number, or a part of its
    /// description that no other has; empty: the only readable one.
    std::string series_uid{};
    bool may_map = true;  ///< false: the file may change while the volume lives
    Progress progress{};  ///< called while voxels are read; may be empty
    /// Polled between pieces of a file, a few milliseconds each; true cancels the reading with
    /// LimitExceeded. May be empty.
    std::function<bool()> give_up{};
    /// Image of a 4-D file to read, from 0; empty: the file must be 3-D, or hold one image.
    std::optional<std::int64_t> frame{};
    /// Resample (trilinear) to a regular grid if axes aren't perpendicular, or DICOM slices are
    /// tilted, shifted, missing or not equally spaced. A note describes it. False: refused.
    bool straighten = false;
    /// Size of the voxels of DICOM images without a position, orientation or Pixel Spacing, which
    /// are then stacked in the order of their Instance Numbers or frames. Empty: refused.
    std::optional<Vec3d> spacing_mm{};
};

/// Reads NRRD, MetaImage, NIfTI, VTI, VTK structured points, a multi-frame DICOM file, or a folder
/// of DICOM slices (sorted by position along their normal). Folders in it are searched if it has no
/// slices of its own. Compressed DICOM pixels are decoded by the program pliant-decode-pixels,
/// which is searched beside the running program and in Pliant's installation. Voxels stored in a
/// file in their memory layout (raw, 16-bit integers or floats, not scaled) are mapped instead of
/// read. Such a file must not be truncated while the volume lives, nor written to in place
/// (VoxelMemory::mapped). Replacing it is safe.
/// @param[out] notes  format, stored type and remarks; may be null
/// @returns NotFound, Unreadable or Unsupported with one line that names the file. If a series must
///          be chosen, the error's field is "series", and `expected` has lines of table_of_series
Result<Volume> read_volume(const std::filesystem::path& path, const ReadOptions& options = {},
                           ReadNotes* notes = nullptr);

/// Resamples a volume whose axes aren't perpendicular, as ReadOptions::straighten does. Another one
/// is returned as it is.
/// @param name     of the volume, in errors
/// @param give_up  as in ReadOptions
/// @returns Unsupported for axes that don't span the space; InvalidArgument; LimitExceeded
Result<Volume> straightened(const Volume& sheared, const std::string& name = "volume",
                            const std::function<bool()>& give_up = {});

/// Reads a label map, as read_volume does. A file of several layers, in which 3D Slicer stores
/// segments that overlap, has one chosen by its number behind the name, from 0:
/// "organs.seg.nrrd#1". The keys of the segments are those of the layer.
/// @returns also InvalidArgument for several layers without a choice, sheared axes, and values that
///          aren't whole numbers
Result<Volume> read_labels(const std::filesystem::path& path, const ReadOptions& options = {},
                           ReadNotes* notes = nullptr);
/// Path of a label map without the number of its layer.
std::filesystem::path label_file(const std::filesystem::path& path);

/// A series of DICOM slices in a folder.
struct DicomSeries {
    std::string uid;                    ///< "none" if the files have none
    std::string number;                 ///< Series Number; may be empty
    std::string description, modality;  ///< may be empty
    int slices = 0;                     ///< of all volumes
    std::int64_t volumes = 1;           ///< to choose from with ReadOptions::frame
    Vec3i size{};                       ///< of the first volume [voxels]; zeros: unknown
    Vec3d spacing_mm{};                 ///< of the first volume; zeros: unknown
    std::string fault{};                ///< reason why it can't be read; empty: none
};

/// Series of a folder, or of that of a DICOMDIR, by their numbers. Pixels are not read.
/// @returns NotFound for a folder without DICOM images, or Unreadable
Result<std::vector<DicomSeries>> list_series(const std::filesystem::path& folder);

/// Lines of a table of series, the heading first: number, description, modality, slices, size,
/// spacing, UID.
std::string table_of_series(std::span<const DicomSeries> series);

enum class Encoding { Gzip, Raw };

/// Name endings that write_volume accepts: ".nrrd", ".nhdr", ".nii", …
std::span<const std::string_view> volume_endings() noexcept;

/// Writes a volume in the format of its name's ending. Voxels keep their type and values.
///
///   .nrrd, .nhdr      LPS, with the volume's key/value pairs; .nhdr has its data beside it
///   .mha, .mhd        likewise, without keys that MetaImage can't express
///   .nii, .nii.gz     NIfTI-1, RAS; positions are rounded to 32-bit floats
///   .vti              write_vti
///
/// @param encoding  of NRRD and MetaImage
/// @param give_up   polled between pieces of the data, a few milliseconds each, except of .vti;
///                  true cancels with LimitExceeded, and nothing is written. May be empty
/// @returns Unwritable, also for another name; Unsupported if the format
///          can't hold the volume
Status write_volume(const std::filesystem::path& path, const Volume& volume,
                    Encoding encoding = Encoding::Gzip, const std::function<bool()>& give_up = {});

/// Writes a NRRD vector image (float32, `kinds: vector domain domain domain`) with the key
/// `displacement field type`, which 3D Slicer opens as a transform. A name that ends in .nii or
/// .nii.gz: NIfTI with the intent of vectors, whose components are LPS as in ITK's and ANTs' files.
/// @param give_up  as of write_volume
Status write_vector_field(const std::filesystem::path& path, const VectorField& field,
                          Encoding encoding = Encoding::Gzip,
                          const std::function<bool()>& give_up = {});

/// Writes a field that is generated slice by slice, and never in memory as a whole.
Status write_vector_field(const std::filesystem::path& path, const Grid& grid, FieldKind kind,
                          const FieldSlices& fill_slice, Encoding encoding = Encoding::Gzip,
                          const std::function<bool()>& give_up = {});
/// Reads NRRD, MetaImage, or NIfTI with a fifth axis of three: vectors in LPS, or displacements
/// (intent 1006) in RAS, as ITK takes them. A file that doesn't tell its kind is Resampling.
Result<VectorField> read_vector_field(const std::filesystem::path& path);

// Volumes for ParaView: VTK's XML image file. 3D Slicer doesn't support it; it opens NRRD.

/// Writes the voxels unchanged (int16 or float32), raw, appended to the header. The grid's
/// direction becomes VTK's Direction, which VTK reads since version 9. Atomic.
/// @param name  of the values, without XML metacharacters
/// @returns InvalidArgument for such a name or a volume that check_volume refuses, Unwritable
Status write_vti(const std::filesystem::path& path, const Volume& volume,
                 const std::string& name = "hu");

}  // namespace pliant
#pragma GCC visibility pop
