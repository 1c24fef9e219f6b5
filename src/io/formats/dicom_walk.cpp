// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_walk.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

using namespace dicom_tags;

constexpr std::uint32_t kUndefinedLength = 0xffffffff;
/// Value representations at multiples of three characters.
constexpr std::string_view kValueTypes =
    "AE AS AT CS DA DS DT FD FL IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI UL UN UR "
    "US UT UV";
constexpr std::string_view kLongLength = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
/// Stored elements and their types.
constexpr std::pair<std::uint32_t, std::string_view> kKept[] = {{kSegmentationType, "CS"},
                                                                {kPadding, ""},
                                                                {kPaddingLimit, ""},
                                                                {kFloatPadding, "FL"},
                                                                {kFloatPaddingLimit, "FL"},
                                                                {kDoublePadding, "FD"},
                                                                {kDoublePaddingLimit, "FD"},
                                                                {kImageType, "CS"},
                                                                {kInstanceUid, "UI"},
                                                                {kInstanceNumber, "IS"},
                                                                {kTemporalPosition, "IS"},
                                                                {kTransferSyntax, "UI"},
                                                                {kSopClass, "UI"},
                                                                {kModality, ""},
                                                                {kSeriesDescription, ""},
                                                                {kSeriesUid, "UI"},
                                                                {kSeriesNumber, ""},
                                                                {kPosition, "DS"},
                                                                {kOrientation, "DS"},
                                                                {kSamples, "US"},
                                                                {kPhotometric, "CS"},
                                                                {kPlanar, "US"},
                                                                {kFrames, "IS"},
                                                                {kRows, "US"},
                                                                {kColumns, "US"},
                                                                {kPixelSpacing, "DS"},
                                                                {kBitsAllocated, "US"},
                                                                {kBitsStored, "US"},
                                                                {kHighBit, "US"},
                                                                {kPixelRepresentation, "US"},
                                                                {kIntercept, "DS"},
                                                                {kSlope, "DS"},
                                                                {kWindowCenter, "DS"},
                                                                {kWindowWidth, "DS"},
                                                                {kRescaleType, ""},
                                                                {kModalityLut, ""},
                                                                {kSliceThickness, "DS"},
                                                                {kSliceSpacing, "DS"},
                                                                {kFramePointer, "AT"},
                                                                {kFrameOffsets, "DS"}};
/// Sequences of functional groups: for all frames and for each; and those of their sequences that
/// are read: Frame Content, Plane Position, Plane Orientation, Pixel Measures, Frame VOI LUT, Pixel
/// Value Transformation, Segment Identification.
constexpr std::uint32_t kSharedGroups = 0x52009229, kFrameGroups = 0x52009230,
                        kExtendedOffsets = 0x7fe00001;
/// Detector Information Sequence of nuclear medicine, which has the position of the first frame.
constexpr std::uint32_t kDetectors = 0x00540022;
constexpr std::uint32_t kSegments = 0x00620002;  ///< Segment Sequence
constexpr std::uint32_t kMacros[] = {0x00209111, 0x00209113, 0x00209116, 0x00289110,
                                     0x00289132, 0x00289145, 0x0062000a};
/// Their stored elements, of types DS, UL and US, and those of a segment.
constexpr std::uint32_t kFrameTags[] = {kPosition,         kOrientation,       kPixelSpacing,
                                        kSliceThickness,   kIntercept,         kSlope,
                                        kWindowCenter,     kWindowWidth,       kTemporalIndex,
                                        kDimensionIndices, kReferencedSegment, kSegmentNumber,
                                        kSegmentLabel};
/// Maximum length of a stored value, also of one with a number for each frame, and maximum nesting
/// of sequences.
constexpr std::uint32_t kMaxValueBytes = 1024, kMaxFrameOffsetBytes = 1 << 20;
constexpr int kMaxDepth = 32;
/// Maximum number of a codestream's fragments.
constexpr std::size_t kMaxFragments = std::size_t(1) << 20;

bool is_frame_vector(std::uint32_t tag) {
    return tag == kSliceVector || std::find(std::begin(kVolumeVectors), std::end(kVolumeVectors),
                                            tag) != std::end(kVolumeVectors);
}

/// The type as a static string; empty for an unknown one.
std::string_view known_type(const char* bytes) {
    const std::string_view type(bytes, 2);
    const std::size_t at = kValueTypes.find(type);
    return at == kValueTypes.npos || at % 3 ? std::string_view() : kValueTypes.substr(at, 2);
}

}  // namespace

bool DicomWalk::walk(bool preamble) {
    m_file.seek(preamble ? 132 : 0);
    if (preamble && !walk_meta()) return false;
    if (!take_syntax()) return false;
    if (!has_plain_elements(m_syntax_uid)) return true;  // refused by name later
    while (m_file.at() < m_file.size() && !m_has_pixels) {
        Element element;
        if (!read_element(element)) return false;
        const bool is_pixels = element.tag == kPixelData || element.tag == kFloatPixelData ||
                               element.tag == kDoublePixelData;
        const bool sound = is_pixels ? take_pixels(element) : take_value(element);
        if (!sound) return false;
    }
    return true;
}

const std::string* DicomValues::find(std::uint32_t tag) const {
    const auto found = m_values.find(tag);
    return found == m_values.end() ? nullptr : &found->second;
}

std::string DicomValues::text(std::uint32_t tag) const {
    const std::string* const found = find(tag);
    if (!found) return {};
    std::string value = *found;
    while (!value.empty() && (value.back() == '\0' || value.back() == ' ')) value.pop_back();
    return value;
}

int DicomWalk::number(std::uint32_t tag, int otherwise) const {
    const std::string* const found = m_values.find(tag);
    if (!found || found->size() < 2) return otherwise;
    return int(u16(found->data()));
}

std::string DicomWalk::bytes_of_number(std::uint32_t tag) const {
    const std::string* const found = m_values.find(tag);
    if (!found || (found->size() != 2 && found->size() != 4 && found->size() != 8)) return {};
    return m_big ? std::string(found->rbegin(), found->rend()) : *found;
}

std::vector<std::uint32_t> DicomWalk::longs(const DicomValues& values, std::uint32_t tag) const {
    const std::string* const found = values.find(tag);
    std::vector<std::uint32_t> numbers;
    if (found && found->size() % 4 == 0)
        for (std::size_t at = 0; at < found->size(); at += 4) numbers.push_back(u32(&(*found)[at]));
    return numbers;
}

std::optional<int> DicomWalk::short_of(const DicomValues& values, std::uint32_t tag) const {
    const std::string* const found = values.find(tag);
    if (!found || found->size() < 2) return std::nullopt;
    return int(u16(found->data()));
}

std::vector<std::uint32_t> DicomWalk::shorts(std::uint32_t tag) const {
    const std::string* const found = m_values.find(tag);
    std::vector<std::uint32_t> numbers;
    if (found && found->size() % 2 == 0)
        for (std::size_t at = 0; at < found->size(); at += 2) numbers.push_back(u16(&(*found)[at]));
    return numbers;
}

std::vector<std::uint32_t> DicomWalk::tags_at(std::uint32_t tag) const {
    const std::string* const found = m_values.find(tag);
    std::vector<std::uint32_t> tags;
    if (found && found->size() % 4 == 0)
        for (std::size_t at = 0; at < found->size(); at += 4)
            tags.push_back(u16(&(*found)[at]) << 16 | u16(&(*found)[at + 2]));
    return tags;
}

std::vector<double> DicomValues::decimals(std::uint32_t tag, std::size_t count) const {
    auto numbers = numbers_from(text(tag), '\\');
    if (!numbers || numbers->size() != count) return {};
    return std::move(*numbers);
}

bool DicomWalk::read(char* out, std::size_t count) {
    if (count > m_file.size() - std::min(m_file.at(), m_file.size())) return false;
    return m_file.read(out, count) == count;
}

bool DicomWalk::skip(std::uint64_t count) {
    if (count > m_file.size() - std::min(m_file.at(), m_file.size())) return false;
    m_file.seek(m_file.at() + count);
    return true;
}

std::uint32_t DicomWalk::u16(const char* bytes) const {
    const auto low = std::uint8_t(bytes[m_big ? 1 : 0]), high = std::uint8_t(bytes[m_big ? 0 : 1]);
    return std::uint32_t(low | high << 8);
}

std::uint32_t DicomWalk::u32(const char* bytes) const {
    return u16(bytes + (m_big ? 2 : 0)) | u16(bytes + (m_big ? 0 : 2)) << 16;
}

/// Reads group 2, which is always explicit little endian and names the syntax of the rest.
bool DicomWalk::walk_meta() {
    for (;;) {
        const std::uint64_t start = m_file.at();
        std::array<char, 2> group{};
        if (!read(group.data(), 2)) return false;
        m_file.seek(start);
        if (u16(group.data()) != 2) return true;
        Element element;
        if (!read_element(element) || !take_value(element)) return false;
    }
}

/// Sets the syntax. If it isn't named, the first element shows whether types are explicit.
/// @returns false if deflated elements can't be inflated
bool DicomWalk::take_syntax() {
    m_syntax_uid = text(kTransferSyntax);
    if (m_syntax_uid.empty()) {
        guess_explicit();
        m_syntax_uid = m_explicit ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2";
    } else if (const TransferSyntax* known = find_transfer_syntax(m_syntax_uid)) {
        m_explicit = known->explicit_types;
        m_big = known->big_endian;
        if (!known->deflated) return true;
        m_deflated_from = m_file.at();
        if (const Status status = m_file.inflate_from(m_deflated_from); !status) {
            m_fault = status.error();
            return false;
        }
    }
    return true;
}

void DicomWalk::guess_explicit() {
    const std::uint64_t start = m_file.at();
    std::array<char, 6> bytes{};
    if (!read(bytes.data(), bytes.size())) return;
    m_explicit = !known_type(&bytes[4]).empty();
    m_file.seek(start);
}

bool DicomWalk::read_element(Element& element) {
    std::array<char, 8> bytes{};
    if (!read(bytes.data(), bytes.size())) return false;
    element.tag = u16(&bytes[0]) << 16 | u16(&bytes[2]);
    const bool delimiter = element.tag >> 16 == 0xfffe;
    if (!m_explicit || delimiter) {
        element.length = u32(&bytes[4]);
    } else {
        element.type = known_type(&bytes[4]);
        if (element.type.empty()) return false;
        if (kLongLength.find(element.type) != std::string_view::npos) {
            if (!read(bytes.data(), 4)) return false;
            element.length = u32(&bytes[0]);
        } else {
            element.length = u16(&bytes[6]);
        }
    }
    element.nests = element.length == kUndefinedLength;
    return true;
}

/// Visits the elements of an item, or the items of a sequence, of known or unknown length.
/// @param visit  reads or skips an element's value; false: the file is damaged
template <class Visit>
bool DicomWalk::each_element(const Element& outer, const Visit& visit) {
    const std::uint32_t delimiter = outer.tag == kItem ? kItemEnd : kSequenceEnd;
    if (!outer.nests && outer.length > m_file.size() - std::min(m_file.at(), m_file.size()))
        return false;
    const std::uint64_t end = outer.nests ? m_file.size() : m_file.at() + outer.length;
    while (m_file.at() < end) {
        Element element;
        if (!read_element(element)) return false;
        if (element.tag == delimiter) return outer.nests;
        if (delimiter == kSequenceEnd && element.tag != kItem) return false;
        if (!visit(element)) return false;
    }
    return !outer.nests && m_file.at() == end;
}

bool DicomWalk::take_groups(const Element& sequence, bool for_each_frame) {
    const bool is_explicit = m_explicit;
    if (sequence.type == "UN") m_explicit = false;
    const bool sound = each_element(sequence, [&](const Element& item) {
        if (for_each_frame && m_frames.size() == kMaxDicomFrames) return false;
        DicomValues& values = for_each_frame ? m_frames.emplace_back() : m_shared;
        return each_element(item, [&](const Element& element) {
            const bool is_macro =
                std::find(std::begin(kMacros), std::end(kMacros), element.tag) != std::end(kMacros);
            return is_macro ? take_macro(element, values) : skip_value(element);
        });
    });
    m_explicit = is_explicit;
    return sound;
}

bool DicomWalk::take_macro(const Element& sequence, DicomValues& values) {
    const bool is_explicit = m_explicit;
    if (sequence.type == "UN") m_explicit = false;
    const bool sound = each_element(sequence, [&](const Element& item) {
        return each_element(
            item, [&](const Element& element) { return take_frame_value(element, values); });
    });
    m_explicit = is_explicit;
    return sound;
}

/// Takes position and orientation of the first detector, unless the file has its own.
bool DicomWalk::take_detector(const Element& sequence) {
    const bool is_explicit = m_explicit;
    if (sequence.type == "UN") m_explicit = false;
    DicomValues detector;
    bool is_first = true;
    const bool sound = each_element(sequence, [&](const Element& item) {
        if (!std::exchange(is_first, false)) return skip_value(item);
        return each_element(
            item, [&](const Element& element) { return take_frame_value(element, detector); });
    });
    m_explicit = is_explicit;
    for (const std::uint32_t tag : {kPosition, kOrientation})
        if (detector.has(tag) && !m_values.has(tag)) m_values[tag] = *detector.find(tag);
    return sound;
}

bool DicomWalk::take_segments(const Element& sequence) {
    const bool is_explicit = m_explicit;
    if (sequence.type == "UN") m_explicit = false;
    const bool sound = each_element(sequence, [&](const Element& item) {
        if (m_segments.size() == kMaxDicomFrames) return false;
        DicomValues& values = m_segments.emplace_back();
        return each_element(
            item, [&](const Element& element) { return take_frame_value(element, values); });
    });
    m_explicit = is_explicit;
    return sound;
}

bool DicomWalk::take_frame_value(const Element& element, DicomValues& values) {
    const bool is_kept = std::find(std::begin(kFrameTags), std::end(kFrameTags), element.tag) !=
                         std::end(kFrameTags);
    if (!is_kept || element.nests || element.length > kMaxValueBytes) return skip_value(element);
    if (element.length == 0) return true;  // as absent
    std::string& value = values[element.tag];
    value.resize(element.length);
    return read(value.data(), value.size());
}

bool DicomWalk::take_value(const Element& element) {
    if (element.tag == kSharedGroups) return take_groups(element, false);
    if (element.tag == kFrameGroups) return take_groups(element, true);
    if (element.tag == kExtendedOffsets) return take_offsets(element);
    if (element.tag == kDetectors) return take_detector(element);
    if (element.tag == kSegments) return take_segments(element);
    const auto kept = std::find_if(std::begin(kKept), std::end(kKept),
                                   [&](const auto& k) { return k.first == element.tag; });
    if (kept == std::end(kKept) && !is_frame_vector(element.tag))
        return element.nests ? skip_nested(element) : skip(element.length);
    const std::string_view type = kept == std::end(kKept) ? std::string_view() : kept->second;
    if (element.length == 0) return true;  // as absent
    // Writers that don't know the type of an implicit file's element make it UN.
    const bool is_known = !element.type.empty() && element.type != "UN";
    if (is_known && !type.empty() && element.type != type) return false;
    if (type == "US" && element.length != 2) return false;
    std::string& value = m_values[element.tag];
    if (element.nests) return skip_nested(element);
    const bool is_long = element.tag == kFrameOffsets || is_frame_vector(element.tag);
    if (element.length > (is_long ? kMaxFrameOffsetBytes : kMaxValueBytes))
        return skip(element.length);
    value.resize(element.length);
    return read(value.data(), value.size());
}

/// Skips nested items. Items of an unknown type are implicit in every file.
bool DicomWalk::skip_nested(const Element& element) {
    const bool is_explicit = m_explicit;
    if (element.type == "UN") m_explicit = false;
    const bool sound = skip_items(element, 0);
    m_explicit = is_explicit;
    return sound;
}

/// Skips items up to the delimiter of the element.
bool DicomWalk::skip_items(const Element& outer, int depth) {
    if (depth > kMaxDepth) return false;
    const std::uint32_t end = outer.tag == kItem ? kItemEnd : kSequenceEnd;
    for (;;) {
        Element element;
        if (!read_element(element)) return false;
        if (element.tag == end) return true;
        if (element.nests ? !skip_items(element, depth + 1) : !skip(element.length)) return false;
    }
}

bool DicomWalk::take_pixels(const Element& element) {
    m_has_pixels = true;
    m_pixel_type = element.type;
    m_pixel_numbers = element.tag == kFloatPixelData    ? PixelNumbers::Float32
                      : element.tag == kDoublePixelData ? PixelNumbers::Float64
                                                        : PixelNumbers::Integer;
    m_in_fragments = element.nests;
    if (m_in_fragments) return take_fragments();
    m_pixel_parts = {{m_file.at(), element.length}};
    return skip(element.length);
}

std::size_t DicomWalk::swapped_bytes() const {
    if (!m_big || m_pixel_type == "OB") return 0;
    return m_pixel_numbers == PixelNumbers::Integer   ? 2
           : m_pixel_numbers == PixelNumbers::Float32 ? 4
                                                      : 8;
}

bool DicomWalk::take_fragments() {
    for (bool table_of_offsets = true;; table_of_offsets = false) {
        Element item;
        if (!read_element(item)) return false;
        if (item.tag == kSequenceEnd) return true;
        if (item.tag != kItem || item.nests) return false;
        if (table_of_offsets) {
            m_first_item = m_file.at() + item.length;
            if (m_offsets.empty() ? !take_offsets(item) : !skip(item.length)) return false;
            continue;
        }
        if (m_pixel_parts.size() == kMaxFragments) return false;
        if (item.length) m_pixel_parts.push_back({m_file.at(), item.length});
        if (!skip(item.length)) return false;
    }
}

/// Reads the offsets of frames: 32-bit numbers in the first item of the pixels, 64-bit ones in the
/// extended table. A table of more than the largest number of frames is skipped.
bool DicomWalk::take_offsets(const Element& element) {
    const std::size_t size = element.tag == kExtendedOffsets ? 8 : 4;
    if (element.nests) return skip_nested(element);
    if (element.length % size || element.length / size > kMaxDicomFrames)
        return skip(element.length);
    std::string bytes(element.length, '\0');
    if (!read(bytes.data(), bytes.size())) return false;
    m_offsets.clear();
    for (std::size_t at = 0; at < bytes.size(); at += size) {
        std::uint64_t offset = u32(&bytes[at]);
        if (size == 8) offset |= std::uint64_t(u32(&bytes[at + 4])) << 32;
        m_offsets.push_back(offset);
    }
    return true;
}

std::vector<std::vector<FilePart>> DicomWalk::parts_of_frames(std::size_t frames) const {
    constexpr std::uint64_t kItemHeader = 8;
    std::vector<std::vector<FilePart>> parts(frames);
    if (m_pixel_parts.size() == frames) {
        for (std::size_t n = 0; n < frames; ++n) parts[n] = {m_pixel_parts[n]};
        return parts;
    }
    if (m_offsets.size() != frames || !std::is_sorted(m_offsets.begin(), m_offsets.end()))
        return {};
    for (const FilePart& part : m_pixel_parts) {
        const std::uint64_t offset = part.start - kItemHeader - m_first_item;
        const auto next = std::upper_bound(m_offsets.begin(), m_offsets.end(), offset);
        if (next == m_offsets.begin()) return {};
        parts[std::size_t(next - m_offsets.begin()) - 1].push_back(part);
    }
    for (const auto& some : parts)
        if (some.empty()) return {};
    return parts;
}

}  // namespace pliant
