// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/check_solid.h"

#include <cmath>
#include <span>
#include <string>

#include "base/errors.h"
#include "base/text.h"
#include "fem/hex_element.h"

namespace pliant {
namespace {

/// Checks Poisson's ratio, and that the energy of a material with fibres is positive.
Status check_fibres(const ElasticMaterial& m, const std::string& name) {
    if (!is_finite(m.fibre)) return invalid(name + "fibre: expected three numbers");
    const bool fibres = has_fibres(m);
    if (!(m.poisson_ratio > -1 && m.poisson_ratio < (fibres ? 1 : 0.5)))
        return invalid(name + "poisson_ratio is " + text_of(m.poisson_ratio) +
                       ", expected a number above -1 and below " + (fibres ? "1" : "0.5"));
    if (!fibres) return Ok{};
    if (!(m.fibre_young_modulus_pa > 0) || !std::isfinite(m.fibre_young_modulus_pa))
        return invalid(name + "fibre_young_modulus_pa is " + text_of(m.fibre_young_modulus_pa) +
                       ", expected a modulus above 0");
    if (!(m.fibre_shear_modulus_pa > 0) || !std::isfinite(m.fibre_shear_modulus_pa))
        return invalid(name + "fibre_shear_modulus_pa is " + text_of(m.fibre_shear_modulus_pa) +
                       ", expected a modulus above 0");
    const double largest =
        std::sqrt((1 - m.poisson_ratio) * m.fibre_young_modulus_pa / (2 * m.young_modulus_pa));
    if (!(std::abs(m.fibre_poisson_ratio) < largest))
        return invalid(name + "fibre_poisson_ratio is " + text_of(m.fibre_poisson_ratio) +
                       ", expected an amount below " + text_of(largest) +
                       ", above which the energy is not positive");
    return Ok{};
}

Status check_materials(std::span<const ElasticMaterial> materials,
                       std::span<const std::int32_t> material_of, std::int64_t cells) {
    if (materials.empty()) return invalid("materials: found none, expected one or more");
    for (std::size_t m = 0; m < materials.size(); ++m) {
        const ElasticMaterial& material = materials[m];
        const std::string name = "materials[" + std::to_string(m) + "]: ";
        if (!(material.young_modulus_pa > 0) || !std::isfinite(material.young_modulus_pa))
            return invalid(name + "young_modulus_pa is " + text_of(material.young_modulus_pa) +
                           ", expected a modulus above 0");
        if (const Status s = check_fibres(material, name); !s) return s;
        if (!(material.density_kg_per_m3 >= 0) || !std::isfinite(material.density_kg_per_m3))
            return invalid(name + "density_kg_per_m3 is " + text_of(material.density_kg_per_m3) +
                           ", expected 0 or more");
    }
    if (material_of.empty()) return Ok{};
    if (std::int64_t(material_of.size()) != cells)
        return invalid("material_of: has " + std::to_string(material_of.size()) +
                       " numbers, expected " + std::to_string(cells) + ", one for each cell");
    for (std::size_t c = 0; c < material_of.size(); ++c)
        if (material_of[c] < 0 || std::size_t(material_of[c]) >= materials.size())
            return invalid("material_of: cell " + std::to_string(c) + " has material " +
                           std::to_string(material_of[c]) + ", expected 0…" +
                           std::to_string(materials.size() - 1));
    return Ok{};
}

/// Checks the Gauss points: a cell can be valid at its corners and inverted between them.
Status check_gauss_points(const HexMesh& mesh) {
    for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
        HexCorners corners;
        for (std::size_t c = 0; c < 8; ++c)
            corners[c] = mesh.nodes_mm[std::size_t(mesh.cells[cell][c])];
        for (int g = -1; g < 8; ++g)
            if (!(hex_point(corners, g < 0 ? Vec3d{0, 0, 0} : gauss_point(g)).weight > 0))
                return invalid("mesh: cell " + std::to_string(cell) +
                               " is inverted inside, expected a convex one");
    }
    return Ok{};
}

}  // namespace

SettingRows<ElasticSettings> elastic_rows() noexcept {
    static constexpr Setting<ElasticSettings> kRows[] = {
        setting<&ElasticSettings::element>({.name = "element",
                                            .choices = "trilinear|incompatible_modes",
                                            .text = "hexahedron, plain or with nine inner modes"}),
        setting<&ElasticSettings::method>({.name = "method",
                                           .choices = "cholesky|conjugate_gradients",
                                           .text = "direct or iterative solution"}),
        setting<&ElasticSettings::tolerance>({.name = "tolerance",
                                              .range = {0, 1},
                                              .above_low = true,
                                              .below_high = true,
                                              .text = "residual relative to the load, of conjugate "
                                                      "gradients"}),
        setting<&ElasticSettings::max_iterations>(
            {.name = "max_iterations", .range = {.low = 1}, .text = "of conjugate gradients"}),
    };
    return kRows;
}

Status check_solid(const ElasticSolid& solid) {
    const HexMesh& mesh = solid.mesh;
    if (const Status s = check_cells(mesh); !s) return s;
    std::vector<bool> used(mesh.nodes_mm.size(), false);
    for (const auto& cell : mesh.cells)
        for (const std::int32_t node : cell) used[std::size_t(node)] = true;
    for (std::size_t n = 0; n < used.size(); ++n)
        if (!used[n])
            return invalid("mesh: node " + std::to_string(n) +
                           " belongs to no cell, expected each to be used");
    if (const Status s = check_gauss_points(mesh); !s) return s;
    return check_materials(solid.materials, solid.material_of, std::int64_t(mesh.cells.size()));
}

Status check_solid(const ElasticLattice& solid) {
    if (const Status s = check_lattice(solid.lattice); !s) return s;
    for (std::size_t m = 0; m < solid.materials.size(); ++m)
        if (has_fibres(solid.materials[m]))
            return invalid("materials[" + std::to_string(m) +
                           "]: has fibres, expected an isotropic material in a lattice");
    return check_materials(solid.materials, solid.material_of, cell_count(solid.lattice));
}

Status check_settings(const ElasticSettings& settings) {
    return check(settings, elastic_rows());
}

}  // namespace pliant
