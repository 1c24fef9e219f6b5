// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: writers/nrrd_writer.cpp, writers/write_volume.cpp.

#include "base/byte_order.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <random>

namespace pliant {
namespace {

namespace fs = std::filesystem;

Grid odd_grid() {
    const Vec3d k = normalized({0.1, -0.2, 0.97});
    const Vec3d i = normalized(cross({0.3, 1, 0}, k));
    return {{6, 5, 4}, {0.1, 1.0 / 3, 2.7}, {-100.1, 1e-3, 1234.5678}, {{i, cross(k, i), -k}}};
}

Volume random_volume(bool narrow, unsigned seed) {
    std::mt19937 random(seed);
    Volume volume;
    volume.grid = odd_grid();
    volume.key_values = {{"modality", "CT"}, {"two lines", "one\ntwo \\ three"}, {"z", "1 2 3"}};
    std::uniform_int_distribution<int> whole(-32768, 32767);
    if (narrow) {
        auto& voxels = volume.voxels.emplace<0>(std::size_t(120));
        for (std::int16_t& voxel : voxels) voxel = std::int16_t(whole(random));
    } else {
        auto& voxels = volume.voxels.emplace<1>(std::size_t(120));
        for (float& voxel : voxels) voxel = float(whole(random)) / 7;
    }
    return volume;
}

std::string header_of(const fs::path& path) {
    const std::string bytes = test::bytes_of(path);
    return bytes.substr(0, bytes.find("\n\n") + 1);
}

void expect_close(const Grid& found, const Grid& expected) {
    EXPECT_EQ(found.size, expected.size);
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(found.spacing_mm[a], expected.spacing_mm[a], 1e-12 * expected.spacing_mm[a]);
        EXPECT_EQ(found.origin_mm[a], expected.origin_mm[a]);
        EXPECT_LT(norm(found.direction.columns[a] - expected.direction.columns[a]), 1e-12);
    }
}

TEST(WriteVolume, EverythingComesBackAsItWas) {
    const test::TemporaryFolder folder;
    for (const bool narrow : {true, false})
        for (const auto encoding : {Encoding::Gzip, Encoding::Raw})
            for (const char* name : {"a.nrrd", "a.nhdr"}) {
                const Volume volume = random_volume(narrow, 7);
                const fs::path path = folder.path() / name;
                const Status status = write_volume(path, volume, encoding);
                ASSERT_TRUE(status.ok()) << status.error().message;
                ReadNotes notes;
                const auto again = read_volume(path, {}, &notes);
                ASSERT_TRUE(again.ok()) << again.error().message;
                expect_close(again->grid, volume.grid);
                EXPECT_EQ(again->voxels, volume.voxels);
                EXPECT_EQ(again->key_values, volume.key_values);
                EXPECT_TRUE(notes.notes.empty());
            }
}

TEST(WriteVolume, WritingWhatWasReadChangesNothingMore) {
    const test::TemporaryFolder folder;
    const fs::path first = folder.path() / "a.nrrd", second = folder.path() / "b.nrrd";
    test::NrrdFile file;
    file.extra = "zebra:=last\ncontent: of the file\napple:=first\nempty:=\nNRRD_kinds[0]:=list\n";
    folder.write("a.nrrd", file.bytes());
    const auto once = read_volume(first);
    ASSERT_TRUE(once.ok()) << once.error().message;
    EXPECT_EQ(once->key_values, (KeyValues{{"zebra", "last"}, {"apple", "first"}, {"empty", ""}}));
    ASSERT_TRUE(write_volume(second, *once).ok());
    const auto twice = read_volume(second);
    ASSERT_TRUE(twice.ok()) << twice.error().message;
    EXPECT_EQ(twice->key_values, once->key_values);
    EXPECT_EQ(twice->grid, once->grid);
    EXPECT_EQ(twice->voxels, once->voxels);
    ASSERT_TRUE(write_volume(first, *twice).ok());
    EXPECT_EQ(test::bytes_of(first), test::bytes_of(second));
}

TEST(WriteVolume, TheHeaderIsWhatOtherProgramsExpect) {
    const test::TemporaryFolder folder;
    Volume volume = random_volume(true, 1);
    volume.grid = {{6, 5, 4}, {0.5, 1, 2}, {10, -20, 30.25}, {{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}}};
    ASSERT_TRUE(write_volume(folder.path() / "a.nrrd", volume, Encoding::Raw).ok());
    const std::string header = header_of(folder.path() / "a.nrrd");
    for (const char* line :
         {"NRRD000", "\ntype: short\n", "\ndimension: 3\n", "\nspace: left-posterior-superior\n",
          "\nsizes: 6 5 4\n", "\nspace directions: (-0.5,0,0) (0,0,1) (0,2,0)\n",
          "\nkinds: domain domain domain\n",
          kIsBigEndian ? "\nendian: big\n" : "\nendian: little\n", "\nencoding: raw\n",
          "\nspace origin: (10,-20,30.25)\n", "\nmodality:=CT\n"})
        EXPECT_NE(header.find(line), header.npos) << line << "missing in\n" << header;
}

TEST(WriteVolume, ADetachedHeaderNamesTheDataBesideIt) {
    const test::TemporaryFolder folder;
    ASSERT_TRUE(write_volume(folder.path() / "a.nhdr", random_volume(true, 1), Encoding::Raw).ok());
    EXPECT_NE(test::bytes_of(folder.path() / "a.nhdr").find("\ndata file: a.raw\n"),
              std::string::npos);
    EXPECT_EQ(fs::file_size(folder.path() / "a.raw"), 240u);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2);
}

TEST(WriteVolume, WhatCannotBeWrittenLeavesNothingBehind) {
    const test::TemporaryFolder folder;
    const Volume volume = random_volume(true, 1);
    const auto refused = [&](const fs::path& path, const char* expected) {
        const Status status = write_volume(path, volume);
        ASSERT_FALSE(status.ok()) << path;
        EXPECT_TRUE(status.error().message.starts_with(path.string())) << status.error().message;
        EXPECT_NE(status.error().message.find(expected), std::string::npos)
            << status.error().message;
    };
    refused(folder.path() / "a.dcm", "ends in .nrrd, .nhdr");
    refused(folder.path() / "gone/a.nrrd", "does not exist");
    fs::create_directory(folder.path() / "b.nrrd");
    refused(folder.path() / "b.nrrd", "is a folder");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(WriteVolume, ADiskThatIsFullLeavesNothingBehind) {
    const test::TemporaryFolder folder;
    Volume volume;
    volume.grid.size = {100, 100, 100};
    volume.voxels = VoxelArray<std::int16_t>(std::size_t(1'000'000));
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
    rlimit small = limit;
    small.rlim_cur = 500'000;
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    const Status attached = write_volume(folder / "a.nrrd", volume, Encoding::Raw);
    const Status detached = write_volume(folder / "a.nhdr", volume, Encoding::Raw);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    std::signal(SIGXFSZ, handler);
    for (const Status& status : {attached, detached}) {
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().code, ErrorCode::Unwritable);
        EXPECT_TRUE(status.error().message.starts_with((folder / "a.n").string()));
        EXPECT_NE(status.error().message.find(": can't be written ("), std::string::npos)
            << status.error().message;
    }
    EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(WriteVolume, KeysThatNrrdCannotHoldAreLeftOut) {
    const test::TemporaryFolder folder;
    Volume volume = random_volume(true, 3);
    const KeyValues good = volume.key_values;
    volume.key_values.insert(volume.key_values.begin(),
                             {{"", "x"}, {"#c", "x"}, {"a:b", "x"}, {"NRRD_kinds[0]", "x"}});
    ASSERT_TRUE(write_volume(folder / "a.nrrd", volume).ok());
    const auto again = read_volume(folder / "a.nrrd");
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_EQ(again->key_values, good);
}

}  // namespace
}  // namespace pliant
