// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The control nodes of a scan with springs, with the scan brought up to date.

#pragma once

#include <gtest/gtest.h>

#include "tissue/spring_tissue.h"

namespace pliant::test {

inline const ControlLattice& control_of(const SpringScanTissue& tissue) {
    EXPECT_TRUE(tissue.update_deformation().ok());
    return tissue.control();
}

/// Displacement of every control node [mm, LPS].
inline const std::vector<Vec3d>& displacements_of(const SpringScanTissue& tissue) {
    EXPECT_TRUE(tissue.update_deformation().ok());
    return tissue.displacements_mm();
}

/// Position of every control node [mm, LPS].
inline std::vector<Vec3d> positions_of(const SpringScanTissue& tissue) {
    std::vector<Vec3d> positions(std::size_t(tissue.node_count()));
    tissue.positions_mm(positions);
    return positions;
}

}  // namespace pliant::test
