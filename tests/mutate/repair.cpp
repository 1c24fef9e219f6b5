// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/repair.h"

#include <algorithm>
#include <cstdint>

#include "base/hash.h"
#include "session/session_line.h"

namespace pliant::mutate {
namespace {

void put_u64(std::string& bytes, std::size_t at, std::uint64_t value) {
    for (std::size_t k = 0; k < 8; ++k) bytes[at + k] = char(value >> 8 * k & 0xff);
}

std::uint64_t word_at(const std::string& bytes, std::size_t at, std::size_t size) {
    std::uint64_t word = 0;
    for (std::size_t k = 0; k < size; ++k)
        word |= std::uint64_t(std::uint8_t(bytes[at + k])) << 8 * k;
    return word;
}

}  // namespace

void repair_state(std::string& bytes) {
    constexpr std::size_t kLengthAt = 16, kCountAt = 8, kShortest = 32;
    if (bytes.size() < kShortest) return;
    if (bytes.starts_with("\x89PLST"))
        put_u64(bytes, kLengthAt, bytes.size());
    else
        put_u64(bytes, kCountAt, bytes.size() / 8 - 3);
    Hash64 hash;
    const std::size_t length = bytes.size() - 8;
    for (std::size_t at = 0; at < length; at += 8) {
        hash.add_word(word_at(bytes, at, std::min<std::size_t>(8, length - at)));
    }
    put_u64(bytes, length, hash.value());
}

std::string checksum_of_state(const std::string& bytes) {
    return bytes.size() < 8 ? "" : serve::hex_text(word_at(bytes, bytes.size() - 8, 8), 16);
}

void repair_session(std::string& bytes) {
    constexpr std::size_t kPrefix = serve::kChecksumDigits + 1;
    std::string repaired;
    std::uint64_t chain = 0;
    for (std::size_t begin = 0; begin < bytes.size();) {
        const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
        std::string_view line(bytes.data() + begin, end - begin);
        const std::size_t brace = line.find('{');
        line.remove_prefix(brace <= kPrefix ? brace : std::min(kPrefix, line.size()));
        repaired += serve::session_line(chain, line);
        begin = end + 1;
    }
    bytes = repaired;
}

}  // namespace pliant::mutate
