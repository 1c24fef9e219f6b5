// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "published.h"

#include <charconv>
#include <cmath>
#include <utility>

namespace pliant::results {
namespace {

std::string short_number(double value, int digits) {
    char text[40];
    const auto end =
        std::to_chars(text, text + sizeof(text), value, std::chars_format::general, digits);
    return {text, end.ptr};
}

}  // namespace

bool holds(const Case& c) {
    const double most = c.is_share ? c.tolerance * std::abs(c.expected) : c.tolerance;
    if (c.is_at_most && c.measured <= c.expected) return true;
    return std::abs(c.measured - c.expected) <= most;  // false for NaN
}

std::vector<std::string> row_of(const Case& c) {
    const std::string most =
        c.is_share ? short_number(100 * c.tolerance, 3) + " %" : short_number(c.tolerance, 3);
    return {std::to_string(c.number),     c.what,
            short_number(c.expected, 6),  short_number(c.measured, 6),
            c.tolerance == 0 ? "" : most, holds(c) ? "yes" : "**no**"};
}

Case within_share(int number, std::string what, double expected, double measured, double share) {
    return {number, std::move(what), expected, measured, share, true, false};
}
Case within(int number, std::string what, double expected, double measured, double difference) {
    return {number, std::move(what), expected, measured, difference, false, false};
}
Case at_most(int number, std::string what, double measured, double most) {
    return {number, std::move(what), 0, measured, most, false, false};
}

}  // namespace pliant::results
