// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "morph/elastic_part.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace pliant::morph {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Index = Eigen::Index;

// The prior: relative growth of the dilation per standard deviation to the back and to the head,
// and the shear strain over the linear growth.
constexpr double kBackGrowth = 0.5, kHeadGrowth = -0.2, kPitch = -0.4;
constexpr double kSpacingMm = 58;          ///< of control points
constexpr double kBorderMm = 6;            ///< of the lattice beyond the voxels' centres
constexpr std::size_t kQuadrature = 1500;  ///< voxels that the integrals sum over
constexpr double kSupport = 1e-9;          ///< stiffness of coefficients that no voxel sees

/// Values, first and second derivatives of the four cubic B-splines of a cell at t in 0…1.
struct Cubic {
    std::array<double, 4> of[3];

    explicit Cubic(double t) {
        const double s = 1 - t;
        of[0] = {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                 (3 * (t + t * t - t * t * t) + 1) / 6, t * t * t / 6};
        of[1] = {-s * s / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2, t * t / 2};
        of[2] = {s, 3 * t - 2, 1 - 3 * t, t};
    }
};

/// The 64 basis functions at a point.
class Basis {
  public:
    Basis(Vec3d x, Vec3d low, double spacing, Vec3i count) : m_per_mm(1 / spacing) {
        Vec3i cell{0, 0, 0};
        for (int a = 0; a < 3; ++a) {
            const double f = (x[a] - low[a]) * m_per_mm;
            cell[a] = std::clamp(int(std::floor(f)), 0, count[a] - 4);
            m_axes[std::size_t(a)] = Cubic(std::clamp(f - cell[a], 0.0, 1.0));
        }
        std::size_t n = 0;
        for (int k = 0; k < 4; ++k)
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i)
                    at[n++] = Index(cell.x + i + count.x * (cell.y + j + count.y * (cell.z + k)));
    }

    std::array<Index, 64> at;  ///< control points

    /// Derivatives of an order along each axis.
    std::array<double, 64> derivative(int x, int y, int z) const {
        const double scale = std::pow(m_per_mm, x + y + z);
        std::array<double, 64> values;
        std::size_t n = 0;
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t j = 0; j < 4; ++j)
                for (std::size_t i = 0; i < 4; ++i)
                    values[n++] =
                        scale * m_axes[0].of[x][i] * m_axes[1].of[y][j] * m_axes[2].of[z][k];
        return values;
    }

  private:
    double m_per_mm;
    std::array<Cubic, 3> m_axes{Cubic(0), Cubic(0), Cubic(0)};
};

struct Moments {
    Vec3d centre{0, 0, 0}, deviation{0, 0, 0};

    explicit Moments(const std::vector<Vec3d>& points) {
        const double share = 1 / double(points.size());
        for (const Vec3d& p : points) centre = centre + share * p;
        for (const Vec3d& p : points)
            for (int a = 0; a < 3; ++a)
                deviation[a] += share * (p[a] - centre[a]) * (p[a] - centre[a]);
        for (int a = 0; a < 3; ++a) deviation[a] = std::sqrt(deviation[a]);
    }
};

/// The quadratic form and its load. Unknowns are ordered by component; of the matrix, the lower
/// triangle is kept.
class System {
  public:
    System(Index count, double kappa, double bending)
        : m_count(count), m_kappa(kappa), m_bending(bending) {
        m_stiffness.setZero(3 * count, 3 * count);
        m_load.setZero(3 * count);
    }

    /// Adds a point of the integrals. @param share  of the part, times the modulus
    /// @param at_rest  share times the modulus times the local scale of rest strains
    /// @param excess  dilation of the eigenstrain @param pitch  its shear strain
    void add_point(const Basis& basis, double share, double at_rest, double excess, double pitch) {
        const std::array<std::array<double, 64>, 3> d{
            basis.derivative(1, 0, 0), basis.derivative(0, 1, 0), basis.derivative(0, 0, 1)};
        constexpr int kSecond[6][3] = {{2, 0, 0}, {0, 2, 0}, {0, 0, 2},
                                       {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
        std::array<std::array<double, 64>, 6> dd;
        for (std::size_t n = 0; n < 6; ++n)
            dd[n] = basis.derivative(kSecond[n][0], kSecond[n][1], kSecond[n][2]);
        const double lambda = m_kappa - 2.0 / 3.0;
        for (std::size_t q = 0; q < 64; ++q) {
            const double dq[3] = {d[0][q], d[1][q], d[2][q]};
            for (std::size_t p = 0; p < 64; ++p) {
                const double dp[3] = {d[0][p], d[1][p], d[2][p]};
                for (int i = 1; i < 3; ++i)
                    for (int j = 0; j < i; ++j)
                        m_stiffness(i * m_count + basis.at[p], j * m_count + basis.at[q]) +=
                            share * (lambda * dp[i] * dq[j] + dp[j] * dq[i]);
                if (p < q) continue;
                double trace = dp[0] * dq[0] + dp[1] * dq[1] + dp[2] * dq[2];
                for (std::size_t n = 0; n < 6; ++n)
                    trace += m_bending * (n < 3 ? 1 : 2) * dd[n][p] * dd[n][q];
                for (int i = 0; i < 3; ++i)
                    m_stiffness(i * m_count + basis.at[p], i * m_count + basis.at[q]) +=
                        share * ((lambda + 1) * dp[i] * dq[i] + trace);
            }
            for (int i = 0; i < 3; ++i)
                m_load[i * m_count + basis.at[q]] += at_rest * 3 * m_kappa * excess * dq[i];
            m_load[m_count + basis.at[q]] += at_rest * 2 * pitch * dq[2];
            m_load[2 * m_count + basis.at[q]] += at_rest * 2 * pitch * dq[1];
        }
    }

    /// Adds the forces that stretch a point along the axes at rest.
    void add_stretch(const Basis& basis, double at_rest, Vec3d stretch) {
        const double trace = stretch.x + stretch.y + stretch.z;
        for (int i = 0; i < 3; ++i) {
            const auto d = basis.derivative(i == 0, i == 1, i == 2);
            const double stress = (m_kappa - 2.0 / 3.0) * trace + 2 * stretch[i];
            for (std::size_t q = 0; q < 64; ++q)
                m_load[i * m_count + basis.at[q]] += at_rest * stress * d[q];
        }
    }

    /// Adds the forces that hold coefficients at rest, of a uniform body.
    void add_rest(const Vector& rest) {
        m_load += m_stiffness.selfadjointView<Eigen::Lower>() * rest;
    }

    Vector solve(const std::vector<Slide>& slides, const std::vector<Basis>& surface,
                 double weight) const {
        Matrix stiffness = m_stiffness;
        Vector load = m_load;
        stiffness.diagonal().array() += kSupport;
        const double share = weight / double(slides.size());
        std::array<double, 192> row;
        std::array<Index, 192> at;
        for (const Slide& slide : slides) {
            const Basis& basis = surface[slide.point];
            const auto values = basis.derivative(0, 0, 0);
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t p = 0; p < 64; ++p) {
                    row[64 * a + p] = slide.normal[int(a)] * values[p];
                    at[64 * a + p] = Index(a) * m_count + basis.at[p];
                }
            for (std::size_t q = 0; q < row.size(); ++q) {
                const double s = share * row[q];
                for (std::size_t p = q; p < row.size(); ++p) stiffness(at[p], at[q]) += s * row[p];
                load[at[q]] += s * slide.gap;
            }
        }
        const Eigen::LLT<Eigen::Ref<Matrix>> factor(stiffness);
        return factor.solve(load);
    }

  private:
    Index m_count;
    double m_kappa, m_bending;
    Matrix m_stiffness;
    Vector m_load;
};

}  // namespace

Vec3d BodyField::at(Vec3d x) const {
    const Basis basis(x, m_low, m_spacing, m_count);
    const auto values = basis.derivative(0, 0, 0);
    Vec3d u{0, 0, 0};
    for (std::size_t n = 0; n < 64; ++n)
        u = u + values[n] * m_coefficients[std::size_t(basis.at[n])];
    return u;
}

Mat3d BodyField::gradient(Vec3d x) const {
    const Basis basis(x, m_low, m_spacing, m_count);
    Mat3d g{};
    for (int a = 0; a < 3; ++a) {
        const auto values = basis.derivative(a == 0, a == 1, a == 2);
        g.columns[a] = {0, 0, 0};
        for (std::size_t n = 0; n < 64; ++n)
            g.columns[a] = g.columns[a] + values[n] * m_coefficients[std::size_t(basis.at[n])];
    }
    return g;
}

BodyField move_body(const Part& part, const ElasticSettings& settings) {
    BodyField field;
    field.m_spacing = kSpacingMm;
    Vec3d low = part.voxels_from[0], high = low;
    for (const Vec3d& p : part.voxels_from)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a] - kBorderMm);
            high[a] = std::max(high[a], p[a] + kBorderMm);
        }
    field.m_low = low;
    for (int a = 0; a < 3; ++a)
        field.m_count[a] = int(std::ceil((high[a] - low[a]) / kSpacingMm)) + 3;
    const auto count =
        std::size_t(field.m_count.x) * std::size_t(field.m_count.y) * std::size_t(field.m_count.z);

    const Moments from(part.voxels_from), to(part.voxels_to);
    const double growth = std::cbrt(part.volume_to_mm3 / part.volume_from_mm3) - 1;
    const double nu = settings.poisson_ratio;
    System system(Index(count), 2 * (1 + nu) / (3 * (1 - 2 * nu)), settings.bending_mm2);
    const std::size_t samples = std::min(kQuadrature, part.voxels_from.size());
    const auto voxel_of = [&](std::size_t n) {
        return (2 * n + 1) * part.voxels_from.size() / (2 * samples);
    };
    const auto modulus_of = [&](std::size_t n) {
        return part.moduli.empty() ? 1 : part.moduli[voxel_of(n)];
    };
    // Under one stress, tissue is strained in proportion to its compliance; the mean is that of a.
    double compliance = 1;
    if (!part.moduli.empty()) {
        compliance = 0;
        for (std::size_t n = 0; n < samples; ++n)
            compliance += 1 / (double(samples) * modulus_of(n));
    }
    Vec3d stretch{0, 0, 0};  // of a
    for (int a = 0; a < 3; ++a)
        if (from.deviation[a] > 0) stretch[a] = to.deviation[a] / from.deviation[a] - 1;
    const double prior = settings.back == 0 ? 0 : 1;
    for (std::size_t n = 0; n < samples; ++n) {
        const Vec3d x = part.voxels_from[voxel_of(n)];
        Vec3d t = x - from.centre;
        for (int a = 0; a < 3; ++a) t[a] = from.deviation[a] > 0 ? t[a] / from.deviation[a] : 0;
        const Basis basis(x, low, kSpacingMm, field.m_count);
        const double at_rest = 1 / double(samples) / compliance;
        system.add_point(basis, modulus_of(n) / double(samples), at_rest,
                         prior * growth * (kBackGrowth * settings.back * t.y + kHeadGrowth * t.z),
                         kPitch * settings.back * growth);
        if (!part.moduli.empty()) system.add_stretch(basis, at_rest, stretch);
    }
    // The rest shape: B-splines are affine where their coefficients are.
    Vector u(Index(3 * count));
    for (std::size_t n = 0; n < count; ++n) {
        const Vec3i at{int(n) % field.m_count.x, int(n) / field.m_count.x % field.m_count.y,
                       int(n) / (field.m_count.x * field.m_count.y)};
        for (int a = 0; a < 3; ++a) {
            const double x = low[a] + (at[a] - 1) * kSpacingMm;
            const double scale = from.deviation[a] > 0 ? to.deviation[a] / from.deviation[a] : 1;
            u[Index(std::size_t(a) * count + n)] = (x - from.centre[a]) * scale + to.centre[a] - x;
        }
    }
    if (part.moduli.empty()) system.add_rest(u);
    std::vector<Basis> surface;
    for (const Vec3d& x : part.from.points) surface.emplace_back(x, low, kSpacingMm, field.m_count);
    const auto take = [&] {
        field.m_coefficients.resize(count);
        for (std::size_t n = 0; n < count; ++n)
            field.m_coefficients[n] = {u[Index(n)], u[Index(count + n)], u[Index(2 * count + n)]};
    };
    take();
    for (std::size_t round = 0; round < settings.slide_weights.size(); ++round) {
        Moved moved;
        for (std::size_t n = 0; n < part.from.points.size(); ++n) {
            const Vec3d x = part.from.points[n], normal = part.from.normals[n];
            moved.points.push_back(x + field.at(x));
            moved.normals.push_back(round == 0 ? normal : moved_normal(field.gradient(x), normal));
        }
        u = system.solve(slides_of(part, moved), surface, settings.slide_weights[round]);
        take();
    }
    return field;
}

}  // namespace pliant::morph
