// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bounds of the time step.

#pragma once

#include <pliant/models/springs.h>

namespace pliant {

constexpr void add_outer(Mat3d& m, Vec3d v, double weight) {
    for (int c = 0; c < 3; ++c) m.columns[c] = m.columns[c] + (weight * v[c]) * v;
}

/// SpringNetwork::stable_time_step for a deformed shape. @param positions  [node]; empty: the rest
/// shape
double stable_time_step(const SpringNetwork& network, std::span<const Vec3d> positions);

}  // namespace pliant
