// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What `pliant deform` did, as one JSON object (docs/conventions.md, "The report").

#pragma once

#include <pliant/chainmail.h>
#include <pliant/chainmail_slide.h>
#include <pliant/resample.h>

#include <optional>
#include <string>
#include <vector>

#include "options.h"

namespace pliant::app {

struct DeformResult {
    std::vector<PushReport> pushes;
    std::vector<SlideReport> slides;
    double edit_ms = 0;                ///< of cuts and carvings
    std::optional<RelaxReport> relax;  ///< none: not asked for
    LatticeState state;
    FoldCertificate certificate;
    Deformed deformed;
    std::uint64_t hash = 0;
    std::vector<std::string> notes;
};

std::string report_json(const DeformOptions& options, const DeformResult& result);

/// A few lines for a person.
std::string report_text(const DeformResult& result);

}  // namespace pliant::app
