// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Names of a command's output files: checked and staged together.

#pragma once

#include <pliant/core/files.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace pliant::app {

struct OutputName {
    const char* option;
    const std::string& name;             ///< empty: not requested
    std::filesystem::path& staged;       ///< set by stage_names; unchanged if not requested
    std::vector<std::string> endings{};  ///< allowed extensions; empty: all
};

/// Extensions of scans, as write_volume takes them.
std::vector<std::string> scan_endings();

/// @returns InvalidArgument unless the name of a scan ends in one of them
Status check_volume_name(const std::string& option, const std::string& name);
/// @returns InvalidArgument unless the name of a picture ends in .png
Status check_picture_name(const std::string& option, const std::string& name);

/// @param input  the command's input file, which no output may replace
/// @returns InvalidArgument for another extension, or a file that is named twice
Status stage_names(std::span<const OutputName> outputs, const std::string& input,
                   StagedFiles& files);

}  // namespace pliant::app
