// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A sandboxed process that decodes compressed pixels with GDCM (src/io/decoder/sandbox.h). It
// receives a file and returns pixels. Every other behaviour (exit, crash, timeout, too little or
// too much output) is an error, after which the process is ended.
//
//   this process                        pliant-decode-pixels
//   decode() ── request, DICOM ──►  socket  ──►  read, GDCM
//            ◄── answer, pixels ──          ◄──  write

#pragma once

#include "formats/pixel_messages.h"

#include <pliant/result.h>

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace pliant {

/// Limits of a decoder.
struct DecoderLimits {
    double seconds_per_slice = 10;   ///< wall-clock time, from the request to the last pixel
    std::uint64_t slices = 1;        ///< 10 s of processor time for each
    std::uint64_t memory_bytes = 0;  ///< address space beyond that of its libraries
};

/// Candidate paths of the decoder program, in order: beside the running program; libexec/pliant and
/// lib/pliant above it; the same for the shared library that contains Pliant; the installation path
/// of this build.
std::vector<std::filesystem::path> decoder_paths();

/// Finds the first valid candidate. Programs of users other than this one and root, or with write
/// permission for all, are ignored. @returns NotFound with all paths
Result<std::filesystem::path> find_pixel_decoder(
    const std::vector<std::filesystem::path>& paths = decoder_paths());

class PixelDecoder {
  public:
    /// Starts a program with an empty environment, three empty standard streams, and a socket.
    static Result<PixelDecoder> start(const std::filesystem::path& program,
                                      const DecoderLimits& limits);
    PixelDecoder(PixelDecoder&& other) noexcept;
    PixelDecoder& operator=(PixelDecoder&& other) noexcept;
    ~PixelDecoder() { end(); }

    /// Decodes one file. Error messages don't name it.
    /// @param message      a PixelRequest, and the file
    /// @param[out] pixels  rows·columns pixels of the requested size
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
