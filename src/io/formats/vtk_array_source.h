// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reader of an array in VTK's XML files, block by block:
//
//   length in bytes, numbers                             without compression
//   blocks, length of a block, length of the last one    with it; 0: the last one is full too
//   (or 0), compressed length of each block, blocks
//
// all in base64, or as they are. Base64 may be padded between two parts. The lengths must agree
// with the image's size before memory is allocated.

#pragma once

#include "base/input_file.h"
#include "formats/image_header.h"

#include <pliant/result.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace pliant {

class VtkArraySource {
  public:
    /// Keeps a reference to the path.
    /// @param start     of the array in the file [bytes]
    /// @param expected  bytes of the numbers
    /// @param big       the lengths have the big-endian order
    VtkArraySource(const std::filesystem::path& path, std::uint64_t start, const VtkArray& array,
                   bool big, std::uint64_t expected);

    /// Reads the next bytes of the numbers.
    Status read(std::span<std::byte> out);

  private:
    bool fill();
    bool decode_four(std::uint8_t* out, int& count);
    bool take(std::byte* out, std::size_t count);
    bool take_count(std::uint64_t& count);
    Status read_lengths();
    Status read_block();

    const std::filesystem::path& m_path;
    InputFile m_file;
    VtkArray m_array;
    bool m_big;
    std::uint64_t m_expected, m_left_in_file = 0;
    std::vector<char> m_input;  ///< of the file
    std::size_t m_at = 0;       ///< in m_input
    std::array<std::byte, 3> m_decoded{};
    int m_decoded_at = 0, m_decoded_count = 0;
    bool m_started = false;
    std::uint64_t m_block_bytes = 0, m_last_bytes = 0;
    std::vector<std::uint64_t> m_lengths;  ///< of the compressed blocks
    std::size_t m_next_block = 0;
    std::vector<std::byte> m_packed, m_block;
    std::size_t m_block_at = 0;
};

}  // namespace pliant
