// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The numbers of an image, one after the other out of its data files, inflated or read from text
// on the way, in the machine's byte order. Inflating once is enough: data that are cut off or
// damaged are noticed when they come by, checksums included, so nothing that was read counts before
// finish() says so.

#pragma once

#include "volume/image_header.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace pliant {

class DataStream {
  public:
    /// @pre check_data(path, header) was fine. Keeps references.
    DataStream(const std::filesystem::path& path, const ImageHeader& header);
    ~DataStream();
    DataStream(const DataStream&) = delete;
    DataStream& operator=(const DataStream&) = delete;

    /// The next bytes: whole numbers.
    Status read(std::span<std::byte> out);
    /// Runs on to the checksum of compressed data, if it is near: like a raw file, a compressed one
    /// may hold more than its sizes say.
    Status finish();

  private:
    class Source;
    class BytesSource;
    class TextSource;

    Status open_next();

    const std::filesystem::path& m_path;
    const ImageHeader& m_header;
    std::uint64_t m_bytes_per_file = 0;
    std::uint64_t m_left = 0;  ///< bytes of the current file that belong to the image
    std::size_t m_next = 0;
    std::unique_ptr<Source> m_source;
};

}  // namespace pliant
