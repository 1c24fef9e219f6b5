// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/research/orderings.h>

#include <algorithm>
#include <string>

#include "chains/published_ordering.h"
#include "material/limit_units.h"

namespace pliant {
namespace {

Error unsupported(Ordering ordering, const char* expected) {
    return {ErrorCode::Unsupported, std::string(name_of(ordering)) + ": expected " + expected};
}

bool suits_gibson_convex(const ChainLattice& lattice) {
    const auto all = [](const std::vector<std::uint8_t>& values, std::uint8_t value) {
        return std::all_of(values.begin(), values.end(), [&](auto v) { return v == value; });
    };
    const auto present = [](std::uint8_t v) { return v != 0; };
    return all(lattice.material, lattice.material.empty() ? 0 : lattice.material[0]) &&
           std::all_of(lattice.present.begin(), lattice.present.end(), present) &&
           std::all_of(lattice.materials.begin(), lattice.materials.end(), [](const auto& m) {
               return !m.fixed && m.max_movement_mm >= kMaxMovementMm;
           });
}

}  // namespace

std::string_view name_of(Ordering ordering) {
    switch (ordering) {
        case Ordering::GibsonConvex:
            return "gibson-convex";
        case Ordering::GibsonLists:
            return "gibson-lists";
        case Ordering::SchillOnce:
            return "schill-once";
        case Ordering::SchillRequeue:
            return "schill-requeue";
        case Ordering::LiOnce:
            return "li-once";
        case Ordering::LiRequeue:
            return "li-requeue";
        case Ordering::Draeger:
            return "draeger";
        case Ordering::DraegerMean:
            return "draeger-mean";
    }
    return "";
}

Result<std::unique_ptr<OrderingSolver>> make_ordering(const ChainLattice& lattice,
                                                      Ordering ordering) {
    if (const Status status = check_chain_lattice(lattice); !status.ok()) return status.error();
    switch (ordering) {
        case Ordering::GibsonConvex:
            if (!suits_gibson_convex(lattice))
                return unsupported(ordering,
                                   "one material, a full box, nothing fixed and movement limits of "
                                   "500 mm");
            return make_gibson_convex(lattice);
        case Ordering::GibsonLists:
            return make_gibson_lists(lattice);
        case Ordering::Draeger:
        case Ordering::DraegerMean:
            return make_draeger(lattice, ordering == Ordering::DraegerMean);
        case Ordering::SchillOnce:
        case Ordering::SchillRequeue:
        case Ordering::LiOnce:
        case Ordering::LiRequeue:
            break;
    }
    auto graph = graph_of_lattice(lattice, Neighbours::Faces);
    if (!graph.ok()) return graph.error();
    auto owned = std::make_shared<const ChainGraph>(std::move(graph).value());
    if (ordering == Ordering::SchillOnce || ordering == Ordering::SchillRequeue)
        return make_schill(std::move(owned), ordering == Ordering::SchillOnce);
    return make_li(std::move(owned), ordering == Ordering::LiOnce);
}

Result<std::unique_ptr<OrderingSolver>> make_ordering(const ChainGraph& graph, Ordering ordering) {
    const auto lent = std::shared_ptr<const ChainGraph>(std::shared_ptr<void>(), &graph);
    switch (ordering) {
        case Ordering::SchillOnce:
        case Ordering::SchillRequeue:
            return make_schill(lent, ordering == Ordering::SchillOnce);
        case Ordering::LiOnce:
        case Ordering::LiRequeue:
            return make_li(lent, ordering == Ordering::LiOnce);
        case Ordering::GibsonConvex:
        case Ordering::GibsonLists:
        case Ordering::Draeger:
        case Ordering::DraegerMean:
            break;
    }
    return unsupported(ordering, "a lattice, found a graph");
}

}  // namespace pliant
