// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Chains of blocks against elimination of the whole matrix, and with vectors against without.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "catheter/chain.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using catheter::Chain;
using Rows = std::vector<std::vector<double>>;

constexpr std::size_t kSize = 6;

/// Σ v vᵀ of random vectors over two neighbouring blocks each, plus a small multiple of the
/// identity.
Rows random_matrix(std::size_t count, Random& random) {
    const std::size_t all = kSize * count;
    Rows m(all, std::vector<double>(all, 0));
    for (std::size_t n = 0; n < all; ++n) m[n][n] = random.ratio(1e-3, 1);
    for (std::size_t block = 0; block < count; ++block)
        for (int n = 0; n < 8; ++n) {
            std::vector<double> v(std::min(2 * kSize, all - kSize * block));
            for (double& x : v) x = random.real(-1, 1);
            for (std::size_t r = 0; r < v.size(); ++r)
                for (std::size_t c = 0; c < v.size(); ++c)
                    m[kSize * block + r][kSize * block + c] += v[r] * v[c];
        }
    return m;
}

/// Gaussian elimination with column pivoting. @returns the solution
std::vector<double> solved(Rows m, std::vector<double> right) {
    const std::size_t all = right.size();
    for (std::size_t j = 0; j < all; ++j) {
        std::size_t pivot = j;
        for (std::size_t r = j; r < all; ++r)
            if (std::abs(m[r][j]) > std::abs(m[pivot][j])) pivot = r;
        std::swap(m[j], m[pivot]);
        std::swap(right[j], right[pivot]);
        for (std::size_t r = 0; r < all; ++r) {
            if (r == j) continue;
            const double share = m[r][j] / m[j][j];
            for (std::size_t c = j; c < all; ++c) m[r][c] -= share * m[j][c];
            right[r] -= share * right[j];
        }
    }
    for (std::size_t n = 0; n < all; ++n) right[n] /= m[n][n];
    return right;
}

/// Clears the part below the diagonal, which the solver ignores.
Chain<kSize> chain_of(const Rows& m, const std::vector<double>& right) {
    Chain<kSize> chain;
    const std::size_t count = right.size() / kSize;
    chain.reset(count);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t r = 0; r < kSize; ++r) {
            const auto& row = m[kSize * i + r];
            for (std::size_t c = 0; c < kSize; ++c) {
                chain.diagonal[i].at[r][c] = c < r ? 1e3 : row[kSize * i + c];
                if (i + 1 < count) chain.upper[i].at[r][c] = row[kSize * (i + 1) + c];
            }
            chain.diagonal[i].at[r][kSize] = right[kSize * i + r];
        }
    return chain;
}

void expect_solved(std::uint64_t seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto count = std::size_t(random.whole(1, 9));
    const Rows m = random_matrix(count, random);
    std::vector<double> right(kSize * count);
    for (double& b : right) b = random.real(-1, 1);
    const auto expected = solved(m, right);
    Chain<kSize> chain = chain_of(m, right), plain = chain;
    chain.solve();
    catheter::solve_chain_plain(plain.diagonal.data(), plain.upper.data(), count);
    double size = 0;
    for (const double x : expected) size = std::max(size, std::abs(x));
    for (std::size_t n = 0; n < expected.size(); ++n) {
        const double x = chain.diagonal[n / kSize].at[n % kSize][kSize];
        EXPECT_NEAR(x, expected[n], 1e-10 * size) << n;
        const double y = plain.diagonal[n / kSize].at[n % kSize][kSize];
        EXPECT_EQ(std::memcmp(&x, &y, sizeof x), 0) << x << ' ' << y;
    }
}

TEST(Chain, IsSolvedAsTheWholeMatrixIs) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) expect_solved(seed);
}

TEST(Chain, PartsAreAddedByTheirPlace) {
    Random random(7);
    const Vec3d a = random.vector(1), v = random.vector(1);
    Chain<kSize> chain;
    chain.reset(2);
    auto& block = chain.upper[0];
    block.add(0, 3, {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}});
    block.add_crossing(3, 0, a);
    block.add_same(0, 0, 2.5);
    block.add_outer(3, 3, -2, v);
    chain.add_right(1, 3, a);
    for (int r = 0; r < 3; ++r) {
        Vec3d unit{0, 0, 0};
        unit[r] = 1;
        for (int c = 0; c < 3; ++c) {
            Vec3d column{0, 0, 0};
            column[c] = 1;
            const auto row = std::size_t(r), to = std::size_t(c);
            EXPECT_EQ(block.at[row][to + 3], 3 * c + r + 1);
            EXPECT_EQ(block.at[row + 3][to], cross(a, column)[r]);
            EXPECT_EQ(block.at[row][to], r == c ? 2.5 : 0);
            EXPECT_NEAR(block.at[row + 3][to + 3], -2 * v[r] * v[c], 1e-15);
        }
        EXPECT_EQ(chain.diagonal[1].at[std::size_t(r) + 3][6], a[r]);
    }
    EXPECT_EQ(chain.solution(1, 3), a);
}

}  // namespace
}  // namespace pliant::test
