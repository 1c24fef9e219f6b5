// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Converts stored numbers of any type to voxels: 16 bits while every value is a whole number that
// fits, floats from the first other value on. Values that aren't finite become air. Floats mapped
// from a file get the same treatment in place.

#pragma once

#include "formats/image_header.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace pliant {

using Voxels = std::variant<VoxelArray<std::int16_t>, VoxelArray<float>>;

class VoxelBuilder {
  public:
    /// @param count  total number of voxels
    explicit VoxelBuilder(std::size_t count) : m_count(count), m_shorts(count) {}

    /// Adds stored numbers. @param values  count numbers of that type
    /// @pre the total is not exceeded
    void add(Component component, const void* values, std::size_t count);
    /// Returns the voxels; missing ones are zero.
    /// @param[out] notes  changes of values that didn't fit
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

/// Whether a builder would store these as floats instead of 16-bit integers.
bool stay_floats(const VoxelArray<float>& values);

/// Replaces values that aren't finite by air. @param[out] notes  their number, as from a builder
void make_finite(VoxelArray<float>& values, std::vector<std::string>& notes);

/// Polls for cancellation between two pieces of a scan, and reports progress.
/// @param fraction  0…1
inline Status go_on(const std::filesystem::path& path, const ReadOptions& options,
                    double fraction) {
    if (options.give_up && options.give_up())
        return Error{ErrorCode::LimitExceeded, path.string() + ": the reading was given up"};
    if (options.progress) options.progress(fraction);
    return Ok{};
}

}  // namespace pliant
