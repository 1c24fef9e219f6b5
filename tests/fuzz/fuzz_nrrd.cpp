// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NRRD: header and data in one file, or a header that names the files of its data.

#include "fuzz/scan_input.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes = fuzz::text_of(data, size);
    const std::string_view header = bytes.substr(0, bytes.find("\n\n"));
    const bool detached =
        header.find("data file") != header.npos || header.find("datafile") != header.npos;
    const std::string name = detached ? "a.nhdr" : "a.nrrd";
    static const auto first = fuzz::folder().write("s1.raw", std::string(24, 1));
    static const auto second = fuzz::folder().write("s2.raw", std::string(24, 2));
    fuzz::read_scan_both_ways(fuzz::write_anew(name, bytes));
    std::filesystem::remove(fuzz::folder() / name);
    return 0;
}
