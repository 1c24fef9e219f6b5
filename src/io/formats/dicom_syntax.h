// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Transfer syntaxes of DICOM: how elements are written and how pixels are encoded [DICOM2024]
// (PS3.5).

#pragma once

#include <string>
#include <string_view>

namespace pliant {

/// How pixels are encoded.
enum class PixelCodec {
    None,      ///< uncompressed
    Rle,       ///< PS3.5 annex G
    Jpeg,      ///< DCT or lossless, ITU-T T.81
    JpegLs,    ///< ITU-T T.87
    Jpeg2000,  ///< ITU-T T.800, bare or in JP2 boxes
};

struct TransferSyntax {
    std::string_view uid;
    PixelCodec codec = PixelCodec::None;
    bool explicit_types = true;  ///< elements name their value representation
    bool big_endian = false;
    bool deflated = false;  ///< all elements behind group 2
};

/// @returns null if Pliant doesn't support it
const TransferSyntax* find_transfer_syntax(std::string_view uid);

/// "High-Throughput JPEG 2000 (transfer syntax 1.2.840.10008.1.2.4.201)", for messages.
std::string describe_transfer_syntax(std::string_view uid);

/// Whether elements can be read even if pixels can't: all syntaxes with encapsulated pixels are
/// explicit little endian.
bool has_plain_elements(std::string_view uid);

}  // namespace pliant
