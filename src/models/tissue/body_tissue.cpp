// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/body_tissue.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/errors.h"
#include "base/hash.h"
#include "base/text.h"
#include "mesh/mean_edge.h"
#include "pbd/rollback.h"

namespace pliant {
namespace {

/// A stride is at most this fraction of the mean edge, and half of a sphere's radius.
constexpr double kStrideShare = 0.25;
/// A tetrahedron is folded if it has less than this fraction of its volume left.
constexpr double kFoldShare = 0.1;
/// Share of a tool's volume that may be folded. Scanned surfaces have slivers of a thousandth of
/// that: a small motion turns them over, and their constraints turn them back.
constexpr double kFoldedShare = 0.01;
constexpr int kPauses = 8;  ///< time steps in which tissue gives way to a tool that stands still
constexpr double kMaxMotion_mm = 500;
// A body is at rest if no node leaves a ball of this radius for that long. Rounding makes nodes
// under load tremble by less than a micrometre. Single nodes between others that touch may tremble
// by tenths of a millimetre forever: a body stops so long after the last command at the latest.
constexpr double kCalm_mm = 0.02, kCalm_s = 0.1, kMaxUntold_s = 10;
constexpr std::size_t kNodesPerTrembler = 1000;  ///< so few may move on while a tool holds a body
constexpr double kBack_mm = 0.05;                ///< a settled body nearer to rest is moved to it
constexpr double kNewtonPerMicronewton = 1e-6;

double volume_of(const std::array<std::int32_t, 4>& cell, std::span<const Vec3d> x) {
    const Vec3d a = x[std::size_t(cell[0])];
    const auto edge = [&](std::size_t n) { return x[std::size_t(cell[n])] - a; };
    return dot(edge(1), cross(edge(2), edge(3))) / 6;
}

double tolerated_mm3(const Push& push) {
    return kFoldedShare * 4 / 3 * std::numbers::pi * std::pow(push.sphere_radius_mm, 3);
}

/// A tool's way in strides: all alike, and finer beyond a position where one failed.
class Strides {
  public:
    Strides(Vec3d way_mm, double longest_mm)
        : m_way(way_mm), m_count(std::max(1, int(std::ceil(norm(way_mm) / longest_mm)))) {}
    bool are_done() const { return m_done == m_count; }
    bool have_begun() const { return m_done > 0; }
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

Status check(const Push& push) {
    if (!(norm(push.push_mm) <= kMaxMotion_mm) || !is_finite(push.point_mm))
        return about(
            "push", ErrorCode::InvalidArgument,
            "expected three numbers and a length up to 500 mm, found " + text_of(push.push_mm));
    if (!(push.sphere_radius_mm >= 0 && push.sphere_radius_mm <= kMaxMotion_mm))
        return about("push", ErrorCode::InvalidArgument, "expected a sphere radius of 0 to 500 mm");
    return Ok{};
}

}  // namespace

BodyTissue::BodyTissue(ShapePointer whole, BodyPlan plan, std::unique_ptr<EmbeddedScan> carried)
    : m_plan(std::move(plan)),
      m_whole(std::move(whole)),
      m_shape(m_whole),
      m_carried(std::move(carried)) {
    m_edge_mm = mean_edge_mm(whole_mesh());
    m_positions.resize(m_shape->rest.size());
    m_velocities.resize(m_shape->rest.size());
    m_stepped.resize(m_shape->rest.size());
    m_shown.resize(m_shape->rest.size());
    m_shapes.reserve(kKeptShapes + 1);
    m_settled = is_weightless();
}

Result<std::unique_ptr<MeshTissue>> BodyTissue::create(const Volume& scan, PbdBody body,
                                                       BodyPlan plan, const TaskArena& arena) {
    if (const Status s = check_volume(scan); !s.ok()) return s.error();
    if (body.settings().volume_recovery > 0)
        return expected_error("volume_recovery", "0", text_of(body.settings().volume_recovery));
    if (plan.mesh.cells.empty())
        return expected_error("body", "volumes or solids", "a body without tetrahedra");
    for (std::size_t c = 0; c < plan.mesh.cells.size(); ++c)
        if (!(volume_of(plan.mesh.cells[c], plan.mesh.nodes_mm) > 0))
            return expected_error("body", "tetrahedra with a volume above 0",
                                  "tetrahedron " + std::to_string(c));
    if (plan.pieces.empty()) plan.pieces.assign(plan.mesh.cells.size(), 0);
    auto contact = BodyContact::create(plan.mesh, plan.pieces, {.friction = plan.friction});
    if (!contact) return contact.error();
    auto whole = std::make_shared<BodyShape>(
        BodyShape{.body = std::move(body), .contact = std::move(*contact)});
    PbdRollback::reserve(whole->body);
    // Particles are rounded to the body's precision, and at rest they don't move the scan.
    whole->body.get_positions(plan.mesh.nodes_mm);
    whole->set_mesh(plan.mesh);
    whole->set_touched(plan.mesh.cells, plan.pieces);
    auto carried = EmbeddedScan::create(
        scan, plan.mesh,
        {.reach_mm = plan.reach_mm, .solids = plan.pieces, .solid_at = plan.solid_at}, arena);
    if (!carried) return carried.error();
    plan.mesh = {};
    return std::unique_ptr<MeshTissue>(
        new BodyTissue(std::move(whole), std::move(plan), std::move(*carried)));
}

TissueTraits BodyTissue::traits() const noexcept {
    const double step_s = m_plan.steps * body().settings().time_step;
    return {.model = "body",
            .slides = true,
            .cuts = true,
            .moves_by_itself = true,
            .sweep_ms = 1000 * step_s,
            .update_hz = 1 / step_s};
}

// Tools.

/// Whether a point in a tetrahedron is in its material, or in that of another copy.
bool BodyTissue::carries(std::size_t cell, Vec3d point_mm) const {
    if (!m_shape->mesh || m_shape->mesh->part_of[cell] < 0) return true;
    const auto& nodes = m_shape->cells[cell];
    const auto at = [&](std::size_t n) { return body().position(nodes[n]); };
    const auto rest = [&](std::size_t n) { return m_shape->rest[std::size_t(nodes[n])]; };
    const Vec3d weights =
        inverse(Mat3d{{at(1) - at(0), at(2) - at(0), at(3) - at(0)}}) * (point_mm - at(0));
    const Vec3d edges = Mat3d{{rest(1) - rest(0), rest(2) - rest(0), rest(3) - rest(0)}} * weights;
    return m_shape->mesh->copy_of(m_shape->mesh->uncut_cell_of[cell], rest(0) + edges) ==
           std::int32_t(cell);
}

/// Nodes in a tool at a point of its way, without those that have no material.
/// @param or_around  if there are none, those of the tetrahedron around the point
std::vector<std::int32_t> BodyTissue::nodes_at(const Push& push, Vec3d point_mm,
                                               bool or_around) const {
    std::vector<std::int32_t> nodes;
    const std::int32_t count = body().particle_count();
    if (push.sphere_radius_mm > 0)
        for (std::int32_t n = 0; n < count; ++n)
            if (const Vec3d away = body().position(n) - point_mm;
                norm(away) <= push.sphere_radius_mm &&
                (!push.shape || push.shape->contains(away)) &&
                (!m_shape->mesh || m_shape->is_real[std::size_t(n)]))
                nodes.push_back(n);
    if (nodes.empty() && or_around && !push.shape)
        for (std::size_t number = 0; number < m_shape->cells.size(); ++number) {
            const auto& cell = m_shape->cells[number];
            std::array<Vec3d, 4> x;
            for (std::size_t n = 0; n < 4; ++n) x[n] = body().position(cell[n]) - point_mm;
            const auto part = [&](std::size_t a, std::size_t b, std::size_t c) {
                return dot(x[a], cross(x[b], x[c]));
            };
            if (!(part(1, 2, 3) >= 0 && part(0, 3, 2) >= 0 && part(0, 1, 3) >= 0 &&
                  part(0, 2, 1) >= 0) ||
                !carries(number, point_mm))
                continue;
            nodes.assign(cell.begin(), cell.end());
            break;
        }
    std::erase_if(nodes, [&](std::int32_t n) {
        return !(body().parts().inverse_masses[std::size_t(n)] > 0);
    });
    std::sort(nodes.begin(), nodes.end());
    return nodes;
}

/// Lets a tool hold these nodes, which other tools then lose.
void BodyTissue::take(std::uint32_t tool, std::vector<std::int32_t> nodes) {
    Tools changed = m_tools;
    changed.erase(tool);
    for (auto& [other, theirs] : changed)
        std::erase_if(theirs, [&](std::int32_t n) {
            return std::binary_search(nodes.begin(), nodes.end(), n);
        });
    std::erase_if(changed, [](const auto& entry) { return entry.second.empty(); });
    if (!nodes.empty()) changed[tool] = std::move(nodes);
    m_tools.swap(changed);
    set_masses();
}

/// Held nodes have an infinite mass.
void BodyTissue::set_masses() noexcept {
    const auto& inverse_masses = body().parts().inverse_masses;
    for (std::size_t n = 0; n < inverse_masses.size(); ++n)
        (void)body().set_inverse_mass(std::int32_t(n), inverse_masses[n]);
    for (const auto& [tool, nodes] : m_tools)
        for (const std::int32_t n : nodes) (void)body().set_inverse_mass(n, 0);
}

void BodyTissue::release(std::uint32_t tool) noexcept {
    if (m_tools.erase(tool) + m_spheres.erase(tool) == 0) return;
    set_masses();
    wake();
}

Status BodyTissue::place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept {
    if (!is_finite(position_mm) || !(radius_mm >= 0 && radius_mm <= kMaxMotion_mm))
        return about("eye", ErrorCode::InvalidArgument,
                     "expected a position, and a radius of 0 to 500 mm");
    return attempt([&]() -> Status {
        if (radius_mm > 0)
            m_eyes[tool] = {position_mm, position_mm, radius_mm};
        else
            m_eyes.erase(tool);
        return Ok{};
    });
}

/// Makes steps of the body. @param way_mm  of the tool's sphere meanwhile
Status BodyTissue::step(std::int32_t count, std::uint32_t tool, Vec3d way_mm) {
    if (!m_shape->has_pieces && m_spheres.empty() && m_eyes.empty())
        return body().step(count, arena());
    m_from.clear();
    for (const auto& [number, sphere] : m_spheres) m_from.push_back(sphere);
    for (const auto& [number, sphere] : m_eyes) m_from.push_back(sphere);
    m_to = m_from;
    const auto moved = m_spheres.find(tool);
    if (moved != m_spheres.end()) {
        BodyTool& to = m_to[std::size_t(std::distance(m_spheres.begin(), moved))];
        to.from = to.to = to.to + way_mm;
    }
    return m_shape->contact.step(count, body(), m_from, m_to, arena());
}

/// Makes a time step in which a tool's nodes move evenly. A jump in the first sub-step would throw
/// the nodes beside them.
Status BodyTissue::stride(std::uint32_t tool, Vec3d shift) {
    const auto held = m_tools.find(tool);
    if (held == m_tools.end()) return step(m_plan.steps);
    const Vec3d part = (1.0 / m_plan.steps) * shift;
    for (std::int32_t k = 0; k < m_plan.steps; ++k) {
        for (const std::int32_t n : held->second)
            if (const Status s = body().set_state(n, body().position(n) + part, {0, 0, 0}); !s.ok())
                return s;
        if (const Status s = step(1); !s.ok()) return s;
    }
    return Ok{};
}

/// Volume at rest of the tetrahedra that are folded.
double BodyTissue::folded_mm3(std::span<const Vec3d> x) const {
    const auto& cells = m_shape->cells;
    const std::vector<double>& rest = m_shape->rest_volumes;
    double sum = 0;
    for (std::size_t c = 0; c < cells.size(); ++c)
        if (volume_of(cells[c], x) < kFoldShare * rest[c]) sum += rest[c];
    return sum;
}

/// Copies positions and velocities, for put().
void BodyTissue::keep_state() {
    body().get_positions(m_positions);
    for (std::size_t n = 0; n < m_velocities.size(); ++n)
        m_velocities[n] = body().velocity(std::int32_t(n));
}

/// The body's box.
void BodyTissue::find_box(Vec3d& low, Vec3d& high) const {
    low = high = body().position(0);
    for (std::int32_t n = 1; n < body().particle_count(); ++n) {
        const Vec3d p = body().position(n);
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    }
}

/// Whether a sphere stays clear of the body's box on its way.
bool BodyTissue::is_free(const BodyTool& sphere, Vec3d way_mm) const {
    Vec3d low, high;
    find_box(low, high);
    for (int a = 0; a < 3; ++a) {
        const double begin = sphere.to[a], end = begin + way_mm[a];
        if (std::max(begin, end) + sphere.radius < low[a] ||
            std::min(begin, end) - sphere.radius > high[a])
            return true;
    }
    return false;
}

/// Whether a point lies in a solid.
bool BodyTissue::contains(std::span<const Vec3d> x, Vec3d point_mm) const {
    const auto at = [&](std::int32_t n) { return x[std::size_t(n)]; };
    const auto& cells = m_shape->touched;
    return std::any_of(cells.begin(), cells.end(), [&](const auto& cell) {
        return is_inside_tetrahedron(point_mm,
                                     {at(cell[0]), at(cell[1]), at(cell[2]), at(cell[3])});
    });
}

Result<SlideReport> BodyTissue::slide(std::uint32_t tool, const Push& way,
                                      const TissueValues&) noexcept {
    return attempt([&]() -> Result<SlideReport> {
        if (const Status s = check(way); !s.ok()) return s.error();
        if (!(way.sphere_radius_mm > 0) || way.shape)
            return expected_error("slide", "a sphere", way.shape ? "another shape" : "a point");
        Tools tools = m_tools;
        Spheres spheres = m_spheres;
        const bool was_settled = m_settled;
        PbdRollback::keep(body());
        auto report = attempt([&] { return slide_sphere(tool, way); });
        m_is_shown = false;
        if (report.ok()) return report;
        m_tools.swap(tools);
        m_spheres.swap(spheres);
        set_masses();
        PbdRollback::take_back(body());
        m_settled = was_settled;
        return report;
    });
}

Result<SlideReport> BodyTissue::slide_sphere(std::uint32_t tool, const Push& way) {
    const auto start = std::chrono::steady_clock::now();
    SlideReport report;
    if (m_tools.erase(tool) > 0) set_masses();
    BodyTool& sphere = m_spheres[tool];
    sphere = {way.point_mm, way.point_mm, way.sphere_radius_mm};
    Strides strides(way.push_mm, std::min(kStrideShare * m_edge_mm, way.sphere_radius_mm / 2));
    while (!strides.are_done()) {
        const Vec3d shift = strides.shift();
        if (!is_free(sphere, shift)) {
            keep_state();
            const double folded = std::max(folded_mm3(m_positions), tolerated_mm3(way));
            const bool was_inside = contains(m_positions, sphere.to);
            const Status went = step(m_plan.steps, tool, shift);
            if (!went.ok() && is_out_of_memory(went.error())) return went.error();
            body().get_positions(m_stepped);
            const bool fold = !went.ok() || folded_mm3(m_stepped) > folded;
            if (fold || (!was_inside && contains(m_stepped, sphere.to + shift))) {
                put(m_positions, m_velocities);
                if (strides.refine()) continue;
                report.limited_by = fold ? LimitedBy::Fold : LimitedBy::Wall;
                break;
            }
            report.contacts += m_shape->contact.touches() > 0;
            wake();
        }
        strides.go_on();
        sphere.from = sphere.to = way.point_mm + strides.offset();
    }
    if (report.contacts > 0) halt();
    report.way_fraction = strides.share();
    report.end_mm = sphere.to;
    body().get_positions(m_stepped);
    report.ends_in_tissue = contains(m_stepped, sphere.to);
    report.slide_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return report;
}

Result<PushReport> BodyTissue::push(std::uint32_t tool, const Push& push) noexcept {
    return attempt([&]() -> Result<PushReport> {
        if (const Status s = check(push); !s.ok()) return s.error();
        Tools before = m_tools;
        Spheres spheres = m_spheres;
        const bool was_settled = m_settled;
        PbdRollback::keep(body());
        auto report = attempt([&] { return push_nodes(tool, push); });
        m_is_shown = false;
        if (report.ok()) return report;
        m_tools.swap(before);
        m_spheres.swap(spheres);
        set_masses();
        PbdRollback::take_back(body());
        m_settled = was_settled;
        return report;
    });
}

Result<PushReport> BodyTissue::push_nodes(std::uint32_t tool, const Push& push) {
    const auto start = std::chrono::steady_clock::now();
    PushReport report;
    report.message = "tetrahedra would fold; a larger sphere or larger tetrahedra go farther";
    std::vector<Vec3d> first(m_positions.size());
    body().get_positions(first);
    m_spheres.erase(tool);
    take(tool, nodes_at(push, push.point_mm, true));
    const bool starts_inside = contains(first, push.point_mm);
    double longest = kStrideShare * m_edge_mm;
    if (push.sphere_radius_mm > 0) longest = std::min(longest, push.sphere_radius_mm / 2);
    Strides strides(push.push_mm, longest);
    int pauses = 0;
    while (!strides.are_done()) {
        if (push.sphere_radius_mm > 0 && strides.have_begun()) {
            // Nodes on the sphere's way join those that it holds.
            auto nodes = nodes_at(push, push.point_mm + strides.offset(), false);
            if (const auto held = m_tools.find(tool); held != m_tools.end())
                nodes.insert(nodes.end(), held->second.begin(), held->second.end());
            std::sort(nodes.begin(), nodes.end());
            nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
            const auto held = m_tools.find(tool);
            if (held == m_tools.end() ? !nodes.empty() : nodes.size() > held->second.size())
                take(tool, std::move(nodes));
        }
        keep_state();
        const double folded = std::max(folded_mm3(m_positions), tolerated_mm3(push));
        const auto goes = [&](Vec3d shift) -> Result<bool> {
            const Status went = stride(tool, shift);
            if (!went.ok() && is_out_of_memory(went.error())) return went.error();
            body().get_positions(m_stepped);
            if (went.ok() && folded_mm3(m_stepped) <= folded) return true;
            put(m_positions, m_velocities);
            return false;
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
    const auto held = m_tools.find(tool);
    if (held == m_tools.end() && !starts_inside && norm(push.push_mm) > 0) {
        Vec3d low, high;
        find_box(low, high);
        return about("push", ErrorCode::InvalidArgument,
                     "expected a point inside of a body, or a sphere that meets nodes that move, "
                     "found " +
                         text_of(push.point_mm) + "; bodies lie from " + short_text(low) + " to " +
                         short_text(high));
    }
    wake();
    report.grabbed_elements = held == m_tools.end() ? 0 : std::int64_t(held->second.size());
    for (std::size_t n = 0; n < first.size(); ++n)
        report.moved_elements += body().position(std::int32_t(n)) != first[n];
    report.step_fraction = strides.share();
    report.status = strides.are_done()     ? PushStatus::Applied
                    : strides.have_begun() ? PushStatus::Limited
                                           : PushStatus::Rejected;
    if (strides.are_done())
        report.message.clear();
    else
        report.limited_by = LimitedBy::Fold;
    if (strides.have_begun() && norm(push.push_mm) > 0) halt();
    report.solve_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return report;
}

std::optional<Vec3d> BodyTissue::force_n(std::uint32_t tool) noexcept try {
    if (const auto sphere = m_spheres.find(tool); sphere != m_spheres.end())
        return is_free(sphere->second, {0, 0, 0})  // no step was made there
                   ? Vec3d{0, 0, 0}
                   : kNewtonPerMicronewton * m_shape->contact.force(std::size_t(
                                                 std::distance(m_spheres.begin(), sphere)));
    Vec3d force{0, 0, 0};
    const auto held = m_tools.find(tool);
    if (held == m_tools.end()) return force;
    const std::vector<Vec3d> forces = body().constraint_forces();
    for (const std::int32_t n : held->second) force = force + forces[std::size_t(n)];
    return kNewtonPerMicronewton * force;
} catch (const std::bad_alloc&) {
    return {};
}

// Time.

void BodyTissue::put(std::span<const Vec3d> positions, std::span<const Vec3d> velocities) noexcept {
    PbdRollback::put_all(body(), positions, velocities);
    m_is_shown = false;
}

/// Stops all nodes. The time that a tool takes for its way is that of its strides, not the hand's,
/// so that its momentum would throw free organs farther than it moved.
void BodyTissue::halt() noexcept {
    body().get_positions(m_positions);
    std::fill(m_velocities.begin(), m_velocities.end(), Vec3d{0, 0, 0});
    put(m_positions, m_velocities);
}

/// Stops all nodes. A free body near its rest positions is moved to them.
void BodyTissue::come_to_rest() noexcept {
    double farthest = 0;
    body().get_positions(m_positions);
    for (std::size_t n = 0; n < m_shape->rest.size(); ++n)
        farthest = std::max(farthest, norm(m_positions[n] - m_shape->rest[n]));
    std::fill(m_velocities.begin(), m_velocities.end(), Vec3d{0, 0, 0});
    const bool is_home = farthest < kBack_mm && !is_touched() && m_eyes.empty() && is_weightless();
    put(is_home ? m_shape->rest : m_positions, m_velocities);
}

/// Whether no node has moved visibly for a while.
bool BodyTissue::is_calm() {
    const double step_s = m_plan.steps * body().settings().time_step;
    if (++m_untold_sweeps * step_s >= kMaxUntold_s) return true;
    body().get_positions(m_positions);
    const std::size_t tremblers = is_touched() ? m_positions.size() / kNodesPerTrembler : 0;
    std::size_t moved = 0;
    for (std::size_t n = 0; n < m_calm.size() && n < m_positions.size(); ++n)
        moved += !(norm(m_positions[n] - m_calm[n]) < kCalm_mm);
    if (m_calm.size() != m_positions.size() || moved > tremblers) {
        m_calm = m_positions;
        m_calm_sweeps = 0;
        return false;
    }
    ++m_calm_sweeps;
    return m_calm_sweeps * step_s >= kCalm_s;
}

Result<Sweep> BodyTissue::sweep() noexcept {
    return attempt([&]() -> Result<Sweep> {
        const auto start = std::chrono::steady_clock::now();
        if (!m_settled) {
            m_calm.reserve(m_positions.size());
            const Status stepped = step(m_plan.steps);
            if (!stepped.ok() && is_out_of_memory(stepped.error())) return stepped.error();
            // A body that can't move any more stops: the failed step would recur.
            m_settled = !stepped.ok() || is_calm();
            if (m_settled) come_to_rest();
            m_is_shown = false;
        }
        return Sweep{m_settled, std::chrono::duration<double, std::milli>(
                                    std::chrono::steady_clock::now() - start)
                                    .count()};
    });
}

// The whole body.

Status BodyTissue::reset() noexcept {
    m_tools.clear();
    m_spheres.clear();
    set_masses();
    std::fill(m_velocities.begin(), m_velocities.end(), Vec3d{0, 0, 0});
    put(m_shape->rest, m_velocities);
    wake();
    m_settled = is_weightless();
    return Ok{};
}

Record BodyTissue::figures() const {
    int fixed = 0;
    for (const double w : body().parts().inverse_masses) fixed += !(w > 0);
    Record figures{{"particles", int(body().particle_count())},
                   {"tetrahedra", int(m_shape->cells.size())},
                   {"fixed_particles", fixed},
                   {"edge_mm", m_edge_mm},
                   {"time_step_ms", traits().sweep_ms}};
    if (!m_plan.bodies.empty()) figures.emplace_back("bodies", m_plan.bodies);
    return figures;
}

Record BodyTissue::report() const {
    Record record{{"summary", std::to_string(body().particle_count()) + " particles, " +
                                  std::to_string(m_shape->cells.size()) + " tetrahedra"},
                  {"solver", "position-based"},
                  {"body.carried_voxels", SettingValue(m_carried->voxel_count())}};
    for (NamedValue& figure : figures())
        record.emplace_back("body." + figure.name, std::move(figure.value));
    return record;
}

/// The first six numbers are those of node 0.
void BodyTissue::state(std::vector<double>& numbers) const {
    const std::vector<double>& cuts = m_shape->cuts;
    const std::size_t whole = m_whole->rest.size();
    const std::size_t beside = cuts.empty() ? 0 : 1 + cuts.size();
    numbers.resize(6 * m_positions.size() + beside);
    for (std::size_t n = 0; n < m_positions.size(); ++n) {
        const Vec3d x = body().position(std::int32_t(n)), v = body().velocity(std::int32_t(n));
        const std::size_t at = 6 * n + (n < whole ? 0 : beside);
        for (int a = 0; a < 3; ++a) {
            numbers[at + std::size_t(a)] = x[a];
            numbers[at + 3 + std::size_t(a)] = v[a];
        }
    }
    if (cuts.empty()) return;
    numbers[6 * whole] = double(cuts.size());
    std::copy(cuts.begin(), cuts.end(), numbers.begin() + std::ptrdiff_t(6 * whole + 1));
}

Status BodyTissue::set_state(std::span<const double> numbers) noexcept {
    return attempt([&]() -> Status {
        const std::size_t whole = 6 * m_whole->rest.size();
        std::span<const double> cuts;
        std::size_t beside = 0;
        if (numbers.size() > whole) {
            const double count = numbers[whole];
            if (!(count >= 1 && count <= double(numbers.size() - whole - 1)) ||
                count != std::floor(count))
                return invalid("expected position and velocity of as many particles");
            cuts = numbers.subspan(whole + 1, std::size_t(count));
            beside = 1 + cuts.size();
        }
        const auto shape = shape_with(cuts);
        if (!shape.ok()) return shape.error();
        const std::vector<Vec3d>& rest = (*shape)->rest;
        if (numbers.size() != 6 * rest.size() + beside)
            return invalid("expected position and velocity of as many particles");
        std::vector<Vec3d> positions, velocities;
        bool is_home = true;
        for (std::size_t n = 0; n < rest.size(); ++n) {
            const double* at = numbers.data() + 6 * n + (6 * n < whole ? 0 : beside);
            positions.push_back({at[0], at[1], at[2]});
            velocities.push_back({at[3], at[4], at[5]});
            if (!(norm(positions.back() - rest[n]) <= kMaxMotion_mm) ||
                !(norm(velocities.back()) <= 1e9))
                return invalid("expected particles within 500 mm of their rest positions");
            is_home &= positions.back() == rest[n] && velocities.back() == Vec3d{0, 0, 0};
        }
        Tools tools;
        Spheres spheres;
        if (const Status s = take_shape(*shape, positions, velocities, tools, spheres); !s.ok())
            return s;
        wake();
        m_settled = is_home && is_weightless();
        return Ok{};
    });
}

std::uint64_t BodyTissue::hash() const {
    Hash64 hash;
    for (std::int32_t n = 0; n < body().particle_count(); ++n) {
        const Vec3d numbers[2] = {body().position(n), body().velocity(n)};
        hash.add(std::span<const Vec3d>(numbers));
    }
    if (!m_shape->cuts.empty()) hash.add(std::span<const double>(m_shape->cuts));
    return hash.value();
}

Status BodyTissue::show() const {
    if (m_is_shown) return Ok{};
    body().get_positions(m_shown);
    const Status placed = m_carried->place(m_shown);
    if (!placed.ok() && is_out_of_memory(placed.error())) return placed;
    m_is_shown = true;
    return Ok{};
}

Status BodyTissue::update_deformation() const {
    return attempt([&] { return show(); });
}

const Deformation& BodyTissue::deformation() const {
    (void)update_deformation();
    return m_carried->deformation();
}

}  // namespace pliant
