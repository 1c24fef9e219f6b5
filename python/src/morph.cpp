// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Motion of an organ between two phases.

#include <pliant/data/morph.h>

#include <optional>
#include <utility>
#include <vector>

#include "keywords.h"
#include "morphs.h"
#include "numbers.h"
#include "volumes.h"

namespace pliant::python {
namespace {

std::vector<Vec3d> points_from(const nb::object& given, const char* name) {
    if (given.is_none()) return {};
    return Numbers<double, 3>(given, name).copied_vectors();
}

/// Label maps, of a volume or of the inside of a surface.
struct Shape {
    std::optional<Volume> filled{};
    const Volume* labels = nullptr;

    Shape(const nb::object& given, const char* name) {
        if (given.is_none()) return;
        if (nb::isinstance<TriangleMesh>(given)) {
            auto made = labels_of_surface(nb::cast<const TriangleMesh&>(given));
            if (!made.ok()) raise(renamed(made.error(), name));
            filled = std::move(*made);
        }
        labels = filled ? &*filled
                        : &object_in<PyVolume>(given, name, "a Volume or a TriangleMesh").volume;
    }
};

std::vector<MorphModulus> moduli_from(const nb::object& given) {
    std::vector<MorphModulus> moduli;
    if (given.is_none()) return moduli;
    const char* const kind = "a dict of labels and ratios, such as {7: 20.0}";
    if (!nb::isinstance<nb::dict>(given)) raise_value("moduli", kind, given);
    for (const auto& [label, relative] : nb::cast<nb::dict>(given)) {
        MorphModulus one;
        if (!nb::try_cast(label, one.label) || !nb::try_cast(relative, one.relative))
            raise_value("moduli", kind, given);
        moduli.push_back(one);
    }
    return moduli;
}

const Volume* volume_from(const nb::object& given, const char* name) {
    return given.is_none() ? nullptr : &object_in<PyVolume>(given, name, "a Volume").volume;
}

Morph morphed(const nb::object& from, const nb::object& to, const nb::object& from_mm,
              const nb::object& to_mm, const nb::object& grid, const nb::object& moduli,
              int threads, const nb::kwargs& settings) {
    const std::vector<Vec3d> known = points_from(from_mm, "from_mm"),
                             found = points_from(to_mm, "to_mm");
    const Volume* const scan = volume_from(grid, "grid");
    const Shape from_shape(from, "from_labels"), to_shape(to, "to_labels");
    const std::vector<MorphModulus> relative = moduli_from(moduli);
    const MorphInput input{.from_mm = known,
                           .to_mm = found,
                           .from = from_shape.labels,
                           .to = to_shape.labels,
                           .moduli = relative,
                           .grid = scan ? &scan->grid : nullptr};
    const auto wanted = settings_from<MorphSettings>(settings, morph_rows());
    const Arena arena(threads);
    auto made = arena.run([&] { return Morph::create(input, wanted, arena.tasks()); });
    if (made.ok()) return std::move(*made);
    const Error& error = made.error();
    raise(error.field == "from" || error.field == "to" ? renamed(error, error.field + "_labels")
                                                       : error);
}

template <class Move>
nb::object moved(const nb::object& given, const Move& move) {
    std::vector<Vec3d> points = points_from(given, "points_mm");
    for_each_row(points.size(), [&](std::size_t n) { points[n] = move(points[n]); });
    return points_of(std::move(points));
}

/// A field on the grid of a volume, or on the nodes.
template <class Make>
VectorField field_on(const Morph& m, const nb::object& given, int threads, const Make& make) {
    const Volume* const volume = volume_from(given, "grid");
    const Grid& grid = volume ? volume->grid : m.nodes();
    const Arena arena(threads);
    return take(arena.run([&] { return make(grid, arena.tasks()); }));
}

nb::dict report_of(const Morph& m) {
    const MorphReport& r = m.report();
    nb::dict dict;
    dict["points"] = r.points;
    dict["parts"] = r.parts;
    dict["prior"] = r.has_prior ? "supine" : "none";
    dict["point_residual_mm"] = r.point_residual_mm;
    dict["surface_residual_mm"] = r.surface_residual_mm;
    dict["max_displacement_mm"] = r.max_displacement_mm;
    dict["least_volume"] = r.least_volume;
    dict["softened"] = r.softened;
    dict["affine_share"] = r.affine_share;
    dict["solve_ms"] = r.solve_ms;
    return dict;
}

}  // namespace

void bind_morph(nb::module_& m) {
    nb::class_<Morph>(
        m, "Morph", "A motion phi between two phases, one to one in all of space, of pliant.morph.")
        .def(
            "forward",
            [](const Morph& self, const nb::object& points) {
                return moved(points, [&](Vec3d p) { return self.forward(p); });
            },
            nb::arg("points_mm"),
            nb::sig("def forward(self, points_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "phi at points (n, 3) [mm, LPS].")
        .def(
            "inverse",
            [](const Morph& self, const nb::object& points) {
                return moved(points, [&](Vec3d p) { return self.inverse(p); });
            },
            nb::arg("points_mm"),
            nb::sig("def inverse(self, points_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "The inverse of phi at points (n, 3) [mm, LPS].")
        .def(
            "forward_field",
            [](const Morph& self, const nb::object& grid, int threads) {
                return field_on(self, grid, threads, [&](const Grid& g, const TaskArena& tasks) {
                    return self.forward_field(g, tasks);
                });
            },
            nb::arg("grid") = nb::none(), nb::arg("threads") = 0,
            nb::sig("def forward_field(self, grid: Volume | None = None, threads: int = 0) -> "
                    "Field"),
            "Displacements at the voxels of a volume, or at the nodes that phi is stored at.")
        .def(
            "inverse_field",
            [](const Morph& self, const nb::object& grid, int threads) {
                return field_on(self, grid, threads, [&](const Grid& g, const TaskArena& tasks) {
                    return self.inverse_field(g, tasks);
                });
            },
            nb::arg("grid") = nb::none(), nb::arg("threads") = 0,
            nb::sig("def inverse_field(self, grid: Volume | None = None, threads: int = 0) -> "
                    "Field"),
            "The inverse field, as resampling filters expect: Field.apply_to_volume.")
        .def_prop_ro("report", &report_of, nb::sig("def report(self, /) -> dict[str, typing.Any]"),
                     "Residuals [mm], the bound of the volume that is left, and times.")
        .def("__repr__", [](const Morph& self) {
            return "Morph(" + std::to_string(self.report().points) + " points, " +
                   std::to_string(self.report().parts) + " parts)";
        });
    const Keywords keywords = keywords_of(morph_rows());
    m.def(
        "morph", &morphed, nb::arg("from_labels") = nb::none(), nb::arg("to_labels") = nb::none(),
        nb::arg("from_mm") = nb::none(), nb::arg("to_mm") = nb::none(),
        nb::arg("grid") = nb::none(), nb::arg("moduli") = nb::none(), nb::arg("threads") = 0,
        nb::arg("settings"),
        typed("def morph(from_labels: Volume | TriangleMesh | None = None, "
              "to_labels: Volume | TriangleMesh | None = None, "
              "from_mm: numpy.typing.ArrayLike | None = None, "
              "to_mm: numpy.typing.ArrayLike | None = None, grid: Volume | None = None, "
              "moduli: dict[int, float] | None = None, threads: int = 0, *, **settings) -> Morph",
              keywords),
        described(
            "Motion of an organ between two phases, from its shapes, known points or both.\n\n"
            "Example:\n"
            "    >>> motion = pliant.morph(exhale, inhale, from_mm=known, to_mm=found)\n"
            "    >>> motion.forward(points)\n\n"
            "Args:\n"
            "    from_labels: Label map of the first phase, or a closed surface.\n"
            "    to_labels: The same of the second phase, on any grid.\n"
            "    from_mm: Known points (n, 3) at the first phase [mm, LPS].\n"
            "    to_mm: The same points at the second phase.\n"
            "    grid: Scan whose voxels hold the nodes; None: from_labels.\n"
            "    moduli: Young's moduli of labels over that of the others: {7: 20}. A label that\n"
            "        to_labels lacks, such as a tumour, is tissue of the part around it.\n"
            "    threads: 0: one for each core.\n"
            "    **settings",
            keywords));
}

}  // namespace pliant::python
