// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "output_names.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <cctype>
#include <utility>

namespace pliant::app {
namespace {

namespace fs = std::filesystem;

Status check_name(const std::string& option, const std::string& name,
                  const std::vector<std::string>& endings) {
    std::string expected, found = fs::path(name).filename().string();
    for (char& c : found) c = char(std::tolower(static_cast<unsigned char>(c)));
    for (const std::string& ending : endings) {
        if (found.ends_with(ending)) return Ok{};
        const bool last = &ending == &endings.back();
        expected += (expected.empty() ? "" : last ? " or " : ", ") + ending;
    }
    if (endings.empty()) return Ok{};
    return Error{ErrorCode::InvalidArgument,
                 option + ": expected a name that ends in " + expected + ", found " + name};
}

/// Resolves links. If that fails, the path is unchanged, and staging reports the error.
fs::path whole_path(const fs::path& path) {
    std::error_code error;
    fs::path whole = fs::weakly_canonical(path, error);
    return error ? path : whole;
}

}  // namespace

std::vector<std::string> scan_endings() {
    const auto endings = volume_endings();
    return {endings.begin(), endings.end()};
}

Status check_volume_name(const std::string& option, const std::string& name) {
    return check_name(option, name, scan_endings());
}

Status check_picture_name(const std::string& option, const std::string& name) {
    return check_name(option, name, {".png"});
}

Status stage_names(std::span<const OutputName> outputs, const std::string& input,
                   StagedFiles& files) {
    std::vector<std::pair<std::string, fs::path>> taken = {{"FILE", whole_path(input)}};
    for (const OutputName& output : outputs) {
        if (output.name.empty()) continue;
        if (const Status status = check_name(output.option, output.name, output.endings);
            !status.ok())
            return status;
        const fs::path place = whole_path(output.name);
        for (const auto& [option, other] : taken)
            if (place == other)
                return Error{ErrorCode::InvalidArgument,
                             std::string(output.option) + ": expected a file of its own, found " +
                                 output.name + ", which is " + option};
        taken.emplace_back(output.option, place);
        const auto staged = files.stage(output.name);
        if (!staged.ok()) return staged.error();
        output.staged = *staged;
    }
    return Ok{};
}

}  // namespace pliant::app
