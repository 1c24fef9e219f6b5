// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Streaming writer of NIfTI-1 [NIfTI2007], as nrrd_writer.h. The header has 32-bit floats: spacing,
// position and directions are rounded to them. sform and qform are both written and agree; the
// codes are those of a scanner's coordinates.

#pragma once

#include <pliant/scan_files.h>

#include "formats/image_header.h"
#include "writers/image_sink.h"
#include "writers/nrrd_writer.h"

#include <filesystem>
#include <span>

namespace pliant {

/// Checks that the header can hold the grid: at most 32767 voxels along an axis.
Status check_nifti_size(const std::filesystem::path& path, const Grid& grid);

class NiftiWriter {
  public:
    /// Starts a file in RAS. With three components the intent is that of vectors, which ITK takes
    /// as LPS; all numbers of one component come before those of the next. Data are compressed if,
    /// and only if, the name ends in .gz.
    NiftiWriter(const std::filesystem::path& path, const NrrdLayout& layout, Encoding);

    /// Adds numbers in the byte order of this machine. Does nothing after a failure.
    void add(std::span<const std::byte> numbers) { m_sink.add(numbers); }
    /// @returns the error of a failed write
    Status finish();

  private:
    ImageSink m_sink;
};

}  // namespace pliant
