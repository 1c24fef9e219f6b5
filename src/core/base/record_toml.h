// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings in TOML: reading a file as tables of named values, and writing a struct.

#pragma once

#include <pliant/core/record.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Values of [name], or of one of several [[name]].
struct TomlTable {
    std::string name;
    int number = 0;  ///< index of [[name]], from 1 on; 0: [name]
    Record values;   ///< in the order of the file's keys
};

/// "[material]", or "[[label]] 2".
std::string title_of(const TomlTable& table);

/// Parses a text to tables. Throws std::bad_alloc if memory is short.
/// @returns Unreadable or InvalidArgument, without the name of the file
Result<std::vector<TomlTable>> parse_toml(const std::string& text);

/// Parses the output of toml_text; empty for other text. Unlike parse_toml's parser, which ends the
/// process, it throws std::bad_alloc if memory is short.
std::vector<TomlTable> parse_plain_toml(std::string_view text);

/// Copy of a value, made before it enters the variant. As GCC 12 compiles the variant's own copy
/// constructor here, memory that runs out in it ends the process.
SettingValue copy_of(const SettingValue& value);

/// Adds the table's title to an error about a key.
Error in_table(const TomlTable& table, std::string_view key, const Error& error);

/// Keys of all rows: "law, offset", with their tables if there are several.
template <class T>
std::string keys_of(SettingRows<T> rows) {
    const bool has_tables = rows.front().table != rows.back().table;
    std::string keys;
    std::string_view table;
    for (const Setting<T>& field : rows) {
        const bool is_new = has_tables && field.table != table;
        if (!keys.empty()) keys += is_new ? "; " : ", ";
        if (is_new) keys.append("[").append(table = field.table).append("] ");
        keys.append(field.key_in_file());
    }
    return keys;
}

/// Allowed keys of a table, from the rows of all structs that it sets.
template <class... T>
std::string keys_in_table(std::string_view table, SettingRows<T>... rows) {
    std::string keys;
    const auto add = [&](const SettingInfo& row) {
        if (row.table == table) keys.append(keys.empty() ? "" : ", ").append(row.key_in_file());
    };
    (std::for_each(rows.begin(), rows.end(), add), ...);
    return keys;
}

/// Sets the values of a table.
/// @returns InvalidArgument that names table and key
template <class T>
Status read_table(const TomlTable& table, std::type_identity_t<SettingRows<T>> rows, T& object) {
    for (const NamedValue& named : table.values) {
        Status set = Ok{};
        bool is_known = false;
        for (const Setting<T>& field : rows) {
            if (field.table != table.name || field.key_in_file() != named.name) continue;
            is_known = true;
            set = assign(object, field, copy_of(named.value));
        }
        if (!is_known) set = unknown_setting(named.name, keys_of<T>(rows));
        if (!set) return in_table(table, named.name, set.error());
    }
    return Ok{};
}

/// Text of a file with all settings, in the order of the rows. read_table restores it bit for bit.
template <class T>
std::string toml_text(const T& object, SettingRows<T> rows) {
    std::string text;
    std::string_view table;
    for (const Setting<T>& field : rows) {
        const SettingValue value = value_of(object, field);
        if (std::holds_alternative<std::monostate>(value)) continue;
        if (field.table != table) text.append("[").append(table = field.table).append("]\n");
        text.append(field.key_in_file()).append(" = ").append(toml_text(value)).append("\n");
    }
    return text;
}

}  // namespace pliant
#pragma GCC visibility pop
