// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Only what is near the catheter moves: the boxes of [VesselPbd2016, Eq. 9-13].
//
//   ┌────┬────┬────┬────┐   space in boxes of side d; each holds the tetrahedra in it and within
//   │    │ ▒▒▒│▒▒▒ │    │   d/3 around it. Boxes that something may touch are active (▒), and so
//   └────┴────┴────┴────┘   are their tetrahedra; particles of any other tetrahedron are held
//
//   auto boxes = PbdBoxes::create(wall.mesh, {.side = 10});
//   boxes->update(places_of_the_rod, 2, body);      // before each step
//
// Beyond the paper: all of the catheter activates, not its tip alone. Particles become movable
// little by little, and a box that nobody wants any more stays active until it has come to rest, so
// that nothing snaps. The paper's hash is not unique, so boxes are told apart by Eq. 10 unless
// asked.

#pragma once

#include <pliant/pbd.h>

#pragma GCC visibility push(default)
namespace pliant {

enum class BoxIndex {
    Linear,  ///< Eq. 10: one number, one box
    Hash,    ///< Eq. 12, with the primes of its reference 21: other boxes may wake up as well
};

struct PbdBoxSettings {
    double side = 10;  ///< d
    double span = -1;  ///< how much wider a box is on each side; below 0: d/3
    BoxIndex index = BoxIndex::Linear;
    std::int32_t blend_steps = 16;  ///< from held to movable
    double settled = 1e-3;          ///< a box rests when no particle is farther from its rest place
};

class PbdBoxes {
  public:
    /// @returns InvalidArgument that names the setting, LimitExceeded for more than 2²⁴ boxes
    static Result<PbdBoxes> create(const TetMesh& mesh, const PbdBoxSettings& settings);

    /// Wakes the boxes within reach of the places, lets others fall asleep. The body is made of the
    /// mesh's nodes, and is held altogether at first.
    Status update(std::span<const Vec3d> places, double reach, PbdBody& body);

    /// Which boxes are active, and particles on their way to be movable.
    std::vector<std::int32_t> state() const;
    /// @returns InvalidArgument where it is no state of these boxes
    Status restore(std::span<const std::int32_t> state, PbdBody& body);

    Vec3i box_counts() const { return m_counts; }  ///< Eq. 9
    Vec3i box_at(Vec3d place) const;               ///< the nearest, if outside
    std::int32_t linear_index(Vec3i box) const;    ///< Eq. 10
    std::int32_t hash(Vec3i box) const;            ///< Eq. 12
    std::span<const std::int32_t> tetrahedra(std::int32_t linear_index) const;
    bool is_active(std::int32_t linear_index) const;
    std::int32_t active_boxes() const { return m_active_boxes; }
    std::int32_t active_tetrahedra() const { return m_active_tetrahedra; }

  private:
    friend class PbdRollback;
    struct Blend {
        std::int32_t particle, age;
    };
    PbdBoxes() = default;
    void mark(Vec3i box);
    void mark_around(std::span<const Vec3d> places, double reach);
    Status wake(std::size_t box, bool active, PbdBody& body);
    Status blend_in(PbdBody& body);
    void keep() noexcept;
    void take_back() noexcept;
    Status check_state(std::span<const std::int32_t> boxes,
                       std::span<const std::int32_t> blends) const;
    bool is_settled(std::size_t box, const PbdBody& body) const;

    PbdBoxSettings m_settings;
    Vec3d m_low{0, 0, 0};
    Vec3i m_counts{1, 1, 1};
    std::vector<Vec3d> m_rest;
    std::vector<std::array<std::int32_t, 4>> m_cells;
    std::vector<std::int32_t> m_starts, m_held;          ///< tetrahedra of each box
    std::vector<std::int32_t> m_hash_starts, m_of_hash;  ///< boxes of each hash
    std::vector<std::uint8_t> m_is_active, m_is_wanted;
    std::vector<std::int32_t> m_active_of;  ///< [tetrahedron]: its active boxes
    std::vector<std::int32_t> m_asleep;     ///< [particle]: its tetrahedra that aren't active
    std::vector<Blend> m_blends;
    std::int32_t m_active_boxes = 0, m_active_tetrahedra = 0;
    bool m_has_begun = false;

    // To take an update back: boxes that changed, of which the first ones have been dealt with.
    std::vector<std::int32_t> m_changed;
    std::size_t m_changed_count = 0;
    std::vector<Blend> m_kept_blends;
    bool m_kept_begun = false;
};

}  // namespace pliant
#pragma GCC visibility pop
