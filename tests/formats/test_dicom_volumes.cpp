// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Series of several volumes, with copies and localizers, and the choice between series.
// Covers: formats/dicom_volumes.cpp, formats/dicom_choice.cpp, formats/dicom_folder.cpp.

#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace pliant {
namespace {

using test::DicomFile;

class DicomVolumes : public testing::Test {
  protected:
    /// Slices at 0, 1, … mm, filled with first, first + 1, …
    void write_series(const std::string& prefix, int count, int first,
                      const DicomFile& pattern = {}) {
        for (int n = 0; n < count; ++n) {
            DicomFile slice = pattern;
            slice.position[2] = n;
            if (!slice.instance.empty()) slice.instance += "." + std::to_string(n);
            slice.pixels.assign(12, std::int16_t(1000 + first + n));
            m_folder.write(prefix + std::to_string(n) + ".dcm", slice.bytes());
        }
    }
    Result<Volume> read(const ReadOptions& options = {}) {
        return read_volume(m_folder.path(), options, &m_notes);
    }
    std::string error(const ReadOptions& options = {}) {
        const auto volume = read(options);
        if (volume.ok()) return "was read";
        EXPECT_EQ(volume.error().message.find('\n'), std::string::npos);
        EXPECT_TRUE(volume.error().message.starts_with(m_folder.path().string()));
        return volume.error().message.substr(m_folder.path().string().size() + 2);
    }
    /// First value of each slice.
    std::vector<float> values(const ReadOptions& options = {}) {
        const auto volume = read(options);
        EXPECT_TRUE(volume.ok()) << volume.error().message;
        std::vector<float> first;
        for (int k = 0; volume.ok() && k < volume->grid.size.z; ++k)
            first.push_back(float(volume->at({0, 0, k})));
        return first;
    }
    test::TemporaryFolder m_folder;
    ReadNotes m_notes;
};

TEST_F(DicomVolumes, CopiesAreLeftOut) {
    write_series("a", 4, 0);
    m_folder.write("a1(1).dcm", test::bytes_of(m_folder / "a1.dcm"));
    m_folder.write("a3(1).dcm", test::bytes_of(m_folder / "a3.dcm"));
    m_folder.write("a3(2).dcm", test::bytes_of(m_folder / "a3.dcm"));
    EXPECT_EQ(values(), (std::vector<float>{0, 1, 2, 3}));
    EXPECT_EQ(m_notes.notes,
              std::vector<std::string>{"3 copies of slices left out: a1.dcm of a1(1).dcm"});
}

TEST_F(DicomVolumes, SlicesWithOneUidAndDifferentPixelsAreNoCopies) {
    write_series("a", 3, 0);
    DicomFile other;
    other.position[2] = 1;
    other.pixels.back() = 7;
    m_folder.write("b.dcm", other.bytes());
    EXPECT_TRUE(
        error().starts_with("two slices are at the same position: a1.dcm and b.dcm, "
                            "expected one at each position, or several volumes"));
    // One UID for all slices, as some programs write that remove names.
    DicomFile pattern;
    pattern.instance = "5.5";
    std::filesystem::remove(m_folder / "b.dcm");
    for (int n = 0; n < 3; ++n) {
        pattern.position[2] = n;
        m_folder.write("a" + std::to_string(n) + ".dcm", pattern.bytes());
    }
    EXPECT_EQ(values().size(), 3u);
}

TEST_F(DicomVolumes, LocalizersInASeriesAreLeftOut) {
    write_series("a", 4, 0);
    DicomFile scout;
    scout.orientation = {0, 1, 0, 0, 0, -1};
    scout.image_type = "ORIGINAL\\PRIMARY\\LOCALIZER";
    scout.instance = "7.7";
    m_folder.write("0.dcm", scout.bytes());
    EXPECT_EQ(values(), (std::vector<float>{0, 1, 2, 3}));
    EXPECT_EQ(m_notes.notes,
              std::vector<std::string>{
                  "1 slice of another orientation left out, such as a localizer: 0.dcm"});
    // Without that type a lone slice is one only beside many.
    scout.image_type = {};
    m_folder.write("0.dcm", scout.bytes());
    EXPECT_EQ(error(),
              "a0.dcm and 0.dcm differ in orientation, choose a volume with --frame 0…1 (0: 4 × 3 "
              "× 4; 1: 4 × 3 × 1 voxels)");
    EXPECT_EQ(values({.frame = 1}).size(), 1u);
    write_series("a", 8, 0);
    EXPECT_EQ(values().size(), 8u);
}

TEST_F(DicomVolumes, StacksOfDifferentShapesAreChosen) {
    write_series("a", 2, 0);
    DicomFile coronal;
    coronal.orientation = {1, 0, 0, 0, 0, -1};
    coronal.instance = "7.7";
    for (int n = 0; n < 3; ++n) {
        coronal.position = {0, double(n), 0};
        coronal.instance = "7.7." + std::to_string(n);
        m_folder.write("b" + std::to_string(n), coronal.bytes());
    }
    EXPECT_TRUE(error().starts_with("b0 and a0.dcm differ in orientation, choose a volume"));
    EXPECT_EQ(values({.frame = 0}).size(), 3u);
    EXPECT_EQ(values({.frame = 1}), (std::vector<float>{0, 1}));
    EXPECT_TRUE(m_notes.notes.empty());
}

TEST_F(DicomVolumes, TimesOfSingleSlicesAreChosen) {
    DicomFile late, soon;
    late.time = "10";
    late.instance = "7.1";
    soon.time = "2";
    soon.instance = "7.2";
    write_series("a", 3, 100, late);
    write_series("b", 3, 0, soon);
    EXPECT_EQ(error(), "holds 2 images, choose one with --frame 0…1");
    EXPECT_EQ(values({.frame = 0}), (std::vector<float>{0, 1, 2}));
    EXPECT_EQ(values({.frame = 1}), (std::vector<float>{100, 101, 102}));
    // Pixels that are equal at all times are no copies.
    write_series("b", 3, 100, soon);
    EXPECT_EQ(values({.frame = 0}), values({.frame = 1}));
}

TEST_F(DicomVolumes, ImagesAtEachPositionAreSortedByInstance) {
    for (int z = 0; z < 3; ++z)
        for (int t = 0; t < 4; ++t) {
            DicomFile slice;
            slice.position[2] = z;
            slice.instance_number = std::to_string(1 + 4 * z + t);
            slice.instance = "7.7." + slice.instance_number;
            slice.pixels.assign(12, std::int16_t(1000 + 10 * t + z));
            m_folder.write(std::to_string(t) + std::to_string(z), slice.bytes());
        }
    EXPECT_EQ(error(), "holds 4 images, choose one with --frame 0…3");
    for (int t = 0; t < 4; ++t)
        EXPECT_EQ(values({.frame = t}),
                  (std::vector<float>{float(10 * t), float(10 * t + 1), float(10 * t + 2)}));
    std::filesystem::remove(m_folder / "32");
    EXPECT_TRUE(error().starts_with("two slices are at the same position: "));
}

TEST_F(DicomVolumes, SeriesAreListedByTheirNumbers) {
    DicomFile thorax, head, scout;
    thorax.series_number = "10";
    thorax.description = "Thorax 1 mm";
    head.series = "1.2.4";
    head.series_number = "9";
    head.description = "Head 1 mm";
    head.modality = "MR";
    scout.series = "1.2.5";
    scout.description = "";
    write_series("a", 3, 0, thorax);
    write_series("b", 2, 50, head);
    write_series("c", 1, 90, scout);
    const std::string table =
        "number  description  modality  slices  size       spacing [mm]     UID\n"
        "9       Head 1 mm    MR        2       4 × 3 × 2  0.25 × 0.5 × 1   1.2.4\n"
        "10      Thorax 1 mm  CT        3       4 × 3 × 3  0.25 × 0.5 × 1   1.2.3\n"
        "                     CT        1       4 × 3 × 1  0.25 × 0.5 × 17  1.2.5\n";
    const auto refused = read();
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().message, m_folder.path().string() +
                                           ": holds 3 series, choose one with --series and its "
                                           "number or a part of its description");
    EXPECT_EQ(refused.error().field, "series");
    const auto list = list_series(m_folder.path());
    ASSERT_TRUE(list.ok()) << list.error().message;
    EXPECT_EQ(refused.error().expected, table);
    EXPECT_EQ(table_of_series(*list), table);

    const auto same = list_series(m_folder.write("DICOMDIR", "x"));
    ASSERT_TRUE(same.ok()) << same.error().message;
    EXPECT_EQ(table_of_series(*same), table);

    EXPECT_EQ(values({"10"}), (std::vector<float>{0, 1, 2}));
    EXPECT_EQ(values({"9"}), (std::vector<float>{50, 51}));
    EXPECT_EQ(values({"THORAX"}), (std::vector<float>{0, 1, 2}));
    EXPECT_EQ(values({"1.2.5"}), std::vector<float>{90});
    EXPECT_EQ(error({"1 mm"}),
              "2 series fit --series 1 mm, expected one: a longer part of the description, or the "
              "UID");
    EXPECT_EQ(read({"1 mm"}).error().expected.find("1.2.5"), std::string::npos);
    // A whole number is no part of a description.
    EXPECT_TRUE(error({"1"}).starts_with("has no series 1, expected --series with the number"));
    EXPECT_EQ(read({"1"}).error().expected, table);
}

TEST_F(DicomVolumes, TheTableOfManySeriesIsComplete) {
    for (int n = 0; n < 30; ++n) {
        DicomFile one;
        one.series =
            "1.2.826.0.1.3680043.8.498.4242424242424242424242424242424242." + std::to_string(n);
        one.series_number = std::to_string(n);
        write_series("s" + std::to_string(n) + "_", 1, 0, one);
    }
    const auto refused = read();
    ASSERT_FALSE(refused.ok());
    const std::string& table = refused.error().expected;
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 31);
    for (int n = 0; n < 30; ++n)
        EXPECT_NE(table.find("4242." + std::to_string(n) + "\n"), table.npos) << n;
}

}  // namespace
}  // namespace pliant
