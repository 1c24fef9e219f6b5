// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Endoscopes for training, many in one scan, and paths in lumina.

#include <pliant/data/gym.h>

#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <array>
#include <optional>
#include <tuple>

#include "keywords.h"
#include "made_tissue.h"
#include "volumes.h"

namespace pliant::python {
namespace {

using Actions = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<const std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// The value of a name among choices.
template <class T, std::size_t kCount>
T choice(const char* field, const std::string& name,
         const std::array<std::pair<const char*, T>, kCount>& choices) {
    std::string all;
    for (const auto& [key, value] : choices) {
        if (name == key) return value;
        all += (all.empty() ? "" : ", ") + std::string(key);
    }
    raise({ErrorCode::InvalidArgument,
           std::string(field) + ": expected one of " + all + ", found " + name, field,
           "one of " + all, name});
}

Polarity polarity_of(const std::string& name) {
    return choice<Polarity, 2>("polarity", name,
                               {{{"rising", Polarity::Rising}, {"falling", Polarity::Falling}}});
}

/// The members are destroyed in reverse order: each refers to those above it.
class PyArena : public Exclusive {
  public:
    /// @param made_of  all arguments of the constructor, for copies
    PyArena(nb::object scan, EndoscopeArenaSettings settings, int threads, nb::tuple made_of)
        : m_scan(std::move(scan)),
          m_made_of(std::move(made_of)),
          m_threads(std::make_unique<Arena>(threads)) {
        const Volume& volume = object_in<PyVolume>(m_scan, "scan", "a Volume").volume;
        m_arena = take(m_threads->run(
            [&] { return EndoscopeArena::create(volume, settings, m_threads->tasks()); }));
    }

    EndoscopeArena& arena() const { return *m_arena; }
    int threads() const { return m_threads->threads(); }
    nb::object scan() const { return m_scan; }
    nb::tuple made_of() const { return m_made_of; }
    void check(int n) const {
        if (n >= 0 && n < m_arena->count()) return;
        raise({ErrorCode::InvalidArgument,
               "endoscope: expected 0 to " + std::to_string(m_arena->count() - 1) + ", found " +
                   std::to_string(n),
               "endoscope"});
    }

    /// Without a look at Ctrl-C in it: a step takes milliseconds.
    void step(const nb::object& given, const nb::object& moves) const {
        const nb::object memory = array_in(given, "actions", "float64");
        Actions actions;
        if (!nb::try_cast<Actions>(memory, actions) || actions.shape(1) != 4 ||
            actions.shape(0) != std::size_t(m_arena->count()))
            raise({ErrorCode::InvalidArgument,
                   "actions: expected axes (" + std::to_string(m_arena->count()) + ", 4), found " +
                       shown(memory.attr("shape")),
                   "actions"});
        Flags flags;
        nb::object flag_memory;
        std::span<const std::uint8_t> asked;
        if (!moves.is_none()) {
            flag_memory = array_in(moves, "moves", "uint8");
            if (!nb::try_cast<Flags>(flag_memory, flags))
                raise({ErrorCode::InvalidArgument, "moves: expected one axis", "moves"});
            asked = {flags.data(), flags.shape(0)};
        }
        const Status done = [&] {
            const nb::gil_scoped_release without_lock;
            return m_arena->step({actions.data(), actions.size()}, asked);
        }();
        take(done);
    }

  private:
    nb::object m_scan;
    nb::tuple m_made_of;
    std::unique_ptr<Arena> m_threads;
    std::unique_ptr<EndoscopeArena> m_arena;
};

/// A read-only array of pictures, with the endoscopes as first axis; None without any.
template <class T, class Value>
nb::object pictures_of(nb::handle self, std::span<const Value> values, std::size_t channels) {
    if (values.empty()) return nb::none();
    const EndoscopeArenaSettings& s = nb::cast<const PyArena&>(self).arena().settings();
    const std::size_t shape[] = {std::size_t(s.count), std::size_t(s.height), std::size_t(s.width),
                                 channels};
    return nb::cast(nb::ndarray<nb::numpy, const T>(reinterpret_cast<const T*>(values.data()),
                                                    channels > 1 ? 4 : 3, shape, self));
}

EndoscopePose pose_of(Vec3d eye_mm, Vec3d look, const std::optional<Vec3d>& up) {
    return {eye_mm, look, up.value_or(Vec3d{0, 0, 0})};
}

void bind_pictures(nb::class_<PyArena>& c) {
    c.def_prop_ro(
         "colour",
         [](nb::handle self) {
             return pictures_of<std::uint8_t>(
                 self, nb::cast<const PyArena&>(self).arena().pictures().colour, 3);
         },
         nb::sig("def colour(self, /) -> numpy.typing.NDArray[numpy.uint8]"),
         "sRGB (n, h, w, 3). This and the other pictures are views that the next step overwrites; "
         "None if they aren't made.")
        .def_prop_ro(
            "depth_mm",
            [](nb::handle self) {
                return pictures_of<float>(
                    self, nb::cast<const PyArena&>(self).arena().pictures().depth_mm, 1);
            },
            nb::sig("def depth_mm(self, /) -> numpy.typing.NDArray[numpy.float32]"),
            "Depth along the optical axis (n, h, w) [mm]; 0: no wall.")
        .def_prop_ro(
            "normals",
            [](nb::handle self) {
                return pictures_of<float>(
                    self, nb::cast<const PyArena&>(self).arena().pictures().normals, 3);
            },
            nb::sig("def normals(self, /) -> numpy.typing.NDArray[numpy.float32]"),
            "Normals (n, h, w, 3) in the camera's axes: right, down, ahead; 0: no wall.")
        .def_prop_ro(
            "flow",
            [](nb::handle self) {
                return pictures_of<float>(
                    self, nb::cast<const PyArena&>(self).arena().pictures().flow, 2);
            },
            nb::sig("def flow(self, /) -> numpy.typing.NDArray[numpy.float32]"),
            "For the pixels of the picture before the last step: where their tissue is now (n, h, "
            "w, 2) [pixels to the right, down].")
        .def_prop_ro(
            "visibility",
            [](nb::handle self) {
                return pictures_of<std::uint8_t>(
                    self, nb::cast<const PyArena&>(self).arena().pictures().visibility, 1);
            },
            nb::sig("def visibility(self, /) -> numpy.typing.NDArray[numpy.uint8]"),
            "Likewise (n, h, w): 0 no wall, 1 seen now, 2 hidden now, 3 outside of the picture "
            "now.")
        .def_prop_ro(
            "scene_flow_mm",
            [](nb::handle self) {
                return pictures_of<float>(
                    self, nb::cast<const PyArena&>(self).arena().pictures().scene_flow_mm, 3);
            },
            nb::sig("def scene_flow_mm(self, /) -> numpy.typing.NDArray[numpy.float32]"),
            "Likewise: motion of the tissue (n, h, w, 3) [mm, LPS].")
        .def_prop_ro(
            "labels",
            [](nb::handle self) {
                return pictures_of<std::int16_t>(
                    self, nb::cast<const PyArena&>(self).arena().pictures().labels, 1);
            },
            nb::sig("def labels(self, /) -> numpy.typing.NDArray[numpy.int16] | None"),
            "Labels of the present picture's tissue (n, h, w).");
}

void make_arena(nb::pointer_and_handle<PyArena> self, const nb::object& scan, int count,
                std::pair<int, int> size, double control_hz, const std::string& wall,
                double radius_mm, int relax_sweeps, int relax_every, double young_modulus_pa,
                double iso_hu, const std::string& polarity, double field_of_view_deg,
                double barrel_distortion, const std::string& style, const std::string& lining,
                const std::string& field_stop, bool is_smooth,
                const std::vector<std::string>& pictures, const std::optional<nb::object>& labels,
                int threads, const std::string& model, const nb::kwargs& materials) {
    EndoscopeArenaSettings s;
    s.count = count;
    s.width = size.first;
    s.height = size.second;
    s.control_hz = control_hz;
    s.deforms = choice<bool, 2>("wall", wall, {{{"deforming", true}, {"rigid", false}}});
    s.radius_mm = radius_mm;
    s.relax_sweeps = relax_sweeps;
    s.relax_every = relax_every;
    s.young_modulus_pa = young_modulus_pa;
    s.iso_hu = iso_hu;
    s.polarity = polarity_of(polarity);
    s.field_of_view_deg = field_of_view_deg;
    s.barrel_distortion = barrel_distortion;
    s.style = choice<Style, 2>("style", style, {{{"plain", Style::Plain}, {"real", Style::Real}}});
    s.lining = choice<Lining, 4>("lining", lining,
                                 {{{"airway", Lining::Airway},
                                   {"colon", Lining::Colon},
                                   {"sinus", Lining::Sinus},
                                   {"vessel", Lining::Vessel}}});
    s.field_stop = choice<FieldStop, 3>("field_stop", field_stop,
                                        {{{"round", FieldStop::Round},
                                          {"octagon", FieldStop::Octagon},
                                          {"full", FieldStop::Full}}});
    s.is_smooth = is_smooth;
    s.has_colour = s.has_depth = false;
    for (const std::string& name : pictures) {
        bool EndoscopeArenaSettings::*const has = choice<bool EndoscopeArenaSettings::*, 4>(
            "pictures", name,
            {{{"rgb", &EndoscopeArenaSettings::has_colour},
              {"depth", &EndoscopeArenaSettings::has_depth},
              {"normals", &EndoscopeArenaSettings::has_normals},
              {"flow", &EndoscopeArenaSettings::has_flow}}});
        s.*has = true;
    }
    if (labels) {
        s.labels = std::make_shared<const Volume>(
            object_in<PyVolume>(*labels, "labels", "a Volume").volume);
    }
    s.materials =
        scan_tissue_from(model, materials, object_in<PyVolume>(scan, "scan", "a Volume").volume);
    const nb::tuple made_of = nb::make_tuple(
        nb::make_tuple(scan, count, size, control_hz, wall, radius_mm, relax_sweeps, relax_every,
                       young_modulus_pa, iso_hu, polarity, field_of_view_deg, barrel_distortion,
                       style, lining, field_stop, is_smooth, pictures, labels, threads, model),
        materials);
    new (self.p) PyArena(scan, s, threads, made_of);
}

nb::object states_of(const PyArena& a) {
    constexpr std::size_t kColumns = 16;
    const auto count = std::size_t(a.arena().count());
    auto* const rows = new std::vector<double>;
    const nb::capsule owner(rows,
                            [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
    for (std::size_t n = 0; n < count; ++n) {
        const EndoscopeState& s = a.arena().state(int(n));
        for (const Vec3d& v : {s.pose.eye_mm, s.pose.look, s.pose.up, s.force_n})
            rows->insert(rows->end(), {v.x, v.y, v.z});
        rows->insert(rows->end(), {s.max_displacement_mm, double(s.is_touching),
                                   double(s.is_stopped), double(s.steps)});
    }
    return nb::cast(nb::ndarray<nb::numpy, double, nb::shape<-1, kColumns>>(
        rows->data(), {count, kColumns}, owner));
}

void bind_arena(nb::module_& m) {
    const Keywords keywords = scan_tissue_keywords();
    nb::class_<PyArena> c(
        m, "EndoscopeArena",
        "Many endoscopes in one scan, each with a tissue of its own; all move in one call.\n\n"
        "The same actions from the same poses give the same bits for any number of threads.");
    c.def("__init__", &make_arena, nb::arg("scan"), nb::arg("count") = 1,
          nb::arg("size") = std::pair<int, int>{64, 64}, nb::arg("control_hz") = 20.0,
          nb::arg("wall") = "deforming", nb::arg("radius_mm") = 1.4, nb::arg("relax_sweeps") = 1,
          nb::arg("relax_every") = 1, nb::arg("young_modulus_pa") = 15e3,
          nb::arg("iso_hu") = -500.0, nb::arg("polarity") = "rising",
          nb::arg("field_of_view_deg") = 80.0, nb::arg("barrel_distortion") = 0.15,
          nb::arg("style") = "real", nb::arg("lining") = "airway", nb::arg("field_stop") = "full",
          nb::arg("is_smooth") = false,
          nb::arg("pictures") = std::vector<std::string>{"rgb", "depth"},
          nb::arg("labels") = nb::none(), nb::arg("threads") = 0, nb::arg("model") = "chainmail",
          nb::arg("materials"),
          typed("def __init__(self, scan: Volume, count: int = 1, "
                "size: tuple[int, int] = (64, 64), control_hz: float = 20.0, "
                "wall: str = \"deforming\", radius_mm: float = 1.4, relax_sweeps: int = 1, "
                "relax_every: int = 1, "
                "young_modulus_pa: float = 15000.0, iso_hu: float = -500.0, "
                "polarity: str = \"rising\", field_of_view_deg: float = 80.0, "
                "barrel_distortion: float = 0.15, style: str = \"real\", "
                "lining: str = \"airway\", field_stop: str = \"full\", "
                "is_smooth: bool = False, "
                "pictures: collections.abc.Sequence[str] = (\"rgb\", \"depth\"), "
                "labels: Volume | None = None, threads: int = 0, model: str = \"chainmail\", *, "
                "**settings) -> None",
                keywords),
          described(
              "Args:\n"
              "    scan: The scan. Its lumina are on the side of iso_hu that polarity says.\n"
              "    count: Number of endoscopes.\n"
              "    size: Width and height of the pictures.\n"
              "    wall: \"deforming\" or \"rigid\".\n"
              "    radius_mm: Of the tip.\n"
              "    relax_sweeps: Of the tissue after a step; relax_every: steps from one time to "
              "the next.\n"
              "    young_modulus_pa: Of ChainMail's walls, for the estimate of the force.\n"
              "    style: \"real\" or \"plain\"; lining: \"airway\", \"colon\", \"sinus\" or "
              "\"vessel\"; field_stop: \"full\", \"round\" or \"octagon\".\n"
              "    is_smooth: Four rays for each pixel at an edge.\n"
              "    pictures: Of \"rgb\", \"depth\", \"normals\", \"flow\".\n"
              "    labels: Label map of the scan, seen together with flow.\n"
              "    model: Of the walls: \"chainmail\", or \"elastic\", which gives the force on "
              "the tip. Each has settings of its own below.\n"
              "    **settings",
              keywords))
        .def(
            "place",
            [](PyArena& a, int n, Vec3d eye_mm, Vec3d look, const std::optional<Vec3d>& up) {
                a.check(n);
                take(a.arena().place(n, pose_of(eye_mm, look, up)));
            },
            nb::arg("endoscope"), nb::arg("eye_mm"), nb::arg("look"), nb::arg("up") = nb::none(),
            "Places an endoscope [mm, LPS], and returns its tissue to rest.")
        .def("step", &PyArena::step, nb::arg("actions"), nb::arg("moves") = nb::none(),
             nb::sig("def step(self, actions: numpy.typing.ArrayLike, "
                     "moves: numpy.typing.ArrayLike | None = None) -> None"),
             "Moves the endoscopes by 1 / control_hz seconds, and makes their pictures.\n\n"
             "Args:\n"
             "    actions: (n, 4): advance [mm/s], roll, pitch, yaw [rad/s].\n"
             "    moves: (n,): False keeps an endoscope as it is.")
        .def(
            "look",
            [](PyArena& a) {
                const Status done = [&] {
                    const nb::gil_scoped_release without_lock;
                    return a.arena().look();
                }();
                take(done);
            },
            "Makes the pictures of endoscopes that were placed or loaded.")
        .def(
            "push",
            [](PyArena& a, int n, Vec3d point_mm, Vec3d push_mm, double radius) {
                a.check(n);
                return take(a.arena().push(n, {point_mm, push_mm, radius}));
            },
            nb::arg("endoscope"), nb::arg("point_mm"), nb::arg("push_mm"),
            nb::arg("sphere_radius_mm") = 0.0,
            "Pushes tissue with another tool; it shows at the next step.")
        .def(
            "save_state",
            [](PyArena& a, int n) {
                a.check(n);
                const auto bytes = take(a.arena().save_state(n));
                return nb::bytes(bytes.data(), bytes.size());
            },
            nb::arg("endoscope"), "Pose and tissue of an endoscope.")
        .def(
            "load_state",
            [](PyArena& a, int n, const nb::bytes& state) {
                a.check(n);
                take(a.arena().load_state(
                    n, {static_cast<const std::byte*>(state.data()), state.size()}));
            },
            nb::arg("endoscope"), nb::arg("state"), "Restores a state of save_state().")
        .def_prop_ro(
            "states", &states_of,
            nb::sig("def states(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "A copy (n, 16): eye (3) [mm, LPS], look (3), up (3), force of the wall (3) [N], "
            "largest displacement [mm], is touching, is stopped, steps.")
        .def(
            "picture",
            [](PyArena& a, int n, std::pair<int, int> size) {
                a.check(n);
                for (const int pixels : {size.first, size.second})
                    if (pixels < 1 || pixels > 8192)
                        raise({ErrorCode::InvalidArgument,
                               "size: expected 1 to 8192 pixels, found " + std::to_string(pixels),
                               "size"});
                auto* const image = new Image([&] {
                    const nb::gil_scoped_release without_lock;
                    return a.arena().picture(n, size.first, size.second);
                }());
                const nb::capsule owner(image,
                                        [](void* p) noexcept { delete static_cast<Image*>(p); });
                return nb::cast(nb::ndarray<nb::numpy, std::uint8_t, nb::shape<-1, -1, 3>>(
                    &image->pixels.data()->r,
                    {std::size_t(size.second), std::size_t(size.first), 3}, owner));
            },
            nb::arg("endoscope"), nb::arg("size"),
            nb::sig("def picture(self, endoscope: int, size: tuple[int, int]) -> "
                    "numpy.typing.NDArray[numpy.uint8]"),
            "A picture (h, w, 3) of another size, smooth.")
        .def(
            "hash",
            [](PyArena& a, int n) {
                a.check(n);
                return a.arena().hash(n);
            },
            nb::arg("endoscope"), "Hash of pose and tissue: equal for any number of threads.")
        .def(
            "project",
            [](PyArena& a, int n, Vec3d point_mm) -> std::optional<std::pair<double, double>> {
                a.check(n);
                const EndoscopeArenaSettings& s = a.arena().settings();
                const auto p = project(a.arena().camera(n), s.width, s.height, point_mm);
                if (!p) return std::nullopt;
                return std::pair{p->x, p->y};
            },
            nb::arg("endoscope"), nb::arg("point_mm"),
            nb::sig("def project(self, endoscope: int, point_mm: "
                    "collections.abc.Sequence[float]) -> tuple[float, float] | None"),
            "Pixel of a point, from the top left corner; None behind the eye.")
        .def(
            "volume",
            [](PyArena& a, int n) {
                a.check(n);
                return PyVolume{a.arena().volume(n), {}};
            },
            nb::arg("endoscope"), "The deformed scan.")
        .def_prop_ro(
            "count", [](PyArena& a) { return a.arena().count(); }, "Number of endoscopes.")
        .def_prop_ro(
            "scan", [](PyArena& a) { return a.scan(); }, nb::sig("def scan(self, /) -> Volume"),
            "The scan at rest.")
        .def_prop_ro("threads", &PyArena::threads, "Number of threads.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                return exchange("reduced_arena")(self, nb::cast<const PyArena&>(self).made_of());
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"));
    bind_pictures(c);
}

}  // namespace

void bind_gym(nb::module_& m) {
    bind_arena(m);
}

}  // namespace pliant::python
