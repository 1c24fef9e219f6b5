// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// VTK's XML format for unstructured grids: a header in XML that says which arrays there are, then
// all numbers in base64. Each array is preceded by its length in bytes (64 bits) and encoded by
// itself; the offsets in the header count characters behind the underscore.

#include <pliant/mesh.h>
#include <pliant/staged_files.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <fstream>

namespace pliant {
namespace {

enum VtkCell : std::uint8_t { kVtkTriangle = 5, kVtkTetrahedron = 10, kVtkHexahedron = 12 };

void append_base64(std::string& text, std::span<const std::byte> bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t n = 0; n < bytes.size(); n += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - n);
        std::uint32_t word = 0;
        for (std::size_t b = 0; b < 3; ++b)
            word = word << 8 | (b < count ? std::to_integer<std::uint32_t>(bytes[n + b]) : 0u);
        for (std::size_t d = 0; d < 4; ++d)
            text += d <= count ? kDigits[word >> (18 - 6 * d) & 63] : '=';
    }
}

/// Names come from callers: what XML means otherwise is written in its own way.
std::string escaped(const std::string& name) {
    std::string text;
    for (const char c : name)
        text += c == '&'   ? "&amp;"
                : c == '<' ? "&lt;"
                : c == '>' ? "&gt;"
                : c == '"' ? "&quot;"
                           : std::string(1, c);
    return text;
}

/// The two halves of the file, growing together.
class Document {
  public:
    void add(const std::string& line) { m_header += line + "\n"; }
    template <class T>
    void add_array(const char* type, const std::string& name, int components,
                   std::span<const T> values) {
        add("<DataArray type=\"" + std::string(type) + "\" Name=\"" + escaped(name) +
            "\" NumberOfComponents=\"" + std::to_string(components) +
            "\" format=\"appended\" offset=\"" + std::to_string(m_data.size()) + "\"/>");
        const auto bytes = std::as_bytes(values);
        const std::uint64_t length = bytes.size();
        std::vector<std::byte> block(sizeof length + bytes.size());
        std::copy_n(reinterpret_cast<const std::byte*>(&length), sizeof length, block.begin());
        std::copy(bytes.begin(), bytes.end(), block.begin() + sizeof length);
        append_base64(m_data, block);
    }
    Status write(const std::filesystem::path& target) const {
        StagedFiles staged;
        const auto path = staged.stage(target);
        if (!path) return path.error();
        std::ofstream file(*path, std::ios::binary);
        file << m_header << "<AppendedData encoding=\"base64\">\n_" << m_data
             << "\n</AppendedData>\n</VTKFile>\n";
        file.close();
        if (!file) return Error{ErrorCode::Unwritable, target.string() + ": can't be written"};
        return staged.commit();
    }

  private:
    std::string m_header, m_data;
};

Status check_length(const std::filesystem::path& path, const std::string& name, std::size_t found,
                    std::size_t expected, const char* of) {
    if (found == expected) return Ok{};
    return Error{ErrorCode::InvalidArgument, path.string() + ": field '" + name + "' has " +
                                                 std::to_string(found) + " values, expected " +
                                                 std::to_string(expected) + ", one for each " + of};
}

template <class Mesh>
Status check_input(const std::filesystem::path& path, const Mesh& mesh, const VtuFields& fields) {
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        for (const std::int32_t node : mesh.cells[c])
            if (node < 0 || std::size_t(node) >= mesh.nodes_mm.size())
                return Error{ErrorCode::InvalidArgument,
                             path.string() + ": cell " + std::to_string(c) + " names node " +
                                 std::to_string(node) + ", expected one of " +
                                 std::to_string(mesh.nodes_mm.size())};
    for (const auto& field : fields.node_vectors)
        if (const Status s =
                check_length(path, field.name, field.values.size(), mesh.nodes_mm.size(), "node");
            !s)
            return s;
    for (const auto& field : fields.cell_numbers)
        if (const Status s =
                check_length(path, field.name, field.values.size(), mesh.cells.size(), "cell");
            !s)
            return s;
    return Ok{};
}

template <class Mesh>
Status write(const std::filesystem::path& path, const Mesh& mesh, const VtuFields& fields,
             VtkCell type) {
    if (const Status input = check_input(path, mesh, fields); !input) return input;
    Document document;
    const char* order = std::endian::native == std::endian::big ? "BigEndian" : "LittleEndian";
    document.add("<?xml version=\"1.0\"?>");
    document.add("<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"" +
                 std::string(order) + "\" header_type=\"UInt64\">");
    document.add("<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
                 std::to_string(mesh.nodes_mm.size()) + "\" NumberOfCells=\"" +
                 std::to_string(mesh.cells.size()) + "\">");
    const auto vectors = [&](const std::string& name, std::span<const Vec3d> values) {
        static_assert(sizeof(Vec3d) == 3 * sizeof(double));
        document.add_array("Float64", name, 3, values);
    };
    document.add("<Points>");
    vectors("Points", mesh.nodes_mm);
    document.add("</Points>\n<Cells>");
    using Cell = typename decltype(mesh.cells)::value_type;
    document.add_array("Int32", "connectivity", 1, std::span<const Cell>(mesh.cells));
    std::vector<std::int64_t> ends(mesh.cells.size());
    for (std::size_t c = 0; c < ends.size(); ++c)
        ends[c] = std::int64_t((c + 1) * std::tuple_size_v<Cell>);
    document.add_array("Int64", "offsets", 1, std::span<const std::int64_t>(ends));
    const std::vector<std::uint8_t> types(mesh.cells.size(), type);
    document.add_array("UInt8", "types", 1, std::span<const std::uint8_t>(types));
    document.add("</Cells>\n<PointData>");
    for (const auto& field : fields.node_vectors) vectors(field.name, field.values);
    document.add("</PointData>\n<CellData>");
    for (const auto& field : fields.cell_numbers)
        document.add_array("Float64", field.name, 1, field.values);
    document.add("</CellData>\n</Piece>\n</UnstructuredGrid>");
    return document.write(path);
}

}  // namespace

Status write_vtu(const std::filesystem::path& path, const HexMesh& mesh, const VtuFields& fields) {
    return write(path, mesh, fields, kVtkHexahedron);
}
Status write_vtu(const std::filesystem::path& path, const TetMesh& mesh, const VtuFields& fields) {
    return write(path, mesh, fields, kVtkTetrahedron);
}
Status write_vtu(const std::filesystem::path& path, const TriangleMesh& mesh,
                 const VtuFields& fields) {
    return write(path, mesh, fields, kVtkTriangle);
}

}  // namespace pliant
