// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/hex_element.h"

#include <cmath>
#include <cstddef>

namespace pliant {
namespace {

/// Adds a Gauss point's 3 × 3 block of two functions with gradients a and b: ∫ λ a_i b_j + μ (a_j
/// b_i + δ_ij a·b).
void add_block(double* block, std::size_t stride, Vec3d a, Vec3d b, const LameParameters& m,
               double weight) {
    const double lambda = m.lambda * weight, mu = m.mu * weight;
    const double trace = mu * dot(a, b);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            block[std::size_t(i) * stride + std::size_t(j)] +=
                lambda * a[i] * b[j] + mu * a[j] * b[i] + (i == j ? trace : 0);
}

/// The same of any material: ∫ C_ikjl a_k b_l.
void add_block(double* block, std::size_t stride, Vec3d a, Vec3d b, const HookeTensor& m,
               double weight) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double sum = 0;
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l) sum += m.c[i][k][j][l] * a[k] * b[l];
            block[std::size_t(i) * stride + std::size_t(j)] += weight * sum;
        }
}

/// The nine incompatible modes: their stiffness (lower Cholesky factor after `factor`), and their
/// coupling with the 24 displacements.
struct InnerModes {
    double own[9][9] = {};
    double coupling[9][24] = {};

    void factor() {
        for (int j = 0; j < 9; ++j)
            for (int i = j; i < 9; ++i) {
                double sum = own[i][j];
                for (int k = 0; k < j; ++k) sum -= own[i][k] * own[j][k];
                own[i][j] = i == j ? std::sqrt(sum) : sum / own[j][j];
            }
    }
    /// Solves L x = b in place for the columns of an array.
    template <std::size_t columns>
    void solve_lower(double (&b)[9][columns]) const {
        for (int i = 0; i < 9; ++i)
            for (std::size_t c = 0; c < columns; ++c) {
                for (int k = 0; k < i; ++k) b[i][c] -= own[i][k] * b[k][c];
                b[i][c] /= own[i][i];
            }
    }
    void solve_upper(double (&b)[9][1]) const {
        for (int i = 8; i >= 0; --i) {
            for (int k = i + 1; k < 9; ++k) b[i][0] -= own[k][i] * b[k][0];
            b[i][0] /= own[i][i];
        }
    }
};

template <class Law>
InnerModes inner_modes(const HexCorners& corners, const Law& m) {
    InnerModes modes;
    const double centre_weight = hex_point(corners, {0, 0, 0}).weight;
    for (int g = 0; g < 8; ++g) {
        const HexPoint p = hex_point(corners, gauss_point(g));
        // The factor centre weight / weight makes the integral of the modes' gradients zero.
        Vec3d gradients[3];
        for (int n = 0; n < 3; ++n) gradients[n] = (centre_weight / p.weight) * p.mode_gradients[n];
        for (int n = 0; n < 3; ++n) {
            for (int k = 0; k <= n; ++k)
                add_block(&modes.own[3 * n][3 * k], 9, gradients[n], gradients[k], m, p.weight);
            for (int c = 0; c < 8; ++c)
                add_block(&modes.coupling[3 * n][3 * c], 24, gradients[n], p.gradients[c], m,
                          p.weight);
        }
    }
    modes.factor();
    return modes;
}

}  // namespace

HexPoint hex_point(const HexCorners& corners, Vec3d natural) {
    HexPoint p;
    Vec3d natural_gradients[8];
    Mat3d jacobian{}, centre{};  // column a: ∂x/∂ξ_a
    for (std::size_t c = 0; c < 8; ++c) {
        const double* sign = kHexSigns[c];
        const double r = 1 + sign[0] * natural.x, s = 1 + sign[1] * natural.y,
                     t = 1 + sign[2] * natural.z;
        p.values[c] = r * s * t / 8;
        natural_gradients[c] = {sign[0] * s * t / 8, sign[1] * r * t / 8, sign[2] * r * s / 8};
        for (int a = 0; a < 3; ++a) {
            auto& column = jacobian.columns[a];
            column = column + natural_gradients[c][a] * corners[c];
            centre.columns[a] = centre.columns[a] + (sign[a] / 8) * corners[c];
        }
    }
    p.weight = determinant(jacobian);
    const Mat3d to_world = transposed(inverse(jacobian));
    for (std::size_t c = 0; c < 8; ++c) p.gradients[c] = to_world * natural_gradients[c];
    const Mat3d centre_to_world = transposed(inverse(centre));
    for (int m = 0; m < 3; ++m)
        p.mode_gradients[m] = (-2 * natural[m]) * centre_to_world.columns[m];
    return p;
}

namespace {

template <class Law>
HexStiffness stiffness_of(const HexCorners& corners, const Law& m, HexElement element) {
    HexStiffness k{};
    for (int g = 0; g < 8; ++g) {
        const HexPoint p = hex_point(corners, gauss_point(g));
        for (std::size_t a = 0; a < 8; ++a)
            for (std::size_t b = 0; b <= a; ++b)
                add_block(&k[3 * a * 24 + 3 * b], 24, p.gradients[a], p.gradients[b], m, p.weight);
    }
    if (element == HexElement::IncompatibleModes) {
        InnerModes modes = inner_modes(corners, m);
        modes.solve_lower(modes.coupling);
        for (std::size_t i = 0; i < 24; ++i)
            for (std::size_t j = 0; j <= i; ++j)
                for (const auto& row : modes.coupling) k[i * 24 + j] -= row[i] * row[j];
    }
    for (std::size_t i = 0; i < 24; ++i)
        for (std::size_t j = i + 1; j < 24; ++j) k[i * 24 + j] = k[j * 24 + i];
    return k;
}

template <class Law>
std::array<Vec3d, 3> modes_of(const HexCorners& corners, const Law& m, HexElement element,
                              const std::array<Vec3d, 8>& displacement) {
    std::array<Vec3d, 3> amplitudes{};
    if (element == HexElement::Trilinear) return amplitudes;
    const InnerModes modes = inner_modes(corners, m);
    double a[9][1];
    for (int i = 0; i < 9; ++i) {
        a[i][0] = 0;
        for (std::size_t c = 0; c < 8; ++c)
            for (int axis = 0; axis < 3; ++axis)
                a[i][0] -= modes.coupling[i][3 * c + std::size_t(axis)] * displacement[c][axis];
    }
    modes.solve_lower(a);
    modes.solve_upper(a);
    for (int i = 0; i < 9; ++i) amplitudes[std::size_t(i / 3)][i % 3] = a[i][0];
    // strain_at needs the amplitudes times the centre's weight.
    const double centre_weight = hex_point(corners, {0, 0, 0}).weight;
    for (Vec3d& v : amplitudes) v = centre_weight * v;
    return amplitudes;
}

}  // namespace

HookeTensor hooke_of(const ElasticMaterial& material) {
    const double e = material.young_modulus_pa, nu = material.poisson_ratio;
    const double e_a = material.fibre_young_modulus_pa, nu_a = material.fibre_poisson_ratio;
    const double g_a = material.fibre_shear_modulus_pa;
    const double n = e / e_a, m = 1 - nu - 2 * n * nu_a * nu_a;
    const double lambda = e * (nu + n * nu_a * nu_a) / ((1 + nu) * m), mu = e / (2 * (1 + nu));
    const double alpha = e * nu_a / m - lambda;
    const double beta = e_a * (1 - nu) / m - lambda - 2 * alpha + 2 * mu - 4 * g_a;
    const double gamma = g_a - mu;
    const Vec3d a = (1 / norm(material.fibre)) * material.fibre;
    const auto d = [](int i, int j) { return i == j ? 1.0 : 0.0; };
    HookeTensor tensor;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l)
                    tensor.c[i][j][k][l] = lambda * d(i, j) * d(k, l) +
                                           mu * (d(i, k) * d(j, l) + d(i, l) * d(j, k)) +
                                           alpha * (d(i, j) * a[k] * a[l] + a[i] * a[j] * d(k, l)) +
                                           beta * a[i] * a[j] * a[k] * a[l] +
                                           gamma * (d(i, k) * a[j] * a[l] + d(i, l) * a[j] * a[k] +
                                                    d(j, k) * a[i] * a[l] + d(j, l) * a[i] * a[k]);
    return tensor;
}

HexStiffness hex_stiffness(const HexCorners& corners, const LameParameters& m, HexElement element) {
    return stiffness_of(corners, m, element);
}
HexStiffness hex_stiffness(const HexCorners& corners, const HookeTensor& m, HexElement element) {
    return stiffness_of(corners, m, element);
}

std::array<Vec3d, 3> hex_modes(const HexCorners& corners, const LameParameters& m,
                               HexElement element, const std::array<Vec3d, 8>& displacement) {
    return modes_of(corners, m, element, displacement);
}
std::array<Vec3d, 3> hex_modes(const HexCorners& corners, const HookeTensor& m, HexElement element,
                               const std::array<Vec3d, 8>& displacement) {
    return modes_of(corners, m, element, displacement);
}

SymmetricTensor strain_at(const HexPoint& p, const std::array<Vec3d, 8>& displacement,
                          const std::array<Vec3d, 3>& modes) {
    double h[3][3] = {};  // h[i][j] = ∂u_i/∂x_j
    const auto add = [&](Vec3d u, Vec3d gradient) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) h[i][j] += u[i] * gradient[j];
    };
    for (std::size_t c = 0; c < 8; ++c) add(displacement[c], p.gradients[c]);
    for (std::size_t m = 0; m < 3; ++m) add((1 / p.weight) * modes[m], p.mode_gradients[m]);
    return {h[0][0],
            h[1][1],
            h[2][2],
            (h[1][2] + h[2][1]) / 2,
            (h[2][0] + h[0][2]) / 2,
            (h[0][1] + h[1][0]) / 2};
}

SymmetricTensor stress_of(const LameParameters& m, const SymmetricTensor& e) {
    const double pressure = m.lambda * (e.xx + e.yy + e.zz), twice = 2 * m.mu;
    return {pressure + twice * e.xx,
            pressure + twice * e.yy,
            pressure + twice * e.zz,
            twice * e.yz,
            twice * e.zx,
            twice * e.xy};
}

SymmetricTensor stress_of(const HookeTensor& m, const SymmetricTensor& e) {
    const double strain[3][3] = {{e.xx, e.xy, e.zx}, {e.xy, e.yy, e.yz}, {e.zx, e.yz, e.zz}};
    const auto component = [&](int i, int j) {
        double sum = 0;
        for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l) sum += m.c[i][j][k][l] * strain[k][l];
        return sum;
    };
    return {component(0, 0), component(1, 1), component(2, 2),
            component(1, 2), component(2, 0), component(0, 1)};
}

double von_mises(const SymmetricTensor& s) {
    const double mean = (s.xx + s.yy + s.zz) / 3;
    const double x = s.xx - mean, y = s.yy - mean, z = s.zz - mean;
    return std::sqrt(1.5 * (x * x + y * y + z * z) + 3 * (s.yz * s.yz + s.zx * s.zx + s.xy * s.xy));
}

}  // namespace pliant
