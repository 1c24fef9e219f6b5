// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/ogden.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/small_matrix.h"

namespace pliant::pbd {
namespace {

/// Values of 2ψ below this come from the gradient: strains of about 1e-5.
constexpr double kSmallOgden = 1e-10;
/// Relative difference below which a divided difference is a series: its error, and that of
/// rounding, are then below 1e-11.
constexpr double kEqualStretches = 1e-4;

/// Tangent of a stretch, over that at rest, up to which a sub-step begins with all forces of the
/// last one: 11 % of compression with an exponent of −18. With the forces of flat and inverted
/// tetrahedra, blocks would not return to rest.
constexpr double kMostRecalled = 10;

Vec3d as_vec(const Triple<double>& t) {
    return {t.x, t.y, t.z};
}
Triple<double> as_triple(Vec3d v) {
    return {v.x, v.y, v.z};
}

/// Some vector of length 1 that is perpendicular to another of length 1.
Vec3d perpendicular(Vec3d a) {
    const double x = std::abs(a.x), y = std::abs(a.y), z = std::abs(a.z);
    const Vec3d axis = x <= y && x <= z ? Vec3d{1, 0, 0} : y <= z ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
    return normalized(pliant::cross(a, axis));
}

/// c of ψ.
double volume_share(double alpha) {
    return alpha > 0 ? 1 / alpha : 0;
}

/// The pure power, whose tangent is given.
StretchTerm power_term(double alpha, double stretch, double tangent) {
    const double slope = 2 / alpha * tangent * stretch;
    return {slope * stretch / alpha, slope, 2 / alpha * (alpha - 1) * tangent};
}

/// (ϕ′(a) − ϕ′(b))/(a − b) of a term of the stretches a and b.
double divided_difference(double alpha, const StretchTerm& of_a, const StretchTerm& of_b, double a,
                          double b) {
    const double apart = a - b;
    if (std::abs(apart) > kEqualStretches * (std::abs(a) + std::abs(b)))
        return (of_a.slope - of_b.slope) / apart;
    // ϕ″ in the middle + (a − b)²/24 ϕ⁗; the second term is that of the power.
    const double middle = 0.5 * (a + b);
    const double curve = ogden_term(alpha, middle).curve;
    if (!(middle > 0)) return curve;
    return curve * (1 + apart * apart * (alpha - 2) * (alpha - 3) / (24 * middle * middle));
}

/// The matrix of ∂ψ/∂λ at rotations of the axes.
Mat3d turned(const Stretches& s, Vec3d diagonal) {
    const Mat3d scaled{
        {diagonal.x * s.u.columns[0], diagonal.y * s.u.columns[1], diagonal.z * s.u.columns[2]}};
    return scaled * transposed(s.v);
}

/// Gradient of a function of F at the last three corners.
void at_corners(const Mat3d& stress, const OgdenSolid& s, Triple<double>* gradients) {
    for (int k = 0; k < 3; ++k)
        gradients[k] = as_triple(stress * Vec3d{s.inverse[k][0], s.inverse[k][1], s.inverse[k][2]});
}

/// Σₖ dₖ ⊗ (row k of the inverse): F of the edges, or dF of their changes.
Mat3d gradient_of(const Vec3d (&edges)[3], const OgdenSolid& s) {
    Mat3d f{};
    for (int j = 0; j < 3; ++j)
        f.columns[j] =
            s.inverse[0][j] * edges[0] + s.inverse[1][j] * edges[1] + s.inverse[2][j] * edges[2];
    return f;
}
Mat3d gradient_of(const Corner<double> (&p)[4], const OgdenSolid& s) {
    const Vec3d edges[3] = {as_vec(p[1].p - p[0].p), as_vec(p[2].p - p[0].p),
                            as_vec(p[3].p - p[0].p)};
    return gradient_of(edges, s);
}
/// ∂J/∂F.
Mat3d cofactor(const Mat3d& f) {
    const auto& c = f.columns;
    return {{pliant::cross(c[1], c[2]), pliant::cross(c[2], c[0]), pliant::cross(c[0], c[1])}};
}

}  // namespace

Stretches stretches_of(const Mat3d& f) {
    Matrix3 c{};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) c[a][b] = pliant::dot(f.columns[a], f.columns[b]);
    const auto eigen = symmetric_eigen(c);  // ascending
    Stretches s{};
    for (int n = 0; n < 2; ++n) {
        const auto& vector = eigen.vectors[std::size_t(2 - n)];
        s.v.columns[n] = {vector[0], vector[1], vector[2]};
    }
    s.v.columns[2] = pliant::cross(s.v.columns[0], s.v.columns[1]);
    // Two vectors by F, the third by a cross product: its stretch has the sign of the volume.
    const Vec3d first = f * s.v.columns[0];
    const double longest = norm(first);
    s.u.columns[0] = longest > 0 ? (1 / longest) * first : s.v.columns[0];
    const Vec3d second = f * s.v.columns[1];
    const Vec3d across = second - pliant::dot(second, s.u.columns[0]) * s.u.columns[0];
    const double wide = norm(across);
    s.u.columns[1] = wide > std::numeric_limits<double>::epsilon() * longest
                         ? (1 / wide) * across
                         : perpendicular(s.u.columns[0]);
    s.u.columns[2] = pliant::cross(s.u.columns[0], s.u.columns[1]);
    for (int n = 0; n < 3; ++n) s.values[n] = pliant::dot(s.u.columns[n], f * s.v.columns[n]);
    return s;
}

StretchTerm ogden_term(double alpha, double stretch) {
    if (alpha == 2) return power_term(alpha, stretch, 1);
    const double exponent = alpha - 2;
    const double tangent = stretch > 0    ? std::pow(stretch, exponent)
                           : exponent < 0 ? std::numeric_limits<double>::infinity()
                                          : 0;
    const bool is_soft = exponent > 0 && tangent < 1 / kStiffest;
    if (tangent <= kStiffest && !is_soft) return power_term(alpha, stretch, tangent);
    const double bound = is_soft ? 1 / kStiffest : kStiffest;
    const double from = std::pow(bound, 1 / exponent), by = stretch - from;
    const StretchTerm at = power_term(alpha, from, bound);
    return {at.value + by * (at.slope + 0.5 * by * at.curve), at.slope + by * at.curve, at.curve};
}

double ogden_volume_stiffness(double alpha, double lambda) {
    return lambda + 2 * (1 / alpha - volume_share(alpha));
}

OgdenPoint ogden_point(double alpha, const Mat3d& f) {
    OgdenPoint at{};
    at.alpha = alpha;
    at.stretches = stretches_of(f);
    const Vec3d s = at.stretches.values;
    const double j = s.x * s.y * s.z, change = j - 1;
    const double c = volume_share(alpha);
    at.value = change * (c * change - 2 / alpha) - 6 / (alpha * alpha);
    at.volume_slope = 2 * (c * change - 1 / alpha);
    at.volume_curve = 2 * c;
    for (int n = 0; n < 3; ++n) {
        at.terms[n] = ogden_term(alpha, s[n]);
        at.value += at.terms[n].value;
        at.slope[n] = at.terms[n].slope + at.volume_slope * s[(n + 1) % 3] * s[(n + 2) % 3];
    }
    return at;
}

Mat3d ogden_stress(const OgdenPoint& at) {
    return turned(at.stretches, at.slope);
}

double ogden_curve(const OgdenPoint& at, const Mat3d& df, bool positive) {
    const Vec3d s = at.stretches.values;
    const Mat3d d = transposed(at.stretches.u) * df * at.stretches.v;
    const auto block = [&](double value) { return positive ? std::max(0.0, value) : value; };
    double stretching = 0, j_change = 0, sum = 0;
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;  // the pair b, c, and the third axis a
        const double change = d.columns[a][a];
        stretching += at.terms[a].curve * change * change +
                      2 * at.volume_slope * s[a] * d.columns[b][b] * d.columns[c][c];
        j_change += s[b] * s[c] * change;
        const double bc = d.columns[c][b], cb = d.columns[b][c];
        const double shear = 0.5 * (bc + cb) * (bc + cb), twist = 0.5 * (bc - cb) * (bc - cb);
        const double by_shear = divided_difference(at.alpha, at.terms[b], at.terms[c], s[b], s[c]) -
                                at.volume_slope * s[a];
        const double total = s[b] + s[c], slopes = at.terms[b].slope + at.terms[c].slope;
        const double by_twist =
            (std::abs(total) > kEqualStretches ? slopes / total : 0) + at.volume_slope * s[a];
        sum += block(by_shear * shear) + block(by_twist * twist);
    }
    return sum + block(stretching + at.volume_curve * j_change * j_change);
}

OgdenSolid ogden_solid(const SolidNumbers& numbers) {
    OgdenSolid s{};
    for (int n = 0; n < 9; ++n) s.inverse[n / 3][n % 3] = numbers.inverse[n];
    s.alpha = numbers.ogden_alpha;
    return s;
}

SolidGradients<double> ogden_constraints(const Corner<double> (&p)[4], const OgdenSolid& s) {
    const Mat3d f = gradient_of(p, s);
    const OgdenPoint at = ogden_point(s.alpha, f);
    const double by_gradient = 0.5 * pliant::dot(at.slope, at.slope);
    SolidGradients<double> c;
    c.h = determinant(f) - 1;
    c.e = std::sqrt(2 * at.value > kSmallOgden ? 2 * at.value : by_gradient);
    at_corners(cofactor(f), s, c.gh + 1);
    at_corners(ogden_stress(at), s, c.ge + 1);
    const double per_e = inverse_or_0(c.e);
    for (int n = 1; n < 4; ++n) c.ge[n] = scaled(per_e, c.ge[n]);
    c.gh[0] = scaled(-1.0, c.gh[1] + c.gh[2] + c.gh[3]);
    c.ge[0] = scaled(-1.0, c.ge[1] + c.ge[2] + c.ge[3]);
    return c;
}

OgdenGradients ogden_gradients(const Corner<double> (&p)[4], const OgdenSolid& s,
                               double e_stiffness) {
    const Mat3d f = gradient_of(p, s);
    const OgdenPoint at = ogden_point(s.alpha, f);
    OgdenGradients r{};
    r.share = 1;
    auto& g = r.gradients;
    g.h = determinant(f) - 1;
    if (std::abs(g.h) <= kLeastStrain) g.h = 0;
    at_corners(cofactor(f), s, g.gh + 1);
    at_corners(ogden_stress(at), s, g.gq + 1);
    // The mean of all directions at rest, as mean_shear().
    double strain = 0, size = 0;
    Vec3d sum{0, 0, 0};
    for (int n = 0; n < 3; ++n) {
        const Vec3d row{s.inverse[n][0], s.inverse[n][1], s.inverse[n][2]};
        const double square = pliant::dot(row, row);
        strain += dot(g.gq[n + 1], g.gq[n + 1]);
        size += square;
        r.shear += p[n + 1].w * square;
        sum = sum + row;
    }
    r.shear = 2.0 / 3 * e_stiffness * (r.shear + p[0].w * pliant::dot(sum, sum));
    if (!(strain > kLeastStrain * kLeastStrain * size)) {
        for (auto& gradient : g.gq) gradient = {0, 0, 0};
        balance(g.gh);
        return r;
    }
    balance(g.gh);
    balance(g.gq);
    // Stiffness of the stiffest stretch, in any direction.
    double stiffest = 1;
    for (const StretchTerm& term : at.terms)
        stiffest = std::max(stiffest, term.curve * s.alpha / (2 * (s.alpha - 1)));
    r.shear *= stiffest;
    r.share = std::min(1.0, kMostRecalled / stiffest);
    // The stiffness along the particles' motion by ∇ψ.
    Vec3d edges[3];
    double square = 0;
    for (int n = 0; n < 4; ++n) square += p[n].w * dot(g.gq[n], g.gq[n]);
    for (int n = 0; n < 3; ++n)
        edges[n] = as_vec(scaled(p[n + 1].w, g.gq[n + 1]) + scaled(p[0].w, g.gq[0]));
    if (square > 0)
        r.shear =
            std::max(r.shear, e_stiffness * ogden_curve(at, gradient_of(edges, s), true) / square);
    return r;
}

}  // namespace pliant::pbd
