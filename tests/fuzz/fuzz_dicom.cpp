// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A folder with one good slice, and one that is the input.

#include "fuzz/scan_input.h"
#include "support/scan_files.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const auto first = fuzz::folder().write("series/1.dcm", test::DicomFile().bytes());
    fuzz::write_anew("series/2.dcm", fuzz::text_of(data, size));
    fuzz::read_scan(fuzz::folder() / "series");
    fuzz::read_scan(fuzz::folder() / "series/2.dcm");
    return 0;
}
