// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of an organ at two phases, from label maps: voxels and surfaces.
//
// A map is sampled at voxels of about 3 mm. A label that both maps have is a part. Two lungs of one
// label are separated: the mask is eroded until it falls into two large pieces, which grow again in
// the order of the depth.
//
//     ####  ####          ##    ##          1111  2222
//     ##########    →     ##    ##    →     1111112222
//     ####  ####          ##    ##          1111  2222

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/data/morph.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <span>
#include <vector>

namespace pliant::morph {

/// Voxels of one part.
struct Mask {
    Grid grid;
    std::vector<std::uint8_t> in;  ///< 0 or 1, i fastest
};

/// Points of a surface, with outward unit normals [mm, LPS].
struct Surface {
    std::vector<Vec3d> points, normals;
};

struct Part {
    std::vector<Vec3d> voxels_from, voxels_to;  ///< centres [mm, LPS]
    std::vector<double> moduli;                 ///< of voxels_from, relative; empty: 1
    double volume_from_mm3 = 0, volume_to_mm3 = 0;
    Surface from;                        ///< sample of the surface: points that slide
    Surface to;                          ///< the whole surface
    std::vector<std::size_t> sample_to;  ///< indices of a sample of it
};

struct Parts {
    std::vector<Part> list;
    bool are_lungs = false;  ///< two, side by side, with the heart's gap between them
    double back = 0;         ///< of lungs: 1 if y grows to the back, −1 if it grows to the front
};

/// @param moduli  of labels of `from`; one that `to` lacks joins the part that is nearest in it
/// @returns InvalidArgument that names from, to or moduli for an invalid map, maps without a common
///          label, and a modulus without its label
Result<Parts> find_parts(const Volume& from, const Volume& to, std::span<const MorphModulus> moduli,
                         const TaskArena& arena);

/// The two largest pieces of a mask, along x, or the mask itself.
std::vector<Mask> split(const Mask& mask);
/// The level 1/2 of the mask after Gaussian smoothing of 3 mm.
Surface surface_of(const Mask& mask);
/// Indices of about `count` points, one per cell of a cubic grid: the nearest one to the mean.
std::vector<std::size_t> thinned(std::span<const Vec3d> points, std::size_t count);

}  // namespace pliant::morph
