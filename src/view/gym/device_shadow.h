// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Projection of a catheter on the detector of a fluoroscopy, and its shadow there.

#pragma once

#include <pliant/render.h>

#include <limits>
#include <span>
#include <vector>

namespace pliant::gym {

/// Position in the plane through the middle of the picture [mm], and the magnification there.
struct Projected {
    double right_mm, up_mm;
    double scale;  ///< of lengths across the ray; 0: not in front of the source
};

/// The part of a wire that is nearest to a pixel.
struct NearWire {
    float distance_mm = std::numeric_limits<float>::infinity();  ///< from the axis
    float right = 0, up = 0;  ///< unit vector across the wire, absolute values
    float scale = 0;          ///< magnification
};

/// All rays of a fluoroscopy.
class XRay {
  public:
    XRay(const Fluoroscopy& view, int width, int height);
    Projected project(Vec3d point_mm) const;

    /// Adds the absorption of a wire to the water lengths of a picture.
    /// @param wire     nodes along its axis [mm, LPS]
    /// @param nearest  scratch
    /// @param[out] water_mm  one for each pixel
    void add_wire(std::span<const Vec3d> wire, double radius_mm, double water_of_mm,
                  std::vector<NearWire>& nearest, std::span<float> water_mm) const;

  private:
    Fluoroscopy m_view;
    int m_width, m_height;
    Vec3d m_eye, m_right, m_up, m_ahead;
};

}  // namespace pliant::gym
