// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Triangles and hexahedra; pictures of surfaces.

#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/view/surface_view.h>

#include "numbers.h"
#include "pictures.h"
#include "struct_class.h"

namespace pliant::python {
namespace {

template <class Mesh>
constexpr std::size_t kCorners = std::tuple_size_v<typename decltype(Mesh::cells)::value_type>;

/// The class of a mesh: nodes and cells in, nodes and cells out.
template <class Mesh>
nb::class_<Mesh> mesh_class(nb::module_& m, const char* name, const char* text) {
    constexpr std::size_t kCount = kCorners<Mesh>;
    nb::class_<Mesh> c(m, name, text);
    c.def(
         "__init__",
         [](Mesh* self, const nb::object& nodes_mm, const nb::object& cells) {
             Mesh mesh;
             mesh.nodes_mm = Numbers<double, 3>(nodes_mm, "nodes_mm").copied_vectors();
             mesh.cells = Numbers<std::int32_t, kCount>(cells, "cells").copied_rows();
             take(check_cells(mesh));
             new (self) Mesh(std::move(mesh));
         },
         nb::arg("nodes_mm"), nb::arg("cells"),
         nb::sig("def __init__(self, nodes_mm: numpy.typing.ArrayLike, cells: "
                 "numpy.typing.ArrayLike) -> None"),
         "Args:\n    nodes_mm: Nodes (n, 3) [mm, LPS].\n    cells: Nodes of each cell.")
        .def_prop_ro(
            "nodes_mm",
            [](nb::handle self) { return viewed_rows(nb::cast<const Mesh&>(self).nodes_mm, self); },
            nb::sig("def nodes_mm(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Nodes (n, 3) [mm, LPS], read-only, without a copy.")
        .def_prop_ro(
            "cells",
            [](nb::handle self) {
                const auto& cells = nb::cast<const Mesh&>(self).cells;
                return nb::cast(nb::ndarray<nb::numpy, const std::int32_t, nb::ndim<2>>(
                    reinterpret_cast<const std::int32_t*>(cells.data()), {cells.size(), kCount},
                    self));
            },
            nb::sig("def cells(self, /) -> numpy.typing.NDArray[numpy.int32]"),
            "Nodes of each cell, read-only, without a copy.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                const nb::object copy = nb::module_::import_("numpy").attr("array");
                return nb::make_tuple(self.type(), nb::make_tuple(copy(self.attr("nodes_mm")),
                                                                  copy(self.attr("cells"))));
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def("__repr__", [name = std::string(name)](const Mesh& mesh) {
            return name + "(" + std::to_string(mesh.nodes_mm.size()) + " nodes, " +
                   std::to_string(mesh.cells.size()) + " cells)";
        });
    return c;
}

/// Calls work() without the interpreter's lock, and raises its error.
template <class Work>
auto unlocked(const Work& work) {
    auto result = [&] {
        const nb::gil_scoped_release without_lock;
        return work();
    }();
    return take(std::move(result));
}

void bind_meshes_of_surfaces(nb::module_& m) {
    mesh_class<TriangleMesh>(m, "TriangleMesh", "Triangles: nodes (n, 3) [mm, LPS], cells (m, 3).")
        .def(
            "save",
            [](const TriangleMesh& mesh, const std::filesystem::path& path) {
                unlocked([&] { return write_surface(path, mesh); });
            },
            nb::arg("path"), "Writes .vtp, .vtu, .stl, .obj or .ply.")
        .def(
            "enclosed_volume_mm3",
            [](const TriangleMesh& mesh) { return enclosed_volume_mm3(mesh); },
            "Enclosed volume [mm^3], negative if the triangles face inwards.");
    mesh_class<HexMesh>(m, "HexMesh",
                        "Hexahedra: nodes (n, 3) [mm, LPS], cells (m, 8) in VTK's order of "
                        "corners.")
        .def(
            "save",
            [](const HexMesh& mesh, const std::filesystem::path& path) {
                unlocked([&] { return write_vtu(path, mesh); });
            },
            nb::arg("path"), "Writes a .vtu.")
        .def(
            "boundary_faces",
            [](const HexMesh& mesh) {
                std::vector<std::int32_t> rows;
                for (const HexFace& face : boundary_faces(mesh)) {
                    rows.push_back(face.cell);
                    rows.push_back(face.face);
                }
                const std::array shape{rows.size() / 2, std::size_t(2)};
                return array_owning<std::int32_t>(std::move(rows), shape);
            },
            nb::sig("def boundary_faces(self) -> numpy.typing.NDArray[numpy.int32]"),
            "Faces of one cell only (n, 2): the cell, and the face 0 to 5 (-r, +r, -s, +s, -t, "
            "+t).");
    m.def(
        "read_surface",
        [](const std::filesystem::path& path) {
            return unlocked([&] { return read_surface(path); });
        },
        nb::arg("path"),
        "Reads the triangles of a VTP, VTU, VTK, MSH, STL, OBJ or PLY, or the boundary of its "
        "tetrahedra [mm, LPS].");
    m.def(
        "hex_mesh",
        [](const std::vector<int>& size, Vec3d spacing_mm, Vec3d origin_mm) {
            if (size.size() != 3)
                raise({ErrorCode::InvalidArgument,
                       "size: expected three numbers, found " + std::to_string(size.size()),
                       "size"});
            const HexLattice lattice{{size[0], size[1], size[2]}, spacing_mm, origin_mm};
            take(check_lattice(lattice));
            return hex_mesh(lattice);
        },
        nb::arg("size"), nb::arg("spacing_mm") = Vec3d{1, 1, 1},
        nb::arg("origin_mm") = Vec3d{0, 0, 0},
        nb::sig("def hex_mesh(size: collections.abc.Sequence[int], spacing_mm: "
                "collections.abc.Sequence[float] = (1, 1, 1), origin_mm: "
                "collections.abc.Sequence[float] = (0, 0, 0)) -> HexMesh"),
        "A box with `size` nodes along x, y, z; x fastest.");
    m.def(
        "boundary_triangles", [](const TetMesh& mesh) { return boundary_triangles(mesh); },
        nb::arg("mesh"), "Boundary of tetrahedra, outward, as a separate mesh.");
    m.def(
        "fill_surface",
        [](const TriangleMesh& surface, double cell_mm, std::int64_t tetrahedra, int threads) {
            const Arena arena(threads);
            return take(arena.run([&] {
                       return fill_surface(surface, {cell_mm, tetrahedra}, arena.tasks());
                   }))
                .mesh;
        },
        nb::arg("surface"), nb::arg("cell_mm") = 0.0, nb::arg("tetrahedra") = 20'000,
        nb::arg("threads") = 0,
        "Fills a closed surface with tetrahedra.\n\n"
        "Args:\n"
        "    cell_mm: Edge of the lattice's cubes; 0: it follows from the number.\n"
        "    tetrahedra: Their approximate number.");
}

/// A surface or wire that a picture shows, with arrays of its own.
struct PySurface {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 3>> triangles;
    std::vector<double> values;
    Rgb8 colour;
    double opacity;
};
struct PyWire {
    std::vector<Vec3d> points_mm;
    double radius_mm;
    Rgb8 colour;
};

void bind_surface_view(nb::module_& m) {
    nb::class_<PySurface>(m, "DrawnSurface", "A surface in a picture of surface_view().")
        .def(
            "__init__",
            [](PySurface* self, const nb::object& nodes_mm, const nb::object& triangles,
               const std::optional<nb::object>& values, const nb::object& colour, double opacity) {
                PySurface made{Numbers<double, 3>(nodes_mm, "nodes_mm").copied_vectors(),
                               Numbers<std::int32_t, 3>(triangles, "triangles").copied_rows(),
                               {},
                               FieldOf<Rgb8>::from(colour, "colour"),
                               opacity};
                if (values) made.values = spread(*values, made.nodes_mm.size(), "values");
                new (self) PySurface(std::move(made));
            },
            nb::arg("nodes_mm"), nb::arg("triangles"), nb::arg("values") = nb::none(),
            nb::arg("colour") = nb::make_tuple(222, 150, 134), nb::arg("opacity") = 1.0,
            nb::sig("def __init__(self, nodes_mm: numpy.typing.ArrayLike, triangles: "
                    "numpy.typing.ArrayLike, values: numpy.typing.ArrayLike | None = None, colour: "
                    "collections.abc.Sequence[int] = (222, 150, 134), opacity: float = 1.0) -> "
                    "None"),
            "Args:\n"
            "    nodes_mm: Nodes (n, 3) [mm, LPS].\n"
            "    triangles: (m, 3).\n"
            "    values: Of the nodes (n,), in the colours of the picture's scale; None: colour.\n"
            "    opacity: 0 to 1, of one layer.");
    nb::class_<PyWire>(m, "DrawnWire", "An opaque wire of round sections in a picture.")
        .def(
            "__init__",
            [](PyWire* self, const nb::object& points_mm, double radius_mm,
               const nb::object& colour) {
                new (self) PyWire{Numbers<double, 3>(points_mm, "points_mm").copied_vectors(),
                                  radius_mm, FieldOf<Rgb8>::from(colour, "colour")};
            },
            nb::arg("points_mm"), nb::arg("radius_mm") = 1.0,
            nb::arg("colour") = nb::make_tuple(240, 190, 70),
            nb::sig("def __init__(self, points_mm: numpy.typing.ArrayLike, radius_mm: float = 1.0, "
                    "colour: collections.abc.Sequence[int] = (240, 190, 70)) -> None"),
            "Args:\n    points_mm: Points (n, 3) [mm, LPS].");
    m.def(
        "surface_view",
        [](const std::vector<PySurface>& surfaces, const std::vector<PyWire>& wires, int width,
           int height, Vec3d look, Vec3d up, double full, const std::string& scale,
           const std::string& caption) {
            check_size(width, height);
            std::vector<DrawnSurface> drawn;
            for (const PySurface& s : surfaces)
                drawn.push_back({s.nodes_mm, s.triangles, s.values, s.colour, s.opacity});
            std::vector<DrawnWire> lines;
            for (const PyWire& w : wires) lines.push_back({w.points_mm, w.radius_mm, w.colour});
            const SurfaceView view{look, up, full, scale, caption};
            return picture_of([&] {
                const nb::gil_scoped_release without_lock;
                return surface_view(drawn, lines, view, width, height);
            }());
        },
        nb::arg("surfaces"), nb::arg("wires") = std::vector<PyWire>{}, nb::arg("width") = 512,
        nb::arg("height") = 512, nb::arg("look") = Vec3d{0, 0, 0}, nb::arg("up") = Vec3d{0, 0, 0},
        nb::arg("full") = 1.0, nb::arg("scale") = "", nb::arg("caption") = "",
        nb::sig("def surface_view(surfaces: collections.abc.Sequence[DrawnSurface], wires: "
                "collections.abc.Sequence[DrawnWire] = (), width: int = 512, height: int = 512, "
                "look: collections.abc.Sequence[float] = (0, 0, 0), up: "
                "collections.abc.Sequence[float] = (0, 0, 0), full: float = 1.0, scale: str = "
                "\"\", caption: str = \"\") -> numpy.typing.NDArray[numpy.uint8]"),
        "Surfaces and wires from outside in parallel projection, as large as they fit, with a "
        "scale bar: a picture (height, width, 3).\n\n"
        "Args:\n"
        "    look: LPS; zero: along the axis of the smallest extent.\n"
        "    full: Value of the scale's last colour.\n"
        "    scale: Name of the values, with its unit; empty: no scale is drawn.\n"
        "    caption: In the upper left corner.");
}

}  // namespace

void bind_surfaces(nb::module_& m) {
    bind_meshes_of_surfaces(m);
    bind_surface_view(m);
}

}  // namespace pliant::python
