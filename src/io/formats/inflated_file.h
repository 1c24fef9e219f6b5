// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The bytes of a file that is compressed by gzip, zlib or deflate alone. gzip files may have
// several members. Checksums are verified.

#pragma once

#include "base/errors.h"
#include "base/input_file.h"

#include <pliant/result.h>

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <vector>

namespace pliant {

class InflatedFile {
  public:
    /// Maximum number of bytes that are read or returned at once.
    static constexpr std::size_t kPieceBytes = 1 << 18;

    static constexpr int kGzipOrZlib = 15 + 32;

    /// Keeps a reference to the path. @param path  for messages  @param name  of the file
    /// @param window_bits  as of zlib's inflateInit2
    InflatedFile(const std::filesystem::path& path, const std::filesystem::path& name,
                 std::uint64_t start, int window_bits = kGzipOrZlib)
        : m_path(path), m_file(name), m_input(kPieceBytes) {
        m_file.seek(start);
        if (inflateInit2(&m_zlib, window_bits) != Z_OK) throw std::bad_alloc();
        m_end.reset(&m_zlib);
    }

    /// Error of reading the compressed bytes.
    Status status() const { return m_file.status(); }
    /// Whether a member has just ended, with the correct checksum.
    bool ended() const { return m_ended; }

    /// @returns number of decompressed bytes, possibly zero; Unreadable at the end of the file
    Result<std::size_t> read_some(std::span<std::byte> out) {
        if (m_zlib.avail_in == 0) {
            m_zlib.next_in = m_input.data();
            m_zlib.avail_in = uInt(m_file.read(m_input.data(), m_input.size()));
            if (Status s = m_file.status(); !s) return s.error();
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

  private:
    struct EndInflate {
        void operator()(z_stream* stream) const { inflateEnd(stream); }
    };

    const std::filesystem::path& m_path;
    InputFile m_file;
    bool m_ended = false;
    std::vector<Bytef> m_input;
    z_stream m_zlib{};
    std::unique_ptr<z_stream, EndInflate> m_end;
};

}  // namespace pliant
