// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/rotations.h"

namespace pliant {

Rotation rotation_by(Vec3d vector) {
    const double angle = norm(vector);
    const double s = angle < 1e-6 ? 0.5 - angle * angle / 48 : std::sin(0.5 * angle) / angle;
    return {std::cos(0.5 * angle), s * vector.x, s * vector.y, s * vector.z};
}
Vec3d rotation_vector(Rotation q) {
    Vec3d u{q.x, q.y, q.z};
    double w = q.w;
    if (w < 0) {
        u = -u;
        w = -w;
    }
    const double s = norm(u);
    return (s < 1e-9 ? 2.0 / w : 2 * std::atan2(s, w) / s) * u;
}

}  // namespace pliant
