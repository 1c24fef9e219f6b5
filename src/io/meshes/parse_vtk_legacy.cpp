// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// VTK's legacy files of polygons and unstructured grids, text or binary (big-endian). Cells are
// lists with a leading length, or from version 5 on separate offsets and connectivity.

#include <algorithm>
#include <limits>

#include "meshes/file_numbers.h"

namespace pliant::mesh {
namespace {

std::string upper(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c >= 'a' && c <= 'z') c = char(c - 'a' + 'A');
    return result;
}

class Legacy {
  public:
    explicit Legacy(std::string_view file) : m_text(file) {}
    Result<MeshData> read();

  private:
    template <class To>
    Result<std::vector<To>> numbers(std::uint64_t count, std::string_view type_name);
    Result<std::uint64_t> count(const char* what);
    Status read_cells(const std::string& keyword);
    Status read_types();
    Status read_field(const std::string& keyword);
    Status read_attribute(const std::string& name, std::uint64_t components, std::string_view type,
                          std::uint64_t tuples);
    Status section(const std::string& keyword);
    Status close_cells();

    TextCursor m_text;
    bool m_binary = false, m_grid = false, m_offsets = false;
    bool m_at_points = false;
    std::uint64_t m_attribute_count = 0;
    MeshData m_mesh;
    /// A cell's range in the list of nodes.
    struct Cell {
        std::uint32_t begin, count;
    };
    /// Unstructured grids: the cells wait for their types.
    std::vector<std::int64_t> m_nodes;
    std::vector<Cell> m_cells;
};

template <class To>
Result<std::vector<To>> Legacy::numbers(std::uint64_t count, std::string_view type_name) {
    const auto type = number_type(type_name);
    if (!type) return unsupported("numbers of type '" + std::string(type_name) + "'");
    if (!m_binary) {
        auto values = numbers_in<To>(m_text, count);
        if (!values)
            return unreadable("expected " + std::to_string(count) + " numbers, found fewer");
        return std::move(*values);
    }
    if (count > m_text.rest().size()) return unreadable("the file ends within numbers");
    const auto bytes = m_text.bytes(std::size_t(count) * size_of(*type));
    if (!bytes) return unreadable("the file ends within numbers");
    // In binary files vtkIdType has 32 bits, and vtktypeint64 has 64.
    return numbers_of<To>(*bytes, *type, true);
}

Result<std::uint64_t> Legacy::count(const char* what) {
    const auto value = m_text.number<std::int64_t>();
    if (!value || *value < 0 || *value > std::int64_t(1) << 40)
        return unreadable(std::string("expected a number of ") + what);
    return std::uint64_t(*value);
}

Status Legacy::read_cells(const std::string& keyword) {
    const int type = keyword == "CELLS"      ? -1
                     : keyword == "LINES"    ? 4
                     : keyword == "POLYGONS" ? 7
                     : keyword == "VERTICES" ? 2
                                             : 6;
    const auto first = count("cells"), second = count("numbers");
    if (!first) return first.error();
    if (!second) return second.error();
    m_text.line();
    std::vector<Cell> cells;
    std::vector<std::int64_t> nodes;
    if (m_offsets) {
        TextCursor ahead = m_text;
        if (upper(ahead.word()) != "OFFSETS") return unreadable("expected OFFSETS");
        const std::string offset_type(ahead.word());
        ahead.line();
        m_text = ahead;
        const auto ends = numbers<std::int64_t>(*first, offset_type);
        if (!ends) return ends.error();
        if (upper(m_text.word()) != "CONNECTIVITY") return unreadable("expected CONNECTIVITY");
        const std::string node_type(m_text.word());
        m_text.line();
        auto read = numbers<std::int64_t>(*second, node_type);
        if (!read) return read.error();
        nodes = std::move(*read);
        for (std::size_t c = 0; c + 1 < ends->size(); ++c) {
            const std::int64_t begin = (*ends)[c], end = (*ends)[c + 1];
            if (begin < 0 || end < begin || end > std::int64_t(nodes.size()))
                return unreadable("cell " + std::to_string(c) + " has a wrong offset");
            cells.push_back({std::uint32_t(begin), std::uint32_t(end - begin)});
        }
    } else {
        auto list = numbers<std::int64_t>(*second, "int");
        if (!list) return list.error();
        nodes = std::move(*list);
        std::size_t at = 0;
        for (std::uint64_t c = 0; c < *first; ++c) {
            const std::int64_t length = at < nodes.size() ? nodes[at++] : -1;
            if (length < 0 || length > std::int64_t(nodes.size() - at))
                return unreadable("cell " + std::to_string(c) +
                                  " is longer than the list of cells");
            cells.push_back({std::uint32_t(at), std::uint32_t(length)});
            at += std::size_t(length);
        }
    }
    if (nodes.size() > std::numeric_limits<std::uint32_t>::max())
        return unsupported("more than 4294967295 numbers in cells");
    if (type < 0) {
        m_nodes = std::move(nodes);
        m_cells = std::move(cells);
        return Ok{};
    }
    for (const Cell& cell : cells)
        if (const Status s =
                add_cell(m_mesh, type, std::span(nodes).subspan(cell.begin, cell.count));
            !s)
            return s;
    return Ok{};
}

Status Legacy::read_types() {
    const auto cells = count("cell types");
    if (!cells) return cells.error();
    m_text.line();
    const auto types = numbers<std::int64_t>(*cells, "int");
    if (!types) return types.error();
    if (types->size() != m_cells.size())
        return unreadable(std::to_string(types->size()) + " types for " +
                          std::to_string(m_cells.size()) + " cells");
    for (std::size_t c = 0; c < m_cells.size(); ++c)
        if (const Status s =
                add_cell(m_mesh, int(std::clamp<std::int64_t>((*types)[c], -1, 255)),
                         std::span(m_nodes).subspan(m_cells[c].begin, m_cells[c].count));
            !s)
            return s;
    return Ok{};
}

Status Legacy::read_attribute(const std::string& name, std::uint64_t components,
                              std::string_view type, std::uint64_t tuples) {
    if (type == "string" || type == "bit" || type == "variant")
        return unsupported("field '" + name + "' of type '" + std::string(type) + "'");
    if (components < 1 || components > 64)
        return unreadable("field '" + name + "' has " + std::to_string(components) +
                          " components, expected 1 to 64");
    if (tuples > std::uint64_t(1) << 40) return unreadable("field '" + name + "' is too long");
    auto values = numbers<double>(components * tuples, type);
    if (!values) return values.error();
    if (m_at_points && tuples == m_mesh.nodes_mm.size())
        m_mesh.node_fields.push_back({name, std::size_t(components), std::move(*values)});
    return Ok{};
}

Status Legacy::read_field(const std::string& keyword) {
    const std::string name(m_text.word());
    if (keyword == "FIELD") {
        const auto arrays = count("arrays");
        if (!arrays) return arrays.error();
        for (std::uint64_t a = 0; a < *arrays; ++a) {
            std::string array(m_text.word());
            if (array == "METADATA") {
                while (!m_text.rest().empty() && !m_text.line().empty()) {
                }
                array = m_text.word();
            }
            const auto components = count("components"), tuples = count("tuples");
            if (!components) return components.error();
            if (!tuples) return tuples.error();
            const std::string type(m_text.word());
            m_text.line();
            if (const Status s = read_attribute(array, *components, type, *tuples); !s) return s;
        }
        return Ok{};
    }
    const std::string type(m_text.word());
    std::uint64_t components = keyword == "SCALARS"               ? 1
                               : keyword == "TEXTURE_COORDINATES" ? 0
                               : keyword == "TENSORS"             ? 9
                                                                  : 3;
    if (keyword == "SCALARS") {
        TextCursor line(m_text.line());
        if (const auto given = line.number<int>(); given && *given > 0)
            components = std::uint64_t(*given);
        TextCursor ahead = m_text;
        if (upper(ahead.word()) == "LOOKUP_TABLE") {
            ahead.line();
            m_text = ahead;
        }
    } else {
        m_text.line();
    }
    return read_attribute(name, components, type, m_attribute_count);
}

Status Legacy::section(const std::string& keyword) {
    if (keyword == "POINTS") {
        const auto points = count("points");
        if (!points) return points.error();
        const std::string type(m_text.word());
        m_text.line();
        const auto positions = numbers<double>(3 * *points, type);
        if (!positions) return positions.error();
        return set_nodes(m_mesh, *positions);
    }
    if (keyword == "CELLS" || keyword == "LINES" || keyword == "POLYGONS" ||
        keyword == "VERTICES" || keyword == "TRIANGLE_STRIPS")
        return read_cells(keyword);
    if (keyword == "CELL_TYPES") return read_types();
    if (keyword == "POINT_DATA" || keyword == "CELL_DATA") {
        m_at_points = keyword == "POINT_DATA";
        const auto values = count("values");
        if (!values) return values.error();
        m_attribute_count = *values;
        m_text.line();
        return Ok{};
    }
    if (keyword == "FIELD" || keyword == "SCALARS" || keyword == "VECTORS" ||
        keyword == "NORMALS" || keyword == "TENSORS")
        return read_field(keyword);
    if (keyword == "METADATA") {
        m_text.line();
        while (!m_text.rest().empty() && !m_text.line().empty()) {
        }
        return Ok{};
    }
    return unsupported("the section '" + keyword.substr(0, 40) + "'");
}

Result<MeshData> Legacy::read() {
    const std::string_view version = m_text.line();
    const auto dot = version.find("Version ");
    m_offsets = dot != version.npos && version.size() > dot + 8 && version[dot + 8] >= '5';
    const std::string_view title = m_text.line();
    const std::string kind = upper(m_text.word());
    if (kind != "ASCII" && kind != "BINARY") return unreadable("expected ASCII or BINARY");
    m_binary = kind == "BINARY";
    if (upper(m_text.word()) != "DATASET") return unreadable("expected DATASET");
    const std::string set = upper(m_text.word());
    if (set != "POLYDATA" && set != "UNSTRUCTURED_GRID")
        return unsupported("DATASET " + set.substr(0, 40) +
                           ", expected POLYDATA or UNSTRUCTURED_GRID");
    m_grid = set == "UNSTRUCTURED_GRID";
    while (!m_text.at_end()) {
        const std::string keyword = upper(m_text.word());
        const Status s = section(keyword);
        // Sections after the cells are fields, which are optional.
        if (!s && s.error().code == ErrorCode::Unsupported && m_attribute_count > 0) break;
        if (!s) return s.error();
    }
    if (title.find("SPACE=RAS") != title.npos)
        for (Vec3d& p : m_mesh.nodes_mm) p = {-p.x, -p.y, p.z};
    return std::move(m_mesh);
}

}  // namespace

Result<MeshData> parse_vtk_legacy(std::string_view file) {
    return Legacy(file).read();
}

}  // namespace pliant::mesh
