// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of packing a change as plain loops: the readable twin of history_vector.cpp.

#include <algorithm>
#include <vector>

#include "chainmail/history_kernel.h"

namespace pliant {
namespace {

/// values[i] −= values[i − 1] along each axis. Alternates between two arrays, so that compilers can
/// vectorise it. @param other  of the same length
void predict_from_neighbours(std::uint32_t* values, std::uint32_t* other, int size) {
    const auto n = std::size_t(size), slice = n * n, all = slice * n;
    for (std::size_t i = 1; i < all; ++i) other[i] = values[i] - values[i - 1];
    for (std::size_t row = 0; row < all; row += n) other[row] = values[row];
    for (std::size_t i = n; i < all; ++i) values[i] = other[i] - other[i - n];
    for (std::size_t z = 0; z < all; z += slice) std::copy_n(other + z, n, values + z);
    for (std::size_t i = slice; i < all; ++i) other[i] = values[i] - values[i - slice];
    std::copy(other + slice, other + all, values + slice);
}

std::uint32_t folded(std::uint32_t v) {
    return v << 1 ^ (v >> 31 ? 0xffffffffu : 0u);
}

std::uint32_t predict(const Fixed* before, const Fixed* after, int brick_size,
                      std::uint32_t* values) {
    static thread_local std::vector<std::uint32_t> other;
    const auto n = std::size_t(brick_size) * std::size_t(brick_size) * std::size_t(brick_size);
    std::uint32_t any = 0;
    for (std::size_t i = 0; i < n; ++i)
        any |= values[i] = std::uint32_t(after[i]) - std::uint32_t(before[i]);
    if (any == 0) return 0;
    other.resize(n);
    predict_from_neighbours(values, other.data(), brick_size);
    any = 0;
    for (std::size_t i = 0; i < n; ++i) any |= values[i] = folded(values[i]);
    return any;
}

void copy_plane(const std::uint32_t* values, int count, int plane, std::byte* out) {
    for (int n = 0; n < count; ++n) out[n] = std::byte(values[n] >> 8 * plane & 0xff);
}

}  // namespace

const ChangeKernels& plain_change_kernels() {
    static constexpr ChangeKernels kernels{predict, copy_plane};
    return kernels;
}

}  // namespace pliant
