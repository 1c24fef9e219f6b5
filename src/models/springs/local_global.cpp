// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only user of sparse matrices of Eigen in this room.

#include "springs/local_global.h"

#include <Eigen/SparseCholesky>

#include <exception>
#include <string>

namespace pliant {

struct LocalGlobal::Impl {
    using Matrix = Eigen::SparseMatrix<double>;
    Eigen::SimplicialLDLT<Matrix> factors;
    std::vector<std::uint8_t> moves;  ///< nodes that it was factored for
    std::vector<std::int32_t> row_of, node_of;
    Eigen::MatrixX3d right, constant, solution;

    Status factor(const SpringNetwork& network, const SpringState& state, double time_step);
};

LocalGlobal::LocalGlobal() : m_impl(std::make_unique<Impl>()) {}
LocalGlobal::~LocalGlobal() = default;
LocalGlobal::LocalGlobal(LocalGlobal&&) noexcept = default;
LocalGlobal& LocalGlobal::operator=(LocalGlobal&&) noexcept = default;

void LocalGlobal::forget() {
    m_impl->moves.clear();
}

Status LocalGlobal::prepare(const SpringNetwork& network, const SpringState& state,
                            double time_step) {
    Impl& m = *m_impl;
    const auto count = std::size_t(network.node_count());
    const auto moves = [&](std::size_t n) { return state.moves(network, std::int32_t(n)); };
    bool is_same = m.moves.size() == count;
    for (std::size_t n = 0; is_same && n < count; ++n) is_same = m.moves[n] == moves(n);
    if (is_same) return Ok{};
    try {
        return m.factor(network, state, time_step);
    } catch (...) {
        m.moves.clear();
        throw;
    }
}

Status LocalGlobal::Impl::factor(const SpringNetwork& network, const SpringState& state,
                                 double time_step) {
    Impl& m = *this;
    const auto count = std::size_t(network.node_count());
    m.moves.resize(count);
    m.row_of.assign(count, -1);
    m.node_of.clear();
    for (std::size_t n = 0; n < count; ++n) {
        m.moves[n] = state.moves(network, std::int32_t(n));
        if (!m.moves[n]) continue;
        m.row_of[n] = std::int32_t(m.node_of.size());
        m.node_of.push_back(std::int32_t(n));
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t row = 0; row < m.node_of.size(); ++row) {
        const std::int32_t node = m.node_of[row];
        const SpringNode& properties = network.nodes()[std::size_t(node)];
        double diagonal =
            properties.mass / (time_step * time_step) + properties.damping / time_step;
        for (const auto& neighbour : network.neighbours(node)) {
            const double k = network.links()[std::size_t(neighbour.link)].stiffness;
            diagonal += k;
            const std::int32_t column = m.row_of[std::size_t(neighbour.node)];
            if (column >= 0) entries.emplace_back(int(row), column, -k);
        }
        entries.emplace_back(int(row), int(row), diagonal);
    }
    const auto size = Eigen::Index(m.node_of.size());
    Impl::Matrix matrix(size, size);
    std::string why = "the matrix isn't positive";
    bool is_factored = false;
    try {
        matrix.setFromTriplets(entries.begin(), entries.end());
        m.factors.compute(matrix);
        is_factored = m.factors.info() == Eigen::Success;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        why = error.what();
    }
    if (!is_factored) {
        m.moves.clear();
        return Error{ErrorCode::LimitExceeded,
                     "LocalGlobal: expected a matrix that can be factored: " + why};
    }
    m.right.resize(size, 3);
    m.constant.resize(size, 3);
    m.solution.resize(size, 3);
    return Ok{};
}

void LocalGlobal::step(const SpringNetwork& network, SpringState& state, double time_step,
                       std::int32_t iterations) {
    Impl& m = *m_impl;
    for (std::size_t row = 0; row < m.node_of.size(); ++row) {
        const std::int32_t node = m.node_of[row];
        const SpringNode& properties = network.nodes()[std::size_t(node)];
        const double inertia = properties.mass / (time_step * time_step);
        const double drag = properties.damping / time_step;
        const Vec3d now = state.place(node), moved = now - state.place_before(node);
        const Vec3d sum = inertia * (now + moved) + drag * now + state.load_of(node);
        for (int c = 0; c < 3; ++c) m.constant(Eigen::Index(row), c) = sum[c];
    }
    for (std::size_t row = 0; row < m.node_of.size(); ++row) {
        const std::int32_t node = m.node_of[row];
        const Vec3d now = state.place(node), moved = now - state.place_before(node);
        state.put_before(node, now);
        state.put(node, now + moved);  // the inertial prediction as a start
    }
    for (std::int32_t turn = 0; turn < iterations; ++turn) {
        m.right = m.constant;
        for (std::size_t row = 0; row < m.node_of.size(); ++row) {
            const std::int32_t node = m.node_of[row];
            Vec3d sum{0, 0, 0};
            for (const auto& neighbour : network.neighbours(node)) {
                const SpringLink& link = network.links()[std::size_t(neighbour.link)];
                const Vec3d other = state.place(neighbour.node);
                const Vec3d r = state.place(node) - other;
                const double length = norm(r);
                if (length > 0) sum = sum + (link.stiffness * link.rest_length / length) * r;
                if (!m.moves[std::size_t(neighbour.node)]) sum = sum + link.stiffness * other;
            }
            for (int c = 0; c < 3; ++c) m.right(Eigen::Index(row), c) += sum[c];
        }
        m.solution = m.factors.solve(m.right);
        for (std::size_t row = 0; row < m.node_of.size(); ++row)
            state.put(m.node_of[row],
                      {m.solution(Eigen::Index(row), 0), m.solution(Eigen::Index(row), 1),
                       m.solution(Eigen::Index(row), 2)});
    }
}

}  // namespace pliant
