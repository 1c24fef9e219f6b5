// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/history_codec.h"

#include <lz4.h>

#include <algorithm>
#include <climits>
#include <cstring>

#include "chainmail/history_kernel.h"

namespace pliant {
namespace {

constexpr int kPlanes = 4;
constexpr std::size_t kMaskBytes = 2;  ///< bit set of the stored planes, of 3 × 4

void unpredict(std::uint32_t* values, int size) {
    const auto n = std::size_t(size), slice = n * n, all = slice * n;
    for (std::size_t i = slice; i < all; ++i) values[i] += values[i - slice];
    for (std::size_t z = 0; z < all; z += slice)
        for (std::size_t i = n; i < slice; ++i) values[z + i] += values[z + i - n];
    for (std::size_t row = 0; row < all; row += n)
        for (std::size_t x = 1; x < n; ++x) values[row + x] += values[row + x - 1];
}

std::uint32_t unfolded(std::uint32_t v) {
    return v >> 1 ^ (v & 1 ? 0xffffffffu : 0u);
}

}  // namespace

bool encode_change(const Components& before, const Components& after, int brick_size, Bytes& out) {
    static thread_local std::vector<std::uint32_t> values;
    const ChangeKernels& kernels =
        brick_size == 8 ? vector_change_kernels() : plain_change_kernels();
    const auto n = std::size_t(brick_size) * std::size_t(brick_size) * std::size_t(brick_size);
    values.resize(n);
    const std::size_t start = out.size();
    out.resize(start + kMaskBytes);
    unsigned mask = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        const std::uint32_t any = kernels.predict(before[a], after[a], brick_size, values.data());
        for (int plane = 0; plane < kPlanes; ++plane) {
            if ((any >> 8 * plane & 0xff) == 0) continue;
            mask |= 1u << (kPlanes * int(a) + plane);
            const std::size_t at = out.size();
            out.resize(at + n);
            kernels.copy_plane(values.data(), int(n), plane, out.data() + at);
        }
    }
    if (mask == 0) {
        out.resize(start);
        return false;
    }
    out[start] = std::byte(mask & 0xff);
    out[start + 1] = std::byte(mask >> 8);
    return true;
}

bool decode_change(std::span<const std::byte>& in, int brick_size,
                   const std::array<std::uint32_t*, 3>& change) {
    const auto n = std::size_t(brick_size) * std::size_t(brick_size) * std::size_t(brick_size);
    if (in.size() < kMaskBytes) return false;
    const unsigned mask = unsigned(in[0]) | unsigned(in[1]) << 8;
    in = in.subspan(kMaskBytes);
    if (mask >> 3 * kPlanes) return false;
    for (std::size_t a = 0; a < 3; ++a) {
        std::uint32_t* values = change[a];
        std::memset(values, 0, n * sizeof *values);
        const unsigned planes = mask >> kPlanes * int(a) & 0xf;
        if (planes == 0) continue;
        for (int plane = 0; plane < kPlanes; ++plane) {
            if (!(planes >> plane & 1)) continue;
            if (in.size() < n) return false;
            for (std::size_t i = 0; i < n; ++i) values[i] |= std::uint32_t(in[i]) << 8 * plane;
            in = in.subspan(n);
        }
        for (std::size_t i = 0; i < n; ++i) values[i] = unfolded(values[i]);
        unpredict(values, brick_size);
    }
    return true;
}

Bytes pack(std::span<const std::byte> raw) {
    // Reused: memory for the worst case is large, and new memory would have to be cleared each
    // time.
    static thread_local Bytes packed;
    packed.resize(std::max(packed.size(), std::size_t(LZ4_compressBound(int(raw.size())))));
    const int size = LZ4_compress_default(reinterpret_cast<const char*>(raw.data()),
                                          reinterpret_cast<char*>(packed.data()), int(raw.size()),
                                          int(packed.size()));
    return Bytes(packed.begin(), packed.begin() + size);
}

bool unpack(std::span<const std::byte> packed, std::span<std::byte> raw) {
    if (packed.size() > INT_MAX || raw.size() > INT_MAX) return false;
    const int size = LZ4_decompress_safe(reinterpret_cast<const char*>(packed.data()),
                                         reinterpret_cast<char*>(raw.data()), int(packed.size()),
                                         int(raw.size()));
    return size >= 0 && std::size_t(size) == raw.size();
}

std::size_t longest_unpacked(std::size_t packed_size) {
    return 255 * packed_size + 64;
}

}  // namespace pliant
