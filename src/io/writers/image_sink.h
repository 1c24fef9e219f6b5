// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Output of an image's writer: bytes as they are, then numbers that may be compressed. Errors are
// kept until finish().

#pragma once

#include "base/descriptor.h"

#include <pliant/result.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include <zlib.h>

namespace pliant {

enum class Compression { Gzip, Zlib };

class ImageSink {
  public:
    explicit ImageSink(const std::filesystem::path& path) : m_path(path) { open(path); }
    ~ImageSink();
    ImageSink(const ImageSink&) = delete;
    ImageSink& operator=(const ImageSink&) = delete;

    /// Writes bytes without compression.
    void write(const void* bytes, std::size_t count);
    /// Overwrites bytes of the present file.
    void write_at(std::uint64_t offset, std::string_view text);
    /// Continues in another file.
    void open(const std::filesystem::path& path);
    /// Compresses the numbers that are added from now on.
    void start(Compression compression);
    void add(std::span<const std::byte> numbers);
    /// Completes the compressed numbers. The file stays open.
    void end_numbers();
    /// Bytes written to the present file.
    std::uint64_t bytes_written() const { return m_bytes_written; }
    /// Closes the file. @returns the first error
    Status finish();

  private:
    void deflate_all(int flush);
    void close();

    std::filesystem::path m_path;
    Descriptor m_file;
    int m_error = 0;  ///< errno of the first failure
    bool m_compresses = false;
    std::uint64_t m_bytes_written = 0;
    std::vector<Bytef> m_output;
    z_stream m_zlib{};
};

}  // namespace pliant
