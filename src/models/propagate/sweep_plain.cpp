// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of the sweep as plain loops: the readable twin of sweep_vector.cpp.

#include <algorithm>

#include "propagate/sweep_kernels.h"

namespace pliant {
namespace {

void gather(const Fixed* column, const MaterialId* ids, int count, Fixed* out) {
    for (int n = 0; n < count; ++n) out[n] = column[ids[n]];
}

int stride_of(int size, int axis) {
    return axis == 0 ? 1 : axis == 1 ? size : size * size;
}

void add_halves(const Fixed* halves, int size, int axis, Fixed* lags) {
    const int stride = stride_of(size, axis);
    for (int n = 0; n + stride < size * size * size; ++n) lags[n] = halves[n] + halves[n + stride];
}

void arrange_x(Fixed*, int) {}

/// to = max(to, value). @returns whether it rose
bool raise(Fixed& to, Fixed value) {
    if (value <= to) return false;
    to = value;
    return true;
}

/// One pass over the links along an axis, up and down, of the lines that start at the elements
/// `base` + p·step_p + q·step_q. @param forward, backward  the lag of the link at an element's
/// index
template <class Forward, class Backward>
bool sweep_axis(Fixed* w, int size, int axis, const Forward& forward, const Backward& backward) {
    const int stride = stride_of(size, axis);
    const int step_p = axis == 0 ? size : 1, step_q = axis == 2 ? size : size * size;
    bool changed = false;
    for (int q = 0; q < size; ++q)
        for (int p = 0; p < size; ++p) {
            const int first = p * step_p + q * step_q, last = first + (size - 1) * stride;
            for (int n = first; n < last; n += stride)
                changed |= raise(w[n + stride], w[n] - forward(n));
            for (int n = last - stride; n >= first; n -= stride)
                changed |= raise(w[n], w[n + stride] - backward(n));
        }
    return changed;
}

void relax(Fixed* w, int size, const InsideLags& lags, std::uint32_t) {
    for (bool changed = true; changed;) {
        changed = false;
        for (std::size_t axis = 0; axis < 3; ++axis)
            changed |= sweep_axis(
                w, size, int(axis), [&](int n) { return lags.forward[axis][n]; },
                [&](int n) { return lags.backward[axis][n]; });
    }
}

void relax_uniform(Fixed* w, int size, const UniformLags& lags, std::uint32_t) {
    // One pass suffices: if all links of an axis are equal, a shortest path may take all its steps
    // along x first, then along y, then along z.
    for (std::size_t axis = 0; axis < 3; ++axis)
        sweep_axis(
            w, size, int(axis), [&](int) { return lags.forward[axis]; },
            [&](int) { return lags.backward[axis]; });
}

/// Calls visit(element on the side, element behind the neighbour's opposite side, index in the
/// face).
template <class Visit>
void for_each_at_face(int size, int side, const Visit& visit) {
    const int axis = side / 2, stride = stride_of(size, axis);
    const int step_p = axis == 0 ? size : 1, step_q = axis == 2 ? size : size * size;
    const int own = side % 2 ? (size - 1) * stride : 0, behind = (size - 1) * stride - own;
    for (int q = 0; q < size; ++q)
        for (int p = 0; p < size; ++p)
            visit(own + p * step_p + q * step_q, behind + p * step_p + q * step_q, p + size * q);
}

void copy_face(const Fixed* values, int size, int side, Fixed* out) {
    for_each_at_face(size, side, [&](int own, int, int n) { out[n] = values[own]; });
}

void add_face(const Fixed* column, const MaterialId* ids, int size, int side, Fixed* out) {
    for_each_at_face(size, side, [&](int own, int, int n) { out[n] += column[ids[own]]; });
}

std::uint32_t take(Fixed* w, int size, int side, const Fixed* neighbour, const Fixed* lags) {
    std::uint32_t dirty = 0;
    for_each_at_face(size, side, [&](int own, int behind, int n) {
        if (raise(w[own], neighbour[behind] - lags[n]))
            dirty |= std::uint32_t(1) << own / (size * size);
    });
    return dirty;
}

Fixed offer(const Fixed* w, int size, int side, const Fixed* lags, const FaceBehind& behind) {
    Fixed largest = 0;
    for_each_at_face(size, side, [&](int own, int there, int n) {
        const Fixed before = behind.u ? behind.sign * behind.u[there] : behind.floor;
        const Fixed now = behind.raised ? behind.raised[there] : before;
        const Fixed offered = w[own] - lags[n];
        if (offered > now) largest = std::max(largest, offered - before);
    });
    return largest;
}

void carry(Fixed* w, int size, int side, const Fixed* neighbour, Fixed lag, bool is_first) {
    const int stride = side % 2 ? -stride_of(size, side / 2) : stride_of(size, side / 2);
    for_each_at_face(size, side, [&](int own, int behind, int) {
        Fixed carried = neighbour[behind];
        for (int n = 0; n < size; ++n) {
            Fixed& here = w[own + n * stride];
            carried = std::max(0, carried - lag);
            here = is_first ? carried : std::max(here, carried);
        }
    });
}

MoveResult move(const std::array<MovingComponent, 3>& components, int count, bool from_rest) {
    MoveResult result;
    for (int n = 0; n < count; ++n) {
        bool any = false;
        for (const MovingComponent& c : components) {
            if (!c.raised) continue;
            const Fixed before = from_rest ? 0 : c.sign * c.u[n];
            const Fixed position = std::max(before, c.raised[n] - c.left);
            c.u[n] = c.sign * position;
            any |= position != before;
        }
        result.moved += any;
    }
    for (std::size_t a = 0; a < 3; ++a) {
        if (!components[a].raised) continue;
        const Fixed* u = components[a].u;
        const auto [low, high] = std::minmax_element(u, u + std::ptrdiff_t(count));
        result.u_min[a] = *low;
        result.u_max[a] = *high;
    }
    return result;
}

Fixed largest(const Fixed* values, int count) {
    return *std::max_element(values, values + std::ptrdiff_t(count));
}

}  // namespace

const SweepKernels& plain_sweep_kernels() {
    static constexpr SweepKernels kernels{gather,    copy_face, add_face,      add_halves,
                                          arrange_x, relax,     relax_uniform, take,
                                          offer,     carry,     move,          largest};
    return kernels;
}

}  // namespace pliant
