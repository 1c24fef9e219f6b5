// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The ghost surface comes from the lumen, not from the wall's faces, so that a cell missing in the
// wall leaves no hole in it. The lumen is stuffed with tetrahedra in the wall's lattice and cut at
// the same ends; its boundary without the cuts is the ghost surface. If the wall is thick enough
// for its cells, both meshes share their nodes there.
//
//     ───────────────────────────   outer surface
//      wall
//     ═══════════════════════════   d = 0: the ghost surface
//      lumen, stuffed           ┆   cut at the end: excluded
//     ═══════════════════════════

#include <algorithm>
#include <cmath>
#include <numeric>

#include "vessel/wall.h"

namespace pliant::vessel {
namespace {

/// Smaller weights are rounding errors: the point lies on a face, an edge or a node.
constexpr double kRounding = 1e-9;
/// The wall's rims are rounded over about a cell; the ghost surface may be trimmed by this much.
constexpr double kRimCells = 2;

/// Fans of triangles around a node: connected by shared edges at the node.
std::vector<std::vector<std::int32_t>> fans_around(const TriangleMesh& mesh, std::int32_t node,
                                                   const std::vector<std::int32_t>& ring) {
    std::vector<std::vector<std::int32_t>> fans;
    std::vector<std::int32_t> left = ring;
    const auto share_edge = [&](std::int32_t s, std::int32_t t) {
        const auto& a = mesh.cells[std::size_t(s)];
        const auto& b = mesh.cells[std::size_t(t)];
        return std::any_of(a.begin(), a.end(), [&](std::int32_t n) {
            return n != node && std::find(b.begin(), b.end(), n) != b.end();
        });
    };
    while (!left.empty()) {
        std::vector<std::int32_t> fan{left.back()};
        left.pop_back();
        for (std::size_t at = 0; at < fan.size(); ++at)
            for (std::size_t n = left.size(); n-- > 0;)
                if (share_edge(fan[at], left[n])) {
                    fan.push_back(left[n]);
                    left.erase(left.begin() + std::ptrdiff_t(n));
                }
        fans.push_back(std::move(fan));
    }
    return fans;
}

/// Removes triangles connected to a rim by a single node, until there is none.
void remove_pinches(TriangleMesh& mesh) {
    for (;;) {
        std::vector<std::vector<std::int32_t>> rings(mesh.nodes_mm.size());
        for (std::size_t t = 0; t < mesh.cells.size(); ++t)
            for (const std::int32_t n : mesh.cells[t])
                rings[std::size_t(n)].push_back(std::int32_t(t));
        std::vector<bool> gone(mesh.cells.size(), false);
        bool any = false;
        for (std::size_t n = 0; n < rings.size(); ++n) {
            const auto fans = fans_around(mesh, std::int32_t(n), rings[n]);
            if (fans.size() < 2) continue;
            const auto largest =
                std::max_element(fans.begin(), fans.end(),
                                 [](const auto& a, const auto& b) { return a.size() < b.size(); });
            for (auto fan = fans.begin(); fan != fans.end(); ++fan)
                if (fan != largest)
                    for (const std::int32_t t : *fan) any = gone[std::size_t(t)] = true;
        }
        if (!any) return;
        std::vector<std::array<std::int32_t, 3>> kept;
        for (std::size_t t = 0; t < gone.size(); ++t)
            if (!gone[t]) kept.push_back(mesh.cells[t]);
        mesh = part_of(mesh.nodes_mm, kept);
    }
}

/// Removes fragments at a rim: pieces of less than 1 % of the largest one.
void remove_crumbs(TriangleMesh& mesh) {
    if (mesh.cells.empty()) return;
    const auto piece = pieces(mesh);
    std::vector<std::int64_t> size(mesh.nodes_mm.size(), 0);
    for (const auto& t : mesh.cells) ++size[std::size_t(piece[std::size_t(t[0])])];
    const std::int64_t most = *std::max_element(size.begin(), size.end());
    const auto removed = std::erase_if(mesh.cells, [&](const auto& t) {
        return 100 * size[std::size_t(piece[std::size_t(t[0])])] < most;
    });
    if (removed > 0) mesh = part_of(mesh.nodes_mm, std::vector(mesh.cells));
}

}  // namespace

void tidy_rims(TriangleMesh& surface) {
    remove_pinches(surface);
    remove_crumbs(surface);
}

bool is_beside(const Embedded& position, Vec3d ghost_node, const TetMesh& wall) {
    // A point of the tetrahedron that is nearly the nearest.
    Vec3d near{0, 0, 0};
    double sum = 0, longest = 0;
    for (const double w : position.weights) sum += std::max(0.0, w);
    const auto corner = [&](std::size_t k) {
        return wall.nodes_mm[std::size_t(wall.cells[std::size_t(position.tetrahedron)][k])];
    };
    for (std::size_t k = 0; k < 4; ++k) {
        near = near + (std::max(0.0, position.weights[k]) / sum) * corner(k);
        for (std::size_t other = 0; other < k; ++other)
            longest = std::max(longest, norm(corner(k) - corner(other)));
    }
    return norm(ghost_node - near) > longest;
}

Result<TriangleMesh> ghost_of(const LumenShape& lumen, const WallSettings& settings,
                              StuffingSettings lattice, const TaskArena& arena) {
    if (settings.ghost_mm > 0) lattice.cell_mm = settings.ghost_mm;
    const double t = settings.thickness_mm;
    const auto level = [&](Vec3d x) {
        return std::min(-lumen.distance_mm(x), outside_of_ends(lumen.ends, t, x));
    };
    auto solid = stuff_isosurface(level, lattice, arena);
    if (!solid) return solid.error();
    make_manifold(*solid);
    if (solid->cells.empty()) return wrong("nothing is left of the lumen between its ends");
    remove_cut_off(*solid, lumen.ends, t);
    // Nodes at a cut are not on the lumen's surface. (Neither are nodes where cells were lost at
    // a sharp edge of the surface; these are not near an end, and belong to the ghost
    // surface.)
    std::vector<bool> is_cut(solid->nodes_mm.size());
    for (std::size_t n = 0; n < is_cut.size(); ++n) {
        const Vec3d x = solid->nodes_mm[n];
        is_cut[n] = std::abs(lumen.distance_mm(x)) > 1e-6 * t &&
                    outside_of_ends(lumen.ends, t, x) < lattice.cell_mm;
    }
    auto faces = boundary_faces(*solid);
    std::erase_if(faces, [&](const auto& face) {
        return std::any_of(face.begin(), face.end(),
                           [&](std::int32_t n) { return is_cut[std::size_t(n)]; });
    });
    for (auto& face : faces)
        std::swap(face[1], face[2]);  // outside of the lumen is inside the wall
    TriangleMesh ghost = part_of(solid->nodes_mm, faces);
    tidy_rims(ghost);
    return ghost;
}

void ride_on(const TetMesh& wall, const std::vector<VesselEnd>& ends, double thickness_mm,
             double cell_mm, const TaskArena& arena, TriangleMesh& ghost,
             std::vector<Embedded>& positions) {
    for (;;) {
        positions = embed(ghost.nodes_mm, wall, arena);
        std::vector<bool> gone(positions.size());
        for (std::size_t n = 0; n < positions.size(); ++n)
            gone[n] = is_beside(positions[n], ghost.nodes_mm[n], wall) &&
                      outside_of_ends(ends, thickness_mm, ghost.nodes_mm[n]) < kRimCells * cell_mm;
        const auto removed = std::erase_if(ghost.cells, [&](const auto& t) {
            return std::any_of(t.begin(), t.end(),
                               [&](std::int32_t n) { return gone[std::size_t(n)]; });
        });
        if (removed == 0) break;
        ghost = part_of(ghost.nodes_mm, std::vector(ghost.cells));
        tidy_rims(ghost);
    }
    for (Embedded& e : positions) {
        for (double& w : e.weights)
            if (std::abs(w) < kRounding) w = 0;
        const double sum = std::accumulate(e.weights.begin(), e.weights.end(), 0.0);
        for (double& w : e.weights) w /= sum;
    }
}

}  // namespace pliant::vessel
