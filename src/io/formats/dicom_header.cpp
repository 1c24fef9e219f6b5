// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_slice.h"

#include "base/byte_order.h"
#include "base/errors.h"
#include "base/input_file.h"
#include "base/text.h"
#include "formats/dicom_walk.h"
#include "formats/image_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

namespace pliant {
namespace fs = std::filesystem;
namespace {

using namespace dicom_tags;

constexpr std::string_view kSegmentation = "1.2.840.10008.5.1.4.1.1.66.4",
                           kLabelMap = "1.2.840.10008.5.1.4.1.1.66.7";

/// SOP classes with pixels that are no image slices.
struct OtherObject {
    std::string_view sop_class, name;
};
constexpr OtherObject kOtherObjects[] = {
    {"1.2.840.10008.5.1.4.1.1.481.2", "an RT Dose"},
    {kSegmentation, "a segmentation"},
    {kLabelMap, "a label map"},
};

/// SOP classes of X-ray projections.
constexpr std::string_view kProjections[] = {
    "1.2.840.10008.5.1.4.1.1.12.1", "1.2.840.10008.5.1.4.1.1.12.1.1",
    "1.2.840.10008.5.1.4.1.1.12.2", "1.2.840.10008.5.1.4.1.1.12.2.1"};
/// Maximum length of a description: 64 characters in UTF-8.
constexpr std::size_t kMaxDescriptionBytes = 256;
constexpr std::string_view kNuclearMedicine = "1.2.840.10008.5.1.4.1.1.20";
/// Elements that give the time of frames: Frame Time, Frame Time Vector.
constexpr std::uint32_t kFrameTimes[] = {0x00181063, 0x00181065};

/// Number of Frames; 1 if it isn't there, nullopt if it is none.
std::optional<std::size_t> frame_count(const DicomWalk& tags) {
    const std::string text = tags.text(kFrames);
    if (trimmed(text).empty()) return 1;
    const auto count = whole_number_from(trimmed(text));
    if (!count || *count < 1) return std::nullopt;
    return std::size_t(*count);
}

/// Distances of frames without functional groups from the first one, along the normal.
struct FrameOffsets {
    std::vector<double> mm;
    bool by_thickness = false;
    std::vector<std::vector<std::uint32_t>> numbers;  ///< DicomSlice::numbers
};

/// Nuclear medicine: the frames' slices by the Slice Vector; all other vectors are numbers.
/// Projections, which have angles or rotations, are no slices.
/// @param step_mm  negative: against the normal [DICOM2024] (PS3.3, C.8.4.15)
std::optional<FrameOffsets> offsets_by_vectors(const DicomWalk& tags, std::size_t frames,
                                               double step_mm) {
    FrameOffsets offsets;
    const std::vector<std::uint32_t> pointers = tags.tags_at(kFramePointer);
    const auto points_to = [&](std::uint32_t tag) {
        return std::find(pointers.begin(), pointers.end(), tag) != pointers.end();
    };
    const std::vector<std::uint32_t> slices = tags.shorts(kSliceVector);
    if (points_to(kRotationVector) || points_to(kAngularVector) || slices.size() != frames)
        return std::nullopt;
    offsets.numbers.resize(frames);
    for (std::size_t n = 0; n < frames; ++n)
        offsets.mm.push_back((double(slices[n]) - 1) * step_mm);
    for (const std::uint32_t tag : kVolumeVectors) {
        const std::vector<std::uint32_t> numbers = tags.shorts(tag);
        if (numbers.size() != frames) continue;
        for (std::size_t n = 0; n < frames; ++n) offsets.numbers[n].push_back(numbers[n]);
    }
    return offsets;
}

/// Reads the Grid Frame Offset Vector, Spacing Between Slices, or Slice Thickness.
/// @returns nullopt if the frames' positions are unknown
std::optional<FrameOffsets> offsets_of_frames(const DicomWalk& tags, std::size_t frames) {
    const DicomValues& values = tags.values();
    if (frames > kMaxDicomFrames) return std::nullopt;
    for (const std::uint32_t tag : {kPosition, kOrientation, kPixelSpacing})
        if (!values.has(tag)) return std::nullopt;
    for (const std::uint32_t pointer : tags.tags_at(kFramePointer))
        if (std::find(std::begin(kFrameTimes), std::end(kFrameTimes), pointer) !=
            std::end(kFrameTimes))
            return std::nullopt;
    FrameOffsets offsets;
    if (values.has(kFrameOffsets)) {
        offsets.mm = values.decimals(kFrameOffsets, frames);
        // Others are coordinates in the patient.
        if (offsets.mm.empty() || offsets.mm.front() != 0) return std::nullopt;
        return offsets;
    }
    std::vector<double> step = values.decimals(kSliceSpacing, 1);
    const bool is_nuclear = tags.text(kSopClass) == kNuclearMedicine;
    if (is_nuclear && tags.has(kSliceVector) && !step.empty() && std::isfinite(step[0]))
        return offsets_by_vectors(tags, frames, step[0]);
    offsets.by_thickness = step.empty() || !(step[0] > 0);
    if (offsets.by_thickness) step = values.decimals(kSliceThickness, 1);
    if (step.empty() || !(step[0] > 0)) return std::nullopt;
    for (std::size_t n = 0; n < frames; ++n) offsets.mm.push_back(double(n) * step[0]);
    return offsets;
}

bool is_segmentation(const DicomWalk& tags) {
    const std::string sop_class = tags.text(kSopClass);
    return sop_class == kSegmentation || sop_class == kLabelMap;
}

/// Checks the SOP class, the number of frames, and the photometric interpretation.
Status check_object(const DicomWalk& tags, const fs::path& path, bool may_lack_geometry) {
    const std::string sop_class = tags.text(kSopClass);
    for (const OtherObject& other : kOtherObjects)
        if (sop_class == other.sop_class)
            return unsupported(path, "is " + std::string(other.name) +
                                         " object, expected an image of CT, MR or the like" +
                                         (is_segmentation(tags)
                                              ? "; as labels, name the file itself: --labels FILE"
                                              : ""));
    if (std::find(std::begin(kProjections), std::end(kProjections), sop_class) !=
        std::end(kProjections))
        return unsupported(path, "holds X-ray projections (angiography or fluoroscopy, " +
                                     std::to_string(frame_count(tags).value_or(1)) +
                                     " frames), expected the slices of a volume");
    if (!find_transfer_syntax(tags.syntax_uid()))
        return unsupported(path, "is " + describe_transfer_syntax(tags.syntax_uid()) +
                                     ", expected pixels without compression or in RLE, JPEG, "
                                     "JPEG-LS or JPEG 2000");
    const std::string text = tags.text(kFrames);
    const auto frames = frame_count(tags);
    if (!frames)
        return unsupported(path,
                           "holds " + shown(trimmed(text)) + " frames, expected a number ≥ 1");
    const bool is_stack = tags.frame_values().empty() && offsets_of_frames(tags, *frames);
    if (*frames > 1 && tags.frame_values().size() != *frames && !is_stack && !may_lack_geometry)
        return unsupported(path, "holds " + std::to_string(*frames) +
                                     " frames without a position for each, expected Per-Frame "
                                     "Functional Groups, a position with the distance of the "
                                     "frames, one slice per file, or --spacing X,Y,Z");
    const int samples = tags.number(kSamples, 1);
    if (samples != 1)
        return unsupported(
            path, "holds colour (" + std::to_string(samples) + " samples per pixel), expected 1");
    const std::string photometric = tags.text(kPhotometric);
    if (!photometric.empty() && photometric != "MONOCHROME1" && photometric != "MONOCHROME2")
        return unsupported(path, "has Photometric Interpretation " + shown(photometric) +
                                     ", expected MONOCHROME1 or MONOCHROME2");
    if (const int planar = tags.number(kPlanar, 0); planar > 1)
        return unsupported(
            path, "has Planar Configuration " + std::to_string(planar) + ", expected 0 or 1");
    return Ok{};
}

/// Checks that the pixel layout is valid and the pixels are complete.
Status check_pixels(const DicomSlice& slice, bool in_fragments, std::size_t frames) {
    const DicomPixels& p = slice.pixels;
    if (p.is_float() && p.compressed())
        return unsupported(slice.path, "has compressed floats as pixels, expected integers");
    const int float_bits = p.numbers == PixelNumbers::Float32 ? 32 : 64;
    if (p.is_float() && p.bits_allocated != float_bits)
        return unsupported(slice.path, "allocates " + std::to_string(p.bits_allocated) +
                                           " bits for a float, expected " +
                                           std::to_string(float_bits));
    const bool is_bits = p.bits_allocated == 1 && slice.is_segmentation;
    const bool whole_bytes = p.is_float() || is_bits || p.bits_allocated == 8 ||
                             p.bits_allocated == 16 || p.bits_allocated == 32;
    // Higher positions of the stored bits occur in old files only.
    if (!whole_bytes || p.bits_stored < 1 || p.bits_stored > p.bits_allocated ||
        p.high_bit + 1 != p.bits_stored)
        return unsupported(slice.path, "stores " + std::to_string(p.bits_stored) + " bits of " +
                                           std::to_string(p.bits_allocated) + " up to bit " +
                                           std::to_string(p.high_bit) +
                                           ", expected the lowest of 8, 16 or 32");
    if (in_fragments != p.compressed())
        return unreadable(
            slice.path, in_fragments ? "has pixels in fragments, expected none without compression"
                                     : "has compressed pixels that aren't in fragments");
    std::uint64_t found = 0;
    for (const FilePart& part : p.parts) found += part.bytes;
    const std::uint64_t bits =
        std::uint64_t(slice.rows) * std::uint64_t(slice.columns) * std::uint64_t(p.bits_allocated);
    if (frames > kMaxDicomFrames)
        return unsupported(slice.path, "holds " + std::to_string(frames) +
                                           " frames, expected up to " +
                                           std::to_string(kMaxDicomFrames));
    const std::uint64_t expected = (bits * frames + 7) / 8;
    if (p.compressed() && found == 0) return unreadable(slice.path, "has no pixels");
    if (p.compressed() || found >= expected) return Ok{};
    return unreadable(slice.path, "has " + std::to_string(found) + " bytes of pixels, expected " +
                                      std::to_string(expected));
}

/// A number of the pixels' type: integers have 16 or 32 bits, with the pixels' sign.
std::optional<double> pixel_number(const DicomWalk& tags, std::uint32_t tag, bool is_signed) {
    const auto number = [](const std::string& bytes, auto value) {
        std::memcpy(&value, bytes.data(), sizeof value);
        return double(little_endian(value));
    };
    const std::string bytes = tags.bytes_of_number(tag);
    if (tag == kFloatPadding || tag == kFloatPaddingLimit)
        return bytes.size() == 4 ? std::optional(number(bytes, float())) : std::nullopt;
    if (tag == kDoublePadding || tag == kDoublePaddingLimit)
        return bytes.size() == 8 ? std::optional(number(bytes, double())) : std::nullopt;
    if (bytes.size() == 2)
        return is_signed ? number(bytes, std::int16_t()) : number(bytes, std::uint16_t());
    if (bytes.size() == 4)
        return is_signed ? number(bytes, std::int32_t()) : number(bytes, std::uint32_t());
    return std::nullopt;
}

/// Reads the Pixel Padding Value and the limit of its range.
std::optional<PixelPadding> padding_of(const DicomWalk& tags, const DicomPixels& pixels) {
    constexpr std::uint32_t kTags[][2] = {{kPadding, kPaddingLimit},
                                          {kFloatPadding, kFloatPaddingLimit},
                                          {kDoublePadding, kDoublePaddingLimit}};
    const auto& [value_tag, limit_tag] = kTags[std::size_t(pixels.numbers)];
    const auto value = pixel_number(tags, value_tag, pixels.is_signed);
    if (!value) return std::nullopt;
    const double limit = pixel_number(tags, limit_tag, pixels.is_signed).value_or(*value);
    PixelPadding padding{std::min(*value, limit), std::max(*value, limit)};
    if (!pixels.is_float()) padding.word = std::uint32_t(std::int64_t(*value));
    return padding;
}

Status take_pixels(const DicomWalk& tags, DicomSlice& slice) {
    DicomPixels& pixels = slice.pixels;
    pixels.syntax = *find_transfer_syntax(tags.syntax_uid());
    pixels.numbers = tags.pixel_numbers();
    pixels.is_signed = tags.number(kPixelRepresentation, 0) != 0;
    pixels.is_sign_unknown = !tags.has(kPixelRepresentation) && !pixels.is_float();
    pixels.bits_allocated = tags.number(kBitsAllocated, 16);
    pixels.bits_stored = tags.number(kBitsStored, pixels.bits_allocated);
    pixels.high_bit = tags.number(kHighBit, pixels.bits_stored - 1);
    if (pixels.is_float()) {  // which have neither
        pixels.bits_stored = pixels.bits_allocated;
        pixels.high_bit = pixels.bits_allocated - 1;
    }
    pixels.swapped_bytes = tags.swapped_bytes();
    pixels.deflated_from = tags.deflated_from();
    pixels.parts = tags.pixel_parts();
    pixels.padding = padding_of(tags, pixels);
    return check_pixels(slice, tags.in_fragments(), frame_count(tags).value_or(1));
}

/// Reads an optional number. @returns false if it isn't finite
bool take_number(const DicomValues& tags, std::uint32_t tag, double& number) {
    if (trimmed(tags.text(tag)).empty()) return true;
    const auto numbers = tags.decimals(tag, 1);
    if (numbers.empty() || !std::isfinite(numbers[0])) return false;
    number = numbers[0];
    return true;
}

/// Takes the first of the windows that are offered, if it can be used.
void take_window(const DicomValues& tags, DicomSlice& slice) {
    const auto widths = numbers_from(tags.text(kWindowWidth), '\\');
    const auto centres = numbers_from(tags.text(kWindowCenter), '\\');
    if (!widths || !centres || widths->empty() || centres->empty()) return;
    if (!std::isfinite(widths->front()) || !std::isfinite(centres->front())) return;
    if (widths->front() <= 0) return;
    slice.window = widths->front();
    slice.level = centres->front();
}

Error missing(const DicomSlice& slice, const char* name, const char* remedy = "") {
    return unreadable(slice.path,
                      std::string("has no usable ") + name +
                          (slice.frame ? " of frame " + std::to_string(slice.frame) : "") +
                          ", expected one" + remedy);
}

/// Reads position, orientation and spacing.
Status take_position(const DicomValues& tags, DicomSlice& slice) {
    const auto lacks = [&](const char* name) {
        return missing(slice, name, ", or --spacing X,Y,Z");
    };
    const auto p = tags.decimals(kPosition, 3);
    if (p.empty()) return lacks("Image Position (Patient)");
    slice.position = {p[0], p[1], p[2]};
    if (!is_finite(slice.position)) return lacks("Image Position (Patient)");
    // Checked before sorting, because products of larger values may overflow.
    if (Status status = check_origin(slice.path, slice.position); !status) return status;
    const auto o = tags.decimals(kOrientation, 6);
    if (o.empty()) return lacks("Image Orientation (Patient)");
    slice.row = {o[0], o[1], o[2]};
    slice.column = {o[3], o[4], o[5]};
    if (!is_finite(slice.row) || !is_finite(slice.column))
        return lacks("Image Orientation (Patient)");
    const auto s = tags.decimals(kPixelSpacing, 2);
    if (s.empty()) return lacks("Pixel Spacing");
    slice.spacing_mm = {s[1], s[0], 0};  // the first number is the distance between rows
    if (!is_finite(slice.spacing_mm)) return lacks("Pixel Spacing");
    return Ok{};
}

Status take_geometry(const DicomValues& tags, DicomSlice& slice, bool may_lack_it) {
    take_window(tags, slice);
    if (!take_number(tags, kSliceThickness, slice.thickness_mm)) slice.thickness_mm = 0;
    if (!take_number(tags, kSlope, slice.slope)) return missing(slice, "Rescale Slope");
    if (!take_number(tags, kIntercept, slice.intercept)) return missing(slice, "Rescale Intercept");
    if (slice.slope == 0) slice.slope = 1;  // some writers use 0 for no scaling
    Status status = take_position(tags, slice);
    if (status || !may_lack_it) return status;
    slice.lacks_geometry = true;
    return Ok{};
}

/// Whether a file should have pixels: CT, MR or PET images, or files with a size in pixels.
bool ought_to_have_pixels(const DicomWalk& tags) {
    const std::string kind = tags.text(kSopClass);
    return tags.has(kRows) || kind == "1.2.840.10008.5.1.4.1.1.2" ||
           kind == "1.2.840.10008.5.1.4.1.1.4" || kind == "1.2.840.10008.5.1.4.1.1.128";
}

/// Takes the numbers that tell the slices of a series apart.
void take_identity(const DicomWalk& tags, DicomSlice& slice) {
    slice.instance_uid = tags.text(kInstanceUid);
    slice.instance_number = whole_number_from(trimmed(tags.text(kInstanceNumber)));
    slice.is_localizer = tags.text(kImageType).find("LOCALIZER") != std::string::npos;
    const auto time = whole_number_from(trimmed(tags.text(kTemporalPosition)));
    if (time && *time >= 0 && *time <= std::numeric_limits<std::uint32_t>::max())
        slice.numbers = {std::uint32_t(*time)};
}

enum class Start { Other, Preamble, Plain };

Result<Start> start_of(const fs::path& path) {
    InputFile file(path);
    std::array<char, 132> start{};
    const std::size_t count = file.read(start.data(), start.size());
    if (Status status = file.status(); !status) return status.error();
    if (count != start.size()) return Start::Other;
    if (std::memcmp(&start[128], "DICM", 4) == 0) return Start::Preamble;
    // Old files start with an element of group 8, little endian.
    return start[0] == 8 && start[1] == 0 && start[3] == 0 ? Start::Plain : Start::Other;
}

std::optional<Error> fault_of(const DicomWalk& tags, DicomSlice& slice, bool whole,
                              bool may_lack_geometry) {
    if (tags.fault()) return tags.fault();
    if (!whole || (!tags.has_pixels() && has_plain_elements(tags.syntax_uid())))
        return unreadable(slice.path, "is damaged or ends early, expected a whole DICOM file");
    if (Status status = check_object(tags, slice.path, may_lack_geometry); !status)
        return status.error();
    if (tags.frame_values().empty())
        if (Status status = take_geometry(tags.values(), slice, may_lack_geometry); !status)
            return status.error();
    if (Status status = take_pixels(tags, slice); !status) return status.error();
    return std::nullopt;
}

/// Numbers that tell the volumes of a file apart.
std::vector<std::uint32_t> numbers_of(const DicomWalk& tags, const DicomValues& values) {
    std::vector<std::uint32_t> numbers = tags.longs(values, kTemporalIndex);
    const std::vector<std::uint32_t> more = tags.longs(values, kDimensionIndices);
    numbers.insert(numbers.end(), more.begin(), more.end());
    return numbers;
}

/// Sets the geometry of a frame, from 0, by its functional groups or else by its distance from the
/// first frame.
Status place_frame(const DicomWalk& tags, std::size_t n, const FrameOffsets* offsets,
                   bool may_lack_geometry, DicomSlice& frame) {
    if (frame.lacks_geometry) return Ok{};
    if (offsets) {
        const Vec3d normal = normalized(cross(frame.row, frame.column));
        frame.position = frame.position + offsets->mm[n] * normal;
        frame.is_spaced_by_thickness = offsets->by_thickness;
        if (!offsets->numbers.empty()) frame.numbers = offsets->numbers[n];
        if (!is_finite(frame.position))
            return unreadable(frame.path,
                              "has no usable position of frame " + std::to_string(n + 1));
        return check_origin(frame.path, frame.position);
    }
    DicomValues geometry = tags.frame_values()[n];
    geometry.add_missing(tags.shared_values());
    // The position of all frames in one is none.
    if (geometry.has(kPosition) || tags.frame_values().size() == 1)
        geometry.add_missing(tags.values());
    frame.numbers = numbers_of(tags, geometry);
    return take_geometry(geometry, frame, may_lack_geometry);
}

/// Sets the bytes that hold some bits of the pixels.
void take_part(DicomPixels& pixels, std::uint64_t start, std::uint64_t first, std::uint64_t bits) {
    pixels.first_bit = int(first % 8);
    pixels.parts = {{start + first / 8, (first % 8 + bits + 7) / 8}};
}

/// Makes a slice of each frame. @param slice  the fields that all frames share, without a fault
/// @returns one slice with a fault if a frame has no position or no pixels
std::vector<DicomSlice> slices_of_frames(const DicomWalk& tags, const DicomSlice& slice,
                                         bool may_lack_geometry) {
    const auto faulty = [&](Error fault) {
        DicomSlice only = slice;
        only.fault = std::move(fault);
        return std::vector{std::move(only)};
    };
    const auto& values = tags.frame_values();
    const std::size_t frames = frame_count(tags).value_or(1);
    std::optional<FrameOffsets> offsets;
    if (values.empty()) offsets = offsets_of_frames(tags, frames);
    const bool lacks_geometry = may_lack_geometry && values.empty() && !offsets;
    if (values.size() != frames && !offsets && !lacks_geometry)
        return faulty(unsupported(slice.path, "has functional groups of " +
                                                  std::to_string(values.size()) +
                                                  " frames, expected " + std::to_string(frames)));
    std::vector<std::vector<FilePart>> parts;
    if (slice.pixels.compressed()) {
        parts = tags.parts_of_frames(frames);
        if (parts.empty())
            return faulty(
                unsupported(slice.path, "has " + std::to_string(slice.pixels.parts.size()) +
                                            " fragments of " + std::to_string(frames) +
                                            " compressed frames, expected one each or a table of "
                                            "their offsets"));
    }
    const std::uint64_t bits = std::uint64_t(slice.rows) * std::uint64_t(slice.columns) *
                               std::uint64_t(slice.pixels.bits_allocated);
    const std::uint64_t start = slice.pixels.parts.front().start;
    DicomSlice common = slice;
    common.lacks_geometry = lacks_geometry || slice.lacks_geometry;
    common.pixels.parts.clear();
    std::vector<DicomSlice> slices;
    for (std::size_t n = 0; n < frames; ++n) {
        DicomSlice& frame = slices.emplace_back(common);
        frame.frame = frames > 1 ? int(n) + 1 : 0;
        if (Status status =
                place_frame(tags, n, offsets ? &*offsets : nullptr, may_lack_geometry, frame);
            !status)
            return faulty(status.error());
        if (!parts.empty())
            frame.pixels.parts = std::move(parts[n]);
        else
            take_part(frame.pixels, start, n * bits, bits);
    }
    return slices;
}

}  // namespace

double DicomSlice::padding_value() const {
    constexpr double kLowestHu = -1024;
    const bool is_hu = modality == "CT" && (rescale_type.empty() || rescale_type == "HU") &&
                       (intercept != 0 || pixels.is_signed || pixels.is_float());
    return is_hu ? kLowestHu : 0;
}

Result<bool> looks_like_dicom(const fs::path& path) {
    const auto start = start_of(path);
    if (!start) return start.error();
    return *start != Start::Other;
}

Result<DicomSegmentation> read_dicom_segmentation(const fs::path& path) {
    const auto start = start_of(path);
    if (!start) return start.error();
    DicomWalk tags(path);
    const bool whole = tags.walk(*start == Start::Preamble);
    if (Status status = tags.status(); !status) return status.error();
    if (tags.fault()) return *tags.fault();
    if (!whole || !tags.has_pixels())
        return unreadable(path, "is damaged or ends early, expected a whole DICOM file");
    if (!find_transfer_syntax(tags.syntax_uid()))
        return unsupported(path, "is " + describe_transfer_syntax(tags.syntax_uid()));
    DicomSegmentation found;
    found.is_label_map = tags.text(kSopClass) == kLabelMap;
    const std::string type = tags.text(kSegmentationType);
    if (!found.is_label_map && type != "BINARY")
        return unsupported(path, "is a segmentation object of type " + shown(type) +
                                     ", expected BINARY or a label map");
    DicomSlice slice;
    slice.path = path;
    slice.is_segmentation = true;
    slice.rows = tags.number(kRows, 0);
    slice.columns = tags.number(kColumns, 0);
    if (slice.rows < 1 || slice.columns < 1) return unreadable(path, "has no size in pixels");
    const std::size_t frames = frame_count(tags).value_or(0);
    if (frames == 0 || tags.frame_values().size() != frames)
        return unsupported(path, "has functional groups of " +
                                     std::to_string(tags.frame_values().size()) +
                                     " frames, expected " + std::to_string(frames));
    if (Status status = take_pixels(tags, slice); !status) return status.error();
    const bool is_bits = slice.pixels.bits_allocated == 1;
    if (is_bits == found.is_label_map || (is_bits && slice.pixels.compressed()))
        return unsupported(path, "stores " + std::to_string(slice.pixels.bits_allocated) +
                                     " bits a pixel, expected 1 without compression, or 8 or 16 in "
                                     "a label map");
    found.frames = slices_of_frames(tags, slice, false);
    if (found.frames.front().fault) return *found.frames.front().fault;
    for (const DicomValues& values : tags.segment_values()) {
        const auto number = tags.short_of(values, kSegmentNumber);
        if (number) found.segments.push_back({*number, shown(trimmed(values.text(kSegmentLabel)))});
    }
    if (found.is_label_map) return found;
    for (std::size_t n = 0; n < frames; ++n) {
        DicomValues values = tags.frame_values()[n];
        values.add_missing(tags.shared_values());
        const auto segment = tags.short_of(values, kReferencedSegment);
        if (!segment || *segment < 1)
            return unreadable(path, "has no Referenced Segment Number of frame " +
                                        std::to_string(n + 1) + ", expected one");
        found.frame_segments.push_back(*segment);
    }
    return found;
}

Result<std::vector<DicomSlice>> read_dicom_slices(const fs::path& path, bool may_lack_geometry) {
    const std::vector<DicomSlice> none;
    const auto start = start_of(path);
    if (!start) return start.error();
    if (*start == Start::Other) return none;
    DicomWalk tags(path);
    const bool whole = tags.walk(*start == Start::Preamble);
    if (Status status = tags.status(); !status) return status.error();
    if (*start == Start::Plain && !tags.has_pixels()) return none;
    const bool readable = has_plain_elements(tags.syntax_uid());
    if (whole && readable && !tags.has_pixels() && !ought_to_have_pixels(tags)) return none;
    DicomSlice slice;
    slice.path = path;
    slice.series_uid = tags.text(kSeriesUid);
    take_identity(tags, slice);
    slice.series_number = shown(trimmed(tags.text(kSeriesNumber)));
    slice.description = printable(trimmed(tags.text(kSeriesDescription)), kMaxDescriptionBytes);
    slice.modality = shown(trimmed(tags.text(kModality)));
    slice.rescale_type = shown(trimmed(tags.text(kRescaleType)));
    slice.rows = tags.number(kRows, 0);
    slice.columns = tags.number(kColumns, 0);
    slice.has_modality_lut = tags.has(kModalityLut);
    slice.is_segmentation = is_segmentation(tags);
    slice.is_parametric_map = tags.text(kSopClass) == "1.2.840.10008.5.1.4.1.1.30";
    if (whole && readable && tags.has_pixels() && (slice.rows < 1 || slice.columns < 1))
        return none;
    // The walk has passed the UID's position if it reached the pixels.
    if (slice.series_uid.empty() && whole && readable) slice.series_uid = kNoSeriesUid;
    slice.fault = fault_of(tags, slice, whole, may_lack_geometry);
    const bool has_frames = !tags.frame_values().empty() || frame_count(tags).value_or(1) > 1;
    if (!slice.fault && has_frames) return slices_of_frames(tags, slice, may_lack_geometry);
    return std::vector{std::move(slice)};
}

}  // namespace pliant
