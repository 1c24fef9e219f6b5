// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which voxels a deformation can change.
//
// A cell is touched if one of its corners moved. The cells that aren't stay where they are, so the
// touched ones together cover just the place that they covered at rest: a voxel can change only if
// all eight cells around it are touched.

#pragma once

#include <pliant/tasks.h>

#include <cstdint>
#include <vector>

#include "chainmail/lattice.h"

namespace pliant {

/// One flag per voxel of a box, i fastest.
struct VoxelMask {
    Box3i box;
    std::vector<std::uint8_t> flags;

    std::size_t index(Vec3i e) const {
        const Vec3i p = e - box.begin, n = box.end - box.begin;
        return std::size_t(p.x) +
               std::size_t(n.x) * (std::size_t(p.y) + std::size_t(n.y) * std::size_t(p.z));
    }
};

/// The voxels of the scan that can change, in the smallest box that holds them.
VoxelMask changeable_voxels(const Lattice& lattice, const TaskArena& arena);

}  // namespace pliant
