// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Linear finite elements.

#include <pliant/models/fem.h>

#include "keywords.h"
#include "numbers.h"
#include "struct_class.h"

namespace pliant::python {
namespace {

/// A solver with its threads.
struct PyElastic : Exclusive {
    PyElastic(std::shared_ptr<const Arena> its_arena, ElasticSolver its_solver, std::size_t nodes)
        : arena(std::move(its_arena)), solver(std::move(its_solver)), node_count(nodes) {}

    std::shared_ptr<const Arena> arena;  ///< of all solvers of the same solid
    ElasticSolver solver;
    std::size_t node_count;
};

using Array = std::optional<nb::object>;

/// Raises unless there is a row for each.
void check_rows(std::size_t found, std::size_t expected, const char* name) {
    if (found == expected) return;
    raise({ErrorCode::InvalidArgument,
           std::string(name) + ": expected " + std::to_string(expected) + " rows, found " +
               std::to_string(found),
           name, std::to_string(expected), std::to_string(found)});
}

std::vector<Support> supports_of(const nb::object& held, const Array& axes,
                                 const Array& displacements) {
    const Numbers<std::int32_t, 0> nodes(held, "held");
    std::vector<Support> supports;
    for (const std::int32_t node : nodes.numbers()) supports.push_back({.node = node});
    if (axes) {
        const auto flags = Numbers<bool, 3>(*axes, "held_axes").copied_rows();
        check_rows(flags.size(), supports.size(), "held_axes");
        for (std::size_t n = 0; n < flags.size(); ++n) supports[n].held = flags[n];
    }
    if (displacements) {
        const Numbers<double, 3> vectors(*displacements, "displacement_mm");
        check_rows(vectors.rows(), supports.size(), "displacement_mm");
        for (std::size_t n = 0; n < supports.size(); ++n)
            supports[n].displacement_mm = vectors.vectors()[n];
    }
    return supports;
}

std::vector<std::int32_t> materials_of(const Array& material_of) {
    if (!material_of) return {};
    return Numbers<std::int32_t, 0>(*material_of, "material_of").copied();
}

ElasticLoads loads_of(const Array& nodes, const Array& forces_n, const Array& faces,
                      const Array& traction_pa, const Array& pressure_pa, Vec3d gravity) {
    ElasticLoads loads;
    loads.gravity_m_per_s2 = gravity;
    if (nodes.has_value() != forces_n.has_value())
        raise({ErrorCode::InvalidArgument, "forces_n: expected with nodes", "forces_n"});
    if (nodes) {
        const Numbers<std::int32_t, 0> at(*nodes, "nodes");
        const Numbers<double, 3> forces(*forces_n, "forces_n");
        check_rows(forces.rows(), at.rows(), "forces_n");
        for (std::size_t n = 0; n < at.rows(); ++n)
            loads.forces.push_back({at.numbers()[n], forces.vectors()[n]});
    }
    if (!faces) {
        if (traction_pa || pressure_pa)
            raise({ErrorCode::InvalidArgument, "faces: expected with tractions or pressures",
                   "faces"});
        return loads;
    }
    for (const auto& [cell, face] : Numbers<std::int32_t, 2>(*faces, "faces").copied_rows())
        loads.surfaces.push_back({.face = {cell, face}});
    const std::size_t count = loads.surfaces.size();
    if (pressure_pa) {
        const auto pressures = spread(*pressure_pa, count, "pressure_pa");
        for (std::size_t n = 0; n < count; ++n) loads.surfaces[n].pressure_pa = pressures[n];
    }
    Vec3d one{};
    if (traction_pa && vector_from(*traction_pa, one)) {
        for (SurfaceLoad& load : loads.surfaces) load.traction_pa = one;
    } else if (traction_pa) {
        const Numbers<double, 3> tractions(*traction_pa, "traction_pa");
        check_rows(tractions.rows(), count, "traction_pa");
        for (std::size_t n = 0; n < count; ++n)
            loads.surfaces[n].traction_pa = tractions.vectors()[n];
    }
    return loads;
}

void bind_solver(nb::module_& m) {
    using S = ElasticSolution;
    StructClass<HexLattice>(m, "HexLattice",
                            "A box of nodes along the world's axes, for large regular solids.")
        .field<&HexLattice::size>("size", "Nodes along x, y, z, each 2 or more; x fastest.")
        .field<&HexLattice::spacing_mm>("spacing_mm", "Between neighbours [mm].")
        .field<&HexLattice::origin_mm>("origin_mm", "Position of the first node [mm].")
        .done();
    const auto vectors = [](const char* name) {
        return std::string("def ") + name + "(self, /) -> numpy.typing.NDArray[numpy.float64]";
    };
    nb::class_<S>(m, "ElasticSolution", "Result of ElasticSolver.solve().")
        .def_prop_ro(
            "displacement_mm",
            [](nb::handle self) {
                return viewed_rows(nb::cast<const S&>(self).displacement_mm, self);
            },
            nb::sig(vectors("displacement_mm").c_str()), "Of each node (n, 3) [mm].")
        .def_prop_ro(
            "reaction_n",
            [](nb::handle self) { return viewed_rows(nb::cast<const S&>(self).reaction_n, self); },
            nb::sig(vectors("reaction_n").c_str()),
            "Force of the supports on each node (n, 3) [N]; 0 at free nodes.")
        .def_ro("strain_energy_j", &S::strain_energy_j, "Strain energy [J].")
        .def_ro("iterations", &S::iterations, "Of conjugate gradients; 0 with Cholesky.")
        .def_ro("relative_residual", &S::relative_residual,
                "Norm of f - K u over the free components, relative to that of f.");
    const Keywords keywords = unset(keywords_of(elastic_rows()), {"method"});  // by the mesh
    nb::class_<PyElastic>(
        m, "ElasticSolver",
        "Static linear elasticity on 8-node hexahedra: assembled and factored once, then solved "
        "for any number of loads.\n\n"
        "Example:\n"
        "    >>> mesh = pliant.hex_mesh((10, 10, 10))\n"
        "    >>> bottom = numpy.flatnonzero(mesh.nodes_mm[:, 2] == 0)\n"
        "    >>> steel = pliant.ElasticMaterial(young_modulus_pa=6e5, poisson_ratio=0.45)\n"
        "    >>> solver = pliant.ElasticSolver(mesh, steel, bottom)\n"
        "    >>> solver.solve(nodes=[999], forces_n=[(0, 0, -0.1)]).displacement_mm[999]")
        .def(
            "__init__",
            [](nb::pointer_and_handle<PyElastic> self, const nb::object& mesh,
               const nb::object& materials, const nb::object& held, const Array& held_axes,
               const Array& displacement_mm, const Array& material_of, int threads,
               const nb::kwargs& settings) {
                auto chosen = settings_from<ElasticSettings>(settings, elastic_rows());
                const HexLattice* lattice = nullptr;
                const HexMesh* cells = nullptr;
                if (!nb::try_cast(mesh, lattice) && !nb::try_cast(mesh, cells))
                    raise_value("mesh", "a HexMesh or a HexLattice", mesh);
                if (lattice && !settings.contains("method"))
                    chosen.method = ElasticMethod::ConjugateGradients;
                std::vector<ElasticMaterial> laws;
                const ElasticMaterial* one = nullptr;
                if (nb::try_cast(materials, one) && one)
                    laws = {*one};
                else if (!nb::try_cast(materials, laws))
                    raise_value("materials", "an ElasticMaterial or a list of them", materials);
                auto supports = supports_of(held, held_axes, displacement_mm);
                auto arena = std::make_shared<const Arena>(threads);
                auto law_of = materials_of(material_of);
                auto solver = take(arena->run([&] {
                    if (lattice)
                        return ElasticSolver::create(
                            ElasticLattice{*lattice, std::move(laws), std::move(law_of)},
                            std::move(supports), chosen, arena->tasks());
                    return ElasticSolver::create(
                        ElasticSolid{*cells, std::move(laws), std::move(law_of)},
                        std::move(supports), chosen, arena->tasks());
                }));
                const std::size_t count =
                    lattice ? std::size_t(node_count(*lattice)) : cells->nodes_mm.size();
                new (self.p) PyElastic(std::move(arena), std::move(solver), count);
            },
            nb::arg("mesh"), nb::arg("materials"), nb::arg("held"),
            nb::arg("held_axes") = nb::none(), nb::arg("displacement_mm") = nb::none(),
            nb::arg("material_of") = nb::none(), nb::arg("threads") = 0, nb::arg("settings"),
            typed("def __init__(self, mesh: HexMesh | HexLattice, materials: ElasticMaterial | "
                  "collections.abc.Sequence[ElasticMaterial], held: numpy.typing.ArrayLike, "
                  "held_axes: numpy.typing.ArrayLike | None = None, displacement_mm: "
                  "numpy.typing.ArrayLike | None = None, material_of: numpy.typing.ArrayLike | "
                  "None = None, threads: int = 0, *, **settings) -> None",
                  keywords),
            described(
                "Args:\n"
                "    mesh: A HexLattice is solved without a matrix, by conjugate gradients with "
                "multigrid.\n"
                "    materials: One, or several with material_of.\n"
                "    held: Nodes with supports (n,).\n"
                "    held_axes: Flags (n, 3), the axes along which each is held; None: all.\n"
                "    displacement_mm: Prescribed along the held axes (n, 3); None: 0.\n"
                "    material_of: The material of each cell (m,); None: the first.\n"
                "    **settings\n\n"
                "Raises:\n    pliant.Error: An inverted cell, a modulus out of range, supports "
                "that leave a rigid motion free.",
                keywords))
        .def(
            "with_supports",
            [](const PyElastic& p, const nb::object& held, const Array& held_axes,
               const Array& displacement_mm) {
                const auto supports = supports_of(held, held_axes, displacement_mm);
                auto solver = take(p.arena->run([&] { return p.solver.with_supports(supports); }));
                return PyElastic(p.arena, std::move(solver), p.node_count);
            },
            nb::arg("held"), nb::arg("held_axes") = nb::none(),
            nb::arg("displacement_mm") = nb::none(),
            nb::sig("def with_supports(self, held: numpy.typing.ArrayLike, held_axes: "
                    "numpy.typing.ArrayLike | None = None, displacement_mm: "
                    "numpy.typing.ArrayLike | None = None) -> ElasticSolver"),
            "A solver of the same solid with other supports, for a tool that moves. It shares the "
            "mesh, the materials and the matrix. With the same held components and other "
            "displacements nothing is computed again; otherwise Cholesky factors again, and "
            "conjugate gradients renew the nodes that differ.\n\n"
            "Args:\n"
            "    held: Nodes with supports (n,), in place of all earlier ones.\n"
            "    held_axes: Flags (n, 3), the axes along which each is held; None: all.\n"
            "    displacement_mm: Prescribed along the held axes (n, 3); None: 0.\n\n"
            "Raises:\n    pliant.Error: Supports that leave a rigid motion free; this solver stays "
            "as it is.")
        .def(
            "solve",
            [](const PyElastic& p, const Array& nodes, const Array& forces_n, const Array& faces,
               const Array& traction_pa, const Array& pressure_pa, Vec3d gravity,
               const Array& initial_displacement_mm, int iteration_budget) {
                const auto loads =
                    loads_of(nodes, forces_n, faces, traction_pa, pressure_pa, gravity);
                std::optional<Numbers<double, 3>> start;
                ElasticSolveOptions options{.iteration_budget = iteration_budget};
                if (initial_displacement_mm) {
                    start.emplace(*initial_displacement_mm, "initial_displacement_mm");
                    check_rows(start->rows(), p.node_count, "initial_displacement_mm");
                    options.initial_displacement_mm = start->vectors();
                }
                return take(p.arena->run([&] { return p.solver.solve(loads, options); }));
            },
            nb::arg("nodes") = nb::none(), nb::arg("forces_n") = nb::none(),
            nb::arg("faces") = nb::none(), nb::arg("traction_pa") = nb::none(),
            nb::arg("pressure_pa") = nb::none(), nb::arg("gravity_m_per_s2") = Vec3d{0, 0, 0},
            nb::arg("initial_displacement_mm") = nb::none(), nb::arg("iteration_budget") = 0,
            nb::sig("def solve(self, nodes: numpy.typing.ArrayLike | None = None, forces_n: "
                    "numpy.typing.ArrayLike | None = None, faces: numpy.typing.ArrayLike | None = "
                    "None, traction_pa: numpy.typing.ArrayLike | None = None, pressure_pa: "
                    "numpy.typing.ArrayLike | None = None, gravity_m_per_s2: "
                    "collections.abc.Sequence[float] = (0, 0, 0), initial_displacement_mm: "
                    "numpy.typing.ArrayLike | None = None, iteration_budget: int = 0) -> "
                    "ElasticSolution"),
            "Args:\n"
            "    nodes, forces_n: Forces (n, 3) [N] on nodes (n,).\n"
            "    faces: (k, 2): a cell, and its face 0 to 5 (HexMesh.boundary_faces).\n"
            "    traction_pa: On all faces (3,), or on each (k, 3) [Pa].\n"
            "    pressure_pa: Against their outward normals: one, or of each (k,) [Pa].\n"
            "    gravity_m_per_s2: Acceleration, with the materials' densities.\n"
            "    initial_displacement_mm: Of each node (n, 3), where conjugate gradients start, "
            "such "
            "as the frame before; None: 0.\n"
            "    iteration_budget: Above 0: the displacement after at most that many iterations is "
            "the answer, with its relative_residual; 0: max_iterations must suffice. Cholesky uses "
            "neither.")
        .def(
            "forces_n",
            [](const PyElastic& p, const nb::object& displacement_mm) {
                const Numbers<double, 3> u(displacement_mm, "displacement_mm");
                check_rows(u.rows(), p.node_count, "displacement_mm");
                const nb::gil_scoped_release without_lock;
                auto forces = p.solver.forces_n(u.vectors());
                const nb::gil_scoped_acquire lock;
                return points_of(std::move(forces));
            },
            nb::arg("displacement_mm"),
            nb::sig("def forces_n(self, displacement_mm: numpy.typing.ArrayLike) -> "
                    "numpy.typing.NDArray[numpy.float64]"),
            "K u: the forces (n, 3) [N] that hold the solid in a displacement (n, 3) [mm], without "
            "supports.")
        .def_prop_ro(
            "matrix_bytes", [](const PyElastic& p) { return p.solver.matrix_bytes(); },
            "Memory of the matrix and its factor.");
}

void bind_states(nb::module_& m) {
    m.def(
        "elastic_states",
        [](const HexMesh& mesh, const nb::object& materials, const nb::object& displacement_mm,
           const Array& material_of, const std::string& element, int threads) {
            ElasticSolid solid{mesh, {}, materials_of(material_of)};
            const ElasticMaterial* one = nullptr;
            if (nb::try_cast(materials, one) && one)
                solid.materials = {*one};
            else if (!nb::try_cast(materials, solid.materials))
                raise_value("materials", "an ElasticMaterial or a list of them", materials);
            const Numbers<double, 3> u(displacement_mm, "displacement_mm");
            const auto kind = choice_of<HexElement>(element, "element");
            const Arena arena(threads);
            const auto states = take(
                arena.run([&] { return elastic_states(solid, u.vectors(), kind, arena.tasks()); }));
            const std::size_t cells = mesh.cells.size();
            std::vector<double> strain, stress;
            std::vector<Vec3d> positions;
            const auto add = [](std::vector<double>& to, const SymmetricTensor& t) {
                for (const double x : {t.xx, t.yy, t.zz, t.yz, t.zx, t.xy}) to.push_back(x);
            };
            for (const ElasticState& s : states) {
                positions.push_back(s.position_mm);
                add(strain, s.strain);
                add(stress, s.stress_pa);
            }
            using Shape = std::array<std::size_t, 3>;
            return nb::make_tuple(array_owning<double>(std::move(positions), Shape{cells, 8, 3}),
                                  array_owning<double>(std::move(strain), Shape{cells, 8, 6}),
                                  array_owning<double>(std::move(stress), Shape{cells, 8, 6}));
        },
        nb::arg("mesh"), nb::arg("materials"), nb::arg("displacement_mm"),
        nb::arg("material_of") = nb::none(), nb::arg("element") = "trilinear",
        nb::arg("threads") = 0,
        nb::sig("def elastic_states(mesh: HexMesh, materials: ElasticMaterial | "
                "collections.abc.Sequence[ElasticMaterial], displacement_mm: "
                "numpy.typing.ArrayLike, material_of: numpy.typing.ArrayLike | None = None, "
                "element: str = \"trilinear\", threads: int = 0) -> "
                "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], "
                "numpy.typing.NDArray[numpy.float64]]"),
        "States at each cell's 2 x 2 x 2 Gauss points.\n\n"
        "Returns:\n"
        "    Positions (m, 8, 3) [mm], strains (m, 8, 6) and stresses (m, 8, 6) [Pa]: xx, yy, zz, "
        "yz, zx, xy, shear as tensor components.");
    m.def(
        "von_mises",
        [](const nb::object& stress) {
            const Numbers<double, 6> tensors(stress, "stress");
            std::vector<double> values;
            for (const auto& [xx, yy, zz, yz, zx, xy] : tensors.copied_rows())
                values.push_back(von_mises({xx, yy, zz, yz, zx, xy}));
            return array_owning<double>(std::move(values), tensors.leading_shape());
        },
        nb::arg("stress"),
        nb::sig("def von_mises(stress: numpy.typing.ArrayLike) -> "
                "numpy.typing.NDArray[numpy.float64]"),
        "Von Mises stress (...) of tensors (..., 6): xx, yy, zz, yz, zx, xy.");
}

}  // namespace

void bind_elastic(nb::module_& m) {
    using M = ElasticMaterial;
    StructClass<M>(m, "ElasticMaterial",
                   "Hooke's law: isotropic, or transversely isotropic around a fibre direction.")
        .field<&M::young_modulus_pa>("young_modulus_pa", "Above 0 [Pa]; with fibres: across them.")
        .field<&M::poisson_ratio>("poisson_ratio",
                                  "Above -1, below 0.5; with fibres: in the plane across.")
        .field<&M::density_kg_per_m3>("density_kg_per_m3", "Used by gravity alone [kg/m^3].")
        .field<&M::fibre>("fibre", "Direction of the fibres, of any length; 0: isotropic.")
        .field<&M::fibre_young_modulus_pa>("fibre_young_modulus_pa", "Along the fibres [Pa].")
        .field<&M::fibre_poisson_ratio>("fibre_poisson_ratio",
                                        "Contraction across for extension along the fibres.")
        .field<&M::fibre_shear_modulus_pa>("fibre_shear_modulus_pa",
                                           "In planes that contain the fibres [Pa].")
        .done();
    bind_solver(m);
    bind_states(m);
}

}  // namespace pliant::python
