// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/embedded_lattice.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/errors.h"

namespace pliant {
namespace {

constexpr std::int64_t kMaxControlNodes = 1'000'000;

/// The control nodes around the mesh, clipped to the scan.
Result<ControlGrid> control_grid_around(const Volume& scan, const TetMesh& mesh, double cell_mm,
                                        double reach_mm) {
    const Grid& g = scan.grid;
    Vec3d low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    for (const Vec3d& p : mesh.nodes_mm) {
        const Vec3d ijk = voxel_from_world(g, p);
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], ijk[a]);
            high[a] = std::max(high[a], ijk[a]);
        }
    }
    ControlGrid grid;
    std::int64_t count = 1;
    for (int a = 0; a < 3; ++a) {
        const double reach = reach_mm / g.spacing_mm[a];
        const int last = g.size[a] - 1;
        grid.cell[a] =
            std::clamp(int(std::lround(cell_mm / g.spacing_mm[a])), 1, std::max(1, last));
        if (last < 1 || !(high[a] > 0) || !(low[a] < last))
            return about("mesh", ErrorCode::InvalidArgument,
                         "expected a body inside of the scan, found one beside it");
        grid.first[a] =
            std::clamp(int(std::floor(low[a] - reach)), 0, std::max(0, last - grid.cell[a]));
        const int end = std::clamp(int(std::ceil(high[a] + reach)), grid.first[a] + 1, last);
        const int cells = (end - grid.first[a] + grid.cell[a] - 1) / grid.cell[a];
        const int most = (last - grid.first[a]) / grid.cell[a];
        grid.size[a] = std::max(1, std::min(cells, most)) + 1;
        count *= grid.size[a];
    }
    if (count > kMaxControlNodes)
        return about("cell_mm", ErrorCode::LimitExceeded,
                     "expected cells so large that there are at most " +
                         std::to_string(kMaxControlNodes) + " control nodes, found " +
                         std::to_string(count));
    return grid;
}

}  // namespace

Result<EmbeddedLattice> embed_lattice(const Volume& scan, const TetMesh& mesh, double cell_mm,
                                      double reach_mm, const TaskArena& arena) {
    const auto grid = control_grid_around(scan, mesh, cell_mm, reach_mm);
    if (!grid) return grid.error();
    auto lattice = ControlLattice::create(scan, *grid, arena);
    if (!lattice) return lattice.error();
    std::vector<Vec3d> points;
    for (std::int32_t n = 0; n < (*lattice)->node_count(); ++n)
        points.push_back((*lattice)->node_mm(n));
    const std::vector<Embedded> embedded = embed(points, mesh, arena);
    EmbeddedLattice made{std::move(*lattice), {}};
    for (std::size_t n = 0; n < points.size(); ++n) {
        Embedded at = embedded[n];
        double sum = 0;
        for (double& w : at.weights) sum += w = std::max(0.0, w);
        for (double& w : at.weights) w /= sum;
        const double share = std::min(1.0, norm(points[n] - place_of(at, mesh)) / reach_mm);
        const double fade = (1 - share * share) * (1 - share * share);
        for (double& w : at.weights) w *= fade;
        made.carried.push_back({mesh.cells[std::size_t(at.tetrahedron)], at.weights});
    }
    return made;
}

}  // namespace pliant
