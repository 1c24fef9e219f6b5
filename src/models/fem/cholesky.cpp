// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only user of Eigen: its simplicial LDLᵀ with an approximate minimum degree ordering.
// Single-threaded, so that the bits are independent of threads.

#include "fem/cholesky.h"

#define EIGEN_MPL2_ONLY
#define EIGEN_DONT_PARALLELIZE
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <new>
#include <string>
#include <vector>

namespace pliant {
namespace {

using Index = std::int64_t;
using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;
using Vector = Eigen::VectorXd;

/// A pivot with a smaller ratio to its diagonal is rounding: the solid has a hinge.
constexpr double kMinPivot = 1e-13;

/// Number of each free component, −1 if held: [3 · node + axis].
std::vector<Index> number_free(const HeldNodes& held) {
    std::vector<Index> numbers(3 * held.axes.size());
    Index count = 0;
    for (std::size_t n = 0; n < held.axes.size(); ++n)
        for (int a = 0; a < 3; ++a)
            numbers[3 * n + std::size_t(a)] = held.holds(n, a) ? -1 : count++;
    return numbers;
}

/// Lower triangle of the free part. The matrix is symmetric, so columns are rows.
Matrix lower_triangle(const BlockMatrix& blocks, const std::vector<Index>& numbers, Index count) {
    Matrix lower(count, count);
    const auto for_each_entry = [&](auto&& use) {
        for (std::int32_t column = 0; column < blocks.row_count(); ++column)
            for (std::size_t a = 0; a < 3; ++a) {
                const Index c = numbers[3 * std::size_t(column) + a];
                if (c < 0) continue;
                const auto nodes = blocks.columns(column);
                for (std::size_t n = 0; n < nodes.size(); ++n)
                    for (std::size_t b = 0; b < 3; ++b) {
                        const Index r = numbers[3 * std::size_t(nodes[n]) + b];
                        if (r >= c) use(r, c, blocks.blocks(column)[n][3 * a + b]);
                    }
            }
    };
    Eigen::Matrix<Index, Eigen::Dynamic, 1> entries(count);
    entries.setZero();
    for_each_entry([&](Index, Index c, double) { ++entries[c]; });
    lower.reserve(entries);
    for_each_entry([&](Index r, Index c, double value) { lower.insert(r, c) = value; });
    lower.makeCompressed();
    return lower;
}

}  // namespace

struct CholeskyFactor::Impl {
    std::vector<Index> numbers;
    Index count = 0;
    Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::AMDOrdering<Index>> factor;
};

CholeskyFactor::CholeskyFactor(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
CholeskyFactor::~CholeskyFactor() = default;
CholeskyFactor::CholeskyFactor(CholeskyFactor&&) noexcept = default;
CholeskyFactor& CholeskyFactor::operator=(CholeskyFactor&&) noexcept = default;

Result<CholeskyFactor> CholeskyFactor::create(const BlockMatrix& matrix, const HeldNodes& held) {
    auto impl = std::make_unique<Impl>();
    impl->numbers = number_free(held);
    for (const Index number : impl->numbers) impl->count += number >= 0;
    if (impl->count == 0) return CholeskyFactor(std::move(impl));
    const Error singular{ErrorCode::InvalidArgument,
                         "solid: its stiffness is singular, although it is held as a whole; "
                         "expected cells that are joined by faces"};
    try {
        const Matrix lower = lower_triangle(matrix, impl->numbers, impl->count);
        const Vector diagonal = lower.diagonal();
        impl->factor.compute(lower);
        if (impl->factor.info() != Eigen::Success) return singular;
        const Vector before = impl->factor.permutationP() * diagonal;
        const Vector pivots = impl->factor.vectorD();
        for (Index n = 0; n < impl->count; ++n)
            if (!(pivots[n] > kMinPivot * before[n])) return singular;
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded,
                     "method: no memory for the factor of " + std::to_string(impl->count) +
                         " unknowns, expected fewer, or conjugate gradients"};
    }
    return CholeskyFactor(std::move(impl));
}

NodeVector CholeskyFactor::solve(const NodeVector& force) const {
    Vector f(m_impl->count);
    const auto& numbers = m_impl->numbers;
    const auto each = [&](auto&& use) {
        for (std::size_t n = 0; n < numbers.size(); ++n)
            if (numbers[n] >= 0) use(int(n % 3), n / 3, numbers[n]);
    };
    each([&](int axis, std::size_t node, Index n) { f[n] = force.component(axis)[node]; });
    NodeVector displacement(force.node_count());
    if (m_impl->count == 0) return displacement;
    const Vector u = m_impl->factor.solve(f);
    each([&](int axis, std::size_t node, Index n) { displacement.component(axis)[node] = u[n]; });
    return displacement;
}

std::int64_t CholeskyFactor::bytes() const {
    if (m_impl->count == 0) return 0;
    const auto entries = m_impl->factor.matrixL().nestedExpression().nonZeros();
    return std::int64_t(entries) * std::int64_t(sizeof(double) + sizeof(Index));
}

}  // namespace pliant
