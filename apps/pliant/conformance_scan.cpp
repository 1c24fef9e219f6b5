// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases of the elastic scan: a rigid ball in an infinite solid.

#include <pliant/tissues.h>

#include <numbers>

#include "conformance.h"
#include "conformance_value.h"

namespace pliant::app {
namespace {

constexpr int kSize = 193, kRadius = 6;  // voxels of 1 mm
constexpr double kYoung_kpa = 10, kShift_mm = 0.3;
constexpr int kMostSweeps = 200;

}  // namespace

ConformanceCases scan_cases(const TaskArena& arena) {
    Volume scan{.grid = {.size = {kSize, kSize, kSize}, .spacing_mm = {1, 1, 1}},
                .voxels = VoxelArray<std::int16_t>(std::size_t(kSize) * kSize * kSize),
                .key_values = {}};
    ConformanceCases cases;
    for (const double nu : {0.3, 0.45}) {
        ElasticScanSettings settings;
        settings.moduli_kpa = {{-1000, 0}, {-900, kYoung_kpa}};
        settings.poisson_ratio = nu;
        const auto tissue = make_elastic(scan, settings, arena);
        if (!tissue.ok()) throw ConformanceFailure{tissue.error().message};
        const double middle = (kSize - 1) / 2.0;
        const auto push = (*tissue)->push(1, {.point_mm = {middle, middle, middle},
                                              .push_mm = {kShift_mm, 0, 0},
                                              .sphere_radius_mm = kRadius});
        if (!push.ok()) throw ConformanceFailure{push.error().message};
        for (int n = 0; n < kMostSweeps; ++n) {
            const auto swept = (*tissue)->sweep();
            if (!swept.ok()) throw ConformanceFailure{swept.error().message};
            if (swept->settled) break;
        }
        const double mu = 1e3 * kYoung_kpa / (2 * (1 + nu));
        const double force_n =
            24e-6 * std::numbers::pi * mu * kRadius * (1 - nu) * kShift_mm / (5 - 6 * nu);
        cases.push_back(
            {"rigid ball in an infinite solid, Poisson's ratio " + std::to_string(nu).substr(0, 4),
             "force for 0.3 mm [N]",
             "24 pi mu a (1 - nu) u / (5 - 6 nu)",
             force_n,
             0.05,
             {{"elastic scan", "193 x 193 x 193 voxels, radius 6, window 30",
               -(*tissue)->force_n(1).value_or(Vec3d{0, 0, 0}).x}}});
    }
    return cases;
}

}  // namespace pliant::app
