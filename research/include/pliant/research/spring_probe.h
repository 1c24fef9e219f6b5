// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A point or sphere that touches the triangles of a mass-spring network [Choi2004, 3.3]. The three
// nodes of a triangle that it meets are moved with it, and force transmittal starts at them:
//
//            ○ tool                          ●──╲        ╱──●
//            ↓                                   ╲  ○   ╱
//     ●──●━━━━━━●──●            →                 ●━━━━●        held nodes ●━━●
//        triangle
//
// @code
//   auto tissue = SpringTissue::create(std::move(*network), {.depth = 10});
//   auto probe = SpringProbe::create(tissue->network(), surface.cells, {.radius = 2});
//   probe->place(*tissue, {0, 0, 40});                      // outside
//   auto moved = probe->move(*tissue, {0, 0, 39}, 1, arena);    // in each servo step
//   auto force = tissue->reaction(probe->nodes(), ReactionLaw::Held);   // Eq. 19
// @endcode
//
// docs/method/springs.md has the rules of contact.

#pragma once

#include <pliant/models/springs.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct SpringProbeSettings {
    double radius = 0;  ///< of the sphere [length]; 0: a point
    /// Longest way without a time step [length]; 0: a quarter of the triangles' mean edge.
    double stride = 0;
};

struct SpringProbeMove {
    Vec3d position{0, 0, 0};  ///< of the tool: the wanted one unless it was stopped
    /// Done fraction of the way; below 1 if a triangle with a fixed node is in it.
    double way_share = 1;
    std::int64_t steps = 0;         ///< time steps
    std::int32_t active_nodes = 0;  ///< nodes that could move in the last step
};

/// Frictionless contact: a touched triangle follows the tool along its normal only, as long as it
/// presses on the tool. Contact is continuous: neither a fast tool nor a fast triangle passes
/// through the other. Parts of the surface that are pushed into each other aren't kept apart.
/// Thread safety: one thread.
class SpringProbe {
  public:
    /// @param triangles  [triangle][3] nodes, counter-clockwise seen from outside
    /// @returns InvalidArgument for no triangles, a node that doesn't exist, a triangle that isn't
    ///          three nodes, or a setting
    static Result<SpringProbe> create(const SpringNetwork& network,
                                      std::vector<std::array<std::int32_t, 3>> triangles,
                                      const SpringProbeSettings& settings = {}) noexcept;
    SpringProbe(SpringProbe&&) noexcept;
    SpringProbe& operator=(SpringProbe&&) noexcept;
    ~SpringProbe();

    /// Lets go, and sets the tool down at a position [length].
    /// @returns InvalidArgument, with nothing changed, for a position inside of the surface
    Status place(SpringTissue& tissue, Vec3d position) noexcept;
    /// Moves the tool in a straight line, in strides. The time steps are spread over them, with at
    /// least one each. The tissue's held nodes are replaced by nodes().
    /// @param steps  1 or more
    /// @pre the tissue is of the network, or of one with the same nodes
    /// @returns the error of SpringTissue::step; the tool then stays where the failed stride began
    Result<SpringProbeMove> move(SpringTissue& tissue, Vec3d to, std::int32_t steps,
                                 const TaskArena& arena) noexcept;

    Vec3d position() const;
    /// Touched triangles, ascending.
    std::span<const std::int32_t> triangles() const;
    /// Their nodes, ascending: those that move with the tool.
    std::span<const std::int32_t> nodes() const;
    /// Nearest point of the triangles within reach of the tool, on the present positions.
    /// @returns the distance from the tool's surface, negative for an overlap; infinity if it is
    ///          above `within`
    double clearance(const SpringTissue& tissue, double within) const;

  private:
    struct Impl;
    explicit SpringProbe(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
