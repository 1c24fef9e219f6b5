// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps from files, and the layers of 3D Slicer's segmentations.

#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

namespace pliant {
namespace {

using test::NrrdFile;
using test::packed;

NrrdFile layers() {
    NrrdFile file;
    file.dimension = "4";
    file.sizes = "2 4 3 2";
    file.kinds = "list domain domain domain";
    file.directions = "none (1,0,0) (0,1,0) (0,0,2)";
    file.type = "uchar";
    file.data.clear();
    for (int n = 0; n < 24; ++n) file.data += {char(n % 3), char(n % 2)};
    for (const char* line : {"Segment0_Name:=liver", "Segment0_LabelValue:=1", "Segment0_Layer:=0",
                             "Segment1_Name:=spleen", "Segment1_LabelValue:=2", "Segment1_Layer:=0",
                             "Segment2_Name:=tumour", "Segment2_LabelValue:=1", "Segment2_Layer:=1",
                             "Segmentation_MasterRepresentation:=Binary labelmap"})
        file.extra += line + std::string("\n");
    return file;
}

TEST(LabelLayers, AreChosenBehindTheNameAndHaveTheirOwnNames) {
    const test::TemporaryFolder folder;
    const auto path = folder.write("over.seg.nrrd", layers().bytes());
    const auto unchosen = read_labels(path);
    ASSERT_FALSE(unchosen.ok());
    EXPECT_EQ(unchosen.error().message,
              path.string() +
                  ": holds 2 layers of labels, choose one: over.seg.nrrd#0 (liver, spleen), "
                  "over.seg.nrrd#1 (tumour)");
    const auto beyond = read_labels(path.string() + "#2");
    ASSERT_FALSE(beyond.ok());
    EXPECT_EQ(beyond.error().message, path.string() + ": found layer 2, expected 0…1");
    const auto first = read_labels(path.string() + "#0"),
               second = read_labels(path.string() + "#1");
    ASSERT_TRUE(first.ok() && second.ok());
    for (int n = 0; n < 24; ++n) {
        EXPECT_EQ(std::get<0>(first->voxels)[std::size_t(n)], n % 3);
        EXPECT_EQ(std::get<0>(second->voxels)[std::size_t(n)], n % 2);
    }
    EXPECT_EQ(second->key_values,
              (KeyValues{{"Segment2_Name", "tumour"},
                         {"Segment2_LabelValue", "1"},
                         {"Segment2_Layer", "0"},
                         {"Segmentation_MasterRepresentation", "Binary labelmap"}}));
    EXPECT_EQ(first->key_values.size(), 7u);
    // A frame that is written as a file of its own keeps its names.
    const auto frame = read_volume(path, {.frame = 1});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_EQ(frame->key_values, second->key_values);
    ASSERT_TRUE(write_volume(folder / "one.seg.nrrd", *frame).ok());
    const auto one = read_labels(folder / "one.seg.nrrd");
    ASSERT_TRUE(one.ok()) << one.error().message;
    EXPECT_EQ(one->key_values, second->key_values);
    // A file may have such a name.
    std::filesystem::rename(folder / "one.seg.nrrd", folder / "map#1.nrrd");
    EXPECT_TRUE(read_labels(folder / "map#1.nrrd").ok());
    EXPECT_EQ(label_file(folder / "map#1.nrrd"), folder / "map#1.nrrd");
    EXPECT_EQ(label_file(path.string() + "#1"), path);
}

TEST(LabelMaps, AdviceIsAboutTheMap) {
    const test::TemporaryFolder folder;
    NrrdFile file;
    file.directions = "(1,0,0) (0.5,1,0) (0,0,2)";
    const auto path = folder.write("sheared.nrrd", file.bytes());
    const auto sheared = read_labels(path);
    ASSERT_FALSE(sheared.ok());
    EXPECT_EQ(sheared.error().message,
              path.string() +
                  ": its axes are sheared, expected a label map with perpendicular ones, such as "
                  "one resampled to the scan's grid");
    file = {};
    file.type = "float";
    file.data = packed(std::vector<float>(24, 1.5f));
    const auto odd = read_labels(folder.write("odd.nrrd", file.bytes()));
    ASSERT_FALSE(odd.ok());
    EXPECT_EQ(odd.error().message, (folder / "odd.nrrd").string() +
                                       ": expected a label map of whole numbers, found 1.5");
    EXPECT_EQ(read_labels(folder / "none.nrrd").error().code, ErrorCode::NotFound);
    EXPECT_NE(read_labels(folder.write("e.nrrd", "")).error().message.find("is empty"),
              std::string::npos);
}

}  // namespace
}  // namespace pliant
