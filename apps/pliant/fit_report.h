// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts that `pliant fit` of a box and of a mesh share: methods, table and report.

#pragma once

#include <pliant/models/fit.h>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "json.h"
#include "options.h"

namespace pliant::app {

/// Parses numbers separated by commas; empty for invalid text.
std::vector<double> numbers_of(std::string_view text);
Error bad_option(const std::string& option, const std::string& expected, const std::string& found);

FitSettings settings_of(const FitOptions& options);
/// The chosen methods, or the default.
std::vector<std::string> methods_of(const FitOptions& options);
FitMethod method_of(const std::string& name, const FitOptions& options,
                    const std::vector<double>& closed_form);

/// A method's result.
struct FitTable {
    const FitProblem& problem;
    const FitResult& result;
    std::span<const FitInterval> intervals;  ///< empty: unknown
    std::string note;                        ///< empty: none
    const char* length;                      ///< of which errors are percentages
};
void print(const std::string& method, const FitTable& table);
Json method_json(const std::string& method, const FitTable& table);

/// Warns of loads whose largest displacement in the reference is no small part of the solid: the
/// finite elements and the linear motion are for small displacements.
/// @param smallest_side  of the solid's box, in the network's unit of length
/// @param mm             of that unit
std::vector<std::string> large_loads(const FitProblem& problem, double smallest_side, double mm);
void print_warnings(const std::vector<std::string>& warnings);

Status write_report(const std::filesystem::path& path, const Json& report);

int run_fit_mesh(const FitOptions& options);

}  // namespace pliant::app
