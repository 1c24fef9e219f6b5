// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings of the library as options; text, unit, range and default come from its rows.

#pragma once

#include <pliant/core/record.h>

#include <string>
#include <string_view>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace pliant::app {

/// Option name of a setting: "--cell-mm" for cell_mm.
std::string option_of(std::string_view name);

/// The same error with the option's name instead of the setting's.
Error named_by_option(Error error);

/// Adds an option whose value is added to a record, to be applied later.
/// @param other_names  aliases with a comma in front; may be empty
CLI::Option* add_setting(CLI::App* command, const SettingInfo& row, const SettingValue& missing,
                         Record& given, const std::string& other_names = {});

/// Adds the option of a named row.
template <class T>
CLI::Option* add_setting(CLI::App* command, SettingRows<T> rows, std::string_view name,
                         Record& given, const std::string& other_names = {}) {
    const Setting<T>& row = *find_setting<T>(name, rows);
    return add_setting(command, row, value_of(T{}, row), given, other_names);
}

}  // namespace pliant::app
