# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Eigen. MPL-2.0 (its LGPL parts are shut out by EIGEN_MPL2_ONLY). Headers only: the sparse Cholesky
# factor of the finite-element reference.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
