// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A push on a graph: three raises, the largest valid step (step.h), the move.

#include <pliant/research/graph.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

#include "base/hash.h"
#include "base/stopwatch.h"
#include "chains/graph_limits.h"
#include "chains/graph_raise.h"
#include "propagate/step.h"

namespace pliant {

struct GraphChainMail::Impl {
    Impl(const ChainGraph& g, GraphQueue queue)
        : graph(g),
          raises{GraphRaise(g, queue), GraphRaise(g, queue), GraphRaise(g, queue)},
          seen(std::size_t(g.element_count()), 0) {
        for (auto& component : u) component.assign(seen.size(), 0);
    }

    Vec3<Fixed> displacement(std::int32_t e) const {
        const auto n = std::size_t(e);
        return {u[0][n], u[1][n], u[2][n]};
    }
    Vec3<Fixed> raise(std::int32_t e) const {
        return {raises[0].raise(e), raises[1].raise(e), raises[2].raise(e)};
    }
    StepLimit limit_of(std::int32_t e, Vec3<Fixed> raised, Vec3<Fixed> shift) const;
    void collect_touched();
    std::int64_t apply(Vec3<Fixed> shift, Vec3<Fixed> done);
    PushReport push(std::span<const std::int32_t> grabbed, Vec3<Fixed> shift,
                    const TaskArena& arena);

    const ChainGraph& graph;
    std::array<std::vector<Fixed>, 3> u;  ///< [component][element]
    std::array<GraphRaise, 3> raises;
    std::vector<std::int32_t> touched;  ///< moved by any component
    std::vector<std::uint8_t> seen;     ///< [element], all 0 between pushes
};

StepLimit GraphChainMail::Impl::limit_of(std::int32_t e, Vec3<Fixed> raised,
                                         Vec3<Fixed> shift) const {
    const ChainElement& element = graph.elements()[std::size_t(e)];
    HalfLimits half{};
    half.max_movement = Fixed(std::floor(element.max_movement_mm * kUnitsPerMm));
    half.fixed = element.fixed;
    return limit_of_element(half, displacement(e), raised, shift);
}

void GraphChainMail::Impl::collect_touched() {
    touched.clear();
    for (const GraphRaise& component : raises)
        for (const std::int32_t e : component.touched())
            if (!std::exchange(seen[std::size_t(e)], 1)) touched.push_back(e);
    for (const std::int32_t e : touched) seen[std::size_t(e)] = 0;
}

std::int64_t GraphChainMail::Impl::apply(Vec3<Fixed> shift, Vec3<Fixed> done) {
    std::int64_t moved = 0;
    for (const std::int32_t e : touched) {
        const Vec3<Fixed> raised = raise(e);
        bool any = false;
        for (int a = 0; a < 3; ++a) {
            const Fixed step = raised[a] - (std::abs(shift[a]) - std::abs(done[a]));
            if (raised[a] == 0 || step <= 0) continue;
            u[std::size_t(a)][std::size_t(e)] += shift[a] > 0 ? step : -step;
            any = true;
        }
        moved += any;
    }
    return moved;
}

PushReport GraphChainMail::Impl::push(std::span<const std::int32_t> grabbed, Vec3<Fixed> shift,
                                      const TaskArena& arena) {
    // As in ChainMail's own push, for equal bits.
    StepLimit own;
    const Vec3<Fixed> full{std::abs(shift.x), std::abs(shift.y), std::abs(shift.z)};
    for (const std::int32_t e : grabbed) tighten(own, limit_of(e, full, shift));
    const Vec3<Fixed> tried = fraction_of(shift, own.fraction);
    arena.for_each(3, 1, [&](std::int64_t begin, std::int64_t end) {
        for (auto a = int(begin); a < int(end); ++a)
            if (tried[a] != 0)
                raises[std::size_t(a)].propagate(u[std::size_t(a)], grabbed,
                                                 {a, tried[a] > 0 ? 1 : -1, std::abs(tried[a])});
    });
    collect_touched();
    StepLimit reached;
    for (const std::int32_t e : touched) tighten(reached, limit_of(e, raise(e), tried));
    PushReport report;
    report.grabbed_elements = std::int64_t(grabbed.size());
    report.step_fraction = own.fraction * reached.fraction;
    report.limited_by = reached.fraction < 1 ? reached.limited_by : own.limited_by;
    report.moved_elements = apply(tried, fraction_of(tried, reached.fraction));
    for (GraphRaise& component : raises) component.clear();
    const bool nothing =
        report.step_fraction <= 0 || (report.step_fraction < 1 && report.moved_elements == 0);
    report.status = nothing                    ? PushStatus::Rejected
                    : report.step_fraction < 1 ? PushStatus::Limited
                                               : PushStatus::Applied;
    if (nothing) report.step_fraction = 0;
    if (report.limited_by == LimitedBy::Bone) report.message = "a fixed element is in the way";
    if (report.limited_by == LimitedBy::Movement)
        report.message = "an element reached its largest movement";
    return report;
}

GraphChainMail::GraphChainMail(const ChainGraph& graph, GraphQueue queue)
    : m_impl(std::make_unique<Impl>(graph, queue)) {}
GraphChainMail::~GraphChainMail() = default;
GraphChainMail::GraphChainMail(GraphChainMail&&) noexcept = default;
GraphChainMail& GraphChainMail::operator=(GraphChainMail&&) noexcept = default;

Result<PushReport> GraphChainMail::push(std::span<const std::int32_t> elements, Vec3d push_mm,
                                        const TaskArena& arena) {
    if (const Status status = check_push(m_impl->graph, elements, push_mm); !status.ok())
        return status.error();
    const Stopwatch watch;
    PushReport report = m_impl->push(elements, units_from_mm(push_mm), arena);
    report.solve_ms = watch.ms();
    return report;
}

Vec3d GraphChainMail::displacement_mm(std::int32_t element) const {
    return mm_from_units(m_impl->displacement(element));
}

std::vector<Vec3d> GraphChainMail::displacements_mm() const {
    std::vector<Vec3d> all(std::size_t(m_impl->graph.element_count()));
    for (std::size_t e = 0; e < all.size(); ++e) all[e] = displacement_mm(std::int32_t(e));
    return all;
}

std::uint64_t GraphChainMail::hash() const {
    Hash64 hash;
    for (const auto& component : m_impl->u) hash.add(std::span<const Fixed>(component));
    return hash.value();
}

void GraphChainMail::reset() {
    for (auto& component : m_impl->u) std::fill(component.begin(), component.end(), 0);
}

}  // namespace pliant
