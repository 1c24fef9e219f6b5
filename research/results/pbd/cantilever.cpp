// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "cantilever.h"

#include <pliant/models/pbd.h>

#include <cmath>

#include "value_of.h"

namespace pliant::results {

TetMesh cantilever_of(int along, int across) {
    TetMesh mesh = five_tet_block({along, across, across}, 1);
    for (Vec3d& p : mesh.nodes_mm)
        p = {p.x * 0.2 / along, p.y * 0.02 / across, p.z * 0.02 / across};
    return mesh;
}

double sag_of_solids(int along, int across, const TaskArena& arena) {
    PbdParts parts =
        value_of(pbd_of_mesh(cantilever_of(along, across), {.density = kCantilever.density,
                                                            .edges = false,
                                                            .volumes = false,
                                                            .solids = true,
                                                            .young_modulus = kCantilever.young,
                                                            .poisson_ratio = kCantilever.nu}));
    for (std::size_t n = 0; n < parts.positions.size(); ++n)
        if (parts.positions[n].x == 0) parts.inverse_masses[n] = 0;
    auto body = value_of(PbdBody::create(parts, {.time_step = 0.005,
                                                 .sub_steps = 250 * across,
                                                 .gravity = {0, 0, -kCantilever.gravity},
                                                 .damping = 80,
                                                 .precision = PbdPrecision::Double}));
    must(body.step(40, arena));
    double sum = 0;
    int count = 0;
    for (std::size_t n = 0; n < parts.positions.size(); ++n)
        if (std::abs(parts.positions[n].x - 0.2) < 1e-9) {
            sum -= body.position(std::int32_t(n)).z - parts.positions[n].z;
            ++count;
        }
    return 1e3 * sum / count;
}

double sag_of_hexahedra(HexElement element, const TaskArena& arena) {
    ElasticSolid solid{hex_mesh({.size = {30, 5, 5}, .spacing_mm = {200.0 / 29, 5, 5}}),
                       {{.young_modulus_pa = kCantilever.young,
                         .poisson_ratio = kCantilever.nu,
                         .density_kg_per_m3 = kCantilever.density}}};
    std::vector<Support> supports;
    std::vector<std::int32_t> tip;
    for (std::int32_t n = 0; n < std::int32_t(solid.mesh.nodes_mm.size()); ++n) {
        const double x = solid.mesh.nodes_mm[std::size_t(n)].x;
        if (x == 0) supports.push_back({.node = n});
        if (std::abs(x - 200) < 1e-9) tip.push_back(n);
    }
    const auto solver =
        value_of(ElasticSolver::create(std::move(solid), supports, {.element = element}, arena));
    const auto solution =
        value_of(solver.solve({.gravity_m_per_s2 = {0, 0, -kCantilever.gravity}}));
    double sum = 0;
    for (const std::int32_t n : tip) sum -= solution.displacement_mm[std::size_t(n)].z;
    return sum / double(tip.size());
}

}  // namespace pliant::results
