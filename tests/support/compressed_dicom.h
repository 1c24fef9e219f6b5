// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// DICOM slices around the codestreams of tests/formats/data, which GDCM encoded: 12 × 10 pixels of
// one pattern, each named like its codec and its kind of pixels (u8, s8, u12, s12, u16, s16).

#pragma once

#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <filesystem>
#include <string>

namespace pliant::test {

/// A codestream of tests/formats/data.
struct Codec {
    const char *syntax, *name, *kind;
};

/// Each codec once, and both transfer syntaxes of lossless JPEG.
inline constexpr Codec kCodecs[] = {{"4.50", "jpeg_baseline", "u8"},
                                    {"4.51", "jpeg_extended", "u12"},
                                    {"4.57", "jpeg_lossless", "s16"},
                                    {"4.70", "jpeg_lossless", "u12"},
                                    {"4.80", "jpeg_ls", "u16"},
                                    {"4.90", "jpeg_2000", "s12"},
                                    {"5", "rle", "u16"}};

/// @param syntax  last parts of the transfer syntax's UID: 5, 4.50, …
inline DicomFile compressed(const std::string& syntax, const std::string& codec,
                            const std::string& kind) {
    DicomFile slice;
    slice.syntax = "1.2.840.10008.1.2." + syntax;
    slice.rows = 10;
    slice.columns = 12;
    slice.bits_stored = std::uint16_t(std::stoi(kind.substr(1)));
    slice.bits_allocated = slice.bits_stored == 8 ? 8 : 16;
    slice.high_bit = std::uint16_t(slice.bits_stored - 1);
    slice.is_signed = kind[0] == 's';
    slice.fragments = {bytes_of(std::filesystem::path(PLIANT_TEST_DATA) / (codec + "_" + kind))};
    return slice;
}

inline DicomFile compressed(const Codec& codec) {
    return compressed(codec.syntax, codec.name, codec.kind);
}

}  // namespace pliant::test
