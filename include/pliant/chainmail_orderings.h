// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The published orderings of ChainMail, for research: what they compute, next to the exact
// solution.
//
// Each takes elements from a list in an order of its own and moves a candidate by the least that
// satisfies its *sponsor*, the neighbour that put it on the list. With one material and from rest
// most of them find the exact move; with several materials they leave links outside of their
// limits (docs/published_orderings.md). They are here to be compared, not to be used.
//
//   auto lists = *make_ordering(lattice, Ordering::GibsonLists);
//   OrderingReport report = lists->push(std::array{element}, {0, 0, 3});

#pragma once

#include <pliant/chainmail_graph.h>

#include <memory>
#include <span>
#include <string_view>

#pragma GCC visibility push(default)
namespace pliant {

enum class Ordering {
    GibsonConvex,   ///< six lists, one material, a full box: as fast as it goes [Gibson1997]
    GibsonLists,    ///< the same lists with a material per element, and the rule for objects that
                    ///< are not convex [Gibson1997]
    SchillOnce,     ///< one list sorted by violation, each element moves once [Schill1998]
    SchillRequeue,  ///< the same; an element may move again
    LiOnce,         ///< first moved, first processed; each element moves once [Li2003]
    LiRequeue,      ///< the same; an element may move again
    Draeger,        ///< sorted list, ignore directions, the sponsor's own limits [Draeger2005]
    DraegerMean,    ///< the same with a link's limits the mean of its ends, as all others have it
};

/// "gibson-convex" and so on, as `pliant bench chainmail --compare` names them.
std::string_view name_of(Ordering ordering);

struct OrderingReport {
    PushStatus status = PushStatus::Rejected;
    double step_fraction = 0;         ///< 1, 1/2, 1/4…: a step that isn't permitted is halved
    std::int64_t moved_elements = 0;  ///< by the last attempt, each counted once
    std::int64_t candidates = 0;      ///< taken from the lists, all attempts together
    bool stopped_early = false;       ///< a list did not run empty within 1000 takings an element
};

class OrderingSolver {
  public:
    virtual ~OrderingSolver() = default;
    OrderingSolver() = default;
    OrderingSolver(const OrderingSolver&) = delete;
    OrderingSolver& operator=(const OrderingSolver&) = delete;

    /// Moves the elements together. Where a fixed element or one at its movement limit would move,
    /// everything goes back, and half the step is tried, eight times at most.
    /// @pre elements of the lattice or graph, |push| ≤ 500 mm; otherwise Rejected
    virtual OrderingReport push(std::span<const std::int32_t> elements, Vec3d push_mm) = 0;
    virtual Vec3d displacement_mm(std::int32_t element) const = 0;
    virtual void set_displacement_mm(std::int32_t element, Vec3d displacement_mm) = 0;
    /// Everything back to its rest place.
    virtual void reset() = 0;
};

/// Keeps copies of what it needs of the lattice.
/// @returns InvalidArgument for a lattice that is not well-formed; Unsupported for GibsonConvex
///          with several materials, absent or fixed elements, or movement limits below 500 mm
Result<std::unique_ptr<OrderingSolver>> make_ordering(const ChainLattice& lattice,
                                                      Ordering ordering);

/// Keeps a reference: the graph must outlive it.
/// @returns Unsupported for an ordering other than Schill's and Li's
Result<std::unique_ptr<OrderingSolver>> make_ordering(const ChainGraph& graph, Ordering ordering);

/// Within these limits a link is at ease, fractions of its length as in ElementLimits.
struct ElasticLimits {
    double compress = 0, stretch = 0, shear = 0;
    double threshold_mm = 0.05;  ///< shorter corrections are not made
};

/// One sweep of the elastic relaxation of [Gibson1997, 3.4]: element by element in ascending order,
/// each moves by the mean of what its links exceed their elastic limits, unless that is shorter
/// than the threshold in all components. The deformation's own limits are not looked at.
/// @param held  elements that stay, ascending
/// @param[in,out] displacement_mm  [element]
/// @pre check_chain_lattice(lattice), sizes fit
/// @returns the number of elements that moved
std::int64_t relax_elastically(const ChainLattice& lattice, const ElasticLimits& limits,
                               std::span<const std::int32_t> held,
                               std::span<Vec3f> displacement_mm);

}  // namespace pliant
#pragma GCC visibility pop
