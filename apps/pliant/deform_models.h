// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The models of `pliant deform --model`: the options that each takes, and its tissue.

#pragma once

#include <pliant/data/scan_values.h>
#include <pliant/tissues.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "options.h"

namespace pliant::app {

/// Makes the tissue of a scan, with settings that suit its values; both must outlive it.
using MakeScanTissue = std::function<Result<std::unique_ptr<Tissue>>(
    const Volume& scan, const ValueDefaults& values, const TaskArena& arena)>;

/// A model of --model.
struct DeformModel {
    std::string_view name;  ///< in tissue_models()
    /// Reads the model's files, except the scan. @param[out] notes  remarks on them
    Result<MakeScanTissue> (*prepare)(const DeformOptions& options,
                                      std::vector<std::string>& notes);
    /// Simulated time to come to rest, for long steps; none: the number of steps is limited.
    std::optional<double> max_ms{};
};
std::span<const DeformModel> deform_models();
const DeformModel& model_of(const DeformOptions& options);
/// Traits of the chosen model.
const TissueTraits& traits_of(const DeformOptions& options);

/// @returns InvalidArgument for an option or an action of another model
Status check_model(const DeformOptions& options);

/// The scan of a deformation, and its tissue.
struct DeformSource {
    std::function<Result<Volume>(ReadNotes& notes)> read;
    MakeScanTissue make;
    /// Writes the moved mesh; may be empty.
    std::function<Status(const std::filesystem::path&)> write_mesh;
    std::string labels{};  ///< file of the label map that moves with the scan; may be empty
};
using Prepare =
    std::function<Result<DeformSource>(std::vector<std::string>& notes, const TaskArena& arena)>;

/// Reads, pushes, lets time pass, writes all outputs. @returns the exit status
int deform(const DeformOptions& options, const Prepare& prepare);

}  // namespace pliant::app
