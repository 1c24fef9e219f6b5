// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: meshes/write_vtu.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>

#include <cstring>
#include <string>

#include "support/random.h"
#include "support/temporary_folder.h"
#include "support/triangle_sheet.h"

namespace pliant {
namespace {

/// The numbers of an array, by the format's rules: text from its offset, a length, the bytes.
template <class T>
std::vector<T> array_of(const std::string& file, const std::string& name) {
    const auto attribute = file.find("Name=\"" + name + "\"");
    if (attribute == file.npos) return {};
    const std::string key = "offset=\"";
    const auto offset = std::stoul(file.substr(file.find(key, attribute) + key.size()));
    std::string bytes;
    std::uint32_t word = 0;
    int digits = 0;
    for (auto at = file.find("\n_") + 2 + offset; file[at] != '\n'; ++at) {
        static const std::string kDigits =
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        const auto digit = kDigits.find(file[at]);
        word = word << 6 | std::uint32_t(digit == kDigits.npos ? 0 : digit);
        if (++digits % 4) continue;
        for (int shift = 16; shift >= 0; shift -= 8) bytes += char(word >> shift & 255);
        std::uint64_t length = 0;
        if (bytes.size() < sizeof length) continue;
        std::memcpy(&length, bytes.data(), sizeof length);
        if (bytes.size() < sizeof length + length) continue;
        std::vector<T> values(length / sizeof(T));
        std::memcpy(values.data(), bytes.data() + sizeof length, length);
        return values;
    }
    return {};
}

TEST(WriteVtu, WhatIsWrittenIsReadBackBitForBit) {
    test::Random random(7);
    const test::TemporaryFolder folder;
    const HexMesh mesh = hex_mesh({{4, 3, 2}, {0.3, 0.7, 1.1}, {-3, 5, 8}});
    std::vector<Vec3d> u(mesh.nodes_mm.size());
    for (Vec3d& v : u) v = random.vector(1);
    std::vector<double> energy(mesh.cells.size());
    for (double& e : energy) e = random.real(0, 1);
    ASSERT_TRUE(write_vtu(folder / "a.vtu", mesh, {{{"u <\"&", u}}, {{"energy", energy}}}).ok());
    const std::string file = test::bytes_of(folder / "a.vtu");
    EXPECT_EQ(array_of<Vec3d>(file, "Points"), mesh.nodes_mm);
    EXPECT_EQ(array_of<Vec3d>(file, "u &lt;&quot;&amp;"), u);
    EXPECT_EQ(array_of<double>(file, "energy"), energy);
    EXPECT_EQ((array_of<std::array<std::int32_t, 8>>(file, "connectivity")), mesh.cells);
    EXPECT_EQ(array_of<std::uint8_t>(file, "types"), std::vector<std::uint8_t>(6, 12));
    EXPECT_EQ(array_of<std::int64_t>(file, "offsets"),
              (std::vector<std::int64_t>{8, 16, 24, 32, 40, 48}));
}

TEST(WriteVtu, TetrahedraAndTrianglesHaveTheirOwnTypes) {
    const test::TemporaryFolder folder;
    ASSERT_TRUE(write_vtu(folder / "t.vtu", tet_mesh({})).ok());
    EXPECT_EQ(array_of<std::uint8_t>(test::bytes_of(folder / "t.vtu"), "types"),
              std::vector<std::uint8_t>(6, 10));
    ASSERT_TRUE(write_vtu(folder / "s.vtu", test::triangle_sheet(2, 2, 1)).ok());
    const std::string file = test::bytes_of(folder / "s.vtu");
    EXPECT_EQ(array_of<std::uint8_t>(file, "types"), std::vector<std::uint8_t>(2, 5));
    EXPECT_EQ(array_of<std::int64_t>(file, "offsets"), (std::vector<std::int64_t>{3, 6}));
}

TEST(WriteVtu, AFieldOfAnotherLengthIsRefusedAndNothingAppears) {
    const test::TemporaryFolder folder;
    const std::vector<Vec3d> u(7);
    const auto path = folder / "a.vtu";
    const Status status = write_vtu(path, hex_mesh({}), {{{"u", u}}});
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().message,
              path.string() + ": field 'u' has 7 values, expected 8, one for each node");
    HexMesh mesh = hex_mesh({});
    mesh.cells[0][3] = 8;
    EXPECT_EQ(write_vtu(path, mesh).error().message,
              path.string() + ": cell 0 names node 8, expected one of 8");
    EXPECT_FALSE(std::filesystem::exists(path));
    EXPECT_EQ(write_vtu(folder / "missing/a.vtu", hex_mesh({})).error().code,
              ErrorCode::Unwritable);
}

}  // namespace
}  // namespace pliant
