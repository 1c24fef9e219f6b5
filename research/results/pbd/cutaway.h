// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A vessel cut open along a plane, with a catheter in it, seen perpendicularly to the plane:
//
//     ▒▒▒▒▒▒▒▒▒▒▒▒▒▒  cut through the tetrahedra, in separate colours
//     ░░░░░░░░░░░░░░  inner surface behind the plane, lit
//     ══════════●     catheter
//     ▒▒▒▒▒▒▒▒▒▒▒▒▒▒
//
// with both axes in mm and a scale bar. Parallel projection, a depth buffer, nine samples per
// pixel.

#pragma once

#include <pliant/mesh.h>

#include <array>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "plot.h"

namespace pliant::results {

struct Camera {
    int right = 0, up = 2;  ///< horizontal and vertical axes of the picture
    Point2 low, high;       ///< visible rectangle [mm], lower left and upper right
    double px_per_mm = 5;
    double cut_mm = 0;  ///< position of the plane on the third axis; nearer parts are removed
    double tick_mm = 10;
    double bar_mm = 10;  ///< length of the scale bar
};

/// A value at each corner of each tetrahedron.
using CornerValues = std::vector<std::array<double, 4>>;
/// Displacements from rest [mm].
CornerValues displacements_of(const TetMesh& mesh, std::span<const Vec3d> positions);
/// Distances of the nodes between two states [mm].
CornerValues distances_of(const TetMesh& mesh, std::span<const Vec3d> a, std::span<const Vec3d> b);
/// Relative changes of volume, the same at all corners.
CornerValues volume_changes_of(const TetMesh& mesh, std::span<const Vec3d> positions);

using Colouring = std::function<Rgb8(double)>;
/// Tissue that is held.
inline constexpr Rgb8 kHeld{196, 192, 184};
/// shade_of, dark at `largest`; kHeld for NaN.
Colouring shaded_to(double largest);
/// Red: smaller; blue: larger; saturated at `largest`.
Colouring signed_to(double largest);
/// The colours of signed_to with the ends of their scale.
/// @param full  value of the full colours. @param name  with its unit
/// @param largest  of the picture's values, without sign: beyond `full`, the ends are marked
Image signed_bar(double full, int decimals, std::string_view name, double largest = 0);

class Cutaway {
  public:
    explicit Cutaway(const Camera& camera);

    /// Draws the half of a wall behind the plane, and its cut.
    void wall(const TetMesh& mesh, std::span<const Vec3d> positions, const CornerValues& values,
              const Colouring& colouring);
    /// A wire of round sections.
    void wire(std::span<const Vec3d> positions, double radius_mm, Rgb8 colour);
    /// Draws a whole body of tetrahedra, with the edges of its surface.
    void body(const TetMesh& mesh, Rgb8 colour);
    /// Draws the edge of a wall's cut as a red line, for example at rest.
    void outline(const TetMesh& mesh, std::span<const Vec3d> positions);
    /// With axes. @param title  a line above it
    Image image(std::string_view title) const;

  private:
    struct Corner {
        double x, y, depth;  ///< [samples], [mm] towards the eye
        double value;
    };
    using Shade = std::function<Rgb8(double value, double edge_px)>;
    Corner corner_of(Vec3d p, double value) const;
    void triangle(const std::array<Corner, 3>& t, const Shade& shade);
    void put(int x, int y, double depth, Rgb8 colour);
    double light_on(Vec3d normal) const;
    bool is_seen(Point2 p) const;
    /// Positive in front of the plane [mm].
    double before_cut(Vec3d p) const;
    std::vector<std::array<Point2, 2>> cut_edge(const TetMesh& mesh,
                                                std::span<const Vec3d> positions) const;

    Camera m_camera;
    Vec3d m_right, m_up, m_toward;
    double m_cut;
    int m_width, m_height;  ///< [samples]
    std::vector<Rgb8> m_colours;
    std::vector<double> m_depths;
    std::vector<std::array<Point2, 2>> m_edges;    ///< of cuts [mm], drawn on top
    std::vector<std::array<Point2, 2>> m_outline;  ///< [mm]
};

}  // namespace pliant::results
