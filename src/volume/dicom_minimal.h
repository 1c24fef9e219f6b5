// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A DICOM file of nothing but pixels: the elements that a decoder needs, with the values that
// passed our checks, and the codestream in one piece. Nothing else of the original is passed on.

#pragma once

#include "volume/dicom_slice.h"

#include <cstdint>
#include <vector>

namespace pliant {

/// Appends everything before the codestream, explicit and little endian.
/// @param bits              allocated for a pixel; 8, 16 or 32
/// @param codestream_bytes  even
void append_minimal_dicom(const DicomSlice& slice, int bits, std::uint32_t codestream_bytes,
                          std::vector<std::uint8_t>& file);

/// Appends what follows it.
void append_minimal_end(std::vector<std::uint8_t>& file);

}  // namespace pliant
