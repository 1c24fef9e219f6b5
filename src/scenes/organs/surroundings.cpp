// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "organs/surroundings.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "mesh/box_tree.h"

namespace pliant {
namespace {

constexpr double kAir_hu = -250;      ///< lower values are air
constexpr double kHuPerMm = 250;      ///< a step between air and tissue over some voxels
constexpr double kStuffedCells = 12;  ///< tetrahedra of the mesher's lattice in a cube

}  // namespace

Result<Organ> make_surroundings(std::span<const Organ> organs, const Volume& scan,
                                double thickness_mm, std::int64_t tetrahedra,
                                const TaskArena& arena) {
    std::vector<SurfaceDistance> surfaces;
    std::vector<mesh::Bounds> bounds;
    mesh::Bounds box, whole;
    for (const Organ& organ : organs) {
        auto surface = SurfaceDistance::create(boundary_triangles(organ.mesh));
        if (!surface) return within(organ.name, surface.error());
        surfaces.push_back(std::move(*surface));
        bounds.emplace_back();
        for (const Vec3d& p : organ.mesh.nodes_mm) bounds.back().add(p);
        box.add(bounds.back());
    }
    // The scan's box along the world's axes; an oblique scan ends before its corners.
    const Vec3i size = scan.grid.size;
    for (int c = 0; c < 8; ++c)
        whole.add(world_from_voxel(
            scan.grid,
            {c & 1 ? size.x - 1.0 : 0.0, c & 2 ? size.y - 1.0 : 0.0, c & 4 ? size.z - 1.0 : 0.0}));
    Vec3d low, high;
    double volume = 1;
    for (int a = 0; a < 3; ++a) {
        low[a] = std::max(box.low[a] - thickness_mm, whole.low[a]);
        high[a] = std::min(box.high[a] + thickness_mm, whole.high[a]);
        volume *= high[a] - low[a];
    }
    const double cell = std::cbrt(kStuffedCells * volume / double(tetrahedra));
    const auto level = [&](Vec3d x) {
        double inside = kHuPerMm * 1e3;
        for (int a = 0; a < 3; ++a) inside = std::min({inside, x[a] - low[a], high[a] - x[a]});
        const Vec3d ijk = voxel_from_world(scan.grid, x);
        inside = std::min(inside, (double(sample_linear(scan, ijk)) - kAir_hu) / kHuPerMm);
        for (std::size_t n = 0; n < surfaces.size(); ++n)
            if (inside > 0 && bounds[n].distance_squared(x) < inside * inside)
                inside = std::min(inside, surfaces[n].signed_mm(x));
        return inside;
    };
    const double margin = 0.01 * cell;
    auto mesh = stuff_isosurface(level,
                                 {.begin_mm = low - Vec3d{margin, margin, margin},
                                  .end_mm = high + Vec3d{margin, margin, margin},
                                  .cell_mm = cell},
                                 arena);
    if (!mesh) return within("surroundings", mesh.error());
    (void)make_manifold(*mesh);
    (void)drop_crumbs(*mesh);
    Organ around{.name = "surroundings", .mesh = std::move(*mesh)};
    around.settings.name = around.name;
    for (int a = 0; a < 3; ++a)
        for (const double face : {low[a], high[a]}) {
            Vec3d one = low - Vec3d{margin, margin, margin},
                  other = high + Vec3d{margin, margin, margin};
            one[a] = face - margin;
            other[a] = face + margin;
            around.settings.held_mm.insert(around.settings.held_mm.end(), {one, other});
        }
    return around;
}

}  // namespace pliant
