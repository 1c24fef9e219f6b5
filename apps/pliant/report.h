// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Report of `pliant deform` as one JSON object (docs/conventions.md, "The report").

#pragma once

#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <optional>
#include <string>
#include <vector>

#include "options.h"

namespace pliant::app {

/// Report of --model springs.
struct SpringResult {
    Vec3i cell_voxels{0, 0, 0};
    Vec3i nodes{0, 0, 0};
    std::int32_t fixed_nodes = 0, active_nodes = 0, depth = 0;
    double time_step_ms = 0, young_modulus_pa = 0, solve_ms = 0;
    std::int64_t steps = 0;  ///< after the pushes
    bool settled = false;
    Vec3d force_n{0, 0, 0};  ///< on the last tool
};

struct DeformResult {
    std::vector<PushReport> pushes;
    std::vector<SlideReport> slides;
    double edit_ms = 0;                   ///< of cuts and carvings
    std::optional<RelaxReport> relax;     ///< nullopt: not requested
    std::optional<SpringResult> springs;  ///< nullopt: ChainMail
    LatticeState state;
    FoldCertificate certificate;  ///< ChainMail only
    Deformed deformed;
    RestField rest;  ///< for a picture in the style real
    std::uint64_t hash = 0;
    std::vector<std::string> notes;
};

std::string report_json(const DeformOptions& options, const DeformResult& result);

/// A few lines of readable text.
std::string report_text(const DeformResult& result);

}  // namespace pliant::app
