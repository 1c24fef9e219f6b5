// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tools that slide along tissue: contact without friction, and an eye that stays out of tissue.
//
//      o →            A push (ChainMail::push) carries the grabbed elements along: a bump that
//     .--.            the tool meets on its slope is pressed into the wall, and the wall follows.
//     |  |            In a slide, the tissue leaves the sphere along the sphere's outward normal.
//  ───'  '─────       So the bump is bent aside, and the tool goes on past it.
//
// The path is cut into steps of at most half a voxel. After each step, the cells whose trilinear
// value is tissue somewhere in the sphere move together by the minimal distance that takes all of
// it out, along the mean direction from the sphere's centre to that tissue. All other elements make
// their minimal move, as after every push. A sphere between voxels, or between thick slices,
// touches the wall like a larger sphere.

#pragma once

#include <pliant/chainmail.h>

#include <cstdint>

#pragma GCC visibility push(default)
namespace pliant {

/// Leads a sphere from path.point_mm along path.push_mm, times the scale setting. It should start
/// in air: tissue inside of it leaves it in the first step. The slide is one step of the history,
/// "slide". The resampled scan shows no tissue at end_mm, unless ends_in_tissue. A slide that would
/// close the lumen around the eye permanently is undone, and its way_fraction is 0. Inside of a
/// group, or without a history, it isn't undone.
/// @param tissue_values  default: values from settings.air_threshold_hu upwards
/// @returns InvalidArgument if the sphere has no radius, or its path isn't finite, is zero, longer
///          than 500 mm or outside of the scan; LimitExceeded as ChainMail::push. Then nothing has
///          changed
Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path,
                                 const TissueValues& tissue_values);
Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path);

}  // namespace pliant
#pragma GCC visibility pop
