// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/real_look.h"

#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/exposure.h"
#include "render/noise_tile.h"

namespace pliant::render {
namespace {

constexpr double kLampAside_mm = 1.6, kLampAbove_mm = 0.5;
constexpr double kAcross = 4;                // distance of the samples beside a slit [voxels]
constexpr Vec3d kSlit{0.045, 0.004, 0.005};  // blood in a slit
constexpr double kFaceSteps[] = {2, 3};      // distances of the samples around a raw face [voxels]
constexpr double kFarthest = 1.5;     // largest distance of a raw face to the voxels' wall [voxels]
constexpr double kFaceSoftHu = 1000;  // a step between tissue and air has no flat sides

using V = double;
using Triple = Vec3d;

double larger(double a, double b) {
    return std::max(a, b);
}
double smaller(double a, double b) {
    return std::min(a, b);
}
double absolute(double a) {
    return std::abs(a);
}
double where_more(double a, double b, double yes, double no) {
    return a > b ? yes : no;
}
bool all_more(double a, double b) {
    return a > b;
}

#define PLIANT_INLINE inline
#include "render/real_look.inc"
#undef PLIANT_INLINE

/// The scan and the noise for Light.
struct PlainScan {
    const VolumeRays& rays;

    double sample(Vec3d point_mm) const { return rays.sample(point_mm); }
    Noise noise(Vec3d cells) const {
        const NoiseTile::Value n = NoiseTile::instance().at(cells);
        return {to_double(n.slope), double(n.value)};
    }
};

/// A closed cut: not visible in the voxels, only in the field of raw tissue.
struct Slit {
    double depth;   ///< 0…1: darkness
    Vec3d towards;  ///< direction to the slit along the wall, longest at its lips
};

/// A wall whose tissue is raw: cut or carved.
class RawWall {
  public:
    /// @param raw  of the tissue at the hit, above 0
    RawWall(const LookInput& input, const VolumeRays& rays, const RestField& rest, double raw)
        : m_input(input), m_rays(rays), m_rest(rest), m_raw(raw) {
        const Grid& grid = rays.volume.grid;
        const Vec3d s = grid.spacing_mm;
        m_spacing_mm = std::cbrt(s.x * s.y * s.z);
        for (int a = 0; a < 3; ++a) m_voxel_axes[a] = s[a] * grid.direction.columns[a];
    }

    Face face(const LookHit& hit) const;
    Slit slit(Vec3d point_mm, Vec3d normal) const;

  private:
    double tissue_at(Vec3d point_mm) const {
        const double above = m_rays.sample(point_mm) - m_input.iso_hu;
        return std::clamp((m_input.is_rising ? above : -above) / kFaceSoftHu + 0.5, 0.0, 1.0);
    }

    const LookInput& m_input;
    const VolumeRays& m_rays;
    const RestField& m_rest;
    double m_raw;
    double m_spacing_mm;    ///< of the voxels, geometric mean
    Vec3d m_voxel_axes[3];  ///< a step along each axis of the grid [mm]
};

/// Carving takes out whole voxels, which leaves terraces: the normal is that of the share of tissue
/// within a few voxels, and the position is where that share is half.
Face RawWall::face(const LookHit& hit) const {
    double share = tissue_at(hit.point_mm), far = 0;
    int count = 1;
    Vec3d slope{0, 0, 0};  // per voxel, along the grid's axes
    for (int n = 0; n < 27; ++n) {
        if (n == 13) continue;
        const Vec3d d =
            normalized(Vec3d{double(n % 3 - 1), double(n / 3 % 3 - 1), double(n / 9 - 1)});
        const Vec3d way = d.x * m_voxel_axes[0] + d.y * m_voxel_axes[1] + d.z * m_voxel_axes[2];
        for (const double step : kFaceSteps) {
            const double tissue = tissue_at(hit.point_mm + step * way);
            share += tissue;
            slope = slope + tissue * d;
            far += step;
            ++count;
        }
    }
    share /= count;
    slope = (3 / far) * slope;  // the gradient of a linear field
    const Mat3d& to_voxel = m_rays.voxel_from_world;
    const Vec3d gradient{dot(to_voxel.columns[0], slope), dot(to_voxel.columns[1], slope),
                         dot(to_voxel.columns[2], slope)};  // per mm
    const double steepness = norm(gradient);
    if (!(steepness > 1e-6)) return {hit.point_mm, hit.normal};
    Vec3d smooth = (-1 / steepness) * gradient;
    smooth = smooth - std::max(dot(smooth, hit.direction), 0.0) * hit.direction;
    if (!(norm(smooth) > 1e-3)) return {hit.point_mm, hit.normal};
    const double weight = smooth_step(0.1, 0.6, m_raw);
    const double far_mm = kFarthest * m_spacing_mm;
    const double off_mm = std::clamp((share - 0.5) / steepness, -far_mm, far_mm);
    return {hit.point_mm + weight * off_mm * normalized(smooth),
            normalized(mix(hit.normal, normalized(smooth), weight))};
}

Slit RawWall::slit(Vec3d point_mm, Vec3d normal) const {
    const Vec3d side = std::abs(normal.z) < 0.7 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
    const Vec3d u = normalized(cross(normal, side)), v = cross(normal, u);
    const double step_mm = kAcross * m_spacing_mm;
    const auto raw_at = [&](Vec3d way) {
        return double(m_rest.at(m_rays.to_voxel(point_mm + step_mm * way)).raw);
    };
    const double u0 = raw_at(-1.0 * u), u1 = raw_at(u), v0 = raw_at(-1.0 * v), v1 = raw_at(v);
    // A ridge of the field; an open face is no ridge.
    const double ridge = m_raw - std::min(std::max(u0, u1), std::max(v0, v1));
    return {std::clamp(ridge / 0.3, 0.0, 1.0) * smooth_step(0.85, 1, m_raw),
            (u1 - u0) * u + (v1 - v0) * v};
}

constexpr int kRaysAcross = 11;  // of the metering
constexpr double kKey = 0.75;    // light on an average wall, as a share of its albedo
constexpr double kPower = 0.75;
constexpr double kNear_mm = 5, kFar_mm = 45;

double arriving(double far_mm) {
    return 1 / (far_mm * far_mm + kLampSize_mm * kLampSize_mm);
}

}  // namespace

RealLook::RealLook(const VolumeRays& rays, const EyeRays& eye_rays, const Endoscope& endoscope,
                   const Camera& camera)
    : m_rays(rays),
      m_endoscope(endoscope),
      m_input{{rays.volume, rays.voxel_from_world},
              endoscope.iso_hu,
              endoscope.polarity == Polarity::Rising,
              lining_colours(endoscope.lining),
              {},
              metered_exposure(eye_rays, camera, endoscope.field_stop),
              0},
      m_radius(std::min(1.0, camera.aspect())) {
    for (int n = 0; n < 2; ++n)
        m_input.lamps[n] = endoscope.eye_mm +
                           (n == 0 ? kLampAside_mm : -kLampAside_mm) * camera.right() +
                           kLampAbove_mm * camera.up();
    const Vec3d s = rays.volume.grid.spacing_mm;
    m_input.voxel_mm = std::clamp(std::cbrt(s.x * s.y * s.z), 0.4, 1.2);
}

Vec3d RealLook::shade(const LookHit& hit) const {
    RestField::Sample moved;
    if (m_endoscope.rest) moved = m_endoscope.rest->at(m_rays.to_voxel(hit.point_mm));
    return shade(hit, moved);
}

Vec3d RealLook::shade(const LookHit& hit, const RestField::Sample& moved) const {
    const PlainScan scan{m_rays};
    const Light<PlainScan> light(m_input, scan);
    const double raw = double(moved.raw);
    const Vec3d rest = hit.point_mm - to_double(moved.offset_mm);
    if (!(raw > 0)) {
        const Coat own = light.coat(hit.t, hit.point_mm, hit.normal, rest,
                                    [](Vec3d&, Vec3d&, double) { return 0.0; });
        return light.shade(hit.t, hit.point_mm, hit.direction, {hit.point_mm, hit.normal}, own);
    }
    const RawWall wall(m_input, m_rays, *m_endoscope.rest, raw);
    const Face face = wall.face(hit);
    // Cut or carved tissue has no lining.
    const auto wounds = [&](Vec3d& colour, Vec3d& normal, double fine) {
        const double ragged = smooth_step(0.65, 0.95, raw + 0.15 * (fine - 0.5));
        colour = mix(colour, (0.7 + 0.6 * fine) * kFlesh, ragged);
        if (ragged > 0) {
            const Slit slit = wall.slit(hit.point_mm, face.normal);
            colour = mix(colour, kSlit, slit.depth);
            normal = normalized(normal + ragged * slit.towards);
        }
        return ragged;
    };
    const Coat own = light.coat(hit.t, hit.point_mm, face.normal, rest, wounds);
    return light.shade(hit.t, hit.point_mm, hit.direction, face, own);
}

void RealLook::shade(std::span<const LookHit> hits, Vec3d* light) const {
    if (!is_vectorised(m_rays.volume)) {
        for (const LookHit& hit : hits) *light++ = shade(hit);
        return;
    }
    const RestField* const rest = m_endoscope.rest;
    if (!rest || rest->halves().empty()) return shade_hits(m_input, hits, {}, light);
    constexpr std::size_t kChunk = 64;
    for (std::size_t begin = 0; begin < hits.size(); begin += kChunk) {
        const auto chunk = hits.subspan(begin, std::min(kChunk, hits.size() - begin));
        RestField::Sample moved[kChunk];
        Vec3f offsets[kChunk];
        for (std::size_t n = 0; n < chunk.size(); ++n) {
            moved[n] = rest->at(m_rays.to_voxel(chunk[n].point_mm));
            offsets[n] = moved[n].offset_mm;
        }
        shade_hits(m_input, chunk, std::span(offsets, chunk.size()), light + begin);
        for (std::size_t n = 0; n < chunk.size(); ++n)
            if (moved[n].raw > 0) light[begin + n] = shade(chunk[n], moved[n]);
    }
}

double RealLook::field(double u, double v) const {
    u /= m_radius;
    v /= m_radius;
    const double round = std::sqrt(u * u + v * v);
    double radius = 0;
    switch (m_endoscope.field_stop) {
        case FieldStop::Round:
            radius = round;
            break;
        case FieldStop::Octagon:
            radius = std::max(
                {std::abs(u), std::abs(v), (std::abs(u) + std::abs(v)) * std::numbers::sqrt2 / 2});
            break;
        case FieldStop::Full:
            break;
    }
    return (1 - 0.35 * smooth_step(0.45, 1.05, round)) * (1 - smooth_step(0.985, 1.005, radius));
}

double metered_exposure(const EyeRays& rays, const Camera& camera, FieldStop field_stop) {
    const bool full = field_stop == FieldStop::Full;
    const double radius = std::min(1.0, camera.aspect());
    const double half_width = full ? camera.aspect() : radius, half_height = full ? 1 : radius;
    std::vector<Vec3d> directions;
    for (int j = 0; j < kRaysAcross; ++j)
        for (int i = 0; i < kRaysAcross; ++i) {
            const double u = (2 * i + 1.0) / kRaysAcross - 1, v = (2 * j + 1.0) / kRaysAcross - 1;
            if (full || u * u + v * v <= 1)
                directions.push_back(camera.through(half_width * u, half_height * v));
        }
    std::vector<double> far_mm(directions.size());
    for (std::size_t n = 0; n < directions.size(); ++n)  // too far apart to share a beam
        rays.hit_distances(std::span(&directions[n], 1), &far_mm[n]);
    // Power mean of exponent 3/4: a near fold has less weight than in a mean, so that it doesn't
    // darken the lumen, and more than in a median, so that it is not overexposed.
    double sum = 0;
    for (const double d : far_mm) sum += std::isinf(d) ? 0 : std::pow(arriving(d), kPower);
    const double mean = std::pow(sum / double(far_mm.size()), 1 / kPower);
    return kKey / std::clamp(mean, arriving(kFar_mm), arriving(kNear_mm));
}

}  // namespace pliant::render
