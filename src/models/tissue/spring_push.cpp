// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tools that grab a scan's control nodes, and move them.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "base/text.h"
#include "springs/cell_volume.h"
#include "springs/rollback.h"
#include "tissue/scan_network.h"
#include "tissue/spring_deformation_impl.h"

namespace pliant {
namespace {

/// Fraction of a cell's edge by which a push advances at a time, with two steps each.
constexpr double kStrideShare = 0.05;
constexpr int kStepsPerStride = 2;
/// A push stops if a corner of a cell has less than this fraction of its volume left.
constexpr double kFoldShare = 0.15;
constexpr double kMaxPush_mm = 500;

Status check(const Push& push) {
    if (!(norm(push.push_mm) <= kMaxPush_mm))
        return about(
            "push", ErrorCode::InvalidArgument,
            "expected three numbers and a length up to 500 mm, found " + text_of(push.push_mm));
    if (!(push.sphere_radius_mm >= 0 && push.sphere_radius_mm <= kMaxPush_mm))
        return about("push", ErrorCode::InvalidArgument, "expected a sphere radius of 0 to 500 mm");
    return Ok{};
}

}  // namespace

std::vector<std::int32_t> SpringDeformation::Impl::nodes_at(const Push& push,
                                                            const ControlPlace& place) const {
    std::vector<std::int32_t> nodes;
    const double radius = push.sphere_radius_mm;
    if (radius > 0)
        for (std::int32_t n = 0; n < control->node_count(); ++n)
            if (const Vec3d away = tissue.position(n) - push.point_mm;
                norm(away) <= radius && (!push.shape || push.shape->contains(away)))
                nodes.push_back(n);
    // A small sphere lies between the nodes.
    if (nodes.empty() && !push.shape) nodes.assign(place.nodes.begin(), place.nodes.end());
    if (radius == 0 && !control->cuts_mm().empty()) {
        const Vec3d point = rest_of(place);
        const auto is_hidden = [&](std::int32_t n) {
            return control->is_cut(point, tissue.network().nodes()[std::size_t(n)].rest);
        };
        if (!std::all_of(nodes.begin(), nodes.end(), is_hidden)) std::erase_if(nodes, is_hidden);
    }
    std::erase_if(nodes, [&](std::int32_t n) { return is_fixed(n); });
    return nodes;
}

/// The tools after one of them grabs these nodes. @param nodes  sorted
SpringDeformation::Impl::Tools SpringDeformation::Impl::with(
    std::uint32_t tool, std::vector<std::int32_t> nodes) const {
    const auto is_taken = [&](std::int32_t n) {
        return std::binary_search(nodes.begin(), nodes.end(), n);
    };
    Tools changed = tools;
    changed.erase(tool);
    for (auto& [other, theirs] : changed) std::erase_if(theirs, is_taken);
    std::erase_if(changed, [](const auto& entry) { return entry.second.empty(); });
    if (!nodes.empty()) changed[tool] = std::move(nodes);
    return changed;
}

void SpringDeformation::Impl::let_go_of(std::uint32_t tool) noexcept {
    const auto found = tools.find(tool);
    if (found == tools.end()) return;
    former.insert(former.end(), found->second.begin(), found->second.end());
    tools.erase(found);
}

/// Updates the tissue's sources of motion: held nodes, and released ones that can still move.
void SpringDeformation::Impl::renew_sources() noexcept {
    held.clear();
    for (const auto& [tool, nodes] : tools) held.insert(held.end(), nodes.begin(), nodes.end());
    std::sort(held.begin(), held.end());
    std::sort(former.begin(), former.end());
    former.erase(std::unique(former.begin(), former.end()), former.end());
    loose.clear();
    std::set_difference(former.begin(), former.end(), held.begin(), held.end(),
                        std::back_inserter(loose));
    (void)tissue.load(loose, std::span(no_forces).first(loose.size()));
    (void)tissue.hold(held);
}

Status SpringDeformation::Impl::stride(std::span<const std::int32_t> nodes, Vec3d shift) noexcept {
    held_places.clear();
    for (const std::int32_t n : held) {
        const bool moves = std::binary_search(nodes.begin(), nodes.end(), n);
        held_places.push_back(moves ? tissue.position(n) + shift : tissue.position(n));
    }
    (void)tissue.move_held(held_places);
    auto stepped = tissue.step(kStepsPerStride, control->arena());
    if (stepped.ok()) return Ok{};
    return is_out_of_memory(stepped.error()) ? out_of_memory() : Error{};
}

/// ControlLattice::folds for the present tissue, restricted to cells with a strongly changed edge:
/// if all edges changed by less than a fifth, a corner keeps at least (1 − √3/5)³ = 0.28 of its
/// volume.
bool SpringDeformation::Impl::folds() noexcept {
    constexpr double kMuch = 0.2;
    static_assert(kFoldShare < 0.28);
    const Vec3i size = control->grid().size;
    const std::int32_t steps[3] = {1, size.x, size.x * size.y};
    const auto& nodes = tissue.network().nodes();
    const auto at = [&](std::int32_t n) { return node_places[std::size_t(n)]; };
    const auto rest = [&](std::int32_t n) { return nodes[std::size_t(n)].rest; };
    double shortest = norm(rest(steps[0]) - rest(0));
    for (const std::int32_t step : steps) shortest = std::min(shortest, norm(rest(step) - rest(0)));
    const double much2 = (kMuch * shortest) * (kMuch * shortest);
    stretched.assign(nodes.size(), 0);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        node_places[n] = tissue.position(std::int32_t(n));
        node_moves[n] = node_places[n] - nodes[n].rest;
    }
    for (int a = 0; a < 3; ++a)
        for (std::int32_t n = 0; n < std::int32_t(nodes.size()); ++n) {
            const std::int32_t other = n + steps[a];
            if (n / steps[a] % size[a] + 1 == size[a]) continue;
            const Vec3d change = node_moves[std::size_t(other)] - node_moves[std::size_t(n)];
            if (dot(change, change) <= much2) continue;
            stretched[std::size_t(n)] = stretched[std::size_t(other)] = 1;
        }
    for (std::size_t c = 0; c < tissue.network().cells().size(); ++c) {
        // The parts of a cut cell follow the nodes on their side.
        if (tissue.network().is_cell_cut(c)) continue;
        const SpringCell& cell = tissue.network().cells()[c];
        if (std::none_of(cell.nodes.begin(), cell.nodes.end(),
                         [&](std::int32_t n) { return stretched[std::size_t(n)] != 0; }))
            continue;
        for (int corner = 0; corner < cell.node_count; ++corner)
            if (corner_volume(cell, corner, at) / corner_volume(cell, corner, rest) <= kFoldShare)
                return true;
    }
    return false;
}

Result<PushReport> SpringDeformation::push(std::uint32_t tool, const Push& push) noexcept {
    return attempt([&] { return m_impl->push(tool, push); });
}

/// Allocates memory, then changes the holders of the nodes, then moves. After the allocation only
/// the first step may fail.
Result<PushReport> SpringDeformation::Impl::push(std::uint32_t tool, const Push& push) {
    const auto start = std::chrono::steady_clock::now();
    if (const Status s = check(push); !s.ok()) return s.error();
    if (const Status s = show(); !s.ok()) return s.error();
    const auto place = is_finite(push.point_mm) ? control->find(push.point_mm) : std::nullopt;
    if (!place)
        return about(
            "push", ErrorCode::InvalidArgument,
            "expected a point inside of the control lattice, found " + text_of(push.point_mm));
    PushReport report;
    std::vector<std::int32_t> nodes = nodes_at(push, *place);
    std::sort(nodes.begin(), nodes.end());
    report.message = nodes.empty() ? "every control node there is fixed"
                                   : "a control cell would fold; larger cells go farther";
    std::vector<Vec3d> at_first(displacements.size()), before(displacements.size());
    for (std::size_t n = 0; n < at_first.size(); ++n)
        at_first[n] = tissue.position(std::int32_t(n));
    const std::vector<std::int32_t> former_before = former;
    SpringRollback rollback(tissue, nodes);
    Tools changed = with(tool, nodes);

    if (const auto found = tools.find(tool); found != tools.end())
        former.insert(former.end(), found->second.begin(), found->second.end());
    tools.swap(changed);
    renew_sources();
    if (nodes.empty()) {
        report.limited_by = LimitedBy::Bone;
        return report;
    }
    report.grabbed_elements = std::int64_t(nodes.size());
    const double length = norm(push.push_mm);
    const Vec3d cell = control->node_mm(0) - control->node_mm(1);
    const int strides = std::max(1, int(std::ceil(length / (kStrideShare * norm(cell)))));
    int done = 0;
    bool folded = folds();
    for (; done < strides; ++done) {
        before.swap(node_places);
        const Status went = stride(nodes, (1.0 / strides) * push.push_mm);
        if (!went.ok() && done == 0 && is_out_of_memory(went.error())) {
            tools.swap(changed);
            former.assign(former_before.begin(), former_before.end());
            renew_sources();
            rollback.restore();
            return went.error();
        }
        const bool is_folded = went.ok() && folds();
        if (went.ok() && (folded || !is_folded)) {
            folded = is_folded;
            continue;
        }
        put(before);
        break;
    }
    settled = is_shown = false;
    for (std::size_t n = 0; n < at_first.size(); ++n)
        report.moved_elements += tissue.position(std::int32_t(n)) != at_first[n];
    report.step_fraction = double(done) / strides;
    report.status = done == strides ? PushStatus::Applied
                    : done > 0      ? PushStatus::Limited
                                    : PushStatus::Rejected;
    if (done < strides)
        report.limited_by = LimitedBy::Fold;
    else
        report.message.clear();
    report.solve_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return report;
}

void SpringDeformation::let_go(std::uint32_t tool) noexcept {
    if (!m_impl->tools.contains(tool)) return;
    m_impl->let_go_of(tool);
    m_impl->renew_sources();
    m_impl->settled = false;
}
bool SpringDeformation::is_held() const {
    return !m_impl->held.empty();
}
bool SpringDeformation::holds(std::uint32_t tool) const {
    return m_impl->tools.contains(tool);
}

}  // namespace pliant
