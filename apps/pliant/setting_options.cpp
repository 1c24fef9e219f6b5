// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "setting_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

namespace pliant::app {

std::string option_of(std::string_view name) {
    std::string option = "--" + std::string(name);
    std::replace(option.begin(), option.end(), '_', '-');
    return option;
}

Error named_by_option(Error error) {
    const bool is_name = std::all_of(error.field.begin(), error.field.end(),
                                     [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
    return is_name ? renamed(error, option_of(error.field)) : error;
}

CLI::Option* add_setting(CLI::App* command, const SettingInfo& row, const SettingValue& missing,
                         Record& given, const std::string& other_names) {
    std::string text(row.text);
    if (!row.unit.empty()) text.append(" [").append(row.unit).append("]");
    text += " (default " + toml_text(missing) + ")";
    const std::string name(row.name);
    const auto add = [&](auto type) {
        using Value = decltype(type);
        return command->add_option_function<Value>(
            option_of(name) + other_names,
            [&given, name](const Value& value) { given.emplace_back(name, SettingValue(value)); },
            text);
    };
    if (row.kind == SettingKind::Whole) return add(std::int64_t());
    if (row.kind == SettingKind::Number) return add(double());
    return add(std::string());
}

}  // namespace pliant::app
