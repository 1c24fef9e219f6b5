// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The elements: one per voxel, and beyond the scan's border as many as the motion reaches.
//
// The lattice is cut into cubes of brick_size³ elements. A brick comes into being when something in
// it moves, and goes when everything in it is back at rest; an element without a brick is at rest.
//
//     brick (0,0,0)   brick (1,0,0)
//    +-------------+-------------+       element ijk → brick ⌊ijk / size⌋, and inside it
//    | o o o … o o | o o o … o o |       index = x + size·(y + size·z)
//    | o o o … o o | o o o … o o |
//    +-------------+-------------+       neighbours: −x, +x, −y, +y, −z, +z

#pragma once

#include <pliant/chainmail.h>

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "chainmail/fixed_point.h"
#include "chainmail/material.h"

namespace pliant {

struct Brick {
    Vec3i coord;                                ///< of its first element, divided by the brick size
    std::array<int, 6> neighbours;              ///< brick indices, −1: not there
    std::array<std::unique_ptr<Fixed[]>, 3> u;  ///< displacement along i, j, k
    /// Where the elements of a solve in progress are: sign·u, raised (see propagation.h).
    std::array<std::unique_ptr<Fixed[]>, 3> raised;
    std::unique_ptr<MaterialId[]> material;
    std::array<bool, 3> reached{};               ///< by the solve in progress, per component
    Vec3<Fixed> u_min{0, 0, 0}, u_max{0, 0, 0};  ///< over the brick, after each push
};

struct ElementRef {
    int brick;
    int index;
    friend constexpr bool operator==(const ElementRef&, const ElementRef&) = default;
};

class Lattice {
  public:
    /// Keeps a reference to the volume.
    Lattice(const Volume& volume, const MaterialLaw& law, int brick_size);

    const Grid& grid() const { return m_volume.grid; }
    const MaterialTable& materials() const { return m_materials; }
    int brick_size() const { return m_size; }
    int elements_per_brick() const { return m_size * m_size * m_size; }
    int stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? m_size : m_size * m_size; }
    /// Indices of a brick's elements on its low or high side along an axis, in one fixed order.
    const std::vector<int>& face(int axis, bool high) const {
        return m_faces[std::size_t(2 * axis + high)];
    }

    Vec3i brick_of(Vec3i ijk) const;
    int index_in_brick(Vec3i ijk) const;
    Vec3i element_of(Vec3i brick_coord, int index) const;

    /// Material of an element, whether it has a brick or not; air beyond the scan.
    MaterialId material_at(Vec3i ijk) const;
    /// Displacement of an element along the lattice's axes; zero where there is no brick.
    Vec3<Fixed> displacement_at(Vec3i ijk) const;

    /// @returns −1 if it isn't there
    int find_brick(Vec3i coord) const;
    /// The brick, made if needed with everything at rest.
    int ensure_brick(Vec3i coord);
    ElementRef ensure_element(Vec3i ijk);
    /// Bounds of a brick's displacements, after they changed.
    void update_bounds(int index);
    /// Removes bricks where every displacement is zero.
    void drop_still_bricks();

    /// Indices of the bricks that are there, sorted by coordinate: the same order however they came
    /// into being.
    std::vector<int> resident_bricks() const;
    int resident_brick_count() const { return int(m_index_of.size()); }
    Brick& brick(int index) { return *m_bricks[std::size_t(index)]; }
    const Brick& brick(int index) const { return *m_bricks[std::size_t(index)]; }
    /// Bytes of all bricks that are there.
    std::size_t resident_bytes() const;

  private:
    struct CoordHash {
        std::size_t operator()(Vec3i c) const {
            return std::size_t(c.x) * 73856093u ^ std::size_t(c.y) * 19349663u ^
                   std::size_t(c.z) * 83492791u;
        }
    };

    std::unique_ptr<Brick> take_brick();
    void fill_materials(Brick& brick) const;

    const Volume& m_volume;
    MaterialTable m_materials;
    int m_size;
    std::array<std::vector<int>, 6> m_faces;
    std::vector<std::unique_ptr<Brick>> m_bricks;  ///< null where dropped
    std::vector<int> m_free_indices;
    std::vector<std::unique_ptr<Brick>> m_spare;  ///< dropped, to be used again
    std::unordered_map<Vec3i, int, CoordHash> m_index_of;
};

}  // namespace pliant
