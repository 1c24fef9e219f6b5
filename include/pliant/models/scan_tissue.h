// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The tissue of a scan's own voxels, by the model that its settings are of. Registration truth
// (truth.h) and environments (gym.h) take any of them.
//
// @code
//   ScanTissueSettings settings = ElasticScanSettings{.poisson_ratio = 0.4};
//   auto tissue = make_scan_tissue(scan, settings, arena);
// @endcode

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/models/elastic_scan.h>
#include <pliant/models/material.h>
#include <pliant/result.h>
#include <pliant/tissue.h>
#include <pliant/volume.h>

#include <memory>
#include <string_view>
#include <variant>

#pragma GCC visibility push(default)
namespace pliant {

/// Settings of ChainMail, or of the elastic scan.
using ScanTissueSettings = std::variant<ChainMailSettings, ElasticScanSettings>;

/// "chainmail" or "elastic", as in tissue_models().
std::string_view model_of(const ScanTissueSettings& settings) noexcept;

/// Makes the tissue: make_chainmail() or make_elastic() (tissues.h).
Result<std::unique_ptr<Tissue>> make_scan_tissue(const Volume& scan,
                                                 const ScanTissueSettings& settings,
                                                 const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
