// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Common part of all fuzz targets. A target passes arbitrary bytes to one reader and checks
// invariants of the result; it ends the process on a violation. docs/developers/robustness.md lists
// the targets and how long each has run.

#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include "support/temporary_folder.h"

namespace pliant::fuzz {

inline void expect(bool holds, const char* what, const std::string& found = {}) {
    if (holds) return;
    std::fprintf(stderr, "expected: %s; found: %s\n", what, found.c_str());
    std::abort();
}

/// An error is one line, and says something.
inline void expect_one_line(const std::string& message) {
    expect(!message.empty(), "a message", message);
    expect(message.find('\n') == std::string::npos, "one line", message);
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
    return {reinterpret_cast<const char*>(data), size};
}

/// A folder for the whole run.
inline const test::TemporaryFolder& folder() {
    static const test::TemporaryFolder kept;
    return kept;
}

/// A new file each time: the one before may still be mapped.
inline std::filesystem::path write_anew(const std::string& name, std::string_view bytes) {
    std::filesystem::remove(folder() / name);
    return folder().write(name, bytes);
}

}  // namespace pliant::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
