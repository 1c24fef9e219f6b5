// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tool that tissue slides off: contact without friction.
//
//      o →            A push (ChainMail::push) takes what it grabs along, all the way: a bump that
//     .--.            the tool meets on its slope goes into the wall, and the wall goes with it.
//     |  |            Here the tissue leaves the sphere the way that the sphere's surface faces, so
//  ───'  '─────       the bump is bent aside, and the tool goes on past it.
//
// The way is cut into steps of half a voxel. After each, the tissue elements inside of the sphere
// move as one along the mean direction from its centre to them, just as far as takes them all out;
// everything else makes its least move, as after any push.

#pragma once

#include <pliant/chainmail.h>

#include <cstdint>

namespace pliant {

struct SlideReport {
    double way_fraction = 0;                 ///< of the scaled way, done in whole steps, 0…1
    LimitedBy limited_by = LimitedBy::None;  ///< what ended it: Bone or Movement
    int contacts = 0;                        ///< moves that tissue made to get out of the way
    /// Tissue that is in the sphere at the end: where it is wedged in, or where something ended it.
    std::int64_t inside_elements = 0;
    double slide_ms = 0;
    int forgotten_steps = 0;  ///< oldest steps that this one pushed out of the history
};

/// Leads a sphere from path.point_mm along path.push_mm, times the scale setting. It should start
/// in air: tissue inside of it leaves it with the first step. One step of the history, "slide".
/// @returns InvalidArgument where the sphere has no radius, or its way is no number, zero, longer
///          than 500 mm or not inside of the scan; LimitExceeded as ChainMail::push, after part of
///          the way
Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path);

}  // namespace pliant
