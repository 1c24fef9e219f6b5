// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Defaults of the commands that follow from a scan's values.

#pragma once

#include <pliant/data/scan_values.h>
#include <pliant/render.h>
#include <pliant/tissues.h>

#include <optional>
#include <string>

namespace pliant::app {

/// Determines the kind of a scan's values, and sets its background.
ValueDefaults take_values(Volume& volume, const ReadNotes& notes);

/// Settings of the elastic scan: those that suit the values, then the file, then options.
/// @param config  a settings file; may be empty
/// @returns errors that name the file and the key, or the option
Result<ElasticScanSettings> elastic_settings(const std::string& config, const Record& options,
                                             const ValueDefaults& values);

/// Polarity of an option, or else of the defaults.
inline Polarity polarity_of(const std::optional<std::string>& option, const ValueDefaults& values) {
    const bool falling = option ? *option == "falling" : values.lumen_is_bright;
    return falling ? Polarity::Falling : Polarity::Rising;
}

}  // namespace pliant::app
