// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "volume/data_stream.h"

#include "core/errors.h"
#include "volume/data_check.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <new>
#include <vector>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kPieceBytes = 1 << 18;

template <class Word>
void swap_words(std::span<std::byte> numbers, Word (*swapped)(Word)) {
    for (std::size_t at = 0; at + sizeof(Word) <= numbers.size(); at += sizeof(Word)) {
        Word word;
        std::memcpy(&word, &numbers[at], sizeof word);
        word = swapped(word);
        std::memcpy(&numbers[at], &word, sizeof word);
    }
}

void swap_bytes(std::span<std::byte> numbers, std::size_t size) {
    if (size == 2)
        swap_words<std::uint16_t>(numbers, [](std::uint16_t w) { return __builtin_bswap16(w); });
    if (size == 4)
        swap_words<std::uint32_t>(numbers, [](std::uint32_t w) { return __builtin_bswap32(w); });
    if (size == 8)
        swap_words<std::uint64_t>(
            numbers, [](std::uint64_t w) { return std::uint64_t(__builtin_bswap64(w)); });
}

}  // namespace

/// One data file.
class DataStream::Source {
  public:
    Source(const fs::path& path, const fs::path& name, std::uint64_t start, bool deflated)
        : m_path(path), m_file(name, std::ios::binary), m_deflated(deflated) {
        m_file.seekg(std::streamoff(start));
        if (!deflated) return;
        m_input.resize(kPieceBytes);
        constexpr int kGzipOrZlib = 15 + 32;
        if (inflateInit2(&m_zlib, kGzipOrZlib) != Z_OK) throw std::bad_alloc();
        m_end.reset(&m_zlib);
    }

    Status read(std::span<std::byte> out) {
        if (!m_deflated) {
            m_file.read(reinterpret_cast<char*>(out.data()), std::streamsize(out.size()));
            if (std::size_t(m_file.gcount()) == out.size()) return Ok{};
            return unreadable(m_path, "ends early: it was cut short while it was read");
        }
        while (!out.empty()) {
            const auto count = inflate_some(out);
            if (!count) return count.error();
            out = out.subspan(*count);
        }
        return Ok{};
    }

    Status finish() {
        std::byte rest[4096];
        for (std::size_t beyond = 0; m_deflated && !m_ended && beyond < kPieceBytes;) {
            const auto count = inflate_some(rest);
            if (!count) return count.error();
            beyond += *count;
        }
        return Ok{};
    }

  private:
    /// @returns how many bytes came out, possibly none. gzip files may be chains.
    Result<std::size_t> inflate_some(std::span<std::byte> out) {
        if (m_zlib.avail_in == 0) {
            m_file.read(reinterpret_cast<char*>(m_input.data()), std::streamsize(m_input.size()));
            m_zlib.next_in = m_input.data();
            m_zlib.avail_in = uInt(m_file.gcount());
        }
        if (m_zlib.avail_in == 0)
            return unreadable(m_path, m_ended
                                          ? "ends early: its compressed data hold less than its "
                                            "sizes say"
                                          : "ends early: its compressed data are cut off");
        if (m_ended) inflateReset(&m_zlib);
        const std::size_t room = std::min(out.size(), kPieceBytes);
        m_zlib.next_out = reinterpret_cast<Bytef*>(out.data());
        m_zlib.avail_out = uInt(room);
        const int result = inflate(&m_zlib, Z_NO_FLUSH);
        m_ended = result == Z_STREAM_END;
        if (result != Z_OK && !m_ended)
            return unreadable(m_path, std::string("its compressed data are damaged (") +
                                          (m_zlib.msg ? m_zlib.msg : "no gzip or zlib") + ")");
        return room - m_zlib.avail_out;
    }

    struct EndInflate {
        void operator()(z_stream* stream) const { inflateEnd(stream); }
    };

    const fs::path& m_path;
    std::ifstream m_file;
    bool m_deflated;
    bool m_ended = false;  ///< a member of the chain did, with the right checksum
    std::vector<Bytef> m_input;
    z_stream m_zlib{};
    std::unique_ptr<z_stream, EndInflate> m_end;
};

DataStream::DataStream(const fs::path& path, const ImageHeader& header)
    : m_path(path), m_header(header) {
    const std::uint64_t values =
        std::uint64_t(voxel_count(header.grid)) * std::uint64_t(header.components);
    m_bytes_per_file = values / header.data.files.size() * size_of(header.stored);
}

DataStream::~DataStream() = default;

Status DataStream::open_next() {
    const DataPlace& data = m_header.data;
    const auto start = find_data_start(m_path, m_header, data.files[m_next]);
    if (!start) return start.error();
    const bool deflated = data.encoding == DataEncoding::Deflated;
    m_source = std::make_unique<Source>(m_path, data.files[m_next], *start, deflated);
    ++m_next;
    m_left = m_bytes_per_file;
    std::vector<std::byte> skipped;
    for (std::uint64_t left = deflated ? data.inner_skip : 0; left > 0; left -= skipped.size()) {
        skipped.resize(std::size_t(std::min<std::uint64_t>(left, kPieceBytes)));
        if (Status status = m_source->read(skipped); !status) return status;
    }
    return Ok{};
}

Status DataStream::read(std::span<std::byte> out) {
    const std::size_t number = size_of(m_header.stored);
    for (std::span<std::byte> rest = out; !rest.empty();) {
        if (m_left == 0) {
            if (Status status = finish(); !status) return status;
            if (Status status = open_next(); !status) return status;
        }
        const auto count = std::size_t(std::min<std::uint64_t>(m_left, rest.size()));
        if (Status status = m_source->read(rest.first(count)); !status) return status;
        m_left -= count;
        rest = rest.subspan(count);
    }
    if (m_header.data.swapped) swap_bytes(out, number);
    return Ok{};
}

Status DataStream::finish() {
    return m_source ? m_source->finish() : Status(Ok{});
}

Status check_stream(const fs::path& path, const ImageHeader& header) {
    DataStream stream(path, header);
    std::vector<std::byte> piece(kPieceBytes);
    std::uint64_t left = std::uint64_t(voxel_count(header.grid)) *
                         std::uint64_t(header.components) * size_of(header.stored);
    for (; left > 0; left -= piece.size()) {
        piece.resize(std::size_t(std::min<std::uint64_t>(left, piece.size())));
        if (Status status = stream.read(piece); !status) return status;
    }
    return stream.finish();
}

}  // namespace pliant
