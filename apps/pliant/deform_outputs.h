// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The output files of `pliant deform`. They are staged, and committed together at the end.

#pragma once

#include <pliant/core/files.h>
#include <pliant/resample.h>

#include <filesystem>
#include <functional>

#include "options.h"
#include "progress.h"
#include "report.h"

namespace pliant::app {

/// Staged paths of the outputs.
struct Outputs {
    StagedFiles files;
    std::filesystem::path out, labels, displacement, transform, jacobian, strain, report, png,
        state, mesh;
};

/// Writers of the tissue's own files.
struct OwnOutputs {
    std::function<Status(const std::filesystem::path&)> save_state, write_mesh;
};

Status stage_outputs(const DeformOptions& options, Outputs& outputs);

/// @param place  point and direction of the picture
Status write_outputs(const DeformOptions& options, const MovingScan& scan,
                     const DeformResult& result, const PushOption& place, const OwnOutputs& own,
                     Outputs& outputs, ProgressBar& bar);

}  // namespace pliant::app
