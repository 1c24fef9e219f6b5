// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "relax/relax.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "lattice/tool_touch.h"
#include "relax/relax_kernel.h"

namespace pliant {
namespace {

/// Bricks of 8³ between two checks of the time, for each thread: about a tenth of a millisecond,
/// twice that if links have to be created first.
constexpr int kElementsPerLook = 8 * 512;

/// If nothing moves any more, and all elements are nearer to rest than this, they go to rest: about
/// a micrometre [units].
constexpr Fixed kSnap = 1 << 10;

/// Maximum number of positions along a tool's axis around which cells are held; on a longer axis
/// their distance exceeds a voxel.
constexpr double kMaxAxisPieces = 4096;

bool same_tools(const std::vector<RelaxTool>& p, const std::vector<RelaxTool>& q) {
    return std::equal(p.begin(), p.end(), q.begin(), q.end(), [](const auto& a, const auto& b) {
        return a.from_mm == b.from_mm && a.to_mm == b.to_mm && a.radius_mm == b.radius_mm;
    });
}

}  // namespace

SettingRows<RelaxOptions> relax_rows() noexcept {
    using R = RelaxOptions;
    static constexpr Setting<R> kRows[] = {
        setting<&R::max_sweeps>({.name = "max_sweeps",
                                 .range = {.low = 0},
                                 .text = "sweeps over all elements that still move"}),
        setting<&R::over_relaxation>(
            {.name = "over_relaxation",
             .range = {1, 1.95},
             .text = "factor of the step to the position of minimal energy"}),
        setting<&R::measure_energy>(
            {.name = "measure_energy", .text = "fills in the energies of the report"}),
    };
    return kRows;
}

Relaxation::Relaxation(Lattice& lattice, const PlasticRest& rest, const TaskArena& arena)
    : m_lattice(lattice), m_rest(rest), m_arena(arena) {}

void Relaxation::list_bricks() {
    m_bricks = m_lattice.resident_bricks();
    const auto odd = std::stable_partition(m_bricks.begin(), m_bricks.end(), [&](int index) {
        return !is_odd(m_lattice.brick(index).coord);
    });
    m_first_odd = std::size_t(odd - m_bricks.begin());
    int bound = 0;
    for (const int index : m_bricks) bound = std::max(bound, index + 1);
    m_workspaces.resize(std::size_t(bound));
    std::vector<bool> is_there(std::size_t(bound), false);
    for (const int index : m_bricks) {
        Brick& brick = m_lattice.brick(index);
        if (brick.is_blank) m_lattice.fill_in(brick);
        if (brick.is_unplaced) m_lattice.place_at_rest(brick);
        is_there[std::size_t(index)] = true;
        if (!m_workspaces[std::size_t(index)])
            m_workspaces[std::size_t(index)] = std::make_unique<Workspace>();
    }
    for (std::size_t n = 0; n < is_there.size(); ++n)
        if (!is_there[n]) m_workspaces[n].reset();
}

/// Removes dropped bricks from the list.
void Relaxation::forget_dropped() noexcept {
    const auto is_gone = [&](int index) {
        if (m_lattice.is_resident(index)) return false;
        m_workspaces[std::size_t(index)].reset();
        return true;
    };
    std::erase_if(m_bricks, is_gone);
    const auto odd = std::find_if(m_bricks.begin(), m_bricks.end(),
                                  [&](int index) { return is_odd(m_lattice.brick(index).coord); });
    m_first_odd = std::size_t(odd - m_bricks.begin());
}

void Relaxation::make_lists() {
    m_has_lists = false;  // until all lists are complete
    // Bricks with imprints can be missing: all elements were pushed back to rest.
    std::vector<Vec3i> imprinted;
    for (const auto& [coord, brick] : m_rest.bricks()) imprinted.push_back(coord);
    for (const Vec3i& coord : imprinted) m_lattice.ensure_brick(coord);
    // An index may denote another brick now.
    m_workspaces.clear();
    if (!m_maker || m_links_version != m_lattice.links_version())
        m_maker = std::make_unique<BrickLinksMaker>(m_lattice);
    m_links_version = m_lattice.links_version();
    list_bricks();
    hold_around_tools();
    mark_held();
    m_wanted.reserve(bricks_per_look());
    // Finds the stop of the last slice by coordinate: indices may have changed.
    m_at.cursor = m_at.is_cut_short ? index_of(m_at.stopped_at) : 0;
    m_has_lists = true;
}

void Relaxation::begin_anew() {
    make_lists();
    if (!m_at.is_cut_short) m_at.colour = 0;
    m_at.step = m_at.last_step = 0;
    wake_all();
}

std::size_t Relaxation::index_of(Vec3i coord) const {
    const auto begin = m_bricks.begin(), odd = begin + std::ptrdiff_t(m_first_odd);
    const auto from = is_odd(coord) ? odd : begin, to = is_odd(coord) ? m_bricks.end() : odd;
    const auto found = std::lower_bound(from, to, coord, [&](int index, Vec3i sought) {
        const Vec3i c = m_lattice.brick(index).coord;
        return std::tie(c.z, c.y, c.x) < std::tie(sought.z, sought.y, sought.x);
    });
    return std::size_t(found - begin);
}

void Relaxation::wake_all() {
    for (const int index : m_bricks) {
        Workspace& own = workspace(index);
        own.changed[0] = own.changed[1] = true;
    }
    // The remainder of a pass doesn't count as a whole one.
    m_at.quiet_passes = m_at.cursor > 0 ? -1 : 0;
}

/// Creates all links before any motion: links outside of their limits are allowed their present
/// state.
void Relaxation::make_all_links() {
    m_arena.for_each(std::int64_t(m_bricks.size()), 4, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t n = first; n < last; ++n) {
            const int index = m_bricks[std::size_t(n)];
            Workspace& own = workspace(index);
            if (!own.links) own.links = m_maker->make(m_lattice.brick(index));
        }
    });
}

/// Holds the cells around each tool's axis, so that the values on the axis stay the same. The guard
/// knows elements only, and tissue between them could pass through the axis.
void Relaxation::hold_around_tools() {
    m_around_tools.clear();
    const Grid& grid = m_lattice.grid();
    const Vec3d h = grid.spacing_mm;
    const double least = std::min({h.x, h.y, h.z}), most = std::max({h.x, h.y, h.z});
    for (const RelaxTool& tool : m_under.tools) {
        const Vec3d axis_mm = tool.to_mm - tool.from_mm;
        const int pieces = int(std::min(std::ceil(norm(axis_mm) / least), kMaxAxisPieces));
        for (int n = 0; n <= pieces; ++n) {
            const Vec3d position_mm = tool.from_mm + (pieces ? double(n) / pieces : 0.0) * axis_mm;
            const auto around = elements_around(m_lattice, voxel_from_world(grid, position_mm),
                                                std::min(tool.radius_mm, most));
            m_around_tools.insert(m_around_tools.end(), around.begin(), around.end());
        }
    }
}

void Relaxation::mark_held() {
    for (const int index : m_bricks) workspace(index).held.clear();
    for (const std::vector<Vec3i>* elements : {&m_under.held, &m_around_tools})
        for (const Vec3i& element : *elements) {
            const int index = m_lattice.find_brick(m_lattice.brick_of(element));
            if (index < 0) continue;
            auto& held = workspace(index).held;
            held.resize(std::size_t(m_lattice.elements_per_brick()), 0);
            held[std::size_t(m_lattice.index_in_brick(element))] = 1;
        }
}

bool Relaxation::goes_on() const {
    return m_has_begun && m_clock == m_lattice.clock() &&
           m_links_version == m_lattice.links_version();
}

void Relaxation::begin(const RelaxOptions& options) {
    m_was_at = m_at;
    m_went_on = goes_on();
    m_is_under_others = false;
    if (!(m_under.held == options.held && same_tools(m_under.tools, options.tools) &&
          m_under.over_relaxation == options.over_relaxation)) {
        Conditions others{options.over_relaxation, options.tools, options.held, {}};
        others.contact = ToolContact(m_lattice.grid(), others.tools);
        m_was_under = std::exchange(m_under, std::move(others));
        m_is_under_others = true;
    }
    if (!m_went_on) {
        begin_anew();
    } else {
        if (!m_has_lists) make_lists();
        if (m_is_under_others) {
            wake_all();
            hold_around_tools();
            mark_held();
        }
    }
    if (m_lattice.may_exceed_limits()) make_all_links();
    m_has_begun = true;
    m_finished_sweeps = 0;
    m_relaxed = 0;
}

bool Relaxation::needs_memory() const {
    if (!m_under.tools.empty()) return true;
    const std::uint64_t observed = m_lattice.observed_step();
    return std::any_of(m_bricks.begin(), m_bricks.end(), [&](int index) {
        const Workspace& own = workspace(index);
        return !own.links || (own.pull.version != m_rest.version() && !m_rest.empty()) ||
               (observed && m_lattice.brick(index).saved_for != observed);
    });
}

void Relaxation::roll_back() noexcept {
    m_at = m_was_at;
    if (std::exchange(m_is_under_others, false)) m_under = std::move(m_was_under);
    m_bricks.clear();
    m_workspaces.clear();
    m_maker.reset();
    m_has_lists = false;
    m_has_begun = m_went_on;
    m_clock = m_lattice.clock();
    m_links_version = m_lattice.links_version();
}

void Relaxation::start_over() noexcept {
    m_at = {};
    m_has_begun = false;
}

bool Relaxation::is_wanted(int index, int colour) const {
    const Workspace& own = workspace(index);
    if (own.changed[colour] || own.changed[1 - colour]) return true;
    const Brick& brick = m_lattice.brick(index);
    return std::any_of(brick.neighbours.begin(), brick.neighbours.end(), [&](int neighbour) {
        return neighbour >= 0 && workspace(neighbour).changed[1 - colour];
    });
}

void Relaxation::relax_brick(int index, int colour, double over_relaxation) {
    Brick& brick = m_lattice.brick(index);
    Workspace& own = workspace(index);
    if (!own.links) own.links = m_maker->make(brick);
    if (own.pull.version != m_rest.version())
        own.pull = pull_of(m_lattice, brick, *own.links, m_rest);
    const bool has_pull = !own.pull.force[0].empty();
    const BrickGuard guard(m_lattice, brick, m_under.contact);
    const Vec3i first = m_lattice.brick_size() * brick.coord;
    const double radius = own.links->least_movement;
    RelaxedBrick relaxed{.size = m_lattice.brick_size(),
                         .parity = (first.x ^ first.y ^ first.z) & 1,
                         .u = brick.u,
                         .side = {},
                         .links = own.links.get(),
                         .imprint = {},
                         .pull = {},
                         .held = own.held.empty() ? nullptr : own.held.data(),
                         .guard = &guard,
                         .guard_all = may_meet_tool(m_lattice, brick, m_under.contact) ||
                                      (has_pull && !m_under.contact.empty()),
                         // Slightly smaller: squares of doubles are rounded.
                         .free_radius_squared = radius * radius * (1 - 1e-9)};
    const PlasticBrick* imprint = m_rest.find(brick.coord);
    for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t side = 0; side < 6; ++side)
            if (const int beside = brick.neighbours[side]; beside >= 0)
                relaxed.side[a][side] = m_lattice.brick(beside).u[a];
        if (imprint) relaxed.imprint[a] = imprint->imprint[a].data();
        if (has_pull) relaxed.pull[a] = own.pull.force[a].data();
    }
    m_lattice.before_move(brick);
    own.step = relax_colour(relaxed, colour, over_relaxation);
    own.changed[colour] = own.step > 0;
    if (own.step == 0) return;
    brick.changed_at = m_lattice.clock();
    own.has_old_bounds = true;
    if (!m_under.contact.empty()) update_bounds(index);
}

void Relaxation::update_bounds(int index) {
    if (!std::exchange(workspace(index).has_old_bounds, false)) return;
    m_lattice.update_bounds(index);
}

std::size_t Relaxation::bricks_per_look() const {
    return std::max<std::size_t>(1,
                                 std::size_t(kElementsPerLook / m_lattice.elements_per_brick())) *
           std::size_t(m_arena.thread_count());
}

bool Relaxation::run_pass(const RelaxOptions& options, Clock::time_point end) {
    const std::size_t look = bricks_per_look();
    const auto relax_some = [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t n = first; n < last; ++n)
            relax_brick(m_wanted[std::size_t(n)], m_at.colour, options.over_relaxation);
    };
    while (m_at.cursor < m_bricks.size()) {
        const std::size_t limit = m_at.cursor < m_first_odd ? m_first_odd : m_bricks.size();
        const auto left = std::size_t(std::max<std::int64_t>(options.max_bricks - m_relaxed, 1));
        std::size_t first = limit;
        m_wanted.clear();
        for (; m_at.cursor < limit && m_wanted.size() < std::min(look, left); ++m_at.cursor) {
            if (!is_wanted(m_bricks[m_at.cursor], m_at.colour)) continue;
            first = std::min(first, m_at.cursor);
            m_wanted.push_back(m_bricks[m_at.cursor]);
        }
        if (m_wanted.empty()) continue;
        // A slice ends before a brick to relax, whatever ends it and for any number of threads.
        if (m_relaxed >= options.max_bricks || options.stop.stop_requested() ||
            Clock::now() >= end) {
            m_at.cursor = first;
            return false;
        }
        m_relaxed += std::int64_t(m_wanted.size());
        m_arena.for_each(std::int64_t(m_wanted.size()), 2, std::ref(relax_some));
        for (const int index : m_wanted) m_at.step = std::max(m_at.step, workspace(index).step);
    }
    return true;
}

void Relaxation::finish_pass() {
    m_at.quiet_passes = m_at.step > 0 ? 0 : m_at.quiet_passes + 1;
    if (m_at.colour == 1) {
        ++m_finished_sweeps;
        m_at.sweep_step = std::max(m_at.last_step, m_at.step);
    }
    m_at.last_step = std::exchange(m_at.step, 0);
    m_at.colour = 1 - m_at.colour;
    m_at.cursor = 0;
}

void Relaxation::snap_to_rest() {
    if (!m_under.held.empty() || !m_under.contact.empty() || !m_rest.empty()) return;
    const auto is_near = [&](int index) {
        const Brick& brick = m_lattice.brick(index);
        for (int a = 0; a < 3; ++a)
            if (brick.u_min[a] < -kSnap || brick.u_max[a] > kSnap) return false;
        return true;
    };
    if (!std::all_of(m_bricks.begin(), m_bricks.end(), is_near)) return;
    for (const int index : m_bricks) {
        Brick& brick = m_lattice.brick(index);
        m_lattice.before_move(brick);
        for (Fixed* u : brick.u) std::fill_n(u, m_lattice.elements_per_brick(), 0);
        brick.changed_at = m_lattice.clock();
        m_lattice.update_bounds(index);
    }
}

RelaxReport Relaxation::run(const RelaxOptions& options) {
    const Clock::time_point start = Clock::now();
    const double budget_ms = std::min(options.budget_ms, 1e9);
    const Clock::time_point end = start + std::chrono::duration_cast<Clock::duration>(
                                              std::chrono::duration<double, std::milli>(budget_ms));
    m_lattice.tick();
    m_at.sweep_step = 0;
    while (m_at.quiet_passes < 2 && m_finished_sweeps < options.max_sweeps) {
        if (m_at.cursor == 0 && !m_under.tools.empty()) {  // cells may have moved to the tools
            hold_around_tools();
            mark_held();
        }
        if (!run_pass(options, end)) break;
        finish_pass();
    }
    const auto update_some = [this](std::int64_t first, std::int64_t last) {
        for (std::int64_t n = first; n < last; ++n) update_bounds(m_bricks[std::size_t(n)]);
    };
    m_arena.for_each(std::int64_t(m_bricks.size()), 16, std::ref(update_some));
    RelaxReport report;
    report.sweeps = m_finished_sweeps;
    report.bricks = m_relaxed;
    report.settled = m_at.quiet_passes >= 2;
    report.largest_step_mm = mm_from_units(m_at.sweep_step);
    report.workspace_bytes = workspace_bytes();
    if (report.settled) snap_to_rest();
    // In the middle of a pass the list must not change.
    if (m_at.cursor == 0 && (report.settled || m_rest.empty())) {
        m_lattice.drop_still_bricks();
        forget_dropped();
    }
    if (report.settled) release_workspace();
    m_at.is_cut_short = m_at.cursor > 0 && m_at.cursor < m_bricks.size();
    if (m_at.cursor < m_bricks.size())
        m_at.stopped_at = m_lattice.brick(m_bricks[m_at.cursor]).coord;
    m_clock = m_lattice.clock();
    report.relax_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return report;
}

void Relaxation::release_workspace() {
    for (const int index : m_bricks) {
        workspace(index).links.reset();
        workspace(index).pull = {};
    }
}

std::int64_t Relaxation::workspace_bytes() const {
    std::int64_t bytes = 0;
    const BrickLinks* last = nullptr;
    for (const int index : m_bricks) {
        const Workspace& own = workspace(index);
        bytes += std::int64_t(sizeof own + own.held.size() +
                              3 * own.pull.force[0].size() * sizeof(double));
        // Bricks of one material share their links, and are mostly adjacent in the list.
        if (own.links && own.links.get() != last) bytes += std::int64_t(own.links->bytes());
        last = own.links.get();
    }
    return bytes;
}

}  // namespace pliant
