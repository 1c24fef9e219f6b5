// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A closed surface is stuffed as the level set of its signed distance. Cells where the boundary
// would touch itself are taken away, and small pieces that this cuts off.

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <pliant/mesh.h>

#include "base/errors.h"
#include "mesh/box_tree.h"

namespace pliant {
namespace {

constexpr double kCellsPerCube = 12;  ///< tetrahedra of the lattice in a cube
constexpr double kTooFew = 24;        ///< tetrahedra of which no organ consists

constexpr Setting<FillSettings> kRows[] = {
    setting<&FillSettings::cell_mm>({.name = "cell_mm",
                                     .unit = "mm",
                                     .range = {0, 1000},
                                     .text = "edge of the lattice's cubes; 0: so that there are "
                                             "about as many tetrahedra as wanted"}),
    setting<&FillSettings::tetrahedra>({.name = "tetrahedra",
                                        .range = {kTooFew, 10'000'000},
                                        .text = "approximate number, without cell_mm"}),
};

mesh::Bounds bounds_of(std::span<const Vec3d> nodes) {
    mesh::Bounds b;
    for (const Vec3d& p : nodes) b.add(p);
    return b;
}

Result<FilledSurface> fill(TriangleMesh surface, const FillSettings& settings,
                           const TaskArena& arena) {
    if (const Status s = check(settings, fill_rows()); !s.ok()) return s.error();
    if (const Status s = check_closed(surface); !s.ok()) return s.error();
    FilledSurface filled;
    filled.surface_mm3 = enclosed_volume_mm3(surface);
    if (filled.surface_mm3 < 0) {  // its triangles face inwards
        for (auto& t : surface.cells) std::swap(t[1], t[2]);
        filled.surface_mm3 = -filled.surface_mm3;
    }
    const mesh::Bounds bounds = bounds_of(surface.nodes_mm);
    const auto distance = SurfaceDistance::create(std::move(surface));
    if (!distance) return distance.error();
    filled.cell_mm =
        settings.cell_mm > 0
            ? settings.cell_mm
            : std::cbrt(kCellsPerCube * filled.surface_mm3 / double(settings.tetrahedra));
    const double margin = 0.01 * filled.cell_mm;
    auto mesh = stuff_isosurface([&](Vec3d x) { return -distance->signed_mm(x); },
                                 {.begin_mm = bounds.low - Vec3d{margin, margin, margin},
                                  .end_mm = bounds.high + Vec3d{margin, margin, margin},
                                  .cell_mm = filled.cell_mm,
                                  .changes_as_distance = true},
                                 arena);
    if (!mesh) return mesh.error();
    filled.mesh = std::move(*mesh);
    filled.removed_cells = make_manifold(filled.mesh);
    if (double(filled.mesh.cells.size()) < kTooFew)
        return expected_error("cell_mm", "cells that are smaller than the solid",
                              std::to_string(filled.cell_mm) + " mm, with which " +
                                  std::to_string(filled.mesh.cells.size()) +
                                  " tetrahedra are left");
    filled.dropped_pieces = drop_crumbs(filled.mesh);
    return filled;
}

}  // namespace

SettingRows<FillSettings> fill_rows() noexcept {
    return kRows;
}

Result<FilledSurface> fill_surface(TriangleMesh surface, const FillSettings& settings,
                                   const TaskArena& arena) noexcept {
    return attempt([&] { return fill(std::move(surface), settings, arena); });
}

}  // namespace pliant
