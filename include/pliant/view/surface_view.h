// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of surfaces of triangles from outside, in parallel projection, and outlines of tools in
// pictures of scans:
//
//     ┌───────────────────────┐
//     │      ░░░▒▒░░░         │   surfaces, some translucent, with colours for values
//     │    ░░────────●  wire  │
//     │      ░░░░░░░░         │
//     │ ├──┤ 10 mm   ▒▒▒▒ mm  │   scale bar, scale of the colours
//     └───────────────────────┘

#pragma once

#include <pliant/render.h>

#include <array>
#include <span>
#include <string>

#pragma GCC visibility push(default)
namespace pliant {

/// Spans must outlive the call.
struct DrawnSurface {
    std::span<const Vec3d> nodes_mm;  ///< LPS
    std::span<const std::array<std::int32_t, 3>> triangles;
    /// A value for each node, which has the colours of SurfaceView's scale; empty: `colour`.
    std::span<const double> values{};
    Rgb8 colour{222, 150, 134};
    double opacity = 1;  ///< 0…1, of one layer; below 1 parts behind it remain visible
};

/// An opaque wire of round sections.
struct DrawnWire {
    std::span<const Vec3d> points_mm;  ///< LPS
    double radius_mm = 1;
    Rgb8 colour{240, 190, 70};
};

struct SurfaceView {
    Vec3d look{0, 0, 0};    ///< LPS; zero: along the axis of the smallest extent
    Vec3d up{0, 0, 0};      ///< LPS; zero or parallel to look: superior or anterior
    double full = 1;        ///< value of the last colour, > 0; larger values have it too
    std::string scale{};    ///< name of the values, with its unit; empty: no scale is drawn
    std::string caption{};  ///< in the upper left corner; may be empty
};

/// Draws all of the surfaces and wires, as large as they fit, with a bar of a round length.
/// Triangles that name a node that doesn't exist, and positions that aren't finite, are left out.
Image surface_view(std::span<const DrawnSurface> surfaces, std::span<const DrawnWire> wires,
                   const SurfaceView& view, int width, int height);

/// Draws the outline of a spherical tool into a picture of four_up_view: its circles in the
/// sections that it reaches, and its silhouette in the endoscope's view, also through tissue.
/// @param[in,out] picture  of four_up_view with this volume and these settings
/// @param radius_mm  0 for a point: a small circle in the sections within a millimetre
void outline_tool(Image& picture, const Volume& volume, const FourUp& settings, Vec3d centre_mm,
                  double radius_mm);

}  // namespace pliant
#pragma GCC visibility pop
