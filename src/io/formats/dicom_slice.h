// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The header of one DICOM image: a file, or a frame of a file. An unusable file has a fault and its
// series, so that it blocks only that series.

#pragma once

#include "formats/dicom_walk.h"

#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// Stored numbers of pixels outside of the image, such as the corners around a circle.
struct PixelPadding {
    double low = 0, high = 0;
    /// Bits of the padding value, as they are above the stored bits too; nullopt: a float.
    std::optional<std::uint32_t> word{};
};

/// Location and encoding of the pixels.
struct DicomPixels {
    TransferSyntax syntax;
    PixelNumbers numbers = PixelNumbers::Integer;
    bool is_signed = false;
    bool is_sign_unknown = false;  ///< Pixel Representation is missing; taken as unsigned
    int bits_allocated = 16, bits_stored = 16, high_bit = 15;
    int first_bit = 0;                ///< of the first byte, for pixels of one bit
    std::size_t swapped_bytes = 0;    ///< size of units in big-endian order; 0: none
    std::uint64_t deflated_from = 0;  ///< DicomWalk::deflated_from
    /// One part if uncompressed, otherwise the fragments of a codestream.
    std::vector<FilePart> parts;
    std::optional<PixelPadding> padding{};

    bool compressed() const { return syntax.codec != PixelCodec::None; }
    bool is_float() const { return numbers != PixelNumbers::Integer; }
};

/// Header of a DICOM image.
struct DicomSlice {
    std::filesystem::path path;
    std::string series_uid;  ///< kNoSeriesUid if the file has none; empty if unknown
    std::string series_number, description;
    int rows = 0, columns = 0;
    double slope = 1, intercept = 0;  ///< value = slope·stored + intercept
    double window = 0, level = 0;     ///< first Window Width and Center; window 0: none
    std::string modality, rescale_type;
    Vec3d position{};                     ///< centre of the first pixel [mm, LPS]
    Vec3d row{};                          ///< unit vector along a row: the i axis
    Vec3d column{};                       ///< unit vector down a column: the j axis
    Vec3d spacing_mm{};                   ///< x: between columns, y: between rows; z unused
    double thickness_mm = 0;              ///< 0: unknown
    int frame = 0;                        ///< from 1; 0: the file has one
    bool is_spaced_by_thickness = false;  ///< its position follows from the frames' thickness
    /// A frame's Temporal Position Index and Dimension Index Values, or the Temporal Position
    /// Identifier of a file with one; empty: none.
    std::vector<std::uint32_t> numbers;
    std::string instance_uid;                     ///< empty: none
    std::optional<std::int64_t> instance_number;  ///< of the file
    bool is_localizer = false;                    ///< by its Image Type
    DicomPixels pixels;
    bool lacks_geometry = false;  ///< no position, orientation or spacing; not a fault then
    bool has_modality_lut = false;
    bool is_parametric_map = false;
    bool is_segmentation = false;  ///< read_dicom_segmentation reads its file
    std::optional<Error> fault;    ///< reason why it can't be used; the rest may be incomplete then

    /// Value of padding: air in a CT scan in HU, else zero.
    double padding_value() const;
    /// Name for messages.
    std::string name() const {
        return path.filename().string() + (frame ? " frame " + std::to_string(frame) : "");
    }
};

/// Series name of files without an UID.
inline constexpr const char* kNoSeriesUid = "none";

/// Slices of a file: one, one for each frame, or one with a fault; none if the file is no DICOM
/// image.
/// @param may_lack_geometry  a missing position, orientation or spacing is no fault
/// @returns Unreadable, which names the file, if it can't be opened or read
Result<std::vector<DicomSlice>> read_dicom_slices(const std::filesystem::path& path,
                                                  bool may_lack_geometry = false);

/// A segment of a segmentation.
struct DicomSegment {
    int number = 0;
    std::string label;  ///< may be empty
};

/// A segmentation, with frames of one bit a pixel for a segment, or a label map, with frames of
/// segments' numbers.
struct DicomSegmentation {
    bool is_label_map = false;
    std::vector<DicomSlice> frames;   ///< one or more
    std::vector<int> frame_segments;  ///< number of each frame's segment; empty: a label map
    std::vector<DicomSegment> segments;
};

/// Frames and segments of a file. @returns Unsupported for fractional ones, or Unreadable
Result<DicomSegmentation> read_dicom_segmentation(const std::filesystem::path& path);

/// Whether a file starts like a DICOM file.
Result<bool> looks_like_dicom(const std::filesystem::path& path);

}  // namespace pliant
