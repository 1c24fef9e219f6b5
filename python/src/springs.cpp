// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mass-spring networks: parts as arrays, force transmittal, files, and tissues of scans.

#include "keywords.h"
#include "made_tissue.h"
#include "numbers.h"
#include "pickled.h"
#include "struct_class.h"

#include <pliant/models/network_file.h>
#include <pliant/models/scene_files.h>
#include <pliant/models/springs.h>
#include <pliant/tissues.h>

namespace pliant::python {
namespace {

/// A writable array of one member of each of the structs, which self keeps.
template <class T, class Struct>
nb::object column(std::vector<Struct>& rows, T* first, std::size_t columns, nb::handle self) {
    static_assert(sizeof(Struct) % sizeof(T) == 0);
    constexpr auto kStride = std::int64_t(sizeof(Struct) / sizeof(T));
    if (columns == 0)
        return nb::cast(
            nb::ndarray<nb::numpy, T, nb::ndim<1>>(first, {rows.size()}, self, {kStride}));
    return nb::cast(
        nb::ndarray<nb::numpy, T, nb::ndim<2>>(first, {rows.size(), columns}, self, {kStride, 1}));
}

/// Adds a property that views a member. @param columns  0: one number each
template <class Member>
void view(nb::class_<SpringParts>& c, const char* name, const char* type, const Member& member,
          std::size_t columns, const char* text) {
    const std::string sig =
        std::string("def ") + name + "(self, /) -> numpy.typing.NDArray[" + type + "]";
    c.def_prop_ro(
        name,
        [member, columns](nb::handle self) {
            auto& parts = nb::cast<SpringParts&>(self);
            auto [rows, first] = member(parts);
            return column(*rows, first, columns, self);
        },
        nb::sig(sig.c_str()), text);
}

template <class Struct, class Get>
auto member_of(std::vector<Struct> SpringParts::*rows, const Get& get) {
    return [rows, get](SpringParts& parts) {
        auto& v = parts.*rows;
        static Struct none{};
        return std::pair{&v, get(v.empty() ? none : v.front())};
    };
}

SpringParts parts_of(const nb::object& rest, const nb::object& links, const nb::object& mass,
                     const nb::object& stiffness, const nb::object& node_damping,
                     const nb::object& link_damping, const nb::object& rest_length,
                     const std::optional<nb::object>& fixed, const std::optional<nb::object>& cells,
                     const nb::object& bulk) {
    SpringParts parts;
    const Numbers<double, 3> positions(rest, "rest");
    const auto count = positions.rows();
    const auto masses = spread(mass, count, "mass"),
               dampings = spread(node_damping, count, "node_damping");
    for (std::size_t n = 0; n < count; ++n)
        parts.nodes.push_back({positions.vectors()[n], masses[n], dampings[n], false});
    if (fixed) {
        const Numbers<std::int32_t, 0> nodes(*fixed, "fixed");
        for (const std::int32_t n : nodes.numbers()) {
            if (n < 0 || std::size_t(n) >= count)
                raise({ErrorCode::InvalidArgument,
                       "fixed: expected nodes below " + std::to_string(count) + ", found " +
                           std::to_string(n),
                       "fixed"});
            parts.nodes[std::size_t(n)].fixed = true;
        }
    }
    const auto pairs = Numbers<std::int32_t, 2>(links, "links").copied_rows();
    const auto k = spread(stiffness, pairs.size(), "stiffness"),
               d = spread(link_damping, pairs.size(), "link_damping"),
               length = spread(rest_length, pairs.size(), "rest_length");
    for (std::size_t n = 0; n < pairs.size(); ++n)
        parts.links.push_back({pairs[n][0], pairs[n][1], k[n], d[n], length[n]});
    if (!cells) return parts;
    const nb::object shape = nb::module_::import_("numpy").attr("shape")(*cells);
    const auto add = [&](const auto& rows) {
        const auto bulks = spread(bulk, rows.size(), "bulk");
        for (std::size_t n = 0; n < rows.size(); ++n) {
            SpringCell cell{.node_count = std::int32_t(rows[n].size()), .bulk = bulks[n]};
            std::copy(rows[n].begin(), rows[n].end(), cell.nodes.begin());
            parts.cells.push_back(cell);
        }
    };
    if (nb::len(shape) == 2 && nb::cast<int>(shape[nb::int_(1)]) == 4)
        add(Numbers<std::int32_t, 4>(*cells, "cells").copied_rows());
    else
        add(Numbers<std::int32_t, 8>(*cells, "cells").copied_rows());
    return parts;
}

void bind_parts(nb::module_& m) {
    nb::class_<SpringParts> c(m, "SpringParts",
                              "Parts of a mass-spring network. Their arrays are views: change them "
                              "before a network is made of them. Any consistent units; in scans "
                              "mm, g, s, with forces in uN and moduli in Pa.");
    c.def(
        "__init__",
        [](SpringParts* self, const nb::object& rest, const nb::object& links,
           const nb::object& mass, const nb::object& stiffness, const nb::object& node_damping,
           const nb::object& link_damping, const nb::object& rest_length,
           const std::optional<nb::object>& fixed, const std::optional<nb::object>& cells,
           const nb::object& bulk) {
            new (self) SpringParts(parts_of(rest, links, mass, stiffness, node_damping,
                                            link_damping, rest_length, fixed, cells, bulk));
        },
        nb::arg("rest"), nb::arg("links"), nb::arg("mass") = 1.0, nb::arg("stiffness") = 1.0,
        nb::arg("node_damping") = 0.0, nb::arg("link_damping") = 0.0, nb::arg("rest_length") = -1.0,
        nb::arg("fixed") = nb::none(), nb::arg("cells") = nb::none(), nb::arg("bulk") = 0.0,
        nb::sig("def __init__(self, rest: numpy.typing.ArrayLike, links: numpy.typing.ArrayLike, "
                "mass: numpy.typing.ArrayLike = 1.0, stiffness: numpy.typing.ArrayLike = 1.0, "
                "node_damping: numpy.typing.ArrayLike = 0.0, link_damping: numpy.typing.ArrayLike "
                "= 0.0, rest_length: numpy.typing.ArrayLike = -1.0, fixed: numpy.typing.ArrayLike "
                "| None = None, cells: numpy.typing.ArrayLike | None = None, bulk: "
                "numpy.typing.ArrayLike = 0.0) -> None"),
        "Args:\n"
        "    rest: Positions of the nodes at rest (n, 3).\n"
        "    links: Two nodes each (m, 2).\n"
        "    mass, node_damping: Of all nodes, or of each (n,).\n"
        "    stiffness, link_damping, rest_length: Of all links, or of each (m,). A negative "
        "length: the distance at rest.\n"
        "    fixed: Nodes that never move.\n"
        "    cells: Four or eight nodes each, whose volume has an energy.\n"
        "    bulk: Modulus of the volume energy of all cells, or of each.");
    using N = SpringNode;
    using L = SpringLink;
    using C = SpringCell;
    const auto nodes = [&](const auto& get) { return member_of(&SpringParts::nodes, get); };
    const auto links = [&](const auto& get) { return member_of(&SpringParts::links, get); };
    const auto cells = [&](const auto& get) { return member_of(&SpringParts::cells, get); };
    view(c, "rest", "numpy.float64", nodes([](N& n) { return &n.rest.x; }), 3,
         "Positions of the nodes at rest (n, 3).");
    view(c, "mass", "numpy.float64", nodes([](N& n) { return &n.mass; }), 0,
         "Masses of the nodes (n,).");
    view(c, "node_damping", "numpy.float64", nodes([](N& n) { return &n.damping; }), 0,
         "Force per velocity of each node (n,).");
    view(c, "fixed", "numpy.bool", nodes([](N& n) { return &n.fixed; }), 0,
         "Whether each node never moves (n,).");
    view(c, "links", "numpy.int32", links([](L& l) { return &l.a; }), 2,
         "The two nodes of each link (m, 2).");
    view(c, "stiffness", "numpy.float64", links([](L& l) { return &l.stiffness; }), 0,
         "Force per length of each link (m,).");
    view(c, "link_damping", "numpy.float64", links([](L& l) { return &l.damping; }), 0,
         "Force per velocity along each link (m,).");
    view(c, "rest_length", "numpy.float64", links([](L& l) { return &l.rest_length; }), 0,
         "Lengths at rest (m,); negative: the distance at rest.");
    view(c, "branch_stiffness", "numpy.float64", links([](L& l) { return &l.branch_stiffness; }), 0,
         "Force per length of a Maxwell branch (m,); 0: none.");
    view(c, "branch_time", "numpy.float64", links([](L& l) { return &l.branch_time; }), 0,
         "Time in which a branch's force falls to 1/e (m,).");
    view(c, "cells", "numpy.int32", cells([](C& l) { return l.nodes.data(); }), 8,
         "Nodes of each cell (c, 8); of tetrahedra the first four.");
    view(c, "cell_node_count", "numpy.int32", cells([](C& l) { return &l.node_count; }), 0,
         "4 or 8 for each cell (c,).");
    view(c, "bulk", "numpy.float64", cells([](C& l) { return &l.bulk; }), 0,
         "Modulus of each cell's volume energy (c,).");
    c.def(
         "stable_time_step",
         [](const SpringParts& parts) {
             return take(SpringNetwork::create(parts)).stable_time_step();
         },
         "Stability bound of central differences near the rest shape.")
        .def(
            "raise_masses",
            [](SpringParts& parts, double time_step) {
                const auto raised = take(raise_masses(parts, time_step));
                return nb::make_tuple(raised.nodes, raised.share);
            },
            nb::arg("time_step"),
            nb::sig("def raise_masses(self, time_step: float) -> tuple[int, float]"),
            "Raises the masses of light, stiff nodes until a time step is stable. Equilibria don't "
            "depend on masses.\n\n"
            "Returns:\n    Number of raised nodes, and the added mass relative to all before.")
        .def(
            "__copy__", [](const SpringParts& parts) { return parts; },
            nb::sig("def __copy__(self) -> SpringParts"), "A copy with arrays of its own.")
        .def(
            "__deepcopy__", [](const SpringParts& parts, const nb::object&) { return parts; },
            nb::arg("memo"), nb::sig("def __deepcopy__(self, memo: typing.Any) -> SpringParts"),
            "A copy with arrays of its own.")
        .def(
            "__reduce__", [](nb::handle self) { return exchange("reduced_parts")(self); },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def("__repr__", [](const SpringParts& parts) {
            return "SpringParts(" + std::to_string(parts.nodes.size()) + " nodes, " +
                   std::to_string(parts.links.size()) + " links, " +
                   std::to_string(parts.cells.size()) + " cells)";
        });
}

void bind_builders(nb::module_& m) {
    m.def(
        "closed_form",
        [](double young_modulus, double poisson_ratio, double spacing) {
            const auto made = closed_form(young_modulus, poisson_ratio, spacing);
            return nb::make_tuple(made.stiffness, made.bulk);
        },
        nb::arg("young_modulus"), nb::arg("poisson_ratio"), nb::arg("spacing"),
        nb::sig("def closed_form(young_modulus: float, poisson_ratio: float, spacing: float) -> "
                "tuple[float, float]"),
        "Stiffness and bulk modulus of a cubic lattice with edges and face diagonals.");
    m.def(
        "springs_of_lattice",
        [](const nb::object& size, Vec3d spacing, const std::string& links,
           const nb::object& stiffness, double link_damping, double node_damping, double node_mass,
           double density, double bulk, bool shared_by_cells) {
            SpringLattice lattice{.size = FieldOf<Vec3i>::from(size, "size"),
                                  .spacing = spacing,
                                  .links = choice_of<LatticeLinks>(links, "links"),
                                  .link_damping = link_damping,
                                  .node_damping = node_damping,
                                  .node_mass = node_mass,
                                  .density = density,
                                  .bulk = bulk,
                                  .shared_by_cells = shared_by_cells};
            double one = 0;
            lattice.stiffness = nb::try_cast(stiffness, one)
                                    ? Vec3d{one, one, one}
                                    : FieldOf<Vec3d>::from(stiffness, "stiffness");
            return take(springs_of_lattice(lattice));
        },
        nb::arg("size"), nb::arg("spacing") = Vec3d{1, 1, 1}, nb::arg("links") = "edges_and_faces",
        nb::arg("stiffness") = 1.0, nb::arg("link_damping") = 0.0, nb::arg("node_damping") = 0.0,
        nb::arg("node_mass") = 1.0, nb::arg("density") = 0.0, nb::arg("bulk") = 0.0,
        nb::arg("shared_by_cells") = false,
        nb::sig("def springs_of_lattice(size: collections.abc.Sequence[int], spacing: "
                "collections.abc.Sequence[float] = (1, 1, 1), links: str = \"edges_and_faces\", "
                "stiffness: float | collections.abc.Sequence[float] = 1.0, link_damping: float = "
                "0.0, node_damping: float = 0.0, node_mass: float = 1.0, density: float = 0.0, "
                "bulk: float = 0.0, shared_by_cells: bool = False) -> SpringParts"),
        "A box of nodes, the first index fastest.\n\n"
        "Args:\n"
        "    links: \"edges\" (6 neighbours), \"edges_and_faces\" (18) or "
        "\"edges_faces_and_body\" (26).\n"
        "    stiffness: One, or along x, y, z; a link along n has the sum of n_a^2 stiffness_a.\n"
        "    density: Above 0: masses are computed from the cells around a node.\n"
        "    bulk: Of each cell.\n"
        "    shared_by_cells: Each cell has springs of its own, so that a free surface is as soft "
        "as the inside.");
    m.def(
        "springs_of_sheet",
        [](std::int32_t columns, std::int32_t rows, double spacing, double stiffness,
           double link_damping, double node_damping, double node_mass) {
            return take(springs_of_sheet(
                {columns, rows, spacing, stiffness, link_damping, node_damping, node_mass}));
        },
        nb::arg("columns"), nb::arg("rows"), nb::arg("spacing") = 1.0, nb::arg("stiffness") = 1.0,
        nb::arg("link_damping") = 0.0, nb::arg("node_damping") = 0.0, nb::arg("node_mass") = 1.0,
        "Equilateral triangles in the plane z = 0, with six neighbours inside.");
    using Mesh = SpringMesh;
    const auto of_mesh = [&m](const char* name, auto make, const char* cells, const char* text) {
        const std::string sig = std::string("def ") + name + "(mesh: " + cells +
                                ", stiffness: float = 1.0, link_damping: float = 0.0, "
                                "node_damping: float = 0.0, node_mass: float = 1.0, density: float "
                                "= 0.0, bulk: float = 0.0) -> SpringParts";
        m.def(
            name,
            [make](const nb::object& mesh, double stiffness, double link_damping,
                   double node_damping, double node_mass, double density, double bulk) {
                return make(mesh,
                            Mesh{stiffness, link_damping, node_damping, node_mass, density, bulk});
            },
            nb::arg("mesh"), nb::arg("stiffness") = 1.0, nb::arg("link_damping") = 0.0,
            nb::arg("node_damping") = 0.0, nb::arg("node_mass") = 1.0, nb::arg("density") = 0.0,
            nb::arg("bulk") = 0.0, nb::sig(sig.c_str()), text);
    };
    of_mesh(
        "springs_of_triangles",
        [](const nb::object& given, const Mesh& mesh) {
            const auto& triangles = nb::cast<const TriangleMesh&>(given);
            return take(springs_of_triangles(triangles.nodes_mm, triangles.cells, mesh));
        },
        "TriangleMesh", "One link for each edge. Surfaces have no density: node_mass applies.");
    of_mesh(
        "springs_of_tetrahedra",
        [](const nb::object& given, const Mesh& mesh) {
            const auto& tetrahedra = nb::cast<const TetMesh&>(given);
            return take(springs_of_tetrahedra(tetrahedra.nodes_mm, tetrahedra.cells, mesh));
        },
        "TetMesh", "One link for each edge.");
    of_mesh(
        "springs_of_elastic_tetrahedra",
        [](const nb::object& given, const Mesh& mesh) {
            const auto& tetrahedra = nb::cast<const TetMesh&>(given);
            return take(springs_of_elastic_tetrahedra(tetrahedra.nodes_mm, tetrahedra.cells, mesh));
        },
        "TetMesh",
        "One link for each edge, with the stiffness as a shear modulus: exact for regular "
        "tetrahedra at a Poisson's ratio of 1/4.");
    of_mesh(
        "springs_of_hexahedra",
        [](const nb::object& given, const Mesh& mesh) {
            const auto& hexahedra = nb::cast<const HexMesh&>(given);
            return take(springs_of_hexahedra(hexahedra.nodes_mm, hexahedra.cells, mesh));
        },
        "HexMesh", "One link for each edge and face diagonal.");
}

/// A network in motion, with its threads.
struct PySprings : Exclusive {
    PySprings(std::unique_ptr<Arena> its_arena, SpringTissue its_tissue)
        : arena(std::move(its_arena)), tissue(std::move(its_tissue)) {}

    std::unique_ptr<Arena> arena;
    SpringTissue tissue;
};

template <class Get>
nb::object of_all_nodes(const SpringTissue& tissue, const Get& get) {
    std::vector<Vec3d> vectors;
    const std::int32_t count = tissue.network().node_count();
    vectors.reserve(std::size_t(count));
    for (std::int32_t n = 0; n < count; ++n) vectors.push_back(get(n));
    return points_of(std::move(vectors));
}

nb::object matrix(const Mat3d& m) {
    std::vector<double> numbers;
    for (int row = 0; row < 3; ++row)
        for (std::size_t c = 0; c < 3; ++c) numbers.push_back(m.columns[c][row]);
    return array_owning<double>(std::move(numbers), std::array<std::size_t, 2>{3, 3});
}

void bind_motion(nb::class_<PySprings>& c) {
    using P = PySprings;
    c.def(
         "load",
         [](P& p, const nb::object& nodes, const nb::object& forces) {
             const Numbers<std::int32_t, 0> at(nodes, "nodes");
             take(p.tissue.load(at.numbers(), Numbers<double, 3>(forces, "forces").vectors()));
         },
         nb::arg("nodes"), nb::arg("forces"),
         nb::sig("def load(self, nodes: numpy.typing.ArrayLike, forces: numpy.typing.ArrayLike) -> "
                 "None"),
         "Replaces the loads: forces (n, 3) on nodes (n,). Force transmittal starts there.")
        .def(
            "hold",
            [](P& p, const nb::object& nodes) {
                take(p.tissue.hold(Numbers<std::int32_t, 0>(nodes, "nodes").numbers()));
            },
            nb::arg("nodes"), nb::sig("def hold(self, nodes: numpy.typing.ArrayLike) -> None"),
            "Replaces the nodes that a tool holds (n,): only move_held() moves them.")
        .def(
            "move_held",
            [](P& p, const nb::object& positions) {
                take(p.tissue.move_held(Numbers<double, 3>(positions, "positions").vectors()));
            },
            nb::arg("positions"),
            nb::sig("def move_held(self, positions: numpy.typing.ArrayLike) -> None"),
            "Positions of the held nodes (n, 3), in the order of hold().")
        .def(
            "shift_held", [](P& p, Vec3d shift) { take(p.tissue.shift_held(shift)); },
            nb::arg("shift"), "Shifts all held nodes.")
        .def(
            "set_depth", [](P& p, std::int32_t depth) { take(p.tissue.set_depth(depth)); },
            nb::arg("depth"), "Number of layers that forces reach.")
        .def(
            "step",
            [](P& p, std::int32_t count) {
                return take(p.arena->run([&] { return p.tissue.step(count, p.arena->tasks()); }));
            },
            nb::arg("count") = 1,
            "Advances by `count` time steps.\n\n"
            "Raises:\n    pliant.Error: The distorted shape makes the time step unstable; the last "
            "step is undone.")
        .def(
            "find_equilibrium",
            [](P& p, double tolerance) {
                const Arena& arena = *p.arena;
                take(arena.run_reading([&] {
                    return p.tissue.find_equilibrium(tolerance,
                                                     [&] { return arena.tasks().gives_up(); });
                }));
            },
            nb::arg("tolerance") = 1e-9,
            "Moves the active nodes to a static equilibrium by Newton's method. Ctrl-C leaves them "
            "where they were.\n\n"
            "Args:\n    tolerance: Largest remaining force, relative to the largest load or "
            "reaction.")
        .def(
            "set_state",
            [](P& p, std::int32_t node, Vec3d position, Vec3d velocity) {
                take(p.tissue.set_state(node, position, velocity));
            },
            nb::arg("node"), nb::arg("position"), nb::arg("velocity") = Vec3d{0, 0, 0},
            "State of a node, for initial conditions.")
        .def(
            "cut_links",
            [](P& p, const nb::object& links) {
                return take(p.tissue.cut_links(Numbers<std::int32_t, 0>(links, "links").numbers()));
            },
            nb::arg("links"),
            nb::sig("def cut_links(self, links: numpy.typing.ArrayLike) -> SpringCut"),
            "Cuts links (n,), and the volume energy of the cells that have one of them.")
        .def(
            "cut_cells",
            [](P& p, const nb::object& cells) {
                return take(p.tissue.cut_cells(Numbers<std::int32_t, 0>(cells, "cells").numbers()));
            },
            nb::arg("cells"),
            nb::sig("def cut_cells(self, cells: numpy.typing.ArrayLike) -> SpringCut"),
            "Cuts cells out (n,): their volume energy, and all links that lie in no other cell.")
        .def(
            "reset", [](P& p) { p.tissue.reset(); },
            "Returns all nodes to their rest positions; loads and held nodes stay.");
}

void bind_state(nb::class_<PySprings>& c) {
    using P = PySprings;
    c.def_prop_ro(
         "positions",
         [](const P& p) {
             return of_all_nodes(p.tissue, [&](std::int32_t n) { return p.tissue.position(n); });
         },
         nb::sig("def positions(self, /) -> numpy.typing.NDArray[numpy.float64]"),
         "Positions of all nodes (n, 3).")
        .def_prop_ro(
            "velocities",
            [](const P& p) {
                return of_all_nodes(p.tissue, [&](std::int32_t n) { return p.tissue.velocity(n); });
            },
            nb::sig("def velocities(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Velocities of all nodes (n, 3).")
        .def_prop_ro(
            "displacements", [](const P& p) { return points_of(p.tissue.displacements()); },
            nb::sig("def displacements(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Positions minus those at rest (n, 3).")
        .def(
            "reaction",
            [](P& p, const nb::object& nodes, const std::string& law) {
                const Numbers<std::int32_t, 0> at(nodes, "nodes");
                return take(p.tissue.reaction(at.numbers(), choice_of<ReactionLaw>(law, "law")));
            },
            nb::arg("nodes"), nb::arg("law") = "held",
            nb::sig("def reaction(self, nodes: numpy.typing.ArrayLike, law: str = \"held\") -> "
                    "SpringReaction"),
            "Force of the tissue on a tool at these nodes, and its linearisation.\n\n"
            "Args:\n    law: \"held\": the other nodes are held; \"relaxed\": they follow to their "
            "equilibrium.")
        .def_prop_ro(
            "time_step", [](const P& p) { return p.tissue.time_step(); }, "Duration of a step.")
        .def_prop_ro(
            "threads", [](const P& p) { return p.arena->threads(); }, "Number of threads.")
        .def(
            "folded_cells", [](const P& p) { return p.tissue.folded_cells(); },
            "Number of cells with an inverted corner.")
        .def(
            "elastic_energy", [](const P& p) { return p.tissue.elastic_energy(); },
            "Energy of links, their branches, and volumes.")
        .def(
            "kinetic_energy", [](const P& p) { return p.tissue.kinetic_energy(); },
            "Half of the sum of mass times squared velocity.")
        .def(
            "momentum", [](const P& p) { return p.tissue.momentum(); },
            "Sum of mass times velocity.")
        .def(
            "hash", [](const P& p) { return p.tissue.hash(); },
            "Of all positions: the same for any number of threads.")
        .def("__repr__", [](const P& p) {
            return "SpringTissue(" + std::to_string(p.tissue.network().node_count()) +
                   " nodes, time_step=" + std::to_string(p.tissue.time_step()) + ")";
        });
}

void bind_tissue(nb::module_& m) {
    nb::class_<SpringStep>(m, "SpringStep", "Result of SpringTissue.step().")
        .def(Pickled<&SpringStep::steps, &SpringStep::active_nodes, &SpringStep::iterations>())
        .def_ro("steps", &SpringStep::steps, "Number of time steps.")
        .def_ro("active_nodes", &SpringStep::active_nodes, "Nodes that could move.")
        .def_ro("iterations", &SpringStep::iterations,
                "Of conjugate gradients, or of local/global steps.");
    nb::class_<SpringReaction>(m, "SpringReaction",
                               "Force of the tissue on a tool: force(shift) = force + stiffness "
                               "shift, to first order.")
        .def(Pickled<&SpringReaction::force, &SpringReaction::stiffness>())
        .def_ro("force", &SpringReaction::force, "Without a shift.")
        .def_prop_ro(
            "stiffness", [](const SpringReaction& r) { return matrix(r.stiffness); },
            nb::sig("def stiffness(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Symmetric (3, 3), negative definite or 0.");
    nb::class_<SpringCut>(m, "SpringCut", "Connectivity after a cut.")
        .def(Pickled<&SpringCut::cut_links, &SpringCut::cut_cells, &SpringCut::pieces,
                     &SpringCut::loose_nodes>())
        .def_ro("cut_links", &SpringCut::cut_links, "Links that this call has cut.")
        .def_ro("cut_cells", &SpringCut::cut_cells, "Cells that this call has cut.")
        .def_ro("pieces", &SpringCut::pieces, "Connected pieces of the network.")
        .def_ro("loose_nodes", &SpringCut::loose_nodes, "Nodes in pieces without a fixed node.");
    nb::class_<PySprings> c(
        m, "SpringTissue",
        "A mass-spring network that moves in time steps, by force "
        "transmittal from the loaded and held nodes, or by another solver.\n\n"
        "Example:\n"
        "    >>> parts = pliant.springs_of_lattice((10, 10, 10), stiffness=2575)\n"
        "    >>> parts.fixed[:100] = True\n"
        "    >>> tissue = pliant.SpringTissue(parts, depth=10)\n"
        "    >>> tissue.load([955], [(0, 0, -10)])\n"
        "    >>> tissue.step(100)\n"
        "    >>> tissue.positions[955]");
    const Keywords keywords = keywords_of(spring_solver_rows());
    c.def(
        "__init__",
        [](nb::pointer_and_handle<PySprings> self, const SpringParts& parts, int threads,
           const nb::kwargs& settings) {
            const auto chosen = settings_from<SpringSettings>(settings, spring_solver_rows());
            auto arena = std::make_unique<Arena>(threads);
            auto network = take(SpringNetwork::create(parts));
            auto tissue =
                take(arena->run([&] { return SpringTissue::create(std::move(network), chosen); }));
            new (self.p) PySprings(std::move(arena), std::move(tissue));
        },
        nb::arg("parts"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def __init__(self, parts: SpringParts, threads: int = 0, *, **settings) -> "
              "None",
              keywords),
        described("Args:\n    parts: Are copied.\n    **settings", keywords));
    bind_motion(c);
    bind_state(c);
    m.def(
        "transmittal_order",
        [](const SpringParts& parts, const nb::object& sources, std::int32_t depth) {
            const auto network = take(SpringNetwork::create(parts));
            auto order = take(transmittal_order(
                network, Numbers<std::int32_t, 0>(sources, "sources").numbers(), depth));
            return nb::make_tuple(array_owning<std::int32_t>(std::move(order.nodes)),
                                  array_owning<std::int32_t>(std::move(order.layers)));
        },
        nb::arg("parts"), nb::arg("sources"), nb::arg("depth"),
        nb::sig("def transmittal_order(parts: SpringParts, sources: numpy.typing.ArrayLike, depth: "
                "int) -> tuple[numpy.typing.NDArray[numpy.int32], "
                "numpy.typing.NDArray[numpy.int32]]"),
        "Breadth-first order from all sources at once, without fixed nodes.\n\n"
        "Returns:\n    The nodes (n,), and the first of each layer with the total (depth + 2,).");
    m.def(
        "find_depth",
        [](const SpringParts& parts, const nb::object& nodes, const nb::object& forces,
           double threshold, std::int32_t max_depth, double duration, int threads,
           const nb::kwargs& settings) {
            const auto chosen = settings_from<SpringSettings>(settings, spring_solver_rows());
            const auto network = take(SpringNetwork::create(parts));
            const Numbers<std::int32_t, 0> at(nodes, "nodes");
            const Numbers<double, 3> loads(forces, "forces");
            const Arena arena(threads);
            auto found = take(arena.run([&] {
                return find_depth(network, chosen, at.numbers(), loads.vectors(),
                                  {threshold, max_depth, duration}, arena.tasks());
            }));
            return nb::make_tuple(found.depth, array_owning<double>(std::move(found.changes)));
        },
        nb::arg("parts"), nb::arg("nodes"), nb::arg("forces"),
        nb::arg("threshold") = DepthSearch{}.threshold,
        nb::arg("max_depth") = DepthSearch{}.max_depth, nb::arg("duration") = 0.0,
        nb::arg("threads") = 0, nb::arg("settings"),
        typed("def find_depth(parts: SpringParts, nodes: numpy.typing.ArrayLike, forces: "
              "numpy.typing.ArrayLike, threshold: float = 0.01, max_depth: int = 64, duration: "
              "float = 0.0, threads: int = 0, *, **settings) -> tuple[int, "
              "numpy.typing.NDArray[numpy.float64]]",
              keywords),
        "Raises the depth of force transmittal by one layer until the shape changes by less than "
        "the threshold.\n\n"
        "Args:\n    duration: Simulated time for each depth; 0: until equilibrium.\n\n"
        "Returns:\n    The depth (0: not found), and the change from each depth to the next.");
}

void bind_files(nb::module_& m) {
    nb::class_<NetworkGroup>(m, "NetworkGroup", "An identified value of a network.")
        .def_ro("name", &NetworkGroup::name, "Its links, cells or nodes.")
        .def_ro("unit", &NetworkGroup::unit, "Of the value.")
        .def_ro("value", &NetworkGroup::value, "It is contained in the parts.")
        .def_ro("low", &NetworkGroup::low, "95 % confidence interval; both 0: unknown.")
        .def_ro("high", &NetworkGroup::high, "Its upper end.")
        .def_ro("note", &NetworkGroup::note, "Such as \"not identifiable\".");
    nb::class_<NetworkFile>(m, "NetworkFile",
                            "An identified mass-spring network, in mm (LPS), g, s, Pa.")
        .def_ro("mesh", &NetworkFile::mesh, "Name of the mesh's file.")
        .def_prop_ro(
            "parts", [](const NetworkFile& f) -> const SpringParts& { return f.parts; },
            nb::rv_policy::reference_internal, "Its parts.")
        .def_ro("groups", &NetworkFile::groups, "The identified values, for readers.")
        .def(
            "save",
            [](const NetworkFile& f, const std::filesystem::path& path) {
                const auto done = [&] {
                    const nb::gil_scoped_release without_lock;
                    return write_network(path, f);
                }();
                take(done);
            },
            nb::arg("path"), "Writes the JSON file of `pliant fit`. Nothing is half-written.");
    m.def(
        "read_network",
        [](const std::filesystem::path& path) {
            auto read = [&] {
                const nb::gil_scoped_release without_lock;
                return read_network(path);
            }();
            return take(std::move(read));
        },
        nb::arg("path"), "Reads the JSON file of an identified network.");
    const Keywords keywords = keywords_of(network_rows());
    m.def(
        "make_network",
        [](const nb::object& scan, const nb::object& network, int threads,
           const nb::kwargs& settings) {
            const auto chosen = settings_from<NetworkSettings>(settings, network_rows());
            const SpringParts* parts = nullptr;
            const NetworkFile* file = nullptr;
            if (nb::try_cast(network, file) && file)
                parts = &file->parts;
            else if (!nb::try_cast(network, parts) || !parts)
                raise_value("network", "SpringParts or a NetworkFile", network);
            // A copy: the arrays of the given parts can be changed.
            return tissue_of(scan, threads,
                             [&](const Volume& volume, const TaskArena& arena) {
                                 return make_network(volume, *parts, chosen, arena);
                             },
                             {"make_network", nb::make_tuple(scan, SpringParts(*parts)), settings});
        },
        nb::arg("scan"), nb::arg("network"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def make_network(scan: Volume, network: SpringParts | NetworkFile, threads: "
              "int = 0, *, **settings) -> Tissue",
              keywords),
        described("A mass-spring network with nodes of its own in a scan, in mm (LPS), g, s. All "
                  "nodes move in each step, by implicit Euler.\n\nArgs:\n    **settings",
                  keywords));
}

}  // namespace

void bind_springs(nb::module_& m) {
    bind_parts(m);
    bind_builders(m);
    bind_tissue(m);
    bind_files(m);
}

}  // namespace pliant::python
