// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Planes of the lattice as pictures and as numbers: elements and links, the deformed scan below
// them, contours of equal displacement, and the deviation of a contour from a circle.
//
// The elements of a plane share one index. Its picture has one lattice axis to the right and
// another downwards, in millimetres along the lattice's axes from element (0,0,0).

#pragma once

#include <pliant/chainmail.h>

#include <vector>

#include "plot.h"

namespace pliant::results {

struct Slice {
    int across = 0;  ///< lattice axis to the right
    int down = 1;    ///< lattice axis downwards
    int index = 0;   ///< along the third axis
    int third() const { return 3 - across - down; }
    Vec3i element(int a, int d) const;
};

/// Half-open ranges of elements in a slice.
struct Window {
    int across_begin, across_end, down_begin, down_end;
};
Window window_around(const Slice& slice, const Grid& grid, Vec3d centre_ijk, double half_mm);

struct LatticeStyle {
    double largest_mm = 1;  ///< displacement of the darkest colour
    double link_px = 1;
    double dot_px = 1.6;         ///< radius; 0: none
    double threshold_hu = -500;  ///< smaller elements are not drawn
    int every = 1;               ///< draws one of so many grid lines
};
/// Draws elements and links of a slice in their current positions, coloured by displacement.
void draw_lattice(Plot& plot, const ChainMail& tissue, const Slice& slice, const Window& window,
                  const LatticeStyle& style);

/// Draws grey values of a scan in a slice.
void draw_values(Plot& plot, const Volume& volume, const Slice& slice, double window_hu,
                 double level_hu);

/// One number per element of a window, a fastest.
struct PlaneField {
    Slice slice;
    Window window;
    Vec3d spacing_mm;
    std::vector<double> values;
    double at(int a, int d) const;
    /// Bilinear interpolation. @param p_mm  along the lattice's axes; zero outside of the window
    double sample(Point2 p_mm) const;
};
/// Component of the displacement along a unit vector [LPS].
PlaneField displacement_along(const ChainMail& tissue, const Slice& slice, const Window& window,
                              Vec3d direction);
/// Values of a scan at the elements of a window.
PlaneField values_in(const Volume& volume, const Slice& slice, const Window& window);
void draw_contour(Plot& plot, const PlaneField& field, double level, const Ink& ink);

/// A closed contour around a point, by its radius at equally spaced angles.
struct Contour {
    std::vector<double> radii_mm;
    double mean_mm = 0;
    /// (largest − smallest radius) / mean radius: 0 for a circle, 0.37 for a square.
    double deviation = 0;
};
/// First position along each ray from the centre at which the field falls to a level.
Contour contour_around(const PlaneField& field, Point2 centre_mm, double level, int rays = 360);

}  // namespace pliant::results
