// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Test scans from analytic shapes, in Hounsfield units, identical on every machine.

#pragma once

#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A recommended push and view of a phantom [mm, LPS].
struct PhantomLandmark {
    std::string name;     ///< "carina", "septum", …
    Vec3d push_point_mm;  ///< on the tissue's surface
    Vec3d push_mm;        ///< a push with a clear effect
    Vec3d eye_mm;         ///< in the lumen, with the pushed point in view
    Vec3d look;           ///< unit vector from the eye
};

struct PhantomSettings {
    std::string name;           ///< one of phantom_names()
    Vec3i size{128, 128, 128};  ///< voxels
    /// [mm]; zero: the phantom's extent divided by the size
    Vec3d spacing_mm{0, 0, 0};
    Mat3d direction = kIdentity3;  ///< axes of the grid in LPS; the shapes don't rotate
};

struct Phantom {
    Volume volume;                           ///< centred on the world's origin
    std::vector<PhantomLandmark> landmarks;  ///< may be empty; also in the volume's key_values
};

std::span<const std::string_view> phantom_names();

/// Makes a phantom. The shapes are fixed in the world; size, spacing and direction define the
/// sampling. Edges are anti-aliased: over one voxel in cube and layers, over two, as in a scanner,
/// in the others.
/// @returns InvalidArgument with the valid names, or the field that is out of range
Result<Phantom> make_phantom(const PhantomSettings& settings, const TaskArena& arena,
                             const Progress& progress = {});

}  // namespace pliant
#pragma GCC visibility pop
