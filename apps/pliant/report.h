// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What `pliant deform` did, as one JSON object (docs/conventions.md, "The report").

#pragma once

#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <optional>
#include <string>
#include <vector>

#include "options.h"

namespace pliant::app {

struct DeformResult {
    std::vector<PushReport> pushes;
    double edit_ms = 0;                ///< of cuts and carvings
    std::optional<RelaxReport> relax;  ///< none: not asked for
    LatticeState state;
    FoldCertificate certificate;
    Deformed deformed;
    std::uint64_t hash = 0;
    std::vector<std::string> notes;
};

/// All pushes as one: rejected if none did anything, applied if all were done in full.
PushReport summary_of(const std::vector<PushReport>& pushes);

std::string report_json(const DeformOptions& options, const DeformResult& result);

/// A few lines for a person.
std::string report_text(const DeformResult& result);

}  // namespace pliant::app
