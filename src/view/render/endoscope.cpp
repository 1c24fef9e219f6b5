// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The endoscope's picture, tile by tile, in beams of rays. First one ray per pixel, then four for
// each pixel at an edge, where its colour or depth differs from a neighbour's. In the style Plain
// the light is at the lens: surfaces facing the camera are bright, wet tissue has highlights, light
// falls off with the distance and fades into the fog. The style Real is RealLook's.

#include "render/camera.h"
#include "render/canvas.h"
#include "render/colour.h"
#include "render/real_look.h"
#include "render/volume_rays.h"

namespace pliant {
namespace {

constexpr int kTile = 16;             // pixels: rays of a tile meet the same bricks
constexpr double kLightReachMm = 40;  // distance at which light is halved, without fog
constexpr double kAmbient = 0.10;     // ambient light
constexpr double kSheen = 0.10;       // broad and narrow highlight of wet tissue
constexpr double kGlint = 0.22;
constexpr double kDepth = 0.6;         // how much redder dim tissue is
constexpr double kColourEdge = 0.035;  // difference of linear light that triggers supersampling
constexpr double kDepthEdge = 0.04;    // relative difference of the depth that triggers it

struct Sample {
    Vec3f light;     ///< linear
    float depth_mm;  ///< infinite: no hit
};

using Point = PicturePoint;
using render::LookHit;
using render::Pixel;

class Painter {
  public:
    Painter(const render::VolumeRays& caster, const Endoscope& endoscope, int width, int height)
        : m_caster(caster),
          m_rays(caster, endoscope.eye_mm, endoscope.iso_hu, endoscope.polarity),
          m_endoscope(endoscope),
          m_camera(endoscope, width, height),
          m_surface(render::linear_from_srgb(endoscope.surface)),
          m_fog(render::linear_from_srgb(endoscope.fog)) {
        const double brightest = std::max({m_surface.x, m_surface.y, m_surface.z, 1e-6});
        for (int c = 0; c < 3; ++c) m_deep[c] = m_surface[c] * m_surface[c] / brightest;
        if (endoscope.style == Style::Real) m_real.emplace(caster, m_rays, endoscope, m_camera);
    }

    /// Light at points of the picture [pixels] in an order of neighbours.
    void look(std::span<const Point> points, std::vector<Vec3f>& light) const {
        std::vector<Vec3d> directions;
        std::vector<double> distances;
        cast(points, directions, distances);
        std::vector<LookHit> hits = find_hits(directions, distances);
        m_caster.normals(hits, m_endoscope.polarity);
        std::vector<Vec3d> shaded;
        shade(hits, shaded);
        light.clear();
        std::size_t next = 0;
        for (std::size_t n = 0; n < points.size(); ++n)
            light.push_back(std::isinf(distances[n]) ? nothing()
                                                     : dimmed(shaded[next++], points[n]));
    }

    /// Rays through points of the picture. @param[out] distances  infinite: no hit
    void cast(std::span<const Point> points, std::vector<Vec3d>& directions,
              std::vector<double>& distances) const {
        directions.clear();
        for (const Point& p : points)  // outside of the field stop: no direction, so no hit
            directions.push_back(field(p) > 0 ? m_camera.direction(p.x, p.y) : Vec3d{0, 0, 0});
        distances.resize(points.size());
        m_rays.hit_distances(directions, distances.data());
    }

    /// Hits of rays, without normals.
    std::vector<LookHit> find_hits(std::span<const Vec3d> directions,
                                   std::span<const double> distances) const {
        std::vector<LookHit> hits;
        for (std::size_t n = 0; n < distances.size(); ++n) {
            const double t = distances[n];
            if (!std::isinf(t))
                hits.push_back({t, m_endoscope.eye_mm + t * directions[n], {}, directions[n]});
        }
        return hits;
    }
    void shade(std::span<const LookHit> hits, std::vector<Vec3d>& light) const {
        light.resize(hits.size());
        if (m_real) return m_real->shade(hits, light.data());
        for (std::size_t n = 0; n < hits.size(); ++n) light[n] = shade(hits[n]);
    }
    /// Light of a ray without a hit.
    Vec3f nothing() const { return to_float(m_real ? Vec3d{0, 0, 0} : m_fog); }
    /// Light at a point of the picture after the field stop.
    Vec3f dimmed(Vec3d light, Point p) const { return to_float(m_real ? field(p) * light : light); }
    /// A vector in the camera's axes: right, down, ahead.
    Vec3f in_camera(Vec3d v) const {
        return to_float(
            {dot(v, m_camera.right()), -dot(v, m_camera.up()), dot(v, m_camera.forward())});
    }
    const render::Camera& camera() const { return m_camera; }
    const render::VolumeRays& rays() const { return m_caster; }

  private:
    double field(Point p) const {
        if (!m_real) return 1;
        const render::Vec2 position = m_camera.position(p.x, p.y);
        return m_real->field(position.u, position.v);
    }

    static Vec3f to_float(Vec3d v) { return {float(v.x), float(v.y), float(v.z)}; }

    /// Ambient occlusion, 0…1: tissue a few millimetres off the surface blocks light.
    double openness(Vec3d point, Vec3d normal) const {
        constexpr double kStepsMm[] = {1.0, 2.0, 4.0};
        constexpr double kSoftnessHu = 400;
        const double sign = m_endoscope.polarity == Polarity::Rising ? 1 : -1;
        double closed = 0;
        for (double step : kStepsMm) {
            const double value = m_caster.sample(point + step * normal);
            const double excess = sign * (value - m_endoscope.iso_hu) / kSoftnessHu + 0.5;
            closed += std::clamp(excess, 0.0, 1.0);
        }
        return 1 - closed / 3;
    }

    Vec3d shade(const LookHit& hit) const {
        const double facing = std::max(0.0, -dot(hit.normal, hit.direction));
        const double reach = hit.t / kLightReachMm;
        const double falloff = 1 / (1 + reach * reach);
        const double open = 0.4 + 0.6 * openness(hit.point_mm, hit.normal);
        const double diffuse = falloff * open * ((1 - kAmbient) * facing + kAmbient);
        const double f4 = facing * facing * facing * facing;
        const double f16 = f4 * f4 * f4 * f4;
        const double shine = falloff * (kSheen * f16 + kGlint * f16 * f16 * f16 * f16 * f16);
        const double own = 1 - kDepth * (1 - diffuse);  // the rest is transmitted
        const Vec3d light =
            diffuse * (own * m_surface + (1 - own) * m_deep) + shine * Vec3d{1, 0.97, 0.95};
        const double clear =
            m_endoscope.fog_distance_mm > 0 ? std::exp(-hit.t / m_endoscope.fog_distance_mm) : 1;
        return clear * light + (1 - clear) * m_fog;
    }

    const render::VolumeRays& m_caster;
    render::EyeRays m_rays;
    const Endoscope& m_endoscope;
    render::Camera m_camera;
    Vec3d m_surface, m_fog;
    std::optional<render::RealLook> m_real;
    Vec3d m_deep;  // colour of light transmitted through tissue, more saturated
};

/// Position of pixel n in a tile: blocks of 8 × 8 pixels with blocks of 4 × 4.
Pixel tile_pixel(int n) {
    return {(n >> 6 & 1) * 8 + (n >> 4 & 1) * 4 + (n & 3),
            (n >> 7 & 1) * 8 + (n >> 5 & 1) * 4 + (n >> 2 & 3)};
}

/// Calls body(pixels) for all tiles, each with its pixels inside the picture.
template <class Body>
void for_each_tile(int width, int height, const TaskArena& arena, const Body& body) {
    const int across = (width + kTile - 1) / kTile, down = (height + kTile - 1) / kTile;
    arena.for_each(std::int64_t(across) * down, 4, [&](std::int64_t begin, std::int64_t end) {
        std::vector<Pixel> pixels;
        for (std::int64_t tile = begin; tile < end; ++tile) {
            const int x0 = int(tile % across) * kTile, y0 = int(tile / across) * kTile;
            pixels.clear();
            for (int n = 0; n < kTile * kTile; ++n) {
                const Pixel inside = tile_pixel(n), p{x0 + inside.x, y0 + inside.y};
                if (p.x < width && p.y < height) pixels.push_back(p);
            }
            body(pixels);
        }
    });
}

bool differ(const Sample& a, const Sample& b) {
    if (std::isinf(a.depth_mm) != std::isinf(b.depth_mm)) return true;
    if (std::isinf(a.depth_mm)) return false;
    const double edge = kDepthEdge * double(std::min(a.depth_mm, b.depth_mm));
    if (std::abs(double(a.depth_mm) - double(b.depth_mm)) > edge) return true;
    const Vec3f d = a.light - b.light;
    return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) > float(kColourEdge);
}

bool at_edge(const std::vector<Sample>& samples, int x, int y, int width, int height) {
    const auto at = [&](int i, int j) -> const Sample& {
        return samples[std::size_t(j) * std::size_t(width) + std::size_t(i)];
    };
    const Sample& here = at(x, y);
    return (x > 0 && differ(here, at(x - 1, y))) || (x + 1 < width && differ(here, at(x + 1, y))) ||
           (y > 0 && differ(here, at(x, y - 1))) || (y + 1 < height && differ(here, at(x, y + 1)));
}

}  // namespace

void RayCaster::endoscope_frame(const Endoscope& endoscope, int width, int height,
                                const EndoscopeFrame& frame) const {
    width = std::max(width, 1);
    height = std::max(height, 1);
    const Painter painter(m_impl->rays, endoscope, width, height);
    const bool has_colour = !frame.colour.empty();
    const bool is_smooth = has_colour && frame.is_smooth;
    const std::size_t count = std::size_t(width) * std::size_t(height);
    std::vector<Sample> samples(is_smooth ? count : 0);
    const auto index = [&](Pixel p) {
        return std::size_t(p.y) * std::size_t(width) + std::size_t(p.x);
    };
    const auto colour_of = [](Vec3f light) {
        return render::srgb_from_linear(Vec3d{double(light.x), double(light.y), double(light.z)});
    };
    for_each_tile(width, height, m_impl->rays.arena, [&](const std::vector<Pixel>& pixels) {
        std::vector<Point> points;
        std::vector<Vec3d> directions;
        std::vector<double> distances;
        for (const Pixel& p : pixels) points.push_back({p.x + 0.5, p.y + 0.5});
        painter.cast(points, directions, distances);
        std::vector<LookHit> hits = painter.find_hits(directions, distances);
        if (has_colour || !frame.normals.empty()) painter.rays().normals(hits, endoscope.polarity);
        std::vector<Vec3d> light;
        if (has_colour) painter.shade(hits, light);
        std::size_t next = 0;
        for (std::size_t n = 0; n < pixels.size(); ++n) {
            const std::size_t at = index(pixels[n]);
            const LookHit* const hit = std::isinf(distances[n]) ? nullptr : &hits[next];
            if (!frame.depth_mm.empty())
                frame.depth_mm[at] =
                    hit ? float(hit->t * dot(hit->direction, painter.camera().forward())) : 0;
            if (!frame.normals.empty())
                frame.normals[at] = hit ? painter.in_camera(hit->normal) : Vec3f{0, 0, 0};
            if (!frame.points_mm.empty()) {
                constexpr double kNowhere = std::numeric_limits<double>::infinity();
                frame.points_mm[at] = hit ? hit->point_mm : Vec3d{kNowhere, kNowhere, kNowhere};
            }
            if (has_colour) {
                const Vec3f seen = hit ? painter.dimmed(light[next], points[n]) : painter.nothing();
                if (is_smooth)
                    samples[at] = {seen, float(distances[n])};
                else
                    frame.colour[at] = colour_of(seen);
            }
            if (hit) ++next;
        }
    });
    if (!is_smooth) return;
    for_each_tile(width, height, m_impl->rays.arena, [&](const std::vector<Pixel>& pixels) {
        std::vector<Point> points;
        std::vector<Vec3f> seen;
        const auto is_edge = [&](Pixel p) { return at_edge(samples, p.x, p.y, width, height); };
        for (const Pixel& p : pixels)
            for (int part = 0; part < 4 && is_edge(p); ++part)
                points.push_back({p.x + 0.25 + 0.5 * (part & 1), p.y + 0.25 + 0.5 * (part >> 1)});
        painter.look(points, seen);
        std::size_t next = 0;
        for (const Pixel& p : pixels) {
            Vec3f light = samples[index(p)].light;
            if (is_edge(p)) {
                light = {0, 0, 0};
                for (int part = 0; part < 4; ++part) light = light + seen[next++];
                light = 0.25f * light;
            }
            frame.colour[index(p)] = colour_of(light);
        }
    });
}

Image RayCaster::endoscope_view(const Endoscope& endoscope, int width, int height) const {
    width = std::max(width, 1);
    height = std::max(height, 1);
    Image image{width, height, std::vector<Rgb8>(std::size_t(width) * std::size_t(height))};
    endoscope_frame(endoscope, width, height, {.colour = image.pixels});
    return image;
}

std::optional<PicturePoint> project(const Endoscope& endoscope, int width, int height,
                                    Vec3d point_mm) {
    const render::Camera camera(endoscope, std::max(width, 1), std::max(height, 1));
    return camera.project(point_mm - endoscope.eye_mm);
}

}  // namespace pliant
