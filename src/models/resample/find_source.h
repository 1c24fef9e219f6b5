// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// φ⁻¹ of a point, for any storage of the displacements. All positions are in voxels:
//
//   φ(X) = X + u(X), u trilinear in each cell             find_source(cells, φ(X), from) = X
//
// The inverse walks from cell to cell: Newton's step in a cell that doesn't hold the point leads to
// a neighbour. Where that goes in a circle (tissue beside strongly sheared air), all cells that can
// hold the point are searched, the nearest first.
//
// The source is exact to kSourceError. There is none only where no whole cell holds the point; in
// a cell that is folded, or nearly so, Newton's method may miss it. Of several, where space is
// folded, it is one near the first guess.
//
// Cells is a type with
//
//   bool corners(Vec3i cell, std::array<Vec3d, 8>& points)
//       images of the corners, relative to the cell's lowest element at rest; false: it is at rest
//   bool is_whole(Vec3i cell)
//       false: a cut or a carving has left a gap, the cell has no image
//   DisplacementBounds bounds()
//       of all displacements; for the search only

#pragma once

#include <pliant/core/vec.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "field/trilinear_cell.h"

namespace pliant {

/// Bound of |X − φ⁻¹(x)| [voxels].
constexpr double kSourceError = 1e-9;
/// A point this far outside of a cell is in it, too, so that rounding leaves no gap between cells
/// [cell coordinates].
constexpr double kOnFace = 1e-10;

struct DisplacementBounds {
    Vec3d min{0, 0, 0}, max{0, 0, 0};  ///< [voxels]
};

inline Vec3i floor_of(Vec3d p) {
    return {int(std::floor(p.x)), int(std::floor(p.y)), int(std::floor(p.z))};
}
inline Vec3d real_of(Vec3i p) {
    return {double(p.x), double(p.y), double(p.z)};
}

/// Whether a point lies in the box around a cell's corners.
inline bool is_near(const std::array<Vec3d, 8>& points, Vec3d p) {
    constexpr double kBeside = 1e-6;  // larger than the tolerance of the inverse [voxels]
    for (int a = 0; a < 3; ++a) {
        double low = points[0][a], high = low;
        for (const Vec3d& corner : points) {
            low = std::min(low, corner[a]);
            high = std::max(high, corner[a]);
        }
        if (p[a] < low - kBeside || p[a] > high + kBeside) return false;
    }
    return true;
}

/// Whether a point lies in a cell at rest. @param local  relative to its lowest element
inline bool is_in_unit_cell(Vec3d local) {
    return local.x >= 0 && local.x <= 1 && local.y >= 0 && local.y <= 1 && local.z >= 0 &&
           local.z <= 1;
}

/// The source of a point that lies in one cell.
template <class Cells>
std::optional<Vec3d> find_source_in(Cells& cells, Vec3i cell, Vec3d now) {
    std::array<Vec3d, 8> points;
    const Vec3d origin = real_of(cell), local = now - origin;
    if (!cells.corners(cell, points)) {
        if (!is_in_unit_cell(local) || !cells.is_whole(cell)) return std::nullopt;
        return now;
    }
    if (!is_near(points, local)) return std::nullopt;
    const auto at = TrilinearCell(points).locate_from_corners(local, kOnFace);
    if (!at || !cells.is_whole(cell)) return std::nullopt;
    return origin + *at;
}

/// The source of a point, by a walk. @param from  its start
/// @returns nothing if the walk ends in a gap, or goes in a circle
template <class Cells>
std::optional<Vec3d> walk_to_source(Cells& cells, Vec3d now, Vec3d from) {
    constexpr int kMaxSteps = 24;
    Vec3d rest = from;
    Vec3i last[2] = {};
    for (int step = 0; step < kMaxSteps; ++step) {
        const Vec3i cell = floor_of(rest);
        if (step > 1 && (cell == last[0] || cell == last[1])) return std::nullopt;
        last[1] = last[0];
        last[0] = cell;
        std::array<Vec3d, 8> points;
        const Vec3d origin = real_of(cell), local = now - origin;
        if (!cells.corners(cell, points)) {  // the identity leads to the point itself
            if (is_in_unit_cell(local))
                return cells.is_whole(cell) ? std::optional(now) : std::nullopt;
            rest = now;
            continue;
        }
        if (is_near(points, local)) {
            if (const auto at = TrilinearCell(points).locate(local, kOnFace))
                return cells.is_whole(cell) ? std::optional(origin + *at) : std::nullopt;
        }
        // The cell's mean edges, to the neighbour in the point's direction.
        Vec3d edges[3], middle{0, 0, 0};
        for (int a = 0; a < 3; ++a) edges[a] = {0, 0, 0};
        for (int c = 0; c < 8; ++c) {
            const Vec3d p = points[std::size_t(c)];
            middle = middle + 0.125 * p;
            for (int a = 0; a < 3; ++a) edges[a] = edges[a] + ((c >> a & 1) ? 0.25 : -0.25) * p;
        }
        const Mat3d jacobian{{edges[0], edges[1], edges[2]}};
        if (!(std::abs(determinant(jacobian)) > 1e-9)) return std::nullopt;
        const Vec3d t = inverse(jacobian) * (local - middle);
        Vec3d way;
        for (int a = 0; a < 3; ++a) way[a] = std::clamp(0.5 + t[a], -0.5, 1.5);
        if (floor_of(origin + way) == cell) return std::nullopt;
        rest = origin + way;
    }
    return std::nullopt;
}

/// The source of a point, by a look into all cells that can hold it.
/// @param from  first guess: cells near it come first
template <class Cells>
std::optional<Vec3d> search_source(Cells& cells, Vec3d now, Vec3d from) {
    // A cell that holds the point is at most the largest displacement away.
    const DisplacementBounds bounds = cells.bounds();
    Vec3i low = floor_of(now - bounds.max), high = floor_of(now - bounds.min);
    const Vec3i middle = floor_of(from);
    int reach = 0;
    for (int a = 0; a < 3; ++a) {
        --low[a];
        ++high[a];
        reach = std::max({reach, middle[a] - low[a], high[a] - middle[a]});
    }
    for (int ring = 0; ring <= reach; ++ring)
        for (int z = std::max(low.z, middle.z - ring); z <= std::min(high.z, middle.z + ring); ++z)
            for (int y = std::max(low.y, middle.y - ring); y <= std::min(high.y, middle.y + ring);
                 ++y) {
                const bool on_face =
                    std::abs(z - middle.z) == ring || std::abs(y - middle.y) == ring;
                const int step = on_face || ring == 0 ? 1 : 2 * ring;
                for (int x = middle.x - ring; x <= middle.x + ring; x += step) {
                    if (x < low.x || x > high.x) continue;
                    if (const auto found = find_source_in(cells, {x, y, z}, now)) return found;
                }
            }
    return std::nullopt;
}

/// φ⁻¹ of a point. @param from  first guess
/// @returns nothing if a cut or a carving has left a gap there
template <class Cells>
std::optional<Vec3d> find_source(Cells& cells, Vec3d now, Vec3d from) {
    if (const auto found = walk_to_source(cells, now, from)) return found;
    return search_source(cells, now, from);
}
/// Likewise. The first guess is where the displacement is that of the point's own position.
template <class Cells>
std::optional<Vec3d> find_source(Cells& cells, Vec3d now) {
    const Vec3i cell = floor_of(now);
    const Vec3d local = now - real_of(cell);
    std::array<Vec3d, 8> points;
    if (!cells.corners(cell, points)) return find_source(cells, now, now);
    return find_source(cells, now, now - (TrilinearCell(points).at(local) - local));
}

}  // namespace pliant
