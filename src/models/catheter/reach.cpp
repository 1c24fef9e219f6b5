// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Minimum reach of local steps. The displacement by a push decays along a tube on an elastic
// foundation. The slowest component is bending of the tube as a beam, with the length
//
//   l = (4 E I/K)^¼,   I = π R³ t,  K = π R k   →   l = (4 E t R²/k)^¼
//
// for a wall of modulus E, thickness t and mean radius R, and a foundation with pressure k per
// displacement [Hetenyi1946]. Most of a local push has shorter waves, so one l is enough.

#include <pliant/models/catheter.h>

#include <algorithm>
#include <cmath>

#include "vessel/wall.h"

namespace pliant {
namespace {

/// A user's wall may lack the volume.
double lumen_mm3_of(const VesselWall& wall) {
    return wall.lumen_mm3 > 0 ? wall.lumen_mm3 : vessel::enclosed_with_lids_mm3(wall.ghost);
}

}  // namespace

double wide_reach_mm(const VesselWall& wall, const WallTissue& tissue) {
    constexpr double kMost = 1000;
    if (tissue.model == WallModel::Rigid) return 0;
    if (tissue.model == WallModel::Distances) return kMost;
    double area = 0, tissue_mm3 = 0;
    for (const auto& t : wall.ghost.cells) {
        const auto p = [&](int n) { return wall.ghost.nodes_mm[std::size_t(t[std::size_t(n)])]; };
        area += 0.5 * norm(cross(p(1) - p(0), p(2) - p(0)));
    }
    for (const auto& t : wall.mesh.cells) {
        const auto p = [&](std::size_t n) { return wall.mesh.nodes_mm[std::size_t(t[n])]; };
        tissue_mm3 += std::abs(dot(cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0))) / 6;
    }
    const double inner = 2 * lumen_mm3_of(wall) / area;
    if (!(inner > 0 && tissue.support_pa_per_mm > 0)) return kMost;
    const double thickness = inner * (std::sqrt(1 + 2 * tissue_mm3 / (area * inner)) - 1);
    const double radius = inner + 0.5 * thickness;
    const double fourth =
        4 * tissue.young_modulus_pa * thickness * radius * radius / tissue.support_pa_per_mm;
    return std::min(kMost, std::sqrt(std::sqrt(fourth)));
}

}  // namespace pliant
