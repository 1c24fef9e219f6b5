// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reader of a series' pixels, slice by slice. Uncompressed pixels are read here; a separate process
// (pixel_decoder.h), one for all slices, decodes codestreams. Values are stored·slope + intercept
// in doubles. MONOCHROME1 affects the display only and changes no values.

#pragma once

#include "formats/dicom_input.h"
#include "formats/dicom_slice.h"
#include "formats/pixel_decoder.h"
#include "formats/voxel_builder.h"

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// Choice of the decoder; tests use others.
struct DecoderChoice {
    std::filesystem::path program;  ///< empty: the result of find_pixel_decoder
    double seconds_per_slice = 10;
};

class DicomPixelReader {
  public:
    /// @param slices  all slices to read, of one size
    explicit DicomPixelReader(const std::vector<DicomSlice>& slices,
                              const DecoderChoice& decoder = {});

    /// Adds rows·columns values. After an error no more slices can be read.
    Status read(const DicomSlice& slice, VoxelBuilder& voxels);
    /// Appends the padding of the slices to come, one bit a pixel, to a list if it isn't null.
    void collect_padding(std::vector<bool>* padding) { m_all_padding = padding; }
    /// Notes about the values of all slices that were read.
    std::vector<std::string> notes() const;

  private:
    void make_room(const DicomSlice& slice);
    Status open(const DicomSlice& slice);
    Status read_plain(const DicomSlice& slice);
    Status read_compressed(const DicomSlice& slice);
    Status start_decoder(const DicomSlice& slice);
    void add(const DicomSlice& slice, VoxelBuilder& voxels);
    template <class Stored, class Number>
    void add_numbers(const DicomSlice& slice, const Number& number, VoxelBuilder& voxels);
    template <class Stored, class Value, class Rescale>
    void add_as(const DicomSlice& slice, Component component, const Rescale& rescale,
                VoxelBuilder& voxels);
    template <class Stored, class Number>
    void find_padding(const DicomSlice& slice, const Number& number);

    std::filesystem::path m_program;
    DecoderLimits m_limits;
    std::optional<PixelDecoder> m_decoder;
    std::optional<DicomInput> m_input;
    std::size_t m_doubtful = 0;      ///< pixels whose sign is unknown
    std::size_t m_padded = 0;        ///< pixels whose value was replaced
    double m_padding_value = 0;      ///< the last replacement
    std::vector<bool> m_is_padding;  ///< pixels of the slice; empty: none
    std::vector<bool>* m_all_padding = nullptr;
    std::string m_kept_padding;  ///< slice whose padding may be an image's value; empty: none
    std::vector<std::uint8_t> m_message;  ///< to the decoder
    std::vector<std::uint8_t> m_bytes;    ///< of the pixels, little endian
    bool m_is_signed = false;
    int m_bits = 16;  ///< used bits of a pixel; those above repeat the sign, or are zero
};

}  // namespace pliant
