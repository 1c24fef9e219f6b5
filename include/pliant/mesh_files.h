// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Meshes from files and to files.
//
//   read: VTP and VTU (text, base64, appended, zlib), legacy VTK, Gmsh's MSH 2.2, 4.0 and 4.1,
//         STL, OBJ, PLY; by what the file holds, not by its name
//   written: VTP, VTU, STL, OBJ, PLY, and PVD for series in time; by the name's ending
//
// World coordinates are LPS and written as such (SPACE=LPS, as 3D Slicer does); a file that says
// RAS is turned. All numbers of a file are checked before memory is asked for.
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

/// What a file holds, as far as Pliant uses it. Polygons come as fans of triangles.
struct MeshData {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 4>> tetrahedra;
    std::vector<std::array<std::int32_t, 3>> triangles;
    std::vector<std::vector<std::int32_t>> lines;  ///< two nodes or more each
    /// Numbers at the nodes, components of one node side by side.
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

/// Largest distance of a node from the origin [mm]. Patients and the rooms around them are smaller;
/// one far node would have lattices of millions of cells laid around it.
inline constexpr double kMaxNodeDistanceMm = 1e4;

/// @returns NotFound, Unreadable, Unsupported, or LimitExceeded for a node beyond
///          kMaxNodeDistanceMm, with one line that names the file
Result<MeshData> read_mesh(const std::filesystem::path& path);
/// Its triangles, or the boundary of its tetrahedra where it has no triangles; nodes in the same
/// place are one (STL has no others). @returns also Unsupported where there are neither
Result<TriangleMesh> read_surface(const std::filesystem::path& path);
/// Its tetrahedra with the nodes that they use. @returns also Unsupported where there are none
Result<TetMesh> read_tetrahedra(const std::filesystem::path& path);

/// Nodes in the very same place become one, and triangles that collapse are left out.
TriangleMesh joined(const TriangleMesh& surface);

/// Vectors and numbers at the nodes, for the formats that hold them (VTP).
struct SurfaceFields {
    std::vector<VtuVectors> node_vectors{};
    std::vector<VtuNumbers> node_numbers{};
};
/// .vtp, .vtu, .stl, .obj or .ply. Appears whole or not at all.
/// @returns InvalidArgument for another ending or a field of another length, Unwritable
Status write_surface(const std::filesystem::path& path, const TriangleMesh& surface,
                     const SurfaceFields& fields = {});

/// Curves with numbers at their nodes, as VTP: centrelines.
Status write_lines(const std::filesystem::path& path, std::span<const Vec3d> nodes_mm,
                   std::span<const std::vector<std::int32_t>> lines,
                   const SurfaceFields& fields = {});

/// A series in time for ParaView: which file shows which moment.
struct SeriesFile {
    double time_s;
    std::string file;  ///< as the series's file names it: relative to its folder
};
Status write_pvd(const std::filesystem::path& path, std::span<const SeriesFile> files);

}  // namespace pliant
#pragma GCC visibility pop
