// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Errors and times of all models over the loads of one body.

#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "errors.h"

namespace pliant::results {

inline constexpr int kSweeps = 40;          ///< of relaxation after a push
inline constexpr double kConverged = 1e-6;  ///< relative residual of the reference
inline constexpr double kDefaultOffset = 0.2;
inline constexpr std::array kStopped = {0.3, 0.1, 0.03, 0.01, 1e-3};  ///< residuals

struct Timed {
    ErrorsOfLoads errors;
    double ms = 0;  ///< sum over the loads
    double mean_ms() const { return ms / double(errors.all.size()); }
};

struct Study {
    std::string name;
    ErrorsOfLoads still;                          ///< the tool alone moves
    Timed by_default, default_relaxed;            ///< offset 0.2; then 40 sweeps
    ErrorsOfLoads best;                           ///< the best offset of each load, in hindsight
    Timed scan_frame, scan_settled;               ///< the elastic scan
    double scan_create_ms = 0;                    ///< mean
    std::array<Timed, kStopped.size()> stopped;   ///< finite elements, every fifth load
    double prepare_fem_ms = 0, fem_ms = 0;        ///< means
    double iterations = 0, default_fraction = 0;  ///< means
};

/// @param load_of  sets the body's held nodes, and returns the load of a number
Study study_of(Body& body, int loads, const std::function<Load(Body&, int)>& load_of,
               const TaskArena& arena);

}  // namespace pliant::results
