// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The folder of `pliant truth`: docs/howto/truth.md lists its files.

#pragma once

#include <pliant/data/truth.h>
#include <pliant/scan_files.h>

#include <filesystem>
#include <string>
#include <vector>

#include "json.h"

namespace pliant::app {

/// A data set: truth.json.
struct TruthIndex {
    Json json;
    std::string ending;              ///< of images: ".nrrd" or ".nii.gz"
    std::vector<std::string> cases;  ///< folders
};

/// Writes the files of a case to a folder. Two at a time where there are threads.
Status write_truth_case(const TruthCase& made, const Json& record,
                        const std::filesystem::path& folder, const std::string& ending,
                        Encoding encoding, const TaskArena& arena);
/// The record of a case: case.json.
/// @param model  of the tissue
Json truth_record(const TruthCase& made, const std::string& model, const TruthSettings& settings);

/// @returns NotFound; Unreadable that names the file and the field
Result<TruthIndex> read_truth_index(const std::filesystem::path& folder);
/// Reads the parts of a case that scores need.
Result<TruthData> read_truth_data(const std::filesystem::path& folder, const std::string& ending);
/// Reads points: lines of three numbers x, y, z [mm, LPS] separated by commas or blanks, or six
/// with the fixed point first; lines that begin with a letter or '#' are skipped.
Result<std::vector<Vec3d>> read_points(const std::filesystem::path& path);

}  // namespace pliant::app
