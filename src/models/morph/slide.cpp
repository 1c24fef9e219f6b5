// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "morph/slide.h"

#include <array>
#include <cmath>
#include <limits>

namespace pliant::morph {
namespace {

/// Points are as far apart as this where their normals differ by a vector of length 1 [mm].
constexpr float kNormalMm = 20;

/// Points with normals, component by component, for a search of all that is vectorised.
class Oriented {
  public:
    void add(Vec3d point, Vec3d normal) {
        for (int a = 0; a < 3; ++a) {
            m_of[std::size_t(a)].push_back(float(point[a]));
            m_of[std::size_t(3 + a)].push_back(kNormalMm * float(normal[a]));
        }
        m_distance.resize(m_of[0].size());
    }

    /// Index of the nearest point. @pre there is one
    std::size_t nearest(Vec3d point, Vec3d normal) {
        float* const distance = m_distance.data();
        const std::size_t count = m_distance.size();
        for (std::size_t n = 0; n < count; ++n) distance[n] = 0;
        for (std::size_t a = 0; a < 6; ++a) {
            const float at = a < 3 ? float(point[int(a)]) : kNormalMm * float(normal[int(a) - 3]);
            const float* const of = m_of[a].data();
            for (std::size_t n = 0; n < count; ++n) {
                const float d = of[n] - at;
                distance[n] += d * d;
            }
        }
        std::size_t best = 0;
        for (std::size_t n = 1; n < count; ++n)
            if (distance[n] < distance[best]) best = n;
        return best;
    }

  private:
    std::array<std::vector<float>, 6> m_of;
    std::vector<float> m_distance;
};

Oriented image_of(const Part& part) {
    Oriented image;
    for (std::size_t n = 0; n < part.to.points.size(); ++n)
        image.add(part.to.points[n], part.to.normals[n]);
    return image;
}

}  // namespace

std::vector<Slide> slides_of(const Part& part, const Moved& moved) {
    std::vector<Slide> slides;
    // Along the mean of the two normals, to which the chord of a curved surface is perpendicular:
    // points beside each other on one sphere have no gap [Rusinkiewicz2019].
    const auto add = [&](std::size_t n, std::size_t image) {
        const Vec3d sum = part.to.normals[image] + moved.normals[n];
        const double length = norm(sum);
        const Vec3d m = length > 0.1 ? (1 / length) * sum : part.to.normals[image];
        slides.push_back({n, m, dot(m, part.to.points[image] - part.from.points[n])});
    };
    Oriented image = image_of(part), surface;
    for (std::size_t n = 0; n < moved.points.size(); ++n) {
        add(n, image.nearest(moved.points[n], moved.normals[n]));
        surface.add(moved.points[n], moved.normals[n]);
    }
    for (const std::size_t n : part.sample_to)
        add(surface.nearest(part.to.points[n], part.to.normals[n]), n);
    return slides;
}

double surface_residual_mm(const Part& part, const Moved& moved) {
    Oriented image = image_of(part);
    double sum = 0;
    for (std::size_t n = 0; n < moved.points.size(); ++n) {
        const std::size_t near = image.nearest(moved.points[n], moved.normals[n]);
        sum += std::abs(dot(part.to.normals[near], part.to.points[near] - moved.points[n]));
    }
    return sum / double(moved.points.size());
}

Vec3d moved_normal(const Mat3d& gradient, Vec3d normal) {
    Mat3d f = gradient;
    for (int a = 0; a < 3; ++a) f.columns[a][a] += 1;
    if (!(std::abs(determinant(f)) > 1e-6)) return normal;
    const Vec3d turned = transposed(inverse(f)) * normal;
    const double length = norm(turned);
    return length > 0 ? (1 / length) * turned : normal;
}

}  // namespace pliant::morph
