// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "conformance_solids.h"

#include <array>
#include <cmath>

namespace pliant::app {
namespace {

/// Area vector of a face, half the cross product of its diagonals [mm²].
Vec3d area_of(const HexMesh& mesh, const HexFace& face) {
    std::array<Vec3d, 4> x;
    for (std::size_t c = 0; c < 4; ++c)
        x[c] = mesh.nodes_mm[std::size_t(
            mesh.cells[std::size_t(face.cell)][std::size_t(kHexFaceCorners[face.face][c])])];
    return 0.5 * cross(x[2] - x[0], x[3] - x[1]);
}

std::vector<HexFace> faces_of(const MappedSolid& solid, const Where& where) {
    std::vector<HexFace> faces;
    for (const HexFace& face : boundary_faces(solid.mesh)) {
        bool all = true;
        for (const int c : kHexFaceCorners[face.face])
            all = all && where(solid.unit[std::size_t(
                             solid.mesh.cells[std::size_t(face.cell)][std::size_t(c)])]);
        if (all) faces.push_back(face);
    }
    return faces;
}

}  // namespace

MappedSolid::MappedSolid(Vec3i cells, const Shape& shape)
    : mesh(hex_mesh({cells + Vec3i{1, 1, 1}, {1.0 / cells.x, 1.0 / cells.y, 1.0 / cells.z}})),
      unit(mesh.nodes_mm) {
    for (Vec3d& x : mesh.nodes_mm) x = shape(x);
}

void MappedSolid::hold(const Where& where, std::array<bool, 3> axes) {
    for (std::size_t n = 0; n < unit.size(); ++n)
        if (where(unit[n])) supports.push_back({std::int32_t(n), axes});
}

void MappedSolid::load(const Where& where, Vec3d traction_pa, double pressure_pa) {
    for (const HexFace& face : faces_of(*this, where))
        loads.surfaces.push_back({face, traction_pa, pressure_pa});
}

void MappedSolid::pull(const Where& where, Vec3d force_n) {
    double area_mm2 = 0;
    for (const HexFace& face : faces_of(*this, where)) area_mm2 += norm(area_of(mesh, face));
    load(where, 1e6 / area_mm2 * force_n);
}

ElasticSolution solve(const MappedSolid& solid, const ElasticMaterial& material, HexElement element,
                      const TaskArena& arena, ElasticMethod method) {
    const auto solver =
        computed(ElasticSolver::create(ElasticSolid{solid.mesh, {material}}, solid.supports,
                                       {.element = element, .method = method}, arena));
    return computed(solver.solve(solid.loads));
}

Vec3d mean_displacement(const MappedSolid& solid, const ElasticSolution& solution,
                        const Where& where) {
    Vec3d sum{0, 0, 0};
    int count = 0;
    for (std::size_t n = 0; n < solid.unit.size(); ++n)
        if (where(solid.unit[n])) {
            sum = sum + solution.displacement_mm[n];
            ++count;
        }
    return (1.0 / count) * sum;
}

SymmetricTensor stress_at(const MappedSolid& solid, const ElasticSolution& solution,
                          const ElasticMaterial& material, HexElement element, std::int32_t node,
                          const TaskArena& arena) {
    const auto states = computed(elastic_states(ElasticSolid{solid.mesh, {material}},
                                                solution.displacement_mm, element, arena));
    const double root = std::sqrt(3.0);
    SymmetricTensor sum;
    int cells = 0;
    for (std::size_t cell = 0; cell < solid.mesh.cells.size(); ++cell) {
        int corner = -1;
        for (std::size_t c = 0; c < 8; ++c)
            if (solid.mesh.cells[cell][c] == node) corner = int(c);
        if (corner < 0) continue;
        ++cells;
        const Vec3d at = solid.mesh.nodes_mm[std::size_t(node)];
        std::size_t nearest = 0;
        for (std::size_t g = 1; g < 8; ++g)
            if (norm(states[8 * cell + g].position_mm - at) <
                norm(states[8 * cell + nearest].position_mm - at))
                nearest = g;
        for (std::size_t g = 0; g < 8; ++g) {
            double weight = 1;
            for (int a = 0; a < 3; ++a)
                weight *= ((g ^ nearest) >> a & 1) ? (1 - root) / 2 : (1 + root) / 2;
            const SymmetricTensor& s = states[8 * cell + g].stress_pa;
            sum.xx += weight * s.xx;
            sum.yy += weight * s.yy;
            sum.zz += weight * s.zz;
            sum.yz += weight * s.yz;
            sum.zx += weight * s.zx;
            sum.xy += weight * s.xy;
        }
    }
    for (double* const s : {&sum.xx, &sum.yy, &sum.zz, &sum.yz, &sum.zx, &sum.xy}) *s /= cells;
    return sum;
}

std::string element_name(HexElement element) {
    return element == HexElement::Trilinear ? "elements, trilinear"
                                            : "elements, incompatible modes";
}

std::string mesh_name(Vec3i cells) {
    return std::to_string(cells.x) + " x " + std::to_string(cells.y) + " x " +
           std::to_string(cells.z);
}

}  // namespace pliant::app
