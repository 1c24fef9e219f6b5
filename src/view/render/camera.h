// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Ray of an endoscope's pixel.
//
// A pixel at distance r from the picture's centre (r = 1 at the middle of the upper edge) belongs
// to the ray that leaves the axis by r·(1 + k·r²)·tan(field of view / 2): barrel distortion, as in
// wide-angle lenses.

#pragma once

#include <pliant/render.h>

#include <cmath>
#include <numbers>
#include <optional>

namespace pliant::render {

/// Conventional up direction in radiology that isn't parallel to look.
inline Vec3d natural_up(Vec3d look) {
    const Vec3d superior{0, 0, 1}, anterior{0, -1, 0};
    return std::abs(look.z) < 0.9 * norm(look) ? superior : anterior;
}

struct Vec2 {
    double u, v;
};

class Camera {
  public:
    Camera(const Endoscope& e, int width, int height)
        : m_width(width), m_height(height), m_barrel(e.barrel_distortion) {
        m_forward = norm(e.look) > 0 ? normalized(e.look) : Vec3d{0, 1, 0};
        Vec3d right = cross(m_forward, e.up);
        if (!(norm(right) > 1e-9 * norm(e.up))) right = cross(m_forward, natural_up(m_forward));
        m_right = normalized(right);
        m_up = cross(m_right, m_forward);
        m_slope = std::tan(e.field_of_view_deg * std::numbers::pi / 360);
    }

    /// Unit direction of the ray through a point of the picture [pixels, from the top left corner].
    Vec3d direction(double x, double y) const {
        const Vec2 p = position(x, y);
        return through(p.u, p.v);
    }
    /// Converts a point of the picture [pixels, from the top left corner] to halves of its height,
    /// from its centre, to the right and up.
    Vec2 position(double x, double y) const {
        const double half = 0.5 * m_height;
        return {(x - 0.5 * m_width) / half, (half - y) / half};
    }
    /// Unit direction of the ray through a point in these units.
    Vec3d through(double u, double v) const {
        const double scale = m_slope * (1 + m_barrel * (u * u + v * v));
        return normalized(m_forward + scale * u * m_right + scale * v * m_up);
    }

    /// Position in the picture [pixels] of a point, given from the eye: the inverse of direction().
    std::optional<PicturePoint> project(Vec3d from_eye) const {
        constexpr int kMaxSteps = 60;
        const double ahead = dot(from_eye, m_forward);
        if (!(ahead > 0)) return std::nullopt;
        const double scale = 1 / (ahead * m_slope);
        const double u = scale * dot(from_eye, m_right), v = scale * dot(from_eye, m_up);
        const double bent = std::sqrt(u * u + v * v);
        double r = bent;  // r·(1 + k·r²) = bent, convex for k > 0: Newton's steps don't overshoot
        for (int step = 0; step < kMaxSteps; ++step) {
            const double slope = 1 + 3 * m_barrel * r * r;
            if (!(slope > 0)) return std::nullopt;
            const double move = (bent - r * (1 + m_barrel * r * r)) / slope;
            r += move;
            if (std::abs(move) <= 1e-7 * r) break;  // the next one is about its square
        }
        if (!(1 + 3 * m_barrel * r * r > 0) ||
            !(std::abs(r * (1 + m_barrel * r * r) - bent) <= 1e-9 * (1 + bent)))
            return std::nullopt;
        const double straight = bent > 0 ? r / bent : 1, half = 0.5 * m_height;
        return PicturePoint{0.5 * m_width + half * straight * u, half - half * straight * v};
    }

    double aspect() const { return double(m_width) / m_height; }  ///< width / height
    Vec3d forward() const { return m_forward; }
    Vec3d right() const { return m_right; }
    Vec3d up() const { return m_up; }

  private:
    int m_width, m_height;
    double m_barrel, m_slope;
    Vec3d m_forward, m_right, m_up;
};

}  // namespace pliant::render
