// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/source_jacobian.h"

#include <cmath>

#include "field/cell_block.h"

namespace pliant {
namespace {

/// Tolerance of positions on a face: above the rounding of single precision [voxels].
constexpr double kNearFace = 1e-4;

Vec3<Fixed> displacement(const BrickRecord* record, int element) {
    return record ? record->displacement(element) : Vec3<Fixed>{0, 0, 0};
}

int edits(const BrickRecord* record, int element) {
    return record && record->edits ? record->edits[element] : 0;
}

}  // namespace

SourceJacobian::SourceJacobian(const Field& field, const Snapshot& snapshot)
    : m_field(field),
      m_snapshot(snapshot),
      m_size(field.brick_size()),
      m_scale(voxels_per_unit(field.grid())),
      m_may_have_gaps(snapshot.has_edits() || field.is_bounded()) {}

double SourceJacobian::at(Vec3d position) {
    for (int a = 0; a < 3; ++a) {
        const double whole = std::round(position[a]);
        if (std::abs(position[a] - whole) < kNearFace) position[a] = whole;
    }
    const Vec3d low{std::floor(position.x), std::floor(position.y), std::floor(position.z)};
    const Vec3i cell{int(low.x), int(low.y), int(low.z)};
    if (m_may_have_gaps) return beside_gaps(cell, position - low);
    return in_cell(corners_of(cell), position - low);
}

/// Value in the first whole cell that holds the position.
double SourceJacobian::beside_gaps(Vec3i cell, Vec3d t) {
    Vec3i other;  // −1: the position is on the cell's low face
    for (int a = 0; a < 3; ++a) other[a] = t[a] == 0 ? -1 : 0;
    for (int side = 0; side < 8; ++side) {
        const Vec3i way{side & 1 ? other.x : 0, side & 2 ? other.y : 0, side & 4 ? other.z : 0};
        const Corners corners = corners_of(cell + way);
        if (is_whole(cell + way, corners))
            return in_cell(corners, t - Vec3d{double(way.x), double(way.y), double(way.z)});
    }
    return 1;
}

SourceJacobian::Corners SourceJacobian::corners_of(Vec3i cell) {
    const Vec3i brick = m_field.brick_of(cell);
    if (!m_is_loaded || brick != m_brick) {
        for (int c = 0; c < 8; ++c)
            m_records[std::size_t(c)] =
                m_snapshot.record_at(brick + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        m_brick = brick;
        m_is_loaded = true;
    }
    const Vec3i local = cell - m_size * brick;
    Corners corners;
    for (int c = 0; c < 8; ++c) {
        int record = 0, element = 0;
        for (int a = 2; a >= 0; --a) {
            const int at = local[a] + (c >> a & 1);
            record |= at == m_size ? 1 << a : 0;
            element = m_size * element + (at == m_size ? 0 : at);
        }
        corners[std::size_t(c)] = {m_records[std::size_t(record)], element};
    }
    return corners;
}

/// Like cell_is_whole of strip_nodes.h: a cut opens no gap while both of its ends move alike.
bool SourceJacobian::is_whole(Vec3i cell, const Corners& corners) const {
    if (m_field.is_bounded()) {
        const Vec3i size = m_field.grid().size;
        for (int a = 0; a < 3; ++a)
            if (cell[a] < 0 || cell[a] + 1 >= size[a]) return false;
    }
    constexpr int kCut[3] = {kCutX, kCutY, kCutZ};
    for (std::size_t c = 0; c < 8; ++c) {
        const int flags = edits(corners[c].record, corners[c].element);
        if (flags & kVoid) return false;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (c >> axis & 1 || !(flags & kCut[axis])) continue;
            const Corner& next = corners[c | std::size_t(1) << axis];
            if (displacement(corners[c].record, corners[c].element) !=
                displacement(next.record, next.element))
                return false;
        }
    }
    return true;
}

/// det(I + ∂u/∂X), each column from the four edges along its axis.
double SourceJacobian::in_cell(const Corners& corners, Vec3d t) const {
    Vec3d u[8];
    for (std::size_t c = 0; c < 8; ++c) {
        const Vec3<Fixed> units = displacement(corners[c].record, corners[c].element);
        u[c] = {m_scale.x * units.x, m_scale.y * units.y, m_scale.z * units.z};
    }
    Mat3d f = kIdentity3;
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const int step = 1 << a;
        for (int edge = 0; edge < 4; ++edge) {
            const int low = (edge & 1 ? 1 << b : 0) | (edge & 2 ? 1 << c : 0);
            const double weight = (edge & 1 ? t[b] : 1 - t[b]) * (edge & 2 ? t[c] : 1 - t[c]);
            f.columns[a] = f.columns[a] + weight * (u[low | step] - u[low]);
        }
    }
    return determinant(f);
}

}  // namespace pliant
