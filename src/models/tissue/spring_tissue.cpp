// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/spring_tissue.h"

#include <algorithm>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "springs/cell_volume.h"
#include "tissue/scan_network.h"

namespace pliant {
namespace {

/// Fraction of a cell's edge by which a push advances at a time, with two steps each.
constexpr double kStrideShare = 0.05;
constexpr int kStepsPerStride = 2;
/// A cell is folded if one of its corners has less than this fraction of its volume left.
constexpr double kFoldShare = 0.15;
/// Lag of a node that a picture needn't show while tissue moves.
constexpr double kUnseenMm = 0.02;
/// Node updates of advance() between two tests whether the tissue rests.
constexpr int kStepsAtATime = 20;

std::vector<double> numbers_of(Vec3i v) {
    return {double(v.x), double(v.y), double(v.z)};
}

/// Rows of the settings that can be changed during use: the depth.
SettingRows<SpringDeformationSettings> live_rows() {
    return {find_setting<SpringDeformationSettings>("depth", spring_rows()), 1};
}

/// Remaining force at an equilibrium, relative to the largest reaction.
constexpr double kTolerance = 1e-4;

}  // namespace

SpringScanTissue::SpringScanTissue(const SpringDeformationSettings& settings, SpringTissue tissue,
                                   std::unique_ptr<ControlLattice> control)
    : SpringNodes(std::move(tissue), std::move(control)), m_settings(settings) {
    // So that nothing fails once a tool has been released or time has passed.
    const auto count = std::size_t(node_count());
    m_displacements.assign(count, Vec3d{0, 0, 0});
    m_former.reserve(2 * count);
    m_former_kept.reserve(2 * count);
    m_loose.reserve(count);
    m_no_forces.assign(count, Vec3d{0, 0, 0});
    m_moves.resize(count);
    m_stretched.resize(count);
}

Result<std::unique_ptr<SpringScanTissue>> SpringScanTissue::create(
    const Volume& volume, const SpringDeformationSettings& settings, const TaskArena& arena) {
    if (const Status s = check_volume(volume); !s.ok()) return s.error();
    if (const Status s = check(settings, spring_rows()); !s.ok()) return s.error();
    const auto grid = control_grid(volume, settings);
    if (!grid.ok()) return grid.error();
    auto control = ControlLattice::create(volume, *grid, arena);
    if (!control.ok()) return control.error();
    auto tissue = tissue_of(volume, *grid, settings);
    if (!tissue.ok()) return tissue.error();
    return std::unique_ptr<SpringScanTissue>(
        new SpringScanTissue(settings, std::move(*tissue), std::move(*control)));
}

TissueTraits SpringScanTissue::traits() const noexcept {
    return {.model = "springs",
            .cuts = true,
            .moves_by_itself = true,
            .sweep_ms = 1000 * kStepsPerSweep / kRate_hz,
            .update_hz = kRate_hz};
}

// Tools.

MeshTissue::Rules SpringScanTissue::rules(const Push&) const {
    return {.longest_mm = kStrideShare * norm(control().node_mm(0) - control().node_mm(1)),
            .gathers = false,
            .folds = "a control cell would fold; larger cells go farther"};
}

Status SpringScanTissue::check_push(const Push& push) {
    // The present positions: those that the scan shows depend on the times of pictures.
    for (std::int32_t n = 0; n < node_count(); ++n)
        m_moves[std::size_t(n)] = m_tissue.position(n) - m_rest.nodes_mm[std::size_t(n)];
    m_position = control().find(push.point_mm, m_moves);
    if (m_position) return Ok{};
    return about("push", ErrorCode::InvalidArgument,
                 "expected a point inside of the control lattice, found " + text_of(push.point_mm));
}

std::vector<std::int32_t> SpringScanTissue::nodes_around(const Push& push) const {
    std::vector<std::int32_t> nodes(m_position->nodes.begin(), m_position->nodes.end());
    if (push.sphere_radius_mm > 0 || control().cuts_mm().empty()) return nodes;
    const Vec3d point = rest_of(*m_position);
    const auto is_hidden = [&](std::int32_t n) {
        return control().is_cut(point, m_rest.nodes_mm[std::size_t(n)]);
    };
    if (!std::all_of(nodes.begin(), nodes.end(), is_hidden)) std::erase_if(nodes, is_hidden);
    return nodes;
}

/// Nodes that tools held before can still move.
void SpringScanTissue::hold_nodes() noexcept {
    m_former.insert(m_former.end(), m_held.begin(), m_held.end());
    renew_sources();
}

/// Updates the tissue's sources of motion: held nodes, and released ones that can still move.
void SpringScanTissue::renew_sources() noexcept {
    m_held.clear();
    for (const auto& [tool, nodes] : m_tools)
        m_held.insert(m_held.end(), nodes.begin(), nodes.end());
    std::sort(m_held.begin(), m_held.end());
    std::sort(m_former.begin(), m_former.end());
    m_former.erase(std::unique(m_former.begin(), m_former.end()), m_former.end());
    m_loose.clear();
    std::set_difference(m_former.begin(), m_former.end(), m_held.begin(), m_held.end(),
                        std::back_inserter(m_loose));
    (void)m_tissue.load(m_loose, std::span(m_no_forces).first(m_loose.size()));
    (void)m_tissue.hold(m_held);
}

void SpringScanTissue::keep() {
    m_former_kept = m_former;
    SpringNodes::keep();
}

void SpringScanTissue::take_back() noexcept {
    m_former.assign(m_former_kept.begin(), m_former_kept.end());
    renew_sources();
    SpringNodes::take_back();
}

Status SpringScanTissue::step() {
    const auto stepped = m_tissue.step(kStepsPerStride, arena());
    return stepped.ok() ? Status(Ok{}) : Status(stepped.error());
}

/// Whether a cell is folded, as ControlLattice::folds. Cells with a strongly changed edge alone are
/// examined: if all edges changed by less than a fifth, a corner keeps at least (1 − √3/5)³ = 0.28
/// of its volume. Further folds of a tissue that is folded are tolerated.
double SpringScanTissue::folded_cells(std::span<const Vec3d> positions_mm) {
    constexpr double kMuch = 0.2;
    static_assert(kFoldShare < 0.28);
    const Vec3i size = control().grid().size;
    const std::int32_t steps[3] = {1, size.x, size.x * size.y};
    const auto at = [&](std::int32_t n) { return positions_mm[std::size_t(n)]; };
    const auto rest = [&](std::int32_t n) { return m_rest.nodes_mm[std::size_t(n)]; };
    double shortest = norm(rest(steps[0]) - rest(0));
    for (const std::int32_t step : steps) shortest = std::min(shortest, norm(rest(step) - rest(0)));
    const double much2 = (kMuch * shortest) * (kMuch * shortest);
    std::fill(m_stretched.begin(), m_stretched.end(), std::uint8_t(0));
    for (std::int32_t n = 0; n < node_count(); ++n) m_moves[std::size_t(n)] = at(n) - rest(n);
    for (int a = 0; a < 3; ++a)
        for (std::int32_t n = 0; n < node_count(); ++n) {
            const std::int32_t other = n + steps[a];
            if (n / steps[a] % size[a] + 1 == size[a]) continue;
            const Vec3d change = m_moves[std::size_t(other)] - m_moves[std::size_t(n)];
            if (dot(change, change) <= much2) continue;
            m_stretched[std::size_t(n)] = m_stretched[std::size_t(other)] = 1;
        }
    for (std::size_t c = 0; c < m_tissue.network().cells().size(); ++c) {
        // The parts of a cut cell follow the nodes on their side.
        if (m_tissue.network().is_cell_cut(c)) continue;
        const SpringCell& cell = m_tissue.network().cells()[c];
        if (std::none_of(cell.nodes.begin(), cell.nodes.end(),
                         [&](std::int32_t n) { return m_stretched[std::size_t(n)] != 0; }))
            continue;
        for (int corner = 0; corner < cell.node_count; ++corner)
            if (corner_volume(cell, corner, at) / corner_volume(cell, corner, rest) <= kFoldShare)
                return 1;
    }
    return 0;
}

// Time.

/// Stops all nodes, and moves those near their rest position to it. Nodes that forces no longer
/// reach, since the depth was reduced, then start to move freely.
void SpringScanTissue::settle() noexcept {
    halt();
    if (!m_held.empty()) return;
    double farthest = 0;
    std::vector<std::int32_t>& away = m_loose;
    away.clear();
    for (std::int32_t n = 0; n < node_count(); ++n) {
        const double distance = norm(m_tissue.displacement(n));
        farthest = std::max(farthest, distance);
        if (distance > 0 && !is_fixed(n)) away.push_back(n);
    }
    if (farthest < home_mm()) {
        m_tissue.reset();
        m_former.clear();
    } else if (away != m_former) {
        m_former.assign(away.begin(), away.end());
        m_settled = false;
    }
    renew_sources();
}

Result<Sweep> SpringScanTissue::sweep() noexcept {
    Result<AdvanceReport> made = advance({.max_steps = kStepsPerSweep});
    if (!made) return made.error();
    return Sweep{made->settled, made->ms, std::move(made->message)};
}

Result<AdvanceReport> SpringScanTissue::advance(const Budget& budget) noexcept {
    return attempt([&]() -> Result<AdvanceReport> {
        AdvanceReport report;
        std::int32_t active_nodes = 0;
        while (report.steps < budget.max_steps && report.ms < budget.max_ms && !m_settled) {
            const int count =
                int(std::min<std::int64_t>(kStepsAtATime, budget.max_steps - report.steps));
            const Stopwatch watch;
            const auto stepped = m_tissue.step(count, arena());
            if (stepped.ok()) {
                report.steps += stepped->steps;
                active_nodes = std::max(active_nodes, stepped->active_nodes);
                m_settled = is_calm();
            } else if (is_out_of_memory(stepped.error())) {
                return stepped.error();
            } else {
                try {
                    report.message = stepped.error().message;
                } catch (const std::bad_alloc&) {  // earlier steps are complete
                    report.message = "unstable";
                }
                m_settled = true;
            }
            if (m_settled) settle();
            m_is_shown = false;
            report.ms += watch.ms();
        }
        if (active_nodes > 0) m_active_nodes = active_nodes;
        report.settled = m_settled;
        return report;
    });
}

/// Returns to rest, and keeps cuts.
Status SpringScanTissue::reset() noexcept {
    m_tools.clear();
    m_former.clear();
    renew_sources();
    m_tissue.reset();
    wake();
    m_settled = true;
    return Ok{};
}

Status SpringScanTissue::set_depth(std::int32_t depth) noexcept {
    if (const Status s = m_tissue.set_depth(depth); !s.ok()) return s;
    m_settings.depth = depth;
    wake();
    return Ok{};
}

Record SpringScanTissue::settings() const {
    return record_of(m_settings, live_rows());
}

Status SpringScanTissue::configure(const Record& changes) noexcept {
    return attempt([&]() -> Status {
        SpringDeformationSettings changed = m_settings;
        if (Status s = apply(changes, live_rows(), changed); !s) return s;
        return set_depth(changed.depth);
    });
}

Record SpringScanTissue::figures() const {
    return {{"nodes", numbers_of(control().grid().size)}, {"active_nodes", int(m_active_nodes)}};
}

Record SpringScanTissue::report() const {
    const ControlGrid& grid = control().grid();
    const Vec3i n = grid.size;
    return {
        {"summary", std::to_string(n.x) + " x " + std::to_string(n.y) + " x " +
                        std::to_string(n.z) + " control nodes, " + std::to_string(m_active_nodes) +
                        " moved to depth " + std::to_string(m_settings.depth)},
        {"solver", "force-transmittal"},
        {"springs.cell_voxels", numbers_of(grid.cell)},
        {"springs.nodes", numbers_of(grid.size)},
        {"springs.fixed_nodes", int(fixed_nodes())},
        {"springs.active_nodes", int(m_active_nodes)},
        {"springs.depth", int(m_settings.depth)},
        {"springs.young_modulus_pa", m_settings.young_modulus_pa},
        {"springs.poisson_ratio", m_settings.poisson_ratio},
        {"springs.time_step_ms", 1000 * m_tissue.time_step()}};
}

Result<std::int32_t> SpringScanTissue::take_depth(double threshold_mm,
                                                  std::int32_t max_depth) noexcept {
    return attempt([&]() -> Result<std::int32_t> {
        const auto found = find_depth(threshold_mm, max_depth);
        if (!found.ok()) return found.error();
        if (found->depth == 0)
            return about("depth", ErrorCode::NotFound,
                         "expected changes below " + short_text(threshold_mm) + " mm within " +
                             std::to_string(max_depth) + " layers, found " +
                             short_text(found->changes.back()) + " mm");
        if (const Status s = set_depth(found->depth); !s.ok()) return s.error();
        return found->depth;
    });
}

// The whole tissue.

void SpringScanTissue::take_displacements(std::span<const Vec3d> positions_mm) const {
    for (std::size_t n = 0; n < positions_mm.size(); ++n)
        m_displacements[n] = positions_mm[n] - m_rest.nodes_mm[n];
}

Status SpringScanTissue::place_scan(std::span<const Vec3d> positions_mm) const {
    take_displacements(positions_mm);
    return control().place(m_displacements);
}

Result<bool> SpringScanTissue::approach_deformation(std::int64_t max_elements) const {
    if (m_is_shown && !m_is_near) return true;
    return attempt([&]() -> Result<bool> {
        positions_mm(m_memory.shown);
        take_displacements(m_memory.shown);
        const double least_mm = m_is_shown ? 0 : kUnseenMm;
        const Result<bool> done = control().approach(m_displacements, max_elements, least_mm);
        if (!done.ok() && is_out_of_memory(done.error())) return done;
        m_is_shown = true;
        m_is_near = done.ok() && !*done;
        return !m_is_near;
    });
}

Status SpringScanTissue::set_positions(std::span<const Vec3d> positions_mm) {
    std::vector<Vec3d> moved(positions_mm.begin(), positions_mm.end());
    std::vector<std::int32_t> away;
    const auto count = std::min(moved.size(), std::size_t(node_count()));
    for (std::size_t n = 0; n < count; ++n) {
        moved[n] = positions_mm[n] - m_rest.nodes_mm[n];
        if (moved[n] != Vec3d{0, 0, 0} && !is_fixed(std::int32_t(n)))
            away.push_back(std::int32_t(n));
    }
    if (const Status s = control().place(moved); !s.ok()) return s;
    m_tools.clear();
    m_former.assign(away.begin(), away.end());
    put(positions_mm, m_memory.velocities);
    renew_sources();
    wake();
    m_settled = m_former.empty();
    return Ok{};
}

// The state: the positions of all nodes, and the corners of all cuts.

void SpringScanTissue::state(std::vector<double>& numbers) const {
    SpringNodes::state(numbers);
    for (const CutTriangle& triangle : control().cuts_mm())
        for (const Vec3d& corner : triangle)
            numbers.insert(numbers.end(), {corner.x, corner.y, corner.z});
}

Status SpringScanTissue::set_state(std::span<const double> numbers) noexcept {
    return attempt([&]() -> Status {
        const std::size_t count = 3 * std::size_t(node_count());
        if (numbers.size() < count || (numbers.size() - count) % 9 != 0)
            return invalid("expected the positions of as many control nodes");
        const auto at = [&](std::size_t n) {
            return Vec3d{numbers[n], numbers[n + 1], numbers[n + 2]};
        };
        std::vector<Vec3d> positions;
        for (std::size_t n = 0; n < count; n += 3) positions.push_back(at(n));
        std::vector<CutTriangle> cuts;
        for (std::size_t n = count; n < numbers.size(); n += 9)
            cuts.push_back({at(n), at(n + 3), at(n + 6)});
        return set_shape(positions, cuts);
    });
}

// The necessary depth for tools that hold a scan's tissue. Unlike pliant::find_depth the positions
// of the touched nodes are given, not the forces on them.

Result<DepthFound> SpringScanTissue::find_depth(double threshold_mm, std::int32_t max_depth) const {
    if (!(threshold_mm > 0))
        return about("depth", ErrorCode::InvalidArgument, "expected a threshold above 0 mm");
    if (m_held.empty())
        return about("depth", ErrorCode::NotFound, "expected a tool that holds tissue, found none");
    auto trial = SpringTissue::create(m_tissue.network(), {.time_step = m_tissue.time_step()});
    if (!trial.ok()) return trial.error();
    if (const Status s = trial->hold(m_held); !s.ok()) return s.error();
    std::vector<Vec3d> positions;
    for (const std::int32_t n : m_held) positions.push_back(m_tissue.position(n));
    if (const Status s = trial->move_held(positions); !s.ok()) return s.error();
    DepthFound found;
    std::vector<Vec3d> last;
    for (std::int32_t depth = 1; depth <= max_depth + 1; ++depth) {
        if (const Status s = trial->set_depth(depth); !s.ok()) return s.error();
        // The last shape is near the next one.
        if (const Status s = trial->find_equilibrium(kTolerance); !s.ok()) return s.error();
        std::vector<Vec3d> shape = trial->displacements();
        if (!last.empty()) {
            double change = 0;
            for (std::size_t n = 0; n < shape.size(); ++n)
                change = std::max(change, norm(shape[n] - last[n]));
            found.changes.push_back(change);
            if (change < threshold_mm) {
                found.depth = depth - 1;
                break;
            }
        }
        last = std::move(shape);
    }
    return found;
}

}  // namespace pliant
