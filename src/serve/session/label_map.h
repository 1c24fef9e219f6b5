// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A label map on the scan's grid: each voxel at rest has the number of its label. The bodies of a
// scene are one, too.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/models/organs.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocol/messages.h"

namespace pliant::serve {

struct LabelMap {
    std::string name{};  ///< of the file
    Grid grid{};         ///< of the scan
    std::vector<LabelInfo> labels{};
    /// Number of each voxel's label in the list, from 1; 0 without a label. i fastest.
    std::vector<std::uint16_t> numbers{};
    /// Edge of the cubes at rest that clients see in two shades beside contacts of bodies [mm];
    /// 0: there are no bodies.
    double stripe_mm = 0;
};

/// Reads a label map and puts it on the scan's grid by labels_on. Colours are those of 3D Slicer's
/// segments in a NRRD file, names those of find_label_names (organs/label_names.h).
/// @param names  table of names; empty: none
/// @param give_up  polled while the file is read; may be empty
/// @returns an error for values that aren't whole numbers, more than kMaxLabels labels, and maps
///          without a label inside of the scan
Result<std::shared_ptr<const LabelMap>> read_label_map(const std::filesystem::path& file,
                                                       const Grid& scan, const TaskArena& arena,
                                                       const std::function<bool()>& give_up = {},
                                                       const std::filesystem::path& names = {});

/// Finds the number of voxels and the centre of each label.
void count_labels(LabelMap& map);

/// Makes the map of a scene's bodies; the surroundings are not shown.
/// @returns null for a single body; an error for labels beside the scan
Result<std::shared_ptr<const LabelMap>> map_bodies(const MadeOrgans& made, const Volume& scan,
                                                   const TaskArena& arena);

/// Marks the labels whose voxels bodies carry, and makes a label of the surroundings' voxels that
/// have none. @pre both maps are on the same grid
void mark_bodies(LabelMap& map, const LabelMap& bodies);

}  // namespace pliant::serve
