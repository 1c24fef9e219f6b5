// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Midpoint rule along each ray, in steps of at most half a voxel; exact for a uniform scan.

#include <pliant/render.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/camera.h"
#include "render/canvas.h"
#include "render/detector.h"
#include "render/volume_or_air.h"
#include "render/voxel_field.h"

namespace pliant {
namespace {

constexpr double kSampleVoxels = 0.5;  ///< step in the scan [voxels]
constexpr double kBorderVoxels = 2;    ///< step beyond the scan [voxels]
constexpr double kBorderShare = 1.0 / 3;
constexpr int kMeterRays = 7;  ///< rays along each side of the central third

/// Interval of a ray's length; empty if end ≤ begin.
struct Stretch {
    double begin, end;
};

/// Interval between the outermost voxel centres, extended by a margin [voxels].
Stretch stretch_in(Vec3i size, Vec3d margin, Vec3d origin, Vec3d direction) {
    Stretch span{0, 1e300};
    for (int a = 0; a < 3; ++a) {
        const double first = -margin[a], last = size[a] - 1 + margin[a];
        if (direction[a] == 0) {
            if (origin[a] < first || origin[a] > last) return {0, 0};
            continue;
        }
        const double t0 = (first - origin[a]) / direction[a],
                     t1 = (last - origin[a]) / direction[a];
        span.begin = std::max(span.begin, std::min(t0, t1));
        span.end = std::min(span.end, std::max(t0, t1));
    }
    return span;
}

/// All rays of one picture.
class Projection {
  public:
    Projection(const Grid& grid, const Endoscope& source, const Fluoroscopy& settings)
        : m_grid(grid),
          m_source(source.eye_mm),
          m_ahead(source.look),
          m_eye(voxel_from_world(grid, source.eye_mm)) {
        const Vec3d last{grid.size.x - 1.0, grid.size.y - 1.0, grid.size.z - 1.0};
        double volume = 1, half_depth = 0;
        for (int a = 0; a < 3; ++a) {
            const double side = last[a] * grid.spacing_mm[a];
            Vec3d axis{0, 0, 0};
            axis[a] = 0.5 * side;
            volume *= side;
            half_depth += std::abs(dot(world_from_lattice_vector(grid, axis), m_ahead));
        }
        const double middle = dot(world_from_voxel(grid, 0.5 * last) - source.eye_mm, m_ahead);
        m_slab = {middle - half_depth, middle + half_depth};
        m_border_mm = settings.border_mm.value_or(kBorderShare * std::cbrt(volume));
        for (int a = 0; a < 3; ++a) m_margin[a] = m_border_mm / grid.spacing_mm[a];
    }

    /// @param ray  unit vector [mm]
    template <class Field>
    double water_along(const Field& field, Vec3d ray) const {
        const Vec3d direction = voxel_from_world(m_grid, m_source + ray) - m_eye;
        const Stretch scan = stretch_in(field.size(), {0, 0, 0}, m_eye, direction);
        const auto everything = [](Vec3d) { return 1.0; };
        const double water = integral(field, direction, scan, kSampleVoxels, everything);
        if (!(m_border_mm > 0)) return water;
        Stretch all = stretch_in(field.size(), m_margin, m_eye, direction);
        const double slope = dot(ray, m_ahead);
        all.begin = std::max(all.begin, m_slab.begin / slope);
        all.end = std::min(all.end, m_slab.end / slope);
        const bool hit = scan.end > scan.begin;
        const Stretch before{all.begin, hit ? scan.begin : all.end}, after{scan.end, all.end};
        const auto faded = [this](Vec3d p) { return left_at(p); };
        const double beyond = integral(field, direction, before, kBorderVoxels, faded);
        return water + beyond + (hit ? integral(field, direction, after, kBorderVoxels, faded) : 0);
    }

  private:
    /// @param share  factor of the density at a position [voxels]
    template <class Field, class Share>
    double integral(const Field& field, Vec3d direction, Stretch span, double step_voxels,
                    const Share& share) const {
        const double length = span.end - span.begin;
        if (!(length > 0)) return 0;
        const double count = std::ceil(length * norm(direction) / step_voxels),
                     step = length / count;
        double sum = 0;
        for (double n = 0; n < count; ++n) {
            const Vec3d p = m_eye + (span.begin + (n + 0.5) * step) * direction;
            sum += share(p) * std::max(0.0, 1 + field.sample(p) / 1000);
        }
        return sum * step;
    }

    /// Fade-out factor of the outermost voxels at p [voxels]; 1 in the scan.
    double left_at(Vec3d p) const {
        double e2 = 0;
        for (int a = 0; a < 3; ++a) {
            const double e = (p[a] - std::clamp(p[a], 0.0, m_grid.size[a] - 1.0)) / m_margin[a];
            e2 += e * e;
        }
        const double left = std::max(0.0, 1 - e2);
        return left * left;
    }

    const Grid& m_grid;
    Vec3d m_source, m_ahead;  ///< [mm]
    Vec3d m_eye;              ///< the source [voxels]
    Stretch m_slab;           ///< along m_ahead, between the planes that touch the scan [mm]
    double m_border_mm;
    Vec3d m_margin;  ///< the border [voxels]
};

/// Water lengths of the rays of the wanted pixels (x, y); 0 for the others.
template <class Wanted>
std::vector<float> lengths_of(const Volume& scan, const Fluoroscopy& settings, int width,
                              int height, const TaskArena& arena, const Wanted& wanted) {
    const Volume& volume = render::volume_or_air(scan);
    const Endoscope source = render::x_ray_source(settings, width, height);
    const render::Camera camera(source, width, height);
    const Projection projection(volume.grid, source, settings);
    std::vector<float> lengths(std::size_t(width) * std::size_t(height));
    render::with_field(volume, [&](const auto& field) {
        arena.for_each(height, 4, [&](std::int64_t begin, std::int64_t end) {
            for (int y = int(begin); y < int(end); ++y)
                for (int x = 0; x < width; ++x)
                    if (wanted(x, y))
                        lengths[std::size_t(y) * std::size_t(width) + std::size_t(x)] = float(
                            projection.water_along(field, camera.direction(x + 0.5, y + 0.5)));
        });
    });
    return lengths;
}

}  // namespace

namespace render {

Endoscope x_ray_source(const Fluoroscopy& s, int width, int height) {
    const Vec3d ahead = norm(s.look) > 0 ? normalized(s.look) : Vec3d{0, 1, 0};
    const double half_height_mm = 0.5 * s.width_mm * height / width;
    return {
        .eye_mm = s.centre_mm - s.source_mm * ahead,
        .look = ahead,
        .up = s.up,
        .field_of_view_deg = 2 * std::atan(half_height_mm / s.source_mm) * 180 / std::numbers::pi,
        .barrel_distortion = 0};
}

double metered_water_mm(const Volume& scan, const Fluoroscopy& settings, int width, int height) {
    const Volume& volume = volume_or_air(scan);
    const Endoscope source = x_ray_source(settings, width, height);
    const Camera camera(source, width, height);
    const Projection projection(volume.grid, source, settings);
    std::vector<double> lengths;
    with_field(volume, [&](const auto& field) {
        for (int i = 0; i < kMeterRays; ++i)
            for (int j = 0; j < kMeterRays; ++j) {
                const auto at = [](int n) { return (1 + (n + 0.5) / kMeterRays) / 3; };
                const Vec3d ray = camera.direction(width * at(i), height * at(j));
                const double water = projection.water_along(field, ray);
                if (water > 1) lengths.push_back(water);
            }
    });
    if (lengths.empty()) return 0;
    const auto middle = lengths.begin() + std::ptrdiff_t(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    return *middle;
}

std::uint8_t detected(const Fluoroscopy& settings, const Camera& camera, int x, int y,
                      double water_mm, double exposure_mm) {
    const auto [u, v] = camera.position(x + 0.5, y + 0.5);
    const double open = collimator(settings.field_stop, camera.aspect(), u, v);
    if (!(open > 0)) return 0;
    double excess = settings.water_per_mm * (water_mm - exposure_mm);
    if (settings.noise > 0)
        excess += settings.noise * quantum_noise(excess) * pixel_noise(x, y, settings.seed);
    const double light = open * curve(settings.contrast * excess);
    return std::uint8_t(255 * std::clamp(light, 0.0, 1.0) + 0.5);
}

}  // namespace render

std::vector<float> water_lengths_mm(const Volume& volume, const Fluoroscopy& settings, int width,
                                    int height, const TaskArena& arena) {
    return lengths_of(volume, settings, width, height, arena, [](int, int) { return true; });
}

Image fluoroscopy_view(const Volume& volume, const Fluoroscopy& settings, int width, int height,
                       const TaskArena& arena) {
    const render::Camera camera(render::x_ray_source(settings, width, height), width, height);
    const auto open_at = [&](int x, int y) {
        const auto [u, v] = camera.position(x + 0.5, y + 0.5);
        return render::collimator(settings.field_stop, camera.aspect(), u, v);
    };
    const std::vector<float> lengths = lengths_of(volume, settings, width, height, arena,
                                                  [&](int x, int y) { return open_at(x, y) > 0; });
    const double exposure = settings.exposure_water_mm
                                ? *settings.exposure_water_mm
                                : render::metered_water_mm(volume, settings, width, height);
    Image image = render::make_image(width, height, {0, 0, 0});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t n = std::size_t(y) * std::size_t(width) + std::size_t(x);
            const std::uint8_t grey =
                render::detected(settings, camera, x, y, double(lengths[n]), exposure);
            image.pixels[n] = {grey, grey, grey};
        }
    return image;
}

}  // namespace pliant
