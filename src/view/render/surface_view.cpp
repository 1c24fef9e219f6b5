// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Triangles in parallel projection. Opaque parts go through a depth buffer. Translucent triangles
// in front of them are then blended from the farthest to the nearest. Each pixel has nine samples.

#include <pliant/core/text.h>
#include <pliant/view/surface_view.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/hypot.h"
#include "render/camera.h"
#include "render/canvas.h"

namespace pliant {
namespace {

constexpr int kSamples = 3;  ///< along each side of a pixel
constexpr Rgb8 kSheet{28, 30, 36};
constexpr Rgb8 kWords{235, 235, 235};
constexpr double kFar = std::numeric_limits<double>::infinity();

/// Colours of values: cold at 0, warm at 1.
Rgb8 warm(double t) {
    constexpr std::array<Vec3d, 4> kStops = {
        {{150, 168, 196}, {214, 206, 150}, {240, 160, 60}, {214, 48, 36}}};
    const double at = std::clamp(t, 0.0, 1.0) * double(kStops.size() - 1);
    const auto n = std::min(std::size_t(at), kStops.size() - 2);
    const Vec3d c = kStops[n] + (at - double(n)) * (kStops[n + 1] - kStops[n]);
    return {std::uint8_t(c.x + 0.5), std::uint8_t(c.y + 0.5), std::uint8_t(c.z + 0.5)};
}

Rgb8 lit(Rgb8 colour, double light) {
    const auto byte = [&](std::uint8_t c) {
        return std::uint8_t(std::min(255.0, light * c + 0.5));
    };
    return {byte(colour.r), byte(colour.g), byte(colour.b)};
}

/// Frame of the picture: x to the right, y down [samples], depth away from the eye [mm].
struct Sheet {
    Vec3d look, right, up;
    Vec3d middle_mm;
    double scale = 1;  ///< samples a millimetre
    int width = 0, height = 0;

    Vec3d position(Vec3d p) const {
        const Vec3d v = p - middle_mm;
        return {0.5 * width + scale * dot(v, right), 0.5 * height - scale * dot(v, up),
                dot(v, look)};
    }
    /// Two-sided light from the upper left behind the eye. @param normal  any length
    double light_on(Vec3d normal) const {
        const double length = norm(normal);
        if (!(length > 0)) return 1;
        const Vec3d lamp = normalized(-1.0 * look + 0.5 * up - 0.5 * right);
        return 0.4 + 0.65 * std::abs(dot(normal, lamp)) / length;
    }
};

struct Corner {
    Vec3d at;  ///< of Sheet::position
    double value;
};

/// A triangle to be blended.
struct Layer {
    std::array<Corner, 3> corners;
    double depth, light;
    const DrawnSurface* surface;
};

class Canvas {
  public:
    Canvas(const Sheet& sheet, double full)
        : m_sheet(sheet),
          m_full(full),
          m_colours(std::size_t(sheet.width) * std::size_t(sheet.height), kSheet),
          m_depths(m_colours.size(), kFar) {}

    void draw(const Layer& layer, bool is_opaque) {
        const auto& t = layer.corners;
        const double area = (t[1].at.x - t[0].at.x) * (t[2].at.y - t[0].at.y) -
                            (t[2].at.x - t[0].at.x) * (t[1].at.y - t[0].at.y);
        if (std::abs(area) < 1e-12) return;
        const auto [left, right] = std::minmax({t[0].at.x, t[1].at.x, t[2].at.x});
        const auto [top, bottom] = std::minmax({t[0].at.y, t[1].at.y, t[2].at.y});
        for (int y = std::max(0, int(top)); y <= std::min(m_sheet.height - 1, int(bottom)); ++y)
            for (int x = std::max(0, int(left)); x <= std::min(m_sheet.width - 1, int(right));
                 ++x) {
                std::array<double, 3> w{};
                bool is_inside = true;
                for (std::size_t n = 0; n < 3 && is_inside; ++n)
                    is_inside =
                        covers(t[(n + 1) % 3].at, t[(n + 2) % 3].at, x + 0.5, y + 0.5, area, w[n]);
                if (!is_inside) continue;
                double depth = 0, value = 0;
                for (std::size_t n = 0; n < 3; ++n) {
                    depth += w[n] * t[n].at.z;
                    value += w[n] * t[n].value;
                }
                const DrawnSurface& s = *layer.surface;
                const Rgb8 colour = s.values.empty() ? s.colour : warm(value / m_full);
                put(x, y, depth, lit(colour, layer.light), is_opaque, s.opacity);
            }
    }

    void draw(const DrawnWire& wire) {
        const double radius = std::max(wire.radius_mm * m_sheet.scale, 1.0);
        for (std::size_t n = 1; n < wire.points_mm.size(); ++n) {
            const Vec3d a = m_sheet.position(wire.points_mm[n - 1]),
                        b = m_sheet.position(wire.points_mm[n]);
            if (!is_finite(a) || !is_finite(b)) continue;
            const int count = std::max(1, int(hypot(b.x - a.x, b.y - a.y) / 1.5));
            for (int k = 0; k <= count; ++k) ball(a + (double(k) / count) * (b - a), radius, wire);
        }
    }

    Image image() const {
        Image picture =
            render::make_image(m_sheet.width / kSamples, m_sheet.height / kSamples, kSheet);
        for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x) {
                int r = 0, g = 0, b = 0;
                for (int n = 0; n < kSamples * kSamples; ++n) {
                    const Rgb8 c =
                        m_colours[index(kSamples * x + n % kSamples, kSamples * y + n / kSamples)];
                    r += c.r, g += c.g, b += c.b;
                }
                constexpr int kAll = kSamples * kSamples;
                picture.pixels[std::size_t(y) * std::size_t(picture.width) + std::size_t(x)] = {
                    std::uint8_t(r / kAll), std::uint8_t(g / kAll), std::uint8_t(b / kAll)};
            }
        return picture;
    }

  private:
    std::size_t index(int x, int y) const {
        return std::size_t(y) * std::size_t(m_sheet.width) + std::size_t(x);
    }

    /// Weight of the corner opposite to an edge. Of a sample on a common edge of two triangles
    /// only one has it: translucent surfaces have no seams.
    static bool covers(Vec3d a, Vec3d b, double x, double y, double area, double& weight) {
        weight = ((a.x - x) * (b.y - y) - (b.x - x) * (a.y - y)) / area;
        if (weight != 0) return weight > 0;
        const double dx = (b.x - a.x) * (area > 0 ? 1 : -1), dy = (b.y - a.y) * (area > 0 ? 1 : -1);
        return dy > 0 || (dy == 0 && dx < 0);
    }

    void put(int x, int y, double depth, Rgb8 colour, bool is_opaque, double opacity) {
        const std::size_t at = index(x, y);
        if (depth >= m_depths[at]) return;
        if (is_opaque) {
            m_depths[at] = depth;
            m_colours[at] = colour;
            return;
        }
        const auto mix = [&](std::uint8_t under, std::uint8_t over) {
            return std::uint8_t(under + (over - under) * opacity + 0.5);
        };
        const Rgb8 under = m_colours[at];
        m_colours[at] = {mix(under.r, colour.r), mix(under.g, colour.g), mix(under.b, colour.b)};
    }

    void ball(Vec3d centre, double radius, const DrawnWire& wire) {
        const int top = std::max(0, int(centre.y - radius)),
                  bottom = std::min(m_sheet.height - 1, int(centre.y + radius)),
                  left = std::max(0, int(centre.x - radius)),
                  right = std::min(m_sheet.width - 1, int(centre.x + radius));
        for (int y = top; y <= bottom; ++y)
            for (int x = left; x <= right; ++x) {
                const double u = (x + 0.5 - centre.x) / radius, v = (centre.y - y - 0.5) / radius;
                const double rest = 1 - u * u - v * v;
                if (rest < 0) continue;
                const double w = std::sqrt(rest);
                const Vec3d normal = u * m_sheet.right + v * m_sheet.up - w * m_sheet.look;
                put(x, y, centre.z - w * wire.radius_mm, lit(wire.colour, m_sheet.light_on(normal)),
                    true, 1);
            }
    }

    Sheet m_sheet;
    double m_full;
    std::vector<Rgb8> m_colours;
    std::vector<double> m_depths;
};

struct Extent {
    Vec3d low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
    void add(Vec3d p) {
        if (!is_finite(p)) return;
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    }
};

template <class Body>
void for_each_point(std::span<const DrawnSurface> surfaces, std::span<const DrawnWire> wires,
                    const Body& body) {
    for (const DrawnSurface& s : surfaces)
        for (const Vec3d& p : s.nodes_mm) body(p);
    for (const DrawnWire& w : wires)
        for (const Vec3d& p : w.points_mm) body(p);
}

/// View direction: from the front, the left, or above, along the smallest extent.
Vec3d look_at(const Extent& extent) {
    const Vec3d size = extent.high - extent.low;
    if (size.y <= size.x && size.y <= size.z) return {0, 1, 0};
    return size.x <= size.z ? Vec3d{-1, 0, 0} : Vec3d{0, 0, -1};
}

Sheet sheet_of(std::span<const DrawnSurface> surfaces, std::span<const DrawnWire> wires,
               const SurfaceView& view, int width, int height) {
    Extent world;
    for_each_point(surfaces, wires, [&](Vec3d p) { world.add(p); });
    Sheet sheet;
    sheet.look = normalized(norm(view.look) > 0 ? view.look : look_at(world));
    Vec3d right = cross(sheet.look, view.up);
    if (!(norm(right) > 1e-9 * norm(view.up)))
        right = cross(sheet.look, render::natural_up(sheet.look));
    sheet.right = normalized(right);
    sheet.up = cross(sheet.right, sheet.look);
    sheet.width = kSamples * width;
    sheet.height = kSamples * height;
    Extent flat;
    for_each_point(surfaces, wires, [&](Vec3d p) {
        flat.add({dot(p, sheet.right), dot(p, sheet.up), dot(p, sheet.look)});
    });
    if (!(flat.low.x <= flat.high.x)) return sheet;
    const Vec3d middle = 0.5 * (flat.low + flat.high), size = flat.high - flat.low;
    sheet.middle_mm = middle.x * sheet.right + middle.y * sheet.up + middle.z * sheet.look;
    // Below it there is room for the two scales.
    const double across = 0.92 * sheet.width / std::max(size.x, 1e-9),
                 down = 0.76 * sheet.height / std::max(size.y, 1e-9);
    sheet.scale = std::min({across, down, 1e9});
    return sheet;
}

/// The largest of 1, 2 and 5 times a power of ten up to a length.
double round_length(double most) {
    const double power = std::pow(10, std::floor(std::log10(most)));
    for (const double factor : {5.0, 2.0})
        if (factor * power <= most) return factor * power;
    return power;
}

/// @param opacity  of the surfaces with values: the scale has the colours of two layers of them
void draw_scales(Image& image, const Sheet& sheet, const SurfaceView& view, bool is_cut,
                 double opacity) {
    const int scale = std::max(1, image.height / 400), edge = 10 * scale;
    const int y = image.height - edge - render::kGlyphHeight * scale;
    const double length = round_length(0.25 * sheet.width / sheet.scale);
    const int bar = std::max(1, int(length * sheet.scale / kSamples + 0.5));
    const int above = y - 7 * scale;
    render::fill_box(image, {edge, above}, {edge + bar, above + 2 * scale}, kWords);
    for (const int end : {edge, edge + bar - scale})
        render::fill_box(image, {end, above - 3 * scale}, {end + scale, above + 5 * scale}, kWords);
    render::draw_text(image, {edge, y}, short_text(length, 3) + " mm", kWords, scale);
    if (view.scale.empty()) return;
    const std::string low = "0", high = (is_cut ? ">= " : "") + short_text(view.full, 3);
    const int high_px = render::text_width(high, scale), colours = 120 * scale,
              left = image.width - edge - high_px - 6 * scale - colours;
    for (int x = 0; x < colours; ++x)
        for (int layer = 0; layer < 2; ++layer)
            render::fill_box(image, {left + x, y}, {left + x + 1, y + render::kGlyphHeight * scale},
                             warm((x + 0.5) / colours), opacity);
    render::draw_text(image, {left + colours + 6 * scale, y}, high, kWords, scale);
    render::draw_text(image, {left - 6 * scale - render::text_width(low, scale), y}, low, kWords,
                      scale);
    render::draw_text(image,
                      {image.width - edge - render::text_width(view.scale, scale),
                       y - (render::kGlyphHeight + 5) * scale},
                      view.scale, kWords, scale);
}

void collect(const DrawnSurface& surface, const Sheet& sheet, std::vector<Layer>& layers) {
    for (const auto& triangle : surface.triangles) {
        Layer layer{.corners = {}, .depth = 0, .light = 1, .surface = &surface};
        std::array<Vec3d, 3> p;
        bool is_good = true;
        for (std::size_t n = 0; n < 3 && is_good; ++n) {
            const auto node = std::size_t(triangle[n]);
            is_good = triangle[n] >= 0 && node < surface.nodes_mm.size() &&
                      is_finite(surface.nodes_mm[node]);
            if (!is_good) break;
            p[n] = surface.nodes_mm[node];
            layer.corners[n] = {sheet.position(p[n]),
                                node < surface.values.size() ? surface.values[node] : 0};
            layer.depth += layer.corners[n].at.z / 3;
        }
        if (!is_good) continue;
        layer.light = sheet.light_on(cross(p[1] - p[0], p[2] - p[0]));
        layers.push_back(layer);
    }
}

}  // namespace

Image surface_view(std::span<const DrawnSurface> surfaces, std::span<const DrawnWire> wires,
                   const SurfaceView& view, int width, int height) {
    width = std::max(width, 1);
    height = std::max(height, 1);
    const Sheet sheet = sheet_of(surfaces, wires, view, width, height);
    Canvas canvas(sheet, view.full);
    std::vector<Layer> opaque, translucent;
    bool is_cut = false;
    double opacity = 1;
    for (const DrawnSurface& surface : surfaces) {
        if (!surface.values.empty()) opacity = std::clamp(surface.opacity, 0.0, 1.0);
        collect(surface, sheet, surface.opacity >= 1 ? opaque : translucent);
        for (const double v : surface.values) is_cut = is_cut || v > view.full;
    }
    for (const Layer& layer : opaque) canvas.draw(layer, true);
    for (const DrawnWire& wire : wires) canvas.draw(wire);
    std::stable_sort(translucent.begin(), translucent.end(),
                     [](const Layer& a, const Layer& b) { return a.depth > b.depth; });
    for (const Layer& layer : translucent) canvas.draw(layer, false);
    Image image = canvas.image();
    draw_scales(image, sheet, view, is_cut, opacity);
    if (!view.caption.empty()) {
        const int scale = std::max(1, image.height / 400);
        render::draw_text(image, {10 * scale, 10 * scale}, view.caption, kWords, scale);
    }
    return image;
}

}  // namespace pliant
