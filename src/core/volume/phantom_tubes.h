// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Trees of tubes: airways with their rings, and vessels.
//
// A tube is a row of points with radii. An airway's tube has further structure:
//
//        ┌ membrane, flat, with folds along it        ring_mm ┌──┐
//      ──┴──                                        ──╮   ╭───╮   ╭──   wall
//     (     )  cartilage: a horseshoe, open           ╰───╯   ╰───╯     lumen
//      ╲___╱   towards `back`                          rings stand out into the lumen

#pragma once

#include "volume/phantom_shapes.h"

#include <cstdint>
#include <vector>

namespace pliant::phantom {

struct TubePoint {
    Vec3d x;           ///< [mm]
    double radius_mm;  ///< of the lumen
};

struct Tube {
    std::vector<TubePoint> points;
    Vec3d back{0, 1, 0};  ///< side of the membranous wall
    double ring_mm = 0;   ///< ring spacing; 0: smooth
    double ring_depth_mm = 0;
    double flatness = 0;  ///< fraction of the radius removed by the membrane
    double wall_mm = 1;
};

/// Position relative to the nearest tube.
struct TubePosition {
    double lumen_mm = 1e9;   ///< signed distance to the lumen with rings, membrane and folds
    double smooth_mm = 1e9;  ///< the same without the rings and folds
    double outer_mm = 1e9;   ///< distance to the outside of the wall
    double ring = 0;         ///< −1 between two rings … 1 on a ring
    double back = 0;         ///< cosine to the membrane's side
};

/// A row of points with radii, in chunks with bounding spheres for fast rejection.
class TubeRow {
  public:
    /// Result for the nearest piece.
    struct Nearest {
        double distance_mm = 1e9;  ///< to the axis, less the radius
        double axis_mm = 0;        ///< to the axis
        double radius_mm = 1;
        double along_mm = 0;
        Vec3d out{0, 0, 0};   ///< from the axis to the point
        Vec3d axis{0, 0, 1};  ///< unit
    };

    /// @pre points.size() ≥ 2
    explicit TubeRow(const std::vector<TubePoint>& points);

    /// @param at_most_mm  pieces farther away may be skipped; then the result is at least this
    Nearest find(Vec3d p, double at_most_mm = 1e9) const;
    /// Fast lower bound of the distance to the nearest piece.
    double least_distance(Vec3d p) const { return sphere(p, m_centre, m_radius_mm); }

  private:
    struct Piece {
        Vec3d from, along;
        double per_square;  ///< 1 / length² [1/mm²]
        double length_mm, start_mm, radius_mm, growth_mm;
    };
    struct Chunk {
        Vec3d centre;
        double radius_mm;
        std::size_t begin, end;
    };
    std::vector<Piece> m_pieces;
    std::vector<Chunk> m_chunks;
    Vec3d m_centre{0, 0, 0};
    double m_radius_mm = 0;
};

class TubeTree {
  public:
    /// @param fillet_mm  size of fillets at branches
    TubeTree(std::vector<Tube> tubes, double fillet_mm);

    /// Distances beyond kFar_mm may be underestimated, but never overestimated or too steep. The
    /// latest results are cached, because wall, cartilage and lumen query the same points.
    TubePosition find(Vec3d p) const;
    double lumen(Vec3d p) const { return find(p).lumen_mm; }
    double outer(Vec3d p) const { return find(p).outer_mm; }

    static constexpr double kFar_mm = 8;

  private:
    TubePosition find_anew(Vec3d p) const;

    std::vector<Tube> m_tubes;
    std::vector<TubeRow> m_rows;  ///< one per tube
    double m_fillet_mm;
    std::uint64_t m_identity;  ///< unique number of the tree
};

/// Points on a smooth curve through the given points, with `pieces` pieces per span.
std::vector<TubePoint> smooth_row(const std::vector<TubePoint>& row, int pieces);

/// Distance to a row of capsules; a lower bound beyond TubeTree::kFar_mm.
ScalarField row_of_capsules(const std::vector<TubePoint>& row);

}  // namespace pliant::phantom
