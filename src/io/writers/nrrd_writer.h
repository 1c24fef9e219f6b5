// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Streaming NRRD writer: the data need not be in memory as a whole.
//
// Raw data start at a multiple of 64 bytes (a comment pads the header), so that they can be mapped.

#pragma once

#include <pliant/scan_files.h>

#include "formats/image_header.h"
#include "writers/image_sink.h"

#include <filesystem>
#include <span>

namespace pliant {

struct NrrdLayout {
    const Grid& grid;
    Component component;
    int components;  ///< numbers per voxel: 1, or 3 for vectors
    /// Invalid NRRD keys (empty, with a leading '#' or a colon) are left out.
    const KeyValues& key_values;
};

class NrrdWriter {
  public:
    /// Starts a file in LPS under this exact name (.nhdr: with the data beside it).
    NrrdWriter(const std::filesystem::path& path, const NrrdLayout& layout, Encoding encoding);

    /// Adds numbers in the byte order of this machine. Does nothing after a failure.
    void add(std::span<const std::byte> numbers);
    /// @returns the error of a failed write
    Status finish();

  private:
    ImageSink m_sink;
};

}  // namespace pliant
