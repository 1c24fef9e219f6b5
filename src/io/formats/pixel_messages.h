// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Protocol between Pliant and the pixel decoder, over a socket, in the machine's byte order:
//
//   Pliant →  PixelRequest, a DICOM file of dicom_bytes
//   Pliant ←  PixelAnswer; if status is Decoded, rows·columns pixels of bytes_per_pixel
//
// Any number of requests in sequence. The program ends when the socket is closed.

#pragma once

#include <cstdint>

namespace pliant {

inline constexpr const char* kDecoderName = "pliant-decode-pixels";
/// Descriptor of the program's socket.
inline constexpr int kDecoderSocket = 3;

struct PixelRequest {
    static constexpr std::uint32_t kMagic = 0x504c5131;
    std::uint32_t magic = kMagic;
    std::uint32_t columns = 0, rows = 0;
    std::uint32_t bytes_per_pixel = 0;  ///< 1, 2 or 4: of the answer, for every file
    std::uint64_t dicom_bytes = 0;
};

enum class PixelStatus : std::uint32_t { Decoded = 1, Undecodable = 2, OutOfMemory = 3 };

struct PixelAnswer {
    static constexpr std::uint32_t kMagic = 0x504c4131;
    std::uint32_t magic = kMagic;
    PixelStatus status = PixelStatus::Undecodable;
    std::uint32_t is_signed = 0;
    std::uint32_t unused = 0;
};

}  // namespace pliant
