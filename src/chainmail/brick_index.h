// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which brick is at a coordinate: an array over the bricks of the scan, where nearly all are asked
// for, and an open-addressing table for those beyond its border. Neither allocates when a brick
// comes back that was there before.

#pragma once

#include <pliant/vec.h>

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

    /// @returns −1 if nothing is there
    int find(Vec3i coord) const {
        if (is_inside(coord)) return m_inside.get()[place_of(coord)] - 1;
        return find_outside(coord);
    }
    /// What is beside a coordinate: −x, +x, −y, +y, −z, +z; −1 where nothing is.
    std::array<int, 6> find_neighbours(Vec3i coord) const;
    /// @pre nothing is there. Allocates only where reserve_outside has not made room.
    void insert(Vec3i coord, int brick);
    /// @pre something is there
    void erase(Vec3i coord);
    bool is_inside(Vec3i c) const {
        return unsigned(c.x) < unsigned(m_size.x) && unsigned(c.y) < unsigned(m_size.y) &&
               unsigned(c.z) < unsigned(m_size.z);
    }
    /// Number of bricks beyond the border.
    std::size_t outside_count() const { return m_outside_count; }
    /// Makes room for a number of bricks beyond the border.
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

    std::size_t place_of(Vec3i c) const {
        return std::size_t(c.x) + std::size_t(m_size.x) *
                                      (std::size_t(c.y) + std::size_t(m_size.y) * std::size_t(c.z));
    }
    std::size_t home_of(Vec3i coord) const;
    int find_outside(Vec3i coord) const;
    void grow();

    Vec3i m_size;
    /// Index + 1; 0: nothing. From calloc, so that the parts nobody looks at take no memory.
    std::unique_ptr<int, Free> m_inside;
    std::vector<Slot> m_slots;  ///< linear probing; a power of two, at most half full
    std::size_t m_outside_count = 0;
};

}  // namespace pliant
