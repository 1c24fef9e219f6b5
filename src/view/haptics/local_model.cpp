// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local models: built and checked on the tissue's thread, before the servo receives them.

#include <pliant/view/haptics.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/small_matrix.h"
#include "base/units.h"

namespace pliant {
namespace {

bool is_finite(const Mat3d& m) {
    return pliant::is_finite(m.columns[0]) && pliant::is_finite(m.columns[1]) &&
           pliant::is_finite(m.columns[2]);
}

Error bad_model(const std::string& what) {
    return {ErrorCode::InvalidArgument, "haptic model: " + what};
}

}  // namespace

Mat3d capped_stiffness(const Mat3d& stiffness_n_m, double largest_n_m) {
    Matrix3 matrix{};
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            matrix[std::size_t(r)][std::size_t(c)] =
                0.5 * (stiffness_n_m.columns[c][r] + stiffness_n_m.columns[r][c]);
    const auto eigen = symmetric_eigen(matrix);
    Mat3d capped{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double value = std::clamp(eigen.values[k], 0.0, largest_n_m);
        const Vec3d v{eigen.vectors[k][0], eigen.vectors[k][1], eigen.vectors[k][2]};
        for (int c = 0; c < 3; ++c) capped.columns[c] = capped.columns[c] + (value * v[c]) * v;
    }
    return capped;
}

Result<HapticModel> checked_model(HapticModel model, double largest_stiffness_n_m) {
    if (model.plane_count < 0 || model.plane_count > HapticModel::kMaxPlanes)
        return bad_model("expected 0 to " + std::to_string(HapticModel::kMaxPlanes) +
                         " planes, found " + std::to_string(model.plane_count));
    for (int k = 0; k < model.plane_count; ++k) {
        HapticPlane& plane = model.planes[k];
        const double length = norm(plane.normal);
        if (!is_finite(plane.point_mm) || !(length > 1e-6) || !std::isfinite(length))
            return bad_model("plane " + std::to_string(k) +
                             ": expected a position and a normal with a length");
        plane.normal = (1 / length) * plane.normal;
    }
    if (!is_finite(model.anchor_mm)) return bad_model("anchor_mm: expected numbers");
    if (!is_finite(model.depth_mm)) return bad_model("depth_mm: expected numbers");
    if (!is_finite(model.force_n)) return bad_model("force_n: expected numbers");
    if (!is_finite(model.stiffness_n_m)) return bad_model("stiffness_n_m: expected numbers");
    if (!(model.friction >= 0) || !std::isfinite(model.friction))
        return bad_model("friction: expected 0 or more, found " + std::to_string(model.friction));
    model.stiffness_n_m = capped_stiffness(model.stiffness_n_m, largest_stiffness_n_m);
    return model;
}

HapticModel model_of_contact(Vec3d surface_mm, Vec3d normal, Vec3d position_mm, Vec3d force_n,
                             const Mat3d& change_n_m) {
    HapticModel model;
    model.plane_count = 1;
    model.planes[0] = {surface_mm, normal};
    const double length2 = dot(normal, normal);
    if (length2 > 0)
        model.depth_mm = (std::max(0.0, dot(normal, surface_mm - position_mm)) / length2) * normal;
    model.force_n = force_n;
    for (int c = 0; c < 3; ++c) model.stiffness_n_m.columns[c] = -change_n_m.columns[c];
    return model;
}

HapticModel model_of_grip(Vec3d position_mm, Vec3d force_n, const Mat3d& change_n_m) {
    HapticModel model;
    model.held = true;
    model.anchor_mm = position_mm;
    model.force_n = force_n;
    for (int c = 0; c < 3; ++c) model.stiffness_n_m.columns[c] = -change_n_m.columns[c];
    return model;
}

Status check_haptic_settings(const HapticSettings& s) {
    const auto expect = [](bool good, const char* name, const char* what, double found) -> Status {
        if (good) return Ok{};
        return Error{ErrorCode::InvalidArgument, std::string("haptics: ") + name + ": expected " +
                                                     what + ", found " + std::to_string(found)};
    };
    const struct {
        double value, low, high;
        const char *name, *what;
    } numbers[] = {
        {s.max_force_n, 0, 1000, "max_force_n", "0 to 1000"},
        {s.max_force_rate_n_s, 1, 1e6, "max_force_rate_n_s", "1 to 1000000"},
        {s.max_stiffness_n_m, 0, 1e5, "max_stiffness_n_m", "0 to 100000"},
        {s.damping_n_s_m, 0, 1000, "damping_n_s_m", "0 to 1000"},
        {s.blend_s, 0, 1, "blend_s", "0 to 1"},
        {s.stale_s, 0.002, 10, "stale_s", "0.002 to 10"},
        {s.ramp_s, 0.001, 10, "ramp_s", "0.001 to 10"},
        {s.workspace.scale, 1e-3, 1e3, "workspace.scale", "0.001 to 1000"},
        {s.workspace.force_scale, 0, 1e3, "workspace.force_scale", "0 to 1000"},
    };
    for (const auto& n : numbers)
        if (const Status status =
                expect(n.value >= n.low && n.value <= n.high, n.name, n.what, n.value);
            !status.ok())
            return status;
    if (!is_finite(s.workspace.origin_mm) || !is_finite(s.workspace.rotation))
        return expect(false, "workspace", "numbers", 0);
    const Mat3d square = transposed(s.workspace.rotation) * s.workspace.rotation;
    double error = 0;
    for (int c = 0; c < 3; ++c)
        error = std::max(error, norm(square.columns[c] - kIdentity3.columns[c]));
    return expect(error < 1e-6, "workspace.rotation", "perpendicular unit vectors", error);
}

// The stiffness of a tissue from its forces.

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
