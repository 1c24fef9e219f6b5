// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scene file of `pliant vessel`: docs/vessel.md lists its keys.

#pragma once

#include <pliant/catheter.h>

#include <optional>
#include <string>
#include <vector>

namespace pliant::app {

/// What the hand does for a while: until the first of the bounds that are given.
struct VesselAct {
    CatheterCommand command{};
    bool follow = false;  ///< the tip is steered along the way
    std::optional<double> for_s, until_inserted_mm, until_way_mm;
};

struct VesselFile {
    // One of: a phantom, a surface, a centreline, a label volume, a scan.
    std::string phantom, surface, centreline, labels_file, scan;
    std::string ends;  ///< a centreline at whose ends a closed surface is cut off
    double trim = 0.5;
    std::vector<int> labels{1};
    double low_hu = 0, high_hu = 0, within_mm = 15, smoothing_voxels = 0.8;
    WallSettings wall{};

    std::string way_file;
    int way_branch = 1;
    bool way_reverse = false;
    std::vector<Vec3d> way_mm;  ///< points, or with a scan from and to
    double ahead_mm = 15, gain = 1.5, most_deg = 120;

    int entry_end = 1;  ///< number of the open end
    double entry_inwards = 0.5;
    bool entry_given = false;  ///< as a place and a direction
    CatheterSettings settings{};
    std::vector<VesselAct> acts;
    double most_steps = 1e6;
};

/// Files that it names are found from its own folder.
/// @returns one line that names the file and the key
Result<VesselFile> read_vessel_file(const std::string& file);

}  // namespace pliant::app
