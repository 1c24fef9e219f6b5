// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Choice of the reader, and checks common to all.

#include <pliant/core/files.h>
#include <pliant/core/text.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>

#include "base/input_file.h"
#include "meshes/file_numbers.h"

namespace pliant {
namespace mesh {

std::optional<NumberType> number_type(std::string_view name) {
    using enum NumberType;
    struct Name {
        std::string_view name;
        NumberType type;
    };
    constexpr Name kNames[] = {{"int8", Int8},
                               {"char", Int8},
                               {"signed_char", Int8},
                               {"uint8", UInt8},
                               {"uchar", UInt8},
                               {"unsigned_char", UInt8},
                               {"int16", Int16},
                               {"short", Int16},
                               {"uint16", UInt16},
                               {"ushort", UInt16},
                               {"unsigned_short", UInt16},
                               {"int32", Int32},
                               {"int", Int32},
                               {"uint32", UInt32},
                               {"uint", UInt32},
                               {"unsigned_int", UInt32},
                               {"int64", Int64},
                               {"long", Int64},
                               {"vtktypeint64", Int64},
                               {"vtkidtype", Int32},
                               {"uint64", UInt64},
                               {"unsigned_long", UInt64},
                               {"vtktypeuint64", UInt64},
                               {"float32", Float32},
                               {"float", Float32},
                               {"float64", Float64},
                               {"double", Float64}};
    std::string lower(name);
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    for (const Name& n : kNames)
        if (n.name == lower) return n.type;
    return std::nullopt;
}

Status set_nodes(MeshData& mesh, std::span<const double> coordinates) {
    if (coordinates.size() / 3 > std::size_t(1) << 31)
        return Error{ErrorCode::LimitExceeded, "more than 2147483648 nodes"};
    const std::size_t first = mesh.nodes_mm.size();
    ask_for(coordinates.size() * sizeof(double));
    mesh.nodes_mm.resize(first + coordinates.size() / 3);
    for (std::size_t n = first; n < mesh.nodes_mm.size(); ++n) {
        const double* at = coordinates.data() + 3 * (n - first);
        mesh.nodes_mm[n] = {at[0], at[1], at[2]};
        if (!is_finite(mesh.nodes_mm[n]))
            return unreadable("node " + std::to_string(n) + " has a position that is not finite");
    }
    return Ok{};
}

Status add_cell(MeshData& mesh, int type, std::span<const std::int64_t> nodes) {
    for (const std::int64_t n : nodes)
        if (n < 0 || n >= std::int64_t(mesh.nodes_mm.size()))
            return unreadable("a cell names node " + std::to_string(n) + ", expected 0…" +
                              std::to_string(std::int64_t(mesh.nodes_mm.size()) - 1));
    const auto at = [&](std::size_t n) { return std::int32_t(nodes[n]); };
    const auto count_is = [&](std::size_t expected) -> Status {
        if (nodes.size() == expected) return Ok{};
        return unreadable("a cell of type " + std::to_string(type) + " has " +
                          std::to_string(nodes.size()) + " nodes, expected " +
                          std::to_string(expected));
    };
    switch (type) {
        case 1:
        case 2:
            return Ok{};
        case 3:
        case 4:
            if (nodes.size() >= 2) mesh.lines.emplace_back(nodes.begin(), nodes.end());
            return Ok{};
        case 6:
            for (std::size_t n = 0; n + 2 < nodes.size(); ++n)
                mesh.triangles.push_back({at(n + n % 2), at(n + 1 - n % 2), at(n + 2)});
            return Ok{};
        case 5:
        case 7:
        case 9:
            if (type != 7)
                if (const Status s = count_is(type == 5 ? 3 : 4); !s) return s;
            return add_polygon(mesh, nodes);
        case 8:
            if (const Status s = count_is(4); !s) return s;
            mesh.triangles.push_back({at(0), at(1), at(3)});
            mesh.triangles.push_back({at(0), at(3), at(2)});
            return Ok{};
        case 10:
            if (const Status s = count_is(4); !s) return s;
            mesh.tetrahedra.push_back({at(0), at(1), at(2), at(3)});
            return Ok{};
    }
    // Those of second order have their corners first.
    constexpr int kSecondOrder[][4] = {
        {21, 3, 3, 2}, {22, 5, 6, 3}, {23, 9, 8, 4}, {24, 10, 10, 4}, {28, 9, 9, 4}};
    for (const auto& [second, first, all, corners] : kSecondOrder) {
        if (second != type) continue;
        if (const Status s = count_is(std::size_t(all)); !s) return s;
        add_note(mesh, kSecondOrderNote);
        return add_cell(mesh, first, nodes.first(std::size_t(corners)));
    }
    return unsupported("a cell of VTK's type " + std::to_string(type) +
                       ", expected lines, polygons or tetrahedra");
}

Status CellList::add_to(MeshData& mesh, int type) const {
    for (std::size_t at = 0; at < m_numbers.size();) {
        const auto count = std::size_t(m_numbers[at]);
        const auto cell = std::span(m_numbers).subspan(at + 1, count);
        if (const Status s = add_cell(mesh, type, cell); !s) return s;
        at += 1 + count;
    }
    return Ok{};
}

Result<MeshData> parse_mesh(std::string_view file, std::string_view ending) {
    const auto starts = [&](std::string_view with) { return file.starts_with(with); };
    TextCursor text(file);
    if (starts("# vtk DataFile")) return parse_vtk_legacy(file);
    if (starts("$MeshFormat") || starts("$Comments") || starts("$NOD")) return parse_msh(file);
    if (starts("ply\n") || starts("ply\r")) return parse_ply(file);
    const std::string_view first = text.word();
    if (first.starts_with("<?xml") || first.starts_with("<VTKFile") || first.starts_with("<!--"))
        return parse_vtk_xml(file);
    if (first.ends_with("OFF") && first.size() <= 5) return parse_off(file);
    if (first == "MeshVersionFormatted") return parse_medit(file);
    if (ending == ".obj") return parse_obj(file);
    if (ending == ".stl" || first == "solid" || first == "SOLID") return parse_stl(file);
    return unreadable("expected VTP, VTU, VTK, MSH, STL, OBJ, PLY, OFF or MESH (Medit)");
}

}  // namespace mesh

namespace {

/// A mesh of a smaller extent is probably in metres [mm].
constexpr double kSmallMesh = 1;

/// Turns tetrahedra in mirrored order, and remarks on lengths.
void put_right(MeshData& mesh) {
    const auto count = mesh.tetrahedra.size();
    if (const auto turned = turn_mirrored(mesh.nodes_mm, mesh.tetrahedra); turned > 0)
        mesh::add_note(mesh, std::to_string(turned) + " of " + std::to_string(count) +
                                 " tetrahedra have their corners in mirrored order; these were "
                                 "turned");
    if (mesh.nodes_mm.empty()) return;
    Vec3d low = mesh.nodes_mm[0], high = low;
    for (const Vec3d& p : mesh.nodes_mm)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const double extent = norm(high - low);
    if (extent > 0 && extent < kSmallMesh)
        mesh::add_note(mesh,
                       "the mesh is " + short_text(extent, 3) +
                           " mm across: lengths are in millimetres, and --units m converts metres");
}

/// A distant node would enlarge all lattices and trees around the mesh.
Status check_distances(const MeshData& mesh) {
    for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n) {
        const Vec3d p = mesh.nodes_mm[n];
        if (dot(p, p) <= kMaxNodeDistanceMm * kMaxNodeDistanceMm) continue;
        return Error{ErrorCode::LimitExceeded, "node " + std::to_string(n) + " is " +
                                                   short_text(std::hypot(p.x, p.y, p.z)) +
                                                   " mm from the origin, expected up to " +
                                                   std::to_string(std::lround(kMaxNodeDistanceMm)) +
                                                   "; lengths are in millimetres"};
    }
    return Ok{};
}

}  // namespace

double mm_of_unit(std::string_view unit) {
    return unit == "m" ? 1000 : unit == "cm" ? 10 : 1;
}

Result<MeshData> read_mesh(const std::filesystem::path& path, double unit_mm) {
    const auto too_large = [&] {
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory to read it"};
    };
    try {
        const auto type = type_of(path);
        if (!type) return type.error();
        if (*type != std::filesystem::file_type::regular)
            return Error{ErrorCode::NotFound, path.string() + ": expected a file, found none"};
        const auto bytes = InputFile(path).read_rest();
        if (!bytes) return bytes.error();
        std::string ending = path.extension().string();
        for (char& c : ending)
            if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
        auto mesh = mesh::parse_mesh(*bytes, ending);
        if (!mesh)
            return Error{mesh.error().code, path.string() + ": " + one_line(mesh.error().message)};
        if (unit_mm != 1)
            for (Vec3d& p : mesh->nodes_mm) p = unit_mm * p;
        if (Status status = check_distances(*mesh); !status)
            return Error{status.error().code, path.string() + ": " + status.error().message};
        put_right(*mesh);
        return mesh;
    } catch (const std::bad_alloc&) {
        return too_large();
    } catch (const std::length_error&) {
        return too_large();
    }
}

Result<TriangleMesh> read_surface(const std::filesystem::path& path, double unit_mm) {
    auto mesh = read_mesh(path, unit_mm);
    if (!mesh) return mesh.error();
    if (!mesh->triangles.empty())
        return cleaned({std::move(mesh->nodes_mm), std::move(mesh->triangles)});
    if (!mesh->tetrahedra.empty())
        return boundary_triangles(TetMesh{std::move(mesh->nodes_mm), std::move(mesh->tetrahedra)});
    return Error{ErrorCode::Unsupported,
                 path.string() + ": found no triangles, expected a surface"};
}

Result<TetMesh> read_tetrahedra(const std::filesystem::path& path, double unit_mm) {
    auto mesh = read_mesh(path, unit_mm);
    if (!mesh) return mesh.error();
    if (mesh->tetrahedra.empty())
        return Error{ErrorCode::Unsupported, path.string() + ": found no tetrahedra"};
    return with_used_nodes({std::move(mesh->nodes_mm), std::move(mesh->tetrahedra)});
}

}  // namespace pliant
