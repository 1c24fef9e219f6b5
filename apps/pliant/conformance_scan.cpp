// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases of the elastic scan: a rigid ball in an infinite solid, and on a layer.

#include <pliant/tissues.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "conformance.h"
#include "conformance_value.h"

namespace pliant::app {
namespace {

constexpr int kSize = 193, kRadius = 6;  // voxels of 1 mm
constexpr double kYoung_kpa = 10, kShift_mm = 0.3;
constexpr int kMostSweeps = 200;

void settle(Tissue& tissue) {
    for (int n = 0; n < kMostSweeps; ++n)
        if (computed(tissue.sweep()).settled) break;
}

void add_ball(ConformanceCases& cases, const TaskArena& arena) {
    Volume scan{.grid = {.size = {kSize, kSize, kSize}, .spacing_mm = {1, 1, 1}},
                .voxels = VoxelArray<std::int16_t>(std::size_t(kSize) * kSize * kSize),
                .key_values = {}};
    for (const double nu : {0.3, 0.45}) {
        ElasticScanSettings settings;
        settings.moduli_kpa = {{-1000, 0}, {-900, kYoung_kpa}};
        settings.poisson_ratio = nu;
        const auto tissue = computed(make_elastic(scan, settings, arena));
        const double middle = (kSize - 1) / 2.0;
        computed(tissue->push(1, {.point_mm = {middle, middle, middle},
                                  .push_mm = {kShift_mm, 0, 0},
                                  .sphere_radius_mm = kRadius}));
        settle(*tissue);
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
               -tissue->force_n(1).value_or(Vec3d{0, 0, 0}).x}}});
    }
}

// Hertz' force with the factor of a layer that is bonded to a rigid ground. The contact radius is
// 7 mm.
void add_layer(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kThick = 64, kHalfWidth = 96, kSphere = 80, kContact = 7;
    constexpr double kDepth = kContact * kContact / kSphere, kChi = kContact / kThick;
    for (const double nu : {0.3, 0.45}) {
        const double pi = std::numbers::pi,
                     a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu),
                     b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1 - nu);
        const double factor =
            1 - 2 * a / pi * kChi + 4 * a * a / (pi * pi) * kChi * kChi -
            8 / std::pow(pi, 3) * (std::pow(a, 3) + 4 * pi * pi / 15 * b) * std::pow(kChi, 3) +
            16 * a / std::pow(pi, 4) * (std::pow(a, 3) + 3 * pi * pi / 5 * b) * std::pow(kChi, 4);
        ConformanceCase one{
            "rigid sphere on a bonded layer, Poisson's ratio " + std::to_string(nu).substr(0, 4),
            "force for 0.61 mm [N]", "Dimitriadis2002",
            1e-3 * 4.0 / 3 * kYoung_kpa / (1 - nu * nu) * std::sqrt(kSphere) *
                std::pow(kDepth, 1.5) * factor,
            0.05};
        for (const int voxel : {2, 1}) {
            const int across = int(2 * kHalfWidth) / voxel + 1, up = int(kThick) / voxel + 1;
            const Volume scan{.grid = {.size = {across, across, up},
                                       .spacing_mm = {double(voxel), double(voxel), double(voxel)}},
                              .voxels = VoxelArray<std::int16_t>(std::size_t(across) * across * up),
                              .key_values = {}};
            ElasticScanSettings settings;
            settings.moduli_kpa = {{-1000, 0}, {-900, kYoung_kpa}};
            settings.poisson_ratio = nu;
            settings.held_sides = {"-z"};
            const auto tissue = computed(make_elastic(scan, settings, arena));
            computed(
                tissue->slide(1,
                              {.point_mm = {kHalfWidth + 0.3, kHalfWidth - 0.2, kThick + kSphere},
                               .push_mm = {0, 0, -kDepth},
                               .sphere_radius_mm = kSphere},
                              {}));
            settle(*tissue);
            one.results.push_back({"elastic scan",
                                   std::to_string(across) + " x " + std::to_string(across) + " x " +
                                       std::to_string(up) + " voxels",
                                   tissue->force_n(1).value_or(Vec3d{0, 0, 0}).z});
        }
        cases.push_back(std::move(one));
    }
}

}  // namespace

ConformanceCases scan_cases(const TaskArena& arena) {
    ConformanceCases cases;
    add_ball(cases, arena);
    add_layer(cases, arena);
    return cases;
}

}  // namespace pliant::app
