// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The size that a codestream says of itself, before a decoder sees it: decoders write as many
// pixels as the codestream has, whatever room the DICOM header made. Nothing is decoded here.
//
//   JPEG       FFD8, segments (marker, length), of which SOFn: bits, rows, columns, components
//   JPEG-LS    likewise, SOF55
//   JPEG 2000  FF4F FF51, SIZ: extent, origin, components; perhaps inside of JP2's boxes
//   RLE        16 numbers (how many segments, where they start), then a segment for each byte of a
//              pixel, the highest first: n ≥ 0: n+1 bytes follow; n < 0: one byte, 1−n times

#pragma once

#include "volume/dicom_slice.h"

#include <pliant/result.h>

#include <cstdint>
#include <span>

namespace pliant {

/// Whether a codestream has the rows and columns of the slice, one component, no more bits than are
/// allocated, and bytes enough for so many pixels.
/// @param[out] bits  of its pixels; RLE: as allocated
Status check_codestream(const DicomSlice& slice, std::span<const std::uint8_t> codestream,
                        int& bits);

}  // namespace pliant
