// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissue as a mass-spring network that moves in time steps, by force transmittal [Choi2004] or by
// one of three solvers for comparison.
//
//   auto tissue = SpringTissue::create(std::move(*network), {.depth = 10});
//   tissue->load(std::array{55}, std::array{Vec3d{0, 0, -10}});     // the tool's force
//   tissue->step(100, arena);
//   Vec3d place = tissue->position(55);
//
// Force transmittal traverses the links breadth-first from the nodes in contact, to a depth of n
// layers. In each step only these nodes move, by central differences, layer by layer:
//
//   m (x⁺ − 2x + x⁻)/h² + d (x⁺ − x⁻)/2h = F − Σ f        [Choi2004, Eq. 5, 7, 8]
//
// The order is computed once per contact. docs/springs.md has the paper's open points, and the
// costs.

#pragma once

#include <pliant/springs_network.h>
#include <pliant/tasks.h>

#include <limits>
#include <memory>

#pragma GCC visibility push(default)
namespace pliant {

enum class SpringSolver {
    ForceTransmittal,  ///< the nodes within `depth` layers of the contact
    Explicit,          ///< all nodes by central differences
    ImplicitEuler,     ///< all nodes; backward Euler by conjugate gradients [Baraff1998]
    LocalGlobal,       ///< all nodes; backward Euler by a matrix factored once [Liu2013]
};

/// Positions of the neighbours in a node's update; the text of [Choi2004, 3.1.4] leaves this open.
enum class SeenPositions {
    Old,        ///< last step's positions (Jacobi): independent of the order, conserves momentum
    NewLayers,  ///< new in earlier layers, old in the node's layer: independent of the order in a
                ///< layer
    NewNodes,   ///< new for all earlier nodes (Gauss-Seidel)
};

struct SpringSettings {
    SpringSolver solver = SpringSolver::ForceTransmittal;
    SeenPositions seen = SeenPositions::Old;  ///< of ForceTransmittal
    std::int32_t depth = 10;                  ///< layers beyond the contact
    /// 0: 90 % of the stability bound. ImplicitEuler and LocalGlobal take any step.
    double time_step = 0;
    bool vectors = true;            ///< vector instructions; the scalar code gives the same bits
    double solve_tolerance = 1e-8;  ///< ImplicitEuler: relative residual
    std::int32_t solve_iterations = 1000;
    std::int32_t local_global_iterations = 20;
};

struct SpringStep {
    std::int64_t steps = 0;
    std::int32_t active_nodes = 0;  ///< nodes that could move
    std::int64_t iterations = 0;    ///< of conjugate gradients, or of local/global steps
};

/// Force of the tissue on the tool, and its linearisation in a common shift of the touched nodes:
/// force(shift) ≈ force + stiffness · shift.
struct SpringReaction {
    Vec3d force{0, 0, 0};
    Mat3d stiffness{};  ///< symmetric, negative definite or 0
};
enum class ReactionLaw {
    Held,     ///< the other nodes are held: exact within a step, too stiff later
    Relaxed,  ///< the other nodes follow to their equilibrium (to first order)
};

/// Nodes in the order in which forces reach them.
struct TransmittalOrder {
    std::vector<std::int32_t> nodes;
    std::vector<std::int32_t> layers;  ///< first node of each layer, and the total
};
/// Breadth-first order from all sources at once; layers of equal distance are merged [Choi2004,
/// 3.1.6]. Fixed nodes transmit no force and are left out.
/// @returns InvalidArgument for a source that doesn't exist or is fixed, or a negative depth
Result<TransmittalOrder> transmittal_order(const SpringNetwork& network,
                                           std::span<const std::int32_t> sources,
                                           std::int32_t depth) noexcept;

/// Stability bound for SpringSettings::seen. It is SpringNetwork::stable_time_step() for old
/// positions. New positions act like negative damping, h·k for each link to an updated neighbour,
/// so the bound is about a node's damping over its stiffness. 0: no stable step.
double stable_time_step(const SpringNetwork& network, SeenPositions seen);

/// If memory runs out, calls return LimitExceeded and the tissue is unchanged.
class SpringTissue {
  public:
    /// @returns InvalidArgument that names the setting; for a time step beyond the stability bound
    ///          it names the bound
    static Result<SpringTissue> create(SpringNetwork network,
                                       const SpringSettings& settings) noexcept;
    ~SpringTissue();
    SpringTissue(SpringTissue&&) noexcept;
    SpringTissue& operator=(SpringTissue&&) noexcept;

    const SpringNetwork& network() const;
    double time_step() const;

    /// Replaces the loads. Force transmittal starts at these nodes.
    /// @returns InvalidArgument for a node that doesn't exist, is fixed or occurs twice, or a force
    ///          that isn't finite
    Status load(std::span<const std::int32_t> nodes, std::span<const Vec3d> forces) noexcept;
    /// Replaces the nodes that a tool holds: only move_held moves them.
    Status hold(std::span<const std::int32_t> nodes) noexcept;
    /// @param positions  of the held nodes, in the order of hold()
    Status move_held(std::span<const Vec3d> positions) noexcept;
    /// Shifts all held nodes.
    Status shift_held(Vec3d shift) noexcept;
    /// Sets the number of layers that forces reach.
    Status set_depth(std::int32_t depth) noexcept;

    /// Advances by `count` time steps. Nodes that are no longer reached stay at their positions, at
    /// rest.
    /// @returns InvalidArgument if the distorted shape makes the time step unstable: one line with
    ///          the new bound. The last step is undone
    Result<SpringStep> step(std::int32_t count, const TaskArena& arena) noexcept;

    /// Finds a static equilibrium of the active nodes: minimises the energy by Newton's method with
    /// a trust region; velocities become 0. Large loads may push nodes through the lattice into a
    /// folded equilibrium: see folded_cells().
    /// @param tolerance  largest remaining force on a node, relative to the largest load or
    ///                   reaction; clamped to the rounding error
    /// @returns LimitExceeded if it isn't reached
    Status find_equilibrium(double tolerance = 1e-9) noexcept;

    Vec3d position(std::int32_t node) const;
    Vec3d velocity(std::int32_t node) const;
    Vec3d displacement(std::int32_t node) const;
    std::vector<Vec3d> displacements() const;
    /// Sets a node's state, for initial conditions.
    Status set_state(std::int32_t node, Vec3d position, Vec3d velocity) noexcept;

    /// Computes −Σ over the nodes of Σ f over their links, plus the force of the volume energy
    /// [Choi2004, Eq. 19].
    Result<SpringReaction> reaction(std::span<const std::int32_t> nodes, ReactionLaw law) noexcept;

    /// Number of cells with an inverted corner. Springs alone resist inversion weakly, so a cell
    /// may snap through and stay inverted.
    std::int64_t folded_cells() const;
    /// Energy of links and volumes.
    double elastic_energy() const;
    double kinetic_energy() const;
    Vec3d momentum() const;

    Result<SpringCut> cut_links(std::span<const std::int32_t> links) noexcept;
    Result<SpringCut> cut_cells(std::span<const std::int32_t> cells) noexcept;

    /// Hash of all positions, equal for any number of threads.
    std::uint64_t hash() const noexcept;
    /// Returns all nodes to their rest positions; loads and held nodes stay.
    void reset() noexcept;

  private:
    friend class SpringRollback;
    struct Impl;
    explicit SpringTissue(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// Search for the necessary depth [Choi2004, 3.1.3]: raises the depth by one layer until the shape
/// changes by less than the threshold.
struct DepthSearch {
    double threshold = 0.01;  ///< of the largest change of a node's position, absolute (a length)
    std::int32_t max_depth = 64;
    /// Simulated time per depth; 0: until the reached nodes are in equilibrium. In a given time,
    /// forces travel farther in a stiffer network.
    double duration = 0;
};
struct DepthFound {
    std::int32_t depth = 0;       ///< 0: not found up to max_depth
    std::vector<double> changes;  ///< [n]: from n to n + 1 layers
};
Result<DepthFound> find_depth(const SpringNetwork& network, const SpringSettings& settings,
                              std::span<const std::int32_t> nodes, std::span<const Vec3d> forces,
                              const DepthSearch& search, const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
