// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fit/elastic_tetrahedra.h"

#include <array>

#include "fit/dissected_cholesky.h"

namespace pliant {
namespace {

constexpr double kMinElasticPivot = 1e-13;  ///< relative to the diagonal; smaller is rounding

/// Gradients of the shape functions. @param[out] volume
std::array<Vec3d, 4> shape_gradients(const std::array<Vec3d, 4>& x, double& volume) {
    const Vec3d a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
    const double six = dot(a, cross(b, c));
    volume = six / 6;
    std::array<Vec3d, 4> g{Vec3d{0, 0, 0}, (1 / six) * cross(b, c), (1 / six) * cross(c, a),
                           (1 / six) * cross(a, b)};
    g[0] = -(g[1] + g[2] + g[3]);
    return g;
}

}  // namespace

struct ElasticTetrahedra::Impl {
    std::vector<int> unknowns;  ///< [3·node + axis]; −1: held
    int count = 0;
    std::unique_ptr<DissectedCholesky> dissection;
    std::unique_ptr<DissectedCholesky::Factor> factor;
};

ElasticTetrahedra::~ElasticTetrahedra() = default;

ElasticTetrahedra::ElasticTetrahedra(const TetMesh& mesh, std::span<const FitRegion> regions,
                                     std::span<const std::int32_t> region_of,
                                     std::span<const std::uint8_t> held)
    : m_impl(std::make_unique<Impl>()) {
    Impl& m = *m_impl;
    std::vector<std::uint8_t> free;
    for (const std::uint8_t h : held) free.push_back(!h);
    DissectedCholesky::Joined joined;
    for (const auto& cell : mesh.cells) joined.emplace_back(cell.begin(), cell.end());
    m.dissection = std::make_unique<DissectedCholesky>(mesh.nodes_mm, joined, free);
    m.unknowns.assign(3 * free.size(), -1);
    for (std::size_t u = 0; u < m.unknowns.size(); ++u)
        if (free[u / 3]) {
            m.unknowns[u] = 3 * m.dissection->order()[u / 3] + int(u % 3);
            ++m.count;
        }
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t t = 0; t < mesh.cells.size(); ++t) {
        const auto& cell = mesh.cells[t];
        const FitRegion& region = regions[std::size_t(region_of[t])];
        const double e = region.young_modulus_pa, nu = region.poisson_ratio;
        const double lambda = e * nu / ((1 + nu) * (1 - 2 * nu)), mu = e / (2 * (1 + nu));
        std::array<Vec3d, 4> x;
        for (std::size_t n = 0; n < 4; ++n) x[n] = mesh.nodes_mm[std::size_t(cell[n])];
        double volume = 0;
        const auto g = shape_gradients(x, volume);
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = 0; b < 4; ++b)
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j) {
                        const int row = m.unknowns[3 * std::size_t(cell[a]) + std::size_t(i)];
                        const int column = m.unknowns[3 * std::size_t(cell[b]) + std::size_t(j)];
                        if (row < 0 || column < 0 || row < column) continue;
                        const double k = lambda * g[a][i] * g[b][j] + mu * g[a][j] * g[b][i] +
                                         (i == j ? mu * dot(g[a], g[b]) : 0.0);
                        entries.emplace_back(row, column, volume * k);
                    }
    }
    if (m.count == 0) return;
    DissectedCholesky::Matrix lower(m.count, m.count);
    lower.setFromTriplets(entries.begin(), entries.end());
    m.dissection->analyse(lower);
    m.factor = m.dissection->factor(lower, kMinElasticPivot);
}

bool ElasticTetrahedra::is_supported() const {
    return m_impl->count == 0 || m_impl->factor;
}

std::vector<Vec3d> ElasticTetrahedra::displacements_mm(std::span<const Vec3d> force_un) const {
    const Impl& m = *m_impl;
    std::vector<Vec3d> moved(m.unknowns.size() / 3, Vec3d{0, 0, 0});
    if (m.count == 0) return moved;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(m.count);
    for (std::size_t u = 0; u < m.unknowns.size(); ++u)
        if (m.unknowns[u] >= 0) right[m.unknowns[u]] = force_un[u / 3][int(u % 3)];
    const Eigen::VectorXd solved = m.dissection->solve(*m.factor, std::move(right));
    for (std::size_t u = 0; u < m.unknowns.size(); ++u)
        if (m.unknowns[u] >= 0) moved[u / 3][int(u % 3)] = solved[m.unknowns[u]];
    return moved;
}

}  // namespace pliant
