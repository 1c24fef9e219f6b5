// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NIfTI-2: the fields of NIfTI-1 at other offsets, with doubles and 64-bit numbers.
// Covers: formats/nifti_header.cpp.

#include "base/byte_order.h"
#include "support/damaged_scan.h"
#include "support/random.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>

namespace pliant {
namespace {

using test::packed;

struct Nifti2File {
    std::array<std::int64_t, 8> dim = {3, 4, 3, 2, 1, 1, 1, 1};
    std::int16_t datatype = 4;
    std::array<double, 8> pixdim = {1, 1, 1, 2, 0, 0, 0, 0};
    std::int64_t vox_offset = 544;
    double slope = 0, intercept = 0;
    std::int32_t units = 2, qform_code = 0, sform_code = 1;
    std::array<double, 6> qform = {0, 0, 0, 0, 0, 0};
    std::array<double, 12> sform = {1, 0, 0, 10, 0, 1, 0, 20, 0, 0, 2, 30};
    std::string magic = std::string("n+2\0\r\n\032\n", 8);
    std::string data = packed(test::small_values());
    bool big_endian = false;

    std::string bytes() const {
        std::string header(544, '\0');
        const auto put = [&](std::size_t at, auto value) {
            value = little_endian(value);
            char* const place = &header[at];
            std::memcpy(place, &value, sizeof value);
            if (big_endian) std::reverse(place, place + sizeof value);
        };
        put(0, std::int32_t(540));
        header.replace(4, magic.size(), magic);
        put(12, datatype);
        for (std::size_t n = 0; n < 8; ++n) {
            put(16 + 8 * n, dim[n]);
            put(104 + 8 * n, pixdim[n]);
        }
        put(168, vox_offset);
        put(176, slope);
        put(184, intercept);
        put(344, qform_code);
        put(348, sform_code);
        for (std::size_t n = 0; n < 6; ++n) put(352 + 8 * n, qform[n]);
        for (std::size_t n = 0; n < 12; ++n) put(400 + 8 * n, sform[n]);
        put(500, units);
        return header + data;
    }
};

TEST(Nifti2, IsReadInBothByteOrdersAndCompressed) {
    const test::TemporaryFolder folder;
    for (const bool big : {false, true})
        for (const bool gzip : {false, true}) {
            Nifti2File file;
            file.big_endian = big;
            if (big) file.data = test::swapped(file.data, 2);
            const std::string bytes = gzip ? test::gzipped(file.bytes()) : file.bytes();
            ReadNotes notes;
            const auto volume =
                read_volume(folder.write(gzip ? "a.nii.gz" : "a.nii", bytes), {}, &notes);
            ASSERT_TRUE(volume.ok()) << volume.error().message;
            EXPECT_EQ(notes.format, "NIfTI");
            EXPECT_TRUE(notes.notes.empty());
            EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 2}));
            EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{1, 1, 2}));
            EXPECT_EQ(volume->grid.origin_mm, (Vec3d{-10, -20, 30}));
            EXPECT_EQ(volume->grid.direction, (Mat3d{{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}}));
            for (int n = 0; n < 24; ++n)
                EXPECT_EQ(std::get<0>(volume->voxels)[std::size_t(n)], n - 100);
        }
}

/// The same rotation as a matrix and as a quaternion, which is computed here from axis and angle.
TEST(Nifti2, TheQuaternionIsARotationInDoublePrecision) {
    const test::TemporaryFolder folder;
    test::Random random(5);
    for (int n = 0; n < 50; ++n) {
        const Vec3d axis = normalized(random.vector(1));
        const double angle = n == 0 ? 3.14159265358979323846 : random.real(-3, 3);
        Nifti2File file;
        file.sform_code = 0;
        file.qform_code = 1;
        file.pixdim = {n % 2 ? -1.0 : 1.0, 0.7, 1.3, 2.1, 0, 0, 0, 0};
        const double half = 0.5 * (angle < 0 ? -angle : angle);
        const Vec3d q = std::sin(half) * (angle < 0 ? -axis : axis);
        file.qform = {q.x, q.y, q.z, 11.1, -22.2, 33.3};
        const auto volume = read_volume(folder.write("a.nii", file.bytes()));
        ASSERT_TRUE(volume.ok()) << volume.error().message;
        const Vec3d units[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, n % 2 ? -1.0 : 1.0}};
        for (std::size_t a = 0; a < 3; ++a) {
            // Rodrigues' formula, in RAS.
            const Vec3d v = units[a];
            const Vec3d turned = std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
                                 ((1 - std::cos(angle)) * dot(axis, v)) * axis;
            EXPECT_LT(
                norm(volume->grid.direction.columns[a] - Vec3d{-turned.x, -turned.y, turned.z}),
                n == 0 ? 1e-7 : 1e-14);
        }
        EXPECT_EQ(volume->grid.origin_mm, (Vec3d{-11.1, 22.2, 33.3}));
        EXPECT_EQ(volume->grid.spacing_mm, (Vec3d{0.7, 1.3, 2.1}));
    }
}

TEST(Nifti2, TheSformCountsBeforeTheQform) {
    const test::TemporaryFolder folder;
    Nifti2File file;
    file.qform_code = 1;
    file.qform = {0, 0, 1, 1, 2, 3};
    file.sform_code = 2;
    const auto volume = read_volume(folder.write("a.nii", file.bytes()));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.origin_mm, (Vec3d{-10, -20, 30}));
}

TEST(Nifti2, FramesUnitsAndSlopesAreRead) {
    const test::TemporaryFolder folder;
    Nifti2File file;
    file.dim = {4, 4, 3, 1, 2, 1, 1, 1};
    file.units = 3;
    file.slope = 0.5;
    file.intercept = 1;
    ReadOptions options;
    options.frame = 1;
    const auto volume = read_volume(folder.write("a.nii", file.bytes()), options);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(volume->grid.size, (Vec3i{4, 3, 1}));
    EXPECT_DOUBLE_EQ(volume->grid.spacing_mm.x, 1e-3);
    EXPECT_EQ(volume->at({0, 0, 0}), 0.5F * (12 - 100) + 1);
}

TEST(Nifti2, DamagedFilesDoNoHarm) {
    Nifti2File file;
    file.dim = {4, 4, 3, 1, 2, 1, 1, 1};
    file.qform_code = 1;
    test::read_damaged("a.nii", file.bytes(), 600);
}

TEST(Nifti2, WhatIsWrongIsSaidInOneLine) {
    const struct {
        std::function<void(Nifti2File&)> change;
        const char* expected;
    } cases[] = {
        {[](auto& f) { f.magic = "n+1"; }, "magic is 'n+1', expected 'n+2' (NIfTI-2)"},
        {[](auto& f) { f.magic = "ni2"; },
         "is the header of a NIfTI pair, expected a name that ends in .hdr"},
        {[](auto& f) { f.dim[0] = 8; }, "dim[0] is 8, expected 1 to 7"},
        {[](auto& f) { f.dim[1] = std::int64_t(1) << 62; }, "expected at most 65536 voxels"},
        {[](auto& f) { f.dim[2] = -1; }, "size is 4 × -1 × 2"},
        {[](auto& f) { f.vox_offset = 352; }, "vox_offset is 352, expected 544 or more"},
        {[](auto& f) { f.data.pop_back(); }, "ends early"},
        {[](auto& f) { f.sform[0] = 0; }, "sform has the axis"},
    };
    const test::TemporaryFolder folder;
    for (const auto& c : cases) {
        Nifti2File file;
        c.change(file);
        const auto path = folder.write("a.nii", file.bytes());
        const auto volume = read_volume(path);
        ASSERT_FALSE(volume.ok()) << c.expected;
        EXPECT_TRUE(volume.error().message.starts_with(path.string() + ": "));
        EXPECT_NE(volume.error().message.find(c.expected), std::string::npos)
            << volume.error().message;
    }
}

}  // namespace
}  // namespace pliant
