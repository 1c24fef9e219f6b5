// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/text.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace pliant {
namespace {

template <class T>
std::optional<T> parsed(std::string_view text) {
    text = trimmed(text);
    if (text.starts_with('+')) text.remove_prefix(1);
    T number{};
    const char* const end = text.data() + text.size();
    const auto [next, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc{} || next != end || text.empty()) return std::nullopt;
    return number;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlank = " \t\r\n\v\f";
    const auto first = text.find_first_not_of(kBlank);
    if (first == text.npos) return {};
    return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::string lower_case(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return result;
}

std::optional<double> number_from(std::string_view text) {
    return parsed<double>(text);
}

std::optional<std::int64_t> whole_number_from(std::string_view text) {
    return parsed<std::int64_t>(text);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    const auto separates = [separator](char c) {
        return c == separator || (separator == ' ' && c == '\t');
    };
    std::vector<std::string_view> parts;
    for (std::size_t at = 0; at < text.size();) {
        std::size_t end = at;
        while (end < text.size() && !separates(text[end])) ++end;
        const std::string_view part = trimmed(text.substr(at, end - at));
        if (!part.empty()) parts.push_back(part);
        at = end + 1;
    }
    return parts;
}

std::optional<std::vector<double>> numbers_from(std::string_view text, char separator) {
    std::vector<double> numbers;
    for (const std::string_view part : split(text, separator)) {
        const auto number = number_from(part);
        if (!number) return std::nullopt;
        numbers.push_back(*number);
    }
    return numbers;
}

std::string text_of(double number) {
    if (std::isnan(number)) return "nan";  // for both signs
    char buffer[40];
    const auto result = std::to_chars(buffer, buffer + sizeof buffer, number);
    return {buffer, result.ptr};
}

std::string short_text(double number, int digits) {
    char buffer[40];
    const auto result =
        std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::general, digits);
    return {buffer, result.ptr};
}

std::string fixed_text(double number, int decimals) {
    char buffer[64];
    auto result =
        std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::fixed, decimals);
    if (result.ec != std::errc{})
        result = std::to_chars(buffer, buffer + sizeof buffer, number,
                               std::chars_format::scientific, decimals);
    return {buffer, result.ptr};
}

std::string text_of(Vec3i v) {
    return std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z);
}

std::string text_of(Vec3d v) {
    return text_of(v.x) + ", " + text_of(v.y) + ", " + text_of(v.z);
}

std::string short_text(Vec3d v) {
    return short_text(v.x) + ", " + short_text(v.y) + ", " + short_text(v.z);
}

std::string text_of_sizes(const std::vector<std::int64_t>& sizes) {
    std::string text;
    for (const std::int64_t size : sizes)
        text += (text.empty() ? "" : " × ") + std::to_string(size);
    return text;
}

std::string text_of_size(Vec3i size) {
    return text_of_sizes({size.x, size.y, size.z});
}

}  // namespace pliant
