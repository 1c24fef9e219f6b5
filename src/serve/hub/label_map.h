// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps from files. Maps on another grid than the scan's are sampled at the nearest voxel, so
// that the labels of a crop fit the whole scan.

#pragma once

#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "session/label_map.h"

namespace pliant::serve {

/// Reads a label map. Colours are those of 3D Slicer's segments in a NRRD file, names those of
/// find_label_names (organs/label_names.h).
/// @param names  table of names; empty: none
/// @param give_up  polled while the file is read; may be empty
/// @returns an error for values that aren't whole numbers, more than kMaxLabels labels, and maps
///          without a label inside of the scan
Result<std::shared_ptr<const LabelMap>> read_label_map(const std::filesystem::path& file,
                                                       const Grid& scan, const TaskArena& arena,
                                                       const std::function<bool()>& give_up = {},
                                                       const std::filesystem::path& names = {});

}  // namespace pliant::serve
