// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files of meshes.
//
//   read: VTP and VTU (text, base64, appended, zlib), legacy VTK, Gmsh's MSH 2.2, 4.0 and 4.1,
//         STL, OBJ, PLY, OFF, Medit's MESH; detected by the content
//   written: VTP, VTU, STL, OBJ, PLY, and PVD for series in time; chosen by the extension
//
// World coordinates are LPS and written as such (SPACE=LPS, as 3D Slicer does). A file that
// declares RAS is converted. All counts of a file are checked before memory is allocated.
//
// @code
//   const auto surface = read_surface("aorta.vtp");
//   if (!surface) std::puts(surface.error().message.c_str());
//   write_vtu("body.vtu", mesh, {{{"displacement_mm", displacements}}});
// @endcode

#pragma once

#include <pliant/core/vec.h>
#include <pliant/mesh.h>
#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Length of a unit, "mm", "cm" or "m" [mm].
double mm_of_unit(std::string_view unit);

/// Tetrahedra in mirrored order are turned (turn_mirrored); of cells of second order, the corners
/// are taken. MeshData::notes says so.
/// @param unit_mm  length of the file's unit: 10 for centimetres, 1000 for metres
/// @returns NotFound, Unreadable, Unsupported, or LimitExceeded for a node beyond
///          kMaxNodeDistanceMm, with one line that names the file
Result<MeshData> read_mesh(const std::filesystem::path& path, double unit_mm = 1);
/// Reads the triangles, or the boundary of the tetrahedra if there are no triangles. The
/// triangles are cleaned (STL has separate corners). @returns also Unsupported if there are neither
Result<TriangleMesh> read_surface(const std::filesystem::path& path, double unit_mm = 1);
/// Reads the tetrahedra with their nodes. @returns also Unsupported if there are none
Result<TetMesh> read_tetrahedra(const std::filesystem::path& path, double unit_mm = 1);

/// Named vectors or numbers at the nodes or in the cells of a file.
struct VtuVectors {
    std::string name;
    std::span<const Vec3d> values;
};
struct VtuNumbers {
    std::string name;
    std::span<const double> values;
};
struct VtuFields {
    std::vector<VtuVectors> node_vectors{};
    std::vector<VtuNumbers> cell_numbers{};
};

/// Writes VTK's XML file of an unstructured grid, for ParaView and 3D Slicer: 64-bit floats,
/// appended in base64. Atomic.
/// @returns InvalidArgument for a field of the wrong length or a cell with an unknown node,
///          Unwritable
Status write_vtu(const std::filesystem::path& path, const HexMesh& mesh,
                 const VtuFields& fields = {});
Status write_vtu(const std::filesystem::path& path, const TetMesh& mesh,
                 const VtuFields& fields = {});
Status write_vtu(const std::filesystem::path& path, const TriangleMesh& mesh,
                 const VtuFields& fields = {});

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
