// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "cutaway.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "page.h"

namespace pliant::results {
namespace {

constexpr int kSamples = 3;  ///< along each side of a pixel
constexpr Rgb8 kGreyText{90, 96, 106};

Vec3d axis_of(int n) {
    Vec3d axis{0, 0, 0};
    axis[n] = 1;
    return axis;
}

Rgb8 scaled(Rgb8 c, double by) {
    const auto byte = [&](std::uint8_t v) {
        return std::uint8_t(std::lround(std::clamp(v * by, 0.0, 255.0)));
    };
    return {byte(c.r), byte(c.g), byte(c.b)};
}

double volume_of(const TetMesh& mesh, std::span<const Vec3d> positions, std::size_t cell) {
    const auto p = [&](std::size_t n) { return positions[std::size_t(mesh.cells[cell][n])]; };
    return dot(cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0)) / 6;
}

/// A triangle of the boundary: its cell, and the cell's corners in it.
struct Face {
    std::size_t cell;
    std::array<std::size_t, 3> corners;
};
std::vector<Face> boundary_of(const TetMesh& mesh) {
    constexpr std::size_t kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    struct Seen {
        Face face;
        int count = 0;
    };
    std::map<std::array<std::int32_t, 3>, Seen> seen;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        for (const auto& f : kFaces) {
            std::array<std::int32_t, 3> key{mesh.cells[c][f[0]], mesh.cells[c][f[1]],
                                            mesh.cells[c][f[2]]};
            std::sort(key.begin(), key.end());
            Seen& s = seen[key];
            s.face = {c, {f[0], f[1], f[2]}};
            ++s.count;
        }
    std::vector<Face> faces;
    for (const auto& [key, s] : seen)
        if (s.count == 1) faces.push_back(s.face);
    return faces;
}

struct Valued {
    Vec3d p;
    double value;
};
/// Intersection of the segment and the plane. @param u, v  distances of the ends from it, of
/// opposite signs
Valued between(const Valued& a, const Valued& b, double u, double v) {
    const double t = u / (u - v);
    return {a.p + t * (b.p - a.p), a.value + t * (b.value - a.value)};
}

}  // namespace

CornerValues distances_of(const TetMesh& mesh, std::span<const Vec3d> a, std::span<const Vec3d> b) {
    CornerValues values;
    for (const auto& cell : mesh.cells) {
        std::array<double, 4> v{};
        for (std::size_t n = 0; n < 4; ++n)
            v[n] = norm(a[std::size_t(cell[n])] - b[std::size_t(cell[n])]);
        values.push_back(v);
    }
    return values;
}

CornerValues displacements_of(const TetMesh& mesh, std::span<const Vec3d> positions) {
    return distances_of(mesh, positions, mesh.nodes_mm);
}

CornerValues volume_changes_of(const TetMesh& mesh, std::span<const Vec3d> positions) {
    CornerValues values;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const double change = volume_of(mesh, positions, c) / volume_of(mesh, mesh.nodes_mm, c) - 1;
        values.push_back({change, change, change, change});
    }
    return values;
}

Colouring shaded_to(double largest) {
    return [largest](double v) { return std::isnan(v) ? kHeld : shade_of(v / largest); };
}

Colouring signed_to(double largest) {
    return [largest](double v) {
        const double t = std::clamp(v / largest, -1.0, 1.0);
        const Rgb8 full = t < 0 ? kRed : kBlue;
        const auto mix = [&](int from, int to) {
            return std::uint8_t(std::lround(from + (to - from) * std::abs(t)));
        };
        return Rgb8{mix(232, full.r), mix(232, full.g), mix(228, full.b)};
    };
}

Image signed_bar(double full, int decimals, std::string_view name, double largest) {
    constexpr int kHeight_px = 26, kBar_px = 140;
    const bool is_cut = largest > full;
    const std::string low = (is_cut ? "\u2264-" : "-") + fixed_text(full, decimals),
                      high = (is_cut ? "\u2265+" : "+") + fixed_text(full, decimals);
    const double texts_px = text_width_px(name) + text_width_px(low) + text_width_px(high);
    Plot plot(int(texts_px) + kBar_px + 46, kHeight_px, {0, 0},
              {texts_px + kBar_px + 46, double(kHeight_px)});
    const double y = 0.5 * kHeight_px;
    double x = 8;
    plot.text({x, y}, name, kText_px, kDark, Align::Left);
    x += text_width_px(name) + 14;
    plot.text({x, y}, low, kText_px, kDark, Align::Left);
    x += text_width_px(low) + 7;
    const Colouring colouring = signed_to(1);
    for (int n = 0; n < kBar_px; ++n)
        for (int row = 6; row < kHeight_px - 6; ++row)
            plot.dab(int(x) + n, row, colouring(2 * (n + 0.5) / kBar_px - 1), 1);
    plot.text({x + kBar_px + 7, y}, high, kText_px, kDark, Align::Left);
    return plot.image();
}

Cutaway::Cutaway(const Camera& camera)
    : m_camera(camera),
      m_right(axis_of(camera.right)),
      m_up(axis_of(camera.up)),
      m_toward(cross(m_right, m_up)),
      m_cut(camera.cut_mm * (m_toward.x + m_toward.y + m_toward.z)),
      m_width(int(std::lround((camera.high.x - camera.low.x) * camera.px_per_mm)) * kSamples),
      m_height(int(std::lround((camera.high.y - camera.low.y) * camera.px_per_mm)) * kSamples),
      m_colours(std::size_t(m_width) * std::size_t(m_height), kPaper),
      m_depths(m_colours.size(), -std::numeric_limits<double>::infinity()) {}

double Cutaway::before_cut(Vec3d p) const {
    return dot(p, m_toward) - m_cut;
}

Cutaway::Corner Cutaway::corner_of(Vec3d p, double value) const {
    const double scale = m_camera.px_per_mm * kSamples;
    return {(dot(p, m_right) - m_camera.low.x) * scale, (m_camera.high.y - dot(p, m_up)) * scale,
            dot(p, m_toward), value};
}

/// Two-sided light from the upper left.
double Cutaway::light_on(Vec3d normal) const {
    const double length = norm(normal);
    if (!(length > 0)) return 1;
    const Vec3d light = (1 / std::sqrt(1.7)) * (m_toward + 0.6 * m_up - 0.6 * m_right);
    const double facing = dot(normal, m_toward) < 0 ? -1 : 1;
    return 0.78 + 0.26 * std::max(0.0, facing * dot(normal, light) / length);
}

void Cutaway::put(int x, int y, double depth, Rgb8 colour) {
    if (x < 0 || y < 0 || x >= m_width || y >= m_height) return;
    const std::size_t at = std::size_t(y) * std::size_t(m_width) + std::size_t(x);
    if (depth <= m_depths[at]) return;
    m_depths[at] = depth;
    m_colours[at] = colour;
}

void Cutaway::triangle(const std::array<Corner, 3>& t, const Shade& shade) {
    const double area =
        (t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[2].x - t[0].x) * (t[1].y - t[0].y);
    if (std::abs(area) < 1e-9) return;
    std::array<double, 3> heights{};
    for (std::size_t n = 0; n < 3; ++n) {
        const Corner &a = t[(n + 1) % 3], &b = t[(n + 2) % 3];
        heights[n] = std::abs(area) / std::max(1e-9, std::hypot(b.x - a.x, b.y - a.y)) / kSamples;
    }
    const auto [left, right] = std::minmax({t[0].x, t[1].x, t[2].x});
    const auto [top, bottom] = std::minmax({t[0].y, t[1].y, t[2].y});
    for (int y = std::max(0, int(top)); y <= std::min(m_height - 1, int(bottom)); ++y)
        for (int x = std::max(0, int(left)); x <= std::min(m_width - 1, int(right)); ++x) {
            const double px = x + 0.5, py = y + 0.5;
            std::array<double, 3> w{};
            for (std::size_t n = 0; n < 3; ++n) {
                const Corner &a = t[(n + 1) % 3], &b = t[(n + 2) % 3];
                w[n] = ((a.x - px) * (b.y - py) - (b.x - px) * (a.y - py)) / area;
            }
            if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
            double depth = 0, value = 0, edge_px = 1e9;
            for (std::size_t n = 0; n < 3; ++n) {
                depth += w[n] * t[n].depth;
                value += w[n] * t[n].value;
                edge_px = std::min(edge_px, w[n] * heights[n]);
            }
            put(x, y, depth, shade(value, edge_px));
        }
}

void Cutaway::wall(const TetMesh& mesh, std::span<const Vec3d> positions,
                   const CornerValues& values, const Colouring& colouring) {
    const auto fan = [&](std::span<const Valued> corners, const Shade& shade) {
        for (std::size_t n = 2; n < corners.size(); ++n)
            triangle({corner_of(corners[0].p, corners[0].value),
                      corner_of(corners[n - 1].p, corners[n - 1].value),
                      corner_of(corners[n].p, corners[n].value)},
                     shade);
    };
    for (const Face& face : boundary_of(mesh)) {
        std::array<Valued, 3> t;
        for (std::size_t n = 0; n < 3; ++n)
            t[n] = {positions[std::size_t(mesh.cells[face.cell][face.corners[n]])],
                    values[face.cell][face.corners[n]]};
        std::vector<Valued> kept;
        for (std::size_t n = 0; n < 3; ++n) {
            const Valued &a = t[n], &b = t[(n + 1) % 3];
            const double u = before_cut(a.p), v = before_cut(b.p);
            if (u <= 0) kept.push_back(a);
            if ((u <= 0) != (v <= 0)) kept.push_back(between(a, b, u, v));
        }
        const double light = light_on(cross(t[1].p - t[0].p, t[2].p - t[0].p));
        fan(kept, [&](double value, double) { return scaled(colouring(value), light); });
    }
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        std::vector<Valued> behind, before, cut;
        for (std::size_t n = 0; n < 4; ++n) {
            const Valued corner{positions[std::size_t(mesh.cells[c][n])], values[c][n]};
            (before_cut(corner.p) <= 0 ? behind : before).push_back(corner);
        }
        // In an order in which neighbours differ in one corner, so that it is a polygon.
        for (std::size_t a = 0; a < behind.size(); ++a)
            for (std::size_t k = 0; k < before.size(); ++k) {
                const std::size_t b = a % 2 == 0 ? k : before.size() - 1 - k;
                cut.push_back(between(behind[a], before[b], before_cut(behind[a].p),
                                      before_cut(before[b].p)));
            }
        fan(cut, [&](double value, double) { return colouring(value); });
    }
    const auto edge = cut_edge(mesh, positions);
    m_edges.insert(m_edges.end(), edge.begin(), edge.end());
}

std::vector<std::array<Point2, 2>> Cutaway::cut_edge(const TetMesh& mesh,
                                                     std::span<const Vec3d> positions) const {
    std::vector<std::array<Point2, 2>> edges;
    for (const Face& face : boundary_of(mesh)) {
        std::vector<Point2> ends;
        for (std::size_t n = 0; n < 3; ++n) {
            const auto& cell = mesh.cells[face.cell];
            const Valued a{positions[std::size_t(cell[face.corners[n]])], 0};
            const Valued b{positions[std::size_t(cell[face.corners[(n + 1) % 3]])], 0};
            const double u = before_cut(a.p), v = before_cut(b.p);
            if ((u <= 0) == (v <= 0)) continue;
            const Vec3d p = between(a, b, u, v).p;
            ends.push_back({dot(p, m_right), dot(p, m_up)});
        }
        if (ends.size() == 2) edges.push_back({ends[0], ends[1]});
    }
    return edges;
}

bool Cutaway::is_seen(Point2 p) const {
    return p.x >= m_camera.low.x && p.x <= m_camera.high.x && p.y >= m_camera.low.y &&
           p.y <= m_camera.high.y;
}

void Cutaway::outline(const TetMesh& mesh, std::span<const Vec3d> positions) {
    m_outline = cut_edge(mesh, positions);
}

void Cutaway::wire(std::span<const Vec3d> positions, double radius_mm, Rgb8 colour) {
    constexpr double kStep_mm = 0.1;
    const double scale = m_camera.px_per_mm * kSamples, radius = radius_mm * scale;
    for (std::size_t n = 1; n < positions.size(); ++n) {
        const Vec3d along = positions[n] - positions[n - 1];
        const int count = std::max(1, int(norm(along) / kStep_mm));
        for (int k = 0; k <= count; ++k) {
            const Corner c = corner_of(positions[n - 1] + (double(k) / count) * along, 0);
            for (int y = int(c.y - radius); y <= int(c.y + radius); ++y)
                for (int x = int(c.x - radius); x <= int(c.x + radius); ++x) {
                    const double u = (x + 0.5 - c.x) / radius, v = (c.y - y - 0.5) / radius;
                    const double w2 = 1 - u * u - v * v;
                    if (w2 < 0) continue;
                    const Vec3d normal = u * m_right + v * m_up + std::sqrt(w2) * m_toward;
                    put(x, y, c.depth + radius_mm * std::sqrt(w2),
                        scaled(colour, light_on(normal)));
                }
        }
    }
}

void Cutaway::body(const TetMesh& mesh, Rgb8 colour) {
    for (const Face& face : boundary_of(mesh)) {
        std::array<Vec3d, 3> p;
        for (std::size_t n = 0; n < 3; ++n)
            p[n] = mesh.nodes_mm[std::size_t(mesh.cells[face.cell][face.corners[n]])];
        const double light = light_on(cross(p[1] - p[0], p[2] - p[0]));
        triangle(
            {corner_of(p[0], 0), corner_of(p[1], 0), corner_of(p[2], 0)},
            [&](double, double edge_px) { return scaled(colour, edge_px < 0.45 ? 0.35 : light); });
    }
}

Image Cutaway::image(std::string_view title) const {
    constexpr int kLeft = 46, kBottom = 48, kTop = 30, kRight = 10;
    const int width = m_width / kSamples, height = m_height / kSamples;
    const double scale = m_camera.px_per_mm;
    const Point2 low{m_camera.low.x - kLeft / scale, m_camera.high.y + kTop / scale};
    const Point2 high{m_camera.high.x + kRight / scale, m_camera.low.y - kBottom / scale};
    Plot plot(width + kLeft + kRight, height + kTop + kBottom, low, high);
    for (int y = 0; y < m_height; ++y)
        for (int x = 0; x < m_width; ++x) {
            // Running mean of all samples.
            const int seen = (y % kSamples) * kSamples + x % kSamples + 1;
            const std::size_t at = std::size_t(y) * std::size_t(m_width) + std::size_t(x);
            plot.dab(kLeft + x / kSamples, kTop + y / kSamples, m_colours[at], 1.0 / seen);
        }
    const auto draw = [&](const std::vector<std::array<Point2, 2>>& lines, const Ink& ink) {
        for (const auto& [a, b] : lines)
            if (is_seen(a) && is_seen(b)) plot.line(a, b, ink);
    };
    draw(m_edges, {kDark, 1.2, 0.8});
    draw(m_outline, {kRed, 1.1, 0.9});
    const auto words = [&](Point2 at, double dx, double dy, std::string_view text, Align align) {
        const Point2 p = plot.pixel_of(at);
        plot.text(plot.point_of({p.x + dx, p.y + dy}), text, kText_px, kGreyText, align);
    };
    const auto [left, bottom] = m_camera.low;
    const auto [right, top] = m_camera.high;
    const Point2 frame[] = {{left, bottom}, {right, bottom}, {right, top}, {left, top}};
    plot.polyline(frame, {kFaint, 1, 1}, true);
    const double tick = m_camera.tick_mm;
    for (int n = int(std::ceil(left / tick)); n * tick <= right; ++n) {
        const double x = n * tick;
        plot.line({x, bottom}, {x, bottom - 4 / scale}, {kGreyText});
        words({x, bottom}, 0, 15, fixed_text(x, 0), Align::Middle);
    }
    for (int n = int(std::ceil(bottom / tick)); n * tick <= top; ++n) {
        const double y = n * tick;
        plot.line({left, y}, {left - 4 / scale, y}, {kGreyText});
        words({left, y}, -8, 0, fixed_text(y, 0), Align::Right);
    }
    constexpr std::string_view kNames[] = {"x [mm]", "y [mm]", "z [mm]"};
    words({right, bottom}, 0, 35, kNames[m_camera.right], Align::Right);
    words({left, top}, 6 - kLeft, -16, kNames[m_camera.up], Align::Left);
    plot.text(plot.point_of({kLeft + 0.5 * width, kTop - 16.0}), title);
    const double bar_y = bottom + 12 / scale, bar_x = right - 12 / scale - m_camera.bar_mm;
    plot.line({bar_x, bar_y}, {bar_x + m_camera.bar_mm, bar_y}, {kDark, 2, 1});
    for (const double end : {bar_x, bar_x + m_camera.bar_mm})
        plot.line({end, bar_y - 4 / scale}, {end, bar_y + 4 / scale}, {kDark, 2, 1});
    plot.text({bar_x + 0.5 * m_camera.bar_mm, bar_y + 13 / scale},
              fixed_text(m_camera.bar_mm, 0) + " mm");
    return plot.image();
}

}  // namespace pliant::results
