// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tetrahedra.

#include <pliant/mesh.h>
#include <pliant/mesh_files.h>

#include "numbers.h"

namespace pliant::python {
namespace {

TetMesh mesh_of(const nb::object& nodes_mm, const nb::object& cells) {
    TetMesh mesh{Numbers<double, 3>(nodes_mm, "nodes_mm").copied_vectors(),
                 Numbers<std::int32_t, 4>(cells, "cells").copied_rows()};
    take(check_mesh(mesh));
    return mesh;
}

}  // namespace

void bind_meshes(nb::module_& m) {
    nb::class_<TetMesh>(m, "TetMesh", "Tetrahedra: nodes (n, 3) [mm, LPS], cells (m, 4).")
        .def(
            "__init__",
            [](TetMesh* self, const nb::object& nodes_mm, const nb::object& cells) {
                new (self) TetMesh(mesh_of(nodes_mm, cells));
            },
            nb::arg("nodes_mm"), nb::arg("cells"),
            nb::sig("def __init__(self, nodes_mm: numpy.typing.ArrayLike, "
                    "cells: numpy.typing.ArrayLike) -> None"))
        .def_prop_ro(
            "nodes_mm",
            [](nb::handle self) {
                const auto& mesh = nb::cast<const TetMesh&>(self);
                return nb::cast(nb::ndarray<nb::numpy, const double, nb::shape<-1, 3>>(
                    &mesh.nodes_mm.data()->x, {mesh.nodes_mm.size(), 3}, self));
            },
            nb::sig("def nodes_mm(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Nodes (n, 3) [mm, LPS], read-only, without a copy.")
        .def_prop_ro(
            "cells",
            [](nb::handle self) {
                const auto& mesh = nb::cast<const TetMesh&>(self);
                return nb::cast(nb::ndarray<nb::numpy, const std::int32_t, nb::shape<-1, 4>>(
                    reinterpret_cast<const std::int32_t*>(mesh.cells.data()),
                    {mesh.cells.size(), 4}, self));
            },
            nb::sig("def cells(self, /) -> numpy.typing.NDArray[numpy.int32]"),
            "Four nodes for each tetrahedron, read-only, without a copy.")
        .def(
            "save",
            [](const TetMesh& mesh, const std::filesystem::path& path) {
                take(write_vtu(path, mesh));
            },
            nb::arg("path"), "Writes a .vtu.")
        .def(
            "__reduce__", [](nb::handle self) { return exchange("reduced_mesh")(self); },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def("__repr__", [](const TetMesh& mesh) {
            return "TetMesh(" + std::to_string(mesh.nodes_mm.size()) + " nodes, " +
                   std::to_string(mesh.cells.size()) + " tetrahedra)";
        });
    m.def(
        "read_tetrahedra",
        [](const std::filesystem::path& path) {
            auto mesh = [&] {
                const nb::gil_scoped_release without_lock;
                return read_tetrahedra(path);
            }();
            return take(std::move(mesh));
        },
        nb::arg("path"), "Reads the tetrahedra of a .vtu, .vtk or .msh [mm, LPS].");
}

}  // namespace pliant::python
