// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/cell_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "resample/cell_kernel.cpp"  // this file, compiled again for each target
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "resample/cell_stages.inc"  // a part of this file

HWY_BEFORE_NAMESPACE();
namespace pliant {
namespace HWY_NAMESPACE {
namespace {

/// Reads rows for the cells of the voxels to be solved, which are in two groups.
class RowsAt {
  public:
    /// @param lane  in the rows, by voxel. @param even, odd  begins of the two groups
    HWY_INLINE RowsAt(const CellRows& rows, hn::Vec<DI> lane, unsigned even, unsigned odd)
        : m_lane(lane), m_rows(rows.row[0]), m_even(m_rows + even), m_odd(m_rows + odd) {}
    HWY_INLINE V operator()(int row) const {
        const std::size_t at = std::size_t(row * CellRows::kLanes);
#if HWY_TARGET <= HWY_AVX3
        const D d;
        return V{_mm512_permutex2var_ps(hn::Load(d, m_even + at).raw, m_lane.raw,
                                        hn::Load(d, m_odd + at).raw)};
#else
        return hn::GatherIndex(D(), m_rows + at, m_lane);
#endif
    }
    HWY_INLINE Vec vec(int row) const {
        return {(*this)(row), (*this)(row + 1), (*this)(row + 2)};
    }
    HWY_INLINE hn::Vec<DI> voxel() const {
        return hn::BitCast(DI(), (*this)(kRowVoxel));
    }

  private:
    const hn::Vec<DI> m_lane;
    [[maybe_unused]] const float *m_rows, *m_even, *m_odd;
};

HWY_INLINE M has_moved(const Vec& from, const Vec& to) {
    const Vec change{hn::Sub(to.x, from.x), hn::Sub(to.y, from.y), hn::Sub(to.z, from.z)};
    return hn::Gt(largest_size(change), hn::Set(D(), kSettled));
}

HWY_INLINE Vec if_then_else(M which, const Vec& a, const Vec& b) {
    return {hn::IfThenElse(which, a.x, b.x), hn::IfThenElse(which, a.y, b.y),
            hn::IfThenElse(which, a.z, b.z)};
}

/// Lanes at the bound to which newton_step clamps.
HWY_INLINE M is_held(const Vec& s) {
    return hn::Ge(largest_size(s), hn::Set(D(), kNewtonReach));
}

/// @param[in,out] s  of the lanes to solve. @returns lanes that did not converge
HWY_NOINLINE M settle_by_newton(const Bending& g, const Vec& s1, M lanes, Vec& s) {
    const D d;
    const auto start = [&](V x)
                           HWY_ATTR { return hn::Min(hn::Max(x, hn::Set(d, -1)), hn::Set(d, 1)); };
    s = if_then_else(lanes, {start(s1.x), start(s1.y), start(s1.z)}, s);
    for (int step = 0; step < kNewtonSteps && !hn::AllFalse(d, lanes); ++step) {
        const Vec next = newton_step(g, s1, s), before = s;
        s = if_then_else(lanes, next, s);
        lanes = hn::And(lanes, has_moved(before, s));
        // Lanes that stay clamped have their solution beyond the bound.
        if (step >= kNewtonSteps / 2)
            lanes = hn::AndNot(hn::And(is_held(before), is_held(s)), lanes);
    }
    return lanes;
}

/// Solves s + G(s) = s₁ with the number of steps that the cells' bends require.
/// @param[out] s  solution. @returns lanes that did not converge
HWY_INLINE M settle(const RowsAt& at, const Vec& s1, M active, Vec& s) {
    const D d;
    const V bend = at(kRowBend);
    const M bent = hn::And(active, hn::Gt(bend, hn::Set(d, kBends[0])));
    s = s1;
    if (hn::AllFalse(d, bent)) return bent;
    const Bending g{at.vec(kRowG), at.vec(kRowG + 3), at.vec(kRowG + 6), at.vec(kRowG + 9)};
    for (std::size_t step = 0; step < kFlatSteps; ++step) s = next_step(g, s1, s);
    // Settled lanes keep their values, which would otherwise depend on other lanes.
    s = if_then_else(bent, s, s1);
    const M very = hn::And(active, hn::Ge(bend, hn::Set(d, kMaxBent)));
    M moving = hn::AndNot(very, hn::And(active, hn::Gt(bend, hn::Set(d, kBends[kFlatSteps]))));
    for (std::size_t step = kFlatSteps + 1; step < kMaxSteps; ++step) {
        if (hn::AllFalse(d, moving)) break;
        const Vec next = next_step(g, s1, s), before = s;
        s = if_then_else(moving, next, s);
        if (step < kWatched) {
            moving = hn::And(moving, hn::Gt(bend, hn::Set(d, kBends[step])));
        } else {
            moving = hn::And(moving, has_moved(before, s));
        }
    }
    if (HWY_UNLIKELY(!hn::AllFalse(d, very))) {
        // Copies: references would force all of the rarely used values into memory.
        const Bending of_g = g;
        const Vec of_s1 = s1;
        Vec of_s = s;
        moving = hn::Or(moving, settle_by_newton(of_g, of_s1, very, of_s));
        s = of_s;
    }
    return moving;
}

HWY_INLINE V lerp(V a, V b, V t) {
    return mul_add(t, hn::Sub(b, a), a);
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
    const V t = mul_add(hn::Set(d, 0.5f), s, hn::Set(d, 0.5f));
    return hn::Min(hn::Max(t, hn::Zero(d)), hn::Set(d, 1));
}

/// Whether voxels p (relative to the strip's origin) are outside of the target's box.
HWY_INLINE M outside(const Vec& p, const StripTarget& to) {
    const D d;
    const V x = hn::Max(hn::Sub(hn::Set(d, to.low.x), p.x), hn::Sub(p.x, hn::Set(d, to.high.x)));
    const V y = hn::Max(hn::Sub(hn::Set(d, to.low.y), p.y), hn::Sub(p.y, hn::Set(d, to.high.y)));
    const V z = hn::Max(hn::Sub(hn::Set(d, to.low.z), p.z), hn::Sub(p.z, hn::Set(d, to.high.z)));
    return hn::Gt(largest({x, y, z}), hn::Zero(d));
}

HWY_INLINE Open open_of(Open* open, std::ptrdiff_t voxel) {
    return std::atomic_ref(open[voxel]).load(std::memory_order_relaxed);
}

/// Stores solved voxels where the target is open. @param found  bit: lane
/// @returns the number of voxels stored
HWY_INLINE int write_solved(const Solved& solved, unsigned found, const StripTarget& strip,
                            const CellTarget& to) {
    // By value: for the compiler a store of one byte may alias everything else.
    Open* const open = to.open + strip.origin;
    const Open yes = to.turn.yes(), taken = to.turn.taken(), shared = to.turn.shared();
    const Open written = to.takes ? taken : to.turn.no();
    const auto write = [=, &solved](const auto& store) HWY_ATTR {
        int count = 0;
        for (unsigned left = found; left; left &= left - 1) {
            const auto lane = unsigned(__builtin_ctz(left));
            const std::ptrdiff_t voxel = solved.voxel[lane];
            const Open state = open_of(open, voxel);
            if (HWY_LIKELY(state == yes)) {
                put(open[voxel], written);
                store(lane, voxel);
                ++count;
            } else if (state == taken) {
                put(open[voxel], shared);
            }
        }
        return count;
    };
    if (strip.is_16_bit && !strip.with_inverse) {
        std::int16_t* const voxels = to.voxels16 + strip.origin;
        return write([voxels, &solved](unsigned lane, std::ptrdiff_t voxel)
                         HWY_ATTR { put(voxels[voxel], std::int16_t(solved.whole[lane])); });
    }
    return write([&](unsigned lane, std::ptrdiff_t from_origin) HWY_ATTR {
        const std::ptrdiff_t voxel = strip.origin + from_origin;
        if (strip.is_16_bit)
            put(to.voxels16[voxel], std::int16_t(solved.whole[lane]));
        else
            put(to.voxels32[voxel], solved.value[lane]);
        if (strip.with_inverse) store_inverse(to, voxel, solved.back_of(int(lane), strip.shift));
    });
}

/// State of one call of write_cells.
struct Work {
    Work(const StripNodes& nodes, const CellTarget& to_target, const StripTarget& to_strip,
         Leftovers& leftovers)
        : strip(nodes), target(to_target), to(to_strip), left(leftovers) {}

    const StripNodes& strip;
    const CellTarget& target;
    const StripTarget to;
    Leftovers& left;
    unsigned group = 0;  ///< the latest one
    CellRows rows;
    Waiting waiting;
    Solved solved;
    unsigned found = 0;  ///< bit: lane of solved voxels that are not written yet
};

/// Writes the result of the last call of solve. Written one vector late: the trip count is then
/// known early, and a mispredicted branch is cheap.
HWY_INLINE void write_last(Work& work) {
    work.left.written += write_solved(work.solved, work.found, work.to, work.target);
    work.found = 0;
}

/// @param first  the first solved item. @param found, edges  bit: lane
HWY_NOINLINE void claim(Work& work, int first, unsigned found, unsigned edges) {
    const Solved& solved = work.solved;
    for (; found; found &= found - 1) {
        const int n = __builtin_ctz(found);
        const std::ptrdiff_t voxel = work.to.origin + solved.voxel[n];
        if (!work.target.turn.is_open(open_of(work.target.open, voxel))) continue;
        const int lane = work.waiting.item[first + n] & ((1 << kLaneBits) - 1);
        work.left.claims.push_back(
            {voxel, (edges >> n & 1) != 0, work.left.strip, work.rows.cell_of(lane),
             work.to.is_16_bit ? double(solved.whole[n]) : double(solved.value[n]),
             work.to.with_inverse ? solved.back_of(n, work.to.shift) : Vec3f{0, 0, 0}});
    }
}

/// Adds unsettled voxels, with the same parameters.
HWY_NOINLINE void leave_unsettled(Work& work, int first, unsigned lanes) {
    for (; lanes; lanes &= lanes - 1) {
        const int n = __builtin_ctz(lanes);
        const int lane = work.waiting.item[first + n] & ((1 << kLaneBits) - 1);
        work.left.unsettled.push_back(
            {work.rows.cell_of(lane), work.to.origin + work.solved.voxel[n]});
    }
}

/// Solves `count` voxels from `first` on, at most a vector of them. Their cells are in the two
/// groups before the latest.
HWY_INLINE void solve(int first, int count, Work& work) {
    const D d;
    const DI di;
    const CellRows& rows = work.rows;
    const StripTarget& to = work.to;
    write_last(work);
    M active = hn::FirstN(d, std::size_t(count));
    const unsigned last = (work.group - 1) % kKeptGroups, other = (work.group - 2) % kKeptGroups;
    const auto fill = hn::Set(di, std::int32_t(kCellGroup * last));
    const auto item =
        hn::IfThenElse(hn::RebindMask(di, active), hn::LoadU(di, work.waiting.item + first), fill);
    const RowsAt at(rows, hn::And(item, hn::Set(di, (1 << kLaneBits) - 1)),
                    kCellGroup * (last % 2 ? other : last), kCellGroup * (last % 2 ? last : other));
    const auto three = hn::Set(di, 3);
    const auto i = hn::And(hn::ShiftRight<kLaneBits>(item), three),
               j = hn::And(hn::ShiftRight<kLaneBits + 2>(item), three),
               k = hn::ShiftRight<kLaneBits + 4>(item);
    const Vec steps{hn::ConvertTo(d, i), hn::ConvertTo(d, j), hn::ConvertTo(d, k)};
    const Vec s1 = mul_add(
        steps.x, at.vec(kRowJ),
        mul_add(steps.y, at.vec(kRowJ + 3), mul_add(steps.z, at.vec(kRowJ + 6), at.vec(kRowS))));
    if (!to.is_inside) active = hn::AndNot(outside(sum(at.vec(kRowPosition), steps), to), active);
    Vec s;
    const M moving = settle(at, s1, active, s);
    const V least = hn::Min(hn::Min(s.x, s.y), s.z);
    M found = hn::And(active, hn::And(hn::Ge(least, hn::Set(d, -1 - kLowSlack)),
                                      hn::Le(largest(s), hn::Set(d, 1 - to.high_slack))));
    hn::Store(hn::Add(hn::Add(at.voxel(), i),
                      hn::Add(hn::Mul(j, hn::Set(di, to.row)), hn::Mul(k, hn::Set(di, to.slice)))),
              di, work.solved.voxel);
    if (HWY_UNLIKELY(!hn::AllFalse(d, moving))) {
        leave_unsettled(work, first, bits_of(moving));
        found = hn::AndNot(moving, found);
    }
    const Vec t{unit_interval(s.x), unit_interval(s.y), unit_interval(s.z)};
    const V value = value_at(at, t);
    if (to.is_16_bit)
        hn::Store(hn::NearestInt(value), di, work.solved.whole);
    else
        hn::Store(value, d, work.solved.value);
    if (to.with_inverse) {
        const Vec p = sum(at.vec(kRowBegin), steps);
        hn::Store(hn::Sub(t.x, p.x), d, work.solved.back[0]);
        hn::Store(hn::Sub(t.y, p.y), d, work.solved.back[1]);
        hn::Store(hn::Sub(t.z, p.z), d, work.solved.back[2]);
    }
    const M edges = hn::And(found, hn::Lt(least, hn::Set(d, -1 - kEdge)));
    const M later = work.left.writes == Writes::None ? found : edges;
    if (HWY_UNLIKELY(!hn::AllFalse(d, later))) {
        claim(work, first, bits_of(later), bits_of(edges));
        found = hn::AndNot(later, found);
    }
    work.found = bits_of(found);
}

/// Solves voxels of the two groups before the latest: all that fill kCellGroup lanes, for every
/// vector width, and the rest of the older group, whose memory is reused next.
HWY_INLINE void solve_waiting(Work& work) {
    constexpr auto kLanes = int(hn::MaxLanes(D()));
    Waiting& waiting = work.waiting;
    while (waiting.last - waiting.begin >= kCellGroup || waiting.begin < waiting.oldest) {
        const int count = std::min(waiting.last - waiting.begin, kCellGroup);
        for (int lane = 0; lane < count; lane += kLanes)
            solve(waiting.begin + lane, std::min(count - lane, kLanes), work);
        waiting.begin += count;
    }
    // Another group may need memory for all its candidates, but usually the beginning suffices,
    // which stays in the first-level cache.
    if (waiting.begin > Waiting::kFew ||
        waiting.end > Waiting::kCapacity - kCellGroup * kMaxCandidates) {
        std::copy(waiting.item + waiting.begin, waiting.item + waiting.end, waiting.item);
        waiting.last -= waiting.begin;
        waiting.end -= waiting.begin;
        waiting.begin = 0;
    }
    waiting.oldest = waiting.last;
    waiting.last = waiting.end;
}

StripTarget target_of(const StripNodes& strip, const CellTarget& target, CellFaces faces) {
    StripTarget to;
    to.is_inside = true;
    for (int a = 0; a < 3; ++a) {
        to.low[a] = float(target.box.begin[a] - strip.origin()[a]);
        to.high[a] = float(target.box.end[a] - 1 - strip.origin()[a]);
        to.shift[a] = float(strip.origin()[a] - strip.first_element()[a]);
        to.is_inside &= strip.reach().low[a] >= target.box.begin[a] + 1 &&
                        strip.reach().high[a] <= target.box.end[a] - 2;
    }
    to.row = target.grid_size.x;
    to.slice = target.grid_size.x * target.grid_size.y;
    const Vec3i first = strip.origin();
    to.origin = first.x + std::ptrdiff_t(to.row) * first.y + std::ptrdiff_t(to.slice) * first.z;
    to.high_slack = faces == CellFaces::HalfOpen ? kHighSlack : -kLowSlack;
    to.is_16_bit = target.voxels16 != nullptr;
    to.with_inverse = target.inverse_mm != nullptr;
    return to;
}

/// Cells (x…x + 7, y, z).
struct HalfGroup {
    Vec3i position;
    unsigned use;  ///< bit: lane
};

/// Coordinates of the cells in lanes lane, lane + 1, …, along one axis.
template <int Vec3i::*kAxis>
HWY_INLINE V coordinate(const HalfGroup& low, const HalfGroup& high, unsigned lane) {
    const D d;
    const bool is_x = kAxis == &Vec3i::x;
    const V along = is_x ? hn::Iota(d, float(lane)) : hn::Zero(d);
    const V below = hn::Add(along, hn::Set(d, float(low.position.*kAxis)));
    const V above =
        hn::Add(along, hn::Set(d, float(high.position.*kAxis - (is_x ? kHalfGroup : 0))));
#if HWY_TARGET <= HWY_AVX3
    return hn::ConcatUpperLower(d, above, below);
#else
    return lane < kHalfGroup ? below : above;
#endif
}

/// Prepares two halves of a group and lists their candidates.
HWY_INLINE void look_into_group(const HalfGroup& low, const HalfGroup& high, Work& work) {
    constexpr auto kLanes = unsigned(hn::MaxLanes(D()));
    constexpr unsigned kAllLanes = (1u << kLanes) - 1;
    const D d;
    const auto number = [&](const HalfGroup& half) {
        return work.strip.index(half.position.x, half.position.y, half.position.z);
    };
    const int low_cell = number(low), high_cell = number(high);
    const unsigned slot = work.group % kKeptGroups, first_lane = slot * kCellGroup;
    work.rows.first_cell[slot][0] = low_cell;
    work.rows.first_cell[slot][1] = high_cell;
    const unsigned use = low.use | high.use << kHalfGroup;
    std::array<Prepared, kCellGroup / kLanes> cells;
    unsigned fast = 0, folded = 0;
    bool is_wide = false;
    for (unsigned part = 0, lane = 0; lane < kCellGroup; ++part, lane += kLanes) {
        const M used = mask_of(use >> lane & kAllLanes);
        const Vec at{coordinate<&Vec3i::x>(low, high, lane), coordinate<&Vec3i::y>(low, high, lane),
                     coordinate<&Vec3i::z>(low, high, lane)};
        const Cells n{lane < kHalfGroup ? std::size_t(low_cell) + lane
                                        : std::size_t(high_cell) + lane - kHalfGroup,
                      std::size_t(high_cell)};
        cells[part] = prepare(work.strip, n, at, work.to, first_lane + lane, work.rows);
        M ready = hn::And(used, cells[part].fast);
        const M simple = hn::And(ready, hn::Lt(cells[part].most, hn::Set(d, kMaxBent)));
        const M doubtful = hn::AndNot(simple, used);
        if (HWY_UNLIKELY(!hn::AllFalse(d, doubtful))) {
            const M sound = is_nowhere_folded(work.strip, n);
            folded |= bits_of(hn::AndNot(sound, doubtful)) << lane;
            ready = hn::Or(simple, hn::And(ready, sound));
        }
        fast |= bits_of(ready) << lane;
        is_wide |= !hn::AllFalse(d, hn::And(ready, hn::Ge(cells[part].widest, hn::Set(d, 2))));
    }
    std::array<int, 3> along{2, 2, 2};
    if (HWY_LIKELY(!is_wide)) {
        list_candidates(cells, fast, work.to.high_slack, first_lane, along, work.waiting);
    } else {
        for (std::size_t a = 0; a < 3; ++a)
            for (unsigned part = 0, lane = 0; lane < kCellGroup; ++part, lane += kLanes)
                if (!hn::AllFalse(d, hn::And(mask_of(fast >> lane & kAllLanes),
                                             hn::Ge(cells[part].count[a], hn::Set(d, 2)))))
                    along[a] = kMaxAlong;
        list_candidates(cells, fast, work.to.high_slack, first_lane, along, work.waiting);
    }
    const auto cell = [&](unsigned lanes) {
        return work.rows.cell_of(int(first_lane) + __builtin_ctz(lanes));
    };
    for (unsigned left = use & ~fast; left; left &= left - 1) work.left.slow.push_back(cell(left));
    for (; folded; folded &= folded - 1) work.left.folded.push_back(cell(folded));
}

HWY_NOINLINE void write_group(const HalfGroup& low, const HalfGroup& high, Work& work) {
    look_into_group(low, high, work);
    solve_waiting(work);
    ++work.group;
}

void write_strip(const StripNodes& strip, const CellTarget& target, CellFaces faces,
                 Leftovers& left, Ahead& ahead) {
    Work work(strip, target, target_of(strip, target, faces), left);
    const RowBits* use = strip.use().data();
    const std::size_t groups = strip.use().size() * std::size_t(strip.cells()) / kCellGroup;
    const std::size_t lines = ahead.left() / groups + 1;
    constexpr unsigned kHalf = (1u << kHalfGroup) - 1;
    HalfGroup alone{{0, 0, 0}, 0};  // without the other half of its row
    for (int z = 0; z < strip.size(); ++z)
        for (int y = 0; y < strip.size(); ++y, ++use)
            for (int x = 0; x < strip.cells(); x += kCellGroup) {
                ahead.fetch(lines);
                const auto group = unsigned(*use >> x & 0xffff);
                if (!group) continue;
                HalfGroup low{{x, y, z}, group & kHalf};
                HalfGroup high{{x + kHalfGroup, y, z}, group >> kHalfGroup};
                if (!low.use || !high.use) {
                    const HalfGroup half = low.use ? low : high;
                    if (!alone.use) {
                        alone = half;
                        continue;
                    }
                    low = std::exchange(alone, {{0, 0, 0}, 0});
                    high = half;
                }
                write_group(low, high, work);
            }
    if (alone.use) write_group(alone, {alone.position, 0}, work);
    for (int rest = 0; rest < 2; ++rest, ++work.group) solve_waiting(work);
    write_last(work);
}

/// Bounds of some cells along an axis, from the strip's origin on.
struct Extent {
    V least, most;
};

/// @param n  number of the first cell. @param position  of the cells' lowest corners
HWY_INLINE Extent extent_of(const StripNodes& strip, std::size_t n, int axis, V position) {
    const D d;
    const std::size_t step[3] = {1, std::size_t(strip.row()), std::size_t(strip.slice())};
    const std::size_t one = step[(axis + 1) % 3], other = step[(axis + 2) % 3];
    // [s]: of the corners on the cells' low side along the axis, and on their high side.
    Extent side[2];
    for (std::size_t s = 0; s < 2; ++s) {
        const float* u = strip.eighth_u(axis) + n + s * step[axis];
        const V a = hn::LoadU(d, u), b = hn::LoadU(d, u + one);
        const V e = hn::LoadU(d, u + other), f = hn::LoadU(d, u + one + other);
        side[s] = {hn::Min(hn::Min(a, b), hn::Min(e, f)), hn::Max(hn::Max(a, b), hn::Max(e, f))};
    }
    const V eight = hn::Set(d, 8), whole = hn::Set(d, 0.125f);
    return {mul_add(eight, hn::Min(side[0].least, hn::Add(side[1].least, whole)), position),
            mul_add(eight, hn::Max(side[0].most, hn::Add(side[1].most, whole)), position)};
}

bool keep_near(const StripNodes& strip, std::span<const Box3i> boxes, std::span<RowBits> use) {
    constexpr auto kLanes = int(hn::MaxLanes(D()));
    const D d;
    const auto reaches = [&](const Extent& extent, int axis, const Box3i& box) HWY_ATTR {
        const int first = box.begin[axis] - strip.origin()[axis];
        const int last = box.end[axis] - 1 - strip.origin()[axis];
        return hn::And(hn::Le(extent.least, hn::Set(d, float(last) + kNearSlack)),
                       hn::Ge(extent.most, hn::Set(d, float(first) - kNearSlack)));
    };
    bool any = false;
    for (std::size_t r = 0; r < use.size(); ++r) {
        if (!use[r]) continue;
        const int y = int(r) % strip.size(), z = int(r) / strip.size();
        RowBits near = 0;
        for (int x = 0; x < strip.cells(); x += kLanes) {
            const auto n = std::size_t(strip.index(x, y, z));
            const V along = hn::Add(hn::Iota(d, 0), hn::Set(d, float(x)));
            const Extent in_x = extent_of(strip, n, 0, along),
                         in_y = extent_of(strip, n, 1, hn::Set(d, float(y))),
                         in_z = extent_of(strip, n, 2, hn::Set(d, float(z)));
            M found = mask_of(0);
            for (const Box3i& box : boxes)
                found =
                    hn::Or(found, hn::And(reaches(in_x, 0, box),
                                          hn::And(reaches(in_y, 1, box), reaches(in_z, 2, box))));
            near |= RowBits(bits_of(found)) << x;
        }
        use[r] &= near;
        any |= use[r] != 0;
    }
    return any;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace pliant
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
namespace {
HWY_EXPORT(write_strip);
HWY_EXPORT(keep_near);
}  // namespace

void write_cells(const StripNodes& strip, const CellTarget& target, CellFaces faces,
                 Leftovers& left, Ahead& ahead) {
    HWY_DYNAMIC_DISPATCH(write_strip)(strip, target, faces, left, ahead);
}

bool write_claim(const Claim& claim, const CellTarget& target) {
    if (!target.turn.is_open(target.open[claim.voxel])) return false;
    target.open[claim.voxel] = target.turn.no();
    if (target.voxels16)
        target.voxels16[claim.voxel] = std::int16_t(std::lrint(claim.value));
    else
        target.voxels32[claim.voxel] = float(claim.value);
    if (target.inverse_mm) store_inverse(target, claim.voxel, claim.back);
    return true;
}

bool keep_cells_near(const StripNodes& strip, std::span<const Box3i> boxes,
                     std::span<RowBits> use) {
    return HWY_DYNAMIC_DISPATCH(keep_near)(strip, boxes, use);
}

}  // namespace pliant
#endif
