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
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "chainmail/brick_index.h"
#include "chainmail/fixed_point.h"
#include "chainmail/material_map.h"
#include "core/memory.h"

namespace pliant {

/// What was done to an element beside moving it: one byte of flags each.
enum ElementEdit : std::uint8_t {
    kCutX = 1,  ///< the link to the neighbour at +x is cut
    kCutY = 2,
    kCutZ = 4,
    kVoid = 8,  ///< carved away
};
using BrickEdits = std::vector<std::uint8_t>;  ///< elements_per_brick flags; empty: none

struct FreeMemory {
    void operator()(void* memory) const { std::free(memory); }
};

/// Beside the flags of MaterialTrait, in Brick::traits. Elements beyond the border of a bounded
/// lattice don't count as a material of their own.
inline constexpr std::uint8_t kMixedMaterials = 128, kPartlyBeyond = 64;

struct Brick {
    Vec3i coord;                    ///< of its first element, divided by the brick size
    std::array<int, 6> neighbours;  ///< brick indices, −1: not there
    // Arrays of elements_per_brick, each aligned to 64 bytes, in one piece of memory.
    std::array<Fixed*, 3> u;  ///< displacement along i, j, k
    /// Where the elements of a solve in progress are: sign·u, raised (see propagation.h).
    std::array<Fixed*, 3> raised;
    MaterialId* material;
    const std::uint8_t* edits = nullptr;  ///< null: none in this brick
    std::array<bool, 3> reached{};        ///< by the solve in progress, per component
    std::uint8_t traits = 0;              ///< of all materials in it, and kMixedMaterials
    Fixed least_movement = 0;             ///< smallest movement limit of all that moves
    bool is_blank = false;                ///< materials and traits are not filled in yet
    bool is_unplaced = false;             ///< u is not written yet, and counts as zero
    std::array<bool, 3> holds_zeros{};    ///< while unplaced: u is all zero by chance
    /// Over the brick, after each push. Wider while a drag has fields (Drag::move).
    Vec3<Fixed> u_min{0, 0, 0}, u_max{0, 0, 0};
    std::uint64_t changed_at = 0;  ///< Lattice::clock() when u last changed
    std::uint64_t saved_for = 0;   ///< step of the history that has it as it was
    std::uint64_t serial = 0;      ///< Lattice::made_count() when it was made
};

/// One of two colours of bricks, as on a chess board: neighbours differ.
inline bool is_odd(Vec3i coord) {
    return ((coord.x ^ coord.y ^ coord.z) & 1) != 0;
}

/// Whether every element of the brick is at its rest place.
inline bool is_at_rest(const Brick& brick) {
    return brick.u_min == Vec3<Fixed>{0, 0, 0} && brick.u_max == Vec3<Fixed>{0, 0, 0};
}

/// Where the neighbour on a side is.
inline Vec3i coord_behind(const Brick& brick, int side) {
    Vec3i coord = brick.coord;
    coord[side / 2] += side % 2 ? 1 : -1;
    return coord;
}

struct PlasticBrick;

/// Told before something changes, where it may have to be taken back. Nothing may change where a
/// call throws.
class LatticeObserver {
  public:
    virtual ~LatticeObserver() = default;
    /// Of a brick whose displacements change; may be called from several threads.
    virtual void before_move(Brick& brick) = 0;
    /// Gets all memory that before_move needs for a brick, which then can't fail.
    virtual void reserve_move(Brick& brick) = 0;
    virtual void before_edit(Vec3i coord, const BrickEdits* edits) = 0;
    virtual void before_imprint(Vec3i coord, const PlasticBrick* imprint) = 0;
    /// Changes where bricks that it was told of may have to be told of again.
    virtual std::uint64_t step() const = 0;
};

struct CoordHash {
    std::size_t operator()(Vec3i c) const {
        return std::size_t(c.x) * 73856093u ^ std::size_t(c.y) * 19349663u ^
               std::size_t(c.z) * 83492791u;
    }
};

/// By brick coordinate.
using EditMap = std::unordered_map<Vec3i, BrickEdits, CoordHash>;

struct ElementRef {
    int brick;
    int index;
    friend constexpr bool operator==(const ElementRef&, const ElementRef&) = default;
};

class Lattice {
  public:
    /// Keeps a reference to the volume. @param bounded  whether elements beyond it are void
    Lattice(const Volume& volume, MaterialMap materials, int brick_size, bool bounded);
    Lattice(const Volume& volume, const std::vector<MaterialLaw>& laws, int brick_size,
            bool bounded)
        : Lattice(volume, MaterialMap(volume, laws), brick_size, bounded) {}

    const Grid& grid() const { return m_volume.grid; }
    const MaterialTable& materials() const { return m_materials.table(); }
    const MaterialMap& material_map() const { return m_materials; }
    /// Exchanges the materials with others; nothing moves. Can't fail.
    void exchange_materials(MaterialMap& materials) noexcept;
    int brick_size() const { return m_size; }
    bool is_bounded() const { return m_bounded; }
    int elements_per_brick() const { return m_size * m_size * m_size; }
    int stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? m_size : m_size * m_size; }
    /// Indices of a brick's elements on its low or high side along an axis, in one fixed order.
    const std::vector<int>& face(int axis, bool high) const {
        return m_faces[std::size_t(2 * axis + high)];
    }

    Vec3i brick_of(Vec3i ijk) const;
    int index_in_brick(Vec3i ijk) const { return index_in_brick(ijk, brick_of(ijk)); }
    int index_in_brick(Vec3i ijk, Vec3i brick_coord) const {
        const Vec3i local = ijk - m_size * brick_coord;
        return local.x + m_size * (local.y + m_size * local.z);
    }
    Vec3i element_of(Vec3i brick_coord, int index) const;

    /// The scan's value, rounded; air beyond it. @returns HU
    int value_at(Vec3i ijk) const { return m_materials.value_at(ijk); }
    /// Material of an element, whether it has a brick or not.
    MaterialId material_at(Vec3i ijk) const;
    /// Whether it is carved, or beyond the border of a bounded lattice.
    bool is_void(Vec3i ijk) const;
    /// Displacement of an element along the lattice's axes; zero where there is no brick.
    Vec3<Fixed> displacement_at(Vec3i ijk) const;

    /// @returns −1 if it isn't there
    int find_brick(Vec3i coord) const;
    /// The brick, made if needed with everything at rest.
    int ensure_brick(Vec3i coord);
    ElementRef ensure_element(Vec3i ijk);
    /// The brick; if it must be made, blank: for a solve, which fills it on the thread that first
    /// visits it, or drops it.
    int ensure_blank_brick(Vec3i coord);
    /// Fills a blank brick in, but for its displacements, which a solve may write once and for all.
    void fill_in(Brick& brick) const;
    /// Asks for the scan's values that filling it in needs, before they are.
    void fetch_early(const Brick& brick) const;
    /// Writes zero to all its displacements. Memory of a brick that was used before may hold zeros
    /// already, of components that never moved.
    void place_at_rest(Brick& brick) const;
    /// Sets the values of those elements of a kPartlyBeyond brick that are beyond the border.
    template <class Value>
    void set_beyond(const Brick& brick, Value* values, Value value) const;
    /// No element of the brick can be anything but void.
    bool is_beyond_border(Vec3i brick_coord) const;
    /// Bounds of a brick's displacements, after they changed.
    void update_bounds(int index);
    /// Removes bricks where every displacement is zero: of all, or of the given ones. Dropping
    /// can't fail, and a brick that was dropped comes back without an allocation.
    void drop_still_bricks() noexcept;
    void drop_still_bricks(std::span<const int> bricks) noexcept;
    /// Puts everything back to rest; element edits stay.
    void drop_all_bricks() noexcept;
    /// Counts bricks that were made.
    std::uint64_t made_count() const { return m_made_count; }
    /// Removes bricks at rest that were made after the count had this value.
    void drop_made_since(std::uint64_t made_count) noexcept;

    /// Flags of a brick's elements, whether it is there or not; null: none.
    const BrickEdits* edits_of(Vec3i brick_coord) const;
    /// Replaces them; all zero takes them away. A resident brick's materials follow.
    void set_edits(Vec3i brick_coord, BrickEdits edits);
    /// Exchanges the edits of several bricks in three calls, of which only the first can fail; then
    /// nothing has changed. The second one may be repeated to take the exchange back.
    void prepare_edits(const EditMap& edits);
    void exchange_edits(EditMap& edits) noexcept;
    void finish_edits(const EditMap& edits) noexcept;
    /// Puts back edits that were replaced since they were saved. Leaves `saved` unspecified.
    void restore_edits(EditMap& saved) noexcept;
    const auto& all_edits() const { return m_edits; }
    /// Counts changes of links: of edits and materials.
    std::uint64_t links_version() const { return m_links_version; }
    /// False where every element has all its links.
    bool may_have_gaps() const { return m_bounded || !m_edits.empty(); }

    /// Whether the link from an element to its neighbour at + along an axis is there: not cut, and
    /// neither end void.
    bool is_linked(Vec3i low, int axis) const;

    /// At most one; null: none. It must outlive its time here.
    void set_observer(LatticeObserver* observer) { m_observer = observer; }
    /// To be called before a brick's displacements are written. Cheap where nobody listens.
    void before_move(Brick& brick) const {
        if (m_observer) m_observer->before_move(brick);
    }
    void reserve_move(Brick& brick) const {
        if (m_observer) m_observer->reserve_move(brick);
    }
    void before_imprint(Vec3i brick_coord, const PlasticBrick* imprint) const {
        if (m_observer) m_observer->before_imprint(brick_coord, imprint);
    }
    /// See LatticeObserver::step; 0 without an observer.
    std::uint64_t observed_step() const { return m_observer ? m_observer->step() : 0; }

    /// Links may be outside of their limits after a change of materials. They may then not get
    /// worse: solvers take the larger of a link's limit and what it has now.
    bool may_exceed_limits() const { return m_may_exceed; }
    void set_may_exceed_limits(bool may) { m_may_exceed = may; }

    /// Counts changes: a brick's changed_at is the clock's value at its last one.
    std::uint64_t clock() const { return m_clock; }
    std::uint64_t tick() { return ++m_clock; }
    /// For a lattice that takes the place of another: nobody mistakes a new stamp for an old one.
    void continue_clock(std::uint64_t clock) { m_clock = clock; }

    /// Indices of the bricks that are there, sorted by coordinate: the same order however they came
    /// into being.
    std::vector<int> resident_bricks() const;
    int resident_brick_count() const { return m_resident_count; }
    bool is_resident(int index) const { return m_bricks[std::size_t(index)] != nullptr; }
    /// Brick indices are below this.
    int brick_index_bound() const { return int(m_bricks.size()); }
    /// Calls visit(brick) for each brick that is there, in no particular order; or for each that
    /// has one of the indices from `begin` to `end`.
    template <class Visit>
    void for_each_brick(const Visit& visit) const {
        for_each_brick(0, brick_index_bound(), visit);
    }
    template <class Visit>
    void for_each_brick(int begin, int end, const Visit& visit) const {
        for (int index = begin; index < end; ++index)
            if (const Brick* brick = m_bricks[std::size_t(index)].get()) visit(*brick);
    }
    template <class Visit>
    void for_each_brick(const Visit& visit) {
        for (const auto& slot : m_bricks)
            if (slot) visit(*slot);
    }
    Brick& brick(int index) { return *m_bricks[std::size_t(index)]; }
    const Brick& brick(int index) const { return *m_bricks[std::size_t(index)]; }
    /// Bytes of all bricks that are there.
    std::size_t resident_bytes() const;

  private:
    int add_brick(Vec3i coord);
    void make_room_for(Vec3i coord);
    void drop_brick(int index) noexcept;
    void follow_edits(Vec3i brick_coord) noexcept;
    std::unique_ptr<Brick> take_brick(Vec3i coord);
    std::unique_ptr<Brick> take_spare(int place);
    void keep_spare(std::unique_ptr<Brick> dropped);
    void take_slab();
    std::unique_ptr<Brick> carve_brick();
    std::size_t brick_bytes() const;
    /// @returns whether all elements that count have one material
    bool fill_materials(Brick& brick) const;
    void look_at_materials(Brick& brick) const;
    std::uint8_t traits_of_one(const Brick& brick) const;
    bool is_whole(const Box3i& part) const;
    Box3i part_in_scan(Vec3i brick_coord) const;

    const Volume& m_volume;
    MaterialMap m_materials;
    int m_size;
    bool m_bounded;
    bool m_may_exceed = false;
    LatticeObserver* m_observer = nullptr;
    std::uint64_t m_clock = 0;
    std::uint64_t m_links_version = 0;
    std::uint64_t m_made_count = 0;
    std::array<std::vector<int>, 6> m_faces;
    std::vector<std::unique_ptr<Brick>> m_bricks;  ///< null where dropped
    std::vector<int> m_free_indices;
    /// Dropped, to be used again: preferably where they were, as their materials are still there.
    std::vector<std::unique_ptr<Brick>> m_spare;
    int m_resident_count = 0;
    BrickIndex m_index_of;
    BrickIndex m_spare_at;  ///< places in m_spare
    /// Bricks' memory, many in one piece: huge pages where the system has them.
    std::vector<AlignedMemory<void>> m_slabs;
    std::byte* m_slab_rest = nullptr;
    std::size_t m_slab_bricks_left = 0;
    EditMap m_edits;  ///< none is empty but for the time of an exchange
};

}  // namespace pliant
