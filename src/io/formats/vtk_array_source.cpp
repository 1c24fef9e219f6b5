// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/vtk_array_source.h"

#include <lz4.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <new>

#include "base/errors.h"
#include "base/memory_budget.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kInputBytes = 1 << 16;
/// Maximum length of a block. VTK's writers use 32 KiB to 4 MiB.
constexpr std::uint64_t kMaxBlockBytes = std::uint64_t(1) << 30;

/// Value of a base64 digit; −1: padding, −2: a blank, −3: something else.
int base64_value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+') return 62;
    if (c == '/') return 63;
    if (c == '=') return -1;
    return c == ' ' || (c >= '\t' && c <= '\r') ? -2 : -3;
}

}  // namespace

VtkArraySource::VtkArraySource(const fs::path& path, std::uint64_t start, const VtkArray& array,
                               bool big, std::uint64_t expected)
    : m_path(path), m_file(path), m_array(array), m_big(big), m_expected(expected) {
    m_left_in_file = m_file.size() - std::min(m_file.size(), start);
    m_file.seek(start);
}

bool VtkArraySource::fill() {
    m_input.resize(kInputBytes);
    m_input.resize(m_file.read(m_input.data(), m_input.size()));
    m_at = 0;
    return !m_input.empty();
}

/// Decodes four digits to one to three bytes.
bool VtkArraySource::decode_four(std::uint8_t* out, int& count) {
    std::uint32_t word = 0;
    int digits = 0, padding = 0;
    while (digits < 4) {
        if (m_at == m_input.size() && !fill()) return false;
        const int value = base64_value(m_input[m_at++]);
        if (value == -2) continue;
        if (value == -3 || (padding > 0 && value != -1)) return false;
        padding += value == -1;
        word = word << 6 | std::uint32_t(std::max(value, 0));
        ++digits;
    }
    if (padding > 2) return false;
    count = 3 - padding;
    for (int b = 0; b < count; ++b) out[b] = std::uint8_t(word >> (16 - 8 * b) & 255);
    return true;
}

bool VtkArraySource::take(std::byte* out, std::size_t count) {
    while (count > 0) {
        if (m_array.base64) {
            if (m_decoded_at == m_decoded_count) {
                m_decoded_at = 0;
                if (!decode_four(reinterpret_cast<std::uint8_t*>(m_decoded.data()),
                                 m_decoded_count))
                    return false;
            }
            *out++ = m_decoded[std::size_t(m_decoded_at++)];
            --count;
            continue;
        }
        if (m_at == m_input.size() && !fill()) return false;
        const std::size_t some = std::min(count, m_input.size() - m_at);
        std::memcpy(out, m_input.data() + m_at, some);
        m_at += some;
        out += some;
        count -= some;
    }
    return true;
}

bool VtkArraySource::take_count(std::uint64_t& count) {
    std::array<std::byte, 8> bytes{};
    const std::size_t size = m_array.wide_counts ? 8 : 4;
    if (!take(bytes.data(), size)) return false;
    count = 0;
    for (std::size_t b = 0; b < size; ++b)
        count |= std::uint64_t(bytes[m_big ? size - 1 - b : b]) << (8 * b);
    return true;
}

/// Reads and checks the lengths in front of the numbers.
Status VtkArraySource::read_lengths() {
    const auto ends = [&] { return m_file.fault("ends early: an array has no length"); };
    const auto differs = [&](std::uint64_t found) {
        return unreadable(m_path, "has " + std::to_string(found) + " bytes of values, expected " +
                                      std::to_string(m_expected));
    };
    std::uint64_t first = 0;
    if (!take_count(first)) return ends();
    if (m_array.codec == VtkArray::Codec::None)
        return first == m_expected ? Status(Ok{}) : Status(differs(first));
    std::uint64_t last = 0;
    if (!take_count(m_block_bytes) || !take_count(last)) return ends();
    m_last_bytes = last > 0 ? last : m_block_bytes;
    const std::uint64_t count_bytes = m_array.wide_counts ? 8 : 4;
    if (first == 0 || first > m_left_in_file / count_bytes || m_last_bytes > m_block_bytes ||
        m_block_bytes > kMaxBlockBytes)
        return unreadable(m_path, "has " + std::to_string(first) + " blocks of " +
                                      std::to_string(m_block_bytes) +
                                      " bytes, expected as many as its values need");
    if (m_block_bytes > 0 && first - 1 > m_expected / m_block_bytes)
        return differs((m_expected / m_block_bytes + 1) * m_block_bytes);
    const std::uint64_t total = (first - 1) * m_block_bytes + m_last_bytes;
    if (total != m_expected) return differs(total);
    if (!has_memory_for(8 * first + 2 * m_block_bytes)) throw std::bad_alloc();
    m_lengths.resize(std::size_t(first));
    for (std::uint64_t& length : m_lengths) {
        if (!take_count(length)) return ends();
        if (length > m_left_in_file || length > 2 * kMaxBlockBytes - 1)
            return unreadable(m_path, "ends early: a block has " + std::to_string(length) +
                                          " bytes, expected at most " +
                                          std::to_string(m_left_in_file));
    }
    return Ok{};
}

/// Decompresses the next block.
Status VtkArraySource::read_block() {
    const std::uint64_t length = m_lengths[m_next_block++];
    const bool is_last = m_next_block == m_lengths.size();
    const auto damaged = [&] {
        return unreadable(
            m_path, "its compressed data are damaged in block " + std::to_string(m_next_block));
    };
    if (!has_memory_for(length)) throw std::bad_alloc();
    m_packed.resize(std::size_t(length));
    m_block.resize(std::size_t(is_last ? m_last_bytes : m_block_bytes));
    m_block_at = 0;
    if (!take(m_packed.data(), m_packed.size()))
        return m_file.fault("ends early: its compressed data are cut off");
    if (m_array.codec == VtkArray::Codec::Lz4) {
        const int got = LZ4_decompress_safe(reinterpret_cast<const char*>(m_packed.data()),
                                            reinterpret_cast<char*>(m_block.data()),
                                            int(m_packed.size()), int(m_block.size()));
        return got == int(m_block.size()) ? Status(Ok{}) : Status(damaged());
    }
    uLongf got = uLongf(m_block.size());
    const int result =
        uncompress(reinterpret_cast<Bytef*>(m_block.data()), &got,
                   reinterpret_cast<const Bytef*>(m_packed.data()), uLong(m_packed.size()));
    return result == Z_OK && got == m_block.size() ? Status(Ok{}) : Status(damaged());
}

Status VtkArraySource::read(std::span<std::byte> out) {
    if (!m_started) {
        if (Status status = read_lengths(); !status) return status;
        m_started = true;
    }
    if (m_array.codec == VtkArray::Codec::None)
        return take(out.data(), out.size())
                   ? Status(Ok{})
                   : Status(m_file.fault("ends early: its values are cut off"));
    while (!out.empty()) {
        if (m_block_at == m_block.size())
            if (Status status = read_block(); !status) return status;
        const std::size_t some = std::min(out.size(), m_block.size() - m_block_at);
        std::memcpy(out.data(), m_block.data() + m_block_at, some);
        m_block_at += some;
        out = out.subspan(some);
    }
    return Ok{};
}

}  // namespace pliant
