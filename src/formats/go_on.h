// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/volume.h>

namespace pliant {

/// Polls for cancellation between two pieces of a scan, and reports progress.
/// @param fraction  0…1
inline Status go_on(const std::filesystem::path& path, const ReadOptions& options,
                    double fraction) {
    if (options.give_up && options.give_up())
        return Error{ErrorCode::LimitExceeded, path.string() + ": the reading was given up"};
    if (options.progress) options.progress(fraction);
    return Ok{};
}

}  // namespace pliant
