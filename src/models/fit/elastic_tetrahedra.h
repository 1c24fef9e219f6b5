// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Linear elasticity on tetrahedra of constant strain, the reference on a network's own mesh. For
// shape functions with gradients g, the block of the corners a and b is
//
//   K_ab = V (λ g_a g_bᵀ + µ g_b g_aᵀ + µ (g_a·g_b) I)
//
// Such elements are too stiff in bending and near ν = ½. So are springs with a volume energy on the
// same tetrahedra: both have one constraint per cell.

#pragma once

#include <pliant/models/fit_mesh.h>

#include <memory>
#include <span>
#include <vector>

namespace pliant {

class ElasticTetrahedra {
  public:
    /// @param region_of  [tetrahedron]
    /// @param held       [node]
    ElasticTetrahedra(const TetMesh& mesh, std::span<const FitRegion> regions,
                      std::span<const std::int32_t> region_of, std::span<const std::uint8_t> held);
    ~ElasticTetrahedra();

    /// Whether no motion is free of force. @pre of displacements()
    bool is_supported() const;
    /// @param force_un  [node], µN @returns [node], mm
    std::vector<Vec3d> displacements_mm(std::span<const Vec3d> force_un) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
