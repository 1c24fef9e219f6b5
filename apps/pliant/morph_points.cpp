// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "morph_points.h"

#include <pliant/core/files.h>
#include <pliant/core/text.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace pliant::app {
namespace {

constexpr std::size_t kMaxBytes = std::size_t(256) << 20;
constexpr const char* kAxes[] = {"x", "y", "z"};
constexpr int kDecimals = 4;  ///< of predicted millimetres

std::string column_name(const char* phase, int axis) {
    return std::string(phase) + "_" + kAxes[axis] + "_mm";
}

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == text.npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string> fields_of(std::string_view line) {
    std::vector<std::string> fields;
    for (;;) {
        const auto comma = line.find(',');
        fields.emplace_back(trimmed(line.substr(0, comma)));
        if (comma == line.npos) return fields;
        line.remove_prefix(comma + 1);
    }
}

std::string unquoted(const std::string& name) {
    const bool is_quoted = name.size() > 1 && name.front() == '"' && name.back() == '"';
    return is_quoted ? name.substr(1, name.size() - 2) : name;
}

std::optional<std::size_t> column_of(const PointTable& table, const std::string& name) {
    const auto at = std::find_if(table.names.begin(), table.names.end(),
                                 [&](const std::string& n) { return unquoted(n) == name; });
    if (at == table.names.end()) return {};
    return std::size_t(at - table.names.begin());
}

std::optional<double> number_in(std::string_view text) {
    if (text.starts_with('+')) text.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(number))
        return {};
    return number;
}

Error wrong(const std::filesystem::path& path, const std::string& text) {
    return {ErrorCode::Unreadable, path.string() + ": " + text};
}

}  // namespace

Result<PointTable> read_point_table(const std::filesystem::path& path, bool with_to) {
    const auto text = read_small_file(path, kMaxBytes, "a table of points");
    if (!text.ok()) return text.error();
    PointTable table;
    std::vector<std::size_t> columns;
    std::string_view rest = *text;
    if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
    for (int number = 1; !rest.empty(); ++number) {
        const auto end = rest.find('\n');
        const std::string_view line = trimmed(rest.substr(0, end));
        rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
        if (line.empty()) continue;
        std::vector<std::string> fields = fields_of(line);
        if (table.names.empty()) {
            table.names = std::move(fields);
            for (const char* phase : {"from", "to"})
                for (int a = 0; a < 3; ++a) {
                    if (phase[0] == 't' && !with_to) continue;
                    const std::string name = column_name(phase, a);
                    const auto column = column_of(table, name);
                    if (!column)
                        return wrong(path, "line " + std::to_string(number) +
                                               ": expected a column " + name + ", found " +
                                               shown(line));
                    columns.push_back(*column);
                }
            continue;
        }
        if (fields.size() != table.names.size())
            return wrong(path, "line " + std::to_string(number) + ": expected " +
                                   std::to_string(table.names.size()) + " fields, found " +
                                   shown(line));
        Vec3d points[2] = {};
        for (std::size_t n = 0; n < columns.size(); ++n) {
            const auto value = number_in(unquoted(fields[columns[n]]));
            if (!value)
                return wrong(path, "line " + std::to_string(number) + ", " +
                                       unquoted(table.names[columns[n]]) +
                                       ": expected a number, found '" + shown(fields[columns[n]]) +
                                       "'");
            points[n / 3][int(n % 3)] = *value;
        }
        table.rows.push_back(std::move(fields));
        table.from_mm.push_back(points[0]);
        if (with_to) table.to_mm.push_back(points[1]);
    }
    if (table.names.empty())
        return wrong(path, "expected a first line with the columns' names, found an empty file");
    if (table.rows.empty()) return wrong(path, "expected a point or more, found none");
    return table;
}

std::string predicted_text(const PointTable& table, std::span<const Vec3d> to_mm) {
    PointTable predicted = table;
    for (int a = 0; a < 3; ++a) {
        const std::string name = column_name("to", a);
        auto column = column_of(predicted, name);
        if (!column) {
            column = predicted.names.size();
            predicted.names.push_back(name);
            for (auto& row : predicted.rows) row.emplace_back();
        }
        for (std::size_t n = 0; n < to_mm.size(); ++n)
            predicted.rows[n][*column] = fixed_text(to_mm[n][a], kDecimals);
    }
    std::string text;
    const auto add = [&](const std::vector<std::string>& fields) {
        for (std::size_t n = 0; n < fields.size(); ++n) text += (n ? "," : "") + fields[n];
        text += '\n';
    };
    add(predicted.names);
    for (const auto& row : predicted.rows) add(row);
    return text;
}

}  // namespace pliant::app
