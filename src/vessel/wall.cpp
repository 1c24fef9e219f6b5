// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "vessel/wall.h"

#include <algorithm>
#include <cmath>

namespace pliant::vessel {
namespace {

/// How far a point is from what an end cuts off, about: a half space, but only as far around the
/// end as the vessel reaches, so that no other branch loses anything.
double outside_of_end(const VesselEnd& end, double thickness_mm, Vec3d x) {
    const Vec3d from = x - end.centre_mm;
    const double beyond = dot(from, end.outward);
    return std::max(-beyond, norm(from) - (1.5 * end.radius_mm + 2 * thickness_mm));
}

/// Whether a point lies where an end's cut comes to its end, beyond it: on the far side of what was
/// taken away.
bool behind_end(const VesselEnd& end, double thickness_mm, Vec3d x) {
    const Vec3d from = x - end.centre_mm;
    const double reach = 1.5 * end.radius_mm + 2 * thickness_mm;
    return dot(from, end.outward) > 0 && std::abs(norm(from) - reach) < 1e-6 * thickness_mm;
}

double outside_of_ends(const std::vector<VesselEnd>& ends, double thickness_mm, Vec3d x) {
    double least = std::numeric_limits<double>::infinity();
    for (const VesselEnd& end : ends) least = std::min(least, outside_of_end(end, thickness_mm, x));
    return least;
}

Status check_settings(const WallSettings& s) {
    const auto length = [](const char* name, double value, bool zero) -> Status {
        if (std::isfinite(value) && (value > 0 || (zero && value == 0))) return Ok{};
        return wrong(std::string(name) + " is " + std::to_string(value) +
                     ", expected a length above 0");
    };
    if (const Status t = length("thickness_mm", s.thickness_mm, false); !t) return t;
    if (const Status t = length("cell_mm", s.cell_mm, true); !t) return t;
    if (const Status t = length("ghost_mm", s.ghost_mm, true); !t) return t;
    if (s.layers < 1 || s.layers > 16)
        return wrong("layers is " + std::to_string(s.layers) + ", expected 1 to 16");
    return Ok{};
}

/// No edge of the mesh is longer than 1.59 cells (a short one with both ends warped away), so
/// layers − 1 of them don't reach across; and two layers are what the surfaces need to keep apart.
double cell_of(const WallSettings& s) {
    return s.cell_mm > 0 ? s.cell_mm : s.thickness_mm / (1.6 * std::max(1, s.layers - 1));
}

/// What an end cuts off may go on behind the cut: such pieces go, but never the largest one.
void remove_cut_off(TetMesh& mesh, const std::vector<VesselEnd>& ends, double thickness_mm) {
    const auto piece = pieces(mesh);
    std::vector<std::int64_t> size(mesh.nodes_mm.size(), 0);
    std::vector<bool> gone(mesh.nodes_mm.size(), false);
    for (std::size_t n = 0; n < piece.size(); ++n) {
        ++size[std::size_t(piece[n])];
        for (const VesselEnd& end : ends)
            if (behind_end(end, thickness_mm, mesh.nodes_mm[n])) gone[std::size_t(piece[n])] = true;
    }
    gone[std::size_t(std::max_element(size.begin(), size.end()) - size.begin())] = false;
    const auto removed = std::erase_if(mesh.cells, [&](const auto& cell) {
        return gone[std::size_t(piece[std::size_t(cell[0])])];
    });
    if (removed > 0) mesh = with_used_nodes(mesh);
}

/// Pieces of a ghost surface that the wall has none of: their nodes are far outside of it.
void remove_far_pieces(TriangleMesh& ghost, std::vector<Embedded>& places) {
    const auto piece = pieces(ghost);
    std::vector<std::int64_t> near(piece.size(), 0);
    for (std::size_t n = 0; n < piece.size(); ++n) {
        const auto& w = places[n].weights;
        near[std::size_t(piece[n])] += *std::min_element(w.begin(), w.end()) > -1 ? 1 : -1;
    }
    const auto removed = std::erase_if(ghost.cells, [&](const auto& cell) {
        return near[std::size_t(piece[std::size_t(cell[0])])] < 0;
    });
    if (removed == 0) return;
    std::vector<std::int32_t> nodes;
    ghost = part_of(ghost.nodes_mm, std::vector(ghost.cells), &nodes);
    std::vector<Embedded> kept;
    for (const std::int32_t n : nodes) kept.push_back(places[std::size_t(n)]);
    places = std::move(kept);
}

Result<TriangleMesh> coarse_ghost(const LumenShape& lumen, const WallSettings& settings,
                                  const TaskArena& arena) {
    StuffingSettings s;
    s.cell_mm = settings.ghost_mm;
    s.begin_mm = lumen.begin_mm - Vec3d{1, 1, 1};
    s.end_mm = lumen.end_mm + Vec3d{1, 1, 1};
    s.changes_as_distance = true;
    s.most_cells = settings.most_cells;
    const auto inside = stuff_isosurface([&](Vec3d x) { return -lumen.distance_mm(x); }, s, arena);
    if (!inside) return inside.error();
    auto faces = boundary_faces(*inside);
    std::erase_if(faces, [&](const auto& t) {
        return std::any_of(t.begin(), t.end(), [&](std::int32_t n) {
            return outside_of_ends(lumen.ends, settings.thickness_mm,
                                   inside->nodes_mm[std::size_t(n)]) < 0;
        });
    });
    for (auto& t : faces) std::swap(t[1], t[2]);  // the lumen's outside is the wall's inside
    return part_of(inside->nodes_mm, faces);
}

}  // namespace

Error wrong(const std::string& what) {
    return {ErrorCode::InvalidArgument, "vessel wall: " + what};
}

int edges_between(const TetMesh& mesh, const std::vector<bool>& from, const std::vector<bool>& to) {
    // Rounds over all cells: walls are few elements thick, so there are few rounds.
    std::vector<std::int32_t> steps(mesh.nodes_mm.size(), -1);
    for (std::size_t n = 0; n < steps.size(); ++n)
        if (from[n]) steps[n] = 0;
    for (std::int32_t round = 0;; ++round) {
        for (std::size_t n = 0; n < steps.size(); ++n)
            if (steps[n] == round && to[n]) return round;
        bool grew = false;
        for (const auto& cell : mesh.cells) {
            const bool reached = std::any_of(cell.begin(), cell.end(), [&](std::int32_t n) {
                return steps[std::size_t(n)] == round;
            });
            for (const std::int32_t n : cell)
                if (reached && steps[std::size_t(n)] < 0) {
                    steps[std::size_t(n)] = round + 1;
                    grew = true;
                }
        }
        if (!grew) return -1;
    }
}

Result<VesselWall> make_wall(const LumenShape& lumen, const WallSettings& settings,
                             const TaskArena& arena) {
    if (const Status s = check_settings(settings); !s) return s.error();
    const double t = settings.thickness_mm;
    const auto level = [&](Vec3d x) {
        const double d = lumen.distance_mm(x);
        return std::min({d, t - d, outside_of_ends(lumen.ends, t, x)});
    };
    StuffingSettings s;
    s.cell_mm = cell_of(settings);
    const double margin = t + 0.01 * s.cell_mm;
    s.begin_mm = lumen.begin_mm - Vec3d{margin, margin, margin};
    s.end_mm = lumen.end_mm + Vec3d{margin, margin, margin};
    s.changes_as_distance = true;
    s.most_cells = settings.most_cells;
    auto mesh = stuff_isosurface(level, s, arena);
    if (!mesh) return mesh.error();

    VesselWall wall;
    wall.mesh = std::move(*mesh);
    make_manifold(wall.mesh);  // at sharp rims it may touch itself
    if (wall.mesh.cells.empty()) return wrong("nothing is left of the wall between its ends");
    remove_cut_off(wall.mesh, lumen.ends, t);
    wall.ends = lumen.ends;
    const auto faces = boundary_faces(wall.mesh);
    std::vector<bool> inner(wall.mesh.nodes_mm.size(), false), outer = inner;
    for (const auto& face : faces)
        for (const std::int32_t n : face) {
            const double d = lumen.distance_mm(wall.mesh.nodes_mm[std::size_t(n)]);
            inner[std::size_t(n)] = std::abs(d) < 1e-6 * t;
            outer[std::size_t(n)] = std::abs(d - t) < 1e-6 * t;
        }
    wall.least_layers = edges_between(wall.mesh, inner, outer);
    if (settings.ghost_mm > 0) {
        auto ghost = coarse_ghost(lumen, settings, arena);
        if (!ghost) return ghost.error();
        wall.ghost = std::move(*ghost);
    } else {
        auto ghost = faces;
        std::erase_if(ghost, [&](const auto& face) {
            return !inner[std::size_t(face[0])] || !inner[std::size_t(face[1])] ||
                   !inner[std::size_t(face[2])];
        });
        wall.ghost = part_of(wall.mesh.nodes_mm, ghost);
    }
    wall.ghost_places = embed(wall.ghost.nodes_mm, wall.mesh, arena);
    remove_far_pieces(wall.ghost, wall.ghost_places);
    wall.lumen_mm3 = enclosed_with_lids_mm3(wall.ghost);
    return wall;
}

}  // namespace pliant::vessel
