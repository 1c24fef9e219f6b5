// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A block of a transversely isotropic solid with fibres along x, held at its foot, as the reference
// of a spring lattice [Choi2004, 3.2, with Eq. 3 in full].
//
// Links obey Cauchy's relations, C_ijkl symmetric in all indices. Edges and face diagonals of a
// cubic lattice of spacing a have, for stiffnesses k of each direction,
//
//   C_xxxx = (k_x + k_xy + k_zx)/a,   C_xxyy = C_xyxy = k_xy/a,   …
//
// so a transversely isotropic solid with C_aabb = G_a and C_bbcc = μ is that of a lattice.

#pragma once

#include <pliant/models/fit.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace pliant::results {

/// Units: mm, g, s; moduli in Pa, forces in µN, stiffness in µN/mm.
struct FibreBlock {
    std::int32_t side = 7;  ///< nodes along an edge
    double spacing_mm = 5;
    double c_aaaa = 40000, c_bbbb = 15000, c_aabb = 8000, c_bbcc = 5000;  ///< [Pa]

    ElasticMaterial material() const {
        const double plane = c_bbbb + c_bbcc, c2 = c_aabb * c_aabb;
        const double across =
            (c_bbbb - c_bbcc) * (c_aaaa * plane - 2 * c2) / (c_aaaa * c_bbbb - c2);
        return {.young_modulus_pa = across,
                .poisson_ratio = across / (2 * c_bbcc) - 1,
                .fibre = {1, 0, 0},
                .fibre_young_modulus_pa = c_aaaa - 2 * c2 / plane,
                .fibre_poisson_ratio = c_aabb / plane,
                .fibre_shear_modulus_pa = c_aabb};
    }
    /// Stiffness of each group of directions, from the relations above.
    std::vector<double> closed_form() const {
        return {spacing_mm * (c_aaaa - 2 * c_aabb), spacing_mm * (c_bbbb - c_aabb - c_bbcc),
                spacing_mm * c_aabb, spacing_mm * c_bbcc};
    }
    std::int32_t node(std::int32_t i, std::int32_t j, std::int32_t k) const {
        return i + side * (j + side * k);
    }
};

/// Loads on whole faces along each axis, and one on a part of the top that isn't fitted.
inline std::vector<FitCase> loads_of(const FibreBlock& block) {
    const std::int32_t last = block.side - 1;
    std::vector<FitCase> cases{{.name = "top up"},      {.name = "top along the fibres"},
                               {.name = "top across"},  {.name = "side along the fibres"},
                               {.name = "side across"}, {.name = "a patch", .held_out = true}};
    const std::array<Vec3d, 6> forces{
        {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {-0.5, -0.5, -1}}};
    for (std::int32_t b = 0; b < block.side; ++b)
        for (std::int32_t a = 0; a < block.side; ++a) {
            // Shares of an even traction on the face.
            const double share = (a % last ? 1 : 0.5) * (b % last ? 1 : 0.5);
            const auto add = [&](std::size_t c, std::int32_t node) {
                cases[c].nodes.push_back(node);
                cases[c].forces.push_back(1000 * share * forces[c]);
            };
            for (std::size_t c = 0; c < 3; ++c) add(c, block.node(a, b, last));
            if (b > 0) {
                add(3, block.node(last, a, b));
                add(4, block.node(a, last, b));
            }
            if (a > last / 2 && b > last / 2) add(5, block.node(a, b, last));
        }
    return cases;
}

/// @param by_direction  groups: edges along the fibres, edges across, diagonals in planes with
///                      fibres, diagonals across; otherwise one group of all links
inline Result<FitProblem> fibre_problem(const FibreBlock& block, bool by_direction,
                                        const TaskArena& arena) {
    const Vec3i size{block.side, block.side, block.side};
    const Vec3d spacing{block.spacing_mm, block.spacing_mm, block.spacing_mm};
    const HexMesh mesh = hex_mesh({size, spacing});
    auto parts = springs_of_lattice({.size = size, .spacing = spacing, .shared_by_cells = true});
    if (!parts.ok()) return parts.error();
    std::vector<Support> foot;
    for (std::int32_t n = 0; n < block.side * block.side; ++n) {
        foot.push_back({.node = n});
        parts->nodes[std::size_t(n)].fixed = true;
    }
    const auto reference = ElasticSolver::create({mesh, {block.material()}}, foot, {}, arena);
    if (!reference.ok()) return reference.error();
    std::vector<FitCase> cases = loads_of(block);
    for (FitCase& one : cases) {
        ElasticLoads loads;
        for (std::size_t n = 0; n < one.nodes.size(); ++n)
            loads.forces.push_back({one.nodes[n], 1e-6 * one.forces[n]});
        auto at_rest = reference->solve(loads);
        if (!at_rest.ok()) return at_rest.error();
        one.target = std::move(at_rest->displacement_mm);
    }
    std::vector<FitGroup> groups;
    if (by_direction)
        groups = {{.name = "edges along"},
                  {.name = "edges across"},
                  {.name = "diagonals with fibres"},
                  {.name = "diagonals across"}};
    else
        groups = {{.name = "links"}};
    for (std::size_t l = 0; l < parts->links.size(); ++l) {
        const SpringLink& link = parts->links[l];
        const Vec3d r =
            parts->nodes[std::size_t(link.b)].rest - parts->nodes[std::size_t(link.a)].rest;
        const bool along = r.x != 0, edge = (r.x != 0) + (r.y != 0) + (r.z != 0) == 1;
        const std::size_t group = edge ? (along ? 0 : 1) : (along ? 2 : 3);
        groups[by_direction ? group : 0].links.push_back(std::int32_t(l));
    }
    const double start = block.spacing_mm * block.c_bbcc;
    for (FitGroup& group : groups) {
        group.start = start;
        group.low = start / 30;
        group.high = 30 * start;
    }
    return FitProblem::create(std::move(*parts), std::move(groups), std::move(cases),
                              {.spring_length = block.spacing_mm});
}

}  // namespace pliant::results
