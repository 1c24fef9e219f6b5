// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Folders as scanners and archives leave them: with files that are damaged or of other kinds, and
// positions that are rounded.
// Covers: formats/dicom_stack.cpp, formats/dicom_series.cpp.

#include "formats/dicom_series.h"
#include "support/compressed_dicom.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace pliant {
namespace {

using test::DicomFile;

class DicomFolders : public testing::Test {
  protected:
    /// Slices at 0, 1, … mm, each filled with its number.
    void write_series(const std::string& prefix, int count, const DicomFile& pattern = {}) {
        for (int n = 0; n < count; ++n) {
            DicomFile slice = pattern;
            slice.position[2] = n;
            slice.pixels.assign(12, std::int16_t(1000 + n));
            m_folder.write(prefix + std::to_string(n) + ".dcm", slice.bytes());
        }
    }
    void cut_short(const std::string& name, std::size_t bytes) {
        const std::string all = test::bytes_of(m_folder / name);
        m_folder.write(name, all.substr(0, all.size() - bytes));
    }
    Result<Volume> read(const std::string& series = {}) {
        testing::internal::CaptureStderr();
        auto volume = read_volume(m_folder.path(), {series}, &m_notes);
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
        return volume;
    }
    std::string error(const std::string& series = {}) {
        const auto volume = read(series);
        if (volume.ok()) return "was read";
        EXPECT_EQ(volume.error().message.find('\n'), std::string::npos) << volume.error().message;
        return volume.error().message;
    }
    void expect_error(const std::string& expected, const std::string& series = {}) {
        const std::string message = error(series);
        EXPECT_NE(message.find(expected), message.npos) << message << "\nexpected: " << expected;
    }
    void expect_note(const std::string& expected) {
        for (const std::string& note : m_notes.notes)
            if (note.find(expected) != note.npos) return;
        ADD_FAILURE() << "no note: " << expected;
    }
    test::TemporaryFolder m_folder;
    ReadNotes m_notes;
};

TEST_F(DicomFolders, ADamagedFileIsInTheWayOfItsOwnSeriesOnly) {
    DicomFile other;
    other.series = "9.8.7";
    write_series("a", 3);
    write_series("b", 3, other);
    cut_short("b1.dcm", 5);
    const auto volume = read();
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({0, 0, 2}), 2);
    expect_note("the series 9.8.7 left out: " + (m_folder / "b1.dcm").string() +
                ": is damaged or ends early");
    EXPECT_TRUE(read("1.2.3").ok());
    expect_error("b1.dcm: is damaged or ends early", "9.8.7");
    expect_error("has no series 4", "4");
    const auto series = list_series(m_folder.path());
    ASSERT_TRUE(series.ok());
    ASSERT_EQ(series->size(), 2u);
    EXPECT_EQ(series->front().fault, "");
    EXPECT_EQ(series->back().uid, "9.8.7");
    EXPECT_NE(series->back().fault.find("b1.dcm: is damaged or ends early"), std::string::npos);
}

TEST_F(DicomFolders, ADamagedFileOfAnUnknownSeriesIsLeftOutWhereASeriesIsNamed) {
    write_series("a", 4);
    cut_short("a3.dcm", test::bytes_of(m_folder / "a3.dcm").size() - 150);
    expect_error("a3.dcm: is damaged or ends early");
    const auto volume = read("1.2.3");
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size.z, 3);
    expect_note("1 file of the folder left out: " + (m_folder / "a3.dcm").string());
}

TEST_F(DicomFolders, WhereAllSeriesAreDamagedOneMustBeNamed) {
    DicomFile other;
    other.series = "9.8.7";
    write_series("a", 2);
    write_series("b", 2, other);
    cut_short("a1.dcm", 5);
    cut_short("b1.dcm", 5);
    expect_error("holds 2 series, choose one with --series");
    expect_error("a1.dcm: is damaged", "1.2.3");
}

TEST_F(DicomFolders, WhatFollowsThePixelsIsOfNoConcern) {
    write_series("a", 2);
    const std::string bytes = test::bytes_of(m_folder / "a1.dcm");
    m_folder.write("a1.dcm", bytes + std::string(1000, '\0'));
    EXPECT_TRUE(read().ok());
    m_folder.write("a1.dcm", bytes + "\x12\x34");
    EXPECT_TRUE(read().ok());
}

TEST_F(DicomFolders, DoseAndSegmentationsAreNoImages) {
    DicomFile dose;
    dose.series = "5.5";
    dose.sop_class = "1.2.840.10008.5.1.4.1.1.481.2";
    dose.more = std::string("\x28\0\x09\0AT\x04\0\x04\x30\x0c\0", 12);  // no number of frames
    write_series("dose", 3, dose);
    expect_error("dose0.dcm: is an RT Dose object, expected an image");
    write_series("a", 2);
    const auto volume = read();
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    expect_note("the series 5.5 left out: ");
    DicomFile labels;
    labels.sop_class = "1.2.840.10008.5.1.4.1.1.66.4";
    labels.series = "6.6";
    write_series("labels", 2, labels);
    expect_error("is a segmentation object", "6.6");
}

TEST_F(DicomFolders, OtherPhotometricInterpretationsAreRefused) {
    for (const char* name : {"PALETTE COLOR", "RGB", "YBR_FULL", "ARGB", "MONOCHROME3"}) {
        DicomFile slice;
        slice.photometric = name;
        write_series("a", 2, slice);
        expect_error(std::string("has Photometric Interpretation ") + name +
                     ", expected MONOCHROME1 or MONOCHROME2");
    }
    DicomFile slice;
    slice.more = std::string("\x28\0\x06\0US\x02\0\x02\0", 10);
    write_series("a", 2, slice);
    expect_error("has Planar Configuration 2, expected 0 or 1");
}

TEST_F(DicomFolders, Monochrome1IsNotInverted) {
    DicomFile slice;
    slice.photometric = "MONOCHROME1";
    write_series("a", 2, slice);
    auto volume = read();
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({0, 0, 0}), 0);
    EXPECT_EQ(volume->at({0, 0, 1}), 1);
    // Compressed ones neither.
    std::vector<float> first;
    for (const char* photometric : {"MONOCHROME2", "MONOCHROME1"}) {
        DicomFile packed = test::compressed("4.90", "jpeg_2000", "u12");
        packed.photometric = photometric;
        write_series("a", 2, packed);
        volume = read();
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        first.push_back(volume->at({0, 0, 0}));
    }
    EXPECT_EQ(first[0], -1000);
    EXPECT_EQ(first[1], -1000);
}

TEST_F(DicomFolders, SeriesWithoutAnUidCanBeChosen) {
    DicomFile nameless;
    nameless.series = "";
    write_series("a", 2);
    write_series("b", 3, nameless);
    expect_error("holds 2 series, choose one with --series");
    const auto series = list_series(m_folder.path());
    ASSERT_TRUE(series.ok()) << series.error().message;
    ASSERT_EQ(series->size(), 2u);
    EXPECT_EQ(series->back().uid, "none");
    EXPECT_EQ(series->back().slices, 3);
    const auto volume = read("none");
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size.z, 3);
}

TEST_F(DicomFolders, TablesOfModalityValuesAreNoted) {
    DicomFile slice;
    // An empty sequence is as good as none.
    slice.more = std::string("\x28\0\0\x30SQ\0\0\0\0\0\0", 12);
    write_series("a", 2, slice);
    ASSERT_TRUE(read().ok());
    EXPECT_TRUE(m_notes.notes.empty());
    slice.more = std::string("\x28\0\0\x30SQ\0\0\x8\0\0\0\xfe\xff\0\xe0\0\0\0\0", 20);
    write_series("a", 2, slice);
    ASSERT_TRUE(read().ok());
    expect_note("the Modality LUT Sequence is not applied");
}

/// Slices that lie straight above each other, in a stack that is turned; positions rounded.
void write_rounded(const test::TemporaryFolder& folder, int count, double gap_mm, double to_mm,
                   double lean = 0, double odd_one_mm = 0) {
    const double angle = 0.123, c = std::cos(angle), s = std::sin(angle);
    for (int n = 0; n < count; ++n) {
        DicomFile slice;
        slice.spacing = {0.9, 0.9};
        slice.orientation = {1, 0, 0, 0, c, s};
        const double along = n * gap_mm, aside = lean * along + (n == 5 ? odd_one_mm : 0);
        const Vec3d at{-100.3 + aside, -120.74 - s * along, 33.1 + c * along};
        for (int a = 0; a < 3; ++a)
            slice.position[std::size_t(a)] = std::round(at[a] / to_mm) * to_mm;
        folder.write(std::to_string(100 + n) + ".dcm", slice.bytes());
    }
}

TEST_F(DicomFolders, RoundedPositionsAreNoGantryTilt) {
    write_rounded(m_folder, 19, 5, 0.1);
    const auto volume = read();
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_NEAR(volume->grid.spacing_mm.z, 5, 0.02);
    expect_note("slices are shifted sideways by up to 0.");
}

TEST_F(DicomFolders, RoundedPositionsAreNoGaps) {
    write_rounded(m_folder, 19, 0.625, 0.1);
    const auto volume = read();
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_NEAR(volume->grid.spacing_mm.z, 0.625, 0.01);
}

TEST_F(DicomFolders, ALeanOfMoreThanAPartOfAPixelIsRefused) {
    write_rounded(m_folder, 19, 5, 0.1, 0.01);
    expect_error("leans by 0.6 degrees (gantry tilt)");
}

TEST_F(DicomFolders, ASliceThatIsShiftedSidewaysIsRefused) {
    write_rounded(m_folder, 19, 5, 0.1, 0, 0.9);
    expect_error("the slice 105.dcm is shifted sideways by 0.8");
}

}  // namespace
}  // namespace pliant
