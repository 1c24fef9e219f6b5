// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Options that several commands share.

#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "options.h"

namespace pliant::app {

/// Parses numbers separated by a character, independent of the locale.
/// @throws CLI::ValidationError that names the option, unless there are `count` finite ones
std::vector<double> parse_numbers(std::string_view text, char separator, std::size_t count,
                                  const std::string& option);
/// Parses three numbers separated by commas. @throws as parse_numbers
Vec3d parse_vector(std::string_view text, const std::string& option);

CLI::Option* add_vector(CLI::App* command, const std::string& name, std::optional<Vec3d>& target,
                        const std::string& help);
/// Adds --series, --frame, --straighten and --spacing.
/// @param spacing  name of the last one where another option has it
void add_scan(CLI::App* command, ScanChoice& scan, const std::string& spacing = "--spacing");
/// Adds --units: of lengths in the files of meshes.
CLI::Option* add_units(CLI::App* command, std::string& units);
/// Adds --bodies: the labels of which bodies are made.
void add_body_labels(CLI::App* command, std::optional<std::vector<int>>& bodies);
/// Adds --label-names: the file of the names of --labels.
void add_label_names(CLI::App* command, std::string& file);
void add_threads(CLI::App* command, int& threads);
/// Adds --iso and --polarity. @param meaning  "threshold of the surface"
void add_surface(CLI::App* command, std::optional<double>& iso,
                 std::optional<std::string>& polarity, const std::string& meaning);
/// Adds --window and --level. @param more_window, more_level  added to the defaults' texts
void add_window(CLI::App* command, std::optional<double>& window, std::optional<double>& level,
                const std::string& more_window = {}, const std::string& more_level = {});
/// Adds --style, --lining and --field.
void add_look(CLI::App* command, LookOptions& look);
/// Adds --png and the options of its views. @param look  text for the default of --look
void add_picture(CLI::App* command, PictureOptions& picture, const std::string& look);

}  // namespace pliant::app
