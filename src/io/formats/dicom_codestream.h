// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The image size in a codestream's header. It is checked before decoding, because decoders write as
// many pixels as the codestream has, independent of the size in the DICOM header. This code decodes
// no pixels.
//
//   JPEG       FFD8, segments (marker, length), of which SOFn: bits, rows, columns, components
//   JPEG-LS    likewise, SOF55
//   JPEG 2000  FF4F FF51, SIZ: extent, origin, components; perhaps inside of JP2's boxes
//   RLE        16 numbers (number of segments, their offsets), then a segment for each byte of a
//              pixel, the highest first: n ≥ 0: n+1 bytes follow; n < 0: one byte, 1−n times

#pragma once

#include "formats/dicom_slice.h"

#include <pliant/result.h>

#include <cstdint>
#include <span>

namespace pliant {

/// Checks that a codestream has the rows and columns of the slice, one component, at most the
/// allocated bits, and enough bytes for its pixels.
/// @param[out] bits  bits of its pixels; RLE: the allocated bits
Status check_codestream(const DicomSlice& slice, std::span<const std::uint8_t> codestream,
                        int& bits);

}  // namespace pliant
