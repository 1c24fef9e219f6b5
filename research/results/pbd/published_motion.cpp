// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases 3, 4 and 12: the spring and the chain of [Macklin2016], and a block that falls.

#include <pliant/models/pbd.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "published.h"
#include "value_of.h"

namespace pliant::results {
namespace {

/// Backward Euler of a chain by Newton's method on positions and multipliers together:
///   M (x − x̃) = ∇Cᵀλ,  C + α̃λ = 0
class ChainByNewton {
  public:
    ChainByNewton(int links, double alpha, double h) : m_links(links), m_alpha(alpha), m_h(h) {
        for (int n = 0; n <= links; ++n) m_x.push_back({double(n), 0, 0});
        m_v.assign(m_x.size(), Vec3d{0, 0, 0});
        m_lambda.assign(std::size_t(links), 0);
    }
    void step(Vec3d g) {
        std::vector<Vec3d> aim = m_x, old = m_x;
        for (std::size_t n = 1; n < m_x.size(); ++n) aim[n] = m_x[n] + m_h * (m_v[n] + m_h * g);
        std::vector<double> lambda = m_lambda;
        for (int turn = 0; turn < 50; ++turn)
            if (newton(aim, lambda) < 1e-13) break;
        for (std::size_t n = 1; n < m_x.size(); ++n) m_v[n] = (1 / m_h) * (m_x[n] - old[n]);
        m_lambda = lambda;
    }
    /// λ/h² of the first link.
    double support() const { return m_lambda[0] / (m_h * m_h); }

  private:
    double newton(const std::vector<Vec3d>& aim, std::vector<double>& lambda) {
        const int free = 3 * m_links, size = free + m_links;
        std::vector<double> a(std::size_t(size * size), 0), b(std::size_t(size), 0);
        const auto at = [&](int r, int c) -> double& { return a[std::size_t(r * size + c)]; };
        for (int n = 1; n <= m_links; ++n)
            for (int c = 0; c < 3; ++c) {
                at(3 * (n - 1) + c, 3 * (n - 1) + c) += 1;
                b[std::size_t(3 * (n - 1) + c)] -= m_x[std::size_t(n)][c] - aim[std::size_t(n)][c];
            }
        for (int l = 0; l < m_links; ++l) {
            const Vec3d d = m_x[std::size_t(l)] - m_x[std::size_t(l) + 1];
            const double length = norm(d), force = lambda[std::size_t(l)];
            b[std::size_t(free + l)] -= length - 1 + m_alpha / (m_h * m_h) * force;
            at(free + l, free + l) = m_alpha / (m_h * m_h);
            for (int p = 0; p < 2; ++p) {
                const int node = l + p - 1;  // index of the unknowns
                if (node < 0) continue;
                const double sign = p == 0 ? 1 : -1;
                for (int c = 0; c < 3; ++c) {
                    const int row = 3 * node + c;
                    b[std::size_t(row)] += sign * d[c] / length * force;
                    at(row, free + l) -= sign * d[c] / length;
                    at(free + l, row) += sign * d[c] / length;
                    for (int q = 0; q < 2; ++q)
                        for (int e = 0; e < 3 && l + q > 0; ++e)
                            at(row, 3 * (l + q - 1) + e) -=
                                sign * (q == 0 ? 1 : -1) * force / length *
                                ((c == e ? 1.0 : 0.0) - d[c] * d[e] / (length * length));
                }
            }
        }
        solve(a, b, size);
        double change = 0;
        for (int n = 0; n < free; ++n) {
            m_x[std::size_t(n / 3 + 1)][n % 3] += b[std::size_t(n)];
            change = std::max(change, std::abs(b[std::size_t(n)]));
        }
        for (int l = 0; l < m_links; ++l) lambda[std::size_t(l)] += b[std::size_t(free + l)];
        return change;
    }
    static void solve(std::vector<double>& a, std::vector<double>& b, int size) {
        const auto at = [&](int r, int c) -> double& { return a[std::size_t(r * size + c)]; };
        for (int k = 0; k < size; ++k) {
            int pivot = k;
            for (int r = k + 1; r < size; ++r)
                if (std::abs(at(r, k)) > std::abs(at(pivot, k))) pivot = r;
            for (int c = 0; c < size; ++c) std::swap(at(k, c), at(pivot, c));
            std::swap(b[std::size_t(k)], b[std::size_t(pivot)]);
            for (int r = k + 1; r < size; ++r) {
                const double f = at(r, k) / at(k, k);
                if (f == 0) continue;
                for (int c = k; c < size; ++c) at(r, c) -= f * at(k, c);
                b[std::size_t(r)] -= f * b[std::size_t(k)];
            }
        }
        for (int k = size - 1; k >= 0; --k) {
            for (int c = k + 1; c < size; ++c) b[std::size_t(k)] -= at(k, c) * b[std::size_t(c)];
            b[std::size_t(k)] /= at(k, k);
        }
    }

    int m_links;
    double m_alpha, m_h;
    std::vector<Vec3d> m_x, m_v;
    std::vector<double> m_lambda;
};

double period_of_a_spring(int iterations) {
    PbdParts parts{.positions = {{0, 0, 0}, {1.5, 0, 0}}, .inverse_masses = {0, 1}};
    parts.distances = {{.nodes = {0, 1}, .rest_length = 1, .compliance = 1e-3}};
    const double step = 5e-4;
    auto body = value_of(
        PbdBody::create(parts, {.time_step = step, .sub_steps = 1, .iterations = iterations}));
    // Intervals between crossings of the rest length in the same direction.
    std::vector<double> crossings;
    double last = 0.5;
    for (int n = 1; crossings.size() < 6 && n < 10000; ++n) {
        must(body.step(1, one_thread()));
        const double now = body.position(1).x - 1;
        if (last > 0 && now <= 0) crossings.push_back(step * (n - now / (now - last)));
        last = now;
    }
    return crossings.size() < 6 ? 0 : (crossings.back() - crossings.front()) / 5;
}

}  // namespace

Cases spring_cases() {
    Cases cases;
    for (const int iterations : {1, 5, 100})
        cases.push_back(within_share(3,
                                     "spring, m 1, compliance 1e-3: period [s] with iterations " +
                                         std::to_string(iterations),
                                     2 * std::numbers::pi / std::sqrt(1000.0),
                                     period_of_a_spring(iterations), 0.01));
    return cases;
}

Cases chain_cases() {
    constexpr int kLinks = 19, kFrames = 100;
    const double alpha = 1e-8, h = 1.0 / 60;
    const Vec3d g{0, 0, -9.81};
    PbdParts parts;
    for (int n = 0; n <= kLinks; ++n) {
        parts.positions.push_back({double(n), 0, 0});
        parts.inverse_masses.push_back(n == 0 ? 0 : 1);
        if (n > 0) parts.distances.push_back({.nodes = {n - 1, n}, .compliance = alpha});
    }
    const struct {
        int iterations;
        double tolerance;
    } runs[] = {{50, 0.06}, {100, 0.02}, {1000, 0.005}};
    Cases cases;
    for (const auto& c : runs) {
        auto body = value_of(PbdBody::create(parts, {.time_step = h,
                                                     .sub_steps = 1,
                                                     .iterations = c.iterations,
                                                     .gravity = g,
                                                     .precision = PbdPrecision::Double}));
        ChainByNewton newton(kLinks, alpha, h);
        double worst = 0, largest = 0;
        for (int frame = 0; frame < kFrames; ++frame) {
            must(body.step(1, one_thread()));
            newton.step(g);
            const double ours = body.multiplier(PbdKind::Distance, 0), theirs = newton.support();
            largest = std::max(largest, std::abs(theirs));
            worst = std::max(worst, std::abs(ours - theirs));
        }
        // It must exceed its weight, because it swings: otherwise this would prove nothing.
        cases.push_back(at_most(4,
                                "chain of 20, compliance 1e-8: force at its support against "
                                "Newton's, relative, with iterations " +
                                    std::to_string(c.iterations),
                                largest > 200 ? worst / largest : 1, c.tolerance));
    }
    return cases;
}

Cases drop_cases() {
    const struct {
        int sub_steps;
        double published;
    } runs[] = {{5, 0.46}, {10, 0.118}, {20, 0.027}};
    Cases cases;
    for (const auto& c : runs) {
        PbdParts parts =
            value_of(pbd_of_mesh(five_tet_block({12, 8, 8}, 0.1), {.density = 1000,
                                                                   .edges = false,
                                                                   .volumes = false,
                                                                   .solids = true,
                                                                   .young_modulus = 1e5,
                                                                   .poisson_ratio = 0.4999}));
        parts.planes = {{{0, 0, -0.5}, {0, 0, 1}, 0.5}};
        auto body =
            value_of(PbdBody::create(parts, {.sub_steps = c.sub_steps, .gravity = {0, 0, -10}}));
        must(body.step(600, one_thread()));
        std::vector<Vec3d> positions(parts.positions.size());
        body.get_positions(positions);
        const VolumeChange change = volume_change(parts, positions);
        double lowest = 0;
        for (const Vec3d& p : positions) lowest = std::min(lowest, p.z);
        const std::string after = "block of 3840 tetrahedra fallen to the floor, sub-steps " +
                                  std::to_string(c.sub_steps);
        Case volume{12,
                    after +
                        ": change of volume [%], the demo's in C++ (in JavaScript 0.30, 0.118, "
                        "0.027) or less",
                    c.published,
                    100 * std::abs(change.total),
                    0,
                    false,
                    true};
        cases.push_back(volume);
        cases.push_back({12, after + ": largest of a tetrahedron [%]; the demo's is above 180", 180,
                         100 * change.largest, 0, false, true});
        cases.push_back(within(12, after + ": its lowest point [m]", -0.5, lowest, 1e-4));
    }
    return cases;
}

}  // namespace pliant::results
