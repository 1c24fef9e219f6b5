# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Eigen. MPL-2.0 (its LGPL parts are shut out by EIGEN_MPL2_ONLY). Headers only: sparse Cholesky
# factors of finite elements and of mass-spring networks.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
