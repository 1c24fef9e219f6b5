// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local simulation near the catheter: the boxes of [VesselPbd2016, Eq. 9-13].
//
//   ┌────┬────┬────┬────┐   space in boxes of side d; each holds the tetrahedra in it and within
//   │    │ ▒▒▒│▒▒▒ │    │   d/3 around it. Boxes near the catheter are active (▒), and so are
//   └────┴────┴────┴────┘   their tetrahedra. The particles of other tetrahedra are held
//
//   auto boxes = PbdBoxes::create(wall.mesh, {.side = 10});
//   boxes->update(places_of_the_rod, 2, body);      // before each step
//
// Deviations from the paper: the whole catheter activates boxes, not only its tip. Particles become
// movable gradually, and an inactive box stays awake until it has come to rest, so that motion is
// continuous. The paper's hash is not unique, so the default index is Eq. 10.

#pragma once

#include <pliant/pbd.h>

#pragma GCC visibility push(default)
namespace pliant {

enum class BoxIndex {
    Linear,  ///< Eq. 10: one number, one box
    Hash,    ///< Eq. 12, with the primes of its reference 21: collisions wake other boxes too
};

struct PbdBoxSettings {
    double side = 10;  ///< d
    double span = -1;  ///< margin of a box on each side; negative: d/3
    BoxIndex index = BoxIndex::Linear;
    std::int32_t blend_steps = 16;  ///< steps from held to movable
    double settled = 1e-3;          ///< a box rests if all its particles are within this distance
                                    ///< of their rest positions
};

class PbdBoxes {
  public:
    /// @returns InvalidArgument that names the setting, LimitExceeded for more than 2²⁴ boxes
    static Result<PbdBoxes> create(const TetMesh& mesh, const PbdBoxSettings& settings);

    /// Wakes the boxes within reach of the positions, and lets others fall asleep. The body
    /// consists of the mesh's nodes; all are held before the first call.
    Status update(std::span<const Vec3d> places, double reach, PbdBody& body);

    /// Returns the active boxes and the particles in transition to movable.
    std::vector<std::int32_t> state() const;
    /// @returns InvalidArgument if it is not a state of these boxes
    Status restore(std::span<const std::int32_t> state, PbdBody& body);

    Vec3i box_counts() const { return m_counts; }  ///< Eq. 9
    Vec3i box_at(Vec3d place) const;               ///< clamped to the nearest box
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
    std::vector<std::int32_t> m_active_of;  ///< [tetrahedron]: number of its active boxes
    std::vector<std::int32_t> m_asleep;     ///< [particle]: number of its inactive tetrahedra
    std::vector<Blend> m_blends;
    std::int32_t m_active_boxes = 0, m_active_tetrahedra = 0;
    bool m_has_begun = false;

    // Rollback of an update: changed boxes, the first m_changed_count of which are processed.
    std::vector<std::int32_t> m_changed;
    std::size_t m_changed_count = 0;
    std::vector<Blend> m_kept_blends;
    bool m_kept_begun = false;
};

}  // namespace pliant
#pragma GCC visibility pop
