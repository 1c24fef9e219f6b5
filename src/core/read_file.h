// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small files that are read as a whole: folders and files without an end are refused.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/errors.h"

namespace pliant {

/// @param expected  the kind of file, for errors: "a settings file"
/// @returns NotFound; Unreadable for a folder, or for a file of more than max_bytes
inline Result<std::string> read_small_file(const std::filesystem::path& path, std::size_t max_bytes,
                                           const std::string& expected) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        return unreadable(path, "is a folder, expected " + expected);
    std::ifstream stream(path, std::ios::binary);
    if (!stream)
        return Error{ErrorCode::NotFound,
                     path.string() + ": expected " + expected + " that can be read"};
    std::string text;
    char piece[4096];
    while (stream.read(piece, sizeof(piece)), stream.gcount() > 0) {
        text.append(piece, std::size_t(stream.gcount()));
        if (text.size() > max_bytes)
            return unreadable(path, "expected " + expected + " of up to " +
                                        std::to_string(max_bytes >> 20) + " MiB, found more");
    }
    return text;
}

}  // namespace pliant
