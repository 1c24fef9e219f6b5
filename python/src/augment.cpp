// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Augmentation: the warp that motions make.

#include <pliant/data/warp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>

#include "volumes.h"
#include "warps.h"

namespace pliant::python {
namespace {

using Numbers = nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>;
using Points = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// The grid of with_doubled_slices.
Grid doubled_grid(const Grid& grid) {
    if (std::min({grid.size.x, grid.size.y, grid.size.z}) != 1) return grid;
    const Volume still{grid, VoxelArray<std::int16_t>(voxel_count(grid)), {}};
    return take(with_doubled_slices(still)).grid;
}

/// Calls write(from, to) for a channel, with the slices that the warp has.
template <class T, class Write>
void with_slices_of(const PyWarp& self, std::span<const T> from, std::span<T> to,
                    const Write& write) {
    if (!self.is_doubled()) return write(from, to);
    const Grid& doubled = self.warp.grid();
    const Vec3i last = self.grid.size - Vec3i{1, 1, 1};
    std::vector<T> given(voxel_count(doubled)), made(given.size());
    const auto for_each_voxel = [](const Grid& grid, const auto& visit) {
        for (int k = 0; k < grid.size.z; ++k)
            for (int j = 0; j < grid.size.y; ++j)
                for (int i = 0; i < grid.size.x; ++i) visit(Vec3i{i, j, k});
    };
    for_each_voxel(doubled, [&](Vec3i p) {
        const Vec3i single{std::min(p.x, last.x), std::min(p.y, last.y), std::min(p.z, last.z)};
        given[voxel_index(doubled, p)] = from[voxel_index(self.grid, single)];
    });
    write(std::span<const T>(given), std::span<T>(made));
    for_each_voxel(self.grid,
                   [&](Vec3i p) { to[voxel_index(self.grid, p)] = made[voxel_index(doubled, p)]; });
}

/// A field on the grid of the arrays.
VectorField single_field(const PyWarp& self, VectorField field) {
    if (!self.is_doubled()) return field;
    VectorField single{self.grid, field.kind, std::vector<Vec3f>(voxel_count(self.grid))};
    with_slices_of<Vec3f>(self, single.vectors_mm, single.vectors_mm,
                          [&](std::span<const Vec3f>, std::span<Vec3f> to) {
                              std::copy(field.vectors_mm.begin(), field.vectors_mm.end(),
                                        to.begin());
                          });
    return single;
}

LabelSampling sampling_of(const std::string& name) {
    if (name == "nearest") return LabelSampling::Nearest;
    if (name == "majority") return LabelSampling::Majority;
    raise({ErrorCode::InvalidArgument, "sampling: expected nearest or majority, found " + name,
           "sampling", "nearest or majority", name});
}

/// Calls work(T) with a value of the array's number type.
template <class Work>
void for_type(const Numbers& array, const Work& work) {
    const nb::dlpack::dtype type = array.dtype();
    const auto is = [&]<class T>(T) { return type == nb::dtype<T>(); };
    const auto call = [&]<class T>(T zero) {
        if (!is(zero)) return false;
        work(zero);
        return true;
    };
    const bool is_known = call(std::int8_t{}) || call(std::int16_t{}) || call(std::int32_t{}) ||
                          call(std::int64_t{}) || call(std::uint8_t{}) || call(std::uint16_t{}) ||
                          call(std::uint32_t{}) || call(std::uint64_t{}) || call(float{}) ||
                          call(double{});
    if (!is_known)
        raise({ErrorCode::InvalidArgument,
               "array: expected whole numbers, float32 or float64, found another type", "array"});
}

/// A new array of the same shape and type, of which each channel is written by write(from, to).
template <class Write>
nb::object each_channel(const PyWarp& self, const nb::object& given, const Write& write) {
    const Grid& grid = self.grid;
    const nb::module_ numpy = nb::module_::import_("numpy");
    const nb::object memory = numpy.attr("ascontiguousarray")(given);
    Numbers from;
    const auto fits = [&] {
        const std::size_t n = from.ndim();
        return n >= 3 && from.shape(n - 1) == std::size_t(grid.size.x) &&
               from.shape(n - 2) == std::size_t(grid.size.y) &&
               from.shape(n - 3) == std::size_t(grid.size.z);
    };
    if (!nb::try_cast<Numbers>(memory, from) || !fits()) {
        const std::string expected = "axes (…, " + std::to_string(grid.size.z) + ", " +
                                     std::to_string(grid.size.y) + ", " +
                                     std::to_string(grid.size.x) + ")";
        const std::string found = shown(memory.attr("shape"));
        raise({ErrorCode::InvalidArgument, "array: expected " + expected + ", found " + found,
               "array", expected, found});
    }
    nb::object made = numpy.attr("empty_like")(memory);
    const auto to = nb::cast<nb::ndarray<nb::c_contig, nb::device::cpu>>(made);
    const std::size_t voxels = voxel_count(grid);
    for_type(from, [&]<class T>(T) {
        const auto* const source = static_cast<const T*>(from.data());
        auto* const target = static_cast<T*>(to.data());
        const nb::gil_scoped_release without_lock;
        for (std::size_t first = 0; first < from.size(); first += voxels)
            with_slices_of<T>(self, std::span<const T>(source + first, voxels),
                              std::span<T>(target + first, voxels), write);
    });
    return made;
}

/// A background as a number of any type.
template <class T>
T number(double value) {
    using Limits = std::numeric_limits<T>;
    // The largest numbers of 64 bits round to one more.
    if (std::is_integral_v<T> && value >= double(Limits::max())) return Limits::max();
    if (std::is_integral_v<T> && value <= double(Limits::min())) return Limits::min();
    return T(value);
}

nb::object image(const PyWarp& self, const nb::object& array, double beyond, bool back) {
    const bool is_integer =
        nb::cast<std::string>(
            nb::module_::import_("numpy").attr("asarray")(array).attr("dtype").attr("kind")) != "f";
    if (is_integer && std::isnan(beyond)) raise_value("beyond", "a number", nb::float_(beyond));
    if (!back && !self.warp.has_inverse())
        raise({ErrorCode::InvalidArgument, "warp: expected one with an inverse", "warp"});
    return each_channel(self, array, [&]<class T>(std::span<const T> from, std::span<T> to) {
        if (back)
            self.warp.unwarp_image(from, to, number<T>(beyond));
        else
            self.warp.warp_image(from, to, number<T>(beyond));
    });
}

nb::object labels(const PyWarp& self, const nb::object& array, const std::string& sampling,
                  double beyond, bool back) {
    const LabelSampling how = sampling_of(sampling);
    if (!back && !self.warp.has_inverse())
        raise({ErrorCode::InvalidArgument, "warp: expected one with an inverse", "warp"});
    return each_channel(self, array, [&]<class T>(std::span<const T> from, std::span<T> to) {
        if (back)
            self.warp.unwarp_labels(from, to, how, number<T>(beyond));
        else
            self.warp.warp_labels(from, to, how, number<T>(beyond));
    });
}

nb::object points(const PyWarp& self, const nb::object& given, bool back) {
    const nb::object memory = array_in(given, "points_mm", "float64");
    Points from;
    if (!nb::try_cast<Points>(memory, from) || from.shape(1) != 3)
        raise({ErrorCode::InvalidArgument,
               "points_mm: expected axes (n, 3), found " + shown(memory.attr("shape")),
               "points_mm"});
    std::vector<Vec3d> moved(from.shape(0));
    bool is_found = true;
    for_each_row(moved.size(), [&](std::size_t n) {
        const double* const p = from.data() + 3 * n;
        const Vec3d at{p[0], p[1], p[2]};
        const auto to = back ? self.warp.inverse(at) : self.warp.forward(at);
        is_found &= to.has_value();
        moved[n] = to.value_or(at);
    });
    if (!is_found)
        raise(
            {ErrorCode::InvalidArgument, "points_mm: a point has no unique inverse", "points_mm"});
    return points_of(std::move(moved));
}

/// Elements along the edge of a block of a state.
constexpr int kStateBlock = 8;

Vec3i blocks_of(const Box3i& box) {
    const Vec3i n = box.end - box.begin;
    return {(n.x + kStateBlock - 1) / kStateBlock, (n.y + kStateBlock - 1) / kStateBlock,
            (n.z + kStateBlock - 1) / kStateBlock};
}

/// Calls visit(first of a row in the box's arrays, first in the block, length) for a block.
template <class Visit>
void for_rows_of_block(const Box3i& box, int number, const Visit& visit) {
    const Vec3i n = box.end - box.begin, blocks = blocks_of(box);
    const Vec3i first{kStateBlock * (number % blocks.x),
                      kStateBlock * (number / blocks.x % blocks.y),
                      kStateBlock * (number / (blocks.x * blocks.y))};
    const int length = std::min(kStateBlock, n.x - first.x);
    for (int z = 0; z < std::min(kStateBlock, n.z - first.z); ++z)
        for (int y = 0; y < std::min(kStateBlock, n.y - first.y); ++y)
            visit(std::size_t(first.x) +
                      std::size_t(n.x) *
                          (std::size_t(first.y + y) + std::size_t(n.y) * std::size_t(first.z + z)),
                  std::size_t(kStateBlock * (y + kStateBlock * z)), std::size_t(length));
}

/// (size, spacing, origin, direction, box, numbers of blocks of 8³ elements that move, their
/// displacements (n, 3, 8, 8, 8), has an inverse)
nb::tuple state_of(const PyWarp& self) {
    const WarpState& state = self.warp.state();
    const Grid& g = self.grid;
    const Box3i& box = state.box;
    constexpr std::size_t kElements = kStateBlock * kStateBlock * kStateBlock;
    auto* const numbers = new std::vector<std::int32_t>;
    auto* const kept = new std::vector<std::int32_t>;
    const auto owner = [](auto* memory) {
        return nb::capsule(
            memory, [](void* p) noexcept { delete static_cast<std::vector<std::int32_t>*>(p); });
    };
    const nb::capsule own_numbers = owner(numbers), own_kept = owner(kept);
    if (!state.units.empty()) {
        const nb::gil_scoped_release without_lock;
        const Vec3i blocks = blocks_of(box);
        const std::size_t count = state.units.size() / 3;
        for (int number = 0; number < blocks.x * blocks.y * blocks.z; ++number) {
            bool moves = false;
            for_rows_of_block(box, number, [&](std::size_t from, std::size_t, std::size_t length) {
                for (std::size_t a = 0; a < 3 && !moves; ++a)
                    for (std::size_t i = 0; i < length; ++i)
                        moves |= state.units[a * count + from + i] != 0;
            });
            if (!moves) continue;
            numbers->push_back(number);
            const std::size_t first = kept->size();
            kept->resize(first + 3 * kElements, 0);
            for_rows_of_block(
                box, number, [&](std::size_t from, std::size_t to, std::size_t length) {
                    for (std::size_t a = 0; a < 3; ++a)
                        std::copy_n(state.units.begin() + std::ptrdiff_t(a * count + from), length,
                                    kept->begin() + std::ptrdiff_t(first + a * kElements + to));
                });
        }
    }
    const auto list = nb::cast(nb::ndarray<nb::numpy, std::int32_t, nb::ndim<1>>(
        numbers->data(), {numbers->size()}, own_numbers));
    const auto units = nb::cast(nb::ndarray<nb::numpy, std::int32_t, nb::ndim<5>>(
        kept->data(), {numbers->size(), 3, kStateBlock, kStateBlock, kStateBlock}, own_kept));
    return nb::make_tuple(
        nb::make_tuple(g.size.x, g.size.y, g.size.z), g.spacing_mm, g.origin_mm, direction_of(g),
        nb::make_tuple(box.begin.x, box.begin.y, box.begin.z, box.end.x, box.end.y, box.end.z),
        list, units, self.warp.has_inverse());
}

[[noreturn]] void raise_about_state() {
    raise({ErrorCode::InvalidArgument, "warp: expected the state of another warp", "warp"});
}

PyWarp warp_of(const nb::tuple& state) {
    using List = nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
    using Units = nb::ndarray<const std::int32_t, nb::ndim<5>, nb::c_contig, nb::device::cpu>;
    if (nb::len(state) != 8) raise_about_state();
    std::vector<int> size, box;
    Vec3d spacing_mm, origin_mm;
    bool with_inverse = false;
    List list;
    Units units;
    if (!nb::try_cast(state[0], size) || !nb::try_cast(state[1], spacing_mm) ||
        !nb::try_cast(state[2], origin_mm) || !nb::try_cast(state[7], with_inverse) ||
        !nb::try_cast(state[4], box) || !nb::try_cast(state[5], list) ||
        !nb::try_cast(state[6], units) || size.size() != 3 || box.size() != 6 ||
        units.shape(0) != list.shape(0) || units.shape(1) != 3 ||
        units.size() != 3 * 512 * list.size())
        raise_about_state();
    WarpState made;
    const Grid grid = grid_from({size[0], size[1], size[2]}, spacing_mm, origin_mm,
                                numbers_of(nb::cast<nb::object>(state[3]), "direction"));
    if (!check_grid(grid).ok()) raise_about_state();
    made.grid = doubled_grid(grid);
    made.box = {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
    constexpr double kMostElements = 1e11;  // whose blocks have numbers of 32 bits
    double elements = 1;
    for (int a = 0; a < 3; ++a) {
        const double length = double(made.box.end[a]) - double(made.box.begin[a]);
        if (!(length >= 0 && length <= 100000)) raise_about_state();
        elements *= length;
    }
    if (elements > kMostElements) raise_about_state();
    const Vec3i n = made.box.end - made.box.begin, blocks = blocks_of(made.box);
    const std::size_t count = std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
    made.units.assign(3 * count, 0);
    for (std::size_t m = 0; m < list.size(); ++m) {
        const int number = list.data()[m];
        if (number < 0 || number >= blocks.x * blocks.y * blocks.z) raise_about_state();
        const std::int32_t* const block = units.data() + 3 * 512 * m;
        for_rows_of_block(made.box, number,
                          [&](std::size_t to, std::size_t from, std::size_t length) {
                              for (std::size_t a = 0; a < 3; ++a)
                                  std::copy_n(block + 512 * a + from, length,
                                              made.units.begin() + std::ptrdiff_t(a * count + to));
                          });
    }
    const Arena arena(1);
    return {
        take(arena.run([&] { return Warp::create(std::move(made), arena.tasks(), with_inverse); })),
        grid};
}

void bind_warp(nb::module_& m) {
    nb::class_<PyWarp> c(
        m, "Warp",
        "One map for images, labels and points on a scan's grid, there and back.\n\n"
        "Arrays are (…, k, j, i): any number of channels before the grid's axes. Results are new "
        "arrays of the same shape and type. The interpreter's lock is free meanwhile.");
    c.def(
         "warp_image",
         [](const PyWarp& w, const nb::object& array, double beyond) {
             return image(w, array, beyond, false);
         },
         nb::arg("array"), nb::arg("beyond") = 0.0,
         nb::sig("def warp_image(self, array: numpy.typing.ArrayLike, beyond: float = 0.0) -> "
                 "numpy.typing.NDArray[typing.Any]"),
         "Moves an image: trilinear at the exact inverse.\n\n"
         "Args:\n    beyond: Value outside of the grid.")
        .def(
            "warp_labels",
            [](const PyWarp& w, const nb::object& array, const std::string& sampling,
               double beyond) { return labels(w, array, sampling, beyond, false); },
            nb::arg("array"), nb::arg("sampling") = "nearest", nb::arg("beyond") = 0.0,
            nb::sig("def warp_labels(self, array: numpy.typing.ArrayLike, sampling: str = "
                    "\"nearest\", beyond: float = 0.0) -> numpy.typing.NDArray[typing.Any]"),
            "Moves a label map by the same inverse.\n\n"
            "Args:\n    sampling: \"nearest\", or \"majority\": the label with the largest "
            "trilinear weight.")
        .def(
            "warp_points", [](const PyWarp& w, const nb::object& p) { return points(w, p, false); },
            nb::arg("points_mm"),
            nb::sig("def warp_points(self, points_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "Moves points (n, 3) [mm, LPS].")
        .def(
            "unwarp_image",
            [](const PyWarp& w, const nb::object& array, double beyond) {
                return image(w, array, beyond, true);
            },
            nb::arg("array"), nb::arg("beyond") = 0.0,
            nb::sig("def unwarp_image(self, array: numpy.typing.ArrayLike, beyond: float = 0.0) "
                    "-> numpy.typing.NDArray[typing.Any]"),
            "Takes a moved image, such as a prediction, back to the scan at rest.")
        .def(
            "unwarp_labels",
            [](const PyWarp& w, const nb::object& array, const std::string& sampling,
               double beyond) { return labels(w, array, sampling, beyond, true); },
            nb::arg("array"), nb::arg("sampling") = "nearest", nb::arg("beyond") = 0.0,
            nb::sig("def unwarp_labels(self, array: numpy.typing.ArrayLike, sampling: str = "
                    "\"nearest\", beyond: float = 0.0) -> numpy.typing.NDArray[typing.Any]"),
            "Takes a moved label map back.")
        .def(
            "unwarp_points",
            [](const PyWarp& w, const nb::object& p) { return points(w, p, true); },
            nb::arg("points_mm"),
            nb::sig("def unwarp_points(self, points_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "Takes moved points back.")
        .def(
            "forward_field",
            [](const PyWarp& w) { return single_field(w, take(w.warp.forward_field())); },
            "The displacement field, at rest voxel centres.")
        .def(
            "inverse_field",
            [](const PyWarp& w) {
                if (!w.warp.has_inverse())
                    raise(
                        {ErrorCode::InvalidArgument, "warp: expected one with an inverse", "warp"});
                return single_field(w, take(w.warp.inverse_field()));
            },
            "Its inverse, for resampling filters.")
        .def_prop_ro(
            "smallest_jacobian",
            [](const PyWarp& w) {
                const nb::gil_scoped_release without_lock;
                return w.warp.smallest_jacobian();
            },
            "Smallest determinant at the corners of all cells; above 0: nothing is folded.")
        .def_prop_ro(
            "moved_voxels", [](const PyWarp& w) { return w.warp.moved_elements(); },
            "Voxels away from their rest position, those beyond the grid included.")
        .def(
            "__init__",
            [](PyWarp* self, const nb::tuple& state) { new (self) PyWarp(warp_of(state)); },
            nb::arg("state"), nb::sig("def __init__(self, state: tuple[typing.Any, ...]) -> None"),
            "Of another warp's state.")
        .def_prop_ro("state", &state_of, nb::sig("def state(self, /) -> tuple[typing.Any, ...]"),
                     "Grid and displacements: numbers and arrays that give the same warp again.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                return nb::make_tuple(self.attr("__class__"), nb::make_tuple(self.attr("state")));
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def(
            "__deepcopy__", [](nb::handle self, nb::handle) { return nb::borrow(self); },
            nb::arg("memo"), nb::sig("def __deepcopy__(self, memo: typing.Any) -> Warp"),
            "The same: a warp doesn't change.")
        .def("__repr__", [](const PyWarp& w) {
            return "Warp(" + std::to_string(w.warp.moved_elements()) + " voxels moved)";
        });
    bind_grid(c, [](const PyWarp& w) -> const Grid& { return w.grid; });
}

}  // namespace

void bind_augment(nb::module_& m) {
    bind_warp(m);
    bind_prepared_scan(m);
}

}  // namespace pliant::python
