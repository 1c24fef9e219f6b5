// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Headers at the limits: long lines, many keys, skips, text for numbers, and images beyond the
// memory.
// Covers: formats/header_lines.cpp.

#include "base/memory_budget.h"
#include "formats/header_lines.h"
#include "formats/image_file.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

namespace pliant {
namespace {

using test::MetaFile;
using test::NrrdFile;

/// Good files with one thing changed.
class Headers : public testing::Test {
  protected:
    Result<Volume> read(const std::string& name, const std::string& bytes) {
        std::filesystem::remove(m_folder / name);
        return read_volume(m_folder.write(name, bytes));
    }
    void expect_read(const std::string& name, const std::string& bytes) {
        const auto volume = read(name, bytes);
        ASSERT_TRUE(volume.ok()) << volume.error().message.substr(0, 300);
        EXPECT_EQ(volume->at({1, 0, 0}), -99);
    }
    void expect_refused(const std::string& name, const std::string& bytes,
                        const std::string& expected) {
        const auto volume = read(name, bytes);
        ASSERT_FALSE(volume.ok()) << name << ": " << expected;
        const std::string reason = reason_of(volume.error());
        EXPECT_NE(reason.find(expected), std::string::npos) << reason;
    }
    /// The message behind the file's name: one short line.
    std::string reason_of(const Error& error) {
        const std::string& message = error.message;
        EXPECT_TRUE(message.starts_with(m_folder.path().string())) << message;
        const std::string reason = message.substr(message.find(": ") + 2);
        EXPECT_LE(reason.size(), 300u) << reason;
        for (const char c : reason) EXPECT_FALSE(c >= 0 && c < ' ') << reason;
        return reason;
    }
    test::TemporaryFolder m_folder;
};

TEST_F(Headers, LongCommentsAndNamesOfMetaImagesAreRead) {
    for (const char* field : {"Comment", "Name", "ObjectSubType", "Unknown"})
        for (const std::size_t length : {254, 255, 256, 499, 500, 501, 1024, 60000}) {
            MetaFile file;
            file.extra = std::string(field) + " = " + std::string(length, 'A') + "\n";
            expect_read("a.mha", file.bytes());
        }
    MetaFile file;
    file.extra = std::string(1000, 'n') + " = value\n";
    const auto volume = read("a.mha", file.bytes());
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->key_values, (KeyValues{{std::string(1000, 'n'), "value"}}));
}

TEST_F(Headers, LongValuesOfNrrdFieldsAreReadOrRefusedInOneLine) {
    const char* fields[] = {"content",
                            "number",
                            "block size",
                            "spacings",
                            "thicknesses",
                            "axis mins",
                            "axis maxs",
                            "centerings",
                            "labels",
                            "units",
                            "min",
                            "max",
                            "old min",
                            "old max",
                            "line skip",
                            "byte skip",
                            "sample units",
                            "space units",
                            "measurement frame",
                            "data file",
                            "space dimension",
                            "unknown",
                            "type",
                            "dimension",
                            "space",
                            "sizes",
                            "kinds",
                            "space directions",
                            "endian",
                            "encoding",
                            "space origin"};
    for (const char* field : fields)
        for (const std::size_t length : {500, 1100, 5000, 60000})
            for (const char fill : {'A', '9', '(', '"', '%', '\x1b'}) {
                NrrdFile file;
                file.extra = std::string(field) + ": " + std::string(length, fill) + "\n";
                const auto volume = read("a.nrrd", file.bytes());
                if (!volume.ok()) reason_of(volume.error());
            }
    for (const std::size_t length : {500, 1100, 60000}) {
        NrrdFile file;
        file.endian = std::string(length, 'A');
        expect_refused("a.nrrd", file.bytes(), "endian is 'aaa");
        file = {};
        file.extra = std::string(length, 'A') + ": 1\n";
        expect_refused("a.nrrd", file.bytes(), "unknown field");
    }
}

TEST_F(Headers, LongKeysAndCommentsOfNrrdAreRead) {
    NrrdFile file;
    file.extra = "#" + std::string(60000, 'c') + "\nkey:=" + std::string(60000, 'v') + "\n" +
                 std::string(1000, 'k') + ":=1\n";
    const auto volume = read("a.nrrd", file.bytes());
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->key_values,
              (KeyValues{{"key", std::string(60000, 'v')}, {std::string(1000, 'k'), "1"}}));
}

TEST_F(Headers, TooLongOnesAreRefused) {
    NrrdFile nrrd;
    nrrd.extra = "# " + std::string(kMaxHeaderLineBytes, 'c') + "\n";
    expect_refused("a.nrrd", nrrd.bytes(), "of its header has more than 65536 bytes");
    nrrd.extra.clear();
    for (int n = 0; n < 20; ++n) nrrd.extra += "# " + std::string(60000, 'c') + "\n";
    expect_refused("a.nrrd", nrrd.bytes(), "its header has more than 1048576 bytes");
    nrrd.extra.clear();
    for (std::size_t n = 0; n <= kMaxKeyValues; ++n) nrrd.extra += std::to_string(n) + ":=\n";
    expect_refused("a.nrrd", nrrd.bytes(), "more than 16384 keys");
    MetaFile meta;
    meta.extra = "Comment = " + std::string(kMaxHeaderLineBytes, 'c') + "\n";
    expect_refused("a.mha", meta.bytes(), "of its header has more than 65536 bytes");
    meta.extra.clear();
    for (std::size_t n = 0; n <= kMaxKeyValues; ++n) meta.extra += std::to_string(n) + " = 1\n";
    expect_refused("a.mha", meta.bytes(), "more than 16384 keys");
}

TEST_F(Headers, FieldsThatAreThereTwiceAreRefused) {
    NrrdFile nrrd;
    nrrd.extra = "sizes: 4 3 2\n";
    expect_refused("a.nrrd", nrrd.bytes(), "sizes is there twice");
    MetaFile meta;
    meta.extra = "DimSize = 4 3 2\n";
    expect_refused("a.mha", meta.bytes(), "DimSize is there twice");
}

TEST_F(Headers, ReadingOneOpensNoDataFile) {
    NrrdFile nrrd;
    nrrd.blank_line = false;
    nrrd.extra = "data file: gone.raw\n";
    EXPECT_TRUE(read_image_header(m_folder.write("a.nhdr", nrrd.bytes()), ImageFormat::Nrrd).ok());
    MetaFile meta;
    meta.data_file = "gone.raw";
    EXPECT_TRUE(
        read_image_header(m_folder.write("a.mhd", meta.bytes()), ImageFormat::MetaImage).ok());
    expect_refused("a.nhdr", nrrd.bytes(), "gone.raw is missing");
}

TEST_F(Headers, SkipsBeyondTheDataAreRefused) {
    NrrdFile file;
    file.extra = "byte skip: 30000000000\n";
    expect_refused("a.nrrd", file.bytes(), "ends early");
    file.encoding = "gzip";
    file.data = test::gzipped(file.data);
    expect_refused("a.nrrd", file.bytes(), "skips 30000000000 bytes of its compressed data");
    file.extra = "byte skip: 9223372036854775807\n";
    expect_refused("a.nrrd", file.bytes(), "skips 9223372036854775807 bytes");
    file.extra = "byte skip: 200000000\n";
    expect_refused("a.nrrd", file.bytes(), "ends early");
    file.extra = "line skip: 9223372036854775807\n";
    expect_refused("a.nrrd", file.bytes(), "ends early");
}

TEST_F(Headers, NumbersInTextHaveTheTypesRange) {
    NrrdFile file;
    file.encoding = "text";
    const auto with = [&](const std::string& word) {
        file.data = word;
        for (int n = 1; n < 24; ++n) file.data += " " + std::to_string(n);
        return file.bytes();
    };
    for (const char* word : {"1e3", "1000", "+1000.0", "1000,"}) {
        const auto volume = read("a.nrrd", with(word));
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->at({0, 0, 0}), 1000) << word;
    }
    for (const char* word : {"1.5", "40000", "-32769", "nan", "1e99", "0x10", "--1", ","})
        expect_refused("a.nrrd", with(word), "a number of type int16");
    expect_refused("a.nrrd", with(std::string(100000, '1')), "a number of type int16");
    file.type = "float";
    for (const char* word : {"1.5", "40000", "nan", "1e39", "-inf", "1e-60"}) {
        const auto volume = read("a.nrrd", with(word));
        EXPECT_TRUE(volume.ok()) << word;
    }
    file.data = "1 2 3";
    file.data += std::string(50, ' ');
    expect_refused("a.nrrd", file.bytes(), "holds 3 numbers, expected 24");
}

TEST_F(Headers, SpacesWithBlanksInTheirNamesAreConverted) {
    NrrdFile file;
    const auto grid_of = [&](const char* space) {
        file.space = space;
        const auto volume = read("a.nrrd", file.bytes());
        EXPECT_TRUE(volume.ok()) << volume.error().message;
        return volume->grid;
    };
    for (const char* alias : {"left anterior superior", "leftanteriorsuperior", "las"})
        EXPECT_EQ(grid_of(alias), grid_of("left-anterior-superior")) << alias;
    for (const char* alias : {"right anterior superior", "rightanteriorsuperior", "ras"})
        EXPECT_EQ(grid_of(alias), grid_of("right-anterior-superior")) << alias;
    EXPECT_NE(grid_of("las"), grid_of("ras"));
    EXPECT_NE(grid_of("las"), grid_of("lps"));
}

TEST_F(Headers, OtherPlacesBesideDirectionsArePassedOverOrRefused) {
    NrrdFile file;
    file.extra = "axis mins: nan nan nan\nunits: \"mm\" \"\" \"???\"\nthicknesses: 1 1 2\n";
    expect_read("a.nrrd", file.bytes());
    file.extra = "units: \"cm\" \"cm\" \"cm\"\n";
    expect_refused("a.nrrd", file.bytes(), "expected space units");
    file.extra = "spacings: 1 1 2\n";
    expect_refused("a.nrrd", file.bytes(), "spacings and space directions");
}

TEST_F(Headers, AxesThatLeanALittleAreNoted) {
    ReadNotes notes;
    NrrdFile file;
    file.directions = "(1,0,0) (0,1,0) (0.004,0,5)";  // a quarter of a millimetre in 60 slices
    ASSERT_TRUE(read_volume(m_folder.write("a.nrrd", file.bytes()), {}, &notes).ok());
    EXPECT_EQ(notes.notes,
              std::vector<std::string>{"axes lean by 0.0458366 degrees; taken as perpendicular"});
    file.directions = "(0.57735,0.57735,0.57735) (0.70711,-0.70711,0) (0.40825,0.40825,-0.8165)";
    ASSERT_TRUE(read_volume(m_folder.write("b.nrrd", file.bytes()), {}, &notes).ok());
    EXPECT_EQ(notes.notes, std::vector<std::string>{});
}

TEST_F(Headers, ImagesLargerThanTheMemoryAreRefused) {
    // 64 MB of memory. Compressed data that could be as long as the header says, but aren't.
    m_folder.write("machine/proc/meminfo", "MemAvailable: 65536 kB\n");
    const MemorySources small{m_folder / "machine", kUnlimited};
    std::string noise;
    for (unsigned n = 0, x = 1; n < 400000; ++n, x = x * 1103515245u + 12345u)
        noise += char(x >> 16);
    NrrdFile nrrd;
    nrrd.type = "uchar";
    nrrd.sizes = "500 500 500";
    nrrd.encoding = "gzip";
    nrrd.data = test::gzipped(noise);
    test::NiftiFile nifti;
    nifti.dim = {3, 500, 500, 500, 1, 1, 1, 1};
    nifti.slope = 2;
    nifti.data = noise;
    const std::string packed_nifti = test::gzipped(nifti.bytes());
    const UseMemorySources use(small);
    expect_refused("a.nrrd", nrrd.bytes(), "not enough memory");
    expect_refused("a.nii.gz", packed_nifti, "not enough memory");
    nrrd.sizes = "200 100 10";
    EXPECT_TRUE(read("a.nrrd", nrrd.bytes()).ok());
}

TEST_F(Headers, FloatsLargerThanTheMemoryAreRefusedWhenTheFirstComes) {
    // 3 million voxels: 6 MB of 16-bit integers, 12 MB of floats.
    m_folder.write("machine/proc/meminfo", "MemAvailable: 8192 kB\n");
    const MemorySources small{m_folder / "machine", kUnlimited};
    NrrdFile file;
    file.type = "int";
    file.sizes = "300 100 100";
    file.encoding = "gzip";
    std::vector<std::int32_t> values(3000000);
    file.data = test::gzipped(test::packed(values));
    const UseMemorySources use(small);
    EXPECT_TRUE(read("a.nrrd", file.bytes()).ok());
    values[2000000] = 40000;
    file.data = test::gzipped(test::packed(values));
    expect_refused("a.nrrd", file.bytes(), "not enough memory");
}

}  // namespace
}  // namespace pliant
