// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan: voxel values on a grid, with the key/value pairs of its file.
//
// CT values are Hounsfield units. They are stored in 16 bits if all are whole numbers in
// −32768…32767, and as float otherwise.

#pragma once

#include <pliant/grid.h>
#include <pliant/result.h>
#include <pliant/voxel_array.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Value of air [HU], assumed outside of every scan and in gaps of the deformed tissue.
inline constexpr int kAirHu = -1000;

using KeyValues = std::vector<std::pair<std::string, std::string>>;

struct Volume {
    Grid grid;
    /// One value per voxel, i fastest: voxel_count(grid) of them.
    std::variant<VoxelArray<std::int16_t>, VoxelArray<float>> voxels;
    KeyValues key_values;  ///< as in the file, in its order

    bool is_16_bit() const { return voxels.index() == 0; }
    /// Value of voxel ijk [HU]. @pre ijk inside the grid
    float at(Vec3i ijk) const {
        const std::size_t n = voxel_index(grid, ijk);
        return is_16_bit() ? float((*std::get_if<0>(&voxels))[n]) : (*std::get_if<1>(&voxels))[n];
    }
};

/// Checks a volume that a program has filled in, in constant time: the size of each axis (1…65536),
/// spacing (10⁻⁶…10⁴ mm), origin (within 10⁸ mm), direction (perpendicular unit columns, to within
/// 0.001), and the number of voxels. Every function of the library that takes a volume and can fail
/// calls it. Functions that return a picture treat an invalid volume as air.
///
/// Voxel values are not checked. A NaN counts as air in material lookups, propagates through
/// interpolation, and is never a wall to a ray.
/// @param name  of the volume, for the message
/// @returns InvalidArgument with the field, the expected and the found value
Status check_volume(const Volume& volume, const std::string& name = "volume");
/// Checks a grid alone.
Status check_grid(const Grid& grid, const std::string& name = "volume");

/// Trilinear interpolation at a continuous voxel index; voxels outside of the grid are air.
float sample_linear(const Volume& volume, Vec3d ijk);

/// Progress of long work, 0…1. Called on the calling thread.
using Progress = std::function<void(double fraction)>;

/// A reader's remarks on the volume.
struct ReadNotes {
    std::string format;              ///< "NRRD", "NIfTI", "MetaImage", "DICOM"
    std::string stored_type;         ///< "int16", "uint8", "float32", …
    std::vector<std::string> notes;  ///< changes and assumptions, one line each
};

struct ReadOptions {
    /// DICOM series to read, "none" for a series without an UID; empty: the only readable one.
    std::string series_uid{};
    bool may_map = true;  ///< false: the file may change while the volume lives
    Progress progress{};  ///< called while voxels are read; may be empty
    /// Polled between pieces of a file, a few milliseconds each; true cancels the reading with
    /// LimitExceeded. May be empty.
    std::function<bool()> give_up{};
};

/// Reads NRRD, NHDR, MetaImage, NIfTI, or a folder of DICOM slices (sorted by position along the
/// slice normal). Compressed DICOM pixels are decoded by the separate program pliant-decode-pixels,
/// which is searched beside the running program and in Pliant's installation. Voxels stored in a
/// file in their memory layout (raw, 16-bit integers or floats, not scaled) are mapped instead of
/// read. Such a file must not be truncated while the volume lives, nor written to in place
/// (VoxelMemory::mapped). Replacing it is safe.
/// @param[out] notes  format, stored type and remarks; may be null
/// @returns NotFound, Unreadable or Unsupported with one line that names the file
Result<Volume> read_volume(const std::filesystem::path& path, const ReadOptions& options = {},
                           ReadNotes* notes = nullptr);

enum class Encoding { Gzip, Raw };

/// Writes NRRD (.nrrd, or .nhdr with its data beside it), LPS, with the volume's key/value pairs.
Status write_volume(const std::filesystem::path& path, const Volume& volume,
                    Encoding encoding = Encoding::Gzip);

/// Whether a vector field maps the rest shape to the deformed one, or back.
enum class FieldKind {
    Modeling,    ///< forward displacement at rest voxel centres
    Resampling,  ///< inverse: output point → input point, on the output grid
};

/// One vector [mm, LPS] per voxel of a grid, i fastest.
struct VectorField {
    Grid grid;
    FieldKind kind = FieldKind::Modeling;
    std::vector<Vec3f> vectors_mm;
};

/// Checks the grid as check_volume, and the number of vectors.
Status check_field(const VectorField& field, const std::string& name = "field");

/// Writes a NRRD vector image (float32, `kinds: vector domain domain domain`) with the key
/// `displacement field type`, which 3D Slicer opens as a transform.
Status write_vector_field(const std::filesystem::path& path, const VectorField& field,
                          Encoding encoding = Encoding::Gzip);

/// Fills slice k of a field, i fastest. Called once for each slice, in order.
/// @param[out] vectors_mm  grid.size.x · grid.size.y vectors [mm, LPS], zero before
using FieldSlices = std::function<void(int k, std::span<Vec3f> vectors_mm)>;

/// Writes a field that is generated slice by slice, and never in memory as a whole.
Status write_vector_field(const std::filesystem::path& path, const Grid& grid, FieldKind kind,
                          const FieldSlices& fill_slice, Encoding encoding = Encoding::Gzip);
Result<VectorField> read_vector_field(const std::filesystem::path& path);

}  // namespace pliant
#pragma GCC visibility pop
