// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pushes and slides in strides.

#include <pliant/models/mesh_tissue.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "mesh/box_tree.h"

namespace pliant {
namespace {

constexpr int kPauses = 8;  ///< steps in which tissue gives way to a tool that stands still
constexpr double kMaxWay_mm = 500;

/// A tool's way in strides: all alike, and finer beyond a position where one failed.
class Strides {
  public:
    Strides(Vec3d way_mm, double longest_mm)
        : m_way(way_mm), m_count(std::max(1, int(std::ceil(norm(way_mm) / longest_mm)))) {}
    bool are_done() const { return m_done == m_count; }
    bool have_begun() const { return m_done > 0; }
    int done() const { return m_done; }
    int count() const { return m_count; }
    double share() const { return double(m_done) / m_count; }
    Vec3d shift() const { return (1.0 / m_count) * m_way; }
    Vec3d offset() const { return double(m_done) * shift(); }
    void go_on() { ++m_done; }
    /// @returns false: they are as fine as can be
    bool refine() {
        if (m_refined == kRefinements) return false;
        ++m_refined;
        m_count *= 2;
        m_done *= 2;
        return true;
    }

  private:
    static constexpr int kRefinements = 3;
    Vec3d m_way;
    int m_count, m_done = 0, m_refined = 0;
};

Status check_way(const Push& push) {
    if (!(norm(push.push_mm) <= kMaxWay_mm) || !is_finite(push.point_mm))
        return about(
            "push", ErrorCode::InvalidArgument,
            "expected three numbers and a length up to 500 mm, found " + text_of(push.push_mm));
    if (!(push.sphere_radius_mm >= 0 && push.sphere_radius_mm <= kMaxWay_mm))
        return about("push", ErrorCode::InvalidArgument, "expected a sphere radius of 0 to 500 mm");
    return Ok{};
}

}  // namespace

/// Calls a function that moves tools and nodes, and undoes its changes if it fails.
template <class Act>
auto MeshTissue::undone_on_error(const Act& act) {
    Tools tools = m_tools;
    Spheres spheres = m_spheres;
    const bool was_settled = m_settled;
    keep();
    auto report = attempt(act);
    m_is_shown = false;
    if (report.ok()) return report;
    m_tools.swap(tools);
    m_spheres.swap(spheres);
    hold_nodes();
    take_back();
    m_settled = was_settled;
    return report;
}

/// Takes the positions that a stride led to, or those before it. @returns whether it was good
Result<bool> MeshTissue::end_stride(const Status& went, double tolerated) {
    if (!went.ok() && is_out_of_memory(went.error())) return went.error();
    if (went.ok()) {
        positions_mm(m_memory.stepped);
        const double folded = folded_cells(m_memory.stepped);
        if (folded <= std::max(m_folded, tolerated)) {
            m_folded = folded;
            m_memory.positions.swap(m_memory.stepped);
            return true;
        }
    }
    put(m_memory.positions, m_memory.velocities);
    return false;
}

// Pushes.

Result<PushReport> MeshTissue::push(std::uint32_t tool, const Push& push) noexcept {
    return attempt([&]() -> Result<PushReport> {
        if (const Status s = check_way(push); !s.ok()) return s.error();
        if (const Status s = check_push(push); !s.ok()) return s.error();
        return undone_on_error([&] { return push_nodes(tool, push); });
    });
}

Result<PushReport> MeshTissue::push_nodes(std::uint32_t tool, const Push& push) {
    const Stopwatch watch;
    const Rules rules = this->rules(push);
    PushReport report;
    positions_mm(m_memory.positions);
    m_memory.first = m_memory.positions;
    const bool lets_go = is_touched_by(tool);
    m_spheres.erase(tool);
    take(tool, nodes_at(push, push.point_mm, true));
    const auto reject = [&] {
        report.limited_by = LimitedBy::Bone;
        report.message = "every node there is fixed";
        if (lets_go) wake();
    };
    if (!rules.gathers && held_by(tool).empty()) {
        reject();
        return report;
    }
    const bool starts_inside = contains(m_memory.first, push.point_mm);
    m_folded = folded_cells(m_memory.positions);
    Strides strides(push.push_mm, rules.longest_mm);
    int pauses = 0;
    while (!strides.are_done()) {
        if (rules.gathers && push.sphere_radius_mm > 0 && strides.have_begun())
            gather(tool, push, push.point_mm + strides.offset());
        const auto goes = [&](Vec3d shift) {
            velocities_mm_s(m_memory.velocities);
            const Status went = stride(held_by(tool), shift);
            auto good = end_stride(went, rules.tolerated_folds);
            if (good.ok() && !*good)
                report.message = went.ok() ? std::string(rules.folds) : went.error().message;
            return good;
        };
        auto went = goes(strides.shift());
        if (went.ok() && *went) {
            strides.go_on();
            continue;
        }
        if (went.ok() && strides.refine()) continue;
        if (went.ok() && pauses++ < kPauses) went = goes({0, 0, 0});
        if (!went.ok()) return went.error();
        if (!*went) break;
    }
    if (held_by(tool).empty() && norm(push.push_mm) > 0) {
        bool meets = false;
        for (int n = 0; n <= strides.done() && !meets; ++n)
            meets = !nodes_met(push, push.point_mm + double(n) * strides.shift(), n == 0).empty();
        if (meets) {
            reject();
            take_back();
            hold_nodes();
            return report;
        }
        if (!starts_inside)
            if (const Status s = check_free_push(push); !s.ok()) return s.error();
    }
    wake();
    report.grabbed_elements = std::int64_t(held_by(tool).size());
    for (std::size_t n = 0; n < m_memory.first.size(); ++n)
        report.moved_elements += m_memory.positions[n] != m_memory.first[n];
    report.step_fraction = strides.share();
    report.status = strides.are_done()     ? PushStatus::Applied
                    : strides.have_begun() ? PushStatus::Limited
                                           : PushStatus::Rejected;
    if (strides.are_done())
        report.message.clear();
    else
        report.limited_by = LimitedBy::Fold;
    if (rules.halts && strides.have_begun() && norm(push.push_mm) > 0) halt();
    report.solve_ms = watch.ms();
    return report;
}

// Slides.

bool MeshTissue::is_free(const TouchTool& sphere, Vec3d way_mm) const {
    if (!sphere.triangles.empty()) return false;
    mesh::Bounds box, swept;
    for (const Vec3d& p : m_memory.positions) box.add(p);
    swept.add(sphere.position);
    swept.add(sphere.position + way_mm);
    for (int a = 0; a < 3; ++a)
        if (swept.low[a] - sphere.radius > box.high[a] ||
            swept.high[a] + sphere.radius < box.low[a])
            return true;
    return false;
}

MeshTissue::SlideStep MeshTissue::slide_step(const TouchTool&, const Push& way, int n,
                                             int count) const {
    const Vec3d shift = (1.0 / count) * way.push_mm;
    return {shift, way.point_mm + double(n + 1) * shift};
}

Result<SlideReport> MeshTissue::slide(std::uint32_t tool, const Push& way,
                                      const TissueValues& tissue_values) noexcept {
    if (!traits().slides) return NodeTissue::slide(tool, way, tissue_values);
    return attempt([&]() -> Result<SlideReport> {
        if (const Status s = check_way(way); !s.ok()) return s.error();
        if (!(way.sphere_radius_mm > 0) || way.shape)
            return expected_error("slide", "a sphere", way.shape ? "another shape" : "a point");
        return undone_on_error([&] { return slide_sphere(tool, way); });
    });
}

Result<SlideReport> MeshTissue::slide_sphere(std::uint32_t tool, const Push& way) {
    const Stopwatch watch;
    const Rules rules = this->rules(way);
    SlideReport report;
    m_tools.erase(tool);
    TouchTool& sphere = m_spheres[tool];
    if (sphere.position != way.point_mm || sphere.radius != way.sphere_radius_mm)
        sphere = {way.point_mm, way.sphere_radius_mm};
    hold_nodes();
    positions_mm(m_memory.positions);
    if (!can_begin(sphere)) {
        m_spheres.erase(tool);
        hold_nodes();
        report.end_mm = way.point_mm;
        report.limited_by = LimitedBy::Wall;
        report.ends_in_tissue = true;
        report.slide_ms = watch.ms();
        return report;
    }
    m_folded = folded_cells(m_memory.positions);
    Strides strides(way.push_mm, rules.longest_mm);
    while (!strides.are_done()) {
        const SlideStep step = slide_step(sphere, way, strides.done(), strides.count());
        if (!is_free(sphere, step.shift)) {
            const auto limit = slide_stride(tool, step, rules.tolerated_folds);
            if (!limit.ok()) return limit.error();
            if (*limit != LimitedBy::None) {
                if (strides.refine()) continue;
                report.limited_by = *limit;
                break;
            }
            report.contacts += touches(sphere);
            wake();
        }
        strides.go_on();
        sphere.position = step.to;
    }
    if (rules.halts && report.contacts > 0) halt();
    report.way_fraction = strides.share();
    report.end_mm = sphere.position;
    report.ends_in_tissue = contains(m_memory.positions, sphere.position);
    report.slide_ms = watch.ms();
    return report;
}

/// @returns the reason if the stride can't be made and is undone
Result<LimitedBy> MeshTissue::slide_stride(std::uint32_t tool, const SlideStep& step,
                                           double tolerated) {
    TouchTool& sphere = m_spheres[tool];
    const TouchTool before = sphere;
    const double folded = m_folded;
    const bool was_inside = contains(m_memory.positions, before.position);
    velocities_mm_s(m_memory.velocities);
    const auto went = slide_by(tool, sphere, step.shift);
    LimitedBy limit = went.ok() ? *went : LimitedBy::Fold;
    if (!went.ok() || limit == LimitedBy::None) {
        const auto good = end_stride(went.ok() ? Status(Ok{}) : Status(went.error()), tolerated);
        if (!good.ok()) return good.error();
        limit = LimitedBy::Fold;
        if (*good) {
            if (was_inside || !contains(m_memory.positions, before.position + step.shift))
                return LimitedBy::None;
            limit = LimitedBy::Wall;
            m_memory.positions.swap(m_memory.stepped);
            m_folded = folded;
        }
    }
    sphere = before;
    hold_nodes();
    put(m_memory.positions, m_memory.velocities);
    return limit;
}

}  // namespace pliant
