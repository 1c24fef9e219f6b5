// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Voxels in the format of the page's texture: half floats (IEEE 754 binary16), and their checksum.

#pragma once

#include <pliant/volume.h>

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/half.h"

namespace pliant::serve {

using pliant::float_from_half;
using pliant::half_from_float;

/// Converts the voxels of a box, i fastest. @pre the box lies in the volume
/// @param[out] halves  one per voxel
void halves_of_box(const Volume& volume, const Box3i& box, std::span<std::uint16_t> halves);

/// Converts every step-th voxel along each axis, i fastest.
/// @param box  of these: its index n is the voxel n · step. @pre all of them lie in the volume
/// @param[out] halves  one per node of the box
void halves_of_every(const Volume& volume, int step, const Box3i& box,
                     std::span<std::uint16_t> halves);

/// MurmurHash3_x86_32 with seed 0 [Appleby2011]. All parts except the last are whole words.
class Murmur32 {
  public:
    void add(std::span<const std::byte> bytes);
    std::uint32_t value() const;

  private:
    std::uint32_t m_state = 0;
    std::uint32_t m_size = 0;
};

/// Checksum of all voxels as half floats, i fastest: that of an up-to-date client.
std::uint32_t checksum_of_halves(const Volume& volume);

}  // namespace pliant::serve
