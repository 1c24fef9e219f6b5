// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NRRD out, piece by piece: what is written need never be in memory as a whole.
//
// Raw data start at a multiple of 64 bytes (a comment fills the header up), so that they can be
// mapped when they are read again.

#pragma once

#include "volume/image_header.h"

#include <filesystem>
#include <memory>
#include <span>

namespace pliant {

struct NrrdLayout {
    const Grid& grid;
    Component component;
    int components;  ///< numbers per voxel: 1, or 3 for vectors
    /// A NRRD key can't be empty, start with '#' or hold a colon; those that do are left out.
    const KeyValues& key_values;
};

class NrrdWriter {
  public:
    /// Starts a file in LPS under exactly this name (.nhdr: the data beside it).
    NrrdWriter(const std::filesystem::path& path, const NrrdLayout& layout, Encoding encoding);
    ~NrrdWriter();
    NrrdWriter(const NrrdWriter&) = delete;
    NrrdWriter& operator=(const NrrdWriter&) = delete;

    /// Adds numbers, in the byte order of this machine. After a failure nothing more is done.
    void add(std::span<const std::byte> numbers);
    /// @returns why it could not be written, if so
    Status finish();

  private:
    class Sink;
    std::unique_ptr<Sink> m_sink;
};

}  // namespace pliant
