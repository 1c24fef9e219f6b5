// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "lit_view.h"

#include <algorithm>
#include <cmath>

namespace pliant::results {

Rgb8 mixed(Rgb8 a, Rgb8 b, double t) {
    const auto channel = [&](std::uint8_t from, std::uint8_t to) {
        return std::uint8_t(std::lround(from + t * (to - from)));
    };
    return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

Image lit_view(const RayCaster& caster, const Endoscope& camera, int width, int height,
               Vec3d towards_lamp, double gain, const SurfaceColour& colour) {
    constexpr double kAmbient = 0.2;
    const Vec3d lamp = normalized(towards_lamp);
    Image image{width, height,
                std::vector<Rgb8>(std::size_t(width) * std::size_t(height), kBackdrop)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto hit = caster.pick(camera, width, height, x + 0.5, y + 0.5);
            if (!hit) continue;
            const double light = std::clamp(
                kAmbient + gain * (1 - kAmbient) * std::max(dot(hit->normal, lamp), 0.0), 0.0, 1.0);
            image.pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)] =
                mixed({0, 0, 0}, colour ? colour(*hit, x, y) : kSkin, light);
        }
    return image;
}

}  // namespace pliant::results
