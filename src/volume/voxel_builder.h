// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Turns stored numbers of any type into voxels: 16 bits as long as every value is a whole number
// that fits, floats from the first one that isn't. Values that aren't finite become air. Floats
// that are mapped from their file get the same treatment where they lie.

#pragma once

#include "volume/image_header.h"

#include <pliant/voxel_array.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace pliant {

using Voxels = std::variant<VoxelArray<std::int16_t>, VoxelArray<float>>;

class VoxelBuilder {
  public:
    /// @param count  voxels that will be added in all
    explicit VoxelBuilder(std::size_t count) : m_count(count), m_shorts(count) {}

    /// Adds stored numbers. @param values  count numbers of that type
    /// @pre no more in all than were announced
    void add(Component component, const void* values, std::size_t count);
    /// Those that were not added are zero.
    /// @param[out] notes  what happened to values that didn't fit
    Voxels finish(std::vector<std::string>& notes);

  private:
    template <class T>
    void add_values(const T* values, std::size_t count);
    void widen();

    std::size_t m_count;
    std::size_t m_added = 0;
    bool m_wide = false;  ///< floats are in use
    VoxelArray<std::int16_t> m_shorts;
    VoxelArray<float> m_floats;
    std::size_t m_not_finite = 0;
    std::size_t m_rounded = 0;
};

/// Whether a builder would make floats of these, and not 16-bit integers.
bool stay_floats(const VoxelArray<float>& values);

/// Makes values that aren't finite air. @param[out] notes  how many, as a builder would say
void make_finite(VoxelArray<float>& values, std::vector<std::string>& notes);

}  // namespace pliant
