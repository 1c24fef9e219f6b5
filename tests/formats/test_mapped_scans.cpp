// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mapped scans, and scans with an offset that prevents mapping: their values are those of the file.
// Covers: formats/read_volume.cpp, volume/voxel_memory.cpp.

#include "support/random.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace pliant {
namespace {

namespace fs = std::filesystem;

const Vec3i kMappedSize{90, 81, 77};  // above 1 MiB as 16-bit integers
constexpr std::size_t kCount = 90 * 81 * 77;

/// Whether a file is mapped into this process.
bool is_mapped(const fs::path& file) {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);)
        if (line.ends_with(file.string())) return true;
    return false;
}

/// Values of every kind, 16-bit integers or floats.
std::string random_data(test::Random& random, bool narrow) {
    std::vector<std::int16_t> shorts(narrow ? kCount : 0);
    for (auto& value : shorts) value = std::int16_t(random.whole(-32768, 32767));
    std::vector<float> floats(narrow ? 0 : kCount);
    for (auto& value : floats) value = float(random.real(-1000, 3000));
    return narrow ? test::packed(shorts) : test::packed(floats);
}

std::string text_of(Vec3d v, const char* separator) {
    return std::to_string(v.x) + separator + std::to_string(v.y) + separator + std::to_string(v.z);
}

std::string nrrd(test::Random& random, bool narrow, const std::string& data) {
    test::NrrdFile file;
    const Mat3d m = random.rotation(random.whole(0, 1) == 1);
    file.type = narrow ? "short" : "float";
    file.sizes = "90 81 77";
    file.space = random.whole(0, 1) ? "left-posterior-superior" : "right-anterior-superior";
    file.directions = "";
    for (std::size_t a = 0; a < 3; ++a)
        file.directions += "(" + text_of(random.real(0.3, 3) * m.columns[a], ",") + ") ";
    file.origin = "(" + text_of(random.vector(300), ",") + ")";
    file.extra = "#" + std::string(std::size_t(random.whole(0, 7)), ' ') + "\n";  // any alignment
    file.data = data;
    return file.bytes();
}

std::string meta(test::Random& random, bool narrow, const std::string& data) {
    test::MetaFile file;
    const Mat3d m = random.rotation(random.whole(0, 1) == 1);
    file.type = narrow ? "MET_SHORT" : "MET_FLOAT";
    file.sizes = "90 81 77";
    file.spacing = "0.5 1 " + std::to_string(random.real(0.5, 2));
    file.matrix = "";
    for (const Vec3d& column : m.columns) file.matrix += text_of(column, " ") + " ";
    file.extra = "Comment = " + std::string(std::size_t(random.whole(1, 8)), 'c') + "\n";
    file.data = data;
    return file.bytes();
}

std::string nifti(test::Random& random, bool narrow, const std::string& data) {
    test::NiftiFile file;
    file.dim = {3, 90, 81, 77, 1, 1, 1, 1};
    file.datatype = narrow ? 4 : 16;
    file.bitpix = narrow ? 16 : 32;
    file.slope = float(random.whole(0, 1));
    file.data = data;
    const Mat3d m = random.rotation(random.whole(0, 1) == 1);
    for (std::size_t n = 0; n < 12; ++n)
        file.sform[n] = n % 4 == 3 ? float(random.real(-200, 200))
                                   : float(m.columns[n % 4][int(n / 4)] * file.pixdim[n % 4 + 1]);
    return file.bytes();
}

template <class T>
void expect_values(const Volume& volume, const std::string& data) {
    const auto* voxels = std::get_if<VoxelArray<T>>(&volume.voxels);
    ASSERT_TRUE(voxels && voxels->size() == kCount);
    EXPECT_EQ(std::memcmp(voxels->data(), data.data(), data.size()), 0);
}

TEST(MappedScans, AreWhatTheFilesHold) {
    const std::uint64_t seed = 20262;
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const test::TemporaryFolder folder;
    int mapped = 0, scans = 0;
    using Maker = std::string (*)(test::Random&, bool, const std::string&);
    const std::pair<const char*, Maker> makers[] = {
        {".nrrd", nrrd}, {".mha", meta}, {".nii", nifti}};
    for (const auto& [ending, make] : makers)
        for (int n = 0; n < 6; ++n) {
            const bool narrow = n % 2 == 0;
            const std::string data = random_data(random, narrow);
            const auto path = folder.write(std::to_string(n) + ending, make(random, narrow, data));
            const auto volume = read_volume(path);
            ASSERT_TRUE(volume.ok()) << volume.error().message;
            EXPECT_EQ(volume->grid.size, kMappedSize);
            mapped += is_mapped(path);
            ++scans;
            if (narrow)
                expect_values<std::int16_t>(*volume, data);
            else
                expect_values<float>(*volume, data);
        }
    EXPECT_GT(mapped, scans / 4) << "aligned ones should be mapped";
    EXPECT_LT(mapped, scans) << "none was at an odd place: the test is too weak";
}

TEST(MappedScans, AreThoseThatLieInTheFileAsInMemory) {
    const test::TemporaryFolder folder;
    test::Random random(7);
    const std::string data = random_data(random, true);
    const auto mapped = [&](const char* name, const std::string& bytes,
                            const fs::path& beside = {}) {
        const auto path = folder.write(name, bytes);
        const auto volume = read_volume(path);
        EXPECT_TRUE(volume.ok()) << volume.error().message;
        return is_mapped(beside.empty() ? path : beside);
    };
    test::NrrdFile file;
    file.sizes = "90 81 77";
    file.blank_line = false;
    file.data = "";
    const auto raw = folder.write("data.raw", "ab" + data);
    file.extra = "byte skip: 2\ndata file: data.raw\n";
    EXPECT_TRUE(mapped("skip.nhdr", file.bytes(), raw));
    file.extra = "byte skip: -1\ndata file: data.raw\n";
    EXPECT_TRUE(mapped("end.nhdr", file.bytes(), raw));
    file.endian = "big";
    EXPECT_FALSE(mapped("big.nhdr", file.bytes(), raw));
    test::MetaFile header;
    header.sizes = "90 81 77";
    header.data = "";
    header.data_file = "data.raw";
    header.extra = "HeaderSize = -1\n";
    EXPECT_TRUE(mapped("end.mhd", header.bytes(), raw));
    test::NiftiFile nifti_file;
    nifti_file.dim = {3, 90, 81, 77, 1, 1, 1, 1};
    nifti_file.data = data;
    EXPECT_TRUE(mapped("plain.nii", nifti_file.bytes()));
    nifti_file.slope = 2;
    EXPECT_FALSE(mapped("scaled.nii", nifti_file.bytes()));
}

TEST(MappedScans, FloatsThatAreNotFiniteBecomeAir) {
    const test::TemporaryFolder folder;
    std::vector<float> values(kCount, 0.5f);
    values[5] = std::numeric_limits<float>::quiet_NaN();
    values[kCount - 1] = std::numeric_limits<float>::infinity();
    test::NiftiFile file;
    file.dim = {3, 90, 81, 77, 1, 1, 1, 1};
    file.datatype = 16;
    file.bitpix = 32;
    file.data = test::packed(values);
    ReadNotes notes;
    const auto path = folder.write("a.nii", file.bytes());
    const auto volume = read_volume(path, {}, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_TRUE(is_mapped(path));
    EXPECT_EQ(volume->at({5, 0, 0}), float(kAirHu));
    EXPECT_EQ(volume->at({89, 80, 76}), float(kAirHu));
    EXPECT_EQ(volume->at({6, 0, 0}), 0.5f);
    EXPECT_EQ(notes.notes, std::vector<std::string>{"2 voxels had no finite value and became air"});
}

TEST(MappedScans, FloatsThatAreWholeNumbersBecome16BitIntegers) {
    const test::TemporaryFolder folder;
    std::vector<float> values(kCount);
    for (std::size_t n = 0; n < kCount; ++n) values[n] = float(n % 4000) - 1000;
    test::NrrdFile file;
    file.type = "float";
    file.sizes = "90 81 77";
    file.data = test::packed(values);
    const auto volume = read_volume(folder.write("a.nrrd", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    ASSERT_TRUE(volume->is_16_bit());
    EXPECT_EQ(volume->at({1, 1, 0}), values[91]);
}

TEST(MappedScans, WhatIsWrittenRawIsMappedWhenItIsReadAgain) {
    const test::TemporaryFolder folder;
    Volume volume;
    volume.grid.size = kMappedSize;
    volume.voxels = std::vector<float>(kCount, 1.5f);
    for (int n = 0; n < 5; ++n) {
        volume.key_values = {{"k", std::string(std::size_t(n * 13), 'v')}};
        const auto path = folder.path() / (std::to_string(n) + ".nrrd");
        ASSERT_TRUE(write_volume(path, volume, Encoding::Raw).ok());
        const auto again = read_volume(path);
        ASSERT_TRUE(again.ok()) << again.error().message;
        EXPECT_TRUE(is_mapped(path));
        EXPECT_EQ(again->voxels, volume.voxels);
        // The mapped file may be replaced by a file derived from it.
        ASSERT_TRUE(write_volume(path, *again, Encoding::Raw).ok());
        EXPECT_EQ(again->voxels, volume.voxels);
    }
}

TEST(MappedScans, AFileThatWasCutShortCannotBeWrittenAgain) {
    const test::TemporaryFolder folder;
    Volume volume;
    volume.grid.size = kMappedSize;
    volume.voxels = std::vector<std::int16_t>(kCount, 9);
    const auto path = folder.path() / "a.nrrd";
    ASSERT_TRUE(write_volume(path, volume, Encoding::Raw).ok());
    const auto mapped = read_volume(path);
    ASSERT_TRUE(mapped.ok());
    fs::resize_file(path, 100'000);
    const Status status = write_volume(folder.path() / "b.nrrd", *mapped, Encoding::Raw);
    ASSERT_FALSE(status.ok());
    EXPECT_NE(status.error().message.find("was cut short"), std::string::npos);
    EXPECT_FALSE(fs::exists(folder.path() / "b.nrrd"));
    EXPECT_FALSE(read_volume(path).ok());
}

}  // namespace
}  // namespace pliant
