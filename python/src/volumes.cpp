// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans. Arrays are (k, j, i), as SimpleITK's: the last index runs along i.

#include "volumes.h"

#include <pliant/data/scan_values.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <array>

namespace pliant::python {
namespace {

using Numbers = nb::ndarray<nb::ro, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

/// The array in a type that volumes have, without a copy if it has one already.
nb::object stored(const nb::object& given) {
    const nb::module_ numpy = nb::module_::import_("numpy");
    const nb::object array = numpy.attr("asanyarray")(given);
    const std::string kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
    const auto bytes = nb::cast<int>(array.attr("dtype").attr("itemsize"));
    const auto ndim = nb::cast<int>(array.attr("ndim"));
    if (ndim != 3 || kind.find_first_of("biuf") == std::string::npos)
        raise({ErrorCode::InvalidArgument,
               "array: expected three axes (k, j, i) of real numbers, found " +
                   std::to_string(ndim) + " axes of " + shown(array.attr("dtype")),
               "array"});
    const char* type = "float32";
    if (kind != "f" && (bytes == 1 || (kind == "i" && bytes == 2))) {
        type = "int16";
    } else if (kind != "f" && nb::cast<std::int64_t>(array.attr("size")) > 0) {
        // As doubles: whole numbers of 16 bits are exact there, and larger ones stay larger.
        const auto least = nb::cast<double>(nb::float_(array.attr("min")()));
        const auto most = nb::cast<double>(nb::float_(array.attr("max")()));
        if (least >= -32768 && most <= 32767) type = "int16";
    }
    return array_in(array, "array", type, true);
}

template <class T>
VoxelArray<T> viewed(const Numbers& array) {
    return VoxelArray<T>::viewed(
        std::span<const T>(static_cast<const T*>(array.data()), array.size()));
}

PyVolume volume_of(const nb::object& array, Vec3d spacing_mm, Vec3d origin_mm,
                   const std::vector<double>& direction, std::optional<double> background,
                   bool straighten = false) {
    const nb::object memory = stored(array);
    const auto numbers = nb::cast<Numbers>(memory);
    const auto length = [&](std::size_t axis) {
        return int(std::min<std::size_t>(numbers.shape(axis), 1u << 20));
    };
    const Grid grid =
        grid_from({length(2), length(1), length(0)}, spacing_mm, origin_mm, direction);
    // A view's owner may be known to its own Python object alone.
    const bool is_view =
        nb::cast<bool>(nb::module_::import_("numpy").attr("may_share_memory")(array, memory));
    PyVolume made{{grid, {}, {}}, is_view ? nb::make_tuple(array, memory) : memory};
    if (numbers.dtype() == nb::dtype<std::int16_t>())
        made.volume.voxels = viewed<std::int16_t>(numbers);
    else
        made.volume.voxels = viewed<float>(numbers);
    if (straighten)
        made.volume = take_until_interrupted([&](const std::function<bool()>& give_up) {
            return straightened(made.volume, "array", give_up);
        });
    take(check_volume(made.volume, "array"));
    made.volume.background =
        float(background ? *background : value_defaults(made.volume).background);
    return made;
}

nb::object voxels_of(nb::handle self) {
    const Volume& volume = nb::cast<const PyVolume&>(self).volume;
    const auto array = [&](const auto* data) {
        using T = std::remove_cv_t<std::remove_pointer_t<decltype(data)>>;
        const Vec3i n = volume.grid.size;
        return nb::cast(nb::ndarray<nb::numpy, const T, nb::ndim<3>>(
            data, {std::size_t(n.z), std::size_t(n.y), std::size_t(n.x)}, self));
    };
    if (volume.is_16_bit()) return array(std::get_if<0>(&volume.voxels)->data());
    return array(std::get_if<1>(&volume.voxels)->data());
}

std::string text_of(const PyVolume& v) {
    const Grid& g = v.volume.grid;
    const auto number = [](double x) {
        std::string text = std::to_string(x);
        text.erase(text.find_last_not_of('0') + 1);
        if (text.ends_with('.')) text.pop_back();
        return text;
    };
    return "Volume(" + std::to_string(g.size.x) + " x " + std::to_string(g.size.y) + " x " +
           std::to_string(g.size.z) + " voxels of " + number(g.spacing_mm.x) + " x " +
           number(g.spacing_mm.y) + " x " + number(g.spacing_mm.z) + " mm, " +
           (v.volume.is_16_bit() ? "int16" : "float32") + ")";
}

PyVolume read(const std::filesystem::path& path, const std::string& series_uid,
              std::optional<std::int64_t> frame, bool straighten, std::optional<Vec3d> spacing_mm) {
    ReadOptions options{.series_uid = series_uid,
                        .frame = frame,
                        .straighten = straighten,
                        .spacing_mm = spacing_mm};
    return {take_until_interrupted([&](const std::function<bool()>& give_up) {
                options.give_up = give_up;
                ReadNotes notes;
                auto found = read_volume(path, options, &notes);
                if (found.ok()) found->background = float(value_defaults(*found, notes).background);
                return found;
            }),
            {}};
}

PyVolume phantom(const std::string& name, std::optional<std::vector<int>> size, Vec3d spacing_mm,
                 int threads) {
    PhantomSettings settings{.name = name, .spacing_mm = spacing_mm};
    if (size) {
        if (size->size() != 3)
            raise({ErrorCode::InvalidArgument,
                   "size: expected three numbers, found " + std::to_string(size->size()), "size"});
        settings.size = {(*size)[0], (*size)[1], (*size)[2]};
    }
    const Arena arena(threads);
    return {take(arena.run_reading([&] { return make_phantom(settings, arena.tasks()); })).volume,
            {}};
}

/// A text of a file; bytes that aren't UTF-8 are replaced.
nb::object text_in(const std::string& text) {
    return nb::steal(PyUnicode_DecodeUTF8(text.data(), Py_ssize_t(text.size()), "replace"));
}

nb::list series_of(const std::filesystem::path& folder) {
    auto found = [&] {
        const nb::gil_scoped_release without_lock;
        return list_series(folder);
    }();
    nb::list rows;
    for (const DicomSeries& series : take(std::move(found))) {
        nb::dict row;
        row["number"] = text_in(series.number);
        row["description"] = text_in(series.description);
        row["modality"] = text_in(series.modality);
        row["slices"] = series.slices;
        row["volumes"] = series.volumes;
        row["size"] = nb::make_tuple(series.size.x, series.size.y, series.size.z);
        row["spacing_mm"] = series.spacing_mm;
        row["uid"] = text_in(series.uid);
        if (!series.fault.empty()) row["fault"] = text_in(series.fault);
        rows.append(row);
    }
    return rows;
}

}  // namespace

Grid grid_from(Vec3i size, Vec3d spacing_mm, Vec3d origin_mm,
               const std::vector<double>& direction) {
    Grid grid{size, spacing_mm, origin_mm, kIdentity3};
    if (direction.empty()) return grid;
    if (direction.size() != 9)
        raise(
            {ErrorCode::InvalidArgument,
             "direction: expected nine numbers, by rows, found " + std::to_string(direction.size()),
             "direction", "nine numbers, by rows", std::to_string(direction.size())});
    for (std::size_t n = 0; n < 9; ++n) grid.direction.columns[n % 3][int(n / 3)] = direction[n];
    return grid;
}

nb::object direction_of(const Grid& grid) {
    auto* const numbers = new std::array<double, 9>;
    for (std::size_t n = 0; n < 9; ++n) (*numbers)[n] = grid.direction.columns[n % 3][int(n / 3)];
    const nb::capsule owner(
        numbers, [](void* p) noexcept { delete static_cast<std::array<double, 9>*>(p); });
    return nb::cast(
        nb::ndarray<nb::numpy, double, nb::shape<3, 3>>(numbers->data(), {3, 3}, owner));
}

nb::object array_of(const float* data, const Grid& grid, bool is_vector, nb::handle owner) {
    std::vector<std::size_t> shape{std::size_t(grid.size.z), std::size_t(grid.size.y),
                                   std::size_t(grid.size.x)};
    if (is_vector) shape.push_back(3);
    return nb::cast(nb::ndarray<nb::numpy, const float>(data, shape.size(), shape.data(), owner));
}

void bind_volumes(nb::module_& m) {
    nb::class_<PyVolume> c(m, "Volume",
                           "A scan: values on a grid in the world [mm, LPS].\n\n"
                           "Arrays are (k, j, i), as SimpleITK's. int16 and float32 in C order are "
                           "viewed without a copy, and must then not be changed while a tissue "
                           "uses them; other types are converted.");
    c.def(
         "__init__",
         [](PyVolume* self, const nb::object& array, Vec3d spacing_mm, Vec3d origin_mm,
            const std::optional<nb::object>& direction, std::optional<double> background) {
             new (self) PyVolume(volume_of(array, spacing_mm, origin_mm,
                                           numbers_of(direction, "direction"), background));
         },
         nb::arg("array"), nb::arg("spacing_mm") = Vec3d{1, 1, 1},
         nb::arg("origin_mm") = Vec3d{0, 0, 0}, nb::arg("direction") = nb::none(),
         nb::arg("background") = nb::none(),
         nb::sig("def __init__(self, array: numpy.typing.ArrayLike, "
                 "spacing_mm: collections.abc.Sequence[float] | "
                 "numpy.typing.NDArray[typing.Any] = (1, 1, 1), "
                 "origin_mm: collections.abc.Sequence[float] | "
                 "numpy.typing.NDArray[typing.Any] = (0, 0, 0), "
                 "direction: numpy.typing.ArrayLike | None = None, "
                 "background: float | None = None) -> None"),
         "Args:\n"
         "    array: Values (k, j, i).\n"
         "    spacing_mm: Distances of voxel centres along i, j, k.\n"
         "    origin_mm: Centre of voxel (0, 0, 0), LPS.\n"
         "    direction: Nine numbers by rows, or a 3 x 3 matrix; its columns are the axes.\n"
         "    background: Value beyond the scan and in gaps; None: air of CT, else the lowest.")
        .def_prop_ro(
            "array", [](nb::handle self) { return voxels_of(self); },
            nb::sig("def array(self, /) -> numpy.typing.NDArray[typing.Any]"),
            "The values (k, j, i), read-only, without a copy.")
        .def_prop_ro(
            "background", [](const PyVolume& v) { return double(v.volume.background); },
            "Value beyond the scan and in gaps.")
        .def_prop_ro(
            "key_values",
            [](const PyVolume& v) {
                nb::dict pairs;
                for (const auto& [key, value] : v.volume.key_values)
                    pairs[text_in(key)] = text_in(value);
                return pairs;
            },
            nb::sig("def key_values(self, /) -> dict[str, str]"), "Those of the file.")
        .def("__repr__", &text_of)
        .def(
            "save",
            [](const PyVolume& v, const std::filesystem::path& path, bool compress) {
                take_until_interrupted([&](const std::function<bool()>& give_up) {
                    const Encoding encoding = compress ? Encoding::Gzip : Encoding::Raw;
                    return write_volume(path, v.volume, encoding, give_up);
                });
            },
            nb::arg("path"), nb::arg("compress") = true,
            "Writes .nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz or .vti. Nothing is half-written.");
    c.def_static(
         "from_sitk", [](const nb::object& image) { return exchange("volume_from_sitk")(image); },
         nb::arg("image"), nb::sig("def from_sitk(image: typing.Any) -> Volume"),
         "Of a SimpleITK image: viewed if its values are int16 or float32.")
        .def_static(
            "from_nibabel",
            [](const nb::object& image, bool straighten) {
                return exchange("volume_from_nibabel")(image, straighten);
            },
            nb::arg("image"), nb::arg("straighten") = false,
            nb::sig("def from_nibabel(image: typing.Any, straighten: bool = False) -> Volume"),
            "Of a NiBabel image; RAS becomes LPS.\n\n"
            "Args:\n"
            "    straighten: Resamples (trilinear) an image of sheared axes, as read_volume does.")
        .def(
            "to_sitk", [](nb::handle self) { return exchange("volume_to_sitk")(self); },
            nb::sig("def to_sitk(self) -> typing.Any"), "A SimpleITK image with a copy.")
        .def(
            "to_nibabel", [](nb::handle self) { return exchange("volume_to_nibabel")(self); },
            nb::sig("def to_nibabel(self) -> typing.Any"), "A NiBabel image that views the values.")
        .def(
            "__array__",
            [](nb::handle self, const nb::object& dtype, const nb::object& copy) {
                return exchange("array_of")(self, dtype, copy);
            },
            nb::arg("dtype") = nb::none(), nb::arg("copy") = nb::none(),
            nb::sig("def __array__(self, dtype: typing.Any = None, copy: bool | None = None) -> "
                    "numpy.typing.NDArray[typing.Any]"))
        .def(
            "__dlpack__",
            [](nb::handle self, const nb::kwargs& options) {
                return exchange("dlpack_of")(self, options);
            },
            nb::sig("def __dlpack__(self, **options: typing.Any) -> typing.Any"))
        .def(
            "__dlpack_device__", [](nb::handle) { return nb::make_tuple(1, 0); },
            nb::sig("def __dlpack_device__(self) -> tuple[int, int]"))
        .def(
            "__reduce__", [](nb::handle self) { return exchange("reduced_volume")(self); },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"));
    bind_grid(c, [](const PyVolume& v) -> const Grid& { return v.volume.grid; });
    m.def(
        "read_volume", &read, nb::arg("path"), nb::arg("series_uid") = "",
        nb::arg("frame") = nb::none(), nb::arg("straighten") = false,
        nb::arg("spacing_mm") = nb::none(),
        "Reads NRRD, MetaImage, NIfTI, VTI, VTK structured points, or DICOM.\n\n"
        "Args:\n"
        "    series_uid: DICOM series by its UID, number or a part of its description; empty:\n"
        "        the only one.\n"
        "    frame: Image of a 4-D file, from 0.\n"
        "    straighten: Resamples tilted or unequally spaced slices to a regular grid.\n"
        "    spacing_mm: Voxels of DICOM images without positions, which are then stacked in the\n"
        "        order of their numbers.");
    m.def("list_series", &series_of, nb::arg("folder"),
          nb::sig("def list_series(folder: str | os.PathLike[str]) -> "
                  "list[dict[str, typing.Any]]"),
          "DICOM series of a folder, or of that of a DICOMDIR; their pixels are not read.\n\n"
          "Returns:\n"
          "    For each, as `pliant info FOLDER --json`: number, description, modality, slices,\n"
          "    volumes, size (i, j, k), spacing_mm, uid, and fault if it can't be read.");
    m.def(
        "straightened_volume",
        [](const nb::object& array, Vec3d spacing_mm, Vec3d origin_mm,
           const nb::object& direction) {
            return volume_of(array, spacing_mm, origin_mm, numbers_of(direction, "direction"),
                             std::nullopt, true);
        },
        nb::arg("array"), nb::arg("spacing_mm"), nb::arg("origin_mm"), nb::arg("direction"),
        nb::sig("def straightened_volume(array: numpy.typing.ArrayLike, "
                "spacing_mm: collections.abc.Sequence[float], "
                "origin_mm: collections.abc.Sequence[float], "
                "direction: numpy.typing.ArrayLike) -> Volume"),
        "A volume whose axes may be sheared, resampled to perpendicular ones.");
    m.def("make_phantom", &phantom, nb::arg("name"), nb::arg("size") = nb::none(),
          nb::arg("spacing_mm") = Vec3d{0, 0, 0}, nb::arg("threads") = 0,
          "A test scan from analytic shapes, in HU, identical on every machine.\n\n"
          "Args:\n"
          "    name: \"airway\", \"knee\", \"layers\", …\n"
          "    size: Voxels along i, j, k; 128 by default.\n"
          "    spacing_mm: Zero: the phantom's extent divided by the size.");
}

}  // namespace pliant::python
