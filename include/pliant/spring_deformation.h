// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan deformed by springs: a network of control nodes over a region of the scan [Choi2004,
// 4.2.2] moves by force transmittal, and the voxels are embedded in its cells.
//
//   auto tissue = SpringDeformation::create(volume, {.cell_mm = 8}, arena);
//   (*tissue)->push(1, {.point_mm = place, .push_mm = {5, 0, 0}});   // tool 1 grabs
//   while (!(*tissue)->step(20)->settled) continue;
//   Result<Deformed> deformed = deform_volume(**tissue);
//
// A tool holds its nodes until it lets go. Time advances only in steps, so the result depends on
// the calls alone. It is bit-identical for any number of threads.

#pragma once

#include <pliant/control_lattice.h>
#include <pliant/record.h>
#include <pliant/springs.h>
#include <pliant/tool.h>

#include <cstdint>
#include <filesystem>
#include <memory>

#pragma GCC visibility push(default)
namespace pliant {

struct SpringDeformationSettings {
    Box3i region{};                  ///< voxels that may move; empty: the whole scan
    double cell_mm = 8;              ///< edge of a control cell, rounded to whole voxels
    double young_modulus_pa = 15e3;  ///< of tissue; air, below −500 HU, has 1 % of it
    double fixed_hu = 300;           ///< nodes with a larger mean value around them are fixed
    double fixed_share = 0.05;       ///< cells with a larger share of such voxels have fixed nodes
    std::int32_t depth = 10;         ///< layers of nodes that forces reach around a tool
    /// Time in which free motion decays to 1/e [s].
    double damping_s = 0.005;

    friend bool operator==(const SpringDeformationSettings&,
                           const SpringDeformationSettings&) = default;
};
/// Rows of these settings, except the region.
SettingRows<SpringDeformationSettings> spring_rows() noexcept;

struct SpringMotion {
    std::int64_t steps = 0;
    std::int32_t active_nodes = 0;  ///< nodes that could move
    double fastest_mm_s = 0;
    bool settled = false;  ///< at rest: more steps make no visible change
    double solve_ms = 0;
    std::string message;  ///< reason why an unstable motion was stopped
};

/// If memory runs out, calls return LimitExceeded and change nothing.
class SpringDeformation : public MovingScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument that names the setting; LimitExceeded above a million nodes
    static Result<std::unique_ptr<SpringDeformation>> create(
        const Volume& volume, const SpringDeformationSettings& settings,
        const TaskArena& arena) noexcept;
    ~SpringDeformation() override;

    /// Lets a tool grab the free nodes of the cell that holds the point, or the free nodes in the
    /// sphere, and moves them; previously held nodes are released. Time advances during the push.
    /// It stops before a control cell folds. grabbed_elements and moved_elements count nodes.
    /// @returns InvalidArgument, with nothing changed, if the point is outside of the control
    ///          lattice, or the push isn't finite or too long
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept;
    void let_go(std::uint32_t tool) noexcept;
    bool is_held() const;
    bool holds(std::uint32_t tool) const;

    /// Makes steps of time_step_s(), fewer if it comes to rest. Without a tool pushed tissue
    /// returns, and finally has its original positions, bit for bit. The elements follow when
    /// update_deformation(), lattice() or control() is called.
    Result<SpringMotion> step(int count) noexcept;
    double time_step_s() const;
    bool is_settled() const;

    const SpringDeformationSettings& settings() const;
    /// @returns InvalidArgument for a negative depth
    Status set_depth(std::int32_t depth) noexcept;
    void reset() noexcept;

    /// Force on the tool [N], with the other nodes held; 0 if it holds none.
    Vec3d force_n(std::uint32_t tool);

    /// Displacement of every control node [mm, LPS].
    const std::vector<Vec3d>& displacements_mm() const;
    /// Position of every control node [mm, LPS].
    std::vector<Vec3d> places_mm() const;
    /// Copies the positions. @param[out] places_mm  one for each node
    void places_mm(std::span<Vec3d> places_mm) const noexcept;
    /// Sets the positions of all nodes, at zero speed. Tools let go; displaced nodes can move.
    /// @returns InvalidArgument, with nothing changed, like ControlLattice::place
    Status set_places(std::span<const Vec3d> places_mm) noexcept;
    const ControlLattice& control() const;
    std::int32_t fixed_nodes() const;
    /// Hash of all positions.
    std::uint64_t hash() const;

    const Volume& volume() const override;
    const Deformation& deformation() const override;
    const TaskArena& arena() const override;
    Status update_deformation() const noexcept override;

  private:
    struct Impl;
    explicit SpringDeformation(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
