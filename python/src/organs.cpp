// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Organs of scene files, meshes and label maps; positions of tissues that are meshes.

#include <pliant/models/cut_mesh.h>
#include <pliant/models/organs.h>

#include "keywords.h"
#include "made_tissue.h"
#include "numbers.h"
#include "struct_class.h"

namespace pliant::python {
namespace {

/// Made organs, and their scan as an object of Python, which tissues keep.
struct PyOrgans {
    MadeOrgans made;
    nb::object scan;
};

PyOrgans organs_of(Result<OrganFile> file, int threads, const nb::kwargs& settings) {
    OrganFile changed = take(std::move(file));
    change(changed, settings, organ_file_rows());
    const Arena arena(threads);
    MadeOrgans made = take(arena.run([&] { return make_organs(changed, arena.tasks()); }));
    // The voxels move: made.scan is then without them, and the tissue gets this one.
    nb::object scan = nb::cast(PyVolume{std::move(made.scan), {}});
    made.scan = Volume{};
    return {std::move(made), std::move(scan)};
}

const MeshTissue& mesh_tissue(nb::handle tissue) {
    const auto* const mesh = dynamic_cast<const MeshTissue*>(find_tissue(tissue));
    if (mesh) return *mesh;
    const std::string found = nb::cast<std::string>(nb::repr(tissue));
    raise({ErrorCode::Unsupported,
           "tissue: expected one whose elements are nodes of a mesh, found " + found, "tissue",
           "one whose elements are nodes of a mesh", found});
}

std::vector<Vec3d> positions_of(nb::handle tissue) {
    const MeshTissue& mesh = mesh_tissue(tissue);
    std::vector<Vec3d> positions(std::size_t(mesh.node_count()));
    const nb::gil_scoped_release without_lock;
    mesh.positions_mm(positions);
    return positions;
}

std::vector<TetMesh> meshes_of(const PyOrgans& organs, nb::handle tissue) {
    const auto positions = positions_of(tissue);
    std::vector<TetMesh> meshes;
    std::size_t first = 0;
    for (const Organ& organ : organs.made.organs) {
        const std::size_t count = organ.mesh.nodes_mm.size();
        if (first + count > positions.size())
            raise({ErrorCode::InvalidArgument,
                   "tissue: expected one of these organs, found one of " +
                       std::to_string(positions.size()) + " nodes",
                   "tissue"});
        meshes.push_back({{positions.begin() + std::ptrdiff_t(first),
                           positions.begin() + std::ptrdiff_t(first + count)},
                          organ.mesh.cells});
        first += count;
    }
    return meshes;
}

/// Settings as apply() takes them back. An empty list has no type; it is the default.
template <class T>
nb::dict kept_settings(const T& settings, SettingRows<T> rows) {
    nb::dict kept;
    for (const auto& [name, value] : dict_of(record_of(settings, rows)))
        if (!nb::isinstance<nb::list>(value) || nb::len(value) > 0) kept[name] = value;
    return kept;
}

/// All that make_tissue needs: scan, labels, settings, bodies, hash.
nb::tuple state_of_organs(const PyOrgans& organs) {
    const MadeOrgans& made = organs.made;
    nb::list bodies;
    for (const Organ& organ : made.organs)
        bodies.append(nb::make_tuple(organ.name, TetMesh(organ.mesh),
                                     kept_settings(organ.settings, organ_rows())));
    return nb::make_tuple(organs.scan,
                          made.labels ? nb::cast(PyVolume{*made.labels, {}}) : nb::none(),
                          kept_settings(made.file, organ_file_rows()), bodies, made.hash);
}

PyOrgans organs_from(const nb::tuple& state) {
    PyOrgans organs{{}, state[0]};
    MadeOrgans& made = organs.made;
    if (!state[1].is_none())
        made.labels = std::make_shared<const Volume>(nb::cast<const PyVolume&>(state[1]).volume);
    change(made.file, nb::cast<nb::dict>(state[2]), organ_file_rows());
    for (const nb::handle body : nb::cast<nb::list>(state[3])) {
        Organ organ{.name = nb::cast<std::string>(body[0]),
                    .mesh = nb::cast<const TetMesh&>(body[1])};
        change(organ.settings, nb::cast<nb::dict>(body[2]), organ_rows());
        made.organs.push_back(std::move(organ));
    }
    made.hash = nb::cast<std::uint64_t>(state[4]);
    return organs;
}

void bind_organ(nb::module_& m) {
    nb::class_<Organ>(m, "Organ", "A body of organs.")
        .def_ro("name", &Organ::name, "Its name.")
        .def_prop_ro(
            "mesh", [](const Organ& o) -> const TetMesh& { return o.mesh; },
            nb::rv_policy::reference_internal, "Its tetrahedra at rest, a TetMesh.")
        .def_prop_ro(
            "settings", [](const Organ& o) { return dict_of(record_of(o.settings, organ_rows())); },
            nb::sig("def settings(self, /) -> dict[str, typing.Any]"),
            "Its law, moduli and held nodes: settings_of(\"organ\").")
        .def("__repr__", [](const Organ& o) {
            return "Organ(" + o.name + ", " + std::to_string(o.mesh.cells.size()) + " tetrahedra)";
        });
    using P = PyOrgans;
    nb::class_<P>(m, "MadeOrgans",
                  "Bodies of tetrahedra in a scan, which slide on each other "
                  "(docs/howto/organs.md).")
        .def_prop_ro(
            "scan", [](const P& p) { return p.scan; }, nb::sig("def scan(self, /) -> Volume"),
            "The scan that they carry along.")
        .def_prop_ro(
            "labels",
            [](const P& p) {
                return p.made.labels ? nb::cast(PyVolume{*p.made.labels, {}}) : nb::none();
            },
            nb::sig("def labels(self, /) -> Volume | None"),
            "Labels of the bodies' voxels; None: bodies carry the voxels in their meshes.")
        .def_prop_ro(
            "organs", [](const P& p) -> const std::vector<Organ>& { return p.made.organs; },
            nb::rv_policy::reference_internal, "The bodies, the surroundings last.")
        .def_prop_ro(
            "settings",
            [](const P& p) { return dict_of(record_of(p.made.file, organ_file_rows())); },
            nb::sig("def settings(self, /) -> dict[str, typing.Any]"),
            "Settings of all bodies: settings_of(\"organs\").")
        .def(
            "make_tissue",
            [](nb::handle self, int threads) {
                const P& p = nb::cast<const P&>(self);
                return tissue_of(p.scan, threads,
                                 [&](const Volume& scan,
                                     const TaskArena& arena) -> Result<std::unique_ptr<Tissue>> {
                                     auto tissue = make_tissue(p.made, scan, arena);
                                     if (!tissue.ok()) return tissue.error();
                                     return std::unique_ptr<Tissue>(std::move(tissue).value());
                                 },
                                 {"MadeOrgans.make_tissue", nb::make_tuple(self)});
            },
            nb::arg("threads") = 0, nb::sig("def make_tissue(self, threads: int = 0) -> Tissue"),
            "A tissue of all bodies at rest, to push, grab, slide along and cut.")
        .def("meshes", &meshes_of, nb::arg("tissue"),
             nb::sig("def meshes(self, tissue: Tissue) -> list[TetMesh]"),
             "The bodies as their tissue has them now, in the order of organs, without what cuts "
             "have added.")
        .def(
            "hash", [](const P& p) { return p.made.hash; }, "Of meshes and settings.")
        .def("__getstate__", &state_of_organs,
             nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"))
        .def(
            "__setstate__", [](P& p, const nb::tuple& state) { new (&p) P(organs_from(state)); },
            nb::arg("state"),
            nb::sig("def __setstate__(self, state: tuple[typing.Any, ...]) -> None"))
        .def("__repr__", [](const P& p) {
            std::string names;
            for (const Organ& organ : p.made.organs)
                names += (names.empty() ? "" : ", ") + organ.name;
            return "MadeOrgans(" + names + ")";
        });
}

void bind_makers(nb::module_& m) {
    const Keywords keywords = unset(keywords_of(organ_file_rows()));  // those of the file
    m.def(
        "make_organs",
        [](const std::filesystem::path& file, int threads, const nb::kwargs& settings) {
            return organs_of(is_mesh_file(file) ? Result(organ_file_of_mesh(file.string()))
                                                : read_organ_file(file.string()),
                             threads, settings);
        },
        nb::arg("file"), nb::arg("threads") = 0, nb::arg("settings"),
        typed("def make_organs(file: str | os.PathLike[str], threads: int = 0, *, "
              "**settings) -> MadeOrgans",
              keywords),
        described("Reads or makes the meshes of a scene file, and its scan.\n\n"
                  "Args:\n"
                  "    file: A scene (docs/howto/organs.md), or one mesh, which lies on its back.\n"
                  "    **settings\n\n"
                  "Example:\n"
                  "    >>> organs = pliant.make_organs(\"liver.toml\")\n"
                  "    >>> tissue = organs.make_tissue()\n"
                  "    >>> tissue.push((-20, -235, -300), (0, 12, 0), sphere_radius_mm=12)\n"
                  "    >>> organs.meshes(tissue)[0].nodes_mm",
                  keywords));
    m.def(
        "make_organs_of_labels",
        [](const std::filesystem::path& scan, const std::filesystem::path& label_volume,
           const std::vector<int>& labels, const std::filesystem::path& label_names, int threads,
           const nb::kwargs& settings) {
            return organs_of(organ_file_of_labels(scan.string(), label_volume.string(), labels,
                                                  label_names.string()),
                             threads, settings);
        },
        nb::arg("scan"), nb::arg("label_volume"), nb::arg("labels") = std::vector<int>{},
        nb::arg("label_names") = "", nb::arg("threads") = 0, nb::arg("settings"),
        typed("def make_organs_of_labels(scan: str | os.PathLike[str], label_volume: str | "
              "os.PathLike[str], labels: collections.abc.Sequence[int] = (), label_names: str | "
              "os.PathLike[str] = \"\", threads: int = 0, *, **settings) -> MadeOrgans",
              keywords),
        described(
            "The labelled organs of a scan with their surroundings, named after their labels.\n\n"
            "Args:\n"
            "    scan, label_volume: Files.\n"
            "    labels: None given: each with 1 ml or more that isn't air or bone.\n"
            "    label_names: File of the labels' names; empty: the label volume's own, or one "
            "beside it.\n"
            "    **settings",
            keywords));
    // A tissue of another part of the module.
    nb::cpp_function_def(
        [](nb::handle self) { return points_of(positions_of(self)); }, nb::scope(m.attr("Tissue")),
        nb::name("positions_mm"), nb::is_method(),
        nb::sig("def positions_mm(self) -> numpy.typing.NDArray[numpy.float64]"),
        "Nodes (n, 3) of a body, a network, springs or organs as they are now [mm, LPS]; cuts of "
        "bodies add nodes at the end.\n\nRaises:\n    pliant.Error: unsupported for other "
        "tissues.");
    nb::cpp_function_def(
        [](nb::handle self) -> nb::object {
            const MeshTissue& tissue = mesh_tissue(self);
            if (!tissue.cut_mesh()) return nb::none();
            return nb::cast(TetMesh{positions_of(self), tissue.cut_mesh()->mesh.cells});
        },
        nb::scope(m.attr("Tissue")), nb::name("cut_mesh"), nb::is_method(),
        nb::sig("def cut_mesh(self) -> TetMesh | None"),
        "Tetrahedra of a body or of organs with their cuts, as they are now; copies of split ones "
        "overlap. None without cuts, and for springs.");
}

}  // namespace

void bind_organs(nb::module_& m) {
    bind_organ(m);
    bind_makers(m);
}

}  // namespace pliant::python
