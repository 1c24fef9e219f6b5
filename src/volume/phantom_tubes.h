// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Trees of tubes: airways with their rings, and vessels.
//
// A tube is a row of points with radii. An airway's tube has more to it:
//
//        ┌ membrane, flat, with folds along it        ring_mm ┌──┐
//      ──┴──                                        ──╮   ╭───╮   ╭──   wall
//     (     )  cartilage: a horseshoe, open           ╰───╯   ╰───╯     lumen
//      ╲___╱   towards `back`                          rings stand out into the lumen

#pragma once

#include "volume/phantom_shapes.h"

#include <vector>

namespace pliant::phantom {

struct TubePoint {
    Vec3d x;           ///< [mm]
    double radius_mm;  ///< of the lumen
};

struct Tube {
    std::vector<TubePoint> points;
    Vec3d back{0, 1, 0};  ///< side of the membranous wall
    double ring_mm = 0;   ///< from ring to ring; 0: smooth
    double ring_depth_mm = 0;
    double flatness = 0;  ///< how much of the radius the membrane takes away
    double wall_mm = 1;
};

/// Where a point is with respect to the nearest tube.
struct TubePlace {
    double lumen_mm = 1e9;   ///< signed distance to the lumen with rings, membrane and folds
    double smooth_mm = 1e9;  ///< the same without the rings and folds
    double outer_mm = 1e9;   ///< to the outside of the wall
    double ring = 0;         ///< −1 between two rings … 1 on a ring
    double back = 0;         ///< cosine to the membrane's side
};

class TubeTree {
  public:
    /// @param fillet_mm  where tubes branch
    TubeTree(std::vector<Tube> tubes, double fillet_mm);

    TubePlace find(Vec3d p) const;
    double lumen(Vec3d p) const { return find(p).lumen_mm; }
    double outer(Vec3d p) const { return find(p).outer_mm; }

  private:
    std::vector<Tube> m_tubes;
    std::vector<std::vector<double>> m_starts;  ///< [mm] along the tube, of each of its points
    double m_fillet_mm;
};

/// Points on a smooth curve through the given ones, pieces per span.
std::vector<TubePoint> smooth_row(const std::vector<TubePoint>& row, int pieces);

/// Distance to a row of capsules.
Field row_of_capsules(std::vector<TubePoint> row);

}  // namespace pliant::phantom
