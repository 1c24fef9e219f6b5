// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan deformed by springs: a network of control nodes over a region of it [Choi2004, 4.2.2],
// moved by force transmittal, and the voxels hanging in its cells.
//
//   auto tissue = SpringDeformation::create(volume, {.cell_mm = 8}, arena);
//   (*tissue)->push(1, {.point_mm = place, .push_mm = {5, 0, 0}});   // tool 1 takes hold
//   while (!(*tissue)->step(20)->settled) continue;
//   Result<Deformed> deformed = deform_volume(**tissue);
//
// A tool holds the nodes that it pushed until it lets go. Time goes on only in steps, so what comes
// out depends on the calls alone: the same bits for any number of threads.

#pragma once

#include <pliant/control_lattice.h>
#include <pliant/record.h>
#include <pliant/springs.h>

#include <cstdint>
#include <filesystem>
#include <memory>

#pragma GCC visibility push(default)
namespace pliant {

struct SpringDeformationSettings {
    Box3i region{};                  ///< voxels that may move; empty: the whole scan
    double cell_mm = 8;              ///< edge of a control cell, rounded to whole voxels
    double young_modulus_pa = 15e3;  ///< of tissue; air, below −500 HU, has a hundredth of it
    double fixed_hu = 300;           ///< nodes with a larger mean value around them don't move
    double fixed_share = 0.05;       ///< nor those of cells with a larger share of such voxels
    std::int32_t depth = 10;         ///< layers of nodes that forces reach beyond a tool
    /// What moves freely loses its speed in this time, to 1/e [s].
    double damping_s = 0.005;

    friend bool operator==(const SpringDeformationSettings&,
                           const SpringDeformationSettings&) = default;
};
/// Rows of these settings, but for the region.
SettingRows<SpringDeformationSettings> spring_rows() noexcept;

struct SpringMotion {
    std::int64_t steps = 0;
    std::int32_t active_nodes = 0;  ///< that could move
    double fastest_mm_s = 0;
    bool settled = false;  ///< at rest: more steps would change nothing that can be seen
    double solve_ms = 0;
    std::string message;  ///< why the motion was stopped, where the step was not stable any more
};

/// Where memory runs out, calls return LimitExceeded, and nothing has changed.
class SpringDeformation : public MovingScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument that names the setting; LimitExceeded above a million nodes
    static Result<std::unique_ptr<SpringDeformation>> create(
        const Volume& volume, const SpringDeformationSettings& settings,
        const TaskArena& arena) noexcept;
    ~SpringDeformation() override;

    /// A tool takes hold of the free nodes of the cell that now holds the point, or within the
    /// sphere, and takes them along; what it held before it lets go. Time goes on meanwhile. It
    /// stops where a control cell would fold. grabbed_elements and moved_elements count nodes.
    /// @returns InvalidArgument, with nothing changed, for a point outside of the control lattice
    ///          or a push that is no number or too long
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept;
    void let_go(std::uint32_t tool) noexcept;
    bool is_held() const;
    bool holds(std::uint32_t tool) const;

    /// Steps of time_step_s(), fewer where it comes to rest. Without a tool tissue that was pushed
    /// goes back, and at the end is where it was, bit for bit. The elements follow when
    /// update_lattice(), lattice() or control() is called.
    Result<SpringMotion> step(int count) noexcept;
    double time_step_s() const;
    bool is_settled() const;

    const SpringDeformationSettings& settings() const;
    /// @returns InvalidArgument below 0
    Status set_depth(std::int32_t depth) noexcept;
    void reset() noexcept;

    /// On the tool, with the other nodes where they are [N]; 0 where it holds nothing.
    Vec3d force_n(std::uint32_t tool);

    /// Of all nodes [mm, LPS].
    const std::vector<Vec3d>& displacements_mm() const;
    /// Of all nodes [mm, LPS].
    std::vector<Vec3d> places_mm() const;
    /// The same. @param[out] places_mm  one for each node
    void places_mm(std::span<Vec3d> places_mm) const noexcept;
    /// Puts all nodes somewhere, with no speed; tools let go, and what is away from its rest place
    /// can move.
    /// @returns InvalidArgument, with nothing changed, where ControlLattice::place does
    Status set_places(std::span<const Vec3d> places_mm) noexcept;
    const ControlLattice& control() const;
    std::int32_t fixed_nodes() const;
    /// Of all nodes' places.
    std::uint64_t hash() const;

    const Volume& volume() const override;
    const Lattice& lattice() const override;
    const TaskArena& arena() const override;
    Status update_lattice() const noexcept override;

  private:
    struct Impl;
    explicit SpringDeformation(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
