// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/exposure.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace pliant::render {
namespace {

constexpr int kAcross = 11;    // rays
constexpr double kKey = 0.75;  // light on an average wall, as a share of its albedo
constexpr double kPower = 0.75;
constexpr double kNear_mm = 5, kFar_mm = 45;

double arriving(double far_mm) {
    return 1 / (far_mm * far_mm + kLampSize_mm * kLampSize_mm);
}

}  // namespace

double metered_exposure(const EyeRays& rays, const Camera& camera, FieldStop field_stop) {
    const bool full = field_stop == FieldStop::Full;
    const double radius = std::min(1.0, camera.aspect());
    const double half_width = full ? camera.aspect() : radius, half_height = full ? 1 : radius;
    std::vector<Vec3d> directions;
    for (int j = 0; j < kAcross; ++j)
        for (int i = 0; i < kAcross; ++i) {
            const double u = (2 * i + 1.0) / kAcross - 1, v = (2 * j + 1.0) / kAcross - 1;
            if (full || u * u + v * v <= 1)
                directions.push_back(camera.through(half_width * u, half_height * v));
        }
    std::vector<double> far_mm(directions.size());
    for (std::size_t n = 0; n < directions.size(); ++n)  // too far apart to share a beam
        rays.hit_distances(std::span(&directions[n], 1), &far_mm[n]);
    // Power mean of exponent 3/4: a near fold has less weight than in a mean, so that it doesn't
    // darken the lumen, and more than in a median, so that it is not overexposed.
    double sum = 0;
    for (const double d : far_mm) sum += std::isinf(d) ? 0 : std::pow(arriving(d), kPower);
    const double mean = std::pow(sum / double(far_mm.size()), 1 / kPower);
    return kKey / std::clamp(mean, arriving(kFar_mm), arriving(kNear_mm));
}

}  // namespace pliant::render
