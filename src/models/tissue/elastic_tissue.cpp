// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/elastic_tissue.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "field/fixed_point.h"

namespace pliant {
namespace {

constexpr double kSweepMs = 20;         ///< simulated time of a sweep
constexpr double kStillMm = 0.01;       ///< a sweep that moves nothing farther has settled
constexpr double kHomeMm = 0.02;        ///< free tissue so near to rest is put there
constexpr double kLeastVolume = 0.05;   ///< determinants of a state that is shown
constexpr int kResponseIterations = 4;  ///< for each axis, when a drag begins
constexpr int kDragIterations = 1;
constexpr double kFarthestStep = 2;  ///< of a tool that goes on, relative to the step before
constexpr int kStrideIterations = 2, kSweepIterations = 2;
constexpr double kAside = 0.1;  ///< part of a step beside the last one that is let pass
constexpr double kNearlyIncompressible = 0.47;  ///< strides take one more above that ratio
constexpr int kMostSweeps = 30;  ///< after a tool's motion: contacts may alternate for ever
constexpr int kHalvings = 2;     ///< of a stride that would fold cells
constexpr int kContactRounds = 2;
constexpr double kContactMm = 0.002;  ///< nodes so deep in a sphere join its contacts

bool has(std::span<const HeldNode> nodes, Vec3i voxel) {
    return std::any_of(nodes.begin(), nodes.end(),
                       [&](const HeldNode& node) { return node.node == voxel; });
}

bool is_valid(const Push& push) {
    return is_finite(push.point_mm) && is_finite(push.push_mm) && push.sphere_radius_mm >= 0 &&
           std::isfinite(push.sphere_radius_mm);
}

}  // namespace

ElasticTissue::ElasticTissue(const Volume& scan, const ElasticScanSettings& settings,
                             const TaskArena& arena)
    : m_scan(scan),
      m_arena(arena),
      m_settings(settings),
      m_field(scan.grid),
      m_map(scan, settings, arena, &m_field.field()),
      m_levels(m_map, settings.window_cells, true, arena),
      m_deformation(m_field.field()) {}

TissueTraits ElasticTissue::traits() const noexcept {
    return {.model = "elastic",
            .slides = true,
            .cuts = true,
            .carves = true,
            .moves_by_itself = true,
            .sweep_ms = kSweepMs,
            .update_hz = 1000 / kSweepMs};
}

Vec3d ElasticTissue::lattice_of(Vec3d world_mm) const {
    return lattice_from_world_vector(m_scan.grid, world_mm - m_scan.grid.origin_mm);
}

Vec3d ElasticTissue::rest_mm(Vec3i voxel) const {
    const Vec3d& h = m_scan.grid.spacing_mm;
    return {h.x * voxel.x, h.y * voxel.y, h.z * voxel.z};
}

/// Visits voxels whose present position is in a sphere: visit(ijk, u, position), on the lattice.
template <class Visit>
void ElasticTissue::visit_near(Vec3d centre_mm, double radius_mm, const Visit& visit) const {
    const Vec3d& h = m_scan.grid.spacing_mm;
    const double reach = radius_mm + m_levels.largest_mm();
    Vec3i begin{}, end{};
    for (int a = 0; a < 3; ++a) {
        const double low = std::ceil((centre_mm[a] - reach) / h[a]);
        const double high = std::floor((centre_mm[a] + reach) / h[a]) + 1;
        begin[a] = int(std::clamp(low, 0.0, double(m_scan.grid.size[a])));
        end[a] = int(std::clamp(high, double(begin[a]), double(m_scan.grid.size[a])));
    }
    const std::size_t count = std::size_t(end.x - begin.x);
    std::vector<float> memory(3 * count);
    const NodeRows u{memory.data(), memory.data() + count, memory.data() + 2 * count};
    for (int k = begin.z; k < end.z; ++k)
        for (int j = begin.y; j < end.y; ++j) {
            m_levels.displacement_row({begin.x, j, k}, int(count), u);
            for (int i = begin.x; i < end.x; ++i) {
                const std::size_t n = std::size_t(i - begin.x);
                const Vec3d shift{u[0][n], u[1][n], u[2][n]};
                const Vec3d now = rest_mm({i, j, k}) + shift;
                if (norm(now - centre_mm) <= radius_mm) visit(Vec3i{i, j, k}, shift, now);
            }
        }
}

/// Nodes that a push takes hold of, where they are.
std::vector<HeldNode> ElasticTissue::nodes_at(const Push& push, Vec3d centre_mm,
                                              bool or_around) const {
    std::vector<HeldNode> nodes;
    const Vec3d centre_world =
        m_scan.grid.origin_mm + world_from_lattice_vector(m_scan.grid, centre_mm);
    if (push.sphere_radius_mm > 0)
        visit_near(centre_mm, push.sphere_radius_mm, [&](Vec3i voxel, Vec3d u, Vec3d now) {
            if (!m_map.is_tissue(voxel) || m_map.is_held(0, voxel)) return;
            const Vec3d world = m_scan.grid.origin_mm + world_from_lattice_vector(m_scan.grid, now);
            if (push.shape && !push.shape->contains(world - centre_world)) return;
            nodes.push_back({voxel, u, {}});
        });
    if (!nodes.empty() || !or_around) return nodes;
    // The cell that holds the point: X + u(X) = centre by fixed-point iteration.
    const Vec3d& h = m_scan.grid.spacing_mm;
    Vec3d rest = centre_mm;
    float u[3];
    const auto voxel_at = [&](Vec3d at) {
        Vec3i voxel;
        for (int a = 0; a < 3; ++a)
            voxel[a] = int(std::clamp(at[a] / h[a], 0.0, double(m_scan.grid.size[a] - 1)));
        return voxel;
    };
    for (int turn = 0; turn < 20; ++turn) {
        m_levels.displacement_row(voxel_at(rest + 0.5 * h), 1, {&u[0], &u[1], &u[2]});
        rest = centre_mm - Vec3d{u[0], u[1], u[2]};
    }
    for (int a = 0; a < 3; ++a)
        if (!(rest[a] > -h[a] && rest[a] < h[a] * m_scan.grid.size[a])) return nodes;
    const Vec3i low = voxel_at(rest);
    for (int c = 0; c < 8; ++c) {
        const Vec3i voxel = low + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        if (voxel.x >= m_scan.grid.size.x || voxel.y >= m_scan.grid.size.y ||
            voxel.z >= m_scan.grid.size.z || m_map.is_held(0, voxel) || !m_map.is_tissue(voxel))
            continue;
        m_levels.displacement_row(voxel, 1, {&u[0], &u[1], &u[2]});
        nodes.push_back({voxel, {u[0], u[1], u[2]}, {}});
    }
    return nodes;
}

/// Nodes that the sphere meets in a stride join the tool: those in it before, and walls that face
/// it. What lies behind a wall evades with it.
/// @param centre_mm  after the stride
void ElasticTissue::gather(Tool& tool, const Push& push, Vec3d centre_mm, Vec3d shift_mm) {
    if (push.sphere_radius_mm == 0) return;
    int axis = 0;  // the longest way, in voxels
    const auto voxels = [&](int a) { return std::abs(shift_mm[a]) / m_scan.grid.spacing_mm[a]; };
    for (const int a : {1, 2})
        if (voxels(a) > voxels(axis)) axis = a;
    for (const HeldNode& met : nodes_at(push, centre_mm, false)) {
        if (has(tool.nodes, met.node)) continue;
        Vec3i before = met.node;
        before[axis] += shift_mm[axis] > 0 ? -1 : 1;
        const bool faces =
            before[axis] < 0 || before[axis] >= m_scan.grid.size[axis] || !m_map.is_tissue(before);
        const Vec3d now = rest_mm(met.node) + met.displacement_mm;
        if (faces || norm(now - (centre_mm - shift_mm)) < push.sphere_radius_mm)
            tool.nodes.push_back(met);
    }
}

/// Centres the windows if a tool leaves the finest one.
void ElasticTissue::look_at(const Way& way) {
    m_levels.forget_windows();
    const Vec3d& h = m_scan.grid.spacing_mm;
    const Vec3d middle = way.from_mm + 0.5 * way.shift_mm;
    const Vec3d voxel{middle.x / h.x, middle.y / h.y, middle.z / h.z};
    const double margin = 3 + (way.radius_mm + 0.5 * norm(way.shift_mm)) / shortest_edge_mm();
    if (!m_levels.is_inside(voxel, std::min(margin, m_settings.window_cells / 3.0)))
        m_levels.focus(voxel);
}

void ElasticTissue::hold_all() {
    std::vector<HeldNode> nodes;
    for (const auto* const tools : {&m_tools, &m_eyes})
        for (const auto& [number, tool] : *tools)
            nodes.insert(nodes.end(), tool.nodes.begin(), tool.nodes.end());
    m_levels.hold(nodes);
}

int ElasticTissue::stride_iterations() const {
    return kStrideIterations + (m_settings.poisson_ratio > kNearlyIncompressible);
}

void ElasticTissue::solve(int iterations) {
    (void)m_levels.start();
    for (int n = 0; n < iterations; ++n)
        if (m_levels.iterate() == 0) break;
    find_forces();
}

/// The tools' forces in the state before cells are untangled.
void ElasticTissue::find_forces() {
    std::vector<Vec3i> voxels;
    for (const auto* const tools : {&m_tools, &m_eyes})
        for (const auto& [number, tool] : *tools)
            for (const HeldNode& node : tool.nodes) voxels.push_back(node.node);
    const std::vector<Vec3d> forces = m_levels.forces_un(voxels);
    auto force = forces.begin();
    for (auto* const tools : {&m_tools, &m_eyes})
        for (auto& [number, tool] : *tools) {
            Vec3d sum{0, 0, 0};
            tool.forces_un.assign(force, force + std::ptrdiff_t(tool.nodes.size()));
            for (const HeldNode& node : tool.nodes) {
                const auto& only = node.only_along;
                sum = sum + (only ? dot(*force, *only) * *only + node.force_un : *force);
                ++force;
            }
            tool.force_un = -1.0 * sum;  // the opposite of what holds the nodes
        }
}

/// The bone in a sphere, if there is any [lattice].
std::optional<Vec3d> ElasticTissue::bone_in(Vec3d centre_mm, double radius_mm) const {
    std::optional<Vec3d> found;
    const Vec3d& h = m_scan.grid.spacing_mm;
    Vec3i begin, end;
    for (int a = 0; a < 3; ++a) {
        begin[a] = std::max(0, int(std::ceil((centre_mm[a] - radius_mm) / h[a])));
        end[a] =
            std::min(m_scan.grid.size[a], int(std::floor((centre_mm[a] + radius_mm) / h[a])) + 1);
    }
    for (int k = begin.z; k < end.z && !found; ++k)
        for (int j = begin.y; j < end.y && !found; ++j)
            for (int i = begin.x; i < end.x && !found; ++i)
                if (const Vec3d at = rest_mm({i, j, k});
                    norm(at - centre_mm) < radius_mm && m_map.is_bone({i, j, k}))
                    found = at;
    return found;
}

/// Lets a tool hold its nodes where they are: some may have slipped.
void ElasticTissue::stay(Tool& tool) const {
    for (HeldNode& node : tool.nodes) {
        float u[3];
        m_levels.displacement_row(node.node, 1, {&u[0], &u[1], &u[2]});
        node.displacement_mm = {u[0], u[1], u[2]};
    }
}

/// Moves a tool along a way in strides: move(centre, shift, is_last) acts on it, and solves. If its
/// folds can't be smoothed, a stride is undone and halved.
template <class Move>
ElasticTissue::WayEnd ElasticTissue::follow(const Way& way, Tool& tool, const Move& move) {
    WayEnd end;
    const double length = norm(way.shift_mm);
    if (length == 0) return {.fraction = 1};
    double part = 1 / std::ceil(length / way.longest_mm - 1e-9);
    int halvings = 0;
    while (end.fraction < 1 - 1e-9) {
        const double step = std::min(part, 1 - end.fraction);
        const Vec3d now = way.from_mm + end.fraction * way.shift_mm;
        const Vec3d next = now + step * way.shift_mm;
        if (const auto bone = bone_in(next, way.radius_mm); bone && !bone_in(now, way.radius_mm)) {
            end.limited_by = LimitedBy::Bone;
            end.bone_mm = m_scan.grid.origin_mm + world_from_lattice_vector(m_scan.grid, *bone);
            end.message = "the tool meets bone";
            return end;
        }
        m_levels.copy_to(m_before);
        const Tool before = tool;
        move(next, step * way.shift_mm, end.fraction + step > 1 - 1e-9);
        if (m_levels.untangle(kLeastVolume)) {
            if (m_levels.was_tangled()) {
                end.message = "tissue slips from the tool where it would fold";
                m_step.reset();
            } else if (m_step) {
                m_step->earlier.swap(m_before);
            }
            end.fraction += step;
            continue;
        }
        m_step.reset();
        (void)m_levels.copy_from(m_before);
        tool = before;
        stay(tool);
        hold_all();
        if (++halvings > kHalvings) {
            end.limited_by = LimitedBy::Fold;
            end.message = "tissue would fold; larger tools go farther";
            return end;
        }
        part /= 2;
    }
    end.fraction = 1;
    return end;
}

double ElasticTissue::shortest_edge_mm() const {
    const Vec3d& h = m_scan.grid.spacing_mm;
    return std::min({h.x, h.y, h.z});
}

Result<PushReport> ElasticTissue::do_push(std::uint32_t number, const Push& push) {
    const Stopwatch watch;
    if (!is_valid(push)) return expected_error("push", "finite numbers", text_of(push.push_mm));
    const Way way{.from_mm = lattice_of(push.point_mm),
                  .shift_mm = lattice_from_world_vector(m_scan.grid, push.push_mm),
                  .radius_mm = push.sphere_radius_mm,
                  .longest_mm = std::max(push.sphere_radius_mm / 2, shortest_edge_mm())};
    look_at(way);
    std::vector<HeldNode> nodes = nodes_at(push, way.from_mm, true);
    // Tissue that another tool holds changes hands.
    for (auto& [other, held] : m_tools)
        if (std::erase_if(held.nodes, [&](const HeldNode& node) { return has(nodes, node.node); }))
            held.forces_un.clear();
    if (m_drag && m_drag->tool == number) m_drag.reset();
    Tool& tool = m_tools[number] = {.nodes = std::move(nodes)};
    m_is_shown = m_settled = false;
    m_is_fresh = true;
    m_sweeps = 0;
    hold_all();
    const auto bone = tool.nodes.empty() ? bone_in(way.from_mm, way.radius_mm) : std::nullopt;
    if (bone) {
        m_tools.erase(number);
        return PushReport{
            .limited_by = LimitedBy::Bone,
            .message = "the tool holds bone alone",
            .bone_mm = m_scan.grid.origin_mm + world_from_lattice_vector(m_scan.grid, *bone)};
    }
    const WayEnd end = follow(way, tool, [&](Vec3d centre, Vec3d shift, bool is_last) {
        gather(tool, push, centre, shift);
        const bool goes_on = norm(go_on(number, shift)) <= kAside * norm(shift);
        for (HeldNode& node : tool.nodes) node.displacement_mm = node.displacement_mm + shift;
        hold_all();
        if (!tool.nodes.empty()) solve(stride_iterations() - (goes_on && !is_last ? 1 : 0));
    });
    PushReport report = report_of(end, tool);
    if (tool.nodes.empty()) m_tools.erase(number);
    report.solve_ms = watch.ms();
    return report;
}

PushReport ElasticTissue::report_of(const WayEnd& end, const Tool& tool) const {
    return {.status = end.limited_by == LimitedBy::None ? PushStatus::Applied
                      : end.fraction > 0                ? PushStatus::Limited
                                                        : PushStatus::Rejected,
            .limited_by = end.limited_by,
            .step_fraction = end.fraction,
            .grabbed_elements = std::int64_t(tool.nodes.size()),
            .moved_elements = m_levels.moved_voxels(kHomeMm),
            .message = end.message,
            .bone_mm = end.bone_mm};
}

// Drags.

Result<GrabReport> ElasticTissue::do_grab(std::uint32_t tool, const Push& position, double) {
    const Stopwatch watch;
    Push still = position;
    still.push_mm = {0, 0, 0};
    const Result<PushReport> report = do_push(tool, still);
    if (!report) return report.error();
    m_drag.reset();
    if (report->grabbed_elements > 0) {
        m_drag = Drag{.tool = tool,
                      .from_mm = lattice_of(position.point_mm),
                      .radius_mm = position.sphere_radius_mm};
        m_tools.at(tool).centre_mm = m_drag->from_mm;
        m_step = Step{tool, {0, 0, 0}};
        find_response();
    }
    return GrabReport{.grabbed_elements = report->grabbed_elements,
                      .grab_ms = watch.ms(),
                      .message = report->message};
}

void ElasticTissue::find_response() {
    std::vector<Vec3i> voxels;
    for (const HeldNode& node : m_tools.at(m_drag->tool).nodes) voxels.push_back(node.node);
    m_levels.find_response(voxels, kResponseIterations, m_drag->response);
}

Result<PushReport> ElasticTissue::do_drag_to(Vec3d offset_mm) {
    const Stopwatch watch;
    if (!m_drag) return invalid("drag: expected a grab before it");
    if (!is_finite(offset_mm)) return expected_error("drag", "finite numbers", text_of(offset_mm));
    Tool& tool = m_tools.at(m_drag->tool);
    const Vec3d to_mm = m_drag->from_mm + lattice_from_world_vector(m_scan.grid, offset_mm);
    const Way way{.from_mm = tool.centre_mm,
                  .shift_mm = to_mm - tool.centre_mm,
                  .radius_mm = m_drag->radius_mm,
                  .longest_mm = std::max(m_drag->radius_mm, shortest_edge_mm())};
    look_at(way);
    m_is_shown = m_settled = false;
    m_is_fresh = true;
    m_sweeps = 0;
    const WayEnd end = follow(way, tool, [&](Vec3d centre, Vec3d shift, bool) {
        const bool is_predicted = predict(shift);
        tool.centre_mm = centre;
        for (HeldNode& node : tool.nodes) node.displacement_mm = node.displacement_mm + shift;
        hold_all();
        solve(is_predicted ? kDragIterations : stride_iterations());
    });
    PushReport report = report_of(end, tool);
    report.solve_ms = watch.ms();
    return report;
}

/// Moves the tissue on as in the tool's last step. @pre m_before is the present state
/// @returns the part of the shift for which it has not moved: all of it where there is no last step
Vec3d ElasticTissue::go_on(std::uint32_t tool, Vec3d shift_mm) {
    const std::optional<Step> last = std::exchange(m_step, Step{tool, shift_mm});
    if (!last || last->tool != tool || last->earlier.empty()) return shift_mm;
    const double square = dot(last->shift_mm, last->shift_mm);
    const double part =
        square > 0 ? std::clamp(dot(shift_mm, last->shift_mm) / square, 0.0, kFarthestStep) : 0.0;
    if (part == 0 || !std::isfinite(m_levels.go_back(last->earlier, -part))) return shift_mm;
    return shift_mm - part * last->shift_mm;
}

/// Moves the tissue to the next position of a drag. @returns false if it has to be solved for
bool ElasticTissue::predict(Vec3d shift_mm) {
    const bool is_smooth = m_step.has_value();
    const Vec3d aside = go_on(m_drag->tool, shift_mm);
    if (!is_smooth) return false;
    // The response is lost when the windows move: to find it again takes longer than to go without.
    return norm(aside) <= kAside * norm(shift_mm) || m_levels.respond(m_drag->response, aside);
}

void ElasticTissue::let_go() noexcept {
    if (m_drag) release(m_drag->tool);
    m_drag.reset();
}

/// The nodes in contact that are pressed stay at the sphere's surface, as do nodes in its way: a
/// primal-dual active set [Hintermueller2002]. With friction they move with the sphere until the
/// force along its surface exceeds Coulomb's, which then acts on them.
void ElasticTissue::find_contacts(Tool& tool) const {
    const double friction = m_settings.friction;
    const Vec3d shift = tool.centre_mm - tool.held_at_mm;
    std::vector<HeldNode> contacts;
    std::vector<Vec3d> surface;
    const auto add = [&](Vec3i voxel, Vec3d u, bool sticks, Vec3d force) {
        const Vec3d from_centre = rest_mm(voxel) + u - tool.centre_mm;
        const double distance = norm(from_centre);
        if (!(distance > 0)) return;
        const Vec3d normal = (1 / distance) * from_centre;
        HeldNode& node =
            contacts.emplace_back(HeldNode{voxel, u + (tool.radius_mm - distance) * normal, {}});
        surface.push_back(tool.radius_mm * normal);
        if (sticks) return;
        node.only_along = normal;
        node.force_un = force - dot(force, normal) * normal;
    };
    for (std::size_t n = 0; n < tool.nodes.size(); ++n) {
        const HeldNode& node = tool.nodes[n];
        float of_node[3];
        m_levels.displacement_row(node.node, 1, {&of_node[0], &of_node[1], &of_node[2]});
        const Vec3d u{of_node[0], of_node[1], of_node[2]};
        if (tool.forces_un.size() != tool.nodes.size()) {  // not solved yet
            add(node.node, node.only_along ? u : u + shift, !node.only_along, node.force_un);
            continue;
        }
        const Vec3d normal = (1 / tool.radius_mm) * tool.surface_mm[n];
        const double pressure = dot(tool.forces_un[n], normal);
        if (pressure < 0) continue;
        const Vec3d along = tool.forces_un[n] - pressure * normal;
        if (!node.only_along) {
            const bool holds = norm(along) <= friction * pressure;
            add(node.node, u + shift, holds,
                holds ? Vec3d{0, 0, 0} : (friction * pressure / norm(along)) * along);
            continue;
        }
        // Friction acts against the motion over the sphere; where that turns, the node sticks.
        const Vec3d moved = rest_mm(node.node) + u - tool.held_at_mm - tool.surface_mm[n];
        const Vec3d slid = moved - dot(moved, normal) * normal;
        const bool turns = friction > 0 && dot(slid, node.force_un) > 0;
        const double length = norm(node.force_un);
        add(node.node, u, turns,
            length > 0 ? (friction * pressure / length) * node.force_un : Vec3d{0, 0, 0});
    }
    visit_near(tool.centre_mm, tool.radius_mm - kContactMm, [&](Vec3i voxel, Vec3d u, Vec3d) {
        if (m_map.is_held(0, voxel) || m_field.field().is_void(voxel)) return;
        if (!tool.tissue.hold(double(m_scan.at(voxel))) || has(contacts, voxel)) return;
        add(voxel, u, friction > 0, {0, 0, 0});
    });
    tool.nodes = std::move(contacts);
    tool.surface_mm = std::move(surface);
    tool.held_at_mm = tool.centre_mm;
    tool.forces_un.clear();
}

/// Finds the nodes in contact, and their equilibrium.
void ElasticTissue::press(Tool& tool) {
    for (int round = 0; round < kContactRounds; ++round) {
        const bool had = !tool.nodes.empty();
        find_contacts(tool);
        if (!had && tool.nodes.empty()) return;
        hold_all();
        solve(stride_iterations());
    }
}

Result<SlideReport> ElasticTissue::do_slide(std::uint32_t number, const Push& push,
                                            const TissueValues& tissue_values) {
    const Stopwatch watch;
    if (!is_valid(push) || push.sphere_radius_mm == 0)
        return expected_error("slide", "finite numbers and a radius above 0",
                              text_of(push.push_mm));
    const Way way{.from_mm = lattice_of(push.point_mm),
                  .shift_mm = lattice_from_world_vector(m_scan.grid, push.push_mm),
                  .radius_mm = push.sphere_radius_mm,
                  .longest_mm = shortest_edge_mm()};
    look_at(way);
    if (m_drag && m_drag->tool == number) m_drag.reset();
    Tool& tool = m_tools[number];
    if (!tool.slides) tool = {};
    tool.slides = true;
    tool.centre_mm = way.from_mm;
    tool.radius_mm = way.radius_mm;
    tool.tissue = tissue_values;
    m_is_shown = m_settled = false;
    m_is_fresh = true;
    m_sweeps = 0;
    m_step.reset();
    const WayEnd end = follow(way, tool, [&](Vec3d centre, Vec3d, bool) {
        tool.centre_mm = centre;
        press(tool);
    });
    hold_all();
    SlideReport report{.way_fraction = end.fraction,
                       .limited_by = end.limited_by,
                       .end_mm = push.point_mm + end.fraction * push.push_mm,
                       .contacts = int(tool.nodes.size()),
                       .message = end.message,
                       .bone_mm = end.bone_mm};
    if (tool.nodes.empty()) m_tools.erase(number);
    report.slide_ms = watch.ms();
    return report;
}

void ElasticTissue::release(std::uint32_t tool) noexcept {
    if (m_drag && m_drag->tool == tool) m_drag.reset();
    if (m_tools.erase(tool) == 0) return;
    m_step.reset();
    m_settled = false;
    m_returns = true;
    m_sweeps = 0;
    const Status held = attempt([&]() -> Status {
        hold_all();
        return Ok{};
    });
    (void)held;
}

bool ElasticTissue::is_touched_by(std::uint32_t tool) const noexcept {
    return m_tools.contains(tool);
}

Status ElasticTissue::place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept {
    return attempt([&]() -> Status {
        if (!is_finite(position_mm) || !(radius_mm >= 0 && radius_mm <= kMaxMovementMm))
            return expected_error("eye", "a position, and a radius of 0 to 500 mm",
                                  text_of(radius_mm));
        const bool had = m_eyes.erase(tool) > 0;
        if (radius_mm > 0) {
            Tool eye;
            eye.slides = true;
            eye.centre_mm = lattice_of(position_mm);
            eye.radius_mm = radius_mm;
            m_eyes[tool] = std::move(eye);
        }
        if (had || radius_mm > 0) m_settled = m_settled && m_levels.largest_mm() == 0;
        return Ok{};
    });
}

Result<Sweep> ElasticTissue::do_sweep() {
    const Stopwatch watch;
    Sweep sweep;
    if (m_settled) {
        sweep.largest_step_mm = 0;
        return sweep;
    }
    m_levels.forget_windows();
    // A tool that moved has had its solution for this step of time.
    if (std::exchange(m_is_fresh, false) && !m_returns && !m_tools.empty()) {
        sweep.settled = false;
        return sweep;
    }
    if (m_step) m_step->shift_mm = {0, 0, 0};
    m_is_shown = false;
    const double stays = std::exp(-kSweepMs / 1000 / m_settings.return_s);
    if (m_tools.empty() && m_eyes.empty()) {
        const double largest = m_levels.largest_mm();
        sweep.largest_step_mm = (1 - stays) * largest;
        m_levels.scale(stays);
        if (stays * largest < kHomeMm) {
            sweep.largest_step_mm = largest;
            m_levels.reset();
            m_settled = true;
            m_returns = false;
        }
    } else {
        m_levels.copy_to(m_before);
        for (auto* const tools : {&m_tools, &m_eyes})
            for (auto& [number, tool] : *tools)
                if (tool.slides) find_contacts(tool);
        hold_all();
        solve(kSweepIterations);
        if (!m_levels.untangle(kLeastVolume)) {
            (void)m_levels.go_back(m_before, 1);
            m_settled = true;
            return Sweep{.ms = watch.ms(), .message = "tissue would fold", .largest_step_mm = 0};
        }
        const double largest = m_levels.go_back(m_before, m_returns ? stays : 0);
        sweep.largest_step_mm = m_returns ? (1 - stays) * largest : largest;
        if (largest < (m_returns ? kHomeMm : kStillMm)) {
            m_settled = !m_returns;
            m_returns = false;
        }
        if (!m_returns && ++m_sweeps >= kMostSweeps) m_settled = true;
        if (m_tools.empty() && m_levels.largest_mm() < kHomeMm) {
            m_levels.reset();
            m_settled = true;
            m_returns = false;
        }
    }
    sweep.settled = m_settled;
    sweep.ms = watch.ms();
    return sweep;
}

Status ElasticTissue::do_reset() {
    m_tools.clear();
    m_drag.reset();
    m_step.reset();
    m_is_fresh = false;
    m_levels.reset();
    m_settled = true;
    m_returns = false;
    m_is_shown = false;
    return Ok{};
}

// A state: the lattices', then 16 · index + edits of each edited voxel, and the number of those.

void ElasticTissue::state(std::vector<double>& numbers) const {
    m_levels.copy_to(numbers);
    const std::size_t begin = numbers.size();
    const Field& field = m_field.field();
    for (const auto& [coord, edits] : field.all_edits())
        for (std::size_t n = 0; n < edits.size(); ++n)
            if (edits[n])
                numbers.push_back(
                    16.0 * double(voxel_index(m_scan.grid, field.element_of(coord, int(n)))) +
                    edits[n]);
    std::sort(numbers.begin() + std::ptrdiff_t(begin), numbers.end());
    numbers.push_back(double(numbers.size() - begin));
}

/// The edits of a state; none if it can't be one.
std::optional<EditMap> ElasticTissue::edits_of(std::span<const double> numbers) const {
    const Field& field = m_field.field();
    const Vec3i size = m_scan.grid.size;
    EditMap bricks;
    double before = -1;
    for (const double number : numbers) {
        if (!(number > before && number < 16.0 * double(voxel_count(m_scan.grid)))) return {};
        before = number;
        const auto whole = std::int64_t(number);
        if (double(whole) != number || whole % 16 == 0) return {};
        const std::int64_t at = whole / 16;
        const Vec3i e{int(at % size.x), int(at / size.x % size.y),
                      int(at / (std::int64_t(size.x) * size.y))};
        const Vec3i coord = field.brick_of(e);
        BrickEdits& edits = bricks[coord];
        edits.resize(std::size_t(field.elements_per_brick()));
        edits[std::size_t(field.index_in_brick(e, coord))] = std::uint8_t(whole % 16);
    }
    return bricks;
}

Status ElasticTissue::do_set_state(std::span<const double> numbers) {
    const Error wrong = invalid("expected a state of this tissue");
    if (numbers.empty() || !(numbers.back() >= 0 && numbers.back() < double(numbers.size())))
        return wrong;
    const std::size_t count = std::size_t(numbers.back());
    auto edits = edits_of(numbers.last(count + 1).first(count));
    if (!edits) return wrong;
    if (!m_levels.copy_from(numbers.first(numbers.size() - count - 1))) return wrong;
    for (const auto& [coord, now] : m_field.field().all_edits()) (*edits)[coord];
    std::erase_if(*edits, [&](const auto& brick) {
        const BrickEdits* const now = m_field.field().edits_of(brick.first);
        return now && *now == brick.second;
    });
    m_levels.forget_windows();
    m_tools.clear();
    m_drag.reset();
    m_step.reset();
    m_is_fresh = false;
    edit(*edits);
    m_is_shown = false;
    m_settled = m_levels.largest_mm() == 0;
    m_returns = !m_settled;
    return Ok{};
}

std::optional<Vec3d> ElasticTissue::do_force_n(std::uint32_t number) {
    const auto found = m_tools.find(number);
    if (found == m_tools.end()) return Vec3d{0, 0, 0};
    return 1e-6 * world_from_lattice_vector(m_scan.grid, found->second.force_un);
}

Record ElasticTissue::figures() const {
    return {{"nodes", int(m_levels.node_count())},
            {"bytes_per_node", double(m_levels.bytes()) / double(m_levels.node_count())}};
}

// The field.

Status ElasticTissue::update_deformation() const {
    if (m_is_shown) return Ok{};
    return attempt([&]() -> Status {
        (void)m_field.show(m_levels, m_map, std::numeric_limits<std::int64_t>::max(), m_arena);
        m_is_shown = true;
        return Ok{};
    });
}

Result<bool> ElasticTissue::approach_deformation(std::int64_t max_elements) const {
    if (m_is_shown) return true;
    return attempt([&]() -> Result<bool> {
        m_is_shown = m_field.show(m_levels, m_map, max_elements, m_arena);
        return m_is_shown;
    });
}

}  // namespace pliant
