// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The pixels of a series, slice by slice. Uncompressed ones are read here; codestreams are decoded
// by a process of its own (pixel_decoder.h), one for all slices. Values are stored·slope +
// intercept in doubles. MONOCHROME1 says how values are to be shown, and changes none.

#pragma once

#include "volume/dicom_slice.h"
#include "volume/pixel_decoder.h"
#include "volume/voxel_builder.h"

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace pliant {

/// Which program decodes; tests have others.
struct DecoderChoice {
    std::filesystem::path program;  ///< empty: the one that find_pixel_decoder finds
    double seconds_per_slice = 10;
};

class DicomPixelReader {
  public:
    /// @param slices  of one size, all that will be read
    explicit DicomPixelReader(const std::vector<DicomSlice>& slices,
                              const DecoderChoice& decoder = {});

    /// Adds rows·columns values. After an error no more slices can be read.
    Status read(const DicomSlice& slice, VoxelBuilder& voxels);

  private:
    void make_room(const DicomSlice& slice);
    Status read_plain(const DicomSlice& slice);
    Status read_compressed(const DicomSlice& slice);
    Status start_decoder(const DicomSlice& slice);
    void add(const DicomSlice& slice, VoxelBuilder& voxels);

    std::filesystem::path m_program;
    DecoderLimits m_limits;
    std::optional<PixelDecoder> m_decoder;
    std::vector<std::uint8_t> m_message;  ///< to the decoder
    std::vector<std::uint8_t> m_bytes;    ///< of the pixels, little endian
    bool m_is_signed = false;
    int m_bits = 16;  ///< of each pixel that count; those above repeat the sign, or are zero
};

}  // namespace pliant
