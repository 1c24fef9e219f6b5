// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/material_points.h"

#include <algorithm>

#include "field/cell_block.h"

namespace pliant {

FieldCells::FieldCells(const Field& field)
    : m_field(field),
      m_size(field.brick_size()),
      m_scale(voxels_per_unit(field.grid())),
      m_is_at_rest(field.resident_brick_count() == 0) {
    field.for_each_brick([&](const FieldBrick& brick) {
        for (int a = 0; a < 3; ++a) {
            m_bounds.min[a] = std::min(m_bounds.min[a], m_scale[a] * brick.u_min[a]);
            m_bounds.max[a] = std::max(m_bounds.max[a], m_scale[a] * brick.u_max[a]);
        }
    });
}

void FieldCells::load(Vec3i coord) {
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

bool FieldCells::corners(Vec3i cell, std::array<Vec3d, 8>& points) {
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

bool FieldCells::is_whole(Vec3i cell) const {
    if (!m_field.may_have_gaps()) return true;
    for (int c = 0; c < 8; ++c) {
        const Vec3i e = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        if (m_field.is_void(e)) return false;
        for (int a = 0; a < 3; ++a)
            if (!(c >> a & 1) && !m_field.is_linked(e, a)) return false;
    }
    return true;
}

Vec3d MaterialPoints::now(Vec3d rest) {
    if (m_cells.is_identity()) return rest;
    const Vec3i cell = floor_of(rest);
    std::array<Vec3d, 8> points;
    if (!m_cells.corners(cell, points)) return rest;
    const Vec3d origin = real_of(cell);
    return origin + TrilinearCell(points).at(rest - origin);
}

std::optional<Vec3d> MaterialPoints::rest(Vec3d now) {
    if (m_cells.is_identity()) return now;
    const auto found = find_source(m_cells, now, now - m_offset);
    if (found) m_offset = now - *found;
    return found;
}

}  // namespace pliant
