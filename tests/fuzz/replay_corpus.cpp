// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Runs a fuzz target on given files and folders, without libFuzzer: a regression test for earlier
// findings, with any compiler.

#include <algorithm>
#include <vector>

#include "fuzz/fuzz.h"

int main(int count, char** arguments) {
    std::vector<std::filesystem::path> files;
    for (int n = 1; n < count; ++n) {
        if (!std::filesystem::is_directory(arguments[n])) {
            files.emplace_back(arguments[n]);
            continue;
        }
        for (const auto& entry : std::filesystem::directory_iterator(arguments[n]))
            files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    for (const auto& file : files) {
        const std::string bytes = pliant::test::bytes_of(file);
        std::printf("%s: %zu bytes\n", file.filename().c_str(), bytes.size());
        std::fflush(stdout);
        LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    }
    std::printf("%zu inputs\n", files.size());
    return files.empty() ? 1 : 0;
}
