# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Finite elements and fits, against formulas and against values that are known beforehand."""

import copy

import numpy
import pytest

import pliant
from test_springs import cube

MATERIAL = pliant.ElasticMaterial(young_modulus_pa=6e5, poisson_ratio=0.3)


def bar(**settings):
    """A bar that slides on three planes, so that its stress is uniform."""
    mesh = pliant.hex_mesh((3, 4, 5), (2, 2, 2))
    at_zero = mesh.nodes_mm == 0
    held = numpy.flatnonzero(at_zero.any(axis=1))
    solver = pliant.ElasticSolver(mesh, MATERIAL, held, held_axes=at_zero[held], **settings)
    faces = mesh.boundary_faces()
    corners = numpy.array(
        [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]]
    )
    z = numpy.array(
        [mesh.nodes_mm[mesh.cells[c][corners[f]], 2].mean() for c, f in faces]
    )
    return mesh, solver, faces[z == 8]


@pytest.mark.parametrize(
    "settings", [{}, {"method": "conjugate_gradients"}, {"element": "incompatible_modes"}]
)
def test_a_bar_stretches_by_hooke_s_law(settings):
    mesh, solver, top = bar(**settings)
    assert len(top) == 2 * 3
    found = solver.solve(faces=top, traction_pa=(0, 0, 3000))
    strain = 3000 / 6e5
    expected = mesh.nodes_mm * (-0.3 * strain, -0.3 * strain, strain)
    assert found.displacement_mm == pytest.approx(expected, abs=1e-8)
    area = 4 * 6 * 1e-6
    assert found.reaction_n.sum(axis=0) == pytest.approx((0, 0, -3000 * area), abs=1e-9)
    assert found.strain_energy_j == pytest.approx(0.5 * 3000 * strain * area * 8e-3)
    assert (solver.forces_n(found.displacement_mm)[:, 2].sum()) == pytest.approx(0, abs=1e-9)
    pressed = solver.solve(faces=top, pressure_pa=3000)
    assert pressed.displacement_mm == pytest.approx(-expected, abs=1e-8)
    _, strains, stresses = pliant.elastic_states(
        mesh, MATERIAL, found.displacement_mm, element=settings.get("element", "trilinear")
    )
    assert stresses.shape == (2 * 3 * 4, 8, 6)
    assert stresses[..., 2] == pytest.approx(3000, abs=1e-3)
    assert strains[..., 0] == pytest.approx(-0.3 * strain, abs=1e-9)
    assert pliant.von_mises(stresses) == pytest.approx(3000, abs=1e-3)


def test_supports_may_move_and_forces_superpose():
    mesh = pliant.hex_mesh((4, 4, 4))
    ends = numpy.flatnonzero((mesh.nodes_mm[:, 2] == 0) | (mesh.nodes_mm[:, 2] == 3))
    lifted = numpy.where(mesh.nodes_mm[ends, 2:] == 3, (0.0, 0.0, 0.1), 0.0)
    solver = pliant.ElasticSolver(mesh, [MATERIAL], ends, displacement_mm=lifted)
    assert (solver.solve().displacement_mm[ends] == lifted).all()
    still = pliant.ElasticSolver(mesh, MATERIAL, ends)
    a = still.solve(nodes=[21], forces_n=[(1, 0, 0)]).displacement_mm
    b = still.solve(nodes=[22], forces_n=[(0, 2, 0)]).displacement_mm
    both = still.solve(nodes=[21, 22], forces_n=[(1, 0, 0), (0, 2, 0)]).displacement_mm
    assert both == pytest.approx(a + b, abs=1e-9)
    heavy = MATERIAL.replaced(density_kg_per_m3=1000)
    weight = pliant.ElasticSolver(mesh, heavy, ends).solve(gravity_m_per_s2=(0, 0, -10))
    assert weight.reaction_n[:, 2].sum() == pytest.approx(10 * 1000 * 27e-9, rel=1e-9)


@pytest.mark.parametrize("method", ["cholesky", "conjugate_gradients", "lattice"])
def test_a_tool_moves_frame_by_frame(method):
    size = (8, 8, 8) if method == "lattice" else (5, 5, 6)  # multigrid has two levels
    mesh = pliant.hex_mesh(size)
    z = mesh.nodes_mm[:, 2]
    foot, tool = numpy.flatnonzero(z == 0), numpy.flatnonzero(z == z.max())[:9]
    held = numpy.concatenate((foot, tool))
    if method == "lattice":
        solid, settings = pliant.HexLattice(size=size), {}
    else:
        solid, settings = mesh, {"method": method}
    solver = pliant.ElasticSolver(solid, MATERIAL, foot, **settings)
    assert not solver.solve().displacement_mm.any()
    last = None
    for depth in (0.1, 0.2, 0.25):
        pressed = numpy.where(numpy.isin(held, tool)[:, None], (0.0, 0.0, -depth), 0.0)
        solver = solver.with_supports(held, displacement_mm=pressed)
        new = pliant.ElasticSolver(solid, MATERIAL, held, displacement_mm=pressed, **settings)
        expected = new.solve()
        found = solver.solve()
        assert (found.displacement_mm == expected.displacement_mm).all()
        assert found.iterations == expected.iterations
        if last is not None and method != "cholesky":
            warm = solver.solve(initial_displacement_mm=last)
            assert warm.iterations <= expected.iterations
            again = solver.solve(initial_displacement_mm=expected.displacement_mm)
            assert again.iterations <= 1
            assert warm.displacement_mm == pytest.approx(expected.displacement_mm, abs=1e-8)
            short = solver.solve(initial_displacement_mm=last, iteration_budget=2)
            assert short.iterations == 2
            assert warm.relative_residual < short.relative_residual < 0.5
        last = found.displacement_mm
    rows = f"^initial_displacement_mm: expected {len(z)} rows, found 2$"
    with pytest.raises(pliant.Error, match=rows):
        solver.solve(initial_displacement_mm=[(0, 0, 0)] * 2)
    with pytest.raises(pliant.Error, match="initial_displacement_mm"):
        solver.solve(initial_displacement_mm=last * numpy.nan)
    with pytest.raises(pliant.Error, match="^iteration_budget: expected 0 or more, found -2$"):
        solver.solve(iteration_budget=-2)
    with pytest.raises(pliant.Error, match="supports: leave the solid free"):
        solver.with_supports([0])
    with pytest.raises(pliant.Error, match=f"^held_axes: expected {len(held)} rows, found 1$"):
        solver.with_supports(held, held_axes=[[True] * 3])


def test_bad_solids_are_named():
    mesh = pliant.hex_mesh((2, 2, 2))
    for arguments, message in (
        ({"materials": pliant.ElasticMaterial(), "held": [0, 1, 2, 3]}, "young_modulus_pa"),
        ({"materials": MATERIAL, "held": [0]}, "rigid|supports"),
        ({"materials": 3, "held": [0]}, "materials: expected an ElasticMaterial"),
        ({"materials": MATERIAL, "held": [[0]]}, "held: expected one axis"),
        ({"materials": MATERIAL, "held": [0, 1, 2], "held_axes": [[True] * 3]}, "held_axes"),
        ({"materials": MATERIAL, "held": [0, 1, 2, 3], "method": "lu"}, "method"),
    ):
        with pytest.raises(pliant.Error, match=message):
            pliant.ElasticSolver(mesh, **arguments)
    solver = pliant.ElasticSolver(mesh, MATERIAL, [0, 1, 2, 3])
    with pytest.raises(pliant.Error, match="forces"):
        solver.solve(nodes=[99], forces_n=[(0, 0, 1)])
    with pytest.raises(pliant.Error, match="forces_n: expected 1 rows, found 2"):
        solver.solve(nodes=[7], forces_n=[(0, 0, 1), (0, 0, 1)])
    with pytest.raises(pliant.Error):
        pliant.HexMesh(mesh.nodes_mm, mesh.cells[:, [1, 0, 2, 3, 4, 5, 6, 7]])


def known_problem(factors):
    """A network whose values are known, as a problem that starts elsewhere."""
    parts = pliant.springs_of_lattice((3, 3, 4), stiffness=100)
    parts.fixed[:9] = True
    vertical = numpy.flatnonzero(numpy.diff(parts.rest[parts.links], axis=1)[:, 0, 2] != 0)
    flat = numpy.setdiff1d(numpy.arange(len(parts.links)), vertical)
    members = (vertical, flat)
    truth = copy.deepcopy(parts)
    for links, factor in zip(members, factors, strict=True):
        truth.stiffness[links] *= factor
    groups = [
        pliant.FitGroup(name, 1, 0.1, 10, links=links)
        for name, links in zip(("vertical", "flat"), members, strict=True)
    ]
    loads = [([35], [(0.0, 0.0, -1.0)]), ([30], [(0.5, 0.3, 0.0)])]
    still = [pliant.FitCase(n, f, numpy.zeros((36, 3))) for n, f in loads]
    reference = pliant.FitProblem(truth, groups, still)
    cases = [
        pliant.FitCase(n, f, reference.displacements([1, 1], index), name=f"case {index}")
        for index, (n, f) in enumerate(loads)
    ]
    return pliant.FitProblem(parts, groups, cases)


@pytest.mark.parametrize(
    ("method", "settings"),
    [("gauss_newton", {}), ("annealing", {"seed": 3})],
)
def test_known_values_are_found(method, settings):
    problem = known_problem((3.0, 0.5))
    found = pliant.fit(problem, method, threads=2, **settings)
    if method != "annealing":
        assert found.values == pytest.approx((3, 0.5), rel=1e-3)
        assert found.at.cost < 1e-4
    assert found.at.cost < problem.evaluate([1, 1]).cost
    assert found.at_bound == ["none", "none"] or method == "annealing"
    assert len(found.trace) > 0
    assert (pliant.fit(problem, method, threads=1, **settings).values == found.values).all()
    assert [case.name for case in found.at.cases] == ["case 0", "case 1"]


def test_values_directions_and_intervals():
    problem = known_problem((3.0, 0.5))
    assert problem.evaluate([3, 0.5]).cost == pytest.approx(0, abs=1e-9)
    assert problem.residuals([3, 0.5], 1) == pytest.approx(0, abs=1e-9)
    given = pliant.fit(problem, "given", values=[1, 1])
    assert given.values.tolist() == [1, 1]
    parts = problem.parts_at([3, 0.5])
    assert sorted(set(numpy.round(parts.stiffness, 6))) == sorted(
        {round(s, 6) for s in numpy.unique(parts.stiffness)}
    )
    directions, influences = pliant.fit_directions(problem, [3, 0.5])
    assert numpy.linalg.norm(directions, axis=1) == pytest.approx(1)
    assert (numpy.diff(influences) >= 0).all()
    narrow = pliant.fit_intervals(problem, [3, 0.5], 1e-5)
    wide = pliant.fit_intervals(problem, [3, 0.5], 1e-4)
    assert ((narrow[:, 0] < (3, 0.5)) & (narrow[:, 1] > (3, 0.5))).all()
    assert ((wide[:, 0] < narrow[:, 0]) & (wide[:, 1] > narrow[:, 1])).all()
    for wrong, message in (
        ({"method": "guess"}, "method: expected gauss_newton"),
        ({"method": "given"}, "method"),
        ({"max_steps": -1}, "max_steps"),
    ):
        with pytest.raises(pliant.Error, match=message):
            pliant.fit(problem, **wrong)
    with pytest.raises(pliant.Error, match="values: expected 2, found 1"):
        problem.parts_at([1])


def test_a_box_is_fitted_to_finite_elements():
    box = pliant.FitBox(size=(5, 5, 5), spacing_mm=(25, 25, 25), young_modulus_pa=6e5)
    assert box.poisson_ratio == 0.45
    load = pliant.FitBoxLoad(name="pressed", force_n=(0, 0, -10))
    made = pliant.fit_box(box, [load])
    assert made.cubic_cells
    assert made.closed_form == pytest.approx([0.4 * 6e5 * 0.025])
    found = pliant.fit(made.problem)
    start = made.problem.evaluate(made.closed_form)
    assert found.at.cost <= start.cost
    assert found.at.cases[0].average_percent < found.at.cases[0].still_average_percent
    # The stiffness scales with the modulus.
    twice = pliant.fit(pliant.fit_box(box.replaced(young_modulus_pa=12e5), [load]).problem)
    assert twice.values == pytest.approx(2 * found.values, rel=1e-3)
    with pytest.raises(pliant.Error, match="held: expected low_x"):
        pliant.FitBox(held="bottom")


def test_a_mesh_is_fitted_and_moves(airway, tmp_path):
    surface = pliant.boundary_triangles(cube((-20, -20, -20), 40))
    mesh = pliant.fill_surface(surface, tetrahedra=600)
    z = mesh.nodes_mm[:, 2]
    held, top = numpy.flatnonzero(z < -14), numpy.flatnonzero(z > 16)
    load = pliant.FitMeshLoad(top, (0, 0, -0.5), name="pressed")
    region = pliant.FitRegion(name="block", young_modulus_pa=15e3)
    fitted = pliant.fit_mesh(mesh, held, [load], [region])
    assert fitted.closed_form == pytest.approx([0.4 * 15e3])
    found = pliant.fit(fitted.problem)
    assert found.at.cases[0].average_percent < found.at.cases[0].still_average_percent
    intervals = pliant.fit_intervals(fitted.problem, found.values, 0.01)
    network = fitted.network(found, intervals)
    assert network.groups[0].value == pytest.approx(found.values[0])
    network.save(tmp_path / "network.json")
    read = pliant.read_network(tmp_path / "network.json")
    assert (read.parts.stiffness == network.parts.stiffness).all()
    tissue = pliant.make_network(airway, read)
    assert tissue.push((0, 0, 14), (0, 0, -2), sphere_radius_mm=6).grabbed_elements > 0
    with pytest.raises(pliant.Error, match="intervals: expected 1 rows, found 2"):
        fitted.network(found, [[0, 1], [0, 1]])


def test_creep_gives_the_damping_back():
    mesh = cube((0, 0, 0), 10)
    load = pliant.FitMeshLoad([6], (0, 0, -1e-3))
    fitted = pliant.fit_mesh(mesh, [0, 1, 2, 3], [load])
    values = fitted.closed_form
    final = fitted.problem.displacements(values)[6]
    # Overdamped: the displacement follows 1 - exp(-t / tau), and tau grows with the damping.
    damping = []
    for tau in (0.05, 0.1):
        times = numpy.linspace(0.01, 0.3, 20)
        samples = final * (1 - numpy.exp(-times / tau))[:, None]
        found = pliant.fit_creep(fitted, values, times, numpy.full(20, 6), samples)
        assert found.at_bound == "none"
        assert found.rms_mm < 0.2 * numpy.abs(final).max()
        damping.append(found.damping_per_s)
    assert damping[1] == pytest.approx(2 * damping[0], rel=0.2)
