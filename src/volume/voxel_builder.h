// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Turns stored numbers of any type into voxels: 16 bits as long as every value is a whole number
// that fits, floats from the first one that isn't. Values that aren't finite become air.

#pragma once

#include "volume/image_header.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace pliant {

using Voxels = std::variant<std::vector<std::int16_t>, std::vector<float>>;

class VoxelBuilder {
  public:
    /// @param count  voxels that will be added in all
    explicit VoxelBuilder(std::size_t count) : m_count(count) {}

    /// Adds stored numbers. @param values  count numbers of that type
    void add(Component component, const void* values, std::size_t count);
    /// @param[out] notes  what happened to values that didn't fit
    Voxels finish(std::vector<std::string>& notes);

  private:
    template <class T>
    void add_values(const T* values, std::size_t count);
    void widen();

    std::size_t m_count;
    bool m_wide = false;  ///< floats are in use
    std::vector<std::int16_t> m_shorts;
    std::vector<float> m_floats;
    std::size_t m_not_finite = 0;
    std::size_t m_rounded = 0;
};

}  // namespace pliant
