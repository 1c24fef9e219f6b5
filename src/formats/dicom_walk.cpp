// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_walk.h"

#include "core/text.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::uint32_t kUndefinedLength = 0xffffffff;
constexpr std::uint32_t kPixelData = 0x7fe00010, kItem = 0xfffee000, kItemEnd = 0xfffee00d,
                        kSequenceEnd = 0xfffee0dd;
/// Value representations at multiples of three characters.
constexpr std::string_view kValueTypes =
    "AE AS AT CS DA DS DT FD FL IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI UL UN UR "
    "US UT UV";
constexpr std::string_view kLongLength = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
/// Stored elements and their types.
constexpr std::pair<std::uint32_t, std::string_view> kKept[] = {
    {dicom_tags::kTransferSyntax, "UI"}, {dicom_tags::kSopClass, "UI"},
    {dicom_tags::kModality, ""},         {dicom_tags::kSeriesDescription, ""},
    {dicom_tags::kSeriesUid, "UI"},      {dicom_tags::kPosition, "DS"},
    {dicom_tags::kOrientation, "DS"},    {dicom_tags::kSamples, "US"},
    {dicom_tags::kPhotometric, "CS"},    {dicom_tags::kPlanar, "US"},
    {dicom_tags::kFrames, "IS"},         {dicom_tags::kRows, "US"},
    {dicom_tags::kColumns, "US"},        {dicom_tags::kPixelSpacing, "DS"},
    {dicom_tags::kBitsAllocated, "US"},  {dicom_tags::kBitsStored, "US"},
    {dicom_tags::kHighBit, "US"},        {dicom_tags::kPixelRepresentation, "US"},
    {dicom_tags::kIntercept, "DS"},      {dicom_tags::kSlope, "DS"},
    {dicom_tags::kRescaleType, ""},      {dicom_tags::kModalityLut, ""}};
/// Maximum length of a stored value, and maximum nesting of sequences.
constexpr std::uint32_t kMaxValueBytes = 1024;
constexpr int kMaxDepth = 32;
/// Maximum number of a codestream's fragments.
constexpr std::size_t kMaxFragments = std::size_t(1) << 20;

/// The type as a static string; empty for an unknown one.
std::string_view known_type(const char* bytes) {
    const std::string_view type(bytes, 2);
    const std::size_t at = kValueTypes.find(type);
    return at == kValueTypes.npos || at % 3 ? std::string_view() : kValueTypes.substr(at, 2);
}

}  // namespace

DicomWalk::DicomWalk(const fs::path& path) : m_file(path, std::ios::binary) {
    m_file.seekg(0, std::ios::end);
    m_size = std::uint64_t(std::max<std::streamoff>(0, m_file.tellg()));
}

bool DicomWalk::walk(bool preamble) {
    seek(preamble ? 132 : 0);
    if (preamble && !walk_meta()) return false;
    take_syntax();
    if (!has_plain_elements(m_syntax_uid)) return true;  // refused by name later
    while (m_at < m_size && !m_has_pixels) {
        Element element;
        if (!read_element(element)) return false;
        const bool sound = element.tag == kPixelData ? take_pixels(element) : take_value(element);
        if (!sound) return false;
    }
    return true;
}

std::string DicomWalk::text(std::uint32_t tag) const {
    const auto found = m_values.find(tag);
    if (found == m_values.end()) return {};
    std::string value = found->second;
    while (!value.empty() && (value.back() == '\0' || value.back() == ' ')) value.pop_back();
    return value;
}

int DicomWalk::number(std::uint32_t tag, int otherwise) const {
    const auto found = m_values.find(tag);
    if (found == m_values.end() || found->second.size() < 2) return otherwise;
    return int(u16(found->second.data()));
}

std::vector<double> DicomWalk::decimals(std::uint32_t tag, std::size_t count) const {
    auto numbers = numbers_from(text(tag), '\\');
    if (!numbers || numbers->size() != count) return {};
    return std::move(*numbers);
}

void DicomWalk::seek(std::uint64_t at) {
    m_at = at;
    m_file.seekg(std::streamoff(at));
}

bool DicomWalk::read(char* out, std::size_t count) {
    if (count > m_size - std::min(m_at, m_size)) return false;
    m_at += count;
    return bool(m_file.read(out, std::streamsize(count)));
}

bool DicomWalk::skip(std::uint64_t count) {
    if (count > m_size - std::min(m_at, m_size)) return false;
    m_at += count;
    return bool(m_file.seekg(std::streamoff(count), std::ios::cur));
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
        const std::uint64_t start = m_at;
        std::array<char, 2> group{};
        if (!read(group.data(), 2)) return false;
        seek(start);
        if (u16(group.data()) != 2) return true;
        Element element;
        if (!read_element(element) || !take_value(element)) return false;
    }
}

/// Sets the syntax. If it isn't named, the first element shows whether types are explicit.
void DicomWalk::take_syntax() {
    m_syntax_uid = text(dicom_tags::kTransferSyntax);
    if (m_syntax_uid.empty()) {
        guess_explicit();
        m_syntax_uid = m_explicit ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2";
    } else if (const TransferSyntax* known = find_transfer_syntax(m_syntax_uid)) {
        m_explicit = known->explicit_types;
        m_big = known->big_endian;
    }
}

void DicomWalk::guess_explicit() {
    const std::uint64_t start = m_at;
    std::array<char, 6> bytes{};
    if (!read(bytes.data(), bytes.size())) return;
    m_explicit = !known_type(&bytes[4]).empty();
    seek(start);
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

bool DicomWalk::take_value(const Element& element) {
    const auto kept = std::find_if(std::begin(kKept), std::end(kKept),
                                   [&](const auto& k) { return k.first == element.tag; });
    if (kept == std::end(kKept)) return element.nests ? skip_nested(element) : skip(element.length);
    const std::string_view type = kept->second;
    if (!type.empty() && !element.type.empty() && element.type != type) return false;
    if (type == "US" && element.length != 2) return false;
    std::string& value = m_values[element.tag];
    if (element.nests) return skip_nested(element);
    if (element.length > kMaxValueBytes) return skip(element.length);
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
    m_in_fragments = element.nests;
    if (m_in_fragments) return take_fragments();
    m_pixel_parts = {{m_at, element.length}};
    return skip(element.length);
}

bool DicomWalk::take_fragments() {
    for (bool table_of_offsets = true;; table_of_offsets = false) {
        Element item;
        if (!read_element(item)) return false;
        if (item.tag == kSequenceEnd) return true;
        if (item.tag != kItem || item.nests) return false;
        if (m_pixel_parts.size() == kMaxFragments) return false;
        if (!table_of_offsets && item.length) m_pixel_parts.push_back({m_at, item.length});
        if (!skip(item.length)) return false;
    }
}

}  // namespace pliant
