// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "output_text.h"

#include <pliant/core/output_file.h>

#include <cstdio>

namespace pliant::app {

std::string hex_of(std::uint64_t hash) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

Status write_text(const std::filesystem::path& path, const std::string& text) {
    OutputFile file(path, path.filename().string());
    file.write(text);
    return file.close();
}

}  // namespace pliant::app
