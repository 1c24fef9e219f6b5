// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small displacements of linear tetrahedra by a plain finite-element code: the reference for a body
// of the same tetrahedra.

#pragma once

#include <pliant/mesh.h>

#include <array>
#include <cstddef>
#include <vector>

namespace pliant::results {

/// Small displacements of linear tetrahedra: forces of a displacement, and conjugate gradients.
class LinearTetrahedra {
  public:
    LinearTetrahedra(const TetMesh& mesh, double young, double nu) : m_mesh(mesh) {
        m_mu = young / (2 * (1 + nu));
        m_lambda = young * nu / ((1 + nu) * (1 - 2 * nu));
        for (const auto& cell : mesh.cells) {
            Mat3d edges{};
            for (std::size_t n = 0; n < 3; ++n)
                edges.columns[n] = place(cell[n + 1]) - place(cell[0]);
            m_volumes.push_back(determinant(edges) / 6);
            const Mat3d rows = transposed(inverse(edges));  // gradients of corners 1, 2, 3
            m_gradients.push_back({-(rows.columns[0] + rows.columns[1] + rows.columns[2]),
                                   rows.columns[0], rows.columns[1], rows.columns[2]});
        }
    }
    double volume(std::size_t cell) const { return m_volumes[cell]; }

    /// Solves; u is 0 at held nodes.
    std::vector<Vec3d> solve(const std::vector<Vec3d>& loads, const std::vector<bool>& held) const {
        std::vector<Vec3d> u(loads.size(), Vec3d{0, 0, 0}), r = loads;
        const auto product = [&](const auto& a, const auto& b) {
            double sum = 0;
            for (std::size_t n = 0; n < a.size(); ++n) sum += dot(a[n], b[n]);
            return sum;
        };
        for (std::size_t n = 0; n < r.size(); ++n)
            if (held[n]) r[n] = {0, 0, 0};
        std::vector<Vec3d> p = r;
        double rr = product(r, r);
        for (const double first = rr; rr > 1e-20 * first;) {
            std::vector<Vec3d> q = forces(p);
            for (std::size_t n = 0; n < q.size(); ++n)
                if (held[n]) q[n] = {0, 0, 0};
            const double alpha = rr / product(p, q);
            for (std::size_t n = 0; n < u.size(); ++n) {
                u[n] = u[n] + alpha * p[n];
                r[n] = r[n] - alpha * q[n];
            }
            const double next = product(r, r);
            for (std::size_t n = 0; n < p.size(); ++n) p[n] = r[n] + (next / rr) * p[n];
            rr = next;
        }
        return u;
    }

  private:
    Vec3d place(std::int32_t n) const { return m_mesh.nodes_mm[std::size_t(n)]; }
    std::vector<Vec3d> forces(const std::vector<Vec3d>& u) const {
        std::vector<Vec3d> f(u.size(), Vec3d{0, 0, 0});
        for (std::size_t c = 0; c < m_mesh.cells.size(); ++c) {
            double strain[3][3] = {}, trace = 0;
            for (std::size_t n = 0; n < 4; ++n)
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j) {
                        const Vec3d& at = u[std::size_t(m_mesh.cells[c][n])];
                        const Vec3d& g = m_gradients[c][n];
                        strain[i][j] += 0.5 * (at[i] * g[j] + at[j] * g[i]);
                    }
            for (int i = 0; i < 3; ++i) trace += strain[i][i];
            for (std::size_t n = 0; n < 4; ++n) {
                Vec3d& at = f[std::size_t(m_mesh.cells[c][n])];
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j)
                        at[i] += m_volumes[c] * m_gradients[c][n][j] *
                                 (2 * m_mu * strain[i][j] + (i == j ? m_lambda * trace : 0));
            }
        }
        return f;
    }

    const TetMesh& m_mesh;
    double m_mu, m_lambda;
    std::vector<double> m_volumes;
    std::vector<std::array<Vec3d, 4>> m_gradients;
};

}  // namespace pliant::results
