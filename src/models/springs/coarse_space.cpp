// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/coarse_space.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>

namespace pliant {
namespace {

constexpr std::size_t kNodesPerGroup = 64;
/// The correction is a product with a full matrix of 6·groups rows.
constexpr std::size_t kMaxGroups = 96;
constexpr std::size_t kPanel = 16;  ///< rows whose sums stay in registers

using Motions = Eigen::Matrix<double, 3, 6>;

}  // namespace

/// Halves groups along their longest axis until they are small.
void CoarseSpace::divide(const SpringNetwork& network) {
    const auto rest = [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; };
    std::vector<std::int32_t> free;
    for (std::int32_t n = 0; n < network.node_count(); ++n)
        if (!network.nodes()[std::size_t(n)].fixed) free.push_back(n);
    const std::size_t longest =
        std::max(kNodesPerGroup, (free.size() + kMaxGroups / 2 - 1) / (kMaxGroups / 2));
    m_group.assign(std::size_t(network.node_count()), -1);
    m_arm.assign(4 * m_group.size(), 0);
    m_group_count = 0;
    std::vector<std::array<std::size_t, 2>> ranges;
    if (!free.empty()) ranges.push_back({0, free.size()});
    while (!ranges.empty()) {
        const auto [begin, end] = ranges.back();
        ranges.pop_back();
        Vec3d low = rest(free[begin]), high = low, sum{0, 0, 0};
        for (std::size_t k = begin; k < end; ++k) {
            const Vec3d at = rest(free[k]);
            sum = sum + at;
            for (int c = 0; c < 3; ++c) {
                low[c] = std::min(low[c], at[c]);
                high[c] = std::max(high[c], at[c]);
            }
        }
        if (end - begin > longest) {
            const Vec3d size = high - low;
            const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
            std::sort(free.begin() + std::ptrdiff_t(begin), free.begin() + std::ptrdiff_t(end),
                      [&](std::int32_t a, std::int32_t b) {
                          const double at = rest(a)[axis], other = rest(b)[axis];
                          return at != other ? at < other : a < b;
                      });
            const std::size_t middle = begin + (end - begin) / 2;
            ranges.push_back({middle, end});
            ranges.push_back({begin, middle});
            continue;
        }
        const Vec3d centre = (1 / double(end - begin)) * sum;
        // Scaled to unit size, so that translations and rotations have similar stiffness.
        const double size = norm(high - low);
        const double scale = size > 0 ? 2 / size : 0;
        for (std::size_t k = begin; k < end; ++k) {
            const auto n = std::size_t(free[k]);
            m_group[n] = std::int32_t(m_group_count);
            const Vec3d arm = scale * (rest(free[k]) - centre);
            for (int c = 0; c < 3; ++c) m_arm[4 * n + std::size_t(c)] = arm[c];
        }
        ++m_group_count;
    }
}

void CoarseSpace::prepare(const SpringNetwork& network, const BlockMatrix& at_rest) {
    divide(network);
    m_size = 6 * m_group_count;
    const std::size_t panels = (m_size + kPanel - 1) / kPanel;
    m_right.assign(m_size, 0);
    m_motion.assign(panels * kPanel, 0);
    const auto motions = [&](std::size_t n) {
        const double* const d = m_arm.data() + 4 * n;
        Motions z;
        z << 1, 0, 0, 0, d[2], -d[1],  //
            0, 1, 0, -d[2], 0, d[0],   //
            0, 0, 1, d[1], -d[0], 0;
        return z;
    };
    Eigen::MatrixXd coarse = Eigen::MatrixXd::Zero(Eigen::Index(m_size), Eigen::Index(m_size));
    for (std::size_t n = 0; n < m_group.size(); ++n) {
        if (m_group[n] < 0) continue;
        const Eigen::Index row = 6 * m_group[n];
        const Motions mine = motions(n);
        Eigen::Matrix3d block;
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
                block(r, c) = at_rest.diagonal[12 * n + std::size_t(4 * c + r)];
        coarse.block<6, 6>(row, row) += mine.transpose() * block * mine;
        for (std::int32_t k = at_rest.first[n]; k < at_rest.first[n + 1]; ++k) {
            const auto other = std::size_t(at_rest.columns[std::size_t(k)]);
            if (m_group[other] < 0) continue;
            for (int c = 0; c < 3; ++c)
                for (int r = 0; r < 3; ++r)
                    block(r, c) =
                        double(at_rest.blocks[9 * std::size_t(k) + std::size_t(3 * c + r)]);
            coarse.block<6, 6>(row, 6 * m_group[other]) +=
                mine.transpose() * block * motions(other);
        }
    }
    // Groups of nodes in a line don't resist every rotation.
    for (Eigen::Index k = 0; k < coarse.rows(); ++k)
        coarse(k, k) = coarse(k, k) > 0 ? (1 + 1e-6) * coarse(k, k) : 1;
    const Eigen::LLT<Eigen::MatrixXd> factor(coarse);
    m_inverse.assign(panels * kPanel * m_size, 0);
    if (factor.info() != Eigen::Success) {  // rounding: no correction then
        m_group.assign(m_group.size(), -1);
        return;
    }
    const Eigen::MatrixXd inverse =
        factor.solve(Eigen::MatrixXd::Identity(coarse.rows(), coarse.cols()));
    // Symmetric in spite of rounding.
    for (std::size_t row = 0; row < m_size; ++row)
        for (std::size_t column = 0; column < m_size; ++column)
            m_inverse[(row / kPanel * m_size + column) * kPanel + row % kPanel] = float(
                inverse(Eigen::Index(std::max(row, column)), Eigen::Index(std::min(row, column))));
}

void CoarseSpace::begin() {
    std::fill(m_right.begin(), m_right.end(), 0.0);
}

void CoarseSpace::solve() {
    for (std::size_t panel = 0; panel < m_motion.size(); panel += kPanel) {
        const float* at = m_inverse.data() + panel * m_size;
        float sums[kPanel] = {};
        for (std::size_t column = 0; column < m_size; ++column, at += kPanel) {
            const auto right = float(m_right[column]);
            for (std::size_t row = 0; row < kPanel; ++row) sums[row] += at[row] * right;
        }
        for (std::size_t row = 0; row < kPanel; ++row) m_motion[panel + row] = double(sums[row]);
    }
}

}  // namespace pliant
