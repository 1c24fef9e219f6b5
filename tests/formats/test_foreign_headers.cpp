// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Headers as other programs write them: positions are those of ITK, of NIfTI those of nibabel.
// Covers: formats/nrrd_header.cpp, formats/nifti_header.cpp, formats/data_stream.cpp.

#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

namespace pliant {
namespace {

using test::MetaFile;
using test::NiftiFile;
using test::NrrdFile;
using test::packed;
using Notes = std::vector<std::string>;

struct Read {
    Volume volume;
    Notes notes;

    std::vector<std::int16_t> values() const {
        const auto& voxels = std::get<0>(volume.voxels);
        return {voxels.begin(), voxels.end()};
    }
};

/// Reads a file that must be readable.
Read read(const std::filesystem::path& path, std::optional<std::int64_t> frame = {}) {
    ReadOptions options;
    options.frame = frame;
    ReadNotes notes;
    auto volume = read_volume(path, options, &notes);
    EXPECT_TRUE(volume.ok()) << volume.error().message;
    return volume.ok() ? Read{std::move(*volume), notes.notes} : Read{};
}

std::string refusal(const std::filesystem::path& path) {
    const auto volume = read_volume(path);
    return volume.ok() ? "" : volume.error().message.substr(path.string().size() + 2);
}

/// The values of a frame of 4 × 3 × 2 voxels.
std::vector<std::int16_t> frame_values(int frame) {
    std::vector<std::int16_t> values;
    for (const std::int16_t v : test::small_values())
        values.push_back(std::int16_t(v + 1000 * frame));
    return values;
}

std::string two_frames() {
    return packed(frame_values(0)) + packed(frame_values(1));
}

NrrdFile nrrd_with_time() {
    NrrdFile file;
    file.dimension = "4";
    file.space = "";
    file.extra = "space dimension: 4\n";
    file.sizes = "4 3 2 2";
    file.kinds = "domain domain domain domain";
    file.directions = "(0,0.5,0,0) (-1,0,0,0) (0,0,2,0) (0,0,0,0.5)";
    file.origin = "(10,20,30,7)";
    file.data = two_frames();
    return file;
}

TEST(ForeignNrrd, FourDimensionsOfSpaceAreSpaceAndTime) {
    const test::TemporaryFolder folder;
    NrrdFile file = nrrd_with_time();  // as ITK writes it
    const auto expect = [&](const std::string& name, Vec3d sign) {
        SCOPED_TRACE(name);
        const auto path = folder.write("t.nrrd", file.bytes());
        for (int frame = 0; frame < 2; ++frame) {
            const Read time = read(path, frame);
            EXPECT_EQ(time.values(), frame_values(frame));
            const Grid& grid = time.volume.grid;
            EXPECT_EQ(grid.size, (Vec3i{4, 3, 2}));
            EXPECT_EQ(grid.spacing_mm, (Vec3d{0.5, 1, 2}));
            EXPECT_EQ(grid.origin_mm, (Vec3d{10 * sign.x, 20 * sign.y, 30 * sign.z}));
            EXPECT_EQ(grid.direction.columns[0], (Vec3d{0, sign.y, 0}));
            EXPECT_EQ(grid.direction.columns[1], (Vec3d{-sign.x, 0, 0}));
        }
    };
    expect("unnamed", {1, 1, 1});
    file.extra = "";
    file.space = "left-posterior-superior-time";
    file.kinds = "space space space time";
    expect("LPS", {1, 1, 1});
    file.space = "RAST";
    file.extra = "space units: \"mm\" \"mm\" \"mm\" \"s\"\n";
    expect("RAS", {-1, -1, 1});
    // The axis of time may be any.
    file = nrrd_with_time();
    file.sizes = "2 4 3 2";
    file.directions = "(0,0,0,1) (0,0.5,0,0) (-1,0,0,0) (0,0,2,0)";
    file.data.clear();
    for (std::size_t n = 0; n < 24; ++n)
        for (int frame = 0; frame < 2; ++frame)
            file.data += packed(std::vector<std::int16_t>{frame_values(frame)[n]});
    expect("time first", {1, 1, 1});
    file = nrrd_with_time();
    file.directions = "(0,0.5,0,1) (-1,0,0,0) (0,0,2,0) (0,0,0,0.5)";
    EXPECT_EQ(refusal(folder.write("s.nrrd", file.bytes())),
              "space directions is '(0,0.5,0,1) (-1,0,0,0) (0,0,2,0) (0,0,0,0.5)', expected axes "
              "of space without a component of time");
    file.directions = "(1,0,0) (0,1,0) (0,0,2) none";
    EXPECT_NE(refusal(folder.write("f.nrrd", file.bytes())).find("a vector (x,y,z,t) for each"),
              std::string::npos);
    file.extra = "space dimension: 5\n";
    EXPECT_EQ(refusal(folder.write("d.nrrd", file.bytes())),
              "space dimension is '5', expected 2, 3 or 4");
}

TEST(ForeignNrrd, TwoDimensionsOfSpaceAreASlice) {
    const test::TemporaryFolder folder;
    NrrdFile file;
    file.dimension = "2";
    file.space = "";
    file.extra = "space dimension: 2\n";
    file.sizes = "4 3";
    file.kinds = "domain domain";
    file.directions = "(0.5,0) (0,1.5)";
    file.origin = "(10,-20)";
    file.data = packed(test::small_values()).substr(0, 24);
    const Read slice = read(folder.write("a.nrrd", file.bytes()));
    EXPECT_EQ(slice.volume.grid.size, (Vec3i{4, 3, 1}));
    EXPECT_EQ(slice.volume.grid.spacing_mm, (Vec3d{0.5, 1.5, 1}));
    EXPECT_EQ(slice.volume.grid.origin_mm, (Vec3d{10, -20, 0}));
    EXPECT_EQ(slice.volume.grid.direction, kIdentity3);
}

TEST(ForeignNrrd, MinimaOfAxesPlaceTheFirstVoxel) {
    const test::TemporaryFolder folder;
    NrrdFile file;
    file.space = file.directions = file.origin = "";
    file.extra = "spacings: 0.9 1.1 2\naxis mins: 10 -20 30\n";
    const Read cells = read(folder.write("a.nrrd", file.bytes()));
    EXPECT_EQ(cells.volume.grid.origin_mm, (Vec3d{10.45, -19.45, 31}));
    EXPECT_EQ(cells.notes, (Notes{"no orientation; the axes are taken as L, P, S from (10.45, "
                                  "-19.45, 31)"}));
    file.extra += "centerings: node cell node\n";
    EXPECT_EQ(read(folder.write("n.nrrd", file.bytes())).volume.grid.origin_mm,
              (Vec3d{10, -19.45, 30}));
    file.extra = "spacings: 0.9 1.1 2\naxis mins: nan nan nan\n";
    EXPECT_EQ(read(folder.write("u.nrrd", file.bytes())).volume.grid.origin_mm, (Vec3d{0, 0, 0}));
    file.extra = "spacings: 0.9 1.1 2\naxis mins: 1 2\n";
    EXPECT_EQ(refusal(folder.write("f.nrrd", file.bytes())),
              "axis mins is '1 2', expected a number for each axis");
}

TEST(ForeignNrrd, CompressedDataMayBeTheLastBytes) {
    const test::TemporaryFolder folder;
    NrrdFile file;
    file.encoding = "gzip";
    file.extra = "byte skip: -1\n";
    const std::string data = file.data;
    for (const std::string before : {"", "any header, such as one of NIfTI"}) {
        file.data = test::gzipped(before + data);
        const Read last = read(folder.write("a.nrrd", file.bytes()));
        EXPECT_EQ(last.values(), test::small_values());
        EXPECT_TRUE(last.notes.empty());
    }
    file.data = test::gzipped(data.substr(1));
    EXPECT_EQ(refusal(folder.write("a.nrrd", file.bytes())),
              "byte skip is -1, but its compressed data hold 47 bytes or more, expected 48 to "
              "268435504");
    file.data = test::gzipped(data).substr(0, 30);
    EXPECT_EQ(refusal(folder.write("a.nrrd", file.bytes())),
              "ends early: its compressed data are cut off");
}

TEST(ForeignHeaders, DataThatGoOnAreNoted) {
    const test::TemporaryFolder folder;
    const Notes longer = {"the data are longer than the header says; the rest was ignored"};
    const std::string data = packed(test::small_values()), more = data + "12";
    NrrdFile nrrd;
    const auto notes_of = [&](const char* name, const std::string& bytes) {
        Notes notes = read(folder.write(name, bytes)).notes;
        std::erase_if(notes, [](const std::string& n) { return n.find("longer") == n.npos; });
        return notes;
    };
    EXPECT_EQ(notes_of("a.nrrd", nrrd.bytes()), Notes{});
    nrrd.data = more;
    EXPECT_EQ(notes_of("b.nrrd", nrrd.bytes()), longer);
    nrrd.encoding = "gzip";
    nrrd.data = test::gzipped(more);
    EXPECT_EQ(notes_of("c.nrrd", nrrd.bytes()), longer);
    nrrd.data = test::gzipped(data);
    EXPECT_EQ(notes_of("d.nrrd", nrrd.bytes()), Notes{});
    nrrd.encoding = "text";
    nrrd.data = "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24\n";
    EXPECT_EQ(notes_of("e.nrrd", nrrd.bytes()), Notes{});
    nrrd.data += "25\n";
    EXPECT_EQ(notes_of("f.nrrd", nrrd.bytes()), longer);
    MetaFile meta;
    meta.data = more;
    EXPECT_EQ(notes_of("g.mha", meta.bytes()), longer);
    NiftiFile nifti;
    nifti.data = more;
    EXPECT_EQ(notes_of("h.nii", nifti.bytes()), longer);
    EXPECT_EQ(notes_of("i.nii.gz", test::gzipped(nifti.bytes())), longer);
    // A frame before the last one is followed by others.
    nrrd = nrrd_with_time();
    EXPECT_EQ(read(folder.write("t.nrrd", nrrd.bytes()), 0).notes,
              (Notes{"no space is named; taken as LPS"}));
}

TEST(ForeignNifti, WhatOthersTolerateIsReadWithANote) {
    const test::TemporaryFolder folder;
    NiftiFile good;
    good.qform_code = good.sform_code;
    good.qform = {0, 0, 0, 10, 20, 30};
    const Read plain = read(folder.write("good.nii", good.bytes()));
    EXPECT_EQ(plain.notes, Notes{});
    const auto expect = [&](const NiftiFile& file, const Notes& notes) {
        const Read same = read(folder.write("a.nii", file.bytes()));
        EXPECT_EQ(same.volume.grid, plain.volume.grid);
        EXPECT_EQ(same.values(), plain.values());
        EXPECT_EQ(same.notes, notes);
    };
    NiftiFile file = good;
    file.intercept = -1024;  // without a slope
    expect(file, {"scl_slope is 0, so scl_inter -1024 is not added"});
    file = good;
    file.dim = {5, 4, 3, 2, 0, 0, 0, 0};
    expect(file, {"dim[4] is 0, taken as 1", "dim[5] is 0, taken as 1"});
    file = good;
    file.sform = {};
    expect(file, {"the sform is zero; the qform is used"});
    file = good;
    file.pixdim[1] = -1;
    expect(file, {"pixdim[1] is negative; its absolute value is used"});
    file.sform_code = 0;
    expect(file, {"pixdim[1] is negative; its absolute value is used"});
    file = good;
    file.sform = {};
    file.qform_code = 0;
    EXPECT_NE(refusal(folder.write("b.nii", file.bytes())).find("sform has the axis"),
              std::string::npos);
    // The content says whether it is compressed.
    EXPECT_EQ(read(folder.write("plain.nii.gz", good.bytes())).values(), plain.values());
    EXPECT_EQ(read(folder.write("packed.nii", test::gzipped(good.bytes()))).values(),
              plain.values());
}

TEST(ForeignNifti, PairsAreReadByTheirHeader) {
    const test::TemporaryFolder folder;
    NiftiFile file;
    const auto whole = read(folder.write("whole.nii", file.bytes()));
    file.magic = "ni1";
    for (const float start : {0.0F, 20.0F}) {
        file.vox_offset = start;
        const std::string header = file.bytes().substr(0, 352);
        const std::string data = std::string(std::size_t(start), 'x') + file.data;
        const auto plain = folder.write("a.hdr", header);
        std::filesystem::remove(folder / "a.img");
        EXPECT_EQ(refusal(plain), "its data file " + (folder / "a.img").string() + " is missing");
        folder.write("a.img", data);
        const auto packed = folder.write("b.hdr.gz", test::gzipped(header));
        folder.write("b.img.gz", test::gzipped(data));
        for (const auto& path : {plain, packed}) {
            const Read found = read(path);
            EXPECT_EQ(found.values(), whole.values());
            EXPECT_EQ(found.volume.grid.origin_mm, whole.volume.grid.origin_mm);
            EXPECT_EQ(found.volume.grid.direction, whole.volume.grid.direction);
            EXPECT_EQ(found.notes, whole.notes);
        }
    }
    EXPECT_NE(refusal(folder / "a.img").find(".hdr (of a NIfTI pair)"), std::string::npos);
    file.magic = "";
    EXPECT_EQ(refusal(folder.write("old.hdr", file.bytes().substr(0, 348))),
              "is an ANALYZE header, which doesn't tell left from right, expected NIfTI (\"ni1\")");
}

TEST(ForeignMetaImage, ANegativeSpacingTurnsItsAxis) {
    const test::TemporaryFolder folder;
    MetaFile file;
    file.spacing = "1 -1.5 2";
    const Read turned = read(folder.write("a.mha", file.bytes()));
    EXPECT_EQ(turned.volume.grid.spacing_mm, (Vec3d{1, 1.5, 2}));
    EXPECT_EQ(turned.volume.grid.direction.columns[1], (Vec3d{0, -1, 0}));
    EXPECT_EQ(turned.volume.grid.origin_mm, (Vec3d{10, 20, 30}));
    EXPECT_EQ(turned.values(), test::small_values());
    EXPECT_EQ(turned.notes,
              (Notes{"spacing of axis 2 is negative; the axis points the other way"}));
}

}  // namespace
}  // namespace pliant
