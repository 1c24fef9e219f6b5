// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Compression of displacements, for the history and for files.
//
// The change of a brick's displacements is predicted along x, y and z: each element stores the
// difference between its change and the change expected from its preceding neighbours. Where links
// are taut, or all elements move alike, that is zero or small, so most of the four byte planes of
// these numbers are zero. The others are compressed by LZ4. All arithmetic is modulo 2³², so it is
// exact for all numbers.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/state_frame.h"
#include "material/limit_units.h"

namespace pliant {

using Components = std::array<const Fixed*, 3>;

/// Appends the difference between `after` and `before`, arrays of brick_size³.
/// @returns false, with nothing appended, if they are equal
bool encode_change(const Components& before, const Components& after, int brick_size, Bytes& out);

/// Reads one change from the front of `in`, and removes it from there.
/// @param[out] change  after − before, brick_size³ numbers for each component
/// @returns false if `in` is too short
[[nodiscard]] bool decode_change(std::span<const std::byte>& in, int brick_size,
                                 const std::array<std::uint32_t*, 3>& change);

/// Compresses by LZ4.
Bytes pack(std::span<const std::byte> raw);
/// @returns false if `packed` is damaged, or isn't raw.size() bytes long when unpacked
[[nodiscard]] bool unpack(std::span<const std::byte> packed, std::span<std::byte> raw);
/// Maximum unpacked length for a packed length.
std::size_t longest_unpacked(std::size_t packed_size);

}  // namespace pliant
