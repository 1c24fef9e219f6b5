// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The parts of the page, in its order.

#pragma once

#include <pliant/tasks.h>

#include <cstdio>
#include <cstdlib>

#include "page.h"

namespace pliant::results {

/// A vessel under pressure, with and without volume conservation.
void add_pressure(Page& page, const TaskArena& arena);
/// A vessel whose wall is pushed, with and without locality.
void add_push(Page& page, const TaskArena& arena);
/// The cantilever of case 5, on several grids.
void add_cantilever(Page& page, const TaskArena& arena);

/// Set-ups are fixed: what fails here is a defect, and ends the program.
template <class T>
T value_of(Result<T> result) {
    if (!result.ok()) {
        std::fprintf(stderr, "results: %s\n", result.error().message.c_str());
        std::exit(1);
    }
    return std::move(result).value();
}
inline void must(const Status& status) {
    if (!status.ok()) value_of(Result<Ok>(status.error()));
}

}  // namespace pliant::results
