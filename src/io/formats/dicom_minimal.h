// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A minimal DICOM file for the decoder: the elements that it needs, with values that passed our
// checks, and the codestream in one piece. Everything else of the original is left out.

#pragma once

#include "formats/dicom_slice.h"

#include <cstdint>
#include <vector>

namespace pliant {

/// Appends the part in front of the codestream, explicit little endian.
/// @param bits              allocated per pixel; 8, 16 or 32
/// @param codestream_bytes  even
void append_minimal_dicom(const DicomSlice& slice, int bits, std::uint32_t codestream_bytes,
                          std::vector<std::uint8_t>& file);

/// Appends the part after the codestream.
void append_minimal_end(std::vector<std::uint8_t>& file);

}  // namespace pliant
