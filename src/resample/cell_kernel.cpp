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

#include "resample/cell_stages.inc"  // a part of this file

HWY_BEFORE_NAMESPACE();
namespace pliant {
namespace HWY_NAMESPACE {
namespace {

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
