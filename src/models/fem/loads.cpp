// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/loads.h"

#include <cmath>
#include <string>

#include "base/errors.h"
#include "base/units.h"

namespace pliant {
namespace {

constexpr double kPerCubicMm = 1e-3;  // N/m³ · mm³ = 1e-9 N = 1e-3 µN

void add(NodeVector& forces, std::int32_t node, Vec3d force) {
    const auto n = std::size_t(node);
    forces.set(n, forces.at(n) + force);
}

/// Adds ∫ N_c (traction − pressure n) dA over a bilinear face, 2 × 2 Gauss points.
void add_surface(const SolidShape& shape, const SurfaceLoad& load, NodeVector& forces) {
    const auto nodes = shape.nodes_of(load.face.cell);
    constexpr double kSigns[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    std::int32_t at[4];
    for (int c = 0; c < 4; ++c) at[c] = nodes[std::size_t(kHexFaceCorners[load.face.face][c])];
    for (int g = 0; g < 4; ++g) {
        const double r = g & 1 ? kGauss : -kGauss, s = g & 2 ? kGauss : -kGauss;
        Vec3d along_r{0, 0, 0}, along_s{0, 0, 0};
        for (int c = 0; c < 4; ++c) {
            const Vec3d x = shape.position(at[c]);
            along_r = along_r + (kSigns[c][0] * (1 + kSigns[c][1] * s) / 4) * x;
            along_s = along_s + (kSigns[c][1] * (1 + kSigns[c][0] * r) / 4) * x;
        }
        const Vec3d area = cross(along_r, along_s);
        const Vec3d force = norm(area) * load.traction_pa - load.pressure_pa * area;
        for (int c = 0; c < 4; ++c)
            add(forces, at[c], ((1 + kSigns[c][0] * r) * (1 + kSigns[c][1] * s) / 4) * force);
    }
}

void add_gravity(const SolidShape& shape, std::int32_t cell, double density, Vec3d gravity,
                 NodeVector& forces) {
    const auto nodes = shape.nodes_of(cell);
    const HexCorners corners = shape.corners_of(cell);
    for (int g = 0; g < 8; ++g) {
        const HexPoint p = hex_point(corners, gauss_point(g));
        for (std::size_t c = 0; c < 8; ++c)
            add(forces, nodes[c], (kPerCubicMm * density * p.weight * p.values[c]) * gravity);
    }
}

Status check_force(const NodalForce& load, const std::string& name, std::int64_t nodes,
                   const HeldNodes& held) {
    if (load.node < 0 || load.node >= nodes)
        return invalid(name + ": node " + std::to_string(load.node) + ", expected 0…" +
                       std::to_string(nodes - 1));
    if (!is_finite(load.force_n)) return invalid(name + ": force_n is not finite");
    for (int a = 0; a < 3; ++a)
        if (load.force_n[a] != 0 && held.holds(std::size_t(load.node), a))
            return invalid(name + ": pushes node " + std::to_string(load.node) + " along " +
                           "xyz"[a] + ", where it is held; expected a free component");
    return Ok{};
}

Status check_surface(const SurfaceLoad& load, const std::string& name, std::int64_t cells) {
    if (load.face.cell < 0 || load.face.cell >= cells)
        return invalid(name + ": cell " + std::to_string(load.face.cell) + ", expected 0…" +
                       std::to_string(cells - 1));
    if (load.face.face < 0 || load.face.face > 5)
        return invalid(name + ": face " + std::to_string(load.face.face) + ", expected 0…5");
    if (!is_finite(load.traction_pa) || !std::isfinite(load.pressure_pa))
        return invalid(name + ": traction_pa or pressure_pa is not finite");
    return Ok{};
}

}  // namespace

Result<NodeVector> nodal_forces(const SolidShape& shape, std::span<const ElasticMaterial> materials,
                                std::span<const std::int32_t> material_of, const HeldNodes& held,
                                const ElasticLoads& loads) {
    NodeVector forces(shape.node_count());
    for (std::size_t n = 0; n < loads.forces.size(); ++n) {
        const NodalForce& load = loads.forces[n];
        const std::string name = "forces[" + std::to_string(n) + "]";
        if (const Status s = check_force(load, name, shape.node_count(), held); !s)
            return s.error();
        add(forces, load.node, kMicronewtonsPerNewton * load.force_n);
    }
    for (std::size_t n = 0; n < loads.surfaces.size(); ++n) {
        const std::string name = "surfaces[" + std::to_string(n) + "]";
        if (const Status s = check_surface(loads.surfaces[n], name, shape.cell_count()); !s)
            return s.error();
        add_surface(shape, loads.surfaces[n], forces);
    }
    const Vec3d gravity = loads.gravity_m_per_s2;
    if (!is_finite(gravity)) return invalid("gravity_m_per_s2: is not finite");
    if (norm(gravity) > 0)
        for (std::int32_t cell = 0; cell < shape.cell_count(); ++cell) {
            const auto material = material_of.empty() ? 0 : material_of[std::size_t(cell)];
            add_gravity(shape, cell, materials[std::size_t(material)].density_kg_per_m3, gravity,
                        forces);
        }
    return forces;
}

}  // namespace pliant
