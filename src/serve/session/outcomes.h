// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Conversions of results to outcomes of commands.

#pragma once

#include <pliant/chainmail.h>

#include <new>
#include <string>
#include <utility>

#include "base/errors.h"
#include "session/scene.h"

namespace pliant::serve {

/// Outcome of a failed command. Throws std::bad_alloc for lack of memory: that isn't the command's
/// outcome, which a replay must find again.
inline Outcome refused(const Error& error) {
    if (is_out_of_memory(error)) throw std::bad_alloc();
    const char* code = error.code == ErrorCode::LimitExceeded ? "limit"
                       : error.code == ErrorCode::NotFound    ? "nothing"
                                                              : "out_of_range";
    return {.error_code = code, .message = error.message};
}

/// Doesn't allocate.
inline Outcome outcome_of(PushReport&& report) {
    return {.message = std::move(report.message),
            .status = report.status,
            .limited_by = report.limited_by,
            .step_fraction = report.step_fraction,
            .grabbed_elements = report.grabbed_elements,
            .moved_elements = report.moved_elements,
            .bone_mm = report.bone_mm,
            .solve_ms = report.solve_ms};
}

/// Outcome of a command for another tissue. @param what  name of the command
inline Outcome not_with(const TissueChoice& choice, const char* what, const char* expected) {
    return {.error_code = "other_tissue",
            .message = std::string(what) + ": expected the tissue " + expected + ", found " +
                       choice.model};
}

}  // namespace pliant::serve
