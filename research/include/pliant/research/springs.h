// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mass-spring networks solved in other ways than by SpringTissue, for comparison: force transmittal
// with new positions, and projective dynamics. Nodes and links are those of SpringNetwork.

#pragma once

#include <pliant/core/vec.h>
#include <pliant/models/springs.h>
#include <pliant/result.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Positions of the neighbours in a node's update; the text of [Choi2004, 3.1.4] leaves this open.
enum class SeenPositions {
    Old,        ///< last step's positions (Jacobi), as in SpringTissue: independent of the order,
                ///< conserves momentum
    NewLayers,  ///< new in earlier layers, old in the node's layer: independent of the order in a
                ///< layer
    NewNodes,   ///< new for all earlier nodes (Gauss-Seidel)
};

/// Stability bound. It is SpringNetwork::stable_time_step() for old positions. New positions act
/// like negative damping, h·k for each link to an updated neighbour, so the bound is about a node's
/// damping over its stiffness. 0: no stable step.
double stable_time_step(const SpringNetwork& network, SeenPositions seen);

/// Force transmittal [Choi2004, Eq. 5, 7, 8], node by node in its order.
/// Thread safety: one thread.
class OrderedTransmittal {
  public:
    /// Nodes from the sources outwards, to a depth in layers, from rest.
    /// @returns InvalidArgument as transmittal_order(), for Maxwell branches, and for a time step
    ///          that isn't above 0
    static Result<OrderedTransmittal> create(SpringNetwork network,
                                             std::span<const std::int32_t> sources,
                                             std::int32_t depth, SeenPositions seen,
                                             double time_step);

    const SpringNetwork& network() const { return m_network; }
    /// Replaces the force on a node. @pre a node of the network
    void load(std::int32_t node, Vec3d force) { m_load[std::size_t(node)] = force; }
    /// Sets a node's position and its motion in the last step.
    void set_state(std::int32_t node, Vec3d position, Vec3d moved);
    void step(std::int32_t count);

    Vec3d position(std::int32_t node) const { return m_now[std::size_t(node)]; }
    std::vector<Vec3d> displacements() const;
    /// Motion of all nodes in the last step, as a sum over their masses.
    Vec3d momentum() const;

  private:
    OrderedTransmittal(SpringNetwork network, TransmittalOrder order, SeenPositions seen,
                       double time_step);
    Vec3d next(std::int32_t node, std::span<const Vec3d> seen,
               std::span<const Vec3d> seen_before) const;
    void step_once();

    SpringNetwork m_network;
    TransmittalOrder m_order;
    SeenPositions m_seen;
    double m_time_step;
    std::vector<Vec3d> m_now, m_before, m_load;  ///< [node]
};

/// Backward Euler by a matrix factored once [Liu2013]. For fixed directions n of the links, the
/// energy is quadratic with a constant matrix. So steps alternate between directions (local) and
///
///   (M/h² + D/h + Σ k) x = M/h² (x_t + h v_t) + D/h x_t + F + Σ k l n      (global)
///
/// Thread safety: one thread.
class LocalGlobalSprings {
  public:
    /// @param iterations  local/global steps of a time step
    /// @returns InvalidArgument for volume energy, damped links, Maxwell branches, and if the time
    ///          step or the iterations aren't above 0
    static Result<LocalGlobalSprings> create(SpringNetwork network, double time_step,
                                             std::int32_t iterations = 20);
    ~LocalGlobalSprings();
    LocalGlobalSprings(LocalGlobalSprings&&) noexcept;
    LocalGlobalSprings& operator=(LocalGlobalSprings&&) noexcept;

    /// Replaces the force on a node. @pre a node of the network
    void load(std::int32_t node, Vec3d force);
    /// Holds a node at a position, until release(). @pre a node of the network
    void hold(std::int32_t node, Vec3d position);
    void release(std::int32_t node);
    Result<SpringCut> cut_links(std::span<const std::int32_t> links);

    /// @returns LimitExceeded if the matrix can't be factored; then nothing has changed
    Status step(std::int32_t count);
    std::vector<Vec3d> displacements() const;

  private:
    struct Impl;
    explicit LocalGlobalSprings(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
