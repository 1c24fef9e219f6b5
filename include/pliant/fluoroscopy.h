// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Simulates the picture of an X-ray image intensifier. The absorption along each ray from the
// source to the detector is
//
//   I / I₀ = exp(−∫ μ ds),   μ = μ_water · max(0, 1 + HU/1000)
//
// for one energy, without scatter or beam hardening. Dense material is dark. The grey value depends
// on p = contrast · ∫ μ ds, nearly linearly around the exposure p₀, with soft shoulders:
//
//   grey = 1 / (1 + 0.55/0.45 · exp(4 (p − p₀) / 4))
//
// This is the sigmoid of DICOM PS3.3, C.11.2.1.3.1, with a window of 4, on a logarithmic detector
// signal. p₀ is 45 % grey. By default it is the median over a grid of 7 × 7 rays through the
// central third of the picture; rays that miss the scan do not count.
//
// A scan is often cut out of a body. Beyond the outermost voxels, up to the two planes across
// `look` that touch the scan, the outermost values continue and fade out:
//
//   μ(x) = μ(nearest voxel centre in the scan) · (1 − e²/b²)²   for e < b, else 0
//
// with e the distance from the scan and b the border, both in mm. This avoids a visible outline of
// the scan's box. Air around a body stays air.

#pragma once

#include <pliant/render.h>

#include <cstdint>
#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// The defaults suit measurements: no noise, no collimator. `pliant render` and the page turn both
/// on.
struct Fluoroscopy {
    Vec3d centre_mm{0, 0, 0};    ///< middle of the picture [LPS]
    Vec3d look{0, 1, 0};         ///< from the source to the detector, length > 0
    Vec3d up{0, 0, 1};           ///< zero or parallel to look: superior or anterior is used
    double source_mm = 1000;     ///< from the source to the centre, > 0
    double width_mm = 200;       ///< width of the picture at the centre, > 0
    double water_per_mm = 0.02;  ///< μ of water, about 60 keV [1/mm]
    double contrast = 1;         ///< factor of the line integral, > 0
    std::optional<double> exposure_water_mm{};  ///< water length at 45 % grey; nullopt: metered
    /// Distance over which the outermost voxels fade out, ≥ 0. 0: nothing beyond the outermost
    /// voxel centres. nullopt: a third of the cube root of the scan's volume.
    std::optional<double> border_mm{};
    FieldStop field_stop = FieldStop::Full;  ///< the collimator
    /// Quantum noise, ≥ 0. At 1 the line integral has a standard deviation of 0.05 at the exposure,
    /// and of 0.05 exp((p − p₀)/2) elsewhere, 0.2 at most, before the contrast.
    double noise = 0;
    std::uint32_t seed = 0;  ///< seed of the noise: a picture's number
};

/// Computes ∫ max(0, 1 + HU/1000) ds along the ray of each pixel's middle [mm of water], rows from
/// the top, with the border, without noise or collimator.
std::vector<float> water_lengths_mm(const Volume& volume, const Fluoroscopy& settings, int width,
                                    int height, const TaskArena& arena);

Image fluoroscopy_view(const Volume& volume, const Fluoroscopy& settings, int width, int height,
                       const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
