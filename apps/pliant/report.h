// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Report of `pliant deform` as one JSON object (docs/reference/conventions.md, "The report").

#pragma once

#include <pliant/resample.h>
#include <pliant/tissue.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <pliant/data/scan_values.h>

#include "options.h"

namespace pliant::app {

/// The time after the actions.
struct Advanced {
    AdvanceReport report;
    std::optional<double> energy_before_mm2, energy_after_mm2;  ///< nullopt: no energy
    std::optional<Vec3d> force_n;                               ///< on the last tool
};

struct DeformResult {
    std::vector<PushReport> pushes;
    std::vector<SlideReport> slides;
    double edit_ms = 0;                ///< of cuts and carvings
    std::optional<Advanced> advanced;  ///< nullopt: no time has passed
    Record figures;                    ///< Tissue::report(), and those of add_figures()
    Deformed deformed;
    std::optional<Volume> single;  ///< the deformed scan, if it has one slice
    RestField rest;                ///< for a picture in the style real
    Volume labels;                 ///< for --labels-out
    std::uint64_t hash = 0;
    std::vector<std::string> notes;
    ValueDefaults values;  ///< of the scan
};

/// A figure by its name, or null.
const SettingValue* find_figure(const Record& record, std::string_view name);
/// Adds the figures of any deformation.
void add_figures(const DeformationState& state, Record& record);

std::string report_json(const DeformOptions& options, const DeformResult& result);

/// A few lines of readable text.
std::string report_text(const DeformOptions& options, const DeformResult& result);

}  // namespace pliant::app
