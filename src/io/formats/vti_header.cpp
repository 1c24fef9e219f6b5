// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// VTK's XML images [VTK2010]. Tags are read one by one, and text between them is skipped, so that
// inline data of any length take no memory. One piece with values at points is supported; VTK's
// world is taken as LPS, as write_vti writes it.

#include "base/errors.h"
#include "base/input_file.h"
#include "base/text.h"
#include "formats/image_header.h"

#include <algorithm>
#include <bit>
#include <map>
#include <optional>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxTagBytes = 1 << 16;
constexpr int kMaxTags = 1 << 14;

/// A tag's name, with its '/' if it ends an element, and its attributes.
struct XmlTag {
    std::string name;
    std::map<std::string, std::string, std::less<>> attributes;
    std::uint64_t end = 0;  ///< offset of the text behind it

    std::string_view value(std::string_view attribute) const {
        const auto found = attributes.find(attribute);
        return found == attributes.end() ? std::string_view() : found->second;
    }
};

class XmlTags {
  public:
    explicit XmlTags(const fs::path& path) : m_path(path), m_file(path) {}

    /// Skips text, and returns the next tag; nullopt at the end. Comments and declarations are left
    /// out.
    Result<std::optional<XmlTag>> next();
    /// Skips blanks and an underscore.
    Status take_underscore();
    std::uint64_t at() const { return m_at; }

  private:
    int take() {
        ++m_at;
        return m_file.get();
    }
    Error damaged() const {
        return m_file.fault("has a damaged XML tag before byte " + std::to_string(m_at));
    }
    static bool parse_tag(std::string_view text, XmlTag& tag);

    const fs::path& m_path;
    InputFile m_file;
    std::uint64_t m_at = 0;
    int m_count = 0;
};

constexpr int kEndOfFile = InputFile::kEnd;

Result<std::optional<XmlTag>> XmlTags::next() {
    for (;;) {
        int c = take();
        while (c != '<' && c != kEndOfFile) c = take();
        if (c == kEndOfFile) {
            if (Status status = m_file.status(); !status) return status.error();
            return std::optional<XmlTag>();
        }
        if (++m_count > kMaxTags)
            return unreadable(m_path, "has more than " + std::to_string(kMaxTags) + " XML tags");
        std::string text;
        char quote = 0;
        for (c = take(); c != kEndOfFile; c = take()) {
            const bool comment = text.starts_with("!--");
            if (!comment && (c == '"' || c == '\'') && (quote == 0 || quote == c))
                quote = quote ? 0 : char(c);
            if (c == '>' && !quote && (!comment || text.ends_with("--"))) break;
            text += char(c);
            if (text.size() > kMaxTagBytes) return damaged();
        }
        if (c == kEndOfFile) return damaged();
        if (text.starts_with('!') || text.starts_with('?')) continue;
        XmlTag tag;
        if (!parse_tag(text, tag)) return damaged();
        tag.end = m_at;
        return std::optional(std::move(tag));
    }
}

bool XmlTags::parse_tag(std::string_view text, XmlTag& tag) {
    const auto is_blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    const auto skip = [&] {
        while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    };
    std::size_t name = 0;
    while (name < text.size() && !is_blank(text[name]) && (name == 0 || text[name] != '/')) ++name;
    tag.name = text.substr(0, name);
    text.remove_prefix(name);
    for (skip(); !text.empty() && text != "/"; skip()) {
        const std::size_t equals = text.find('=');
        if (equals == text.npos) return false;
        const std::string key(trimmed(text.substr(0, equals)));
        text.remove_prefix(equals + 1);
        skip();
        if (text.empty() || (text[0] != '"' && text[0] != '\'')) return false;
        const std::size_t end = text.find(text[0], 1);
        if (end == text.npos) return false;
        tag.attributes[key] = text.substr(1, end - 1);
        text.remove_prefix(end + 1);
    }
    return true;
}

Status XmlTags::take_underscore() {
    int c = take();
    while (c == ' ' || (c >= '\t' && c <= '\r')) c = take();
    return c == '_' ? Status(Ok{}) : m_file.fault("its appended data don't start with '_'");
}

/// An array of values at points.
struct PointArray {
    std::string name, type, format;
    std::int64_t components = 1;
    std::uint64_t offset = 0;  ///< in the appended data
    std::uint64_t start = 0;   ///< of inline data in the file
};

struct VtiFile {
    XmlTag file, image;
    std::string active;  ///< name of the active array
    std::vector<PointArray> arrays;
    int pieces = 0;
    bool has_cell_arrays = false, appended_base64 = false;
    std::string piece_extent;
    std::uint64_t appended = 0;  ///< offset behind the underscore; 0: no appended data
};

Error bad_attribute(const fs::path& path, const char* name, std::string_view found,
                    const std::string& expected) {
    return unreadable(path, std::string(name) + " is '" + shown(found) + "', expected " + expected);
}

Status take_array(const fs::path& path, const XmlTag& tag, VtiFile& vti) {
    PointArray array;
    array.name = tag.value("Name");
    array.type = tag.value("type");
    array.format = tag.value("format");
    array.start = tag.end;
    if (const auto text = tag.value("NumberOfComponents"); !text.empty()) {
        const auto number = whole_number_from(text);
        if (!number || *number < 1)
            return bad_attribute(path, "NumberOfComponents", text, "a number ≥ 1");
        array.components = *number;
    }
    if (array.format == "appended") {
        const auto number = whole_number_from(tag.value("offset"));
        if (!number || *number < 0)
            return bad_attribute(path, "offset", tag.value("offset"), "a number ≥ 0");
        array.offset = std::uint64_t(*number);
    }
    vti.arrays.push_back(std::move(array));
    return Ok{};
}

Result<VtiFile> read_tags(const fs::path& path) {
    XmlTags tags(path);
    VtiFile vti;
    bool in_points = false, in_cells = false;
    for (;;) {
        auto next = tags.next();
        if (!next) return next.error();
        if (!*next) break;
        const XmlTag& tag = **next;
        if (tag.name == "VTKFile") {
            vti.file = tag;
            if (tag.value("type") != "ImageData")
                return unsupported(path, "is a VTKFile of type '" + shown(tag.value("type")) +
                                             "', expected ImageData");
        } else if (tag.name == "ImageData") {
            vti.image = tag;
        } else if (tag.name == "Piece") {
            ++vti.pieces;
            vti.piece_extent = tag.value("Extent");
        } else if (tag.name == "PointData") {
            in_points = true;
            if (vti.pieces < 2) vti.active = tag.value("Scalars");
        } else if (tag.name == "CellData") {
            in_cells = true;
        } else if (tag.name == "/PointData" || tag.name == "/CellData") {
            in_points = in_cells = false;
        } else if (tag.name == "DataArray" && in_points && vti.pieces < 2) {
            if (Status status = take_array(path, tag, vti); !status) return status.error();
        } else if (tag.name == "DataArray" && in_cells) {
            vti.has_cell_arrays = true;
        } else if (tag.name == "AppendedData") {
            vti.appended_base64 = tag.value("encoding") != "raw";
            if (Status status = tags.take_underscore(); !status) return status.error();
            vti.appended = tags.at();
            break;  // they may hold any bytes
        }
    }
    if (vti.image.name.empty()) return unreadable(path, "has no ImageData, expected one");
    if (vti.pieces != 1)
        return unsupported(path, "has " + std::to_string(vti.pieces) + " pieces, expected one");
    if (vti.arrays.empty())
        return unsupported(path, vti.has_cell_arrays
                                     ? "has values of cells, expected values of points"
                                     : "has no values, expected an array of PointData");
    return vti;
}

Status place_vti(const fs::path& path, const XmlTag& image, ImageHeader& header) {
    const auto three = [&](const char* name, std::size_t count) {
        auto numbers = numbers_from(image.value(name));
        if (numbers && numbers->size() != count) numbers.reset();
        return numbers;
    };
    const auto extent = three("WholeExtent", 6), spacing = three("Spacing", 3),
               origin = three("Origin", 3), direction = three("Direction", 9);
    if (!extent)
        return bad_attribute(path, "WholeExtent", image.value("WholeExtent"), "six whole numbers");
    Grid& grid = header.grid;
    Vec3d first{};
    for (std::size_t a = 0; a < 3; ++a) {
        const double low = (*extent)[2 * a], high = (*extent)[2 * a + 1];
        if (low != std::trunc(low) || high != std::trunc(high) || !(std::abs(low) < 1e9) ||
            !(std::abs(high) < 1e9))
            return bad_attribute(path, "WholeExtent", image.value("WholeExtent"),
                                 "six whole numbers");
        header.sizes.push_back(std::int64_t(high - low) + 1);
        first[int(a)] = low;
    }
    if (!spacing && !image.value("Spacing").empty())
        return bad_attribute(path, "Spacing", image.value("Spacing"), "three numbers");
    if (!origin && !image.value("Origin").empty())
        return bad_attribute(path, "Origin", image.value("Origin"), "three numbers");
    if (!direction && !image.value("Direction").empty())
        return bad_attribute(path, "Direction", image.value("Direction"), "nine numbers");
    if (spacing) grid.spacing_mm = {(*spacing)[0], (*spacing)[1], (*spacing)[2]};
    if (origin) grid.origin_mm = {(*origin)[0], (*origin)[1], (*origin)[2]};
    for (int a = 0; a < 3; ++a)
        if (Status status = check_spacing(path, a, grid.spacing_mm[a]); !status) return status;
    for (std::size_t a = 0; a < 3 && direction; ++a)
        for (std::size_t row = 0; row < 3; ++row)
            grid.direction.columns[a][int(row)] = (*direction)[3 * row + a];
    if (!direction) header.notes.push_back("no Direction; the axes are taken as L, P, S");
    // The origin is the position of index 0, which the extent need not contain.
    if (!(first == Vec3d{})) grid.origin_mm = world_from_voxel(grid, first);
    return check_origin(path, grid.origin_mm);
}

/// The active array, or the first one.
const PointArray& chosen_array(const VtiFile& vti, std::vector<std::string>& notes) {
    const auto active = std::find_if(vti.arrays.begin(), vti.arrays.end(),
                                     [&](const PointArray& a) { return a.name == vti.active; });
    const PointArray& chosen = active == vti.arrays.end() ? vti.arrays.front() : *active;
    if (vti.arrays.size() > 1)
        notes.push_back("the array '" + shown(chosen.name) + "' is read, " +
                        std::to_string(vti.arrays.size() - 1) + " more left out");
    return chosen;
}

Status take_type(const fs::path& path, const PointArray& array, ImageHeader& header) {
    static const std::map<std::string, Component, std::less<>> kTypes = {
        {"Int8", Component::Int8},       {"UInt8", Component::UInt8},
        {"Int16", Component::Int16},     {"UInt16", Component::UInt16},
        {"Int32", Component::Int32},     {"UInt32", Component::UInt32},
        {"Int64", Component::Int64},     {"UInt64", Component::UInt64},
        {"Float32", Component::Float32}, {"Float64", Component::Float64}};
    const auto found = kTypes.find(array.type);
    if (found == kTypes.end())
        return bad_attribute(path, "type", array.type, "Int16, Float32 or the like");
    header.stored = found->second;
    header.components = array.components;
    return Ok{};
}

Status take_encoding(const fs::path& path, const VtiFile& vti, const PointArray& array,
                     DataLocation& data) {
    data.files = {path};
    const std::string_view order = vti.file.value("byte_order"),
                           counts = vti.file.value("header_type"),
                           compressor = vti.file.value("compressor");
    if (order != "LittleEndian" && order != "BigEndian")
        return bad_attribute(path, "byte_order", order, "LittleEndian or BigEndian");
    data.swapped = (order == "BigEndian") != (std::endian::native == std::endian::big);
    if (!counts.empty() && counts != "UInt32" && counts != "UInt64")
        return bad_attribute(path, "header_type", counts, "UInt32 or UInt64");
    data.vtk.wide_counts = counts == "UInt64";
    if (compressor == "vtkZLibDataCompressor")
        data.vtk.codec = VtkArray::Codec::Zlib;
    else if (compressor == "vtkLZ4DataCompressor")
        data.vtk.codec = VtkArray::Codec::Lz4;
    else if (!compressor.empty())
        return unsupported(path, "compressor is '" + shown(compressor) +
                                     "', expected vtkZLibDataCompressor or vtkLZ4DataCompressor");
    data.start = array.start;
    if (array.format == "ascii" || array.format.empty()) {
        data.encoding = DataEncoding::Text;
        return Ok{};
    }
    data.encoding = DataEncoding::VtkArray;
    data.vtk.base64 = true;
    if (array.format == "binary") return Ok{};
    if (array.format != "appended")
        return bad_attribute(path, "format", array.format, "ascii, binary or appended");
    if (vti.appended == 0) return unreadable(path, "has no AppendedData, expected them");
    data.vtk.base64 = vti.appended_base64;
    data.start = vti.appended + array.offset;
    if (data.start < vti.appended)
        return bad_attribute(path, "offset", std::to_string(array.offset), "one in the file");
    return Ok{};
}

/// Raw appended numbers without compression are in memory's layout, behind their length.
Status skip_length(const fs::path& path, ImageHeader& header) {
    DataLocation& data = header.data;
    if (data.encoding != DataEncoding::VtkArray || data.vtk.base64 ||
        data.vtk.codec != VtkArray::Codec::None)
        return Ok{};
    const std::size_t size = data.vtk.wide_counts ? 8 : 4;
    InputFile file(path);
    file.seek(data.start);
    std::array<unsigned char, 8> bytes{};
    if (file.read(bytes.data(), size) != size)
        return file.fault("ends early: an array has no length");
    const bool big = data.swapped != (std::endian::native == std::endian::big);
    std::uint64_t found = 0, expected = size_of(header.stored) * std::uint64_t(header.components);
    for (std::size_t b = 0; b < size; ++b)
        found |= std::uint64_t(bytes[big ? size - 1 - b : b]) << (8 * b);
    for (const std::int64_t n : header.sizes) expected *= std::uint64_t(n);
    if (found != expected)
        return unreadable(path, "has " + std::to_string(found) + " bytes of values, expected " +
                                    std::to_string(expected));
    data.encoding = DataEncoding::Raw;
    data.start += size;
    return Ok{};
}

}  // namespace

Result<ImageHeader> read_vti_header(const fs::path& path) {
    const auto vti = read_tags(path);
    if (!vti) return vti.error();
    ImageHeader header;
    header.format = ImageFormat::Vti;
    if (Status status = place_vti(path, vti->image, header); !status) return status.error();
    if (Status status = check_size(path, header.sizes); !status) return status.error();
    if (numbers_from(vti->piece_extent) != numbers_from(vti->image.value("WholeExtent")))
        return unsupported(path, "has a piece of the extent '" + shown(vti->piece_extent) +
                                     "', expected the whole image");
    const PointArray& array = chosen_array(*vti, header.notes);
    if (Status status = take_type(path, array, header); !status) return status.error();
    if (Status status = take_encoding(path, *vti, array, header.data); !status)
        return status.error();
    if (Status status = skip_length(path, header); !status) return status.error();
    return header;
}

}  // namespace pliant
