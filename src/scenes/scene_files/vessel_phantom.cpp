// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vessels that the program makes. The aorta with the arteries of its arch, from in front:
//
//      right    carotids    left
//    subclavian  │    │   subclavian
//        ╲__     │    │     __╱
//           ╲__╱_│____│____╱
//             │  ╭─────╮  │
//   ascending │  │     │  │ descending, where catheters enter
//
// The sizes are typical for an adult; not those of a patient.

#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/errors.h"

namespace pliant {
namespace {

constexpr double kStep_mm = 2;  ///< of the points of a curve

/// A straight tube with a part of a circle in it: "bend" has a quarter, "arch" a half.
std::vector<CentrePoint> bent_tube(const std::string& name) {
    const double bend = name == "arch" ? std::numbers::pi : std::numbers::pi / 2,
                 radius = name == "arch" ? 35 : 30, tube = name == "arch" ? 10 : 4;
    std::vector<CentrePoint> branch;
    for (double z = 0; z < 60; z += 3) branch.push_back({{0, 0, z}, tube});
    for (int n = 0; n <= 24; ++n) {
        const double angle = bend * n / 24;
        branch.push_back(
            {{radius * (1 - std::cos(angle)), 0, 60 + radius * std::sin(angle)}, tube});
    }
    const Vec3d last = branch.back().position_mm, ahead{std::sin(bend), 0, std::cos(bend)};
    for (double s = 3; s < 40; s += 3) branch.push_back({last + s * ahead, tube});
    return branch;
}

/// Catmull-Rom spline through points.
std::vector<CentrePoint> curve_through(std::vector<CentrePoint> p) {
    const auto beyond = [](const CentrePoint& end, const CentrePoint& next) {
        return CentrePoint{2.0 * end.position_mm - next.position_mm,
                           2 * end.radius_mm - next.radius_mm};
    };
    p.insert(p.begin(), beyond(p[0], p[1]));
    p.push_back(beyond(p[p.size() - 1], p[p.size() - 2]));
    std::vector<CentrePoint> curve;
    for (std::size_t i = 1; i + 2 < p.size(); ++i) {
        const int count =
            std::max(2, int(norm(p[i + 1].position_mm - p[i].position_mm) / kStep_mm));
        for (int n = 0; n < count; ++n) {
            const double t = double(n) / count, u = t * t, v = u * t;
            const double w[] = {0.5 * (2 * u - t - v), 0.5 * (2 - 5 * u + 3 * v),
                                0.5 * (t + 4 * u - 3 * v), 0.5 * (v - u)};
            CentrePoint at{{0, 0, 0}, 0};
            for (std::size_t k = 0; k < 4; ++k) {
                at.position_mm = at.position_mm + w[k] * p[i + k - 1].position_mm;
                at.radius_mm += w[k] * p[i + k - 1].radius_mm;
            }
            curve.push_back(at);
        }
    }
    curve.push_back(p[p.size() - 2]);
    return curve;
}

/// A curve from a point, through points relative to it.
std::vector<CentrePoint> branch_from(Vec3d from, std::vector<CentrePoint> points) {
    for (CentrePoint& p : points) p.position_mm = p.position_mm + from;
    return curve_through(std::move(points));
}

Centreline aorta() {
    constexpr double kRadius_mm = 30, kDescending_mm = 10, kAscending_mm = 12;
    const Vec3d side = normalized(Vec3d{0.45, 0.893, 0});  // left and posterior
    const auto on_arch = [&](double deg) {
        const double a = deg * std::numbers::pi / 180;
        return kRadius_mm * (std::cos(a) * side + std::sin(a) * Vec3d{0, 0, 1});
    };
    std::vector<CentrePoint> trunk;
    for (double z = -120; z < 0; z += 3)
        trunk.push_back({kRadius_mm * side + Vec3d{0, 0, z}, kDescending_mm});
    for (int n = 0; n <= 32; ++n)
        trunk.push_back(
            {on_arch(180.0 * n / 32), kDescending_mm + (kAscending_mm - kDescending_mm) * n / 32});
    for (double z = 3; z <= 30; z += 3)
        trunk.push_back({-kRadius_mm * side - Vec3d{0, 0, z}, kAscending_mm});
    const auto stem =
        branch_from(on_arch(116), {{{0, 0, 0}, 6}, {{-9, 1, 18}, 5.8}, {{-18, 4, 34}, 5.5}});
    const Vec3d fork = stem.back().position_mm;
    return {
        {std::move(trunk),
         branch_from(on_arch(62), {{{0, 0, 0}, 4.5},
                                   {{6, 2, 22}, 4.5},
                                   {{16, 4, 44}, 4.2},
                                   {{40, 6, 58}, 4},
                                   {{66, 8, 52}, 4}}),
         branch_from(on_arch(88),
                     {{{0, 0, 0}, 3.8}, {{3, 2, 25}, 3.6}, {{7, 4, 55}, 3.5}, {{6, 2, 95}, 3.5}}),
         stem,
         branch_from(fork,
                     {{{0, 0, 0}, 5}, {{-14, 4, 14}, 4.4}, {{-36, 6, 20}, 4}, {{-60, 8, 12}, 4}}),
         branch_from(
             fork, {{{0, 0, 0}, 5}, {{-3, 2, 18}, 3.8}, {{-4, 2, 45}, 3.5}, {{-3, 0, 75}, 3.5}})}};
}

}  // namespace

Result<Centreline> phantom_centreline(const std::string& name) noexcept {
    return attempt([&]() -> Result<Centreline> {
        if (name == "bend" || name == "arch") return Centreline{{bent_tube(name)}};
        if (name == "aorta") return aorta();
        return expected_error("phantom", "bend, arch or aorta", name);
    });
}

}  // namespace pliant
