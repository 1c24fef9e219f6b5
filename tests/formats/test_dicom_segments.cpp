// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Segmentations, label maps, frames of nuclear medicine, and images without positions.
// Covers: formats/dicom_segments.cpp, formats/dicom_header.cpp.

#include "formats/dicom_series.h"
#include "support/damaged_scan.h"
#include "support/dicom_style.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace pliant {
namespace {

using test::DicomFile;
using test::packed;
using test::Style;

constexpr std::uint32_t kPlanePosition = 0x00209113, kPlaneOrientation = 0x00209116,
                        kPixelMeasures = 0x00289110, kPosition = 0x00200032,
                        kOrientation = 0x00200037, kPixelSpacing = 0x00280030,
                        kThickness = 0x00180050, kShared = 0x52009229, kPerFrame = 0x52009230,
                        kSegments = 0x00620002, kSegmentNumber = 0x00620004,
                        kSegmentLabel = 0x00620005, kIdentification = 0x0062000a,
                        kReferenced = 0x0062000b;

/// A frame of a segmentation: 5 × 3 pixels.
struct SegmentFrame {
    double height = 0;
    std::uint16_t segment = 1;
    std::vector<int> pixels = {};
};

std::string groups_of(const std::vector<SegmentFrame>& frames, const Style& s, bool with_segments) {
    const std::string common =
        s.sequence(kPlaneOrientation, {s.decimals(kOrientation, "1\\0\\0\\0\\1\\0")}) +
        s.sequence(kPixelMeasures,
                   {s.decimals(kThickness, "2.5") + s.decimals(kPixelSpacing, "0.5\\0.25")});
    std::vector<std::string> items;
    for (const SegmentFrame& frame : frames) {
        items.push_back(s.sequence(
            kPlanePosition, {s.decimals(kPosition, "10\\20\\" + std::to_string(frame.height))}));
        if (with_segments)
            items.back() += s.sequence(kIdentification, {s.shorts(kReferenced, {frame.segment})});
    }
    return s.sequence(kShared, {common}) + s.sequence(kPerFrame, items);
}

/// Segments 1 "liver" and 2 without a label, in one bit a pixel.
DicomFile segmentation(const std::vector<SegmentFrame>& frames, const Style& s = {}) {
    DicomFile file;
    file.sop_class = "1.2.840.10008.5.1.4.1.1.66.4";
    file.modality = "SEG";
    file.with_position = false;
    file.implicit = s.implicit;
    file.frames = std::to_string(frames.size());
    file.columns = 5;
    file.bits_allocated = file.bits_stored = 1;
    file.high_bit = file.is_signed = 0;
    file.slope = file.intercept = "";
    file.more = s.element(0x00620001, "CS", "BINARY") +
                s.sequence(kSegments,
                           {s.shorts(kSegmentNumber, {1}) + s.element(kSegmentLabel, "LO", "liver"),
                            s.shorts(kSegmentNumber, {2})}) +
                groups_of(frames, s, true);
    std::size_t bit = 0;
    for (const SegmentFrame& frame : frames)
        for (const int pixel : frame.pixels) {
            if (bit % 8 == 0) file.raw += '\0';
            if (pixel) file.raw.back() = char(file.raw.back() | 1 << bit % 8);
            ++bit;
        }
    if (file.raw.size() % 2) file.raw += '\0';
    file.pixel_type = "OB";
    return file;
}

std::string refusal_of(const std::filesystem::path& path, const ReadOptions& options = {}) {
    const auto volume = read_volume(path, options);
    if (volume.ok()) return "was read";
    EXPECT_EQ(volume.error().message.find('\n'), std::string::npos);
    EXPECT_TRUE(volume.error().message.starts_with(path.string())) << volume.error().message;
    return volume.error().message.substr(path.string().size() + 2);
}

TEST(DicomSegments, BitsOfEachFrameAreItsSegmentsNumber) {
    const test::TemporaryFolder folder;
    std::mt19937 random(7);
    for (const bool implicit : {false, true}) {
        const Style s{implicit, implicit};
        // Segment 1 at 3, 6 and 15 mm, segment 2 beside it at 6 mm: 9 and 12 mm are empty.
        std::vector<SegmentFrame> frames = {{6, 2}, {15, 1}, {3, 1}, {6, 1}};
        for (SegmentFrame& frame : frames)
            for (int p = 0; p < 15; ++p) frame.pixels.push_back(int(random() & 1));
        for (std::size_t p = 0; p < 15; ++p)
            if (frames[0].pixels[p]) frames[3].pixels[p] = 0;
        const auto path = folder.write("seg.dcm", segmentation(frames, s).bytes());
        ReadNotes notes;
        const auto volume = read_volume(path, {}, &notes);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->grid.size, (Vec3i{5, 3, 5}));
        EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{0.25, 0.5, 3}));
        EXPECT_EQ(volume->grid.origin_mm, (Vec3d{10, 20, 3}));
        EXPECT_EQ(notes.modality, "SEG");
        for (int p = 0; p < 15; ++p) {
            const auto at = [&](int k) { return int(volume->at({p % 5, p / 5, k})); };
            const auto n = std::size_t(p);
            EXPECT_EQ(at(0), frames[2].pixels[n]);
            EXPECT_EQ(at(1), frames[0].pixels[n] ? 2 : frames[3].pixels[n]);
            EXPECT_EQ(at(2) + at(3), 0);
            EXPECT_EQ(at(4), frames[1].pixels[n]);
        }
        const KeyValues expected = {{"Segment0_LabelValue", "1"},
                                    {"Segment0_Name", "liver"},
                                    {"Segment1_LabelValue", "2"},
                                    {"Segment1_Name", ""}};
        EXPECT_EQ(volume->key_values, expected);
        // A segment alone.
        const auto second = read_volume(path, {.frame = 1});
        ASSERT_TRUE(second.ok()) << second.error().message;
        for (int p = 0; p < 15; ++p)
            EXPECT_EQ(second->at({p % 5, p / 5, 1}), 2 * frames[0].pixels[std::size_t(p)]);
        EXPECT_EQ(read_volume(path, {.frame = 2}).error().message,
                  "--frame: found 2, expected 0…1 for " + path.string());
    }
}

TEST(DicomSegments, OverlappingOnesAreChosen) {
    const test::TemporaryFolder folder;
    const std::vector<int> all(15, 1);
    const auto path = folder.write("seg.dcm", segmentation({{0, 1, all}, {0, 2, all}}).bytes());
    EXPECT_EQ(
        refusal_of(path),
        "its segments 1 (liver) and 2 overlap in 15 voxels, choose one of 2 by pliant convert "
        "with --frame 0…1");
    const auto second = read_volume(path, {.frame = 1});
    ASSERT_TRUE(second.ok()) << second.error().message;
    EXPECT_EQ(second->at({4, 2, 0}), 2);
    EXPECT_EQ(second->grid.spacing_mm.z, 2.5);
    EXPECT_EQ(count_dicom_volumes(path, "").value(), 2);
}

TEST(DicomSegments, LabelMapsHaveNumbersAndGaps) {
    const test::TemporaryFolder folder;
    DicomFile file = segmentation({{3}, {0}, {9}});
    file.sop_class = "1.2.840.10008.5.1.4.1.1.66.7";
    file.photometric = "PALETTE COLOR";
    file.bits_allocated = file.bits_stored = 8;
    file.high_bit = 7;
    file.raw.clear();
    for (int n = 0; n < 45; ++n) file.raw += char(n + 200 * (n == 44));
    file.raw += '\0';
    const auto volume = read_volume(folder.write("map.dcm", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size, (Vec3i{5, 3, 4}));
    EXPECT_EQ(volume->at({1, 0, 0}), 16);
    EXPECT_EQ(volume->at({1, 0, 1}), 1);
    EXPECT_EQ(volume->at({1, 0, 2}), 0);
    EXPECT_EQ(volume->at({4, 2, 3}), 244);
    EXPECT_EQ(volume->key_values[1].second, "liver");
}

TEST(DicomSegments, OtherOnesAreRefusedInOneLine) {
    const test::TemporaryFolder folder;
    const std::vector<SegmentFrame> two = {{0, 1, std::vector<int>(15, 1)},
                                           {1, 1, std::vector<int>(15, 1)}};
    const auto refused = [&](const std::function<void(DicomFile&)>& change,
                             const std::string& expected) {
        DicomFile file = segmentation(two);
        change(file);
        const std::string error = refusal_of(folder.write("seg.dcm", file.bytes()));
        EXPECT_NE(error.find(expected), error.npos) << error << "\nexpected: " << expected;
    };
    refused([](auto& f) { f.more.replace(f.more.find("BINARY"), 6, "FRACTI"); },
            "is a segmentation object of type FRACTI, expected BINARY or a label map");
    refused([](auto& f) { f.frames = "3"; }, "has functional groups of 2 frames, expected 3");
    refused([](auto& f) { f.raw.resize(2); }, "has 2 bytes of pixels, expected 4");
    refused([](auto& f) { f.bits_allocated = f.bits_stored = 8, f.high_bit = 7, f.raw.resize(30); },
            "stores 8 bits a pixel, expected 1 without compression");
    refused([](auto& f) { f.rows = 0; }, "is DICOM without an image");
    refused(
        [&](auto& f) {
            const auto at = f.more.rfind("1.000000");
            f.more.replace(at, 8, "9.000e99");
        },
        "origin is");
    // Beside images the file isn't one.
    DicomFile image;
    folder.write("ct/1.dcm", image.bytes());
    image.position[2] = 1;
    folder.write("ct/2.dcm", image.bytes());
    DicomFile labels = segmentation(two);
    labels.series = "7.7";
    folder.write("ct/seg.dcm", labels.bytes());
    ReadNotes notes;
    const auto volume = read_volume(folder / "ct", {}, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    ASSERT_EQ(notes.notes.size(), 1u);
    EXPECT_NE(notes.notes[0].find("as labels, name the file itself: --labels FILE"),
              std::string::npos);
}

TEST(DicomSegments, DamagedFilesDoNoHarm) {
    const std::vector<int> all(15, 1);
    for (const bool known_lengths : {false, true})
        test::read_damaged("seg.dcm",
                           segmentation({{0, 1, all}, {4, 2, all}}, {false, known_lengths}).bytes(),
                           200);
}

/// Frames of nuclear medicine: slices at the given distance, in two time slots.
DicomFile nuclear(double step_mm, bool projections) {
    const Style s;
    DicomFile file;
    file.sop_class = "1.2.840.10008.5.1.4.1.1.20";
    file.modality = "NM";
    file.with_position = false;
    file.with_orientation = false;
    file.is_signed = 0;
    file.intercept = "0";
    file.frames = "6";
    const std::string pointers = packed<std::uint16_t>(
        {0x0054, std::uint16_t(projections ? 0x0090 : 0x0070), 0x0054, 0x0080});
    file.more =
        s.element(0x00280009, "AT", pointers) + s.decimals(0x00180088, std::to_string(step_mm)) +
        s.sequence(0x00540022,
                   {s.decimals(kPosition, "1\\2\\3") + s.decimals(kOrientation, "1\\0\\0\\0\\1\\0"),
                    s.decimals(kPosition, "9\\9\\9")}) +
        s.shorts(0x00540070, {1, 1, 1, 2, 2, 2}) + s.shorts(0x00540080, {1, 2, 3, 1, 2, 3});
    file.pixels.clear();
    for (int n = 0; n < 72; ++n) file.pixels.push_back(std::int16_t(n / 12));
    return file;
}

TEST(DicomFrames, OfNuclearMedicineArePlacedByTheDetector) {
    const test::TemporaryFolder folder;
    for (const double step : {2.0, -2.0}) {
        const auto path = folder.write("nm.dcm", nuclear(step, false).bytes());
        EXPECT_EQ(refusal_of(path), "holds 2 images, choose one with --frame 0…1");
        const auto volume = read_volume(path, {.frame = 1});
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 3}));
        EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{0.25, 0.5, 2}));
        EXPECT_EQ(volume->grid.origin_mm, (Vec3d{1, 2, step > 0 ? 3.0 : -1.0}));
        for (int k = 0; k < 3; ++k) EXPECT_EQ(volume->at({0, 0, k}), step > 0 ? 3 + k : 5 - k);
    }
    const auto path = folder.write("nm.dcm", nuclear(2, true).bytes());
    EXPECT_NE(refusal_of(path).find("frames without a position for each"), std::string::npos);
}

TEST(DicomSlices, WithoutPositionsAreStackedByTheGivenSpacing) {
    const test::TemporaryFolder folder;
    DicomFile slice;
    slice.with_position = false;
    for (int n = 0; n < 12; ++n) {
        slice.instance_number = std::to_string(n + 1);
        slice.instance = "5.5." + slice.instance_number;
        slice.pixels.assign(12, std::int16_t(1000 + n));
        folder.write(std::to_string(n), slice.bytes());
    }
    folder.write("copy", slice.bytes());
    EXPECT_NE(refusal_of(folder.path())
                  .find("has no usable Image Position (Patient), expected one, or "
                        "--spacing X,Y,Z"),
              std::string::npos);
    ReadNotes notes;
    const ReadOptions options{.spacing_mm = Vec3d{0.3, 0.4, 0.5}};
    const auto volume = read_volume(folder.path(), options, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 12}));
    EXPECT_LT(norm(volume->grid.spacing_mm - Vec3d{0.3, 0.4, 0.5}), 1e-12);
    EXPECT_EQ(volume->grid.direction, kIdentity3);
    for (int k = 0; k < 12; ++k) EXPECT_EQ(volume->at({0, 0, k}), k);
    ASSERT_EQ(notes.notes.size(), 2u);
    EXPECT_TRUE(notes.notes[0].starts_with("1 copy of slices left out"));
    EXPECT_TRUE(notes.notes[1].starts_with("no positions: 12 slices are stacked"));
    slice.instance = "5.5.99";
    folder.write("copy", slice.bytes());
    EXPECT_NE(refusal_of(folder.path(), options).find("no different Instance Numbers"),
              std::string::npos);
    // Frames have an order of their own.
    DicomFile frames;
    frames.with_position = false;
    frames.frames = "3";
    frames.pixels.clear();
    for (int n = 0; n < 36; ++n) frames.pixels.push_back(std::int16_t(1000 + n / 12));
    const auto file = folder.write("frames/a.dcm", frames.bytes());
    EXPECT_NE(refusal_of(file).find("--spacing X,Y,Z"), std::string::npos);
    const auto stack = read_volume(file, options);
    ASSERT_TRUE(stack.ok()) << stack.error().message;
    EXPECT_EQ(stack->grid.size.z, 3);
    EXPECT_EQ(stack->at({3, 2, 2}), 2);
    // Others have their own spacing.
    frames.frames = {};
    frames.with_position = true;
    frames.pixels.resize(12);
    folder.write("own/a.dcm", frames.bytes());
    EXPECT_EQ(read_volume(folder / "own", options).error().message,
              "--spacing: expected none for " + (folder / "own").string() + ", which has its own");
}

}  // namespace
}  // namespace pliant
