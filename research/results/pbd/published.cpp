// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "published.h"

#include <pliant/core/text.h>

#include <cmath>
#include <utility>

namespace pliant::results {

bool holds(const Case& c) {
    const double most = c.is_share ? c.tolerance * std::abs(c.expected) : c.tolerance;
    if (c.is_at_most && c.measured <= c.expected) return true;
    return std::abs(c.measured - c.expected) <= most;  // false for NaN
}

std::vector<std::string> row_of(const Case& c) {
    const std::string most =
        c.is_share ? short_text(100 * c.tolerance, 3) + " %" : short_text(c.tolerance, 3);
    return {std::to_string(c.number),     c.what,
            short_text(c.expected, 6),    short_text(c.measured, 6),
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
