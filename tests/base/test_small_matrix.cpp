// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/small_matrix.h"

#include <gtest/gtest.h>

#include "support/random.h"

namespace pliant::test {
namespace {

TEST(Eigen, VectorsAreEigenvectorsAndStandUprightOnEachOther) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const auto size = std::size_t(random.whole(1, 7));
        SquareMatrix a(size, std::vector<double>(size, 0));
        for (std::size_t p = 0; p < size; ++p)
            for (std::size_t q = 0; q <= p; ++q) a[p][q] = a[q][p] = random.real(-1, 1);
        const auto eigen = symmetric_eigen(a);
        for (std::size_t e = 0; e < size; ++e) {
            if (e > 0) {
                EXPECT_LE(eigen.values[e - 1], eigen.values[e]);
            }
            for (std::size_t p = 0; p < size; ++p) {
                double image = 0;
                for (std::size_t q = 0; q < size; ++q) image += a[p][q] * eigen.vectors[e][q];
                EXPECT_NEAR(image, eigen.values[e] * eigen.vectors[e][p], 1e-13);
            }
            for (std::size_t f = 0; f <= e; ++f) {
                double product = 0;
                for (std::size_t p = 0; p < size; ++p)
                    product += eigen.vectors[e][p] * eigen.vectors[f][p];
                EXPECT_NEAR(product, e == f ? 1 : 0, 1e-13);
            }
        }
    }
}

TEST(LargestEigenvalue, IsThatOfJacobisRotations) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Matrix3 rows{};
        Mat3d m{};
        const bool diagonal = seed % 4 == 0;
        for (int p = 0; p < 3; ++p)
            for (int q = 0; q <= p; ++q) {
                const double value = diagonal && p != q ? 0 : random.real(-1, 1);
                m.columns[p][q] = m.columns[q][p] = value;
                rows[std::size_t(p)][std::size_t(q)] = rows[std::size_t(q)][std::size_t(p)] = value;
            }
        const double expected = symmetric_eigen(rows).values[2];
        EXPECT_NEAR(largest_eigenvalue(m, Scaling::Quotients), expected, 1e-7);
        EXPECT_NEAR(largest_eigenvalue(m, Scaling::Reciprocal), expected, 1e-7);
    }
}

TEST(LargestEigenvalue, OfAMultipleOfTheIdentityIsTheMultiple) {
    const Mat3d m{{{0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}};
    EXPECT_DOUBLE_EQ(largest_eigenvalue(m, Scaling::Quotients), 0.1);
    EXPECT_EQ(largest_eigenvalue(Mat3d{}, Scaling::Reciprocal), 0);
}

}  // namespace
}  // namespace pliant::test
