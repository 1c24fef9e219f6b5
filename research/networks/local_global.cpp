// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/research/springs.h>

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <string>

#include "base/errors.h"

namespace pliant {

struct LocalGlobalSprings::Impl {
    using Matrix = Eigen::SparseMatrix<double>;

    Impl(SpringNetwork n, double h, std::int32_t count)
        : network(std::move(n)), time_step(h), iterations(count) {
        for (const SpringNode& node : network.nodes()) {
            now.push_back(node.rest);
            moves.push_back(!node.fixed);
        }
        before = now;
        load.assign(now.size(), {0, 0, 0});
    }

    Status factor();
    void step();
    void set_constant();
    void add_directions();

    SpringNetwork network;
    double time_step;
    std::int32_t iterations;
    std::vector<Vec3d> now, before, load;  ///< [node]
    std::vector<std::uint8_t> moves;
    bool is_factored = false;
    Eigen::SimplicialLDLT<Matrix> factors;
    std::vector<std::int32_t> node_of;  ///< [row]
    Eigen::MatrixX3d right, constant, solution;
};

Status LocalGlobalSprings::Impl::factor() {
    std::vector<std::int32_t> row_of(now.size(), -1);
    node_of.clear();
    for (std::size_t n = 0; n < now.size(); ++n) {
        if (!moves[n]) continue;
        row_of[n] = std::int32_t(node_of.size());
        node_of.push_back(std::int32_t(n));
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t row = 0; row < node_of.size(); ++row) {
        const std::int32_t node = node_of[row];
        const SpringNode& properties = network.nodes()[std::size_t(node)];
        double diagonal =
            properties.mass / (time_step * time_step) + properties.damping / time_step;
        for (const auto& neighbour : network.neighbours(node)) {
            const double k = network.links()[std::size_t(neighbour.link)].stiffness;
            diagonal += k;
            const std::int32_t column = row_of[std::size_t(neighbour.node)];
            if (column >= 0) entries.emplace_back(int(row), column, -k);
        }
        entries.emplace_back(int(row), int(row), diagonal);
    }
    const auto size = Eigen::Index(node_of.size());
    Matrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    factors.compute(matrix);
    if (factors.info() != Eigen::Success)
        return Error{ErrorCode::LimitExceeded,
                     "step: expected a matrix that can be factored, found one that isn't positive"};
    right.resize(size, 3);
    constant.resize(size, 3);
    is_factored = true;
    return Ok{};
}

/// Terms of the right side that don't depend on directions.
void LocalGlobalSprings::Impl::set_constant() {
    for (std::size_t row = 0; row < node_of.size(); ++row) {
        const auto n = std::size_t(node_of[row]);
        const SpringNode& properties = network.nodes()[n];
        const double inertia = properties.mass / (time_step * time_step);
        const double drag = properties.damping / time_step;
        const Vec3d moved = now[n] - before[n];
        const Vec3d sum = inertia * (now[n] + moved) + drag * now[n] + load[n];
        for (int c = 0; c < 3; ++c) constant(Eigen::Index(row), c) = sum[c];
        before[n] = now[n];
        now[n] = now[n] + moved;  // the inertial prediction as a start
    }
}

/// The local step: adds Σ k l n for the present directions, and the pull of nodes that don't move.
void LocalGlobalSprings::Impl::add_directions() {
    for (std::size_t row = 0; row < node_of.size(); ++row) {
        const std::int32_t node = node_of[row];
        Vec3d sum{0, 0, 0};
        for (const auto& neighbour : network.neighbours(node)) {
            const SpringLink& link = network.links()[std::size_t(neighbour.link)];
            const Vec3d other = now[std::size_t(neighbour.node)];
            const Vec3d r = now[std::size_t(node)] - other;
            const double length = norm(r);
            if (length > 0) sum = sum + (link.stiffness * link.rest_length / length) * r;
            if (!moves[std::size_t(neighbour.node)]) sum = sum + link.stiffness * other;
        }
        for (int c = 0; c < 3; ++c) right(Eigen::Index(row), c) += sum[c];
    }
}

void LocalGlobalSprings::Impl::step() {
    set_constant();
    for (std::int32_t turn = 0; turn < iterations; ++turn) {
        right = constant;
        add_directions();
        solution = factors.solve(right);
        for (std::size_t row = 0; row < node_of.size(); ++row)
            for (int c = 0; c < 3; ++c)
                now[std::size_t(node_of[row])][c] = solution(Eigen::Index(row), c);
    }
}

LocalGlobalSprings::LocalGlobalSprings(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
LocalGlobalSprings::~LocalGlobalSprings() = default;
LocalGlobalSprings::LocalGlobalSprings(LocalGlobalSprings&&) noexcept = default;
LocalGlobalSprings& LocalGlobalSprings::operator=(LocalGlobalSprings&&) noexcept = default;

Result<LocalGlobalSprings> LocalGlobalSprings::create(SpringNetwork network, double time_step,
                                                      std::int32_t iterations) {
    if (!(time_step > 0))
        return invalid("time_step: expected one above 0, found " + std::to_string(time_step));
    if (iterations < 1)
        return invalid("iterations: expected 1 or more, found " + std::to_string(iterations));
    if (network.has_volume_energy()) return invalid("network: expected one without volume energy");
    if (network.has_branches()) return invalid("network: expected one without Maxwell branches");
    for (const SpringLink& link : network.links())
        if (link.damping > 0) return invalid("network: expected links without damping");
    return LocalGlobalSprings(std::make_unique<Impl>(std::move(network), time_step, iterations));
}

void LocalGlobalSprings::load(std::int32_t node, Vec3d force) {
    m_impl->load[std::size_t(node)] = force;
}

void LocalGlobalSprings::hold(std::int32_t node, Vec3d position) {
    const auto n = std::size_t(node);
    m_impl->now[n] = m_impl->before[n] = position;
    m_impl->is_factored &= !m_impl->moves[n];
    m_impl->moves[n] = 0;
}

void LocalGlobalSprings::release(std::int32_t node) {
    const auto n = std::size_t(node);
    if (m_impl->moves[n] || m_impl->network.nodes()[n].fixed) return;
    m_impl->moves[n] = 1;
    m_impl->is_factored = false;
}

Result<SpringCut> LocalGlobalSprings::cut_links(std::span<const std::int32_t> links) {
    m_impl->is_factored = false;
    return m_impl->network.cut_links(links);
}

Status LocalGlobalSprings::step(std::int32_t count) {
    if (!m_impl->is_factored)
        if (const Status s = m_impl->factor(); !s.ok()) return s;
    for (std::int32_t n = 0; n < count; ++n) m_impl->step();
    return Ok{};
}

std::vector<Vec3d> LocalGlobalSprings::displacements() const {
    std::vector<Vec3d> moved;
    for (std::size_t n = 0; n < m_impl->now.size(); ++n)
        moved.push_back(m_impl->now[n] - m_impl->network.nodes()[n].rest);
    return moved;
}

}  // namespace pliant
