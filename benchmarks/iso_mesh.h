// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The surface of a threshold as triangles, by marching cubes: the input of a mesh renderer, which
// must be rebuilt for each threshold.

#pragma once

#include <pliant/volume.h>

#include <array>
#include <vector>

namespace pliant::bench {

struct IsoMesh {
    std::vector<Vec3f> points_mm;  ///< LPS
    std::vector<std::array<unsigned, 3>> triangles;
};

IsoMesh make_iso_mesh(const Volume& volume, double iso_hu);

}  // namespace pliant::bench
