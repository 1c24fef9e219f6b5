// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "small_file.h"

#include <filesystem>
#include <fstream>

namespace pliant::app {
namespace {

constexpr std::size_t kMaxBytes = std::size_t(16) << 20;

}  // namespace

Result<std::string> read_small_file(const std::string& file, const std::string& expected) {
    const auto wrong = [&](const std::string& what) {
        return Error{ErrorCode::Unreadable, file + ": " + what};
    };
    std::error_code ignored;
    if (std::filesystem::is_directory(file, ignored))
        return wrong("is a folder, expected " + expected);
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return Error{ErrorCode::NotFound, file + ": can't be opened"};
    std::string text;
    char piece[4096];
    while (stream.read(piece, sizeof(piece)), stream.gcount() > 0) {
        text.append(piece, std::size_t(stream.gcount()));
        if (text.size() > kMaxBytes)
            return wrong("expected " + expected + " of up to 16 MiB, found more");
    }
    return text;
}

}  // namespace pliant::app
