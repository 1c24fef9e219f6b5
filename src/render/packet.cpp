// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/packet.h"

#include <algorithm>
#include <cstring>
#include <limits>

// Vectors without a size at compile time can't be kept in structs.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/packet.cpp"  // this file, compiled again for each target
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/packet_cell.inc"
#include "render/packet_cubic.inc"  // parts of this file

HWY_BEFORE_NAMESPACE();
namespace pliant::render {
namespace HWY_NAMESPACE {
namespace {

/// A vector of rays on their way.
template <class T>
class Packet {
  public:
    HWY_INLINE Packet(const PacketScene<T>& scene, const V3& world_direction) : m_scene(scene) {
        const D d;
        const Mat3d& m = scene.voxel_from_world;
        const V3& w = world_direction;
        const auto component = [&](int a) HWY_ATTR {
            return hn::Add(hn::Add(hn::Mul(w.x, hn::Set(d, m.columns[0][a])),
                                   hn::Mul(w.y, hn::Set(d, m.columns[1][a]))),
                           hn::Mul(w.z, hn::Set(d, m.columns[2][a])));
        };
        m_direction = {component(0), component(1), component(2)};
        const V one = hn::Set(d, 1), none = hn::Zero(d);
        const double row = scene.size.x, slice = row * scene.size.y;
        const auto axis = [&](V along, double from, V& flat_origin, V& inverse, V& step, V& high,
                              V& stride, double cells) HWY_ATTR {
            const M flat = hn::Eq(along, none), back = hn::Lt(along, none);
            // Where a ray runs along a plane, this puts the meeting with it at infinity.
            flat_origin = hn::IfThenElse(flat, hn::Set(d, -kInfinity), hn::Set(d, from));
            inverse = hn::IfThenElse(flat, one, hn::Div(one, along));
            step = hn::IfThenElse(back, hn::Set(d, -1), one);
            high = hn::IfThenElse(back, none, one);
            stride = hn::IfThenElse(back, hn::Set(d, -cells), hn::Set(d, cells));
        };
        axis(m_direction.x, scene.origin.x, m_flat_origin.x, m_inverse.x, m_step.x, m_high.x,
             m_stride.x, 1);
        axis(m_direction.y, scene.origin.y, m_flat_origin.y, m_inverse.y, m_step.y, m_high.y,
             m_stride.y, row);
        axis(m_direction.z, scene.origin.z, m_flat_origin.z, m_inverse.z, m_step.z, m_high.z,
             m_stride.z, slice);
        clip();
    }

    HWY_INLINE V first_hit() {
        const D d;
        m_hit = hn::Set(d, kInfinity);
        if (hn::AllFalse(d, m_live)) return m_hit;
        start();
        while (true) {
            leap();
            if (hn::AllFalse(d, m_live)) return m_hit;
            walk();
        }
    }

  private:
    HWY_INLINE V3 at(V t) const {
        const D d;
        const Vec3d& o = m_scene.origin;
        return {hn::Add(hn::Set(d, o.x), hn::Mul(t, m_direction.x)),
                hn::Add(hn::Set(d, o.y), hn::Mul(t, m_direction.y)),
                hn::Add(hn::Set(d, o.z), hn::Mul(t, m_direction.z))};
    }
    /// t at which the rays meet planes across the axes.
    HWY_INLINE V3 meets(const V3& places) const {
        return {hn::Mul(hn::Sub(places.x, m_flat_origin.x), m_inverse.x),
                hn::Mul(hn::Sub(places.y, m_flat_origin.y), m_inverse.y),
                hn::Mul(hn::Sub(places.z, m_flat_origin.z), m_inverse.z)};
    }
    static HWY_INLINE V least(const V3& v) { return hn::Min(hn::Min(v.x, v.y), v.z); }

    /// Which axis has the least exit; the first one of equals.
    struct Axes {
        M x, y, z;
    };
    static HWY_INLINE Axes exit_axes(const V3& exit) {
        const M x = hn::And(hn::Le(exit.x, exit.y), hn::Le(exit.x, exit.z));
        const M y = hn::AndNot(x, hn::And(hn::Lt(exit.y, exit.x), hn::Le(exit.y, exit.z)));
        return {x, y, hn::Not(hn::Or(x, y))};
    }
    /// v moved by `by` on the axes where `which` says so.
    static HWY_INLINE V3 stepped(const V3& v, const Axes& axes, M which, const V3& by) {
        return {hn::Add(v.x, hn::IfThenElseZero(hn::And(axes.x, which), by.x)),
                hn::Add(v.y, hn::IfThenElseZero(hn::And(axes.y, which), by.y)),
                hn::Add(v.z, hn::IfThenElseZero(hn::And(axes.z, which), by.z))};
    }
    static HWY_INLINE V3 chosen(M which, const V3& yes, const V3& no) {
        return {hn::IfThenElse(which, yes.x, no.x), hn::IfThenElse(which, yes.y, no.y),
                hn::IfThenElse(which, yes.z, no.z)};
    }
    static HWY_INLINE V3 clamped(const V3& v, const V3& low, const V3& high) {
        return {hn::Min(hn::Max(v.x, low.x), high.x), hn::Min(hn::Max(v.y, low.y), high.y),
                hn::Min(hn::Max(v.z, low.z), high.z)};
    }
    static HWY_INLINE V3 all(double x, double y, double z) {
        const D d;
        return {hn::Set(d, x), hn::Set(d, y), hn::Set(d, z)};
    }
    HWY_INLINE V3 last_cell() const {
        const Vec3i n = m_scene.size;
        return all(n.x - 2, n.y - 2, n.z - 2);
    }

    /// The part of each ray, t ≥ 0, between the outermost voxel centres.
    HWY_INLINE void clip() {
        const D d;
        const Vec3i n = m_scene.size;
        const Vec3d o = m_scene.origin;
        m_t = hn::Zero(d);
        m_end = hn::Set(d, kInfinity);
        m_live = hn::Eq(m_t, m_t);
        const auto axis = [&](V along, V inverse, double from, double cells) HWY_ATTR {
            const M flat = hn::Eq(along, hn::Zero(d));
            const V p = hn::Mul(hn::Set(d, 0 - from), inverse);
            const V q = hn::Mul(hn::Set(d, cells - from), inverse);
            m_t = hn::IfThenElse(flat, m_t, hn::Max(m_t, hn::Min(p, q)));
            m_end = hn::IfThenElse(flat, m_end, hn::Min(m_end, hn::Max(p, q)));
            if (!(from >= 0 && from <= cells)) m_live = hn::AndNot(flat, m_live);
        };
        axis(m_direction.x, m_inverse.x, o.x, n.x - 1);
        axis(m_direction.y, m_inverse.y, o.y, n.y - 1);
        axis(m_direction.z, m_inverse.z, o.z, n.z - 1);
        m_live = hn::And(m_live, hn::And(hn::Lt(m_t, m_end), hn::Lt(m_end, hn::Set(d, kInfinity))));
    }

    /// Puts each ray into its first brick, and finds out which side of the threshold it is on.
    HWY_INLINE void start() {
        const D d;
        const double per_cell = 1.0 / kFineCells;
        const V3 p = at(m_t);
        const Vec3i n = m_scene.leaps->size;
        const V3 place{hn::Mul(p.x, hn::Set(d, per_cell)), hn::Mul(p.y, hn::Set(d, per_cell)),
                       hn::Mul(p.z, hn::Set(d, per_cell))};
        m_brick = clamped({hn::Floor(place.x), hn::Floor(place.y), hn::Floor(place.z)},
                          all(0, 0, 0), all(n.x - 1, n.y - 1, n.z - 1));
        const M from_origin = hn::Eq(m_t, hn::Zero(d));
        m_above = m_scene.origin_above ? from_origin : hn::Lt(m_t, hn::Zero(d));
        const M entering = hn::AndNot(from_origin, m_live);
        if (hn::AllFalse(d, entering)) return;
        const Field<T> field(m_scene.voxels, m_scene.size);
        HWY_ALIGN double x[kLanes], y[kLanes], z[kLanes], above[kLanes];
        hn::Store(p.x, d, x), hn::Store(p.y, d, y), hn::Store(p.z, d, z);
        for (std::size_t i = 0; i < hn::Lanes(d); ++i)  // rays that come from outside
            above[i] = field.sample({x[i], y[i], z[i]}) >= m_scene.iso ? 1 : 0;
        const M sampled = hn::Ne(hn::Load(d, above), hn::Zero(d));
        m_above = hn::Or(m_above, hn::And(entering, sampled));
    }

    /// The code of each ray's brick in the leap map.
    HWY_INLINE V codes() const {
        const D d;
        const DI di;
        const Vec3i n = m_scene.leaps->size;
        const V at = hn::Add(
            m_brick.x,
            hn::Mul(hn::Set(d, n.x), hn::Add(m_brick.y, hn::Mul(hn::Set(d, n.y), m_brick.z))));
        // Rays that are done may stand outside of the grid.
        const VI index = hn::DemoteTo(di, hn::IfThenElseZero(m_live, at));
        const VI four = gather_32(m_scene.leaps->codes.data(), index);
        return hn::PromoteTo(d, hn::And(four, hn::Set(di, 255)));
    }

    /// Ends rays that turn to the wanted side on the face to a uniform block. @param above  its
    /// side
    HWY_INLINE void enter_uniform(M which, M above) {
        const M turned = hn::And(which, hn::Xor(above, m_above));
        m_above = hn::Or(hn::And(which, above), hn::AndNot(which, m_above));
        const M hit = m_scene.rising ? hn::And(turned, above) : hn::AndNot(above, turned);
        m_hit = hn::IfThenElse(hit, m_t, m_hit);
        m_live = hn::AndNot(hit, m_live);
    }

    /// Until each ray that is left is in a brick that holds the threshold.
    HWY_INLINE void leap() {
        const D d;
        const V one = hn::Set(d, 1), size = hn::Set(d, kFineCells);
        const V per_cell = hn::Set(d, 1.0 / kFineCells);
        while (true) {
            const V code = codes();
            const M uniform = hn::And(m_live, hn::Gt(code, hn::Zero(d)));
            if (hn::AllFalse(d, uniform)) return;
            const M above = hn::Ge(code, hn::Set(d, LeapMap::kAbove));
            enter_uniform(uniform, above);
            const V distance =
                hn::Sub(code, hn::IfThenElseZero(above, hn::Set(d, LeapMap::kAbove)));
            const V within = hn::Sub(distance, one);
            // The farthest brick of the leap on each axis, and the plane beyond it.
            const auto last = [&](V brick, V step)
                                  HWY_ATTR { return hn::Add(brick, hn::Mul(step, within)); };
            const V3 far{last(m_brick.x, m_step.x), last(m_brick.y, m_step.y),
                         last(m_brick.z, m_step.z)};
            const V3 exit = meets({hn::Mul(size, hn::Add(far.x, m_high.x)),
                                   hn::Mul(size, hn::Add(far.y, m_high.y)),
                                   hn::Mul(size, hn::Add(far.z, m_high.z))});
            m_t = hn::IfThenElse(uniform, least(exit), m_t);
            m_live = hn::AndNot(hn::And(uniform, hn::Ge(m_t, m_end)), m_live);
            const V3 p = at(m_t);
            // On other axes rounding must lead neither backwards nor out of the leap.
            const auto reached = [&](V place, V brick, V end) HWY_ATTR {
                const V there = hn::Floor(hn::Mul(place, per_cell));
                return hn::Min(hn::Max(there, hn::Min(brick, end)), hn::Max(brick, end));
            };
            const V3 there{reached(p.x, m_brick.x, far.x), reached(p.y, m_brick.y, far.y),
                           reached(p.z, m_brick.z, far.z)};
            const Axes axes = exit_axes(exit);
            const V3 next{hn::IfThenElse(axes.x, hn::Add(far.x, m_step.x), there.x),
                          hn::IfThenElse(axes.y, hn::Add(far.y, m_step.y), there.y),
                          hn::IfThenElse(axes.z, hn::Add(far.z, m_step.z), there.z)};
            m_brick = chosen(uniform, next, m_brick);
        }
    }

    /// Puts each ray into the cell of its brick where it is at t.
    HWY_INLINE void enter_bricks() {
        const D d;
        const V size = hn::Set(d, kFineCells), inside = hn::Set(d, kFineCells - 1);
        const V3 low{hn::Mul(size, m_brick.x), hn::Mul(size, m_brick.y), hn::Mul(size, m_brick.z)};
        const V3 end = last_cell();
        const V3 high{hn::Min(hn::Add(low.x, inside), end.x),
                      hn::Min(hn::Add(low.y, inside), end.y),
                      hn::Min(hn::Add(low.z, inside), end.z)};
        const V3 p = at(m_t);
        const V3 cell = clamped({hn::Floor(p.x), hn::Floor(p.y), hn::Floor(p.z)}, low, high);
        const auto far = [&](V brick_low, V positive)
                             HWY_ATTR { return hn::Add(brick_low, hn::Mul(size, positive)); };
        m_brick_exit = meets({far(low.x, m_high.x), far(low.y, m_high.y), far(low.z, m_high.z)});
        m_brick_end = hn::Min(least(m_brick_exit), m_end);
        m_place = {hn::Add(cell.x, m_high.x), hn::Add(cell.y, m_high.y), hn::Add(cell.z, m_high.z)};
        m_exit = meets(m_place);
        const double row = m_scene.size.x, slice = row * m_scene.size.y;
        m_cell = hn::Add(
            cell.x, hn::Add(hn::Mul(hn::Set(d, row), cell.y), hn::Mul(hn::Set(d, slice), cell.z)));
        m_cell = hn::IfThenElseZero(m_live, m_cell);  // rays that are done may stand anywhere
    }

    /// Moves rays to their next cells. @returns those that have left their bricks
    HWY_INLINE M next_cells(M which) {
        const Axes axes = exit_axes(m_exit);
        m_t = hn::IfThenElse(which, least(m_exit), m_t);
        m_place = stepped(m_place, axes, which, m_step);
        const V along =
            hn::IfThenElse(axes.x, m_stride.x, hn::IfThenElse(axes.y, m_stride.y, m_stride.z));
        const M left = hn::And(which, hn::Ge(m_t, m_brick_end));
        // Those that left may stand outside of the grid: their cells are not read any more.
        m_cell = hn::Add(m_cell, hn::IfThenElseZero(hn::AndNot(left, which), along));
        m_exit = meets(m_place);
        return left;
    }

    /// Through the cells of the bricks in which the rays are, then into the next bricks.
    HWY_INLINE void walk() {
        const D d;
        enter_bricks();
        M walking = m_live;
        while (!hn::AllFalse(d, walking)) {
            CellPairs<T> cells(m_scene, m_cell);
            M waiting = hn::Or(cells.mixed, hn::Xor(cells.above, m_above));
            M moving = hn::AndNot(waiting, walking);
            while (!hn::AllFalse(d, moving)) {
                walking = hn::AndNot(next_cells(moving), walking);
                cells = CellPairs<T>(m_scene, m_cell);
                waiting = hn::Or(cells.mixed, hn::Xor(cells.above, m_above));
                moving = hn::AndNot(waiting, walking);
            }
            if (hn::AllFalse(d, walking)) break;
            in_cells(walking, cells);
            walking = hn::And(walking, m_live);
            walking = hn::AndNot(next_cells(walking), walking);
        }
        m_live = hn::And(m_live, hn::Lt(m_t, m_end));
        m_brick = stepped(m_brick, exit_axes(m_brick_exit), m_live, m_step);
    }

    /// Looks for crossings in the cells where rays wait.
    HWY_INLINE void in_cells(M which, const CellPairs<T>& cells) {
        const D d;
        enter_uniform(hn::AndNot(cells.mixed, which), cells.above);
        const M mixed = hn::And(which, cells.mixed);
        if (hn::AllFalse(d, mixed)) return;
        const V end = hn::Min(least(m_exit), m_end);
        const V3 corner{hn::Sub(m_place.x, m_high.x), hn::Sub(m_place.y, m_high.y),
                        hn::Sub(m_place.z, m_high.z)};
        const auto local = [&](V t) HWY_ATTR {
            const V3 p = at(t);
            return clamped({hn::Sub(p.x, corner.x), hn::Sub(p.y, corner.y), hn::Sub(p.z, corner.z)},
                           all(0, 0, 0), all(1, 1, 1));
        };
        const CubicLanes cubic =
            cubic_between(cells.corners().v, m_scene.iso, local(m_t), local(end));
        const Turn turn = first_turn(cubic, m_scene.rising, mixed, m_above);
        m_above = hn::Or(hn::And(mixed, turn.above), hn::AndNot(mixed, m_above));
        const V t = hn::Add(m_t, hn::Mul(turn.s, hn::Sub(end, m_t)));
        m_hit = hn::IfThenElse(turn.found, t, m_hit);
        m_live = hn::AndNot(turn.found, m_live);
    }

    static constexpr double kInfinity = std::numeric_limits<double>::infinity();

    const PacketScene<T>& m_scene;
    V3 m_direction;               // voxels per length of the direction
    V3 m_flat_origin, m_inverse;  // for meets()
    V3 m_step, m_high, m_stride;  // ±1; 1 where forwards; of the cell's number per step
    V m_t, m_end, m_hit;
    M m_live, m_above;
    V3 m_brick;
    V3 m_brick_exit;
    V m_brick_end;
    V3 m_place, m_exit;  // the planes through which the ray leaves its cell, and when
    V m_cell;            // number of the cell's first voxel
};

template <class T>
HWY_INLINE void cast_all(const PacketScene<T>& scene, std::span<const Vec3d> directions,
                         double* distances) {
    const D d;
    const std::size_t lanes = hn::Lanes(d), count = directions.size();
    const auto cast = [&](const Vec3d* from) HWY_ATTR {
        V3 w;
        hn::LoadInterleaved3(d, &from->x, w.x, w.y, w.z);
        return Packet<T>(scene, w).first_hit();
    };
    std::size_t n = 0;
    for (; n + lanes <= count; n += lanes) hn::StoreU(cast(&directions[n]), d, distances + n);
    if (n == count) return;
    Vec3d rest[kLanes];
    HWY_ALIGN double found[kLanes];
    for (std::size_t i = 0; i < lanes; ++i) rest[i] = directions[std::min(n + i, count - 1)];
    hn::Store(cast(rest), d, found);
    std::copy_n(found, count - n, distances + n);
}

void cast_16_bits(const PacketScene<std::int16_t>& scene, std::span<const Vec3d> directions,
                  double* distances) {
    cast_all(scene, directions, distances);
}
void cast_floats(const PacketScene<float>& scene, std::span<const Vec3d> directions,
                 double* distances) {
    cast_all(scene, directions, distances);
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

void cast_packets(const PacketScene<std::int16_t>& scene, std::span<const Vec3d> directions,
                  double* distances) {
    HWY_DYNAMIC_DISPATCH(cast_16_bits)(scene, directions, distances);
}
void cast_packets(const PacketScene<float>& scene, std::span<const Vec3d> directions,
                  double* distances) {
    HWY_DYNAMIC_DISPATCH(cast_floats)(scene, directions, distances);
}

}  // namespace pliant::render
#endif
