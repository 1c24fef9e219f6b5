// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string_view>

namespace pliant::app {

/// Whether an output's name means standard output; a summary must not be printed there too.
inline bool is_standard_output(std::string_view name) {
    return name == "-" || name == "/dev/stdout" || name == "/dev/fd/1" || name == "/proc/self/fd/1";
}

}  // namespace pliant::app
