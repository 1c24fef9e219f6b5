// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Set-ups of results are fixed: a failure is a bug, and ends the program.

#pragma once

#include <pliant/result.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace pliant::results {

template <class T>
T value_of(Result<T> result) {
    if (!result.ok()) {
        std::fprintf(stderr, "results: %s\n", result.error().message.c_str());
        std::exit(1);
    }
    return std::move(result).value();
}
inline void must(const Status& status) {
    value_of(status);
}

}  // namespace pliant::results
