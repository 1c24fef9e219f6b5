// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/volume.h>

#include "arrays.h"

namespace pliant::python {

/// A volume, with the array whose memory it views, if any.
struct PyVolume {
    Volume volume;
    nb::object memory;
};

/// A grid from Python's arguments. @param direction  nine numbers by rows, as SimpleITK's
Grid grid_from(Vec3i size, Vec3d spacing_mm, Vec3d origin_mm, const std::vector<double>& direction);
/// The direction's columns as rows of numbers.
nb::object direction_of(const Grid& grid);
/// A read-only array (k, j, i) or (k, j, i, 3) of memory that the owner keeps.
nb::object array_of(const float* data, const Grid& grid, bool is_vector, nb::handle owner);

/// Adds size, spacing_mm, origin_mm, direction and the maps between voxels and the world.
template <class Class, class GridOf>
void bind_grid(Class& c, const GridOf& grid_of) {
    using T = typename Class::Type;
    c.def_prop_ro(
         "size",
         [=](const T& v) {
             return nb::make_tuple(grid_of(v).size.x, grid_of(v).size.y, grid_of(v).size.z);
         },
         nb::sig("def size(self, /) -> tuple[int, int, int]"), "Voxels along i, j, k.")
        .def_prop_ro(
            "spacing_mm", [=](const T& v) { return grid_of(v).spacing_mm; },
            "Distances of voxel centres along i, j, k [mm].")
        .def_prop_ro(
            "origin_mm", [=](const T& v) { return grid_of(v).origin_mm; },
            "Centre of voxel (0, 0, 0) [mm, LPS].")
        .def_prop_ro(
            "direction", [=](const T& v) { return direction_of(grid_of(v)); },
            nb::sig("def direction(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "3 x 3 matrix whose columns are the i, j, k axes in LPS.")
        .def(
            "world_from_voxel",
            [=](const T& v, Vec3d ijk) { return world_from_voxel(grid_of(v), ijk); },
            nb::arg("ijk"), "Continuous voxel index (i, j, k) to a point [mm, LPS].")
        .def(
            "voxel_from_world",
            [=](const T& v, Vec3d point_mm) { return voxel_from_world(grid_of(v), point_mm); },
            nb::arg("point_mm"), "Point [mm, LPS] to a continuous voxel index (i, j, k).");
}

}  // namespace pliant::python
