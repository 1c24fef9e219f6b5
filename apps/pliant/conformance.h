// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Published and closed-form results, and those of Pliant's models: the cases of `pliant
// conformance`.

#pragma once

#include <pliant/core/tasks.h>

#include <string>
#include <vector>

namespace pliant::app {

/// What a model gives on one mesh.
struct ConformanceResult {
    std::string model, mesh;
    double value = 0;
};

struct ConformanceCase {
    std::string name;      ///< of the problem
    std::string quantity;  ///< with its unit
    std::string source;    ///< key of docs/references.bib, or how the value is derived
    double expected = 0;
    double tolerance = 0;  ///< relative to the expected value; absolute if that is 0
    std::vector<ConformanceResult> results{};
};

/// Whether a result is within the case's tolerance.
bool conforms(const ConformanceCase& one, const ConformanceResult& result);

using ConformanceCases = std::vector<ConformanceCase>;

// Small displacements of 8-node hexahedra.
ConformanceCases patch_cases(const TaskArena& arena);
ConformanceCases beam_cases(const TaskArena& arena);
ConformanceCases membrane_cases(const TaskArena& arena);
ConformanceCases solid_cases(const TaskArena& arena);
ConformanceCases thermal_cases(const TaskArena& arena);
// Tissue on a scan's voxels.
ConformanceCases scan_cases(const TaskArena& arena);
// Models in real time.
ConformanceCases chainmail_cases(const TaskArena& arena);
ConformanceCases spring_cases(const TaskArena& arena);
ConformanceCases body_cases(const TaskArena& arena);
ConformanceCases rod_cases(const TaskArena& arena);
ConformanceCases rig_cases(const TaskArena& arena);

}  // namespace pliant::app
