// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissues: the interface of tissue.h, with the scan, the threads and the deformed scan that belong
// to it.

#include <pliant/check_tissue.h>
#include <pliant/mesh.h>
#include <pliant/resample.h>
#include <pliant/tissue.h>
#include <pliant/tissues.h>

#include "keywords.h"
#include "made_tissue.h"
#include "own_tissue.h"
#include "pickled.h"
#include "volumes.h"

namespace pliant::python {
namespace {

/// The members are destroyed in reverse order: each refers to those above it.
class PyTissue : public Exclusive {
  public:
    PyTissue(nb::object scan, int threads)
        : m_scan(std::move(scan)), m_arena(std::make_unique<Arena>(threads)) {}
    /// A tissue of a class of Python. @param self  the object that will hold this
    PyTissue(nb::handle self, nb::object scan, int threads) : PyTissue(std::move(scan), threads) {
        m_tissue = make_own_tissue(self, rest(), m_arena->tasks());
        m_is_own = true;
        allow_inner_calls();
    }

    template <class Make>
    static std::unique_ptr<PyTissue> made(nb::object scan, int threads, const Make& make) {
        auto made = std::make_unique<PyTissue>(std::move(scan), threads);
        const Volume& volume = made->rest();
        made->m_tissue =
            take(made->m_arena->run([&] { return make(volume, made->m_arena->tasks()); }));
        return made;
    }

    nb::object scan() const { return m_scan; }
    const Volume& rest() const { return object_in<PyVolume>(m_scan, "scan", "a Volume").volume; }
    bool is_own() const { return m_is_own; }
    /// Notes the call that made it, for copies.
    void note_maker(const char* function, nb::tuple arguments, nb::dict settings) {
        settings["threads"] = threads();
        m_maker = nb::make_tuple(function, std::move(arguments), std::move(settings));
    }
    /// The call that made it: function, arguments, settings; none without one.
    nb::object maker() const { return m_maker; }
    void configure(const nb::dict& changes) {
        take(m_tissue->configure(record_of(changes)));
        m_changes.append(changes);
    }
    nb::list changes() const { return m_changes; }
    Tissue& tissue() const { return *m_tissue; }
    void begin_group(const std::string& name) {
        m_tissue->begin_group(name);
        ++m_groups;
    }
    int end_group() {
        if (m_groups == 0)
            raise({ErrorCode::InvalidArgument,
                   "end_group: expected a group of begin_group(), found none", "end_group",
                   "a group of begin_group()", "none"});
        --m_groups;
        return m_tissue->end_group();
    }
    template <class Work>
    auto run(const Work& work) const {
        return take(m_arena->run([&] { return work(*m_tissue); }));
    }
    int threads() const { return m_arena->threads(); }
    /// The deformed scan, brought up to date.
    Volume deformed() {
        return run([&](Tissue& tissue) -> Result<Volume> {
            if (!m_live) {
                auto live = LiveDeformation::create(tissue);
                if (!live.ok()) return live.error();
                m_live.emplace(std::move(live).value());
            }
            if (const auto update = m_live->update(); !update.ok()) return update.error();
            return m_live->volume();
        });
    }

  private:
    nb::object m_scan;
    std::unique_ptr<Arena> m_arena;
    std::unique_ptr<Tissue> m_tissue;
    std::optional<LiveDeformation> m_live;
    bool m_is_own = false;
    int m_groups = 0;  ///< that have begun
    nb::object m_maker = nb::none();
    nb::list m_changes;  ///< of settings, in order
};

template <class T>
std::unique_ptr<PyTissue> tissue_of_settings(
    const char* name, const nb::object& scan, int threads, const nb::kwargs& settings,
    SettingRows<T> rows,
    Result<std::unique_ptr<Tissue>> (*make)(const Volume&, const T&, const TaskArena&) noexcept,
    T chosen = {}) {
    change(chosen, settings, rows);
    auto made = PyTissue::made(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
        return make(volume, chosen, arena);
    });
    made->note_maker(name, nb::make_tuple(scan), settings);
    return made;
}

Result<std::unique_ptr<Tissue>> chainmail_of(const Volume& volume,
                                             const ChainMailSettings& settings,
                                             const TaskArena& arena) noexcept {
    return make_chainmail(volume, settings, arena);
}

PushStatus status_of(const std::string& name) {
    for (const PushStatus status : {PushStatus::Applied, PushStatus::Limited, PushStatus::Rejected})
        if (name_of(status) == name) return status;
    raise({ErrorCode::InvalidArgument,
           "status: expected \"applied\", \"limited\" or \"rejected\", found \"" + name + "\"",
           "status", "applied, limited or rejected", name});
}

void bind_reports(nb::module_& m) {
    nb::class_<PushReport>(m, "PushReport", "Result of a push or a step of a drag.")
        .def(Pickled<&PushReport::status, &PushReport::limited_by, &PushReport::step_fraction,
                     &PushReport::grabbed_elements, &PushReport::moved_elements,
                     &PushReport::solve_ms, &PushReport::forgotten_steps, &PushReport::message>())
        .def(
            "__init__",
            [](PushReport* report, const std::string& status, double step_fraction,
               std::int64_t grabbed, std::int64_t moved, const std::string& message) {
                PushReport made{.step_fraction = step_fraction,
                                .grabbed_elements = grabbed,
                                .moved_elements = moved,
                                .message = message};
                made.status = status_of(status);
                new (report) PushReport(std::move(made));
            },
            nb::arg("status") = "applied", nb::arg("step_fraction") = 1.0,
            nb::arg("grabbed_elements") = 0, nb::arg("moved_elements") = 0, nb::arg("message") = "",
            "For a tissue of one's own.")
        .def_prop_ro(
            "status", [](const PushReport& r) { return std::string(name_of(r.status)); },
            "\"applied\", \"limited\" or \"rejected\".")
        .def_prop_ro(
            "limited_by", [](const PushReport& r) { return std::string(name_of(r.limited_by)); },
            "\"none\", \"bone\", \"movement\", \"fold\", …")
        .def_ro("step_fraction", &PushReport::step_fraction, "Part of the push that was made, 0…1.")
        .def_ro("grabbed_elements", &PushReport::grabbed_elements,
                "Elements that the tool holds; nodes of a mesh.")
        .def_ro("moved_elements", &PushReport::moved_elements,
                "Elements that have moved, the held ones included.")
        .def_ro("solve_ms", &PushReport::solve_ms, "Wall-clock time [ms].")
        .def_ro("message", &PushReport::message, "Reason, if it isn't simply applied.")
        .def_ro("bone_mm", &PushReport::bone_mm,
                "The bone that stopped it nearest to the tool [mm, LPS], or None.")
        .def("__repr__", [](const PushReport& r) {
            return "PushReport(" + std::string(name_of(r.status)) +
                   ", step_fraction=" + std::to_string(r.step_fraction) +
                   ", moved_elements=" + std::to_string(r.moved_elements) + ")";
        });
    nb::class_<SlideReport>(m, "SlideReport", "Result of a slide.")
        .def(Pickled<&SlideReport::way_fraction, &SlideReport::limited_by, &SlideReport::end_mm,
                     &SlideReport::ends_in_tissue, &SlideReport::contacts,
                     &SlideReport::inside_elements, &SlideReport::slide_ms,
                     &SlideReport::forgotten_steps>())
        .def_ro("way_fraction", &SlideReport::way_fraction, "Part of the way that was made, 0…1.")
        .def_prop_ro(
            "limited_by", [](const SlideReport& r) { return std::string(name_of(r.limited_by)); },
            "As of a push.")
        .def_ro("end_mm", &SlideReport::end_mm, "The sphere's centre at the end [mm, LPS].")
        .def_ro("ends_in_tissue", &SlideReport::ends_in_tissue,
                "Whether the centre ends in tissue.")
        .def_ro("contacts", &SlideReport::contacts, "Moves of tissue out of the sphere's way.")
        .def_ro("slide_ms", &SlideReport::slide_ms, "Wall-clock time [ms].")
        .def_ro("message", &SlideReport::message, "Reason, if it ended early.")
        .def_ro("bone_mm", &SlideReport::bone_mm, "As of a push.");
    nb::class_<CutReport>(m, "CutReport", "Result of a cut.")
        .def(Pickled<&CutReport::cut_links, &CutReport::cut_ms, &CutReport::forgotten_steps>())
        .def_ro("cut_links", &CutReport::cut_links,
                "Links between the scan's elements that were cut.")
        .def_ro("cut_ms", &CutReport::cut_ms, "Wall-clock time [ms].");
    nb::class_<CarveReport>(m, "CarveReport", "Result of a carving.")
        .def(Pickled<&CarveReport::carved_elements, &CarveReport::carve_ms,
                     &CarveReport::forgotten_steps>())
        .def_ro("carved_elements", &CarveReport::carved_elements, "Elements that were removed.")
        .def_ro("carve_ms", &CarveReport::carve_ms, "Wall-clock time [ms].");
    nb::class_<AdvanceReport>(m, "AdvanceReport", "Result of motion by itself.")
        .def(Pickled<&AdvanceReport::steps, &AdvanceReport::settled, &AdvanceReport::ms,
                     &AdvanceReport::message>())
        .def_ro("steps", &AdvanceReport::steps, "Sweeps or time steps that were made.")
        .def_ro("settled", &AdvanceReport::settled, "Whether more steps have no effect.")
        .def_ro("ms", &AdvanceReport::ms, "Wall-clock time.")
        .def_ro("message", &AdvanceReport::message,
                "Reason why the motion was stopped before it was at rest.");
}

void bind_own(nb::class_<PyTissue>& c) {
    c.def(
         "__init__",
         [](nb::pointer_and_handle<PyTissue> self, const nb::object& scan, int threads) {
             if (self.h.type().is(nb::type<PyTissue>()))
                 raise({ErrorCode::Unsupported,
                        "Tissue: expected a class of your own that derives from it, or "
                        "make_chainmail, make_elastic, make_springs, make_body"});
             if (!nb::isinstance<PyVolume>(scan))
                 raise({ErrorCode::InvalidArgument,
                        "scan: expected a Volume, found " + shown(nb::borrow(scan.type())), "scan",
                        "a Volume", shown(nb::borrow(scan.type()))});
             new (self.p) PyTissue(self.h, scan, threads);
         },
         nb::arg("scan"), nb::arg("threads") = 0,
         nb::sig("def __init__(self, scan: Volume, threads: int = 0) -> None"),
         "For classes of one's own. docs/howto/python.md lists the methods that they have.")
        .def(
            "displace",
            [](const PyTissue& t, const nb::object& displacements_mm, const Vec3d& first) {
                displace_own(t.tissue(), first, displacements_mm);
            },
            nb::arg("displacements_mm"), nb::arg("first") = Vec3d{0, 0, 0},
            nb::sig("def displace(self, displacements_mm: numpy.typing.NDArray[typing.Any], "
                    "first: collections.abc.Sequence[int] = (0, 0, 0)) -> None"),
            "Displaces elements of a tissue of one's own; the others stay as they are.\n\n"
            "Args:\n"
            "    displacements_mm: Array (k, j, i, 3) [mm, LPS].\n"
            "    first: Voxel (i, j, k) of its first vector; may lie beyond the scan.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                const PyTissue& tissue = nb::cast<const PyTissue&>(self);
                return exchange(tissue.is_own() ? "reduced_own_tissue" : "reduced_tissue")(
                    self, tissue.maker(), tissue.changes());
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"));
}

void bind_tools(nb::class_<PyTissue>& c) {
    c.def(
         "push",
         [](const PyTissue& t, Vec3d point_mm, Vec3d push_mm, double radius, std::uint32_t tool) {
             const Push push{.point_mm = point_mm, .push_mm = push_mm, .sphere_radius_mm = radius};
             return t.run([&](Tissue& tissue) { return tissue.push(tool, push); });
         },
         nb::arg("point_mm"), nb::arg("push_mm"), nb::arg("sphere_radius_mm") = 0.0,
         nb::arg("tool") = 1,
         "Pushes with a tool, which holds its tissue until release().\n\n"
         "Args:\n"
         "    point_mm: Contact point [mm, LPS].\n"
         "    push_mm: Motion [mm, LPS].\n"
         "    sphere_radius_mm: 0: the elements of the cell around the point.\n"
         "    tool: Its number.")
        .def(
            "slide",
            [](const PyTissue& t, Vec3d point_mm, Vec3d way_mm, double radius, double threshold,
               bool is_above, std::uint32_t tool) {
                const Push way{.point_mm = point_mm, .push_mm = way_mm, .sphere_radius_mm = radius};
                return t.run([&](Tissue& tissue) {
                    return tissue.slide(tool, way,
                                        {.threshold_hu = threshold, .is_above = is_above});
                });
            },
            nb::arg("point_mm"), nb::arg("way_mm"), nb::arg("sphere_radius_mm"),
            nb::arg("threshold_hu") = -500.0, nb::arg("is_above") = true, nb::arg("tool") = 1,
            "Moves a sphere along which tissue slides. Tissue: values from the threshold upwards, "
            "or below it.")
        .def(
            "cut",
            [](const PyTissue& t, std::vector<Vec3d> line_mm, Vec3d depth_mm) {
                const CutSurface surface{std::move(line_mm), depth_mm};
                return t.run([&](Tissue& tissue) { return tissue.cut(surface); });
            },
            nb::arg("line_mm"), nb::arg("depth_mm"),
            "Cuts along a line (two or more points) swept by a vector [mm, LPS].")
        .def(
            "carve",
            [](const PyTissue& t, Vec3d from_mm, Vec3d to_mm, double radius_mm, bool spare_fixed) {
                const CarveTool tool{from_mm, to_mm, radius_mm, spare_fixed};
                return t.run([&](Tissue& tissue) { return tissue.carve(tool); });
            },
            nb::arg("from_mm"), nb::arg("to_mm"), nb::arg("radius_mm"),
            nb::arg("spare_fixed") = false, "Carves what is in a capsule now.")
        .def(
            "release", [](const PyTissue& t, std::uint32_t tool) { t.tissue().release(tool); },
            nb::arg("tool") = 1, "Lets a tool go, with the tissue that it holds.")
        .def(
            "force_n",
            [](const PyTissue& t, std::uint32_t tool) { return t.tissue().force_n(tool); },
            nb::arg("tool") = 1, "Force on a tool [N]; None if the model computes none.");
}

/// Settings of all models that can be changed afterwards.
Keywords all_settings() {
    using Springs = SpringDeformationSettings;
    const SettingRows<Springs> depth(find_setting<Springs>("depth", spring_rows()), 1);
    return unset(together({keywords_of(chainmail_material_rows()), keywords_of(depth)}));
}

void bind_motion(nb::class_<PyTissue>& c) {
    c.def(
         "advance",
         [](const PyTissue& t, std::optional<std::int64_t> max_steps,
            std::optional<double> max_ms) {
             Budget budget;
             if (max_steps) budget.max_steps = *max_steps;
             if (max_ms) budget.max_ms = *max_ms;
             return t.run([&](Tissue& tissue) { return tissue.advance(budget); });
         },
         nb::arg("max_steps") = nb::none(), nb::arg("max_ms") = nb::none(),
         "Lets the tissue move by itself, until it is at rest or a limit is reached: sweeps of "
         "ChainMail's relaxation, time steps of the others.")
        .def(
            "reset", [](const PyTissue& t) { take(t.tissue().reset()); },
            "Returns all tissue to rest.")
        .def(
            "configure", [](PyTissue& t, const nb::kwargs& changes) { t.configure(changes); },
            typed("def configure(self, *, **settings) -> None", all_settings()),
            "Changes settings of the tissue's model, all or none.")
        .def("begin_group", &PyTissue::begin_group, nb::arg("name"),
             "Calls until end_group() are one step of the history.")
        .def("end_group", &PyTissue::end_group,
             "Returns the number of the oldest steps that were forgotten.\n\n"
             "Raises:\n    pliant.Error: No group has begun.")
        .def(
            "undo", [](const PyTissue& t) { take(t.tissue().undo()); }, "Takes the last step back.")
        .def(
            "redo", [](const PyTissue& t) { take(t.tissue().redo()); }, "Makes it again.")
        .def_prop_ro(
            "undo_steps", [](const PyTissue& t) { return t.tissue().undo_steps(); },
            "Steps that can be taken back.")
        .def(
            "save_state",
            [](const PyTissue& t, const std::filesystem::path& path) {
                take(t.tissue().save_state(path));
            },
            nb::arg("path"), "Writes the state (.plst). Nothing is half-written.")
        .def(
            "load_state",
            [](const PyTissue& t, const std::filesystem::path& path) {
                take(t.tissue().load_state(path));
            },
            nb::arg("path"), "Clears the history. Nothing changes on failure.");
}

void bind_results(nb::class_<PyTissue>& c) {
    c.def_prop_ro("scan", &PyTissue::scan, nb::sig("def scan(self, /) -> Volume"),
                  "The scan at rest.")
        .def(
            "volume",
            [](PyTissue& t) {
                return PyVolume{t.deformed(), {}};
            },
            "The scan as the tissue has it now. It shares unchanged pages with the next ones.")
        .def(
            "displacement_field",
            [](const PyTissue& t) {
                return t.run([](Tissue& tissue) { return displacement_field(tissue); });
            },
            "Forward displacement at rest voxel centres.")
        .def(
            "inverse_field",
            [](const PyTissue& t) {
                return t.run([](Tissue& tissue) -> Result<VectorField> {
                    const auto deformed = deform_volume(tissue, Mapping::Cells, true);
                    if (!deformed.ok()) return deformed.error();
                    return inverse_field(*deformed);
                });
            },
            "The exact inverse on the scan's grid: for resampling filters, and for points of the "
            "deformed scan.")
        .def(
            "jacobian",
            [](const PyTissue& t) {
                return PyVolume{t.run([](Tissue& tissue) { return jacobian_field(tissue); }), {}};
            },
            "Local growth at each rest voxel: 1 at rest, below 0 where space is inverted.")
        .def(
            "strain",
            [](const PyTissue& t) {
                return PyVolume{t.run([](Tissue& tissue) { return strain_field(tissue); }), {}};
            },
            "Largest eigenvalue of the Green-Lagrange strain at each rest voxel.")
        .def_prop_ro(
            "model", [](const PyTissue& t) { return std::string(t.tissue().traits().model); },
            "\"chainmail\", \"springs\", \"body\", \"network\", …")
        .def_prop_ro("threads", &PyTissue::threads, "Number of threads.")
        .def_prop_ro(
            "settings", [](const PyTissue& t) { return dict_of(t.tissue().settings()); },
            nb::sig("def settings(self, /) -> dict[str, typing.Any]"),
            "Settings that configure() can change.")
        .def_prop_ro(
            "figures", [](const PyTissue& t) { return dict_of(t.tissue().figures()); },
            nb::sig("def figures(self, /) -> dict[str, typing.Any]"),
            "Counts of nodes and the like.")
        .def(
            "report", [](const PyTissue& t) { return dict_of(t.tissue().report()); },
            nb::sig("def report(self) -> dict[str, typing.Any]"),
            "Figures that may take a while to compute.")
        .def(
            "hash", [](const PyTissue& t) { return t.tissue().hash(); },
            "Of the state: the same for any number of threads.")
        .def("__repr__", [](const PyTissue& t) {
            return "Tissue(" + std::string(t.tissue().traits().model) + ")";
        });
}

/// Makes tissues by a function of Python. Each keeps its object.
MakeAnother made_by(const nb::callable& make) {
    return [&make]() -> Result<std::shared_ptr<Tissue>> {
        const nb::gil_scoped_acquire lock;
        try {
            auto object = std::make_unique<nb::object>(make());
            Tissue* const tissue = find_tissue(*object);
            if (!tissue)
                return Error{ErrorCode::InvalidArgument,
                             "make: expected a Tissue, found " + shown(nb::borrow(object->type())),
                             "make", "a Tissue", shown(nb::borrow(object->type()))};
            const auto let_go = [kept = object.get()](Tissue*) {
                const nb::gil_scoped_acquire locked;
                delete kept;
            };
            std::shared_ptr<Tissue> shared(tissue, let_go);
            (void)object.release();
            return shared;
        } catch (nb::python_error& raised) {
            return error_of("make", raised);
        }
    };
}

}  // namespace

nb::object tissue_of(const nb::object& scan, int threads, const MakeTissue& make, MakerCall maker) {
    auto made = PyTissue::made(scan, threads, make);
    made->note_maker(maker.function, std::move(maker.arguments), std::move(maker.settings));
    return nb::cast(std::move(made));
}

Tissue* find_tissue(nb::handle object) {
    const bool is_one = nb::isinstance<PyTissue>(object) && nb::inst_ready(object);
    return is_one ? &nb::inst_ptr<PyTissue>(object)->tissue() : nullptr;
}
void claim_tissue(nb::handle object, Claim& claim) {
    claim.take(*nb::inst_ptr<PyTissue>(object), nb::type<PyTissue>());
}

void bind_tissues(nb::module_& m) {
    bind_reports(m);
    nb::class_<PyTissue> c(m, "Tissue",
                           "A scan's tissue: tools push and hold it, it moves by itself, and its "
                           "former states can be restored.\n\n"
                           "A call that raises has changed nothing, Ctrl-C included. One thread at "
                           "a time.");
    bind_own(c);
    bind_tools(c);
    bind_motion(c);
    bind_results(c);
    const Keywords chainmail = keywords_of(chainmail_rows()), springs = keywords_of(spring_rows()),
                   body = keywords_of(body_rows()),
                   elastic = unset(keywords_of(elastic_scan_rows()), {"held_above_hu"});
    m.def(
        "check_tissue",
        [](const nb::callable& make, Vec3d point_mm, Vec3d push_mm, double radius) {
            const Push push{.point_mm = point_mm, .push_mm = push_mm, .sphere_radius_mm = radius};
            const Arena arena(1);
            take(arena.run([&] { return check_tissue(made_by(make), push); }));
        },
        nb::arg("make"), nb::arg("point_mm"), nb::arg("push_mm"), nb::arg("sphere_radius_mm") = 0.0,
        nb::sig("def check_tissue(make: collections.abc.Callable[[], Tissue], "
                "point_mm: collections.abc.Sequence[float], "
                "push_mm: collections.abc.Sequence[float], sphere_radius_mm: float = 0.0) -> None"),
        "Checks that a tissue of one's own keeps the rules of all tissues: it pushes, moves, "
        "undoes "
        "and saves it, and compares.\n\n"
        "Args:\n"
        "    make: Makes one more tissue of the same kind, at rest.\n"
        "    point_mm: Contact point of a push that moves the tissue [mm, LPS].\n"
        "    push_mm: Motion [mm, LPS].\n"
        "    sphere_radius_mm: As of push().\n\n"
        "Raises:\n"
        "    Error: The first broken rule: its name in `field`, the expected and the found.");
    m.def(
        "make_chainmail",
        [](const nb::object& scan, int threads, const nb::kwargs& settings) {
            return tissue_of_settings<ChainMailSettings>("make_chainmail", scan, threads, settings,
                                                         chainmail_rows(), &chainmail_of);
        },
        nb::arg("scan"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def make_chainmail(scan: Volume, threads: int = 0, *, **settings) -> Tissue",
              chainmail),
        described("ChainMail on the scan's voxels.\n\nArgs:\n    **settings", chainmail));
    m.def(
        "make_elastic",
        [](const nb::object& scan, int threads, const nb::kwargs& settings) {
            return tissue_of_settings<ElasticScanSettings>(
                "make_elastic", scan, threads, settings, elastic_scan_rows(), &make_elastic,
                elastic_settings_for(object_in<PyVolume>(scan, "scan", "a Volume").volume));
        },
        nb::arg("scan"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def make_elastic(scan: Volume, threads: int = 0, *, **settings) -> Tissue", elastic),
        described("Linear elasticity on the scan's voxels: their equilibrium under the tools, with "
                  "forces in newtons.\n\n"
                  "Moduli and the threshold of bone that aren't given suit the scan's values: for "
                  "CT moduli of lung, fat and parenchyma, else 5 kPa.\n\n"
                  "Args:\n    **settings",
                  elastic));
    m.def(
        "make_springs",
        [](const nb::object& scan, int threads, const nb::kwargs& settings) {
            return tissue_of_settings<SpringDeformationSettings>(
                "make_springs", scan, threads, settings, spring_rows(), &make_springs);
        },
        nb::arg("scan"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def make_springs(scan: Volume, threads: int = 0, *, **settings) -> Tissue", springs),
        described("A mass-spring lattice over the scan.\n\nArgs:\n    **settings", springs));
    m.def(
        "make_body",
        [](const nb::object& scan, const nb::object& mesh, int threads,
           const nb::kwargs& settings) {
            const auto chosen = settings_from<BodySettings>(settings, body_rows());
            const auto& tetrahedra = object_in<TetMesh>(mesh, "mesh", "a TetMesh");
            auto made =
                PyTissue::made(scan, threads, [&](const Volume& volume, const TaskArena& arena) {
                    return make_body(volume, tetrahedra, chosen, arena);
                });
            made->note_maker("make_body", nb::make_tuple(scan, mesh), settings);
            return made;
        },
        nb::arg("scan"), nb::arg("mesh"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def make_body(scan: Volume, mesh: TetMesh, threads: int = 0, *, **settings) "
              "-> Tissue",
              body),
        described("Hyperelastic tetrahedra in a scan.\n\nArgs:\n    **settings", body));
}

}  // namespace pliant::python
