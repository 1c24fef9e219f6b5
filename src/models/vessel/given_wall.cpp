// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A wall from a user's tetrahedra. Its boundary is split at sharp edges, the rims of the open ends:
//
//     ┌─────────────────────┐  outer surface: encloses the wall and the lumen
//     │ wall                │  annulus at the end: flat
//     ├─────────────────────┤
//       lumen                  inner surface: faces the lumen, so it encloses a negative volume
//     ├─────────────────────┤

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/errors.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

using Face = std::array<std::int32_t, 3>;

/// Rims are sharper than a ring of six nodes, whose faces meet at 60°.
constexpr double kRim_deg = 65;

Vec3d area_vector(std::span<const Vec3d> nodes, const Face& f) {
    const Vec3d a = nodes[std::size_t(f[0])];
    return 0.5 * cross(nodes[std::size_t(f[1])] - a, nodes[std::size_t(f[2])] - a);
}

/// Patches of a closed surface between sharp edges, as the faces of each.
std::vector<std::vector<Face>> patches_of(std::span<const Vec3d> nodes,
                                          const std::vector<Face>& faces) {
    std::vector<std::int32_t> parent(faces.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](std::int32_t f) {
        while (parent[std::size_t(f)] != f)
            f = parent[std::size_t(f)] = parent[std::size_t(parent[std::size_t(f)])];
        return f;
    };
    const double least = std::cos(kRim_deg * std::numbers::pi / 180);
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> sides;
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::size_t n = 0; n < 3; ++n) sides[{faces[f][n], faces[f][(n + 1) % 3]}] = int(f);
    for (const auto& [side, face] : sides) {
        const auto other = sides.find({side.second, side.first});
        if (other == sides.end() || other->second < face) continue;
        const Vec3d a = area_vector(nodes, faces[std::size_t(face)]),
                    b = area_vector(nodes, faces[std::size_t(other->second)]);
        if (dot(a, b) > least * norm(a) * norm(b))
            parent[std::size_t(root(other->second))] = root(face);
    }
    std::map<std::int32_t, std::vector<Face>> patches;
    for (std::size_t f = 0; f < faces.size(); ++f)
        patches[root(std::int32_t(f))].push_back(faces[f]);
    std::vector<std::vector<Face>> found;
    for (auto& [number, patch] : patches) found.push_back(std::move(patch));
    return found;
}

Result<TriangleMesh> inner_surface_of(const TetMesh& mesh) {
    TriangleMesh inner;
    double largest = 0;
    for (const auto& patch : patches_of(mesh.nodes_mm, boundary_faces(mesh))) {
        double area = 0;
        for (const Face& f : patch) area += norm(area_vector(mesh.nodes_mm, f));
        TriangleMesh part = part_of(mesh.nodes_mm, patch);
        const double volume = vessel::enclosed_with_lids_mm3(part);
        // Not the rounding error of an annulus.
        if (!(volume > std::max(largest, 1e-3 * std::pow(area, 1.5)))) continue;
        largest = volume;
        inner = std::move(part);
    }
    if (!inner.cells.empty()) return inner;
    return vessel::wrong(
        "it is no tube: no part of its boundary between rims sharper than 65° encloses a lumen, "
        "expected an inner surface that is open at the ends, or one that is given");
}

/// The ends at the openings of an inner surface that faces the lumen.
Result<std::vector<VesselEnd>> ends_at_openings(const TriangleMesh& ghost) {
    const auto openings = vessel::openings_of(ghost);
    if (!openings) return openings.error();
    std::vector<VesselEnd> ends;
    for (const auto& loop : *openings) {
        const auto at = [&](std::size_t n) {
            return ghost.nodes_mm[std::size_t(loop[n % loop.size()])];
        };
        Vec3d centre = at(0), inwards{0, 0, 0};
        for (std::size_t n = 0; n < loop.size(); ++n)
            centre = centre + (1 / double(loop.size())) * (at(n) - at(0));
        for (std::size_t n = 0; n < loop.size(); ++n)
            inwards = inwards + 0.5 * cross(at(n) - centre, at(n + 1) - centre);
        const double area = norm(inwards);
        if (!(area > 0)) return vessel::wrong("an opening of its inner surface has no area");
        ends.push_back({centre, (-1 / area) * inwards, std::sqrt(area / std::numbers::pi)});
    }
    const SurfaceTopology found = surface_topology(ghost);
    const auto lids = std::int64_t(ends.size());
    if (ends.empty() || found.pieces != 1 || found.euler + lids != 2)
        return vessel::wrong("it is no tube: its inner surface has " + std::to_string(lids) +
                             (lids == 1 ? " opening" : " openings") + ", " +
                             std::to_string(found.pieces) +
                             (found.pieces == 1 ? " piece" : " pieces") +
                             " and Euler characteristic " + std::to_string(found.euler) +
                             ", expected one or more openings, 1 piece and 2 − the openings");
    return ends;
}

Status check_lumen(const TriangleMesh& lumen) {
    if (const Status s = check_cells(lumen); !s)
        return vessel::wrong("inner surface: " + s.error().message);
    const SurfaceTopology found = surface_topology(lumen);
    const std::int64_t spots =
        found.non_manifold_edges + found.disagreeing_edges + found.pinched_nodes;
    if (spots == 0) return Ok{};
    return vessel::wrong("its inner surface branches or touches itself in " +
                         std::to_string(spots) + " edges and nodes, expected a manifold");
}

double mean_edge_mm(const TetMesh& mesh) {
    double sum = 0;
    for (const auto& cell : mesh.cells)
        sum += norm(mesh.nodes_mm[std::size_t(cell[0])] - mesh.nodes_mm[std::size_t(cell[1])]);
    return sum / double(mesh.cells.size());
}

/// Edges from the inner to the outer surface, without the annuli at the ends.
Result<int> layers_of(const VesselWall& wall, double thickness_mm) {
    const auto closed = vessel::with_lids(wall.ghost);
    if (!closed) return closed.error();
    const auto lumen = SurfaceDistance::create(*closed);
    if (!lumen) return lumen.error();
    const double edge = mean_edge_mm(wall.mesh);
    std::vector<bool> inner(wall.mesh.nodes_mm.size(), false), outer = inner;
    for (const Face& f : boundary_faces(wall.mesh))
        for (const std::int32_t node : f) {
            const auto n = std::size_t(node);
            const Vec3d x = wall.mesh.nodes_mm[n];
            if (vessel::outside_of_ends(wall.ends, thickness_mm, x) <= edge) continue;
            inner[n] = lumen->nearest(x, 0.5 * std::min(edge, thickness_mm)).triangle >= 0;
            outer[n] = !inner[n];
        }
    return vessel::edges_between(wall.mesh, inner, outer);
}

Result<VesselWall> make_given(TetMesh mesh, TriangleMesh lumen, const TaskArena& arena) {
    if (mesh.cells.empty()) return vessel::wrong("it has no tetrahedra, expected one or more");
    if (const Status s = check_cells(mesh); !s) return vessel::wrong(s.error().message);
    VesselWall wall;
    wall.mesh = with_used_nodes(mesh);
    const TetQuality quality = tet_quality(wall.mesh);
    if (const Status s = check_quality(quality); !s) return vessel::wrong(s.error().message);
    if (quality.pieces != 1)
        return vessel::wrong("it has " + std::to_string(quality.pieces) + " pieces, expected 1");
    if (lumen.cells.empty()) {
        auto inner = inner_surface_of(wall.mesh);
        if (!inner) return inner.error();
        lumen = std::move(*inner);
    }
    if (const Status s = check_lumen(lumen); !s) return s.error();
    if (vessel::enclosed_with_lids_mm3(lumen) < 0)
        for (Face& t : lumen.cells) std::swap(t[1], t[2]);
    wall.ghost = std::move(lumen);
    auto ends = ends_at_openings(wall.ghost);
    if (!ends) return ends.error();
    wall.ends = std::move(*ends);
    // The boundary of a tube of n ends is a sphere with n − 1 handles. More handles are branches
    // whose walls merge outside.
    const std::int64_t most = (4 - quality.boundary.euler) / 2;
    if (std::int64_t(wall.ends.size()) > most)
        return vessel::wrong("its inner surface has " + std::to_string(wall.ends.size()) +
                             " openings, expected at most the " + std::to_string(most) +
                             " of its tetrahedra");
    double area = 0;
    for (const Face& t : wall.ghost.cells) area += norm(area_vector(wall.ghost.nodes_mm, t));
    const double thickness_mm = quality.volume_mm3 / area;
    vessel::ride_on(wall.mesh, wall.ends, thickness_mm, 0, arena, wall.ghost, wall.ghost_positions);
    const auto layers = layers_of(wall, thickness_mm);
    if (!layers) return layers.error();
    wall.min_layers = *layers;
    wall.lumen_mm3 = vessel::enclosed_with_lids_mm3(wall.ghost);
    if (const Status s = check_wall(wall); !s) return s.error();
    return wall;
}

std::string counted(std::int64_t count, const char* one, const char* many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
}

Status check_ghost(const VesselWall& wall) {
    const SurfaceTopology ghost = surface_topology(wall.ghost);
    if (ghost.pieces != 1)
        return vessel::wrong("its inner surface has " + counted(ghost.pieces, "piece", "pieces") +
                             ", expected 1");
    const std::int64_t spots =
        ghost.non_manifold_edges + ghost.disagreeing_edges + ghost.pinched_nodes;
    if (spots > 0)
        return vessel::wrong("its inner surface branches or touches itself in " +
                             counted(spots, "edge or node", "edges and nodes") +
                             ", expected a manifold");
    const auto openings = vessel::openings_of(wall.ghost);
    if (!openings) return openings.error();
    if (openings->size() != wall.ends.size())
        return vessel::wrong("its inner surface has " +
                             counted(std::int64_t(openings->size()), "opening", "openings") +
                             ", expected " + std::to_string(wall.ends.size()) +
                             ", one at each end of the vessel");
    if (wall.ghost_positions.size() != wall.ghost.nodes_mm.size())
        return vessel::wrong("ghost_positions: expected " +
                             std::to_string(wall.ghost.nodes_mm.size()) + ", found " +
                             std::to_string(wall.ghost_positions.size()));
    std::int64_t away = 0;
    for (std::size_t n = 0; n < wall.ghost_positions.size(); ++n)
        away += vessel::is_beside(wall.ghost_positions[n], wall.ghost.nodes_mm[n], wall.mesh);
    if (away > 0)
        return vessel::wrong(
            counted(away, "node of its inner surface lies", "nodes of its inner surface lie") +
            " beside the wall, expected all on it");
    return Ok{};
}

Status check_parts_of(const VesselWall& wall, int layers) {
    if (const Status s = check_cells(wall.ghost); !s) return s;
    if (const Status s = check_mesh(wall.mesh); !s) return s;
    const TetQuality quality = tet_quality(wall.mesh);
    if (const Status s = check_quality(quality); !s) return vessel::wrong(s.error().message);
    if (quality.pieces != 1)
        return vessel::wrong("it has " + counted(quality.pieces, "piece", "pieces") +
                             ", expected 1");
    if (const Status s = check_ghost(wall); !s) return s;
    if (wall.min_layers < layers)
        return vessel::wrong(counted(wall.min_layers, "layer", "layers") +
                             " of tetrahedra across it, expected " + std::to_string(layers) +
                             " or more");
    return Ok{};
}

}  // namespace

Result<VesselWall> wall_of_mesh(TetMesh mesh, TriangleMesh lumen, const TaskArena& arena) noexcept {
    return attempt([&] { return make_given(std::move(mesh), std::move(lumen), arena); });
}

// Validity checks of walls from any source.

Status check_wall(const VesselWall& wall, int layers) noexcept {
    return attempt([&] { return check_parts_of(wall, layers); });
}

}  // namespace pliant
