// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail's elements: the displacements of a Field, together with the materials that limit the
// links, and the solver's memory. A brick gets its materials from the scan at the first visit of a
// solve.

#pragma once

#include <pliant/models/material.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "field/field.h"
#include "material/limit_units.h"
#include "material/material_map.h"

namespace pliant {

/// Additional flags in Brick::traits, beside MaterialTrait. Elements beyond the border of a bounded
/// lattice don't count as a material of their own.
inline constexpr std::uint8_t kMixedMaterials = 128, kPartlyBeyond = 64;

struct Brick : FieldBrick {
    // Arrays of elements_per_brick, each aligned to 64 bytes, in one allocation with u.
    /// Positions of the elements of a solve in progress: sign·u, raised (see propagation.h).
    std::array<Fixed*, 3> raised;
    MaterialId* material;
    std::array<bool, 3> reached{};  ///< by the solve in progress, per component
    std::uint8_t traits = 0;        ///< of all materials in it, and kMixedMaterials
    Fixed least_movement = 0;       ///< smallest movement limit of all movable elements
    bool is_blank = false;          ///< materials and traits are not filled in yet
    std::uint64_t saved_for = 0;    ///< step of the history that has a copy of it
};

struct PlasticBrick;

/// Is told of a change before it, for the history. Nothing has changed if a call throws.
class LatticeObserver {
  public:
    virtual ~LatticeObserver() = default;
    /// The displacements of a brick will change; called from several threads.
    virtual void before_move(Brick& brick) = 0;
    /// Allocates all memory that before_move needs for a brick; before_move then can't fail.
    virtual void reserve_move(Brick& brick) = 0;
    virtual void before_edit(Vec3i coord, const BrickEdits* edits) = 0;
    virtual void before_imprint(Vec3i coord, const PlasticBrick* imprint) = 0;
    /// Number of the step; when it changes, the observer must be told of each brick again.
    virtual std::uint64_t step() const = 0;
};

struct ElementRef {
    int brick;
    int index;
    friend constexpr bool operator==(const ElementRef&, const ElementRef&) = default;
};

class Lattice final : public Field {
  public:
    /// Keeps a reference to the volume. @param bounded  whether elements beyond it are void
    Lattice(const Volume& volume, MaterialMap materials, int brick_size, bool bounded);
    Lattice(const Volume& volume, const std::vector<MaterialLaw>& laws, int brick_size,
            bool bounded)
        : Lattice(volume, MaterialMap(volume, laws), brick_size, bounded) {}

    const MaterialTable& materials() const { return m_materials.table(); }
    const MaterialMap& material_map() const { return m_materials; }
    /// Exchanges the materials with others; nothing moves. Can't fail.
    void exchange_materials(MaterialMap& materials) noexcept;
    /// Indices of a brick's elements on its low or high side along an axis, in one fixed order.
    const std::vector<int>& face(int axis, bool high) const {
        return m_faces[std::size_t(2 * axis + high)];
    }

    /// See MaterialMap::value_at.
    double value_at(Vec3i ijk) const { return m_materials.value_at(ijk); }
    /// Material of an element, with or without a brick.
    MaterialId material_at(Vec3i ijk) const;

    /// Index of the brick, created at rest if needed.
    int ensure_brick(Vec3i coord);
    ElementRef ensure_element(Vec3i ijk);
    /// Index of the brick, created blank if needed: for a solve, which fills it on the thread of
    /// the first visit, or drops it.
    int ensure_blank_brick(Vec3i coord);
    /// Fills in a blank brick except its displacements: a solve may write these directly, only
    /// once.
    void fill_in(Brick& brick) const;
    /// Prefetches the scan's values that fill_in needs.
    void fetch_early(const Brick& brick) const;
    /// Sets the values of the elements of a kPartlyBeyond brick that are beyond the border.
    template <class Value>
    void set_beyond(const Brick& brick, Value* values, Value value) const;
    /// Whether all elements of the brick are necessarily void.
    bool is_beyond_border(Vec3i brick_coord) const;
    void update_bounds(int index) { Field::update_bounds(brick(index)); }
    using Field::continue_clock;
    using Field::drop_all_bricks;
    using Field::drop_made_since;
    using Field::drop_still_bricks;
    using Field::exchange_edits;
    using Field::finish_edits;
    using Field::place_at_rest;
    using Field::restore_edits;
    using Field::tick;

    /// Overrides Field's function; notifies the observer.
    void set_edits(Vec3i brick_coord, BrickEdits edits);
    void prepare_edits(const EditMap& edits);

    /// At most one; null: none. It must outlive its registration.
    void set_observer(LatticeObserver* observer) { m_observer = observer; }
    /// Must be called before a brick's displacements are written. Cheap without an observer.
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

    /// Whether links may be outside of their limits, after a change of materials. They must not get
    /// worse: solvers take the larger of a link's limit and its present length.
    bool may_exceed_limits() const { return m_may_exceed; }
    void set_may_exceed_limits(bool may) { m_may_exceed = may; }

    // Overrides Field's function: visits bricks with their materials.
    template <class Visit>
    void for_each_brick(const Visit& visit) const {
        Field::for_each_brick([&](const FieldBrick& b) { visit(static_cast<const Brick&>(b)); });
    }
    template <class Visit>
    void for_each_brick(const Visit& visit) {
        for (int index = 0; index < brick_index_bound(); ++index)
            if (is_resident(index)) visit(brick(index));
    }
    Brick& brick(int index) { return static_cast<Brick&>(brick_to_write(index)); }
    const Brick& brick(int index) const { return static_cast<const Brick&>(Field::brick(index)); }

  private:
    FieldBrick& make_brick(std::byte* memory) override;
    void begin_brick(FieldBrick& brick, bool is_elsewhere) noexcept override;
    void follow_edits(FieldBrick& brick) noexcept override;
    void forget_dropped(FieldBrick& brick) noexcept override;
    /// @returns whether all elements that count have one material
    bool fill_materials(Brick& brick) const;
    void look_at_materials(Brick& brick) const;
    std::uint8_t traits_of_one(const Brick& brick) const;
    bool is_whole(const Box3i& part) const;

    MaterialMap m_materials;
    bool m_may_exceed = false;
    LatticeObserver* m_observer = nullptr;
    std::array<std::vector<int>, 6> m_faces;
    std::deque<Brick> m_made;  ///< all of Field's bricks, resident or dropped
};

}  // namespace pliant
