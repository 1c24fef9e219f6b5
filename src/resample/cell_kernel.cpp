// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/cell_kernel.h"

#include <array>

// Vectors without a size at compile time can't be kept in structs.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "resample/cell_kernel.cpp"  // this file, compiled again for each target
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PLIANT_CELL_KERNEL_ONCE
#define PLIANT_CELL_KERNEL_ONCE
namespace pliant {

/// Voxels that one cell may hold; one with more is slow.
inline constexpr int kMaxHits = 4;
/// Voxels along one axis of a cell's bounding box; likewise.
inline constexpr int kMaxAlong = 4;

/// A group's voxels: what each lane found, first to last.
struct CellHits {
    alignas(64) std::int32_t voxel[kMaxHits][kCellGroup];  ///< index, from the block's origin on
    alignas(64) std::int32_t whole[kMaxHits][kCellGroup];  ///< value, rounded: of 16-bit targets
    alignas(64) float value[kMaxHits][kCellGroup];         ///< of others
    alignas(64) float back[3][kMaxHits][kCellGroup];  ///< φ⁻¹(p) − p [voxels], if it is wanted
    unsigned found[kMaxHits];                         ///< bit: lane
};

/// What is the same for all cells of a block.
struct BlockTarget {
    Vec3f low, high;          ///< first and last voxel of the target's box, from the origin on
    bool is_inside;           ///< all that the block reaches lies in the box
    std::int32_t row, slice;  ///< voxels from one row, one layer, to the next
    Vec3f shift;              ///< of the origin
    float high_slack;
    bool is_16_bit, with_inverse;
};

}  // namespace pliant
#endif

HWY_BEFORE_NAMESPACE();
namespace pliant {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, kCellGroup>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

// All in units of s, in which a cell is two wide, but kBox [voxels].
constexpr float kSettled = 1e-5f;    ///< last change of s
constexpr float kLowSlack = 8e-5f;   ///< how far s may be beyond −1 …
constexpr float kHighSlack = 2e-5f;  ///< … and how far short of +1 it must stay if half-open:
                                     ///< larger than all rounding, and than kLowSlack smaller
constexpr float kAffine = 1e-6f;     ///< G below it is none
/// Largest rate of contraction; the error is then below 3·kSettled.
constexpr float kSteepest = 0.75f;
constexpr float kFlat = 0.00625f;  ///< det J: a twentieth of a voxel
constexpr int kMaxSteps = 40;      ///< 0.75⁴⁰ is below kSettled

struct Vec {
    V x, y, z;
};

HWY_INLINE V dot(const Vec& a, const Vec& b) {
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vec cross(const Vec& a, const Vec& b) {
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
            hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec scaled(V s, const Vec& a) {
    return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
HWY_INLINE Vec sum(const Vec& a, const Vec& b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE V sum_of_sizes(V a, V b, V c, V d) {
    return hn::Add(hn::Add(hn::Abs(a), hn::Abs(b)), hn::Add(hn::Abs(c), hn::Abs(d)));
}
HWY_INLINE V largest(const Vec& a) {
    return hn::Max(hn::Max(a.x, a.y), a.z);
}

/// One component of φ by powers of s.
struct Component {
    V c, x, y, z, xy, xz, yz, xyz;
};

/// @param u  at the lowest corner of the first lane's cell
HWY_INLINE Component component_of(const float* HWY_RESTRICT u, std::size_t row, int axis) {
    const D d;
    const std::size_t slice = row * row;
    const V a0 = hn::LoadU(d, u), a1 = hn::LoadU(d, u + 1);
    const V a2 = hn::LoadU(d, u + row), a3 = hn::LoadU(d, u + row + 1);
    const V a4 = hn::LoadU(d, u + slice), a5 = hn::LoadU(d, u + slice + 1);
    const V a6 = hn::LoadU(d, u + slice + row), a7 = hn::LoadU(d, u + slice + row + 1);
    const V s01 = hn::Add(a0, a1), s23 = hn::Add(a2, a3), s45 = hn::Add(a4, a5),
            s67 = hn::Add(a6, a7);
    const V d01 = hn::Sub(a1, a0), d23 = hn::Sub(a3, a2), d45 = hn::Sub(a5, a4),
            d67 = hn::Sub(a7, a6);
    const V ss0 = hn::Add(s01, s23), ss1 = hn::Add(s45, s67);
    const V sd0 = hn::Sub(s23, s01), sd1 = hn::Sub(s67, s45);
    const V ds0 = hn::Add(d01, d23), ds1 = hn::Add(d45, d67);
    const V dd0 = hn::Sub(d23, d01), dd1 = hn::Sub(d67, d45);
    const V eighth = hn::Set(d, 0.125f), half = hn::Set(d, 0.5f);
    Component k{hn::Mul(eighth, hn::Add(ss0, ss1)), hn::Mul(eighth, hn::Add(ds0, ds1)),
                hn::Mul(eighth, hn::Add(sd0, sd1)), hn::Mul(eighth, hn::Sub(ss1, ss0)),
                hn::Mul(eighth, hn::Add(dd0, dd1)), hn::Mul(eighth, hn::Sub(ds1, ds0)),
                hn::Mul(eighth, hn::Sub(sd1, sd0)), hn::Mul(eighth, hn::Sub(dd1, dd0))};
    // The rest place of the cell: the cube 0…1.
    k.c = hn::Add(k.c, half);
    if (axis == 0) k.x = hn::Add(k.x, half);
    if (axis == 1) k.y = hn::Add(k.y, half);
    if (axis == 2) k.z = hn::Add(k.z, half);
    return k;
}

/// φ of a vector of cells, made ready for inversion.
struct Cells {
    Vec jx, jy, jz;  ///< columns of J⁻¹
    Vec gxy, gxz, gyz, gxyz;
    Vec delta;        ///< bound of |G|
    Vec begin, last;  ///< grid points in the bounding box, relative to the lowest corner
    Vec s;            ///< s₁ of `begin`
    M fast;           ///< can be inverted here
};

HWY_INLINE V bound(const Component& k) {
    return hn::Add(sum_of_sizes(k.x, k.y, k.z, k.xyz),
                   hn::Add(hn::Add(hn::Abs(k.xy), hn::Abs(k.xz)), hn::Abs(k.yz)));
}

/// Grid points between the cell's lowest and highest place along an axis. A face at rest lies on
/// grid points; for it the high side must be left out here already.
HWY_INLINE void find_range(const Component& k, V along, float high_slack, V& begin, V& last) {
    const D d;
    const V extent = bound(k);
    const V widened = hn::Mul(extent, hn::Set(d, 1 + kLowSlack));
    begin = hn::Ceil(hn::Sub(k.c, widened));
    const V inward = hn::Mul(along, hn::Set(d, kLowSlack + high_slack));
    last = hn::Floor(hn::Sub(hn::Add(k.c, widened), inward));
}

HWY_INLINE Cells prepare(const Component& a, const Component& b, const Component& c,
                         float high_slack) {
    const D d;
    Cells cells;
    const Vec x{a.x, b.x, c.x}, y{a.y, b.y, c.y}, z{a.z, b.z, c.z};
    const Vec r0 = cross(y, z), r1 = cross(z, x), r2 = cross(x, y);
    const V det = dot(x, r0);
    cells.fast = hn::Gt(det, hn::Set(d, kFlat));
    const V inverse = hn::Div(hn::Set(d, 1), hn::IfThenElse(cells.fast, det, hn::Set(d, 1)));
    cells.jx = scaled(inverse, {r0.x, r1.x, r2.x});
    cells.jy = scaled(inverse, {r0.y, r1.y, r2.y});
    cells.jz = scaled(inverse, {r0.z, r1.z, r2.z});
    const auto times = [&cells](V p, V q, V r) HWY_ATTR {
        return sum(sum(scaled(p, cells.jx), scaled(q, cells.jy)), scaled(r, cells.jz));
    };
    cells.gxy = times(a.xy, b.xy, c.xy);
    cells.gxz = times(a.xz, b.xz, c.xz);
    cells.gyz = times(a.yz, b.yz, c.yz);
    cells.gxyz = times(a.xyz, b.xyz, c.xyz);
    cells.delta = {sum_of_sizes(cells.gxy.x, cells.gxz.x, cells.gyz.x, cells.gxyz.x),
                   sum_of_sizes(cells.gxy.y, cells.gxz.y, cells.gyz.y, cells.gxyz.y),
                   sum_of_sizes(cells.gxy.z, cells.gxz.z, cells.gyz.z, cells.gxyz.z)};
    // Row sums of |∂G/∂s| are at most 2·(|g_xy| + |g_xz| + |g_yz|) + 3·|g_xyz|.
    const Vec rate{hn::Add(hn::Add(cells.delta.x, cells.delta.x), hn::Abs(cells.gxyz.x)),
                   hn::Add(hn::Add(cells.delta.y, cells.delta.y), hn::Abs(cells.gxyz.y)),
                   hn::Add(hn::Add(cells.delta.z, cells.delta.z), hn::Abs(cells.gxyz.z))};
    cells.fast = hn::And(cells.fast, hn::Lt(largest(rate), hn::Set(d, kSteepest)));
    find_range(a, a.x, high_slack, cells.begin.x, cells.last.x);
    find_range(b, b.y, high_slack, cells.begin.y, cells.last.y);
    find_range(c, c.z, high_slack, cells.begin.z, cells.last.z);
    cells.s = times(hn::Sub(cells.begin.x, a.c), hn::Sub(cells.begin.y, b.c),
                    hn::Sub(cells.begin.z, c.c));
    return cells;
}

/// The voxels that each lane may hold, up to kMaxHits: numbers i + 4·j + 16·k of steps from begin.
struct Pending {
    V code[kMaxHits];
    M have[kMaxHits];
    M too_many;
};

HWY_INLINE void add_pending(M found, V code, Pending& pending) {
    for (int h = 0; h < kMaxHits; ++h) {
        const M here = hn::AndNot(pending.have[h], found);
        pending.code[h] = hn::IfThenElse(here, code, pending.code[h]);
        found = hn::And(found, pending.have[h]);
        pending.have[h] = hn::Or(pending.have[h], here);
        if (hn::AllFalse(D(), found)) return;
    }
    pending.too_many = hn::Or(pending.too_many, found);
}

HWY_INLINE Pending find_candidates(const Cells& cells, M use, float high_slack) {
    const D d;
    // −1 − kLowSlack − δ ≤ s ≤ 1 − high_slack + δ
    const V middle = hn::Set(d, 0.5f * (kLowSlack + high_slack));
    const V half = hn::Set(d, 1 + 0.5f * (kLowSlack - high_slack));
    const Vec width{hn::Add(half, cells.delta.x), hn::Add(half, cells.delta.y),
                    hn::Add(half, cells.delta.z)};
    Pending pending;
    for (int h = 0; h < kMaxHits; ++h) {
        pending.code[h] = hn::Zero(d);
        pending.have[h] = hn::MaskFromVec(hn::Zero(d));
    }
    const Vec count{hn::Sub(cells.last.x, cells.begin.x), hn::Sub(cells.last.y, cells.begin.y),
                    hn::Sub(cells.last.z, cells.begin.z)};
    pending.too_many = hn::And(use, hn::Gt(largest(count), hn::Set(d, float(kMaxAlong) - 1)));
    Vec sk{hn::Add(cells.s.x, middle), hn::Add(cells.s.y, middle), hn::Add(cells.s.z, middle)};
    for (int k = 0; k < kMaxAlong; ++k, sk = sum(sk, cells.jz)) {
        const M in_z = hn::And(use, hn::Ge(count.z, hn::Set(d, float(k))));
        if (hn::AllFalse(d, in_z)) break;
        Vec sj = sk;
        for (int j = 0; j < kMaxAlong; ++j, sj = sum(sj, cells.jy)) {
            const M in_y = hn::And(in_z, hn::Ge(count.y, hn::Set(d, float(j))));
            if (hn::AllFalse(d, in_y)) break;
            Vec s = sj;
            for (int i = 0; i < kMaxAlong; ++i, s = sum(s, cells.jx)) {
                const M in_x = hn::And(in_y, hn::Ge(count.x, hn::Set(d, float(i))));
                if (hn::AllFalse(d, in_x)) break;
                const Vec beyond{hn::Sub(hn::Abs(s.x), width.x), hn::Sub(hn::Abs(s.y), width.y),
                                 hn::Sub(hn::Abs(s.z), width.z)};
                const M found = hn::And(in_x, hn::Le(largest(beyond), hn::Zero(d)));
                if (!hn::AllFalse(d, found))
                    add_pending(found, hn::Set(d, float(i + 4 * j + 16 * k)), pending);
            }
        }
    }
    return pending;
}

/// Solves s + G(s) = s₁. @param active  lanes to look at @returns lanes that did not settle
HWY_INLINE M settle(const Cells& cells, const Vec& s1, M active, Vec& s) {
    const D d;
    s = s1;
    M moving = hn::And(active, hn::Gt(largest(cells.delta), hn::Set(d, kAffine)));
    for (int step = 0; step < kMaxSteps && !hn::AllFalse(d, moving); ++step) {
        const V xy = hn::Mul(s.x, s.y), xz = hn::Mul(s.x, s.z), yz = hn::Mul(s.y, s.z);
        const V xyz = hn::Mul(xy, s.z);
        const Vec g = sum(sum(scaled(xy, cells.gxy), scaled(xz, cells.gxz)),
                          sum(scaled(yz, cells.gyz), scaled(xyz, cells.gxyz)));
        const Vec next{hn::Sub(s1.x, g.x), hn::Sub(s1.y, g.y), hn::Sub(s1.z, g.z)};
        const Vec change{hn::Abs(hn::Sub(next.x, s.x)), hn::Abs(hn::Sub(next.y, s.y)),
                         hn::Abs(hn::Sub(next.z, s.z))};
        // Settled lanes stay as they are, or they would depend on their neighbours.
        s = {hn::IfThenElse(moving, next.x, s.x), hn::IfThenElse(moving, next.y, s.y),
             hn::IfThenElse(moving, next.z, s.z)};
        moving = hn::And(moving, hn::Gt(largest(change), hn::Set(d, kSettled)));
    }
    return moving;
}

HWY_INLINE V lerp(V a, V b, V t) {
    return hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
}

/// Trilinear in the original values at the corners. @param t  0…1
HWY_INLINE V value_at(const float* HWY_RESTRICT v, std::size_t row, const Vec& t) {
    const D d;
    const std::size_t slice = row * row;
    const V x0 = lerp(hn::LoadU(d, v), hn::LoadU(d, v + 1), t.x);
    const V x1 = lerp(hn::LoadU(d, v + row), hn::LoadU(d, v + row + 1), t.x);
    const V x2 = lerp(hn::LoadU(d, v + slice), hn::LoadU(d, v + slice + 1), t.x);
    const V x3 = lerp(hn::LoadU(d, v + slice + row), hn::LoadU(d, v + slice + row + 1), t.x);
    return lerp(lerp(x0, x1, t.y), lerp(x2, x3, t.y), t.z);
}

HWY_INLINE V unit_interval(V s) {
    const D d;
    const V t = hn::Add(hn::Set(d, 0.5f), hn::Mul(hn::Set(d, 0.5f), s));
    return hn::Min(hn::Max(t, hn::Zero(d)), hn::Set(d, 1));
}

HWY_INLINE unsigned bits_of(M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(D(), mask, bytes);
    return bytes[0] | unsigned(bytes[1]) << 8;
}
HWY_INLINE M mask_of(unsigned bits) {
    const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
    return hn::LoadMaskBits(D(), bytes);
}

/// Where voxels p (relative to the block's origin) are outside of the target's box.
HWY_INLINE M outside(const Vec& p, const BlockTarget& to) {
    const D d;
    const V x = hn::Max(hn::Sub(hn::Set(d, to.low.x), p.x), hn::Sub(p.x, hn::Set(d, to.high.x)));
    const V y = hn::Max(hn::Sub(hn::Set(d, to.low.y), p.y), hn::Sub(p.y, hn::Set(d, to.high.y)));
    const V z = hn::Max(hn::Sub(hn::Set(d, to.low.z), p.z), hn::Sub(p.z, hn::Set(d, to.high.z)));
    return hn::Gt(largest({x, y, z}), hn::Zero(d));
}

/// What the cells of one vector hold goes into the lanes from `lane` on.
/// @returns cells that are slow
HWY_INLINE unsigned look_into_cells(const BlockNodes& block, std::size_t n, unsigned use_bits,
                                    const BlockTarget& to, int lane, CellHits& hits) {
    const D d;
    const DI di;
    const auto row = std::size_t(block.row());
    const Cells cells =
        prepare(component_of(block.u(0) + n, row, 0), component_of(block.u(1) + n, row, 1),
                component_of(block.u(2) + n, row, 2), to.high_slack);
    const M used = mask_of(use_bits);
    const M use = hn::And(used, cells.fast);
    const Pending pending = find_candidates(cells, use, to.high_slack);
    M slow = hn::Or(hn::AndNot(cells.fast, used), pending.too_many);
    const V low = hn::Set(d, -1 - kLowSlack), high = hn::Set(d, 1 - to.high_slack);
    for (int h = 0; h < kMaxHits; ++h) {
        if (hn::AllFalse(d, pending.have[h])) break;
        const auto code = hn::ConvertTo(di, pending.code[h]);
        const auto three = hn::Set(di, 3);
        const Vec steps{hn::ConvertTo(d, hn::And(code, three)),
                        hn::ConvertTo(d, hn::And(hn::ShiftRight<2>(code), three)),
                        hn::ConvertTo(d, hn::ShiftRight<4>(code))};
        const Vec s1 = sum(cells.s, sum(sum(scaled(steps.x, cells.jx), scaled(steps.y, cells.jy)),
                                        scaled(steps.z, cells.jz)));
        Vec s;
        const M unsettled = settle(cells, s1, pending.have[h], s);
        slow = hn::Or(slow, unsettled);
        const V least = hn::Min(hn::Min(s.x, s.y), s.z);
        M found = hn::And(hn::AndNot(unsettled, pending.have[h]),
                          hn::And(hn::Ge(least, low), hn::Le(largest(s), high)));
        const Vec step = sum(cells.begin, steps);
        const Vec p{hn::Add(step.x, hn::LoadU(d, block.place(0) + n)),
                    hn::Add(step.y, hn::LoadU(d, block.place(1) + n)),
                    hn::Add(step.z, hn::LoadU(d, block.place(2) + n))};
        if (!to.is_inside) found = hn::AndNot(outside(p, to), found);
        hits.found[h] |= bits_of(found) << lane;
        const auto voxel = hn::Add(hn::ConvertTo(di, p.x),
                                   hn::Add(hn::Mul(hn::ConvertTo(di, p.y), hn::Set(di, to.row)),
                                           hn::Mul(hn::ConvertTo(di, p.z), hn::Set(di, to.slice))));
        hn::Store(voxel, di, &hits.voxel[h][lane]);
        const Vec t{unit_interval(s.x), unit_interval(s.y), unit_interval(s.z)};
        const V value = value_at(block.values() + n, row, t);
        if (to.is_16_bit)
            hn::Store(hn::NearestInt(value), di, &hits.whole[h][lane]);
        else
            hn::Store(value, d, &hits.value[h][lane]);
        if (!to.with_inverse) continue;
        hn::Store(hn::Sub(t.x, step.x), d, &hits.back[0][h][lane]);
        hn::Store(hn::Sub(t.y, step.y), d, &hits.back[1][h][lane]);
        hn::Store(hn::Sub(t.z, step.z), d, &hits.back[2][h][lane]);
    }
    return bits_of(slow);
}

/// Stores what a group found where the target is open. @param origin  voxel index of the block's
void write_hits(const CellHits& hits, std::ptrdiff_t origin, const BlockTarget& block,
                const CellTarget& to) {
    for (int h = 0; h < kMaxHits; ++h)
        for (unsigned left = hits.found[h]; left; left &= left - 1) {
            const auto lane = unsigned(__builtin_ctz(left));
            const std::ptrdiff_t voxel = origin + hits.voxel[h][lane];
            const auto bit = std::size_t(voxel - to.first_voxel);
            const RowBits word = to.open[bit / 64], flag = RowBits(1) << (bit % 64);
            if (!(word & flag)) continue;
            to.open[bit / 64] = word & ~flag;
            if (block.is_16_bit)
                to.voxels16[voxel] = std::int16_t(hits.whole[h][lane]);
            else
                to.voxels32[voxel] = hits.value[h][lane];
            if (block.with_inverse)
                store_inverse(
                    to, voxel,
                    {hits.back[0][h][lane] - block.shift.x, hits.back[1][h][lane] - block.shift.y,
                     hits.back[2][h][lane] - block.shift.z});
        }
}

BlockTarget target_of(const BlockNodes& block, const CellTarget& target, CellFaces faces) {
    BlockTarget to;
    to.is_inside = true;
    for (int a = 0; a < 3; ++a) {
        to.low[a] = float(target.box.begin[a] - block.origin()[a]);
        to.high[a] = float(target.box.end[a] - 1 - block.origin()[a]);
        to.shift[a] = float(block.origin()[a] - block.first_element()[a]);
        to.is_inside &= block.reach().low[a] >= target.box.begin[a] + 1 &&
                        block.reach().high[a] <= target.box.end[a] - 2;
    }
    to.row = target.grid_size.x;
    to.slice = target.grid_size.x * target.grid_size.y;
    to.high_slack = faces == CellFaces::HalfOpen ? kHighSlack : -kLowSlack;
    to.is_16_bit = target.voxels16 != nullptr;
    to.with_inverse = target.inverse_mm != nullptr;
    return to;
}

void write_block(const BlockNodes& block, const CellTarget& target, CellFaces faces,
                 std::vector<int>& slow) {
    constexpr auto kLanes = int(hn::MaxLanes(D()));
    const BlockTarget to = target_of(block, target, faces);
    const Vec3i first = block.origin();
    const std::ptrdiff_t origin =
        first.x + std::ptrdiff_t(to.row) * first.y + std::ptrdiff_t(to.slice) * first.z;
    CellHits hits;
    const std::span<const RowBits> use = block.use();
    for (std::size_t w = 0; w < use.size(); ++w) {
        if (!use[w]) continue;
        for (int part = 0; part < 64; part += kCellGroup) {
            const auto group = unsigned(use[w] >> part & 0xffff);
            if (!group) continue;
            for (unsigned& found : hits.found) found = 0;
            unsigned slow_lanes = 0;
            for (int lane = 0; lane < kCellGroup; lane += kLanes) {
                const unsigned lanes = group >> lane & ((1u << kLanes) - 1);
                if (!lanes) continue;
                slow_lanes |=
                    look_into_cells(block, 64 * w + unsigned(part + lane), lanes, to, lane, hits)
                    << lane;
            }
            write_hits(hits, origin, to, target);
            for (; slow_lanes; slow_lanes &= slow_lanes - 1)
                slow.push_back(int(64 * w) + part + __builtin_ctz(slow_lanes));
        }
    }
}

/// Fixed point to voxels, for the nodes of a block. @param from  a component in its eight bricks
void convert_nodes(const std::array<const Fixed*, 8>& from, int size, Fixed base, float scale,
                   float shift, float* HWY_RESTRICT to) {
    const hn::CappedTag<float, 8> d;
    const hn::RebindToSigned<decltype(d)> di;
    constexpr auto kLanes = int(hn::MaxLanes(d));
    const auto voxels = hn::Set(d, scale), more = hn::Set(d, shift);
    const auto middle = hn::Set(di, base);
    for (int z = 0; z <= size; ++z)
        for (int y = 0; y <= size; ++y, to += size + 1) {
            const bool hy = y == size, hz = z == size;
            const auto corner = std::size_t(2 * hy + 4 * hz);
            const int at = size * ((hy ? 0 : y) + size * (hz ? 0 : z));
            const Fixed* HWY_RESTRICT row = from[corner] + at;
            int x = 0;
            for (; x + kLanes <= size; x += kLanes) {
                const auto u = hn::ConvertTo(d, hn::Sub(hn::LoadU(di, row + x), middle));
                hn::StoreU(hn::Add(hn::Mul(u, voxels), more), d, to + x);
            }
            for (; x < size; ++x) to[x] = float(row[x] - base) * scale + shift;
            to[size] = float(from[corner + 1][at] - base) * scale + shift;
        }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace pliant
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
namespace {
HWY_EXPORT(write_block);
HWY_EXPORT(convert_nodes);
}  // namespace

void write_cells(const BlockNodes& block, const CellTarget& target, CellFaces faces,
                 std::vector<int>& slow) {
    HWY_DYNAMIC_DISPATCH(write_block)(block, target, faces, slow);
}

void convert_block_nodes(const std::array<const Fixed*, 8>& from, int size, Fixed base, float scale,
                         float shift, float* to) {
    HWY_DYNAMIC_DISPATCH(convert_nodes)(from, size, base, scale, shift, to);
}

}  // namespace pliant
#endif
