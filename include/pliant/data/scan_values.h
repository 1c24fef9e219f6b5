// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Kind of a scan's values, and defaults that suit them: window, threshold, materials, background.
//
// @code
//   ReadNotes notes;
//   Result<Volume> scan = read_volume("head.nii.gz", {}, &notes);
//   const ValueDefaults values = value_defaults(*scan, notes);
//   scan->background = float(values.background);
//   ChainMailSettings settings;
//   suit_materials(values, settings);  // material.h
// @endcode
//
// Values are Hounsfield units if
//
//   * DICOM says so: Modality CT with Rescale Type HU, or CT without a type whose numbers are
//     shifted or scaled;
//   * the scan is a phantom of make_phantom; or
//   * nothing is said, and the histogram looks like CT:
//       - values −1100…−850 (air and lung) are in 0.1 % of the voxels or more, values −200…300
//         (soft tissue) in 1 % or more, and none is below −4096; or
//       - all values are whole, the lowest is −1100…−30, and values −200…300 are in half of the
//         voxels or more: a part of CT without air.
//
// Other statements of DICOM are believed. A CT that isn't in HU has air and soft tissue at two
// peaks, which are found, and is treated like CT with −1000 and 40 HU there. In all other scans
// nothing is bone, and the lowest values are air if they are a peak of their own.

#pragma once

#include <pliant/volume.h>

#include <string>

#pragma GCC visibility push(default)
namespace pliant {

/// Two values, low < high.
struct ValueSpan {
    double low = 0, high = 0;
    friend constexpr bool operator==(const ValueSpan&, const ValueSpan&) = default;
};

enum class ValueKind {
    Hounsfield,  ///< CT in HU
    XRay,        ///< CT that is not in HU, such as cone-beam CT
    Magnetic,    ///< MR
    Ultrasound,
    Other,
};

/// "CT in HU", "CT without HU", "MR", "ultrasound", "values without a unit".
std::string name_of(ValueKind kind);
/// " HU", or nothing.
std::string unit_of(ValueKind kind);

/// A scan's kind, and settings for it. The defaults are those for CT in HU.
struct ValueDefaults {
    ValueKind kind = ValueKind::Hounsfield;
    std::string reason{};  ///< "DICOM says MR", "by its histogram", …
    double window = 1500;  ///< of sections
    double level = -200;
    double blended_window = 500;  ///< of the blended view's opacity
    double blended_level = 150;
    double iso = -500;             ///< threshold of the surface
    bool lumen_is_bright = false;  ///< the polarity: falling, else rising
    ValueSpan range{-1000, 3095};  ///< of the material law
    bool has_air = true;           ///< air is a material of its own
    double air_threshold = -500;   ///< smaller values are air
    double bone_threshold = 300;   ///< larger values don't move
    bool has_bone = true;          ///< false: the threshold is the highest value
    double background = kAirHu;    ///< beyond the scan
};

/// Finds a scan's kind and the defaults for it. Reads a sample of up to 2¹⁸ values if the scan may
/// be CT, and all values of others; the result depends on the values and the notes alone.
/// @param notes  of read_volume; default: the file told nothing
ValueDefaults value_defaults(const Volume& volume, const ReadNotes& notes = {});

/// The kind and its reason: "MR (DICOM says MR)".
std::string kind_text(const ValueDefaults& values);
/// The defaults: "window 900, level 450, iso 300 falling, no air, no bone, …".
std::string defaults_text(const ValueDefaults& values);
/// Both in one line; empty for CT in HU, which needs no remark. @param how  to change them
std::string remark_on(const ValueDefaults& values, const std::string& how);

/// Factor of lengths that suit a body, such as a tool's radius: 1 for scans whose longest side is
/// 100 mm or more, proportional to it for smaller specimens.
double length_scale(const Grid& grid);

/// Percentiles of all values, exact up to 1/65536 of their range. @param percent  0…100
std::vector<double> percentiles(const Volume& volume, std::span<const double> percent);

}  // namespace pliant
#pragma GCC visibility pop
