// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan as an X-ray image intensifier would show it: each ray from the source to the detector is
// dimmed by what it goes through,
//
//   I / I₀ = exp(−∫ μ ds),   μ = μ_water · max(0, 1 + HU/1000)
//
// for one energy, without scatter or beam hardening. Dense is dark. The grey depends on
// p = contrast · ∫ μ ds, nearly linear around the exposure p₀, with soft shoulders:
//
//   grey = 1 / (1 + 0.55/0.45 · exp(4 (p − p₀) / 4))
//
// the sigmoid of DICOM PS3.3, C.11.2.1.3.1, with a window of 4, on a logarithmic detector signal.
// p₀ is 45 % grey. By default it is the median over a grid of 7 × 7 rays through the central third
// of the picture; rays that miss the scan do not count.
//
// A scan is often cut out of a body. Beyond its outermost voxels, up to the two planes across
// `look` that touch it, they go on and fade out, so that a ray that leaves through a side ends
// nowhere at once:
//
//   μ(x) = μ(nearest voxel centre in the scan) · (1 − e²/b²)²   for e < b, else 0
//
// with e the distance from the scan and b the border, both in mm. So there is no picture of the
// scan's box; air around a body stays air.

#pragma once

#include <pliant/render.h>

#include <cstdint>
#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// As made, it measures: no noise, no collimator. `pliant render` and the page turn both on.
struct Fluoroscopy {
    Vec3d centre_mm{0, 0, 0};    ///< in the picture's middle [LPS]
    Vec3d look{0, 1, 0};         ///< from the source to the detector, any length > 0
    Vec3d up{0, 0, 1};           ///< zero or parallel to look: superior or anterior is taken
    double source_mm = 1000;     ///< from the source to the centre, > 0
    double width_mm = 200;       ///< that the picture's width shows at the centre, > 0
    double water_per_mm = 0.02;  ///< μ of water, about 60 keV [1/mm]
    double contrast = 1;         ///< factor of the line integral, > 0
    std::optional<double> exposure_water_mm{};  ///< water that is 45 % grey; none: metered
    /// Over which the outermost voxels fade out, ≥ 0; 0: beyond the outermost voxel centres is
    /// nothing; none: a third of the cube root of the scan's volume.
    std::optional<double> border_mm{};
    FieldStop field_stop = FieldStop::Full;  ///< the collimator
    /// Of the quantum noise, ≥ 0; at 1 the line integral has a standard deviation of 0.05 at the
    /// exposure, and of 0.05 exp((p − p₀)/2) elsewhere, 0.2 at most, before the contrast.
    double noise = 0;
    std::uint32_t seed = 0;  ///< of the noise: a picture's number
};

/// ∫ max(0, 1 + HU/1000) ds along the ray of each pixel's middle [mm of water], rows from the top,
/// with the border, without noise or collimator.
std::vector<float> water_lengths_mm(const Volume& volume, const Fluoroscopy& settings, int width,
                                    int height, const TaskArena& arena);

Image fluoroscopy_view(const Volume& volume, const Fluoroscopy& settings, int width, int height,
                       const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
