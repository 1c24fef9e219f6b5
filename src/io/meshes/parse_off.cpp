// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// OFF (text), and Medit's .mesh files of version 1 and 2 (text), as Mmg, TetGen and CGAL write
// them.

#include <algorithm>

#include "meshes/file_numbers.h"

namespace pliant::mesh {
namespace {

/// Takes the next line with words, without its comment.
std::string_view line_with_words(TextCursor& text) {
    while (!text.rest().empty()) {
        const std::string_view line = text.line();
        const std::string_view words = line.substr(0, line.find('#'));
        if (!TextCursor(words).at_end()) return words;
    }
    return {};
}

/// Elements of a .mesh file that are read: VTK's number and the number of nodes.
constexpr struct {
    std::string_view name;
    int vtk;
    std::size_t nodes;
} kElements[] = {
    {"Edges", 3, 2}, {"Triangles", 5, 3}, {"Quadrilaterals", 9, 4}, {"Tetrahedra", 10, 4}};

class Medit {
  public:
    explicit Medit(std::string_view file) : m_text(file) {}
    Result<MeshData> read();

  private:
    /// Takes the next word that isn't part of a comment.
    std::string_view word() {
        std::string_view next = m_text.word();
        while (next.starts_with('#')) {
            m_text.line();
            next = m_text.word();
        }
        return next;
    }
    Status read_vertices();
    Status read_elements(std::string_view name, int vtk, std::size_t nodes);

    TextCursor m_text;
    MeshData m_mesh;
};

Status Medit::read_vertices() {
    const auto count = m_text.number<std::int64_t>();
    if (!count || *count < 0) return unreadable("Vertices without a count");
    std::vector<double> positions;
    for (std::int64_t n = 0; n < *count; ++n)
        for (int a = 0; a < 4; ++a) {
            const auto value = m_text.number<double>();
            if (!value)
                return unreadable("Vertices: vertex " + std::to_string(n + 1) +
                                  " has no three numbers and a reference");
            if (a < 3) positions.push_back(*value);
        }
    return set_nodes(m_mesh, positions);
}

Status Medit::read_elements(std::string_view name, int vtk, std::size_t nodes) {
    const auto count = m_text.number<std::int64_t>();
    if (!count || *count < 0) return unreadable(std::string(name) + " without a count");
    std::vector<std::int64_t> cell;
    for (std::int64_t n = 0; n < *count; ++n) {
        cell.clear();
        for (std::size_t k = 0; k <= nodes; ++k) {
            const auto value = m_text.number<std::int64_t>();
            if (!value)
                return unreadable(std::string(name) + ": element " + std::to_string(n + 1) +
                                  " has no " + std::to_string(nodes) +
                                  " numbers of nodes and a reference");
            if (k < nodes) cell.push_back(*value - 1);
        }
        if (const Status s = add_cell(m_mesh, vtk, cell); !s) return s;
    }
    return Ok{};
}

Result<MeshData> Medit::read() {
    word();  // MeshVersionFormatted
    m_text.number<int>();
    for (std::string_view name = word(); !name.empty() && name != "End"; name = word()) {
        Status s = Ok{};
        const auto element = std::find_if(std::begin(kElements), std::end(kElements),
                                          [&](const auto& e) { return e.name == name; });
        if (name == "Dimension") {
            if (const auto dimension = m_text.number<int>(); dimension != 3)
                s = unsupported("Dimension is " + std::to_string(dimension.value_or(0)) +
                                ", expected 3");
        } else if (name == "Vertices") {
            s = read_vertices();
        } else if (element != std::end(kElements)) {
            s = read_elements(name, element->vtk, element->nodes);
        } else if (name == "Hexahedra" || name == "Prisms" || name == "Pyramids" ||
                   name.ends_with("P2")) {
            s = unsupported(std::string(name) + ", expected lines, polygons or linear tetrahedra");
        } else if (!(name[0] >= 'A' && name[0] <= 'Z')) {
            s = unreadable("found '" + std::string(name.substr(0, 40)) +
                           "', expected a keyword such as Vertices");
        } else {
            // Corners, Ridges, RequiredVertices, Normals, …: numbers up to the next keyword.
            while (!m_text.at_end() && !(m_text.rest()[0] >= 'A' && m_text.rest()[0] <= 'Z'))
                if (m_text.rest()[0] == '#')
                    m_text.line();
                else
                    m_text.word();
        }
        if (!s) return s.error();
    }
    return std::move(m_mesh);
}

}  // namespace

Result<MeshData> parse_off(std::string_view file) {
    TextCursor text(file);
    TextCursor head(line_with_words(text));
    const std::string_view magic = head.word();
    if (magic != "OFF" && magic != "COFF" && magic != "NOFF" && magic != "CNOFF" &&
        magic != "STOFF")
        return unsupported("'" + std::string(magic.substr(0, 20)) +
                           "', expected OFF of three axes");
    if (head.at_end()) head = TextCursor(line_with_words(text));
    if (head.rest().find("BINARY") != std::string_view::npos)
        return unsupported("binary OFF, expected text");
    const auto nodes = head.number<std::int64_t>(), faces = head.number<std::int64_t>();
    if (!nodes || !faces || *nodes < 0 || *faces < 0)
        return unreadable("expected the numbers of vertices and faces behind OFF");
    // An element is a row; normals, colours and the like follow its numbers.
    std::vector<double> positions;
    for (std::int64_t n = 0; n < *nodes; ++n) {
        TextCursor row(line_with_words(text));
        for (int a = 0; a < 3; ++a) {
            const auto value = row.number<double>();
            if (!value)
                return unreadable("vertex " + std::to_string(n) + " of " + std::to_string(*nodes) +
                                  " has no three numbers");
            positions.push_back(*value);
        }
    }
    MeshData mesh;
    if (const Status s = set_nodes(mesh, positions); !s) return s.error();
    std::vector<std::int64_t> cell;
    for (std::int64_t f = 0; f < *faces; ++f) {
        TextCursor row(line_with_words(text));
        const auto count = row.number<std::int64_t>();
        const auto numbers = count && *count >= 0
                                 ? numbers_in<std::int64_t>(row, std::size_t(*count))
                                 : std::nullopt;
        if (!numbers)
            return unreadable("face " + std::to_string(f) + " of " + std::to_string(*faces) +
                              " has no count and as many numbers of vertices");
        const int type = numbers->size() == 2 ? 3 : 7;
        if (numbers->empty()) continue;
        if (const Status s = add_cell(mesh, type, *numbers); !s) return s.error();
    }
    if (!line_with_words(text).empty())
        add_note(mesh, "the file is longer than its elements; the rest was ignored");
    return mesh;
}

Result<MeshData> parse_medit(std::string_view file) {
    return Medit(file).read();
}

}  // namespace pliant::mesh
