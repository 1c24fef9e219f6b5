// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Equilibria, reactions, energies.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "base/errors.h"
#include "springs/cell_volume.h"
#include "springs/stability.h"
#include "springs/tissue_impl.h"

namespace pliant {
namespace {

constexpr int kNewtonSteps = 300, kHalvings = 40;
constexpr std::int32_t kSolveIterations = 20000;
constexpr double kRounding = 4e-16;

/// Stiffness for a common shift of nodes with all others held: the contribution of links and cells
/// with ends in both sets.
/// @param shifted  [node]
Mat3d held_stiffness(const SpringNetwork& network, const SpringState& state, double time_step,
                     std::span<const std::int32_t> nodes, std::span<const std::uint8_t> shifted) {
    const auto position = [&](std::int32_t n) { return state.position(n); };
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    Mat3d stiffness{};
    for (const std::int32_t n : nodes) {
        for (const auto& neighbour : network.neighbours(n)) {
            if (shifted[std::size_t(neighbour.node)]) continue;
            const SpringLink& link = network.links()[std::size_t(neighbour.link)];
            const Vec3d r = position(n) - position(neighbour.node);
            const double length = norm(r);
            if (!(length > 0)) continue;
            double along = link.stiffness;
            double across = link.stiffness * (1 - link.rest_length / length);
            if (network.has_branches()) {
                along += branch_of(link, time_step).pull;
                across +=
                    branch_force(network, state, std::size_t(neighbour.link), time_step) / length;
            }
            add_outer(stiffness, (1 / length) * r, -(along - across));
            for (int c = 0; c < 3; ++c) stiffness.columns[c][c] -= across;
        }
        for (const std::int32_t c : network.cells_of(n)) {
            const SpringCell& cell = network.cells()[std::size_t(c)];
            if (cell.bulk == 0 || network.is_cell_cut(std::size_t(c))) continue;
            const auto is_shifted = [&](int k) {
                return shifted[std::size_t(cell.nodes[std::size_t(k)])] != 0;
            };
            int first = 0;
            while (!is_shifted(first)) ++first;
            if (cell.nodes[std::size_t(first)] != n) continue;  // once per cell
            Vec3d gradient{0, 0, 0};
            for (int k = first; k < cell.node_count; ++k)
                if (is_shifted(k)) gradient = gradient + volume_gradient(cell, k, position);
            add_outer(stiffness, gradient, -cell.bulk / cell_volume(cell, rest));
        }
    }
    return stiffness;
}

Result<DepthFound> search_depth(const SpringNetwork& network, const SpringSettings& settings,
                                std::span<const std::int32_t> nodes, std::span<const Vec3d> forces,
                                const DepthSearch& search, const TaskArena& arena) {
    const auto bad = [](const std::string& text) {
        return Error{ErrorCode::InvalidArgument, "find_depth: " + text};
    };
    if (!(search.threshold > 0)) return bad("expected a threshold above 0");
    if (search.max_depth < 1) return bad("expected a max_depth of 1 or more");
    if (!(std::isfinite(search.duration) && search.duration >= 0))
        return bad("expected a duration of 0 or more");
    if (settings.solver != SpringSolver::ForceTransmittal)
        return bad("expected the solver ForceTransmittal");
    auto tissue = SpringTissue::create(network, settings);
    if (!tissue.ok()) return tissue.error();
    if (const Status status = tissue->load(nodes, forces); !status.ok()) return status.error();
    const double steps = std::ceil(search.duration / tissue->time_step());
    if (steps > double(INT32_MAX)) return bad("expected a duration of fewer than 2147483647 steps");
    DepthFound found;
    std::vector<Vec3d> last;
    for (std::int32_t depth = 1; depth <= search.max_depth + 1; ++depth) {
        tissue->reset();
        if (const Status status = tissue->set_depth(depth); !status.ok()) return status.error();
        if (search.duration > 0) {
            const auto report = tissue->step(std::int32_t(steps), arena);
            if (!report.ok()) return report.error();
        } else if (const Status status = tissue->find_equilibrium(); !status.ok()) {
            return status.error();
        }
        std::vector<Vec3d> shape = tissue->displacements();
        if (!last.empty()) {
            double change = 0;
            for (std::size_t n = 0; n < shape.size(); ++n)
                change = std::max(change, norm(shape[n] - last[n]));
            found.changes.push_back(change);
            if (change < search.threshold) {
                found.depth = depth - 1;
                return found;
            }
        }
        last = std::move(shape);
    }
    return found;
}

}  // namespace

double SpringTissue::elastic_energy() const {
    double energy = m_impl->static_energy();
    const SpringNetwork& network = m_impl->network;
    for (std::size_t l = 0; l < m_impl->state.branch.size(); ++l) {
        const double stiffness = network.links()[l].branch_stiffness;
        const double force = branch_force(network, m_impl->state, l, m_impl->time_step);
        if (stiffness > 0) energy += 0.5 * force * force / stiffness;
    }
    return energy;
}

/// Energy of links, without their branches, and volumes.
double SpringTissue::Impl::static_energy() {
    current();
    const auto position = [&](std::int32_t n) { return state.position(n); };
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    double energy = 0;
    for (std::size_t l = 0; l < network.links().size(); ++l) {
        const SpringLink& link = network.links()[l];
        if (network.is_cut(l)) continue;
        const double stretch = norm(position(link.a) - position(link.b)) - link.rest_length;
        energy += 0.5 * link.stiffness * stretch * stretch;
    }
    for (std::size_t c = 0; c < network.cells().size(); ++c) {
        const SpringCell& cell = network.cells()[c];
        if (cell.bulk == 0 || network.is_cell_cut(c)) continue;
        const double rest_volume = cell_volume(cell, rest);
        const double swell = cell_volume(cell, position) - rest_volume;
        energy += 0.5 * cell.bulk * swell * swell / rest_volume;
    }
    return energy;
}

double SpringTissue::kinetic_energy() const {
    double energy = 0;
    for (std::int32_t n = 0; n < m_impl->network.node_count(); ++n) {
        const Vec3d v = velocity(n);
        energy += 0.5 * m_impl->network.nodes()[std::size_t(n)].mass * dot(v, v);
    }
    return energy;
}

Vec3d SpringTissue::momentum() const {
    Vec3d sum{0, 0, 0};
    for (std::int32_t n = 0; n < m_impl->network.node_count(); ++n)
        sum = sum + m_impl->network.nodes()[std::size_t(n)].mass * velocity(n);
    return sum;
}

std::int64_t SpringTissue::folded_cells() const {
    const SpringNetwork& network = m_impl->network;
    const SpringState& state = m_impl->current();
    const auto position = [&](std::int32_t n) { return state.position(n); };
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    std::int64_t folded = 0;
    for (std::size_t c = 0; c < network.cells().size(); ++c) {
        const SpringCell& cell = network.cells()[c];
        if (network.is_cell_cut(c)) continue;
        bool any = false;
        for (int corner = 0; corner < cell.node_count; ++corner)
            any |= corner_volume(cell, corner, position) * corner_volume(cell, corner, rest) <= 0;
        folded += any;
    }
    return folded;
}

Status SpringTissue::find_equilibrium(double tolerance,
                                      const std::function<bool()>& give_up) noexcept {
    return attempt([&] { return m_impl->find_equilibrium(tolerance, give_up); });
}

/// Allocates everything before the first node moves: later iterations need no more memory.
Status SpringTissue::Impl::find_equilibrium(double tolerance,
                                            const std::function<bool()>& give_up) {
    if (!(tolerance > 0 && tolerance < 1))
        return Error{ErrorCode::InvalidArgument,
                     "find_equilibrium: expected a tolerance between 0 and 1"};
    current();
    find_movable();
    const auto count = std::size_t(network.node_count());
    std::vector<Vec3d> force(count), move(count), start(count);
    std::array<std::vector<double>, 3> first;
    if (give_up) std::copy_n(state.x, 3, first.begin());
    bool is_given_up = false;
    const std::function<bool()> ask = [&] {
        return is_given_up = is_given_up || (give_up && give_up());
    };
    // Rounding error of cancelling forces.
    double rounding = 0;
    for (std::int32_t n = 0; n < network.node_count(); ++n) {
        double sum = 0;
        for (const auto& neighbour : network.neighbours(n)) {
            const SpringLink& link = network.links()[std::size_t(neighbour.link)];
            sum += link.stiffness * link.rest_length;
        }
        rounding = std::max(rounding, kRounding * sum);
    }
    const auto potential = [&] {
        double work = 0;
        for (const std::int32_t n : state.loaded) work += dot(state.load_of(n), state.position(n));
        return static_energy() - work;
    };
    double radius = farthest;  // trust radius of a node's motion in a step
    for (int turn = 0; turn < kNewtonSteps; ++turn) {
        double left = 0, scale = 0;
        for (std::size_t n = 0; n < count; ++n) {
            const auto node = std::int32_t(n);
            const Vec3d load = state.load_of(node);
            const Vec3d inner = static_force(network, state, node);
            scale = std::max({scale, norm(load), state.is_held[n] ? norm(inner) : 0.0});
            force[n] = movable[n] ? load + inner : Vec3d{0, 0, 0};
            left = std::max(left, norm(force[n]));
        }
        if (left <= std::max(tolerance * scale, rounding)) {
            edited();
            for (int c = 0; c < 3; ++c) state.before[c] = state.x[c];
            relax_branches(network, state, time_step);
            return Ok{};
        }
        tangent.renew(network, state, movable, TangentKind::Exact, 0, 0, 0);
        // Far away a rough direction suffices; nearby the convergence is quadratic.
        const double accuracy = std::clamp(left / scale, 1e-12, 1e-2);
        for (std::size_t n = 0; n < count; ++n) start[n] = state.position(std::int32_t(n));
        const double before = potential();
        for (int halving = 0; halving < kHalvings; ++halving, radius /= 4) {
            const double expected = tangent.descend(
                network, force, {accuracy * 1e-2, kSolveIterations, &ask}, radius, move);
            edited();
            if (is_given_up) {
                std::copy_n(first.begin(), 3, state.x);
                return Error{ErrorCode::LimitExceeded, "find_equilibrium: given up"};
            }
            for (std::size_t n = 0; n < count; ++n)
                if (movable[n]) state.put(std::int32_t(n), start[n] + move[n]);
            // The gain of the last steps is below rounding.
            const double gained = before - potential();
            if (gained < 1e-4 * expected - 1e-13 * std::abs(before)) continue;
            if (gained > 0.7 * expected) radius = std::min(2 * radius, farthest);
            break;
        }
    }
    return Error{
        ErrorCode::LimitExceeded,
        "find_equilibrium: not reached in " + std::to_string(kNewtonSteps) +
            " steps of Newton's method; expected smaller loads, or nodes that hold the rest"};
}

/// Stiffness for a common shift of nodes that aren't movable, with the movable ones in equilibrium.
/// @returns whether the tangent is positive; `stiffness` is set anyway
bool SpringTissue::Impl::find_relaxed_stiffness(std::span<const std::int32_t> nodes,
                                                TangentKind kind, Mat3d& stiffness) {
    tangent.renew(network, state, movable, kind, 0, 0, 0);
    std::vector<Vec3d> shift(movable.size()), image(shift.size());
    const std::vector<Vec3d> none(shift.size(), {0, 0, 0});
    bool positive = true;
    stiffness = {};
    for (int c = 0; c < 3; ++c) {
        std::fill(shift.begin(), shift.end(), Vec3d{0, 0, 0});
        for (const std::int32_t n : nodes) shift[std::size_t(n)][c] = 1;
        positive &=
            tangent.solve(network, none, {1e-10, kSolveIterations}, shift) <= kSolveIterations;
        tangent.multiply(network, shift, false, image);
        for (const std::int32_t n : nodes)
            stiffness.columns[c] = stiffness.columns[c] - image[std::size_t(n)];
    }
    return positive;
}

Result<SpringReaction> SpringTissue::reaction(std::span<const std::int32_t> nodes,
                                              ReactionLaw law) noexcept {
    return attempt([&] { return m_impl->reaction(nodes, law); });
}

Result<SpringReaction> SpringTissue::Impl::reaction(std::span<const std::int32_t> nodes,
                                                    ReactionLaw law) {
    for (const std::int32_t n : nodes)
        if (n < 0 || n >= network.node_count())
            return Error{ErrorCode::InvalidArgument, "reaction: expected nodes below " +
                                                         std::to_string(network.node_count()) +
                                                         ", found " + std::to_string(n)};
    current();
    SpringReaction reaction;
    for (const std::int32_t n : nodes)
        reaction.force = reaction.force + static_force(network, state, n) +
                         branches_force(network, state, n, time_step);
    if (law == ReactionLaw::Held) {
        movable.assign(std::size_t(network.node_count()), 0);
        for (const std::int32_t n : nodes) movable[std::size_t(n)] = 1;
        reaction.stiffness = held_stiffness(network, state, time_step, nodes, movable);
        return reaction;
    }
    find_movable();
    for (const std::int32_t n : nodes) movable[std::size_t(n)] = 0;
    // Near an instability, possibly far from an equilibrium, the others have no nearby equilibrium.
    // Then the equilibrium of the positive, stiffer tangent is used, which always exists.
    if (!find_relaxed_stiffness(nodes, TangentKind::Exact, reaction.stiffness))
        find_relaxed_stiffness(nodes, TangentKind::Positive, reaction.stiffness);
    return reaction;
}

Result<DepthFound> find_depth(const SpringNetwork& network, const SpringSettings& settings,
                              std::span<const std::int32_t> nodes, std::span<const Vec3d> forces,
                              const DepthSearch& search, const TaskArena& arena) noexcept {
    return attempt([&] { return search_depth(network, settings, nodes, forces, search, arena); });
}

}  // namespace pliant
