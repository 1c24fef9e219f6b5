// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Good files of every kind: their numbers are known, and so is where they lie.
// Covers: formats/data_stream.cpp, formats/*_header.cpp, formats/nrrd_fields.cpp.

#include "support/random.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace pliant::test {
namespace {

const Grid kPlain{{4, 3, 2}, {1, 1, 2}, {10, 20, 30}, kIdentity3};

/// Grid of a NiftiFile: its world is RAS.
const Grid kNifti{{4, 3, 2}, {1, 1, 2}, {-10, -20, 30}, {{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}}};

/// Expects values first, first + step, … on a grid.
void expect_ramp(const std::filesystem::path& path, double first, double step,
                 const Grid& grid = kPlain) {
    const auto volume = read_volume(path);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size, grid.size) << path;
    EXPECT_LT(norm(volume->grid.spacing_mm - grid.spacing_mm), 1e-6) << path;
    EXPECT_LT(norm(volume->grid.origin_mm - grid.origin_mm), 1e-5) << path;
    for (int a = 0; a < 3; ++a)
        EXPECT_LT(norm(volume->grid.direction.columns[a] - grid.direction.columns[a]), 2e-6)
            << path;
    for (int n = 0; n < 24; ++n)
        ASSERT_EQ(volume->at({n % 4, n / 4 % 3, n / 12}), float(first + n * step)) << path << n;
}
void expect_small_values(const std::filesystem::path& path, const Grid& grid = kPlain) {
    expect_ramp(path, -100, 1, grid);
}

struct Ramp {
    double first, step;
    std::string data;
};
template <class T>
Ramp ramp(double first, double step) {
    std::vector<T> values;
    for (int n = 0; n < 24; ++n) values.push_back(T(first + step * n));
    return {first, step, packed(values)};
}

std::string text_ramp() {
    std::string text;
    for (int n = 0; n < 24; ++n) text += std::to_string(n * 7 - 50) + (n % 4 == 3 ? "\n" : " ");
    return text;
}

TEST(ReadNrrd, EveryTypeOfNumberIsRead) {
    const TemporaryFolder folder;
    const std::pair<const char*, Ramp> types[] = {{"signed char", ramp<std::int8_t>(-120, 9)},
                                                  {"uchar", ramp<std::uint8_t>(3, 10)},
                                                  {"int16", ramp<std::int16_t>(-32768, 2800)},
                                                  {"ushort", ramp<std::uint16_t>(0, 2800)},
                                                  {"int", ramp<std::int32_t>(-70000, 6001)},
                                                  {"uint32", ramp<std::uint32_t>(5, 100)},
                                                  {"longlong", ramp<std::int64_t>(-1000, 17)},
                                                  {"uint64", ramp<std::uint64_t>(1, 3)},
                                                  {"float", ramp<float>(-3, 0.75)},
                                                  {"double", ramp<double>(-1000, 50)}};
    for (const auto& each : types) {
        const std::string type = each.first;
        const Ramp& numbers = each.second;
        NrrdFile file;
        file.type = type;
        const auto expect = [&](const std::string& name) {
            expect_ramp(folder.write(type + name, file.bytes()), numbers.first, numbers.step);
        };
        file.data = numbers.data;
        expect(".nrrd");
        file.data = swapped(numbers.data, numbers.data.size() / 24);
        file.endian = "big";
        expect("-big.nrrd");
        file.data = gzipped(numbers.data);
        file.endian = "little";
        file.encoding = "gzip";
        expect("-gz.nrrd");
    }
}

TEST(ReadNrrd, EveryPlaceForTheDataIsFound) {
    const TemporaryFolder folder;
    const std::string data = packed(small_values());
    folder.write("data.raw", data);
    folder.write("data.gz", gzipped("xyz" + data));
    folder.write("head.raw", "two\nlines\nabc" + data);
    folder.write("half1.raw", data.substr(0, 24));
    folder.write("half2.raw", data.substr(24));
    NrrdFile text;
    text.encoding = "ascii";
    text.data = text_ramp();
    expect_ramp(folder.write("text.nrrd", text.bytes()), -50, 7);
    NrrdFile beside;
    beside.blank_line = false;
    const std::pair<const char*, const char*> positions[] = {
        {"one.nhdr", "data file: data.raw\n"},
        {"skip.nhdr", "line skip: 2\nbyte skip: 3\ndata file: head.raw\n"},
        {"end.nhdr", "byte skip: -1\ndata file: head.raw\n"},
        {"list.nhdr", "data file: LIST\nhalf1.raw\nhalf2.raw\n"},
        {"pattern.nhdr", "data file: half%d.raw 1 2 1\n"}};
    for (const auto& [name, lines] : positions) {
        beside.extra = lines;
        expect_small_values(folder.write(name, beside.bytes()));
    }
    beside.encoding = "gzip";
    beside.extra = "byte skip: 3\ndata file: data.gz\n";
    expect_small_values(folder.write("gz.nhdr", beside.bytes()));
}

TEST(ReadNrrd, OtherSpacesAndNoneArePlaced) {
    const TemporaryFolder folder;
    const Grid as_is{{4, 3, 2}, {1.5, 1, 2}, {10, 20, 30}, {{{0, 1, 0}, {0, 0, -1}, {1, 0, 0}}}};
    const Grid from_ras{
        {4, 3, 2}, {1.5, 1, 2}, {-10, -20, 30}, {{{0, -1, 0}, {0, 0, -1}, {-1, 0, 0}}}};
    for (const char* space : {"RAS", "LPS", "scanner-xyz", "3D-left-handed"}) {
        NrrdFile file;
        file.space = space;
        file.directions = "(0,1.5,0) (0,0,-1) (2,0,0)";
        expect_small_values(folder.write(std::string(space) + ".nrrd", file.bytes()),
                            space == std::string("RAS") ? from_ras : as_is);
    }
    NrrdFile plain;
    plain.space = plain.directions = plain.origin = "";
    plain.extra = "spacings: 1 2 3\n";
    expect_small_values(folder.write("plain.nrrd", plain.bytes()),
                        {{4, 3, 2}, {1, 2, 3}, {}, kIdentity3});
    plain.extra = "";
    expect_small_values(folder.write("bare.nrrd", plain.bytes()),
                        {{4, 3, 2}, {1, 1, 1}, {}, kIdentity3});
}

TEST(ReadNrrd, UnitsOfSpaceAreTurnedIntoMillimetres) {
    const TemporaryFolder folder;
    NrrdFile file;
    file.extra = "space units: \"cm\" \"cm\" \"cm\"\n";
    expect_small_values(folder.write("a.nrrd", file.bytes()),
                        {{4, 3, 2}, {10, 10, 20}, {100, 200, 300}, kIdentity3});
}

TEST(ReadMetaImage, EveryTypeOfNumberIsRead) {
    const TemporaryFolder folder;
    const std::pair<const char*, Ramp> types[] = {
        {"MET_CHAR", ramp<std::int8_t>(-120, 9)},     {"MET_UCHAR", ramp<std::uint8_t>(3, 10)},
        {"MET_SHORT", ramp<std::int16_t>(-999, 99)},  {"MET_USHORT", ramp<std::uint16_t>(0, 2800)},
        {"MET_INT", ramp<std::int32_t>(-70000, 601)}, {"MET_UINT", ramp<std::uint32_t>(5, 100)},
        {"MET_LONG", ramp<std::int32_t>(-5, 100)},    {"MET_LONG_LONG", ramp<std::int64_t>(-9, 2)},
        {"MET_FLOAT", ramp<float>(-3, 0.75)},         {"MET_DOUBLE", ramp<double>(-1000, 50)}};
    for (const auto& each : types) {
        const std::string type = each.first;
        const Ramp& numbers = each.second;
        MetaFile file;
        file.type = type;
        file.data = numbers.data;
        expect_ramp(folder.write(type + ".mha", file.bytes()), numbers.first, numbers.step);
        file.data = zlibbed(numbers.data);
        file.extra =
            "CompressedData = True\nCompressedDataSize = " + std::to_string(file.data.size()) +
            "\n";
        expect_ramp(folder.write(type + "-z.mha", file.bytes()), numbers.first, numbers.step);
    }
}

TEST(ReadMetaImage, EveryPlaceForTheDataIsFound) {
    const TemporaryFolder folder;
    const std::string data = packed(small_values());
    folder.write("data.raw", data);
    folder.write("head.raw", "abc" + data);
    folder.write("s1.raw", data.substr(0, 24));
    folder.write("s2.raw", data.substr(24));
    const auto write = [&](const std::string& name, const std::string& place,
                           const std::string& extra = "") {
        MetaFile file;
        file.data = "";
        file.data_file = place;
        file.extra = extra;
        return folder.write(name, file.bytes());
    };
    expect_small_values(write("one.mhd", "data.raw"));
    expect_small_values(write("end.mhd", "head.raw", "HeaderSize = -1\n"));
    expect_small_values(write("skip.mhd", "head.raw", "HeaderSize = 3\n"));
    expect_small_values(write("list.mhd", "LIST\ns1.raw\ns2.raw"));
    expect_small_values(write("pattern.mhd", "s%d.raw 1 2 1"));
}

TEST(ReadNifti, EveryTypeOfNumberIsRead) {
    const TemporaryFolder folder;
    struct Type {
        std::int16_t code;
        Ramp numbers;
    };
    const Type types[] = {{256, ramp<std::int8_t>(-120, 9)},   {2, ramp<std::uint8_t>(3, 10)},
                          {4, ramp<std::int16_t>(-999, 99)},   {512, ramp<std::uint16_t>(0, 2800)},
                          {8, ramp<std::int32_t>(-7000, 601)}, {768, ramp<std::uint32_t>(5, 100)},
                          {1024, ramp<std::int64_t>(-9, 2)},   {16, ramp<float>(-3, 0.75)},
                          {64, ramp<double>(-1000, 50)}};
    for (const Type& type : types) {
        NiftiFile file;
        const Ramp& numbers = type.numbers;
        const std::size_t size = numbers.data.size() / 24;
        const auto expect = [&](const char* name, const std::string& bytes) {
            expect_ramp(folder.write(std::to_string(type.code) + name, bytes), numbers.first,
                        numbers.step, kNifti);
        };
        file.datatype = type.code;
        file.bitpix = std::int16_t(8 * size);
        file.data = numbers.data;
        expect(".nii", file.bytes());
        expect(".nii.gz", gzipped(file.bytes()));
        file.data = swapped(numbers.data, size);
        file.big_endian = true;
        expect("-big.nii", file.bytes());
    }
}

TEST(ReadNifti, SlopeAndInterceptAreApplied) {
    const TemporaryFolder folder;
    NiftiFile file;
    file.slope = 2;
    file.intercept = -1000;
    ReadNotes notes;
    const auto volume = read_volume(folder.write("a.nii", file.bytes()), {}, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_TRUE(volume->is_16_bit());
    EXPECT_EQ(notes.stored_type, "int16");
    EXPECT_EQ(volume->at({1, 0, 0}), 2 * -99 - 1000);
    file.slope = 0.25;
    expect_ramp(folder.write("b.nii", file.bytes()), -1025, 0.25, kNifti);
    file.slope = 0;  // stands for no slope: the intercept isn't added then
    expect_ramp(folder.write("c.nii", file.bytes()), -100, 1, kNifti);
}

TEST(ReadNifti, UnitsOfSpaceAreTurnedIntoMillimetres) {
    const TemporaryFolder folder;
    NiftiFile file;
    file.units = 1;
    Grid metres = kNifti;
    metres.spacing_mm = 1000.0 * metres.spacing_mm;
    metres.origin_mm = 1000.0 * metres.origin_mm;
    expect_small_values(folder.write("a.nii", file.bytes()), metres);
}

TEST(ReadNifti, TheSformCountsIfThereIsOne) {
    const TemporaryFolder folder;
    const Grid unplaced{{4, 3, 2}, {1, 1, 2}, {}, kIdentity3};
    // The quaternion (½, ½, ½, ½) turns i to j, j to k and k to i, in RAS.
    const Grid turned{{4, 3, 2}, {1, 1, 2}, {-4, -5, 6}, {{{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}}}};
    const Grid half_turn{{4, 3, 2}, {1, 1, 2}, {-4, -5, 6}, {{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}};
    for (const std::int16_t qform_code : {0, 1, 2, 3})
        for (const std::int16_t sform_code : {0, 1, 2, 3}) {
            NiftiFile file;
            file.qform_code = qform_code;
            file.sform_code = sform_code;
            file.qform = {0.5, 0.5, 0.5, 4, 5, 6};
            const bool sform = sform_code > 0;
            const Grid& other = qform_code > 0 ? turned : unplaced;
            const auto name = std::to_string(qform_code) + std::to_string(sform_code) + ".nii";
            ReadNotes notes;
            const auto path = folder.write(name, file.bytes());
            expect_small_values(path, sform ? kNifti : other);
            ASSERT_TRUE(read_volume(path, {}, &notes).ok());
            EXPECT_EQ(notes.notes.empty(), sform != (qform_code > 0)) << name;
            file.qform[0] = 1;  // a half turn
            file.qform[1] = file.qform[2] = 0;
            expect_small_values(folder.write("half" + name, file.bytes()),
                                sform ? kNifti : (qform_code > 0 ? half_turn : unplaced));
        }
}

TEST(ReadNifti, RoundedHalfTurnsAreHalfTurns) {
    const TemporaryFolder folder;
    test::Random random(6);
    for (int n = 0; n < 100; ++n) {
        const Vec3d axis = normalized(random.vector(1));
        NiftiFile file;
        file.qform_code = 1;
        file.sform_code = 0;
        file.qform = {float(axis.x), float(axis.y), float(axis.z), 4, 5, 6};
        const auto volume = read_volume(folder.write("a.nii", file.bytes()));
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        const Vec3d units[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (std::size_t a = 0; a < 3; ++a) {
            const Vec3d turned = 2 * dot(axis, units[a]) * axis - units[a];
            const Vec3d expected{-turned.x, -turned.y, turned.z};
            EXPECT_LT(norm(volume->grid.direction.columns[a] - expected), 1e-6);
        }
    }
}

TEST(ReadNifti, AShearedSformIsAnErrorWhateverTheQform) {
    const TemporaryFolder folder;
    NiftiFile file;
    file.sform[1] = 0.3F;
    for (const std::int16_t qform_code : {0, 1}) {
        file.qform_code = qform_code;
        const auto volume = read_volume(folder.write("a.nii", file.bytes()));
        ASSERT_FALSE(volume.ok());
        EXPECT_NE(volume.error().message.find("--straighten"), std::string::npos)
            << volume.error().message;
    }
}

TEST(ReadNifti, AnSformCountsHoweverFarItIs) {
    const TemporaryFolder folder;
    for (int n = 1; n <= 20; ++n) {
        NiftiFile file;
        const float z = -137.f * float(n);
        file.pixdim = {1, 0.1f * float(n), 0.7f, 1.3f, 0, 0, 0, 0};
        file.sform = {file.pixdim[1], 0, 0, 10, 0, file.pixdim[2], 0, 20, 0, 0, 1.3f, z};
        file.qform_code = std::int16_t(n % 2);
        Grid far = kNifti;
        far.spacing_mm = {0.1 * n, 0.7, 1.3};
        far.origin_mm.z = z;
        expect_small_values(folder.write(std::to_string(n) + ".nii", file.bytes()), far);
    }
}

TEST(ReadNifti, LaterAxesOfOneAreLeftOut) {
    const TemporaryFolder folder;
    NiftiFile file;
    file.dim = {5, 4, 3, 2, 1, 1, 1, 1};
    const auto volume = read_volume(folder.write("a.nii", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 2}));
}

}  // namespace
}  // namespace pliant::test
