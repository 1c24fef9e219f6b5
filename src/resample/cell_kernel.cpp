// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/cell_kernel.h"

#include <algorithm>
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

/// Voxels along one axis of a cell's bounding box; a cell with more is slow.
inline constexpr int kMaxAlong = 4;
inline constexpr int kMaxCandidates = kMaxAlong * kMaxAlong * kMaxAlong;

/// Steps of s ← s₁ − G(s) after which a cell that has not settled is slow.
inline constexpr int kMaxSteps = 40;

/// Steps from which on is watched whether they still move s; fewer are simply taken.
inline constexpr std::size_t kWatched = 4;

/// Cells that need no more are flat; they wait apart from the others, so that they needn't take the
/// others' steps with them.
inline constexpr std::size_t kFlatSteps = 2;

/// What is kept of a cell while its voxels are solved: the rows of CellRows.
enum Row {
    kRowJ = 0,       ///< J⁻¹, by columns
    kRowC = 9,       ///< coefficients of C: xy, xz, yz, xyz, each with three components
    kRowS = 21,      ///< s₁ of the first grid point in the bounding box
    kRowBend = 24,   ///< bound of |G|
    kRowValue = 25,  ///< original values at the corners
    kRowBegin = 33,  ///< that grid point, from the cell's lowest corner on
    kRowPlace = 36,  ///< and from the block's origin on
    kRowWidth = 39,  ///< bound of |G| by component
    kRowCount = 42,
};

/// Two groups of cells, so that voxels which are left over from one group can be solved together
/// with those of the next, in full vectors.
struct CellRows {
    alignas(64) float row[kRowCount][2 * kCellGroup];
    alignas(64) std::int32_t voxel[2 * kCellGroup];  ///< index of kRowPlace
    int first_cell[2];
};

/// Voxels to be solved, first to last: number of the cell in CellRows, and 32 times the candidate:
/// i + 4·j + 16·k steps from the first one.
struct Waiting {
    alignas(64) std::int32_t item[kCellGroup * (kMaxCandidates + 3)];
    int count = 0;
};

/// What was found out of a vector of voxels.
struct Solved {
    alignas(64) std::int32_t voxel[kCellGroup];  ///< index, from the block's origin on
    alignas(64) std::int32_t whole[kCellGroup];  ///< value, rounded: of 16-bit targets
    alignas(64) float value[kCellGroup];         ///< of others
    alignas(64) float back[3][kCellGroup];       ///< φ⁻¹(p) − p [voxels], if it is wanted
};

/// Candidates of a group, from the affine part alone.
struct Candidates {
    unsigned found[kMaxCandidates];  ///< bit: lane
    int along;                       ///< 2 or 4 per axis
};

/// What is the same for all cells of a block.
struct BlockTarget {
    Vec3f low, high;          ///< first and last voxel of the target's box, from the origin on
    bool is_inside;           ///< all that the block reaches lies in the box
    std::int32_t row, slice;  ///< voxels from one row, one layer, to the next
    std::ptrdiff_t origin;    ///< index of the block's origin
    Vec3f shift;              ///< of the origin
    float high_slack;
    bool is_16_bit, with_inverse;
};

/// Largest bound of |G| [units of s] with which n steps leave an error below `settled`: the rate of
/// contraction on the way is at most 2·bend·(1 + 2·bend)².
constexpr std::array<float, kWatched> bends_by_steps(double settled) {
    std::array<float, kWatched> bends{};
    for (int n = 0; n < int(kWatched); ++n) {
        double low = 0, high = 0.19;
        for (int bisection = 0; bisection < 40; ++bisection) {
            const double bend = 0.5 * (low + high);
            double error = bend;
            for (int step = 0; step < n; ++step)
                error *= 2 * bend * (1 + 2 * bend) * (1 + 2 * bend);
            (error <= settled ? low : high) = bend;
        }
        bends[std::size_t(n)] = float(low);
    }
    return bends;
}

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

// All in units of s, in which a cell is two wide.
constexpr double kError = 5e-6;      ///< of s, after the steps that are known to suffice
constexpr float kSettled = 1e-5f;    ///< last change of s with which it is taken for settled before
constexpr float kLowSlack = 8e-5f;   ///< how far s may be beyond −1 …
constexpr float kHighSlack = 2e-5f;  ///< … and how far short of +1 it must stay if half-open:
                                     ///< larger than all rounding, and than kLowSlack smaller
constexpr float kFlat = 0.00625f;    ///< det J: a twentieth of a voxel
constexpr std::array<float, kWatched> kBends = bends_by_steps(kError);
constexpr float kMostBent = 0.375f;  ///< of cells that are not slow: three quarters are kept of a
                                     ///< change by the next step, at most

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

HWY_INLINE unsigned bits_of(M mask) {
#if HWY_TARGET <= HWY_AVX3
    return mask.raw;
#else
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(D(), mask, bytes);
    return bytes[0] | unsigned(bytes[1]) << 8;
#endif
}
HWY_INLINE M mask_of(unsigned bits) {
#if HWY_TARGET <= HWY_AVX3
    return M{__mmask16(bits)};
#else
    const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
    return hn::LoadMaskBits(D(), bytes);
#endif
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

HWY_INLINE void store(V v, int row, std::size_t lane, CellRows& rows) {
    hn::Store(v, D(), &rows.row[row][lane]);
}
HWY_INLINE void store(const Vec& v, int row, std::size_t lane, CellRows& rows) {
    store(v.x, row, lane, rows);
    store(v.y, row + 1, lane, rows);
    store(v.z, row + 2, lane, rows);
}
HWY_INLINE V load(int row, std::size_t lane, const CellRows& rows) {
    return hn::Load(D(), &rows.row[row][lane]);
}
HWY_INLINE Vec load3(int row, std::size_t lane, const CellRows& rows) {
    return {load(row, lane, rows), load(row + 1, lane, rows), load(row + 2, lane, rows)};
}

/// How far a component can be from its affine part, and half more of the highest power: the sum of
/// the sizes of ∂C's coefficients, by 2.
HWY_INLINE V bend_of(const Component& k) {
    return hn::Add(hn::Add(hn::Abs(k.xy), hn::Abs(k.xz)),
                   hn::Add(hn::Abs(k.yz), hn::Mul(hn::Set(D(), 1.5f), hn::Abs(k.xyz))));
}

/// @param row  of the first coefficient; those of one component lie three apart
HWY_INLINE void store_bent(const Component& k, int row, std::size_t lane, CellRows& rows, V& bend) {
    store(k.xy, row, lane, rows);
    store(k.xz, row + 3, lane, rows);
    store(k.yz, row + 6, lane, rows);
    store(k.xyz, row + 9, lane, rows);
    bend = bend_of(k);
}

/// Grid points between the cell's lowest and highest place along an axis. A face at rest lies on
/// grid points; for it the high side is left out here already.
HWY_INLINE void find_range(const Component& k, V bend, V along, float high_slack, V& begin,
                           V& count) {
    const D d;
    const V extent = hn::Add(hn::Add(hn::Abs(k.x), hn::Abs(k.y)), hn::Add(hn::Abs(k.z), bend));
    const V widened = hn::Mul(extent, hn::Set(d, 1 + kLowSlack));
    begin = hn::Ceil(hn::Sub(k.c, widened));
    const V inward = hn::Mul(along, hn::Set(d, kLowSlack + high_slack));
    count = hn::Sub(hn::Floor(hn::Sub(hn::Add(k.c, widened), inward)), begin);
}

/// Lanes that can be inverted here; those of them where a few steps suffice; and those with more
/// than two grid points along an axis.
struct Prepared {
    M fast, flat, wide;
};

/// φ of a vector of cells, made ready for inversion, into the lanes from `lane` on.
HWY_INLINE Prepared prepare(const BlockNodes& block, std::size_t n, const BlockTarget& to,
                            std::size_t lane, CellRows& rows) {
    const D d;
    const hn::RebindToSigned<D> di;
    const auto row = std::size_t(block.row());
    // What is only kept goes away at once: registers are few.
    Vec bend;
    const Component a = component_of(block.u(0) + n, row, 0);
    store_bent(a, kRowC, lane, rows, bend.x);
    const Component b = component_of(block.u(1) + n, row, 1);
    store_bent(b, kRowC + 1, lane, rows, bend.y);
    const Component c = component_of(block.u(2) + n, row, 2);
    store_bent(c, kRowC + 2, lane, rows, bend.z);
    const Vec x{a.x, b.x, c.x}, y{a.y, b.y, c.y}, z{a.z, b.z, c.z};
    const Vec r0 = cross(y, z), r1 = cross(z, x), r2 = cross(x, y);
    const V det = dot(x, r0);
    M fast = hn::Gt(det, hn::Set(d, kFlat));
    const V inverse = hn::Div(hn::Set(d, 1), hn::IfThenElse(fast, det, hn::Set(d, 1)));
    const Vec jx = scaled(inverse, {r0.x, r1.x, r2.x}), jy = scaled(inverse, {r0.y, r1.y, r2.y}),
              jz = scaled(inverse, {r0.z, r1.z, r2.z});
    store(jx, kRowJ, lane, rows);
    store(jy, kRowJ + 3, lane, rows);
    store(jz, kRowJ + 6, lane, rows);
    const auto size = [](const Vec& v) HWY_ATTR {
        return Vec{hn::Abs(v.x), hn::Abs(v.y), hn::Abs(v.z)};
    };
    const Vec width =
        sum(sum(scaled(bend.x, size(jx)), scaled(bend.y, size(jy))), scaled(bend.z, size(jz)));
    const V most = largest(width);
    store(width, kRowWidth, lane, rows);
    store(most, kRowBend, lane, rows);
    fast = hn::And(fast, hn::Lt(most, hn::Set(d, kMostBent)));
    Vec begin, count;
    find_range(a, bend.x, a.x, to.high_slack, begin.x, count.x);
    find_range(b, bend.y, b.y, to.high_slack, begin.y, count.y);
    find_range(c, bend.z, c.z, to.high_slack, begin.z, count.z);
    const V widest = largest(count);
    fast = hn::And(fast, hn::Lt(widest, hn::Set(d, float(kMaxAlong))));
    store(sum(sum(scaled(hn::Sub(begin.x, a.c), jx), scaled(hn::Sub(begin.y, b.c), jy)),
              scaled(hn::Sub(begin.z, c.c), jz)),
          kRowS, lane, rows);
    const Vec place{hn::Add(begin.x, hn::LoadU(d, block.place(0) + n)),
                    hn::Add(begin.y, hn::LoadU(d, block.place(1) + n)),
                    hn::Add(begin.z, hn::LoadU(d, block.place(2) + n))};
    hn::Store(hn::Add(hn::ConvertTo(di, place.x),
                      hn::Add(hn::Mul(hn::ConvertTo(di, place.y), hn::Set(di, to.row)),
                              hn::Mul(hn::ConvertTo(di, place.z), hn::Set(di, to.slice)))),
              di, &rows.voxel[lane]);
    if (!to.is_inside) store(place, kRowPlace, lane, rows);
    if (to.with_inverse) store(begin, kRowBegin, lane, rows);
    const std::size_t slice = row * row;
    const float* v = block.values() + n;
    for (int corner = 0; corner < 8; ++corner)
        store(hn::LoadU(d, v + (corner & 1) + (corner & 2 ? row : 0) + (corner & 4 ? slice : 0)),
              kRowValue + corner, lane, rows);
    return {fast, hn::Le(most, hn::Set(d, kBends[kFlatSteps])),
            hn::And(fast, hn::Ge(widest, hn::Set(d, 2)))};
}

/// Finds the grid points that may lie in the cells of a vector: |s₁| ≤ 1 + a bound of |G| + some
/// slack.
HWY_INLINE void find_candidates(const CellRows& rows, std::size_t lane, M use, float high_slack,
                                int along, unsigned shift, Candidates& candidates) {
    const D d;
    const Vec jx = load3(kRowJ, lane, rows), jy = load3(kRowJ + 3, lane, rows),
              jz = load3(kRowJ + 6, lane, rows);
    const V middle = hn::Set(d, 0.5f * (kLowSlack + high_slack));
    const V half = hn::Set(d, 1 + 0.5f * (kLowSlack - high_slack));
    Vec width = load3(kRowWidth, lane, rows);
    width = {hn::IfThenElse(use, hn::Add(width.x, half), hn::Set(d, -1)), hn::Add(width.y, half),
             hn::Add(width.z, half)};
    Vec sk = sum(load3(kRowS, lane, rows), {middle, middle, middle});
    for (int k = 0; k < along; ++k, sk = sum(sk, jz)) {
        Vec sj = sk;
        for (int j = 0; j < along; ++j, sj = sum(sj, jy)) {
            Vec s = sj;
            for (int i = 0; i < along; ++i, s = sum(s, jx)) {
                const M found =
                    hn::And(hn::And(hn::Le(hn::Abs(s.x), width.x), hn::Le(hn::Abs(s.y), width.y)),
                            hn::Le(hn::Abs(s.z), width.z));
                candidates.found[i + 4 * j + 16 * k] |= bits_of(found) << shift;
            }
        }
    }
}

/// Appends the candidates of some of a group's lanes, in an order that doesn't depend on the
/// vector's width.
HWY_INLINE void append(const Candidates& candidates, unsigned lanes, unsigned parity,
                       Waiting& waiting) {
    const auto first = std::int32_t(parity * kCellGroup);
    for (int k = 0; k < candidates.along; ++k)
        for (int j = 0; j < candidates.along; ++j)
            for (int i = 0; i < candidates.along; ++i) {
                const int code = i + 4 * j + 16 * k;
                unsigned found = candidates.found[code] & lanes;
                if constexpr (hn::MaxLanes(D()) == kCellGroup) {
                    const DI di;
                    const auto item = hn::Add(hn::Iota(di, 0), hn::Set(di, first + 32 * code));
                    hn::StoreU(hn::Compress(item, hn::RebindMask(di, mask_of(found))), di,
                               waiting.item + waiting.count);
                    waiting.count += __builtin_popcount(found);
                } else {
                    for (; found; found &= found - 1)
                        waiting.item[waiting.count++] = first + 32 * code + __builtin_ctz(found);
                }
            }
}

/// Reads rows at the cells of the voxels to be solved.
class RowsAt {
  public:
    HWY_INLINE RowsAt(const CellRows& rows, hn::Vec<DI> cell) : m_rows(rows), m_cell(cell) {}
    HWY_INLINE V operator()(int row) const { return at(m_rows.row[row]); }
    HWY_INLINE Vec vec(int row) const { return {(*this)(row), (*this)(row + 1), (*this)(row + 2)}; }
    HWY_INLINE hn::Vec<DI> voxel() const {
        const DI di;
        return hn::BitCast(di, at(reinterpret_cast<const float*>(m_rows.voxel)));
    }

  private:
    HWY_INLINE V at(const float* HWY_RESTRICT row) const {
        const D d;
#if HWY_TARGET <= HWY_AVX3
        return V{_mm512_permutex2var_ps(hn::Load(d, row).raw, m_cell.raw,
                                        hn::Load(d, row + kCellGroup).raw)};
#else
        return hn::GatherIndex(d, row, m_cell);
#endif
    }

    const CellRows& m_rows;
    const hn::Vec<DI> m_cell;
};

/// Solves s + G(s) = s₁ with as many steps as the cells' bends ask for.
/// @param[out] moving  lanes that did not settle
HWY_INLINE Vec settle(const RowsAt& at, const Vec& jx, const Vec& jy, const Vec& jz, const Vec& s1,
                      M active, M& moving) {
    const D d;
    const V bend = at(kRowBend);
    Vec s = s1;
    moving = hn::And(active, hn::Gt(bend, hn::Set(d, kBends[0])));
    if (hn::AllFalse(d, moving)) return s;
    const Vec cxy = at.vec(kRowC), cxz = at.vec(kRowC + 3), cyz = at.vec(kRowC + 6),
              cxyz = at.vec(kRowC + 9);
    for (std::size_t step = 1; step < kMaxSteps; ++step) {
        const V xy = hn::Mul(s.x, s.y), xz = hn::Mul(s.x, s.z), yz = hn::Mul(s.y, s.z);
        const V xyz = hn::Mul(xy, s.z);
        const Vec c =
            sum(sum(scaled(xy, cxy), scaled(xz, cxz)), sum(scaled(yz, cyz), scaled(xyz, cxyz)));
        const Vec g = sum(sum(scaled(c.x, jx), scaled(c.y, jy)), scaled(c.z, jz));
        const Vec next{hn::Sub(s1.x, g.x), hn::Sub(s1.y, g.y), hn::Sub(s1.z, g.z)};
        // Settled lanes stay as they are, or they would depend on their neighbours.
        const Vec before = s;
        s = {hn::IfThenElse(moving, next.x, s.x), hn::IfThenElse(moving, next.y, s.y),
             hn::IfThenElse(moving, next.z, s.z)};
        if (step < kWatched) {
            moving = hn::And(moving, hn::Gt(bend, hn::Set(d, kBends[step])));
        } else {
            const Vec change{hn::Abs(hn::Sub(s.x, before.x)), hn::Abs(hn::Sub(s.y, before.y)),
                             hn::Abs(hn::Sub(s.z, before.z))};
            moving = hn::And(moving, hn::Gt(largest(change), hn::Set(d, kSettled)));
        }
        if (hn::AllFalse(d, moving)) break;
    }
    return s;
}

HWY_INLINE V lerp(V a, V b, V t) {
    return hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
}

/// Trilinear in the original values at the corners. @param t  0…1
HWY_INLINE V value_at(const RowsAt& at, const Vec& t) {
    const V x0 = lerp(at(kRowValue), at(kRowValue + 1), t.x);
    const V x1 = lerp(at(kRowValue + 2), at(kRowValue + 3), t.x);
    const V x2 = lerp(at(kRowValue + 4), at(kRowValue + 5), t.x);
    const V x3 = lerp(at(kRowValue + 6), at(kRowValue + 7), t.x);
    return lerp(lerp(x0, x1, t.y), lerp(x2, x3, t.y), t.z);
}

HWY_INLINE V unit_interval(V s) {
    const D d;
    const V t = hn::Add(hn::Set(d, 0.5f), hn::Mul(hn::Set(d, 0.5f), s));
    return hn::Min(hn::Max(t, hn::Zero(d)), hn::Set(d, 1));
}

/// Where voxels p (relative to the block's origin) are outside of the target's box.
HWY_INLINE M outside(const Vec& p, const BlockTarget& to) {
    const D d;
    const V x = hn::Max(hn::Sub(hn::Set(d, to.low.x), p.x), hn::Sub(p.x, hn::Set(d, to.high.x)));
    const V y = hn::Max(hn::Sub(hn::Set(d, to.low.y), p.y), hn::Sub(p.y, hn::Set(d, to.high.y)));
    const V z = hn::Max(hn::Sub(hn::Set(d, to.low.z), p.z), hn::Sub(p.z, hn::Set(d, to.high.z)));
    return hn::Gt(largest({x, y, z}), hn::Zero(d));
}

/// Stores what lies in a cell where the target is open. @param found  bit: lane
HWY_INLINE void write_solved(const Solved& solved, unsigned found, const BlockTarget& block,
                             const CellTarget& to) {
    for (; found; found &= found - 1) {
        const auto lane = unsigned(__builtin_ctz(found));
        const std::ptrdiff_t voxel = block.origin + solved.voxel[lane];
        if (!to.open[voxel]) continue;
        to.open[voxel] = 0;
        if (block.is_16_bit)
            to.voxels16[voxel] = std::int16_t(solved.whole[lane]);
        else
            to.voxels32[voxel] = solved.value[lane];
        if (block.with_inverse)
            store_inverse(
                to, voxel,
                {solved.back[0][lane] - block.shift.x, solved.back[1][lane] - block.shift.y,
                 solved.back[2][lane] - block.shift.z});
    }
}

/// Solves and writes the voxels from `first` on, at most a vector of them.
HWY_INLINE void solve(const CellRows& rows, const Waiting& waiting, int first,
                      const BlockTarget& block, const CellTarget& to, Solved& solved,
                      std::vector<int>& slow) {
    const D d;
    const DI di;
    M active = hn::FirstN(d, std::size_t(std::min(waiting.count - first, kCellGroup)));
    const auto item =
        hn::IfThenElseZero(hn::RebindMask(di, active), hn::LoadU(di, waiting.item + first));
    const RowsAt at(rows, hn::And(item, hn::Set(di, 31)));
    const auto three = hn::Set(di, 3);
    const auto i = hn::And(hn::ShiftRight<5>(item), three),
               j = hn::And(hn::ShiftRight<7>(item), three), k = hn::ShiftRight<9>(item);
    const Vec steps{hn::ConvertTo(d, i), hn::ConvertTo(d, j), hn::ConvertTo(d, k)};
    const Vec jx = at.vec(kRowJ), jy = at.vec(kRowJ + 3), jz = at.vec(kRowJ + 6);
    const Vec s1 =
        sum(at.vec(kRowS), sum(sum(scaled(steps.x, jx), scaled(steps.y, jy)), scaled(steps.z, jz)));
    M unsettled;
    const Vec s = settle(at, jx, jy, jz, s1, active, unsettled);
    if (HWY_UNLIKELY(!hn::AllFalse(d, unsettled))) {
        for (unsigned left = bits_of(unsettled); left; left &= left - 1) {
            const int cell = waiting.item[first + __builtin_ctz(left)] & 31;
            slow.push_back(rows.first_cell[cell / kCellGroup] + cell % kCellGroup);
        }
        active = hn::AndNot(unsettled, active);
    }
    const V least = hn::Min(hn::Min(s.x, s.y), s.z);
    M found = hn::And(active, hn::And(hn::Ge(least, hn::Set(d, -1 - kLowSlack)),
                                      hn::Le(largest(s), hn::Set(d, 1 - block.high_slack))));
    if (!block.is_inside) found = hn::AndNot(outside(sum(at.vec(kRowPlace), steps), block), found);
    hn::Store(hn::Add(hn::Add(at.voxel(), i), hn::Add(hn::Mul(j, hn::Set(di, block.row)),
                                                      hn::Mul(k, hn::Set(di, block.slice)))),
              di, solved.voxel);
    const Vec t{unit_interval(s.x), unit_interval(s.y), unit_interval(s.z)};
    const V value = value_at(at, t);
    if (block.is_16_bit)
        hn::Store(hn::NearestInt(value), di, solved.whole);
    else
        hn::Store(value, d, solved.value);
    if (block.with_inverse) {
        const Vec p = sum(at.vec(kRowBegin), steps);
        hn::Store(hn::Sub(t.x, p.x), d, solved.back[0]);
        hn::Store(hn::Sub(t.y, p.y), d, solved.back[1]);
        hn::Store(hn::Sub(t.z, p.z), d, solved.back[2]);
    }
    write_solved(solved, bits_of(found), block, to);
}

/// Solves all that fills kCellGroup lanes, whatever the vector's width; the rest too if it must not
/// wait any longer.
HWY_INLINE void solve_waiting(const CellRows& rows, bool all, const BlockTarget& block,
                              const CellTarget& to, Waiting& waiting, Solved& solved,
                              std::vector<int>& slow) {
    constexpr auto kLanes = int(hn::MaxLanes(D()));
    const int count = all ? waiting.count : waiting.count / kCellGroup * kCellGroup;
    if (!count) return;
    for (int first = 0; first < count; first += kLanes)
        solve(rows, waiting, first, block, to, solved, slow);
    waiting.count -= count;
    for (int n = 0; n < waiting.count; ++n) waiting.item[n] = waiting.item[count + n];
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
    const Vec3i first = block.origin();
    to.origin = first.x + std::ptrdiff_t(to.row) * first.y + std::ptrdiff_t(to.slice) * first.z;
    to.high_slack = faces == CellFaces::HalfOpen ? kHighSlack : -kLowSlack;
    to.is_16_bit = target.voxels16 != nullptr;
    to.with_inverse = target.inverse_mm != nullptr;
    return to;
}

/// @returns lanes whose cells are slow
HWY_INLINE unsigned look_into_group(const BlockNodes& block, std::size_t n, unsigned use,
                                    const BlockTarget& to, unsigned parity, CellRows& rows,
                                    std::array<Waiting, 2>& waiting) {
    constexpr auto kLanes = unsigned(hn::MaxLanes(D()));
    constexpr unsigned kLaneBits = (1u << kLanes) - 1;
    const D d;
    unsigned fast = 0, flat = 0;
    bool wide = false;
    for (unsigned lane = 0; lane < kCellGroup; lane += kLanes) {
        const M used = mask_of(use >> lane & kLaneBits);
        const Prepared prepared = prepare(block, n + lane, to, parity * kCellGroup + lane, rows);
        fast |= bits_of(hn::And(used, prepared.fast)) << lane;
        flat |= bits_of(prepared.flat) << lane;
        wide |= !hn::AllFalse(d, hn::And(used, prepared.wide));
    }
    Candidates candidates;
    candidates.along = wide ? kMaxAlong : 2;
    for (unsigned& found : candidates.found) found = 0;
    for (unsigned lane = 0; lane < kCellGroup; lane += kLanes)
        find_candidates(rows, parity * kCellGroup + lane, mask_of(fast >> lane & kLaneBits),
                        to.high_slack, candidates.along, lane, candidates);
    append(candidates, flat, parity, waiting[0]);
    append(candidates, ~flat, parity, waiting[1]);
    return use & ~fast;
}

void write_block(const BlockNodes& block, const CellTarget& target, CellFaces faces,
                 std::vector<int>& slow) {
    const BlockTarget to = target_of(block, target, faces);
    CellRows rows;
    std::array<Waiting, 2> waiting;  // flat ones, others
    Solved solved{};
    unsigned parity = 0;
    std::array<int, 2> last_count{};  // of the group before
    const std::span<const RowBits> use = block.use();
    for (std::size_t w = 0; w < use.size(); ++w) {
        if (!use[w]) continue;
        for (int part = 0; part < 64; part += kCellGroup) {
            const auto group = unsigned(use[w] >> part & 0xffff);
            if (!group) continue;
            // Items of the group whose place is about to be taken are the first ones.
            for (std::size_t i = 0; i < 2; ++i) {
                if (waiting[i].count > last_count[i])
                    solve_waiting(rows, true, to, target, waiting[i], solved, slow);
                last_count[i] = waiting[i].count;
            }
            rows.first_cell[parity] = int(64 * w) + part;
            unsigned slow_lanes =
                look_into_group(block, 64 * w + unsigned(part), group, to, parity, rows, waiting);
            for (std::size_t i = 0; i < 2; ++i) {
                last_count[i] = waiting[i].count - last_count[i];
                solve_waiting(rows, false, to, target, waiting[i], solved, slow);
            }
            parity ^= 1;
            for (; slow_lanes; slow_lanes &= slow_lanes - 1)
                slow.push_back(int(64 * w) + part + __builtin_ctz(slow_lanes));
        }
    }
    for (Waiting& left : waiting) solve_waiting(rows, true, to, target, left, solved, slow);
    // In an order that doesn't depend on the vector's width.
    std::sort(slow.begin(), slow.end());
    slow.erase(std::unique(slow.begin(), slow.end()), slow.end());
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
