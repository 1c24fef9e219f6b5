// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Catheters for training, many in one vessel.

#include <pliant/data/gym.h>

#include <algorithm>

#include "keywords.h"
#include "numbers.h"
#include "struct_class.h"
#include "vessels.h"
#include "volumes.h"

namespace pliant::python {
namespace {

using Flags = nb::ndarray<const std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// The members are destroyed in reverse order: each refers to those above it.
class PyCatheters : public Exclusive {
  public:
    /// @param made_of  all arguments of the constructor, for copies
    PyCatheters(const VesselWall& wall, nb::object scan, const CatheterArenaSettings& settings,
                int threads, nb::tuple made_of)
        : m_scan(std::move(scan)),
          m_made_of(std::move(made_of)),
          m_threads(std::make_unique<Arena>(threads)) {
        const Volume& volume = object_in<PyVolume>(m_scan, "scan", "a Volume").volume;
        m_arena = take(m_threads->run(
            [&] { return CatheterArena::create(wall, volume, settings, m_threads->tasks()); }));
    }

    CatheterArena& arena() const { return *m_arena; }
    const Arena& threads() const { return *m_threads; }
    nb::object scan() const { return m_scan; }
    nb::tuple made_of() const { return m_made_of; }
    void check(int n) const {
        if (n >= 0 && n < m_arena->count()) return;
        raise({ErrorCode::InvalidArgument,
               "catheter: expected 0 to " + std::to_string(m_arena->count() - 1) + ", found " +
                   std::to_string(n),
               "catheter"});
    }

    void step(const nb::object& given, const nb::object& moves) const {
        const Numbers<double, 3> actions(given, "actions");
        Flags flags;
        nb::object flag_memory;
        std::span<const std::uint8_t> asked;
        if (!moves.is_none()) {
            flag_memory = array_in(moves, "moves", "uint8");
            if (!nb::try_cast<Flags>(flag_memory, flags))
                raise({ErrorCode::InvalidArgument, "moves: expected one axis", "moves"});
            asked = {flags.data(), flags.shape(0)};
        }
        take(m_threads->run([&] { return m_arena->step(actions.numbers(), asked); }));
    }

  private:
    nb::object m_scan;
    nb::tuple m_made_of;
    std::unique_ptr<Arena> m_threads;
    std::unique_ptr<CatheterArena> m_arena;
};

void make_catheters(nb::pointer_and_handle<PyCatheters> self, const nb::object& given_wall,
                    const nb::object& scan, const nb::object& entry, double inwards, int count,
                    std::pair<int, int> size, double control_hz,
                    const std::optional<nb::object>& view, bool has_pictures, double device_water,
                    int points, double points_mm, double bend_rad, double max_bend_rad, int threads,
                    const nb::kwargs& settings) {
    const auto& wall = object_in<VesselWall>(given_wall, "wall", "a VesselWall");
    CatheterArenaSettings s;
    s.catheter = settings_from<CatheterSettings>(settings, catheter_rows());
    s.catheter.entry = entry_of(entry, inwards, s.catheter.entry.inserted_mm, wall);
    s.count = count;
    s.width = size.first;
    s.height = size.second;
    s.control_hz = control_hz;
    s.has_pictures = has_pictures;
    if (view) s.view = nb::cast<const Fluoroscopy&>(*view);
    s.device_water = device_water;
    s.points = points;
    s.points_mm = points_mm;
    s.bend_rad = bend_rad;
    s.max_bend_rad = max_bend_rad;
    const nb::tuple made_of =
        nb::make_tuple(nb::make_tuple(given_wall, scan, entry, inwards, count, size, control_hz,
                                      view, has_pictures, device_water, points, points_mm, bend_rad,
                                      max_bend_rad, threads),
                       settings);
    new (self.p) PyCatheters(wall, scan, s, threads, made_of);
}

nb::object states_of(const PyCatheters& a) {
    std::vector<double> rows;
    const auto count = std::size_t(a.arena().count());
    for (std::size_t n = 0; n < count; ++n) {
        const CatheterArenaState& s = a.arena().state(int(n));
        for (const Vec3d& v : {s.tip_mm, s.ahead, s.bends_to})
            rows.insert(rows.end(), {v.x, v.y, v.z});
        rows.insert(rows.end(),
                    {s.inserted_mm, s.rotated_rad, s.bend_rad, s.push_n, s.wall_force_n, s.depth_mm,
                     s.max_displacement_mm, double(s.left_end), double(s.steps)});
    }
    return array_owning<double>(std::move(rows), std::array{count, rows.size() / count});
}

}  // namespace

void bind_catheter_gym(nb::module_& m) {
    const Keywords keywords = without(keywords_of(catheter_rows()), {"place_mm", "direction"});
    nb::class_<PyCatheters> c(
        m, "CatheterArena",
        "Many catheters, each in a vessel of its own with the same wall at rest; all move in one "
        "call.\n\n"
        "The same actions from the same positions give the same bits for any number of threads.");
    c.def(
         "__init__", &make_catheters, nb::arg("wall"), nb::arg("scan"), nb::arg("entry") = 0,
         nb::arg("inwards") = 0.5, nb::arg("count") = 1,
         nb::arg("size") = std::pair<int, int>{64, 64}, nb::arg("control_hz") = 7.5,
         nb::arg("view") = nb::none(), nb::arg("has_pictures") = true,
         nb::arg("device_water") = 20.0, nb::arg("points") = 8, nb::arg("points_mm") = 5.0,
         nb::arg("bend_rad") = 0.0, nb::arg("max_bend_rad") = 2.0, nb::arg("threads") = 0,
         nb::arg("settings"),
         typed("def __init__(self, wall: VesselWall, scan: Volume, entry: int | VesselEnd | "
               "tuple[collections.abc.Sequence[float], collections.abc.Sequence[float]] = 0, "
               "inwards: float = 0.5, count: int = 1, size: tuple[int, int] = (64, 64), "
               "control_hz: float = 7.5, view: Fluoroscopy | None = None, has_pictures: bool = "
               "True, device_water: float = "
               "20.0, points: int = 8, points_mm: float = 5.0, bend_rad: float = 0.0, "
               "max_bend_rad: float = 2.0, threads: int = 0, *, **settings) -> None",
               keywords),
         described(
             "Args:\n"
             "    wall: The vessel's wall.\n"
             "    scan: Seen in the pictures: a scan, or scan_of_vessel(wall).\n"
             "    entry: Where the guide ends: a number of wall.ends, a VesselEnd, or a position "
             "and a direction.\n"
             "    inwards: Fraction of an end's radius from it to the guide's end.\n"
             "    view: The fluoroscopy.\n"
             "    device_water: Absorption of the catheter, in that of water.\n"
             "    points: Number of tracked points; points_mm: their distance along the catheter.\n"
             "    bend_rad: Bend of the tip at first; max_bend_rad: its limit.\n"
             "    **settings",
             keywords))
        .def(
            "place",
            [](PyCatheters& a, int n, double rotated_rad) {
                a.check(n);
                take(a.threads().run([&] { return a.arena().place(n, rotated_rad); }));
            },
            nb::arg("catheter"), nb::arg("rotated_rad") = 0.0,
            "Withdraws a catheter to the guide, returns its wall to rest, and rotates it.")
        .def(
            "step", &PyCatheters::step, nb::arg("actions"), nb::arg("moves") = nb::none(),
            nb::sig("def step(self, actions: numpy.typing.ArrayLike, "
                    "moves: numpy.typing.ArrayLike | None = None) -> None"),
            "Moves the catheters by 1 / control_hz seconds, and makes their pictures. After an "
            "interruption or another error they are as before.\n\n"
            "Args:\n"
            "    actions: (n, 3): insertion [mm/s], rotation [rad/s], bending of the tip [rad/s].\n"
            "    moves: (n,): False keeps a catheter as it is.")
        .def(
            "look", [](PyCatheters& a) { take(a.threads().run([&] { return a.arena().look(); })); },
            "Makes the pictures of catheters that were placed or loaded.")
        .def(
            "save_state",
            [](const PyCatheters& a, int n) {
                a.check(n);
                return array_owning<double>(take(a.arena().save_state(n)));
            },
            nb::arg("catheter"),
            nb::sig("def save_state(self, catheter: int) -> numpy.typing.NDArray[numpy.float64]"),
            "The complete state of a catheter and its wall (m,).")
        .def(
            "load_state",
            [](PyCatheters& a, int n, const nb::object& state) {
                a.check(n);
                const Numbers<double, 0> numbers(state, "state");
                take(a.threads().run([&] { return a.arena().load_state(n, numbers.numbers()); }));
            },
            nb::arg("catheter"), nb::arg("state"),
            nb::sig("def load_state(self, catheter: int, state: numpy.typing.ArrayLike) -> None"),
            "Restores a state of save_state().")
        .def_prop_ro(
            "fluoro",
            [](nb::handle self) -> nb::object {
                const CatheterArena& a = nb::cast<const PyCatheters&>(self).arena();
                if (a.pictures().empty()) return nb::none();
                const CatheterArenaSettings& s = a.settings();
                return nb::cast(nb::ndarray<nb::numpy, const std::uint8_t, nb::ndim<3>>(
                    a.pictures().data(),
                    {std::size_t(s.count), std::size_t(s.height), std::size_t(s.width)}, self));
            },
            nb::sig("def fluoro(self, /) -> numpy.typing.NDArray[numpy.uint8]"),
            "Fluoroscopies (n, h, w), a view that the next step overwrites.")
        .def_prop_ro(
            "points_mm",
            [](nb::handle self) {
                const CatheterArena& a = nb::cast<const PyCatheters&>(self).arena();
                return nb::cast(nb::ndarray<nb::numpy, const float, nb::ndim<3>>(
                    a.points().data(),
                    {std::size_t(a.count()), std::size_t(a.settings().points), 2}, self));
            },
            nb::sig("def points_mm(self, /) -> numpy.typing.NDArray[numpy.float32]"),
            "Tracked points (n, points, 2) in the plane through the middle of the picture, mm to "
            "the right and up, the tip first: a view that the next step overwrites.")
        .def_prop_ro("states", &states_of,
                     nb::sig("def states(self, /) -> numpy.typing.NDArray[numpy.float64]"),
                     "A copy (n, 18): tip (3) [mm, LPS], its direction (3), the direction to which "
                     "it bends (3), inserted length [mm], rotation [rad], bend [rad], reaction on "
                     "the hand [N], force on the wall [N], depth [mm], the wall's largest "
                     "displacement [mm], number of the end that it has left through, steps.")
        .def(
            "project",
            [](const PyCatheters& a, Vec3d point_mm) {
                const auto p = a.arena().project(point_mm);
                return nb::make_tuple(p[0], p[1]);
            },
            nb::arg("point_mm"),
            nb::sig("def project(self, point_mm: collections.abc.Sequence[float]) -> "
                    "tuple[float, float]"),
            "A point [mm, LPS] in the plane of points_mm.")
        .def(
            "wire_mm",
            [](const PyCatheters& a, int n) {
                a.check(n);
                const CatheterScene& scene = a.arena().scene(n);
                const auto nodes =
                    scene.wire_positions().subspan(std::size_t(scene.first_inserted()));
                return points_of({nodes.rbegin(), nodes.rend()});
            },
            nb::arg("catheter"),
            nb::sig("def wire_mm(self, catheter: int) -> numpy.typing.NDArray[numpy.float64]"),
            "Nodes of a catheter (m, 3) [mm, LPS], the tip first; the last is in the guide.")
        .def(
            "ghost_mm",
            [](const PyCatheters& a, int n) {
                a.check(n);
                return points_of(a.arena().scene(n).ghost_positions());
            },
            nb::arg("catheter"),
            nb::sig("def ghost_mm(self, catheter: int) -> numpy.typing.NDArray[numpy.float64]"),
            "Nodes of the lumen's surface around a catheter, in the order of wall.ghost.")
        .def(
            "picture",
            [](const PyCatheters& a, int n, std::pair<int, int> size) {
                a.check(n);
                for (const int pixels : {size.first, size.second})
                    if (pixels < 1 || pixels > 8192)
                        raise({ErrorCode::InvalidArgument,
                               "size: expected 1 to 8192 pixels, found " + std::to_string(pixels),
                               "size"});
                const Image image = take(
                    a.threads().run([&] { return a.arena().picture(n, size.first, size.second); }));
                std::vector<std::uint8_t> bytes;
                for (const Rgb8& p : image.pixels) bytes.insert(bytes.end(), {p.r, p.g, p.b});
                return array_owning<std::uint8_t>(
                    std::move(bytes),
                    std::array{std::size_t(size.second), std::size_t(size.first), std::size_t(3)});
            },
            nb::arg("catheter"), nb::arg("size"),
            nb::sig("def picture(self, catheter: int, size: tuple[int, int]) -> "
                    "numpy.typing.NDArray[numpy.uint8]"),
            "A fluoroscopy (h, w, 3) of another size.")
        .def(
            "hash",
            [](const PyCatheters& a, int n) {
                a.check(n);
                return a.arena().hash(n);
            },
            nb::arg("catheter"), "Of positions and velocities: equal for any number of threads.")
        .def_prop_ro(
            "count", [](const PyCatheters& a) { return a.arena().count(); }, "Number of catheters.")
        .def_prop_ro(
            "time_step_s",
            [](const PyCatheters& a) { return a.arena().settings().catheter.time_step_s; },
            "Time step [s].")
        .def_prop_ro(
            "scan", [](const PyCatheters& a) { return a.scan(); },
            nb::sig("def scan(self, /) -> Volume"), "The scan in the pictures.")
        .def_prop_ro(
            "threads", [](const PyCatheters& a) { return a.threads().threads(); },
            "Number of threads.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                return exchange("reduced_arena")(self,
                                                 nb::cast<const PyCatheters&>(self).made_of());
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"));
}

}  // namespace pliant::python
