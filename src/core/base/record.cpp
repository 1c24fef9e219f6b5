// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/files.h>
#include <pliant/core/record.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/errors.h"
#include "base/text.h"

namespace pliant {
namespace {

/// Choice with a number, from 0 on; empty: none.
std::string_view choice_at(std::string_view choices, std::int64_t number) {
    for (std::int64_t n = 0; !choices.empty(); ++n) {
        const std::string_view choice = choices.substr(0, choices.find('|'));
        if (n == number) return choice;
        choices.remove_prefix(std::min(choices.size(), choice.size() + 1));
    }
    return {};
}

/// Number of a choice; −1: none.
std::int64_t number_of_choice(std::string_view choices, std::string_view text) {
    for (std::int64_t n = 0;; ++n) {
        const std::string_view choice = choice_at(choices, n);
        if (choice.empty()) return -1;
        if (choice == text) return n;
    }
}

std::string list_of_choices(std::string_view choices) {
    std::string list;
    for (std::int64_t n = 0;; ++n) {
        const std::string_view choice = choice_at(choices, n);
        if (choice.empty()) return list;
        const bool is_last = choice_at(choices, n + 1).empty();
        list.append(n == 0 ? "\"" : is_last ? " or \"" : ", \"").append(choice).append("\"");
    }
}

/// Readable text of a bound: 0.0001, 100000, 1e9.
std::string bound_text(double bound) {
    char buffer[400];
    const auto fixed =
        std::to_chars(buffer, buffer + sizeof buffer, bound, std::chars_format::fixed);
    if (fixed.ptr - buffer <= 8) return {buffer, fixed.ptr};
    const auto scientific =
        std::to_chars(buffer, buffer + sizeof buffer, bound, std::chars_format::scientific);
    std::string text(buffer, scientific.ptr);
    const std::size_t digits = text.find('e') + 2;
    text.erase(digits, std::min(text.find_first_not_of('0', digits), text.size() - 1) - digits);
    if (text[digits - 1] == '+') text.erase(digits - 1, 1);
    return text;
}

/// Text of a value in messages.
std::string found_text(const SettingValue& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return "\"" + shown(*text) + "\"";
    const auto* numbers = std::get_if<std::vector<double>>(&value);
    if (numbers && numbers->size() == 1) return text_of(numbers->front());
    if (numbers)
        return numbers->size() <= 3 ? toml_text(value)
                                    : std::to_string(numbers->size()) + " numbers";
    if (const auto* points = std::get_if<std::vector<Vec3d>>(&value))
        return std::to_string(points->size()) + " points";
    if (const auto* pairs = std::get_if<std::vector<NumberPair>>(&value))
        return std::to_string(pairs->size()) + " pairs";
    if (const auto* texts = std::get_if<std::vector<std::string>>(&value))
        return texts->size() == 1 ? "[\"" + shown(texts->front()) + "\"]"
                                  : std::to_string(texts->size()) + " texts";
    return std::holds_alternative<std::monostate>(value) ? "something else" : toml_text(value);
}

std::string expected_kind(const SettingInfo& field) {
    switch (field.kind) {
        case SettingKind::Flag:
            return "true or false";
        case SettingKind::Whole:
            return "a whole number";
        case SettingKind::Number:
            return "a number";
        case SettingKind::Text:
            return field.choices.empty() ? "a text" : expected_of(field);
        case SettingKind::Choice:
            return expected_of(field);
        case SettingKind::Numbers:
            return field.count == 2 ? "two numbers" : "one number or three";
        case SettingKind::Wholes:
            return "a whole number, or a list of them";
        case SettingKind::Points:
            return "a list of points, three numbers each";
        case SettingKind::Pairs:
            return "a list of pairs of numbers";
        case SettingKind::Texts:
            return field.choices.empty() ? "a list of texts" : expected_of(field);
    }
    return {};
}

bool are_among(std::string_view choices, const std::vector<std::string>& texts) {
    return choices.empty() || std::all_of(texts.begin(), texts.end(), [&](const auto& text) {
               return number_of_choice(choices, text) >= 0;
           });
}

bool is_whole(double number) {
    return std::abs(number) <= 1e9 && number == std::floor(number);
}

bool is_in_range(const SettingInfo& field, double number) {
    return std::isfinite(number) &&
           (field.above_low ? number > field.range.low : number >= field.range.low) &&
           (field.below_high ? number < field.range.high : number <= field.range.high);
}

}  // namespace

std::string title_of(const SettingInfo& field) {
    std::string title(field.table);
    if (!title.empty()) title = "[" + title + "] ";
    return title.append(title.empty() ? field.name : field.key_in_file());
}

std::string expected_of(const SettingInfo& field) {
    if (!field.choices.empty())
        return (field.kind == SettingKind::Texts ? "a list of " : "") +
               list_of_choices(field.choices);
    const bool has_low = std::isfinite(field.range.low), has_high = std::isfinite(field.range.high);
    const std::string low = has_low ? bound_text(field.range.low) : "";
    const std::string high = has_high ? bound_text(field.range.high) : "";
    const std::string above = field.above_low ? "above " + low : low + " or more";
    const std::string below = field.below_high ? "below " + high : "up to " + high;
    std::string range;
    if (has_low && has_high && !field.above_low && !field.below_high)
        range = low + " to " + high;
    else if (has_low && has_high)
        range = above + ", " + below;
    else if (has_low)
        range = above;
    else if (has_high)
        range = below;
    else
        return expected_kind(field);
    if (!field.unit.empty()) range.append(" ").append(field.unit);
    return range;
}

std::string toml_text(const SettingValue& value) {
    struct {
        std::string operator()(std::monostate) const { return {}; }
        std::string operator()(bool flag) const { return flag ? "true" : "false"; }
        std::string operator()(std::int64_t number) const { return std::to_string(number); }
        std::string operator()(double number) const { return pliant::text_of(number); }
        std::string operator()(const std::string& text) const { return "\"" + text + "\""; }
        std::string operator()(const std::vector<double>& numbers) const {
            std::string list;
            for (const double number : numbers)
                list += (list.empty() ? "[" : ", ") + pliant::text_of(number);
            return list.empty() ? "[]" : list + "]";
        }
        std::string operator()(const std::vector<Vec3d>& points) const {
            std::string list;
            for (const Vec3d p : points)
                list += (list.empty() ? "[" : ", ") + (*this)(std::vector{p.x, p.y, p.z});
            return list.empty() ? "[]" : list + "]";
        }
        std::string operator()(const std::vector<NumberPair>& pairs) const {
            std::string list;
            for (const NumberPair& pair : pairs)
                list += (list.empty() ? "[" : ", ") + (*this)(std::vector{pair[0], pair[1]});
            return list.empty() ? "[]" : list + "]";
        }
        std::string operator()(const std::vector<std::string>& texts) const {
            std::string list;
            for (const std::string& text : texts)
                list += (list.empty() ? "[" : ", ") + (*this)(text);
            return list.empty() ? "[]" : list + "]";
        }
    } const text;
    return std::visit(text, value);
}

Result<SettingValue> value_of_kind(const SettingInfo& field, SettingValue value) {
    const auto wrong = [&] {
        return expected_error(title_of(field), expected_kind(field), found_text(value));
    };
    if (const auto* whole = std::get_if<std::int64_t>(&value);
        whole && field.kind != SettingKind::Whole)
        value = double(*whole);
    const auto* number = std::get_if<double>(&value);
    if (number && field.kind == SettingKind::Whole && is_whole(*number))
        return SettingValue(std::int64_t(*number));
    const bool is_list = field.kind == SettingKind::Wholes ||
                         (field.kind == SettingKind::Numbers && field.count == 3);
    if (number && is_list)
        value = std::vector<double>(std::size_t(std::max(1, field.count)), *number);
    const auto* list = std::get_if<std::vector<double>>(&value);
    const auto* text = std::get_if<std::string>(&value);
    bool fits = false;
    switch (field.kind) {
        case SettingKind::Flag:
            fits = std::holds_alternative<bool>(value);
            break;
        case SettingKind::Whole:
            fits = std::holds_alternative<std::int64_t>(value);
            break;
        case SettingKind::Number:
            fits = std::holds_alternative<double>(value);
            break;
        case SettingKind::Text:
            fits = text && (field.choices.empty() || number_of_choice(field.choices, *text) >= 0);
            break;
        case SettingKind::Numbers:
            fits = list && list->size() == std::size_t(field.count);
            break;
        case SettingKind::Points:
            if (list && list->empty()) value = std::vector<Vec3d>();
            fits = std::holds_alternative<std::vector<Vec3d>>(value);
            break;
        case SettingKind::Pairs:
            if (list && list->empty()) value = std::vector<NumberPair>();
            fits = std::holds_alternative<std::vector<NumberPair>>(value);
            break;
        case SettingKind::Texts: {
            if (list && list->empty()) value = std::vector<std::string>();
            const auto* texts = std::get_if<std::vector<std::string>>(&value);
            fits = texts && are_among(field.choices, *texts);
            break;
        }
        case SettingKind::Wholes:
            fits = list && !list->empty();
            for (std::size_t n = 0; fits && n < list->size(); ++n) fits = is_whole((*list)[n]);
            break;
        case SettingKind::Choice: {
            const std::int64_t choice = text ? number_of_choice(field.choices, *text) : -1;
            if (choice < 0) return wrong();
            return SettingValue(choice);
        }
    }
    if (!fits) return wrong();
    return value;
}

Status check_range(const SettingInfo& field, const SettingValue& value) {
    bool fits = true;
    if (const auto* whole = std::get_if<std::int64_t>(&value))
        fits = field.kind == SettingKind::Choice || is_in_range(field, double(*whole));
    else if (const auto* number = std::get_if<double>(&value))
        fits = is_in_range(field, *number);
    else if (const auto* numbers = std::get_if<std::vector<double>>(&value))
        for (const double n : *numbers) fits = fits && is_in_range(field, n);
    else if (const auto* points = std::get_if<std::vector<Vec3d>>(&value))
        for (const Vec3d p : *points)
            for (int a = 0; a < 3; ++a) fits = fits && is_in_range(field, p[a]);
    else if (const auto* pairs = std::get_if<std::vector<NumberPair>>(&value))
        for (const NumberPair& pair : *pairs)
            for (const double n : pair) fits = fits && is_in_range(field, n);
    else if (const auto* texts = std::get_if<std::vector<std::string>>(&value))
        fits = are_among(field.choices, *texts);
    else if (const auto* text = std::get_if<std::string>(&value))
        fits = field.choices.empty() || number_of_choice(field.choices, *text) >= 0;
    if (fits) return Ok{};
    return expected_error(title_of(field), expected_of(field), found_text(value));
}

Result<SettingValue> checked_value(const SettingInfo& field, SettingValue value) {
    Result<SettingValue> converted = value_of_kind(field, std::move(value));
    if (!converted) return converted.error();
    if (const Status s = check_range(field, *converted); !s) return s.error();
    return converted;
}

SettingValue shown_value(const SettingInfo& field, SettingValue stored) {
    if (field.kind != SettingKind::Choice) return stored;
    if (const auto* number = std::get_if<std::int64_t>(&stored))
        return std::string(choice_at(field.choices, *number));
    if (const auto* flag = std::get_if<bool>(&stored))
        return std::string(choice_at(field.choices, *flag ? 1 : 0));
    return stored;
}

Error unknown_setting(std::string_view name, const std::string& names) {
    return expected_error(shown(name), "one of " + names, "a name that has no meaning here");
}

}  // namespace pliant
