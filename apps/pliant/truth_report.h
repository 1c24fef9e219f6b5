// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The results of `pliant truth score` as CSV, JSON, Markdown and a page. The same scores give the
// same bytes.

#pragma once

#include <pliant/data/truth.h>

#include <string>
#include <utility>
#include <vector>

#include "truth_files.h"

namespace pliant::app {

struct TruthMethod {
    std::string name;
    std::vector<TruthScore> scores;  ///< one for each case
};

struct TruthTable {
    const TruthIndex& index;
    std::vector<TruthMethod> methods;  ///< the first one: no registration
};

/// Over the cases that have points in a row: mean of the means, medians and 95th percentiles, and
/// the largest maximum. Its count is the sum.
TruthErrors errors_over_cases(const TruthMethod& method, TruthRow row);
/// Mean over the cases; none for points.
std::optional<double> folded_share(const TruthMethod& method);

std::string truth_csv(const TruthTable& table);
std::string truth_json(const TruthTable& table);
std::string truth_markdown(const TruthTable& table);
std::string truth_page(const TruthTable& table);

}  // namespace pliant::app
