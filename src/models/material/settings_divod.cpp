// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The key=value lines of Divod's configuration [Draeger2005, 4.6].

#include <cctype>
#include <cmath>
#include <optional>
#include <sstream>

#include "base/errors.h"
#include "base/text.h"
#include "material/settings.h"

namespace pliant {
namespace {

std::string quoted(std::string_view text) {
    return "'" + shown(text) + "'";
}

/// Reduces a key to lower-case letters and digits: the thesis names its keys in words.
std::string plain_key(std::string_view key) {
    std::string plain;
    for (const char c : key)
        if (std::isalnum(static_cast<unsigned char>(c)))
            plain += char(std::tolower(static_cast<unsigned char>(c)));
    return plain;
}

Status read_divod_key(std::string_view key, std::string_view value, ChainMailSettings& s,
                      std::vector<std::string>& notes) {
    const std::string plain = plain_key(key);
    const std::string name = shown(key);
    if (plain == "maxtries" || plain == "stepscale") {
        notes.push_back(name + ": not needed, the largest valid step is found exactly");
        return Ok{};
    }
    if (plain == "adaptregionstozscale" || plain == "zscale") {
        notes.push_back(name + ": always on, the lattice works in millimetres");
        return Ok{};
    }
    const std::optional<double> read = number_from(value);
    if (!read || !std::isfinite(*read)) return expected_error(name, "a number", quoted(value));
    const double number = *read;
    if (plain == "cubiclesize") {
        if (number != std::floor(number) || std::abs(number) > 1000)
            return expected_error(name, "a whole number", quoted(value));
        s.brick_size = int(number);
    } else if (plain == "scalefactor" || plain == "scale") {
        s.scale = number;
    } else if (plain == "offset") {
        s.offset = number;
    } else if (plain == "bonethreshold") {
        s.bone_threshold_hu = number - 1000;
        notes.push_back(name + ": read on the scale 0 to 4095, bone_threshold_hu = value - 1000");
    } else if (plain.starts_with("max") && plain.find("movement") != std::string::npos) {
        s.max_movement_mm = number;
        notes.push_back(name + ": voxels are taken as millimetres");
    } else {
        return expected_error(name,
                              "cubicle size, scale factor, offset, maximum allowed movement, bone "
                              "threshold, adapt regions to z-scale, max tries or step scale",
                              "a key that has no meaning here");
    }
    return Ok{};
}

}  // namespace

Status read_divod(const std::string& text, ChainMailSettings& settings,
                  std::vector<std::string>& notes) {
    settings.smallest_bone_mm3 = 0;  // the thesis holds each voxel of bone
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::string_view content = trimmed(line);
        if (content.empty() || content.front() == '#') continue;
        const auto equals = content.find('=');
        if (equals == std::string_view::npos)
            return expected_error(quoted(content), "key=value", "no '='");
        const Status status = read_divod_key(trimmed(content.substr(0, equals)),
                                             trimmed(content.substr(equals + 1)), settings, notes);
        if (!status.ok()) return status;
    }
    return Ok{};
}

}  // namespace pliant
