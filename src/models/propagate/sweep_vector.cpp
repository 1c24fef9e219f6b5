// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of the sweep with vector instructions, for bricks of 8³, once for each
// instruction set; the program chooses at run time. The plain twin is sweep_plain.cpp.
//
// A row of eight elements along x is one vector (or a few shorter ones), a slice eight rows. A scan
// along y or z works on these rows. A scan along x works on the transposed slice, so that it
// processes eight lines at once, too:
//
//     row y, lanes x  --transposed-->  row x, lanes y  --scan along x-->  --transposed-->  back
//
// The lags of links along x are therefore kept transposed, slice by slice.

#include <algorithm>
#include <bit>
#include <cstddef>

#include "propagate/sweep_kernels.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "propagate/sweep_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

const SweepKernels& kernels_of_target() {
    return plain_sweep_kernels();
}

#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kSize = 8, kSlice = 64, kBrick = 512;
constexpr std::uint32_t kAllSlices = 0xFF;

using D = hn::CappedTag<Fixed, 8>;
using V = hn::Vec<D>;
constexpr int kLanes = int(hn::MaxLanes(D()));
constexpr int kParts = kSize / kLanes;  ///< vectors in a row

struct Row {
    V part[kParts];
};
struct Slice {
    Row row[kSize];
};

HWY_INLINE Row load_row(const Fixed* from) {
    Row row;
    for (int p = 0; p < kParts; ++p) row.part[p] = hn::Load(D(), from + p * kLanes);
    return row;
}
HWY_INLINE void store_row(const Row& row, Fixed* to) {
    for (int p = 0; p < kParts; ++p) hn::Store(row.part[p], D(), to + p * kLanes);
}
HWY_INLINE Row all(Fixed value) {
    Row row;
    for (int p = 0; p < kParts; ++p) row.part[p] = hn::Set(D(), value);
    return row;
}
/// max(to, from − lag)
HWY_INLINE void raise(Row& to, const Row& from, const Row& lag) {
    for (int p = 0; p < kParts; ++p)
        to.part[p] = hn::Max(to.part[p], hn::Sub(from.part[p], lag.part[p]));
}
HWY_INLINE void add_difference(Row& sum, const Row& a, const Row& b) {
    for (int p = 0; p < kParts; ++p)
        sum.part[p] = hn::Or(sum.part[p], hn::Xor(a.part[p], b.part[p]));
}
HWY_INLINE bool is_zero(const Row& row) {
    V any = row.part[0];
    for (int p = 1; p < kParts; ++p) any = hn::Or(any, row.part[p]);
    return hn::AllTrue(D(), hn::Eq(any, hn::Zero(D())));
}
HWY_INLINE bool differ(const Slice& a, const Slice& b) {
    Row sum = all(0);
    for (int n = 0; n < kSize; ++n) add_difference(sum, a.row[n], b.row[n]);
    return !is_zero(sum);
}

/// Lanes a and b of 4 interleaved two by two, in each block of 128 bits: a0 b0 a1 b1, a2 b2 a3 b3.
HWY_INLINE void transpose_blocks(V& a, V& b, V& c, V& d) {
    const D d32;
    const hn::Repartition<std::int64_t, D> d64;
    const auto ab_low = hn::BitCast(d64, hn::InterleaveLower(d32, a, b));
    const auto ab_high = hn::BitCast(d64, hn::InterleaveUpper(d32, a, b));
    const auto cd_low = hn::BitCast(d64, hn::InterleaveLower(d32, c, d));
    const auto cd_high = hn::BitCast(d64, hn::InterleaveUpper(d32, c, d));
    a = hn::BitCast(d32, hn::InterleaveLower(d64, ab_low, cd_low));
    b = hn::BitCast(d32, hn::InterleaveUpper(d64, ab_low, cd_low));
    c = hn::BitCast(d32, hn::InterleaveLower(d64, ab_high, cd_high));
    d = hn::BitCast(d32, hn::InterleaveUpper(d64, ab_high, cd_high));
}

HWY_INLINE void transpose(Slice& s) {
    Row* r = s.row;
    for (int half = 0; half < 2; ++half)
        for (int p = 0; p < kParts; ++p)
            transpose_blocks(r[4 * half].part[p], r[4 * half + 1].part[p], r[4 * half + 2].part[p],
                             r[4 * half + 3].part[p]);
    // Then the off-diagonal blocks of 4×4 are exchanged.
    for (int n = 0; n < 4; ++n) {
#if HWY_MAX_BYTES >= 32
        if constexpr (kParts == 1) {
            const V low = r[n].part[0], high = r[n + 4].part[0];
            r[n].part[0] = hn::ConcatLowerLower(D(), high, low);
            r[n + 4].part[0] = hn::ConcatUpperUpper(D(), high, low);
        }
#endif
        if constexpr (kParts == 2) std::swap(r[n].part[kParts - 1], r[n + 4].part[0]);
    }
}

HWY_INLINE Slice load_slice(const Fixed* from, int step) {
    Slice s;
    for (int n = 0; n < kSize; ++n) s.row[n] = load_row(from + n * step);
    return s;
}
HWY_INLINE void store_slice(const Slice& s, Fixed* to, int step) {
    for (int n = 0; n < kSize; ++n) store_row(s.row[n], to + n * step);
}

/// Lags of the links between rows n and n + 1, from memory or all equal.
struct ListedLags {
    const Fixed* lags;
    int step;
    HWY_INLINE Row operator()(int n) const { return load_row(lags + n * step); }
};
struct EqualLags {
    Row lag;
    HWY_INLINE const Row& operator()(int) const { return lag; }
};

/// Raises the eight rows to the fixed point of the links between them.
template <class Lags>
HWY_INLINE void scan(Slice& s, const Lags& forward, const Lags& backward) {
    for (int n = 0; n + 1 < kSize; ++n) raise(s.row[n + 1], s.row[n], forward(n));
    for (int n = kSize - 2; n >= 0; --n) raise(s.row[n], s.row[n + 1], backward(n));
}

void arrange_x(Fixed* lags, int) {
    for (int z = 0; z < kSize; ++z) {
        Slice s = load_slice(lags + z * kSlice, kSize);
        transpose(s);
        store_slice(s, lags + z * kSlice, kSize);
    }
}

/// Brings a slice to the fixed point of its own links. @returns whether it changed
bool relax_slice(Fixed* w, const InsideLags& lags, int z) {
    const auto of = [&](const std::array<const Fixed*, 3>& arrays, std::size_t axis) {
        return ListedLags{arrays[axis] + z * kSlice, kSize};
    };
    const Slice start = load_slice(w + z * kSlice, kSize);
    Slice s = start;
    for (bool first = true;; first = false) {
        Slice before = s;
        transpose(s);
        scan(s, of(lags.forward, 0), of(lags.backward, 0));
        transpose(s);
        if (!first && !differ(s, before)) break;
        before = s;
        scan(s, of(lags.forward, 1), of(lags.backward, 1));
        if (!differ(s, before)) break;
    }
    store_slice(s, w + z * kSlice, kSize);
    return differ(s, start);
}

/// Brings all links between slices to their fixed point. @returns the slices that changed
std::uint32_t relax_columns(Fixed* w, const InsideLags& lags) {
    Row changed[kSize];
    for (Row& row : changed) row = all(0);
    for (int y = 0; y < kSize; ++y) {
        const Slice before = load_slice(w + y * kSize, kSlice);
        Slice s = before;
        scan(s, ListedLags{lags.forward[2] + y * kSize, kSlice},
             ListedLags{lags.backward[2] + y * kSize, kSlice});
        store_slice(s, w + y * kSize, kSlice);
        for (int z = 0; z < kSize; ++z) add_difference(changed[z], s.row[z], before.row[z]);
    }
    std::uint32_t dirty = 0;
    for (int z = 0; z < kSize; ++z) dirty |= std::uint32_t(!is_zero(changed[z])) << z;
    return dirty;
}

void relax(Fixed* w, int, const InsideLags& lags, std::uint32_t dirty) {
    for (bool first = true;; first = false) {
        bool changed = false;
        for (; dirty != 0; dirty &= dirty - 1)
            changed |= relax_slice(w, lags, std::countr_zero(dirty));
        if (!first && !changed) break;
        dirty = relax_columns(w, lags);
        if (dirty == 0) break;
    }
}

void relax_uniform(Fixed* w, int, const UniformLags& lags, std::uint32_t dirty) {
    const EqualLags fx{all(lags.forward[0])}, bx{all(lags.backward[0])};
    const EqualLags fy{all(lags.forward[1])}, by{all(lags.backward[1])};
    const EqualLags fz{all(lags.forward[2])}, bz{all(lags.backward[2])};
    for (dirty &= kAllSlices; dirty != 0; dirty &= dirty - 1) {
        Fixed* slice = w + std::countr_zero(dirty) * kSlice;
        Slice s = load_slice(slice, kSize);
        transpose(s);
        scan(s, fx, bx);
        transpose(s);
        scan(s, fy, by);
        store_slice(s, slice, kSize);
    }
    for (int y = 0; y < kSize; ++y) {
        Slice s = load_slice(w + y * kSize, kSlice);
        scan(s, fz, bz);
        store_slice(s, w + y * kSize, kSlice);
    }
}

void add_halves(const Fixed* halves, int, int axis, Fixed* lags) {
    const int stride = axis == 0 ? 1 : axis == 1 ? kSize : kSlice;
    // The last elements have no link in the brick; their lags are never used.
    const int count = axis == 2 ? kBrick - kSlice : kBrick - kSize;
    for (int n = 0; n < count; n += kLanes)
        hn::Store(hn::Add(hn::Load(D(), halves + n), hn::LoadU(D(), halves + n + stride)), D(),
                  lags + n);
    if (axis != 0) return;
    for (int n = count; n + 1 < kBrick; ++n) lags[n] = halves[n] + halves[n + 1];
}

/// Calls of(index in the face, element) for a face across x, whose elements are not contiguous.
template <class Of>
HWY_INLINE void for_each_of_x_face(int side, const Of& of) {
    const int first = side % 2 ? kSize - 1 : 0;
    for (int n = 0; n < kSlice; ++n) of(n, first + n * kSize);
}
/// Calls of(index in the face, element) for each vector of a face across y or z.
template <class Of>
HWY_INLINE void for_each_row_of_face(int side, const Of& of) {
    const bool along_y = side < 4;
    const int first = side % 2 == 0 ? 0 : along_y ? kSlice - kSize : kBrick - kSlice;
    for (int n = 0; n < kSize; ++n)
        for (int p = 0; p < kSize; p += kLanes)
            of(n * kSize + p, first + n * (along_y ? kSlice : kSize) + p);
}

void copy_face(const Fixed* values, int, int side, Fixed* out) {
    if (side < 2)
        for_each_of_x_face(side, [&](int n, int element) { out[n] = values[element]; });
    else
        for_each_row_of_face(side, [&](int n, int element) {
            hn::Store(hn::Load(D(), values + element), D(), out + n);
        });
}

/// Uses plain loads: gathers are slower on processors with mitigations against data sampling, and
/// hardly faster elsewhere.
void add_face(const Fixed* column, const MaterialId* ids, int, int side, Fixed* out) {
    HWY_ALIGN Fixed there[kSlice];
    if (side < 2) {
        for_each_of_x_face(side, [&](int n, int element) { out[n] += column[ids[element]]; });
        return;
    }
    const auto load = plain_sweep_kernels().gather;
    const MaterialId* first = ids + (side == 3 ? kSlice - kSize : side == 5 ? kBrick - kSlice : 0);
    if (side < 4)
        for (int n = 0; n < kSize; ++n) load(column, first + n * kSlice, kSize, there + n * kSize);
    else
        load(column, first, kSlice, there);
    for (int n = 0; n < kSlice; n += kLanes)
        hn::Store(hn::Add(hn::Load(D(), out + n), hn::Load(D(), there + n)), D(), out + n);
}

/// The rows of a face: kSize rows, `step` apart. Faces across x are first copied to contiguous
/// memory.
struct Face {
    const Fixed* first;
    int step;
};
Face face_of(const Fixed* w, int side, Fixed* copy) {
    const bool high = side % 2;
    if (side / 2 == 1) return {w + (high ? kSlice - kSize : 0), kSlice};
    if (side / 2 == 2) return {w + (high ? kBrick - kSlice : 0), kSize};
    const Fixed* column = w + (high ? kSize - 1 : 0);
    for (int n = 0; n < kSlice; ++n) copy[n] = column[n * kSize];
    return {copy, kSize};
}

std::uint32_t take(Fixed* w, int, int side, const Fixed* neighbour, const Fixed* lags) {
    HWY_ALIGN Fixed copy[kSlice];
    const Face from = face_of(neighbour, side ^ 1, copy);
    std::uint32_t dirty = 0;
    if (side < 2) {
        Fixed* column = w + (side % 2 ? kSize - 1 : 0);
        for (int n = 0; n < kSlice; ++n) {
            const Fixed offered = from.first[n] - lags[n], old = column[n * kSize];
            column[n * kSize] = std::max(old, offered);
            dirty |= std::uint32_t(offered > old) << n / kSize;
        }
        return dirty;
    }
    const bool along_y = side < 4;
    const int step = along_y ? kSlice : kSize;
    Fixed* face = w + (side % 2 == 0 ? 0 : along_y ? kSlice - kSize : kBrick - kSlice);
    for (int n = 0; n < kSize; ++n) {
        const Row old = load_row(face + n * step);
        Row row = old, changed = all(0);
        raise(row, load_row(from.first + n * from.step), load_row(lags + n * kSize));
        add_difference(changed, row, old);
        store_row(row, face + n * step);
        dirty |= std::uint32_t(!is_zero(changed)) << n;
    }
    if (along_y || dirty == 0) return dirty;
    return side % 2 ? 0x80 : 1;
}

Fixed offer(const Fixed* w, int, int side, const Fixed* lags, const FaceBehind& behind) {
    HWY_ALIGN Fixed own_copy[kSlice];
    HWY_ALIGN Fixed raised_copy[kSlice];
    HWY_ALIGN Fixed u_copy[kSlice];
    const Face own = face_of(w, side, own_copy);
    const Face u = behind.u ? face_of(behind.u, side ^ 1, u_copy) : Face{nullptr, 0};
    const Face raised = behind.raised ? face_of(behind.raised, side ^ 1, raised_copy) : u;
    V largest = hn::Zero(D());
    const V sign = hn::Set(D(), behind.sign);
    for (int n = 0; n < kSize; ++n)
        for (int p = 0; p < kLanes * kParts; p += kLanes) {
            V before = hn::Set(D(), behind.floor);
            if (u.first) before = hn::Mul(sign, hn::Load(D(), u.first + n * u.step + p));
            V now = before;
            if (behind.raised) now = hn::Load(D(), raised.first + n * raised.step + p);
            const V offered = hn::Sub(hn::Load(D(), own.first + n * own.step + p),
                                      hn::Load(D(), lags + n * kSize + p));
            const V rise = hn::IfThenElseZero(hn::Gt(offered, now), hn::Sub(offered, before));
            largest = hn::Max(largest, rise);
        }
    return hn::GetLane(hn::MaxOfLanes(D(), largest));
}

/// Writes a row of the carried raise at its next position.
template <bool kIsFirst>
HWY_INLINE void put_row(const Row& carried, Fixed* to) {
    Row row = carried;
    if (!kIsFirst)
        for (int p = 0; p < kParts; ++p)
            row.part[p] = hn::Max(row.part[p], hn::Load(D(), to + p * kLanes));
    store_row(row, to);
}

/// Along y and z: eight rows, `across` apart, are carried in steps of `along`.
template <bool kIsFirst>
void carry_rows(Fixed* w, int along, int across, const Fixed* face, Fixed lag) {
    const Row step = all(lag);
    Slice carried = load_slice(face, across);
    for (int n = 0; n < kSize; ++n)
        for (int r = 0; r < kSize; ++r) {
            Row lowered = all(0);
            raise(lowered, carried.row[r], step);
            carried.row[r] = lowered;
            put_row<kIsFirst>(lowered, w + n * along + r * across);
        }
}

/// Along x: all steps are within a row.
template <bool kIsFirst>
void carry_along_x(Fixed* w, bool up, const Fixed* face, Fixed lag) {
    HWY_ALIGN Fixed lags[kSize];
    for (int n = 0; n < kSize; ++n) {
        const std::int64_t sum = std::int64_t(n + 1) * lag;
        lags[up ? n : kSize - 1 - n] = Fixed(std::min<std::int64_t>(sum, INT32_MAX));
    }
    const Row steps = load_row(lags);
    for (int n = 0; n < kSlice; ++n) {
        Row row = all(0);
        raise(row, all(face[n * kSize]), steps);
        put_row<kIsFirst>(row, w + n * kSize);
    }
}

template <bool kIsFirst>
void carry_from(Fixed* w, int side, const Fixed* neighbour, Fixed lag) {
    const bool up = side % 2 == 0;  // from the low side
    if (side < 2) {
        carry_along_x<kIsFirst>(w, up, neighbour + (up ? kSize - 1 : 0), lag);
        return;
    }
    const int along = side < 4 ? kSize : kSlice, across = side < 4 ? kSlice : kSize;
    const int last = (kSize - 1) * along;
    carry_rows<kIsFirst>(w + (up ? 0 : last), up ? along : -along, across,
                         neighbour + (up ? last : 0), lag);
}

void carry(Fixed* w, int, int side, const Fixed* neighbour, Fixed lag, bool is_first) {
    if (is_first)
        carry_from<true>(w, side, neighbour, lag);
    else
        carry_from<false>(w, side, neighbour, lag);
}

// The following functions process a brick's elements in memory order, in the longest vectors.
using WideD = hn::ScalableTag<Fixed>;
using Wide = hn::Vec<WideD>;
constexpr int kWideLanes = int(hn::MaxLanes(WideD()));

/// One component, with the data of its loop. A component that stays is raised to its own position.
struct Motion {
    Fixed* u;
    const Fixed* raised;
    Wide left, flip;  ///< flip: all bits set if the sign is −1: (x ^ flip) − flip = sign·x
    Wide low, high;   ///< bounds of sign·u

    HWY_INLINE explicit Motion(const MovingComponent& c)
        : u(c.u),
          raised(c.raised ? c.raised : c.u),
          left(hn::Set(WideD(), c.raised ? c.left : 0)),
          flip(hn::Set(WideD(), c.raised && c.sign < 0 ? -1 : 0)),
          low(hn::Set(WideD(), INT32_MAX)),
          high(hn::Set(WideD(), INT32_MIN)) {}

    /// @returns a vector with nonzero lanes for moved elements
    template <bool kFromRest>
    HWY_INLINE Wide step(int n) {
        const WideD d;
        const Wide old = kFromRest ? hn::Zero(d) : hn::Load(d, u + n);
        const Wide before = kFromRest ? old : hn::Sub(hn::Xor(old, flip), flip);
        const Wide position = hn::Max(before, hn::Sub(hn::Load(d, raised + n), left));
        low = hn::Min(low, position);
        high = hn::Max(high, position);
        hn::Store(hn::Sub(hn::Xor(position, flip), flip), d, u + n);
        return hn::Xor(position, before);
    }
    HWY_INLINE void bounds(Fixed& u_min, Fixed& u_max) const {
        const bool negative = hn::GetLane(flip) != 0;
        const Fixed from = hn::GetLane(hn::MinOfLanes(WideD(), low));
        const Fixed to = hn::GetLane(hn::MaxOfLanes(WideD(), high));
        u_min = negative ? -to : from;
        u_max = negative ? -from : to;
    }
};

/// Adds −1 for each lane that didn't move.
HWY_INLINE void count_still(Wide& still, const Wide& moved) {
    const WideD d;
    still = hn::Add(still, hn::VecFromMask(d, hn::Eq(moved, hn::Zero(d))));
}

template <bool kFromRest>
MoveResult move_brick(const std::array<MovingComponent, 3>& components, int count) {
    Motion x(components[0]), y(components[1]), z(components[2]);
    Wide still = hn::Zero(WideD());  // minus the number of elements that didn't move
    for (int n = 0; n < count; n += kWideLanes) {
        const Wide x_moved = x.step<kFromRest>(n), y_moved = y.step<kFromRest>(n);
        count_still(still, hn::Or(hn::Or(x_moved, y_moved), z.step<kFromRest>(n)));
    }
    MoveResult result;
    result.moved = count + hn::GetLane(hn::SumOfLanes(WideD(), still));
    const std::array<const Motion*, 3> motions = {&x, &y, &z};
    for (std::size_t a = 0; a < 3; ++a)
        if (components[a].raised) motions[a]->bounds(result.u_min[a], result.u_max[a]);
    return result;
}

/// The same for a single moving component.
template <bool kFromRest>
MoveResult move_alone(const std::array<MovingComponent, 3>& components, std::size_t a, int count) {
    Motion motion(components[a]);
    Wide still = hn::Zero(WideD());
    for (int n = 0; n < count; n += kWideLanes) count_still(still, motion.step<kFromRest>(n));
    MoveResult result;
    result.moved = count + hn::GetLane(hn::SumOfLanes(WideD(), still));
    motion.bounds(result.u_min[a], result.u_max[a]);
    return result;
}

MoveResult move(const std::array<MovingComponent, 3>& components, int count, bool from_rest) {
    int moving = 0;
    std::size_t alone = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        if (components[a].raised) ++moving, alone = a;
    }
    if (moving == 1)
        return from_rest ? move_alone<true>(components, alone, count)
                         : move_alone<false>(components, alone, count);
    return from_rest ? move_brick<true>(components, count) : move_brick<false>(components, count);
}

Fixed largest(const Fixed* values, int count) {
    const WideD d;
    Wide high = hn::Load(d, values);
    for (int n = kWideLanes; n < count; n += kWideLanes)
        high = hn::Max(high, hn::Load(d, values + n));
    return hn::GetLane(hn::MaxOfLanes(d, high));
}

const SweepKernels& kernels_of_target() {
    static const SweepKernels kernels{plain_sweep_kernels().gather,
                                      copy_face,
                                      add_face,
                                      add_halves,
                                      arrange_x,
                                      relax,
                                      relax_uniform,
                                      take,
                                      offer,
                                      carry,
                                      move,
                                      largest};
    return kernels;
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(kernels_of_target);
const SweepKernels& vector_sweep_kernels() {
    return HWY_DYNAMIC_DISPATCH(kernels_of_target)();
}
}  // namespace pliant
#endif
