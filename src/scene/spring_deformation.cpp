// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/spring_deformation.h>
#include <pliant/springs_builders.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <string>

#include "core/errors.h"
#include "core/hash.h"

namespace pliant {
namespace {

constexpr double kAirBelow_hu = -500, kAirShare = 0.01;
/// Of the longest time step that is sure to be stable near rest; a bent network wants shorter ones.
constexpr double kStepShare = 0.6;
/// A push goes on by so much of a cell's edge at a time, with two steps each.
constexpr double kStrideShare = 0.05;
constexpr int kStepsPerStride = 2;
/// A push stops where a corner of a cell has less than this left of its volume.
constexpr double kFoldShare = 0.15;
constexpr double kSettled_mm_s = 0.05;
constexpr double kBack_mm = 0.02;  ///< a settled node nearer to its rest place is put there
constexpr double kMaxPush_mm = 500;
constexpr std::int64_t kMaxNodes = 1'000'000;
constexpr double kNewtonPerMicronewton = 1e-6;

std::string text_of(double number) {
    std::string text = std::to_string(number);
    text.erase(std::min(text.size(), text.find('.') + 3));
    return text;
}
std::string text_of(Vec3d v) {
    return text_of(v.x) + "," + text_of(v.y) + "," + text_of(v.z);
}

Status check(const SpringDeformationSettings& s) {
    const auto expected = [](const char* name, const char* what, double found) -> Status {
        return invalid(std::string(name) + ": expected " + what + ", found " + text_of(found));
    };
    if (!(s.cell_mm > 0 && s.cell_mm <= 1000))
        return expected("cell_mm", "a length above 0, up to 1000 mm", s.cell_mm);
    if (!(s.young_modulus_pa >= 1 && s.young_modulus_pa <= 1e9))
        return expected("young_modulus_pa", "1 to 1e9 Pa", s.young_modulus_pa);
    if (!std::isfinite(s.fixed_above_hu))
        return expected("fixed_above_hu", "a number", s.fixed_above_hu);
    if (!(s.damping_s >= 1e-4 && s.damping_s <= 1e4))
        return expected("damping_s", "0.0001 to 10000 s", s.damping_s);
    if (s.depth < 0) return expected("depth", "0 layers or more", s.depth);
    return Ok{};
}

Result<ControlGrid> control_grid(const Volume& volume, const SpringDeformationSettings& s) {
    const Box3i whole = voxel_box(volume.grid);
    const Box3i region = s.region == Box3i{} ? whole : s.region;
    if (is_empty(region) || !contains(whole, region.begin) ||
        !contains(whole, region.end - Vec3i{1, 1, 1}))
        return invalid("region: expected a box of voxels inside of the scan");
    ControlGrid grid;
    std::int64_t nodes = 1;
    for (int a = 0; a < 3; ++a) {
        const int steps = region.end[a] - region.begin[a] - 1;
        grid.cell[a] = std::max(1, int(std::lround(s.cell_mm / volume.grid.spacing_mm[a])));
        const int cells = steps / grid.cell[a];
        if (cells < 2)
            return invalid("cell_mm: expected at most " +
                           text_of(std::max(0, steps / 2) * volume.grid.spacing_mm[a]) +
                           ", so that two cells fit into the region along axis " +
                           std::to_string(a) + ", found " + text_of(s.cell_mm));
        grid.size[a] = cells + 1;
        grid.first[a] = region.begin[a] + (steps - cells * grid.cell[a]) / 2;
        nodes *= grid.size[a];
    }
    if (nodes > kMaxNodes)
        return Error{ErrorCode::LimitExceeded,
                     "cell_mm: expected cells so large that there are at most " +
                         std::to_string(kMaxNodes) + " nodes, found " + std::to_string(nodes)};
    return grid;
}

Result<SpringTissue> network_of(const Volume& volume, const ControlGrid& grid,
                                const SpringDeformationSettings& s) {
    SpringScan scan{.region = {grid.first, {}}, .size = grid.size};
    for (int a = 0; a < 3; ++a)
        scan.region.end[a] = grid.first[a] + grid.cell[a] * (grid.size[a] - 1) + 1;
    scan.fixed_above_hu = s.fixed_above_hu;
    scan.young_modulus_pa = [young = s.young_modulus_pa](double hu) {
        return hu < kAirBelow_hu ? kAirShare * young : young;
    };
    auto parts = springs_of_scan(volume, scan);
    if (!parts.ok()) return parts.error();
    for (SpringNode& node : parts->nodes) node.damping = node.mass / s.damping_s;
    auto network = SpringNetwork::create(std::move(*parts));
    if (!network.ok()) return network.error();
    const double step = kStepShare * network->stable_time_step();
    return SpringTissue::create(std::move(*network), {.depth = s.depth, .time_step = step});
}

}  // namespace

struct SpringDeformation::Impl {
    Impl(const SpringDeformationSettings& s, std::unique_ptr<ControlLattice> c, SpringTissue t)
        : settings(s), control(std::move(c)), tissue(std::move(t)) {
        displacements.assign(std::size_t(control->node_count()), Vec3d{0, 0, 0});
        for (const SpringNode& node : tissue.network().nodes()) fixed += node.fixed;
    }

    bool is_fixed(std::int32_t n) const { return tissue.network().nodes()[std::size_t(n)].fixed; }
    std::vector<std::int32_t> nodes_at(const Push& push, const ControlPlace& place) const;
    void grab(std::uint32_t tool, std::vector<std::int32_t> nodes);
    void renew_sources();
    /// Nodes that tools hold go by a shift, time by a few steps. @returns whether they could
    bool stride(std::span<const std::int32_t> nodes, Vec3d shift);
    void stop();
    void come_to_rest();
    void put(std::span<const Vec3d> places);
    void show() { (void)control->place(displacements = tissue.displacements()); }

    SpringDeformationSettings settings;
    std::unique_ptr<ControlLattice> control;
    SpringTissue tissue;
    std::vector<Vec3d> displacements;  ///< as shown
    std::map<std::uint32_t, std::vector<std::int32_t>> tools;
    std::vector<std::int32_t> held;    ///< by all tools, in the tissue's order
    std::vector<std::int32_t> former;  ///< let go, and perhaps not at rest yet: sorted
    bool settled = true;
    std::int32_t fixed = 0;
};

SpringDeformation::SpringDeformation(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
SpringDeformation::~SpringDeformation() = default;

Result<std::unique_ptr<SpringDeformation>> SpringDeformation::create(
    const Volume& volume, const SpringDeformationSettings& settings, const TaskArena& arena) {
    if (const Status s = check(settings); !s.ok()) return s.error();
    const auto grid = control_grid(volume, settings);
    if (!grid.ok()) return grid.error();
    auto control = ControlLattice::create(volume, *grid, arena);
    if (!control.ok()) return control.error();
    auto tissue = network_of(volume, *grid, settings);
    if (!tissue.ok()) return tissue.error();
    return std::unique_ptr<SpringDeformation>(new SpringDeformation(
        std::make_unique<Impl>(settings, std::move(*control), std::move(*tissue))));
}

// Tools.

std::vector<std::int32_t> SpringDeformation::Impl::nodes_at(const Push& push,
                                                            const ControlPlace& place) const {
    std::vector<std::int32_t> nodes;
    const double radius = push.sphere_radius_mm;
    if (radius > 0)
        for (std::int32_t n = 0; n < control->node_count(); ++n)
            if (norm(tissue.position(n) - push.point_mm) <= radius) nodes.push_back(n);
    // A small sphere lies between the nodes.
    if (nodes.empty()) nodes.assign(place.nodes.begin(), place.nodes.end());
    std::erase_if(nodes, [&](std::int32_t n) { return is_fixed(n); });
    return nodes;
}

void SpringDeformation::Impl::grab(std::uint32_t tool, std::vector<std::int32_t> nodes) {
    std::sort(nodes.begin(), nodes.end());
    const auto is_taken = [&](std::int32_t n) {
        return std::binary_search(nodes.begin(), nodes.end(), n);
    };
    if (const auto found = tools.find(tool); found != tools.end()) {
        former.insert(former.end(), found->second.begin(), found->second.end());
        tools.erase(found);
    }
    for (auto& [other, theirs] : tools) std::erase_if(theirs, is_taken);
    std::erase_if(tools, [](const auto& entry) { return entry.second.empty(); });
    if (!nodes.empty()) tools[tool] = std::move(nodes);
    renew_sources();
}

/// Tells the tissue what is held, and that what was let go can still move.
void SpringDeformation::Impl::renew_sources() {
    held.clear();
    for (const auto& [tool, nodes] : tools) held.insert(held.end(), nodes.begin(), nodes.end());
    std::sort(held.begin(), held.end());
    std::sort(former.begin(), former.end());
    former.erase(std::unique(former.begin(), former.end()), former.end());
    std::vector<std::int32_t> loose;
    std::set_difference(former.begin(), former.end(), held.begin(), held.end(),
                        std::back_inserter(loose));
    const std::vector<Vec3d> no_forces(loose.size(), Vec3d{0, 0, 0});
    (void)tissue.load(loose, no_forces);
    (void)tissue.hold(held);
}

void SpringDeformation::Impl::put(std::span<const Vec3d> places) {
    for (std::size_t n = 0; n < places.size(); ++n)
        (void)tissue.set_state(std::int32_t(n), places[n], {0, 0, 0});
}

/// No speed any more.
void SpringDeformation::Impl::stop() {
    std::vector<Vec3d> places;
    for (std::int32_t n = 0; n < control->node_count(); ++n) places.push_back(tissue.position(n));
    put(places);
}

/// What came back is back. What no force reaches any more, because the depth is less than it was,
/// begins to move by itself.
void SpringDeformation::Impl::come_to_rest() {
    stop();
    if (!held.empty()) return;
    double farthest = 0;
    std::vector<std::int32_t> away;
    for (std::int32_t n = 0; n < control->node_count(); ++n) {
        const double distance = norm(tissue.displacement(n));
        farthest = std::max(farthest, distance);
        if (distance > 0 && !is_fixed(n)) away.push_back(n);
    }
    if (farthest < kBack_mm) {
        tissue.reset();
        former.clear();
    } else if (away != former) {
        former = std::move(away);
        settled = false;
    }
    renew_sources();
}

bool SpringDeformation::Impl::stride(std::span<const std::int32_t> nodes, Vec3d shift) {
    std::vector<Vec3d> places;
    for (const std::int32_t n : held) {
        const bool moves = std::binary_search(nodes.begin(), nodes.end(), n);
        places.push_back(moves ? tissue.position(n) + shift : tissue.position(n));
    }
    (void)tissue.move_held(places);
    return tissue.step(kStepsPerStride, control->arena()).ok();
}

Result<PushReport> SpringDeformation::push(std::uint32_t tool, const Push& push) {
    Impl& m = *m_impl;
    const auto start = std::chrono::steady_clock::now();
    const double length = norm(push.push_mm);
    if (!(length <= kMaxPush_mm))
        return invalid("push: expected three numbers and a length up to 500 mm, found " +
                       text_of(push.push_mm));
    if (!(push.sphere_radius_mm >= 0 && push.sphere_radius_mm <= kMaxPush_mm))
        return invalid("push: expected a sphere radius of 0 to 500 mm");
    const auto place = is_finite(push.point_mm) ? m.control->find(push.point_mm) : std::nullopt;
    if (!place)
        return invalid("push: expected a point inside of the control lattice, found " +
                       text_of(push.point_mm));
    PushReport report;
    m.grab(tool, m.nodes_at(push, *place));
    const auto found = m.tools.find(tool);
    if (found == m.tools.end()) {
        report.limited_by = LimitedBy::Bone;
        report.message = "every control node there is fixed";
        return report;
    }
    const std::vector<std::int32_t> nodes = found->second;
    report.grabbed_elements = std::int64_t(nodes.size());
    m.settled = false;
    const Vec3d cell = m.control->node_mm(0) - m.control->node_mm(1);
    const int strides = std::max(1, int(std::ceil(length / (kStrideShare * norm(cell)))));
    int done = 0;
    bool folded = m.control->folds(m.displacements, kFoldShare);
    std::vector<Vec3d> before(m.displacements.size());
    for (; done < strides; ++done) {
        for (std::size_t n = 0; n < before.size(); ++n)
            before[n] = m.tissue.position(std::int32_t(n));
        const bool went = m.stride(nodes, (1.0 / strides) * push.push_mm);
        const bool folds = went && m.control->folds(m.tissue.displacements(), kFoldShare);
        if (went && (folded || !folds)) {
            folded = folds;
            continue;
        }
        m.put(before);
        break;
    }
    m.show();
    report.step_fraction = double(done) / strides;
    report.status = done == strides ? PushStatus::Applied
                    : done > 0      ? PushStatus::Limited
                                    : PushStatus::Rejected;
    if (done < strides) {
        report.limited_by = LimitedBy::Movement;
        report.message = "a control cell would fold; larger cells go farther";
    }
    report.solve_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return report;
}

void SpringDeformation::let_go(std::uint32_t tool) {
    if (!m_impl->tools.contains(tool)) return;
    m_impl->grab(tool, {});
    m_impl->settled = false;
}
bool SpringDeformation::is_held() const {
    return !m_impl->held.empty();
}
bool SpringDeformation::holds(std::uint32_t tool) const {
    return m_impl->tools.contains(tool);
}

// Time.

SpringMotion SpringDeformation::step(int count) {
    Impl& m = *m_impl;
    SpringMotion motion;
    const auto start = std::chrono::steady_clock::now();
    if (!m.settled) {
        const auto stepped = m.tissue.step(count, m.control->arena());
        if (stepped.ok()) {
            motion.steps = stepped->steps;
            motion.active_nodes = stepped->active_nodes;
            for (std::int32_t n = 0; n < m.control->node_count(); ++n)
                motion.fastest_mm_s = std::max(motion.fastest_mm_s, norm(m.tissue.velocity(n)));
            m.settled = motion.fastest_mm_s < kSettled_mm_s;
        } else {
            motion.message = stepped.error().message;
            m.settled = true;
        }
        if (m.settled) m.come_to_rest();
        m.show();
    }
    motion.settled = m.settled;
    motion.solve_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return motion;
}

double SpringDeformation::time_step_s() const {
    return m_impl->tissue.time_step();
}
bool SpringDeformation::is_settled() const {
    return m_impl->settled;
}

// The whole tissue.

const SpringDeformationSettings& SpringDeformation::settings() const {
    return m_impl->settings;
}

Status SpringDeformation::set_depth(std::int32_t depth) {
    if (const Status s = m_impl->tissue.set_depth(depth); !s.ok()) return s;
    m_impl->settings.depth = depth;
    m_impl->settled = false;
    return Ok{};
}

void SpringDeformation::reset() {
    Impl& m = *m_impl;
    m.tools.clear();
    m.former.clear();
    m.renew_sources();
    m.tissue.reset();
    m.settled = true;
    m.show();
}

Vec3d SpringDeformation::force_n(std::uint32_t tool) {
    const auto found = m_impl->tools.find(tool);
    if (found == m_impl->tools.end()) return {0, 0, 0};
    const auto reaction = m_impl->tissue.reaction(found->second, ReactionLaw::Held);
    return reaction.ok() ? kNewtonPerMicronewton * reaction->force : Vec3d{0, 0, 0};
}

const std::vector<Vec3d>& SpringDeformation::displacements_mm() const {
    return m_impl->displacements;
}

std::vector<Vec3d> SpringDeformation::places_mm() const {
    std::vector<Vec3d> places;
    for (std::int32_t n = 0; n < m_impl->control->node_count(); ++n)
        places.push_back(m_impl->tissue.position(n));
    return places;
}

Status SpringDeformation::set_places(std::span<const Vec3d> places_mm) {
    Impl& m = *m_impl;
    std::vector<Vec3d> moved(places_mm.begin(), places_mm.end());
    std::vector<std::int32_t> away;
    const auto count = std::min(moved.size(), std::size_t(m.control->node_count()));
    for (std::size_t n = 0; n < count; ++n) {
        moved[n] = places_mm[n] - m.tissue.network().nodes()[n].rest;
        if (moved[n] != Vec3d{0, 0, 0} && !m.is_fixed(std::int32_t(n)))
            away.push_back(std::int32_t(n));
    }
    if (const Status s = m.control->place(moved); !s.ok()) return s;
    m.tools.clear();
    m.former = std::move(away);
    m.put(places_mm);
    m.renew_sources();
    m.settled = m.former.empty();
    m.show();
    return Ok{};
}

const ControlLattice& SpringDeformation::control() const {
    return *m_impl->control;
}
std::int32_t SpringDeformation::fixed_nodes() const {
    return m_impl->fixed;
}
std::uint64_t SpringDeformation::hash() const {
    return m_impl->tissue.hash();
}

const Volume& SpringDeformation::volume() const {
    return m_impl->control->volume();
}
const Lattice& SpringDeformation::lattice() const {
    return m_impl->control->lattice();
}
const TaskArena& SpringDeformation::arena() const {
    return m_impl->control->arena();
}

}  // namespace pliant
