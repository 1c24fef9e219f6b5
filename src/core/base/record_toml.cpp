// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The only user of toml++.

#include "base/record_toml.h"

#include <pliant/core/files.h>
#include <toml++/toml.h>

#include <charconv>
#include <new>
#include <optional>
#include <sstream>
#include <utility>

#include "base/errors.h"

namespace pliant {
namespace {

/// toml::parse ends the process if memory runs out. This test allocation makes that improbable,
/// except for concurrent threads and very unusual files. toml++ uses up to seventy bytes per byte
/// of text. Throws std::bad_alloc.
void get_memory_for_tables(std::size_t bytes) {
    constexpr std::size_t kPerByte = 100, kAtLeast = std::size_t(1) << 20;
    ::operator delete(::operator new(kAtLeast + kPerByte * bytes));
}

/// Reads an array of two or three numbers; false for other nodes.
bool read_numbers(const toml::node& node, std::vector<NumberPair>& pairs,
                  std::vector<Vec3d>& points) {
    const toml::array* array = node.as_array();
    if (!array || (array->size() != 2 && array->size() != 3)) return false;
    Vec3d read{};
    for (int a = 0; a < int(array->size()); ++a) {
        const toml::node& number = *array->get(std::size_t(a));
        if (!number.is_number()) return false;
        read[a] = number.value_or(0.0);
    }
    if (array->size() == 2)
        pairs.push_back({read.x, read.y});
    else
        points.push_back(read);
    return true;
}

/// Converts numbers, pairs, points or texts; monostate for other arrays.
SettingValue list_of(const toml::array& array) {
    std::vector<double> numbers;
    std::vector<NumberPair> pairs;
    std::vector<Vec3d> points;
    std::vector<std::string> texts;
    for (const toml::node& node : array) {
        if (node.is_number())
            numbers.push_back(node.value_or(0.0));
        else if (node.is_string())
            texts.push_back(node.value_or(std::string()));
        else if (!read_numbers(node, pairs, points))
            return {};
    }
    if (numbers.size() == array.size()) return numbers;
    if (pairs.size() == array.size()) return pairs;
    if (points.size() == array.size()) return points;
    if (texts.size() == array.size()) return texts;
    return {};
}

SettingValue value_of(const toml::node& node) {
    if (node.is_boolean()) return node.value_or(false);
    if (const auto whole = node.value_exact<std::int64_t>()) return *whole;
    if (const auto number = node.value_exact<double>()) return *number;
    if (const auto text = node.value_exact<std::string>()) return *text;
    if (const toml::array* array = node.as_array()) return list_of(*array);
    return {};
}

TomlTable table_of(std::string_view name, int number, const toml::table& table) {
    TomlTable read{std::string(name), number, {}};
    for (const auto& [key, node] : table)
        read.values.emplace_back(std::string(key.str()), value_of(node));
    return read;
}

/// Parses numbers in brackets, separated by commas and blanks; nullopt for other text.
std::optional<SettingValue> plain_numbers(std::string_view text) {
    if (text.size() < 2 || text.front() != '[' || text.back() != ']') return std::nullopt;
    text = text.substr(1, text.size() - 2);
    std::vector<double> numbers;
    while (!text.empty()) {
        double number = 0;
        const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
        if (read.ec != std::errc{}) return std::nullopt;
        numbers.push_back(number);
        text.remove_prefix(std::size_t(read.ptr - text.data()));
        if (text.starts_with(", "))
            text.remove_prefix(2);
        else if (!text.empty())
            return std::nullopt;
    }
    return SettingValue(std::move(numbers));
}

/// Parses a number, true, false, a quoted text, or a list of numbers; nullopt for other text.
std::optional<SettingValue> plain_value(std::string_view text) {
    if (auto numbers = plain_numbers(text)) return numbers;
    const char *begin = text.data(), *end = begin + text.size();
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"' &&
        text.find_first_of("\"\\", 1) == text.size() - 1)
        return SettingValue(std::string(text.substr(1, text.size() - 2)));
    if (text == "true" || text == "false") return SettingValue(text == "true");
    std::int64_t whole = 0;
    if (const auto read = std::from_chars(begin, end, whole); read.ptr == end && begin != end)
        return SettingValue(whole);
    double number = 0;
    if (const auto read = std::from_chars(begin, end, number); read.ptr == end && begin != end)
        return SettingValue(number);
    return std::nullopt;
}

}  // namespace

std::string title_of(const TomlTable& table) {
    const std::string name = shown(table.name);
    if (table.number == 0) return "[" + name + "]";
    return "[[" + name + "]] " + std::to_string(table.number);
}

SettingValue copy_of(const SettingValue& value) {
    return std::visit(
        [](const auto& held) -> SettingValue {
            auto copy = held;
            return SettingValue(std::move(copy));
        },
        value);
}

Error in_table(const TomlTable& table, std::string_view key, const Error& error) {
    return expected_error(title_of(table) + " " + shown(key), error.expected, error.found,
                          error.code);
}

Result<std::vector<TomlTable>> parse_toml(const std::string& text) {
    if (const Status s = check_nesting(text, TextSyntax::Toml); !s) return s.error();
    toml::table root;
    try {
        get_memory_for_tables(text.size());
        root = toml::parse(text);
    } catch (const toml::parse_error& error) {
        std::ostringstream where;
        where << "line " << error.source().begin.line << ": expected TOML, " << error.description();
        return Error{ErrorCode::Unreadable, where.str()};
    }
    std::vector<TomlTable> tables;
    for (const auto& [key, node] : root) {
        if (const toml::table* table = node.as_table()) {
            tables.push_back(table_of(key.str(), 0, *table));
        } else if (node.is_array_of_tables()) {
            int number = 0;
            for (const toml::node& element : *node.as_array())
                tables.push_back(table_of(key.str(), ++number, *element.as_table()));
        } else {
            std::ostringstream found;
            found << node.type();
            return expected_error(shown(key.str()), "a table, [" + shown(key.str()) + "]",
                                  found.str());
        }
    }
    return tables;
}

std::vector<TomlTable> parse_plain_toml(std::string_view text) {
    std::vector<TomlTable> tables;
    while (!text.empty()) {
        const std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(text.size(), line.size() + 1));
        if (line.empty()) continue;
        if (line.size() > 2 && line.front() == '[' && line.back() == ']') {
            tables.push_back({std::string(line.substr(1, line.size() - 2)), 0, {}});
            continue;
        }
        const std::size_t equals = line.find(" = ");
        if (equals == std::string_view::npos || tables.empty()) return {};
        auto value = plain_value(line.substr(equals + 3));
        if (!value) return {};
        tables.back().values.emplace_back(std::string(line.substr(0, equals)), std::move(*value));
    }
    return tables;
}

}  // namespace pliant
