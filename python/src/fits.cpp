// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Spring networks that move as a reference does: boxes, meshes, measurements.

#include <pliant/models/fit.h>
#include <pliant/models/fit_mesh.h>

#include <cmath>

#include "keywords.h"
#include "numbers.h"
#include "struct_class.h"

namespace pliant::python {
namespace {

using Array = std::optional<nb::object>;
using Nodes = Numbers<std::int32_t, 0>;
using Vectors = Numbers<double, 3>;

std::vector<double> values_of(const nb::object& given) {
    return Numbers<double, 0>(given, "values").copied();
}

constexpr const char* kFitArguments =
    "Args:\n    run: Of the solver, settings_of(\"spring_solver\").\n    **settings";

/// Settings of a fit; "run" is a dictionary of those of its solver.
FitSettings fit_settings(const nb::kwargs& given) {
    nb::dict own;
    SpringSettings run;
    for (const auto& [key, value] : given) {
        if (nb::cast<std::string>(key) != "run") {
            own[key] = value;
            continue;
        }
        nb::dict settings;
        if (!nb::try_cast(value, settings)) raise_value("run", "a dictionary of settings", value);
        run = settings_from<SpringSettings>(settings, spring_solver_rows());
    }
    auto made = settings_from<FitSettings>(own, fit_rows());
    made.run = run;
    return made;
}

nb::object array_of_pairs(const std::vector<std::array<double, 2>>& pairs) {
    return array_owning<double>(std::vector(pairs), std::array{pairs.size(), std::size_t(2)});
}

void bind_problem_parts(nb::module_& m) {
    nb::class_<FitGroup>(m, "FitGroup",
                         "Links, cells and nodes whose stiffness, bulk and damping one value "
                         "multiplies.")
        .def(
            "__init__",
            [](FitGroup* self, const std::string& name, double start, double low, double high,
               const Array& links, const Array& cells, const Array& nodes) {
                FitGroup made{name, {}, {}, {}, start, low, high};
                if (links) made.links = Nodes(*links, "links").copied();
                if (cells) made.cells = Nodes(*cells, "cells").copied();
                if (nodes) made.nodes = Nodes(*nodes, "nodes").copied();
                new (self) FitGroup(std::move(made));
            },
            nb::arg("name"), nb::arg("start"), nb::arg("low"), nb::arg("high"),
            nb::arg("links") = nb::none(), nb::arg("cells") = nb::none(),
            nb::arg("nodes") = nb::none(),
            nb::sig("def __init__(self, name: str, start: float, low: float, high: float, links: "
                    "numpy.typing.ArrayLike | None = None, cells: numpy.typing.ArrayLike | None = "
                    "None, nodes: numpy.typing.ArrayLike | None = None) -> None"),
            "Args:\n    start: First value, within the bounds 0 < low <= start <= high.\n"
            "    links, cells, nodes: Numbers of its members.")
        .def_ro("name", &FitGroup::name, "Its name.")
        .def_ro("start", &FitGroup::start, "First value.")
        .def_ro("low", &FitGroup::low, "Lower bound.")
        .def_ro("high", &FitGroup::high, "Upper bound.");
    nb::class_<FitCase>(m, "FitCase", "A load, and the displacements of the reference under it.")
        .def(
            "__init__",
            [](FitCase* self, const nb::object& nodes, const nb::object& forces,
               const nb::object& target, const Array& held, const std::string& name, double weight,
               bool held_out) {
                FitCase made{.name = name,
                             .nodes = Nodes(nodes, "nodes").copied(),
                             .forces = Vectors(forces, "forces").copied_vectors(),
                             .target = Vectors(target, "target").copied_vectors(),
                             .weight = weight,
                             .held_out = held_out};
                if (held) made.held = Nodes(*held, "held").copied();
                new (self) FitCase(std::move(made));
            },
            nb::arg("nodes"), nb::arg("forces"), nb::arg("target"), nb::arg("held") = nb::none(),
            nb::arg("name") = "", nb::arg("weight") = 1.0, nb::arg("held_out") = false,
            nb::sig("def __init__(self, nodes: numpy.typing.ArrayLike, forces: "
                    "numpy.typing.ArrayLike, target: numpy.typing.ArrayLike, held: "
                    "numpy.typing.ArrayLike | None = None, name: str = \"\", weight: float = 1.0, "
                    "held_out: bool = False) -> None"),
            "Args:\n    nodes, forces: Loaded nodes (n,), and the forces on them (n, 3).\n"
            "    target: Displacement of every node (all, 3).\n"
            "    held: Immobile nodes, besides those fixed in the parts.\n"
            "    weight: Of its distances in the cost.\n    held_out: Used for evaluation only.")
        .def_ro("name", &FitCase::name, "Its name.")
        .def_ro("held_out", &FitCase::held_out, "Whether it is used for evaluation only.");
    using E = FitCaseErrors;
    nb::class_<E>(m, "FitCaseErrors", "Distances from the reference in one case.")
        .def_ro("name", &E::name, "Of the case.")
        .def_ro("held_out", &E::held_out, "Whether the case was used for evaluation only.")
        .def_ro("average_percent", &E::average_percent, "Average, in percent of a spring's length.")
        .def_ro("largest_percent", &E::largest_percent, "Largest, in percent of it.")
        .def_ro("still_average_percent", &E::still_average_percent,
                "Average of a network that doesn't move at all.")
        .def_ro("still_largest_percent", &E::still_largest_percent,
                "Largest of a network that doesn't move at all.")
        .def("__repr__", [](const E& e) {
            return "FitCaseErrors(" + e.name +
                   ", average_percent=" + std::to_string(e.average_percent) +
                   ", largest_percent=" + std::to_string(e.largest_percent) + ")";
        });
    nb::class_<FitPoint>(m, "FitPoint", "Cost and errors at some values.")
        .def_ro("cost", &FitPoint::cost, "Of the cases that aren't held out.")
        .def_ro("cases", &FitPoint::cases, "Errors of all cases, a list of FitCaseErrors.");
}

void bind_problem(nb::module_& m) {
    using P = FitProblem;
    const Keywords keywords = keywords_of(fit_rows());
    nb::class_<P>(m, "FitProblem",
                  "A network, its groups and the reference. The values are one for each group.")
        .def(
            "__init__",
            [](P* self, const SpringParts& parts, const std::vector<FitGroup>& groups,
               const std::vector<FitCase>& cases, const nb::kwargs& settings) {
                const auto chosen = fit_settings(settings);
                auto made = [&] {
                    const nb::gil_scoped_release without_lock;
                    return P::create(parts, groups, cases, chosen);
                }();
                new (self) P(take(std::move(made)));
            },
            nb::arg("parts"), nb::arg("groups"), nb::arg("cases"), nb::arg("settings"),
            typed("def __init__(self, parts: SpringParts, groups: "
                  "collections.abc.Sequence[FitGroup], cases: collections.abc.Sequence[FitCase], "
                  "*, run: dict[str, typing.Any] = {}, **settings) -> None",
                  keywords),
            described(kFitArguments, keywords))
        .def_prop_ro(
            "groups",
            [](const P& p) { return std::vector<FitGroup>(p.groups().begin(), p.groups().end()); },
            "A list of FitGroup.")
        .def_prop_ro("spring_length", &P::spring_length,
                     "Errors are given in percent of this length.")
        .def(
            "evaluate",
            [](const P& p, const nb::object& values) {
                const auto v = values_of(values);
                auto found = [&] {
                    const nb::gil_scoped_release without_lock;
                    return p.evaluate(v);
                }();
                return take(std::move(found));
            },
            nb::arg("values"),
            nb::sig("def evaluate(self, values: numpy.typing.ArrayLike) -> FitPoint"),
            "Cost and errors at some values, one for each group. The bounds don't apply.")
        .def(
            "residuals",
            [](const P& p, const nb::object& values, std::size_t fit_case) {
                return points_of(take(p.residuals(values_of(values), fit_case)));
            },
            nb::arg("values"), nb::arg("fit_case") = 0,
            nb::sig("def residuals(self, values: numpy.typing.ArrayLike, fit_case: int = 0) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "Displacement of the network minus each target of a case (n, 3).")
        .def(
            "displacements",
            [](const P& p, const nb::object& values, std::size_t fit_case) {
                return points_of(take(p.displacements(values_of(values), fit_case)));
            },
            nb::arg("values"), nb::arg("fit_case") = 0,
            nb::sig("def displacements(self, values: numpy.typing.ArrayLike, fit_case: int = 0) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "The network's displacements in a case (n, 3).")
        .def(
            "parts_at",
            [](const P& p, const nb::object& values) {
                const auto v = values_of(values);
                if (v.size() != p.groups().size())
                    raise({ErrorCode::InvalidArgument,
                           "values: expected " + std::to_string(p.groups().size()) + ", found " +
                               std::to_string(v.size()),
                           "values"});
                return p.parts_at(v);
            },
            nb::arg("values"),
            nb::sig("def parts_at(self, values: numpy.typing.ArrayLike) -> SpringParts"),
            "The parts with the values inserted.");
}

FitMethod method_of(const std::string& name, const Array& values, const nb::kwargs& settings) {
    if (name == "gauss_newton") return settings_from<GaussNewton>(settings, gauss_newton_rows());
    if (name == "annealing") {
        nb::dict rest;
        std::uint64_t seed = Annealing{}.seed;
        for (const auto& [key, value] : settings)
            if (nb::cast<std::string>(key) != "seed")
                rest[key] = value;
            else if (!nb::try_cast(value, seed))
                raise_value("seed", "a whole number of 0 or more", value);
        auto made = settings_from<Annealing>(rest, annealing_rows());
        made.seed = seed;
        return made;
    }
    if (name == "given" && values) return GivenValues{values_of(*values)};
    const std::string expected = "gauss_newton, annealing, or given with values";
    raise({ErrorCode::InvalidArgument, "method: expected " + expected + ", found " + name, "method",
           expected, name});
}

void bind_fit(nb::module_& m) {
    using R = FitResult;
    const Keywords keywords =
        together({keywords_of(gauss_newton_rows()), keywords_of(annealing_rows())});
    nb::class_<R>(m, "FitResult", "Result of fit().")
        .def_prop_ro(
            "values", [](const R& r) { return array_owning<double>(std::vector(r.values)); },
            nb::sig("def values(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "One for each group.")
        .def_prop_ro(
            "at_bound",
            [](const R& r) {
                std::vector<std::string> texts;
                for (const FitBound b : r.at_bound) texts.push_back(text_of(b));
                return texts;
            },
            "\"none\", \"low\" or \"high\" for each group: a value at a bound reflects the bound.")
        .def_ro("at", &R::at, "Cost and errors there, a FitPoint.")
        .def_ro("evaluations", &R::evaluations, "Evaluations of all cases.")
        .def_ro("refused", &R::refused, "Evaluations of networks without an equilibrium.")
        .def_ro("seconds", &R::seconds, "Wall-clock time [s].")
        .def_prop_ro(
            "trace",
            [](const R& r) {
                std::vector<std::array<double, 3>> rows;
                for (const FitTrace& t : r.trace)
                    rows.push_back({double(t.evaluation), t.cost, t.seconds});
                const std::array shape{rows.size(), std::size_t(3)};
                return array_owning<double>(std::move(rows), shape);
            },
            nb::sig("def trace(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "History of the best cost (n, 3): evaluation, cost, seconds.")
        .def("__repr__", [](const R& r) {
            return "FitResult(cost=" + std::to_string(r.at.cost) +
                   ", evaluations=" + std::to_string(r.evaluations) + ")";
        });
    m.def(
        "fit",
        [](const FitProblem& problem, const std::string& method, const Array& values, int threads,
           const nb::kwargs& settings) {
            const auto chosen = method_of(method, values, settings);
            const Arena arena(threads);
            return take(arena.run_reading([&] { return fit(problem, chosen, arena.tasks()); }));
        },
        nb::arg("problem"), nb::arg("method") = "gauss_newton", nb::arg("values") = nb::none(),
        nb::arg("threads") = 0, nb::arg("settings"),
        typed("def fit(problem: FitProblem, method: str = \"gauss_newton\", values: "
              "numpy.typing.ArrayLike | None = None, threads: int = 0, *, "
              "seed: int = ..., **settings) -> FitResult",
              keywords),
        described(
            "Finds the values with which the network moves as the reference does. Equal for any "
            "number of threads.\n\n"
            "Args:\n"
            "    method: \"gauss_newton\", \"annealing\", or \"given\" with values.\n"
            "    seed: Of annealing.\n"
            "    **settings",
            keywords));
    m.def(
        "fit_directions",
        [](const FitProblem& problem, const nb::object& values, int threads) {
            const auto v = values_of(values);
            const Arena arena(threads);
            const auto found =
                take(arena.run_reading([&] { return fit_directions(problem, v, arena.tasks()); }));
            std::vector<double> directions, influences;
            for (const FitDirection& d : found) {
                directions.insert(directions.end(), d.direction.begin(), d.direction.end());
                influences.push_back(d.influence);
            }
            const std::array shape{found.size(), v.size()};
            return nb::make_tuple(array_owning<double>(std::move(directions), shape),
                                  array_owning<double>(std::move(influences)));
        },
        nb::arg("problem"), nb::arg("values"), nb::arg("threads") = 0,
        nb::sig("def fit_directions(problem: FitProblem, values: numpy.typing.ArrayLike, threads: "
                "int = 0) -> tuple[numpy.typing.NDArray[numpy.float64], "
                "numpy.typing.NDArray[numpy.float64]]"),
        "Directions in the space of the values' logarithms (d, groups) and their influence on the "
        "displacements (d,), ascending. Below 0.001 a direction isn't identifiable.");
    m.def(
        "fit_intervals",
        [](const FitProblem& problem, const nb::object& values, double noise, int threads) {
            const auto v = values_of(values);
            const Arena arena(threads);
            std::vector<std::array<double, 2>> pairs;
            for (const FitInterval& i : take(arena.run_reading(
                     [&] { return fit_intervals(problem, v, noise, arena.tasks()); })))
                pairs.push_back({i.low, i.high});
            return array_of_pairs(pairs);
        },
        nb::arg("problem"), nb::arg("values"), nb::arg("noise"), nb::arg("threads") = 0,
        nb::sig("def fit_intervals(problem: FitProblem, values: numpy.typing.ArrayLike, noise: "
                "float, threads: int = 0) -> numpy.typing.NDArray[numpy.float64]"),
        "95 % confidence intervals of the values at an optimum (groups, 2); 0 and infinity if one "
        "isn't identifiable.\n\n"
        "Args:\n    noise: Standard deviation of a measured component, in the network's unit of "
        "length.");
}

void bind_box(nb::module_& m) {
    using L = FitBoxLoad;
    StructClass<L>(m, "FitBoxLoad", "A load on a box.")
        .field<&L::name>("name", "Its name.")
        .field<&L::force_n>("force_n", "Total force [N], spread evenly over the nodes.")
        .field<&L::face>("face", "The loaded face.")
        .field<&L::across>("across", "Centre of the load on the face's first axis, 0 to 1.")
        .field<&L::along>("along", "The same on its second axis.")
        .field<&L::nodes_across>("nodes_across", "Loaded nodes on either axis.")
        .field<&L::weight>("weight", "Weight of its distances in the cost.")
        .field<&L::held_out>("held_out", "Used for evaluation only.")
        .done();
    using B = FitBox;
    StructClass<B>(m, "FitBox",
                   "A box of elastic material, held at a face, by finite elements and as a "
                   "lattice of springs.")
        .field<&B::size>("size", "Nodes along x, y, z.")
        .field<&B::spacing_mm>("spacing_mm", "Between them [mm].")
        .field<&B::young_modulus_pa>("young_modulus_pa", "Of the material [Pa].")
        .field<&B::poisson_ratio>("poisson_ratio", "Of the material.")
        .field<&B::fibre>("fibre", "Fibres of the reference; 0: isotropic.")
        .field<&B::fibre_young_modulus_pa>("fibre_young_modulus_pa", "Along the fibres [Pa].")
        .field<&B::fibre_poisson_ratio>("fibre_poisson_ratio", "As of ElasticMaterial.")
        .field<&B::fibre_shear_modulus_pa>("fibre_shear_modulus_pa", "As of ElasticMaterial [Pa].")
        .field<&B::density_kg_per_m3>("density_kg_per_m3", "Of the material [kg/m^3].")
        .field<&B::element>("element", "Of the reference.")
        .field<&B::held>("held", "The held face.")
        .field<&B::links>("links", "Links of the lattice.")
        .field<&B::groups>("groups", "Partition of links and cells.")
        .field<&B::volume_energy>("volume_energy", "Whether there is a group \"volume\".")
        .field<&B::shared_by_cells>("shared_by_cells", "As of springs_of_lattice().")
        .field<&B::damping>("damping", "Whether there is a group \"damping\", of the nodes.")
        .field<&B::damping_start_kg_s>("damping_start_kg_s", "Its first value [kg/s].")
        .field<&B::range>("range", "Bounds of the values: start/range and start range.")
        .done();
    nb::class_<FitBoxProblem>(m, "FitBoxProblem",
                              "Result of fit_box(); the network is in m, kg, s.")
        .def_prop_ro(
            "problem", [](const FitBoxProblem& p) -> const FitProblem& { return p.problem; },
            nb::rv_policy::reference_internal, "For fit().")
        .def_prop_ro(
            "closed_form",
            [](const FitBoxProblem& p) { return array_owning<double>(std::vector(p.closed_form)); },
            nb::sig("def closed_form(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Values in closed form; methods start there.")
        .def_ro("cubic_cells", &FitBoxProblem::cubic_cells,
                "Whether spacings differ by less than 1 %.");
    const Keywords keywords = keywords_of(fit_rows());
    m.def(
        "fit_box",
        [](const FitBox& box, const std::vector<FitBoxLoad>& loads, int threads,
           const nb::kwargs& settings) {
            FitBox made = box;
            made.loads = loads;
            made.settings = fit_settings(settings);
            const Arena arena(threads);
            return take(arena.run_reading([&] { return fit_box(made, arena.tasks()); }));
        },
        nb::arg("box"), nb::arg("loads"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def fit_box(box: FitBox, loads: collections.abc.Sequence[FitBoxLoad], threads: "
              "int = 0, *, run: dict[str, typing.Any] = {}, **settings) -> FitBoxProblem",
              keywords),
        described(
            std::string("The problem of a box: its reference is computed by finite elements.\n\n") +
                kFitArguments,
            keywords));
}

FitMeshLoad load_of_mesh(const nb::object& nodes, Vec3d force_n, const std::string& name,
                         const Array& positions, const Array& displacements, double weight,
                         bool held_out) {
    FitMeshLoad load{name, Nodes(nodes, "nodes").copied(), force_n, {}, weight, held_out};
    if (positions.has_value() != displacements.has_value())
        raise({ErrorCode::InvalidArgument,
               "measured_displacements_mm: expected with measured_positions_mm",
               "measured_displacements_mm"});
    if (!positions) return load;
    const Vectors x(*positions, "measured_positions_mm"),
        u(*displacements, "measured_displacements_mm");
    if (x.rows() != u.rows())
        raise({ErrorCode::InvalidArgument,
               "measured_displacements_mm: expected " + std::to_string(x.rows()) + " rows, found " +
                   std::to_string(u.rows()),
               "measured_displacements_mm"});
    for (std::size_t n = 0; n < x.rows(); ++n)
        load.measured.push_back({x.vectors()[n], u.vectors()[n]});
    return load;
}

void bind_mesh(nb::module_& m) {
    using R = FitRegion;
    StructClass<R>(m, "FitRegion", "A tissue of a mesh.")
        .field<&R::name>("name", "In the names of its groups.")
        .field<&R::young_modulus_pa>("young_modulus_pa", "Of the finite elements, and the start.")
        .field<&R::poisson_ratio>("poisson_ratio", "Of the finite elements.")
        .done();
    nb::class_<FitMeshLoad>(m, "FitMeshLoad", "A load on a mesh.")
        .def(
            "__init__",
            [](FitMeshLoad* self, const nb::object& nodes, Vec3d force_n, const std::string& name,
               const Array& positions, const Array& displacements, double weight, bool held_out) {
                new (self) FitMeshLoad(
                    load_of_mesh(nodes, force_n, name, positions, displacements, weight, held_out));
            },
            nb::arg("nodes"), nb::arg("force_n"), nb::arg("name") = "",
            nb::arg("measured_positions_mm") = nb::none(),
            nb::arg("measured_displacements_mm") = nb::none(), nb::arg("weight") = 1.0,
            nb::arg("held_out") = false,
            nb::sig("def __init__(self, nodes: numpy.typing.ArrayLike, force_n: "
                    "collections.abc.Sequence[float], name: str = \"\", measured_positions_mm: "
                    "numpy.typing.ArrayLike | None = None, measured_displacements_mm: "
                    "numpy.typing.ArrayLike | None = None, weight: float = 1.0, held_out: bool = "
                    "False) -> None"),
            "Args:\n    nodes: Loaded nodes (n,).\n"
            "    force_n: Total force [N], spread evenly over them.\n"
            "    measured_positions_mm, measured_displacements_mm: Of measured points (k, 3) [mm]; "
            "None: finite elements are the reference.");
    using P = FitMeshProblem;
    nb::class_<P>(m, "FitMeshProblem", "Result of fit_mesh(); the network is in mm, g, s.")
        .def_prop_ro(
            "problem", [](const P& p) -> const FitProblem& { return p.problem; },
            nb::rv_policy::reference_internal, "For fit().")
        .def_prop_ro(
            "mesh", [](const P& p) -> const TetMesh& { return p.mesh; },
            nb::rv_policy::reference_internal, "The tetrahedra.")
        .def_prop_ro(
            "closed_form",
            [](const P& p) { return array_owning<double>(std::vector(p.closed_form)); },
            nb::sig("def closed_form(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Shear moduli [Pa], and with a volume energy bulk moduli; methods start there.")
        .def(
            "network",
            [](const P& p, const FitResult& found, const Array& intervals) {
                std::vector<FitInterval> given;
                if (intervals)
                    for (const auto& [low, high] :
                         Numbers<double, 2>(*intervals, "intervals").copied_rows())
                        given.push_back({low, high, std::isfinite(high)});
                if (!given.empty() && given.size() != p.problem.groups().size())
                    raise({ErrorCode::InvalidArgument,
                           "intervals: expected " + std::to_string(p.problem.groups().size()) +
                               " rows, found " + std::to_string(given.size()),
                           "intervals"});
                return network_of(p, found, given);
            },
            nb::arg("found"), nb::arg("intervals") = nb::none(),
            nb::sig("def network(self, found: FitResult, intervals: numpy.typing.ArrayLike | None "
                    "= None) -> NetworkFile"),
            "The network of identified values, for make_network() and files.");
    const Keywords keywords = keywords_of(fit_rows());
    m.def(
        "fit_mesh",
        [](const TetMesh& mesh, const nb::object& held, const std::vector<FitMeshLoad>& loads,
           const std::vector<FitRegion>& regions, const Array& region_of, double density,
           bool volume_energy, double range, int threads, const nb::kwargs& settings) {
            FitMesh made{.mesh = mesh,
                         .held = Nodes(held, "held").copied(),
                         .loads = loads,
                         .density_kg_per_m3 = density,
                         .volume_energy = volume_energy,
                         .range = range,
                         .settings = fit_settings(settings)};
            if (!regions.empty()) made.regions = regions;
            if (region_of) made.region_of = Nodes(*region_of, "region_of").copied();
            const Arena arena(threads);
            return take(arena.run_reading([&] { return fit_mesh(made, arena.tasks()); }));
        },
        nb::arg("mesh"), nb::arg("held"), nb::arg("loads"),
        nb::arg("regions") = std::vector<FitRegion>{}, nb::arg("region_of") = nb::none(),
        nb::arg("density_kg_per_m3") = 1000.0, nb::arg("volume_energy") = false,
        nb::arg("range") = 10.0, nb::arg("threads") = 0, nb::arg("settings"),
        typed("def fit_mesh(mesh: TetMesh, held: numpy.typing.ArrayLike, loads: "
              "collections.abc.Sequence[FitMeshLoad], regions: "
              "collections.abc.Sequence[FitRegion] = (), region_of: numpy.typing.ArrayLike | "
              "None = None, density_kg_per_m3: float = 1000.0, volume_energy: bool = False, "
              "range: float = 10.0, threads: int = 0, *, run: dict[str, typing.Any] = {}, "
              "**settings) -> FitMeshProblem",
              keywords),
        described(
            "A network on the tetrahedra of an organ, against linear finite elements on the same "
            "tetrahedra or against measurements.\n\n"
            "Args:\n"
            "    held: Nodes that don't move (n,).\n"
            "    regions, region_of: Tissues, and that of each tetrahedron (m,).\n"
            "    volume_energy: Whether each region has a bulk modulus, too.\n"
            "    range: Bounds of the values: start/range and start range.\n"
            "    run: Of the solver, settings_of(\"spring_solver\").\n"
            "    **settings",
            keywords));
    nb::class_<CreepResult>(m, "CreepResult", "Result of fit_creep().")
        .def_ro("damping_per_s", &CreepResult::damping_per_s,
                "Of each node's motion, relative to its mass [1/s].")
        .def_prop_ro(
            "at_bound", [](const CreepResult& r) { return text_of(r.at_bound); },
            "\"none\", \"low\" or \"high\".")
        .def_prop_ro(
            "interval",
            [](const CreepResult& r) { return nb::make_tuple(r.interval.low, r.interval.high); },
            nb::sig("def interval(self, /) -> tuple[float, float]"),
            "95 % confidence interval, if noise_mm was given.")
        .def_ro("rms_mm", &CreepResult::rms_mm, "Residual, root mean square of a component [mm].");
    m.def(
        "fit_creep",
        [](const FitMeshProblem& fitted, const nb::object& values, const nb::object& times_s,
           const nb::object& nodes, const nb::object& displacements_mm, std::size_t load,
           double noise_mm, int threads) {
            const auto v = values_of(values);
            const Vectors u(displacements_mm, "displacements_mm");
            const Nodes at(nodes, "nodes");
            const auto times = spread(times_s, u.rows(), "times_s");
            FitCreep creep{.load = load, .noise_mm = noise_mm};
            if (at.rows() != u.rows())
                raise({ErrorCode::InvalidArgument,
                       "nodes: expected " + std::to_string(u.rows()) + ", found " +
                           std::to_string(at.rows()),
                       "nodes"});
            for (std::size_t n = 0; n < u.rows(); ++n)
                creep.samples.push_back({times[n], at.numbers()[n], u.vectors()[n]});
            const Arena arena(threads);
            return take(
                arena.run_reading([&] { return fit_creep(fitted, v, creep, arena.tasks()); }));
        },
        nb::arg("fitted"), nb::arg("values"), nb::arg("times_s"), nb::arg("nodes"),
        nb::arg("displacements_mm"), nb::arg("load") = 0, nb::arg("noise_mm") = 0.0,
        nb::arg("threads") = 0,
        nb::sig("def fit_creep(fitted: FitMeshProblem, values: numpy.typing.ArrayLike, times_s: "
                "numpy.typing.ArrayLike, nodes: numpy.typing.ArrayLike, displacements_mm: "
                "numpy.typing.ArrayLike, load: int = 0, noise_mm: float = 0.0, threads: int = 0) "
                "-> CreepResult"),
        "Damping with which the network creeps as measured under a constant load.\n\n"
        "Args:\n"
        "    times_s, nodes, displacements_mm: Samples (n,), (n,), (n, 3) [mm].\n"
        "    load: Case of the problem.\n"
        "    noise_mm: Above 0: the interval is computed.");
}

}  // namespace

void bind_fits(nb::module_& m) {
    bind_problem_parts(m);
    bind_problem(m);
    bind_fit(m);
    bind_box(m);
    bind_mesh(m);
}

}  // namespace pliant::python
