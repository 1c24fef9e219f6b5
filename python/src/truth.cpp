// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Registration truth: cases and scores.

#include <pliant/data/truth.h>

#include <cmath>
#include <limits>

#include "keywords.h"
#include "made_tissue.h"
#include "volumes.h"

namespace pliant::python {
namespace {

using Points = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// The members are destroyed in reverse order: the maker refers to the scan and the threads.
class PyMaker : public Exclusive {
  public:
    PyMaker(nb::object scan, int threads, const nb::dict& materials, const std::string& model,
            const nb::kwargs& settings)
        : m_scan(std::move(scan)),
          m_arguments(nb::make_tuple(m_scan, threads, materials, model, settings)),
          m_arena(std::make_unique<Arena>(threads)) {
        const Volume& volume = object_in<PyVolume>(m_scan, "scan", "a Volume").volume;
        ChainMailSettings chainmail;
        suit_materials(value_defaults(volume), chainmail);
        const auto chosen = scan_tissue_from(model, materials, volume, std::move(chainmail));
        const auto wanted = settings_from<TruthSettings>(settings, truth_rows());
        m_maker = std::make_unique<TruthMaker>(take(m_arena->run(
            [&] { return TruthMaker::create(volume, chosen, wanted, m_arena->tasks()); })));
    }
    /// @returns a TruthCase
    nb::object make(std::uint64_t seed) const {
        nb::object made = nb::cast(take(m_arena->run([&] { return m_maker->make(seed); })));
        made.attr("_made_of") = nb::make_tuple(m_arguments, seed);
        return made;
    }
    nb::tuple arguments() const { return m_arguments; }

  private:
    nb::object m_scan;
    nb::tuple m_arguments;  ///< of the constructor
    std::unique_ptr<Arena> m_arena;
    std::unique_ptr<TruthMaker> m_maker;
};

nb::dict dict_of(const TruthScore& score) {
    nb::dict dict;
    for (std::size_t r = 0; r < score.rows.size(); ++r) {
        const TruthErrors& e = score.rows[r];
        if (e.count == 0) continue;
        nb::dict row;
        row["count"] = e.count;
        row["mean_mm"] = e.mean_mm;
        row["median_mm"] = e.median_mm;
        row["p95_mm"] = e.p95_mm;
        row["max_mm"] = e.max_mm;
        dict[std::string(name_of(TruthRow(r))).c_str()] = row;
    }
    if (score.folded_share) {
        dict["folded_share"] = *score.folded_share;
        dict["folded_voxels"] = score.folded_voxels;
    }
    return dict;
}

std::vector<Vec3d> points_from(const nb::object& given) {
    const nb::object memory = array_in(given, "points_mm", "float64");
    Points points;
    if (!nb::try_cast<Points>(memory, points) || points.shape(1) != 3)
        raise({ErrorCode::InvalidArgument,
               "points_mm: expected axes (n, 3), found " + shown(memory.attr("shape")),
               "points_mm"});
    std::vector<Vec3d> list(points.shape(0));
    for (std::size_t n = 0; n < list.size(); ++n)
        list[n] = {points.data()[3 * n], points.data()[3 * n + 1], points.data()[3 * n + 2]};
    return list;
}

/// Maps points; those without a counterpart become NaN.
template <class Map>
nb::object mapped(const nb::object& given, const Map& map) {
    std::vector<Vec3d> points = points_from(given);
    {
        const nb::gil_scoped_release without_lock;
        constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
        for (Vec3d& point : points)
            point = is_finite(point) ? map(point).value_or(Vec3d{kNone, kNone, kNone})
                                     : Vec3d{kNone, kNone, kNone};
    }
    return points_of(std::move(points));
}

nb::object landmarks_of(const TruthCase& c, bool is_fixed) {
    std::vector<Vec3d> points;
    for (const TruthLandmark& landmark : c.landmarks)
        points.push_back(is_fixed ? landmark.fixed_mm : landmark.moving_mm);
    return points_of(std::move(points));
}

nb::list motions_of(const TruthCase& c) {
    nb::list list;
    for (const TruthMotion& m : c.motions) {
        nb::dict one;
        one["kind"] = std::string(name_of(m.kind));
        one["point_mm"] = m.point_mm;
        one["motion_mm"] = m.motion_mm;
        one["normal"] = m.normal;
        one["radius_mm"] = m.radius_mm;
        one["length_mm"] = m.length_mm;
        one["depth_mm"] = m.depth_mm;
        one["fraction"] = m.fraction;
        one["moved_elements"] = m.moved_elements;
        list.append(one);
    }
    return list;
}

void bind_case(nb::module_& m) {
    nb::class_<TruthCase>(m, "TruthCase", nb::dynamic_attr(),
                          "A pair of scans whose deformation is known.\n\n"
                          "phi maps points of the fixed image, the scan, to the moving image. Both "
                          "fields are exact at their voxel centres only.")
        .def_ro("seed", &TruthCase::seed, "It makes the same case of the same scan everywhere.")
        .def_ro("hash", &TruthCase::hash, "Of all arrays; equal for any number of threads.")
        .def_ro("inverse_error_mm", &TruthCase::inverse_error_mm,
                "Largest |phi(p + inverse(p)) - p| of the voxels with a counterpart [mm].")
        .def_ro("landmark_error_mm", &TruthCase::landmark_error_mm,
                "Largest |phi^-1(phi(X)) - X| of the landmarks [mm].")
        .def_ro("max_displacement_mm", &TruthCase::max_displacement_mm, "Largest displacement.")
        .def_prop_ro(
            "moving",
            [](const TruthCase& c) {
                return PyVolume{c.moving, {}};
            },
            "The moving image: the scan, deformed.")
        .def_ro("forward", &TruthCase::forward,
                "Field of the fixed image, fixed point to moving point, as registrations find it.")
        .def_ro("inverse", &TruthCase::inverse,
                "Field of the moving image, moving point to fixed point; 0 without a counterpart.")
        .def_prop_ro(
            "labels",
            [](const TruthCase& c) {
                return PyVolume{c.labels, {}};
            },
            "Type of each voxel of the fixed image: 0 air, 1 interior, 2 bone, 3 wall, 4 "
            "interface, 5 cut.")
        .def_prop_ro(
            "fixed_mask",
            [](const TruthCase& c) {
                return PyVolume{c.fixed_mask, {}};
            },
            "Counterparts of the fixed image's voxels: 0 exact, 1 outside, 2 gap, 3 ambiguous, 4 "
            "closed lumen.")
        .def_prop_ro(
            "moving_mask",
            [](const TruthCase& c) {
                return PyVolume{c.moving_mask, {}};
            },
            "Counterparts of the moving image's voxels, likewise.")
        .def_prop_ro(
            "landmarks_fixed_mm", [](const TruthCase& c) { return landmarks_of(c, true); },
            nb::sig("def landmarks_fixed_mm(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Points of the fixed image (n, 3) [mm, LPS].")
        .def_prop_ro(
            "landmarks_moving_mm", [](const TruthCase& c) { return landmarks_of(c, false); },
            nb::sig("def landmarks_moving_mm(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Their counterparts in the moving image.")
        .def_prop_ro(
            "landmark_types",
            [](const TruthCase& c) {
                std::vector<std::string> types;
                for (const TruthLandmark& landmark : c.landmarks)
                    types.emplace_back(name_of(landmark.label));
                return types;
            },
            "Types of the landmarks: \"interior\", \"wall\", \"interface\" or \"cut\".")
        .def_prop_ro("motions", &motions_of,
                     nb::sig("def motions(self, /) -> list[dict[str, typing.Any]]"),
                     "The motions that were carried out, in their order.")
        .def(
            "moving_from_fixed",
            [](const TruthCase& c, const nb::object& points) {
                return mapped(points, [&](Vec3d p) { return c.map->moving_from_fixed(p); });
            },
            nb::arg("points_mm"),
            nb::sig("def moving_from_fixed(self, points_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "phi at points (n, 3) [mm, LPS]; NaN for points without a counterpart.")
        .def(
            "fixed_from_moving",
            [](const TruthCase& c, const nb::object& points) {
                return mapped(points, [&](Vec3d p) { return c.map->fixed_from_moving(p); });
            },
            nb::arg("points_mm"),
            nb::sig("def fixed_from_moving(self, points_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "The inverse of phi at points (n, 3) [mm, LPS]; NaN likewise.")
        .def(
            "__reduce__", [](nb::handle self) { return exchange("reduced_truth")(self); },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def("__repr__", [](const TruthCase& c) {
            return "TruthCase(seed " + std::to_string(c.seed) + ", " +
                   std::to_string(c.motions.size()) + " motions, " +
                   std::to_string(c.landmarks.size()) + " landmarks)";
        });
}

}  // namespace

void bind_truth(nb::module_& m) {
    bind_case(m);
    const Keywords keywords = keywords_of(truth_rows());
    nb::class_<PyMaker>(m, "TruthMaker", "Makes cases of one scan.")
        .def(
            "__init__",
            [](nb::pointer_and_handle<PyMaker> self, const nb::object& scan, int threads,
               const std::optional<nb::dict>& materials, const std::string& model,
               const nb::kwargs& settings) {
                if (!nb::isinstance<PyVolume>(scan))
                    raise({ErrorCode::InvalidArgument,
                           "scan: expected a pliant.Volume, found " +
                               shown(nb::object(nb::borrow(scan.type()))),
                           "scan"});
                new (self.p)
                    PyMaker(scan, threads, materials.value_or(nb::dict()), model, settings);
            },
            nb::arg("scan"), nb::arg("threads") = 0, nb::arg("materials") = nb::none(),
            nb::arg("model") = "chainmail", nb::arg("settings"),
            typed("def __init__(self, scan: Volume, threads: int = 0, "
                  "materials: dict[str, typing.Any] | None = None, "
                  "model: str = \"chainmail\", *, **settings) -> None",
                  keywords),
            described("Args:\n"
                      "    scan: The fixed image.\n"
                      "    threads: 0: one for each core.\n"
                      "    materials: Settings of the tissue, as of make_chainmail or "
                      "make_elastic.\n"
                      "    model: \"chainmail\", or \"elastic\": equilibrium after each motion, "
                      "and no cuts.\n"
                      "    **settings",
                      keywords))
        .def("make", &PyMaker::make, nb::arg("seed"),
             nb::sig("def make(self, seed: int) -> TruthCase"),
             "Makes the case of a seed: the same bits for any number of threads.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                return exchange("reduced_truth_maker")(nb::cast<const PyMaker&>(self).arguments());
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"));
    m.def(
        "score_truth_field",
        [](const TruthCase& c, const VectorField* field, int threads) {
            const Arena arena(threads);
            return dict_of(take(arena.run([&] {
                return field ? score_field(c, *field, arena.tasks())
                             : score_nothing(c, arena.tasks());
            })));
        },
        nb::arg("case"), nb::arg("field").none(), nb::arg("threads") = 0,
        nb::sig("def score_truth_field(case: TruthCase, field: Field | None, threads: int = 0) -> "
                "dict[str, typing.Any]"),
        "Scores a field, fixed point to moving point. Use pliant.truth.score.");
    m.def(
        "score_truth_points",
        [](const TruthCase& c, const nb::object& points) {
            return dict_of(take(score_points(c, points_from(points))));
        },
        nb::arg("case"), nb::arg("points_mm"),
        nb::sig("def score_truth_points(case: TruthCase, points_mm: numpy.typing.ArrayLike) -> "
                "dict[str, typing.Any]"),
        "Scores positions of the landmarks. Use pliant.truth.score.");
}

}  // namespace pliant::python
