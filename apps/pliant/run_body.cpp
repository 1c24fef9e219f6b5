// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Organs without a window: meshes, scenes of organs, or the labelled organs of a scan. They are
// deformed like every other tissue; the moved meshes are an output of their own.

#include <pliant/mesh_files.h>
#include <pliant/models/organs.h>

#include <memory>
#include <utility>
#include <vector>

#include "deform_models.h"
#include "options.h"

namespace pliant::app {
namespace {

Result<OrganFile> scene_of(const BodyOptions& o) {
    const std::string& file = o.deform.file;
    if (!o.deform.units.empty() && !is_mesh_file(file) && !is_organ_file(file))
        return Error{
            ErrorCode::InvalidArgument,
            "--units: expected a mesh or a scene of organs, whose unit it is, found " + file};
    if (!o.labels.empty())
        return organ_file_of_labels(file, o.labels, o.bodies.value_or(std::vector<int>{}),
                                    o.label_names, o.deform.scan.options());
    if (!o.label_names.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--label-names: expected --labels, whose names these are, found none"};
    if (o.bodies)
        return Error{ErrorCode::InvalidArgument,
                     "--bodies: expected --labels, of which they are made, found none"};
    if (is_mesh_file(file)) return organ_file_of_mesh(file);
    if (is_organ_file(file)) return read_organ_file(file);
    return Error{ErrorCode::Unsupported,
                 file +
                     ": expected an organ's mesh, a scene of organs (TOML), or a scan with "
                     "--labels"};
}

/// The organs' meshes, and the tissue that moves them.
struct Moved {
    MadeOrgans organs;
    const MeshTissue* tissue = nullptr;

    Status write(const std::filesystem::path& path) const {
        TetMesh mesh;
        std::vector<double> bodies;
        for (std::size_t n = 0; n < organs.organs.size(); ++n) {
            const TetMesh& own = organs.organs[n].mesh;
            const auto first = std::int32_t(mesh.nodes_mm.size());
            mesh.nodes_mm.insert(mesh.nodes_mm.end(), own.nodes_mm.begin(), own.nodes_mm.end());
            for (auto cell : own.cells) {
                for (std::int32_t& node : cell) node += first;
                mesh.cells.push_back(cell);
                bodies.push_back(double(n + 1));
            }
        }
        VtuFields fields;
        if (const CutMesh* cut = tissue->cut_mesh()) {
            mesh.cells = cut->mesh.cells;
            for (std::size_t n = mesh.nodes_mm.size(); n < cut->uncut_node_of.size(); ++n)
                mesh.nodes_mm.push_back(mesh.nodes_mm[std::size_t(cut->uncut_node_of[n])]);
            for (std::size_t c = bodies.size(); c < cut->uncut_cell_of.size(); ++c)
                bodies.push_back(bodies[std::size_t(cut->uncut_cell_of[c])]);
            fields.cell_numbers.push_back({"share", cut->shares});
        }
        const std::vector<Vec3d> rest = mesh.nodes_mm;
        tissue->positions_mm(mesh.nodes_mm);
        std::vector<Vec3d> moved;
        for (std::size_t n = 0; n < rest.size(); ++n) moved.push_back(mesh.nodes_mm[n] - rest[n]);
        fields.node_vectors.push_back({"displacement_mm", moved});
        fields.cell_numbers.push_back({"body", bodies});
        return write_vtu(path, mesh, fields);
    }
};

}  // namespace

int run_body(const BodyOptions& o) {
    if (o.deform.mesh_out.empty() && o.deform.out.empty() && o.deform.report.empty() &&
        o.deform.picture.png.empty() && o.deform.displacement.empty() &&
        o.deform.labels_out.empty())
        return bad_input(
            "body: expected one or more of --out, --volume, --labels-out, --report, --displacement "
            "and --png");
    return deform(
        o.deform,
        [&](std::vector<std::string>& notes, const TaskArena& arena) -> Result<DeformSource> {
            auto file = scene_of(o);
            if (!file.ok()) return file.error();
            file->reading = o.deform.scan.options();
            if (!o.deform.units.empty()) file->units = o.deform.units;
            auto made = make_organs(*file, arena);
            if (!made.ok()) return made.error();
            const auto moved = std::make_shared<Moved>(Moved{std::move(*made)});
            for (const Organ& organ : moved->organs.organs)
                notes.push_back(organ.name + ": " + std::to_string(organ.mesh.cells.size()) +
                                " tetrahedra");
            return DeformSource{
                .read = [moved](ReadNotes& read_notes) -> Result<Volume> {
                    read_notes = moved->organs.notes;
                    return std::exchange(moved->organs.scan, {});
                },
                .make = [moved](const Volume& scan, const ValueDefaults&,
                                const TaskArena& own) -> Result<std::unique_ptr<Tissue>> {
                    auto tissue = make_tissue(moved->organs, scan, own);
                    if (!tissue.ok()) return tissue.error();
                    moved->tissue = tissue->get();
                    return std::unique_ptr<Tissue>(std::move(*tissue));
                },
                .write_mesh =
                    [moved](const std::filesystem::path& path) { return moved->write(path); },
                .labels = moved->organs.file.label_volume};
        });
}

}  // namespace pliant::app
