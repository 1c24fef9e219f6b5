// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parser of a DICOM file's elements up to the pixels:
//
//   explicit   group(2) element(2) VR(2) length(2)   or   … VR(2) 0(2) length(4)
//   implicit   group(2) element(2) length(4)
//
// A file of several frames has functional groups: a sequence with one item for all frames, and one
// with an item for each. An item has sequences of one item each, such as that of the position.
//
// A length of 0xFFFFFFFF means items up to a delimiter. Compressed pixels have this form: an offset
// table, then the fragments of a codestream. Only the elements of dicom_tags are stored.

#pragma once

#include "formats/dicom_input.h"
#include "formats/dicom_syntax.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

namespace dicom_tags {
inline constexpr std::uint32_t kTransferSyntax = 0x00020010, kImageType = 0x00080008,
                               kSopClass = 0x00080016, kInstanceUid = 0x00080018,
                               kInstanceNumber = 0x00200013, kTemporalPosition = 0x00200100,
                               kModality = 0x00080060, kSeriesDescription = 0x0008103e,
                               kSeriesUid = 0x0020000e, kSeriesNumber = 0x00200011,
                               kPosition = 0x00200032, kOrientation = 0x00200037,
                               kSamples = 0x00280002, kPhotometric = 0x00280004,
                               kPlanar = 0x00280006, kFrames = 0x00280008, kRows = 0x00280010,
                               kColumns = 0x00280011, kPixelSpacing = 0x00280030,
                               kBitsAllocated = 0x00280100, kBitsStored = 0x00280101,
                               kHighBit = 0x00280102, kPixelRepresentation = 0x00280103,
                               kIntercept = 0x00281052, kSlope = 0x00281053,
                               kRescaleType = 0x00281054, kPadding = 0x00280120,
                               kPaddingLimit = 0x00280121, kFloatPadding = 0x00280122,
                               kDoublePadding = 0x00280123, kFloatPaddingLimit = 0x00280124,
                               kDoublePaddingLimit = 0x00280125, kWindowCenter = 0x00281050,
                               kWindowWidth = 0x00281051, kModalityLut = 0x00283000,
                               kSliceThickness = 0x00180050, kSliceSpacing = 0x00180088,
                               kFramePointer = 0x00280009, kSegmentationType = 0x00620001,
                               kSegmentNumber = 0x00620004, kSegmentLabel = 0x00620005,
                               kReferencedSegment = 0x0062000b, kRotationVector = 0x00540050,
                               kSliceVector = 0x00540080, kAngularVector = 0x00540090,
                               kFrameOffsets = 0x3004000c, kTemporalIndex = 0x00209128,
                               kDimensionIndices = 0x00209157, kFloatPixelData = 0x7fe00008,
                               kDoublePixelData = 0x7fe00009, kPixelData = 0x7fe00010,
                               kItem = 0xfffee000, kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd;
}

/// Vectors of nuclear medicine, with a number for each frame, that tell volumes apart: of energy
/// windows, detectors, phases, R-R intervals, time slots, and time slices.
inline constexpr std::uint32_t kVolumeVectors[] = {0x00540010, 0x00540020, 0x00540030,
                                                   0x00540060, 0x00540070, 0x00540100};

/// Maximum number of frames of a file, and of segments.
inline constexpr std::size_t kMaxDicomFrames = std::size_t(1) << 16;

/// Type of the stored pixels.
enum class PixelNumbers { Integer, Float32, Float64 };

/// A range of a file's bytes, after they were inflated.
struct FilePart {
    std::uint64_t start = 0;  ///< [bytes] from the start of the file
    std::uint64_t bytes = 0;
};

/// Values of elements, by tag.
class DicomValues {
  public:
    /// Value without padding; empty if there is none.
    std::string text(std::uint32_t tag) const;
    /// @returns empty unless there are exactly `count` numbers
    std::vector<double> decimals(std::uint32_t tag, std::size_t count) const;
    bool has(std::uint32_t tag) const { return m_values.contains(tag); }
    std::string& operator[](std::uint32_t tag) { return m_values[tag]; }
    /// Stored bytes; null if there are none.
    const std::string* find(std::uint32_t tag) const;
    /// Adds the values that are missing here.
    void add_missing(const DicomValues& others) {
        m_values.insert(others.m_values.begin(), others.m_values.end());
    }

  private:
    std::map<std::uint32_t, std::string> m_values;
};

class DicomWalk {
  public:
    explicit DicomWalk(const std::filesystem::path& path) : m_file(path) {}

    /// @param preamble  the file starts with 128 bytes and DICM
    /// @returns whether the file is complete up to the pixels. Elements are unknown for syntaxes
    ///          without plain ones (has_plain_elements).
    bool walk(bool preamble);
    /// Error of reading, after which the file isn't complete.
    Status status() const { return m_file.status(); }
    /// Reason why deflated elements aren't complete.
    const std::optional<Error>& fault() const { return m_fault; }
    /// Position of the first deflated element; 0: they aren't deflated.
    std::uint64_t deflated_from() const { return m_deflated_from; }

    const DicomValues& values() const { return m_values; }
    std::string text(std::uint32_t tag) const { return m_values.text(tag); }
    int number(std::uint32_t tag, int otherwise) const;
    bool has(std::uint32_t tag) const { return m_values.has(tag); }
    /// Bytes of a number, little endian; empty unless there are 2, 4 or 8.
    std::string bytes_of_number(std::uint32_t tag) const;
    /// 16-bit numbers of an element.
    std::vector<std::uint32_t> shorts(std::uint32_t tag) const;
    /// 32-bit numbers of an element.
    std::vector<std::uint32_t> longs(const DicomValues& values, std::uint32_t tag) const;
    /// Tags that an element names.
    std::vector<std::uint32_t> tags_at(std::uint32_t tag) const;
    /// Values of the functional groups for all frames, and for each frame.
    const DicomValues& shared_values() const { return m_shared; }
    const std::vector<DicomValues>& frame_values() const { return m_frames; }
    /// Number and label of each segment of a segmentation.
    const std::vector<DicomValues>& segment_values() const { return m_segments; }
    /// First 16-bit number of an element. @returns nullopt if there is none
    std::optional<int> short_of(const DicomValues& values, std::uint32_t tag) const;

    const std::string& syntax_uid() const { return m_syntax_uid; }
    bool has_pixels() const { return m_has_pixels; }
    /// Whether the pixels are in fragments, possibly zero of them.
    bool in_fragments() const { return m_in_fragments; }
    /// Range of the uncompressed pixels, or the fragments of a codestream.
    const std::vector<FilePart>& pixel_parts() const { return m_pixel_parts; }
    /// Fragments of each frame: by the table of offsets, or one each.
    /// @returns empty if they can't be told apart
    std::vector<std::vector<FilePart>> parts_of_frames(std::size_t frames) const;
    PixelNumbers pixel_numbers() const { return m_pixel_numbers; }
    /// Size of the pixels' units that are in big-endian order [bytes]; 0: none.
    std::size_t swapped_bytes() const;

  private:
    struct Element {
        std::uint32_t tag = 0;
        std::uint32_t length = 0;
        std::string_view type;  ///< empty for implicit types
        bool nests = false;     ///< undefined length: items follow
    };
    bool read(char* out, std::size_t count);
    bool skip(std::uint64_t count);
    std::uint32_t u16(const char* bytes) const;
    std::uint32_t u32(const char* bytes) const;
    bool walk_meta();
    void guess_explicit();
    bool take_syntax();
    bool read_element(Element& element);
    bool take_value(const Element& element);
    bool skip_nested(const Element& element);
    bool skip_value(const Element& element) {
        return element.nests ? skip_nested(element) : skip(element.length);
    }
    template <class Visit>
    bool each_element(const Element& outer, const Visit& visit);
    bool take_groups(const Element& sequence, bool for_each_frame);
    bool take_macro(const Element& sequence, DicomValues& values);
    bool take_detector(const Element& sequence);
    bool take_segments(const Element& sequence);
    bool take_frame_value(const Element& element, DicomValues& values);
    bool take_offsets(const Element& element);
    bool skip_items(const Element& outer, int depth);
    bool take_pixels(const Element& element);
    bool take_fragments();

    DicomInput m_file;
    std::optional<Error> m_fault;
    bool m_explicit = true, m_big = false, m_has_pixels = false, m_in_fragments = false;
    std::string m_syntax_uid;
    std::string_view m_pixel_type;
    PixelNumbers m_pixel_numbers = PixelNumbers::Integer;
    std::uint64_t m_deflated_from = 0;
    std::vector<FilePart> m_pixel_parts;
    std::vector<std::uint64_t> m_offsets;  ///< of the frames, from the first fragment's item
    std::uint64_t m_first_item = 0;        ///< position of that item
    DicomValues m_values, m_shared;
    std::vector<DicomValues> m_frames, m_segments;
};

}  // namespace pliant
