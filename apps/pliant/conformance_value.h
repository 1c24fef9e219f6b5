// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Errors of the models in the cases of `pliant conformance`: the command ends with their message.

#pragma once

#include <pliant/result.h>

#include <string>
#include <utility>

namespace pliant::app {

struct ConformanceFailure {
    std::string message;
};

/// Value of a result, or of a status, that must be there. @throws ConformanceFailure
template <class T>
T computed(Result<T> result) {
    if (!result.ok()) throw ConformanceFailure{result.error().message};
    return std::move(result).value();
}

}  // namespace pliant::app
