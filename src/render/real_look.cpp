// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/real_look.h"

#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/exposure.h"

namespace pliant::render {
namespace {

constexpr double kLampAside_mm = 1.6, kLampAbove_mm = 0.5;
constexpr double kSoftHu = 300;                 // width of a shadow's edge
constexpr Vec3d kWrap{0.38, 0.14, 0.10};        // red light penetrates tissue farther
constexpr Vec3d kClosedTint{0.30, 0.15, 0.13};  // share of light left in occluded places
constexpr Vec3d kBlood{0.42, 0.10, 0.14};       // transmission of a blood vessel
constexpr Vec3d kLampColour{1.0, 0.97, 0.94};
constexpr double kAcross = 4;                // distance of the samples beside a slit [voxels]
constexpr Vec3d kSlit{0.045, 0.004, 0.005};  // blood in a slit
constexpr double kShadow = 0.35;             // share of light left in a shadow
constexpr int kShadowTaps = 6;
constexpr double kGlintReach_mm = 15;    // distance at which glints are twice as wide
constexpr double kFaceSteps[] = {2, 3};  // distances of the samples around a raw face [voxels]
constexpr double kFarthest = 1.5;     // largest distance of a raw face to the voxels' wall [voxels]
constexpr double kFaceSoftHu = 1000;  // a step between tissue and air has no flat sides

double smooth_step(double low, double high, double x) {
    const double s = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return s * s * (3 - 2 * s);
}
double mix(double a, double b, double s) {
    return a + s * (b - a);
}
Vec3d mix(Vec3d a, Vec3d b, double s) {
    return a + s * (b - a);
}
Vec3d times(Vec3d a, Vec3d b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// Trowbridge and Reitz's distribution of microfacets ("GGX" in [Walter2007]), with a = roughness².
double facets(double cosine, double a) {
    const double d = cosine * cosine * (a - 1) + 1;
    return a / (std::numbers::pi * d * d);
}

/// Tone curve of [Narkowicz2015]: highlights approach white without clipping.
double tone(double x) {
    x *= 0.9;
    return std::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

/// A line on the wall along the noise's level 0.5, with a given half width [cells]. It fades out
/// where the noise is flat along the wall, because it would widen to a patch.
double line_at_half(const NoiseTile::Value& n, Vec3d normal, double half_width) {
    const Vec3d slope = to_double(n.slope);
    const double along = norm(slope - dot(slope, normal) * normal);
    const double width = half_width * smooth_step(0.25, 0.7, along);
    const double away = std::abs(double(n.value) - 0.5) / std::max(along, 0.25);
    return width > 0 ? 1 - smooth_step(0.3 * width, width, away) : 0;
}

}  // namespace

RealLook::RealLook(const VolumeRays& rays, const EyeRays& eye_rays, const Endoscope& endoscope,
                   const Camera& camera)
    : m_rays(rays),
      m_endoscope(endoscope),
      m_colours(lining_colours(endoscope.lining)),
      m_noise(NoiseTile::instance()),
      m_exposure(metered_exposure(eye_rays, camera, endoscope.field_stop)),
      m_radius(std::min(1.0, camera.aspect())) {
    for (int n = 0; n < 2; ++n)
        m_lamps[n] = endoscope.eye_mm + (n == 0 ? kLampAside_mm : -kLampAside_mm) * camera.right() +
                     kLampAbove_mm * camera.up();
    const Vec3d s = rays.volume.grid.spacing_mm;
    m_spacing_mm = std::cbrt(s.x * s.y * s.z);
    m_voxel_mm = std::clamp(m_spacing_mm, 0.4, 1.2);
    const Grid& grid = rays.volume.grid;
    for (int a = 0; a < 3; ++a) m_voxel_axes[a] = s[a] * grid.direction.columns[a];
}

double RealLook::value_behind(Vec3d point_mm, Vec3d normal, double voxels) const {
    return m_rays.sample(point_mm - voxels * m_voxel_mm * normal);
}

double RealLook::excess(Vec3d point_mm) const {
    const double above = m_rays.sample(point_mm) - m_endoscope.iso_hu;
    return m_endoscope.polarity == Polarity::Rising ? above : -above;
}

double RealLook::openness(Vec3d point_mm, Vec3d normal) const {
    double closed = 0;
    for (const double step_mm : {1.0, 2.0, 4.0})
        closed += std::clamp(excess(point_mm + step_mm * normal) / 400 + 0.5, 0.0, 1.0);
    return 1 - closed / 3;
}

double RealLook::lit(Vec3d point_mm, Vec3d normal, Vec3d to_lamp, double far_mm) const {
    const double step_mm = std::min(far_mm / 8, 1.5);
    double dark = 0;
    for (int n = 1; n <= kShadowTaps; ++n) {
        const double way_mm = 0.5 + n * step_mm;
        if (way_mm > far_mm - 0.8) break;
        const double e = excess(point_mm + 0.4 * normal + way_mm * to_lamp) / kSoftHu + 0.3;
        dark = std::max(dark, std::clamp(e, 0.0, 1.0));
    }
    return mix(1, kShadow, dark);
}

RealLook::Face RealLook::raw_face(Vec3d point_mm, Vec3d normal, Vec3d direction, double raw) const {
    const auto tissue_at = [&](Vec3d at_mm) {
        return std::clamp(excess(at_mm) / kFaceSoftHu + 0.5, 0.0, 1.0);
    };
    double share = tissue_at(point_mm), far = 0;
    int count = 1;
    Vec3d slope{0, 0, 0};  // per voxel, along the grid's axes
    for (int n = 0; n < 27; ++n) {
        if (n == 13) continue;
        const Vec3d d =
            normalized(Vec3d{double(n % 3 - 1), double(n / 3 % 3 - 1), double(n / 9 - 1)});
        const Vec3d way = d.x * m_voxel_axes[0] + d.y * m_voxel_axes[1] + d.z * m_voxel_axes[2];
        for (const double step : kFaceSteps) {
            const double tissue = tissue_at(point_mm + step * way);
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
    if (!(steepness > 1e-6)) return {point_mm, normal};
    Vec3d smooth = (-1 / steepness) * gradient;
    smooth = smooth - std::max(dot(smooth, direction), 0.0) * direction;
    if (!(norm(smooth) > 1e-3)) return {point_mm, normal};
    const double weight = smooth_step(0.1, 0.6, raw);
    const double far_mm = kFarthest * m_spacing_mm;
    const double off_mm = std::clamp((share - 0.5) / steepness, -far_mm, far_mm);
    return {point_mm + weight * off_mm * normalized(smooth),
            normalized(mix(normal, normalized(smooth), weight))};
}

RealLook::Slit RealLook::slit_at(Vec3d point_mm, Vec3d normal, double raw) const {
    const Vec3d side = std::abs(normal.z) < 0.7 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
    const Vec3d u = normalized(cross(normal, side)), v = cross(normal, u);
    const double step_mm = kAcross * m_spacing_mm;
    const auto raw_at = [&](Vec3d way) {
        return double(m_endoscope.rest->at(m_rays.to_voxel(point_mm + step_mm * way)).raw);
    };
    const double u0 = raw_at(-1.0 * u), u1 = raw_at(u), v0 = raw_at(-1.0 * v), v1 = raw_at(v);
    // A ridge of the field; an open face is no ridge.
    const double ridge = raw - std::min(std::max(u0, u1), std::max(v0, v1));
    return {std::clamp(ridge / 0.3, 0.0, 1.0) * smooth_step(0.85, 1, raw),
            (u1 - u0) * u + (v1 - v0) * v};
}

RealLook::Coat RealLook::coat(double t, Vec3d point_mm, Vec3d normal) const {
    const LiningColours& c = m_colours;
    const double shallow = value_behind(point_mm, normal, 2.5);
    const double deep = value_behind(point_mm, normal, 4);
    // Between air and tissue every value occurs once, so fat requires two depths with fat's values.
    const auto fat_at = [](double hu) {
        return smooth_step(-135, -95, hu) * (1 - smooth_step(-55, -20, hu));
    };
    const double fat = std::min(fat_at(shallow), fat_at(deep)) *
                       (1 - smooth_step(25, 70, std::abs(shallow - deep)));
    const double most = std::max(shallow, deep);
    const bool rising = m_endoscope.polarity == Polarity::Rising;
    const double dense = rising ? smooth_step(80, 260, most) : smooth_step(90, 160, deep);
    const double bone = rising ? smooth_step(280, 650, most) : smooth_step(250, 500, deep);
    const double thin = 1 - smooth_step(-750, -350, std::min(shallow, deep));
    Vec3d own = mix(c.mucosa, c.fatty, c.fat_share * fat);
    own = mix(own, c.pale, c.pale_share * dense);
    own = mix(own, c.bony, c.bone_share * bone);
    own = mix(own, c.thin_wall, c.thin_share * thin);

    RestField::Sample moved{{0, 0, 0}, 0};
    if (m_endoscope.rest) moved = m_endoscope.rest->at(m_rays.to_voxel(point_mm));
    const Vec3d rest = point_mm - to_double(moved.offset_mm);
    const NoiseTile::Value wide = m_noise.at(0.055 * rest + Vec3d{3.1, 7.7, 1.3});
    const NoiseTile::Value middle = m_noise.at(0.21 * rest);
    const NoiseTile::Value fine = m_noise.at(0.9 * rest + Vec3d{5.5, 2.5, 8.5});
    const double patches =
        0.5 * double(wide.value) + 0.3 * double(middle.value) + 0.2 * double(fine.value) - 0.5;
    own = (1 + c.mottle * patches) * own;

    // Blood vessels: level lines of a noise in a domain warped by another noise. Small vessels
    // appear near large ones.
    const Vec3d bent = rest + 1.3 * to_double(middle.slope) + 0.2 * to_double(fine.slope);
    const NoiseTile::Value trunk = m_noise.at(0.13 * bent + Vec3d{9.1, 4.3, 6.7});
    const NoiseTile::Value twig = m_noise.at(0.36 * bent + Vec3d{1.9, 3.3, 0.7});
    const NoiseTile::Value hair = m_noise.at(0.85 * bent + Vec3d{4.2, 0.6, 2.8});
    const double where = smooth_step(0.34, 0.6, double(wide.value));
    const double near = 1 - smooth_step(0.12, 0.45, std::abs(double(trunk.value) - 0.5));
    const double twigs = near * smooth_step(0.25, 0.55, double(middle.value));
    const double veins = std::max(
        {0.80 * line_at_half(trunk, normal, 0.034 * where) * (1 - smooth_step(35, 80, t)),
         0.55 * line_at_half(twig, normal, 0.050 * twigs) * (1 - smooth_step(16, 45, t)),
         0.34 * line_at_half(hair, normal, 0.080 * smooth_step(0.34, 0.6, double(twig.value))) *
             (1 - smooth_step(8, 24, t))});
    own = mix(own, times(own, kBlood), c.vein_share * veins * (1 - bone));
    // Cut or carved tissue has no lining.
    const double ragged = double(moved.raw) + 0.15 * (double(fine.value) - 0.5);
    const double raw = double(moved.raw) > 0 ? smooth_step(0.65, 0.95, ragged) : 0;
    own = mix(own, (0.7 + 0.6 * double(fine.value)) * kFlesh, raw);
    Vec3d bent_normal = normal;  // bent towards a slit at its lips
    if (raw > 0) {
        const Slit slit = slit_at(point_mm, normal, double(moved.raw));
        own = mix(own, kSlit, slit.depth);
        bent_normal = normalized(normal + raw * slit.towards);
    }

    // Film of liquid: it follows folds below the voxel size.
    const NoiseTile::Value ripple = m_noise.at(1.9 * rest + Vec3d{2.2, 6.1, 4.4});
    const Vec3d bump = 0.26 * 0.9 * to_double(fine.slope) + 0.20 * 1.9 * to_double(ripple.slope);
    const double fade = 1 - smooth_step(8, 60, t);
    const Vec3d film = normalized(bent_normal - fade * (bump - dot(bump, normal) * normal));
    return {own, bent_normal, film,
            c.gloss * (0.45 + 1.1 * double(middle.value)) * (1 + 0.6 * raw)};
}

Vec3d RealLook::shade(double t, Vec3d point_mm, Vec3d normal, Vec3d direction) const {
    Face face{point_mm, normal};
    const double raw =
        m_endoscope.rest ? double(m_endoscope.rest->at(m_rays.to_voxel(point_mm)).raw) : 0;
    if (raw > 0) face = raw_face(point_mm, normal, direction, raw);
    const Coat own = coat(t, point_mm, face.normal);
    const double open = openness(face.point_mm, face.normal);
    const Vec3d rough = normalized(own.normal + 0.35 * (own.film - own.normal));
    // Far away a pixel covers many folds: glints are wider and weaker, or single pixels would be
    // white specks in dark lumina.
    const double blur = 1 + t * t / (kGlintReach_mm * kGlintReach_mm);
    Vec3d total{0, 0, 0};
    for (const Vec3d lamp : m_lamps) {
        const Vec3d way = lamp - point_mm;
        const double far_mm = norm(way);
        const Vec3d to_lamp = (1 / std::max(far_mm, 1e-6)) * way;
        const double facing = dot(rough, to_lamp);
        const double falloff = m_exposure / (far_mm * far_mm + kLampSize_mm * kLampSize_mm);
        const double arrives = 0.5 * falloff * lit(face.point_mm, face.normal, to_lamp, far_mm);
        const Vec3d half = normalized(to_lamp - direction);
        const double cosine = std::max(dot(own.film, half), 0.0);
        const double fresnel = 0.04 + 0.96 * std::pow(1 - std::max(dot(half, to_lamp), 0.0), 5.0);
        const double shine =
            fresnel * own.wetness * open * std::clamp(4 * facing, 0.0, 1.0) *
            (1.5 / blur * facets(cosine, 0.0012 * blur) + 0.25 * facets(cosine, 0.05));
        for (int c = 0; c < 3; ++c) {
            const double through = std::clamp((facing + kWrap[c]) / (1 + kWrap[c]), 0.0, 1.0);
            const double around = mix(kClosedTint[c], 1, open);
            total[c] += arrives * (own.colour[c] * through * around + kLampColour[c] * shine);
        }
    }
    return {tone(total.x), tone(total.y), tone(total.z)};
}

double RealLook::field(double u, double v) const {
    u /= m_radius;
    v /= m_radius;
    const double round = std::sqrt(u * u + v * v);
    double place = 0;
    switch (m_endoscope.field_stop) {
        case FieldStop::Round:
            place = round;
            break;
        case FieldStop::Octagon:
            place = std::max(
                {std::abs(u), std::abs(v), (std::abs(u) + std::abs(v)) * std::numbers::sqrt2 / 2});
            break;
        case FieldStop::Full:
            break;
    }
    return (1 - 0.35 * smooth_step(0.45, 1.05, round)) * (1 - smooth_step(0.985, 1.005, place));
}

}  // namespace pliant::render
