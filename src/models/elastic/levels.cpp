// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "elastic/levels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "elastic/level.h"

namespace pliant {
namespace {

constexpr int kTurnSteps = 4;
constexpr int kPlanesPerTask = 8;
constexpr std::int64_t kSmallLevel = 3000;  ///< nodes; one thread is faster

/// A window of a level on one axis, in its nodes.
struct Span {
    int first, cells;
};
/// @param low, high  nodes between which it must lie, multiples of step
Span place_span(double centre, int wanted, int low, int high, int step) {
    const int cells = std::min(wanted, high - low);
    const int first = int(std::lround((centre - cells / 2.0) / step)) * step;
    return {std::clamp(first, low, high - cells), cells};
}

}  // namespace

ElasticLevels::ElasticLevels(const StiffnessMap& map, int window_cells, bool turns,
                             const TaskArena& arena)
    : m_map(map), m_arena(arena), m_window_cells(window_cells), m_turns(turns) {
    const Vec3i voxels = map.grid().size;
    focus({(voxels.x - 1) / 2.0, (voxels.y - 1) / 2.0, (voxels.z - 1) / 2.0});
}

ElasticLevels::~ElasticLevels() = default;

template <class Body>
void ElasticLevels::for_planes(const ElasticLevel& level, const Body& body) const {
    const std::int64_t planes = level.nodes.z;
    if (level.node_count() < kSmallLevel) return body(0, int(planes));
    const std::int64_t tasks =
        std::clamp<std::int64_t>(planes / kPlanesPerTask, 1, 2 * m_arena.thread_count());
    const std::int64_t grain = (planes + tasks - 1) / tasks;
    m_arena.for_each(planes, grain,
                     [&](std::int64_t begin, std::int64_t end) { body(int(begin), int(end)); });
}

template <class Change>
void ElasticLevels::sweep(ElasticLevel& level, SweepPass pass, const Change& change) const {
    LatticeSweep sweep = level.sweep(m_map);
    sweep.pass = pass;
    change(sweep);
    for_planes(level, [&](int begin, int end) {
        thread_local AlignedVector<float> workspace;
        const std::size_t size = sweep_workspace(level.nodes, level.stride);
        if (workspace.size() < size) workspace.resize(size);
        sweep_planes(sweep, begin, end, workspace.data());
    });
}

// Windows.

std::vector<Box3i> ElasticLevels::windows_at(Vec3d voxel) const {
    std::vector<Box3i> windows(std::size_t(m_map.level_count()));
    const std::int64_t most =
        std::int64_t(m_window_cells + 1) * (m_window_cells + 1) * (m_window_cells + 1);
    for (std::size_t n = windows.size(); n-- > 0;) {
        const Vec3i cells = m_map.cells(int(n)), shift = m_map.shift(int(n));
        Box3i& box = windows[n];
        box = {{0, 0, 0}, cells + Vec3i{1, 1, 1}};
        const std::int64_t nodes = std::int64_t(box.end.x) * box.end.y * box.end.z;
        if (nodes <= most || n + 1 == windows.size()) continue;
        const Box3i& coarse = windows[n + 1];
        const Vec3i whole = m_map.cells(int(n + 1));
        for (int a = 0; a < 3; ++a) {
            const int step = m_map.shift(int(n + 1))[a] - shift[a];
            // A node away from the coarser window's border, except at the lattice's.
            const int low = coarse.begin[a] + (coarse.begin[a] > 0);
            const int high = coarse.end[a] - 1 - (coarse.end[a] <= whole[a]);
            const Span span = place_span(voxel[a] / (1 << shift[a]), m_window_cells, low << step,
                                         high << step, 1 << step);
            box.begin[a] = span.first;
            box.end[a] = span.first + span.cells + 1;
        }
    }
    return windows;
}

/// Whether windows lie in each other as windows_at() places them.
bool ElasticLevels::are_nested(std::span<const Box3i> windows) const {
    const std::int64_t most =
        std::int64_t(m_window_cells + 1) * (m_window_cells + 1) * (m_window_cells + 1);
    for (std::size_t n = 0; n < windows.size(); ++n) {
        const Box3i& box = windows[n];
        const Vec3i cells = m_map.cells(int(n));
        const bool whole = box == Box3i{{0, 0, 0}, cells + Vec3i{1, 1, 1}};
        if (n + 1 == windows.size()) return whole;
        if (whole && windows[n + 1] == Box3i{{0, 0, 0}, m_map.cells(int(n + 1)) + Vec3i{1, 1, 1}})
            continue;
        std::int64_t nodes = 1;
        for (int a = 0; a < 3; ++a) {
            const int step = m_map.shift(int(n + 1))[a] - m_map.shift(int(n))[a];
            const int first = box.begin[a], last = box.end[a] - 1;
            const Box3i& coarse = windows[n + 1];
            const int whole_cells = m_map.cells(int(n + 1))[a];
            const int low = coarse.begin[a] + (coarse.begin[a] > 0);
            const int high = coarse.end[a] - 1 - (coarse.end[a] <= whole_cells);
            if (first % (1 << step) != 0 || last % (1 << step) != 0 || first >= last ||
                first < low << step || last > high << step)
                return false;
            nodes *= last - first + 1;
        }
        if (nodes > most) return false;
    }
    return false;
}

/// A level at a window, at rest: a spare one, or a new one.
std::unique_ptr<ElasticLevel> ElasticLevels::take_level(int number, const Box3i& window) {
    for (auto& spare : m_spare) {
        if (!spare || spare->number != number) continue;
        if (Box3i{spare->first, spare->first + spare->nodes} != window) continue;
        spare->let_go(m_map);
        spare->loosen(m_map);
        spare->touching.clear();
        spare->covered = {};
        for (float* const u : spare->u) std::fill_n(u, spare->array_size(), 0.0F);
        return std::move(spare);
    }
    return std::make_unique<ElasticLevel>(m_map, number, window.begin, window.end - window.begin,
                                          m_arena);
}

/// Replaces the levels whose windows are others. Displacements are kept.
void ElasticLevels::place(std::span<const Box3i> windows) {
    Levels levels(windows.size());
    const auto stays = [&](std::size_t n) {
        const ElasticLevel& now = *m_levels[n];
        return Box3i{now.first, now.first + now.nodes} == windows[n];
    };
    if (!m_levels.empty()) {
        std::size_t same = 0;
        for (std::size_t n = 0; n < windows.size(); ++n) same += stays(n);
        if (same == windows.size()) return;
        for (std::size_t n = 0; n + 1 < m_levels.size(); ++n) inject(n);
    }
    for (std::size_t n = 0; n < windows.size(); ++n)
        if (m_levels.empty() || !stays(n)) levels[n] = take_level(int(n), windows[n]);
    if (!m_levels.empty()) m_spare.reserve(m_spare.size() + windows.size());
    for (std::size_t n = windows.size(); n-- > 0;) {
        if (!levels[n]) {
            levels[n] = std::move(m_levels[n]);
        } else if (!m_levels.empty()) {
            ElasticLevel& to = *levels[n];
            if (n + 1 < levels.size()) interpolate(*levels[n + 1], levels[n + 1]->u, to, to.u);
            take_displacements(*m_levels[n], to);
        }
    }
    m_levels.swap(levels);
    for (auto& level : levels)
        if (level) m_spare.push_back(std::move(level));
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n)
        m_levels[n + 1]->covered = m_levels[n]->box_in(*m_levels[n + 1]);
    stiffen();
}

/// Copies the displacements of nodes in both windows of a level, and the cells that touch.
void ElasticLevels::take_displacements(const ElasticLevel& from, ElasticLevel& to) {
    for (TouchingCell cell : from.touching) {
        cell.cell = cell.cell + from.first - to.first;
        if (to.has(cell.cell) && to.has(cell.cell + Vec3i{1, 1, 1})) to.touching.push_back(cell);
    }
    to.for_each_node([&](Vec3i local, std::size_t at) {
        const Vec3i old = local + to.first - from.first;
        const bool has = from.has(old);
        for (std::size_t a = 0; a < 3; ++a) {
            if (has) to.u[a][at] = from.u[a][from.index(old)];
            if (to.is_held(at)) to.u[a][at] = 0;
        }
    });
}

void ElasticLevels::focus(Vec3d voxel) {
    place(windows_at(voxel));
}

bool ElasticLevels::is_inside(Vec3d voxel, double margin) const {
    const ElasticLevel& level = *m_levels.front();
    for (int a = 0; a < 3; ++a) {
        const double from_first = voxel[a] - level.first[a];
        const double to_last = level.first[a] + level.nodes[a] - 1 - voxel[a];
        if (level.follows[a][0] && from_first < margin) return false;
        if (level.follows[a][1] && to_last < margin) return false;
    }
    return true;
}

Box3i ElasticLevels::finest() const {
    const ElasticLevel& level = *m_levels.front();
    return {level.first, level.first + level.nodes};
}

// Contacts.

void ElasticLevels::hold(std::span<const HeldNode> nodes) {
    for (auto& level : m_levels) level->let_go(m_map);
    m_held.assign(nodes.begin(), nodes.end());
    for (std::size_t n = 0; n < m_levels.size(); ++n)
        for (const HeldNode& held : m_held) m_levels[n]->hold(m_map, held);
}

void ElasticLevels::renew(const Box3i& voxels) {
    for (auto& level : m_levels) {
        Box3i cells;
        // Those with a corner in the box and their neighbours, whose nodes may hold for its sake.
        for (int a = 0; a < 3; ++a) {
            const int begin = (std::max(voxels.begin[a] - 1, 0) >> level->shift[a]) - 1;
            const int end = ((voxels.end[a] - 1) >> level->shift[a]) + 2;
            cells.begin[a] = std::max(begin - level->first[a], 0);
            cells.end[a] = std::min(end - level->first[a], level->nodes[a] - 1);
        }
        if (is_empty(cells)) continue;
        level->renew(m_map, cells);
        std::erase_if(level->touching,
                      [&](const TouchingCell& touches) { return contains(cells, touches.cell); });
    }
    stiffen();
}

/// @returns whether other cells touch than before
bool ElasticLevels::find_touching() {
    bool changed = false;
    for (auto& level : m_levels) {
        std::vector<std::vector<TouchingCell>> of_plane(std::size_t(level->nodes.z));
        for_planes(*level, [&](int begin, int end) {
            for (int k = begin; k < std::min(end, level->nodes.z - 1); ++k)
                level->find_touching(k, of_plane[std::size_t(k)]);
        });
        std::vector<TouchingCell> found;
        for (const auto& cells : of_plane) found.insert(found.end(), cells.begin(), cells.end());
        const bool same = std::equal(
            found.begin(), found.end(), level->touching.begin(), level->touching.end(),
            [](const TouchingCell& a, const TouchingCell& b) { return a.cell == b.cell; });
        changed = changed || !same;
        level->touching = std::move(found);
    }
    return changed;
}

/// Gives the cells that touch their stiffness, and coarser cells their share of it.
void ElasticLevels::stiffen() {
    for (auto& level : m_levels) level->loosen(m_map);
    for (std::size_t n = 0; n < m_levels.size(); ++n)
        for (const TouchingCell& touches : m_levels[n]->touching) {
            const ElasticLevel& fine = *m_levels[n];
            for (std::size_t m = n; m < m_levels.size(); ++m) {
                ElasticLevel& level = *m_levels[m];
                Vec3i cell;
                int steps = 0;
                for (int a = 0; a < 3; ++a) {
                    const int step = level.shift[a] - fine.shift[a];
                    cell[a] = ((fine.first[a] + touches.cell[a]) >> step) - level.first[a];
                    steps += step;
                }
                level.stiffen(m_map, cell, m_map.touching_mu() / float(1 << steps));
            }
        }
    const std::vector<HeldNode> held = std::move(m_held);
    hold(held);
}

/// Removes the held direction of nodes that slide.
void ElasticLevels::slide(const ElasticLevel& level, const NodeRows& rows) {
    for (const auto& [at, normal, force] : level.slides) {
        float along = 0;
        for (int a = 0; a < 3; ++a) along += float(normal[a]) * rows[std::size_t(a)][at];
        for (int a = 0; a < 3; ++a) rows[std::size_t(a)][at] -= along * float(normal[a]);
    }
}

// Transfer between levels.

/// Rows of a level = interpolated ones of the next coarser level, 0 at held nodes.
void ElasticLevels::interpolate(const ElasticLevel& coarse, const NodeRows& from,
                                const ElasticLevel& fine, const NodeRows& rows) const {
    const Vec3i step = coarse.shift - fine.shift;
    for_planes(fine, [&](int begin, int end) {
        std::vector<float> means(std::size_t(coarse.stride) + 1);
        for (int k = begin; k < end; ++k)
            for (int j = 0; j < fine.nodes.y; ++j) {
                const int gy = fine.first.y + j, gz = fine.first.z + k;
                const Vec3i low{(fine.first.x >> step.x) - coarse.first.x,
                                (gy >> step.y) - coarse.first.y, (gz >> step.z) - coarse.first.z};
                const std::size_t up = gy & step.y ? std::size_t(coarse.stride) : 0;
                const std::size_t above = gz & step.z ? coarse.plane : 0;
                const std::size_t at = fine.index({0, j, k}), source = coarse.index(low);
                const std::size_t count = std::size_t((fine.nodes.x - 1) >> step.x) + 1;
                for (std::size_t a = 0; a < 3; ++a) {
                    const float* const c = from[a] + source;
                    for (std::size_t i = 0; i < count; ++i)
                        means[i] =
                            0.25F * ((c[i] + c[i + up]) + (c[i + above] + c[i + up + above]));
                    means[count] = 0;
                    float* const to = rows[a] + at;
                    if (step.x == 0) {
                        std::copy_n(means.begin(), count, to);
                    } else {
                        for (std::size_t i = 0; i + 1 < count; ++i) {
                            to[2 * i] = means[i];
                            to[2 * i + 1] = 0.5F * (means[i] + means[i + 1]);
                        }
                        to[2 * (count - 1)] = means[count - 1];
                    }
                }
                fine.clear_held(rows, at, std::size_t(fine.nodes.x));
            }
    });
}

/// Right side of the next level += the restricted one of this level.
void ElasticLevels::gather(std::size_t n) const {
    const ElasticLevel& fine = *m_levels[n];
    const ElasticLevel& coarse = *m_levels[n + 1];
    const Vec3i step = coarse.shift - fine.shift;
    for_planes(coarse, [&](int begin, int end) {
        std::vector<float> sums(std::size_t(fine.stride) + 2);
        for (int k = begin; k < end; ++k)
            for (int j = 0; j < coarse.nodes.y; ++j) {
                // The fine node at this coarse row, and the neighbours that share its weight.
                const int y = ((coarse.first.y + j) << step.y) - fine.first.y;
                const int z = ((coarse.first.z + k) << step.z) - fine.first.z;
                if (y < -step.y || y >= fine.nodes.y + step.y || z < -step.z ||
                    z >= fine.nodes.z + step.z)
                    continue;
                const Vec3i at{(fine.first.x >> step.x) - coarse.first.x, j, k};
                const std::size_t count = std::size_t((fine.nodes.x - 1) >> step.x) + 1;
                for (std::size_t a = 0; a < 3; ++a) {
                    std::fill(sums.begin(), sums.end(), 0.0F);
                    for (int dz = -step.z; dz <= step.z; ++dz)
                        for (int dy = -step.y; dy <= step.y; ++dy) {
                            if (!fine.has({0, y + dy, z + dz})) continue;
                            const float weight = (dz ? 0.5F : 1.0F) * (dy ? 0.5F : 1.0F);
                            const float* const row = fine.q[a] + fine.index({0, y + dy, z + dz});
                            for (std::size_t i = 0; i < std::size_t(fine.nodes.x); ++i)
                                sums[1 + i] += weight * row[i];
                        }
                    float* const to = coarse.q[a] + coarse.index(at);
                    if (step.x == 0)
                        for (std::size_t i = 0; i < count; ++i) to[i] += sums[1 + i];
                    else
                        for (std::size_t i = 0; i < count; ++i)
                            to[i] += sums[1 + 2 * i] + 0.5F * (sums[2 * i] + sums[2 + 2 * i]);
                }
            }
    });
}

/// Displacements of a level under the window of a finer one: those of the window.
void ElasticLevels::inject(std::size_t n) {
    const ElasticLevel& fine = *m_levels[n];
    ElasticLevel& coarse = *m_levels[n + 1];
    const Vec3i step = coarse.shift - fine.shift;
    const Box3i box = fine.box_in(coarse);
    for (int k = box.begin.z; k <= box.end.z; ++k)
        for (int j = box.begin.y; j <= box.end.y; ++j)
            for (int i = box.begin.x; i <= box.end.x; ++i) {
                const Vec3i local{((coarse.first.x + i) << step.x) - fine.first.x,
                                  ((coarse.first.y + j) << step.y) - fine.first.y,
                                  ((coarse.first.z + k) << step.z) - fine.first.z};
                for (std::size_t a = 0; a < 3; ++a)
                    coarse.u[a][coarse.index({i, j, k})] = fine.u[a][fine.index(local)];
            }
}

/// Nodes on the border of a window take the coarser lattice's values.
void ElasticLevels::follow(std::size_t n) {
    ElasticLevel& fine = *m_levels[n];
    const ElasticLevel& coarse = *m_levels[n + 1];
    fine.for_each_follower([&](Vec3i local, std::size_t at) {
        coarse.with_parents(fine, local, [&](std::size_t parent, float weight, bool first) {
            for (std::size_t a = 0; a < 3; ++a)
                fine.u[a][at] = (first ? 0.0F : fine.u[a][at]) + weight * coarse.u[a][parent];
        });
    });
}

/// Forces on the border of a window act on the coarser lattice.
void ElasticLevels::give_forces(std::size_t n, NodeRows ElasticLevel::*rows, bool to_held) {
    ElasticLevel& fine = *m_levels[n];
    ElasticLevel& coarse = *m_levels[n + 1];
    fine.for_each_follower([&](Vec3i local, std::size_t at) {
        coarse.with_parents(fine, local, [&](std::size_t parent, float weight, bool) {
            if (!to_held && coarse.is_held(parent)) return;
            for (std::size_t a = 0; a < 3; ++a)
                (coarse.*rows)[a][parent] += weight * (fine.*rows)[a][at];
        });
        for (std::size_t a = 0; a < 3; ++a) (fine.*rows)[a][at] = 0;
    });
}

// The cycle.

/// A polynomial in D⁻¹K for the residual in q, from zero or after the correction in s; the sum of
/// all corrections is e.
void ElasticLevels::smooth(ElasticLevel& level, bool from_zero, int degree, float part,
                           bool with_residual) const {
    const float spectrum = (m_turns ? 1.3F : 1) * level.spectrum;
    const float least = spectrum / part;
    const float middle = (spectrum + least) / 2, half = (spectrum - least) / 2;
    const float sigma = middle / half;
    float rho = 1 / sigma;
    const auto product = [&](float alpha, float beta) {
        sweep(level, SweepPass::Smooth, [&](LatticeSweep& s) {
            s.turning = m_turns ? Turning::Kept : Turning::None;
            s.x = level.s;
            s.out = level.t;
            s.residual = level.q;
            s.sum = level.e;
            s.alpha = alpha;
            s.beta = beta;
        });
        std::swap(level.s, level.t);
    };
    if (from_zero)
        for_planes(level, [&](int begin, int end) {
            begin_smoothing(level.planes(begin, end), 1 / middle, level.q, level.s, level.e);
        });
    else
        product(1 / middle, 0);
    for (int n = 1; n < degree; ++n) {
        const float next = 1 / (2 * sigma - rho);
        product(2 * next / half, next * rho);
        rho = next;
    }
    if (!with_residual) return;
    sweep(level, SweepPass::Subtract, [&](LatticeSweep& s) {
        s.turning = m_turns ? Turning::Kept : Turning::None;
        s.x = level.s;
        s.residual = level.q;
    });
}

/// e = approximate solution for the right side q, which is lost.
void ElasticLevels::cycle(std::size_t n) {
    ElasticLevel& level = *m_levels[n];
    if (n + 1 == m_levels.size())
        return smooth(level, true, smoother.last_degree, smoother.last_part, false);
    smooth(level, true, smoother.degree, smoother.part, true);
    slide(level, level.q);
    gather(n);
    cycle(n + 1);
    interpolate(*m_levels[n + 1], m_levels[n + 1]->e, level, level.s);
    slide(level, level.s);
    for_planes(level, [&](int begin, int end) {
        renew_direction(level.planes(begin, end), 1, level.s, level.e);
    });
    smooth(level, false, smoother.degree, smoother.part, false);
}

template <class Part>
double ElasticLevels::sum_over_planes(const Part& part) const {
    double sum = 0;
    for (const auto& level : m_levels) {
        for_planes(*level, [&](int begin, int end) {
            for (int k = begin; k < end; ++k)
                level->dots[std::size_t(k)] = part(*level, level->planes(k, k + 1));
        });
        for (const double dot : level->dots) sum += dot;
    }
    return sum;
}

double ElasticLevels::start() {
    m_product = 0;
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n) inject(n);
    for (std::size_t n = m_levels.size() - 1; n-- > 0;) follow(n);
    if (m_turns && find_touching()) stiffen();
    for (auto& level : m_levels) {
        if (!m_turns) break;
        LatticeSweep sweep = level->sweep(m_map);
        sweep.x = level->u;
        for_planes(*level, [&](int begin, int end) {
            turn_planes(sweep, level->rotations, kTurnSteps, begin, end);
        });
    }
    find_residual(Turning::Positions);
    return std::sqrt(sum_over_planes([](const ElasticLevel& level, const NodeSweep& nodes) {
        return dot_nodes(nodes, level.r, level.r);
    }));
}

/// r = the negative forces of u, those of touching cells included if they belong to positions.
void ElasticLevels::find_residual(Turning turning) {
    for (auto& level : m_levels) {
        sweep(*level, SweepPass::Residual, [&](LatticeSweep& s) {
            s.x = level->u;
            s.out = level->r;
            s.left_out = level->covered;
            s.turning = m_turns ? turning : Turning::None;
        });
        if (turning == Turning::Positions) level->add_touching(m_map, level->r, 1, m_turns, false);
    }
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n) give_forces(n, &ElasticLevel::r, false);
    for (auto& level : m_levels) {
        slide(*level, level->r);
        if (turning != Turning::Positions) continue;
        for (const auto& [at, normal, force] : level->slides)
            for (int a = 0; a < 3; ++a) level->r[std::size_t(a)][at] += float(force[a]);
    }
}

// Responses.

void ElasticLevels::find_response(std::span<const Vec3i> voxels, int iterations,
                                  HeldResponse& response) {
    (void)start();  // rotations
    response.levels.clear();
    std::vector<AlignedVector<float>> kept;
    const auto rows_of = [](AlignedVector<float>& memory, std::size_t size) {
        return NodeRows{memory.data(), memory.data() + size, memory.data() + 2 * size};
    };
    for (auto& level : m_levels) {
        const std::size_t size = level->array_size();
        auto& of_level = response.levels.emplace_back();
        of_level.window = {level->first, level->first + level->nodes};
        for (auto& along : of_level.along) along.resize(3 * size);
        const NodeRows rows = rows_of(kept.emplace_back(3 * size), size);
        for (std::size_t a = 0; a < 3; ++a) std::copy_n(level->u[a], size, rows[a]);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (auto& level : m_levels) {
            for (float* const u : level->u) std::fill_n(u, level->array_size(), 0.0F);
            for (const Vec3i voxel : voxels)
                if (const auto local = level->local_of(voxel);
                    local && level->is_held(level->index(*local)))
                    level->u[axis][level->index(*local)] = 1;
        }
        for (std::size_t n = m_levels.size() - 1; n-- > 0;) follow(n);
        m_product = 0;
        find_residual(Turning::Kept);
        for (int n = 0; n < iterations; ++n)
            if (iterate() == 0) break;
        for (std::size_t n = 0; n < m_levels.size(); ++n) {
            const std::size_t size = m_levels[n]->array_size();
            const NodeRows rows = rows_of(response.levels[n].along[axis], size);
            for (std::size_t a = 0; a < 3; ++a) std::copy_n(m_levels[n]->u[a], size, rows[a]);
        }
    }
    for (std::size_t n = 0; n < m_levels.size(); ++n) {
        const std::size_t size = m_levels[n]->array_size();
        const NodeRows rows = rows_of(kept[n], size);
        for (std::size_t a = 0; a < 3; ++a) std::copy_n(rows[a], size, m_levels[n]->u[a]);
    }
    m_product = 0;
}

bool ElasticLevels::respond(const HeldResponse& response, Vec3d shift_mm) {
    if (response.levels.size() != m_levels.size()) return false;
    for (std::size_t n = 0; n < m_levels.size(); ++n)
        if (response.levels[n].window !=
            Box3i{m_levels[n]->first, m_levels[n]->first + m_levels[n]->nodes})
            return false;
    const float shift[3] = {float(shift_mm.x), float(shift_mm.y), float(shift_mm.z)};
    for (std::size_t n = 0; n < m_levels.size(); ++n) {
        const ElasticLevel& level = *m_levels[n];
        const auto& along = response.levels[n].along;
        for_planes(level, [&](int begin, int end) {
            for (std::size_t a = 0; a < 3; ++a) {
                const std::size_t rest = a * level.array_size();
                for (std::size_t at = level.plane * std::size_t(begin);
                     at < level.plane * std::size_t(end); ++at)
                    level.u[a][at] += shift[0] * along[0][rest + at] +
                                      shift[1] * along[1][rest + at] +
                                      shift[2] * along[2][rest + at];
            }
        });
    }
    return true;
}

double ElasticLevels::iterate() {
    for (auto& level : m_levels)
        for (std::size_t a = 0; a < 3; ++a)
            std::memcpy(level->q[a], level->r[a], level->array_size() * sizeof(float));
    cycle(0);
    const double product = sum_over_planes([](const ElasticLevel& level, const NodeSweep& nodes) {
        return dot_nodes(nodes, level.r, level.e);
    });
    const float beta = m_product > 0 ? float(product / m_product) : 0.0F;
    m_product = product;
    double curvature = 0;
    for (auto& level : m_levels) {
        for_planes(*level, [&](int begin, int end) {
            renew_direction(level->planes(begin, end), beta, level->e, level->p);
        });
        sweep(*level, SweepPass::Direction, [&](LatticeSweep& s) {
            s.x = level->p;
            s.out = level->q;
            s.left_out = level->covered;
            s.turning = m_turns ? Turning::Kept : Turning::None;
            s.dots = level->dots.data();
        });
        for (const double dot : level->dots) curvature += dot;
    }
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n) give_forces(n, &ElasticLevel::q, false);
    if (!(curvature > 0) || !(product > 0)) {
        m_product = 0;
        return 0;
    }
    const float alpha = float(product / curvature);
    const double squares = sum_over_planes([&](const ElasticLevel& level, const NodeSweep& nodes) {
        return advance_nodes(nodes, alpha, level.p, level.q, level.u, level.r);
    });
    for (auto& level : m_levels) slide(*level, level->r);
    return std::sqrt(squares);
}

std::vector<Vec3d> ElasticLevels::forces_un(std::span<const Vec3i> voxels) {
    for (auto& level : m_levels) {
        sweep(*level, SweepPass::Store, [&](LatticeSweep& s) {
            s.x = level->u;
            s.out = level->q;
            s.left_out = level->covered;
            s.turning = m_turns ? Turning::Positions : Turning::None;
        });
        level->add_touching(m_map, level->q, -1, m_turns, true);
    }
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n) give_forces(n, &ElasticLevel::q, true);
    std::vector<Vec3d> forces(voxels.size(), Vec3d{0, 0, 0});
    for (std::size_t n = 0; n < voxels.size(); ++n)
        for (const auto& level : m_levels) {
            const auto local = level->local_of(voxels[n]);
            if (!local || level->is_follower(*local)) continue;
            for (int a = 0; a < 3; ++a)
                forces[n][a] = double(level->q[std::size_t(a)][level->index(*local)]);
            break;
        }
    return forces;
}

// Results.

void ElasticLevels::displacement_row(Vec3i first, int count, const NodeRows& to) const {
    // From the finest level that has all of them.
    const Vec3i last = first + Vec3i{count - 1, 0, 0};
    std::size_t n = 0;
    while (n + 1 < m_levels.size() &&
           !(m_levels[n]->has_voxel(first) && m_levels[n]->has_voxel(last)))
        ++n;
    for (++n; n-- > 0;) m_levels[n]->displacements(first, count, to);
}

Box3i ElasticLevels::moved_box(double mm) const {
    Box3i box{m_map.grid().size, {0, 0, 0}};
    const auto limit = float(mm);
    for (const auto& level : m_levels) {
        const Vec3i s = level->shift;
        level->for_each_node([&](Vec3i local, std::size_t at) {
            if (!level->is_active(local)) return;
            if (std::abs(level->u[0][at]) <= limit && std::abs(level->u[1][at]) <= limit &&
                std::abs(level->u[2][at]) <= limit)
                return;
            for (int a = 0; a < 3; ++a) {
                const int voxel = (level->first[a] + local[a]) << s[a], reach = (1 << s[a]) - 1;
                box.begin[a] = std::min(box.begin[a], std::max(voxel - reach, 0));
                box.end[a] =
                    std::max(box.end[a], std::min(voxel + reach + 1, m_map.grid().size[a]));
            }
        });
    }
    return is_empty(box) ? Box3i{} : box;
}

bool ElasticLevels::untangle(double limit) {
    const auto is_folded = [&](const ElasticLevel& level) {
        std::vector<char> of_plane(std::size_t(level.nodes.z), 0);
        for_planes(level, [&](int begin, int end) {
            for (int k = begin; k < std::min(end, level.nodes.z - 1); ++k)
                of_plane[std::size_t(k)] = level.has_folded(k, float(limit), nullptr);
        });
        return std::find(of_plane.begin(), of_plane.end(), 1) != of_plane.end();
    };
    m_was_tangled = false;
    return std::all_of(m_levels.begin(), m_levels.end(), [&](auto& level) {
        if (!is_folded(*level)) return true;
        m_was_tangled = true;
        return level->untangle(m_map, float(limit));
    });
}

void ElasticLevels::reset() {
    m_held.clear();
    for (auto& level : m_levels) {
        level->touching.clear();
        for (float* const u : level->u) std::fill_n(u, level->array_size(), 0.0F);
    }
    stiffen();
}

void ElasticLevels::scale(double factor) {
    for (auto& level : m_levels)
        for (float* const u : level->u)
            for (std::size_t n = 0; n < level->array_size(); ++n) u[n] *= float(factor);
}

double ElasticLevels::largest_mm() const {
    // The bits of magnitudes have their order, and are compared in vectors.
    std::int32_t largest = 0;
    for (const auto& level : m_levels)
        for (const float* const u : level->u)
            for (std::size_t n = 0; n < level->array_size(); ++n)
                largest = std::max(largest, std::bit_cast<std::int32_t>(std::abs(u[n])));
    return double(std::bit_cast<float>(largest));
}

std::int64_t ElasticLevels::moved_voxels(double mm) const {
    std::int64_t count = 0;
    const auto limit = float(mm);
    for (const auto& level : m_levels) {
        const Vec3i s = level->shift;
        std::int64_t nodes = 0;
        level->for_each_node([&](Vec3i local, std::size_t at) {
            if (std::abs(level->u[0][at]) <= limit && std::abs(level->u[1][at]) <= limit &&
                std::abs(level->u[2][at]) <= limit)
                return;
            if (level->is_active(local)) ++nodes;
        });
        count += nodes << (s.x + s.y + s.z);
    }
    return count;
}

std::int64_t ElasticLevels::node_count() const {
    std::int64_t count = 0;
    for (const auto& level : m_levels) count += level->node_count();
    return count;
}

std::int64_t ElasticLevels::bytes() const {
    std::int64_t bytes = 0;
    for (const auto& level : m_levels) bytes += level->bytes();
    return bytes;
}

}  // namespace pliant
