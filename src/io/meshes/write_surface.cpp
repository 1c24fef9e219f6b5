// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writers of surfaces, curves and series. Each file declares LPS if the format allows: 3D Slicer
// looks for SPACE=LPS.

#include <pliant/core/text.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>

#include <bit>
#include <cstring>

#include "meshes/vtk_document.h"

namespace pliant {
namespace {

template <class T>
void append_little_endian(std::string& bytes, T value) {
    char copy[sizeof value];
    std::memcpy(copy, &value, sizeof value);
    for (std::size_t b = 0; b < sizeof value; ++b)
        bytes += copy[std::endian::native == std::endian::big ? sizeof value - 1 - b : b];
}

Status check(const std::filesystem::path& path, std::size_t nodes, const SurfaceFields& fields) {
    for (const auto& f : fields.node_vectors)
        if (const Status s = mesh::check_length(path, f.name, f.values.size(), nodes, "node"); !s)
            return s;
    for (const auto& f : fields.node_numbers)
        if (const Status s = mesh::check_length(path, f.name, f.values.size(), nodes, "node"); !s)
            return s;
    return Ok{};
}

/// Writes cells of one kind, as connectivity and ends; "Polys" or "Lines".
Status write_vtp(const std::filesystem::path& path, std::span<const Vec3d> nodes, const char* kind,
                 std::span<const std::int32_t> connectivity, std::span<const std::int64_t> ends,
                 const SurfaceFields& fields) {
    mesh::VtkDocument document("PolyData");
    document.add("<Piece NumberOfPoints=\"" + std::to_string(nodes.size()) + "\" NumberOf" + kind +
                 "=\"" + std::to_string(ends.size()) + "\">\n<PointData>");
    for (const auto& f : fields.node_vectors) document.add_vectors(f.name, f.values);
    for (const auto& f : fields.node_numbers) document.add_array("Float64", f.name, 1, f.values);
    document.add("</PointData>\n<Points>");
    document.add_vectors("Points", nodes);
    document.add(std::string("</Points>\n<") + kind + ">");
    document.add_array("Int32", "connectivity", 1, connectivity);
    document.add_array("Int64", "offsets", 1, ends);
    document.add(std::string("</") + kind + ">\n</Piece>");
    return document.write(path);
}

std::string stl_of(const TriangleMesh& surface) {
    std::string bytes = "Pliant SPACE=LPS";
    bytes.resize(80, ' ');
    append_little_endian(bytes, std::uint32_t(surface.cells.size()));
    for (const auto& t : surface.cells) {
        const Vec3d a = surface.nodes_mm[std::size_t(t[0])],
                    b = surface.nodes_mm[std::size_t(t[1])],
                    c = surface.nodes_mm[std::size_t(t[2])];
        const Vec3d across = cross(b - a, c - a);
        const Vec3d normal = norm(across) > 0 ? normalized(across) : across;
        for (const Vec3d& v : {normal, a, b, c})
            for (int axis = 0; axis < 3; ++axis) append_little_endian(bytes, float(v[axis]));
        append_little_endian(bytes, std::uint16_t(0));
    }
    return bytes;
}

std::string obj_of(const TriangleMesh& surface) {
    std::string text = "# Pliant, millimetres, SPACE=LPS\n";
    for (const Vec3d& p : surface.nodes_mm)
        text += "v " + text_of(p.x) + " " + text_of(p.y) + " " + text_of(p.z) + "\n";
    for (const auto& t : surface.cells)
        text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
                std::to_string(t[2] + 1) + "\n";
    return text;
}

std::string ply_of(const TriangleMesh& surface) {
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\ncomment Pliant, millimetres, "
        "SPACE=LPS\nelement vertex " +
        std::to_string(surface.nodes_mm.size()) +
        "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
        std::to_string(surface.cells.size()) +
        "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3d& p : surface.nodes_mm)
        for (int a = 0; a < 3; ++a) append_little_endian(bytes, p[a]);
    for (const auto& t : surface.cells) {
        bytes += char(3);
        for (const std::int32_t n : t) append_little_endian(bytes, n);
    }
    return bytes;
}

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text)
        result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
    return result;
}

}  // namespace

Status write_surface(const std::filesystem::path& path, const TriangleMesh& surface,
                     const SurfaceFields& fields) {
    for (std::size_t c = 0; c < surface.cells.size(); ++c)
        for (const std::int32_t n : surface.cells[c])
            if (n < 0 || std::size_t(n) >= surface.nodes_mm.size())
                return Error{ErrorCode::InvalidArgument,
                             path.string() + ": cell " + std::to_string(c) + " names node " +
                                 std::to_string(n) + ", expected one of " +
                                 std::to_string(surface.nodes_mm.size())};
    if (const Status s = check(path, surface.nodes_mm.size(), fields); !s) return s;
    const std::string ending = path.extension().string();
    if (ending == ".stl") return mesh::write_file(path, stl_of(surface));
    if (ending == ".obj") return mesh::write_file(path, obj_of(surface));
    if (ending == ".ply") return mesh::write_file(path, ply_of(surface));
    if (ending == ".vtu") return write_vtu(path, surface, {fields.node_vectors, {}});
    if (ending != ".vtp")
        return Error{ErrorCode::InvalidArgument,
                     path.string() + ": expected the ending .vtp, .vtu, .stl, .obj or .ply"};
    std::vector<std::int32_t> connectivity;
    std::vector<std::int64_t> ends;
    for (const auto& t : surface.cells) {
        connectivity.insert(connectivity.end(), t.begin(), t.end());
        ends.push_back(std::int64_t(connectivity.size()));
    }
    return write_vtp(path, surface.nodes_mm, "Polys", connectivity, ends, fields);
}

Status write_lines(const std::filesystem::path& path, std::span<const Vec3d> nodes_mm,
                   std::span<const std::vector<std::int32_t>> lines, const SurfaceFields& fields) {
    if (const Status s = check(path, nodes_mm.size(), fields); !s) return s;
    std::vector<std::int32_t> connectivity;
    std::vector<std::int64_t> ends;
    for (const auto& line : lines) {
        for (const std::int32_t n : line) {
            if (n < 0 || std::size_t(n) >= nodes_mm.size())
                return Error{ErrorCode::InvalidArgument,
                             path.string() + ": a line names node " + std::to_string(n) +
                                 ", expected one of " + std::to_string(nodes_mm.size())};
            connectivity.push_back(n);
        }
        ends.push_back(std::int64_t(connectivity.size()));
    }
    return write_vtp(path, nodes_mm, "Lines", connectivity, ends, fields);
}

Status write_pvd(const std::filesystem::path& path, std::span<const SeriesFile> files) {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n"
        "<Collection>\n";
    for (const SeriesFile& f : files)
        text += "<DataSet timestep=\"" + text_of(f.time_s) + "\" group=\"\" part=\"0\" file=\"" +
                escaped(f.file) + "\"/>\n";
    return mesh::write_file(path, text + "</Collection>\n</VTKFile>\n");
}

}  // namespace pliant
