// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Stream of an image's numbers from its data files, decompressed or parsed, in the machine's byte
// order. One pass suffices: truncated or damaged data are detected on the way, checksums included.
// Data are valid only after finish() succeeds.

#pragma once

#include "formats/image_header.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace pliant {

class DataStream {
  public:
    /// @pre check_data(path, header) succeeded. Keeps references.
    DataStream(const std::filesystem::path& path, const ImageHeader& header);
    ~DataStream();
    DataStream(const DataStream&) = delete;
    DataStream& operator=(const DataStream&) = delete;

    /// Reads the next bytes, a multiple of a number's size.
    Status read(std::span<std::byte> out);
    /// Skips bytes, a multiple of a number's size.
    Status skip(std::uint64_t bytes);
    /// Reads on to the checksum of compressed data, if it is near. Like a raw file, a compressed
    /// one may have excess data.
    Status finish();
    /// Whether all numbers were read, and compressed data or a text go on behind them.
    /// @pre finish() succeeded
    bool is_longer() const;

  private:
    class Source;
    class BytesSource;
    class InflatedSource;
    class TextSource;
    class VtkSource;

    Status open_next();

    const std::filesystem::path& m_path;
    const ImageHeader& m_header;
    std::uint64_t m_bytes_per_file = 0;
    std::uint64_t m_left = 0;  ///< remaining bytes of the current file
    std::size_t m_next = 0;
    std::unique_ptr<Source> m_source;
};

}  // namespace pliant
