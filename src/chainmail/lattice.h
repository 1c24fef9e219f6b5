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
#include <new>
#include <unordered_map>
#include <vector>

#include "chainmail/fixed_point.h"
#include "chainmail/material.h"

namespace pliant {

/// What was done to an element beside moving it: one byte of flags each.
enum ElementEdit : std::uint8_t {
    kCutX = 1,  ///< the link to the neighbour at +x is cut
    kCutY = 2,
    kCutZ = 4,
    kVoid = 8,  ///< carved away
};
using BrickEdits = std::vector<std::uint8_t>;  ///< elements_per_brick flags

struct FreeAligned {
    void operator()(void* memory) const { ::operator delete (memory, std::align_val_t{64}); }
};

struct Brick {
    Vec3i coord;                    ///< of its first element, divided by the brick size
    std::array<int, 6> neighbours;  ///< brick indices, −1: not there
    // Arrays of elements_per_brick, each aligned to 64 bytes, in one piece of memory.
    std::array<Fixed*, 3> u;  ///< displacement along i, j, k
    /// Where the elements of a solve in progress are: sign·u, raised (see propagation.h).
    std::array<Fixed*, 3> raised;
    MaterialId* material;
    const std::uint8_t* edits = nullptr;         ///< null: none in this brick
    std::array<bool, 3> reached{};               ///< by the solve in progress, per component
    Vec3<Fixed> u_min{0, 0, 0}, u_max{0, 0, 0};  ///< over the brick, after each push
    std::uint64_t changed_at = 0;                ///< Lattice::clock() when u last changed
    std::unique_ptr<void, FreeAligned> memory;
};

struct ElementRef {
    int brick;
    int index;
    friend constexpr bool operator==(const ElementRef&, const ElementRef&) = default;
};

class Lattice {
  public:
    /// Keeps a reference to the volume. @param bounded  whether elements beyond it are void
    Lattice(const Volume& volume, const std::vector<MaterialLaw>& laws, int brick_size,
            bool bounded);

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

    /// The scan's value, rounded; air beyond it. @returns HU
    int value_at(Vec3i ijk) const;
    /// Material of an element, whether it has a brick or not.
    MaterialId material_at(Vec3i ijk) const;
    bool is_void(Vec3i ijk) const { return material_at(ijk) == kVoidMaterial; }
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

    /// Flags of a brick's elements, whether it is there or not; null: none.
    const BrickEdits* edits_of(Vec3i brick_coord) const;
    /// Replaces them; all zero takes them away. A resident brick's materials follow.
    void set_edits(Vec3i brick_coord, BrickEdits edits);
    const auto& all_edits() const { return m_edits; }
    /// Counts changes of links: of edits and materials.
    std::uint64_t links_version() const { return m_links_version; }

    /// Links may be outside of their limits after a change of materials. They may then not get
    /// worse: solvers take the larger of a link's limit and what it has now.
    bool may_exceed_limits() const { return m_may_exceed; }
    void set_may_exceed_limits(bool may) { m_may_exceed = may; }

    /// Counts changes: a brick's changed_at is the clock's value at its last one.
    std::uint64_t clock() const { return m_clock; }
    std::uint64_t tick() { return ++m_clock; }

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
    std::size_t brick_bytes() const;
    void fill_materials(Brick& brick) const;

    const Volume& m_volume;
    MaterialTable m_materials;
    int m_size;
    bool m_bounded;
    bool m_may_exceed = false;
    std::uint64_t m_clock = 0;
    std::uint64_t m_links_version = 0;
    std::array<std::vector<int>, 6> m_faces;
    std::vector<std::unique_ptr<Brick>> m_bricks;  ///< null where dropped
    std::vector<int> m_free_indices;
    std::vector<std::unique_ptr<Brick>> m_spare;  ///< dropped, to be used again
    std::unordered_map<Vec3i, int, CoordHash> m_index_of;
    std::unordered_map<Vec3i, BrickEdits, CoordHash> m_edits;
};

}  // namespace pliant
