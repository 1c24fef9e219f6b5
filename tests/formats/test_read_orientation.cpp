// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One linear field of the world, written on differently placed grids in every format: wherever a
// voxel says it is, its value must be the field's there.
// Covers: formats/*_header.cpp.

#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <cmath>

namespace pliant {
namespace {

constexpr Vec3i kSize{5, 4, 3};

/// Values of the field, at points in LPS [mm].
double field_at(Vec3d x) {
    return 2 * x.x - 3 * x.y + 5 * x.z + 11;
}

/// A turn about an oblique axis; with a mirrored first axis where left-handed.
Mat3d oblique(bool left_handed) {
    const Vec3d k = normalized({0.48, -0.6, 0.64});
    const Vec3d i = normalized(cross(k, {0, 1, 0.3}));
    return {{left_handed ? -i : i, cross(k, i), k}};
}

Grid oblique_grid(bool left_handed) {
    return {kSize, {0.5, 1.25, 3}, {-12.5, 40, 7.75}, oblique(left_handed)};
}

std::vector<float> field_on(const Grid& grid) {
    std::vector<float> values;
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i)
                values.push_back(
                    float(field_at(world_from_voxel(grid, {double(i), double(j), double(k)}))));
    return values;
}

std::string numbers(const char* separator, std::initializer_list<double> values) {
    std::string text;
    for (const double value : values) {
        char buffer[40];
        std::snprintf(buffer, sizeof buffer, "%.17g", value);
        text += (text.empty() ? "" : separator) + std::string(buffer);
    }
    return text;
}

Vec3d flipped(Vec3d v) {
    return {-v.x, -v.y, v.z};
}

void expect_field(const Volume& volume, double tolerance) {
    for (int k = 0; k < volume.grid.size.z; ++k)
        for (int j = 0; j < volume.grid.size.y; ++j)
            for (int i = 0; i < volume.grid.size.x; ++i)
                ASSERT_NEAR(
                    volume.at({i, j, k}),
                    field_at(world_from_voxel(volume.grid, {double(i), double(j), double(k)})),
                    tolerance)
                    << i << ' ' << j << ' ' << k;
}

void expect_grid(const Grid& found, const Grid& expected, double tolerance) {
    EXPECT_EQ(found.size, expected.size);
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(found.spacing_mm[a], expected.spacing_mm[a], tolerance);
        EXPECT_NEAR(found.origin_mm[a], expected.origin_mm[a], 10 * tolerance);
        EXPECT_NEAR(norm(found.direction.columns[a] - expected.direction.columns[a]), 0, tolerance);
    }
}

class OnBothHands : public testing::TestWithParam<bool> {
  protected:
    Grid grid = oblique_grid(GetParam());
    Vec3d step(int a) const { return grid.spacing_mm[a] * grid.direction.columns[a]; }
    test::TemporaryFolder folder;
};
INSTANTIATE_TEST_SUITE_P(Handedness, OnBothHands, testing::Bool());

test::NrrdFile nrrd_of(const Grid& grid, const std::string& space, bool flip) {
    test::NrrdFile file;
    file.type = "float";
    file.sizes = "5 4 3";
    file.space = space;
    file.directions.clear();
    const auto vector = [flip](Vec3d v) {
        if (flip) v = flipped(v);
        return "(" + numbers(",", {v.x, v.y, v.z}) + ")";
    };
    for (int a = 0; a < 3; ++a)
        file.directions += (a ? " " : "") + vector(grid.spacing_mm[a] * grid.direction.columns[a]);
    file.origin = vector(grid.origin_mm);
    file.data = test::packed(field_on(grid));
    return file;
}

TEST_P(OnBothHands, NrrdInLpsIsPlacedExactly) {
    const auto path =
        folder.write("a.nrrd", nrrd_of(grid, "left-posterior-superior", false).bytes());
    const auto volume = read_volume(path);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    expect_grid(volume->grid, grid, 1e-12);
    expect_field(*volume, 1e-4);
}

TEST_P(OnBothHands, NrrdInRasIsConverted) {
    for (const char* space : {"right-anterior-superior", "RAS"}) {
        const auto path = folder.write("a.nrrd", nrrd_of(grid, space, true).bytes());
        ReadNotes notes;
        const auto volume = read_volume(path, {}, &notes);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        expect_grid(volume->grid, grid, 1e-12);
        expect_field(*volume, 1e-4);
        EXPECT_EQ(notes.notes, std::vector<std::string>{"converted from RAS to LPS"});
    }
}

// ITK 5.2 is no help here: it flips the first component of LAS instead of the second.
TEST_P(OnBothHands, NrrdInLasIsConverted) {
    const auto las = [](Vec3d v) { return Vec3d{v.x, -v.y, v.z}; };
    Grid mirrored = grid;
    mirrored.origin_mm = las(grid.origin_mm);
    for (Vec3d& axis : mirrored.direction.columns) axis = las(axis);
    test::NrrdFile file = nrrd_of(mirrored, "left-anterior-superior", false);
    file.data = test::packed(field_on(grid));
    const auto volume = read_volume(folder.write("a.nrrd", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    expect_grid(volume->grid, grid, 1e-12);
    expect_field(*volume, 1e-4);
}

TEST_P(OnBothHands, MetaImageIsPlacedExactly) {
    test::MetaFile file;
    file.type = "MET_FLOAT";
    file.sizes = "5 4 3";
    const auto& c = grid.direction.columns;
    file.matrix =
        numbers(" ", {c[0].x, c[0].y, c[0].z, c[1].x, c[1].y, c[1].z, c[2].x, c[2].y, c[2].z});
    file.offset = numbers(" ", {grid.origin_mm.x, grid.origin_mm.y, grid.origin_mm.z});
    file.spacing = numbers(" ", {grid.spacing_mm.x, grid.spacing_mm.y, grid.spacing_mm.z});
    file.data = test::packed(field_on(grid));
    const auto volume = read_volume(folder.write("a.mha", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    expect_grid(volume->grid, grid, 1e-12);
    expect_field(*volume, 1e-4);
}

test::NiftiFile nifti_of(const Grid& grid) {
    test::NiftiFile file;
    file.dim = {3, 5, 4, 3, 1, 1, 1, 1};
    file.datatype = 16;
    file.bitpix = 32;
    for (std::size_t a = 0; a < 3; ++a) {
        const Vec3d step = flipped(grid.spacing_mm[int(a)] * grid.direction.columns[a]);
        file.pixdim[a + 1] = float(grid.spacing_mm[int(a)]);
        for (std::size_t row = 0; row < 3; ++row) file.sform[4 * row + a] = float(step[int(row)]);
        file.sform[4 * a + 3] = float(flipped(grid.origin_mm)[int(a)]);
    }
    file.data = test::packed(field_on(grid));
    return file;
}

TEST_P(OnBothHands, NiftiSformIsConvertedFromRas) {
    const auto volume = read_volume(folder.write("a.nii", nifti_of(grid).bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    expect_grid(volume->grid, grid, 1e-6);
    expect_field(*volume, 1e-3);
}

TEST_P(OnBothHands, NiftiQformIsConvertedFromRas) {
    test::NiftiFile file = nifti_of(grid);
    file.sform_code = 0;
    file.qform_code = 1;
    file.pixdim[0] = GetParam() ? -1.f : 1.f;  // flips the k axis of a rotation
    // A rotation of known quaternion (a, b, c, d), and the grid that it stands for in LPS.
    const double b = 0.1, c = -0.3, d = 0.5, a = std::sqrt(1 - b * b - c * c - d * d);
    const Vec3d i{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)};
    const Vec3d j{2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)};
    const Vec3d k = GetParam() ? -cross(i, j) : cross(i, j);
    Grid turned = grid;
    turned.direction = {{flipped(i), flipped(j), flipped(k)}};
    file.qform = {float(b),
                  float(c),
                  float(d),
                  float(-turned.origin_mm.x),
                  float(-turned.origin_mm.y),
                  float(turned.origin_mm.z)};
    file.data = test::packed(field_on(turned));
    const auto volume = read_volume(folder.write("a.nii", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    expect_grid(volume->grid, turned, 1e-6);
    expect_field(*volume, 1e-3);
}

TEST_P(OnBothHands, WhatIsWrittenIsReadBackInTheSamePlace) {
    Volume volume{grid, field_on(grid), {{"b", "2"}, {"a", "1"}}};
    for (const char* name : {"a.nrrd", "b.nhdr"}) {
        const auto path = folder.path() / name;
        ASSERT_TRUE(write_volume(path, volume).ok());
        const auto again = read_volume(path);
        ASSERT_TRUE(again.ok()) << again.error().message;
        expect_grid(again->grid, grid, 1e-14);
        EXPECT_EQ(again->voxels, volume.voxels);
    }
}

TEST(ReadDicom, SlicesInAnyOrderAreStackedByPosition) {
    test::TemporaryFolder folder;
    Grid grid = oblique_grid(false);
    grid.spacing_mm = {0.25, 0.5, 2};  // exact in decimal text
    const auto& c = grid.direction.columns;
    const int positions[] = {2, 0, 1};  // file 0 holds slice 2, …
    for (int file = 0; file < 3; ++file) {
        test::DicomFile slice;
        slice.rows = 4;
        slice.columns = 5;
        const int k = positions[file];
        const Vec3d position = world_from_voxel(grid, {0, 0, double(k)});
        slice.position = {position.x, position.y, position.z};
        slice.orientation = {c[0].x, c[0].y, c[0].z, c[1].x, c[1].y, c[1].z};
        slice.spacing = {grid.spacing_mm.y, grid.spacing_mm.x};
        slice.pixels.clear();
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 5; ++i) {
                const Vec3d x = world_from_voxel(grid, {double(i), double(j), double(k)});
                slice.pixels.push_back(std::int16_t(std::lround(field_at(x)) + 1000));
            }
        slice.implicit = file == 1;
        folder.write("slice" + std::to_string(file) + ".dcm", slice.bytes());
    }
    ReadNotes notes;
    const auto volume = read_volume(folder.path(), {}, &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    expect_grid(volume->grid, grid, 1e-9);
    expect_field(*volume, 0.5 + 1e-6);
    EXPECT_TRUE(volume->is_16_bit());
    EXPECT_EQ(notes.format, "DICOM");
    EXPECT_EQ(notes.stored_type, "int16");
}

}  // namespace
}  // namespace pliant
