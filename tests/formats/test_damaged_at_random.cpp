// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files with bytes changed, cut out or cut off anywhere: read or refused in one line, and nothing
// worse.
// Covers: formats/*_header.cpp, formats/nrrd_fields.cpp, formats/read_volume.cpp.

#include "support/damaged_scan.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <random>

namespace pliant {
namespace {

using test::damaged;
using test::expect_one_line_or_a_sound_volume;

class DamagedAtRandom : public testing::Test {
  protected:
    /// Writes a new file each time: file systems flush files that replace old ones early.
    std::filesystem::path write_anew(const std::string& name, const std::string& bytes) const {
        std::filesystem::remove(m_folder.path() / name);
        return m_folder.write(name, bytes);
    }
    void read_many(const std::string& name, const std::string& good, int count) {
        std::mt19937 random(m_seed);
        testing::internal::CaptureStderr();
        for (int n = 0; n < count; ++n)
            expect_one_line_or_a_sound_volume(read_volume(write_anew(name, damaged(good, random))));
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << name << ", seed " << m_seed;
    }
    unsigned m_seed = 4711;
    test::TemporaryFolder m_folder;
};

TEST_F(DamagedAtRandom, NrrdFilesDoNoHarm) {
    test::NrrdFile file;
    file.extra = "key:=value\nspace units: \"mm\" \"mm\" \"mm\"\n";
    read_many("a.nrrd", file.bytes(), 300);
    file.encoding = "gzip";
    file.data = test::gzipped(file.data);
    read_many("b.nrrd", file.bytes(), 300);
}

TEST_F(DamagedAtRandom, MetaImageFilesDoNoHarm) {
    test::MetaFile file;
    read_many("a.mha", file.bytes(), 300);
    file.data = test::zlibbed(file.data);
    file.extra = "CompressedData = True\n";
    read_many("b.mha", file.bytes(), 300);
}

TEST_F(DamagedAtRandom, NiftiFilesDoNoHarm) {
    read_many("a.nii", test::NiftiFile().bytes(), 300);
    test::NiftiFile file;
    file.big_endian = true;
    file.qform_code = 1;
    read_many("c.nii", file.bytes(), 300);
    read_many("b.nii.gz", test::gzipped(test::NiftiFile().bytes()), 300);
}

TEST_F(DamagedAtRandom, HeadersOfDataInOtherFilesDoNoHarm) {
    test::NrrdFile nrrd;
    m_folder.write("s1.raw", nrrd.data.substr(0, 24));
    m_folder.write("s2.raw", nrrd.data.substr(24));
    nrrd.blank_line = false;
    test::MetaFile meta;
    meta.data = "";
    for (const char* files : {"LIST\ns1.raw\ns2.raw", "s%d.raw 1 2 1"}) {
        nrrd.extra = std::string("data file: ") + files + "\n";
        read_many("a.nhdr", nrrd.bytes(), 300);
        meta.data_file = files;
        read_many("a.mhd", meta.bytes(), 600);
    }
}

TEST_F(DamagedAtRandom, DicomFilesDoNoHarm) {
    std::mt19937 random(m_seed);
    test::DicomFile first, second;
    second.position[2] = 1;
    m_folder.write("series/1.dcm", first.bytes());
    testing::internal::CaptureStderr();
    for (int n = 0; n < 500; ++n) {
        second.implicit = n % 2 == 1;
        write_anew("series/2.dcm", damaged(second.bytes(), random));
        expect_one_line_or_a_sound_volume(read_volume(m_folder.path() / "series"));
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "seed " << m_seed;
}

}  // namespace
}  // namespace pliant
