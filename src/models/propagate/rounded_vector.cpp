// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rounded limits with vector instructions, for bricks of 8³, once for each instruction set; the
// program chooses at run time. The plain twin is rounded_plain.cpp.
//
// A sweep in the order of the motion updates each element once, if its neighbours on the near sides
// are final. Elements with equal x + y don't depend on each other; a brick is stored so that these
// are the lanes of a vector, by y:
//
//     y ^  2 3 4 5        row r = x + y + 10·z + 12 of the memory has the element at y in lane y.
//       |  1 2 3 4        Each neighbour is at one fixed offset, so that all six are plain loads.
//       |  0 1 2 3        The layer behind the faces has its own rows and lanes, −1 and 8.
//       +---------> x
//
// All slices follow each other in the same rows: while high y are in slice z, low y are in z + 1. A
// sweep through ascending rows thus has ascending x, y and z. The axes are reversed on loading as
// needed for this to be the direction away from the farthest element behind the faces. Descending
// sweeps alternate with ascending ones; only rows are processed in which a neighbour rose.
//
// The root of a quadratic equation is a guess of an element's position. The exact sum, at the whole
// number above it and at the one before, decides. So the guess may be computed in any way, and
// differently on each instruction set.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "propagate/rounded_kernel.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "propagate/rounded_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR || !HWY_HAVE_FLOAT64

RelaxRounded relax_of_target() {
    return plain_relax_rounded();
}

#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kSize = 8, kSlice = 64, kFace = 64;
constexpr int kRow = 16;    ///< stride of the rows
constexpr int kLayer = 10;  ///< rows from one slice to the next
constexpr int kFirstRow = 12, kLastRow = 96, kRowCount = 112;
constexpr int kFirstLane = 8;  ///< aligned
constexpr int kSliceStep = kLayer * kRow;
constexpr std::array<int, 3> kStep = {kRow, kRow + 1, kSliceStep};
constexpr std::size_t kCells = kRowCount * kRow;

constexpr int index_of(int x, int y, int z) {
    return kRow * (x + y + kLayer * z + kFirstRow) + y + kFirstLane;
}

/// By row: the lanes with elements of the brick.
constexpr std::array<std::uint8_t, kRowCount> kInside = [] {
    std::array<std::uint8_t, kRowCount> inside{};
    for (int z = 0; z < kSize; ++z)
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                std::uint8_t& row = inside[std::size_t(x + y + kLayer * z + kFirstRow)];
                row = std::uint8_t(row | 1 << y);
            }
    return inside;
}();

using D = hn::CappedTag<double, kSize>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using DI = hn::Rebind<Fixed, D>;
using VI = hn::Vec<DI>;
using MI = hn::Mask<DI>;
constexpr int kLanes = int(hn::MaxLanes(D()));
constexpr int kParts = kSize / kLanes;
constexpr unsigned kPartBits = (1u << kLanes) - 1;

/// One value for each row and lane.
template <class T>
struct alignas(64) Skewed {
    std::array<T, kCells> values;
    T* at(int n) { return values.data() + n; }
    const T* at(int n) const { return values.data() + n; }
};

HWY_INLINE MI mask_of(unsigned bits) {
    std::uint8_t bytes[8] = {std::uint8_t(bits)};
    return hn::LoadMaskBits(DI(), bytes);
}
HWY_INLINE unsigned bits_of(MI mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(DI(), mask, bytes);
    return bytes[0] & kPartBits;
}
HWY_INLINE unsigned bits_of_wide(M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(D(), mask, bytes);
    return bytes[0] & kPartBits;
}
HWY_INLINE M wide_mask_of(unsigned bits) {
    std::uint8_t bytes[8] = {std::uint8_t(bits)};
    return hn::LoadMaskBits(D(), bytes);
}

/// The neighbours of a vector of elements, by side, and the bounds of the sums.
struct Links {
    std::array<V, 6> w, share;
    V bound;
};

HWY_INLINE V lag_share(const Links& links, std::size_t b, V v) {
    const V below = hn::Mul(hn::Sub(links.w[2 * b], v), links.share[2 * b]);
    const V above = hn::Mul(hn::Sub(links.w[2 * b + 1], v), links.share[2 * b + 1]);
    return hn::Max(hn::Zero(D()), hn::Max(below, above));
}
/// The same operations in the same order as in rounded_plain.cpp.
HWY_INLINE V lag_sum(const Links& links, V v) {
    const V x = lag_share(links, 0, v), y = lag_share(links, 1, v), z = lag_share(links, 2, v);
    return hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
}

/// See rounded_rise in rounded_plain.cpp. Axes that cease to contribute before the root are left
/// out, all at once.
HWY_INLINE V rise(const Links& links, V v, unsigned wanted) {
    std::array<V, 3> t, q;
    for (std::size_t b = 0; b < 3; ++b) {
        const V below = hn::Mul(hn::Sub(links.w[2 * b], v), links.share[2 * b]);
        const V above = hn::Mul(hn::Sub(links.w[2 * b + 1], v), links.share[2 * b + 1]);
        t[b] = hn::Max(hn::Zero(D()), hn::Max(below, above));
        q[b] = hn::IfThenElse(hn::Gt(above, below), links.share[2 * b + 1], links.share[2 * b]);
        q[b] = hn::IfThenElseZero(hn::Gt(t[b], hn::Zero(D())), q[b]);
    }
    for (;;) {
        const V qq = hn::MulAdd(q[0], q[0], hn::MulAdd(q[1], q[1], hn::Mul(q[2], q[2])));
        const V qt = hn::MulAdd(q[0], t[0], hn::MulAdd(q[1], t[1], hn::Mul(q[2], t[2])));
        const V tt = hn::MulAdd(t[0], t[0], hn::MulAdd(t[1], t[1], hn::Mul(t[2], t[2])));
        const V excess = hn::Sub(tt, links.bound);
        const V under_root = hn::NegMulAdd(qq, excess, hn::Mul(qt, qt));
        const V root = hn::Sqrt(hn::Max(under_root, hn::Zero(D())));
        // The division doesn't wait for the root.
        const V x = hn::Mul(hn::Sub(qt, root), hn::Div(hn::Set(D(), 1.0), qq));
        const M left_0 = hn::Gt(hn::Mul(x, q[0]), t[0]), left_1 = hn::Gt(hn::Mul(x, q[1]), t[1]),
                left_2 = hn::Gt(hn::Mul(x, q[2]), t[2]);
        const unsigned left = bits_of_wide(hn::Or(left_0, hn::Or(left_1, left_2))) & wanted;
        if (left == 0) return x;
        const std::array<M, 3> leaves = {left_0, left_1, left_2};
        for (std::size_t b = 0; b < 3; ++b) {
            t[b] = hn::IfThenZeroElse(leaves[b], t[b]);
            q[b] = hn::IfThenZeroElse(leaves[b], q[b]);
        }
    }
}

/// Least positions at or above v that satisfy the bound of the sum. @param over  the lanes in which
/// v doesn't
HWY_INLINE V least_positions(const Links& links, V v, unsigned over) {
    const V lowest = v, one = hn::Set(D(), 1.0);
    const unsigned changes = over;
    do {
        const V guess = hn::Max(hn::Ceil(hn::Add(v, rise(links, v, over))), hn::Add(v, one));
        v = hn::IfThenElse(wide_mask_of(over), guess, v);
        over &= bits_of_wide(hn::Gt(lag_sum(links, v), links.bound));
    } while (over != 0);
    for (;;) {
        const V before = hn::Sub(v, one);
        const M valid = hn::And(hn::Le(lag_sum(links, before), links.bound), hn::Gt(v, lowest));
        const unsigned lower = bits_of_wide(valid) & changes;
        if (lower == 0) return v;
        v = hn::IfThenElse(wide_mask_of(lower), before, v);
    }
}

/// A brick in rows of independent elements.
class SkewedBrick {
  public:
    void load(const RoundedBrick& brick) {
        choose_directions(brick);
        m_moved = brick.start != nullptr;
        m_ready = {};
        m_waiting = {};
        if (brick.is_new) m_waiting = kInside;
        copy_in(brick.w, m_now, m_first);
        if (m_moved) copy_in(brick.start, m_start, m_first);
        for (std::size_t b = 0; b < 3; ++b) load_links(brick, b);
        for (int side = 0; side < 6; ++side) load_face(brick, side);
    }

    void sweep_up() {
        for (int r = kFirstRow; r <= kLastRow; ++r)
            if (m_waiting[std::size_t(r)]) update_row(r);
    }
    void sweep_down() {
        for (int r = kLastRow; r >= kFirstRow; --r)
            if (m_waiting[std::size_t(r)]) update_row(r);
    }
    bool is_waiting() const {
        unsigned any = 0;
        for (const std::uint8_t bits : m_waiting) any |= bits;
        return any != 0;
    }

    void store(Fixed* w) const {
        const std::array<int, 3> step = m_step;
        for (int z = 0; z < kSize; ++z)
            for (int y = 0; y < kSize; ++y) {
                const Fixed* from = m_now.at(m_first + y * step[1] + z * step[2]);
                Fixed* to = w + y * kSize + z * kSlice;
                for (int x = 0; x < kSize; ++x) to[x] = from[x * step[0]];
            }
    }

  private:
    /// The axes are reversed so that the farthest element behind the faces is near the first one.
    void choose_directions(const RoundedBrick& brick) {
        Fixed farthest = kNeverLeads;
        m_reversed = {};
        for (int side = 0; side < 6; ++side) {
            const Fixed* now = brick.faces[std::size_t(side)].now;
            if (!now) continue;
            Fixed highest = now[0];
            for (int n = 1; n < kFace; ++n) highest = std::max(highest, now[n]);
            if (highest <= farthest) continue;
            farthest = highest;
            const int n = int(std::find(now, now + kFace, highest) - now);
            const std::array<bool, 2> high = {n % kSize >= kSize / 2, n / kSize >= kSize / 2};
            const auto b = std::size_t(side / 2);
            m_reversed[b] = side % 2;
            m_reversed[b == 0 ? 1 : 0] = high[0];
            m_reversed[b == 2 ? 1 : 2] = high[1];
        }
        std::array<int, 3> corner{};
        for (std::size_t b = 0; b < 3; ++b) {
            m_step[b] = m_reversed[b] ? -kStep[b] : kStep[b];
            corner[b] = m_reversed[b] ? kSize - 1 : 0;
        }
        m_first = index_of(corner[0], corner[1], corner[2]);
    }

    /// Copies the brick's values, the first one to an index.
    void copy_in(const Fixed* values, Skewed<Fixed>& to, int first) const {
        const std::array<int, 3> step = m_step;
        for (int z = 0; z < kSize; ++z)
            for (int y = 0; y < kSize; ++y) {
                Fixed* row = to.at(first + y * step[1] + z * step[2]);
                const Fixed* from = values + y * kSize + z * kSlice;
                for (int x = 0; x < kSize; ++x) row[x * step[0]] = from[x];
            }
    }

    /// Lags are stored at the link's lower element, in the brick's own or the reversed order. The
    /// last elements have no link inside; the face's follow.
    void load_links(const RoundedBrick& brick, std::size_t b) {
        const Fixed* forward = brick.lags.forward[b];
        const Fixed* backward = brick.lags.backward[b];
        m_two_way[b] = forward != backward;
        if (m_reversed[b]) std::swap(forward, backward);
        const int first = m_first + (m_reversed[b] ? m_step[b] : 0);
        copy_in(forward, m_forward[b].lag, first);
        if (m_two_way[b]) copy_in(backward, m_backward[b].lag, first);
    }

    struct LinkRows {
        Skewed<Fixed> lag;     ///< largest lag of one end behind the other
        Skewed<double> share;  ///< of one unit
    };
    LinkRows& backward(std::size_t b) { return m_two_way[b] ? m_backward[b] : m_forward[b]; }

    void load_face(const RoundedBrick& brick, int side) {
        const RoundedBrick::Face& face = brick.faces[std::size_t(side)];
        const auto b = std::size_t(side / 2), p = std::size_t(b == 0), q = b == 2 ? 1ul : 2ul;
        const bool is_high = (side % 2 != 0) != m_reversed[b];
        const int first = m_first + (side % 2 ? (kSize - 1) * m_step[b] : 0);
        const int behind = is_high ? kStep[b] : -kStep[b];
        Fixed* lag = is_high ? backward(b).lag.at(0) : m_forward[b].lag.at(-kStep[b]);
        const auto for_each = [&, step_p = m_step[p], step_q = m_step[q]](const auto& visit) {
            for (int j = 0; j < kSize; ++j)
                for (int i = 0; i < kSize; ++i)
                    visit(first + i * step_p + j * step_q, i + j * kSize);
        };
        const auto copy = [&](const Fixed* values, Fixed* to) {
            for_each([=](int at, int n) { to[at] = values[n]; });
        };
        if (!face.now) {
            for_each([=](int at, int) { lag[at] = kUnlinked; });
            for_each([to = m_now.at(behind)](int at, int) { to[at] = kNeverLeads; });
            for_each([to = m_start.at(behind)](int at, int) { to[at] = kNeverLeads; });
            return;
        }
        copy(face.lag, lag);
        copy(face.now, m_now.at(behind));
        if (m_moved) copy(face.start, m_start.at(behind));
        if (!face.rose) return;
        for_each([&, now = m_now.at(0)](int at, int n) {
            if (face.now[n] > now[at]) wake(at / kRow, 1u << (at % kRow - kFirstLane));
        });
    }

    static void find_shares(LinkRows& links, int at) {
        for (int p = 0; p < kParts; ++p) {
            const VI lag = hn::Load(DI(), links.lag.at(at + p * kLanes));
            const MI counts =
                hn::And(hn::Gt(lag, hn::Zero(DI())), hn::Lt(lag, hn::Set(DI(), kMaxHalfLimit)));
            const V share = hn::Div(hn::Set(D(), 1.0), hn::PromoteTo(D(), lag));
            const V counted = hn::IfThenElseZero(wide_mask_of(bits_of(counts)), share);
            hn::Store(counted, D(), links.share.at(at + p * kLanes));
        }
    }

    /// Shares of the links at the elements of a row.
    void prepare_links(int row) {
        if (m_ready[std::size_t(row)] & 1) return;
        m_ready[std::size_t(row)] |= 1;
        const int at = row * kRow + kFirstLane;
        for (std::size_t b = 0; b < 3; ++b) {
            find_shares(m_forward[b], at);
            if (m_two_way[b]) find_shares(m_backward[b], at);
        }
        // The link along y from the element before the first lane.
        *m_forward[1].share.at(at - 1) = share_of_unit(*m_forward[1].lag.at(at - 1));
    }

    HWY_INLINE std::array<VI, 6> around(const Skewed<Fixed>& w, int at) const {
        return {hn::LoadU(DI(), w.at(at - kStep[0])), hn::LoadU(DI(), w.at(at + kStep[0])),
                hn::LoadU(DI(), w.at(at - kStep[1])), hn::LoadU(DI(), w.at(at + kStep[1])),
                hn::LoadU(DI(), w.at(at - kStep[2])), hn::LoadU(DI(), w.at(at + kStep[2]))};
    }
    static HWY_INLINE void promote(const std::array<VI, 6>& w, Links& links) {
        for (std::size_t s = 0; s < 6; ++s) links.w[s] = hn::PromoteTo(D(), w[s]);
    }

    void prepare_bounds(int row) {
        if (!m_moved || m_ready[std::size_t(row)] & 2) return;
        m_ready[std::size_t(row)] |= 2;
        for (int p = 0; p < kParts; ++p) {
            const int at = row * kRow + kFirstLane + p * kLanes;
            Links links;
            promote(around(m_start, at), links);
            load_shares(links, at);
            const V v = hn::PromoteTo(D(), hn::Load(DI(), m_start.at(at)));
            hn::Store(hn::Max(hn::Set(D(), 1.0), lag_sum(links, v)), D(), m_bound.at(at));
        }
    }

    HWY_INLINE void load_shares(Links& links, int at) {
        for (std::size_t b = 0; b < 3; ++b) {
            links.share[2 * b] = hn::LoadU(D(), m_forward[b].share.at(at - kStep[b]));
            links.share[2 * b + 1] = hn::LoadU(D(), backward(b).share.at(at));
        }
    }

    void update_row(int row) {
        const auto r = std::size_t(row);
        const unsigned waiting = m_waiting[r] & kInside[r];
        m_waiting[r] = 0;
        if (waiting == 0) return;
        prepare_links(row - kLayer);
        prepare_links(row - 1);
        prepare_links(row);
        prepare_bounds(row);
        for (int p = 0; p < kParts; ++p)
            if (waiting >> p * kLanes & kPartBits) update_part(row, p);
    }

    HWY_INLINE void update_part(int row, int p) {
        const int at = row * kRow + kFirstLane + p * kLanes;
        const unsigned inside = kInside[std::size_t(row)] >> p * kLanes & kPartBits;
        const VI old = hn::Load(DI(), m_now.at(at));
        const std::array<VI, 6> w = around(m_now, at);
        VI low = old;
        for (std::size_t b = 0; b < 3; ++b) {
            const VI below = hn::LoadU(DI(), m_forward[b].lag.at(at - kStep[b]));
            const VI above = hn::LoadU(DI(), backward(b).lag.at(at));
            low = hn::Max(low, hn::Max(hn::Sub(w[2 * b], below), hn::Sub(w[2 * b + 1], above)));
        }
        Links links;
        promote(w, links);
        load_shares(links, at);
        links.bound = m_moved ? hn::Load(D(), m_bound.at(at)) : hn::Set(D(), 1.0);
        const V v = hn::PromoteTo(D(), low);
        const unsigned over = bits_of_wide(hn::Gt(lag_sum(links, v), links.bound)) & inside;
        const VI now = over == 0 ? low : hn::DemoteTo(DI(), least_positions(links, v, over));
        const unsigned rose = bits_of(hn::Gt(now, old)) & inside;
        if (rose == 0) return;
        hn::Store(hn::IfThenElse(mask_of(rose), now, old), DI(), m_now.at(at));
        const auto led = [&](std::size_t side) {
            return (bits_of(hn::Gt(now, w[side])) & rose) << p * kLanes;
        };
        wake(row - 1, led(0) | led(2) >> 1);
        wake(row + 1, led(1) | led(3) << 1);
        wake(row - kLayer, led(4));
        wake(row + kLayer, led(5));
    }
    void wake(int row, unsigned lanes) {
        std::uint8_t& waiting = m_waiting[std::size_t(row)];
        waiting = std::uint8_t(waiting | (lanes & kInside[std::size_t(row)]));
    }

    Skewed<Fixed> m_now;                            ///< raised so far
    Skewed<Fixed> m_start;                          ///< before the push, if that is not 0
    std::array<LinkRows, 3> m_forward, m_backward;  ///< the first alone unless m_two_way
    Skewed<double> m_bound;                         ///< 1 unless m_moved
    std::array<std::uint8_t, kRowCount> m_waiting;  ///< lanes in which a neighbour rose
    std::array<std::uint8_t, kRowCount> m_ready;    ///< 1: shares, 2: bounds
    std::array<bool, 3> m_reversed;                 ///< [axis]
    std::array<int, 3> m_step;                      ///< from an element to the next one on an axis
    int m_first;
    std::array<bool, 3> m_two_way;  ///< [axis]: lags differ by direction
    bool m_moved;
};

void relax(const RoundedBrick& brick) {
    // A thread-local object itself would be looked up in each function.
    static thread_local const auto memory = std::make_unique<SkewedBrick>();
    SkewedBrick& skewed = *memory;
    skewed.load(brick);
    for (bool up = true; skewed.is_waiting(); up = !up) {
        if (up)
            skewed.sweep_up();
        else
            skewed.sweep_down();
    }
    skewed.store(brick.w);
}

RelaxRounded relax_of_target() {
    return relax;
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(relax_of_target);
RelaxRounded vector_relax_rounded() {
    return HWY_DYNAMIC_DISPATCH(relax_of_target)();
}
}  // namespace pliant
#endif
