// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Eight elements of a row at a time, of which every other has the colour: four lanes. Uses the
// compilers' own vector types, which map to any instruction set. Each file that includes this
// compiles it separately: relax_kernel.cpp for any processor, relax_kernel_avx2.cpp for AVX2. Both
// give the same bits.

#pragma once

#include "relax/relax_kernel.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#ifdef PLIANT_RELAX_FOR_AVX2
#include <immintrin.h>
#endif

// Vectors are passed between inlined functions only, so the calling convention doesn't matter.
#pragma GCC diagnostic ignored "-Wpsabi"
#define PLIANT_INLINE inline __attribute__((always_inline))

#ifdef PLIANT_RELAX_FOR_AVX2
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
#endif

namespace pliant {
namespace {

using Lanes = Fixed __attribute__((vector_size(16)));
using Halves = std::int64_t __attribute__((vector_size(16)));
using Doubles = double __attribute__((vector_size(32)));
using Row8 = Fixed __attribute__((vector_size(32)));
using Weights8 = std::uint16_t __attribute__((vector_size(16)));

constexpr double kFarthestStep = 1 << 29;  ///< [units]: u and twice a step still fit

PLIANT_INLINE Lanes smaller(Lanes a, Lanes b) {
    return a < b ? a : b;
}
PLIANT_INLINE Lanes larger(Lanes a, Lanes b) {
    return a > b ? a : b;
}
#ifdef PLIANT_RELAX_FOR_AVX2
// GCC converts half vectors only.
PLIANT_INLINE Doubles to_doubles(Lanes a) {
    return Doubles(_mm256_cvtepi32_pd(__m128i(a)));
}
/// Rounds towards zero.
PLIANT_INLINE Lanes to_lanes(Doubles a) {
    return Lanes(_mm256_cvttpd_epi32(__m256d(a)));
}
PLIANT_INLINE Doubles smaller(Doubles a, Doubles b) {
    return Doubles(_mm256_min_pd(__m256d(a), __m256d(b)));
}
PLIANT_INLINE Doubles larger(Doubles a, Doubles b) {
    return Doubles(_mm256_max_pd(__m256d(a), __m256d(b)));
}
#else
PLIANT_INLINE Doubles smaller(Doubles a, Doubles b) {
    return a < b ? a : b;
}
PLIANT_INLINE Doubles larger(Doubles a, Doubles b) {
    return a > b ? a : b;
}
PLIANT_INLINE Doubles to_doubles(Lanes a) {
    return __builtin_convertvector(a, Doubles);
}
/// Rounds towards zero.
PLIANT_INLINE Lanes to_lanes(Doubles a) {
    return __builtin_convertvector(a, Lanes);
}
#endif
PLIANT_INLINE bool any(Lanes mask) {
    const auto halves = Halves(mask);
    return (halves[0] | halves[1]) != 0;
}

/// Every other of up to eight values, starting at the first or the second.
template <int Phase, bool Whole>
PLIANT_INLINE Lanes every_other(const Fixed* row, int count) {
    Row8 values{};
    std::memcpy(&values, row, Whole ? sizeof values : std::size_t(count) * sizeof *row);
    return __builtin_shufflevector(values, values, Phase, Phase + 2, Phase + 4, Phase + 6);
}
template <int Phase, bool Whole>
PLIANT_INLINE Doubles every_other(const std::uint16_t* row, int count) {
    Weights8 values{};
    std::memcpy(&values, row, Whole ? sizeof values : std::size_t(count) * sizeof *row);
    const auto chosen =
        __builtin_shufflevector(values, values, Phase, Phase + 2, Phase + 4, Phase + 6);
    return to_doubles(__builtin_convertvector(chosen, Lanes));
}
template <int Phase>
PLIANT_INLINE Doubles every_other(const double* row, int count) {
    Doubles values{};
    for (int k = 0; k < 4; ++k)
        if (Phase + 2 * k < count) values[k] = row[Phase + 2 * k];
    return values;
}

/// The six links and neighbours of a row, each as a pointer to the row's first element: along −x,
/// +x, −y, +y, −z, +z.
struct Rows {
    std::array<std::array<const Fixed*, 6>, 3> neighbour;  ///< by component; from −y on
    std::array<std::array<Fixed, 2>, 3> ends;  ///< elements before and after the row, by component
    std::array<int, 6> link;                   ///< index of the first element's link on each side
};

/// First link of a brick along each axis.
struct LinkArrays {
    explicit LinkArrays(const BrickLinks& links) {
        for (std::size_t b = 0; b < 3; ++b) {
            shear[b] = links.shear[b].data(), weight[b] = links.weight[b].data();
            stretch[b] = links.stretch[b].data(), compress[b] = links.compress[b].data();
        }
    }
    std::array<const Fixed*, 3> shear, stretch, compress;
    std::array<const std::uint16_t*, 3> weight;
};

/// Neighbours along −x or +x of every other of up to eight elements. At the ends of the row they
/// are in other bricks. (A copy of the row with its ends would be read right after its writes: a
/// stall.)
template <int Phase, bool Whole>
PLIANT_INLINE Lanes beside_in_row(const RelaxedBrick& brick, const Rows& rows, int a, bool high,
                                  int n, int x, int count) {
    const Fixed* row = brick.u[std::size_t(a)] + n;
    if (Whole && Phase != int(high)) {
        // All of them are among the eight.
        return every_other<1 - Phase, Whole>(row, count);
    }
    if (Whole) {
        Row8 values;
        std::memcpy(&values, row, sizeof values);
        if (high) {
            Lanes lanes = __builtin_shufflevector(values, values, 2, 4, 6, 0);
            lanes[3] = x + 8 < brick.size ? row[8] : rows.ends[std::size_t(a)][1];
            return lanes;
        }
        Lanes lanes = __builtin_shufflevector(values, values, 0, 1, 3, 5);
        lanes[0] = x > 0 ? row[-1] : rows.ends[std::size_t(a)][0];
        return lanes;
    }
    Lanes lanes{};
    for (int k = 0; k < 4; ++k) {
        const int at = Phase + 2 * k + (high ? 1 : -1);
        if (Phase + 2 * k >= count) continue;
        lanes[k] = x + at < 0             ? rows.ends[std::size_t(a)][0]
                   : x + at >= brick.size ? rows.ends[std::size_t(a)][1]
                                          : row[at];
    }
    return lanes;
}

struct Moved {
    Lanes from[3], to[3];
};

/// Property of the links of a brick: limits equal in both directions.
struct AnyKind {
    bool symmetric;
};
/// Known to the compiler. @see AnyKind
template <bool Symmetric>
struct Kind {
    static constexpr bool symmetric = Symmetric;
};

/// The step rounded to the nearest unit, plus over-relaxation: see relax_kernel.h. Adding slightly
/// less than a half, away from zero, and truncating rounds halves towards zero: other fractions are
/// at least 2⁻²⁰ away from a half, since no sum of weights is above 2¹⁹.
PLIANT_INLINE Lanes step_of(Doubles x, Lanes e, double beyond) {
    constexpr double kAlmost = 0.5 - 0x1p-24, kMore = 0.5 + 0x1p-24;
    const Doubles far = Doubles{} + kFarthestStep;
    x = smaller(larger(x, -far), far);
    const Doubles zero{}, almost = zero + kAlmost, half = zero + 0.5;
    // A half, and towards rest: round up instead. (x·e < 0: never true for e = 0.)
    const auto to_rest = (x * x == half * half) & (x * to_doubles(e) < zero);
    const Doubles size = to_rest ? zero + kMore : almost;
    return to_lanes(x + (x < zero ? -size : size)) + to_lanes(x * beyond);
}

template <int Phase, bool Whole, class Kind>
PLIANT_INLINE void move_component(Kind kind, const RelaxedBrick& brick, const LinkArrays& links,
                                  const Rows& rows, int a, int n, int x, int count,
                                  const Doubles (&weights)[6], Doubles weight_sum, Lanes imprint,
                                  Doubles force, double beyond, Moved& moved) {
    const Lanes u = moved.from[a];
    Lanes lowest = Lanes{} + INT32_MIN, highest = Lanes{} + INT32_MAX;
#pragma GCC unroll 6
    for (std::size_t side = 0; side < 6; ++side) {
        const Lanes v =
            side < 2 ? beside_in_row<Phase, Whole>(brick, rows, a, side == 1, n, x, count)
                     : every_other<Phase, Whole>(rows.neighbour[std::size_t(a)][side] + x, count);
        // Largest distance of this element below and above its neighbour.
        Lanes below, above;
        if (kind.symmetric || int(side / 2) != a) {
            below = above =
                every_other<Phase, Whole>(links.shear[side / 2] + rows.link[side] + x, count);
        } else {
            const Lanes stretch =
                every_other<Phase, Whole>(links.stretch[side / 2] + rows.link[side] + x, count);
            const Lanes compress =
                every_other<Phase, Whole>(links.compress[side / 2] + rows.link[side] + x, count);
            below = side % 2 ? stretch : compress;
            above = side % 2 ? compress : stretch;
        }
        lowest = larger(lowest, v - below);
        highest = smaller(highest, v + above);
        force += weights[side] * to_doubles(v - u);
    }
    // Links outside of their limits must not get worse: standing still is always allowed.
    lowest = smaller(lowest, u);
    highest = larger(highest, u);
    const Lanes to = u + step_of(force / weight_sum, u - imprint, beyond);
    moved.to[a] = smaller(larger(to, lowest), highest);
}

template <int Phase>
PLIANT_INLINE Lanes flags_of(const std::uint8_t* flags, int count) {
    Lanes mask{};
    for (int k = 0; k < 4; ++k)
        if (Phase + 2 * k < count && flags[Phase + 2 * k]) mask[k] = -1;
    return mask;
}

/// Writes lanes back to the positions of every_other.
template <int Phase, bool Whole>
PLIANT_INLINE void write_every_other(Lanes lanes, Fixed* row, int count) {
    if (!Whole) {
        for (int k = 0; k < 4; ++k)
            if (Phase + 2 * k < count) row[Phase + 2 * k] = lanes[k];
        return;
    }
    Row8 old;
    std::memcpy(&old, row, sizeof old);
    const Row8 wide = __builtin_shufflevector(lanes, lanes, 0, 0, 1, 1, 2, 2, 3, 3);
    const Row8 mixed = Phase ? __builtin_shufflevector(old, wide, 0, 9, 2, 11, 4, 13, 6, 15)
                             : __builtin_shufflevector(old, wide, 8, 1, 10, 3, 12, 5, 14, 7);
    std::memcpy(row, &mixed, sizeof mixed);
}

/// @param n  index of the first of the eight
template <int Phase>
void ask_guard(const RelaxedBrick& brick, int n, Moved& moved) {
    for (int k = 0; k < 4; ++k) {
        const Vec3<Fixed> from{moved.from[0][k], moved.from[1][k], moved.from[2][k]};
        Vec3<Fixed> to{moved.to[0][k], moved.to[1][k], moved.to[2][k]};
        if (to == from) continue;
        to = brick.guard->admit(n + Phase + 2 * k, from, to);
        for (int a = 0; a < 3; ++a) moved.to[a][k] = to[a];
    }
}

/// Moves the elements of one colour among eight. @param n  index of the first of the eight
template <int Phase, bool Whole, class Kind>
PLIANT_INLINE Lanes move_eight(Kind kind, const RelaxedBrick& brick, const LinkArrays& links,
                               const Rows& rows, int n, int x, int count, double beyond) {
    Moved moved;
    Lanes imprint[3]{};
    for (std::size_t a = 0; a < 3; ++a) {
        moved.from[a] = every_other<Phase, Whole>(brick.u[a] + n, count);
        if (brick.imprint[a]) imprint[a] = every_other<Phase, Whole>(brick.imprint[a] + n, count);
    }
    // Elements at rest stay: only displaced ones relax.
    Lanes stays =
        (moved.from[0] | moved.from[1] | moved.from[2] | imprint[0] | imprint[1] | imprint[2]) == 0;
    if (brick.held) stays |= flags_of<Phase>(brick.held + n, count);
    if (!brick.links->fixed.empty()) stays |= flags_of<Phase>(brick.links->fixed.data() + n, count);
    if (!any(~stays)) return Lanes{};
    Doubles weights[6], sum{};
#pragma GCC unroll 6
    for (std::size_t side = 0; side < 6; ++side) {
        weights[side] =
            every_other<Phase, Whole>(links.weight[side / 2] + rows.link[side] + x, count);
        sum += weights[side];
    }
    sum = sum > 0.0 ? sum : Doubles{} + 1.0;
    Lanes changed{};
#pragma GCC unroll 3
    for (int a = 0; a < 3; ++a) {
        const double* pull = brick.pull[std::size_t(a)];
        const Doubles force = pull ? every_other<Phase>(pull + n, count) : Doubles{};
        move_component<Phase, Whole>(kind, brick, links, rows, a, n, x, count, weights, sum,
                                     imprint[a], force, beyond, moved);
        moved.to[a] = stays ? moved.from[a] : moved.to[a];
        changed |= moved.to[a] != moved.from[a];
    }
    if (!any(changed)) return Lanes{};
    Doubles squared{};
    for (const Lanes to : moved.to) squared += to_doubles(to) * to_doubles(to);
    const auto beyond_radius = squared > brick.free_radius_squared;
    const bool ask = brick.guard_all ||
                     (beyond_radius[0] | beyond_radius[1] | beyond_radius[2] | beyond_radius[3]);
    if (ask) {
        Moved asked = moved;  // a copy, so that `moved` can stay in registers
        ask_guard<Phase>(brick, n, asked);
        moved = asked;
    }
    Lanes largest{};
    for (std::size_t a = 0; a < 3; ++a) {
        write_every_other<Phase, Whole>(moved.to[a], brick.u[a] + n, count);
        const Lanes step = moved.to[a] - moved.from[a];
        largest = larger(largest, larger(step, -step));
    }
    return largest;
}

/// Substitute for rows of missing bricks.
alignas(64) constexpr Fixed kRowAtRest[64] = {};

template <bool Whole, class Kind>
PLIANT_INLINE Lanes move_row(Kind kind, const RelaxedBrick& brick, const LinkArrays& links, int y,
                             int z, int phase, double beyond) {
    const int size = brick.size, row = size * (y + size * z);
    const int size_of_slice = size * size;
    Rows rows;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto& side = brick.side[a];
        const Fixed* u = brick.u[a];
        rows.ends[a] = {side[0] ? side[0][row + size - 1] : 0, side[1] ? side[1][row] : 0};
        const auto beside = [&](std::size_t s, int offset) {
            return side[s] ? side[s] + row + offset : kRowAtRest;
        };
        rows.neighbour[a] = {
            nullptr,
            nullptr,
            y > 0 ? u + row - size : beside(2, size_of_slice - size),
            y + 1 < size ? u + row + size : beside(3, size - size_of_slice),
            z > 0 ? u + row - size_of_slice : beside(4, (size - 1) * size_of_slice),
            z + 1 < size ? u + row + size_of_slice : beside(5, (1 - size) * size_of_slice)};
    }
    for (int b = 0; b < 3; ++b) {
        const Vec3i strides = link_strides(size, b);
        const int below = y * strides.y + z * strides.z;
        rows.link[std::size_t(2 * b)] = below;
        rows.link[std::size_t(2 * b + 1)] = below + strides[b];
    }
    Lanes largest{};
    for (int x = 0; x < size; x += 8) {
        const int count = std::min(8, size - x);
        const Lanes moved =
            phase ? move_eight<1, Whole>(kind, brick, links, rows, row + x, x, count, beyond)
                  : move_eight<0, Whole>(kind, brick, links, rows, row + x, x, count, beyond);
        largest = larger(largest, moved);
    }
    return largest;
}

template <bool Whole, class Kind>
PLIANT_INLINE Fixed move_rows(Kind kind, const RelaxedBrick& brick, int colour, double beyond) {
    const LinkArrays links(*brick.links);
    Lanes largest{};
    for (int z = 0; z < brick.size; ++z)
        for (int y = 0; y < brick.size; ++y) {
            const int phase = (brick.parity + y + z + colour) & 1;
            largest = larger(largest, move_row<Whole>(kind, brick, links, y, z, phase, beyond));
        }
    return std::max({largest[0], largest[1], largest[2], largest[3]});
}

/// Compiled for each kind where it pays: with AVX2, for bricks of the usual sizes.
Fixed move_brick(const RelaxedBrick& brick, int colour, double beyond) {
    const AnyKind kind{brick.links->stretch[0].empty()};
    if (brick.size % 8 != 0) return move_rows<false>(kind, brick, colour, beyond);
#ifdef PLIANT_RELAX_FOR_AVX2
    return kind.symmetric ? move_rows<true>(Kind<true>{}, brick, colour, beyond)
                          : move_rows<true>(Kind<false>{}, brick, colour, beyond);
#else
    return move_rows<true>(kind, brick, colour, beyond);
#endif
}

}  // namespace
}  // namespace pliant

#ifdef PLIANT_RELAX_FOR_AVX2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
