// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Ogden's law: stresses against closed forms, derivatives against finite differences, equal and
// negative stretches, and bodies in uniaxial tension and compression.
// Covers: pbd/ogden.cpp.

#include <gtest/gtest.h>
#include <pliant/models/pbd.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "pbd/ogden.h"
#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using pbd::ogden_point;
using pbd::OgdenPoint;

constexpr double kExponents[] = {-40, -18, -7.5, -2, -1, 2.5, 2, 3, 8, 25};

Mat3d stretched(Vec3d s) {
    return {{{s.x, 0, 0}, {0, s.y, 0}, {0, 0, s.z}}};
}
Mat3d random_matrix(Random& random, double size) {
    return {{random.vector(size), random.vector(size), random.vector(size)}};
}
double inner(const Mat3d& a, const Mat3d& b) {
    double sum = 0;
    for (int n = 0; n < 3; ++n) sum += dot(a.columns[n], b.columns[n]);
    return sum;
}
Mat3d sum_of(const Mat3d& a, double by, const Mat3d& b) {
    Mat3d m = a;
    for (int n = 0; n < 3; ++n) m.columns[n] = m.columns[n] + by * b.columns[n];
    return m;
}
double norm_of(const Mat3d& m) {
    return std::sqrt(inner(m, m));
}
double energy_of(double alpha, const Mat3d& f) {
    return ogden_point(alpha, f).value;
}
Mat3d stress_of(double alpha, const Mat3d& f) {
    return pbd::ogden_stress(ogden_point(alpha, f));
}

TEST(OgdenLaw, StretchesAreASignedDecompositionByRotations) {
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Mat3d f = random_matrix(random, 1);
        if (seed % 5 == 1) f = random.rotation(false);
        if (seed % 5 == 2) f.columns[2] = f.columns[0];              // flat
        if (seed % 5 == 3) f.columns[1] = f.columns[2] = {0, 0, 0};  // a line
        if (seed == 4) f = {};
        const auto s = pbd::stretches_of(f);
        for (const Mat3d& r : {s.u, s.v}) {
            EXPECT_LT(norm_of(sum_of(transposed(r) * r, -1, kIdentity3)), 1e-13);
            EXPECT_NEAR(determinant(r), 1, 1e-13);
        }
        EXPECT_LT(norm_of(sum_of(s.u * stretched(s.values) * transposed(s.v), -1, f)), 2e-8);
        EXPECT_NEAR(s.values.x * s.values.y * s.values.z, determinant(f), 1e-8);
        EXPECT_GE(s.values.y, -1e-12);
    }
}

TEST(OgdenLaw, TermsHaveContinuousDerivativesAlsoForNegativeStretches) {
    constexpr double kStep = 1e-6;
    for (const double alpha : kExponents)
        for (double s = -0.5; s < 2; s += 0.0137) {
            const auto at = pbd::ogden_term(alpha, s), more = pbd::ogden_term(alpha, s + kStep),
                       less = pbd::ogden_term(alpha, s - kStep);
            const double size = 1 + std::abs(at.curve);
            EXPECT_NEAR(at.slope, (more.value - less.value) / (2 * kStep), 2e-8 * size);
            EXPECT_NEAR(at.curve, (more.slope - less.slope) / (2 * kStep), 4e-5 * size)
                << alpha << ", " << s;
            EXPECT_LE(at.curve, 2 * (1 - 1 / alpha) * pbd::kStiffest * (1 + 1e-12));
            EXPECT_GE(at.curve, 0);
        }
    // The bound: λ^(α − 2) = 100.
    EXPECT_NEAR(pbd::ogden_term(-18, 0.8).value, 2.0 / 324 * std::pow(0.8, -18), 1e-14);
    EXPECT_LT(pbd::ogden_term(-18, 0.79).value, 2.0 / 324 * std::pow(0.79, -18));
}

TEST(OgdenLaw, StressAndTangentAreDerivativesOfTheEnergy) {
    constexpr double kStep = 1e-5;
    int inverted = 0;
    for (std::uint64_t seed = 1; seed <= 500; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const double alpha = kExponents[seed % std::size(kExponents)];
        Mat3d f = sum_of(kIdentity3, 1, random_matrix(random, seed % 3 == 0 ? 1.2 : 0.15));
        if (seed % 3 == 1) f = random.rotation(false) * f;
        inverted += determinant(f) < 0;
        const OgdenPoint at = ogden_point(alpha, f);
        const Mat3d df = random_matrix(random, 1);
        const double size = norm_of(pbd::ogden_stress(at)) + norm_of(f);
        EXPECT_NEAR(
            inner(pbd::ogden_stress(at), df),
            (energy_of(alpha, sum_of(f, kStep, df)) - energy_of(alpha, sum_of(f, -kStep, df))) /
                (2 * kStep),
            1e-6 * size);
        // The limit of λᵢ + λⱼ → 0 has no derivative.
        const Vec3d s = at.stretches.values;
        if (std::abs(s.y + s.z) < 0.05) continue;
        const Mat3d change = sum_of(stress_of(alpha, sum_of(f, kStep, df)), -1,
                                    stress_of(alpha, sum_of(f, -kStep, df)));
        const double curve = inner(change, df) / (2 * kStep);
        double largest = 1;
        for (const auto& term : at.terms) largest = std::max(largest, term.curve);
        EXPECT_NEAR(pbd::ogden_curve(at, df, false), curve, 1e-4 * largest * inner(df, df));
        EXPECT_GE(pbd::ogden_curve(at, df, true), 0);
        EXPECT_GE(pbd::ogden_curve(at, df, true), pbd::ogden_curve(at, df, false) - 1e-12);
    }
    EXPECT_GT(inverted, 20);
}

TEST(OgdenLaw, EqualStretchesHaveTheLimitOfUnequalOnes) {
    constexpr double kStep = 1e-5;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const double alpha = kExponents[seed % std::size(kExponents)];
        const Mat3d r = random.rotation(false), q = random.rotation(false);
        const Mat3d df = random_matrix(random, 1);
        const double a = random.real(0.85, 1.15), b = random.real(0.85, 1.15);
        double before = 0;
        for (const double apart : {0.0, 1e-12, 1e-8, 1.9e-4, 2.3e-4})
            for (const Vec3d s : {Vec3d{a, a + apart, b}, {a, a + apart, a - apart}}) {
                const Mat3d f = r * stretched(s) * transposed(q);
                const double curve = pbd::ogden_curve(ogden_point(alpha, f), df, false);
                const Mat3d change = sum_of(stress_of(alpha, sum_of(f, kStep, df)), -1,
                                            stress_of(alpha, sum_of(f, -kStep, df)));
                EXPECT_NEAR(curve, inner(change, df) / (2 * kStep), 1e-5 * (1 + std::abs(curve)));
                before = curve;
            }
        EXPECT_TRUE(std::isfinite(before));
        // A sphere's stress has no direction.
        const OgdenPoint sphere = ogden_point(alpha, r * stretched({a, a, a}));
        const Mat3d stress = pbd::ogden_stress(sphere);
        EXPECT_LT(norm_of(sum_of(stress, -sphere.slope.x, r)), 1e-12);
    }
}

TEST(OgdenLaw, RotationsChangeNothing) {
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const double alpha = kExponents[seed % std::size(kExponents)];
        const Mat3d f = sum_of(kIdentity3, 1, random_matrix(random, 0.2));
        const Mat3d r = random.rotation(false), q = random.rotation(false);
        const double energy = energy_of(alpha, f);
        EXPECT_NEAR(energy_of(alpha, r * f * q), energy, 1e-11 * (1 + energy));
        const Mat3d stress = stress_of(alpha, f);
        EXPECT_LT(norm_of(sum_of(stress_of(alpha, r * f * q), -1, r * stress * q)),
                  1e-11 * (1 + norm_of(stress)) * pbd::kStiffest);
        EXPECT_NEAR(energy_of(alpha, r), 0, 1e-14);
        EXPECT_LT(norm_of(stress_of(alpha, r)), 1e-14);
    }
}

TEST(OgdenLaw, TangentAtRestIsThatOfHooke) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Mat3d df = random_matrix(random, 1);
        const Mat3d strain = sum_of(df, 1, transposed(df));  // twice
        // 2 ε : ε, and the rest of (λ/2 + µ/α) (J − 1)² beside the volume constraint.
        const double volume = df.columns[0].x + df.columns[1].y + df.columns[2].z;
        for (const double alpha : kExponents)
            EXPECT_NEAR(pbd::ogden_curve(ogden_point(alpha, kIdentity3), df, true),
                        0.5 * inner(strain, strain) +
                            (7 - pbd::ogden_volume_stiffness(alpha, 7)) * volume * volume,
                        1e-12);
    }
}

TEST(OgdenLaw, StressesAreThoseOfTheIncompressibleClosedForms) {
    // Without volume change, σᵢ − σⱼ = λᵢ Pᵢ − λⱼ Pⱼ = 2/α (λᵢ^α − λⱼ^α): the pressure cancels.
    for (const double alpha : kExponents)
        for (const double s : {0.9, 0.95, 1.02, 1.1}) {
            const double t = 1 / std::sqrt(s);
            const auto differences = [&](Vec3d values) {
                const Mat3d p = stress_of(alpha, stretched(values));
                return values.x * p.columns[0].x - values.z * p.columns[2].z;
            };
            // Uniaxial: P = 2/α (s^(α − 1) − s^(−α/2 − 1)); equibiaxial: 2/α (s^(α−1) − s^(−2α−1)).
            EXPECT_NEAR(differences({s, t, t}) / s,
                        2 / alpha * (std::pow(s, alpha - 1) - std::pow(s, -alpha / 2 - 1)), 1e-12);
            if (std::pow(s, -2 * (alpha - 2)) < 90) {
                EXPECT_NEAR(differences({s, s, 1 / (s * s)}) / s,
                            2 / alpha * (std::pow(s, alpha - 1) - std::pow(s, -2 * alpha - 1)),
                            1e-11);
            }
            // Simple shear by γ: P₁₂ = 2/α (λ^α − λ^−α)/(λ + 1/λ) with γ = λ − 1/λ.
            const double gamma = s - 1 / s;
            Mat3d f = kIdentity3;
            f.columns[1].x = gamma;
            EXPECT_NEAR(stress_of(alpha, f).columns[1].x,
                        2 / alpha * (std::pow(s, alpha) - std::pow(s, -alpha)) / (s + 1 / s),
                        1e-12);
        }
}

/// A tetrahedron at rest, and moved.
struct Moved {
    explicit Moved(std::uint64_t seed, double by) : random(seed) {
        Mat3d edges{};
        do edges = random_matrix(random, 1);
        while (determinant(edges) < 0.1);
        inverse_edges = inverse(edges);
        for (int n = 0; n < 3; ++n) positions[n + 1] = edges.columns[n];
        for (Vec3d& p : positions) p = p + random.vector(by);
    }
    pbd::OgdenSolid solid(double alpha) const {
        pbd::OgdenSolid s{};
        s.alpha = alpha;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                s.inverse[row][column] = inverse_edges.columns[column][row];
        return s;
    }
    void corners(pbd::Corner<double> (&p)[4]) const {
        for (int n = 0; n < 4; ++n)
            p[n] = {{positions[n].x, positions[n].y, positions[n].z}, 1.0 + n};
    }
    Random random;
    Vec3d positions[4];
    Mat3d inverse_edges;
};

TEST(OgdenLaw, ConstraintsHaveTheirGradients) {
    constexpr double kStep = 1e-6;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const double alpha = kExponents[seed % std::size(kExponents)];
        Moved m(seed, 0.1);
        pbd::Corner<double> p[4];
        m.corners(p);
        const auto s = m.solid(alpha);
        const auto c = pbd::ogden_constraints(p, s);
        const auto warm = pbd::ogden_gradients(p, s, 3).gradients;
        for (int n = 0; n < 4; ++n)
            for (double pbd::Triple<double>::*axis :
                 {&pbd::Triple<double>::x, &pbd::Triple<double>::y, &pbd::Triple<double>::z}) {
                pbd::Corner<double> more[4], less[4];
                m.corners(more);
                m.corners(less);
                more[n].p.*axis += kStep;
                less[n].p.*axis -= kStep;
                const auto high = pbd::ogden_constraints(more, s),
                           low = pbd::ogden_constraints(less, s);
                const double size = 1 + std::abs(c.ge[n].*axis);
                EXPECT_NEAR(c.gh[n].*axis, (high.h - low.h) / (2 * kStep), 1e-7);
                EXPECT_NEAR(c.ge[n].*axis, (high.e - low.e) / (2 * kStep), 1e-6 * size);
                // Gradients of ½ E²; the first one's negative is stored.
                const double sign = n > 0 ? 1 : -1;
                EXPECT_NEAR(sign * (warm.gq[n].*axis), c.e * (c.ge[n].*axis), 1e-9 * size);
                EXPECT_NEAR(sign * (warm.gh[n].*axis), c.gh[n].*axis, 1e-12);
            }
    }
}

TEST(OgdenLaw, AnExponentOfTwoIsTheNeoHookeanLaw) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Moved m(seed, seed % 4 == 0 ? 1.0 : 0.2);  // some are inverted
        pbd::Corner<double> p[4];
        m.corners(p);
        const auto s = m.solid(2);
        pbd::Solid<double> other{};
        for (int n = 0; n < 9; ++n) other.inverse[n / 3][n % 3] = s.inverse[n / 3][n % 3];
        const auto a = pbd::ogden_constraints(p, s);
        const auto b = pbd::solid_constraints(p, other);
        const double size = 1 + b.e * b.e + b.h * b.h;
        EXPECT_NEAR(a.h, b.h, 1e-13 * size);
        if (b.e > 0.011) {
            EXPECT_NEAR(a.e * a.e, b.e * b.e, 1e-12 * size);
        }
        for (int n = 0; n < 4; ++n) {
            EXPECT_LT(norm(a.e * Vec3d{a.ge[n].x, a.ge[n].y, a.ge[n].z} -
                           b.e * Vec3d{b.ge[n].x, b.ge[n].y, b.ge[n].z}),
                      1e-10 * size);
            EXPECT_LT(
                norm(Vec3d{a.gh[n].x - b.gh[n].x, a.gh[n].y - b.gh[n].y, a.gh[n].z - b.gh[n].z}),
                1e-12 * size);
        }
    }
}

PbdParts ogden_block(Vec3i cells, double side, double young, double nu, double alpha) {
    return made(pbd_of_mesh(five_tet_block(cells, side), {.density = 1e-3,
                                                          .edges = false,
                                                          .volumes = false,
                                                          .solids = true,
                                                          .young_modulus = young,
                                                          .poisson_ratio = nu,
                                                          .ogden_alpha = alpha}));
}

/// The sideways stretch without stress, and the nominal stress along x, from derivatives of ψ that
/// are written out here.
struct Uniaxial {
    Uniaxial(double young, double nu, double alpha, double s) {
        const double mu = young / (2 * (1 + nu)), lambda = 2 * mu * nu / (1 - 2 * nu);
        const auto stress = [&](double stretch, double others, double j) {
            return 2 * mu / alpha * (std::pow(stretch, alpha - 1) - others) +
                   (lambda + 2 * mu / alpha) * (j - 1) * others;
        };
        double low = 0.5, high = 2;
        for (int n = 0; n < 100; ++n) {
            sideways = 0.5 * (low + high);
            const double j = s * sideways * sideways;
            (stress(sideways, s * sideways, j) > 0 ? high : low) = sideways;
        }
        along = stress(s, sideways * sideways, s * sideways * sideways);
    }
    double sideways = 1, along = 0;
};

/// Nominal stress of a cube between two faces that are moved apart by a stretch; the nodes between
/// them find their places. @param[out] worst  largest distance from the homogeneous solution
double stress_of_cube(double alpha, double s, bool warm, double& worst) {
    constexpr double kYoung = 4540, kNu = 0.49, kSide = 5;
    constexpr int kCells = 2, kRamp = 30, kSteps = 90;
    const Uniaxial expected(kYoung, kNu, alpha, s);
    PbdParts parts = ogden_block({kCells, kCells, kCells}, kSide, kYoung, kNu, alpha);
    const double length = kCells * kSide;
    std::vector<std::int32_t> faces;
    for (std::size_t n = 0; n < parts.positions.size(); ++n)
        if (const double x = parts.positions[n].x; x == 0 || x == length) {
            faces.push_back(std::int32_t(n));
            parts.inverse_masses[n] = 0;
        }
    const double step = 1.0 / 60;
    const auto subs = std::int32_t(std::ceil((warm ? 2 : 4) * wave_sub_steps(parts, step)));
    auto body = made(PbdBody::create(parts, {.time_step = step,
                                             .sub_steps = subs,
                                             .damping = 20,
                                             .precision = PbdPrecision::Double,
                                             .warm_starts = warm}));
    const auto solution = [&](std::size_t n, double share) {
        const double along = 1 + share * (s - 1), across = 1 + share * (expected.sideways - 1);
        const Vec3d p = parts.positions[n];
        return Vec3d{along * p.x, across * p.y, across * p.z};
    };
    const TaskArena arena(1);
    for (int n = 1; n <= kSteps; ++n) {
        if (n <= kRamp) {
            for (const std::int32_t node : faces)
                EXPECT_TRUE(
                    body.set_state(node, solution(std::size_t(node), double(n) / kRamp), {}).ok());
        }
        EXPECT_TRUE(body.step(1, arena).ok());
    }
    for (std::size_t n = 0; n < parts.positions.size(); ++n)
        worst = std::max(worst, norm(body.position(std::int32_t(n)) - solution(n, 1)));
    double force = 0;
    const auto forces = body.constraint_forces();
    for (const std::int32_t node : faces)
        if (parts.positions[std::size_t(node)].x > 0) force -= forces[std::size_t(node)].x;
    return force / (length * length);
}

TEST(OgdenBody, ACubeIsStifferInCompressionByTheLawsRatio) {
    double worst = 0;
    const double tension = stress_of_cube(-17.9, 1.1, true, worst);
    const double compression = stress_of_cube(-17.9, 0.9, true, worst);
    // Of a cube of 10 mm.
    EXPECT_LT(worst, 0.01);
    EXPECT_NEAR(tension / Uniaxial(4540, 0.49, -17.9, 1.1).along, 1, 0.01);
    EXPECT_NEAR(compression / Uniaxial(4540, 0.49, -17.9, 0.9).along, 1, 0.01);
    EXPECT_NEAR(-compression / tension, 3.57, 0.05);
    const double soft = stress_of_cube(2, 1.1, true, worst),
                 hard = stress_of_cube(2, 0.9, true, worst);
    EXPECT_NEAR(-hard / soft, 1.22, 0.02) << "neo-Hookean";
}

TEST(OgdenBody, TheSameHoldsWithoutWarmStarts) {
    double worst = 0;
    for (const double s : {1.1, 0.9})
        EXPECT_NEAR(stress_of_cube(-17.9, s, false, worst) / Uniaxial(4540, 0.49, -17.9, s).along,
                    1, 0.05);
    EXPECT_LT(worst, 0.1);
}

/// A block whose upper cells have another law, held below and pulled.
std::vector<Vec3d> positions_of_mixed(double alpha, bool vectors, bool warm, int threads,
                                      PbdPrecision precision = PbdPrecision::Float,
                                      std::int32_t iterations = 1) {
    PbdParts parts = ogden_block({5, 4, 6}, 4, 5e3, 0.45, 2);
    for (PbdSolid& solid : parts.solids)
        if (parts.positions[std::size_t(solid.nodes[0])].z > 12) solid.ogden_alpha = alpha;
    for (std::size_t n = 0; n < parts.positions.size(); ++n)
        if (parts.positions[n].z == 0) parts.inverse_masses[n] = 0;
    auto body = made(PbdBody::create(parts, {.sub_steps = 12,
                                             .iterations = iterations,
                                             .gravity = {3e3, 0, -9.81e3},
                                             .damping = 5,
                                             .precision = precision,
                                             .vectors = vectors,
                                             .domain_particles = 60,
                                             .alternates = iterations > 1,
                                             .warm_starts = warm}));
    const TaskArena arena(threads);
    EXPECT_TRUE(body.step(12, arena).ok());
    std::vector<Vec3d> positions(parts.positions.size());
    body.get_positions(positions);
    return positions;
}
double farthest(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double most = 0;
    for (std::size_t n = 0; n < a.size(); ++n) most = std::max(most, norm(a[n] - b[n]));
    return most;
}

TEST(OgdenBody, BitsAreThoseOfAnyThreadsAndWithoutVectors) {
    for (const bool warm : {false, true})
        for (const std::int32_t iterations : {1, 2}) {
            const auto float_ = PbdPrecision::Float;
            const auto first = positions_of_mixed(-18, true, warm, 1, float_, iterations);
            EXPECT_EQ(positions_of_mixed(-18, false, warm, 1, float_, iterations), first);
            EXPECT_EQ(positions_of_mixed(-18, true, warm, 2, float_, iterations), first);
            const auto wide =
                positions_of_mixed(-18, true, warm, 1, PbdPrecision::Double, iterations);
            EXPECT_LT(farthest(wide, first), 2e-3);
            EXPECT_GT(farthest(positions_of_mixed(2, true, warm, 1, float_, iterations), first),
                      0.01)
                << "the law makes a difference";
        }
}

TEST(OgdenBody, AnExponentNearTwoMovesAsTheNeoHookeanLaw) {
    const auto wide = PbdPrecision::Double;
    EXPECT_LT(farthest(positions_of_mixed(2 + 1e-9, false, false, 1, wide),
                       positions_of_mixed(2, false, false, 1, wide)),
              1e-4);
}

TEST(OgdenBody, RecoversFromFlatAndInvertedTetrahedra) {
    for (const double squeeze : {0.0, -0.3})
        for (const bool warm : {true, false}) {
            PbdParts parts = ogden_block({2, 2, 2}, 5, 5e3, 0.45, -18);
            const double step = 1.0 / 60;
            const auto subs = std::int32_t(std::ceil(wave_sub_steps(parts, step)));
            auto body = made(PbdBody::create(
                parts, {.time_step = step, .sub_steps = subs, .damping = 20, .warm_starts = warm}));
            const TaskArena arena(1);
            for (std::size_t n = 0; n < parts.positions.size(); ++n) {
                Vec3d p = parts.positions[n];
                if (p.z == 10) p.z = 5 + 5 * squeeze;  // the upper cells
                EXPECT_TRUE(body.set_state(std::int32_t(n), p, {}).ok());
            }
            body.recall_forces();
            ASSERT_TRUE(body.step(60, arena).ok());
            std::vector<Vec3d> positions(parts.positions.size());
            body.get_positions(positions);
            EXPECT_LT(volume_change(parts, positions).largest, 0.02) << squeeze << warm;
        }
}

TEST(OgdenBody, RefusesExponentsWithoutALaw) {
    const auto fault = [](double alpha, double nu) {
        PbdParts parts{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                       .inverse_masses = {1, 1, 1, 1}};
        parts.solids = {{.nodes = {0, 1, 2, 3}, .poisson_ratio = nu, .ogden_alpha = alpha}};
        const auto body = PbdBody::create(parts, {});
        return body.ok() ? "" : body.error().message;
    };
    EXPECT_EQ(fault(-18, 0.45), "");
    EXPECT_EQ(fault(-1, 0.4), "");
    EXPECT_EQ(fault(0.5, 0.45),
              "solid 0: expected an Ogden exponent of 2 to 40, or −40 to −1, found 0.5");
    EXPECT_NE(fault(41, 0.45), "");
    EXPECT_NE(fault(-40.5, 0.45), "");
    EXPECT_NE(fault(std::nan(""), 0.45), "");
    EXPECT_EQ(fault(-2, 0.2),
              "solid 0: expected an Ogden exponent below -3 for a Poisson's ratio of 0.2, "
              "found -2");
}

}  // namespace
}  // namespace pliant::test
