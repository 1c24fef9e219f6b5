// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Decodes a DICOM file in memory by GDCM.

#pragma once

#include "formats/pixel_messages.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pliant::decoder {

/// @param[out] pixels  columns·rows numbers of bytes_per_pixel, little endian
/// @param[out] is_signed  whether these are signed
PixelStatus decode(const PixelRequest& request, std::span<char> dicom, std::vector<char>& pixels,
                   bool& is_signed);

}  // namespace pliant::decoder
