// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// World positions of a section's pixels, LPS (x to the patient's left, y to the back, z to the
// head):
//
//            picture's right   picture's up   crossed by
//   axial          L                A         coronal ─, sagittal │
//   coronal        L                S         axial ─,   sagittal │
//   sagittal       P                S         axial ─,   coronal │

#pragma once

#include <pliant/render.h>

#include "render/canvas.h"

namespace pliant::render {

/// Colours of the three sections, as in 3D Slicer.
inline constexpr Rgb8 kAxialColour{244, 80, 66};
inline constexpr Rgb8 kCoronalColour{110, 176, 75};
inline constexpr Rgb8 kSagittalColour{237, 213, 76};

struct SectionStyle {
    Vec3d right, up;      ///< of the picture, world
    const char* name;     ///< "axial", …
    const char* letters;  ///< at the left, right, upper, lower border
    char axis;            ///< world axis perpendicular to the section
    Rgb8 colour, horizontal, vertical;
};

SectionStyle section_style(Orientation orientation);

/// Conversions between pixels and the world.
class SectionPlane {
  public:
    SectionPlane(const Grid& grid, const Section& section, int width, int height);

    double mm_per_pixel() const { return m_mm_per_pixel; }
    /// World point at a position of the picture [pixels from its top left corner; centres at
    /// halves].
    Vec3d world_from_picture(double x, double y) const;
    /// Pixel of a world point's projection; may be far outside of the picture.
    Pixel pixel_of(Vec3d point_mm) const;

  private:
    Vec3d m_centre_mm, m_right, m_up;
    double m_mm_per_pixel;
    double m_half_width, m_half_height;  // pixels
};

/// Scale of the letters for a picture of this height.
int text_scale(int height);

}  // namespace pliant::render
