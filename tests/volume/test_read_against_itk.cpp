// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Good files of every kind, read by Pliant and by ITK: the same values in the same places.

#include "support/itk_reader.h"
#include "support/scan_files.h"
#include "support/temp_folder.h"

#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <cmath>

namespace pliant {
namespace {

using test::gzipped;
using test::MetaFile;
using test::NiftiFile;
using test::NrrdFile;
using test::packed;
using test::swapped;
using test::zlibbed;

void expect_same_as_itk(const std::filesystem::path& path) {
    const auto volume = read_volume(path);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    const test::ItkImage itk = test::read_with_itk(path);
    ASSERT_EQ(itk.error, "") << path;
    EXPECT_EQ(volume->grid.size, itk.grid.size) << path;
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(volume->grid.spacing_mm[a], itk.grid.spacing_mm[a],
                    1e-6 * itk.grid.spacing_mm[a])
            << path;
        EXPECT_NEAR(volume->grid.origin_mm[a], itk.grid.origin_mm[a],
                    1e-6 * (1 + std::abs(itk.grid.origin_mm[a])))
            << path;
        EXPECT_LT(norm(volume->grid.direction.columns[a] - itk.grid.direction.columns[a]), 2e-6)
            << path;
    }
    ASSERT_EQ(itk.values.size(), voxel_count(volume->grid)) << path;
    std::size_t n = 0;
    for (int k = 0; k < volume->grid.size.z; ++k)
        for (int j = 0; j < volume->grid.size.y; ++j)
            for (int i = 0; i < volume->grid.size.x; ++i, ++n)
                ASSERT_EQ(volume->at({i, j, k}), float(itk.values[n])) << path << ' ' << n;
}

template <class T>
std::string ramp(double first, double step) {
    std::vector<T> values;
    for (int n = 0; n < 24; ++n) values.push_back(T(first + step * n));
    return packed(values);
}

std::string text_ramp() {
    std::string text;
    for (int n = 0; n < 24; ++n) text += std::to_string(n * 7 - 50) + (n % 4 == 3 ? "\n" : " ");
    return text;
}

TEST(ReadNrrd, EveryTypeOfNumberIsReadAsItkReadsIt) {
    const test::TempFolder folder;
    const std::pair<const char*, std::string> types[] = {
        {"signed char", ramp<std::int8_t>(-120, 9)},
        {"uchar", ramp<std::uint8_t>(3, 10)},
        {"int16", ramp<std::int16_t>(-32768, 2800)},
        {"ushort", ramp<std::uint16_t>(0, 2800)},
        {"int", ramp<std::int32_t>(-70000, 6001)},
        {"uint32", ramp<std::uint32_t>(5, 100)},
        {"longlong", ramp<std::int64_t>(-1000, 17)},
        {"uint64", ramp<std::uint64_t>(1, 3)},
        {"float", ramp<float>(-3, 0.75)},
        {"double", ramp<double>(-1000, 50)}};
    for (const auto& [type, data] : types) {
        NrrdFile file;
        file.type = type;
        const std::size_t size = data.size() / 24;
        const std::string name = type;
        file.data = data;
        expect_same_as_itk(folder.write(name + ".nrrd", file.bytes()));
        file.data = swapped(data, size);
        file.endian = "big";
        expect_same_as_itk(folder.write(name + "-big.nrrd", file.bytes()));
        file.data = gzipped(data);
        file.endian = "little";
        file.encoding = "gzip";
        expect_same_as_itk(folder.write(name + "-gz.nrrd", file.bytes()));
    }
}

TEST(ReadNrrd, EveryPlaceForTheDataIsFound) {
    const test::TempFolder folder;
    const std::string data = packed(test::small_values());
    folder.write("data.raw", data);
    folder.write("data.gz", gzipped("xyz" + data));
    folder.write("head.raw", "two\nlines\nabc" + data);
    folder.write("half1.raw", data.substr(0, 24));
    folder.write("half2.raw", data.substr(24));
    NrrdFile text;
    text.encoding = "ascii";
    text.data = text_ramp();
    expect_same_as_itk(folder.write("text.nrrd", text.bytes()));
    NrrdFile beside;
    beside.blank_line = false;
    const std::pair<const char*, const char*> places[] = {
        {"one.nhdr", "data file: data.raw\n"},
        {"skip.nhdr", "line skip: 2\nbyte skip: 3\ndata file: head.raw\n"},
        {"end.nhdr", "byte skip: -1\ndata file: head.raw\n"},
        {"list.nhdr", "data file: LIST\nhalf1.raw\nhalf2.raw\n"},
        {"pattern.nhdr", "data file: half%d.raw 1 2 1\n"}};
    for (const auto& [name, lines] : places) {
        beside.extra = lines;
        expect_same_as_itk(folder.write(name, beside.bytes()));
    }
    beside.encoding = "gzip";
    beside.extra = "byte skip: 3\ndata file: data.gz\n";
    expect_same_as_itk(folder.write("gz.nhdr", beside.bytes()));
}

TEST(ReadNrrd, OtherSpacesAndNoneArePlacedAsItkPlacesThem) {
    const test::TempFolder folder;
    for (const char* space : {"RAS", "LPS", "LAS", "scanner-xyz", "3D-left-handed"}) {
        NrrdFile file;
        file.space = space;
        file.directions = "(0,1.5,0) (0,0,-1) (2,0,0)";
        expect_same_as_itk(folder.write(std::string(space) + ".nrrd", file.bytes()));
    }
    NrrdFile plain;
    plain.space = plain.directions = plain.origin = "";
    plain.extra = "spacings: 1 2 3\n";
    expect_same_as_itk(folder.write("plain.nrrd", plain.bytes()));
    plain.extra = "";
    expect_same_as_itk(folder.write("bare.nrrd", plain.bytes()));
}

TEST(ReadMetaImage, EveryTypeOfNumberIsReadAsItkReadsIt) {
    const test::TempFolder folder;
    const std::pair<const char*, std::string> types[] = {
        {"MET_CHAR", ramp<std::int8_t>(-120, 9)},     {"MET_UCHAR", ramp<std::uint8_t>(3, 10)},
        {"MET_SHORT", ramp<std::int16_t>(-999, 99)},  {"MET_USHORT", ramp<std::uint16_t>(0, 2800)},
        {"MET_INT", ramp<std::int32_t>(-70000, 601)}, {"MET_UINT", ramp<std::uint32_t>(5, 100)},
        {"MET_LONG", ramp<std::int32_t>(-5, 100)},    {"MET_LONG_LONG", ramp<std::int64_t>(-9, 2)},
        {"MET_FLOAT", ramp<float>(-3, 0.75)},         {"MET_DOUBLE", ramp<double>(-1000, 50)}};
    for (const auto& [type, data] : types) {
        MetaFile file;
        file.type = type;
        file.data = data;
        expect_same_as_itk(folder.write(std::string(type) + ".mha", file.bytes()));
        file.data = zlibbed(data);
        file.extra =
            "CompressedData = True\nCompressedDataSize = " + std::to_string(file.data.size()) +
            "\n";
        expect_same_as_itk(folder.write(std::string(type) + "-z.mha", file.bytes()));
    }
}

TEST(ReadMetaImage, EveryPlaceForTheDataIsFound) {
    const test::TempFolder folder;
    const std::string data = packed(test::small_values());
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
    expect_same_as_itk(write("one.mhd", "data.raw"));
    expect_same_as_itk(write("end.mhd", "head.raw", "HeaderSize = -1\n"));
    expect_same_as_itk(write("skip.mhd", "head.raw", "HeaderSize = 3\n"));
    expect_same_as_itk(write("list.mhd", "LIST\ns1.raw\ns2.raw"));
    expect_same_as_itk(write("pattern.mhd", "s%d.raw 1 2 1"));
}

TEST(ReadNifti, EveryTypeOfNumberIsReadAsItkReadsIt) {
    const test::TempFolder folder;
    struct Type {
        std::int16_t code;
        std::string data;
    };
    const Type types[] = {{256, ramp<std::int8_t>(-120, 9)},   {2, ramp<std::uint8_t>(3, 10)},
                          {4, ramp<std::int16_t>(-999, 99)},   {512, ramp<std::uint16_t>(0, 2800)},
                          {8, ramp<std::int32_t>(-7000, 601)}, {768, ramp<std::uint32_t>(5, 100)},
                          {1024, ramp<std::int64_t>(-9, 2)},   {16, ramp<float>(-3, 0.75)},
                          {64, ramp<double>(-1000, 50)}};
    for (const Type& type : types) {
        NiftiFile file;
        const std::size_t size = type.data.size() / 24;
        const std::string name = std::to_string(type.code);
        file.datatype = type.code;
        file.bitpix = std::int16_t(8 * size);
        file.data = type.data;
        expect_same_as_itk(folder.write(name + ".nii", file.bytes()));
        expect_same_as_itk(folder.write(name + ".nii.gz", gzipped(file.bytes())));
        file.data = swapped(type.data, size);
        file.big_endian = true;
        expect_same_as_itk(folder.write(name + "-big.nii", file.bytes()));
    }
}

TEST(ReadNifti, SlopeAndInterceptAreApplied) {
    const test::TempFolder folder;
    NiftiFile file;
    file.slope = 2;
    file.intercept = -1000;
    const auto path = folder.write("a.nii", file.bytes());
    expect_same_as_itk(path);
    const auto volume = read_volume(path);
    EXPECT_TRUE(volume->is_16_bit());
    EXPECT_EQ(volume->at({1, 0, 0}), 2 * -99 - 1000);
    file.slope = 0.25;
    expect_same_as_itk(folder.write("b.nii", file.bytes()));
}

TEST(ReadNifti, TheSameMapAsInItkIsChosen) {
    const test::TempFolder folder;
    for (const std::int16_t qform_code : {0, 1, 2, 3})
        for (const std::int16_t sform_code : {0, 1, 2, 3}) {
            NiftiFile file;
            file.qform_code = qform_code;
            file.sform_code = sform_code;
            file.qform = {0.5, 0.5, 0.5, 4, 5, 6};
            const auto name = std::to_string(qform_code) + std::to_string(sform_code) + ".nii";
            expect_same_as_itk(folder.write(name, file.bytes()));
            file.qform[0] = 1;  // a half turn
            file.qform[1] = file.qform[2] = 0;
            expect_same_as_itk(folder.write("half" + name, file.bytes()));
        }
}

TEST(ReadNifti, LaterAxesOfOneAreLeftOut) {
    const test::TempFolder folder;
    NiftiFile file;
    file.dim = {5, 4, 3, 2, 1, 1, 1, 1};
    const auto volume = read_volume(folder.write("a.nii", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 2}));
}

}  // namespace
}  // namespace pliant
