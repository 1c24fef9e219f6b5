// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissue as a mass-spring network that moves in time steps, by force transmittal [Choi2004] or by
// one of three solvers that it can be compared with.
//
//   auto tissue = SpringTissue::create(std::move(*network), {.depth = 10});
//   tissue->load(std::array{55}, std::array{Vec3d{0, 0, -10}});     // where the tool presses
//   tissue->step(100, arena);
//   Vec3d place = tissue->position(55);
//
// Force transmittal: from the nodes in contact, breadth-first over links, to a depth of n layers.
// In each step these nodes, and only these, are moved by central differences, layer by layer:
//
//   m (x⁺ − 2x + x⁻)/h² + d (x⁺ − x⁻)/2h = F − Σ f        [Choi2004, Eq. 5, 7, 8]
//
// The order is kept for each contact. docs/springs.md has what the paper leaves open, and costs.

#pragma once

#include <pliant/springs_network.h>
#include <pliant/tasks.h>

#include <limits>
#include <memory>

#pragma GCC visibility push(default)
namespace pliant {

enum class SpringSolver {
    ForceTransmittal,  ///< the nodes within `depth` layers of the contact
    Explicit,          ///< the same, all nodes
    ImplicitEuler,     ///< all nodes, backward Euler by conjugate gradients [Baraff1998]
    LocalGlobal,       ///< all nodes, backward Euler by a matrix factored once [Liu2013]
};

/// Which of its neighbours' positions a node sees, where the text of [Choi2004, 3.1.4] is open.
enum class SeenPositions {
    Old,        ///< all of the last step: any order gives the same bits, and momentum is kept
    NewLayers,  ///< new ones of earlier layers, old ones of its own: order in a layer is free
    NewNodes,   ///< new ones of all nodes before it, node by node
};

struct SpringSettings {
    SpringSolver solver = SpringSolver::ForceTransmittal;
    SeenPositions seen = SeenPositions::Old;  ///< of ForceTransmittal
    std::int32_t depth = 10;                  ///< layers beyond the contact
    /// 0: nine tenths of the longest stable one. ImplicitEuler and LocalGlobal take any.
    double time_step = 0;
    bool vectors = true;            ///< vector instructions; the bits are the same without
    double solve_tolerance = 1e-8;  ///< ImplicitEuler: of the residual, relative
    std::int32_t solve_iterations = 1000;
    std::int32_t local_global_iterations = 20;
};

struct SpringStep {
    std::int64_t steps = 0;
    std::int32_t active_nodes = 0;  ///< moved or could have
    std::int64_t iterations = 0;    ///< of conjugate gradients, or of local and global steps
};

/// The force of the tissue on what touches it, and how it changes with a common shift of the
/// touched nodes: force(shift) ≈ force + stiffness · shift.
struct SpringReaction {
    Vec3d force{0, 0, 0};
    Mat3d stiffness{};  ///< symmetric, negative definite or 0
};
enum class ReactionLaw {
    Held,     ///< the other nodes stay: right within a step, and too stiff after it
    Relaxed,  ///< the other nodes follow to their equilibrium (to first order)
};

/// Nodes in the order in which forces reach them.
struct TransmittalOrder {
    std::vector<std::int32_t> nodes;
    std::vector<std::int32_t> layers;  ///< first node of each layer, and the end
};
/// Breadth-first from all sources at once; layers at the same distance are one [Choi2004, 3.1.6].
/// Fixed nodes pass nothing on and are left out.
/// @returns InvalidArgument for a source that isn't there or is fixed, or a negative depth
Result<TransmittalOrder> transmittal_order(const SpringNetwork& network,
                                           std::span<const std::int32_t> sources,
                                           std::int32_t depth) noexcept;

/// For SpringSettings::seen: SpringNetwork::stable_time_step() where old positions are seen. New
/// ones act like negative damping, h·k of each link whose other end is seen too early, so that a
/// step is stable only up to about a node's damping over its stiffness. 0: none is.
double stable_time_step(const SpringNetwork& network, SeenPositions seen);

/// Where memory runs out, calls return LimitExceeded, and the tissue is as if they had not been
/// made.
class SpringTissue {
  public:
    /// @returns InvalidArgument that names the setting; for a time step beyond the stability bound
    ///          the longest stable one
    static Result<SpringTissue> create(SpringNetwork network,
                                       const SpringSettings& settings) noexcept;
    ~SpringTissue();
    SpringTissue(SpringTissue&&) noexcept;
    SpringTissue& operator=(SpringTissue&&) noexcept;

    const SpringNetwork& network() const;
    double time_step() const;

    /// Sets the loads, instead of those before. Force transmittal starts at these nodes.
    /// @returns InvalidArgument for a node that isn't there, is fixed or comes twice, or a force
    ///          that is no number
    Status load(std::span<const std::int32_t> nodes, std::span<const Vec3d> forces) noexcept;
    /// Nodes that a tool holds, instead of those before: they go only where move_held puts them.
    Status hold(std::span<const std::int32_t> nodes) noexcept;
    /// @param positions  of the held nodes, in the order in which they were given
    Status move_held(std::span<const Vec3d> positions) noexcept;
    /// A common shift of the held nodes.
    Status shift_held(Vec3d shift) noexcept;
    /// How many layers forces reach from now on.
    Status set_depth(std::int32_t depth) noexcept;

    /// Nodes that are no longer reached stay where they are, at rest.
    /// @returns InvalidArgument where the shape has become so distorted that the time step isn't
    ///          stable any more: one line with the longest step that is. The last step is taken
    ///          back
    Result<SpringStep> step(std::int32_t count, const TaskArena& arena) noexcept;

    /// Goes to a static equilibrium of the nodes that steps move, downhill in energy by Newton's
    /// method within a trusted radius; velocities become 0. Large loads may push nodes through the
    /// lattice, to where it holds them from the other side: see folded_cells().
    /// @param tolerance  largest force left on a node, relative to the largest load or reaction;
    ///                   less than rounding leaves isn't asked for
    /// @returns LimitExceeded where it isn't reached
    Status find_equilibrium(double tolerance = 1e-9) noexcept;

    Vec3d position(std::int32_t node) const;
    Vec3d velocity(std::int32_t node) const;
    Vec3d displacement(std::int32_t node) const;
    std::vector<Vec3d> displacements() const;
    /// Puts a node somewhere, for initial conditions.
    Status set_state(std::int32_t node, Vec3d position, Vec3d velocity) noexcept;

    /// −Σ over the nodes of Σ f over their links, and of the volume energy's force
    /// [Choi2004, Eq. 19].
    Result<SpringReaction> reaction(std::span<const std::int32_t> nodes, ReactionLaw law) noexcept;

    /// Cells that have a corner turned inside out. Springs alone resist that so little that they
    /// may snap through, and stay.
    std::int64_t folded_cells() const;
    /// Of links and volumes.
    double elastic_energy() const;
    double kinetic_energy() const;
    Vec3d momentum() const;

    Result<SpringCut> cut_links(std::span<const std::int32_t> links) noexcept;
    Result<SpringCut> cut_cells(std::span<const std::int32_t> cells) noexcept;

    /// Of all places: equal for every number of threads.
    std::uint64_t hash() const noexcept;
    /// Everything back to its rest place; loads and held nodes stay what they are.
    void reset() noexcept;

  private:
    friend class SpringRollback;
    struct Impl;
    explicit SpringTissue(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// How deep forces must reach [Choi2004, 3.1.3]: the depth is raised by one layer until that
/// changes the shape by less than the threshold.
struct DepthSearch {
    double threshold = 0.01;  ///< of the largest change of a node's place, absolute (a length)
    std::int32_t max_depth = 64;
    /// Each depth is simulated for so long; 0: until the equilibrium of the nodes it reaches.
    /// In a given time forces travel farther in a stiffer network.
    double duration = 0;
};
struct DepthFound {
    std::int32_t depth = 0;       ///< 0: none up to max_depth
    std::vector<double> changes;  ///< [n]: from n to n + 1 layers
};
Result<DepthFound> find_depth(const SpringNetwork& network, const SpringSettings& settings,
                              std::span<const std::int32_t> nodes, std::span<const Vec3d> forces,
                              const DepthSearch& search, const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
