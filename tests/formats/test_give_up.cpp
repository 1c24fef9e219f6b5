// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reading and writing that are given up, and how far they say they are.
// Covers: formats/data_stream.cpp, writers/write_volume.cpp.

#include <gtest/gtest.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include "support/scan_files.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

/// A compressed scan of some pieces, and a series of four slices.
class GiveUp : public ::testing::TestWithParam<bool> {
  protected:
    void SetUp() override {
        Volume volume;
        volume.grid.size = {128, 128, 64};
        volume.voxels = std::vector<std::int16_t>(128 * 128 * 64, 7);
        ASSERT_TRUE(write_volume(m_folder / "scan.nrrd", volume).ok());
        for (int n = 0; n < 4; ++n) {
            DicomFile slice;
            slice.position[2] = n;
            m_folder.write("series/" + std::to_string(n), slice.bytes());
        }
    }
    std::filesystem::path file() const { return m_folder / (GetParam() ? "series" : "scan.nrrd"); }

    TemporaryFolder m_folder;
};

TEST_P(GiveUp, EndsTheReadingAtTheNextPiece) {
    for (const int most : {0, 1, 3}) {
        int asked = 0;
        ReadOptions options;
        options.give_up = [&] { return asked++ == most; };
        const auto volume = read_volume(file(), options);
        ASSERT_FALSE(volume.ok());
        EXPECT_EQ(volume.error().code, ErrorCode::LimitExceeded);
        EXPECT_EQ(volume.error().message, file().string() + ": the reading was given up");
        EXPECT_EQ(asked, most + 1);
    }
}

TEST_P(GiveUp, ProgressGrowsFromZeroToLessThanOne) {
    std::vector<double> fractions;
    ReadOptions options;
    options.progress = [&](double fraction) { fractions.push_back(fraction); };
    options.give_up = [] { return false; };
    ASSERT_TRUE(read_volume(file(), options).ok());
    ASSERT_GE(fractions.size(), 4U);
    EXPECT_EQ(fractions.front(), 0);
    EXPECT_LT(fractions.back(), 1);
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
}

TEST(GiveUpWriting, LeavesNoFile) {
    const TemporaryFolder folder;
    Volume volume;
    volume.grid.size = {128, 128, 64};
    volume.voxels = std::vector<std::int16_t>(128 * 128 * 64, 7);
    const VectorField field{volume.grid, FieldKind::Modeling,
                            std::vector<Vec3f>(voxel_count(volume.grid))};
    for (const std::string name : {"a.nrrd", "a.mha", "a.nii.gz", "field.nrrd", "field.nii"}) {
        SCOPED_TRACE(name);
        int asked = 0;
        const std::function<bool()> give_up = [&] { return asked++ == 3; };
        const auto path = folder / name;
        const Status done = name.starts_with("field")
                                ? write_vector_field(path, field, Encoding::Gzip, give_up)
                                : write_volume(path, volume, Encoding::Gzip, give_up);
        ASSERT_FALSE(done.ok());
        EXPECT_EQ(done.error().code, ErrorCode::LimitExceeded);
        EXPECT_EQ(asked, 4);
        EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, GiveUp, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "Dicom" : "Nrrd"; });

}  // namespace
}  // namespace pliant::test
