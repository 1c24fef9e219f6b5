// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "writers/image_sink.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kOutputBytes = 1 << 18;
constexpr std::size_t kMaxAtOnce = std::size_t(1) << 30;
/// Fastest level: on scans and on sparse fields, higher levels cost three times the time for a few
/// percent.
constexpr int kFastest = 1;

}  // namespace

ImageSink::~ImageSink() {
    close();
    if (m_compresses) deflateEnd(&m_zlib);
}

void ImageSink::write(const void* bytes, std::size_t count) {
    if (m_error == 0) m_error = write_all(m_file.number(), bytes, count);
    m_bytes_written += count;
}

void ImageSink::write_at(std::uint64_t offset, std::string_view text) {
    if (m_error) return;
    if (::lseek(m_file.number(), off_t(offset), SEEK_SET) < 0)
        m_error = errno;
    else
        m_error = write_all(m_file.number(), text.data(), text.size());
}

void ImageSink::open(const fs::path& path) {
    close();
    m_bytes_written = 0;
    if (m_error) return;
    m_file = open_file(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (!m_file.is_open()) m_error = errno;
}

void ImageSink::start(Compression compression) {
    constexpr int kZlib = 15, kGzip = 15 + 16, kDefaultMemory = 8;
    if (deflateInit2(&m_zlib, kFastest, Z_DEFLATED,
                     compression == Compression::Gzip ? kGzip : kZlib, kDefaultMemory,
                     Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
    m_compresses = true;
    m_output.resize(kOutputBytes);
}

void ImageSink::add(std::span<const std::byte> numbers) {
    if (!m_compresses) return write(numbers.data(), numbers.size());
    while (!numbers.empty() && m_error == 0) {
        const auto piece = numbers.first(std::min(numbers.size(), kMaxAtOnce));
        m_zlib.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(piece.data()));
        m_zlib.avail_in = uInt(piece.size());
        deflate_all(Z_NO_FLUSH);
        numbers = numbers.subspan(piece.size());
    }
}

void ImageSink::end_numbers() {
    if (!m_compresses || m_error) return;
    m_zlib.next_in = nullptr;
    m_zlib.avail_in = 0;
    deflate_all(Z_FINISH);
}

Status ImageSink::finish() {
    close();
    if (m_error == 0) return Ok{};
    return Error{ErrorCode::Unwritable,
                 m_path.string() + ": can't be written (" + std::strerror(m_error) + ")"};
}

void ImageSink::deflate_all(int flush) {
    do {
        m_zlib.next_out = m_output.data();
        m_zlib.avail_out = uInt(m_output.size());
        deflate(&m_zlib, flush);
        write(m_output.data(), m_output.size() - m_zlib.avail_out);
    } while (m_zlib.avail_out == 0 && m_error == 0);
}

void ImageSink::close() {
    const int error = m_file.close();
    if (m_error == 0) m_error = error;
}

}  // namespace pliant
