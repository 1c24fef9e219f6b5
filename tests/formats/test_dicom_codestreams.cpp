// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Codestreams that don't have the size of the DICOM header are refused before a decoder sees them.
// Covers: formats/dicom_header.cpp, formats/dicom_pixels.cpp.

#include "formats/dicom_pixels.h"
#include "support/compressed_dicom.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

/// The error of a series of two such slices.
std::string error_of(DicomFile slice) {
    const TemporaryFolder folder;
    folder.write("a.dcm", slice.bytes());
    slice.position[2] = 1;
    folder.write("b.dcm", slice.bytes());
    testing::internal::CaptureStderr();
    const auto volume = read_volume(folder.path());
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    if (volume.ok()) return "was read";
    const std::string& message = volume.error().message;
    EXPECT_EQ(message.find('\n'), message.npos) << message;
    EXPECT_TRUE(message.starts_with((folder.path() / "a.dcm").string())) << message;
    return message;
}

void expect_refused(const DicomFile& slice, const std::string& expected) {
    const std::string message = error_of(slice);
    EXPECT_NE(message.find(expected), message.npos) << message << "\nexpected: " << expected;
}

TEST(DicomCodestreams, OtherSizesThanTheHeadersAreRefused) {
    for (const Codec& codec : kCodecs) {
        SCOPED_TRACE(codec.name);
        const bool rle = std::string(codec.name) == "rle";
        const std::vector<std::pair<int, int>> sizes = {{4, 12},  {9, 12},  {11, 12},
                                                        {10, 11}, {10, 13}, {10000, 10000}};
        for (const auto& [rows, columns] : sizes) {
            DicomFile slice = compressed(codec);
            slice.rows = std::uint16_t(rows);
            slice.columns = std::uint16_t(columns);
            expect_refused(slice,
                           rle ? "run lengths that don't make" : "compressed pixels for 12 ×");
        }
    }
}

TEST(DicomCodestreams, MoreBitsThanAreAllocatedAreRefused) {
    for (const Codec& codec : kCodecs) {
        if (codec.kind == std::string("u8")) continue;
        DicomFile slice = compressed(codec);
        slice.bits_allocated = slice.bits_stored = 8;
        slice.high_bit = 7;
        expect_refused(slice, codec.name == std::string("rle") ? "2 segments of run lengths"
                                                               : "bits), expected 12 × 10");
    }
}

TEST(DicomCodestreams, ThoseThatEndBeforeTheirSizeAreRefused) {
    for (const Codec& codec : kCodecs)
        for (const std::size_t bytes : {2, 4, 6, 12, 20}) {
            DicomFile slice = compressed(codec);
            slice.fragments[0].resize(bytes);
            const std::string message = error_of(slice);
            EXPECT_NE(message, "was read") << codec.name << ' ' << bytes;
        }
    DicomFile empty = compressed(kCodecs[0]);
    empty.fragments = {""};
    expect_refused(empty, "has no pixels");
}

TEST(DicomCodestreams, FewBytesDontMakeManyPixels) {
    const auto grown = [](const Codec& codec, std::size_t rows_at) {
        DicomFile slice = compressed(codec);
        slice.rows = slice.columns = 20000;
        std::string& bytes = slice.fragments[0];
        for (const std::size_t at : {rows_at, rows_at + 2}) {
            bytes[at] = char(20000 >> 8);
            bytes[at + 1] = char(20000 & 0xff);
        }
        return slice;
    };
    for (const Codec& codec : kCodecs) {
        const DicomFile slice = compressed(codec);
        const std::string name = codec.name, &bytes = slice.fragments[0];
        const char* frame = name == "jpeg_baseline"   ? "\xff\xc0"
                            : name == "jpeg_extended" ? "\xff\xc1"
                            : name == "jpeg_lossless" ? "\xff\xc3"
                            : name == "jpeg_ls"       ? "\xff\xf7"
                                                      : nullptr;
        if (!frame) continue;
        const std::size_t at = bytes.find(frame);
        ASSERT_NE(at, bytes.npos) << name;
        expect_refused(grown(codec, at + 5), "bytes of compressed pixels, expected");
    }
}

TEST(DicomCodestreams, RunLengthsOutsideOfTheirSegmentAreRefused) {
    const auto refused = [](const std::function<void(std::string&)>& change, const char* expected) {
        DicomFile slice = compressed("5", "rle", "u16");
        change(slice.fragments[0]);
        expect_refused(slice, expected);
    };
    refused([](auto& b) { b[0] = 3; }, "has 3 segments of run lengths, expected 2");
    refused([](auto& b) { b[3] = '\x7f'; }, "segments of run lengths, expected 2");
    refused([](auto& b) { b[4] = 60; }, "run lengths that don't make 12 × 10 pixels");
    refused([](auto& b) { b[8] = '\xff', b[9] = '\xff'; }, "run lengths that don't make");
    refused([](auto& b) { b.resize(b.size() - 8); }, "run lengths that don't make");
}

TEST(DicomCodestreams, Jpeg2000MayLieInBoxes) {
    const auto box = [](const std::string& type, const std::string& content) {
        const auto length = std::uint32_t(content.size() + 8);
        return std::string{char(length >> 24), char(length >> 16), char(length >> 8),
                           char(length)} +
               type + content;
    };
    DicomFile slice = compressed("4.90", "jpeg_2000", "u8");
    const std::string size("\0\0\0\x0a\0\0\0\x0c\0\x01\x07\x07\0\0", 14);
    const std::string colour("\x01\0\0\0\0\0\x11", 7);  // grey
    const std::string start = box("jP  ", "\x0d\x0a\x87\x0a") +
                              box("ftyp", std::string("jp2 \0\0\0\0jp2 ", 12)) +
                              box("jp2h", box("ihdr", size) + box("colr", colour));
    slice.fragments = {start + box("jp2c", slice.fragments[0])};
    EXPECT_EQ(error_of(slice), "was read");
    slice.rows = 4;
    expect_refused(slice, "compressed pixels for 12 × 10");
    slice.fragments = {start};
    expect_refused(slice, "don't say their size");
}

TEST(DicomCodestreams, OtherTransferSyntaxesAreRefusedByName) {
    const auto refused = [](const std::string& syntax, const std::string& expected) {
        DicomFile slice = compressed("4.90", "jpeg_2000", "u8");
        slice.syntax = syntax;
        expect_refused(slice, expected);
    };
    refused("1.2.840.10008.1.2.4.201", "is High-Throughput JPEG 2000 (transfer syntax");
    refused("1.2.840.10008.1.2.4.92", "is JPEG 2000 part 2");
    refused("1.2.840.10008.1.2.4.53", "is a retired process of JPEG");
    refused("1.2.840.10008.1.2.4.102", "is video");
    refused("1.2.840.113619.5.2", "is transfer syntax 1.2.840.113619.5.2");
}

TEST(DicomCodestreams, PixelsMustBeInFragmentsAsTheSyntaxSays) {
    DicomFile slice = compressed("4.90", "jpeg_2000", "u8");
    slice.syntax = "1.2.840.10008.1.2.1";
    expect_refused(slice, "has pixels in fragments");
    slice = DicomFile();
    slice.syntax = "1.2.840.10008.1.2.4.90";
    expect_refused(slice, "has compressed pixels that aren't in fragments");
}

/// Slices that ended the process once.
TEST(DicomCodestreams, FilesThatEndedTheProcessAreRefusedInOneLine) {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(PLIANT_DICOM_CORPUS)) {
        if (!entry.path().filename().string().starts_with("crash")) continue;
        SCOPED_TRACE(entry.path().filename());
        ++count;
        const auto slices = read_dicom_slices(entry.path());
        ASSERT_TRUE(slices.ok()) << slices.error().message;
        ASSERT_EQ(slices->size(), 1u);
        const DicomSlice& slice = slices->front();
        Status status = slice.fault ? Status(*slice.fault) : Status(Ok{});
        if (status) {
            VoxelBuilder voxels(std::size_t(slice.rows) * std::size_t(slice.columns));
            status = DicomPixelReader({slice}).read(slice, voxels);
        }
        ASSERT_FALSE(status.ok());
        EXPECT_TRUE(status.error().message.starts_with(entry.path().string() + ": "));
        EXPECT_EQ(status.error().message.find('\n'), std::string::npos);
    }
    EXPECT_EQ(count, 18);
}

}  // namespace
}  // namespace pliant::test
