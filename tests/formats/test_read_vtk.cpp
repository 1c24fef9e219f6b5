// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// VTK's images in every encoding that its writers have, put together byte by byte.
// Covers: formats/vti_header.cpp, formats/vtk_*.cpp.

#include "support/damaged_scan.h"
#include "support/random.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>
#include <lz4.h>

#include <algorithm>
#include <functional>

namespace pliant {
namespace {

using test::packed;
using test::small_values;

std::string base64(const std::string& bytes) {
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        std::uint32_t word = 0;
        for (std::size_t b = 0; b < 3; ++b)
            word = word << 8 | (at + b < bytes.size() ? std::uint8_t(bytes[at + b]) : 0U);
        for (std::size_t d = 0; d < 4; ++d)
            text += at + d > bytes.size() ? '=' : kDigits[word >> (18 - 6 * d) & 63];
    }
    return text;
}

std::string lz4_packed(const std::string& bytes) {
    std::string packed(std::size_t(LZ4_compressBound(int(bytes.size()))), '\0');
    const int size =
        LZ4_compress_default(bytes.data(), packed.data(), int(bytes.size()), int(packed.size()));
    return packed.substr(0, std::size_t(size));
}

/// An image of 4 × 3 × 2 voxels, −100, −99, …
struct VtiImage {
    bool appended = true, in_base64 = false, ascii = false, wide = true, big = false;
    std::string compressor = {};  ///< "ZLib", "LZ4" or none
    std::size_t block_bytes = 20;
    std::string type = "Int16", extent = "0 3 0 2 0 1", name = "hu", active = "hu";
    std::string geometry = "Origin=\"10 20 30\" Spacing=\"1 1 2\" Direction=\"1 0 0 0 1 0 0 0 1\"";
    std::string values = packed(small_values());
    std::string more_arrays = {};

    std::string count(std::uint64_t n) const {
        const std::string bytes =
            wide ? packed<std::uint64_t>({n}) : packed<std::uint32_t>({std::uint32_t(n)});
        return big ? test::swapped(bytes, bytes.size()) : bytes;
    }
    std::string encoded(const std::string& bytes) const {
        return in_base64 || !appended ? base64(bytes) : bytes;
    }
    std::string array() const {
        if (compressor.empty()) return encoded(count(values.size()) + values);
        std::string lengths, blocks;
        std::uint64_t number = 0;
        for (std::size_t at = 0; at < values.size(); at += block_bytes, ++number) {
            const std::string block = values.substr(at, block_bytes);
            const std::string small =
                compressor == "LZ4" ? lz4_packed(block) : test::zlibbed(block);
            lengths += count(small.size());
            blocks += small;
        }
        return encoded(count(number) + count(block_bytes) + count(values.size() % block_bytes) +
                       lengths) +
               encoded(blocks);
    }
    std::string bytes() const {
        std::string text =
            "<?xml version=\"1.0\"?>\n<!-- a <comment> -->\n<VTKFile "
            "type=\"ImageData\" version=\"1.0\" byte_order=\"";
        text += big ? "BigEndian" : "LittleEndian";
        text += std::string("\" header_type=\"") + (wide ? "UInt64" : "UInt32") + "\"";
        if (!compressor.empty()) text += " compressor=\"vtk" + compressor + "DataCompressor\"";
        text += ">\n  <ImageData WholeExtent=\"" + extent + "\" " + geometry +
                ">\n  <FieldData>"
                "<DataArray type=\"Float64\" Name=\"time\" format=\"ascii\">1</DataArray>"
                "</FieldData>\n  <Piece Extent=\"" +
                extent + "\">\n    <PointData Scalars=\"" + active + "\">\n" + more_arrays +
                "      <DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"";
        if (appended)
            text += "appended\" offset=\"3\"/>\n";
        else
            text += std::string(ascii ? "ascii" : "binary") + "\">\n" + (ascii ? values : array()) +
                    "</DataArray>\n";
        text += "    </PointData>\n    <CellData>\n    </CellData>\n  </Piece>\n  </ImageData>\n";
        if (appended)
            text += std::string("  <AppendedData encoding=\"") + (in_base64 ? "base64" : "raw") +
                    "\">\n   _xyz" + array() + "\n  </AppendedData>\n";
        return text + "</VTKFile>\n";
    }
};

std::string text_of(const std::vector<std::int16_t>& values) {
    std::string text;
    for (const std::int16_t v : values) text += std::to_string(v) + " ";
    return text;
}

void expect_small_scan(const std::filesystem::path& path, const std::string& what,
                       const char* format = "VTI") {
    ReadNotes notes;
    const auto volume = read_volume(path, {}, &notes);
    ASSERT_TRUE(volume.ok()) << what << ": " << volume.error().message;
    EXPECT_EQ(notes.format, format);
    EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 2})) << what;
    EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{1, 1, 2})) << what;
    EXPECT_EQ(volume->grid.origin_mm, (Vec3d{10, 20, 30})) << what;
    EXPECT_EQ(volume->grid.direction, kIdentity3) << what;
    ASSERT_TRUE(volume->is_16_bit()) << what;
    const auto expected = small_values();
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), std::get<0>(volume->voxels).begin()))
        << what;
}

TEST(ReadVti, EveryEncodingIsRead) {
    const test::TemporaryFolder folder;
    for (const char* compressor : {"", "ZLib", "LZ4"})
        for (const bool appended : {true, false})
            for (const bool in_base64 : {true, false})
                for (const bool wide : {true, false})
                    for (const bool big : {true, false})
                        for (const std::size_t block : {16, 20, 48, 100}) {
                            VtiImage image;
                            image.compressor = compressor;
                            image.appended = appended;
                            image.in_base64 = in_base64;
                            image.wide = wide;
                            image.big = big;
                            // The last block of 48 bytes is full, and its length is said as 0.
                            image.block_bytes = block;
                            if (big) image.values = test::swapped(image.values, 2);
                            if (block == 100 && *compressor == 0) continue;
                            expect_small_scan(folder.write("a.vti", image.bytes()),
                                              std::string(compressor) + (appended ? " app" : "") +
                                                  (in_base64 ? " b64" : "") +
                                                  (wide ? " 64" : " 32") + (big ? " big" : "") +
                                                  " " + std::to_string(block));
                        }
}

TEST(ReadVti, NumbersInTextEndAtTheTag) {
    const test::TemporaryFolder folder;
    VtiImage image;
    image.appended = false;
    image.ascii = true;
    image.values = text_of(small_values());
    expect_small_scan(folder.write("a.vti", image.bytes()), "blank before the tag");
    image.values.pop_back();
    expect_small_scan(folder.write("a.vti", image.bytes()), "no blank before the tag");
    image.values = image.values.substr(0, image.values.rfind(' '));
    const auto volume = read_volume(folder.write("a.vti", image.bytes()));
    ASSERT_FALSE(volume.ok());
    EXPECT_NE(volume.error().message.find("holds 23 numbers, expected 24"), std::string::npos)
        << volume.error().message;
}

TEST(ReadVti, WhatIsWrittenComesBackToTheBit) {
    const test::TemporaryFolder folder;
    test::Random random(8);
    for (int n = 0; n < 30; ++n) {
        Volume volume;
        volume.grid.size = {random.whole(1, 7), random.whole(1, 7), random.whole(1, 7)};
        volume.grid.spacing_mm = {random.real(0.1, 3), random.real(0.1, 3), random.real(0.1, 3)};
        volume.grid.origin_mm = random.vector(500);
        volume.grid.direction = random.rotation(n % 2 == 0);
        const std::size_t count = voxel_count(volume.grid);
        if (n % 3)
            for (std::int16_t& v : volume.voxels.emplace<0>(count))
                v = std::int16_t(random.whole(-32768, 32767));
        else
            for (float& v : volume.voxels.emplace<1>(count)) v = float(random.real(-1, 1));
        ASSERT_TRUE(write_volume(folder / "a.vti", volume).ok());
        ReadNotes notes;
        const auto again = read_volume(folder / "a.vti", {}, &notes);
        ASSERT_TRUE(again.ok()) << again.error().message;
        EXPECT_EQ(again->grid, volume.grid);
        EXPECT_EQ(again->voxels, volume.voxels);
        EXPECT_TRUE(notes.notes.empty());
    }
}

TEST(ReadVti, TheExtentMayBeginAnywhere) {
    const test::TemporaryFolder folder;
    VtiImage image;
    image.extent = "2 5 -1 1 10 11";
    image.geometry = "Origin=\"0 0 0\" Spacing=\"1 2 3\" Direction=\"0 0 1 1 0 0 0 1 0\"";
    const auto volume = read_volume(folder.write("a.vti", image.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    // The axes point along y, z and x.
    EXPECT_EQ(volume->grid.origin_mm, (Vec3d{30, 2, -2}));
    EXPECT_EQ(world_from_voxel(volume->grid, {1, 0, 0}), (Vec3d{30, 3, -2}));
    EXPECT_EQ(world_from_voxel(volume->grid, {0, 0, 1}), (Vec3d{33, 2, -2}));
}

TEST(ReadVti, TheActiveArrayIsRead) {
    const test::TemporaryFolder folder;
    VtiImage image;
    image.more_arrays =
        "<DataArray type=\"Float32\" Name=\"other\" NumberOfComponents=\"3\" format=\"appended\" "
        "offset=\"0\"/>\n";
    ReadNotes notes;
    const auto volume = read_volume(folder.write("a.vti", image.bytes()), {}, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->at({1, 0, 0}), -99);
    EXPECT_EQ(notes.notes, std::vector<std::string>{"the array 'hu' is read, 1 more left out"});
}

TEST(ReadVti, WhatIsWrongIsSaidInOneLine) {
    const struct {
        std::function<void(VtiImage&)> change;
        const char* expected;
    } cases[] = {
        {[](auto& i) { i.values.pop_back(); }, "has 47 bytes of values, expected 48"},
        {[](auto& i) { i.values.pop_back(), i.compressor = "ZLib"; }, "has 47 bytes of values"},
        {[](auto& i) { i.compressor = "LZMA"; }, "compressor is 'vtkLZMADataCompressor'"},
        {[](auto& i) { i.extent = "0 3 0 2"; }, "WholeExtent is '0 3 0 2', expected six"},
        {[](auto& i) { i.extent = "0 3 0 2 0 1.5"; }, "WholeExtent is"},
        {[](auto& i) { i.extent = "0 3 0 2 0 70000"; }, "expected at most 65536 voxels"},
        {[](auto& i) { i.extent = "3 0 0 2 0 1"; }, "size is -2 × 3 × 2"},
        {[](auto& i) { i.type = "String"; }, "type is 'String'"},
        {[](auto& i) { i.geometry = "Origin=\"0 0 0\" Spacing=\"1 0 1\""; },
         "spacing of axis 2 is 0 mm"},
        {[](auto& i) { i.geometry = "Origin=\"0 0\" Spacing=\"1 1 1\""; }, "Origin is '0 0'"},
        {[](auto& i) { i.geometry = "Direction=\"1 0 0 0.5 1 0 0 0 1\""; },
         "expected perpendicular directions"},
        {[](auto& i) { i.geometry = "Direction=\"1 0 0 1 0 0 0 0 1\""; },
         "expected directions that span the space"},
        {[](auto& i) { i.geometry = "Origin='1 1"; }, "has a damaged XML tag"},
    };
    const test::TemporaryFolder folder;
    for (const auto& c : cases) {
        VtiImage image;
        c.change(image);
        const auto path = folder.write("a.vti", image.bytes());
        const auto volume = read_volume(path);
        ASSERT_FALSE(volume.ok()) << c.expected;
        const std::string& message = volume.error().message;
        EXPECT_TRUE(message.starts_with(path.string() + ": ")) << message;
        EXPECT_NE(message.find(c.expected), message.npos) << message;
        EXPECT_EQ(message.find('\n'), message.npos) << message;
    }
}

TEST(ReadVti, EveryCutOffFileIsRefused) {
    const test::TemporaryFolder folder;
    for (const char* compressor : {"", "ZLib", "LZ4"})
        for (const bool appended : {true, false}) {
            VtiImage image;
            image.compressor = compressor;
            image.appended = appended;
            const std::string bytes = image.bytes();
            const std::size_t data_end =
                bytes.rfind(appended ? "\n  </AppendedData" : "</DataArray>");
            for (std::size_t length = 1; length < data_end; length += 1 + length / 29) {
                const auto volume =
                    read_volume(folder.write("a.vti", std::string_view(bytes).substr(0, length)));
                EXPECT_FALSE(volume.ok()) << compressor << appended << " cut at " << length;
            }
        }
}

TEST(ReadVti, DamagedFilesDoNoHarm) {
    for (const char* compressor : {"", "ZLib", "LZ4"})
        for (const bool appended : {true, false}) {
            VtiImage image;
            image.compressor = compressor;
            image.appended = appended;
            test::read_damaged("a.vti", image.bytes(), 300);
        }
    VtiImage image;
    image.appended = false;
    image.ascii = true;
    image.values = text_of(small_values());
    test::read_damaged("a.vti", image.bytes(), 300);
}

constexpr const char* kVtkHead =
    "# vtk DataFile Version 3.0\na title\n%FORM\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\n"
    "SPACING 1 1 2\nORIGIN 10 20 30\nPOINT_DATA 24\n";

std::string vtk_head(const std::string& form) {
    std::string head = kVtkHead;
    return head.replace(head.find("%FORM"), 5, form);
}

TEST(ReadVtk, TextAndBytesAreRead) {
    const test::TemporaryFolder folder;
    const std::string big = test::swapped(packed(small_values()), 2);
    for (const char* scalars :
         {"SCALARS hu short\nLOOKUP_TABLE default\n", "SCALARS hu short 1\nLOOKUP_TABLE default\n",
          "FIELD FieldData 1\nhu 1 24 short\n"}) {
        expect_small_scan(
            folder.write("a.vtk", vtk_head("ASCII") + scalars + text_of(small_values())), scalars,
            "VTK");
        expect_small_scan(folder.write("a.vtk", vtk_head("BINARY") + scalars + big + "\n"), scalars,
                          "VTK");
    }
}

TEST(ReadVtk, EveryTypeIsRead) {
    const test::TemporaryFolder folder;
    const auto check = [&]<class T>(const char* type, T) {
        std::vector<T> values(24);
        for (std::size_t n = 0; n < 24; ++n) values[n] = T(n + 3);
        const auto volume = read_volume(folder.write(
            "a.vtk", vtk_head("BINARY") + "SCALARS v " + type + "\nLOOKUP_TABLE default\n" +
                         test::swapped(packed(values), sizeof(T))));
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->at({0, 0, 0}), 3) << type;
        EXPECT_EQ(volume->at({3, 2, 1}), 26) << type;
    };
    std::string bytes;
    for (int n = 0; n < 24; ++n) bytes += char(200 + n);
    const auto colours =
        read_volume(folder.write("a.vtk", vtk_head("BINARY") + "COLOR_SCALARS v 1\n" + bytes));
    ASSERT_TRUE(colours.ok()) << colours.error().message;
    EXPECT_EQ(colours->at({3, 2, 1}), 223);
    check("unsigned_char", std::uint8_t());
    check("char", std::int8_t());
    check("unsigned_short", std::uint16_t());
    check("int", std::int32_t());
    check("unsigned_int", std::uint32_t());
    check("long", std::int64_t());
    check("float", float());
    check("double", double());
}

TEST(ReadVtk, WhatIsWrongIsSaidInOneLine) {
    const test::TemporaryFolder folder;
    const std::string start = "# vtk DataFile Version 3.0\nt\nASCII\n";
    const struct {
        std::string text, expected;
    } cases[] = {
        {start + "DATASET POLYDATA\n", "holds a POLYDATA, expected STRUCTURED_POINTS"},
        {start + "DATASET STRUCTURED_POINTS\nDIMENSIONS 4 3\n", "dimensions is '4 3'"},
        {start + "DATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nPOINT_DATA 23\nSCALARS a short\n"
                 "LOOKUP_TABLE default\n1 2",
         "POINT_DATA is '23', expected 24"},
        {vtk_head("ASCII") + "SCALARS a short\nLOOKUP_TABLE default\n1 2", "ends early"},
        {vtk_head("ASCII") + "SCALARS a bit\nLOOKUP_TABLE default\n1 2", "is 'bit'"},
        {vtk_head("BINARY") + "SCALARS a short\nLOOKUP_TABLE default\n12", "ends early"},
        {vtk_head("ASCII") + "SCALARS a short 3\nLOOKUP_TABLE default\n", "3 numbers per voxel"},
        {vtk_head("ASCII") + "COLOR_SCALARS a 1\n0.5 1", "has COLOR_SCALARS in text"},
        {vtk_head("ASCII") + "VECTORS a short\n1 2", "has the keyword 'vectors'"},
        {vtk_head("UTF-8"), "the third line is 'utf-8', expected ASCII or BINARY"},
        {"# vtk DataFile Version 3.0\n", "ends early"},
        {start, "ends early"},
    };
    for (const auto& c : cases) {
        const auto path = folder.write("a.vtk", c.text);
        const auto volume = read_volume(path);
        ASSERT_FALSE(volume.ok()) << c.expected;
        const std::string& message = volume.error().message;
        EXPECT_TRUE(message.starts_with(path.string() + ": ")) << message;
        EXPECT_NE(message.find(c.expected), message.npos) << message;
        EXPECT_EQ(message.find('\n'), message.npos) << message;
    }
}

TEST(ReadVtk, DamagedFilesDoNoHarm) {
    const std::string scalars = "SCALARS hu short\nLOOKUP_TABLE default\n";
    test::read_damaged("a.vtk", vtk_head("ASCII") + scalars + text_of(small_values()), 300);
    test::read_damaged("a.vtk", vtk_head("BINARY") + scalars + packed(small_values()), 300);
}

}  // namespace
}  // namespace pliant
