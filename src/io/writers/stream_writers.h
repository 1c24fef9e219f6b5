// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Streaming writers: the data need not be in memory as a whole. Numbers are added in the byte order
// of this machine, which does nothing after a failure; finish() returns its error.

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
    const KeyValues& key_values;
};

/// NRRD. Raw data start at a multiple of 64 bytes (a comment pads the header), so that they can be
/// mapped.
class NrrdWriter {
  public:
    /// Starts a file in LPS under this exact name (.nhdr: with the data beside it). Invalid keys
    /// (empty, with a leading '#' or a colon) are left out.
    NrrdWriter(const std::filesystem::path& path, const NrrdLayout& layout, Encoding encoding);
    void add(std::span<const std::byte> numbers);
    Status finish();

  private:
    ImageSink m_sink;
};

/// MetaImage [MetaIO2007]. Compressed data are zlib's; their length is known at the end, and is
/// then put into the header.
class MetaWriter {
  public:
    /// Starts a file in LPS under this exact name (.mhd: with the data beside it). Keys with
    /// separators, several lines or outer blanks are left out.
    MetaWriter(const std::filesystem::path& path, const NrrdLayout& layout, Encoding encoding);
    void add(std::span<const std::byte> numbers) { m_sink.add(numbers); }
    Status finish();

  private:
    ImageSink m_sink;
    std::uint64_t m_header_bytes = 0;
    std::uint64_t m_size_offset = 0;  ///< of the compressed data's length; 0: none
};

/// Checks that NIfTI-1 can hold the grid: at most 32767 voxels along an axis.
Status check_nifti_size(const std::filesystem::path& path, const Grid& grid);

/// NIfTI-1 [NIfTI2007]. The header has 32-bit floats: spacing, position and directions are rounded
/// to them. sform and qform are both written and agree; the codes are those of a scanner's
/// coordinates.
class NiftiWriter {
  public:
    /// Starts a file in RAS. With three components the intent is that of vectors, which ITK takes
    /// as LPS; all numbers of one component come before those of the next. Data are compressed if,
    /// and only if, the name ends in .gz.
    NiftiWriter(const std::filesystem::path& path, const NrrdLayout& layout, Encoding);
    void add(std::span<const std::byte> numbers) { m_sink.add(numbers); }
    Status finish();

  private:
    ImageSink m_sink;
};

}  // namespace pliant
