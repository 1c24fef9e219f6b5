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
    alignas(64) std::int32_t x[kMaxHits][kCellGroup];  ///< relative to the block's origin
    alignas(64) std::int32_t y[kMaxHits][kCellGroup];
    alignas(64) std::int32_t z[kMaxHits][kCellGroup];
    alignas(64) std::int32_t whole[kMaxHits][kCellGroup];  ///< value, rounded
    alignas(64) float value[kMaxHits][kCellGroup];
    alignas(64) float back[3][kMaxHits][kCellGroup];  ///< φ⁻¹(p) − p [voxels]
    unsigned found[kMaxHits];                         ///< bit: lane
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

HWY_INLINE V inside(V s, V low, V high) {
    return hn::VecFromMask(D(), hn::And(hn::Ge(s, low), hn::Le(s, high)));
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
    const V low = hn::Set(d, -1 - kLowSlack), high = hn::Set(d, 1 - high_slack);
    const Vec least{hn::Sub(low, cells.delta.x), hn::Sub(low, cells.delta.y),
                    hn::Sub(low, cells.delta.z)};
    const Vec most{hn::Add(high, cells.delta.x), hn::Add(high, cells.delta.y),
                   hn::Add(high, cells.delta.z)};
    Pending pending;
    for (int h = 0; h < kMaxHits; ++h) {
        pending.code[h] = hn::Zero(d);
        pending.have[h] = hn::MaskFromVec(hn::Zero(d));
    }
    const Vec count{hn::Sub(cells.last.x, cells.begin.x), hn::Sub(cells.last.y, cells.begin.y),
                    hn::Sub(cells.last.z, cells.begin.z)};
    pending.too_many = hn::And(use, hn::Gt(largest(count), hn::Set(d, float(kMaxAlong) - 1)));
    Vec sk = cells.s;
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
                const V hit =
                    hn::And(hn::And(inside(s.x, least.x, most.x), inside(s.y, least.y, most.y)),
                            inside(s.z, least.z, most.z));
                const M found = hn::And(in_x, hn::MaskFromVec(hit));
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

/// What the cells of one vector hold goes into the lanes from `lane` on.
/// @returns cells that are slow
HWY_INLINE unsigned look_into_cells(const BlockNodes& block, std::size_t n, unsigned use_bits,
                                    float high_slack, int lane, CellHits& hits) {
    const D d;
    const DI di;
    const auto row = std::size_t(block.row());
    const Cells cells =
        prepare(component_of(block.u(0) + n, row, 0), component_of(block.u(1) + n, row, 1),
                component_of(block.u(2) + n, row, 2), high_slack);
    const M used = mask_of(use_bits);
    const M use = hn::And(used, cells.fast);
    const Pending pending = find_candidates(cells, use, high_slack);
    M slow = hn::Or(hn::AndNot(cells.fast, used), pending.too_many);
    const V low = hn::Set(d, -1 - kLowSlack), high = hn::Set(d, 1 - high_slack);
    const float* local[3] = {block.place(0) + n, block.place(1) + n, block.place(2) + n};
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
        const V in = hn::And(hn::And(inside(s.x, low, high), inside(s.y, low, high)),
                             inside(s.z, low, high));
        const M found = hn::AndNot(unsettled, hn::And(pending.have[h], hn::MaskFromVec(in)));
        const Vec t{unit_interval(s.x), unit_interval(s.y), unit_interval(s.z)};
        const V value = value_at(block.values() + n, row, t);
        hits.found[h] |= bits_of(found) << lane;
        const Vec p = sum(cells.begin, steps);
        hn::Store(hn::ConvertTo(di, hn::Add(p.x, hn::LoadU(d, local[0]))), di, &hits.x[h][lane]);
        hn::Store(hn::ConvertTo(di, hn::Add(p.y, hn::LoadU(d, local[1]))), di, &hits.y[h][lane]);
        hn::Store(hn::ConvertTo(di, hn::Add(p.z, hn::LoadU(d, local[2]))), di, &hits.z[h][lane]);
        hn::Store(value, d, &hits.value[h][lane]);
        hn::Store(hn::NearestInt(value), di, &hits.whole[h][lane]);
        hn::Store(hn::Sub(t.x, p.x), d, &hits.back[0][h][lane]);
        hn::Store(hn::Sub(t.y, p.y), d, &hits.back[1][h][lane]);
        hn::Store(hn::Sub(t.z, p.z), d, &hits.back[2][h][lane]);
    }
    return bits_of(slow);
}

/// Stores what a group found where the target is open.
void write_hits(const CellHits& hits, Vec3i origin, Vec3f shift, const CellTarget& to) {
    const std::ptrdiff_t nx = to.grid_size.x, slice = nx * to.grid_size.y;
    for (int h = 0; h < kMaxHits && hits.found[h]; ++h)
        for (unsigned left = hits.found[h]; left; left &= left - 1) {
            const auto lane = unsigned(__builtin_ctz(left));
            const int x = origin.x + hits.x[h][lane], y = origin.y + hits.y[h][lane],
                      z = origin.z + hits.z[h][lane];
            if (unsigned(x - to.box.begin.x) >= unsigned(to.box.end.x - to.box.begin.x) ||
                unsigned(y - to.box.begin.y) >= unsigned(to.box.end.y - to.box.begin.y) ||
                unsigned(z - to.box.begin.z) >= unsigned(to.box.end.z - to.box.begin.z))
                continue;
            const std::ptrdiff_t in_slice = x + nx * y;
            const auto bit = std::size_t(in_slice + to.open_slice * z);
            const RowBits word = to.open[bit / 64], flag = RowBits(1) << (bit % 64);
            if (!(word & flag)) continue;
            to.open[bit / 64] = word & ~flag;
            if (to.voxels16)
                to.voxels16[in_slice + slice * z] = std::int16_t(hits.whole[h][lane]);
            else
                to.voxels32[in_slice + slice * z] = hits.value[h][lane];
            if (!to.inverse_mm) continue;
            const Vec3i p = Vec3i{x, y, z} - to.inverse_box.begin;
            const Vec3i n = to.inverse_box.end - to.inverse_box.begin;
            const Vec3f back{hits.back[0][h][lane] - shift.x, hits.back[1][h][lane] - shift.y,
                             hits.back[2][h][lane] - shift.z};
            to.inverse_mm[p.x + std::ptrdiff_t(n.x) * (p.y + std::ptrdiff_t(n.y) * p.z)] =
                back.x * to.world_from_voxels[0] + back.y * to.world_from_voxels[1] +
                back.z * to.world_from_voxels[2];
        }
}

void write_block(const BlockNodes& block, const CellTarget& target, CellFaces faces,
                 std::vector<int>& slow) {
    constexpr auto kLanes = int(hn::MaxLanes(D()));
    const float high_slack = faces == CellFaces::HalfOpen ? kHighSlack : -kLowSlack;
    const Vec3i whole = block.origin() - block.first_element();
    const Vec3f shift{float(whole.x), float(whole.y), float(whole.z)};
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
                slow_lanes |= look_into_cells(block, 64 * w + unsigned(part + lane), lanes,
                                              high_slack, lane, hits)
                              << lane;
            }
            write_hits(hits, block.origin(), shift, target);
            for (; slow_lanes; slow_lanes &= slow_lanes - 1)
                slow.push_back(int(64 * w) + part + __builtin_ctz(slow_lanes));
        }
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
}  // namespace

void write_cells(const BlockNodes& block, const CellTarget& target, CellFaces faces,
                 std::vector<int>& slow) {
    HWY_DYNAMIC_DISPATCH(write_block)(block, target, faces, slow);
}

}  // namespace pliant
#endif
