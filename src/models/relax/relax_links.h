// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A brick's links in the layout of relaxation: limits and elastic weights, in rows, including links
// across the brick's faces.
//
// Along axis b there is one more layer of links than of elements:
//
//     ·--o--o--o … o--·      link n lies below element n, link n + stride(b) above it
//     0  1  2        size
//
// An element's weight along b is inverse to the room that its material gives to a link along b,
// over all components and both directions, per length squared: the energy of a shift is then
// independent of the spacing,
//
//   w_b = 64 · (h_least / h_b)² / fraction_b,   fraction_b = (compress + stretch + 4·shear) / 6,
//
// rounded to a whole number in 1…32767. The weight of a link is the sum of its ends' weights, or
// zero if it is cut or leads to void. Weights from the slack of links are usual [Schulze2007];
// whole numbers make the energy exact.

#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "lattice/lattice.h"

namespace pliant {

/// Weights of the materials, by axis.
class ElasticWeights {
  public:
    ElasticWeights(const MaterialTable& materials, Vec3d spacing_mm);
    int operator()(MaterialId material, int b) const { return m_weights[std::size_t(b)][material]; }

  private:
    std::array<std::vector<std::uint16_t>, 3> m_weights;
};

/// Links of one brick, by link axis. Bounds of u_a(upper) − u_a(lower): −compress…stretch if a is
/// the link's axis, else −shear…shear.
struct BrickLinks {
    std::array<std::vector<Fixed>, 3> shear;
    std::array<std::vector<Fixed>, 3> stretch, compress;  ///< empty: equal to shear
    std::array<std::vector<std::uint16_t>, 3> weight;
    std::vector<std::uint8_t> fixed;  ///< by element, nonzero: doesn't move; empty: all move
    Fixed least_movement = 0;         ///< smallest movement limit of all movable elements

    std::size_t bytes() const;
};

/// Strides of the links' arrays along x, y, z for link axis b.
inline Vec3i link_strides(int size, int b) {
    const int row = size + (b == 0), rows = size + (b == 1);
    return {1, row, row * rows};
}

/// Creates links; bricks of one material share one set. Valid until materials or edits change.
class BrickLinksMaker {
  public:
    explicit BrickLinksMaker(const Lattice& lattice);
    /// Uses other limits than the lattice's own. @param limits  by material
    BrickLinksMaker(const Lattice& lattice, std::vector<HalfLimits> limits);
    /// Callable from several threads.
    std::shared_ptr<const BrickLinks> make(const Brick& brick) { return make(brick, true); }
    /// The same if only the elastic weights are needed: other arrays may be empty.
    std::shared_ptr<const BrickLinks> make_weights(const Brick& brick) {
        return make(brick, false);
    }

  private:
    struct Neighbourhood;
    Neighbourhood look_around(const Brick& brick) const;
    bool is_uniform(const Neighbourhood& around) const;
    std::shared_ptr<const BrickLinks> make(const Brick& brick, bool with_limits);
    BrickLinks links_of(const Neighbourhood& around) const;
    void fill_limits(const Neighbourhood& around, int b, BrickLinks& links) const;
    void fill_weights(const Neighbourhood& around, int b, BrickLinks& links) const;
    template <class Visit>
    void for_each_link(const Neighbourhood& around, int b, const Visit& visit) const;

    const Lattice& m_lattice;
    std::vector<HalfLimits> m_limits;  ///< by material
    bool m_is_symmetric;               ///< compress, stretch and shear are equal
    ElasticWeights m_weights;
    std::mutex m_mutex;  ///< guards m_uniform
    std::unordered_map<MaterialId, std::shared_ptr<const BrickLinks>> m_uniform;
};

}  // namespace pliant
