// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tools that tissue slides off: contact without friction, and an eye that stays out of tissue.
//
//      o →            A push (ChainMail::push) takes what it grabs along, all the way: a bump that
//     .--.            the tool meets on its slope goes into the wall, and the wall goes with it.
//     |  |            Here the tissue leaves the sphere the way that the sphere's surface faces, so
//  ───'  '─────       the bump is bent aside, and the tool goes on past it.
//
// The way is cut into steps of at most half a voxel. After each, the cells whose trilinear value is
// tissue somewhere in the sphere move together along the mean direction from its centre to that
// tissue, by the least distance that takes all of it out. All other elements make their least move,
// as after any push. A sphere between voxels, or between thick slices, touches the wall like a
// larger one.

#pragma once

#include <pliant/chainmail.h>

#include <cstdint>

#pragma GCC visibility push(default)
namespace pliant {

/// The values that are tissue for a tool: those from a threshold upwards, or those below it.
struct TissueValues {
    double threshold_hu = -500;
    bool is_above = true;

    bool hold(double value_hu) const { return (value_hu >= threshold_hu) == is_above; }
};

struct SlideReport {
    double way_fraction = 0;  ///< of the scaled way, done in whole steps, 0…1
    /// Cause of the end: Bone; Movement; Wall where tissue closes around the sphere's centre.
    LimitedBy limited_by = LimitedBy::None;
    /// The sphere's centre at the end [mm, LPS]: way_fraction of the way, or the nearest free place
    /// where tissue came to lie there. An endoscope's eye can stay here.
    Vec3d end_mm{0, 0, 0};
    bool ends_in_tissue = false;       ///< no free place was found within reach
    int contacts = 0;                  ///< moves that tissue made to get out of the way
    std::int64_t inside_elements = 0;  ///< tissue elements in the sphere at end_mm
    double slide_ms = 0;
    int forgotten_steps = 0;  ///< oldest steps that this one pushed out of the history
};

/// Leads a sphere from path.point_mm along path.push_mm, times the scale setting. It should start
/// in air: tissue inside of it leaves it with the first step. One step of the history, "slide".
/// The resampled scan shows no tissue at end_mm, unless ends_in_tissue. A slide that would close
/// the lumen around the eye for good is taken back, and its way_fraction is 0; inside of a group,
/// or without a history, it isn't.
/// @param tissue_values  without them: those from settings.air_threshold_hu upwards
/// @returns InvalidArgument where the sphere has no radius, or its way is no number, zero, longer
///          than 500 mm or not inside of the scan; LimitExceeded as ChainMail::push. Nothing has
///          changed then
Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path,
                                 const TissueValues& tissue_values);
Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path);

}  // namespace pliant
#pragma GCC visibility pop
