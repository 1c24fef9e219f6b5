// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <functional>

namespace pliant {
namespace {

using test::DicomFile;

/// Writes slices at these heights, each filled with its number.
void write_slices(const test::TemporaryFolder& folder, const std::vector<double>& heights,
                  const DicomFile& pattern = {}, const std::string& prefix = "s") {
    for (std::size_t n = 0; n < heights.size(); ++n) {
        DicomFile slice = pattern;
        slice.position[2] = heights[n];
        slice.pixels.assign(12, std::int16_t(1000 + n));
        folder.write(prefix + std::to_string(n) + ".dcm", slice.bytes());
    }
}

std::string error_of(const std::filesystem::path& path, const ReadOptions& options = {}) {
    testing::internal::CaptureStderr();
    const auto volume = read_volume(path, options);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    return volume.ok() ? "was read" : volume.error().message;
}

void expect_error(const test::TemporaryFolder& folder, const std::string& expected) {
    const std::string message = error_of(folder.path());
    EXPECT_TRUE(message.starts_with(folder.path().string())) << message;
    EXPECT_NE(message.find(expected), message.npos) << message << "\nexpected: " << expected;
    EXPECT_EQ(message.find('\n'), message.npos) << message;
}

TEST(DicomSeries, IsSortedByPositionAndSpacedByIt) {
    const test::TemporaryFolder folder;
    write_slices(folder, {4, -2, 1});
    const auto volume = read_volume(folder.path());
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 3}));
    EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{0.25, 0.5, 3}));
    EXPECT_EQ(volume->grid.origin_mm, (Vec3d{0, 0, -2}));
    EXPECT_EQ(volume->at({0, 0, 0}), 1);
    EXPECT_EQ(volume->at({0, 0, 1}), 2);
    EXPECT_EQ(volume->at({3, 2, 2}), 0);
    EXPECT_TRUE(volume->key_values.empty());
}

TEST(DicomSeries, UnknownTypesAreReadAsThoseOfTheirElements) {
    const test::TemporaryFolder folder;
    DicomFile pattern;
    pattern.unknown_types = true;
    write_slices(folder, {4, -2, 1}, pattern);
    const auto volume = read_volume(folder.path());
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{0.25, 0.5, 3}));
    EXPECT_EQ(volume->at({0, 0, 1}), 2);
}

TEST(DicomSeries, ModalityAndRescaleTypeAreNoted) {
    const auto notes_of = [](const DicomFile& pattern) {
        const test::TemporaryFolder folder;
        write_slices(folder, {0, 1, 2}, pattern);
        ReadNotes notes;
        const auto volume = read_volume(folder.path(), {}, &notes);
        EXPECT_TRUE(volume.ok()) << volume.error().message;
        return notes;
    };
    for (const bool implicit : {false, true}) {
        DicomFile ct;
        ct.implicit = implicit;
        ct.rescale_type = "HU";
        const ReadNotes notes = notes_of(ct);
        EXPECT_EQ(notes.modality, "CT");
        EXPECT_EQ(notes.rescale_type, "HU");
        EXPECT_TRUE(notes.is_rescaled);
    }
    DicomFile mr;
    mr.modality = "MR";
    mr.intercept = "0";
    const ReadNotes notes = notes_of(mr);
    EXPECT_EQ(notes.modality, "MR");
    EXPECT_EQ(notes.rescale_type, "");
    EXPECT_FALSE(notes.is_rescaled);
    DicomFile none;
    none.modality = {};
    none.slope = "2";
    none.intercept = "0";
    EXPECT_EQ(notes_of(none).modality, "");
    EXPECT_TRUE(notes_of(none).is_rescaled);
}

TEST(DicomSeries, WindowOfTheMiddleSliceIsNoted) {
    const auto notes_of = [](const std::string& window, const std::string& level) {
        const test::TemporaryFolder folder;
        for (int n = 0; n < 3; ++n) {
            DicomFile slice;
            slice.position[2] = 2 - n;
            slice.window = n == 1 ? window : "7";
            slice.level = n == 1 ? level : "8";
            folder.write(std::to_string(n), slice.bytes());
        }
        ReadNotes notes;
        const auto volume = read_volume(folder.path(), {}, &notes);
        EXPECT_TRUE(volume.ok()) << volume.error().message;
        return notes;
    };
    const auto expect = [&](const ReadNotes& notes, double window, double level) {
        EXPECT_EQ(notes.window, window);
        EXPECT_EQ(notes.level, level);
    };
    expect(notes_of("350", "-40.5"), 350, -40.5);
    expect(notes_of("350\\1500", "40\\-600"), 350, 40);  // the first of two
    for (const auto& [window, level] : {std::pair{"", "40"},
                                        {"400", ""},
                                        {"0", "40"},
                                        {"-5", "40"},
                                        {"wide", "40"},
                                        {"1e999", "40"}}) {
        SCOPED_TRACE(std::string(window) + " " + level);
        expect(notes_of(window, level), 0, 0);
    }
}

TEST(DicomSeries, SlopeAndInterceptAreAppliedSliceBySlice) {
    const test::TemporaryFolder folder;
    for (int n = 0; n < 2; ++n) {
        DicomFile slice;
        slice.position[2] = n;
        slice.slope = n == 0 ? "2" : "0.5";
        slice.intercept = n == 0 ? "-1024" : "0";
        slice.pixels.assign(12, 11);
        folder.write(std::to_string(n), slice.bytes());
    }
    const auto volume = read_volume(folder.path());
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({0, 0, 0}), -1002);
    EXPECT_EQ(volume->at({0, 0, 1}), 5.5f);
    EXPECT_FALSE(volume->is_16_bit());
}

TEST(DicomSeries, PixelsOfEveryLayoutAreRead) {
    struct Layout {
        std::uint16_t bits_stored, high_bit, is_signed;
    };
    for (const Layout& layout :
         {Layout{16, 15, 1}, Layout{16, 15, 0}, Layout{12, 11, 0}, Layout{12, 11, 1}}) {
        const test::TemporaryFolder folder;
        DicomFile slice;
        slice.bits_stored = layout.bits_stored;
        slice.high_bit = layout.high_bit;
        slice.is_signed = layout.is_signed;
        slice.slope = "1.5";
        slice.intercept = "-1024";
        std::vector<int> stored;
        for (int n = 0; n < 12; ++n) {
            stored.push_back(layout.is_signed ? 340 * n - 2000 : 340 * n);
            slice.pixels[std::size_t(n)] =
                std::int16_t(stored.back() & ((1 << layout.bits_stored) - 1));
        }
        folder.write("a.dcm", slice.bytes());
        slice.position[2] = 1;
        folder.write("b.dcm", slice.bytes());
        const auto volume = read_volume(folder.path());
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        for (int n = 0; n < 12; ++n)
            EXPECT_EQ(volume->at({n % 4, n / 4, 0}), float(1.5 * stored[std::size_t(n)] - 1024))
                << layout.bits_stored << ' ' << layout.is_signed << ' ' << n;
    }
}

TEST(DicomSeries, BitsBesideThePixelAreLeftOut) {
    const test::TemporaryFolder folder;
    DicomFile slice;
    slice.bits_stored = 12;
    slice.high_bit = 11;
    slice.is_signed = 1;
    for (int n = 0; n < 12; ++n)
        slice.pixels[std::size_t(n)] = std::int16_t(((n - 6) & 0xfff) | 0xf000);
    folder.write("a.dcm", slice.bytes());
    slice.position[2] = 1;
    folder.write("b.dcm", slice.bytes());
    const auto volume = read_volume(folder.path());
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    for (int n = 0; n < 24; ++n)
        EXPECT_EQ(volume->at({n % 4, n / 4 % 3, n / 12}), float(n % 12 - 6 - 1000));
    slice.high_bit = 15;
    folder.write("b.dcm", slice.bytes());
    expect_error(folder, "stores 12 bits of 16 up to bit 15");
}

TEST(DicomSeries, OtherFilesAreLeftOutAndCounted) {
    const test::TemporaryFolder folder;
    write_slices(folder, {0, 1});
    folder.write("notes.txt", "hello");
    folder.write("short", "x");
    DicomFile report;  // DICOM, but no image
    report.sop_class = "1.2.840.10008.5.1.4.1.1.88.11";
    std::string bytes = report.bytes();
    bytes.resize(bytes.find(std::string("\x28\0\x02\0", 4)));
    folder.write("report.dcm", bytes);
    ReadNotes notes;
    const auto volume = read_volume(folder.path(), {}, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    ASSERT_EQ(notes.notes.size(), 1u);
    EXPECT_EQ(notes.notes[0], "3 files of the folder left out: no DICOM image");
}

TEST(DicomSeries, AmongSeveralOneMustBeChosen) {
    const test::TemporaryFolder folder;
    DicomFile bone;
    bone.series = "9.8.7";
    bone.description = "bone kernel";
    write_slices(folder, {0, 1}, {}, "a");
    write_slices(folder, {0, 1, 2}, bone, "b");
    expect_error(folder,
                 "holds 2 series, choose one with --series and its number or a part of its "
                 "description");
    const auto chosen = read_volume(folder.path(), {"9.8.7"});
    ASSERT_TRUE(chosen.ok()) << chosen.error().message;
    EXPECT_EQ(chosen->grid.size.z, 3);
    EXPECT_NE(error_of(folder.path(), {"4.4"}).find("has no series 4.4"), std::string::npos);
}

TEST(DicomSeries, ASingleFileIsSentToItsFolder) {
    const test::TemporaryFolder folder;
    write_slices(folder, {0, 1});
    const std::string message = error_of(folder.path() / "s0.dcm");
    EXPECT_NE(message.find("expected the folder of its series"), message.npos) << message;
}

TEST(DicomSeries, StacksWithGapsAndDoublesAreRefused) {
    {
        const test::TemporaryFolder folder;
        write_slices(folder, {0, 1, 2, 5, 6});
        expect_error(folder, "slices are missing between s2.dcm and s3.dcm (2 of them)");
    }
    {
        const test::TemporaryFolder folder;
        write_slices(folder, {0, 1, 2, 3.4, 4.4});
        expect_error(folder, "not equally spaced");
    }
    {
        const test::TemporaryFolder folder;
        write_slices(folder, {0, 1, 1, 2});
        expect_error(folder, "at the same position: s1.dcm and s2.dcm");
    }
}

TEST(DicomSeries, RoundingOfPositionsIsNoGap) {
    const test::TemporaryFolder folder;
    write_slices(folder, {0, 0.62, 1.25, 1.88, 2.5});
    const auto volume = read_volume(folder.path());
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_DOUBLE_EQ(volume->grid.spacing_mm.z, 0.625);
}

TEST(DicomSeries, ATiltedGantryIsRefused) {
    const test::TemporaryFolder folder;
    for (int n = 0; n < 5; ++n) {
        DicomFile slice;
        slice.position = {0, 0.2679 * n, double(n)};
        folder.write(std::to_string(n), slice.bytes());
    }
    expect_error(folder, "leans by 15 degrees (gantry tilt)");
}

TEST(DicomSeries, SlicesThatDifferAreRefused) {
    const auto refused = [](const std::function<void(DicomFile&)>& change, const char* expected) {
        const test::TemporaryFolder folder;
        write_slices(folder, {0, 1});
        DicomFile other;
        other.position[2] = 2;
        change(other);
        folder.write("t.dcm", other.bytes());
        expect_error(folder, expected);
    };
    refused([](auto& f) { f.rows = 4, f.columns = 3; }, "s0.dcm and t.dcm differ in size");
    refused([](auto& f) { f.orientation = {0, 1, 0, 1, 0, 0}; }, "differ in orientation");
    refused([](auto& f) { f.spacing = {1, 1}; }, "differ in pixel spacing");
    refused([](auto& f) { f.with_position = false; }, "no usable Image Position (Patient)");
    refused([](auto& f) { f.slope = "steep"; }, "no usable Rescale Slope");
    refused([](auto& f) { f.high_bit = 16; }, "stores 16 bits of 16 up to bit 16");
    refused([](auto& f) { f.frames = "7"; }, "has 24 bytes of pixels, expected 168");
    refused([](auto& f) { f.frames = "4294967297"; }, "holds 4294967297 frames");
    refused([](auto& f) { f.position[0] = 1e308, f.position[1] = -1e308; }, "origin is");
    refused([](auto& f) { f.samples = 3, f.pixels.resize(36); }, "holds colour");
    refused([](auto& f) { f.pixels.resize(5); }, "has 10 bytes of pixels, expected 24");
}

TEST(DicomSeries, OrientationsThatMakeNoSenseAreRefused) {
    const auto refused = [](const std::array<double, 6>& orientation, const char* expected) {
        const test::TemporaryFolder folder;
        DicomFile slice;
        slice.orientation = orientation;
        write_slices(folder, {0, 1}, slice);
        expect_error(folder, expected);
    };
    refused({1, 0, 0, 1, 0, 0}, "expected perpendicular unit vectors");
    refused({0, 0, 0, 0, 0, 0}, "expected perpendicular unit vectors");
    refused({1, 0, 0, 0.5, 1, 0}, "expected perpendicular unit vectors");
}

TEST(DicomSeries, FilesThatEndEarlyAreNamed) {
    for (const std::size_t cut : {1, 10, 30, 36, 50, 100, 200, 300}) {
        const test::TemporaryFolder folder;
        write_slices(folder, {0, 1, 2});
        const std::string bytes = test::bytes_of(folder.path() / "s1.dcm");
        folder.write("s1.dcm", bytes.substr(0, bytes.size() - cut));
        const std::string message = error_of(folder.path());
        EXPECT_NE(message.find("s1.dcm: is damaged or ends early"), message.npos) << message;
    }
}

TEST(DicomSeries, ElementsOfAnotherTypeAreRefused) {
    const test::TemporaryFolder folder;
    write_slices(folder, {0, 1});
    std::string bytes = test::bytes_of(folder.path() / "s1.dcm");
    const std::size_t bits_stored = bytes.find(std::string("\x28\0\x01\x01US", 6));
    ASSERT_NE(bits_stored, bytes.npos);
    bytes.replace(bits_stored + 4, 2, "SS");
    folder.write("s1.dcm", bytes);
    const std::string message = error_of(folder.path());
    EXPECT_NE(message.find("s1.dcm: is damaged or ends early"), message.npos) << message;
}

}  // namespace
}  // namespace pliant
