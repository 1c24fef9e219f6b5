// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vessels: walls, and catheters that are fed into them.

#include <pliant/mesh_files.h>
#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>
#include <pliant/models/vessel.h>

#include "keywords.h"
#include "made_tissue.h"
#include "numbers.h"
#include "pickled.h"
#include "struct_class.h"
#include "vessels.h"

namespace pliant::python {
namespace {

/// Calls work(arena), which may fail, without the interpreter's lock; Ctrl-C ends it.
template <class Work>
auto taken(int threads, const Work& work) {
    const Arena arena(threads);
    return take(arena.run([&] { return work(arena.tasks()); }));
}

std::vector<CentrePoint> branch_of(const nb::object& given, const char* name) {
    const Numbers<double, 4> rows(given, name);
    std::vector<CentrePoint> branch;
    for (const auto& [x, y, z, radius] : rows.copied_rows()) branch.push_back({{x, y, z}, radius});
    return branch;
}

Centreline centreline_of_branches(const nb::list& branches) {
    Centreline line;
    for (const nb::handle branch : branches)
        line.branches.push_back(branch_of(nb::borrow(branch), "branches"));
    return line;
}

nb::list branches_of(const Centreline& line) {
    nb::list branches;
    for (const auto& branch : line.branches) {
        std::vector<double> numbers;
        for (const CentrePoint& p : branch)
            for (const double x : {p.position_mm.x, p.position_mm.y, p.position_mm.z, p.radius_mm})
                numbers.push_back(x);
        branches.append(
            array_owning<double>(std::move(numbers), std::array{branch.size(), std::size_t(4)}));
    }
    return branches;
}

template <std::size_t kCount>
nb::object indices_of(const std::vector<std::array<std::int32_t, kCount>>& cells) {
    std::vector<std::int32_t> numbers;
    for (const auto& cell : cells) numbers.insert(numbers.end(), cell.begin(), cell.end());
    return array_owning<std::int32_t>(std::move(numbers), std::array{cells.size(), kCount});
}

nb::tuple state_of(const VesselWall& w) {
    std::vector<double> places;
    for (const Embedded& e : w.ghost_positions) {
        places.push_back(e.tetrahedron);
        places.insert(places.end(), e.weights.begin(), e.weights.end());
    }
    nb::list ends;
    for (const VesselEnd& e : w.ends)
        ends.append(nb::make_tuple(e.centre_mm, e.outward, e.radius_mm));
    return nb::make_tuple(
        points_of(w.mesh.nodes_mm), indices_of(w.mesh.cells), points_of(w.ghost.nodes_mm),
        indices_of(w.ghost.cells),
        array_owning<double>(std::move(places),
                             std::array<std::size_t, 2>{w.ghost_positions.size(), 5}),
        ends, w.min_layers, w.lumen_mm3, w.cell_mm, w.dropped_pieces, w.refined_because);
}

VesselWall wall_from(const nb::tuple& state) {
    VesselWall w;
    const auto part = [&](std::size_t n) { return nb::borrow(state[n]); };
    w.mesh.nodes_mm = Numbers<double, 3>(part(0), "mesh").copied_vectors();
    w.mesh.cells = Numbers<std::int32_t, 4>(part(1), "mesh").copied_rows();
    w.ghost.nodes_mm = Numbers<double, 3>(part(2), "ghost").copied_vectors();
    w.ghost.cells = Numbers<std::int32_t, 3>(part(3), "ghost").copied_rows();
    for (const auto& row : Numbers<double, 5>(part(4), "ghost_positions").copied_rows())
        w.ghost_positions.push_back({std::int32_t(row[0]), {row[1], row[2], row[3], row[4]}});
    for (const nb::handle each : nb::cast<nb::list>(part(5))) {
        const auto end = nb::cast<nb::tuple>(each);
        w.ends.push_back(
            {nb::cast<Vec3d>(end[0]), nb::cast<Vec3d>(end[1]), nb::cast<double>(end[2])});
    }
    w.min_layers = nb::cast<int>(part(6));
    w.lumen_mm3 = nb::cast<double>(part(7));
    w.cell_mm = nb::cast<double>(part(8));
    w.dropped_pieces = nb::cast<int>(part(9));
    w.refined_because = nb::cast<std::string>(part(10));
    return w;
}

void bind_walls(nb::module_& m) {
    nb::class_<VesselEnd>(m, "VesselEnd", "A cut through a vessel with an open wall.")
        .def(
            "__init__",
            [](VesselEnd* self, Vec3d centre_mm, Vec3d outward, double radius_mm) {
                new (self) VesselEnd{centre_mm, outward, radius_mm};
            },
            nb::arg("centre_mm"), nb::arg("outward"), nb::arg("radius_mm"),
            "Args:\n    centre_mm: Its middle [mm, LPS].\n    outward: Unit vector, LPS.\n"
            "    radius_mm: Of the lumen there.")
        .def_ro("centre_mm", &VesselEnd::centre_mm, "Its middle [mm, LPS].")
        .def_ro("outward", &VesselEnd::outward, "Unit vector out of the vessel, LPS.")
        .def_ro("radius_mm", &VesselEnd::radius_mm, "Radius of the lumen there [mm].")
        .def("__repr__", [](const VesselEnd& e) {
            return "VesselEnd(radius_mm=" + std::to_string(e.radius_mm) + ")";
        });
    nb::class_<VesselWall>(m, "VesselWall",
                           "The wall of a vessel: tetrahedra of a given thickness around the "
                           "lumen, whose surface (the ghost) is embedded in them.")
        .def_prop_ro(
            "mesh", [](const VesselWall& w) -> const TetMesh& { return w.mesh; },
            nb::rv_policy::reference_internal, "The tetrahedra, a TetMesh.")
        .def_prop_ro(
            "ghost", [](const VesselWall& w) -> const TriangleMesh& { return w.ghost; },
            nb::rv_policy::reference_internal, "The lumen's surface, which faces the lumen.")
        .def_ro("ends", &VesselWall::ends, "The open ends, a list of VesselEnd.")
        .def_ro("min_layers", &VesselWall::min_layers,
                "Minimum number of edges from the inner to the outer surface.")
        .def_ro("lumen_mm3", &VesselWall::lumen_mm3,
                "Volume inside of the ghost and its open ends [mm^3].")
        .def_ro("cell_mm", &VesselWall::cell_mm, "Edge of the lattice [mm]; 0: no lattice.")
        .def_ro("refined_because", &VesselWall::refined_because,
                "Fault of a larger lattice; empty: none.")
        .def(
            "check",
            [](const VesselWall& w, int layers) {
                const auto done = [&] {
                    const nb::gil_scoped_release without_lock;
                    return check_wall(w, layers);
                }();
                take(done);
            },
            nb::arg("layers") = 1,
            "Raises pliant.Error for a wall in several pieces, a surface that isn't a manifold, "
            "other openings than the ends, or fewer layers of tetrahedra.")
        .def("__getstate__", &state_of, nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"))
        .def(
            "__setstate__",
            [](VesselWall& w, const nb::tuple& state) { new (&w) VesselWall(wall_from(state)); },
            nb::arg("state"),
            nb::sig("def __setstate__(self, state: tuple[typing.Any, ...]) -> None"))
        .def("__repr__", [](const VesselWall& w) {
            return "VesselWall(" + std::to_string(w.mesh.cells.size()) + " tetrahedra, " +
                   std::to_string(w.ends.size()) + " ends)";
        });
    const Keywords keywords = keywords_of(wall_rows());
    m.def(
        "wall_around_centreline",
        [](const nb::list& branches, int threads, const nb::kwargs& settings) {
            const auto chosen = settings_from<WallSettings>(settings, wall_rows());
            const Centreline line = centreline_of_branches(branches);
            return taken(threads, [&](const TaskArena& arena) {
                return wall_around_centreline(line, chosen, arena);
            });
        },
        nb::arg("branches"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def wall_around_centreline(branches: list[numpy.typing.ArrayLike], threads: int = "
              "0, *, **settings) -> VesselWall",
              keywords),
        described("The wall around a tree of spheres along a centreline. It is open at each end of "
                  "a branch that lies in no other branch.\n\n"
                  "Args:\n"
                  "    branches: An array (n, 4) for each: position [mm, LPS] and radius [mm].\n"
                  "    **settings",
                  keywords));
    m.def(
        "wall_around_surface",
        [](const TriangleMesh& lumen, const std::vector<VesselEnd>& ends, int threads,
           const nb::kwargs& settings) {
            const auto chosen = settings_from<WallSettings>(settings, wall_rows());
            return taken(threads, [&](const TaskArena& arena) {
                return wall_around_surface(lumen, ends, chosen, arena);
            });
        },
        nb::arg("lumen"), nb::arg("ends") = std::vector<VesselEnd>{}, nb::arg("threads") = 0,
        nb::arg("settings"),
        typed("def wall_around_surface(lumen: TriangleMesh, ends: "
              "collections.abc.Sequence[VesselEnd] = (), threads: int = 0, *, **settings) "
              "-> VesselWall",
              keywords),
        described("The wall around a surface. It is open where the surface is open; a closed "
                  "surface is cut off at the ends.\n\nArgs:\n    **settings",
                  keywords));
    m.def(
        "wall_of_mesh",
        [](const TetMesh& mesh, const std::optional<TriangleMesh>& lumen, int threads) {
            return taken(threads, [&](const TaskArena& arena) {
                return wall_of_mesh(mesh, lumen ? *lumen : TriangleMesh{}, arena);
            });
        },
        nb::arg("mesh"), nb::arg("lumen") = nb::none(), nb::arg("threads") = 0,
        "A wall of given tetrahedra. The ends are the openings of its inner surface.\n\n"
        "Args:\n"
        "    lumen: The inner surface, open at the ends; None: the part of the boundary between "
        "sharp rims that encloses the lumen.");
    m.def(
        "swept_tube",
        [](const nb::object& branch, double thickness_mm, int layers, int sectors, double ring_mm) {
            const auto points = branch_of(branch, "branch");
            const TubeSettings settings{thickness_mm, layers, sectors, ring_mm};
            return taken(1, [&](const TaskArena&) { return swept_tube(points, settings); });
        },
        nb::arg("branch"), nb::arg("thickness_mm") = TubeSettings{}.thickness_mm,
        nb::arg("layers") = TubeSettings{}.layers, nb::arg("sectors") = TubeSettings{}.sectors,
        nb::arg("ring_mm") = TubeSettings{}.ring_mm,
        nb::sig("def swept_tube(branch: numpy.typing.ArrayLike, thickness_mm: float = 1.5, layers: "
                "int = 2, sectors: int = 24, ring_mm: float = 0.0) -> VesselWall"),
        "Sweeps the wall of one branch along it, in rings of hexahedra of six tetrahedra each.\n\n"
        "Args:\n"
        "    branch: (n, 4), position [mm, LPS] and radius [mm].\n"
        "    sectors: Around the tube.\n"
        "    ring_mm: Distance of rings along the tube; 0: the width of a sector.");
    m.def(
        "centreline_of",
        [](const std::filesystem::path& path) {
            const auto read = [&]() -> Result<Centreline> {
                const nb::gil_scoped_release without_lock;
                const auto mesh = read_mesh(path);
                if (!mesh.ok()) return mesh.error();
                return centreline_of(*mesh);
            }();
            return branches_of(take(read));
        },
        nb::arg("path"),
        nb::sig("def centreline_of(path: str | os.PathLike[str]) -> "
                "list[numpy.typing.NDArray[numpy.float64]]"),
        "Branches of a file of lines (VTP, VTK), such as VMTK's: arrays (n, 4) of positions [mm, "
        "LPS] and radii [mm].");
    m.def(
        "phantom_centreline",
        [](const std::string& name) { return branches_of(take(phantom_centreline(name))); },
        nb::arg("name"),
        nb::sig("def phantom_centreline(name: str) -> list[numpy.typing.NDArray[numpy.float64]]"),
        "Branches of a synthetic vessel: arrays (n, 4) of positions [mm, LPS] and radii [mm].\n\n"
        "Args:\n"
        "    name: \"bend\" or \"arch\", tubes; or \"aorta\", whose first branch leads from the "
        "descending aorta to the ascending one; then follow the left subclavian, left carotid, "
        "brachiocephalic, right subclavian and right carotid artery.");
    m.def(
        "ends_of",
        [](const nb::list& branches, double inwards) {
            return ends_of(centreline_of_branches(branches), inwards);
        },
        nb::arg("branches"), nb::arg("inwards") = 0.0,
        nb::sig("def ends_of(branches: list[numpy.typing.ArrayLike], inwards: float = 0.0) -> "
                "list[VesselEnd]"),
        "Open ends of a centreline, each moved inwards by this fraction of its radius.");
    nb::class_<Lumen>(m, "Lumen", "A vessel's lumen in a scan.")
        .def_prop_ro(
            "surface", [](const Lumen& l) -> const TriangleMesh& { return l.surface; },
            nb::rv_policy::reference_internal, "Closed surface, which faces outwards.")
        .def_ro("ends", &Lumen::ends, "Openings at the scan's border, a list of VesselEnd.")
        .def_ro("voxels", &Lumen::voxels, "Number of its voxels.")
        .def_ro("region_mm3", &Lumen::region_mm3, "Their volume [mm^3].");
    m.def(
        "lumen_of_region",
        [](const PyVolume& scan, Vec3d seed_mm, double low, double high, double smoothing_voxels,
           const std::optional<nb::object>& way_mm, double within_mm, double max_ml, int threads) {
            RegionSettings settings{.seed_mm = seed_mm,
                                    .low = low,
                                    .high = high,
                                    .smoothing_voxels = smoothing_voxels,
                                    .within_mm = within_mm,
                                    .max_ml = max_ml};
            if (way_mm) settings.way_mm = Numbers<double, 3>(*way_mm, "way_mm").copied_vectors();
            return taken(threads, [&](const TaskArena& arena) {
                return lumen_of_region(scan.volume, settings, arena);
            });
        },
        nb::arg("scan"), nb::arg("seed_mm"), nb::arg("low"), nb::arg("high"),
        nb::arg("smoothing_voxels") = 0.8, nb::arg("way_mm") = nb::none(),
        nb::arg("within_mm") = 15.0, nb::arg("max_ml") = 0.0, nb::arg("threads") = 0,
        nb::sig("def lumen_of_region(scan: Volume, seed_mm: collections.abc.Sequence[float] | "
                "numpy.typing.NDArray[typing.Any], low: float, high: float, smoothing_voxels: "
                "float = 0.8, way_mm: numpy.typing.ArrayLike | None = None, within_mm: float = "
                "15.0, max_ml: float = 0.0, threads: int = 0) -> Lumen"),
        "The region connected with a seed [mm, LPS] through voxels between two values, as a "
        "surface.\n\n"
        "Args:\n"
        "    smoothing_voxels: Of the region's edge, a standard deviation.\n"
        "    way_mm: Points (n, 3) that limit the region to a distance of within_mm.\n"
        "    max_ml: A larger region is refused as a leak; 0: no limit.");
    m.def(
        "lumen_of_labels",
        [](const PyVolume& labels, const std::vector<int>& wanted, double smoothing_voxels,
           int threads) {
            return taken(threads, [&](const TaskArena& arena) {
                return lumen_of_labels(labels.volume, wanted, smoothing_voxels, arena);
            });
        },
        nb::arg("labels"), nb::arg("wanted") = std::vector<int>{1},
        nb::arg("smoothing_voxels") = 0.8, nb::arg("threads") = 0,
        "The largest connected part of the voxels with one of these labels, as a surface.");
    m.def(
        "scan_of_vessel",
        [](const VesselWall& wall, int threads) {
            return PyVolume{
                taken(threads, [&](const TaskArena& arena) { return scan_of_vessel(wall, arena); }),
                {}};
        },
        nb::arg("wall"), nb::arg("threads") = 0,
        "A synthetic scan of a vessel with contrast agent: the lumen at 300 HU, its wall at 90.");
}

/// A scene with its threads.
struct PyCatheter : Exclusive {
    PyCatheter(std::unique_ptr<Arena> its_arena, CatheterScene its_scene, CatheterSettings settings)
        : arena(std::move(its_arena)), scene(std::move(its_scene)), given(std::move(settings)) {}

    std::unique_ptr<Arena> arena;
    CatheterScene scene;
    CatheterSettings given;  ///< at first, for copies
};

std::unique_ptr<PyCatheter> catheter_in(VesselWall wall, const CatheterSettings& settings,
                                        int threads) {
    auto arena = std::make_unique<Arena>(threads);
    auto scene = take(arena->run([&] { return CatheterScene::create(std::move(wall), settings); }));
    return std::make_unique<PyCatheter>(std::move(arena), std::move(scene), settings);
}

nb::object matrix_of(const Rotation& frame) {
    std::vector<double> numbers;
    const Vec3d axes[] = {rotated(frame, {1, 0, 0}), rotated(frame, {0, 1, 0}),
                          rotated(frame, {0, 0, 1})};
    for (int row = 0; row < 3; ++row)
        for (const Vec3d& axis : axes) numbers.push_back(axis[row]);
    return array_owning<double>(std::move(numbers), std::array<std::size_t, 2>{3, 3});
}

void bind_measures(nb::module_& m) {
    using M = CatheterMeasures;
    nb::class_<VolumeChange>(m, "VolumeChange", "Change of the wall's volumes.")
        .def(Pickled<&VolumeChange::total, &VolumeChange::mean, &VolumeChange::largest>())
        .def_ro("total", &VolumeChange::total, "Of the sum of all volumes, relative.")
        .def_ro("mean", &VolumeChange::mean, "Mean of the absolute relative changes.")
        .def_ro("largest", &VolumeChange::largest, "Largest absolute relative change.");
    nb::class_<M>(m, "CatheterMeasures", "Figures of a catheter's present state.")
        .def(Pickled<&M::steps, &M::time_s, &M::inserted_mm, &M::rotated_deg, &M::force_n,
                     &M::torque_n_mm, &M::contact_n, &M::largest_contact_n, &M::contact_mm_per_n,
                     &M::wall_moved_mm, &M::depth_mm, &M::wire_energy_mj, &M::wall_energy_mj,
                     &M::kinetic_energy_mj, &M::volume, &M::inverted, &M::active_tetrahedra,
                     &M::sub_steps, &M::needed_sub_steps, &M::left_end>())
        .def_ro("steps", &M::steps, "Time steps since the start.")
        .def_ro("time_s", &M::time_s, "Simulated time [s].")
        .def_ro("inserted_mm", &M::inserted_mm, "Inserted length [mm].")
        .def_ro("rotated_deg", &M::rotated_deg, "Rotation of the hand [degrees].")
        .def_ro("force_n", &M::force_n, "Along the guide, reaction on the hand [N].")
        .def_ro("torque_n_mm", &M::torque_n_mm, "About the guide's axis [N mm].")
        .def_ro("contact_n", &M::contact_n, "Sum of the contact forces on the wall [N].")
        .def_ro("largest_contact_n", &M::largest_contact_n, "The largest of these forces [N].")
        .def_ro("contact_mm_per_n", &M::contact_mm_per_n, "Compliance of the contacts [mm/N].")
        .def_ro("wall_moved_mm", &M::wall_moved_mm,
                "Largest distance of a wall's node from its rest position [mm].")
        .def_ro("depth_mm", &M::depth_mm, "Penetration of the ghost [mm]; negative: distance.")
        .def_ro("wire_energy_mj", &M::wire_energy_mj, "Elastic energy of the wire [mJ].")
        .def_ro("wall_energy_mj", &M::wall_energy_mj, "Elastic energy of the wall [mJ].")
        .def_ro("kinetic_energy_mj", &M::kinetic_energy_mj, "Kinetic energy [mJ].")
        .def_ro("volume", &M::volume, "Change of the wall's volumes.")
        .def_ro("inverted", &M::inverted, "Tetrahedra of wall and catheter with negative volume.")
        .def_ro("active_tetrahedra", &M::active_tetrahedra, "Tetrahedra of the wall that move.")
        .def_ro("sub_steps", &M::sub_steps, "Sub-steps of the last step.")
        .def_ro("needed_sub_steps", &M::needed_sub_steps,
                "Number that the wire's tip and waves in the wall need; at most 1000 are made.")
        .def_ro(
            "left_end", &M::left_end,
            "Number of the open end through which the tip has left the vessel, from 1; 0: none.")
        .def(
            "warnings", [](const M& measures) { return warnings_of(measures); },
            "Faults, one line each: penetration by more than 0.1 mm, inverted tetrahedra, too "
            "few sub-steps, a tip "
            "outside of the vessel.")
        .def("__repr__", [](const M& measures) {
            return "CatheterMeasures(time_s=" + std::to_string(measures.time_s) +
                   ", inserted_mm=" + std::to_string(measures.inserted_mm) +
                   ", force_n=" + std::to_string(measures.force_n) + ")";
        });
}

Status save(const CatheterScene& scene, const std::filesystem::path& wall,
            const std::optional<std::filesystem::path>& wire) {
    const auto positions = scene.wall_positions();
    std::vector<Vec3d> moved = positions;
    for (std::size_t n = 0; n < moved.size(); ++n)
        moved[n] = positions[n] - scene.wall().mesh.nodes_mm[n];
    const TetMesh mesh{positions, scene.wall().mesh.cells};
    if (const Status s = write_vtu(wall, mesh, {.node_vectors = {{"displacement_mm", moved}}});
        !s.ok() || !wire)
        return s;
    const auto nodes = scene.wire_positions();
    std::vector<std::int32_t> line;
    for (std::size_t n = 0; n < nodes.size(); ++n) line.push_back(std::int32_t(n));
    return write_lines(*wire, nodes, std::array{line});
}

void bind_scene(nb::module_& m) {
    using P = PyCatheter;
    const Keywords keywords = without(keywords_of(catheter_rows()), {"place_mm", "direction"});
    nb::class_<P> c(m, "CatheterScene",
                    "A catheter that is fed into a vessel through a guide. Wall and wire "
                    "deform; contact is solved within the wire's Newton steps.\n\n"
                    "Example:\n"
                    "    >>> scene = pliant.CatheterScene(wall, entry=1)\n"
                    "    >>> scene.command(insert_mm_s=50, bend_first_deg=20)\n"
                    "    >>> scene.step(1000)                     # of a millisecond each\n"
                    "    >>> scene.measures().force_n, scene.wire_positions, scene.wall_positions\n"
                    "\nA call that raises has changed nothing. One thread at a time.");
    c.def(
         "__init__",
         [](nb::pointer_and_handle<P> self, const VesselWall& wall, const nb::object& entry,
            double inwards, double inserted_mm, int threads, const nb::kwargs& settings) {
             auto chosen = settings_from<CatheterSettings>(settings, catheter_rows());
             chosen.entry = entry_of(entry, inwards, inserted_mm, wall);
             new (self.p) P(std::move(*catheter_in(wall, chosen, threads)));
         },
         nb::arg("wall"), nb::arg("entry") = 0, nb::arg("inwards") = 0.5,
         nb::arg("inserted_mm") = CatheterEntry{}.inserted_mm, nb::arg("threads") = 0,
         nb::arg("settings"),
         typed("def __init__(self, wall: VesselWall, entry: int | VesselEnd | "
               "tuple[collections.abc.Sequence[float], collections.abc.Sequence[float]] = 0, "
               "inwards: float = 0.5, inserted_mm: float = 5.0, threads: int = 0, *, "
               "**settings) -> None",
               keywords),
         described(
             "Args:\n"
             "    entry: End of the guide: a number of wall.ends from 0, a VesselEnd, or a "
             "position [mm, LPS] and a direction into the vessel.\n"
             "    inwards: Fraction of the end's radius by which it is inside of the vessel.\n"
             "    inserted_mm: Length inserted at the start.\n"
             "    threads: 0: one for each core. The result is the same to the bit.\n"
             "    **settings",
             keywords))
        .def_prop_ro(
            "threads", [](const P& p) { return p.arena->threads(); }, "Number of threads.")
        .def_prop_ro(
            "wall", [](const P& p) -> const VesselWall& { return p.scene.wall(); },
            nb::rv_policy::reference_internal, "The wall at rest.")
        .def_prop_ro(
            "settings",
            [](const P& p) { return dict_of(record_of(p.scene.settings(), catheter_rows())); },
            nb::sig("def settings(self, /) -> dict[str, typing.Any]"),
            "All settings, with the actual sub-steps and reach.")
        .def(
            "command",
            [](P& p, double insert, double rotate, double first, double second) {
                take(p.scene.command({insert, rotate, first, second}));
            },
            nb::arg("insert_mm_s") = 0.0, nb::arg("rotate_deg_s") = 0.0,
            nb::arg("bend_first_deg") = 0.0, nb::arg("bend_second_deg") = 0.0,
            "Motion of the hand, in force until the next command.\n\n"
            "Args:\n"
            "    insert_mm_s: Speed of advance; negative: withdraws.\n"
            "    rotate_deg_s: Speed of rotation.\n"
            "    bend_first_deg, bend_second_deg: Of the tip, about two perpendicular axes.")
        .def(
            "step",
            [](P& p, std::int32_t count) {
                take(p.arena->run([&] { return p.scene.step(count, p.arena->tasks()); }));
            },
            nb::arg("count") = 1,
            "Advances by `count` time steps. The wire stops at the end of its length.\n\n"
            "Raises:\n    pliant.Error: limit_exceeded if a position is no longer finite: earlier "
            "steps of the call remain.")
        .def(
            "measures",
            [](const P& p) {
                const nb::gil_scoped_release without_lock;
                return p.scene.measures();
            },
            "All figures. Needs a pass over the wall.")
        .def(
            "quick_measures", [](const P& p) { return p.scene.quick_measures(); },
            "Inserted length, force, torque, contact, depth, time and sub-steps alone.")
        .def_prop_ro(
            "wire_positions",
            [](const P& p) {
                const auto nodes = p.scene.wire_positions();
                return points_of({nodes.begin(), nodes.end()});
            },
            nb::sig("def wire_positions(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "All nodes of the wire (n, 3), the tip last [mm, LPS].")
        .def_prop_ro(
            "first_inserted", [](const P& p) { return p.scene.first_inserted(); },
            "Index of the wire's last node inside the guide.")
        .def_prop_ro(
            "tip_mm", [](const P& p) { return p.scene.tip_mm(); }, "The tip [mm, LPS].")
        .def_prop_ro(
            "tip_frame", [](const P& p) { return matrix_of(p.scene.tip_frame()); },
            nb::sig("def tip_frame(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "3 x 3 matrix whose columns are the tip's axes: the third points ahead, the tip bends "
            "about the first two.")
        .def_prop_ro(
            "wall_positions", [](const P& p) { return points_of(p.scene.wall_positions()); },
            nb::sig("def wall_positions(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Nodes of the wall (n, 3), in the order of wall.mesh [mm, LPS].")
        .def_prop_ro(
            "ghost_positions", [](const P& p) { return points_of(p.scene.ghost_positions()); },
            nb::sig("def ghost_positions(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Nodes of the lumen's surface (n, 3), in the order of wall.ghost [mm, LPS].")
        .def(
            "state", [](const P& p) { return array_owning<double>(p.scene.state()); },
            nb::sig("def state(self) -> numpy.typing.NDArray[numpy.float64]"),
            "The complete dynamic state (n,), for a scene with the same wall and settings.")
        .def(
            "restore",
            [](P& p, const nb::object& state) {
                const Numbers<double, 0> numbers(state, "state");
                take(p.arena->run(
                    [&] { return p.scene.restore(numbers.numbers(), p.arena->tasks()); }));
            },
            nb::arg("state"), nb::sig("def restore(self, state: numpy.typing.ArrayLike) -> None"),
            "Continues from a state, bit for bit. Reported forces are those of the next step.")
        .def(
            "save",
            [](const P& p, const std::filesystem::path& wall,
               const std::optional<std::filesystem::path>& wire) {
                const auto done = [&] {
                    const nb::gil_scoped_release without_lock;
                    return save(p.scene, wall, wire);
                }();
                take(done);
            },
            nb::arg("wall"), nb::arg("wire") = nb::none(),
            nb::sig("def save(self, wall: str | os.PathLike[str], wire: str | os.PathLike[str] | "
                    "None = None) -> None"),
            "Writes the wall with its displacements (.vtu), and the wire (.vtp).")
        .def(
            "hash", [](const P& p) { return p.scene.hash(); },
            "Of all positions and velocities: the same for any number of threads.")
        .def(
            "__reduce__",
            [](nb::handle self) {
                const P& p = nb::cast<const P&>(self);
                const CatheterCommand hand = p.scene.hand();
                return exchange("reduced_scene")(
                    self, nb::make_tuple(p.given.entry.position_mm, p.given.entry.direction),
                    dict_of(record_of(p.given, catheter_rows())),
                    nb::make_tuple(hand.insert_mm_s, hand.rotate_deg_s, hand.bend_first_deg,
                                   hand.bend_second_deg));
            },
            nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
        .def("__repr__", [](const P& p) {
            return "CatheterScene(" + std::to_string(p.scene.wall().mesh.cells.size()) +
                   " tetrahedra, inserted_mm=" +
                   std::to_string(p.scene.quick_measures().inserted_mm) + ")";
        });
    m.def(
        "wide_reach_mm",
        [](const VesselWall& wall, const nb::kwargs& settings) {
            const auto chosen = settings_from<CatheterSettings>(settings, catheter_rows());
            return wide_reach_mm(wall, chosen.wall);
        },
        nb::arg("wall"), nb::arg("settings"),
        typed("def wide_reach_mm(wall: VesselWall, *, **settings) -> float", keywords),
        "Reach at which a local step differs from a step of the whole wall by at most 2 % of the "
        "movement [mm]. Settings are those of a CatheterScene.");
}

/// A vessel of a scene file, and its file.
struct PyVessel {
    VesselFile file;
    MadeVessel made;
};

void bind_files(nb::module_& m) {
    nb::class_<WayPilot>(m, "WayPilot",
                         "Steers along a path: bends the tip towards a point of the path at a "
                         "fixed distance ahead.")
        .def(
            "__init__",
            [](WayPilot* self, const nb::object& way_mm, double ahead_mm, double gain,
               double max_deg) {
                new (self) WayPilot(Numbers<double, 3>(way_mm, "way_mm").copied_vectors(), ahead_mm,
                                    gain, max_deg);
            },
            nb::arg("way_mm"), nb::arg("ahead_mm") = 15.0, nb::arg("gain") = 1.5,
            nb::arg("max_deg") = 120.0,
            nb::sig("def __init__(self, way_mm: numpy.typing.ArrayLike, ahead_mm: float = 15.0, "
                    "gain: float = 1.5, max_deg: float = 120.0) -> None"),
            "Args:\n    way_mm: Points (n, 3) of the path [mm, LPS].\n"
            "    max_deg: Largest bend of the tip.")
        .def(
            "steer",
            [](WayPilot& pilot, const PyCatheter& p) {
                CatheterCommand command;
                pilot.steer(p.scene, command);
                return nb::make_tuple(command.bend_first_deg, command.bend_second_deg);
            },
            nb::arg("scene"),
            nb::sig("def steer(self, scene: CatheterScene) -> tuple[float, float]"),
            "The two bends for CatheterScene.command() [degrees].")
        .def_prop_ro("way_mm", &WayPilot::way_mm, "Length of the path [mm].")
        .def("progress_mm", &WayPilot::progress_mm, nb::arg("tip_mm"),
             "Arc length of the path's point nearest to the tip [mm].");
    nb::class_<VesselScript>(m, "VesselScript", "Plays the acts of a scene file in order.")
        .def(
            "next",
            [](VesselScript& script, PyCatheter& p) {
                CatheterCommand command = p.scene.hand();
                if (!script.next(p.scene, command)) return false;
                take(p.scene.command(command));
                return true;
            },
            nb::arg("scene"), "Sets the command of the next step. False after the last act.")
        .def(
            "way_mm",
            [](const VesselScript& script, const PyCatheter& p) { return script.way_mm(p.scene); },
            nb::arg("scene"), "Distance of the tip along the path [mm]; 0 without a path.")
        .def_prop_ro("progress", &VesselScript::progress, "Share of finished acts, 0 to 1.");
    nb::class_<PyVessel>(m, "MadeVessel", "The vessel of a scene file (docs/howto/vessel.md).")
        .def_prop_ro(
            "wall", [](const PyVessel& v) -> const VesselWall& { return v.made.wall; },
            nb::rv_policy::reference_internal, "Its wall.")
        .def_prop_ro(
            "way_mm", [](const PyVessel& v) { return points_of(v.made.way); },
            nb::sig("def way_mm(self, /) -> numpy.typing.NDArray[numpy.float64]"),
            "Points of the path (n, 3) [mm, LPS]. May be empty.")
        .def_prop_ro(
            "scan",
            [](const PyVessel& v) {
                return v.made.scan ? nb::cast(PyVolume{*v.made.scan, {}}) : nb::none();
            },
            nb::sig("def scan(self, /) -> Volume | None"), "The scan that the file names.")
        .def_prop_ro(
            "settings",
            [](const PyVessel& v) { return dict_of(record_of(v.made.settings, catheter_rows())); },
            nb::sig("def settings(self, /) -> dict[str, typing.Any]"),
            "Settings of the file, as those of CatheterScene.")
        .def_prop_ro(
            "max_steps", [](const PyVessel& v) { return v.file.max_steps; },
            "Limit of the script's steps.")
        .def(
            "scene",
            [](const PyVessel& v, int threads, const nb::kwargs& changes) {
                auto settings = v.made.settings;
                change(settings, changes, catheter_rows());
                return catheter_in(v.made.wall, settings, threads);
            },
            nb::arg("threads") = 0, nb::arg("settings"),
            typed("def scene(self, threads: int = 0, *, **settings) -> CatheterScene",
                  unset(keywords_of(catheter_rows()))),
            "A new scene with the file's settings, some of them changed.")
        .def(
            "script", [](const PyVessel& v) { return VesselScript(v.file, v.made.way); },
            "The acts of the file, from the first on.")
        .def("__repr__", [](const PyVessel& v) { return "MadeVessel(" + v.file.file + ")"; });
    m.def(
        "make_vessel",
        [](const std::filesystem::path& path, int threads) {
            return taken(threads, [&](const TaskArena& arena) -> Result<PyVessel> {
                auto file = read_vessel_file(path.string());
                if (!file.ok()) return file.error();
                auto made = make_vessel(*file, arena);
                if (!made.ok()) return made.error();
                return PyVessel{std::move(file).value(), std::move(made).value()};
            });
        },
        nb::arg("path"), nb::arg("threads") = 0,
        "Reads a scene file of `pliant vessel`, and makes or reads the wall.\n\n"
        "Example:\n"
        "    >>> vessel = pliant.make_vessel(\"scenes/vessel_phantom.toml\")\n"
        "    >>> scene, script = vessel.scene(), vessel.script()\n"
        "    >>> while script.next(scene):\n"
        "    ...     scene.step()");
}

/// Carries a scan along, with the volume, threads and deformed scan that belong to it.
class PyCarried : public Exclusive {
  public:
    PyCarried(nb::object scan, const TetMesh& wall, const CarriedScanSettings& settings,
              int threads)
        : m_scan(std::move(scan)), m_arena(threads) {
        const Volume& volume = object_in<PyVolume>(m_scan, "scan", "a Volume").volume;
        m_carried.emplace(take(m_arena.run(
            [&] { return CarriedScan::create(volume, wall, settings, m_arena.tasks()); })));
    }
    void update(const nb::object& wall_positions) {
        const Numbers<double, 3> positions(wall_positions, "wall_positions");
        take(m_arena.run([&] { return m_carried->update(positions.vectors()); }));
    }
    PyVolume volume() const {
        return {take(m_arena.run([&] { return deform_volume(m_carried->scan()); })).volume, {}};
    }
    VectorField displacement_field() const {
        return take(m_arena.run([&] { return pliant::displacement_field(m_carried->scan()); }));
    }
    nb::object scan() const { return m_scan; }

  private:
    nb::object m_scan;
    Arena m_arena;
    std::optional<CarriedScan> m_carried;
};

void bind_carried(nb::module_& m) {
    nb::class_<PyCarried>(m, "CarriedScan",
                          "The scan around a vessel, which moves with the vessel's wall: near the "
                          "wall fully, beyond reach_mm not at all.")
        .def(
            "__init__",
            [](nb::pointer_and_handle<PyCarried> self, const nb::object& scan, const TetMesh& wall,
               double reach_mm, double cell_mm, int threads) {
                new (self.p) PyCarried(seen_scan(scan).owner, wall,
                                       CarriedScanSettings{reach_mm, cell_mm}, threads);
            },
            nb::arg("scan"), nb::arg("wall"), nb::arg("reach_mm") = 20.0, nb::arg("cell_mm") = 3.0,
            nb::arg("threads") = 0,
            nb::sig("def __init__(self, scan: Volume, wall: TetMesh, reach_mm: float = 20.0, "
                    "cell_mm: float = 3.0, threads: int = 0) -> None"),
            "Args:\n    wall: The wall's tetrahedra at rest, VesselWall.mesh.\n"
            "    reach_mm: Distance from the wall's nodes.\n"
            "    cell_mm: Edge of a cell of the control lattice.")
        .def_prop_ro("scan", &PyCarried::scan, nb::sig("def scan(self, /) -> Volume"),
                     "The scan at rest.")
        .def("update", &PyCarried::update, nb::arg("wall_positions"),
             nb::sig("def update(self, wall_positions: numpy.typing.ArrayLike) -> None"),
             "Moves the scan with the wall's nodes (n, 3) [mm, LPS].")
        .def("volume", &PyCarried::volume, "The deformed scan.")
        .def("displacement_field", &PyCarried::displacement_field,
             "Forward displacement at rest voxel centres.");
}

}  // namespace

CatheterEntry entry_of(const nb::object& entry, double inwards, double inserted_mm,
                       const VesselWall& wall) {
    CatheterEntry made;
    std::size_t number = 0;
    nb::tuple pair;
    const VesselEnd* end = nullptr;
    if (nb::try_cast(entry, number) && number < wall.ends.size())
        made = entry_at(wall.ends[number], inwards);
    else if (nb::try_cast(entry, end) && end)
        made = entry_at(*end, inwards);
    else if (!nb::try_cast(entry, pair) || pair.size() != 2 ||
             !vector_from(pair[0], made.position_mm) || !vector_from(pair[1], made.direction))
        raise_value("entry",
                    "a number below " + std::to_string(wall.ends.size()) +
                        ", a VesselEnd, or a tuple of a position and a direction",
                    entry);
    made.inserted_mm = inserted_mm;
    return made;
}

void bind_vessels(nb::module_& m) {
    bind_walls(m);
    bind_measures(m);
    bind_scene(m);
    bind_files(m);
    bind_carried(m);
}

}  // namespace pliant::python
