// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/state_frame.h"

#include <bit>
#include <cstring>
#include <utility>

#include "base/hash.h"

namespace pliant {
namespace {

constexpr unsigned char kMagic[8] = {0x89, 'P', 'L', 'S', 'T', 0x0d, 0x0a, 0x1a};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kLengthAt = 16;
constexpr std::size_t kShortest = 24 + 8;

/// A checksum that is equal on big- and little-endian machines.
std::uint64_t checksum_of(std::span<const std::byte> bytes) {
    Hash64 hash;
    for (std::size_t at = 0; at < bytes.size(); at += 8) {
        std::uint64_t word = 0;
        for (std::size_t k = 0; k < 8 && at + k < bytes.size(); ++k)
            word |= std::uint64_t(bytes[at + k]) << 8 * k;
        hash.add_word(word);
    }
    return hash.value();
}

}  // namespace

StateWriter::StateWriter(std::uint32_t flags) {
    put(std::as_bytes(std::span(kMagic)));
    put_u32(kVersion);
    put_u32(flags);
    put_u64(0);  // placeholder for the length
}

void StateWriter::put(std::span<const std::byte> bytes) {
    m_out.insert(m_out.end(), bytes.begin(), bytes.end());
}
void StateWriter::put_u32(std::uint32_t value) {
    for (int k = 0; k < 4; ++k) m_out.push_back(std::byte(value >> 8 * k & 0xff));
}
void StateWriter::put_u64(std::uint64_t value) {
    put_u32(std::uint32_t(value));
    put_u32(std::uint32_t(value >> 32));
}
void StateWriter::put_double(double value) {
    put_u64(std::bit_cast<std::uint64_t>(value));
}
void StateWriter::put_vector(Vec3d v) {
    for (int a = 0; a < 3; ++a) put_double(v[a]);
}

Bytes StateWriter::finish() {
    const std::uint64_t length = m_out.size() + 8;
    for (std::size_t k = 0; k < 8; ++k) m_out[kLengthAt + k] = std::byte(length >> 8 * k & 0xff);
    put_u64(checksum_of(m_out));
    return std::move(m_out);
}

Result<StateParser> StateParser::open(std::string name, std::span<const std::byte> file,
                                      std::uint32_t known_flags) {
    StateParser parser(std::move(name), file);
    std::span<const std::byte> magic;
    std::uint32_t version = 0;
    std::uint64_t length = 0;
    if (!parser.take(sizeof kMagic, magic) || std::memcmp(magic.data(), kMagic, sizeof kMagic) != 0)
        return Error{
            ErrorCode::Unreadable,
            parser.m_name + ": expected a state that Pliant saved, found another kind of file"};
    if (!parser.take_u32(version)) return parser.damaged();
    if (version > kVersion)
        return Error{ErrorCode::Unsupported, parser.m_name + ": expected a state of version " +
                                                 std::to_string(kVersion) + ", found version " +
                                                 std::to_string(version) +
                                                 " of a newer Pliant, or damage"};
    if (version == 0 || !parser.take_u32(parser.m_flags) || !parser.take_u64(length) ||
        length < kShortest)
        return parser.damaged();
    if (length != file.size())
        return Error{ErrorCode::Unreadable, parser.m_name + ": expected " + std::to_string(length) +
                                                " bytes, found " + std::to_string(file.size())};
    std::uint64_t checksum = 0;
    for (std::size_t k = 0; k < 8; ++k)
        checksum |= std::uint64_t(file[file.size() - 8 + k]) << 8 * k;
    if (checksum_of(file.first(file.size() - 8)) != checksum || (parser.m_flags & ~known_flags))
        return parser.damaged();
    parser.m_bytes = parser.m_bytes.first(parser.m_bytes.size() - 8);
    return parser;
}

Error StateParser::damaged() const {
    return {ErrorCode::Unreadable, m_name + ": expected a saved state, found one that is damaged"};
}

bool StateParser::take(std::size_t count, std::span<const std::byte>& out) {
    if (m_bytes.size() < count) return false;
    out = m_bytes.first(count);
    m_bytes = m_bytes.subspan(count);
    return true;
}
bool StateParser::take_u32(std::uint32_t& value) {
    std::span<const std::byte> bytes;
    if (!take(4, bytes)) return false;
    value = 0;
    for (std::size_t k = 0; k < 4; ++k) value |= std::uint32_t(bytes[k]) << 8 * k;
    return true;
}
bool StateParser::take_u64(std::uint64_t& value) {
    std::uint32_t low = 0, high = 0;
    if (!take_u32(low) || !take_u32(high)) return false;
    value = low | std::uint64_t(high) << 32;
    return true;
}
bool StateParser::take_double(double& value) {
    std::uint64_t bits = 0;
    if (!take_u64(bits)) return false;
    value = std::bit_cast<double>(bits);
    return true;
}
bool StateParser::take_vector(Vec3d& v) {
    for (int a = 0; a < 3; ++a)
        if (!take_double(v[a])) return false;
    return true;
}

}  // namespace pliant
