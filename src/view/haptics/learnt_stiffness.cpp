// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The stiffness of a tissue from its forces.

#include <pliant/view/haptics.h>

#include "base/units.h"

namespace pliant {

LearntStiffness::LearntStiffness(double start_n_m, double largest_n_m)
    : m_largest_n_m(largest_n_m), m_stiffness_n_m{} {
    for (int c = 0; c < 3; ++c) m_stiffness_n_m.columns[c][c] = start_n_m;
}

void LearntStiffness::begin_with(const Mat3d& change_n_m) {
    for (int c = 0; c < 3; ++c) m_stiffness_n_m.columns[c] = -change_n_m.columns[c];
    m_stiffness_n_m = capped_stiffness(m_stiffness_n_m, m_largest_n_m);
}

void LearntStiffness::add(Vec3d position_mm, Vec3d force_n) {
    constexpr double kMinStep_mm = 0.01;  // below: rounding or own motion
    if (m_has_position) {
        const Vec3d step = position_mm - m_position_mm;
        if (norm(step) < kMinStep_mm) return;
        // K ← K + (r sᵀ + s rᵀ)/s·s − (r·s) s sᵀ/(s·s)², r = −ΔF − K s: symmetric.
        const Vec3d change = 1e3 * (m_force_n - force_n);
        const Vec3d r = change - m_stiffness_n_m * step;
        const double ss = dot(step, step), rs = dot(r, step);
        for (int c = 0; c < 3; ++c)
            m_stiffness_n_m.columns[c] = m_stiffness_n_m.columns[c] + (step[c] / ss) * r +
                                         (r[c] / ss) * step - (rs * step[c] / (ss * ss)) * step;
        m_stiffness_n_m = capped_stiffness(m_stiffness_n_m, m_largest_n_m);
    }
    m_has_position = true;
    m_position_mm = position_mm;
    m_force_n = force_n;
}

Mat3d LearntStiffness::change_n_m() const {
    Mat3d change{};
    for (int c = 0; c < 3; ++c) change.columns[c] = -m_stiffness_n_m.columns[c];
    return change;
}

}  // namespace pliant
