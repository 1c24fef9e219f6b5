// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/section.h"

#include <cmath>
#include <limits>

#include "render/volume_or_air.h"
#include "render/voxel_field.h"

namespace pliant {
namespace render {
namespace {

struct Bounds {
    Vec3d low, high;
};

/// Bounds of the whole volume, to the outer faces of its voxels.
Bounds world_bounds(const Grid& grid) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Bounds b{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
    for (int corner = 0; corner < 8; ++corner) {
        const auto position = [&](int axis) {
            return corner >> axis & 1 ? grid.size[axis] - 0.5 : -0.5;
        };
        const Vec3d p = world_from_voxel(grid, {position(0), position(1), position(2)});
        for (int a = 0; a < 3; ++a) {
            b.low[a] = std::min(b.low[a], p[a]);
            b.high[a] = std::max(b.high[a], p[a]);
        }
    }
    return b;
}

/// Whether a position is in a voxel, up to the outer faces.
bool holds(const Grid& grid, Vec3d ijk) {
    for (int a = 0; a < 3; ++a)
        if (!(ijk[a] >= -0.5 && ijk[a] <= grid.size[a] - 0.5)) return false;
    return true;
}

Rgb8 grey(double value_hu, const Section& section) {
    const double bottom = section.level_hu - 0.5 * section.window_hu;
    const double share = (value_hu - bottom) / std::max(section.window_hu, 1e-6);
    // NaN is black.
    const auto g = std::uint8_t((share > 0 ? std::min(share, 1.0) : 0.0) * 255 + 0.5);
    return {g, g, g};
}

void draw_crosshair(Image& image, Pixel at, const SectionStyle& style) {
    constexpr double kOpacity = 0.75;
    const int gap = std::max(4, std::min(image.width, image.height) / 32);
    for (int x = 0; x < image.width; ++x)
        if (std::abs(x - at.x) > gap) blend(image, {x, at.y}, style.horizontal, kOpacity);
    for (int y = 0; y < image.height; ++y)
        if (std::abs(y - at.y) > gap) blend(image, {at.x, y}, style.vertical, kOpacity);
}

void draw_letters(Image& image, const SectionStyle& style) {
    constexpr Rgb8 kInk{235, 235, 235};
    const int scale = text_scale(image.height);
    const int margin = 3 * scale, wide = 5 * scale, high = kGlyphHeight * scale;
    const int cx = (image.width - wide) / 2, cy = (image.height - high) / 2;
    const std::string_view letters = style.letters;
    draw_text(image, {margin, cy}, letters.substr(0, 1), kInk, scale);
    draw_text(image, {image.width - margin - wide, cy}, letters.substr(1, 1), kInk, scale);
    draw_text(image, {cx, margin}, letters.substr(2, 1), kInk, scale);
    draw_text(image, {cx, image.height - margin - high}, letters.substr(3, 1), kInk, scale);
}

}  // namespace

SectionStyle section_style(Orientation orientation) {
    const Vec3d left{1, 0, 0}, posterior{0, 1, 0}, superior{0, 0, 1};
    switch (orientation) {
        case Orientation::Coronal:
            return {left, superior,       "coronal",    "RLSI",
                    'y',  kCoronalColour, kAxialColour, kSagittalColour};
        case Orientation::Sagittal:
            return {posterior, superior,        "sagittal",   "APSI",
                    'x',       kSagittalColour, kAxialColour, kCoronalColour};
        case Orientation::Axial:
            break;
    }
    return {left, -posterior, "axial", "RLAP", 'z', kAxialColour, kCoronalColour, kSagittalColour};
}

SectionPlane::SectionPlane(const Grid& grid, const Section& section, int width, int height)
    : m_half_width(0.5 * width), m_half_height(0.5 * height) {
    const SectionStyle style = section_style(section.orientation);
    m_right = style.right;
    m_up = style.up;
    m_centre_mm = section.point_mm;
    m_mm_per_pixel = section.width_mm / width;
    if (section.width_mm > 0) return;
    const Bounds bounds = world_bounds(grid);
    const Vec3d extent = bounds.high - bounds.low;
    const Vec3d middle = 0.5 * (bounds.low + bounds.high);
    m_mm_per_pixel =
        std::max(std::abs(dot(extent, m_right)) / width, std::abs(dot(extent, m_up)) / height);
    const Vec3d shift = middle - section.point_mm;
    m_centre_mm = section.point_mm + dot(shift, m_right) * m_right + dot(shift, m_up) * m_up;
}

Vec3d SectionPlane::world_from_picture(double x, double y) const {
    return m_centre_mm + (x - m_half_width) * m_mm_per_pixel * m_right +
           (m_half_height - y) * m_mm_per_pixel * m_up;
}

Pixel SectionPlane::pixel_of(Vec3d point_mm) const {
    const Vec3d v = point_mm - m_centre_mm;
    const auto whole = [](double p) {
        constexpr double kFar = 1e8;
        return int(std::floor(std::clamp(p, -kFar, kFar)));
    };
    return {whole(m_half_width + dot(v, m_right) / m_mm_per_pixel),
            whole(m_half_height - dot(v, m_up) / m_mm_per_pixel)};
}

int text_scale(int height) {
    return std::max(1, height / 170);
}

}  // namespace render

Image section_view(const Volume& scan, const Section& section, int width, int height,
                   const TaskArena& arena) {
    const Volume& volume = render::volume_or_air(scan);
    Image image = render::make_image(width, height, {0, 0, 0});
    const render::SectionPlane plane(volume.grid, section, image.width, image.height);
    const auto pixel_voxel = [&](double x, double y) {
        return voxel_from_world(volume.grid, plane.world_from_picture(x, y));
    };
    const Vec3d first = pixel_voxel(0.5, 0.5);
    const Vec3d across = pixel_voxel(1.5, 0.5) - first, down = pixel_voxel(0.5, 1.5) - first;
    render::with_field(volume, [&](const auto& field) {
        arena.for_each(image.height, 16, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t y = begin; y < end; ++y)
                for (int x = 0; x < image.width; ++x) {
                    const Vec3d ijk = first + double(x) * across + double(y) * down;
                    if (render::holds(volume.grid, ijk))
                        image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)] =
                            render::grey(field.sample(ijk), section);
                }
        });
    });
    const render::SectionStyle style = render::section_style(section.orientation);
    if (section.crosshair) render::draw_crosshair(image, plane.pixel_of(section.point_mm), style);
    render::draw_letters(image, style);
    return image;
}

}  // namespace pliant
