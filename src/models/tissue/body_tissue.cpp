// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/body_tissue.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "base/units.h"
#include "mesh/box_tree.h"
#include "pbd/rollback.h"

namespace pliant {
namespace {

/// Share of a tool's volume that may be folded. Scanned surfaces have slivers of a thousandth of
/// that: a small motion turns them over, and their constraints turn them back.
constexpr double kFoldedShare = 0.01;
// A body is at rest if no node leaves a ball of this radius for that long. Rounding makes nodes
// under load tremble by less than a micrometre. Single nodes between others that touch may tremble
// by tenths of a millimetre forever: a body stops so long after the last command at the latest.
constexpr double kCalm_mm = 0.02, kCalm_s = 0.1, kMaxUntold_s = 10;
// While a tool holds the body, one node in 1000 may move on, and one in 100 by up to kCreep_mm in
// that time: crushed cells between bodies creep for seconds.
constexpr std::size_t kNodesPerTrembler = 1000, kNodesPerCreeper = 100;
constexpr double kCreep_mm = 0.2;
/// Trials in which a time step of bodies that touch finds the forces of the sub-step before it.
/// Each halves their error, which is 6 times the forces at first where bodies crush each other.
constexpr std::int32_t kTrials = 8;
constexpr double kBack_mm = 0.05;  ///< a settled body nearer to rest is moved to it

}  // namespace

BodyTissue::BodyTissue(ShapePointer whole, BodyPlan plan, std::unique_ptr<MovingScan> carried)
    : MeshTissue(std::move(carried), whole->rest.nodes_mm.size()),
      m_plan(std::move(plan)),
      m_whole(std::move(whole)),
      m_shape(m_whole) {
    m_calm.reserve(m_whole->rest.nodes_mm.size());
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
    if (const auto cell = inverted_cell(rest_mesh(plan.mesh)))
        return expected_error("body", "tetrahedra with a volume above 0",
                              "tetrahedron " + std::to_string(*cell));
    if (plan.pieces.empty()) plan.pieces.assign(plan.mesh.cells.size(), 0);
    auto contact = BodyContact::create(plan.mesh, plan.pieces, {.friction = plan.friction});
    if (!contact) return contact.error();
    auto whole = std::make_shared<BodyShape>(
        BodyShape{.body = std::move(body), .contact = std::move(*contact)});
    PbdRollback::reserve(whole->body);
    // Particles are rounded to the body's precision, and at rest they don't move the scan.
    whole->body.get_positions(plan.mesh.nodes_mm);
    whole->rest = rest_mesh(plan.mesh);
    whole->set_touched(plan.mesh.cells, plan.pieces);
    auto carried = EmbeddedScan::create(
        scan, plan.mesh,
        {.reach_mm = plan.reach_mm, .solids = plan.pieces, .solid_at = plan.solid_at}, arena);
    if (!carried) return carried.error();
    plan.mesh = {};
    return std::unique_ptr<MeshTissue>(
        new BodyTissue(std::move(whole), std::move(plan), std::move(*carried)));
}

Result<std::int32_t> body_steps(const PbdParts& parts, double time_step_s, std::int32_t at_least) {
    constexpr double kMost = 1000;
    const double needed = std::ceil(wave_sub_steps(parts, time_step_s));
    if (needed > kMost)
        return expected_error("sub_steps",
                              "at most 1000 for waves that cross an edge each; larger cells, a "
                              "shorter time_step_s or softer or denser tissue need fewer",
                              short_text(needed));
    return std::max(at_least, std::int32_t(needed));
}

TissueTraits BodyTissue::traits() const noexcept {
    return {.model = "body",
            .slides = true,
            .cuts = true,
            .moves_by_itself = true,
            .sweep_ms = 1000 * step_s(),
            .update_hz = 1 / step_s()};
}

// Tools.

MeshTissue::Rules BodyTissue::rules(const Push& push) const {
    Rules rules = MeshTissue::rules(push);
    rules.tolerated_folds =
        kFoldedShare * 4 / 3 * std::numbers::pi * std::pow(push.sphere_radius_mm, 3);
    // The time that a tool takes for its way is that of its strides, not the hand's, so that its
    // momentum would throw free organs farther than it moved.
    rules.halts = true;
    rules.folds = "tetrahedra would fold; a larger sphere or larger tetrahedra go farther";
    return rules;
}

/// Whether a point is in a tetrahedron, and in its material rather than that of another copy.
bool BodyTissue::is_in_cell(std::size_t cell, Vec3d point_mm) const {
    const auto& nodes = m_shape->rest.cells[cell];
    std::array<Vec3d, 4> x;
    for (std::size_t n = 0; n < 4; ++n) x[n] = m_memory.positions[std::size_t(nodes[n])] - point_mm;
    const auto part = [&](std::size_t a, std::size_t b, std::size_t c) {
        return dot(x[a], cross(x[b], x[c]));
    };
    if (!(part(1, 2, 3) >= 0 && part(0, 3, 2) >= 0 && part(0, 1, 3) >= 0 && part(0, 2, 1) >= 0))
        return false;
    if (!m_shape->mesh || m_shape->mesh->part_of[cell] < 0) return true;
    const auto at = [&](std::size_t n) { return body().position(nodes[n]); };
    const auto rest = [&](std::size_t n) { return m_shape->rest.nodes_mm[std::size_t(nodes[n])]; };
    const Vec3d weights =
        inverse(Mat3d{{at(1) - at(0), at(2) - at(0), at(3) - at(0)}}) * (point_mm - at(0));
    const Vec3d edges = Mat3d{{rest(1) - rest(0), rest(2) - rest(0), rest(3) - rest(0)}} * weights;
    return m_shape->mesh->copy_of(m_shape->mesh->uncut_cell_of[cell], rest(0) + edges) ==
           std::int32_t(cell);
}

Status BodyTissue::check_free_push(const Push& push) const {
    mesh::Bounds box;
    for (const Vec3d& p : m_memory.positions) box.add(p);
    return about("push", ErrorCode::InvalidArgument,
                 "expected a point inside of a body, or a sphere that meets nodes that move, "
                 "found " +
                     text_of(push.point_mm) + "; bodies lie from " + short_text(box.low) + " to " +
                     short_text(box.high));
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

/// Held nodes have an infinite mass.
void BodyTissue::hold_nodes() noexcept {
    const auto& inverse_masses = body().parts().inverse_masses;
    for (std::size_t n = 0; n < inverse_masses.size(); ++n)
        (void)body().set_inverse_mass(std::int32_t(n), inverse_masses[n]);
    for (const auto& [tool, nodes] : m_tools)
        for (const std::int32_t n : nodes) (void)body().set_inverse_mass(n, 0);
}

/// Makes steps of the body. @param way_mm  of the tool's sphere meanwhile
Status BodyTissue::step_contact(std::int32_t count, std::uint32_t tool, Vec3d way_mm) {
    if (!m_shape->has_pieces && m_spheres.empty() && m_eyes.empty())
        return body().step(count, arena());
    m_from.clear();
    for (const Spheres* spheres : {&m_spheres, &m_eyes})
        for (const auto& [number, sphere] : *spheres)
            m_from.push_back({sphere.position, sphere.position, sphere.radius});
    m_to = m_from;
    const auto moved = m_spheres.find(tool);
    if (moved != m_spheres.end()) {
        BodyTool& to = m_to[std::size_t(std::distance(m_spheres.begin(), moved))];
        to.from = to.to = to.to + way_mm;
    }
    return m_shape->contact.step(count, body(), m_from, m_to, arena());
}

/// Makes a time step in which nodes move evenly. It begins with the forces of the present shape, so
/// that it depends on positions and velocities alone. A jump in the first sub-step would throw the
/// nodes beside them.
Status BodyTissue::stride(std::span<const std::int32_t> nodes, Vec3d shift) {
    body().recall_forces(nodes.empty() && m_shape->has_pieces ? kTrials : 0);
    if (nodes.empty()) return step_contact(m_plan.steps);
    const Vec3d part = (1.0 / m_plan.steps) * shift;
    for (std::int32_t k = 0; k < m_plan.steps; ++k) {
        for (const std::int32_t n : nodes)
            if (const Status s = body().set_state(n, body().position(n) + part, {0, 0, 0}); !s.ok())
                return s;
        if (const Status s = step_contact(1); !s.ok()) return s;
    }
    return Ok{};
}

Result<LimitedBy> BodyTissue::slide_by(std::uint32_t tool, TouchTool&, Vec3d shift) {
    body().recall_forces();
    if (const Status s = step_contact(m_plan.steps, tool, shift); !s.ok()) return s.error();
    return LimitedBy::None;
}

bool BodyTissue::touches(const TouchTool&) const {
    return m_shape->contact.touches() > 0;
}

std::optional<Vec3d> BodyTissue::force_n(std::uint32_t tool) noexcept try {
    if (const auto sphere = m_spheres.find(tool); sphere != m_spheres.end()) {
        positions_mm(m_memory.positions);
        return is_free(sphere->second, {0, 0, 0})  // no step was made there
                   ? Vec3d{0, 0, 0}
                   : kNewtonsPerMicronewton * m_shape->contact.force(std::size_t(
                                                  std::distance(m_spheres.begin(), sphere)));
    }
    Vec3d force{0, 0, 0};
    const auto held = held_by(tool);
    if (held.empty()) return force;
    const std::vector<Vec3d> forces = body().constraint_forces();
    for (const std::int32_t n : held) force = force + forces[std::size_t(n)];
    return kNewtonsPerMicronewton * force;
} catch (const std::bad_alloc&) {
    return {};
}

// Time.

void BodyTissue::put(std::span<const Vec3d> positions, std::span<const Vec3d> velocities) noexcept {
    PbdRollback::put_all(body(), positions, velocities);
}

void BodyTissue::velocities_mm_s(std::span<Vec3d> velocities) const {
    for (std::size_t n = 0; n < velocities.size(); ++n)
        velocities[n] = body().velocity(std::int32_t(n));
}

void BodyTissue::keep() {
    PbdRollback::keep(body());
}

void BodyTissue::take_back() noexcept {
    PbdRollback::take_back(body());
}

double BodyTissue::home_mm() const {
    return is_weightless() ? kBack_mm : 0;
}

/// Whether no node has moved visibly for a while.
bool BodyTissue::is_calm() {
    if (m_sweeps == 1) m_calm.clear();
    if (m_sweeps * step_s() >= kMaxUntold_s) return true;
    const auto& x = m_memory.positions;
    const std::size_t touched = is_touched() ? x.size() : 0;
    std::size_t moved = 0, far = 0;
    for (std::size_t n = 0; n < m_calm.size() && n < x.size(); ++n) {
        const double way = norm(x[n] - m_calm[n]);
        moved += !(way < kCalm_mm);
        far += !(way < kCreep_mm);
    }
    if (m_calm.size() != x.size() || moved > touched / kNodesPerCreeper ||
        far > touched / kNodesPerTrembler) {
        m_calm = x;
        m_calm_sweeps = 0;
        return false;
    }
    ++m_calm_sweeps;
    return m_calm_sweeps * step_s() >= kCalm_s;
}

// The whole body.

int BodyTissue::fixed_particles() const {
    int fixed = 0;
    for (std::int32_t n = 0; n < node_count(); ++n) fixed += is_fixed(n);
    return fixed;
}

Record BodyTissue::figures() const {
    Record figures{
        {"particles", int(node_count())},       {"tetrahedra", int(m_shape->rest.cells.size())},
        {"fixed_particles", fixed_particles()}, {"edge_mm", m_whole->rest.edge_mm},
        {"sub_steps", int(m_plan.steps)},       {"time_step_ms", traits().sweep_ms}};
    if (!m_plan.bodies.empty()) figures.emplace_back("bodies", m_plan.bodies);
    return figures;
}

Record BodyTissue::report() const {
    Record record{{"summary", std::to_string(node_count()) + " particles (" +
                                  std::to_string(fixed_particles()) + " held), " +
                                  std::to_string(m_shape->rest.cells.size()) + " tetrahedra"},
                  {"solver", "position-based"},
                  {"body.carried_voxels", SettingValue(carried().voxel_count())}};
    for (NamedValue& figure : figures())
        record.emplace_back("body." + figure.name, std::move(figure.value));
    return record;
}

}  // namespace pliant
