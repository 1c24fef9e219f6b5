// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "elastic/levels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

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
    place_windows({(voxels.x - 1) / 2.0, (voxels.y - 1) / 2.0, (voxels.z - 1) / 2.0});
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

void ElasticLevels::place_windows(Vec3d voxel) {
    Levels levels(std::size_t(m_map.level_count()));
    bool moves = m_levels.empty();
    for (int n = m_map.level_count() - 1; n >= 0; --n) {
        const Vec3i cells = m_map.cells(n), shift = m_map.shift(n);
        const bool whole =
            std::int64_t(cells.x + 1) * (cells.y + 1) * (cells.z + 1) <=
            std::int64_t(m_window_cells + 1) * (m_window_cells + 1) * (m_window_cells + 1);
        Vec3i first{0, 0, 0}, nodes{cells.x + 1, cells.y + 1, cells.z + 1};
        if (!whole && std::size_t(n) + 1 < levels.size()) {
            const ElasticLevel& coarse = *levels[std::size_t(n) + 1];
            for (int a = 0; a < 3; ++a) {
                const int step = coarse.shift[a] - shift[a];
                const int low = coarse.follows[a][0] ? coarse.first[a] + 1 : coarse.first[a];
                const int last = coarse.first[a] + coarse.nodes[a] - 1;
                const int high = coarse.follows[a][1] ? last - 1 : last;
                const Span span = place_span(voxel[a] / (1 << shift[a]), m_window_cells,
                                             low << step, high << step, 1 << step);
                first[a] = span.first;
                nodes[a] = span.cells + 1;
            }
        }
        const ElasticLevel* const old = m_levels.empty() ? nullptr : m_levels[std::size_t(n)].get();
        moves = moves || old->first != first;
        levels[std::size_t(n)] = std::make_unique<ElasticLevel>(m_map, n, first, nodes, m_arena);
    }
    if (!moves) return;
    take_displacements(levels);
    m_levels = std::move(levels);
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n)
        m_levels[n + 1]->covered = m_levels[n]->box_in(*m_levels[n + 1]);
    const std::vector<HeldNode> held = std::move(m_held);
    m_held.clear();
    hold(held);
}

/// Copies displacements from the present levels to others, and interpolates those of new nodes.
void ElasticLevels::take_displacements(Levels& levels) {
    if (m_levels.empty()) return;
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n) inject(n);
    for (std::size_t n = levels.size(); n-- > 0;) {
        ElasticLevel& to = *levels[n];
        const ElasticLevel& from = *m_levels[n];
        if (n + 1 < levels.size()) interpolate(*levels[n + 1], levels[n + 1]->u, to, to.u);
        to.for_each_node([&](Vec3i local, std::size_t at) {
            const Vec3i old = local + to.first - from.first;
            if (!from.has(old)) return;
            for (std::size_t a = 0; a < 3; ++a) to.u[a][at] = from.u[a][from.index(old)];
        });
        to.for_each_node([&](Vec3i, std::size_t at) {
            if (!to.is_held(at)) return;
            for (float* const u : to.u) u[at] = 0;
        });
    }
}

void ElasticLevels::focus(Vec3d voxel) {
    place_windows(voxel);
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

/// Removes the held direction of nodes that slide.
void ElasticLevels::slide(const ElasticLevel& level, const NodeRows& rows) {
    for (const auto& [at, normal] : level.slides) {
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
    for (auto& level : m_levels) {
        if (m_turns) {
            LatticeSweep sweep = level->sweep(m_map);
            sweep.x = level->u;
            for_planes(*level, [&](int begin, int end) {
                turn_planes(sweep, level->turns, kTurnSteps, begin, end);
            });
        }
        sweep(*level, SweepPass::Residual, [&](LatticeSweep& s) {
            s.x = level->u;
            s.out = level->r;
            s.left_out = level->covered;
            s.turning = m_turns ? Turning::Positions : Turning::None;
        });
    }
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n) give_forces(n, &ElasticLevel::r, false);
    for (auto& level : m_levels) slide(*level, level->r);
    return std::sqrt(sum_over_planes([](const ElasticLevel& level, const NodeSweep& nodes) {
        return dot_nodes(nodes, level.r, level.r);
    }));
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
    for (auto& level : m_levels)
        sweep(*level, SweepPass::Store, [&](LatticeSweep& s) {
            s.x = level->u;
            s.out = level->q;
            s.left_out = level->covered;
            s.turning = m_turns ? Turning::Positions : Turning::None;
        });
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
    for (std::size_t n = m_levels.size(); n-- > 0;) m_levels[n]->displacements(first, count, to);
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
    return std::all_of(m_levels.begin(), m_levels.end(), [&](auto& level) {
        return !is_folded(*level) || level->untangle(m_map, float(limit));
    });
}

void ElasticLevels::reset() {
    hold({});
    for (auto& level : m_levels)
        for (float* const u : level->u) std::fill_n(u, level->array_size(), 0.0F);
}

void ElasticLevels::copy_to(std::vector<double>& numbers) const {
    numbers.clear();
    for (const auto& level : m_levels) {
        for (int a = 0; a < 3; ++a) numbers.push_back(level->first[a]);
        for (int a = 0; a < 3; ++a) numbers.push_back(level->nodes[a]);
    }
    for (const auto& level : m_levels)
        level->for_each_node([&](Vec3i, std::size_t at) {
            for (const float* const u : level->u) numbers.push_back(double(u[at]));
        });
}

bool ElasticLevels::copy_from(std::span<const double> numbers) {
    const std::size_t head = 6 * m_levels.size();
    if (numbers.size() < head) return false;
    Levels levels(m_levels.size());
    std::size_t count = head;
    for (std::size_t n = levels.size(); n-- > 0;) {
        Vec3i first, nodes;
        const Vec3i cells = m_map.cells(int(n));
        for (int a = 0; a < 3; ++a) {
            const double at = numbers[6 * n + std::size_t(a)];
            const double size = numbers[6 * n + 3 + std::size_t(a)];
            if (!(at >= 0 && size >= 2 && at + size <= cells[a] + 1)) return false;
            first[a] = int(at);
            nodes[a] = int(size);
        }
        const ElasticLevel& now = *m_levels[n];
        if (nodes != now.nodes) return false;
        levels[n] = std::make_unique<ElasticLevel>(m_map, int(n), first, nodes, m_arena);
        count += 3 * std::size_t(levels[n]->node_count());
    }
    if (numbers.size() != count) return false;
    const double* next = numbers.data() + head;
    for (auto& level : levels)
        level->for_each_node([&](Vec3i, std::size_t at) {
            for (float* const u : level->u) u[at] = float(*next++);
        });
    m_levels = std::move(levels);
    for (std::size_t n = 0; n + 1 < m_levels.size(); ++n)
        m_levels[n + 1]->covered = m_levels[n]->box_in(*m_levels[n + 1]);
    m_held.clear();
    return true;
}

double ElasticLevels::go_back(std::span<const double> earlier, double part) {
    std::size_t at = 6 * m_levels.size();
    for (std::size_t n = 0; n < m_levels.size(); ++n)
        for (std::size_t a = 0; a < 3; ++a)
            if (earlier[6 * n + a] != m_levels[n]->first[int(a)])
                return std::numeric_limits<double>::infinity();
    double largest = 0;
    for (auto& level : m_levels)
        level->for_each_node([&](Vec3i, std::size_t node) {
            for (float* const u : level->u) {
                const double difference = earlier[at++] - double(u[node]);
                largest = std::max(largest, std::abs(difference));
                if (part != 0) u[node] += float(part * difference);
            }
        });
    return largest;
}

void ElasticLevels::scale(double factor) {
    for (auto& level : m_levels)
        for (float* const u : level->u)
            for (std::size_t n = 0; n < level->array_size(); ++n) u[n] *= float(factor);
}

double ElasticLevels::largest_mm() const {
    float largest = 0;
    for (const auto& level : m_levels)
        for (const float* const u : level->u)
            for (std::size_t n = 0; n < level->array_size(); ++n)
                largest = std::max(largest, std::abs(u[n]));
    return double(largest);
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
