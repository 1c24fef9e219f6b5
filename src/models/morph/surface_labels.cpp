// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inside of a closed surface as a label map: rays along x, filled by the parity of crossings.

#include <pliant/data/morph.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "base/errors.h"

namespace pliant {
namespace {

constexpr int kMarginVoxels = 2;
constexpr double kMostVoxels = 4e8;

/// Twice the area of (a, b, p) in the plane (y, z), the same number for (b, a, p) but its sign.
double turn(Vec3d a, Vec3d b, double y, double z) {
    const bool is_swapped = b.y < a.y || (b.y == a.y && b.z < a.z);
    if (is_swapped) std::swap(a, b);
    const double area = (b.y - a.y) * (z - a.z) - (b.z - a.z) * (y - a.y);
    return is_swapped ? -area : area;
}

/// Whether a point on the line through a and b counts as on its left: for one of both directions.
bool takes_line(Vec3d a, Vec3d b) {
    return b.z > a.z || (b.z == a.z && b.y < a.y);
}

/// Calls cross(j, k, x) where rays along x through voxel centres meet a triangle. Rays through a
/// common edge or node meet exactly one of the triangles on either side.
template <class Cross>
void for_crossings(const Grid& grid, const std::array<Vec3d, 3>& corners, const Cross& cross) {
    int low[2], high[2];
    for (const int a : {1, 2}) {
        double least = corners[0][a], most = least;
        for (const Vec3d& p : corners) {
            least = std::min(least, p[a]);
            most = std::max(most, p[a]);
        }
        const double h = grid.spacing_mm[a], from = grid.origin_mm[a];
        low[a - 1] = std::max(0, int(std::ceil((least - from) / h)));
        high[a - 1] = std::min(grid.size[a] - 1, int(std::floor((most - from) / h)));
    }
    for (int k = low[1]; k <= high[1]; ++k)
        for (int j = low[0]; j <= high[0]; ++j) {
            const double y = grid.origin_mm.y + j * grid.spacing_mm.y;
            const double z = grid.origin_mm.z + k * grid.spacing_mm.z;
            std::array<double, 3> share;  // of the corner opposite to an edge
            int left = 0, right = 0;
            for (std::size_t n = 0; n < 3; ++n) {
                const Vec3d &a = corners[(n + 1) % 3], &b = corners[(n + 2) % 3];
                share[n] = turn(a, b, y, z);
                const bool is_left = share[n] > 0 || (share[n] == 0 && takes_line(a, b));
                ++(is_left ? left : right);
            }
            const double sum = share[0] + share[1] + share[2];
            if ((left != 3 && right != 3) || sum == 0) continue;
            cross(j, k,
                  (share[0] * corners[0].x + share[1] * corners[1].x + share[2] * corners[2].x) /
                      sum);
        }
}

/// An error under the argument's name.
Error of_surface(Error error) {
    error.field = "surface";
    if (!error.message.starts_with(error.field)) error.message = "surface: " + error.message;
    return error;
}

Result<Grid> grid_around(const TriangleMesh& surface, double spacing_mm) {
    Vec3d low = surface.nodes_mm[0], high = low;
    for (const Vec3d& p : surface.nodes_mm)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    Grid grid{{1, 1, 1}, {spacing_mm, spacing_mm, spacing_mm}, low, kIdentity3};
    double count = 1;
    for (int a = 0; a < 3; ++a) {
        const double size = std::ceil((high[a] - low[a]) / spacing_mm) + 1 + 2 * kMarginVoxels;
        count *= size;
        if (!(count <= kMostVoxels))
            return expected_error(
                "surface",
                "at most 400 million voxels of " + toml_text(spacing_mm) + " mm around it", "more",
                ErrorCode::LimitExceeded);
        grid.size[a] = int(size);
        grid.origin_mm[a] = low[a] - kMarginVoxels * spacing_mm;
    }
    return grid;
}

}  // namespace

Result<Volume> labels_of_surface(const TriangleMesh& surface, double spacing_mm) noexcept {
    return attempt([&]() -> Result<Volume> {
        if (!(spacing_mm >= 0.01 && spacing_mm <= 100))
            return expected_error("spacing_mm", "0.01 to 100", toml_text(spacing_mm));
        for (const Status& s : {check_mesh(surface), check_closed(surface)})
            if (!s.ok()) return of_surface(s.error());
        const auto grid = grid_around(surface, spacing_mm);
        if (!grid.ok()) return grid.error();
        std::vector<std::vector<double>> rows(std::size_t(grid->size.y) *
                                              std::size_t(grid->size.z));
        for (const auto& cell : surface.cells) {
            std::array<Vec3d, 3> corners;
            for (std::size_t n = 0; n < 3; ++n) corners[n] = surface.nodes_mm[std::size_t(cell[n])];
            for_crossings(*grid, corners, [&](int j, int k, double x) {
                rows[std::size_t(j) + std::size_t(grid->size.y) * std::size_t(k)].push_back(x);
            });
        }
        VoxelArray<std::int16_t> voxels(voxel_count(*grid));
        std::fill(voxels.begin(), voxels.end(), std::int16_t{0});
        for (std::size_t row = 0; row < rows.size(); ++row) {
            std::vector<double>& crossings = rows[row];
            std::sort(crossings.begin(), crossings.end());
            for (std::size_t n = 0; n + 1 < crossings.size(); n += 2) {
                const auto voxel = [&](double x) {
                    return int(std::ceil((x - grid->origin_mm.x) / spacing_mm));
                };
                const int begin = std::max(0, voxel(crossings[n]));
                const int end = std::min(grid->size.x, voxel(crossings[n + 1]));
                for (int i = begin; i < end; ++i)
                    voxels[row * std::size_t(grid->size.x) + std::size_t(i)] = 1;
            }
        }
        Volume volume{*grid, std::move(voxels), {}};
        volume.background = 0;
        return volume;
    });
}

}  // namespace pliant
