// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/network_tissue.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "mesh/surface_winding.h"
#include "springs/rollback.h"

namespace pliant {
namespace {

/// A stride is at most this fraction of the mean edge.
constexpr double kNetworkStrideShare = 0.25;
/// A push stops if a tetrahedron has less than this fraction of its volume left.
constexpr double kNetworkFoldShare = 0.1;
constexpr double kMaxNetworkMotion_mm = 500;
constexpr double kNetworkSettled_mm_s = 0.05;
constexpr double kNetworkBack_mm = 0.02;  ///< a settled network nearer to rest is moved to it
constexpr const char* kFliesApart =
    "the network flies apart, a node is more than 500 mm from its position at rest; check its "
    "fixed nodes, stiffness, damping and time step";
constexpr double kNetworkNewton = 1e-6;  ///< N per µN

double tet_volume(const std::array<Vec3d, 4>& x) {
    return dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) / 6;
}

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

Status check_push(const Push& push) {
    if (!(norm(push.push_mm) <= kMaxNetworkMotion_mm) || !is_finite(push.point_mm))
        return about(
            "push", ErrorCode::InvalidArgument,
            "expected three numbers and a length up to 500 mm, found " + text_of(push.push_mm));
    if (!(push.sphere_radius_mm >= 0 && push.sphere_radius_mm <= kMaxNetworkMotion_mm))
        return about("push", ErrorCode::InvalidArgument, "expected a sphere radius of 0 to 500 mm");
    return Ok{};
}

double ms_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

}  // namespace

NetworkTissue::NetworkTissue(SpringTissue tissue, std::vector<std::array<std::int32_t, 4>> cells,
                             std::unique_ptr<EmbeddedScan> carried)
    : m_tissue(std::move(tissue)),
      m_cells(std::move(cells)),
      m_carried(std::move(carried)),
      m_touch(m_tissue.network(), boundary_faces({{}, m_cells})) {
    const auto nodes = m_tissue.network().nodes();
    const auto rest = [&](std::int32_t n) { return nodes[std::size_t(n)].rest; };
    for (const auto& cell : m_cells) {
        m_rest_volumes.push_back(
            tet_volume({rest(cell[0]), rest(cell[1]), rest(cell[2]), rest(cell[3])}));
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b)
                m_edge_mm += norm(rest(cell[a]) - rest(cell[b])) / (6.0 * double(m_cells.size()));
    }
    m_positions.resize(nodes.size());
    m_held.reserve(nodes.size());
    m_held_positions.reserve(nodes.size());
    m_shown.resize(nodes.size());
    m_sphere_nodes.reserve(3 * m_touch.triangles().size());
    m_is_held.assign(nodes.size(), 0);
}

Result<std::unique_ptr<MeshTissue>> NetworkTissue::create(const Volume& scan, SpringParts parts,
                                                          const NetworkSettings& settings,
                                                          const TaskArena& arena) {
    if (const Status s = check_volume(scan); !s.ok()) return s.error();
    if (const Status s = pliant::check(settings, network_rows()); !s.ok()) return s.error();
    auto network = SpringNetwork::create(std::move(parts));
    if (!network.ok()) return network.error();
    if (network->has_branches())
        return expected_error("network", "links without Maxwell branches", "one");
    TetMesh mesh{{}, tetrahedra_of(network->cells())};
    for (const SpringNode& node : network->nodes()) mesh.nodes_mm.push_back(node.rest);
    if (mesh.cells.empty()) return expected_error("network", "cells", "links alone");
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        std::array<Vec3d, 4> x;
        for (std::size_t n = 0; n < 4; ++n) x[n] = mesh.nodes_mm[std::size_t(mesh.cells[c][n])];
        if (!(tet_volume(x) > 0))
            return expected_error("network", "cells without inverted corners",
                                  "tetrahedron " + std::to_string(c));
    }
    auto carried = EmbeddedScan::create(scan, mesh, {.reach_mm = settings.reach_mm}, arena);
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

/// Free nodes in a tool at a point of its way.
/// @param or_around  if there are none, those of the tetrahedron around the point
std::vector<std::int32_t> NetworkTissue::nodes_at(const Push& push, Vec3d point_mm,
                                                  bool or_around) const {
    std::vector<std::int32_t> nodes;
    if (push.sphere_radius_mm > 0)
        for (std::int32_t n = 0; n < std::int32_t(m_positions.size()); ++n)
            if (const Vec3d away = m_tissue.position(n) - point_mm;
                norm(away) <= push.sphere_radius_mm && (!push.shape || push.shape->contains(away)))
                nodes.push_back(n);
    if (nodes.empty() && or_around && !push.shape)
        for (const auto& cell : m_cells)
            if (is_inside_tetrahedron(point_mm,
                                      {m_tissue.position(cell[0]), m_tissue.position(cell[1]),
                                       m_tissue.position(cell[2]), m_tissue.position(cell[3])})) {
                nodes.assign(cell.begin(), cell.end());
                break;
            }
    std::erase_if(nodes, [&](std::int32_t n) { return is_fixed(n); });
    std::sort(nodes.begin(), nodes.end());
    return nodes;
}

/// The tools after one of them takes these nodes from the others. @param nodes  sorted
NetworkTissue::Tools NetworkTissue::with(std::uint32_t tool,
                                         std::vector<std::int32_t> nodes) const {
    Tools changed = m_tools;
    changed.erase(tool);
    for (auto& [other, theirs] : changed)
        std::erase_if(theirs, [&](std::int32_t n) {
            return std::binary_search(nodes.begin(), nodes.end(), n);
        });
    std::erase_if(changed, [](const auto& entry) { return entry.second.empty(); });
    if (!nodes.empty()) changed[tool] = std::move(nodes);
    return changed;
}

/// Holds the nodes of all tools, first those of pushes. Doesn't allocate.
void NetworkTissue::hold_all() noexcept {
    m_held.clear();
    for (const auto& [tool, nodes] : m_tools)
        m_held.insert(m_held.end(), nodes.begin(), nodes.end());
    m_pushed = m_held.size();
    if (!m_spheres.empty()) {
        for (const std::int32_t n : m_held) m_is_held[std::size_t(n)] = 1;
        for (const auto& [tool, sphere] : m_spheres) {
            m_touch.nodes_of(sphere, m_sphere_nodes);
            for (const std::int32_t n : m_sphere_nodes)
                if (m_is_held[std::size_t(n)] == 0) {
                    m_is_held[std::size_t(n)] = 1;
                    m_held.push_back(n);
                }
        }
        for (const std::int32_t n : m_held) m_is_held[std::size_t(n)] = 0;
    }
    (void)m_tissue.hold(m_held);
}

/// Moves the nodes of spheres to where contact puts them.
void NetworkTissue::put_touched() noexcept {
    m_held_positions.clear();
    for (std::size_t k = 0; k < m_held.size(); ++k)
        m_held_positions.push_back(k < m_pushed ? m_tissue.position(m_held[k])
                                                : m_touch.positions()[std::size_t(m_held[k])]);
    (void)m_tissue.move_held(m_held_positions);
}

/// Stops triangles that would have passed over a sphere since m_touch last looked.
void NetworkTissue::keep_spheres_clear() {
    for (auto& [tool, sphere] : m_spheres) m_touch.keep_clear(sphere);
    hold_all();
    put_touched();
}

void NetworkTissue::release(std::uint32_t tool) noexcept {
    if (m_tools.erase(tool) + m_spheres.erase(tool) == 0) return;
    hold_all();
    m_settled = false;
}

/// Makes a time step.
Status NetworkTissue::step() {
    if (!m_spheres.empty()) m_touch.look(m_tissue);
    const auto stepped = m_tissue.step(1, arena());
    if (!stepped.ok()) return stepped.error();
    if (m_spheres.empty()) return Ok{};
    m_touch.look_again(m_tissue);
    keep_spheres_clear();
    return Ok{};
}

Status NetworkTissue::stride(std::uint32_t tool, Vec3d shift) {
    const auto mine = m_tools.find(tool);
    if (!m_spheres.empty()) m_touch.look(m_tissue);
    m_held_positions.clear();
    for (const std::int32_t n : m_held) {
        const bool moves = mine != m_tools.end() &&
                           std::binary_search(mine->second.begin(), mine->second.end(), n);
        m_held_positions.push_back(moves ? m_tissue.position(n) + shift : m_tissue.position(n));
    }
    if (const Status s = m_tissue.move_held(m_held_positions); !s.ok()) return s;
    if (!m_spheres.empty()) {
        m_touch.look_again(m_tissue);
        keep_spheres_clear();
    }
    return step();
}

bool NetworkTissue::folds() const {
    for (std::size_t c = 0; c < m_cells.size(); ++c) {
        const auto& cell = m_cells[c];
        const double volume = tet_volume({m_tissue.position(cell[0]), m_tissue.position(cell[1]),
                                          m_tissue.position(cell[2]), m_tissue.position(cell[3])});
        if (!(volume >= kNetworkFoldShare * m_rest_volumes[c])) return true;
    }
    return false;
}

/// Whether a node is too far from its rest position, or nowhere.
bool NetworkTissue::is_far() const {
    for (std::int32_t n = 0; n < std::int32_t(m_positions.size()); ++n)
        if (!(norm(m_tissue.displacement(n)) <= kMaxNetworkMotion_mm)) return true;
    return false;
}

/// Calls a function that moves tools and nodes, and undoes its changes if it fails.
template <class Act>
auto NetworkTissue::undone_on_error(const Act& act) {
    std::vector<std::int32_t> all(m_positions.size());
    for (std::size_t n = 0; n < all.size(); ++n) all[n] = std::int32_t(n);
    Tools tools = m_tools;
    Spheres spheres = m_spheres;
    const bool was_settled = m_settled;
    SpringRollback rollback(m_tissue, all);
    auto report = attempt(act);
    m_is_shown = false;
    if (report.ok()) return report;
    m_tools.swap(tools);
    m_spheres.swap(spheres);
    hold_all();
    rollback.restore();
    m_settled = was_settled;
    return report;
}

Result<PushReport> NetworkTissue::push(std::uint32_t tool, const Push& push) noexcept {
    return attempt([&]() -> Result<PushReport> {
        if (const Status s = check_push(push); !s.ok()) return s.error();
        return undone_on_error([&] { return push_nodes(tool, push); });
    });
}

Result<SlideReport> NetworkTissue::slide(std::uint32_t tool, const Push& way,
                                         const TissueValues&) noexcept {
    return attempt([&]() -> Result<SlideReport> {
        if (const Status s = check_push(way); !s.ok()) return s.error();
        if (!(way.sphere_radius_mm > 0) || way.shape)
            return expected_error("slide", "a sphere", way.shape ? "another shape" : "a point");
        return undone_on_error([&] { return slide_sphere(tool, way); });
    });
}

/// Whether a sphere that touches nothing stays clear of the network's box on its way.
bool NetworkTissue::is_free(const TouchTool& sphere, Vec3d way_mm) const {
    if (!sphere.triangles.empty()) return false;
    mesh::Bounds box, swept;
    for (std::int32_t n = 0; n < std::int32_t(m_positions.size()); ++n)
        box.add(m_tissue.position(n));
    swept.add(sphere.position);
    swept.add(sphere.position + way_mm);
    for (int a = 0; a < 3; ++a)
        if (swept.low[a] - sphere.radius > box.high[a] ||
            swept.high[a] + sphere.radius < box.low[a])
            return true;
    return false;
}

Result<SlideReport> NetworkTissue::slide_sphere(std::uint32_t tool, const Push& way) {
    const auto start = std::chrono::steady_clock::now();
    SlideReport report;
    report.end_mm = way.point_mm;
    m_tools.erase(tool);
    TouchTool& sphere = m_spheres[tool];
    if (sphere.position != way.point_mm || sphere.radius != way.sphere_radius_mm)
        sphere = {way.point_mm, way.sphere_radius_mm};
    sphere.triangles.reserve(m_touch.triangles().size());
    hold_all();
    m_touch.look(m_tissue);
    if (mesh::surface_winding(m_touch.triangles(), m_touch.positions(), way.point_mm) > 0.5) {
        m_spheres.erase(tool);
        hold_all();
        report.limited_by = LimitedBy::Wall;
        report.ends_in_tissue = true;
        report.slide_ms = ms_since(start);
        return report;
    }
    const double longest = std::min(kNetworkStrideShare * m_edge_mm, way.sphere_radius_mm / 2);
    const int strides = std::max(1, int(std::ceil(norm(way.push_mm) / longest)));
    int done = 0;
    for (; done < strides; ++done) {
        const Vec3d shift =
            way.point_mm + (double(done + 1) / strides) * way.push_mm - sphere.position;
        if (is_free(sphere, shift)) {
            sphere.position = sphere.position + shift;
            continue;
        }
        const auto went = slide_stride(sphere, shift, report);
        if (!went.ok()) return went.error();
        if (!*went) break;
    }
    report.way_fraction = double(done) / strides;
    report.end_mm = sphere.position;
    report.slide_ms = ms_since(start);
    return report;
}

/// @returns false, with the stride undone, if it can't be made
Result<bool> NetworkTissue::slide_stride(TouchTool& sphere, Vec3d shift, SlideReport& report) {
    const TouchTool before = sphere;
    for (std::size_t n = 0; n < m_positions.size(); ++n)
        m_positions[n] = m_tissue.position(std::int32_t(n));
    const bool was_folded = folds();
    m_touch.look(m_tissue);
    if (!m_touch.move(sphere, shift, m_tissue)) {
        hold_all();
        report.limited_by = LimitedBy::Bone;
        return false;
    }
    for (auto& [tool, other] : m_spheres)
        if (&other != &sphere) m_touch.keep_clear(other);
    hold_all();
    put_touched();
    m_settled = false;
    const Status went = step();
    if (!went.ok() && is_out_of_memory(went.error())) return went.error();
    if (went.ok() && !is_far() && (was_folded || !folds())) {
        report.contacts += !sphere.triangles.empty();
        return true;
    }
    sphere = before;
    hold_all();
    put(m_positions);
    report.limited_by = LimitedBy::Fold;
    return false;
}

Result<PushReport> NetworkTissue::push_nodes(std::uint32_t tool, const Push& push) {
    const auto start = std::chrono::steady_clock::now();
    PushReport report;
    report.message = "a tetrahedron would fold; larger ones go farther";
    std::vector<Vec3d> first(m_positions.size());
    for (std::size_t n = 0; n < first.size(); ++n) first[n] = m_tissue.position(std::int32_t(n));
    m_spheres.erase(tool);
    m_tools = with(tool, nodes_at(push, push.point_mm, true));
    hold_all();
    double longest = kNetworkStrideShare * m_edge_mm;
    if (push.sphere_radius_mm > 0) longest = std::min(longest, push.sphere_radius_mm / 2);
    const int strides = std::max(1, int(std::ceil(norm(push.push_mm) / longest)));
    const Vec3d shift = (1.0 / strides) * push.push_mm;
    int done = 0;
    for (; done < strides; ++done) {
        if (push.sphere_radius_mm > 0 && done > 0) {
            // Nodes on the sphere's way join those that it holds.
            auto nodes = nodes_at(push, push.point_mm + double(done) * shift, false);
            const auto held = m_tools.find(tool);
            const std::size_t count = held == m_tools.end() ? 0 : held->second.size();
            if (count > 0) nodes.insert(nodes.end(), held->second.begin(), held->second.end());
            std::sort(nodes.begin(), nodes.end());
            nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
            if (nodes.size() > count) {
                m_tools = with(tool, std::move(nodes));
                hold_all();
            }
        }
        for (std::size_t n = 0; n < m_positions.size(); ++n)
            m_positions[n] = m_tissue.position(std::int32_t(n));
        const bool was_folded = folds();
        const Status went = stride(tool, shift);
        if (!went.ok() && is_out_of_memory(went.error())) return went.error();
        const bool is_lost = !went.ok() || is_far();
        if (!is_lost && (was_folded || !folds())) continue;
        if (is_lost) report.message = went.ok() ? kFliesApart : went.error().message;
        put(m_positions);
        break;
    }
    m_settled = false;
    const auto held = m_tools.find(tool);
    report.grabbed_elements = held == m_tools.end() ? 0 : std::int64_t(held->second.size());
    for (std::size_t n = 0; n < first.size(); ++n)
        report.moved_elements += m_tissue.position(std::int32_t(n)) != first[n];
    report.step_fraction = double(done) / strides;
    report.status = done == strides ? PushStatus::Applied
                    : done > 0      ? PushStatus::Limited
                                    : PushStatus::Rejected;
    if (done < strides)
        report.limited_by = LimitedBy::Fold;
    else
        report.message.clear();
    report.solve_ms = ms_since(start);
    return report;
}

std::optional<Vec3d> NetworkTissue::force_n(std::uint32_t tool) noexcept {
    std::span<const std::int32_t> nodes;
    if (const auto held = m_tools.find(tool); held != m_tools.end()) nodes = held->second;
    if (const auto sphere = m_spheres.find(tool); sphere != m_spheres.end()) {
        m_touch.nodes_of(sphere->second, m_sphere_nodes);
        nodes = m_sphere_nodes;
    }
    if (nodes.empty()) return Vec3d{0, 0, 0};
    const auto reaction = m_tissue.reaction(nodes, ReactionLaw::Held);
    if (!reaction.ok()) return {};
    return kNetworkNewton * reaction->force;
}

// Time.

/// Sets all positions, at zero velocity.
void NetworkTissue::put(std::span<const Vec3d> positions) noexcept {
    for (std::size_t n = 0; n < positions.size(); ++n)
        if (!is_fixed(std::int32_t(n)))
            (void)m_tissue.set_state(std::int32_t(n), positions[n], {0, 0, 0});
    m_is_shown = false;
}

/// Stops all nodes. A free network near its rest positions is moved to them.
void NetworkTissue::come_to_rest() noexcept {
    double farthest = 0;
    for (std::size_t n = 0; n < m_positions.size(); ++n) {
        m_positions[n] = m_tissue.position(std::int32_t(n));
        farthest = std::max(farthest, norm(m_tissue.displacement(std::int32_t(n))));
    }
    if (farthest < kNetworkBack_mm && !is_touched())
        m_tissue.reset();
    else
        put(m_positions);
}

Result<Sweep> NetworkTissue::sweep() noexcept {
    return attempt([&]() -> Result<Sweep> {
        const auto start = std::chrono::steady_clock::now();
        if (m_settled) return Sweep{true, ms_since(start)};
        for (std::size_t n = 0; n < m_positions.size(); ++n)
            m_positions[n] = m_tissue.position(std::int32_t(n));
        const Status stepped = step();
        if (!stepped.ok() && is_out_of_memory(stepped.error())) return stepped.error();
        m_is_shown = false;
        double fastest = 0;
        for (std::int32_t n = 0; n < std::int32_t(m_positions.size()); ++n)
            fastest = std::max(fastest, norm(m_tissue.velocity(n)));
        // A network that would fly apart stops where it was.
        const bool is_lost = !stepped.ok() || is_far();
        if (is_lost) put(m_positions);
        m_settled = is_lost || fastest < kNetworkSettled_mm_s;
        if (m_settled) come_to_rest();
        Sweep sweep{m_settled, ms_since(start)};
        if (is_lost) sweep.message = stepped.ok() ? kFliesApart : stepped.error().message;
        return sweep;
    });
}

// The whole network.

Status NetworkTissue::reset() noexcept {
    m_tools.clear();
    m_spheres.clear();
    hold_all();
    m_tissue.reset();
    m_settled = true;
    m_is_shown = false;
    return Ok{};
}

Record NetworkTissue::figures() const {
    const SpringNetwork& network = m_tissue.network();
    int fixed = 0;
    for (const SpringNode& node : network.nodes()) fixed += node.fixed;
    return {{"network_nodes", int(network.node_count())},
            {"links", int(network.links().size())},
            {"tetrahedra", int(m_cells.size())},
            {"fixed_nodes", fixed}};
}

Record NetworkTissue::report() const {
    const SpringNetwork& network = m_tissue.network();
    Record record{{"summary", std::to_string(network.node_count()) + " nodes, " +
                                  std::to_string(network.links().size()) + " links, " +
                                  std::to_string(m_cells.size()) + " tetrahedra"},
                  {"solver", "implicit-euler"},
                  {"network.carried_voxels", double(m_carried->voxel_count())}};
    for (NamedValue& figure : figures())
        record.emplace_back("network." + figure.name, std::move(figure.value));
    record.emplace_back("network.time_step_ms", 1000 * m_tissue.time_step());
    return record;
}

void NetworkTissue::state(std::vector<double>& numbers) const {
    numbers.resize(3 * m_positions.size());
    for (std::size_t n = 0; n < m_positions.size(); ++n) {
        const Vec3d x = m_tissue.position(std::int32_t(n));
        for (int a = 0; a < 3; ++a) numbers[3 * n + std::size_t(a)] = x[a];
    }
}

Status NetworkTissue::set_state(std::span<const double> numbers) noexcept {
    return attempt([&]() -> Status {
        if (numbers.size() != 3 * m_positions.size())
            return invalid("expected the positions of as many nodes");
        std::vector<Vec3d> positions;
        bool is_home = true;
        for (std::size_t n = 0; n < m_positions.size(); ++n) {
            const Vec3d rest = m_tissue.network().nodes()[n].rest;
            positions.push_back({numbers[3 * n], numbers[3 * n + 1], numbers[3 * n + 2]});
            if (!(norm(positions.back() - rest) <= kMaxNetworkMotion_mm))
                return invalid("expected nodes within 500 mm of their rest positions");
            if (positions.back() != rest && is_fixed(std::int32_t(n)))
                return invalid("expected fixed nodes at their rest positions");
            is_home &= positions.back() == rest;
        }
        m_tools.clear();
        m_spheres.clear();
        hold_all();
        put(positions);
        m_settled = is_home;
        return Ok{};
    });
}

Status NetworkTissue::show() const {
    if (m_is_shown) return Ok{};
    for (std::size_t n = 0; n < m_shown.size(); ++n)
        m_shown[n] = m_tissue.position(std::int32_t(n));
    const Status placed = m_carried->place(m_shown);
    if (!placed.ok() && is_out_of_memory(placed.error())) return placed;
    m_is_shown = true;
    return Ok{};
}

Status NetworkTissue::update_deformation() const {
    return attempt([&] { return show(); });
}

const Deformation& NetworkTissue::deformation() const {
    (void)update_deformation();
    return m_carried->deformation();
}

Result<std::unique_ptr<MeshTissue>> make_network_tissue(const Volume& scan, SpringParts parts,
                                                        const NetworkSettings& settings,
                                                        const TaskArena& arena) {
    return NetworkTissue::create(scan, std::move(parts), settings, arena);
}

}  // namespace pliant
