// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases 5 and 11: a cantilever under its weight, and a tube under pressure [Lame1852].

#include <pliant/models/pbd.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "cantilever.h"
#include "linear_tetrahedra.h"
#include "published.h"
#include "value_of.h"

namespace pliant::results {
namespace {

/// A thin ring of hexahedra, six tetrahedra each; nodes by angle, then radius, then height.
TetMesh ring(int around, int across, double inner, double outer, double height) {
    TetMesh mesh;
    for (int k = 0; k < 2; ++k)
        for (int r = 0; r <= across; ++r)
            for (int a = 0; a < around; ++a) {
                const double radius = inner + (outer - inner) * r / across;
                const double angle = 2 * std::numbers::pi * a / around;
                mesh.nodes_mm.push_back(
                    {radius * std::cos(angle), radius * std::sin(angle), height * k});
            }
    const auto node = [&](int r, int a, int k) {
        return a % around + around * (r + (across + 1) * k);
    };
    constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int r = 0; r < across; ++r)
        for (int a = 0; a < around; ++a)
            for (const auto& path : kPaths) {  // along the three axes in each order
                int at[3] = {r, a, 0};
                std::array<std::int32_t, 4> cell{node(at[0], at[1], at[2])};
                for (std::size_t n = 0; n < 3; ++n) {
                    ++at[path[n]];
                    cell[n + 1] = node(at[0], at[1], at[2]);
                }
                const auto p = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(cell[n])]; };
                if (dot(cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0)) < 0)
                    std::swap(cell[2], cell[3]);
                mesh.cells.push_back(cell);
            }
    return mesh;
}

/// [mm], of the same tetrahedra by finite elements.
double sag_of_linear_tetrahedra(const TetMesh& mesh) {
    const LinearTetrahedra linear(mesh, kCantilever.young, kCantilever.nu);
    std::vector<Vec3d> weights(mesh.nodes_mm.size(), Vec3d{0, 0, 0});
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        for (const std::int32_t n : mesh.cells[c])
            weights[std::size_t(n)].z -=
                kCantilever.density * kCantilever.gravity * linear.volume(c) / 4;
    std::vector<bool> held;
    for (const Vec3d& p : mesh.nodes_mm) held.push_back(p.x == 0);
    const std::vector<Vec3d> moved = linear.solve(weights, held);
    double sum = 0;
    int count = 0;
    for (std::size_t n = 0; n < moved.size(); ++n)
        if (std::abs(mesh.nodes_mm[n].x - 0.2) < 1e-9) {
            sum -= moved[n].z;
            ++count;
        }
    return 1e3 * sum / count;
}

}  // namespace

Cases cantilever_cases() {
    const double elements = sag_of_hexahedra(HexElement::IncompatibleModes, one_thread());
    return {within_share(5, "cantilever under its weight, 5 × 5 × 30 nodes of good elements [mm]",
                         kCantilever.exact_mm, elements, 0.02),
            within_share(5,
                         "its body of solids, 3 × 3 × 16 nodes, against finite elements of the "
                         "same tetrahedra, which lock [mm]",
                         sag_of_linear_tetrahedra(cantilever_of(15, 2)),
                         sag_of_solids(15, 2, one_thread()), 0.01)};
}

// With 1/20 of the pressure and 20 times the displacement, because the formula is for small
// strains. For plane strain a link from each node to the one above keeps the tube's length, which
// would otherwise decrease.
Cases tube_cases() {
    const double inner = 2, outer = 3, height = 0.15, young = 0.6e6, nu = 0.45;
    const double pressure = 13332.0 / 20, ratio = outer * outer / (inner * inner);
    constexpr int kAround = 64, kAcross = 8;
    Cases cases;
    for (const bool keeps_length : {false, true}) {
        PbdParts parts = value_of(
            pbd_of_mesh(ring(kAround, kAcross, inner, outer, height), {.density = 200,
                                                                       .edges = false,
                                                                       .volumes = false,
                                                                       .solids = true,
                                                                       .young_modulus = young,
                                                                       .poisson_ratio = nu}));
        const int layer = kAround * (kAcross + 1);
        for (int n = 0; keeps_length && n < layer; ++n)
            parts.distances.push_back({.nodes = {n, n + layer}});
        // Sub-steps in which waves cross a third of a cell: longer ones are too soft under a
        // lasting load; shorter ones lose a twentieth of the widening to float rounding.
        auto body = value_of(PbdBody::create(parts, {.time_step = 0.01,
                                                     .sub_steps = 20,
                                                     .damping = 20,
                                                     .precision = PbdPrecision::Double}));
        std::vector<std::int32_t> nodes;
        std::vector<Vec3d> forces;
        for (int k = 0; k < 2; ++k)
            for (int a = 0; a < kAround; ++a) {
                nodes.push_back(a + layer * k);
                const Vec3d out = parts.positions[std::size_t(nodes.back())];
                const double area = 2 * inner * std::sin(std::numbers::pi / kAround) * height / 2;
                forces.push_back((pressure * area / inner) * Vec3d{out.x, out.y, 0});
            }
        must(body.load(nodes, forces));
        must(body.step(64, one_thread()));
        double widening = 0;
        for (const std::int32_t n : nodes)
            widening += std::hypot(body.position(n).x, body.position(n).y) - inner;
        const double formula = keeps_length ? (1 + nu) * (1 - 2 * nu + ratio) / (ratio - 1)
                                            : (ratio + 1) / (ratio - 1) + nu;
        cases.push_back(within_share(11,
                                     std::string("Lamé's tube in plane ") +
                                         (keeps_length ? "strain" : "stress") + ": widening [mm]",
                                     13332.0 * inner / young * formula,
                                     widening * 20.0 / double(nodes.size()), 0.02));
    }
    return cases;
}

}  // namespace pliant::results
