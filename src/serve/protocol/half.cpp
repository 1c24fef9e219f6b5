// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "protocol/half.h"

#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <vector>

#include "base/byte_order.h"

namespace pliant::serve {
namespace {

/// Table of all 16-bit values: most scans have no others.
const std::array<std::uint16_t, 65536>& half_of_int16() {
    static const auto table = [] {
        auto made = std::make_unique<std::array<std::uint16_t, 65536>>();
        for (int v = -32768; v < 32768; ++v) (*made)[std::uint16_t(v)] = half_from_float(float(v));
        return made;
    }();
    return *table;
}

std::uint32_t mix_word(std::uint32_t state, std::uint32_t word) {
    word = std::rotl(word * 0xcc9e2d51U, 15) * 0x1b873593U;
    return std::rotl(state ^ word, 13) * 5 + 0xe6546b64U;
}

}  // namespace

void halves_of_box(const Volume& volume, const Box3i& box, std::span<std::uint16_t> halves) {
    const auto length = std::size_t(box.end.x - box.begin.x);
    std::uint16_t* out = halves.data();
    const auto for_each_row = [&](auto convert) {
        for (int k = box.begin.z; k < box.end.z; ++k)
            for (int j = box.begin.y; j < box.end.y; ++j, out += length)
                convert(voxel_index(volume.grid, {box.begin.x, j, k}));
    };
    if (volume.is_16_bit()) {
        const auto* values = std::get_if<0>(&volume.voxels)->data();
        const auto& table = half_of_int16();
        for_each_row([&](std::size_t first) {
            for (std::size_t i = 0; i < length; ++i)
                out[i] = table[std::uint16_t(values[first + i])];
        });
    } else {
        const auto* values = std::get_if<1>(&volume.voxels)->data();
        for_each_row([&](std::size_t first) {
            for (std::size_t i = 0; i < length; ++i) out[i] = half_from_float(values[first + i]);
        });
    }
}

void halves_of_every(const Volume& volume, int step, const Box3i& box,
                     std::span<std::uint16_t> halves) {
    std::size_t out = 0;
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j)
            for (int i = box.begin.x; i < box.end.x; ++i)
                halves[out++] = half_from_float(volume.at({step * i, step * j, step * k}));
}

void Murmur32::add(std::span<const std::byte> bytes) {
    m_size += std::uint32_t(bytes.size());
    for (; bytes.size() >= 4; bytes = bytes.subspan(4)) {
        std::uint32_t word = 0;
        std::memcpy(&word, bytes.data(), 4);
        m_state = mix_word(m_state, little_endian(word));
    }
    std::uint32_t tail = 0;
    for (std::size_t n = 0; n < bytes.size(); ++n) tail |= std::uint32_t(bytes[n]) << (8 * n);
    if (!bytes.empty()) m_state ^= std::rotl(tail * 0xcc9e2d51U, 15) * 0x1b873593U;
}

std::uint32_t Murmur32::value() const {
    std::uint32_t h = m_state ^ m_size;
    h = (h ^ (h >> 16)) * 0x85ebca6bU;
    h = (h ^ (h >> 13)) * 0xc2b2ae35U;
    return h ^ (h >> 16);
}

std::uint32_t checksum_of_halves(const Volume& volume) {
    // Parts must be whole words (two voxels), so rows are concatenated in a buffer.
    constexpr std::size_t kPart = 1 << 14;
    std::vector<std::uint16_t> buffer;
    buffer.reserve(kPart + std::size_t(volume.grid.size.x));
    Murmur32 sum;
    const auto hash = [&](std::size_t count) {
        if constexpr (kIsBigEndian)
            for (std::size_t n = 0; n < count; ++n) buffer[n] = little_endian(buffer[n]);
        sum.add(std::as_bytes(std::span(buffer).first(count)));
        buffer.erase(buffer.begin(), buffer.begin() + std::ptrdiff_t(count));
    };
    const Vec3i size = volume.grid.size;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j) {
            const std::size_t before = buffer.size();
            buffer.resize(before + std::size_t(size.x));
            halves_of_box(volume, {{0, j, k}, {size.x, j + 1, k + 1}},
                          std::span(buffer).subspan(before));
            if (buffer.size() >= kPart) hash(buffer.size() / 2 * 2);
        }
    hash(buffer.size());
    return sum.value();
}

}  // namespace pliant::serve
