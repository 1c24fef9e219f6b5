// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of scans and of tissues. A picture is an array (height, width, 3) of uint8.

#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/view/png.h>
#include <pliant/view/surface_view.h>

#include <limits>

#include "made_tissue.h"
#include "numbers.h"
#include "pickled.h"
#include "pictures.h"
#include "struct_class.h"

namespace pliant::python {

nb::object picture_of(Image image) {
    const std::size_t shape[] = {std::size_t(image.height), std::size_t(image.width), 3};
    return array_owning<std::uint8_t>(std::move(image.pixels), shape);
}

Image image_of(const nb::object& given, const char* name) {
    nb::ndarray<const std::uint8_t, nb::ndim<3>, nb::c_contig, nb::device::cpu> pixels;
    const nb::object memory = nb::module_::import_("numpy").attr("ascontiguousarray")(given);
    if (!nb::try_cast(memory, pixels, false) || pixels.shape(2) != 3 || pixels.size() == 0)
        raise({ErrorCode::InvalidArgument,
               std::string(name) + ": expected axes (height, width, 3) of uint8, found " +
                   shown(memory.attr("shape")) + " of " + shown(memory.attr("dtype")),
               name});
    const auto* const first = reinterpret_cast<const Rgb8*>(pixels.data());
    return {int(pixels.shape(1)),
            int(pixels.shape(0)),
            {first, first + pixels.shape(0) * pixels.shape(1)}};
}

void check_size(int width, int height) {
    constexpr int kMost = 16384;
    const auto check = [](const char* name, int found) {
        const std::string expected = "1 to " + std::to_string(kMost), is = std::to_string(found);
        if (found < 1 || found > kMost)
            raise({ErrorCode::InvalidArgument,
                   std::string(name) + ": expected " + expected + ", found " + is, name, expected,
                   is});
    };
    check("width", width);
    check("height", height);
}

namespace {

using Points = Numbers<double, 3>;

/// Casts rays at a volume, or at the present shape of a tissue, which it follows.
class PyCaster : public Exclusive {
  public:
    PyCaster(const nb::object& scan, int threads) : m_arena(threads), m_tissue(find_tissue(scan)) {
        m_scan = m_tissue ? scan : seen_scan(scan).owner;
        Claim claim;
        if (m_tissue) {
            claim_tissue(m_scan, claim);
            auto live = [&] {
                const nb::gil_scoped_release without_lock;
                return LiveDeformation::create(*m_tissue);
            }();
            m_live.emplace(take(std::move(live)));
        }
        const Volume& volume = m_live ? m_live->volume() : nb::cast<const PyVolume&>(m_scan).volume;
        m_arena.run_reading([&] { return &m_caster.emplace(volume, m_arena.tasks()); });
    }

    nb::object scan() const { return m_scan; }
    int threads() const { return m_arena.threads(); }

    /// Calls work(caster), without the interpreter's lock, with the tissue's present shape.
    template <class Work>
    auto run(const Work& work) {
        Claim claim;
        follow(false, claim);
        return m_arena.run_reading([&] { return work(*m_caster); });
    }

    /// Calls work(caster, endoscope) likewise, with the rest field that the style needs.
    template <class Work>
    auto look(const Endoscope& endoscope, const Work& work) {
        Claim claim;
        follow(endoscope.style == Style::Real, claim);
        Endoscope e = endoscope;
        if (m_rest) e.rest = &*m_rest;
        return m_arena.run_reading([&] { return work(*m_caster, e); });
    }

  private:
    void follow(bool with_rest, Claim& claim) {
        if (!m_tissue) return;
        claim_tissue(m_scan, claim);
        const auto done = [&]() -> Status {
            const nb::gil_scoped_release without_lock;
            const auto update = m_live->update();
            if (!update.ok()) return update.error();
            m_caster->update(update->boxes);
            if (m_rest) {
                if (const auto boxes = m_rest->update(*m_live, update->boxes); !boxes.ok()) {
                    m_rest.reset();
                    return boxes.error();
                }
            } else if (with_rest) {
                if (!m_live->keep_sources(true))
                    return Error{ErrorCode::LimitExceeded,
                                 "the endoscope's view ran out of memory"};
                const auto deformed = deform_volume(*m_tissue, Mapping::Cells, true);
                if (!deformed.ok()) return deformed.error();
                auto rest = RestField::create(*m_tissue, *deformed);
                if (!rest.ok()) return rest.error();
                m_rest.emplace(std::move(rest).value());
            }
            return Ok{};
        }();
        take(done);
    }

    // Destroyed in reverse order: each refers to those above it.
    Arena m_arena;
    nb::object m_scan;
    Tissue* m_tissue;
    std::optional<LiveDeformation> m_live;
    std::optional<RestField> m_rest;
    std::optional<RayCaster> m_caster;
};

void bind_structs(nb::module_& m) {
    using E = Endoscope;
    StructClass<E>(m, "Endoscope",
                   "A pin-hole camera with barrel distortion and a light at the lens.")
        .field<&E::eye_mm>("eye_mm", "Position [mm, LPS].")
        .field<&E::look>("look", "Direction of the view, LPS, of any length > 0.")
        .field<&E::up>("up", "LPS; zero or parallel to look: superior or anterior is used.")
        .field<&E::field_of_view_deg>("field_of_view_deg",
                                      "Across the picture's height, before distortion [degrees].")
        .field<&E::barrel_distortion>("barrel_distortion",
                                      "0: none; r_ray = r (1 + k r^2), r = 1 at the edge.")
        .field<&E::iso_hu>("iso_hu", "Threshold of the surface [HU].")
        .field<&E::polarity>("polarity",
                             "Rising: the wall is brighter than the lumen. Falling: a vessel with "
                             "contrast agent.")
        .field<&E::fog_distance_mm>("fog_distance_mm",
                                    "Light falls to 1/e over this [mm]; 0: no fog.")
        .field<&E::surface>("surface", "Colour of the tissue in full light.")
        .field<&E::fog>("fog", "Colour at infinite distance, and of rays without a hit.")
        .field<&E::style>("style",
                          "Plain: one colour, for measurements. Real: lamps, automatic exposure, "
                          "tissue colours, wet surface; it ignores fog and surface.")
        .field<&E::lining>("lining", "Kind of lumen, for its colours in the style \"real\".")
        .field<&E::field_stop>("field_stop",
                               "Shape of the picture in the style \"real\"; black outside.")
        .done();
    using S = Section;
    StructClass<S>(m, "Section",
                   "A section through a point, perpendicular to a world axis, in the radiological "
                   "convention.")
        .field<&S::orientation>("orientation", "Direction of view.")
        .field<&S::point_mm>("point_mm", "Position of the crosshair [mm, LPS].")
        .field<&S::window_hu>("window_hu", "Width of the range of values that is shown [HU].")
        .field<&S::level_hu>("level_hu", "Middle of that range [HU].")
        .field<&S::width_mm>("width_mm", "Width of the picture [mm]; 0: the whole volume.")
        .field<&S::crosshair>("crosshair", "Whether a crosshair is drawn.")
        .done();
    using T = TransferFunction;
    StructClass<T>(
        m, "TransferFunction",
        "Opacity of a blended view: zero below the window, then rising to its upper end.")
        .field<&T::window_hu>("window_hu", "Width of the window [HU].")
        .field<&T::level_hu>("level_hu", "Middle of the window [HU].")
        .field<&T::opacity_per_mm>("opacity_per_mm", "Extinction at the window's upper end [1/mm].")
        .field<&T::dim>("dim", "Colour at the window's lower end.")
        .field<&T::bright>("bright", "Colour at the window's upper end.")
        .done();
    using F = Fluoroscopy;
    StructClass<F>(
        m, "Fluoroscopy",
        "An X-ray image intensifier: one energy, no scatter. Dense material is dark. The "
        "defaults suit measurements: no noise, no collimator.")
        .field<&F::centre_mm>("centre_mm", "Middle of the picture [mm, LPS].")
        .field<&F::look>("look", "From the source to the detector, LPS, of any length > 0.")
        .field<&F::up>("up", "LPS; zero or parallel to look: superior or anterior is used.")
        .field<&F::source_mm>("source_mm", "From the source to the centre [mm], > 0.")
        .field<&F::width_mm>("width_mm", "Width of the picture at the centre [mm], > 0.")
        .field<&F::water_per_mm>("water_per_mm", "Absorption of water [1/mm].")
        .field<&F::contrast>("contrast", "Factor of the line integral, > 0.")
        .field<&F::exposure_water_mm>("exposure_water_mm",
                                      "Water length at 45 % grey [mm]; None: metered.")
        .field<&F::border_mm>("border_mm",
                              "Distance over which the outermost voxels fade out [mm], >= 0; None: "
                              "a third of the cube root of the scan's volume.")
        .field<&F::field_stop>("field_stop", "The collimator.")
        .field<&F::noise>("noise", "Quantum noise, >= 0; at 1 a standard deviation of 0.05.")
        .field<&F::seed>("seed", "Seed of the noise: a picture's number.")
        .done();
    nb::class_<RayHit>(m, "RayHit", "First intersection of a ray with the surface.")
        .def(Pickled<&RayHit::distance_mm, &RayHit::point_mm, &RayHit::normal>())
        .def_ro("distance_mm", &RayHit::distance_mm, "From the ray's origin [mm].")
        .def_ro("point_mm", &RayHit::point_mm, "Position [mm, LPS].")
        .def_ro("normal", &RayHit::normal, "Unit vector towards the side of the camera, LPS.")
        .def("__repr__", [](const RayHit& h) {
            return "RayHit(distance_mm=" + std::to_string(h.distance_mm) + ")";
        });
}

nb::object first_hits(PyCaster& caster, Vec3d eye_mm, const nb::object& given, double iso_hu,
                      Polarity polarity) {
    const Points directions(given, "directions");
    std::vector<double> distances(directions.rows());
    caster.run([&](const RayCaster& c) {
        c.first_hits(eye_mm, directions.vectors(), iso_hu, polarity, distances);
        // Multiples of the direction's length are millimetres for unit vectors alone.
        for (std::size_t n = 0; n < distances.size(); ++n) {
            const double length = norm(directions.vectors()[n]);
            if (length > 0) distances[n] *= length;
        }
        return true;
    });
    return array_owning<double>(std::move(distances), directions.leading_shape());
}

nb::object endoscope_frame(PyCaster& caster, const Endoscope& e, int width, int height,
                           bool is_smooth) {
    check_size(width, height);
    const std::size_t count = std::size_t(width) * std::size_t(height);
    std::vector<Rgb8> colour(count);
    std::vector<float> depth(count);
    std::vector<Vec3f> normals(count);
    std::vector<Vec3d> points(count);
    caster.look(e, [&](const RayCaster& c, const Endoscope& with_rest) {
        c.endoscope_frame(with_rest, width, height,
                          {.colour = colour,
                           .depth_mm = depth,
                           .normals = normals,
                           .points_mm = points,
                           .is_smooth = is_smooth});
        return true;
    });
    const std::array shape{std::size_t(height), std::size_t(width), std::size_t(3)};
    return nb::make_tuple(array_owning<std::uint8_t>(std::move(colour), shape),
                          array_owning<float>(std::move(depth), std::span(shape).first(2)),
                          array_owning<float>(std::move(normals), shape),
                          array_owning<double>(std::move(points), shape));
}

constexpr const char* kIsoAndPolarity =
    "    iso_hu: Threshold of the surface [HU].\n"
    "    polarity: \"rising\" (the wall is brighter) or \"falling\".\n";

void bind_caster(nb::module_& m) {
    nb::class_<PyCaster>(
        m, "RayCaster",
        "Casts rays at a scan, or at the present shape of a tissue, which it follows.\n\n"
        "The constructor builds the bricks that skip empty space, once for all pictures. One "
        "thread at a "
        "time, that of the tissue.\n\n"
        "Example:\n"
        "    >>> caster = pliant.RayCaster(tissue)\n"
        "    >>> endoscope = pliant.find_endoscope(tissue.scan)\n"
        "    >>> picture = caster.endoscope_view(endoscope, 512, 512)    # (512, 512, 3), uint8\n"
        "    >>> colour, depth_mm, normals, points_mm = caster.endoscope_frame(endoscope)")
        .def(nb::init<const nb::object&, int>(), nb::arg("scan"), nb::arg("threads") = 0,
             nb::sig("def __init__(self, scan: Volume | Tissue, threads: int = 0) -> None"),
             "Args:\n    scan: A Volume or a Tissue, which it keeps.\n"
             "    threads: 0: one for each core; 1: the caller's alone.")
        .def_prop_ro("scan", &PyCaster::scan, nb::sig("def scan(self, /) -> Volume | Tissue"),
                     "The Volume or Tissue at which it casts rays.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                const auto& caster = nb::cast<const PyCaster&>(self);
                return nb::make_tuple(self.type(), nb::make_tuple(caster.scan(), caster.threads()));
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def(
            "endoscope_view",
            [](PyCaster& caster, const Endoscope& endoscope, int width, int height) {
                check_size(width, height);
                return picture_of(
                    caster.look(endoscope, [&](const RayCaster& c, const Endoscope& e) {
                        return c.endoscope_view(e, width, height);
                    }));
            },
            nb::arg("endoscope"), nb::arg("width") = 512, nb::arg("height") = 512,
            nb::sig("def endoscope_view(self, endoscope: Endoscope, width: int = 512, "
                    "height: int = 512) -> numpy.typing.NDArray[numpy.uint8]"),
            "Picture (height, width, 3), rows from the top. In the style \"real\", vessels and "
            "folds move with a tissue, and raw faces of cuts show.")
        .def(
            "endoscope_frame", &endoscope_frame, nb::arg("endoscope"), nb::arg("width") = 512,
            nb::arg("height") = 512, nb::arg("is_smooth") = true,
            nb::sig("def endoscope_frame(self, endoscope: Endoscope, width: int = 512, height: int "
                    "= 512, is_smooth: bool = True) -> tuple[numpy.typing.NDArray[numpy.uint8], "
                    "numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32], "
                    "numpy.typing.NDArray[numpy.float64]]"),
            "The picture with its measurements, those of the rays through the pixels' middles.\n\n"
            "Args:\n    is_smooth: Four rays for each pixel at an edge of the picture.\n\n"
            "Returns:\n"
            "    Colour (height, width, 3); depth along the optical axis (height, width) [mm], 0 "
            "without a wall; unit normals (height, width, 3) in the camera's axes right, down, "
            "ahead; positions on the wall (height, width, 3) [mm, LPS], infinite without one.")
        .def(
            "blended_view",
            [](PyCaster& c, const Endoscope& e, const TransferFunction& t, int width, int height) {
                check_size(width, height);
                return picture_of(
                    c.run([&](const RayCaster& r) { return r.blended_view(e, t, width, height); }));
            },
            nb::arg("endoscope"), nb::arg("transfer"), nb::arg("width") = 512,
            nb::arg("height") = 512,
            nb::sig("def blended_view(self, endoscope: Endoscope, transfer: TransferFunction, "
                    "width: int = 512, height: int = 512) -> numpy.typing.NDArray[numpy.uint8]"),
            "Volume rendering with emission and absorption, (height, width, 3). The endoscope "
            "supplies camera and background.")
        .def(
            "first_hit",
            [](PyCaster& c, Vec3d origin_mm, Vec3d direction, double iso_hu,
               const std::string& polarity) {
                const auto p = choice_of<Polarity>(polarity, "polarity");
                return c.run([&](const RayCaster& r) {
                    return r.first_hit(origin_mm, direction, iso_hu, p);
                });
            },
            nb::arg("origin_mm"), nb::arg("direction"), nb::arg("iso_hu") = -500.0,
            nb::arg("polarity") = "rising",
            (std::string("First crossing of the threshold along a ray, exact for the trilinear "
                         "interpolant.\n\nArgs:\n"
                         "    origin_mm: Start of the ray [mm, LPS].\n"
                         "    direction: LPS, of any length > 0.\n") +
             kIsoAndPolarity + "\nReturns:\n    The RayHit; None without one.")
                .c_str())
        .def(
            "first_hits",
            [](PyCaster& c, Vec3d eye_mm, const nb::object& directions, double iso_hu,
               const std::string& polarity) {
                return first_hits(c, eye_mm, directions, iso_hu,
                                  choice_of<Polarity>(polarity, "polarity"));
            },
            nb::arg("eye_mm"), nb::arg("directions"), nb::arg("iso_hu") = -500.0,
            nb::arg("polarity") = "rising",
            nb::sig("def first_hits(self, eye_mm: collections.abc.Sequence[float] | "
                    "numpy.typing.NDArray[typing.Any], directions: numpy.typing.ArrayLike, iso_hu: "
                    "float = -500.0, polarity: str = \"rising\") -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            (std::string(
                 "Casts many rays from one eye, vectorised.\n\nArgs:\n"
                 "    eye_mm: Start of all rays [mm, LPS].\n"
                 "    directions: (..., 3), LPS, of any length; zero vectors hit nothing.\n") +
             kIsoAndPolarity + "\nReturns:\n    Distances (...) [mm]; infinite without a hit.")
                .c_str())
        .def(
            "pick",
            [](PyCaster& c, const Endoscope& e, int width, int height, double x, double y) {
                check_size(width, height);
                return c.run([&](const RayCaster& r) { return r.pick(e, width, height, x, y); });
            },
            nb::arg("endoscope"), nb::arg("width"), nb::arg("height"), nb::arg("x"), nb::arg("y"),
            "Surface point under a point of the endoscope's picture [pixels, from the top left "
            "corner]; None without one.")
        .def(
            "nearest_surface",
            [](PyCaster& c, Vec3d point_mm, double within_mm, double iso_hu,
               const std::string& polarity) {
                const auto p = choice_of<Polarity>(polarity, "polarity");
                return c.run([&](const RayCaster& r) {
                    return r.nearest_surface(point_mm, within_mm, iso_hu, p);
                });
            },
            nb::arg("point_mm"), nb::arg("within_mm"), nb::arg("iso_hu") = -500.0,
            nb::arg("polarity") = "rising",
            "Point of the surface nearest to a point [mm, LPS], to 0.02 mm or a hundredth of the "
            "distance; None if there is none within that distance.");
}

/// Calls work(volume, arena) without the interpreter's lock; Ctrl-C ends it.
template <class Work>
auto with_scan(const nb::object& scan, int threads, const Work& work) {
    const SeenScan seen = seen_scan(scan);
    const Arena arena(threads);
    const Volume& volume = seen.volume();
    return arena.run_reading([&] { return work(volume, arena.tasks()); });
}

void bind_aims(nb::module_& m) {
    m.def(
        "find_endoscope",
        [](const nb::object& scan, double iso_hu, const std::string& polarity, int threads) {
            const auto p = choice_of<Polarity>(polarity, "polarity");
            return with_scan(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                return find_endoscope(volume, iso_hu, p, arena);
            });
        },
        nb::arg("scan"), nb::arg("iso_hu") = -500.0, nb::arg("polarity") = "rising",
        nb::arg("threads") = 0,
        nb::sig("def find_endoscope(scan: Volume | Tissue, iso_hu: float = -500.0, polarity: str = "
                "\"rising\", threads: int = 0) -> Endoscope | None"),
        (std::string("Suggests a first view: deep inside a lumen, along its longest free path.\n\n"
                     "Args:\n    scan: A Volume, or a Tissue for its present shape.\n") +
         kIsoAndPolarity +
         "\nReturns:\n    None if no voxel is on the lumen's side of the threshold.")
            .c_str());
    m.def(
        "view_of_whole",
        [](const nb::object& scan) {
            return with_scan(scan, 1, [](const Volume& volume, const TaskArena&) {
                return view_of_whole(volume);
            });
        },
        nb::arg("scan"), nb::sig("def view_of_whole(scan: Volume | Tissue) -> Endoscope"),
        "A view of the whole scan from outside, from the front, for scans without a lumen.");
    m.def(
        "find_look",
        [](const nb::object& scan, Vec3d eye_mm, double iso_hu, const std::string& polarity,
           int threads) {
            const auto p = choice_of<Polarity>(polarity, "polarity");
            return with_scan(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                return find_look(volume, eye_mm, iso_hu, p, arena);
            });
        },
        nb::arg("scan"), nb::arg("eye_mm"), nb::arg("iso_hu") = -500.0,
        nb::arg("polarity") = "rising", nb::arg("threads") = 0,
        nb::sig("def find_look(scan: Volume | Tissue, eye_mm: collections.abc.Sequence[float] | "
                "numpy.typing.NDArray[typing.Any], iso_hu: float = -500.0, polarity: str = "
                "\"rising\", threads: int = 0) -> tuple[float, float, float] | None"),
        "Finds the longest free path from an eye [mm, LPS] to a wall: a unit vector, None if no "
        "wall is visible.");
    m.def(
        "aim_endoscope",
        [](const nb::object& scan, Vec3d target_mm, Vec3d push_mm, double iso_hu,
           const std::string& polarity, int threads) {
            const auto p = choice_of<Polarity>(polarity, "polarity");
            return with_scan(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                return aim_endoscope(volume, target_mm, push_mm, iso_hu, p, arena);
            });
        },
        nb::arg("scan"), nb::arg("target_mm"), nb::arg("push_mm") = Vec3d{0, 0, 0},
        nb::arg("iso_hu") = -500.0, nb::arg("polarity") = "rising", nb::arg("threads") = 0,
        nb::sig("def aim_endoscope(scan: Volume | Tissue, target_mm: "
                "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any], push_mm: "
                "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any] = (0, 0, 0), "
                "iso_hu: float = -500.0, polarity: str = \"rising\", threads: int = 0) -> "
                "Endoscope"),
        "Aims a view at a point on the tissue that a push starts from [mm, LPS]: some 15 to 45 mm "
        "away, with a free line of sight, against the push or beside it. A zero push: every side "
        "is allowed.");
    m.def(
        "view_directions",
        [](const Endoscope& e, int width, int height) {
            check_size(width, height);
            auto directions = view_directions(e, width, height);
            return array_owning<double>(
                std::move(directions),
                std::array{std::size_t(height), std::size_t(width), std::size_t(3)});
        },
        nb::arg("endoscope"), nb::arg("width") = 512, nb::arg("height") = 512,
        nb::sig("def view_directions(endoscope: Endoscope, width: int = 512, height: int = 512) -> "
                "numpy.typing.NDArray[numpy.float64]"),
        "Unit directions (height, width, 3) of the rays through the pixels' middles [LPS].");
    m.def(
        "project",
        [](const Endoscope& e, int width, int height, const nb::object& points_mm) {
            check_size(width, height);
            const Points points(points_mm, "points_mm");
            std::vector<double> pixels;
            for (const Vec3d& point : points.vectors()) {
                constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
                const auto found = project(e, width, height, point);
                pixels.push_back(found ? found->x : kNone);
                pixels.push_back(found ? found->y : kNone);
            }
            std::vector<std::size_t> shape = points.leading_shape();
            shape.push_back(2);
            return array_owning<double>(std::move(pixels), shape);
        },
        nb::arg("endoscope"), nb::arg("width"), nb::arg("height"), nb::arg("points_mm"),
        nb::sig("def project(endoscope: Endoscope, width: int, height: int, points_mm: "
                "numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]"),
        "Projects points (..., 3) [mm, LPS] on an endoscope's picture: x and y (..., 2) [pixels, "
        "from the top left corner], not a number beside or behind the eye.");
}

void bind_pictures(nb::module_& m) {
    m.def(
        "section_view",
        [](const nb::object& scan, const Section& section, int width, int height, int threads) {
            check_size(width, height);
            return picture_of(
                with_scan(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                    return section_view(volume, section, width, height, arena);
                }));
        },
        nb::arg("scan"), nb::arg("section"), nb::arg("width") = 512, nb::arg("height") = 512,
        nb::arg("threads") = 0,
        nb::sig("def section_view(scan: Volume | Tissue, section: Section, width: int = 512, "
                "height: int = 512, threads: int = 0) -> numpy.typing.NDArray[numpy.uint8]"),
        "A section (height, width, 3): patient's right on the left, anterior or head up.");
    m.def(
        "four_up_view",
        [](const nb::object& scan, const Endoscope& endoscope,
           const std::optional<Section>& section, int width, int height, const std::string& caption,
           int threads) {
            check_size(width, height);
            Section chosen;
            if (section)
                chosen = *section;
            else
                chosen.point_mm = endoscope.eye_mm;
            const FourUp settings{endoscope, chosen, caption};
            return picture_of(
                with_scan(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                    return four_up_view(volume, settings, width, height, arena);
                }));
        },
        nb::arg("scan"), nb::arg("endoscope"), nb::arg("section") = nb::none(),
        nb::arg("width") = 1024, nb::arg("height") = 1024, nb::arg("caption") = "",
        nb::arg("threads") = 0,
        nb::sig("def four_up_view(scan: Volume | Tissue, endoscope: Endoscope, section: Section | "
                "None = None, width: int = 1024, height: int = 1024, caption: str = \"\", threads: "
                "int = 0) -> numpy.typing.NDArray[numpy.uint8]"),
        "Endoscope (top left), axial (top right), coronal (bottom left), sagittal (bottom right), "
        "with letters, crosshair and captions, (height, width, 3).\n\n"
        "Args:\n"
        "    section: Point, window and level of all three; None: through the eye.\n"
        "    caption: Drawn in the corner.");
    m.def(
        "outline_tool",
        [](const nb::object& picture, const nb::object& scan, const Endoscope& endoscope,
           const Section& section, Vec3d centre_mm, double radius_mm) {
            Image image = image_of(picture, "picture");
            with_scan(scan, 1, [&](const Volume& volume, const TaskArena&) {
                outline_tool(image, volume, {endoscope, section, ""}, centre_mm, radius_mm);
                return true;
            });
            return picture_of(std::move(image));
        },
        nb::arg("picture"), nb::arg("scan"), nb::arg("endoscope"), nb::arg("section"),
        nb::arg("centre_mm"), nb::arg("radius_mm"),
        nb::sig("def outline_tool(picture: numpy.typing.NDArray[numpy.uint8], scan: Volume | "
                "Tissue, endoscope: Endoscope, section: Section, centre_mm: "
                "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any], radius_mm: "
                "float) -> numpy.typing.NDArray[numpy.uint8]"),
        "A picture of four_up_view() with the outline of a spherical tool [mm, LPS]: circles in "
        "the sections, its silhouette in the endoscope's view. Radius 0: a point.");
    m.def(
        "side_by_side",
        [](const nb::object& left, const nb::object& right) {
            const Image a = image_of(left, "left"), b = image_of(right, "right");
            if (a.height != b.height)
                raise({ErrorCode::InvalidArgument,
                       "right: expected a height of " + std::to_string(a.height) + ", found " +
                           std::to_string(b.height),
                       "right", std::to_string(a.height), std::to_string(b.height)});
            return picture_of(side_by_side(a, b));
        },
        nb::arg("left"), nb::arg("right"),
        nb::sig("def side_by_side(left: numpy.typing.NDArray[numpy.uint8], right: "
                "numpy.typing.NDArray[numpy.uint8]) -> numpy.typing.NDArray[numpy.uint8]"),
        "Two pictures of equal height next to each other.");
    m.def(
        "fluoroscopy_view",
        [](const nb::object& scan, const Fluoroscopy& settings, int width, int height,
           int threads) {
            check_size(width, height);
            return picture_of(
                with_scan(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                    return fluoroscopy_view(volume, settings, width, height, arena);
                }));
        },
        nb::arg("scan"), nb::arg("settings"), nb::arg("width") = 512, nb::arg("height") = 512,
        nb::arg("threads") = 0,
        nb::sig("def fluoroscopy_view(scan: Volume | Tissue, settings: Fluoroscopy, width: int = "
                "512, height: int = 512, threads: int = 0) -> numpy.typing.NDArray[numpy.uint8]"),
        "An X-ray picture (height, width, 3).");
    m.def(
        "water_lengths_mm",
        [](const nb::object& scan, const Fluoroscopy& settings, int width, int height,
           int threads) {
            check_size(width, height);
            auto lengths =
                with_scan(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                    return water_lengths_mm(volume, settings, width, height, arena);
                });
            return array_owning<float>(std::move(lengths),
                                       std::array{std::size_t(height), std::size_t(width)});
        },
        nb::arg("scan"), nb::arg("settings"), nb::arg("width") = 512, nb::arg("height") = 512,
        nb::arg("threads") = 0,
        nb::sig("def water_lengths_mm(scan: Volume | Tissue, settings: Fluoroscopy, width: int = "
                "512, height: int = 512, threads: int = 0) -> numpy.typing.NDArray[numpy.float32]"),
        "Integral of max(0, 1 + HU/1000) along the ray of each pixel's middle (height, width) [mm "
        "of water], with the border, without noise or collimator.");
    m.def(
        "write_png",
        [](const std::filesystem::path& path, const nb::object& picture) {
            const Image image = image_of(picture, "picture");
            const auto done = [&] {
                const nb::gil_scoped_release without_lock;
                return write_png(path, image);
            }();
            take(done);
        },
        nb::arg("path"), nb::arg("picture"),
        nb::sig("def write_png(path: str | os.PathLike[str], picture: "
                "numpy.typing.NDArray[numpy.uint8]) -> None"),
        "Writes a picture (height, width, 3). Nothing is half-written.");
}

void bind_paths(nb::module_& m) {
    nb::class_<LumenPath>(m, "LumenPath", "A path along the middle of a lumen.")
        .def_prop_ro(
            "points_mm",
            [](nb::handle self) {
                const auto& points = nb::cast<const LumenPath&>(self).points_mm;
                return viewed_rows(points, self);
            },
            nb::sig("def points_mm(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Points (n, 3) from start to end [mm, LPS], read-only.")
        .def_prop_ro(
            "radius_mm",
            [](nb::handle self) {
                const auto& radius = nb::cast<const LumenPath&>(self).radius_mm;
                return nb::cast(nb::ndarray<nb::numpy, const double, nb::ndim<1>>(
                    radius.data(), {radius.size()}, self));
            },
            nb::sig("def radius_mm(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Distance of each point to the wall (n,) [mm], read-only.")
        .def_ro("length_mm", &LumenPath::length_mm, "Its length [mm].")
        .def("__repr__", [](const LumenPath& p) {
            return "LumenPath(" + std::to_string(p.points_mm.size()) +
                   " points, length_mm=" + std::to_string(p.length_mm) + ")";
        });
    m.def(
        "find_lumen_path",
        [](const nb::object& scan, Vec3d from_mm, Vec3d to_mm, double iso_hu,
           const std::string& polarity, double reach_mm, double spacing_mm, std::int64_t max_voxels,
           int threads) {
            LumenPathSettings settings{.iso_hu = iso_hu,
                                       .polarity = choice_of<Polarity>(polarity, "polarity"),
                                       .reach_mm = reach_mm,
                                       .spacing_mm = spacing_mm,
                                       .max_voxels = max_voxels};
            Interruption interruption;
            settings.give_up = [&] { return interruption.is_there(); };
            auto path = with_scan(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                return find_lumen_path(volume, from_mm, to_mm, settings, arena);
            });
            interruption.raise_if_there();
            return take(std::move(path));
        },
        nb::arg("scan"), nb::arg("from_mm"), nb::arg("to_mm"), nb::arg("iso_hu") = -500.0,
        nb::arg("polarity") = "rising", nb::arg("reach_mm") = 0.0, nb::arg("spacing_mm") = 2.0,
        nb::arg("max_voxels") = std::int64_t(48'000'000), nb::arg("threads") = 0,
        nb::sig("def find_lumen_path(scan: Volume | Tissue, from_mm: "
                "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any], to_mm: "
                "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any], iso_hu: float "
                "= -500.0, polarity: str = \"rising\", reach_mm: float = 0.0, spacing_mm: float = "
                "2.0, max_voxels: int = 48000000, threads: int = 0) -> LumenPath"),
        (std::string(
             "Finds the shortest path that keeps some distance from the walls, then centres "
             "it in the lumen. It needs no segmentation.\n\nArgs:\n"
             "    from_mm, to_mm: Its ends in the lumen [mm, LPS].\n") +
         kIsoAndPolarity +
         "    reach_mm: An end in the tissue is moved into a lumen within this distance.\n"
         "    spacing_mm: Largest distance between the path's points.\n"
         "    max_voxels: Limit of visited voxels; 13 bytes each.\n\n"
         "Raises:\n    pliant.Error: invalid_argument for an end outside of the volume or in the "
         "tissue, not_found if the ends aren't connected, limit_exceeded.")
            .c_str());
}

}  // namespace

void bind_render(nb::module_& m) {
    bind_structs(m);
    bind_caster(m);
    bind_aims(m);
    bind_pictures(m);
    bind_paths(m);
}

}  // namespace pliant::python
