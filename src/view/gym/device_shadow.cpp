// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "gym/device_shadow.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/hypot.h"
#include "render/camera.h"
#include "render/detector.h"

namespace pliant::gym {
namespace {

/// ∫∫ 2 √(r² − x²) dx from −r to t, twice.
double area_twice(double t, double r) {
    if (t <= -r) return 0;
    const double whole = std::numbers::pi * r * r;
    if (t >= r) return whole * t;
    const double root = std::sqrt(r * r - t * t);
    return r * r * (t * std::asin(t / r) + root) - root * root * root / 3 + whole * t / 2;
}

/// Mean of the chords through a cylinder at a distance d from its axis, over two widths.
double mean_chord(double d, double a, double b, double r) {
    const double sum = 0.5 * (a + b), difference = 0.5 * (a - b);
    return (area_twice(d + sum, r) - area_twice(d + difference, r) - area_twice(d - difference, r) +
            area_twice(d - sum, r)) /
           (a * b);
}

double distance_to_segment(double x, double y, const Projected& a, const Projected& b) {
    const double dx = b.right_mm - a.right_mm, dy = b.up_mm - a.up_mm;
    const double px = x - a.right_mm, py = y - a.up_mm, square = dx * dx + dy * dy;
    const double along = square > 0 ? std::clamp((px * dx + py * dy) / square, 0.0, 1.0) : 0;
    return pliant::hypot(px - along * dx, py - along * dy);
}

}  // namespace

XRay::XRay(const Fluoroscopy& view, int width, int height)
    : m_view(view), m_width(width), m_height(height) {
    const Endoscope source = render::x_ray_source(view, width, height);
    const render::Camera camera(source, width, height);
    m_eye = source.eye_mm;
    m_right = camera.right();
    m_up = camera.up();
    m_ahead = camera.forward();
}

Projected XRay::project(Vec3d point_mm) const {
    const Vec3d from = point_mm - m_eye;
    const double ahead = dot(from, m_ahead);
    if (!(ahead > 1e-3 * m_view.source_mm)) return {0, 0, 0};
    const double scale = m_view.source_mm / ahead;
    return {scale * dot(from, m_right), scale * dot(from, m_up), scale};
}

void XRay::add_wire(std::span<const Vec3d> wire, double radius_mm, double water_of_mm,
                    std::vector<NearWire>& nearest, std::span<float> water_mm) const {
    const double pixel = m_view.width_mm / m_width;
    nearest.assign(water_mm.size(), {});
    for (std::size_t n = 0; n + 1 < wire.size(); ++n) {
        const Projected a = project(wire[n]), b = project(wire[n + 1]);
        if (a.scale == 0 || b.scale == 0) continue;
        const double scale = std::max(a.scale, b.scale), reach = radius_mm * scale + pixel;
        const double dx = b.right_mm - a.right_mm, dy = b.up_mm - a.up_mm;
        const double length = pliant::hypot(dx, dy);
        // Pixel (x, y) has its middle at ((x + ½ − width/2) pixel, (height/2 − y − ½) pixel).
        const auto column = [&](double mm) {
            return int(std::clamp(mm / pixel + 0.5 * m_width - 0.5, -1.0, double(m_width)));
        };
        const auto row = [&](double mm) {
            return int(std::clamp(0.5 * m_height - 0.5 - mm / pixel, -1.0, double(m_height)));
        };
        const int left = std::max(0, column(std::min(a.right_mm, b.right_mm) - reach)),
                  right =
                      std::min(m_width - 1, column(std::max(a.right_mm, b.right_mm) + reach) + 1),
                  top = std::max(0, row(std::max(a.up_mm, b.up_mm) + reach)),
                  bottom = std::min(m_height - 1, row(std::min(a.up_mm, b.up_mm) - reach) + 1);
        for (int y = top; y <= bottom; ++y)
            for (int x = left; x <= right; ++x) {
                NearWire& at = nearest[std::size_t(y) * std::size_t(m_width) + std::size_t(x)];
                const double d = distance_to_segment((x + 0.5 - 0.5 * m_width) * pixel,
                                                     (0.5 * m_height - y - 0.5) * pixel, a, b);
                if (!(d < double(at.distance_mm))) continue;
                at = {float(d), float(length > 0 ? std::abs(dy) / length : 1),
                      float(length > 0 ? std::abs(dx) / length : 0), float(scale)};
            }
    }
    for (std::size_t n = 0; n < water_mm.size(); ++n) {
        const NearWire& at = nearest[n];
        const double scale = double(at.scale);
        if (!(double(at.distance_mm) < scale * radius_mm + pixel)) continue;
        // The square of a pixel is as wide as two intervals across the wire, one after the other.
        const double least = 1e-3, across = pixel / scale;
        water_mm[n] +=
            float(water_of_mm * mean_chord(double(at.distance_mm) / scale,
                                           across * std::max(least, double(at.right)),
                                           across * std::max(least, double(at.up)), radius_mm));
    }
}

}  // namespace pliant::gym
