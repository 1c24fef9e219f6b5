// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Streaming MetaImage writer [MetaIO2007], as nrrd_writer.h. Compressed data are zlib's; their
// length is known at the end, and is then put into the header.

#pragma once

#include <pliant/scan_files.h>

#include "formats/image_header.h"
#include "writers/image_sink.h"
#include "writers/nrrd_writer.h"

#include <filesystem>
#include <span>

namespace pliant {

class MetaWriter {
  public:
    /// Starts a file in LPS under this exact name (.mhd: with the data beside it). Keys with
    /// separators, several lines or outer blanks are left out.
    MetaWriter(const std::filesystem::path& path, const NrrdLayout& layout, Encoding encoding);

    /// Adds numbers in the byte order of this machine. Does nothing after a failure.
    void add(std::span<const std::byte> numbers) { m_sink.add(numbers); }
    /// @returns the error of a failed write
    Status finish();

  private:
    ImageSink m_sink;
    std::uint64_t m_header_bytes = 0;
    std::uint64_t m_size_offset = 0;  ///< of the compressed data's length; 0: none
};

}  // namespace pliant
