// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Errors of displacements beside those of finite elements.

#pragma once

#include <cstddef>
#include <vector>

#include "loads.h"

namespace pliant::results {

/// [% of the push]
struct Errors {
    double mean = 0, p95 = 0;  ///< over the free nodes that the elements move by more than 1 %
    double whole = 0;          ///< mean over all free nodes of the body
    double l2 = 0;             ///< ‖error‖ / ‖displacement‖ over all free nodes [%]
};

/// Free: neither held nor of the tool.
Errors errors_of(const Displacements& found, const Displacements& reference, const Body& body,
                 const Load& load);

/// Means over loads, and the largest mean.
struct ErrorsOfLoads {
    std::vector<Errors> all;

    void add(const Errors& errors) { all.push_back(errors); }
    Errors mean() const;
    double worst_mean() const;
};

/// Displacements of the tool's nodes only.
Displacements of_tool_alone(const Body& body, const Load& load);

/// Chain with the offset whose mean error is least, of 12 between 0.02 and 0.8.
Errors best_offset(const ChainBody& chain, const Displacements& reference, const Body& body,
                   const Load& load, double* offset = nullptr);

}  // namespace pliant::results
