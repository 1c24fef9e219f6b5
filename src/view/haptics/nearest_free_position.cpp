// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Nearest point of a convex polyhedron. It lies on at most three planes with independent normals,
// and x is then x + Σ λ n with λ ≥ 0. Eight planes have 92 sets of up to three, so all are tried,
// small ones first. There is no iteration, so the time is bounded.

#include <pliant/view/haptics.h>

namespace pliant {
namespace {

constexpr double kTouching_mm = 1e-9;  ///< rounding at coordinates of some metres
constexpr double kParallel = 1e-12;    ///< Gram determinant of parallel planes

bool is_free(const HapticModel& model, Vec3d p) {
    for (int k = 0; k < model.plane_count; ++k)
        if (dot(model.planes[k].normal, p - model.planes[k].point_mm) < -kTouching_mm) return false;
    return true;
}

/// Computes λ of one, two or three planes; false if they have no common point or λ < 0.
bool find_multipliers(const Vec3d* n, const double* d, int count, double* lambda) {
    if (count == 1) {
        lambda[0] = d[0];
        return d[0] >= 0;
    }
    const double ab = dot(n[0], n[1]);
    if (count == 2) {
        const double determinant = 1 - ab * ab;
        if (determinant < kParallel) return false;
        lambda[0] = (d[0] - ab * d[1]) / determinant;
        lambda[1] = (d[1] - ab * d[0]) / determinant;
        return lambda[0] >= 0 && lambda[1] >= 0;
    }
    const double ac = dot(n[0], n[2]), bc = dot(n[1], n[2]);
    const Mat3d gram = {{{1, ab, ac}, {ab, 1, bc}, {ac, bc, 1}}};
    if (pliant::determinant(gram) < kParallel) return false;
    const Vec3d l = inverse(gram) * Vec3d{d[0], d[1], d[2]};
    for (int k = 0; k < 3; ++k) lambda[k] = l[k];
    return l.x >= 0 && l.y >= 0 && l.z >= 0;
}

}  // namespace

Vec3d nearest_free_position(const HapticModel& model, Vec3d x, bool* is_boxed_in) {
    if (is_boxed_in) *is_boxed_in = false;
    if (is_free(model, x)) return x;
    const int count = model.plane_count;
    Vec3d n[3];
    double d[3], lambda[3];
    const auto choose = [&](int at, int plane) {
        n[at] = model.planes[plane].normal;
        d[at] = dot(n[at], model.planes[plane].point_mm - x);
    };
    Vec3d found{0, 0, 0};
    const auto is_nearest = [&](int size) {
        if (!find_multipliers(n, d, size, lambda)) return false;
        found = x;
        for (int k = 0; k < size; ++k) found = found + lambda[k] * n[k];
        return is_free(model, found);
    };
    for (int a = 0; a < count; ++a) {
        choose(0, a);
        if (is_nearest(1)) return found;
    }
    for (int a = 0; a < count; ++a) {
        choose(0, a);
        for (int b = a + 1; b < count; ++b) {
            choose(1, b);
            if (is_nearest(2)) return found;
        }
    }
    for (int a = 0; a < count; ++a) {
        choose(0, a);
        for (int b = a + 1; b < count; ++b) {
            choose(1, b);
            for (int c = b + 1; c < count; ++c) {
                choose(2, c);
                if (is_nearest(3)) return found;
            }
        }
    }
    if (is_boxed_in) *is_boxed_in = true;
    int deepest = 0;
    for (int a = 0; a < count; ++a) {
        choose(1, a);
        choose(0, deepest);
        if (d[1] > d[0]) deepest = a;
    }
    choose(0, deepest);
    return x + d[0] * n[0];
}

}  // namespace pliant
