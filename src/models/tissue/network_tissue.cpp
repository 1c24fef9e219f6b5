// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/network_tissue.h"

#include <utility>

#include "base/errors.h"
#include "mesh/surface_winding.h"
#include "resample/embedded_scan.h"

namespace pliant {
namespace {

constexpr double kNetworkReach_mm = 500;
constexpr const char* kFliesApart =
    "the network flies apart, a node is more than 500 mm from its position at rest; check its "
    "fixed nodes, stiffness, damping and time step";

/// Tetrahedra; hexahedra are split around the diagonal from corner 0 to corner 6.
std::vector<std::array<std::int32_t, 4>> tetrahedra_of(std::span<const SpringCell> cells) {
    constexpr std::size_t kRing[7] = {1, 2, 3, 7, 4, 5, 1};
    std::vector<std::array<std::int32_t, 4>> tetrahedra;
    for (const SpringCell& cell : cells) {
        const auto& n = cell.nodes;
        if (cell.node_count == 4)
            tetrahedra.push_back({n[0], n[1], n[2], n[3]});
        else
            for (std::size_t k = 0; k < 6; ++k)
                tetrahedra.push_back({n[0], n[kRing[k]], n[kRing[k + 1]], n[6]});
    }
    return tetrahedra;
}

}  // namespace

NetworkTissue::NetworkTissue(SpringTissue tissue, std::vector<std::array<std::int32_t, 4>> cells,
                             std::unique_ptr<MovingScan> carried)
    : SpringNodes(std::move(tissue), std::move(carried), std::move(cells)),
      m_touch(m_tissue.network(), boundary_faces({{}, m_rest.cells})) {
    m_sphere_nodes.reserve(3 * m_touch.triangles().size());
    m_is_held.assign(m_rest.nodes_mm.size(), 0);
}

Result<std::unique_ptr<MeshTissue>> NetworkTissue::create(const Volume& scan, SpringParts parts,
                                                          const NetworkSettings& settings,
                                                          const TaskArena& arena) {
    if (const Status s = check_volume(scan); !s.ok()) return s.error();
    if (const Status s = check(settings, network_rows()); !s.ok()) return s.error();
    auto network = SpringNetwork::create(std::move(parts));
    if (!network.ok()) return network.error();
    if (network->has_branches())
        return expected_error("network", "links without Maxwell branches", "one");
    TetMesh mesh{{}, tetrahedra_of(network->cells())};
    for (const SpringNode& node : network->nodes()) mesh.nodes_mm.push_back(node.rest);
    if (mesh.cells.empty()) return expected_error("network", "cells", "links alone");
    if (const auto cell = inverted_cell(rest_mesh(mesh)))
        return expected_error("network", "cells without inverted corners",
                              "tetrahedron " + std::to_string(*cell));
    auto carried = carry(scan, mesh, settings.reach_mm, arena);
    if (!carried.ok())
        return carried.error().field == "mesh" ? renamed(carried.error(), "network")
                                               : carried.error();
    auto tissue =
        SpringTissue::create(std::move(*network), {.solver = SpringSolver::ImplicitEuler,
                                                   .time_step = settings.time_step_s,
                                                   .solve_tolerance = settings.solve_tolerance,
                                                   .assembled = true});
    if (!tissue.ok()) return tissue.error();
    return std::unique_ptr<MeshTissue>(
        new NetworkTissue(std::move(*tissue), std::move(mesh.cells), std::move(*carried)));
}

TissueTraits NetworkTissue::traits() const noexcept {
    return {.model = "network",
            .slides = true,
            .moves_by_itself = true,
            .sweep_ms = 1000 * m_tissue.time_step(),
            .update_hz = 1 / m_tissue.time_step()};
}

// Tools.

/// Holds the nodes of all tools, first those of pushes. Doesn't allocate.
void NetworkTissue::hold_nodes() noexcept {
    m_held.clear();
    for (const auto& [tool, nodes] : m_tools)
        m_held.insert(m_held.end(), nodes.begin(), nodes.end());
    m_pushed = m_held.size();
    for (const std::int32_t n : m_held) m_is_held[std::size_t(n)] = 1;
    for (const Spheres* spheres : {&m_spheres, &m_eyes})
        for (const auto& [tool, sphere] : *spheres) {
            m_touch.nodes_of(sphere, m_sphere_nodes);
            for (const std::int32_t n : m_sphere_nodes)
                if (m_is_held[std::size_t(n)] == 0) {
                    m_is_held[std::size_t(n)] = 1;
                    m_held.push_back(n);
                }
        }
    for (const std::int32_t n : m_held) m_is_held[std::size_t(n)] = 0;
    (void)m_tissue.hold(m_held);
}

/// Stops triangles that would have passed over a sphere since m_touch last looked, and moves the
/// nodes of spheres to where contact puts them. @param moved  a sphere that is clear already
void NetworkTissue::keep_spheres_clear(const TouchTool* moved) {
    for (Spheres* spheres : {&m_spheres, &m_eyes})
        for (auto& [tool, sphere] : *spheres)
            if (&sphere != moved) m_touch.keep_clear(sphere);
    hold_nodes();
    m_held_positions.clear();
    for (std::size_t k = 0; k < m_held.size(); ++k)
        m_held_positions.push_back(k < m_pushed ? m_tissue.position(m_held[k])
                                                : m_touch.positions()[std::size_t(m_held[k])]);
    (void)m_tissue.move_held(m_held_positions);
}

Status NetworkTissue::step() {
    if (has_spheres()) m_touch.look(m_tissue);
    const auto stepped = m_tissue.step(1, arena());
    if (!stepped.ok()) return stepped.error();
    if (has_spheres()) {
        m_touch.look_again(m_tissue);
        keep_spheres_clear();
    }
    return is_far() ? Status(invalid(kFliesApart)) : Status(Ok{});
}

Status NetworkTissue::stride(std::span<const std::int32_t> nodes, Vec3d shift) {
    if (has_spheres()) m_touch.look(m_tissue);
    move_held(nodes, shift);
    if (has_spheres()) {
        m_touch.look_again(m_tissue);
        keep_spheres_clear();
    }
    return step();
}

/// Whether a tetrahedron is folded: further folds of a network that is folded are tolerated.
double NetworkTissue::folded_cells(std::span<const Vec3d> positions_mm) {
    return SpringNodes::folded_cells(positions_mm) > 0;
}

/// Whether a node is too far from its rest position, or nowhere.
bool NetworkTissue::is_far() const {
    for (std::int32_t n = 0; n < node_count(); ++n)
        if (!(norm(m_tissue.displacement(n)) <= kNetworkReach_mm)) return true;
    return false;
}

/// Whether the centre of a sphere lies outside of the network.
bool NetworkTissue::can_begin(TouchTool& sphere) {
    sphere.triangles.reserve(m_touch.triangles().size());
    m_touch.look(m_tissue);
    return !(mesh::surface_winding(m_touch.triangles(), m_touch.positions(), sphere.position) >
             0.5);
}

MeshTissue::SlideStep NetworkTissue::slide_step(const TouchTool& sphere, const Push& way, int n,
                                                int count) const {
    const Vec3d shift = way.point_mm + (double(n + 1) / count) * way.push_mm - sphere.position;
    return {shift, sphere.position + shift};
}

Result<LimitedBy> NetworkTissue::slide_by(std::uint32_t, TouchTool& sphere, Vec3d shift) {
    m_touch.look(m_tissue);
    if (!m_touch.move(sphere, shift, m_tissue)) return LimitedBy::Bone;
    keep_spheres_clear(&sphere);
    const Status went = step();
    if (!went.ok()) return went.error();
    return LimitedBy::None;
}

std::optional<Vec3d> NetworkTissue::force_n(std::uint32_t tool) noexcept {
    const auto sphere = m_spheres.find(tool);
    if (sphere == m_spheres.end()) return SpringNodes::force_n(tool);
    m_touch.nodes_of(sphere->second, m_sphere_nodes);
    return force_on(m_sphere_nodes);
}

// The whole network.

Record NetworkTissue::figures() const {
    const SpringNetwork& network = m_tissue.network();
    return {{"network_nodes", int(network.node_count())},
            {"links", int(network.links().size())},
            {"tetrahedra", int(m_rest.cells.size())},
            {"fixed_nodes", int(fixed_nodes())}};
}

Record NetworkTissue::report() const {
    const SpringNetwork& network = m_tissue.network();
    const auto& carried = static_cast<const EmbeddedScan&>(*m_carried);
    Record record{{"summary", std::to_string(network.node_count()) + " nodes (" +
                                  std::to_string(fixed_nodes()) + " fixed), " +
                                  std::to_string(network.links().size()) + " links, " +
                                  std::to_string(m_rest.cells.size()) + " tetrahedra"},
                  {"solver", "implicit-euler"},
                  {"network.carried_voxels", double(carried.voxel_count())},
                  {"network.time_step_ms", 1000 * m_tissue.time_step()}};
    for (NamedValue& figure : figures())
        record.push_back({"network." + figure.name, std::move(figure.value)});
    return record;
}

Result<std::unique_ptr<MeshTissue>> make_network_tissue(const Volume& scan, SpringParts parts,
                                                        const NetworkSettings& settings,
                                                        const TaskArena& arena) {
    return NetworkTissue::create(scan, std::move(parts), settings, arena);
}

}  // namespace pliant
