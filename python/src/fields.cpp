// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacement fields.

#include <pliant/resample.h>
#include <pliant/scan_files.h>

#include "volumes.h"

namespace pliant::python {
namespace {

using Vectors = nb::ndarray<const float, nb::ndim<4>, nb::c_contig, nb::device::cpu>;
using Points = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

const char* name_of(FieldKind kind) {
    return kind == FieldKind::Modeling ? "modeling" : "resampling";
}

VectorField field_of(const nb::object& array, Vec3d spacing_mm, Vec3d origin_mm,
                     const std::vector<double>& direction, const std::string& kind) {
    if (kind != "modeling" && kind != "resampling")
        raise({ErrorCode::InvalidArgument, "kind: expected modeling or resampling, found " + kind,
               "kind", "modeling or resampling", kind});
    Vectors vectors;
    const nb::object memory = array_in(array, "array", "float32", true);
    if (!nb::try_cast<Vectors>(memory, vectors) || vectors.shape(3) != 3)
        raise({ErrorCode::InvalidArgument,
               "array: expected axes (k, j, i, 3), found " + shown(memory.attr("shape")), "array"});
    VectorField field{
        grid_from({int(vectors.shape(2)), int(vectors.shape(1)), int(vectors.shape(0))}, spacing_mm,
                  origin_mm, direction),
        kind == "modeling" ? FieldKind::Modeling : FieldKind::Resampling,
        {}};
    const auto* const first = reinterpret_cast<const Vec3f*>(vectors.data());
    field.vectors_mm.assign(first, first + vectors.size() / 3);
    take(check_field(field, "array"));
    return field;
}

nb::object apply_to_points(const VectorField& field, const nb::object& given) {
    const nb::object memory = array_in(given, "points_mm", "float64");
    Points points;
    if (!nb::try_cast<Points>(memory, points) || points.shape(1) != 3)
        raise({ErrorCode::InvalidArgument,
               "points_mm: expected axes (n, 3), found " + shown(memory.attr("shape")),
               "points_mm"});
    std::vector<Vec3d> moved(points.shape(0));
    for_each_row(moved.size(), [&](std::size_t n) {
        const double* const p = points.data() + 3 * n;
        moved[n] = Vec3d{p[0], p[1], p[2]} + sample_field(field, {p[0], p[1], p[2]});
    });
    return points_of(std::move(moved));
}

}  // namespace

void bind_fields(nb::module_& m) {
    nb::class_<VectorField> c(
        m, "Field",
        "A displacement [mm, LPS] for each voxel of a grid.\n\n"
        "kind \"modeling\": forward, from rest to the deformed shape, at rest voxel centres. kind "
        "\"resampling\": its inverse, from points of the output to points of the input, as "
        "resampling filters and 3D Slicer's grid transforms expect.");
    c.def(
         "__init__",
         [](VectorField* self, const nb::object& array, Vec3d spacing_mm, Vec3d origin_mm,
            const std::optional<nb::object>& direction, const std::string& kind) {
             new (self) VectorField(
                 field_of(array, spacing_mm, origin_mm, numbers_of(direction, "direction"), kind));
         },
         nb::arg("array"), nb::arg("spacing_mm") = Vec3d{1, 1, 1},
         nb::arg("origin_mm") = Vec3d{0, 0, 0}, nb::arg("direction") = nb::none(),
         nb::arg("kind") = "modeling",
         nb::sig("def __init__(self, array: numpy.typing.ArrayLike, "
                 "spacing_mm: collections.abc.Sequence[float] | "
                 "numpy.typing.NDArray[typing.Any] = (1, 1, 1), "
                 "origin_mm: collections.abc.Sequence[float] | "
                 "numpy.typing.NDArray[typing.Any] = (0, 0, 0), "
                 "direction: numpy.typing.ArrayLike | None = None, "
                 "kind: str = \"modeling\") -> None"),
         "Args:\n    array: Vectors (k, j, i, 3), components x, y, z in LPS [mm].")
        .def_prop_ro(
            "array",
            [](nb::handle self) {
                const auto& field = nb::cast<const VectorField&>(self);
                return array_of(&field.vectors_mm.front().x, field.grid, true, self);
            },
            nb::sig("def array(self, /) -> numpy.typing.NDArray[numpy.float32]"),
            "The vectors (k, j, i, 3) [mm, LPS], read-only, without a copy.")
        .def_prop_ro(
            "kind", [](const VectorField& f) { return name_of(f.kind); },
            "\"modeling\" or \"resampling\".")
        .def("apply_to_points", &apply_to_points, nb::arg("points_mm"),
             nb::sig("def apply_to_points(self, points_mm: numpy.typing.ArrayLike) -> "
                     "numpy.typing.NDArray[numpy.float64]"),
             "Moves points (n, 3) [mm, LPS] by the field, trilinear; those beyond it rest.")
        .def(
            "apply_to_volume",
            [](const VectorField& f, const PyVolume& volume, int threads) {
                const Arena arena(threads);
                return PyVolume{
                    take(arena.run([&] { return apply_field(f, volume.volume, arena.tasks()); })),
                    {}};
            },
            nb::arg("volume"), nb::arg("threads") = 0,
            "Resamples a volume: out(p) = volume(p + field(p)), trilinear. For kind "
            "\"resampling\".")
        .def(
            "jacobian",
            [](const VectorField& f) {
                auto made = [&] {
                    const nb::gil_scoped_release without_lock;
                    return jacobian_field(f);
                }();
                return PyVolume{take(std::move(made)), {}};
            },
            "Determinant of I + du/dX at each voxel, from central differences.")
        .def(
            "save",
            [](const VectorField& f, const std::filesystem::path& path) {
                take_until_interrupted([&](const std::function<bool()>& give_up) {
                    return write_vector_field(path, f, Encoding::Gzip, give_up);
                });
            },
            nb::arg("path"), "Writes a NRRD vector image, which 3D Slicer opens as a transform.")
        .def(
            "to_sitk_transform",
            [](nb::handle self) { return exchange("field_to_sitk_transform")(self); },
            nb::sig("def to_sitk_transform(self) -> typing.Any"),
            "A SimpleITK transform of the same map of points; to resample, that of an inverse.")
        .def(
            "__reduce__", [](nb::handle self) { return exchange("reduced_field")(self); },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def("__repr__", [](const VectorField& f) {
            const Vec3i n = f.grid.size;
            return "Field(" + std::to_string(n.x) + " x " + std::to_string(n.y) + " x " +
                   std::to_string(n.z) + " vectors, " + name_of(f.kind) + ")";
        });
    bind_grid(c, [](const VectorField& f) -> const Grid& { return f.grid; });
    m.def(
        "read_field",
        [](const std::filesystem::path& path) {
            auto field = [&] {
                const nb::gil_scoped_release without_lock;
                return read_vector_field(path);
            }();
            return take(std::move(field));
        },
        nb::arg("path"), "Reads a NRRD vector image.");
}

}  // namespace pliant::python
