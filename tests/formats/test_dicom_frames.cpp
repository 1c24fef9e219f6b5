// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// DICOM files of several frames, with functional groups written in every way that the format
// allows: explicit and implicit types, known and unknown lengths, shared or for each frame.
// Covers: formats/dicom_walk.cpp, formats/dicom_syntax.cpp.

#include "support/compressed_dicom.h"
#include "support/damaged_scan.h"
#include "support/dicom_style.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <functional>

namespace pliant {
namespace {

using test::DicomFile;
using test::packed;
using test::Style;

constexpr std::uint32_t kPlanePosition = 0x00209113, kPlaneOrientation = 0x00209116,
                        kPixelMeasures = 0x00289110, kValueTransformation = 0x00289145,
                        kVoiLut = 0x00289132, kCenter = 0x00281050, kWidth = 0x00281051,
                        kPosition = 0x00200032, kOrientation = 0x00200037,
                        kPixelSpacing = 0x00280030, kIntercept = 0x00281052, kSlope = 0x00281053,
                        kShared = 0x52009229, kPerFrame = 0x52009230, kPrivate = 0x2005140f;

std::string value_group(const Style& s, const std::string& slope, const std::string& intercept) {
    return s.sequence(kValueTransformation,
                      {s.decimals(kIntercept, intercept) + s.decimals(kSlope, slope)});
}

/// A file of frames at these heights. Frame n holds 100 n, 100 n + 1, …
DicomFile enhanced(const std::vector<double>& heights, const Style& s, bool all_per_frame) {
    DicomFile file;
    file.sop_class = "1.2.840.10008.5.1.4.1.1.2.1";
    file.with_position = false;
    file.implicit = s.implicit;
    file.frames = std::to_string(heights.size());
    // Values at the top that the groups replace.
    file.orientation = {0, 1, 0, 0, 0, 1};
    file.slope = "7";
    const std::string common =
        s.sequence(kPlaneOrientation, {s.decimals(kOrientation, "1\\0\\0\\0\\1\\0")}) +
        s.sequence(kPixelMeasures, {s.decimals(kPixelSpacing, "0.5\\0.25")}) +
        s.sequence(kVoiLut, {s.decimals(kCenter, "-600") + s.decimals(kWidth, "1500")}) +
        value_group(s, "2", "-1000");
    std::vector<std::string> frames;
    for (const double height : heights) {
        // A private copy of the position, as some writers have, is none.
        frames.push_back(
            s.sequence(kPrivate, {s.decimals(kPosition, "5\\5\\5") + s.decimals(kSlope, "9")}) +
            s.sequence(kPlanePosition,
                       {s.decimals(kPosition, "10\\20\\" + std::to_string(height))}) +
            (all_per_frame ? common : ""));
    }
    file.more = s.sequence(kShared, {all_per_frame ? "" : common}) + s.sequence(kPerFrame, frames);
    file.pixels.clear();
    for (std::size_t n = 0; n < heights.size(); ++n)
        for (int p = 0; p < 12; ++p) file.pixels.push_back(std::int16_t(100 * int(n) + p));
    return file;
}

std::string error_of(const std::filesystem::path& path, const ReadOptions& options = {}) {
    const auto volume = read_volume(path, options);
    EXPECT_FALSE(volume.ok());
    if (volume.ok()) return {};
    EXPECT_EQ(volume.error().message.find('\n'), std::string::npos);
    return volume.error().message;
}

TEST(DicomFrames, AreReadFromFunctionalGroupsOfEveryStyle) {
    const test::TemporaryFolder folder;
    for (const bool implicit : {false, true})
        for (const bool known_lengths : {false, true})
            for (const bool all_per_frame : {false, true}) {
                SCOPED_TRACE(std::to_string(implicit) + std::to_string(known_lengths) +
                             std::to_string(all_per_frame));
                const auto path = folder.write(
                    "a.dcm",
                    enhanced({4, -2, 1}, {implicit, known_lengths}, all_per_frame).bytes());
                ReadNotes notes;
                const auto volume = read_volume(path, {}, &notes);
                ASSERT_TRUE(volume.ok()) << volume.error().message;
                EXPECT_EQ(notes.window, 1500);
                EXPECT_EQ(notes.level, -600);
                EXPECT_EQ(notes.format, "DICOM");
                EXPECT_TRUE(notes.notes.empty());
                EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 3}));
                EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{0.25, 0.5, 3}));
                EXPECT_EQ(volume->grid.origin_mm, (Vec3d{10, 20, -2}));
                EXPECT_EQ(volume->grid.direction, kIdentity3);
                // The second frame is the lowest.
                EXPECT_EQ(volume->at({0, 0, 0}), 2 * 100 - 1000);
                EXPECT_EQ(volume->at({3, 2, 1}), 2 * 211 - 1000);
                EXPECT_EQ(volume->at({1, 0, 2}), 2 * 1 - 1000);
                // The folder of the file is its series.
                const auto same = read_volume(folder.path());
                ASSERT_TRUE(same.ok()) << same.error().message;
                EXPECT_EQ(same->voxels, volume->voxels);
            }
}

TEST(DicomFrames, ValuesAreTransformedFrameByFrame) {
    const test::TemporaryFolder folder;
    const Style s;
    DicomFile file = enhanced({0, 1}, s, false);
    std::vector<std::string> frames;
    for (int n = 0; n < 2; ++n)
        frames.push_back(
            s.sequence(kPlanePosition, {s.decimals(kPosition, n ? "0\\0\\1" : "0\\0\\0")}) +
            value_group(s, n ? "0.5" : "3", n ? "1" : "-5"));
    const std::string shared =
        s.sequence(kPlaneOrientation, {s.decimals(kOrientation, "1\\0\\0\\0\\1\\0")}) +
        s.sequence(kPixelMeasures, {s.decimals(kPixelSpacing, "1\\1")}) + value_group(s, "2", "0");
    file.more = s.sequence(kShared, {shared}) + s.sequence(kPerFrame, frames);
    const auto volume = read_volume(folder.write("a.dcm", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({1, 0, 0}), 3 * 1 - 5);
    EXPECT_EQ(volume->at({1, 0, 1}), 0.5F * 101 + 1);
}

TEST(DicomFrames, OfCompressedPixelsAreDecoded) {
    const test::TemporaryFolder folder;
    for (const test::Codec& codec : test::kCodecs) {
        SCOPED_TRACE(codec.name);
        DicomFile slice = test::compressed(codec);
        slice.intercept = "0";
        folder.write("single/a.dcm", slice.bytes());
        slice.position[2] = 3;
        folder.write("single/b.dcm", slice.bytes());
        const auto single = read_volume(folder / "single");
        ASSERT_TRUE(single.ok()) << single.error().message;
        const Style s;
        DicomFile file = slice;
        const DicomFile groups = enhanced({0, 3, 6}, s, false);
        file.more = groups.more;
        file.frames = "3";
        file.with_position = false;
        file.fragments = {slice.fragments[0], slice.fragments[0], slice.fragments[0]};
        const auto volume = read_volume(folder.write("frames.dcm", file.bytes()));
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        ASSERT_EQ(volume->grid.size, (Vec3i{12, 10, 3}));
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 12; ++i)
                EXPECT_EQ(volume->at({i, 7, k}), 2 * single->at({i, 7, 0}) - 1000);
    }
}

TEST(DicomFrames, FragmentsAreSortedByTheTableOfOffsets) {
    const test::TemporaryFolder folder;
    DicomFile slice = test::compressed("5", "rle", "u16");
    slice.intercept = "0";
    DicomFile file = slice;
    const std::string whole = file.fragments[0];
    const std::string half = whole.substr(0, whole.size() / 4 * 2);
    const std::string rest = whole.substr(half.size());
    file.more = enhanced({0, 3}, {}, false).more;
    file.frames = "2";
    file.with_position = false;
    file.fragments = {half, rest, whole};
    const auto refused = folder.write("a.dcm", file.bytes());
    EXPECT_NE(
        error_of(refused).find("has 3 fragments of 2 compressed frames, expected one each or a "
                               "table of their offsets"),
        std::string::npos);
    // A table of offsets in the first item.
    std::string bytes = file.bytes();
    const std::string empty("\xfe\xff\x00\xe0\0\0\0\0", 8);
    const std::size_t at = bytes.find(empty);
    ASSERT_NE(at, bytes.npos);
    const auto padded = [](const std::string& part) { return part.size() + part.size() % 2; };
    const std::uint32_t second = std::uint32_t(16 + padded(half) + padded(rest));
    bytes.replace(
        at, 8, std::string("\xfe\xff\x00\xe0\x08\0\0\0", 8) + packed<std::uint32_t>({0, second}));
    const auto volume = read_volume(folder.write("a.dcm", bytes));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    for (int i = 0; i < 12; ++i) EXPECT_EQ(volume->at({i, 5, 0}), volume->at({i, 5, 1}));
    const auto single = read_volume(folder.write("single/a.dcm", slice.bytes()).parent_path());
    ASSERT_TRUE(single.ok()) << single.error().message;
    for (int i = 0; i < 12; ++i) EXPECT_EQ(volume->at({i, 5, 0}), 2 * single->at({i, 5, 0}) - 1000);
    // Offsets that don't begin with the first fragment, or leave a frame without one.
    for (const std::uint32_t first : {1U, second}) {
        std::string wrong = bytes;
        wrong.replace(at + 8, 8, packed<std::uint32_t>({first, second}));
        EXPECT_NE(error_of(folder.write("a.dcm", wrong)).find("has 3 fragments"),
                  std::string::npos);
    }
}

TEST(DicomFrames, WhatIsWrongIsSaidInOneLine) {
    const Style s;
    const struct {
        std::function<void(DicomFile&)> change;
        const char* expected;
    } cases[] = {
        {[](auto& f) { f.more = ""; },
         "holds 3 frames without a position for each, expected Per-Frame Functional Groups"},
        {[](auto& f) { f.frames = "4", f.pixels.resize(48); }, "holds 4 frames without a position"},
        {[](auto& f) { f.frames = "none"; }, "holds none frames, expected a number"},
        {[](auto& f) { f.frames = "0"; }, "holds 0 frames, expected a number"},
        {[](auto& f) { f.pixels.pop_back(); }, "has 70 bytes of pixels, expected 72"},
        {[](auto& f) {
             f = enhanced({0, 1, 1}, {}, true);
         },
         "two slices are at the same position: a.dcm frame 2 and a.dcm frame 3"},
        {[](auto& f) {
             f = enhanced({0, 1, 3, 4}, {}, true);
         },
         "slices are missing between a.dcm frame 2 and a.dcm frame 3"},
        {[&](auto& f) {
             f.more = s.sequence(kPerFrame, {"", "", ""});
         },
         "has no usable Image Position (Patient) of frame 1"},
        {[&](auto& f) { f.more.resize(f.more.size() - 20); }, "is damaged or ends early"},
        {[](auto& f) { f.sop_class = "1.2.840.10008.5.1.4.1.1.66.4"; }, "is a segmentation object"},
    };
    const test::TemporaryFolder folder;
    for (const auto& c : cases) {
        DicomFile file = enhanced({0, 1, 2}, s, true);
        c.change(file);
        const auto path = folder.write("a.dcm", file.bytes());
        const std::string message = error_of(path);
        EXPECT_TRUE(message.starts_with(path.string() + ": ")) << message;
        EXPECT_NE(message.find(c.expected), message.npos) << message;
    }
}

/// Elements of group 18 to 3004 in front of the pixels, in explicit types.
std::string element(std::uint32_t tag, const char* type, std::string value) {
    if (value.size() % 2) value += ' ';
    return Style{}.tag(tag) + type + packed<std::uint16_t>({std::uint16_t(value.size())}) + value;
}

constexpr std::uint32_t kSliceSpacing = 0x00180088, kFramePointer = 0x00280009,
                        kFrameOffsets = 0x3004000c;

/// A file of frames without functional groups. Frame n holds 100 n, 100 n + 1, …
DicomFile plain_frames(int frames, const std::string& more) {
    DicomFile file;
    file.frames = std::to_string(frames);
    file.position = {1, 2, 3};
    file.orientation = {0, 1, 0, 0, 0, -1};  // the frames go to -x
    file.intercept = "0";
    file.more = more;
    file.pixels.clear();
    for (int n = 0; n < frames; ++n)
        for (int p = 0; p < 12; ++p) file.pixels.push_back(std::int16_t(100 * n + p));
    return file;
}

TEST(DicomFrames, WithoutFunctionalGroupsGoAlongTheNormal) {
    const test::TemporaryFolder folder;
    const struct {
        std::string more;
        double spacing_mm;
        bool is_noted;
    } cases[] = {
        {element(kSliceSpacing, "DS", "0.4"), 0.4, false},
        {element(kFrameOffsets, "DS", "0\\0.5\\1"), 0.5, false},
        {element(kSliceSpacing, "DS", "9") + element(kFrameOffsets, "DS", "0\\-2\\-4"), 2, false},
        {"", 17, true},  // the thickness
        {element(kFramePointer, "AT", packed<std::uint16_t>({0x3004, 0x000c})) +
             element(kFrameOffsets, "DS", "0\\3\\6"),
         3, false},
    };
    for (const auto& c : cases) {
        SCOPED_TRACE(c.spacing_mm);
        ReadNotes notes;
        const auto path = folder.write("a.dcm", plain_frames(3, c.more).bytes());
        const auto volume = read_volume(path, {}, &notes);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 3}));
        EXPECT_NEAR(volume->grid.spacing_mm.z, c.spacing_mm, 1e-12);
        // Frames that go against the normal are sorted along it.
        const bool is_reversed = c.spacing_mm == 2;
        EXPECT_EQ(volume->grid.direction.columns[2], (Vec3d{-1, 0, 0}));
        EXPECT_NEAR(volume->grid.origin_mm.x, is_reversed ? 5 : 1, 1e-12);
        EXPECT_EQ(volume->at({3, 2, 1}), 111);
        EXPECT_EQ(volume->at({0, 0, 2}), is_reversed ? 0 : 200);
        EXPECT_EQ(notes.notes.size(), c.is_noted ? 1U : 0U);
        if (c.is_noted && notes.notes.size() == 1) {
            EXPECT_EQ(notes.notes[0], "the frames' thickness of 17 mm is taken as their distance");
        }
        const auto same = read_volume(folder.path());
        ASSERT_TRUE(same.ok()) << same.error().message;
        EXPECT_EQ(same->voxels, volume->voxels);
    }
}

TEST(DicomFrames, HundredsOfThemHaveALongVectorOfOffsets) {
    const test::TemporaryFolder folder;
    std::string offsets = "0";
    for (int n = 1; n < 400; ++n) offsets += "\\" + std::to_string(n) + ".00";
    const auto path =
        folder.write("a.dcm", plain_frames(400, element(kFrameOffsets, "DS", offsets)).bytes());
    const auto volume = read_volume(path);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size.z, 400);
    EXPECT_EQ(volume->grid.spacing_mm.z, 1);
}

TEST(DicomFrames, ThatAreNoSlicesAreRefused) {
    const test::TemporaryFolder folder;
    const auto refused = [&](const DicomFile& file) {
        return error_of(folder.write("a.dcm", file.bytes()));
    };
    const std::string unplaced = "a.dcm: holds 3 frames without a position for each";
    // The offsets of too few frames, those that are coordinates, and frames in time.
    for (const std::string& more :
         {element(kFrameOffsets, "DS", "0\\1"), element(kFrameOffsets, "DS", "3\\4\\5"),
          element(kFramePointer, "AT", packed<std::uint16_t>({0x0018, 0x1063})) +
              element(kSliceSpacing, "DS", "1")})
        EXPECT_NE(refused(plain_frames(3, more)).find(unplaced), std::string::npos)
            << refused(plain_frames(3, more));
    DicomFile many = plain_frames(3, element(kSliceSpacing, "DS", "1"));
    many.frames = "2000000000";
    EXPECT_NE(refused(many).find("holds 2000000000 frames without"), std::string::npos);
    DicomFile far = plain_frames(3, element(kSliceSpacing, "DS", "1e300"));
    EXPECT_FALSE(refused(far).empty());
    for (const char* kind : {"12.1", "12.1.1", "12.2", "12.2.1"}) {
        DicomFile cine = plain_frames(3, "");
        cine.sop_class = std::string("1.2.840.10008.5.1.4.1.1.") + kind;
        EXPECT_NE(
            refused(cine).find("a.dcm: holds X-ray projections (angiography or fluoroscopy, 3 "
                               "frames), expected the slices of a volume"),
            std::string::npos);
    }
}

constexpr std::uint32_t kFrameContent = 0x00209111, kTemporalIndex = 0x00209128,
                        kDimensionIndices = 0x00209157;

std::string longs(const Style& s, std::uint32_t t, const std::vector<std::uint32_t>& numbers) {
    const std::string value = packed(numbers);
    if (s.implicit) return s.tag(t) + Style::u32(value.size()) + value;
    return s.tag(t) + "UL" + packed<std::uint16_t>({std::uint16_t(value.size())}) + value;
}

struct TimedFrame {
    double height;
    std::string content;  ///< of the Frame Content Sequence
};

DicomFile timed(const std::vector<TimedFrame>& all, const Style& s) {
    DicomFile file = enhanced(std::vector<double>(all.size()), s, false);
    const std::string common =
        s.sequence(kPlaneOrientation, {s.decimals(kOrientation, "1\\0\\0\\0\\1\\0")}) +
        s.sequence(kPixelMeasures, {s.decimals(kPixelSpacing, "0.5\\0.25")});
    std::vector<std::string> frames;
    for (const TimedFrame& frame : all)
        frames.push_back(
            s.sequence(kFrameContent, {frame.content}) +
            s.sequence(kPlanePosition,
                       {s.decimals(kPosition, "0\\0\\" + std::to_string(frame.height))}));
    file.slope = "1";
    file.intercept = "0";
    file.more = s.sequence(kShared, {common}) + s.sequence(kPerFrame, frames);
    return file;
}

TEST(DicomFrames, OfSeveralVolumesOneIsChosen) {
    const test::TemporaryFolder folder;
    for (const bool implicit : {false, true}) {
        const Style s{implicit, true};
        // Three points in time of two slices, mixed; the numbers are in every usual element.
        const auto both = [&](std::uint32_t slice, std::uint32_t time, bool temporal) {
            return TimedFrame{2.0 * slice, temporal
                                               ? longs(s, kTemporalIndex, {time}) +
                                                     longs(s, kDimensionIndices, {1, slice})
                                               : longs(s, kDimensionIndices, {1, slice, time})};
        };
        for (const bool temporal : {false, true}) {
            SCOPED_TRACE(std::to_string(implicit) + std::to_string(temporal));
            const auto path = folder.write(
                "a.dcm",
                timed({both(1, 30, temporal), both(2, 10, temporal), both(1, 10, temporal),
                       both(2, 30, temporal), both(1, 20, temporal), both(2, 20, temporal)},
                      s)
                    .bytes());
            const std::string name = path.string();
            EXPECT_EQ(error_of(path), name + ": holds 3 images, choose one with --frame 0…2");
            EXPECT_EQ(error_of(path, {.frame = 3}), "--frame: found 3, expected 0…2 for " + name);
            EXPECT_EQ(error_of(path, {.frame = -1}), "--frame: found -1, expected 0…2 for " + name);
            const int first[] = {2, 4, 0}, second[] = {1, 5, 3};
            for (int n = 0; n < 3; ++n) {
                const auto volume = read_volume(path, {.frame = n});
                ASSERT_TRUE(volume.ok()) << volume.error().message;
                EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 2}));
                EXPECT_EQ(volume->grid.spacing_mm.z, 2);
                EXPECT_EQ(volume->at({0, 0, 0}), 100 * first[n]);
                EXPECT_EQ(volume->at({0, 0, 1}), 100 * second[n]);
            }
            EXPECT_EQ(error_of(folder.path()),
                      folder.path().string() + ": holds 3 images, choose one with --frame 0…2");
            EXPECT_TRUE(read_volume(folder.path(), {.frame = 1}).ok());
        }
    }
}

TEST(DicomFrames, AtOnePlaceWithoutNumbersForVolumesStayDoubleSlices) {
    const test::TemporaryFolder folder;
    const Style s;
    const std::string same = longs(s, kDimensionIndices, {1, 1});
    for (const auto& frames : {std::vector<TimedFrame>{{0, ""}, {0, ""}},
                               {{0, same}, {0, same}},
                               {{0, longs(s, kTemporalIndex, {1})}, {0, ""}},
                               // The third frame is a double of the second one.
                               {{0, longs(s, kTemporalIndex, {1})},
                                {0, longs(s, kTemporalIndex, {2})},
                                {0, longs(s, kTemporalIndex, {2})}}})
        EXPECT_NE(error_of(folder.write("a.dcm", timed(frames, s).bytes()))
                      .find("two slices are at the same position"),
                  std::string::npos);
    // Different positions are one volume, whichever numbers the frames have.
    const auto one = read_volume(folder.write(
        "a.dcm", timed({{0, longs(s, kTemporalIndex, {1})}, {1, longs(s, kTemporalIndex, {2})}}, s)
                     .bytes()));
    ASSERT_TRUE(one.ok()) << one.error().message;
    EXPECT_EQ(one->grid.size.z, 2);
}

TEST(DicomFrames, ASingleSliceIsNoScanByItself) {
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.dcm", DicomFile().bytes());
    EXPECT_EQ(error_of(path),
              path.string() + ": is a single DICOM slice, expected the folder of its series");
    // Its folder is one of one slice.
    ReadNotes notes;
    const auto volume = read_volume(folder.path(), {}, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 1}));
    EXPECT_EQ(volume->grid.spacing_mm.z, 17);
    EXPECT_EQ(notes.notes, std::vector<std::string>{
                               "one slice; its thickness of 17 mm is taken as the spacing"});
}

TEST(DicomFrames, TheSeriesOfAFileCanBeNamed) {
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.dcm", enhanced({0, 1}, {}, true).bytes());
    ReadOptions options;
    options.series_uid = "1.2.3";
    EXPECT_TRUE(read_volume(path, options).ok());
    options.series_uid = "1.2.4";
    EXPECT_EQ(error_of(path, options),
              path.string() +
                  ": has no series 1.2.4, expected --series with the number, a part of "
                  "the description or the UID of one");
}

TEST(DicomFrames, EveryCutOffFileIsRefused) {
    const test::TemporaryFolder folder;
    for (const bool known_lengths : {false, true}) {
        const std::string bytes = enhanced({0, 1}, {false, known_lengths}, true).bytes();
        for (std::size_t length = 132; length < bytes.size(); length += 7)
            EXPECT_FALSE(read_volume(folder.write("a.dcm", bytes.substr(0, length))).ok())
                << length;
    }
}

TEST(DicomFrames, DamagedFilesDoNoHarm) {
    for (const bool known_lengths : {false, true})
        for (const bool implicit : {false, true})
            test::read_damaged("a.dcm", enhanced({0, 1}, {implicit, known_lengths}, true).bytes(),
                               300);
}

/// Folders of folders, as exports of archives have.
class DicomTrees : public ::testing::Test {
  protected:
    void write_slices(const std::string& place, int first, int count, const DicomFile& like = {}) {
        for (int n = first; n < first + count; ++n) {
            DicomFile slice = like;
            slice.position[2] = n;
            slice.pixels.assign(12, std::int16_t(n));
            m_folder.write(place + "/IM" + std::to_string(n), slice.bytes());
        }
    }
    test::TemporaryFolder m_folder;
};

TEST_F(DicomTrees, AreSearchedIfTheFolderHasNoSlice) {
    m_folder.write("DICOMDIR", "x");
    m_folder.write("readme.txt", "x");
    write_slices("PAT1/STUDY/A", 0, 2);
    write_slices("PAT1/STUDY/B", 2, 2);
    ReadNotes notes;
    const auto volume = read_volume(m_folder.path(), {}, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    // One series in two folders.
    EXPECT_EQ(volume->grid.size.z, 4);
    EXPECT_EQ(volume->at({0, 0, 3}), 3 - 1000);
    EXPECT_EQ(notes.notes, (std::vector<std::string>{
                               "the folder has no slices itself; found in folders below it",
                               "1 file of the folder left out: no DICOM image"}));
}

TEST_F(DicomTrees, TheDirectoryFileStandsForItsFolder) {
    write_slices("IMAGES/1", 0, 3);
    const auto path = m_folder.write("DICOMDIR", DicomFile().bytes());
    // Without its own image: a directory has none.
    std::filesystem::resize_file(path, 400);
    const auto volume = read_volume(path);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size.z, 3);
}

TEST_F(DicomTrees, SeveralSeriesAreListed) {
    write_slices("a", 0, 2);
    DicomFile other;
    other.series = "1.2.9";
    write_slices("b/c", 0, 3, other);
    EXPECT_EQ(error_of(m_folder.path()), m_folder.path().string() +
                                             ": holds 2 series, choose one with --series and its "
                                             "number or a part of its description");
    ReadOptions options;
    options.series_uid = "1.2.9";
    const auto volume = read_volume(m_folder.path(), options);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size.z, 3);
}

TEST_F(DicomTrees, FoldersBelowSlicesAreNotSearched) {
    write_slices("a", 0, 2);
    write_slices("a/b", 2, 2);
    const auto volume = read_volume(m_folder / "a");
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size.z, 2);
}

TEST_F(DicomTrees, LinksAndDeepFoldersAreNotFollowed) {
    std::string place = "x";
    for (int n = 0; n < 12; ++n) place += "/d";
    write_slices(place, 0, 2);
    std::filesystem::create_directory_symlink("..", m_folder / "x/up");
    EXPECT_EQ(error_of(m_folder.path()),
              m_folder.path().string() +
                  ": holds no DICOM images (0 files looked at, in folders below it too; 1 link to "
                  "folders not followed)");
}

}  // namespace
}  // namespace pliant
