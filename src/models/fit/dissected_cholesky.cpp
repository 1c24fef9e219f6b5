// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fit/dissected_cholesky.h"

#include <algorithm>
#include <utility>

namespace pliant {
namespace {

/// Maximum size of a part that is a single block.
constexpr std::size_t kBlockNodes = 24;

}  // namespace

struct DissectedCholesky::Graph {
    std::span<const Vec3d> positions;
    std::vector<std::vector<std::int32_t>> neighbours;  ///< [node]
};

DissectedCholesky::DissectedCholesky(std::span<const Vec3d> positions, const Joined& joined,
                                     std::span<const std::uint8_t> free)
    : m_order(positions.size(), -1) {
    Graph graph{positions, std::vector<std::vector<std::int32_t>>(positions.size())};
    for (const auto& nodes : joined)
        for (const std::int32_t a : nodes)
            for (const std::int32_t b : nodes)
                if (a != b) graph.neighbours[std::size_t(a)].push_back(b);
    for (auto& of_node : graph.neighbours) {
        std::sort(of_node.begin(), of_node.end());
        of_node.erase(std::unique(of_node.begin(), of_node.end()), of_node.end());
    }
    std::vector<std::int32_t> nodes;
    for (std::size_t n = 0; n < positions.size(); ++n)
        if (free[n]) nodes.push_back(std::int32_t(n));
    int next = 0;
    if (!nodes.empty()) dissect(graph, std::move(nodes), next);
}

int DissectedCholesky::add_block(std::span<const std::int32_t> nodes, std::vector<int> children,
                                 int& next) {
    Block block{3 * next, 0, std::move(children), {}};
    for (const std::int32_t n : nodes) m_order[std::size_t(n)] = next++;
    block.end = 3 * next;
    m_blocks.push_back(std::move(block));
    return int(m_blocks.size()) - 1;
}

/// @param next  next position in the order. @returns the last block of this part
int DissectedCholesky::dissect(const Graph& graph, std::vector<std::int32_t> nodes, int& next) {
    if (nodes.size() <= kBlockNodes) return add_block(nodes, {}, next);
    const auto position = [&](std::int32_t n) { return graph.positions[std::size_t(n)]; };
    Vec3d low = position(nodes[0]), high = low;
    for (const std::int32_t n : nodes)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], position(n)[a]);
            high[a] = std::max(high[a], position(n)[a]);
        }
    const Vec3d extent = high - low;
    const int axis =
        extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    if (!(extent[axis] > 0)) return add_block(nodes, {}, next);
    std::vector<double> along;
    for (const std::int32_t n : nodes) along.push_back(position(n)[axis]);
    std::nth_element(along.begin(), along.begin() + std::ptrdiff_t(along.size() / 2), along.end());
    double cut = along[along.size() / 2];
    if (cut == low[axis]) {  // most nodes are there: use the next plane
        cut = high[axis];
        for (const double c : along)
            if (c > low[axis]) cut = std::min(cut, c);
    }
    enum : std::uint8_t { kElsewhere, kLeft, kRight };
    std::vector<std::uint8_t> side(graph.positions.size(), kElsewhere);
    for (const std::int32_t n : nodes)
        side[std::size_t(n)] = position(n)[axis] < cut ? kLeft : kRight;
    std::vector<std::int32_t> left, right, separator;
    for (const std::int32_t n : nodes) {
        const auto& beside = graph.neighbours[std::size_t(n)];
        if (side[std::size_t(n)] == kLeft)
            left.push_back(n);
        else if (std::any_of(beside.begin(), beside.end(),
                             [&](std::int32_t m) { return side[std::size_t(m)] == kLeft; }))
            separator.push_back(n);
        else
            right.push_back(n);
    }
    std::vector<int> children{dissect(graph, std::move(left), next)};
    if (!right.empty()) children.push_back(dissect(graph, std::move(right), next));
    return add_block(separator, std::move(children), next);
}

void DissectedCholesky::analyse(const Matrix& lower) {
    std::vector<int> seen(std::size_t(lower.rows()), -1);
    for (int b = 0; b < int(m_blocks.size()); ++b) {
        Block& block = m_blocks[std::size_t(b)];
        block.rows.clear();
        const auto add = [&](int row) {
            if (row < block.end || seen[std::size_t(row)] == b) return;
            seen[std::size_t(row)] = b;
            block.rows.push_back(row);
        };
        for (int column = block.begin; column < block.end; ++column)
            for (Matrix::InnerIterator at(lower, column); at; ++at) add(int(at.row()));
        for (const int child : block.children)
            for (const int row : m_blocks[std::size_t(child)].rows) add(row);
        std::sort(block.rows.begin(), block.rows.end());
    }
}

std::unique_ptr<DissectedCholesky::Factor> DissectedCholesky::factor(const Matrix& lower,
                                                                     double least_pivot) const {
    auto made = std::make_unique<Factor>(m_blocks.size());
    std::vector<Eigen::MatrixXd> updates(m_blocks.size());  // for the parents
    std::vector<int> position(std::size_t(lower.rows()));   // index in the front
    for (std::size_t b = 0; b < m_blocks.size(); ++b) {
        const Block& block = m_blocks[b];
        const int own = block.end - block.begin, later = int(block.rows.size());
        for (int n = 0; n < own; ++n) position[std::size_t(block.begin + n)] = n;
        for (int n = 0; n < later; ++n) position[std::size_t(block.rows[std::size_t(n)])] = own + n;
        Eigen::MatrixXd front = Eigen::MatrixXd::Zero(own + later, own + later);
        for (int n = 0; n < own; ++n)
            for (Matrix::InnerIterator at(lower, block.begin + n); at; ++at)
                front(position[std::size_t(at.row())], n) += at.value();
        for (const int child : block.children) {
            // Rows ascend in both, so the lower triangle is preserved.
            const std::vector<int>& rows = m_blocks[std::size_t(child)].rows;
            Eigen::MatrixXd& update = updates[std::size_t(child)];
            for (int c = 0; c < int(rows.size()); ++c)
                for (int r = c; r < int(rows.size()); ++r)
                    front(position[std::size_t(rows[std::size_t(r)])],
                          position[std::size_t(rows[std::size_t(c)])]) += update(r, c);
            update.resize(0, 0);
        }
        if (own > 0) {
            Eigen::Ref<Eigen::MatrixXd> corner = front.topLeftCorner(own, own);
            const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(corner);
            if (llt.info() != Eigen::Success) return nullptr;
            for (int n = 0; n < own; ++n) {
                const double pivot = corner(n, n) * corner(n, n);
                const int at = block.begin + n;
                if (!(pivot > least_pivot * lower.coeff(at, at))) return nullptr;
            }
            auto below = front.bottomLeftCorner(later, own);
            corner.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(
                below);
            front.bottomRightCorner(later, later)
                .selfadjointView<Eigen::Lower>()
                .rankUpdate(below, -1);
        }
        (*made)[b] = front.leftCols(own);
        updates[b] = front.bottomRightCorner(later, later);
    }
    return made;
}

Eigen::VectorXd DissectedCholesky::solve(const Factor& factor, Eigen::VectorXd x) const {
    for (std::size_t b = 0; b < m_blocks.size(); ++b) {
        const Block& block = m_blocks[b];
        const int own = block.end - block.begin, later = int(block.rows.size());
        auto its = x.segment(block.begin, own);
        factor[b].topRows(own).triangularView<Eigen::Lower>().solveInPlace(its);
        const Eigen::VectorXd change = factor[b].bottomRows(later) * its;
        for (int n = 0; n < later; ++n) x[block.rows[std::size_t(n)]] -= change[n];
    }
    for (std::size_t b = m_blocks.size(); b-- > 0;) {
        const Block& block = m_blocks[b];
        const int own = block.end - block.begin, later = int(block.rows.size());
        Eigen::VectorXd beside(later);
        for (int n = 0; n < later; ++n) beside[n] = x[block.rows[std::size_t(n)]];
        auto its = x.segment(block.begin, own);
        its.noalias() -= factor[b].bottomRows(later).transpose() * beside;
        factor[b].topRows(own).triangularView<Eigen::Lower>().transpose().solveInPlace(its);
    }
    return x;
}

}  // namespace pliant
