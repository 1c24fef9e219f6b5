// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reading and writing of meshes.
//
//   read: VTP and VTU (text, base64, appended, zlib), legacy VTK, Gmsh's MSH 2.2, 4.0 and 4.1,
//         STL, OBJ, PLY; detected by the content
//   written: VTP, VTU, STL, OBJ, PLY, and PVD for series in time; chosen by the extension
//
// World coordinates are LPS and written as such (SPACE=LPS, as 3D Slicer does). A file that
// declares RAS is converted. All counts of a file are checked before memory is allocated.
//
//   const auto surface = read_surface("aorta.vtp");
//   if (!surface) …surface.error().message

#pragma once

#include <pliant/mesh.h>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Contents of a file, as far as Pliant uses them. Polygons are split into fans of triangles.
struct MeshData {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 4>> tetrahedra;
    std::vector<std::array<std::int32_t, 3>> triangles;
    std::vector<std::vector<std::int32_t>> lines;  ///< two nodes or more each
    /// Numbers at the nodes, the components of one node contiguous.
    struct Field {
        std::string name;
        std::size_t components = 1;
        std::vector<double> values;
    };
    std::vector<Field> node_fields;

    const Field* field(std::string_view name) const {
        for (const Field& f : node_fields)
            if (f.name == name) return &f;
        return nullptr;
    }
};

/// Largest distance of a node from the origin [mm]. Patients and treatment rooms are smaller; one
/// distant node would cause lattices of millions of cells.
inline constexpr double kMaxNodeDistanceMm = 1e4;

/// @returns NotFound, Unreadable, Unsupported, or LimitExceeded for a node beyond
///          kMaxNodeDistanceMm, with one line that names the file
Result<MeshData> read_mesh(const std::filesystem::path& path);
/// Reads the triangles, or the boundary of the tetrahedra if there are no triangles. Nodes in equal
/// positions are merged (STL has no others). @returns also Unsupported if there are neither
Result<TriangleMesh> read_surface(const std::filesystem::path& path);
/// Reads the tetrahedra with their nodes. @returns also Unsupported if there are none
Result<TetMesh> read_tetrahedra(const std::filesystem::path& path);

/// Merges nodes in equal positions and drops collapsed triangles.
TriangleMesh joined(const TriangleMesh& surface);

/// Vectors and numbers at the nodes, for formats with fields (VTP).
struct SurfaceFields {
    std::vector<VtuVectors> node_vectors{};
    std::vector<VtuNumbers> node_numbers{};
};
/// Writes .vtp, .vtu, .stl, .obj or .ply. Atomic.
/// @returns InvalidArgument for another extension or a field of the wrong length, Unwritable
Status write_surface(const std::filesystem::path& path, const TriangleMesh& surface,
                     const SurfaceFields& fields = {});

/// Curves with numbers at their nodes, as VTP: centrelines.
Status write_lines(const std::filesystem::path& path, std::span<const Vec3d> nodes_mm,
                   std::span<const std::vector<std::int32_t>> lines,
                   const SurfaceFields& fields = {});

/// File of one time step in a series for ParaView.
struct SeriesFile {
    double time_s;
    std::string file;  ///< relative to the folder of the .pvd file
};
Status write_pvd(const std::filesystem::path& path, std::span<const SeriesFile> files);

}  // namespace pliant
#pragma GCC visibility pop
