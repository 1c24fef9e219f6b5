// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings checked field by field.

#pragma once

#include <pliant/chainmail.h>

namespace pliant {

/// @returns InvalidArgument that names the key, what was found and what was expected
Status check_settings(const ChainMailSettings& settings);

/// Reads the key=value lines of Divod. @param[out] notes  as read_chainmail_settings
/// @returns an error without the name of the file
Status read_divod(const std::string& text, ChainMailSettings& settings,
                  std::vector<std::string>& notes);

/// All keys that a settings file can have, as TOML; parse_settings reads them back, bit for bit.
std::string settings_text(const ChainMailSettings& settings);
/// @param name  for messages
Result<ChainMailSettings> parse_settings(const std::string& name, const std::string& toml);

}  // namespace pliant
