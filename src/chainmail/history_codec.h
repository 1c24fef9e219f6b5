// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How displacements are made small, for the history and for files.
//
// The change of a brick's displacements is predicted along x, y and z: what remains is how much an
// element's change differs from the one that its neighbours before it would lead one to expect.
// Where links are taut, or where all move alike, that is nothing or little, so most of the four
// byte planes of these numbers are zero. Those that aren't go to LZ4. Everything is done modulo
// 2³², so it is exact whatever the numbers.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "chainmail/fixed_point.h"

namespace pliant {

using Bytes = std::vector<std::byte>;
using Components = std::array<const Fixed*, 3>;

/// Appends how `after` differs from `before`, arrays of brick_size³.
/// @returns false, with nothing appended, where they are equal
bool encode_change(const Components& before, const Components& after, int brick_size, Bytes& out);

/// Reads one change from the front of `in`, and removes it from there.
/// @param[out] change  after − before, brick_size³ numbers for each component
/// @returns false if `in` is too short
[[nodiscard]] bool decode_change(std::span<const std::byte>& in, int brick_size,
                                 const std::array<std::uint32_t*, 3>& change);

/// LZ4.
Bytes pack(std::span<const std::byte> raw);
/// @returns false if `packed` is damaged, or isn't raw.size() bytes long when unpacked
[[nodiscard]] bool unpack(std::span<const std::byte> packed, std::span<std::byte> raw);
/// Longest length that so many packed bytes can unpack to.
std::size_t longest_unpacked(std::size_t packed_size);

}  // namespace pliant
