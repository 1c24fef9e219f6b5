// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fit/linear_network.h"

#include "fit/dissected_cholesky.h"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <array>
#include <mutex>
#include <optional>

#include "springs/cell_volume.h"

namespace pliant {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;
using Entries = std::vector<Eigen::Triplet<double>>;

/// A pivot with a smaller ratio to its diagonal is rounding.
constexpr double kMinPivot = 1e-13;

/// Adds s · v vᵀ, with v given by vectors at nodes, to the lower triangle of the unknowns.
template <std::size_t kMost>
void add_outer(std::span<const int> unknowns, int count, const std::array<std::int32_t, kMost>& at,
               const std::array<Vec3d, kMost>& v, double s, Entries& to) {
    for (int a = 0; a < 3 * count; ++a)
        for (int b = 0; b < 3 * count; ++b) {
            const auto p = std::size_t(a / 3), q = std::size_t(b / 3);
            const int row = unknowns[3 * std::size_t(at[p]) + std::size_t(a % 3)];
            const int column = unknowns[3 * std::size_t(at[q]) + std::size_t(b % 3)];
            if (row < 0 || column < 0 || row < column) continue;
            to.emplace_back(row, column, s * v[p][a % 3] * v[q][b % 3]);
        }
}

void add_link(const SpringParts& parts, std::span<const int> unknowns, std::size_t l, Entries& to) {
    const SpringLink& link = parts.links[l];
    const Vec3d n =
        normalized(parts.nodes[std::size_t(link.a)].rest - parts.nodes[std::size_t(link.b)].rest);
    add_outer<2>(unknowns, 2, {link.a, link.b}, {n, -n}, link.stiffness, to);
}

void add_cell(const SpringParts& parts, std::span<const int> unknowns, std::size_t c, Entries& to) {
    const SpringCell& cell = parts.cells[c];
    const auto rest = [&](std::int32_t n) { return parts.nodes[std::size_t(n)].rest; };
    std::array<Vec3d, 8> gradient{};
    for (int n = 0; n < cell.node_count; ++n)
        gradient[std::size_t(n)] = volume_gradient(cell, n, rest);
    add_outer<8>(unknowns, cell.node_count, cell.nodes, gradient,
                 cell.bulk / cell_volume(cell, rest), to);
}

}  // namespace

struct LinearNetwork::Factor {
    Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factor;
    std::shared_ptr<const DissectedCholesky::Factor> dissected;  ///< for large networks, instead of
                                                                 ///< `factor`
    double scale = 1;  ///< scale of the matrix relative to the factor
};

struct LinearNetwork::Impl {
    std::vector<int> unknowns;           ///< [3·node + axis]: index in the matrices; −1: held
    std::vector<std::uint8_t> is_empty;  ///< [group]: its matrix is zero
    std::optional<DissectedCholesky> dissection;  ///< for large networks
    // Cache of the last factor of a large network: the derivatives of a step need the factor of its
    // cost.
    std::mutex last_mutex;
    std::vector<double> last_values;
    std::shared_ptr<const Factor> last;
    std::vector<Matrix> matrices;  ///< of each group, and of the rest; lower triangles
    int count = 0;

    Vector gather(std::span<const Vec3d> from) const {
        Vector v = Vector::Zero(count);
        for (std::size_t n = 0; n < unknowns.size(); ++n)
            if (unknowns[n] >= 0) v[unknowns[n]] = from[n / 3][int(n % 3)];
        return v;
    }
    std::vector<Vec3d> scatter(const Vector& v) const {
        std::vector<Vec3d> to(unknowns.size() / 3, Vec3d{0, 0, 0});
        for (std::size_t n = 0; n < unknowns.size(); ++n)
            if (unknowns[n] >= 0) to[n / 3][int(n % 3)] = v[unknowns[n]];
        return to;
    }
};

LinearNetwork::~LinearNetwork() = default;
LinearNetwork::LinearNetwork(LinearNetwork&&) noexcept = default;
LinearNetwork& LinearNetwork::operator=(LinearNetwork&&) noexcept = default;

/// Computes one elimination order for all values. @returns position of each unknown
std::vector<int> LinearNetwork::minimum_degree(const SpringParts& parts) const {
    const Impl& m = *m_impl;
    Entries all;
    for (std::size_t l = 0; l < parts.links.size(); ++l) add_link(parts, m.unknowns, l, all);
    for (std::size_t c = 0; c < parts.cells.size(); ++c) add_cell(parts, m.unknowns, c, all);
    Matrix lower(m.count, m.count);
    lower.setFromTriplets(all.begin(), all.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), order);
    std::vector<int> index(std::size_t(m.count), 0);
    for (int n = 0; n < m.count; ++n) index[std::size_t(order.indices()[n])] = n;
    return index;
}

/// Elimination order by nested dissection.
std::vector<int> LinearNetwork::dissect(const SpringParts& parts,
                                        std::span<const std::uint8_t> held) {
    Impl& m = *m_impl;
    std::vector<Vec3d> positions;
    std::vector<std::uint8_t> free;
    for (std::size_t n = 0; n < parts.nodes.size(); ++n) {
        positions.push_back(parts.nodes[n].rest);
        free.push_back(!held[n]);
    }
    DissectedCholesky::Joined joined;
    for (const SpringLink& link : parts.links) joined.push_back({link.a, link.b});
    for (const SpringCell& cell : parts.cells)
        joined.emplace_back(cell.nodes.begin(), cell.nodes.begin() + cell.node_count);
    m.dissection.emplace(positions, joined, free);
    std::vector<int> index;
    for (std::size_t u = 0; u < m.unknowns.size(); ++u)
        if (m.unknowns[u] >= 0) index.push_back(3 * m.dissection->order()[u / 3] + int(u % 3));
    return index;
}

LinearNetwork::LinearNetwork(const SpringParts& parts, std::span<const FitGroup> groups,
                             std::span<const std::uint8_t> held, std::size_t most_simple_nodes)
    : m_impl(std::make_unique<Impl>()) {
    Impl& m = *m_impl;
    m.unknowns.resize(3 * parts.nodes.size());
    for (std::size_t n = 0; n < m.unknowns.size(); ++n)
        m.unknowns[n] = held[n / 3] ? -1 : m.count++;
    const std::vector<int> index =
        std::size_t(m.count) / 3 > most_simple_nodes ? dissect(parts, held) : minimum_degree(parts);
    for (int& unknown : m.unknowns)
        if (unknown >= 0) unknown = index[std::size_t(unknown)];
    std::vector<std::size_t> link_group(parts.links.size(), groups.size());
    std::vector<std::size_t> cell_group(parts.cells.size(), groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        for (const std::int32_t l : groups[g].links) link_group[std::size_t(l)] = g;
        for (const std::int32_t c : groups[g].cells) cell_group[std::size_t(c)] = g;
    }
    std::vector<Entries> entries(groups.size() + 1);
    for (std::size_t l = 0; l < parts.links.size(); ++l)
        add_link(parts, m.unknowns, l, entries[link_group[l]]);
    for (std::size_t c = 0; c < parts.cells.size(); ++c)
        add_cell(parts, m.unknowns, c, entries[cell_group[c]]);
    // Explicit zeros at the entries of other groups, so that all matrices share a pattern.
    Entries pattern;
    for (const Entries& of_group : entries)
        for (const auto& e : of_group) pattern.emplace_back(e.row(), e.col(), 0.0);
    for (int n = 0; n < m.count; ++n) pattern.emplace_back(n, n, 0.0);
    Matrix zeros(m.count, m.count);
    zeros.setFromTriplets(pattern.begin(), pattern.end());
    pattern.clear();
    for (int column = 0; column < m.count; ++column)
        for (Matrix::InnerIterator at(zeros, column); at; ++at)
            pattern.emplace_back(at.row(), column, 0.0);
    for (Entries& of_group : entries) {
        m.is_empty.push_back(of_group.empty());
        of_group.insert(of_group.end(), pattern.begin(), pattern.end());
        Matrix& matrix = m.matrices.emplace_back(m.count, m.count);
        matrix.setFromTriplets(of_group.begin(), of_group.end());
    }
    if (m.dissection) m.dissection->analyse(zeros);
}

std::shared_ptr<const LinearNetwork::Factor> LinearNetwork::factor(
    std::span<const double> given) const {
    Impl& m = *m_impl;
    // Recomputing a small factor in the same memory is faster than caching it.
    if (!m.dissection) return make_factor(given, {});
    std::vector<double> values(given.begin(), given.end());
    for (std::size_t g = 0; g < values.size(); ++g)
        if (m.is_empty[g]) values[g] = 0;
    // K(c·p) = c·K(p): a large network with a uniform change of stiffness keeps its factor.
    double scale = 1;
    if (m.is_empty.back()) {
        for (std::size_t g = values.size(); g-- > 0;)
            if (values[g] != 0) scale = values[g];
        for (double& value : values) value /= scale;
    }
    std::shared_ptr<const Factor> found;
    {
        const std::lock_guard lock(m.last_mutex);
        if (m.last && m.last_values == values) found = m.last;
    }
    if (!found) found = make_factor(values, {});
    if (!found) return nullptr;
    {
        const std::lock_guard lock(m.last_mutex);
        m.last_values = values;
        m.last = found;
    }
    if (scale == 1) return found;
    auto scaled = std::make_shared<Factor>();
    scaled->dissected = found->dissected;
    scaled->scale = scale;
    return scaled;
}

/// @param diagonal  [node]; empty: none
std::shared_ptr<const LinearNetwork::Factor> LinearNetwork::make_factor(
    std::span<const double> values, std::span<const double> diagonal) const {
    const Impl& m = *m_impl;
    Matrix sum = m.matrices.back();
    const auto size = std::size_t(sum.nonZeros());
    for (std::size_t g = 0; g < values.size(); ++g)
        for (std::size_t n = 0; n < size; ++n)
            sum.valuePtr()[n] += values[g] * m.matrices[g].valuePtr()[n];
    for (std::size_t u = 0; u < m.unknowns.size() && !diagonal.empty(); ++u)
        if (m.unknowns[u] >= 0) sum.coeffRef(m.unknowns[u], m.unknowns[u]) += diagonal[u / 3];
    auto made = std::make_shared<Factor>();
    if (m.count == 0) return made;
    if (m.dissection) {
        made->dissected = m.dissection->factor(sum, kMinPivot);
        if (!made->dissected) return nullptr;
        return made;
    }
    made->factor.compute(sum);
    if (made->factor.info() != Eigen::Success) return nullptr;
    const Vector pivots = made->factor.vectorD();
    for (int n = 0; n < m.count; ++n)
        if (!(pivots[n] > kMinPivot * sum.coeff(n, n))) return nullptr;
    return made;
}

std::vector<Vec3d> LinearNetwork::solve(const Factor& factor, std::span<const Vec3d> force) const {
    const Impl& m = *m_impl;
    if (m.count == 0) return std::vector<Vec3d>(force.size(), Vec3d{0, 0, 0});
    if (factor.dissected)
        return m.scatter(m.dissection->solve(*factor.dissected, m.gather(force)) / factor.scale);
    return m.scatter(factor.factor.solve(m.gather(force)));
}

std::vector<Vec3d> LinearNetwork::multiply(std::size_t group, std::span<const Vec3d> u) const {
    const Vector v = m_impl->gather(u);
    return m_impl->scatter(m_impl->matrices[group].selfadjointView<Eigen::Lower>() * v);
}

}  // namespace pliant
