// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A vessel's wall from a scan, a surface or a centreline; an organ's solid from a surface or
// labels; reports on meshes.

#include <pliant/core/files.h>
#include <pliant/core/text.h>
#include <pliant/mesh_files.h>
#include <pliant/models/organs.h>
#include <pliant/models/vessel.h>
#include <pliant/render.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "options.h"
#include "progress.h"

namespace pliant::app {
namespace {

nlohmann::ordered_json quality_json(const TetQuality& q) {
    return {{"tetrahedra", q.tetrahedra},
            {"nodes", q.nodes},
            {"pieces", q.pieces},
            {"inverted", q.inverted},
            {"volume_mm3", q.volume_mm3},
            {"dihedral_min_deg", q.min_dihedral_deg},
            {"dihedral_max_deg", q.largest_dihedral_deg},
            {"radius_ratio_min", q.min_radius_ratio},
            {"radius_ratio_mean", q.mean_radius_ratio},
            {"edge_min_mm", q.shortest_edge_mm},
            {"edge_max_mm", q.longest_edge_mm},
            {"boundary_pieces", q.boundary.pieces},
            {"boundary_euler", q.boundary.euler},
            {"boundary_open_edges", q.boundary.open_edges},
            {"boundary_non_manifold_edges", q.boundary.non_manifold_edges},
            {"boundary_pinched_nodes", q.boundary.pinched_nodes}};
}

/// Lowest and highest coordinates of a mesh [mm, LPS].
struct Bounds {
    Vec3d low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};

    explicit Bounds(std::span<const Vec3d> nodes_mm) {
        for (const Vec3d& p : nodes_mm)
            for (int a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], p[a]);
                high[a] = std::max(high[a], p[a]);
            }
    }
    nlohmann::ordered_json json() const {
        return {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
    }
    void print() const {
        std::printf("corners             %.1f,%.1f,%.1f and %.1f,%.1f,%.1f mm\n", low.x, low.y,
                    low.z, high.x, high.y, high.z);
    }
};

void tell(const MeshOptions& o, const VesselWall& wall, const TetQuality& quality) {
    if (o.json) {
        auto report = quality_json(quality);
        report["layers"] = wall.min_layers;
        report["ends"] = wall.ends.size();
        report["ghost_triangles"] = wall.ghost.cells.size();
        report["ghost_nodes"] = wall.ghost.nodes_mm.size();
        report["lumen_mm3"] = wall.lumen_mm3;
        report["cell_mm"] = wall.cell_mm;
        report["refined_because"] = wall.refined_because;
        report["dropped_pieces"] = wall.dropped_pieces;
        std::printf("%s\n", report.dump().c_str());
        return;
    }
    std::printf("%s\n", describe(quality).c_str());
    std::printf("layers              %d at least\n", wall.min_layers);
    std::printf("ghost surface       %zu triangles, %zu nodes, around %.1f mm3\n",
                wall.ghost.cells.size(), wall.ghost.nodes_mm.size(), wall.lumen_mm3);
    if (!wall.refined_because.empty())
        std::printf("cells               refined to %.3g mm; with larger ones, %s\n", wall.cell_mm,
                    wall.refined_because.c_str());
    if (wall.dropped_pieces > 0)
        std::printf("dropped             %d small pieces that nothing holds\n",
                    wall.dropped_pieces);
    for (const VesselEnd& end : wall.ends)
        std::printf("open end            at %.1f,%.1f,%.1f mm, radius %.1f mm\n", end.centre_mm.x,
                    end.centre_mm.y, end.centre_mm.z, end.radius_mm);
}

nlohmann::ordered_json with_notes(nlohmann::ordered_json report,
                                  const std::vector<std::string>& notes) {
    if (!notes.empty()) report["notes"] = notes;
    return report;
}
void print_notes(const std::vector<std::string>& notes) {
    for (const std::string& note : notes) std::printf("note                %s\n", note.c_str());
}

/// The surface of a file. @param[out] notes  of the file and of the surface
TriangleMesh surface_of(const MeshData& mesh, std::vector<std::string>& notes) {
    return cleaned({mesh.nodes_mm, mesh.triangles}, &notes);
}

/// Reports on a file's mesh without making a wall.
int judge(const MeshOptions& o, const MeshData& mesh) {
    std::vector<std::string> notes = mesh.notes;
    if (!mesh.tetrahedra.empty()) {
        const TetMesh solid = with_used_nodes({mesh.nodes_mm, mesh.tetrahedra});
        const TetQuality q = tet_quality(solid);
        const Bounds bounds(solid.nodes_mm);
        if (o.json) {
            auto report = quality_json(q);
            report["corners_mm"] = bounds.json();
            std::printf("%s\n", with_notes(report, notes).dump().c_str());
        } else {
            std::printf("%s\n", describe(q).c_str());
            bounds.print();
            print_notes(notes);
        }
        if (const Status s = check_quality(q); !s)
            return bad_input(o.file + ": " + s.error().message);
        return kExitOk;
    }
    if (!mesh.triangles.empty()) {
        const TriangleMesh surface = surface_of(mesh, notes);
        const SurfaceTopology t = surface_topology(surface);
        const double volume = t.open_edges ? 0 : enclosed_volume_mm3(surface);
        const Bounds bounds(surface.nodes_mm);
        if (o.json) {
            const nlohmann::ordered_json report = {{"triangles", surface.cells.size()},
                                                   {"nodes", surface.nodes_mm.size()},
                                                   {"pieces", t.pieces},
                                                   {"euler", t.euler},
                                                   {"open_edges", t.open_edges},
                                                   {"non_manifold_edges", t.non_manifold_edges},
                                                   {"disagreeing_edges", t.disagreeing_edges},
                                                   {"pinched_nodes", t.pinched_nodes},
                                                   {"volume_mm3", volume},
                                                   {"corners_mm", bounds.json()}};
            std::printf("%s\n", with_notes(report, notes).dump().c_str());
        } else {
            std::printf("triangles           %zu, %zu nodes, %lld piece%s\n", surface.cells.size(),
                        surface.nodes_mm.size(), static_cast<long long>(t.pieces),
                        t.pieces == 1 ? "" : "s");
            std::printf("Euler               %lld\n", static_cast<long long>(t.euler));
            std::printf(
                "edges               %lld open, %lld of three triangles or more, %lld where "
                "sides differ\n",
                static_cast<long long>(t.open_edges), static_cast<long long>(t.non_manifold_edges),
                static_cast<long long>(t.disagreeing_edges));
            if (!t.open_edges)
                std::printf("encloses            %.1f mm3%s\n", std::abs(volume),
                            volume < 0 ? ", its triangles face inwards" : "");
            bounds.print();
            print_notes(notes);
        }
        return kExitOk;
    }
    if (!mesh.lines.empty()) {
        std::printf("lines               %zu, %zu nodes\n", mesh.lines.size(),
                    mesh.nodes_mm.size());
        return kExitOk;
    }
    return bad_input(o.file + ": found no cells, expected tetrahedra, triangles or lines");
}

Result<std::vector<VesselEnd>> ends_from(const MeshOptions& o) {
    const auto file = read_mesh(o.ends, mm_of_unit(o.units));
    if (!file) return file.error();
    const auto centreline = centreline_of(*file);
    if (!centreline)
        return Error{centreline.error().code, o.ends + ": " + centreline.error().message};
    return ends_of(*centreline, o.trim);
}

Result<VesselWall> wall_from_mesh(const MeshOptions& o, const MeshData& mesh,
                                  const WallSettings& settings, const TaskArena& arena) {
    if (mesh.triangles.empty() && !mesh.lines.empty()) {
        const auto centreline = centreline_of(mesh);
        if (!centreline) return centreline.error();
        if (!o.sweep) return wall_around_centreline(*centreline, settings, arena);
        if (centreline->branches.size() != 1)
            return Error{ErrorCode::InvalidArgument,
                         "--sweep: the centreline has " +
                             std::to_string(centreline->branches.size()) +
                             " branches, expected one"};
        return swept_tube(
            centreline->branches[0],
            {.thickness_mm = o.thickness_mm, .layers = o.layers, .sectors = o.sectors});
    }
    if (o.sweep)
        return Error{ErrorCode::InvalidArgument, "--sweep: expected a centreline, found none"};
    std::vector<VesselEnd> ends;
    if (!o.ends.empty()) {
        auto read = ends_from(o);
        if (!read) return read.error();
        ends = std::move(*read);
    }
    if (mesh.triangles.empty())
        return Error{ErrorCode::InvalidArgument, "found no triangles, expected a surface"};
    std::vector<std::string> notes = mesh.notes;
    const TriangleMesh surface = surface_of(mesh, notes);
    if (!o.json) print_notes(notes);
    return wall_around_surface(surface, ends, settings, arena);
}

/// @param[out] surface  surface of the lumen
Result<VesselWall> wall_from_scan(const MeshOptions& o, const WallSettings& settings,
                                  const TaskArena& arena, TriangleMesh& surface, ProgressBar& bar) {
    if (!o.seed_mm && o.labels.empty())
        return Error{ErrorCode::InvalidArgument,
                     "expected --seed with --window, or --labels, for the lumen in a scan"};
    const auto volume = read_volume(o.file, o.scan.options());
    if (!volume) return volume.error();
    RegionSettings region{.low = o.low,
                          .high = o.high,
                          .smoothing_voxels = o.smoothing_voxels,
                          .within_mm = o.within_mm,
                          .max_ml = o.max_ml};
    if (o.seed_mm) region.seed_mm = *o.seed_mm;
    if (o.to_mm) {
        const auto way =
            find_lumen_path(*volume, *o.seed_mm, *o.to_mm,
                            {.iso_hu = o.low, .polarity = Polarity::Falling, .reach_mm = 5}, arena);
        if (!way) return Error{way.error().code, "--seed, --to: " + way.error().message};
        region.way_mm = way->points_mm;
    }
    const auto lumen = o.seed_mm ? lumen_of_region(*volume, region, arena)
                                 : lumen_of_labels(*volume, o.labels, o.smoothing_voxels, arena);
    if (!lumen) {
        Error error = lumen.error();
        const std::string name = "within_mm", option = "--to and --within";
        if (const auto at = error.message.find(name); at != std::string::npos)
            error.message.replace(at, name.size(), option);
        return error;
    }
    bar.show(0.3);
    surface = lumen->surface;
    if (!o.json)
        std::printf("lumen               %lld voxels, %.1f mm3, leaves the scan in %zu places\n",
                    static_cast<long long>(lumen->voxels), lumen->region_mm3, lumen->ends.size());
    std::vector<VesselEnd> ends = lumen->ends;
    if (!o.ends.empty()) {
        const auto more = ends_from(o);
        if (!more) return more.error();
        ends.insert(ends.end(), more->begin(), more->end());
    }
    return wall_around_surface(lumen->surface, ends, settings, arena);
}

/// A surface that is too thin for a wall may have other units.
std::string hint_at_units(const MeshOptions& o, const MeshData& mesh) {
    constexpr double kSmall = 30;  // [mm]: vessels are longer
    const Bounds bounds(mesh.nodes_mm);
    const double extent = norm(bounds.high - bounds.low);
    if (mesh.nodes_mm.empty() || extent > kSmall || !o.units.empty()) return {};
    return " (the mesh is " + short_text(extent, 3) +
           " mm across; --units cm or m reads other lengths)";
}

/// Returns the closed surface to be filled with tetrahedra.
Result<TriangleMesh> surface_to_fill(const MeshOptions& o, bool from_mesh, const MeshData& mesh,
                                     const TaskArena& arena) {
    if (from_mesh) {
        if (mesh.triangles.empty())
            return Error{ErrorCode::InvalidArgument, "found no triangles, expected a surface"};
        std::vector<std::string> notes = mesh.notes;
        TriangleMesh surface = surface_of(mesh, notes);
        if (!o.json) print_notes(notes);
        return surface;
    }
    if (o.labels.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--labels: expected the solid's labels in a volume, found none"};
    const auto volume = read_volume(o.file, o.scan.options());
    if (!volume) return volume.error();
    auto found = lumen_of_labels(*volume, o.labels, o.smoothing_voxels, arena);
    if (!found) return found.error();
    return std::move(found->surface);
}

void tell(const MeshOptions& o, const FilledSurface& solid, const TetQuality& quality) {
    if (o.json) {
        auto report = quality_json(quality);
        report["cell_mm"] = solid.cell_mm;
        report["surface_mm3"] = solid.surface_mm3;
        report["removed_cells"] = solid.removed_cells;
        report["dropped_pieces"] = solid.dropped_pieces;
        report["corners_mm"] = Bounds(solid.mesh.nodes_mm).json();
        std::printf("%s\n", report.dump().c_str());
        return;
    }
    std::printf("%s\n", describe(quality).c_str());
    Bounds(solid.mesh.nodes_mm).print();
    std::printf("cells               %.3g mm\n", solid.cell_mm);
    std::printf("of the surface      %.1f %% of %.1f mm3\n",
                100 * quality.volume_mm3 / solid.surface_mm3, solid.surface_mm3);
    if (solid.dropped_pieces > 0)
        std::printf("dropped             %d small pieces\n", solid.dropped_pieces);
}

struct MeshOutputs {
    StagedFiles files;
    std::filesystem::path out, ghost, surface;
};

Status stage_outputs(const MeshOptions& o, MeshOutputs& outputs) {
    for (const auto& [name, place] : {std::pair(&o.out, &outputs.out),
                                      {&o.ghost, &outputs.ghost},
                                      {&o.surface, &outputs.surface}}) {
        if (name->empty()) continue;
        const auto staged = outputs.files.stage(*name);
        if (!staged) return staged.error();
        *place = *staged;
    }
    return Ok{};
}

Status write_outputs(MeshOutputs& outputs, const TetMesh& mesh, const TriangleMesh& ghost,
                     const TriangleMesh& surface) {
    if (const Status s = write_vtu(outputs.out, mesh); !s) return s;
    if (!outputs.ghost.empty())
        if (const Status s = write_surface(outputs.ghost, ghost); !s) return s;
    if (!outputs.surface.empty())
        if (const Status s = write_surface(outputs.surface, surface); !s) return s;
    return outputs.files.commit();
}

int make_solid(const MeshOptions& o, bool from_mesh, const MeshData& mesh, const TaskArena& arena) {
    MeshOutputs outputs;
    if (const Status s = stage_outputs(o, outputs); !s) return bad_input(s.error());
    std::optional<ProgressBar> bar(std::in_place, "solid");
    const auto surface = surface_to_fill(o, from_mesh, mesh, arena);
    bar->show(0.3);
    const auto solid =
        surface ? fill_surface(*surface, {.cell_mm = o.cell_mm, .tetrahedra = o.tetrahedra}, arena)
                : Result<FilledSurface>(surface.error());
    bar.reset();
    if (!solid)
        return bad_input(from_mesh ? o.file + ": " + solid.error().message : solid.error().message);
    const TetQuality quality = tet_quality(solid->mesh);
    if (const Status s = check_quality(quality); !s) return bad_input(s.error());
    if (const Status s = write_outputs(outputs, solid->mesh, {}, *surface); !s)
        return bad_input(s.error());
    tell(o, *solid, quality);
    return kExitOk;
}

}  // namespace

int run_mesh(const MeshOptions& o) {
    const TaskArena arena(o.threads);
    const WallSettings settings{.thickness_mm = o.thickness_mm,
                                .layers = o.layers,
                                .cell_mm = o.cell_mm,
                                .ghost_mm = o.ghost_mm};
    const bool from_mesh = is_mesh_file(o.file);
    MeshData mesh;
    if (const Status s = check_mesh_or_scan(o.file); !s) return bad_input(s.error().message);
    if (from_mesh) {
        auto read = read_mesh(o.file, mm_of_unit(o.units));
        if (!read) return bad_input(read.error());
        mesh = std::move(*read);
        if (o.out.empty()) return judge(o, mesh);
    } else if (o.out.empty()) {
        return bad_input("--out: expected a file to write (.vtu), found none");
    }
    if (std::filesystem::path(o.out).extension() != ".vtu")
        return bad_input("--out: expected a file that ends in .vtu, found '" + o.out + "'");
    if (from_mesh && !o.surface.empty())
        return bad_input("--surface: expected a scan, from which it is made, found " + o.file);
    if (o.solid) return make_solid(o, from_mesh, mesh, arena);
    MeshOutputs outputs;
    if (const Status s = stage_outputs(o, outputs); !s) return bad_input(s.error());
    std::optional<ProgressBar> bar(std::in_place, "wall");
    TriangleMesh surface;
    const auto wall = from_mesh ? wall_from_mesh(o, mesh, settings, arena)
                                : wall_from_scan(o, settings, arena, surface, *bar);
    bar.reset();
    if (!wall)
        return bad_input(from_mesh && wall.error().message.rfind("--", 0) != 0
                             ? o.file + ": " + wall.error().message + hint_at_units(o, mesh)
                             : wall.error().message);
    const TetQuality quality = tet_quality(wall->mesh);
    if (const Status s = check_quality(quality); !s) return bad_input(s.error());
    if (const Status s = write_outputs(outputs, wall->mesh, wall->ghost, surface); !s)
        return bad_input(s.error());
    tell(o, *wall, quality);
    return kExitOk;
}

}  // namespace pliant::app
