// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Values of DICOM pixels: empty elements, floats, deflated files.
// Covers: formats/dicom_input.cpp, formats/dicom_pixels.cpp.

#include "base/byte_order.h"
#include "support/damaged_scan.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <cstring>

namespace pliant {
namespace {

using test::DicomFile;
using test::packed;

class DicomNumbers : public testing::Test {
  protected:
    /// Reads the folder of this slice and of another one 1 mm above.
    Result<Volume> read(DicomFile slice) {
        m_folder.write("a.dcm", slice.bytes());
        slice.position[2] += 1;
        m_folder.write("b.dcm", slice.bytes());
        return read_volume(m_folder.path(), {}, &m_notes);
    }
    test::TemporaryFolder m_folder;
    ReadNotes m_notes;
};

/// The file with all elements behind group 2 deflated.
std::string deflated(DicomFile file) {
    file.syntax = "1.2.840.10008.1.2.1.99";
    const std::string bytes = file.bytes();
    std::uint32_t meta = 0;
    std::memcpy(&meta, &bytes[140], sizeof meta);
    meta = little_endian(meta);
    const std::string body = test::zlibbed(bytes.substr(144 + meta));
    return bytes.substr(0, 144 + meta) + body.substr(2, body.size() - 6);
}

TEST_F(DicomNumbers, EmptyElementsCountAsAbsent) {
    for (const bool implicit : {false, true})
        for (const char* empty : {"", " "}) {
            DicomFile slice;
            slice.implicit = implicit;
            slice.slope = empty;
            slice.intercept = empty;
            slice.frames = empty;
            // Empty Samples per Pixel and Pixel Representation.
            if (!implicit) slice.more = std::string("\x28\0\x02\0US\0\0\x28\0\x03\1US\0\0", 16);
            const auto volume = read(slice);
            ASSERT_TRUE(volume.ok()) << volume.error().message;
            EXPECT_EQ(volume->at({1, 1, 1}), 1000);
            EXPECT_TRUE(m_notes.notes.empty());
        }
}

TEST_F(DicomNumbers, AMissingPixelRepresentationIsNotedIfItMatters) {
    DicomFile slice;
    slice.with_sign = false;
    slice.intercept = "0";
    ASSERT_TRUE(read(slice).ok());
    EXPECT_TRUE(m_notes.notes.empty());
    slice.pixels[3] = -1000;
    const auto volume = read(slice);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({3, 0, 0}), 64536);
    EXPECT_EQ(m_notes.notes, std::vector<std::string>{
                                 "Pixel Representation is missing: pixels are taken as unsigned, "
                                 "2 of them have the bit that would be the sign"});
    slice.bits_allocated = slice.bits_stored = 8;
    slice.high_bit = 7;
    slice.raw = std::string("\0\x7f\x80\xff\0\0\0\0\0\0\0\0", 12);
    ASSERT_TRUE(read(slice).ok());
    ASSERT_EQ(m_notes.notes.size(), 1u);
    EXPECT_NE(m_notes.notes[0].find("4 of them"), std::string::npos);
}

TEST_F(DicomNumbers, FloatsAndDoublesAreRead) {
    std::vector<float> floats;
    std::vector<double> doubles;
    for (int n = 0; n < 12; ++n) {
        floats.push_back(float(n) / 3 - 2);
        doubles.push_back(double(floats.back()));
    }
    for (const bool is_double : {false, true})
        for (const bool big_endian : {false, true})
            for (const bool scaled : {false, true}) {
                DicomFile slice;
                slice.pixel_element = is_double ? 9 : 8;
                slice.pixel_type = is_double ? "OD" : "OF";
                slice.bits_allocated = is_double ? 64 : 32;
                slice.raw = is_double ? packed(doubles) : packed(floats);
                if (big_endian) {
                    slice.raw = test::swapped(slice.raw, is_double ? 8 : 4);
                    slice.syntax = "1.2.840.10008.1.2.2";
                }
                slice.slope = scaled ? "2" : "1";
                slice.intercept = scaled ? "10" : "0";
                const auto volume = read(slice);
                ASSERT_TRUE(volume.ok()) << volume.error().message;
                EXPECT_EQ(m_notes.stored_type, is_double ? "float64" : "float32");
                for (int n = 0; n < 12; ++n) {
                    const float stored = floats[std::size_t(n)];
                    EXPECT_EQ(volume->at({n % 4, n / 4, 1}),
                              scaled ? float(2 * double(stored) + 10) : stored);
                }
            }
    DicomFile slice;
    slice.pixel_element = 8;
    slice.pixel_type = "OF";
    slice.raw = packed(floats);
    const auto wrong = read(slice);
    ASSERT_FALSE(wrong.ok());
    EXPECT_NE(wrong.error().message.find("allocates 16 bits for a float, expected 32"),
              std::string::npos)
        << wrong.error().message;
}

/// A Pixel Padding Value, and the limit of its range if it differs.
std::string padding(std::uint16_t value, std::uint16_t limit) {
    std::string text = std::string("\x28\0\x20\1US\2\0", 8) + packed<std::uint16_t>({value});
    if (limit != value)
        text += std::string("\x28\0\x21\1US\2\0", 8) + packed<std::uint16_t>({limit});
    return text;
}

TEST_F(DicomNumbers, PaddingOfCtBecomesAir) {
    DicomFile slice;
    slice.intercept = "0";
    slice.pixels.assign(12, 40);
    slice.pixels[0] = slice.pixels[5] = -2000;
    slice.more = padding(std::uint16_t(-2000), std::uint16_t(-2000));
    auto volume = read(slice);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({0, 0, 0}), -1024);
    EXPECT_EQ(volume->at({1, 1, 1}), -1024);
    EXPECT_EQ(volume->at({2, 1, 1}), 40);
    EXPECT_EQ(m_notes.notes, std::vector<std::string>{"4 voxels of padding became -1024"});
    // A range; and a number above the stored bits, as old scanners write it.
    slice.pixels[1] = -1990;
    slice.more = padding(std::uint16_t(-2000), std::uint16_t(-1990));
    volume = read(slice);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({1, 0, 0}), -1024);
    slice.intercept = "-1024";
    slice.is_signed = 0;
    slice.bits_stored = 12;
    slice.high_bit = 11;
    slice.pixels.assign(12, 2096);
    slice.pixels[0] = std::int16_t(63536);
    slice.pixels[1] = 0;
    slice.more = padding(63536, 63536);
    volume = read(slice);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({0, 0, 0}), -1024);
    EXPECT_EQ(volume->at({1, 0, 0}), -1024);
    EXPECT_EQ(volume->at({2, 0, 0}), 1072);
    EXPECT_TRUE(volume->is_16_bit());
    EXPECT_EQ(m_notes.notes, std::vector<std::string>{"2 voxels of padding became -1024"});
}

TEST_F(DicomNumbers, PaddingThatIsAirKeepsItsValue) {
    DicomFile slice;  // −1000 … 0 HU
    slice.is_signed = 0;
    slice.pixels[0] = 0;
    slice.more = padding(0, 0);
    auto volume = read(slice);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({0, 0, 0}), -1000);
    EXPECT_TRUE(m_notes.notes.empty());
    slice.modality = "MR";
    slice.intercept = "0";
    volume = read(slice);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({0, 0, 0}), 0);
    EXPECT_TRUE(m_notes.notes.empty());
    // Other padding becomes 0 in scans that aren't CT.
    slice.pixels[0] = std::int16_t(65535);
    slice.more = padding(65535, 65535);
    volume = read(slice);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({0, 0, 0}), 0);
    EXPECT_EQ(m_notes.notes, std::vector<std::string>{"2 voxels of padding became 0"});
}

TEST_F(DicomNumbers, PaddingBetweenOtherValuesIsKept) {
    DicomFile slice;
    slice.intercept = "0";
    slice.pixels = {-1000, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1000};
    slice.more = padding(0, 0);
    const auto volume = read(slice);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({1, 0, 0}), 0);
    EXPECT_EQ(m_notes.notes, std::vector<std::string>{
                                 "the Pixel Padding Value is kept where it lies between other "
                                 "values, first in a.dcm"});
}

TEST_F(DicomNumbers, PaddingIsNotBlendedByStraightening) {
    DicomFile slice;
    slice.intercept = "0";
    slice.more = padding(std::uint16_t(-2000), std::uint16_t(-2000));
    for (int n = 0; n < 6; ++n) {
        slice.position = {0, 0.3 * n, double(n)};
        slice.instance = "6.6." + std::to_string(n);
        slice.pixels.assign(12, 40);
        for (std::size_t p = 0; p < 4; ++p) slice.pixels[p] = -2000;
        m_folder.write(std::to_string(n), slice.bytes());
    }
    const auto volume = read_volume(m_folder.path(), {.straighten = true}, &m_notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    int padding_count = 0, other = 0;
    for (int k = 0; k < volume->grid.size.z; ++k)
        for (int j = 0; j < volume->grid.size.y; ++j)
            for (int i = 0; i < volume->grid.size.x; ++i) {
                const float value = volume->at({i, j, k});
                padding_count += value == -1024;
                other += value != -1024 && value != 40 && value != -1000;
            }
    EXPECT_GE(padding_count, 6);
    EXPECT_EQ(other, 0);
}

TEST_F(DicomNumbers, DeflatedFilesAreRead) {
    DicomFile slice;
    for (std::size_t n = 0; n < 12; ++n) slice.pixels[n] = std::int16_t(100 * n);
    m_folder.write("a.dcm", deflated(slice));
    slice.position[2] = 3;
    m_folder.write("b.dcm", deflated(slice));
    m_folder.write("b(1).dcm", deflated(slice));
    const auto volume = read_volume(m_folder.path(), {}, &m_notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{0.25, 0.5, 3}));
    for (int n = 0; n < 24; ++n)
        EXPECT_EQ(volume->at({n % 4, n / 4 % 3, n / 12}), float(100 * (n % 12) - 1000));
    EXPECT_EQ(m_notes.notes,
              std::vector<std::string>{"1 copy of slices left out: b.dcm of b(1).dcm"});
}

TEST_F(DicomNumbers, DamagedDeflatedFilesAreRefusedInOneLine) {
    const std::string bytes = deflated({});
    m_folder.write("a.dcm", bytes.substr(0, bytes.size() - 20));
    const auto volume = read_volume(m_folder.path());
    ASSERT_FALSE(volume.ok());
    EXPECT_EQ(volume.error().message,
              (m_folder / "a.dcm").string() + ": ends early: its compressed data are cut off");
    test::read_damaged("a.dcm", bytes, 200);
    // A short file that inflates to a lot.
    DicomFile large;
    large.more = std::string("\x09\0\x01\0OB\0\0\0\0\0\1", 12) + std::string(1 << 24, '\0');
    m_folder.write("a.dcm", deflated(large));
    EXPECT_TRUE(read_volume(m_folder.path()).ok());
}

}  // namespace
}  // namespace pliant
