// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Finds the brick at a coordinate: an array over the bricks of the scan, which get nearly all
// queries, and an open-addressing table for bricks beyond its border. Neither allocates when a
// former brick comes back.

#pragma once

#include <pliant/core/vec.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

namespace pliant {

class BrickIndex {
  public:
    /// @param size  bricks with coordinates 0 … size − 1 are looked up in the array
    explicit BrickIndex(Vec3i size);

    /// @returns −1 if there is none
    int find(Vec3i coord) const {
        if (is_inside(coord)) return m_inside.get()[index_of(coord)] - 1;
        return find_outside(coord);
    }
    /// Neighbours of a coordinate: −x, +x, −y, +y, −z, +z; −1 for none.
    std::array<int, 6> find_neighbours(Vec3i coord) const;
    /// @pre there is none. Allocates only if reserve_outside has not reserved memory.
    void insert(Vec3i coord, int brick);
    /// @pre there is one
    void erase(Vec3i coord);
    bool is_inside(Vec3i c) const {
        return unsigned(c.x) < unsigned(m_size.x) && unsigned(c.y) < unsigned(m_size.y) &&
               unsigned(c.z) < unsigned(m_size.z);
    }
    /// Number of bricks beyond the border.
    std::size_t outside_count() const { return m_outside_count; }
    /// Reserves memory for a number of bricks beyond the border.
    void reserve_outside(std::size_t count) {
        while (2 * count > m_slots.size()) grow();
    }

  private:
    struct Slot {
        Vec3i coord;
        int brick_plus_one;  ///< 0: empty
    };
    struct Free {
        void operator()(int* memory) const { std::free(memory); }
    };

    std::size_t index_of(Vec3i c) const {
        return std::size_t(c.x) + std::size_t(m_size.x) *
                                      (std::size_t(c.y) + std::size_t(m_size.y) * std::size_t(c.z));
    }
    std::size_t home_of(Vec3i coord) const;
    int find_outside(Vec3i coord) const;
    void grow();

    Vec3i m_size;
    /// Index + 1; 0: none. From calloc, so that untouched parts take no memory.
    std::unique_ptr<int, Free> m_inside;
    std::vector<Slot> m_slots;  ///< linear probing; a power of two, at most half full
    std::size_t m_outside_count = 0;
};

}  // namespace pliant
