// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of a drag with vector instructions, once for each instruction set; the
// program chooses at run time. The plain twin is drag_plain.cpp.

#include <algorithm>
#include <array>
#include <cstddef>

#include "propagate/drag_kernel.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "propagate/drag_vector.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

MoveDragged move_of_target() {
    return plain_move_dragged();
}
LookAtBrick look_of_target() {
    return plain_look_at_fields();
}

#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kLine = 16;
using D = hn::CappedTag<Fixed, kLine>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr int kLanes = int(hn::MaxLanes(D()));

constexpr int kParts = kLine / kLanes;  ///< vectors in a line

struct Line {
    V part[kParts];
};
HWY_INLINE Line load_line(const Fixed* from) {
    Line line;
    for (int p = 0; p < kParts; ++p) line.part[p] = hn::Load(D(), from + p * kLanes);
    return line;
}

/// One component. A shrinking one is read with all bits flipped, which reverses its order (~u = −u
/// − 1), so that it rises as well: min(u, left − raised) = ~max(~u, raised − (left + 1)).
struct Rise {
    Fixed* u;
    const Fixed* raised;
    const Fixed *next_u, *next_raised;
    V left, flip, lowest;
    V low;  ///< over all lines read, flipped

    HWY_INLINE explicit Rise(const DraggedComponent& c)
        : u(c.u),
          raised(c.raised),
          next_u(c.next_u),
          next_raised(c.next_raised),
          left(hn::Set(D(), c.left + (c.sign < 0))),
          flip(hn::Set(D(), c.sign < 0 ? -1 : 0)),
          lowest(hn::Set(D(), c.lowest - (c.sign < 0))),
          low(hn::Set(D(), INT32_MAX)) {}
};

/// Moves a line. @returns the number of moved elements; −1 if it was skipped
template <bool kOneField, std::size_t kCount>
HWY_INLINE int move_line(std::array<Rise, kCount>& rises, int n) {
    for (std::size_t c = 0; c < kCount; ++c) {
        if (!kOneField || c == 0) __builtin_prefetch(rises[c].next_raised + n);
        __builtin_prefetch(rises[c].next_u + n, 1);
    }
    Line position[kCount];
    for (std::size_t c = 0; c < kCount; ++c)
        position[c] = kOneField && c > 0 ? position[0] : load_line(rises[c].raised + n);
    M may = hn::FirstN(D(), 0);
    for (std::size_t c = 0; c < kCount; ++c)
        for (V& part : position[c].part) {
            part = hn::Sub(part, rises[c].left);
            may = hn::Or(may, hn::Gt(part, rises[c].lowest));
        }
    if (hn::AllFalse(D(), may)) return -1;
    // All reads come before any write: arrays of other components may lie 4 KiB apart, and
    // processors then mistake a read for one of the data just written.
    Line before[kCount];
    for (std::size_t c = 0; c < kCount; ++c) before[c] = load_line(rises[c].u + n);
    int moved = 0;
    for (int p = 0; p < kParts; ++p) {
        M rose = hn::FirstN(D(), 0);
        for (std::size_t c = 0; c < kCount; ++c) {
            Rise& rise = rises[c];
            const V old = hn::Xor(before[c].part[p], rise.flip);
            const V now = hn::Max(old, position[c].part[p]);
            rose = hn::Or(rose, hn::Gt(now, old));
            rise.low = hn::Min(rise.low, now);
            hn::Store(hn::Xor(now, rise.flip), D(), rise.u + n + p * kLanes);
        }
        moved += int(hn::CountTrue(D(), rose));
    }
    return moved;
}

/// Likewise, with u from the turns.
template <std::size_t kCount>
HWY_INLINE int move_known_line(std::array<Rise, kCount>& rises,
                               std::span<const DraggedComponent> components, int n) {
    const D d;
    __builtin_prefetch(rises[0].next_raised + n);
    const Line raised = load_line(rises[0].raised + n);
    M may = hn::FirstN(d, 0);
    for (const V part : raised.part)
        for (const Rise& rise : rises)
            may = hn::Or(may, hn::Gt(hn::Sub(part, rise.left), rise.lowest));
    if (hn::AllFalse(d, may)) return -1;
    int moved = 0;
    for (int p = 0; p < kParts; ++p) {
        M any = hn::FirstN(d, 0);
        for (std::size_t c = 0; c < kCount; ++c) {
            Rise& rise = rises[c];
            V u = hn::Zero(d);
            for (const DragTurn turn : components[c].turns)
                u = turn.sign > 0 ? hn::Max(u, hn::Sub(raised.part[p], hn::Set(d, turn.left)))
                                  : hn::Min(u, hn::Sub(hn::Set(d, turn.left), raised.part[p]));
            const V old = hn::Xor(u, rise.flip);
            const V now = hn::Max(old, hn::Sub(raised.part[p], rise.left));
            const M rose = hn::Gt(now, old);
            rise.low = hn::Min(rise.low, now);
            if (hn::AllFalse(d, rose)) continue;
            any = hn::Or(any, rose);
            hn::Stream(hn::Xor(now, rise.flip), d, rise.u + n + p * kLanes);
        }
        moved += int(hn::CountTrue(d, any));
    }
    return moved;
}

template <bool kOneField, bool kKnown, std::size_t kCount>
DraggedBrick move_all(std::array<Rise, kCount> rises, std::span<DraggedComponent> components,
                      int count) {
    DraggedBrick result;
    for (int n = 0; n < count; n += kLine) {
        int moved;
        if constexpr (kKnown)
            moved = move_known_line(rises, components, n);
        else
            moved = move_line<kOneField>(rises, n);
        result.has_wide_bounds |= moved < 0;
        result.moved += moved < 0 ? 0 : moved;
    }
    // Skipped lines are not below the previous lowest.
    if (result.has_wide_bounds) return result;
    for (std::size_t c = 0; c < kCount; ++c)
        components[c].lowest =
            hn::GetLane(hn::MinOfLanes(D(), rises[c].low)) + (components[c].sign < 0);
    return result;
}

template <bool kKnown>
DraggedBrick move_some(std::span<DraggedComponent> c, int count) {
    if (c.size() == 1) return move_all<false, kKnown, 1>({Rise(c[0])}, c, count);
    if (c.size() == 2) return move_all<false, kKnown, 2>({Rise(c[0]), Rise(c[1])}, c, count);
    const std::array<Rise, 3> rises = {Rise(c[0]), Rise(c[1]), Rise(c[2])};
    const bool one_field = c[0].raised == c[1].raised && c[1].raised == c[2].raised;
    return one_field && !kKnown ? move_all<true, false, 3>(rises, c, count)
                                : move_all<false, kKnown, 3>(rises, c, count);
}

DraggedBrick move(std::span<DraggedComponent> c, int count, bool known) {
    return known ? move_some<true>(c, count) : move_some<false>(c, count);
}

/// Variant for one array for all fields, and a brick at rest.
LookAtFields look_at_one(const FieldsOfBrick& fields, int count) {
    const D d;
    const V above = hn::Set(d, -*std::max_element(fields.ahead.begin(), fields.ahead.end()));
    V high = hn::Set(d, INT32_MIN);
    LookAtFields found{{}, 0};
    for (int n = 0; n < count; n += kLanes) {
        const V value = hn::Load(d, fields.of[0] + n);
        high = hn::Max(high, value);
        found.reached += int(hn::CountTrue(d, hn::Gt(value, above)));
    }
    found.highest.fill(hn::GetLane(hn::MaxOfLanes(d, high)));
    return found;
}

LookAtFields look(const FieldsOfBrick& fields, int count) {
    const D d;
    const bool one = std::all_of(fields.of.begin(), fields.of.end(),
                                 [&](const Fixed* field) { return field == fields.of[0]; });
    if (one && fields.at_rest) return look_at_one(fields, count);
    V high[6], ahead[6];
    for (std::size_t k = 0; k < 6; ++k) {
        high[k] = hn::Set(d, INT32_MIN);
        ahead[k] = hn::Set(d, fields.ahead[k]);
    }
    LookAtFields found{{}, 0};
    for (int n = 0; n < count; n += kLanes) {
        M reached = hn::FirstN(d, 0);
        for (std::size_t a = 0; a < 3; ++a) {
            const V u = hn::Load(d, fields.u[a] + n);
            const V down = hn::Load(d, fields.of[2 * a] + n);
            const V up = hn::Load(d, fields.of[2 * a + 1] + n);
            high[2 * a] = hn::Max(high[2 * a], down);
            high[2 * a + 1] = hn::Max(high[2 * a + 1], up);
            const V below = hn::Sub(hn::Neg(u), ahead[2 * a]);
            reached = hn::Or(reached, hn::Gt(down, below));
            reached = hn::Or(reached, hn::Gt(up, hn::Sub(u, ahead[2 * a + 1])));
        }
        found.reached += int(hn::CountTrue(d, reached));
    }
    for (std::size_t k = 0; k < 6; ++k) found.highest[k] = hn::GetLane(hn::MaxOfLanes(d, high[k]));
    return found;
}

MoveDragged move_of_target() {
    return move;
}
LookAtBrick look_of_target() {
    return look;
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(move_of_target);
HWY_EXPORT(look_of_target);
LookAtBrick vector_look_at_fields() {
    return HWY_DYNAMIC_DISPATCH(look_of_target)();
}
void finish_moves() {
    hwy::FlushStream();
}
MoveDragged vector_move_dragged() {
    return HWY_DYNAMIC_DISPATCH(move_of_target)();
}
}  // namespace pliant
#endif
