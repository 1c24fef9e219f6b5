// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// First hits on a mesh by Embree, 16 rays at a time: the reference of our ray caster.

#pragma once

#include <memory>
#include <span>

#include "iso_mesh.h"

namespace pliant::bench {

class EmbreeRays {
  public:
    /// Builds the tree over the triangles. @param rays  of one eye; copied for 16 lanes beforehand
    EmbreeRays(const IsoMesh& mesh, Vec3d eye_mm, std::span<const Vec3d> directions);
    ~EmbreeRays();

    double build_seconds() const;
    /// Casts all rays, on this thread. @param[out] distances  infinite: no hit
    void cast(std::span<float> distances);

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant::bench
