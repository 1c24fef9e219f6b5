// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Strain and stress at the Gauss points, where they are most accurate.

#include <string>

#include "fem/check_solid.h"
#include "fem/hex_element.h"

namespace pliant {

Result<std::vector<ElasticState>> elastic_states(const ElasticSolid& solid,
                                                 std::span<const Vec3d> displacement_mm,
                                                 HexElement element, const TaskArena& arena) {
    if (const Status s = check_solid(solid); !s) return s.error();
    const HexMesh& mesh = solid.mesh;
    if (displacement_mm.size() != mesh.nodes_mm.size())
        return Error{ErrorCode::InvalidArgument,
                     "displacement_mm: has " + std::to_string(displacement_mm.size()) +
                         " vectors, expected " + std::to_string(mesh.nodes_mm.size()) +
                         ", one for each node"};
    std::vector<ElasticState> states(8 * mesh.cells.size());
    const auto add_cell = [&](std::size_t cell) {
        const auto material = solid.material_of.empty() ? 0 : std::size_t(solid.material_of[cell]);
        HexCorners corners;
        std::array<Vec3d, 8> displacement;
        for (std::size_t c = 0; c < 8; ++c) {
            const auto node = std::size_t(mesh.cells[cell][c]);
            corners[c] = mesh.nodes_mm[node];
            displacement[c] = displacement_mm[node];
        }
        const auto modes = with_law(solid.materials[material], [&](const auto& law) {
            return hex_modes(corners, law, element, displacement);
        });
        for (int g = 0; g < 8; ++g) {
            const HexPoint p = hex_point(corners, gauss_point(g));
            ElasticState& state = states[8 * cell + std::size_t(g)];
            state.position_mm = {0, 0, 0};
            for (std::size_t c = 0; c < 8; ++c)
                state.position_mm = state.position_mm + p.values[c] * corners[c];
            state.strain = strain_at(p, displacement, modes);
            state.stress_pa = with_law(solid.materials[material], [&](const auto& law) {
                return stress_of(law, state.strain);
            });
        }
    };
    arena.for_each(std::int64_t(mesh.cells.size()), 64, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t cell = begin; cell < end; ++cell) add_cell(std::size_t(cell));
    });
    return states;
}

}  // namespace pliant
