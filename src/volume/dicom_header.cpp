// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Walks through the elements of a DICOM file, as far as the pixels:
//
//   explicit   group(2) element(2) VR(2) length(2)   or   … VR(2) 0(2) length(4)
//   implicit   group(2) element(2) length(4)
//
// A length of 0xFFFFFFFF means items up to a delimiter. Done here because the GDCM of Linux
// distributions, with which ITK reads the pixels, aborts the process on damaged files and takes
// truncated pixels for whole ones: it only gets to see files that came through this walk.

#include "volume/dicom_series.h"
#include "volume/text.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <map>
#include <utility>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::uint32_t kUndefinedLength = 0xffffffff;
constexpr std::uint32_t kPixelData = 0x7fe00010, kItem = 0xfffee000, kItemEnd = 0xfffee00d,
                        kSequenceEnd = 0xfffee0dd;
constexpr std::uint32_t kTransferSyntax = 0x00020010, kSeriesDescription = 0x0008103e,
                        kSeriesUid = 0x0020000e, kPosition = 0x00200032, kOrientation = 0x00200037,
                        kSamples = 0x00280002, kFrames = 0x00280008, kRows = 0x00280010,
                        kColumns = 0x00280011, kPixelSpacing = 0x00280030,
                        kBitsAllocated = 0x00280100, kBitsStored = 0x00280101,
                        kHighBit = 0x00280102, kPixelRepresentation = 0x00280103,
                        kIntercept = 0x00281052, kSlope = 0x00281053, kSopClass = 0x00080016;
constexpr std::string_view kValueTypes =
    "AE AS AT CS DA DS DT FD FL IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI UL UN UR "
    "US UT UV";
/// Types of the elements that GDCM looks into: it aborts where an element has another one.
constexpr std::pair<std::uint32_t, std::string_view> kTypesOf[] = {
    {0x00020000, "UL"}, {0x00020001, "OB"}, {0x00020002, "UI"}, {0x00020003, "UI"},
    {0x00020010, "UI"}, {0x00080005, "CS"}, {0x00080008, "CS"}, {0x00080016, "UI"},
    {0x00080018, "UI"}, {0x00080060, "CS"}, {0x00180050, "DS"}, {0x00180088, "DS"},
    {0x00181164, "DS"}, {0x0020000e, "UI"}, {0x00200032, "DS"}, {0x00200037, "DS"},
    {0x00280002, "US"}, {0x00280004, "CS"}, {0x00280006, "US"}, {0x00280008, "IS"},
    {0x00280009, "AT"}, {0x00280010, "US"}, {0x00280011, "US"}, {0x00280030, "DS"},
    {0x00280034, "IS"}, {0x00280100, "US"}, {0x00280101, "US"}, {0x00280102, "US"},
    {0x00280103, "US"}, {0x00281050, "DS"}, {0x00281051, "DS"}, {0x00281052, "DS"},
    {0x00281053, "DS"}, {0x00281054, "LO"}, {0x00282110, "CS"}, {0x20500020, "CS"},
    {0x30040002, "CS"}, {0x3004000e, "DS"}};
/// Longest value that is kept, and deepest nesting of sequences that is followed.
constexpr std::uint32_t kMaxValueBytes = 1024;
constexpr int kMaxDepth = 32;

struct Element {
    std::uint32_t tag = 0;
    std::uint32_t length = 0;
    bool nests = false;  ///< of undefined length: items follow
};

class Walker {
  public:
    explicit Walker(const fs::path& path) : m_file(path, std::ios::binary) {
        m_file.seekg(0, std::ios::end);
        m_size = std::uint64_t(std::max<std::streamoff>(0, m_file.tellg()));
    }

    /// @returns whether the file is whole
    bool walk(bool preamble) {
        seek(preamble ? 132 : 0);
        if (preamble && !walk_meta()) return false;
        if (!preamble) guess_explicit();
        if (text(kTransferSyntax) == "1.2.840.10008.1.2.1.99") return true;  // refused by name
        while (m_at < m_size) {
            Element element;
            if (!read_element(element)) return false;
            const bool sound =
                element.tag == kPixelData ? walk_pixels(element) : take_value(element);
            if (!sound) return false;
        }
        return true;
    }

    std::string text(std::uint32_t tag) const {
        const auto found = m_values.find(tag);
        if (found == m_values.end()) return {};
        std::string value = found->second;
        while (!value.empty() && (value.back() == '\0' || value.back() == ' ')) value.pop_back();
        return value;
    }
    int number(std::uint32_t tag, int otherwise) const {
        const auto found = m_values.find(tag);
        if (found == m_values.end() || found->second.size() < 2) return otherwise;
        return int(u16(found->second.data()));
    }
    std::vector<double> decimals(std::uint32_t tag, std::size_t count) const {
        auto numbers = numbers_from(text(tag), '\\');
        if (!numbers || numbers->size() != count) return {};
        return std::move(*numbers);
    }
    bool has(std::uint32_t tag) const { return m_values.contains(tag); }
    bool has_pixels() const { return m_has_pixels; }
    DicomPixels pixels() const {
        DicomPixels pixels = m_pixels;
        pixels.is_signed = number(kPixelRepresentation, 0) != 0;
        pixels.bits_allocated = number(kBitsAllocated, 16);
        pixels.bits_stored = number(kBitsStored, pixels.bits_allocated);
        pixels.high_bit = number(kHighBit, pixels.bits_stored - 1);
        return pixels;
    }

  private:
    void seek(std::uint64_t at) {
        m_at = at;
        m_file.seekg(std::streamoff(at));
    }
    bool read(char* out, std::size_t count) {
        if (count > m_size - std::min(m_at, m_size)) return false;
        m_at += count;
        return bool(m_file.read(out, std::streamsize(count)));
    }
    bool skip(std::uint64_t count) {
        if (count > m_size - std::min(m_at, m_size)) return false;
        m_at += count;
        return bool(m_file.seekg(std::streamoff(count), std::ios::cur));
    }
    std::uint32_t u16(const char* bytes) const {
        const auto low = std::uint8_t(bytes[m_big ? 1 : 0]),
                   high = std::uint8_t(bytes[m_big ? 0 : 1]);
        return std::uint32_t(low | high << 8);
    }
    std::uint32_t u32(const char* bytes) const {
        return u16(bytes + (m_big ? 2 : 0)) | u16(bytes + (m_big ? 0 : 2)) << 16;
    }

    /// Group 2, which is always explicit and little endian, and says how the rest is written.
    bool walk_meta() {
        for (;;) {
            const std::uint64_t start = m_at;
            std::array<char, 2> group{};
            if (!read(group.data(), 2)) return false;
            seek(start);
            if (u16(group.data()) != 2) break;
            Element element;
            if (!read_element(element) || !take_value(element)) return false;
        }
        const std::string syntax = text(kTransferSyntax);
        m_explicit = syntax != "1.2.840.10008.1.2";
        m_big = syntax == "1.2.840.10008.1.2.2";
        return true;
    }
    void guess_explicit() {
        std::array<char, 6> start{};
        if (!read(start.data(), start.size())) return;
        const auto letter = [](char c) { return c >= 'A' && c <= 'Z'; };
        m_explicit = letter(start[4]) && letter(start[5]);
        seek(0);
    }

    bool read_element(Element& element) {
        std::array<char, 8> bytes{};
        if (!read(bytes.data(), bytes.size())) return false;
        element.tag = u16(&bytes[0]) << 16 | u16(&bytes[2]);
        const std::array<char, 2> type{bytes[4], bytes[5]};
        const bool delimiter = element.tag >> 16 == 0xfffe;
        if (!m_explicit || delimiter) {
            element.length = u32(&bytes[4]);
        } else {
            const std::string_view vr(&bytes[4], 2);
            if (vr.find(' ') != vr.npos || kValueTypes.find(vr) == vr.npos) return false;
            constexpr std::string_view kLongLength = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
            if (kLongLength.find(vr) != std::string_view::npos) {
                if (!read(bytes.data(), 4)) return false;
                element.length = u32(&bytes[0]);
            } else {
                element.length = u16(&bytes[6]);
            }
        }
        element.nests = element.length == kUndefinedLength;
        return is_sound(element, std::string_view(type.data(), m_explicit ? 2 : 0));
    }
    /// @param type  empty where the file doesn't say
    static bool is_sound(const Element& element, std::string_view type) {
        const auto known = std::find_if(std::begin(kTypesOf), std::end(kTypesOf),
                                        [&](const auto& t) { return t.first == element.tag; });
        if (known == std::end(kTypesOf)) return true;
        return (type.empty() || type == known->second) &&
               (known->second != "US" || element.length == 2);
    }
    bool take_value(const Element& element) {
        if (element.nests) return skip_items(element, 0);
        if (element.length > kMaxValueBytes) return skip(element.length);
        std::string value(element.length, '\0');
        if (!read(value.data(), value.size())) return false;
        m_values[element.tag] = std::move(value);
        return true;
    }
    /// Goes past the delimiter that ends the element.
    bool skip_items(const Element& outer, int depth) {
        if (depth > kMaxDepth) return false;
        const std::uint32_t end = outer.tag == kItem ? kItemEnd : kSequenceEnd;
        for (;;) {
            Element element;
            if (!read_element(element)) return false;
            if (element.tag == end) return true;
            if (element.nests ? !skip_items(element, depth + 1) : !skip(element.length))
                return false;
        }
    }
    bool walk_pixels(const Element& element) {
        m_has_pixels = true;
        m_pixels.compressed = element.nests;
        if (element.nests) return skip_items(element, 0);
        m_pixels.bytes = element.length;
        return skip(element.length);
    }

    std::ifstream m_file;
    std::uint64_t m_size = 0, m_at = 0;
    bool m_explicit = true, m_big = false, m_has_pixels = false;
    DicomPixels m_pixels;
    std::map<std::uint32_t, std::string> m_values;
};

DicomSlice slice_from(const Walker& tags, const fs::path& path) {
    DicomSlice slice;
    slice.path = path;
    slice.series_uid = tags.text(kSeriesUid);
    slice.description = shown(trimmed(tags.text(kSeriesDescription)));
    slice.rows = tags.number(kRows, 0);
    slice.columns = tags.number(kColumns, 0);
    slice.samples_per_pixel = tags.number(kSamples, 1);
    slice.frames = int(std::clamp<std::int64_t>(whole_number_from(tags.text(kFrames)).value_or(1),
                                                -1, std::int64_t(1) << 30));
    slice.pixels = tags.pixels();
    if (const auto n = tags.decimals(kSlope, 1); !n.empty()) slice.slope = n[0];
    if (const auto n = tags.decimals(kIntercept, 1); !n.empty()) slice.intercept = n[0];
    if (!tags.has(kSlope)) slice.slope = 1;
    if (!tags.has(kIntercept)) slice.intercept = 0;
    if (const auto p = tags.decimals(kPosition, 3); !p.empty())
        slice.position = Vec3d{p[0], p[1], p[2]};
    if (const auto o = tags.decimals(kOrientation, 6); !o.empty()) {
        slice.row = Vec3d{o[0], o[1], o[2]};
        slice.column = Vec3d{o[3], o[4], o[5]};
    }
    // The first number is the distance between rows.
    if (const auto s = tags.decimals(kPixelSpacing, 2); !s.empty())
        slice.spacing_mm = Vec3d{s[1], s[0], 0};
    return slice;
}

/// Whether a file is of a kind that has pixels: CT, MR or PET images, or with a size in pixels.
bool ought_to_have_pixels(const Walker& tags) {
    const std::string kind = tags.text(kSopClass);
    return tags.has(kRows) || kind == "1.2.840.10008.5.1.4.1.1.2" ||
           kind == "1.2.840.10008.5.1.4.1.1.4" || kind == "1.2.840.10008.5.1.4.1.1.128";
}

enum class Start { Other, Preamble, Plain };

Start start_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::array<char, 132> start{};
    file.read(start.data(), std::streamsize(start.size()));
    if (file.gcount() != 132) return Start::Other;
    if (std::memcmp(&start[128], "DICM", 4) == 0) return Start::Preamble;
    // Old files start with an element of group 8, little endian.
    return start[0] == 8 && start[1] == 0 && start[3] == 0 ? Start::Plain : Start::Other;
}

}  // namespace

bool looks_like_dicom(const fs::path& path) {
    return start_of(path) != Start::Other;
}

Result<std::optional<DicomSlice>> read_dicom_slice(const fs::path& path) {
    const Start start = start_of(path);
    std::optional<DicomSlice> nothing;
    if (start == Start::Other) return nothing;
    Walker walker(path);
    const bool whole = walker.walk(start == Start::Preamble);
    if (start == Start::Plain && !walker.has_pixels()) return nothing;
    if (walker.text(kTransferSyntax) == "1.2.840.10008.1.2.1.99")
        return Error{ErrorCode::Unsupported,
                     path.string() + ": is deflated DICOM, expected another transfer syntax"};
    if (!whole || (!walker.has_pixels() && ought_to_have_pixels(walker)))
        return Error{ErrorCode::Unreadable,
                     path.string() + ": is damaged or ends early, expected a whole DICOM file"};
    std::optional<DicomSlice> slice = slice_from(walker, path);
    if (!walker.has_pixels() || slice->rows < 1 || slice->columns < 1) return nothing;
    return slice;
}

}  // namespace pliant
