// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The picture of --png: before and after a deformation, four views each.

#pragma once

#include <pliant/data/scan_values.h>
#include <pliant/render.h>
#include <pliant/resample.h>

#include <optional>

#include "options.h"

namespace pliant::app {

/// Whether the picture's blood vessels move with the tissue: they need a RestField.
inline bool shows_rest(const PictureOptions& options) {
    return !options.png.empty() && options.look_of.style == "real";
}

/// @returns InvalidArgument that names the option
Status check_picture(const PictureOptions& options);

/// Returns the middle of the deformed part, or of the whole scan at rest: a position for the
/// picture if there is no push.
PushOption middle_of_deformation(const MovingScan& scan);

/// A spherical tool before and after the deformation. @see outline_tool
struct ShownTool {
    double radius_mm = 0;
    std::optional<Vec3d> before_mm{}, after_mm{};  ///< centres; nullopt: not there
};

/// Draws before and after, with the same camera and the same sections through the pushed point.
/// @param rest  may be empty unless shows_rest()
/// @param place  point and direction of the picture
Image before_and_after(const PictureOptions& options, const MovingScan& scan, const Volume& after,
                       const RestField& rest, const ValueDefaults& values, const PushOption& place,
                       const ShownTool& tool = {});

}  // namespace pliant::app
