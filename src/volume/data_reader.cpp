// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "volume/data_reader.h"

#include "volume/text.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <fstream>
#include <limits>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kPieceBytes = 1 << 18;

Error damaged(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}

/// Bytes of a file.
class RawSource {
  public:
    explicit RawSource(std::ifstream& file) : m_file(file) {}

    Status read(const fs::path& path, std::byte* out, std::size_t count) {
        m_file.read(reinterpret_cast<char*>(out), std::streamsize(count));
        if (std::size_t(m_file.gcount()) == count) return Ok{};
        return damaged(path, "ends early: its data are incomplete");
    }
    Status finish(const fs::path&) { return Ok{}; }

  private:
    std::ifstream& m_file;
};

/// Bytes that come out of gzip or zlib data in a file.
class DeflatedSource {
  public:
    explicit DeflatedSource(std::ifstream& file) : m_file(file), m_input(kPieceBytes) {
        constexpr int kGzipOrZlib = 15 + 32;
        m_ready = inflateInit2(&m_stream, kGzipOrZlib) == Z_OK;
    }
    ~DeflatedSource() {
        if (m_ready) inflateEnd(&m_stream);
    }
    DeflatedSource(const DeflatedSource&) = delete;
    DeflatedSource& operator=(const DeflatedSource&) = delete;

    Status read(const fs::path& path, std::byte* out, std::size_t count) {
        m_stream.next_out = reinterpret_cast<Bytef*>(out);
        m_stream.avail_out = uInt(count);
        while (m_stream.avail_out > 0) {
            if (m_ended && !start_next_member())
                return damaged(path,
                               "ends early: its compressed data hold less than its sizes "
                               "say");
            if (Status status = inflate_some(path); !status) return status;
        }
        return Ok{};
    }

    /// Runs to the end of the compressed data, where their checksum is, if that is near: like a
    /// raw file, a compressed one may hold more than its sizes say.
    Status finish(const fs::path& path) {
        std::vector<std::byte> rest(kPieceBytes);
        m_stream.next_out = reinterpret_cast<Bytef*>(rest.data());
        m_stream.avail_out = uInt(rest.size());
        while (!m_ended && m_stream.avail_out > 0)
            if (Status status = inflate_some(path); !status) return status;
        return Ok{};
    }

  private:
    void fill() {
        if (m_stream.avail_in > 0) return;
        m_file.read(reinterpret_cast<char*>(m_input.data()), std::streamsize(m_input.size()));
        m_stream.next_in = m_input.data();
        m_stream.avail_in = uInt(m_file.gcount());
    }
    /// gzip files may be chains of gzip files.
    bool start_next_member() {
        fill();
        if (m_stream.avail_in == 0 || inflateReset(&m_stream) != Z_OK) return false;
        m_ended = false;
        return true;
    }
    Status inflate_some(const fs::path& path) {
        fill();
        if (!m_ready) return damaged(path, "no memory to decompress it");
        if (m_stream.avail_in == 0)
            return damaged(path, "ends early: its compressed data are cut off");
        const int result = inflate(&m_stream, Z_NO_FLUSH);
        m_ended = result == Z_STREAM_END;
        if (result == Z_OK || m_ended) return Ok{};
        return damaged(path, std::string("its compressed data are damaged (") +
                                 (m_stream.msg ? m_stream.msg : "no gzip or zlib") + ")");
    }

    std::ifstream& m_file;
    std::vector<Bytef> m_input;
    z_stream m_stream{};
    bool m_ready = false;
    bool m_ended = false;
};

void swap_bytes(std::byte* bytes, std::size_t count, std::size_t size) {
    for (std::size_t n = 0; n < count; ++n) std::reverse(bytes + n * size, bytes + (n + 1) * size);
}

/// Hands count numbers of a source to the sink.
template <class Source>
Status read_numbers(const fs::path& path, const ImageHeader& header, Source& source,
                    std::uint64_t count, const DataSink& sink) {
    const std::size_t size = size_of(header.component);
    const bool swap = header.data.big_endian != (std::endian::native == std::endian::big);
    std::vector<std::byte> piece(kPieceBytes);
    for (std::uint64_t skip = header.data.inner_skip; skip > 0;) {
        const auto some = std::size_t(std::min<std::uint64_t>(skip, kPieceBytes));
        if (Status status = source.read(path, piece.data(), some); !status) return status;
        skip -= some;
    }
    while (count > 0) {
        const auto some = std::size_t(std::min<std::uint64_t>(count, kPieceBytes / size));
        if (Status status = source.read(path, piece.data(), some * size); !status) return status;
        if (swap) swap_bytes(piece.data(), some, size);
        sink(header.component, piece.data(), some);
        count -= some;
    }
    return source.finish(path);
}

Status read_text(const fs::path& path, std::ifstream& file, std::uint64_t count,
                 const DataSink& sink) {
    std::string word;
    for (std::uint64_t n = 0; n < count; ++n) {
        if (!(file >> word))
            return damaged(path, "ends early: holds " + std::to_string(n) + " numbers, expected " +
                                     std::to_string(count));
        if (word.ends_with(',')) word.pop_back();
        const auto number = number_from(word);
        if (!number)
            return damaged(path, "holds '" + shown(word) + "' among its data, expected a number");
        sink(Component::Float64, &*number, 1);
    }
    return Ok{};
}

Status read_file(const fs::path& path, const ImageHeader& header, const fs::path& name,
                 std::uint64_t count, const DataSink& sink) {
    const DataPlace& data = header.data;
    std::ifstream file(name, std::ios::binary);
    if (!file) return damaged(path, "its data file " + name.string() + " can't be opened");
    file.seekg(std::streamoff(data.start));
    for (std::int64_t line = 0; line < data.line_skip; ++line)
        file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    file.seekg(std::streamoff(data.byte_skip), std::ios::cur);
    if (data.at_the_end && data.encoding == DataEncoding::Raw)
        file.seekg(-std::streamoff(count * size_of(header.component)), std::ios::end);
    if (data.encoding == DataEncoding::Text) return read_text(path, file, count, sink);
    if (data.encoding == DataEncoding::Deflated) {
        DeflatedSource source(file);
        return read_numbers(path, header, source, count, sink);
    }
    RawSource source(file);
    return read_numbers(path, header, source, count, sink);
}

}  // namespace

Status read_data(const fs::path& path, const ImageHeader& header, const DataSink& sink) {
    const std::vector<fs::path>& files = header.data.files;
    const std::uint64_t count =
        std::uint64_t(voxel_count(header.grid)) * std::uint64_t(header.components) / files.size();
    for (const fs::path& file : files)
        if (Status status = read_file(path, header, file, count, sink); !status) return status;
    return Ok{};
}

}  // namespace pliant
