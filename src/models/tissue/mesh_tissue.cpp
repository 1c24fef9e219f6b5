// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/mesh_tissue.h>

#include <algorithm>
#include <utility>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "mesh/mean_edge.h"
#include "resample/embedded_scan.h"

namespace pliant {
namespace {

/// A stride is at most this fraction of the mean edge.
constexpr double kMeshStrideShare = 0.25;
/// A tetrahedron is folded if it has less than this fraction of its volume left.
constexpr double kMeshFoldShare = 0.1;
constexpr double kFarthestAway_mm = 500;

std::array<Vec3d, 4> corners_of(const std::array<std::int32_t, 4>& cell, std::span<const Vec3d> x) {
    return {x[std::size_t(cell[0])], x[std::size_t(cell[1])], x[std::size_t(cell[2])],
            x[std::size_t(cell[3])]};
}

double volume_of(const std::array<Vec3d, 4>& x) {
    return dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) / 6;
}

}  // namespace

RestMesh rest_mesh(TetMesh mesh) {
    RestMesh rest{.edge_mm = mesh.cells.empty() ? 0 : mean_edge_mm(mesh)};
    for (const auto& cell : mesh.cells)
        rest.volumes_mm3.push_back(volume_of(corners_of(cell, mesh.nodes_mm)));
    rest.nodes_mm = std::move(mesh.nodes_mm);
    rest.cells = std::move(mesh.cells);
    return rest;
}

std::optional<std::size_t> inverted_cell(const RestMesh& mesh) {
    for (std::size_t c = 0; c < mesh.volumes_mm3.size(); ++c)
        if (!(mesh.volumes_mm3[c] > 0)) return c;
    return {};
}

MeshTissue::Memory::Memory(std::size_t nodes)
    : first(nodes),
      first_velocities(nodes),
      positions(nodes),
      velocities(nodes),
      stepped(nodes),
      shown(nodes) {}

MeshTissue::MeshTissue(std::unique_ptr<MovingScan> carried, std::size_t node_count)
    : m_carried(std::move(carried)), m_memory(node_count) {}

Result<std::unique_ptr<MovingScan>> MeshTissue::carry(const Volume& scan, const TetMesh& mesh,
                                                      double reach_mm, const TaskArena& arena) {
    auto carried = EmbeddedScan::create(scan, mesh, {.reach_mm = reach_mm}, arena);
    if (!carried.ok()) return carried.error();
    return std::unique_ptr<MovingScan>(std::move(*carried));
}

// Tools.

MeshTissue::Rules MeshTissue::rules(const Push& push) const {
    double longest = kMeshStrideShare * at_rest().edge_mm;
    if (push.sphere_radius_mm > 0) longest = std::min(longest, push.sphere_radius_mm / 2);
    return {.longest_mm = longest};
}

bool MeshTissue::is_in_cell(std::size_t cell, Vec3d point_mm) const {
    return is_inside_tetrahedron(point_mm, corners_of(at_rest().cells[cell], m_memory.positions));
}

std::vector<std::int32_t> MeshTissue::nodes_around(const Push& push) const {
    const auto& cells = at_rest().cells;
    for (std::size_t c = 0; c < cells.size(); ++c)
        if (is_in_cell(c, push.point_mm)) return {cells[c].begin(), cells[c].end()};
    return {};
}

/// Nodes in a tool at a point of its way.
/// @param or_around  if there are none, those of the cell around the point
std::vector<std::int32_t> MeshTissue::nodes_met(const Push& push, Vec3d point_mm,
                                                bool or_around) const {
    std::vector<std::int32_t> nodes;
    const auto& x = m_memory.positions;
    if (push.sphere_radius_mm > 0)
        for (std::size_t n = 0; n < x.size(); ++n)
            if (const Vec3d away = x[n] - point_mm; norm(away) <= push.sphere_radius_mm &&
                                                    (!push.shape || push.shape->contains(away)) &&
                                                    has_material(std::int32_t(n)))
                nodes.push_back(std::int32_t(n));
    // A small sphere lies between the nodes.
    if (nodes.empty() && or_around && !push.shape) nodes = nodes_around(push);
    return nodes;
}

/// Those of them that can move, in order.
std::vector<std::int32_t> MeshTissue::nodes_at(const Push& push, Vec3d point_mm,
                                               bool or_around) const {
    std::vector<std::int32_t> nodes = nodes_met(push, point_mm, or_around);
    std::erase_if(nodes, [&](std::int32_t n) { return is_fixed(n); });
    std::sort(nodes.begin(), nodes.end());
    return nodes;
}

std::span<const std::int32_t> MeshTissue::held_by(std::uint32_t tool) const {
    const auto found = m_tools.find(tool);
    if (found == m_tools.end()) return {};
    return found->second;
}

/// Lets a tool hold these nodes, which other tools then lose.
void MeshTissue::take(std::uint32_t tool, std::vector<std::int32_t> nodes) {
    Tools changed = m_tools;
    changed.erase(tool);
    for (auto& [other, theirs] : changed)
        std::erase_if(theirs, [&](std::int32_t n) {
            return std::binary_search(nodes.begin(), nodes.end(), n);
        });
    std::erase_if(changed, [](const auto& entry) { return entry.second.empty(); });
    if (!nodes.empty()) changed[tool] = std::move(nodes);
    m_tools.swap(changed);
    hold_nodes();
}

/// Lets the nodes that a sphere has met join those that it holds.
void MeshTissue::gather(std::uint32_t tool, const Push& push, Vec3d centre_mm) {
    std::vector<std::int32_t> nodes = nodes_at(push, centre_mm, false);
    const auto held = held_by(tool);
    nodes.insert(nodes.end(), held.begin(), held.end());
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    if (nodes.size() > held.size()) take(tool, std::move(nodes));
}

void MeshTissue::release(std::uint32_t tool) noexcept {
    if (m_tools.erase(tool) + m_spheres.erase(tool) == 0) return;
    hold_nodes();
    wake();
}

Status MeshTissue::place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept {
    return attempt([&]() -> Status {
        if (!is_finite(position_mm) || !(radius_mm >= 0 && radius_mm <= kFarthestAway_mm))
            return about("eye", ErrorCode::InvalidArgument,
                         "expected a position, and a radius of 0 to 500 mm");
        if (!traits().slides) return Ok{};
        TouchTool eye{position_mm, radius_mm};
        const bool has_effect = radius_mm > 0 && can_begin(eye);
        const auto before = m_eyes.find(tool);
        const bool frees = before != m_eyes.end() && !before->second.triangles.empty();
        if (has_effect)
            m_eyes.insert_or_assign(tool, std::move(eye));
        else
            m_eyes.erase(tool);
        hold_nodes();
        if (frees) wake();
        return Ok{};
    });
}

void MeshTissue::keep() {
    positions_mm(m_memory.first);
    velocities_mm_s(m_memory.first_velocities);
}

void MeshTissue::take_back() noexcept {
    put(m_memory.first, m_memory.first_velocities);
}

double MeshTissue::folded_cells(std::span<const Vec3d> positions_mm) {
    const RestMesh& rest = at_rest();
    double sum = 0;
    for (std::size_t c = 0; c < rest.cells.size(); ++c)
        if (volume_of(corners_of(rest.cells[c], positions_mm)) <
            kMeshFoldShare * rest.volumes_mm3[c])
            sum += rest.volumes_mm3[c];
    return sum;
}

// Time.

void MeshTissue::wake() noexcept {
    m_settled = false;
    m_sweeps = 0;
    m_is_shown = false;
}

void MeshTissue::halt() noexcept {
    positions_mm(m_memory.positions);
    std::fill(m_memory.velocities.begin(), m_memory.velocities.end(), Vec3d{0, 0, 0});
    put(m_memory.positions, m_memory.velocities);
}

/// Stops all nodes. A free tissue near its rest positions is moved to them.
void MeshTissue::come_to_rest() noexcept {
    halt();
    const auto& rest = at_rest().nodes_mm;
    double farthest = 0;
    for (std::size_t n = 0; n < rest.size(); ++n)
        farthest = std::max(farthest, norm(m_memory.positions[n] - rest[n]));
    if (farthest < home_mm() && !is_touched() && m_eyes.empty()) put(rest, m_memory.velocities);
}

Result<Sweep> MeshTissue::sweep() noexcept {
    return attempt([&]() -> Result<Sweep> {
        const Stopwatch watch;
        if (m_settled) return Sweep{true, watch.ms()};
        positions_mm(m_memory.positions);
        const Status stepped = step();
        if (!stepped.ok() && is_out_of_memory(stepped.error())) return stepped.error();
        ++m_sweeps;
        m_is_shown = false;
        if (stepped.ok()) {
            positions_mm(m_memory.positions);
            m_settled = is_calm();
        } else {
            // The failed step would recur.
            put(m_memory.positions, m_memory.velocities);
            m_settled = true;
        }
        if (m_settled) come_to_rest();
        Sweep sweep{m_settled, watch.ms()};
        if (!stepped.ok()) sweep.message = stepped.error().message;
        return sweep;
    });
}

// The whole tissue.

Status MeshTissue::reset() noexcept {
    m_tools.clear();
    m_spheres.clear();
    for (auto& [tool, eye] : m_eyes) eye.triangles.clear();
    hold_nodes();
    std::fill(m_memory.velocities.begin(), m_memory.velocities.end(), Vec3d{0, 0, 0});
    put(at_rest().nodes_mm, m_memory.velocities);
    wake();
    m_settled = home_mm() > 0;
    return Ok{};
}

void MeshTissue::state(std::vector<double>& numbers) const {
    numbers.resize(3 * m_memory.positions.size());
    positions_mm(m_memory.positions);
    for (std::size_t n = 0; n < m_memory.positions.size(); ++n)
        for (int a = 0; a < 3; ++a) numbers[3 * n + std::size_t(a)] = m_memory.positions[n][a];
}

Status MeshTissue::set_state(std::span<const double> numbers) noexcept {
    return attempt([&]() -> Status {
        const auto& rest = at_rest().nodes_mm;
        if (numbers.size() != 3 * rest.size())
            return invalid("expected the positions of as many nodes");
        std::vector<Vec3d> positions;
        for (std::size_t n = 0; n < rest.size(); ++n) {
            positions.push_back({numbers[3 * n], numbers[3 * n + 1], numbers[3 * n + 2]});
            if (!(norm(positions[n] - rest[n]) <= kFarthestAway_mm))
                return invalid("expected nodes within 500 mm of their rest positions");
            if (positions[n] != rest[n] && is_fixed(std::int32_t(n)))
                return invalid("expected fixed nodes at their rest positions");
        }
        const bool is_home = positions == rest;
        (void)reset();
        put(positions, m_memory.velocities);
        m_settled = m_settled && is_home;
        return Ok{};
    });
}

// Its scan.

Status MeshTissue::place_scan(std::span<const Vec3d> positions_mm) const {
    return static_cast<EmbeddedScan&>(*m_carried).place(positions_mm);
}

Status MeshTissue::show() const {
    if (m_is_shown && !m_is_near) return Ok{};
    positions_mm(m_memory.shown);
    const Status placed = place_scan(m_memory.shown);
    if (!placed.ok() && is_out_of_memory(placed.error())) return placed;
    m_is_shown = true;
    m_is_near = false;
    return Ok{};
}

Status MeshTissue::update_deformation() const {
    return attempt([&] { return show(); });
}

const Deformation& MeshTissue::deformation() const {
    if (!m_is_shown) (void)update_deformation();
    return m_carried->deformation();
}

}  // namespace pliant
