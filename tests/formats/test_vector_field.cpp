// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: writers/vector_field.cpp.

#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <span>

namespace pliant {
namespace {

VectorField some_field(FieldKind kind) {
    VectorField field;
    field.grid = {{4, 3, 2}, {0.5, 1, 2}, {1, 2, 3}, {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}}};
    field.kind = kind;
    for (int n = 0; n < 24; ++n)
        field.vectors_mm.push_back({0.1f * float(n), -float(n), 1 / (1 + float(n))});
    return field;
}

TEST(VectorField, ComesBackAsItWas) {
    const test::TemporaryFolder folder;
    for (const FieldKind kind : {FieldKind::Modeling, FieldKind::Resampling})
        for (const auto encoding : {Encoding::Gzip, Encoding::Raw})
            for (const char* name : {"u.nrrd", "u.nhdr"}) {
                const VectorField field = some_field(kind);
                const auto path = folder.path() / name;
                ASSERT_TRUE(write_vector_field(path, field, encoding).ok());
                const auto again = read_vector_field(path);
                ASSERT_TRUE(again.ok()) << again.error().message;
                EXPECT_EQ(again->grid, field.grid);
                EXPECT_EQ(again->kind, field.kind);
                EXPECT_EQ(again->vectors_mm, field.vectors_mm);
            }
}

TEST(VectorField, ComesBackFromNifti) {
    const test::TemporaryFolder folder;
    for (const char* name : {"u.nii", "u.nii.gz"}) {
        const VectorField field = some_field(FieldKind::Resampling);
        const auto path = folder.path() / name;
        ASSERT_TRUE(write_vector_field(path, field).ok());
        const auto again = read_vector_field(path);
        ASSERT_TRUE(again.ok()) << again.error().message;
        EXPECT_EQ(again->grid, field.grid);
        EXPECT_EQ(again->vectors_mm, field.vectors_mm);
        EXPECT_EQ(read_volume(path).error().code, ErrorCode::Unsupported);
    }
}

TEST(VectorField, DisplacementsOfNiftiAreRas) {
    const test::TemporaryFolder folder;
    const VectorField field = some_field(FieldKind::Resampling);
    ASSERT_TRUE(write_vector_field(folder / "u.nii", field).ok());
    {
        std::fstream file(folder / "u.nii", std::ios::in | std::ios::out | std::ios::binary);
        const std::int16_t displacements = 1006;
        file.seekp(68);
        file.write(reinterpret_cast<const char*>(&displacements), 2);
    }
    const auto again = read_vector_field(folder / "u.nii");
    ASSERT_TRUE(again.ok()) << again.error().message;
    for (std::size_t n = 0; n < field.vectors_mm.size(); ++n) {
        const Vec3f v = field.vectors_mm[n];
        EXPECT_EQ(again->vectors_mm[n], (Vec3f{-v.x, -v.y, v.z}));
    }
}

TEST(VectorField, IsTheSameSliceBySlice) {
    const test::TemporaryFolder folder;
    const VectorField field = some_field(FieldKind::Resampling);
    for (const auto encoding : {Encoding::Gzip, Encoding::Raw}) {
        int next = 0;
        const auto fill = [&](int k, std::span<Vec3f> slice) {
            EXPECT_EQ(k, next++);
            ASSERT_EQ(slice.size(), 12u);
            for (const Vec3f& vector : slice) EXPECT_EQ(vector, (Vec3f{0, 0, 0}));
            if (k == 1) std::copy_n(field.vectors_mm.begin() + 12, 12, slice.begin());
        };
        ASSERT_TRUE(
            write_vector_field(folder / "u.nrrd", field.grid, field.kind, fill, encoding).ok());
        EXPECT_EQ(next, 2);
        const auto again = read_vector_field(folder / "u.nrrd");
        ASSERT_TRUE(again.ok()) << again.error().message;
        EXPECT_EQ(again->kind, field.kind);
        VectorField expected = field;
        std::fill_n(expected.vectors_mm.begin(), 12, Vec3f{0, 0, 0});
        EXPECT_EQ(again->vectors_mm, expected.vectors_mm);
    }
}

TEST(VectorField, TheHeaderIsThatOfAGridTransform) {
    const test::TemporaryFolder folder;
    const auto path = folder.path() / "u.nrrd";
    for (const FieldKind kind : {FieldKind::Modeling, FieldKind::Resampling}) {
        ASSERT_TRUE(write_vector_field(path, some_field(kind)).ok());
        const std::string bytes = test::bytes_of(path);
        const std::string header = bytes.substr(0, bytes.find("\n\n") + 1);
        const std::string kind_line = kind == FieldKind::Modeling
                                          ? "\ndisplacement field type:=modeling\n"
                                          : "\ndisplacement field type:=resampling\n";
        for (const std::string& line :
             {std::string("\ntype: float\n"), std::string("\ndimension: 4\n"),
              std::string("\nspace: left-posterior-superior\n"), std::string("\nsizes: 3 4 3 2\n"),
              std::string("\nspace directions: none (0,0.5,0) (-1,0,0) (0,0,2)\n"),
              std::string("\nkinds: vector domain domain domain\n"),
              std::string("\nencoding: gzip\n"), std::string("\nspace origin: (1,2,3)\n"),
              kind_line})
            EXPECT_NE(header.find(line), header.npos) << line << "missing in\n" << header;
    }
}

test::NrrdFile field_file(const std::string& space, const std::vector<float>& numbers) {
    test::NrrdFile file;
    file.type = "float";
    file.dimension = "4";
    file.sizes = "3 4 3 2";
    file.kinds = "vector domain domain domain";
    file.directions = "none (1,0,0) (0,1,0) (0,0,2)";
    file.space = space;
    file.data = test::packed(numbers);
    return file;
}

TEST(VectorField, VectorsInRasAreConverted) {
    const test::TemporaryFolder folder;
    std::vector<float> numbers;
    for (int n = 0; n < 24; ++n)
        for (const float v : {1.f, 2.f, 3.f}) numbers.push_back(v);
    const auto field =
        read_vector_field(folder.write("u.nrrd", field_file("RAS", numbers).bytes()));
    ASSERT_TRUE(field.ok()) << field.error().message;
    EXPECT_EQ(field->vectors_mm[5], (Vec3f{-1, -2, 3}));
    EXPECT_EQ(field->grid.origin_mm, (Vec3d{-10, -20, 30}));
    EXPECT_EQ(field->kind, FieldKind::Resampling);  // default of a grid transform without the key
}

TEST(VectorField, OtherFilesAreRefused) {
    const test::TemporaryFolder folder;
    const auto refused = [&](const std::string& name, const std::string& bytes,
                             const char* expected) {
        const auto path = folder.write(name, bytes);
        const auto field = read_vector_field(path);
        ASSERT_FALSE(field.ok()) << name;
        EXPECT_TRUE(field.error().message.starts_with(path.string())) << field.error().message;
        EXPECT_NE(field.error().message.find(expected), std::string::npos) << field.error().message;
    };
    std::vector<float> numbers(72, 1.f);
    refused("scan.nrrd", test::NrrdFile().bytes(), "holds 1 numbers per voxel, expected 3");
    refused("scan.mha", test::MetaFile().bytes(), "holds 1 numbers per voxel, expected 3");
    refused("scan.vti", "<VTKFile/>", "expected a vector field in NRRD");
    auto shorts = field_file("LPS", numbers);
    shorts.type = "short";
    refused("short.nrrd", shorts.bytes(), "expected vectors of float or double");
    auto turned = field_file("LPS", numbers);
    turned.extra = "measurement frame: (0,1,0) (-1,0,0) (0,0,1)\n";
    refused("turned.nrrd", turned.bytes(), "measurement frame");
    numbers[40] = std::numeric_limits<float>::quiet_NaN();
    refused("nan.nrrd", field_file("LPS", numbers).bytes(), "a vector that is no number");
    numbers.resize(71);
    refused("short-data.nrrd", field_file("LPS", numbers).bytes(), "ends early");
    EXPECT_FALSE(read_vector_field(folder.path() / "gone.nrrd").ok());
    const auto as_scan =
        read_volume(folder.write("u.nrrd", field_file("LPS", std::vector<float>(72)).bytes()));
    ASSERT_FALSE(as_scan.ok());
    EXPECT_NE(as_scan.error().message.find("3 numbers per voxel"), std::string::npos);
}

}  // namespace
}  // namespace pliant
