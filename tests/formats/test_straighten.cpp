// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A linear function of the position is interpolated exactly. So a straightened scan of one has its
// values at every voxel that lies inside of the original stack, whatever its slices were like.

#include "support/random.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace pliant {
namespace {

using test::DicomFile;

constexpr Vec3d kSlope{3, -2, 5};

double linear(Vec3d x_mm) {
    return dot(kSlope, x_mm) + 700;
}

ReadOptions straighten() {
    ReadOptions options;
    options.straighten = true;
    return options;
}

std::string error_of(const std::filesystem::path& path, const ReadOptions& options = {}) {
    const auto volume = read_volume(path, options);
    EXPECT_FALSE(volume.ok());
    return volume.ok() ? std::string() : volume.error().message;
}

/// Writes a scan of the linear function with these steps between voxels, as floats.
void write_sheared(const std::filesystem::path& path, Vec3i size, const Mat3d& steps,
                   Vec3d origin) {
    test::NrrdFile file;
    file.type = "float";
    file.sizes =
        std::to_string(size.x) + " " + std::to_string(size.y) + " " + std::to_string(size.z);
    char text[300];
    const auto& c = steps.columns;
    std::snprintf(text, sizeof text, "(%.17g,%.17g,%.17g) (%.17g,%.17g,%.17g) (%.17g,%.17g,%.17g)",
                  c[0].x, c[0].y, c[0].z, c[1].x, c[1].y, c[1].z, c[2].x, c[2].y, c[2].z);
    file.directions = text;
    std::snprintf(text, sizeof text, "(%.17g,%.17g,%.17g)", origin.x, origin.y, origin.z);
    file.origin = text;
    std::vector<float> values;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                values.push_back(
                    float(linear(origin + steps * Vec3d{double(i), double(j), double(k)}) + 0.25));
    file.data = test::packed(values);
    std::ofstream(path, std::ios::binary) << file.bytes();
}

TEST(Straighten, ShearedAxesAreResampled) {
    const test::TemporaryFolder folder;
    test::Random random(21);
    const auto path = folder / "a.nrrd";
    int inside = 0;
    for (int n = 0; n < 30; ++n) {
        SCOPED_TRACE(n);
        const Mat3d turn = random.rotation(n % 2 == 0);
        Mat3d steps = turn;
        for (std::size_t a = 0; a < 3; ++a)
            steps.columns[a] = random.real(0.5, 2) * steps.columns[a];
        if (n % 3 != 1)
            steps.columns[2] = steps.columns[2] + random.real(0.05, 0.6) * turn.columns[0];
        if (n % 3 != 2)
            steps.columns[1] = steps.columns[1] - random.real(0.05, 0.6) * turn.columns[0];
        const Vec3i size{random.whole(4, 9), random.whole(4, 9), random.whole(4, 9)};
        const Vec3d origin = random.vector(50);
        write_sheared(path, size, steps, origin);
        EXPECT_NE(error_of(path).find("--straighten resamples sheared scans"), std::string::npos);
        ReadNotes notes;
        const auto volume = read_volume(path, straighten(), &notes);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        ASSERT_EQ(notes.notes.size(), 2u);
        EXPECT_TRUE(notes.notes[0].starts_with("the axes are sheared by ")) << notes.notes[0];
        EXPECT_TRUE(notes.notes[1].starts_with("straightened: resampled from ")) << notes.notes[1];
        EXPECT_TRUE(check_volume(*volume).ok());
        Volume sheared = *volume;  // of memory, as of the file
        sheared.grid = {size, {}, origin, {}};
        std::vector<float> values;
        for (std::size_t a = 0; a < 3; ++a) {
            sheared.grid.spacing_mm[int(a)] = norm(steps.columns[a]);
            sheared.grid.direction.columns[a] = normalized(steps.columns[a]);
        }
        for (int k = 0; k < size.z; ++k)
            for (int j = 0; j < size.y; ++j)
                for (int i = 0; i < size.x; ++i)
                    values.push_back(float(
                        linear(origin + steps * Vec3d{double(i), double(j), double(k)}) + 0.25));
        sheared.voxels = values;
        const auto again = straightened(sheared);
        ASSERT_TRUE(again.ok()) << again.error().message;
        EXPECT_EQ(again->grid.size, volume->grid.size);
        EXPECT_LT(norm(again->grid.origin_mm - volume->grid.origin_mm), 1e-9);
        EXPECT_NEAR(again->at({1, 1, 1}), volume->at({1, 1, 1}), 2e-4);
        EXPECT_EQ(straightened(*again)->grid.direction, again->grid.direction);
        EXPECT_EQ(determinant(volume->grid.direction) > 0, n % 2 != 0);
        const Mat3d back = inverse(steps);
        int found = 0;
        const Vec3i s = volume->grid.size;
        for (int k = 0; k < s.z; ++k)
            for (int j = 0; j < s.y; ++j)
                for (int i = 0; i < s.x; ++i) {
                    const Vec3d x =
                        world_from_voxel(volume->grid, {double(i), double(j), double(k)});
                    const Vec3d ijk = back * (x - origin);
                    bool is_inside = true;
                    for (int a = 0; a < 3; ++a)
                        is_inside = is_inside && ijk[a] >= -1e-9 && ijk[a] <= size[a] - 1 + 1e-9;
                    if (!is_inside) continue;
                    ++found;
                    ASSERT_NEAR(double(volume->at({i, j, k})), linear(x) + 0.25, 2e-4);
                }
        EXPECT_GT(found, 10);
        inside += found;
        // Every voxel of the stack is within the new grid.
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3d at =
                origin + steps * Vec3d{corner & 1 ? size.x - 1.0 : 0, corner & 2 ? size.y - 1.0 : 0,
                                       corner & 4 ? size.z - 1.0 : 0};
            const Vec3d ijk = voxel_from_world(volume->grid, at);
            for (int a = 0; a < 3; ++a) {
                EXPECT_GE(ijk[a], -1e-6);
                EXPECT_LE(ijk[a], s[a] - 1 + 1e-6);
            }
        }
    }
    EXPECT_GT(inside, 1000);
}

/// Slices of ten times the linear function, in parts of 128, turned about the x axis.
void write_slices(const test::TemporaryFolder& folder, const std::vector<Vec3d>& shifts) {
    const double c = std::cos(0.3), s = std::sin(0.3);
    const Vec3d column{0, c, s}, normal{0, -s, c};
    int n = 0;
    for (const Vec3d shift : shifts) {
        DicomFile slice;
        slice.spacing = {0.5, 0.25};
        slice.rows = 9;
        slice.columns = 11;
        slice.orientation = {1, 0, 0, 0, c, s};
        slice.slope = "0.0078125";  // exact in binary
        slice.intercept = "0";
        const Vec3d at = Vec3d{shift.x, 0, 0} + shift.y * column + shift.z * normal;
        slice.position = {at.x, at.y, at.z};
        slice.pixels.clear();
        for (int j = 0; j < 9; ++j)
            for (int i = 0; i < 11; ++i) {
                const Vec3d x = at + Vec3d{0.25 * i, 0, 0} + (0.5 * j) * column;
                slice.pixels.push_back(std::int16_t(std::lround(10 * linear(x))));
            }
        folder.write("s" + std::to_string(100 + n++) + ".dcm", slice.bytes());
    }
}

TEST(Straighten, ATiltedGantryIsResampled) {
    const test::TemporaryFolder folder;
    write_slices(folder, {{0, 0, 0}, {0, 0.5, 1}, {0, 1, 2}, {0, 1.5, 3}, {0, 2, 4}});
    EXPECT_NE(error_of(folder.path()).find("leans by 26.6 degrees (gantry tilt)"),
              std::string::npos);
    EXPECT_NE(error_of(folder.path()).find("(--straighten resamples them)"), std::string::npos);
    ReadNotes notes;
    const auto volume = read_volume(folder.path(), straighten(), &notes);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    // The lean of 0.5 mm a slice is one row.
    EXPECT_EQ(volume->grid.size, (Vec3i{11, 13, 5}));
    EXPECT_EQ(notes.notes, (std::vector<std::string>{
                               "the stack of slices leans by 26.6 degrees (gantry tilt)",
                               "straightened: resampled from 11 × 9 × 5 to 11 × 13 × 5 voxels"}));
    // So every row lies on a row of its slice, or beyond it, where the smallest value is.
    const auto value_at = [&](int i, int j, int k) {
        const Vec3d x = world_from_voxel(volume->grid, {double(i), double(j), double(k)});
        return std::round(10 * linear(x)) / 128;
    };
    double lowest = 1e9;
    for (int k = 0; k < 5; ++k)
        for (int j = k; j < k + 9; ++j)
            for (int i = 0; i < 11; ++i) lowest = std::min(lowest, value_at(i, j, k));
    for (int k = 0; k < 5; ++k)
        for (int j = 0; j < 13; ++j)
            for (int i = 0; i < 11; ++i)
                ASSERT_NEAR(double(volume->at({i, j, k})),
                            j >= k && j < k + 9 ? value_at(i, j, k) : lowest, 1e-3);
}

TEST(Straighten, MissingAndUnequalSlicesAreFilled) {
    for (const auto& heights :
         {std::vector<double>{0, 1, 2, 5, 6}, {0, 1, 2, 3.4, 4.4}, {0, 0.9, 2.2, 3, 4.4}}) {
        const test::TemporaryFolder folder;
        std::vector<Vec3d> shifts;
        for (const double height : heights) shifts.push_back({0, 0, height});
        write_slices(folder, shifts);
        EXPECT_NE(error_of(folder.path()).find("--straighten"), std::string::npos);
        ReadNotes notes;
        const auto volume = read_volume(folder.path(), straighten(), &notes);
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(notes.notes.size(), 2u);
        const Grid& grid = volume->grid;
        EXPECT_EQ(grid.size.x, 11);
        EXPECT_EQ(grid.size.y, 9);
        EXPECT_NEAR(grid.spacing_mm.z * (grid.size.z - 1), heights.back(), 1e-9);
        for (int k = 0; k < grid.size.z; ++k)
            for (int j = 0; j < 9; ++j)
                for (int i = 0; i < 11; ++i) {
                    const Vec3d x = world_from_voxel(grid, {double(i), double(j), double(k)});
                    ASSERT_NEAR(double(volume->at({i, j, k})), 10 * linear(x) / 128, 0.0040);
                }
    }
}

TEST(Straighten, ARegularScanIsLeftAsItIs) {
    const test::TemporaryFolder folder;
    write_slices(folder, {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}});
    const auto plain = read_volume(folder.path()), same = read_volume(folder.path(), straighten());
    ASSERT_TRUE(plain.ok() && same.ok());
    EXPECT_EQ(plain->grid, same->grid);
    EXPECT_EQ(plain->voxels, same->voxels);
}

TEST(Straighten, DoubleSlicesAreRefusedAllTheSame) {
    const test::TemporaryFolder folder;
    write_slices(folder, {{0, 0, 0}, {0, 0, 1}, {0.1, 0, 1}});
    EXPECT_NE(error_of(folder.path(), straighten()).find("two slices are at the same position"),
              std::string::npos);
}

TEST(Straighten, AResultThatIsMuchLargerIsRefused) {
    const test::TemporaryFolder folder;
    test::NrrdFile file;
    file.sizes = "40 30 30";
    file.directions = "(0.001,0,0) (0,1,0) (1,0,1)";
    file.data = std::string(40 * 30 * 30 * 2, 'x');
    const auto path = folder.write("a.nrrd", file.bytes());
    EXPECT_EQ(error_of(path, straighten()),
              path.string() +
                  ": straightened it would have 26136000 voxels, expected at most 16 "
                  "times its 36000");
}

TEST(Straighten, HounsfieldUnitsAreFilledWithAirAndOtherValuesWithTheirSmallest) {
    const test::TemporaryFolder folder;
    test::NrrdFile file;
    file.directions = "(1,0,0) (0,1,0) (1,0,2)";
    for (const int lowest : {-100, 40}) {
        std::vector<std::int16_t> values(24, 500);
        values[5] = std::int16_t(lowest);
        file.data = test::packed(values);
        const auto volume = read_volume(folder.write("a.nrrd", file.bytes()), straighten());
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        EXPECT_EQ(volume->grid.size, (Vec3i{5, 3, 2}));
        EXPECT_EQ(volume->at({4, 0, 0}), lowest < 0 ? -1000 : 40) << "beyond the first slice";
        EXPECT_EQ(volume->at({4, 0, 1}), 500);
    }
}

}  // namespace
}  // namespace pliant
