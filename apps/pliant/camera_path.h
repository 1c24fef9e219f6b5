// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A way for the endoscope: the control points of a curve that 3D Slicer saved (.mrk.json), and the
// smooth flight along it.

#pragma once

#include <pliant/result.h>
#include <pliant/vec.h>

#include <string>
#include <vector>

namespace pliant::app {

/// @returns the control points of the file's first curve [mm, LPS], at least two different ones
Result<std::vector<Vec3d>> read_camera_path(const std::string& file);

/// Writes a curve for 3D Slicer, LPS.
/// @param radius_mm  of the lumen at each point: kept as the points' descriptions
Status write_camera_path(const std::string& file, const std::vector<Vec3d>& points_mm,
                         const std::vector<double>& radius_mm);

struct CameraPose {
    Vec3d eye_mm, look, up;  ///< LPS
};

/// Poses along the smoothed path, each the same way from the one before. The camera looks at where
/// it will be a little later, and doesn't roll.
/// @param step_mm  between poses, > 0
std::vector<CameraPose> fly(const std::vector<Vec3d>& points_mm, double step_mm);

}  // namespace pliant::app
