// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacements of the elements of a scan, with cut links and void elements: the part of a
// deformation that is common to all models. One element per voxel, and beyond the scan's border as
// many as the motion reaches.
//
// The elements are divided into cubes of brick_size³. A brick is created when an element in it
// moves, and dropped when all are back at rest; an element without a brick is at rest.
//
//     brick (0,0,0)   brick (1,0,0)
//    +-------------+-------------+       element ijk → brick ⌊ijk / size⌋, and inside it
//    | o o o … o o | o o o … o o |       index = x + size·(y + size·z)
//    | o o o … o o | o o o … o o |
//    +-------------+-------------+       neighbours: −x, +x, −y, +y, −z, +z
//
// Field has the read access. A model writes through a class of its own: Lattice (ChainMail) keeps
// materials and the solver's memory in its bricks as well, WritableField has no other data.

#pragma once

#include <pliant/deformation.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/memory.h"
#include "field/fixed_point.h"

#pragma GCC visibility push(default)  // for other components

namespace pliant {

// Finds the brick at a coordinate: an array over the bricks of the scan, which get nearly all
// queries, and an open-addressing table for bricks beyond its border. Neither allocates when a
// former brick comes back.

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

using BrickEdits = std::vector<std::uint8_t>;  ///< elements_per_brick flags; empty: none

/// Elements along a brick's edge, at most.
inline constexpr int kMaxBrickSize = 32;

struct FieldBrick {
    Vec3i coord;                    ///< of its first element, divided by the brick size
    std::array<int, 6> neighbours;  ///< brick indices, −1: none
    /// Displacements along i, j, k: elements_per_brick each, aligned to 64 bytes.
    std::array<Fixed*, 3> u;
    const std::uint8_t* edits = nullptr;  ///< null: none in this brick
    bool is_unplaced = false;             ///< u is not written yet, and counts as zero
    std::array<bool, 3> holds_zeros{};    ///< while unplaced: the memory of u is already zero
    /// Bounds over the brick. Wider while a drag has fields (Drag::move).
    Vec3<Fixed> u_min{0, 0, 0}, u_max{0, 0, 0};
    std::uint64_t changed_at = 0;  ///< Field::clock() at the last change of u
    std::uint64_t serial = 0;      ///< Field::made_count() at its creation
};

/// Parity of a brick on a chess board of two colours: neighbours differ.
inline bool is_odd(Vec3i coord) {
    return ((coord.x ^ coord.y ^ coord.z) & 1) != 0;
}

/// Whether every element of the brick is at its rest position.
inline bool is_at_rest(const FieldBrick& brick) {
    return brick.u_min == Vec3<Fixed>{0, 0, 0} && brick.u_max == Vec3<Fixed>{0, 0, 0};
}

/// Coordinate of the neighbour on a side.
inline Vec3i coord_behind(const FieldBrick& brick, int side) {
    Vec3i coord = brick.coord;
    coord[side / 2] += side % 2 ? 1 : -1;
    return coord;
}

struct CoordHash {
    std::size_t operator()(Vec3i c) const {
        return std::size_t(c.x) * 73856093u ^ std::size_t(c.y) * 19349663u ^
               std::size_t(c.z) * 83492791u;
    }
};

/// Edits by brick coordinate.
using EditMap = std::unordered_map<Vec3i, BrickEdits, CoordHash>;

/// Memory of one brick [bytes].
struct BrickLayout {
    std::size_t header;  ///< FieldBrick, or a model's type derived from it
    std::size_t arrays;  ///< all arrays, each in whole cache lines
};

class Field {
  public:
    /// @param bounded  whether elements beyond the grid are void
    Field(const Grid& grid, int brick_size, bool bounded, BrickLayout layout);
    virtual ~Field() = default;
    Field(Field&&) = default;
    Field& operator=(Field&&) = default;

    const Grid& grid() const { return m_grid; }
    int brick_size() const { return m_size; }
    bool is_bounded() const { return m_bounded; }
    int elements_per_brick() const { return m_size * m_size * m_size; }
    int stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? m_size : m_size * m_size; }

    Vec3i brick_of(Vec3i ijk) const;
    int index_in_brick(Vec3i ijk) const { return index_in_brick(ijk, brick_of(ijk)); }
    int index_in_brick(Vec3i ijk, Vec3i brick_coord) const {
        const Vec3i local = ijk - m_size * brick_coord;
        return local.x + m_size * (local.y + m_size * local.z);
    }
    Vec3i element_of(Vec3i brick_coord, int index) const;

    /// Whether an element is carved, or beyond the border of a bounded field.
    bool is_void(Vec3i ijk) const;
    /// Displacement of an element along the grid's axes; zero where there is no brick.
    Vec3<Fixed> displacement_at(Vec3i ijk) const;

    /// @returns −1 if there is no brick
    int find_brick(Vec3i coord) const { return m_index_of.find(coord); }
    /// Edits of a brick, resident or not; null: none.
    const BrickEdits* edits_of(Vec3i brick_coord) const;
    const EditMap& all_edits() const { return m_edits; }
    /// Number of changes of links: of edits, and of materials if the model has them.
    std::uint64_t links_version() const { return m_links_version; }
    /// False if every element has all its links.
    bool may_have_gaps() const { return m_bounded || !m_edits.empty(); }
    /// Whether the link from an element to its neighbour at + along an axis exists: not cut, and
    /// without a void end.
    bool is_linked(Vec3i low, int axis) const;

    /// Number of changes: a brick's changed_at is the clock's value at its last one.
    std::uint64_t clock() const { return m_clock; }
    /// Number of bricks created so far.
    std::uint64_t made_count() const { return m_made_count; }

    /// Indices of the resident bricks, sorted by coordinate: independent of the order of creation.
    std::vector<int> resident_bricks() const;
    int resident_brick_count() const { return m_resident_count; }
    bool is_resident(int index) const { return m_bricks[std::size_t(index)] != nullptr; }
    /// Upper bound of brick indices.
    int brick_index_bound() const { return int(m_bricks.size()); }
    /// Calls visit(brick) for each resident brick, in unspecified order; or for each with an index
    /// from `begin` to `end`.
    template <class Visit>
    void for_each_brick(const Visit& visit) const {
        for_each_brick(0, brick_index_bound(), visit);
    }
    template <class Visit>
    void for_each_brick(int begin, int end, const Visit& visit) const {
        for (int index = begin; index < end; ++index)
            if (const FieldBrick* brick = m_bricks[std::size_t(index)]) visit(*brick);
    }
    const FieldBrick& brick(int index) const { return *m_bricks[std::size_t(index)]; }
    /// Memory of all resident bricks and edits [bytes].
    std::size_t resident_bytes() const;

  protected:
    static constexpr std::size_t kLine = 64;  ///< size of a cache line [bytes]

    /// Size of an array with a value for each element, in whole cache lines [bytes].
    template <class T>
    static constexpr std::size_t array_bytes(int brick_size) {
        const std::size_t count = std::size_t(brick_size) * std::size_t(brick_size * brick_size);
        return (count * sizeof(T) + kLine - 1) / kLine * kLine;
    }
    /// The next array of a brick's memory.
    template <class T>
    T* next_array(std::byte*& memory) const {
        return reinterpret_cast<T*>(std::exchange(memory, memory + array_bytes<T>(m_size)));
    }

    // Bricks of a derived model.

    /// Creates a brick with its arrays in `memory`. It lives as long as the field.
    virtual FieldBrick& make_brick(std::byte* memory) = 0;
    /// Called when a brick is taken into use. @param is_elsewhere  it is new, or had another
    /// coordinate
    virtual void begin_brick(FieldBrick&, bool is_elsewhere) noexcept { (void)is_elsewhere; }
    /// Called when edits of a resident brick have changed.
    virtual void follow_edits(FieldBrick&) noexcept {}
    /// Called when edits have changed at the coordinate of a dropped brick.
    virtual void forget_dropped(FieldBrick&) noexcept {}

    FieldBrick& brick_to_write(int index) { return *m_bricks[std::size_t(index)]; }
    /// Creates a missing brick; its displacements are not placed.
    int add_brick(Vec3i coord);
    /// Writes zero to all displacements. The memory of a reused brick may be zero already, for
    /// components that never moved.
    void place_at_rest(FieldBrick& brick) const;
    /// Updates the bounds of a brick after a change of its displacements.
    void update_bounds(FieldBrick& brick) const;
    /// Removes bricks in which every displacement is zero: all of them, or among the given ones.
    /// Can't fail, and a dropped brick comes back without an allocation.
    void drop_still_bricks() noexcept;
    void drop_still_bricks(std::span<const int> bricks) noexcept;
    /// Returns all elements to rest; element edits stay.
    void drop_all_bricks() noexcept;
    /// Removes bricks at rest that were created after the count had this value.
    void drop_made_since(std::uint64_t made_count) noexcept;
    /// Calls forget_dropped for all dropped bricks.
    void forget_all_dropped() noexcept;

    /// Replaces a brick's edits; all-zero edits remove them.
    void set_edits(Vec3i brick_coord, BrickEdits edits);
    /// Exchange of the edits of several bricks in three calls, of which only the first can fail; it
    /// has no effect then. A second call of exchange_edits reverts the first.
    void prepare_edits(const EditMap& edits);
    void exchange_edits(EditMap& edits) noexcept;
    void finish_edits(const EditMap& edits) noexcept;
    /// Restores edits that were replaced since they were saved. Leaves `saved` unspecified.
    void restore_edits(EditMap& saved) noexcept;

    void drop_all_edits() noexcept;

    std::uint64_t tick() { return ++m_clock; }
    /// Sets the clock of a field that replaces another: no new stamp equals an old one.
    void continue_clock(std::uint64_t clock) { m_clock = clock; }
    void count_links_change() { ++m_links_version; }
    /// The part of a brick that lies in the grid, relative to its first element.
    Box3i part_in_grid(Vec3i brick_coord) const;

  private:
    void make_room_for(Vec3i coord);
    void drop_brick(int index) noexcept;
    void edits_changed(Vec3i brick_coord) noexcept;
    FieldBrick& take_brick(Vec3i coord);
    FieldBrick& take_spare(int index);
    void keep_spare(FieldBrick& dropped);
    void look_at_memory() const;
    void take_slab();
    FieldBrick& carve_brick();

    Grid m_grid;
    int m_size;
    bool m_bounded;
    BrickLayout m_layout;
    std::uint64_t m_clock = 0;
    std::uint64_t m_links_version = 0;
    std::uint64_t m_made_count = 0;
    std::vector<FieldBrick*> m_bricks;  ///< null if dropped
    std::vector<int> m_free_indices;
    /// Dropped bricks for reuse, preferably at their former coordinate, since a model may keep data
    /// of the elements there.
    std::vector<FieldBrick*> m_spare;
    int m_resident_count = 0;
    BrickIndex m_index_of;
    BrickIndex m_spare_at;  ///< positions in m_spare
    /// Memory of the bricks, many per allocation: huge pages if the system has them.
    std::vector<AlignedMemory<void>> m_slabs;
    std::byte* m_slab_rest = nullptr;
    std::size_t m_slab_bricks_left = 0;
    EditMap m_edits;  ///< none is empty except during an exchange
};

}  // namespace pliant
#pragma GCC visibility pop
