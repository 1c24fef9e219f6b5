// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checks of settings, field by field.

#pragma once

#include <pliant/models/material.h>

namespace pliant {

/// @returns InvalidArgument that names the key, and the value found and expected
Status check_settings(const ChainMailSettings& settings);

/// Reads the key=value lines of Divod. @param[out] notes  like read_chainmail_settings
/// @returns an error without the name of the file
Status read_divod(const std::string& text, ChainMailSettings& settings,
                  std::vector<std::string>& notes);

/// All keys that a settings file can have, as TOML; parse_settings restores the same bits.
std::string settings_text(const ChainMailSettings& settings);
/// @param name  for messages
Result<ChainMailSettings> parse_settings(const std::string& name, const std::string& toml);

}  // namespace pliant
