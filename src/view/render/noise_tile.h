// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Value noise with a period of 16 cells, and its gradient: baked at four samples per cell, then
// interpolated trilinearly. The page bakes the same tile (viewer/src/views/noise.ts) into a
// texture, so that both renderers draw the same blood vessels.

#pragma once

#include <pliant/core/vec.h>

#include <cstdint>
#include <vector>

namespace pliant::render {

inline Vec3d to_double(Vec3f v) {
    return {double(v.x), double(v.y), double(v.z)};
}

class NoiseTile {
  public:
    static constexpr int kCells = 16;
    static constexpr int kSamples = 4 * kCells;  ///< along each axis

    struct Value {
        Vec3f slope;  ///< per cell
        float value;  ///< 0…1, 0.5 on average
    };

    /// The shared tile, baked at the first call.
    static const NoiseTile& instance();

    /// @param q  any position [cells]
    Value at(Vec3d q) const;
    const std::vector<Value>& samples() const { return m_samples; }  ///< x fastest

  private:
    NoiseTile();

    std::vector<Value> m_samples;
};

}  // namespace pliant::render
