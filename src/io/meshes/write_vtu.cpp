// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// VTK's XML format for unstructured grids.

#include <pliant/mesh.h>
#include <pliant/mesh_files.h>

#include "meshes/vtk_document.h"

namespace pliant {
namespace {

enum VtkCell : std::uint8_t { kVtkTriangle = 5, kVtkTetrahedron = 10, kVtkHexahedron = 12 };

using mesh::check_length;

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
    mesh::VtkDocument document("UnstructuredGrid");
    document.add("<Piece NumberOfPoints=\"" + std::to_string(mesh.nodes_mm.size()) +
                 "\" NumberOfCells=\"" + std::to_string(mesh.cells.size()) + "\">");
    document.add("<Points>");
    document.add_vectors("Points", mesh.nodes_mm);
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
    for (const auto& field : fields.node_vectors) document.add_vectors(field.name, field.values);
    document.add("</PointData>\n<CellData>");
    for (const auto& field : fields.cell_numbers)
        document.add_array("Float64", field.name, 1, field.values);
    document.add("</CellData>\n</Piece>");
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
