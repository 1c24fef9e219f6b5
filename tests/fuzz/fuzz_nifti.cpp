// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NIfTI, also packed with gzip.

#include "fuzz/scan_input.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes = fuzz::text_of(data, size);
    const std::string name = bytes.starts_with("\x1f\x8b") ? "a.nii.gz" : "a.nii";
    fuzz::read_scan_both_ways(fuzz::write_anew(name, bytes));
    std::filesystem::remove(fuzz::folder() / name);
    return 0;
}
