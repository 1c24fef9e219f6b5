// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Along a ray, the trilinear field of one cell is a cubic. It is split at its extrema into monotone
// pieces, each with at most one zero. The first piece whose ends lie on different sides of zero
// contains the first crossing.
//
// "Above" means ≥ 0 everywhere. The ray's side before the cell is an input, so that rounding can't
// lose a crossing on a cell's face: if the cubic starts on the other side, the crossing was on the
// face.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace pliant::render {

struct Cubic {
    double c0, c1, c2, c3;

    double operator()(double s) const { return ((c3 * s + c2) * s + c1) * s + c0; }
    double slope(double s) const { return (3 * c3 * s + 2 * c2) * s + c1; }
};

/// Root of a cubic between a and b, where it is monotone and changes sign: Newton's method
/// safeguarded by bisection, to adjacent numbers.
inline double bracketed_root(const Cubic& f, double a, double b) {
    constexpr int kMaxSteps = 80;
    constexpr double kTolerance = 1e-15;  // of the ray's part in the cell, 0…1
    const bool above_a = f(a) >= 0;
    double s = 0.5 * (a + b);
    for (int step = 0; step < kMaxSteps && b - a > kTolerance; ++step) {
        const double value = f(s);
        if (value == 0) return s;
        ((value >= 0) == above_a ? a : b) = s;
        const double newton = s - value / f.slope(s);
        const double next = newton > a && newton < b ? newton : 0.5 * (a + b);
        if (std::abs(next - s) <= kTolerance) return next;
        s = next;
    }
    return s;
}

/// Zeros of the cubic's slope in 0…1, ascending, then 1.
struct MonotonePieces {
    std::array<double, 3> ends;
    int count;
};

inline MonotonePieces monotone_pieces(const Cubic& f) {
    MonotonePieces pieces{{1, 1, 1}, 1};
    const double a = 3 * f.c3;
    const double b = f.c2;  // half of the slope's linear coefficient
    const double discriminant = b * b - a * f.c1;
    if (!(discriminant > 0)) return pieces;
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    double first = a != 0 ? q / a : 2;  // 2: not in 0…1
    double second = q != 0 ? f.c1 / q : 2;
    if (first > second) std::swap(first, second);
    pieces.count = 0;
    if (first > 0 && first < 1) pieces.ends[std::size_t(pieces.count++)] = first;
    if (second > 0 && second < 1) pieces.ends[std::size_t(pieces.count++)] = second;
    pieces.ends[std::size_t(pieces.count++)] = 1;
    return pieces;
}

/// First s in 0…1 at which the cubic crosses to the requested side of zero.
/// @param[in,out] above  the side before s = 0; afterwards the side at the hit or at s = 1
inline std::optional<double> first_turn(const Cubic& f, bool to_above, bool& above) {
    const auto turns = [&](bool now_above) {
        const bool turned = now_above != above && now_above == to_above;
        above = now_above;
        return turned;
    };
    if (turns(f.c0 >= 0)) return 0.0;
    const MonotonePieces pieces = monotone_pieces(f);
    double begin = 0;
    for (int i = 0; i < pieces.count; ++i) {
        const double end = pieces.ends[std::size_t(i)];
        if (turns(f(end) >= 0)) return bracketed_root(f, begin, end);
        begin = end;
    }
    return std::nullopt;
}

}  // namespace pliant::render
