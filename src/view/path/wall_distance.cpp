// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Crossings on lines along x have fractional x but whole y and z, and likewise for y and z. So each
// of the three families is first searched along its axis (nearest crossing on the line). The
// results are on voxels, and two passes of the line transform along the other axes propagate them.
// Taking the minimum of two families before a common pass saves one of the six passes:
//
//   d² = min( Z( min( Y(x), X(y) ) ), Y( X(z) ) )

#include "path/wall_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/voxel_field.h"
#include "volume/line_transform.h"

namespace pliant::render {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

class BoxTransform {
  public:
    BoxTransform(const Volume& volume, const Box3i& box, const LumenSide& lumen,
                 const TaskArena& arena)
        : m_volume(volume),
          m_lumen(lumen),
          m_arena(arena),
          m_begin(box.begin),
          m_size(box.end - box.begin),
          m_stride{1, std::size_t(m_size.x), std::size_t(m_size.x) * std::size_t(m_size.y)} {}

    std::size_t count() const { return m_stride[2] * std::size_t(m_size.z); }

    /// Squared distance of each voxel to the nearest crossing on its line along an axis.
    void search(int axis, std::vector<float>& squares) const {
        squares.resize(count());
        with_field(m_volume, [&](const auto& field) {
            const std::ptrdiff_t steps[3] = {1, field.row(), field.slice()};
            for_each_line(axis, [&](Vec3i first, std::size_t at, auto&) {
                search_line(field.at(m_begin + first), steps[axis], squares.data() + at, axis);
            });
        });
    }

    void spread(int axis, std::vector<float>& squares) const {
        for_each_line(axis, [&](Vec3i, std::size_t at, LineTransform& transform) {
            transform.run(squares.data() + at, m_stride[axis], m_size[axis], spacing(axis));
        });
    }

  private:
    double spacing(int axis) const { return m_volume.grid.spacing_mm[axis]; }

    template <class Body>
    void for_each_line(int axis, const Body& body) const {
        const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        m_arena.for_each(
            std::int64_t(m_size[u]) * m_size[v], 256, [&](std::int64_t begin, std::int64_t end) {
                LineTransform transform(m_size[axis]);
                for (std::int64_t line = begin; line < end; ++line) {
                    Vec3i first{0, 0, 0};
                    first[u] = int(line % m_size[u]);
                    first[v] = int(line / m_size[u]);
                    body(first,
                         std::size_t(first[u]) * m_stride[u] + std::size_t(first[v]) * m_stride[v],
                         transform);
                }
            });
    }

    template <class T>
    void search_line(const T* value, std::ptrdiff_t step, float* square, int axis) const {
        const int n = m_size[axis];
        const std::size_t stride = m_stride[axis];
        const double mm = spacing(axis);
        const auto keep = [&](int i, double crossing) {
            const double d = (i - crossing) * mm;
            float& s = square[std::size_t(i) * stride];
            s = std::min(s, float(d * d));
        };
        // Two passes: the last crossing behind, then the next one ahead.
        double crossing = -std::numeric_limits<double>::infinity();
        for (int i = 0; i < n; ++i) {
            if (i > 0) crossing = between(value, step, i - 1, crossing);
            square[std::size_t(i) * stride] = kFar;
            if (std::isfinite(crossing)) keep(i, crossing);
        }
        crossing = std::numeric_limits<double>::infinity();
        for (int i = n - 1; i-- > 0;) {
            crossing = between(value, step, i, crossing);
            if (std::isfinite(crossing)) keep(i, crossing);
        }
    }

    /// Position of the crossing between voxels i and i + 1, or `otherwise`.
    template <class T>
    double between(const T* value, std::ptrdiff_t step, int i, double otherwise) const {
        const double a = double(value[i * step]), b = double(value[(i + 1) * step]);
        return m_lumen.contains(a) == m_lumen.contains(b) ? otherwise
                                                          : i + (m_lumen.iso_hu - a) / (b - a);
    }

    const Volume& m_volume;
    const LumenSide& m_lumen;
    const TaskArena& m_arena;
    Vec3i m_begin, m_size;
    std::size_t m_stride[3];
};

void take_less(std::vector<float>& a, const std::vector<float>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = std::min(a[i], b[i]);
}

}  // namespace

void wall_distance(const Volume& volume, const Box3i& box, const LumenSide& lumen,
                   const TaskArena& arena, std::vector<float>& wall_mm) {
    const BoxTransform transform(volume, box, lumen, arena);
    std::vector<float> other;
    transform.search(0, wall_mm);
    transform.spread(1, wall_mm);
    transform.search(1, other);
    transform.spread(0, other);
    take_less(wall_mm, other);
    transform.spread(2, wall_mm);
    transform.search(2, other);
    transform.spread(0, other);
    transform.spread(1, other);
    take_less(wall_mm, other);
    for (float& s : wall_mm) s = std::sqrt(s);
}

}  // namespace pliant::render
