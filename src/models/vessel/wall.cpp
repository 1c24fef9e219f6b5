// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "vessel/wall.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/errors.h"

namespace pliant {

SettingRows<WallSettings> wall_rows() noexcept {
    using S = WallSettings;
    static constexpr Setting<S> kRows[] = {
        setting<&S::thickness_mm>({.name = "thickness_mm",
                                   .unit = "mm",
                                   .range = {.low = 0},
                                   .above_low = true,
                                   .text = "thickness of the wall"}),
        setting<&S::layers>(
            {.name = "layers", .range = {1, 16}, .text = "tetrahedra across the wall, at least"}),
        setting<&S::cell_mm>({.name = "cell_mm",
                              .unit = "mm",
                              .range = {.low = 0},
                              .text = "cell of the lattice; 0: as the layers allow"}),
        setting<&S::ghost_mm>({.name = "ghost_mm",
                               .unit = "mm",
                               .range = {.low = 0},
                               .text = "cell for the ghost surface; 0: the wall's"}),
    };
    return kRows;
}

}  // namespace pliant

namespace pliant::vessel {
namespace {

/// Approximate distance of a point from the part that an end cuts off: a half space, limited to the
/// vessel's extent around the end, so that other branches are not cut.
double outside_of_end(const VesselEnd& end, double thickness_mm, Vec3d x) {
    const Vec3d from = x - end.centre_mm;
    const double beyond = dot(from, end.outward);
    return std::max(-beyond, norm(from) - (1.5 * end.radius_mm + 2 * thickness_mm));
}

/// Whether a point lies on the far boundary of an end's cut.
bool behind_end(const VesselEnd& end, double thickness_mm, Vec3d x) {
    const Vec3d from = x - end.centre_mm;
    const double reach = 1.5 * end.radius_mm + 2 * thickness_mm;
    return dot(from, end.outward) > 0 && std::abs(norm(from) - reach) < 1e-6 * thickness_mm;
}

/// Cell size for the layers. An edge of the mesh has at most 1.59 cells (a short one with both ends
/// warped away), so layers − 1 edges don't reach across; and the surfaces need two layers to stay
/// apart.
double cell_of_layers(const WallSettings& s) {
    return s.thickness_mm / (1.6 * std::max(1, s.layers - 1));
}

}  // namespace

double outside_of_ends(const std::vector<VesselEnd>& ends, double thickness_mm, Vec3d x) {
    double least = std::numeric_limits<double>::infinity();
    for (const VesselEnd& end : ends) least = std::min(least, outside_of_end(end, thickness_mm, x));
    return least;
}

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

namespace {

/// Compares the wall's inner faces with the ghost surface: a hole through the wall, or a missing
/// part, changes their Euler characteristic. (The outer surface is no criterion: walls of adjacent
/// branches merge there.)
/// @param is_beside  [node]: on the outer surface, or on an end's cut
Status check_inner_faces(const TetMesh& mesh, const std::vector<bool>& is_beside,
                         const TriangleMesh& ghost) {
    auto faces = boundary_faces(mesh);
    std::erase_if(faces, [&](const auto& face) {
        return std::any_of(face.begin(), face.end(),
                           [&](std::int32_t n) { return is_beside[std::size_t(n)]; });
    });
    TriangleMesh surface = part_of(mesh.nodes_mm, faces);
    tidy_rims(surface);
    const SurfaceTopology found = surface_topology(surface), expected = surface_topology(ghost);
    if (found.pieces == expected.pieces && found.euler == expected.euler) return Ok{};
    return wrong("it has holes: its inner faces have " + std::to_string(found.pieces) +
                 " pieces and Euler characteristic " + std::to_string(found.euler) + ", expected " +
                 std::to_string(expected.pieces) + " and " + std::to_string(expected.euler));
}

/// Makes a wall with cells of this size.
Result<VesselWall> wall_of_cells(const LumenShape& lumen, const WallSettings& settings,
                                 double cell_mm, const TaskArena& arena) {
    const double t = settings.thickness_mm;
    const auto level = [&](Vec3d x) {
        const double d = lumen.distance_mm(x);
        return std::min({d, t - d, outside_of_ends(lumen.ends, t, x)});
    };
    StuffingSettings s;
    s.cell_mm = cell_mm;
    const double margin = t + 0.01 * s.cell_mm;
    s.begin_mm = lumen.begin_mm - Vec3d{margin, margin, margin};
    s.end_mm = lumen.end_mm + Vec3d{margin, margin, margin};
    s.changes_as_distance = true;
    s.max_cells = settings.max_cells;
    auto mesh = stuff_isosurface(level, s, arena);
    if (!mesh) return mesh.error();

    VesselWall wall;
    wall.cell_mm = cell_mm;
    wall.mesh = std::move(*mesh);
    make_manifold(wall.mesh);  // at sharp rims it may touch itself
    if (wall.mesh.cells.empty()) return wrong("nothing is left of the wall between its ends");
    remove_cut_off(wall.mesh, lumen.ends, t);
    wall.dropped_pieces = drop_crumbs(wall.mesh);
    wall.ends = lumen.ends;
    std::vector<bool> inner(wall.mesh.nodes_mm.size(), false), outer = inner, beside = inner;
    for (const auto& face : boundary_faces(wall.mesh))
        for (const std::int32_t node : face) {
            const auto n = std::size_t(node);
            const Vec3d x = wall.mesh.nodes_mm[n];
            const double d = lumen.distance_mm(x);
            inner[n] = std::abs(d) < 1e-6 * t;
            outer[n] = std::abs(d - t) < 1e-6 * t;
            beside[n] = outer[n] || (!inner[n] && outside_of_ends(lumen.ends, t, x) < cell_mm);
        }
    wall.min_layers = edges_between(wall.mesh, inner, outer);
    auto ghost = ghost_of(lumen, settings, s, arena);
    if (!ghost) return ghost.error();
    wall.ghost = std::move(*ghost);
    ride_on(wall.mesh, wall.ends, t, std::max(cell_mm, settings.ghost_mm), arena, wall.ghost,
            wall.ghost_positions);
    if (const Status holds = check_inner_faces(wall.mesh, beside, wall.ghost); !holds)
        return holds.error();
    wall.lumen_mm3 = enclosed_with_lids_mm3(wall.ghost);
    return wall;
}

}  // namespace

Result<VesselWall> make_wall(const LumenShape& lumen, const WallSettings& settings,
                             const TaskArena& arena) {
    if (const Status s = check(settings, wall_rows()); !s) return within("vessel wall", s.error());
    const double by_layers = cell_of_layers(settings);
    const double wanted = settings.cell_mm > 0 ? settings.cell_mm : by_layers;
    const double allowed = std::min(wanted, by_layers);
    std::vector<double> cells_mm{wanted};
    if (allowed < wanted) cells_mm.push_back(allowed);
    cells_mm.push_back(allowed / std::numbers::sqrt2);
    cells_mm.push_back(allowed / 2);
    std::string first, last;
    for (const double cell_mm : cells_mm) {
        auto wall = wall_of_cells(lumen, settings, cell_mm, arena);
        if (!wall && wall.error().code == ErrorCode::LimitExceeded) {
            if (first.empty() || is_out_of_memory(wall.error())) return wall.error();
            break;
        }
        const Status sound = wall ? check_wall(*wall, settings.layers) : Status(wall.error());
        if (sound.ok()) {
            wall->refined_because = first;
            return wall;
        }
        const bool is_the_same = sound.error().message == last;
        last = sound.error().message;
        if (first.empty()) first = last;
        if (is_the_same) break;  // smaller cells don't help
    }
    return Error{ErrorCode::InvalidArgument, last + ", with smaller cells as well"};
}

}  // namespace pliant::vessel
