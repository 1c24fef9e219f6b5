// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// VTK's XML files of polygons and unstructured grids; the only user of pugixml. Appended data after
// an underscore may be raw bytes, which are invalid XML, so the document is truncated there and
// closed manually. An array is text, or bytes (in base64 unless raw): its length, then its numbers;
// if compressed, the number of blocks, the blocks' length, the last block's length, and the
// compressed length of each block.

#include <zlib.h>

#include <algorithm>
#include <pugixml.hpp>

#include "meshes/file_numbers.h"

namespace pliant::mesh {
namespace {

/// Reads bytes from base64 or raw text. Padding within base64 is skipped: some writers encode an
/// array's length separately from its numbers.
class ByteSource {
  public:
    ByteSource(std::string_view text, bool base64) : m_text(text), m_base64(base64) {}

    /// Upper bound of the remaining bytes.
    std::uint64_t left() const {
        return m_base64 ? m_kept.size() + 3 * (m_text.size() / 4 + 1) : m_text.size();
    }
    std::optional<std::string> take(std::uint64_t count) {
        if (count > left()) return std::nullopt;
        std::string bytes;
        bytes.reserve(std::size_t(count));
        if (!m_base64) {
            bytes = m_text.substr(0, std::size_t(count));
            m_text.remove_prefix(std::size_t(count));
            return bytes;
        }
        while (bytes.size() + m_kept.size() < count)
            if (!decode_four())
                return std::nullopt;
            else if (bytes.size() + m_kept.size() <= count) {
                bytes += m_kept;
                m_kept.clear();
            }
        const std::size_t missing = std::size_t(count) - bytes.size();
        bytes += m_kept.substr(0, missing);
        m_kept.erase(0, missing);
        return bytes;
    }

  private:
    bool decode_four() {
        std::uint32_t word = 0;
        int digits = 0, padding = 0;
        while (digits < 4) {
            if (m_text.empty()) return false;
            const char c = m_text[0];
            m_text.remove_prefix(1);
            int value = 0;
            if (c >= 'A' && c <= 'Z')
                value = c - 'A';
            else if (c >= 'a' && c <= 'z')
                value = c - 'a' + 26;
            else if (c >= '0' && c <= '9')
                value = c - '0' + 52;
            else if (c == '+')
                value = 62;
            else if (c == '/')
                value = 63;
            else if (c == '=')
                ++padding;
            else if (c == ' ' || (c >= '\t' && c <= '\r'))
                continue;
            else
                return false;
            if (padding > 0 && c != '=') return false;
            word = word << 6 | std::uint32_t(value);
            ++digits;
        }
        if (padding > 2) return false;
        for (int b = 0; b < 3 - padding; ++b) m_kept += char(word >> (16 - 8 * b) & 255);
        return true;
    }
    std::string_view m_text;
    bool m_base64;
    std::string m_kept;
};

class Document {
  public:
    explicit Document(std::string_view file) : m_file(file) {}
    Result<MeshData> read();

  private:
    Status open();
    Status read_piece(const pugi::xml_node& piece, MeshData& mesh);
    Status read_cells(const pugi::xml_node& group, int type, MeshData& mesh);
    Status read_cell_fields(const pugi::xml_node& group, MeshData& mesh);
    Status read_fields(const pugi::xml_node& group, std::size_t points, std::size_t before,
                       MeshData& mesh);
    bool says_ras();
    template <class To>
    Result<std::vector<To>> array(const pugi::xml_node& node, std::optional<std::uint64_t> count);
    Result<std::string> bytes_of(const pugi::xml_node& node, ByteSource source,
                                 std::optional<std::uint64_t> expected);
    std::optional<std::uint64_t> header_number(ByteSource& source) const;
    static pugi::xml_node array_named(const pugi::xml_node& group, const char* name) {
        return group.find_child_by_attribute("DataArray", "Name", name);
    }

    std::string_view m_file, m_appended;
    bool m_appended_base64 = false, m_compressed = false, m_big_endian = false, m_long = false;
    bool m_grid = false;
    pugi::xml_document m_xml;
    std::uint64_t m_cells = 0;                 ///< of the last group
    std::vector<std::uint32_t> m_cell_of_tet;  ///< likewise
};

Status Document::open() {
    std::string text;
    const auto tag = m_file.find("<AppendedData");
    if (tag != m_file.npos) {
        const auto end = m_file.find('>', tag);
        const auto underscore = m_file.find('_', std::min(end, m_file.size()));
        if (underscore == m_file.npos) return unreadable("appended data without an underscore");
        m_appended = m_file.substr(underscore + 1);
        text = std::string(m_file.substr(0, end + 1)) + "</AppendedData></VTKFile>";
    } else {
        text = m_file;
    }
    // A node or an attribute of the document takes some hundred bytes, even for a short name.
    constexpr std::uint64_t kNodeBytes = 100;
    ask_for(text.size() +
            kNodeBytes * std::uint64_t(std::count_if(text.begin(), text.end(),
                                                     [](char c) { return c == '<' || c == '='; })));
    const auto parsed = m_xml.load_buffer(text.data(), text.size());
    if (!parsed)
        return unreadable("no XML at character " + std::to_string(parsed.offset) + ": " +
                          parsed.description());
    const pugi::xml_node root = m_xml.child("VTKFile");
    const std::string_view type = root.attribute("type").value();
    if (type != "PolyData" && type != "UnstructuredGrid")
        return unsupported("VTKFile of type '" + std::string(type) +
                           "', expected PolyData or UnstructuredGrid");
    m_grid = type == "UnstructuredGrid";
    const std::string_view compressor = root.attribute("compressor").value();
    if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
        return unsupported("compressor '" + std::string(compressor) +
                           "', expected vtkZLibDataCompressor");
    m_compressed = !compressor.empty();
    m_big_endian = std::string_view(root.attribute("byte_order").value()) == "BigEndian";
    m_long = std::string_view(root.attribute("header_type").value()) == "UInt64";
    m_appended_base64 =
        std::string_view(root.child("AppendedData").attribute("encoding").value()) != "raw";
    return Ok{};
}

std::optional<std::uint64_t> Document::header_number(ByteSource& source) const {
    const auto bytes = source.take(m_long ? 8 : 4);
    if (!bytes) return std::nullopt;
    const auto type = m_long ? NumberType::UInt64 : NumberType::UInt32;
    const auto value = numbers_of<std::int64_t>(*bytes, type, m_big_endian)[0];
    if (value < 0) return std::nullopt;
    return std::uint64_t(value);
}

/// Maximum ratio of deflate's compression.
constexpr std::uint64_t kMaxInflated = 1100;
/// Maximum number of numbers in a compressed array: the coordinates of 16,777,216 nodes. Limits the
/// memory that a small file can cause.
constexpr std::uint64_t kMaxInflatedNumbers = 3 * (std::uint64_t(1) << 24);

Result<std::string> Document::bytes_of(const pugi::xml_node& node, ByteSource source,
                                       std::optional<std::uint64_t> expected) {
    const std::string name = std::string("array '") + node.attribute("Name").value() + "'";
    const auto ends = [&] { return unreadable(name + " ends before it should"); };
    const auto check = [&](std::uint64_t found) -> Status {
        if (!expected || found == *expected) return Ok{};
        return unreadable(name + " has " + std::to_string(found) + " bytes, expected " +
                          std::to_string(*expected));
    };
    const auto first = header_number(source);
    if (!first) return ends();
    if (!m_compressed) {
        if (const Status s = check(*first); !s) return s.error();
        auto bytes = source.take(*first);
        if (!bytes) return ends();
        return std::move(*bytes);
    }
    const auto block = header_number(source), last = header_number(source);
    if (!block || !last || *first > source.left() / (m_long ? 8 : 4)) return ends();
    std::vector<std::uint64_t> lengths(std::size_t(*first), 0);
    std::uint64_t total = 0;
    for (std::uint64_t& length : lengths) {
        const auto number = header_number(source);
        if (!number || *number > source.left()) return ends();
        length = *number;
        total += length;
    }
    if (total > source.left()) return ends();
    // All blocks but the last are full; 0 means that the last one is full too.
    const std::uint64_t most = kMaxInflated * (total + 64);
    if ((*first > 1 && *block > most) || *last > *block) return ends();
    const std::uint64_t size =
        lengths.empty() ? 0 : (*first - 1) * *block + (*last > 0 ? *last : *block);
    if (const Status s = check(size); !s) return s.error();
    if (size > most) return ends();
    const auto type = number_type(node.attribute("type").value());
    if (type && size / size_of(*type) > kMaxInflatedNumbers)
        return Error{ErrorCode::LimitExceeded, name + " has " +
                                                   std::to_string(size / size_of(*type)) +
                                                   " compressed numbers, expected up to " +
                                                   std::to_string(kMaxInflatedNumbers)};
    ask_for(size);
    std::string bytes(std::size_t(size), '\0');
    std::uint64_t at = 0;
    for (std::size_t b = 0; b < lengths.size(); ++b) {
        const auto packed = source.take(lengths[b]);
        if (!packed) return ends();
        const std::uint64_t room = std::min(*block, size - at);
        uLongf got = uLongf(room);
        if (uncompress(reinterpret_cast<Bytef*>(bytes.data() + at), &got,
                       reinterpret_cast<const Bytef*>(packed->data()),
                       uLong(packed->size())) != Z_OK ||
            got != room)
            return unreadable(name + " is damaged in block " + std::to_string(b));
        at += room;
    }
    return bytes;
}

template <class To>
Result<std::vector<To>> Document::array(const pugi::xml_node& node,
                                        std::optional<std::uint64_t> count) {
    const std::string name = std::string("array '") + node.attribute("Name").value() + "'";
    const auto type = number_type(node.attribute("type").value());
    if (!node || !type) return unreadable(name + " is missing or has an unknown type");
    const std::string_view format = node.attribute("format").value();
    if (format == "ascii" || format.empty()) {
        TextCursor text(node.child_value());
        std::vector<To> numbers;
        while (!text.at_end()) {
            const auto value = text.number<To>();
            if (!value) return unreadable(name + " holds something that is no number");
            numbers.push_back(*value);
        }
        if (count && numbers.size() != *count)
            return unreadable(name + " has " + std::to_string(numbers.size()) +
                              " numbers, expected " + std::to_string(*count));
        return numbers;
    }
    std::optional<std::uint64_t> expected;
    if (count) expected = *count * size_of(*type);
    std::string_view text = node.child_value();
    bool base64 = true;
    if (format == "appended") {
        const std::uint64_t offset = node.attribute("offset").as_ullong(~0ULL);
        if (offset > m_appended.size()) return unreadable(name + " begins behind the file's end");
        text = m_appended.substr(std::size_t(offset));
        base64 = m_appended_base64;
    } else if (format != "binary") {
        return unsupported(name + " has the format '" + std::string(format) + "'");
    }
    const auto bytes = bytes_of(node, ByteSource(text, base64), expected);
    if (!bytes) return bytes.error();
    return numbers_of<To>(*bytes, *type, m_big_endian);
}

Status Document::read_cells(const pugi::xml_node& group, int type, MeshData& mesh) {
    if (!array_named(group, "connectivity")) return Ok{};
    const auto nodes = array<std::int64_t>(array_named(group, "connectivity"), std::nullopt);
    const auto ends = array<std::int64_t>(array_named(group, "offsets"), std::nullopt);
    if (!nodes) return nodes.error();
    if (!ends) return ends.error();
    std::vector<std::int64_t> types;
    if (type < 0) {
        auto read = array<std::int64_t>(array_named(group, "types"), ends->size());
        if (!read) return read.error();
        types = std::move(*read);
    }
    m_cells = ends->size();
    m_cell_of_tet.clear();
    std::int64_t begin = 0;
    for (std::size_t c = 0; c < ends->size(); ++c) {
        const std::int64_t end = (*ends)[c];
        if (end < begin || end > std::int64_t(nodes->size()))
            return unreadable("cell " + std::to_string(c) + " ends at " + std::to_string(end) +
                              ", expected " + std::to_string(begin) + "…" +
                              std::to_string(nodes->size()));
        const auto cell = std::span(*nodes).subspan(std::size_t(begin), std::size_t(end - begin));
        const std::int64_t kind = type < 0 ? types[c] : type;
        if (const Status s = add_cell(mesh, int(std::clamp<std::int64_t>(kind, -1, 255)), cell); !s)
            return s;
        if (m_cell_of_tet.size() < mesh.tetrahedra.size())
            m_cell_of_tet.push_back(std::uint32_t(c));
        begin = end;
    }
    return Ok{};
}

/// Numbers of the tetrahedra. Arrays of text, and of vectors, are left out.
Status Document::read_cell_fields(const pugi::xml_node& group, MeshData& mesh) {
    if (m_cell_of_tet.empty()) return Ok{};
    for (const pugi::xml_node& node : group.children("DataArray")) {
        if (node.attribute("NumberOfComponents").as_ullong(1) != 1 ||
            !number_type(node.attribute("type").value()))
            continue;
        const auto values = array<double>(node, m_cells);
        if (!values) return values.error();
        MeshData::Field field{node.attribute("Name").value(), 1, {}};
        ask_for(m_cell_of_tet.size() * sizeof(double));
        for (const std::uint32_t cell : m_cell_of_tet) field.values.push_back((*values)[cell]);
        mesh.tetrahedron_fields.push_back(std::move(field));
    }
    return Ok{};
}

Status Document::read_fields(const pugi::xml_node& group, std::size_t points, std::size_t before,
                             MeshData& mesh) {
    for (const pugi::xml_node& node : group.children("DataArray")) {
        const auto components = node.attribute("NumberOfComponents").as_ullong(1);
        if (components < 1 || components > 64) continue;
        auto values = array<double>(node, points * components);
        if (!values) return values.error();
        const std::string name = node.attribute("Name").value();
        if (before == 0)
            mesh.node_fields.push_back({name, std::size_t(components), std::move(*values)});
    }
    return Ok{};
}

Status Document::read_piece(const pugi::xml_node& piece, MeshData& mesh) {
    const std::uint64_t points = piece.attribute("NumberOfPoints").as_ullong(0);
    if (points > std::uint64_t(1) << 31) return unreadable("more than 2147483648 points");
    if (points == 0) return Ok{};
    const auto positions = array<double>(piece.child("Points").child("DataArray"), 3 * points);
    if (!positions) return positions.error();
    MeshData part;
    if (const Status s = set_nodes(part, *positions); !s) return s;
    if (const Status s =
            read_fields(piece.child("PointData"), std::size_t(points), mesh.nodes_mm.size(), part);
        !s)
        return s;
    if (m_grid) {
        if (const Status s = read_cells(piece.child("Cells"), -1, part); !s) return s;
        if (const Status s = read_cell_fields(piece.child("CellData"), part); !s) return s;
    } else {
        constexpr struct {
            const char* name;
            int type;
        } kGroups[] = {{"Lines", 4}, {"Strips", 6}, {"Polys", 7}};
        for (const auto& g : kGroups)
            if (const Status s = read_cells(piece.child(g.name), g.type, part); !s) return s;
    }
    // Concatenates pieces; fields are dropped unless a single piece contains the whole mesh.
    const auto first = std::int32_t(mesh.nodes_mm.size());
    if (first == 0) {
        mesh = std::move(part);
        return Ok{};
    }
    mesh.node_fields.clear();
    mesh.tetrahedron_fields.clear();
    mesh.nodes_mm.insert(mesh.nodes_mm.end(), part.nodes_mm.begin(), part.nodes_mm.end());
    const auto append = [first](auto& cells, auto& more) {
        for (auto& cell : more) {
            for (std::int32_t& n : cell) n += first;
            cells.push_back(std::move(cell));
        }
    };
    append(mesh.tetrahedra, part.tetrahedra);
    append(mesh.triangles, part.triangles);
    append(mesh.lines, part.lines);
    return Ok{};
}

bool Document::says_ras() {
    const pugi::xml_node data = m_xml.child("VTKFile").first_child().child("FieldData");
    const pugi::xml_node space = data.find_child_by_attribute("Array", "Name", "SPACE");
    if (!space) return false;
    // A string is stored as its character codes and a zero.
    const std::string_view format = space.attribute("format").value();
    std::string text;
    if (format == "ascii") {
        TextCursor words(space.child_value());
        for (auto c = words.number<int>(); c; c = words.number<int>()) text += char(*c);
    } else {
        const bool appended = format == "appended";
        const auto offset = space.attribute("offset").as_ullong(~0ULL);
        if (appended && offset > m_appended.size()) return false;
        const ByteSource source(appended ? m_appended.substr(std::size_t(offset))
                                         : std::string_view(space.child_value()),
                                !appended || m_appended_base64);
        if (auto bytes = bytes_of(space, source, std::nullopt)) text = *bytes;
    }
    return text.starts_with("RAS");
}

Result<MeshData> Document::read() {
    if (const Status s = open(); !s) return s.error();
    MeshData mesh;
    const pugi::xml_node data =
        m_xml.child("VTKFile").child(m_grid ? "UnstructuredGrid" : "PolyData");
    for (const pugi::xml_node& piece : data.children("Piece"))
        if (const Status s = read_piece(piece, mesh); !s) return s.error();
    if (says_ras())
        for (Vec3d& p : mesh.nodes_mm) p = {-p.x, -p.y, p.z};
    return mesh;
}

}  // namespace

Result<MeshData> parse_vtk_xml(std::string_view file) {
    return Document(file).read();
}

}  // namespace pliant::mesh
