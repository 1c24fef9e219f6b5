// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A folder with one good slice and one from the input; then the input's pixels alone, for every
// size, so that codestreams reach the decoder.

#include "formats/dicom_pixels.h"
#include "fuzz/scan_input.h"
#include "support/scan_files.h"

using namespace pliant;

namespace {

void decode(const std::filesystem::path& path) {
    constexpr std::int64_t kMaxPixels = 1 << 20;
    const auto slices = read_dicom_slices(path);
    if (!slices || slices->empty()) return;
    const DicomSlice& slice = slices->front();
    if (slice.fault) return fuzz::expect_one_line(slice.fault->message);
    const std::int64_t pixels = std::int64_t(slice.rows) * slice.columns;
    if (pixels > kMaxPixels) return;
    VoxelBuilder voxels{std::size_t(pixels)};
    DicomPixelReader reader({slice});
    const Status status = reader.read(slice, voxels);
    if (!status) fuzz::expect_one_line(status.error().message);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const auto first = fuzz::folder().write("series/1.dcm", test::DicomFile().bytes());
    const auto second = fuzz::write_anew("series/2.dcm", fuzz::text_of(data, size));
    fuzz::read_scan(fuzz::folder() / "series");
    fuzz::read_scan_both_ways(second);
    decode(second);
    return 0;
}
