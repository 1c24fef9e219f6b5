// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "slices.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pliant::results {
namespace {

Point2 place_of(const ChainMail& tissue, const Slice& slice, Vec3i element, double& moved_mm) {
    const Grid& grid = tissue.volume().grid;
    const Vec3d u = lattice_from_world_vector(grid, tissue.displacement_mm(element));
    moved_mm = norm(u);
    return {grid.spacing_mm[slice.across] * element[slice.across] + u[slice.across],
            grid.spacing_mm[slice.down] * element[slice.down] + u[slice.down]};
}

/// Fraction of the way at which a value between two ends reaches a level.
double crossing(double from, double to, double level) {
    return from == to ? 0.5 : (level - from) / (to - from);
}

}  // namespace

Vec3i Slice::element(int a, int d) const {
    Vec3i e{0, 0, 0};
    e[across] = a;
    e[down] = d;
    e[third()] = index;
    return e;
}

Window window_around(const Slice& slice, const Grid& grid, Vec3d centre_ijk, double half_mm) {
    const auto begin = [&](int axis) {
        const double low = centre_ijk[axis] - half_mm / grid.spacing_mm[axis];
        return std::max(0, int(std::ceil(low)));
    };
    const auto end = [&](int axis) {
        const double high = centre_ijk[axis] + half_mm / grid.spacing_mm[axis];
        return std::min(grid.size[axis], int(std::floor(high)) + 1);
    };
    return {begin(slice.across), end(slice.across), begin(slice.down), end(slice.down)};
}

void draw_lattice(Plot& plot, const ChainMail& tissue, const Slice& slice, const Window& window,
                  const LatticeStyle& style) {
    const Volume& scan = tissue.volume();
    const auto is_there = [&](int a, int d) {
        return a < window.across_end && d < window.down_end &&
               scan.at(slice.element(a, d)) >= style.threshold_hu;
    };
    double moved = 0;
    const auto place = [&](int a, int d) {
        return place_of(tissue, slice, slice.element(a, d), moved);
    };
    const auto for_each = [&](auto&& body) {
        for (int d = window.down_begin; d < window.down_end; ++d)
            for (int a = window.across_begin; a < window.across_end; ++a)
                if (is_there(a, d)) body(a, d);
    };
    for_each([&](int a, int d) {
        const Point2 here = place(a, d);
        const double moved_here = moved;
        for (const auto& [na, nd] : {std::pair{a + 1, d}, std::pair{a, d + 1}}) {
            if (!is_there(na, nd) || (na == a ? a : d) % style.every != 0) continue;
            const Point2 there = place(na, nd);
            const double mean = 0.5 * (moved_here + moved);
            plot.line(here, there, {shade_of(mean / style.largest_mm), style.link_px, 1});
        }
    });
    if (style.dot_px <= 0) return;
    for_each([&](int a, int d) {
        const Point2 here = place(a, d);
        plot.dot(here, style.dot_px, shade_of(0.15 + 0.85 * moved / style.largest_mm));
    });
}

void draw_values(Plot& plot, const Volume& volume, const Slice& slice, double window_hu,
                 double level_hu) {
    const int width = plot.image().width, height = plot.image().height;
    Vec3d ijk{};
    ijk[slice.third()] = slice.index;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Point2 p = plot.point_of({x + 0.5, y + 0.5});
            ijk[slice.across] = p.x / volume.grid.spacing_mm[slice.across];
            ijk[slice.down] = p.y / volume.grid.spacing_mm[slice.down];
            const double share = (sample_linear(volume, ijk) - level_hu) / window_hu + 0.5;
            const auto grey = std::uint8_t(std::lround(255 * std::clamp(share, 0.0, 1.0)));
            plot.dab(x, y, {grey, grey, grey}, 1);
        }
}

double PlaneField::at(int a, int d) const {
    const int wide = window.across_end - window.across_begin;
    const int n = a - window.across_begin + wide * (d - window.down_begin);
    return values[std::size_t(n)];
}

double PlaneField::sample(Point2 p_mm) const {
    const double a = p_mm.x / spacing_mm[slice.across], d = p_mm.y / spacing_mm[slice.down];
    const int a0 = int(std::floor(a)), d0 = int(std::floor(d));
    if (a0 < window.across_begin || d0 < window.down_begin || a0 + 1 >= window.across_end ||
        d0 + 1 >= window.down_end)
        return 0;
    const double s = a - a0, t = d - d0;
    return (1 - t) * ((1 - s) * at(a0, d0) + s * at(a0 + 1, d0)) +
           t * ((1 - s) * at(a0, d0 + 1) + s * at(a0 + 1, d0 + 1));
}

PlaneField displacement_along(const ChainMail& tissue, const Slice& slice, const Window& window,
                              Vec3d direction) {
    PlaneField field{slice, window, tissue.volume().grid.spacing_mm, {}};
    for (int d = window.down_begin; d < window.down_end; ++d)
        for (int a = window.across_begin; a < window.across_end; ++a)
            field.values.push_back(dot(tissue.displacement_mm(slice.element(a, d)), direction));
    return field;
}

PlaneField values_in(const Volume& volume, const Slice& slice, const Window& window) {
    PlaneField field{slice, window, volume.grid.spacing_mm, {}};
    for (int d = window.down_begin; d < window.down_end; ++d)
        for (int a = window.across_begin; a < window.across_end; ++a)
            field.values.push_back(volume.at(slice.element(a, d)));
    return field;
}

void draw_contour(Plot& plot, const PlaneField& field, double level, const Ink& ink) {
    const Window& w = field.window;
    const double sa = field.spacing_mm[field.slice.across], sd = field.spacing_mm[field.slice.down];
    for (int d = w.down_begin; d + 1 < w.down_end; ++d)
        for (int a = w.across_begin; a + 1 < w.across_end; ++a) {
            // Crossings of the level on the four sides of the cell, in pairs.
            const int ca[] = {a, a + 1, a + 1, a, a}, cd[] = {d, d, d + 1, d + 1, d};
            std::vector<Point2> ends;
            for (int n = 0; n < 4; ++n) {
                const double from = field.at(ca[n], cd[n]), to = field.at(ca[n + 1], cd[n + 1]);
                if ((from >= level) == (to >= level)) continue;
                const double t = crossing(from, to, level);
                ends.push_back({sa * (ca[n] + t * (ca[n + 1] - ca[n])),
                                sd * (cd[n] + t * (cd[n + 1] - cd[n]))});
            }
            for (std::size_t n = 0; n + 1 < ends.size(); n += 2)
                plot.line(ends[n], ends[n + 1], ink);
        }
}

Contour contour_around(const PlaneField& field, Point2 centre_mm, double level, int rays) {
    constexpr double kStep_mm = 0.05;
    Contour contour;
    for (int ray = 0; ray < rays; ++ray) {
        const double angle = 2 * std::numbers::pi * ray / rays;
        const auto value = [&](double r) {
            return field.sample(
                {centre_mm.x + r * std::cos(angle), centre_mm.y + r * std::sin(angle)});
        };
        double r = 0, before = value(0), now = before;
        while (now >= level) {
            r += kStep_mm;
            before = now;
            now = value(r);
        }
        if (r > 0) r -= kStep_mm * (1 - crossing(before, now, level));
        contour.radii_mm.push_back(r);
        contour.mean_mm += r / rays;
    }
    const auto [low, high] = std::minmax_element(contour.radii_mm.begin(), contour.radii_mm.end());
    contour.deviation = contour.mean_mm > 0 ? (*high - *low) / contour.mean_mm : 0;
    return contour;
}

}  // namespace pliant::results
