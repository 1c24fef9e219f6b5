// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/beam.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/beam.cpp"  // this file, compiled again for each target
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/beam_cubic.inc"  // parts of this file
#include "render/beam_rays.inc"

HWY_BEFORE_NAMESPACE();
namespace pliant::render {
namespace HWY_NAMESPACE {
namespace {

/// A range of cells or bricks, both ends included; empty if last < first.
struct Reach {
    int first, last;
};

/// Range of a beam on another axis between two planes across its main axis.
/// @param near, far  distances from the eye to the planes; 0 ≤ near < far
HWY_INLINE Reach reach_of(double eye, const Slopes& slopes, double near, double far, int block,
                          int blocks) {
    constexpr double kMargin = 1e-6;  // cells: more than all rounding
    const double low = eye + std::min(near * slopes.least, far * slopes.least) - kMargin;
    const double high = eye + std::max(near * slopes.most, far * slopes.most) + kMargin;
    const double scale = 1.0 / block;
    return {int(std::floor(std::clamp(low * scale, 0.0, double(blocks)))),
            int(std::floor(std::clamp(high * scale, -1.0, blocks - 1.0)))};
}

/// Traversal of the grid by a beam.
template <class T>
class Beam {
  public:
    HWY_INLINE Beam(const BeamInput<T>& input, Rays& rays) : m_input(input), m_rays(rays) {
        const Vec3i n = input.size;
        m_cells = {n.x - 1, n.y - 1, n.z - 1};
        m_stride[0] = 1;
        m_stride[1] = n.x;
        m_stride[2] = std::ptrdiff_t(n.x) * n.y;
    }

    /// Casts the rays in use, all of which point to one octant.
    /// @param first, end  vectors of rays
    HWY_INLINE void cast(std::size_t first, std::size_t end) {
        const Vec3d middle = m_rays.direction_of(m_rays.first_in_use(first, end));
        const Vec3d size{std::abs(middle.x), std::abs(middle.y), std::abs(middle.z)};
        m_axis[0] = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
        m_axis[1] = (m_axis[0] + 1) % 3;
        m_axis[2] = (m_axis[0] + 2) % 3;
        for (int a = 0; a < 3; ++a) m_forward[a] = middle[a] > 0;
        const int main = m_axis[0];
        const double eye = m_input.eye[main];
        const int cells = m_cells[main];
        if (m_forward[main] ? !(eye < cells) : !(eye > 0)) return;
        const int from = m_forward[main]
                             ? std::max(0, int(std::floor(std::max(eye, 0.0))))
                             : std::min(cells, int(std::ceil(std::min(eye, double(cells))))) - 1;
        follow(first, end, from / kFineCells, true);
    }

  private:
    /// Distance from the eye to a plane across the main axis, forwards, at least 0.
    HWY_INLINE double ahead(int position) const {
        const double d = position - m_input.eye[m_axis[0]];
        return std::max(m_forward[m_axis[0]] ? d : -d, 0.0);
    }

    struct Slab {
        double near, far;
    };
    HWY_INLINE Slab slab_of(int block, int size) const {
        const int low = block * size, high = std::min(low + size, m_cells[m_axis[0]]);
        return m_forward[m_axis[0]] ? Slab{ahead(low), ahead(high)} : Slab{ahead(high), ahead(low)};
    }

    /// Traverses slices of bricks. @param may_split  splits wide beams into beams of one vector
    HWY_NOINLINE void follow(std::size_t first, std::size_t end, int brick, bool may_split) {
        const int main = m_axis[0], u = m_axis[1], v = m_axis[2];
        const Slopes su = m_rays.slopes(u, main, m_forward[main], first, end);
        const Slopes sv = m_rays.slopes(v, main, m_forward[main], first, end);
        const double steepest = std::max({-su.least, su.most, -sv.least, sv.most, 1.0});
        const double across_per_slice = std::ceil(steepest);
        const Vec3i bricks = m_input.leaps->size;
        const std::ptrdiff_t brick_stride[3] = {1, bricks.x, std::ptrdiff_t(bricks.x) * bricks.y};
        const int step = m_forward[main] ? 1 : -1;
        while (brick >= 0 && brick < bricks[main]) {
            const Slab slab = slab_of(brick, kFineCells);
            const Reach ru =
                reach_of(m_input.eye[u], su, slab.near, slab.far, kFineCells, bricks[u]);
            const Reach rv =
                reach_of(m_input.eye[v], sv, slab.near, slab.far, kFineCells, bricks[v]);
            int least = LeapMap::kFarthest;
            const std::uint8_t* codes = m_input.leaps->codes.data() + brick * brick_stride[main];
            for (int j = rv.first; j <= rv.last; ++j)
                for (int i = ru.first; i <= ru.last; ++i)
                    least = std::min(
                        least, codes[i * brick_stride[u] + j * brick_stride[v]] & ~LeapMap::kAbove);
            if (ru.last < ru.first || rv.last < rv.first) least = 1;  // outside of the grid
            if (least > 0) {
                brick += step * (1 + int((least - 1) / across_per_slice));
                continue;
            }
            constexpr double kWidest = 2.5;  // cells, at the far end
            if (may_split && end - first > kVectorsOfPart &&
                slab.far * std::max(su.most - su.least, sv.most - sv.least) > kWidest) {
                for (std::size_t part = first; part < end; part += kVectorsOfPart) {
                    const std::size_t part_end = std::min(part + kVectorsOfPart, end);
                    if (m_rays.any_in_use(part, part_end)) follow(part, part_end, brick, false);
                }
                return;
            }
            if (!through_bricks(first, end, brick, su, sv)) return;
            brick += step;
        }
    }

    /// Traverses the slices of cells in a slice of bricks. @returns whether rays are left
    HWY_INLINE bool through_bricks(std::size_t first, std::size_t end, int brick, const Slopes& su,
                                   const Slopes& sv) {
        const int main = m_axis[0], u = m_axis[1], v = m_axis[2];
        const int low = brick * kFineCells, high = std::min(low + kFineCells, m_cells[main]);
        for (int s = 0; s < high - low; ++s) {
            Vec3i cell;
            cell[main] = m_forward[main] ? low + s : high - 1 - s;
            const Slab slab = slab_of(cell[main], 1);
            if (!(slab.near < slab.far)) continue;  // behind the eye
            const Reach ru = reach_of(m_input.eye[u], su, slab.near, slab.far, 1, m_cells[u]);
            const Reach rv = reach_of(m_input.eye[v], sv, slab.near, slab.far, 1, m_cells[v]);
            bool ended = false;
            for (int j = rv.first; j <= rv.last; ++j)
                for (int i = ru.first; i <= ru.last; ++i) {
                    cell[u] = m_forward[u] ? i : ru.first + ru.last - i;
                    cell[v] = m_forward[v] ? j : rv.first + rv.last - j;
                    ended |= in_cell(first, end, cell);
                }
            if (ended && !m_rays.any_in_use(first, end)) return false;
        }
        return true;
    }

    /// Intersects the rays with a cell if it contains the threshold. @returns whether some of them
    /// ended
    HWY_INLINE bool in_cell(std::size_t first, std::size_t end, Vec3i cell) {
        const T* p = m_input.voxels + cell.x + cell.y * m_stride[1] + cell.z * m_stride[2];
        const T* q = p + m_stride[2];
        const std::ptrdiff_t row = m_stride[1];
        const T threshold = m_input.threshold;
        const int above = int(p[0] >= threshold) + int(p[1] >= threshold) +
                          int(p[row] >= threshold) + int(p[row + 1] >= threshold) +
                          int(q[0] >= threshold) + int(q[1] >= threshold) +
                          int(q[row] >= threshold) + int(q[row + 1] >= threshold);
        if (above == 0 || above == 8) return false;
        const CellForm form(
            CellCorners{{double(p[0]), double(p[1]), double(p[row]), double(p[row + 1]),
                         double(q[0]), double(q[1]), double(q[row]), double(q[row + 1])}});
        return m_rays.try_cell(form, cell, m_forward, m_input.eye, m_input.iso, m_input.rising,
                               first, end);
    }

    const BeamInput<T>& m_input;
    Rays& m_rays;
    Vec3i m_cells;
    std::ptrdiff_t m_stride[3];
    int m_axis[3];      // the main axis first
    bool m_forward[3];  // along x, y, z
};

template <class T>
HWY_INLINE void cast_all(const BeamInput<T>& input, std::span<const Vec3d> directions,
                         double* distances) {
    Rays rays;
    for (std::size_t begin = 0; begin < directions.size(); begin += kRaysOfBeam) {
        const std::size_t count = std::min(kRaysOfBeam, directions.size() - begin);
        rays.set(directions.data() + begin, count, input.voxel_from_world);
        const std::size_t vectors = (count + kLanes - 1) / kLanes;
        Beam<T> beam(input, rays);
        while (rays.choose_octant(vectors)) beam.cast(0, vectors);
        std::copy_n(rays.hit, count, distances + begin);
    }
}

void cast_16_bits(const BeamInput<std::int16_t>& input, std::span<const Vec3d> directions,
                  double* distances) {
    cast_all(input, directions, distances);
}
void cast_floats(const BeamInput<float>& input, std::span<const Vec3d> directions,
                 double* distances) {
    cast_all(input, directions, distances);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace pliant::render
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant::render {
namespace {
HWY_EXPORT(cast_16_bits);
HWY_EXPORT(cast_floats);
}  // namespace

void cast_beams(const BeamInput<std::int16_t>& input, std::span<const Vec3d> directions,
                double* distances) {
    HWY_DYNAMIC_DISPATCH(cast_16_bits)(input, directions, distances);
}
void cast_beams(const BeamInput<float>& input, std::span<const Vec3d> directions,
                double* distances) {
    HWY_DYNAMIC_DISPATCH(cast_floats)(input, directions, distances);
}

}  // namespace pliant::render
#endif
