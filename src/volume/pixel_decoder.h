// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A process that decodes compressed pixels with GDCM, and may do nothing else
// (src/decoder/sandbox.h). It gets a file and gives back pixels; whatever else it does (ends,
// crashes, hangs, says too little or too much) is an error, after which it is gone.
//
//   this process                        pliant-decode-pixels
//   decode() ── request, DICOM ──►  socket  ──►  read, GDCM
//            ◄── answer, pixels ──          ◄──  write

#pragma once

#include "volume/pixel_messages.h"

#include <pliant/result.h>

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace pliant {

/// What a decoder may use.
struct DecoderLimits {
    double seconds_per_slice = 10;   ///< by the clock, from the request to the last pixel
    std::uint64_t slices = 1;        ///< so many times 10 s of processor time in all
    std::uint64_t memory_bytes = 0;  ///< address space beside that of its libraries
};

/// Places where the program that decodes may be, in the order in which they are tried: beside the
/// running program; libexec/pliant and lib/pliant above it; the same for the shared library that
/// holds Pliant; where this build installs it.
std::vector<std::filesystem::path> decoder_places();

/// The first of these places that has it. Programs of other users than this one and root, or that
/// all may write, don't count. @returns NotFound with all places
Result<std::filesystem::path> find_pixel_decoder(
    const std::vector<std::filesystem::path>& places = decoder_places());

class PixelDecoder {
  public:
    /// Starts a program with an empty environment, three empty standard streams, and a socket.
    static Result<PixelDecoder> start(const std::filesystem::path& program,
                                      const DecoderLimits& limits);
    PixelDecoder(PixelDecoder&& other) noexcept;
    PixelDecoder& operator=(PixelDecoder&& other) noexcept;
    ~PixelDecoder() { end(); }

    /// Decodes one file. Messages of errors don't name it.
    /// @param message      a PixelRequest, and the file
    /// @param[out] pixels  rows·columns pixels of the size that was requested
    /// @returns whether they are signed
    Result<bool> decode(std::span<const std::uint8_t> message, std::span<std::uint8_t> pixels);

  private:
    PixelDecoder(pid_t process, int socket, double seconds)
        : m_process(process), m_socket(socket), m_seconds(seconds) {}
    Error lost();
    void end() noexcept;

    pid_t m_process = -1;
    int m_socket = -1;
    double m_seconds = 10;
};

}  // namespace pliant
