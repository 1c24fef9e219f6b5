// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The published orderings of ChainMail, for research: a comparison with the exact solution.
//
// Each processes elements from a list in its own order. It moves a candidate by the minimal amount
// that satisfies its *sponsor*, the neighbour that put it on the list. With one material and from
// rest, most orderings find the exact move. With several materials they leave links outside of
// their limits (docs/method/published_orderings.md). Use them for comparisons only.
//
// @code
//   auto lists = make_ordering(lattice, Ordering::GibsonLists);
//   OrderingReport report = (*lists)->push(std::array{element}, {0, 0, 3});
// @endcode

#pragma once

#include <pliant/research/graph.h>

#include <memory>
#include <span>
#include <string_view>

#pragma GCC visibility push(default)
namespace pliant {

enum class Ordering {
    GibsonConvex,   ///< six lists, one material, a full box: fastest [Gibson1997]
    GibsonLists,    ///< the same lists with a material per element, and the rule for objects that
                    ///< are not convex [Gibson1997]
    SchillOnce,     ///< one list sorted by violation; each element moves once [Schill1998]
    SchillRequeue,  ///< the same; an element may move again
    LiOnce,         ///< first in, first out; each element moves once [Li2003]
    LiRequeue,      ///< the same; an element may move again
    Draeger,        ///< sorted list, ignore directions, the sponsor's own limits [Draeger2005]
    DraegerMean,    ///< the same with the mean of a link's ends as its limits, as in all others
};

/// Names in tables, for example "gibson-convex".
std::string_view name_of(Ordering ordering);

struct OrderingReport {
    PushStatus status = PushStatus::Rejected;
    double step_fraction = 0;         ///< 1, 1/2, 1/4…: a step that isn't permitted is halved
    std::int64_t moved_elements = 0;  ///< elements that the last attempt moved, each counted once
    std::int64_t candidates = 0;      ///< candidates taken from the lists in all attempts
    bool stopped_early = false;       ///< a list did not run empty within 1000 candidates per
                                      ///< element
};

/// Thread safety: one thread.
class OrderingSolver {
  public:
    virtual ~OrderingSolver() = default;
    OrderingSolver() = default;
    OrderingSolver(const OrderingSolver&) = delete;
    OrderingSolver& operator=(const OrderingSolver&) = delete;

    /// Moves the elements together. If a fixed element or one at its movement limit would move, all
    /// displacements are restored, and half the step is tried, at most eight times.
    /// @pre elements of the lattice or graph, |push| ≤ 500 mm; otherwise Rejected
    virtual OrderingReport push(std::span<const std::int32_t> elements, Vec3d push_mm) = 0;
    virtual Vec3d displacement_mm(std::int32_t element) const = 0;
    virtual void set_displacement_mm(std::int32_t element, Vec3d displacement_mm) = 0;
    /// Returns every element to its rest position.
    virtual void reset() = 0;
};

/// Copies the parts of the lattice that it needs.
/// @returns InvalidArgument for an invalid lattice; Unsupported for GibsonConvex with several
///          materials, absent or fixed elements, or movement limits below 500 mm
Result<std::unique_ptr<OrderingSolver>> make_ordering(const ChainLattice& lattice,
                                                      Ordering ordering);

/// Keeps a reference: the graph must outlive it.
/// @returns Unsupported for orderings other than those of Schill and Li
Result<std::unique_ptr<OrderingSolver>> make_ordering(const ChainGraph& graph, Ordering ordering);

/// Limits within which a link has no elastic energy, as fractions of its length like ElementLimits.
struct ElasticLimits {
    double compress = 0, stretch = 0, shear = 0;
    double threshold_mm = 0.05;  ///< shorter corrections are skipped
};

/// Makes one sweep of the elastic relaxation of [Gibson1997, 3.4]. In ascending order, each element
/// moves by the mean excess of its links over their elastic limits, unless that is shorter than the
/// threshold in all components. The deformation's own limits are ignored.
/// @param held  elements that don't move, ascending
/// @param[in,out] displacement_mm  [element]
/// @pre check_chain_lattice(lattice), sizes fit
/// @returns number of elements that moved
std::int64_t relax_elastically(const ChainLattice& lattice, const ElasticLimits& limits,
                               std::span<const std::int32_t> held,
                               std::span<Vec3f> displacement_mm);

}  // namespace pliant
#pragma GCC visibility pop
