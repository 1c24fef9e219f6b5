// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The models of `pliant deform --model`: the options that each takes, and its tissue.

#pragma once

#include <pliant/tissues.h>

#include <string>
#include <vector>

#include "options.h"

namespace pliant::app {

/// Traits of the chosen model.
const TissueTraits& traits_of(const DeformOptions& options);

/// @returns InvalidArgument for an option or an action of another model
Status check_model(const DeformOptions& options);

/// Reads the model's files, except the scan. @param[out] notes  remarks on them
Result<MakeTissue> prepare_tissue(const DeformOptions& options, std::vector<std::string>& notes);

}  // namespace pliant::app
