// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/assembled_euler.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "springs/cell_volume.h"

namespace pliant {
namespace {

Vec3d vector_at(const AlignedArray& all, std::size_t node) {
    return {all[4 * node], all[4 * node + 1], all[4 * node + 2]};
}

void add_to(AlignedArray& all, std::size_t node, Vec3d v) {
    for (int c = 0; c < 3; ++c) all[4 * node + std::size_t(c)] += v[c];
}

/// Adds a sum over four lanes that are kept apart, so that compilers may use vectors.
struct LaneSum {
    double lanes[4] = {};
    void add(const double* a, const double* b) {
        for (int c = 0; c < 4; ++c) lanes[c] += a[c] * b[c];
    }
    double total() const { return (lanes[0] + lanes[1]) + lanes[2]; }
};

}  // namespace

// The pattern.

void AssembledEuler::prepare(const SpringNetwork& network, double time_step) {
    if (m_is_ready) return;
    const auto count = std::size_t(network.node_count());
    make_pattern(network);
    for (AlignedArray* all :
         {&m_position, &m_velocity, &m_residual, &m_direction, &m_image, &m_scaled})
        all->assign(4 * count, 0);
    m_inverse.assign(12 * count, 0);
    m_matrix.diagonal.assign(12 * count, 0);
    m_matrix.moves.resize(count);
    for (std::size_t n = 0; n < count; ++n) {
        m_matrix.moves[n] = !network.nodes()[n].fixed;
        for (int c = 0; c < 3; ++c) m_position[4 * n + std::size_t(c)] = network.nodes()[n].rest[c];
    }
    assemble(network, time_step);
    m_coarse.prepare(network, m_matrix);
    m_is_ready = true;
}

std::int32_t AssembledEuler::pair_of(std::int32_t a, std::int32_t b) const {
    const auto [low, high] = std::minmax(a, b);
    const auto begin = m_pairs.begin() + m_first_pair[std::size_t(low)];
    const auto end = m_pairs.begin() + m_first_pair[std::size_t(low) + 1];
    return std::int32_t(
        std::lower_bound(begin, end, high,
                         [](const Pair& pair, std::int32_t node) { return pair.b < node; }) -
        m_pairs.begin());
}

void AssembledEuler::make_pattern(const SpringNetwork& network) {
    const auto count = std::size_t(network.node_count());
    const auto has_energy = [&](std::size_t c) {
        return network.cells()[c].bulk > 0 && !network.is_cell_cut(c);
    };
    std::vector<std::array<std::int32_t, 2>> ends;
    for (std::size_t l = 0; l < network.links().size(); ++l) {
        const SpringLink& link = network.links()[l];
        if (!network.is_cut(l))
            ends.push_back({std::min(link.a, link.b), std::max(link.a, link.b)});
    }
    m_rest_volumes.assign(network.has_volume_energy() ? network.cells().size() : 0, 0);
    for (std::size_t c = 0; c < m_rest_volumes.size(); ++c) {
        if (!has_energy(c)) continue;
        const SpringCell& cell = network.cells()[c];
        m_rest_volumes[c] =
            cell_volume(cell, [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; });
        for (int k = 0; k < cell.node_count; ++k)
            for (int j = 0; j < k; ++j) {
                const auto [low, high] =
                    std::minmax(cell.nodes[std::size_t(j)], cell.nodes[std::size_t(k)]);
                ends.push_back({low, high});
            }
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    m_pairs.clear();
    m_first_pair.assign(count + 1, 0);
    m_matrix.first.assign(count + 1, 0);
    for (const auto& [a, b] : ends) {
        m_pairs.push_back({a, b, 0, 0});
        ++m_first_pair[std::size_t(a) + 1];
        ++m_matrix.first[std::size_t(a) + 1];
        ++m_matrix.first[std::size_t(b) + 1];
    }
    for (std::size_t n = 0; n < count; ++n) {
        m_first_pair[n + 1] += m_first_pair[n];
        m_matrix.first[n + 1] += m_matrix.first[n];
    }
    m_matrix.columns.resize(2 * m_pairs.size());
    m_matrix.blocks.assign(18 * m_pairs.size() + 4, 0);
    std::vector<std::int32_t> next(m_matrix.first.begin(), m_matrix.first.end() - 1);
    for (Pair& pair : m_pairs) {
        pair.ab = next[std::size_t(pair.a)]++;
        pair.ba = next[std::size_t(pair.b)]++;
        m_matrix.columns[std::size_t(pair.ab)] = pair.b;
        m_matrix.columns[std::size_t(pair.ba)] = pair.a;
    }
    m_link_blocks.assign(network.links().size(), -1);
    for (std::size_t l = 0; l < m_link_blocks.size(); ++l)
        if (!network.is_cut(l))
            m_link_blocks[l] =
                m_pairs[std::size_t(pair_of(network.links()[l].a, network.links()[l].b))].ab;
    m_cell_blocks.clear();
    for (std::size_t c = 0; c < m_rest_volumes.size(); ++c) {
        if (m_rest_volumes[c] == 0) continue;
        const SpringCell& cell = network.cells()[c];
        for (int k = 0; k < cell.node_count; ++k)
            for (int j = 0; j < k; ++j)
                m_cell_blocks.push_back(m_pairs[std::size_t(pair_of(cell.nodes[std::size_t(j)],
                                                                    cell.nodes[std::size_t(k)]))]
                                            .ab);
    }
}

// The matrix.

void AssembledEuler::assemble(const SpringNetwork& network, double time_step) noexcept {
    std::fill(m_residual.begin(), m_residual.end(), 0.0);
    for (const Pair& pair : m_pairs) {
        float* const block = m_matrix.blocks.data() + 9 * std::size_t(pair.ab);
        std::fill(block, block + 9, 0.0F);
    }
    add_links(network, time_step);
    add_cells(network);
    for (const Pair& pair : m_pairs) {
        const float* const block = m_matrix.blocks.data() + 9 * std::size_t(pair.ab);
        float* const other = m_matrix.blocks.data() + 9 * std::size_t(pair.ba);
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) other[3 * r + c] = block[3 * c + r];
    }
    fill_diagonal(network, time_step);
}

void AssembledEuler::add_links(const SpringNetwork& network, double time_step) noexcept {
    for (std::size_t l = 0; l < m_link_blocks.size(); ++l) {
        if (m_link_blocks[l] < 0) continue;
        const SpringLink& link = network.links()[l];
        const Vec3d r =
            vector_at(m_position, std::size_t(link.a)) - vector_at(m_position, std::size_t(link.b));
        const double length = norm(r);
        if (!(length > 0)) continue;  // undefined direction
        const Vec3d n = (1 / length) * r;
        const double across = std::max(0.0, link.stiffness * (1 - link.rest_length / length));
        const double along = link.stiffness - across + link.damping / time_step;
        float* const block = m_matrix.blocks.data() + 9 * std::size_t(m_link_blocks[l]);
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k)
                block[3 * c + k] -= float(along * n[c] * n[k] + (c == k ? across : 0));
        const Vec3d pull = (link.stiffness * (length - link.rest_length)) * n;
        add_to(m_residual, std::size_t(link.a), -pull);
        add_to(m_residual, std::size_t(link.b), pull);
    }
}

void AssembledEuler::add_cells(const SpringNetwork& network) noexcept {
    const std::int32_t* at = m_cell_blocks.data();
    for (std::size_t c = 0; c < m_rest_volumes.size(); ++c) {
        if (m_rest_volumes[c] == 0) continue;
        const SpringCell& cell = network.cells()[c];
        Vec3d gradients[8];
        const double volume = find_gradients(cell, gradients);
        const double weight = cell.bulk / m_rest_volumes[c];
        const double pressure = weight * (volume - m_rest_volumes[c]);
        float single[8][3];
        const double root = std::sqrt(weight);
        for (int k = 0; k < cell.node_count; ++k) {
            const auto mine = std::size_t(cell.nodes[std::size_t(k)]);
            add_to(m_residual, mine, -pressure * gradients[k]);
            for (int r = 0; r < 3; ++r) single[k][r] = float(root * gradients[k][r]);
            for (int j = 0; j < k; ++j) {
                // The block of the lower node's row.
                const bool is_lower = mine < std::size_t(cell.nodes[std::size_t(j)]);
                const float* const row = single[is_lower ? k : j];
                const float* const column = single[is_lower ? j : k];
                float* const block = m_matrix.blocks.data() + 9 * std::size_t(*at++);
                for (int q = 0; q < 3; ++q)
                    for (int r = 0; r < 3; ++r) block[3 * q + r] += row[r] * column[q];
            }
        }
    }
}

/// Computes ∂V/∂corner. @returns the volume
double AssembledEuler::find_gradients(const SpringCell& cell,
                                      Vec3d (&gradients)[8]) const noexcept {
    const auto position = [&](std::int32_t n) { return vector_at(m_position, std::size_t(n)); };
    const Vec3d origin = position(cell.nodes[0]);
    if (cell.node_count == 4) {
        const Vec3d a = position(cell.nodes[1]) - origin, b = position(cell.nodes[2]) - origin,
                    c = position(cell.nodes[3]) - origin;
        gradients[1] = (1.0 / 6) * cross(b, c);
        gradients[2] = (1.0 / 6) * cross(c, a);
        gradients[3] = (1.0 / 6) * cross(a, b);
        gradients[0] = -(gradients[1] + gradients[2] + gradients[3]);
        return dot(a, gradients[1]);
    }
    double volume = 0;
    for (int k = 0; k < cell.node_count; ++k) {
        gradients[k] = volume_gradient(cell, k, position);
        volume += dot(position(cell.nodes[std::size_t(k)]) - origin, gradients[k]);
    }
    return volume / 3;
}

void AssembledEuler::fill_diagonal(const SpringNetwork& network, double time_step) noexcept {
    for (std::size_t n = 0; n < m_matrix.moves.size(); ++n) {
        const SpringNode& node = network.nodes()[n];
        const double alone = (node.mass / time_step + node.damping) / time_step;
        Mat3d sum{{{alone, 0, 0}, {0, alone, 0}, {0, 0, alone}}};
        for (std::int32_t k = m_matrix.first[n]; k < m_matrix.first[n + 1]; ++k) {
            const float* const block = m_matrix.blocks.data() + 9 * std::size_t(k);
            for (int c = 0; c < 3; ++c)
                for (int r = 0; r < 3; ++r) sum.columns[c][r] -= double(block[3 * c + r]);
        }
        // Blocks aren't symmetric, their sum is, but for rounding.
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < c; ++r)
                sum.columns[c][r] = sum.columns[r][c] =
                    0.5 * (sum.columns[c][r] + sum.columns[r][c]);
        const Mat3d inverted = inverse(sum);
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) {
                m_matrix.diagonal[12 * n + std::size_t(4 * c + r)] = sum.columns[c][r];
                m_inverse[12 * n + std::size_t(4 * c + r)] = float(inverted.columns[c][r]);
            }
    }
}

// A step.

std::int32_t AssembledEuler::step(const SpringNetwork& network, SpringState& state,
                                  std::span<const std::uint8_t> moves, double time_step,
                                  const SolveLimits& limits) noexcept {
    const double h = time_step;
    const std::size_t count = moves.size();
    std::copy(moves.begin(), moves.end(), m_matrix.moves.begin());
    for (std::size_t n = 0; n < count; ++n)
        for (int c = 0; c < 3; ++c) m_position[4 * n + std::size_t(c)] = state.x[c][n];
    assemble(network, h);
    LaneSum scale;
    for (std::size_t n = 0; n < count; ++n) {
        const double mass = network.nodes()[n].mass;
        for (int c = 0; c < 3; ++c) {
            const std::size_t k = 4 * n + std::size_t(c);
            m_velocity[k] = moves[n] ? (state.x[c][n] - state.before[c][n]) / h : 0;
            m_residual[k] =
                moves[n] ? (state.load[c][n] + m_residual[k]) / h + mass / (h * h) * m_velocity[k]
                         : 0;
        }
        scale.add(m_residual.data() + 4 * n, m_residual.data() + 4 * n);
    }
    const std::int32_t iterations = solve(limits, scale.total());
    for (std::size_t n = 0; n < count; ++n)
        for (int c = 0; moves[n] && c < 3; ++c) {
            state.before[c][n] = state.x[c][n];
            state.x[c][n] += h * m_velocity[4 * n + std::size_t(c)];
        }
    return iterations;
}

/// Subtracts a multiple of m_image from the residual, adds that of m_direction to the velocity, and
/// sums the residual for the coarse space. @returns square of the residual's length
double AssembledEuler::reduce(double step) noexcept {
    m_coarse.begin();
    LaneSum left;
    for (std::size_t n = 0; n < m_matrix.moves.size(); ++n) {
        double* const v = m_velocity.data() + 4 * n;
        double* const r = m_residual.data() + 4 * n;
        for (std::size_t c = 0; c < 4; ++c) {
            v[c] += step * m_direction[4 * n + c];
            r[c] -= step * m_image[4 * n + c];
        }
        left.add(r, r);
        if (m_matrix.moves[n]) m_coarse.add(n, r);
    }
    return left.total();
}

/// Computes m_scaled from m_residual. @returns their product
double AssembledEuler::precondition() noexcept {
    m_coarse.solve();
    LaneSum weight;
    for (std::size_t n = 0; n < m_matrix.moves.size(); ++n) {
        if (!m_matrix.moves[n]) continue;
        const float* const inverse = m_inverse.data() + 12 * n;
        const double* const r = m_residual.data() + 4 * n;
        double* const z = m_scaled.data() + 4 * n;
        for (int c = 0; c < 4; ++c)
            z[c] = double(inverse[c]) * r[0] + double(inverse[4 + c]) * r[1] +
                   double(inverse[8 + c]) * r[2];
        m_coarse.correct(n, z);
        weight.add(r, z);
    }
    return weight.total();
}

/// Conjugate gradients. @param scale  square of the right side's length; m_residual is the right
/// side
std::int32_t AssembledEuler::solve(const SolveLimits& limits, double scale) noexcept {
    const std::size_t count = m_residual.size();
    std::fill(m_scaled.begin(), m_scaled.end(), 0.0);
    std::fill(m_direction.begin(), m_direction.end(), 0.0);
    m_multiply(m_matrix, m_velocity.data(), m_image.data());
    double left = reduce(1), weight = 0;
    const double enough = limits.tolerance * limits.tolerance * std::max(scale, left);
    for (std::int32_t turn = 0; turn < limits.iterations; ++turn) {
        if (!(left > enough)) return turn;
        const double last = weight;
        weight = precondition();
        const double kept = turn == 0 ? 0 : weight / last;
        for (std::size_t k = 0; k < count; ++k)
            m_direction[k] = m_scaled[k] + kept * m_direction[k];
        m_multiply(m_matrix, m_direction.data(), m_image.data());
        LaneSum curvature;
        for (std::size_t k = 0; k < count; k += 4)
            curvature.add(m_direction.data() + k, m_image.data() + k);
        if (!(curvature.total() > 0)) break;
        left = reduce(weight / curvature.total());
    }
    return limits.iterations + 1;
}

}  // namespace pliant
