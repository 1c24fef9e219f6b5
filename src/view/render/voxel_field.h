// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The volume's voxels as a continuous field over voxel space: trilinear between voxel centres,
// constant beyond the outermost ones.

#pragma once

#include <pliant/core/vec.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cstddef>

namespace pliant::render {

/// Corner values of one cell, x fastest: bit 0 of the index is x, bit 1 y, bit 2 z.
struct CellCorners {
    double v[8];
};

/// Trilinear interpolation. @param f  local coordinates in the cell, 0…1
inline double interpolate(const CellCorners& c, Vec3d f) {
    const double* v = c.v;
    const double x00 = v[0] + f.x * (v[1] - v[0]), x10 = v[2] + f.x * (v[3] - v[2]);
    const double x01 = v[4] + f.x * (v[5] - v[4]), x11 = v[6] + f.x * (v[7] - v[6]);
    const double y0 = x00 + f.y * (x10 - x00), y1 = x01 + f.y * (x11 - x01);
    return y0 + f.z * (y1 - y0);
}

template <class T>
class VoxelField {
  public:
    VoxelField(const T* voxels, Vec3i size)
        : m_voxels(voxels), m_size(size), m_row(size.x), m_slice(std::ptrdiff_t(size.x) * size.y) {}

    Vec3i size() const { return m_size; }
    /// Voxel ijk. @pre inside the grid
    const T* at(Vec3i p) const { return m_voxels + p.x + p.y * m_row + p.z * m_slice; }
    std::ptrdiff_t row() const { return m_row; }
    std::ptrdiff_t slice() const { return m_slice; }

    /// @pre 0 ≤ cell < size − 1
    CellCorners corners(Vec3i cell) const {
        const T* p = at(cell);
        const T* q = p + m_slice;
        return {{double(p[0]), double(p[1]), double(p[m_row]), double(p[m_row + 1]), double(q[0]),
                 double(q[1]), double(q[m_row]), double(q[m_row + 1])}};
    }

    /// Value at a continuous voxel index; any size ≥ 1, any position.
    double sample(Vec3d ijk) const {
        std::ptrdiff_t offset = 0, next[3];
        const std::ptrdiff_t stride[3] = {1, m_row, m_slice};
        Vec3d f{};
        for (int a = 0; a < 3; ++a) {
            const int last = m_size[a] - 1;
            const double p = std::clamp(ijk[a], 0.0, double(last));
            const int cell = std::clamp(int(p), 0, std::max(last - 1, 0));
            f[a] = p - cell;
            offset += cell * stride[a];
            next[a] = last > 0 ? stride[a] : 0;
        }
        const T* p = m_voxels + offset;
        const T* q = p + next[2];
        return interpolate(
            {{double(p[0]), double(p[next[0]]), double(p[next[1]]), double(p[next[0] + next[1]]),
              double(q[0]), double(q[next[0]]), double(q[next[1]]), double(q[next[0] + next[1]])}},
            f);
    }

    /// Central differences one voxel wide, interpolated trilinearly; one-sided at the border.
    /// @returns change per voxel along i, j, k
    Vec3d gradient(Vec3d ijk) const {
        Vec3d g{};
        for (int a = 0; a < 3; ++a) {
            const double last = m_size[a] - 1;
            Vec3d before = ijk, after = ijk;
            before[a] = std::clamp(ijk[a] - 1, 0.0, last);
            after[a] = std::clamp(ijk[a] + 1, 0.0, last);
            const double width = after[a] - before[a];
            g[a] = width > 0 ? (sample(after) - sample(before)) / width : 0;
        }
        return g;
    }

  private:
    const T* m_voxels;
    Vec3i m_size;
    std::ptrdiff_t m_row, m_slice;
};

/// Calls body with the volume's VoxelField of either type.
template <class Body>
auto with_field(const Volume& volume, const Body& body) {
    if (const auto* v = std::get_if<0>(&volume.voxels))
        return body(VoxelField<std::int16_t>(v->data(), volume.grid.size));
    return body(VoxelField<float>(std::get_if<1>(&volume.voxels)->data(), volume.grid.size));
}

}  // namespace pliant::render
