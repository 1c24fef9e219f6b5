// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A flight of the endoscope: the control points of a curve saved by 3D Slicer (.mrk.json), and the
// smooth camera path along it.

#pragma once

#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <string>
#include <vector>

namespace pliant::app {

/// Reads the file's first curve. @returns control points [mm, LPS], at least two different ones
Result<std::vector<Vec3d>> read_camera_path(const std::string& file);

/// Writes a curve for 3D Slicer, LPS.
/// @param radius_mm  lumen radius at each point, stored in the points' descriptions
Status write_camera_path(const std::string& file, const std::vector<Vec3d>& points_mm,
                         const std::vector<double>& radius_mm);

struct CameraPose {
    Vec3d eye_mm, look, up;  ///< LPS
};

/// Poses along the smoothed path at equal distances. The camera looks at a later point of the path,
/// and doesn't roll.
/// @param step_mm  between poses, > 0
/// @param scale  of the smoothing and of the view ahead; see length_scale
std::vector<CameraPose> fly(const std::vector<Vec3d>& points_mm, double step_mm, double scale = 1);

}  // namespace pliant::app
