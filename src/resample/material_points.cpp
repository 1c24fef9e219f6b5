// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/material_points.h"

#include <algorithm>
#include <cmath>

#include "field/cell_block.h"
#include "field/trilinear_cell.h"

namespace pliant {
namespace {

constexpr int kMaxSteps = 24;  // cells of a walk

Vec3d to_double(Vec3i v) {
    return {double(v.x), double(v.y), double(v.z)};
}
Vec3i floor_of(Vec3d p) {
    return {int(std::floor(p.x)), int(std::floor(p.y)), int(std::floor(p.z))};
}

/// Whether a point lies in the box around a cell.
bool is_near(const std::array<Vec3d, 8>& points, Vec3d p) {
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

}  // namespace

MaterialPoints::MaterialPoints(const Field& field)
    : m_field(field),
      m_size(field.brick_size()),
      m_scale(voxels_per_unit(field.grid())),
      m_is_at_rest(field.resident_brick_count() == 0) {
    field.for_each_brick([&](const FieldBrick& brick) {
        for (int a = 0; a < 3; ++a) {
            m_u_min[a] = std::min(m_u_min[a], m_scale[a] * brick.u_min[a]);
            m_u_max[a] = std::max(m_u_max[a], m_scale[a] * brick.u_max[a]);
        }
    });
}

void MaterialPoints::load(Vec3i coord) {
    if (m_block.is_loaded && m_block.coord == coord) return;
    m_block.is_loaded = true;
    m_block.coord = coord;
    m_block.is_at_rest = true;
    for (int c = 0; c < 8; ++c) {
        const int found = m_field.find_brick(coord + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        const FieldBrick* brick = found < 0 ? nullptr : &m_field.brick(found);
        if (brick && (brick->is_unplaced || pliant::is_at_rest(*brick))) brick = nullptr;
        m_block.bricks[std::size_t(c)] = brick;
        if (brick) m_block.is_at_rest = false;
    }
}

bool MaterialPoints::corners(Vec3i cell, std::array<Vec3d, 8>& points) {
    const Vec3i coord = m_field.brick_of(cell);
    load(coord);
    if (m_block.is_at_rest) return false;
    const Vec3i local = cell - m_size * coord;
    bool moved = false;
    for (int c = 0; c < 8; ++c) {
        Vec3i p = local + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        int brick = 0;
        for (int a = 0; a < 3; ++a)
            if (p[a] == m_size) {
                p[a] = 0;
                brick |= 1 << a;
            }
        Vec3d& point = points[std::size_t(c)];
        point = {double(c & 1), double(c >> 1 & 1), double(c >> 2)};
        const FieldBrick* const held = m_block.bricks[std::size_t(brick)];
        if (!held) continue;
        const int n = p.x + m_size * (p.y + m_size * p.z);
        for (int a = 0; a < 3; ++a) {
            const Fixed u = held->u[std::size_t(a)][n];
            moved = moved || u != 0;
            point[a] += m_scale[a] * u;
        }
    }
    return moved;
}

Vec3d MaterialPoints::now(Vec3d rest) {
    if (m_is_at_rest) return rest;
    const Vec3i cell = floor_of(rest);
    std::array<Vec3d, 8> points;
    if (!corners(cell, points)) return rest;
    const Vec3d origin = to_double(cell);
    return origin + TrilinearCell(points).at(rest - origin);
}

bool MaterialPoints::is_whole(Vec3i cell) const {
    if (!m_field.may_have_gaps()) return true;
    for (int c = 0; c < 8; ++c) {
        const Vec3i e = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        if (m_field.is_void(e)) return false;
        for (int a = 0; a < 3; ++a)
            if (!(c >> a & 1) && !m_field.is_linked(e, a)) return false;
    }
    return true;
}

std::optional<Vec3d> MaterialPoints::in_cell(Vec3i cell, Vec3d now) {
    std::array<Vec3d, 8> points;
    const Vec3d origin = to_double(cell), local = now - origin;
    if (!corners(cell, points)) {
        for (int a = 0; a < 3; ++a)
            if (!(local[a] >= 0 && local[a] <= 1)) return std::nullopt;
        return is_whole(cell) ? std::optional(now) : std::nullopt;
    }
    if (!is_near(points, local)) return std::nullopt;
    const auto at = TrilinearCell(points).locate(local);
    if (!at || !is_whole(cell)) return std::nullopt;
    return origin + *at;
}

std::optional<Vec3d> MaterialPoints::walk(Vec3d now, Vec3d from) {
    Vec3d rest = from;
    Vec3i last[2] = {};
    for (int step = 0; step < kMaxSteps; ++step) {
        const Vec3i cell = floor_of(rest);
        if (step > 1 && (cell == last[0] || cell == last[1])) return std::nullopt;
        last[1] = last[0];
        last[0] = cell;
        std::array<Vec3d, 8> points;
        const Vec3d origin = to_double(cell), local = now - origin;
        if (!corners(cell, points)) {  // the identity leads to the point itself
            bool inside = true;
            for (int a = 0; a < 3; ++a) inside = inside && local[a] >= 0 && local[a] <= 1;
            if (inside) return is_whole(cell) ? std::optional(now) : std::nullopt;
            rest = now;
            continue;
        }
        if (is_near(points, local)) {
            if (const auto at = TrilinearCell(points).locate(local))
                return is_whole(cell) ? std::optional(origin + *at) : std::nullopt;
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

std::optional<Vec3d> MaterialPoints::search(Vec3d now) {
    ++m_searches;
    // A cell that holds the point is at most the largest displacement away.
    Vec3i low = floor_of(now - m_u_max), high = floor_of(now - m_u_min);
    const Vec3i middle = floor_of(now - m_offset);
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
                    if (const auto found = in_cell({x, y, z}, now)) return found;
                }
            }
    return std::nullopt;
}

std::optional<Vec3d> MaterialPoints::rest(Vec3d now) {
    if (m_is_at_rest) return m_field.may_have_gaps() ? in_cell(floor_of(now), now) : now;
    auto found = walk(now, now - m_offset);
    if (!found) found = search(now);
    if (found) m_offset = now - *found;
    return found;
}

}  // namespace pliant
