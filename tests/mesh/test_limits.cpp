// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small files that would take much memory, and messages about files that hold anything.
// Covers: meshes/parse_*.cpp, meshes/vtk_document.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <zlib.h>

#include <string>

#include "base/byte_order.h"
#include "base/memory_budget.h"
#include "support/count_allocations.h"
#include "support/temporary_folder.h"

namespace pliant {
namespace {

class MeshLimits : public testing::Test {
  protected:
    Result<MeshData> read(const std::string& name, const std::string& bytes) {
        return read_mesh(m_folder.write(name, bytes));
    }
    /// Expects that no piece of memory of most_bytes or more is asked for.
    void expect_read_below(std::size_t most_bytes, const std::string& name,
                           const std::string& bytes) {
        const auto path = m_folder.write(name, bytes);
        const test::FailingAllocation failing(0, most_bytes);
        const auto mesh = read_mesh(path);
        EXPECT_TRUE(mesh.ok()) << name << ": " << mesh.error().message;
    }
    void expect_one_short_line(const std::string& name, const std::string& bytes) {
        const auto mesh = read(name, bytes);
        ASSERT_FALSE(mesh.ok()) << name;
        const std::string start = (m_folder / name).string() + ": ";
        ASSERT_TRUE(mesh.error().message.starts_with(start)) << mesh.error().message;
        const std::string reason = mesh.error().message.substr(start.size());
        EXPECT_LE(reason.size(), 400u) << name;
        for (const char c : reason)
            EXPECT_FALSE((c >= 0 && c < ' ') || c == 0x7f) << name << ": " << reason;
    }
    test::TemporaryFolder m_folder;
};

std::string repeated(const std::string& text, int count) {
    std::string result;
    for (int n = 0; n < count; ++n) result += text;
    return result;
}

TEST_F(MeshLimits, EmptyFacesTakeNoMemory) {
    constexpr int kFaces = 1000000;
    const std::string ply =
        "ply\nformat binary_little_endian 1.0\nelement face " + std::to_string(kFaces) +
        "\nproperty list uchar int vertex_indices\nend_header\n" + std::string(kFaces, '\0');
    expect_read_below(4 << 20, "a.ply", ply);
    expect_read_below(4 << 20, "a.obj", repeated("f\n", kFaces));
    const std::string vtk =
        "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\n"
        "POINTS 0 float\nPOLYGONS 250000 250000\n" +
        repeated("0 ", 250000) + "\n";
    expect_read_below(5 << 20, "a.vtk", vtk);
}

TEST_F(MeshLimits, NodesThatAreNotThereTakeNoMemory) {
    const std::string msh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n500000\n" +
                            std::string(1100000, ' ') + "\n$EndNodes\n";
    const auto path = m_folder.write("a.msh", msh);
    const test::FailingAllocation failing(0, 3 << 20);
    const auto mesh = read_mesh(path);
    ASSERT_FALSE(mesh.ok());
    EXPECT_NE(mesh.error().message.find("a position that is not finite"), std::string::npos)
        << mesh.error().message;
}

/// A VTP with points at zero, compressed in one block.
std::string zlib_vtp(std::uint32_t points) {
    const std::uint32_t bytes = 3 * points;
    std::string packed(compressBound(bytes), '\0');
    const std::string zeros(bytes, '\0');
    uLongf size = uLongf(packed.size());
    compress(reinterpret_cast<Bytef*>(packed.data()), &size,
             reinterpret_cast<const Bytef*>(zeros.data()), bytes);
    const std::uint32_t head[4] = {little_endian(1U), little_endian(bytes), 0,
                                   little_endian(std::uint32_t(size))};
    return "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt32\" compressor=\"vtkZLibDataCompressor\"><PolyData>"
           "<Piece NumberOfPoints=\"" +
           std::to_string(points) +
           "\"><Points><DataArray type=\"Int8\" NumberOfComponents=\"3\" format=\"appended\" "
           "offset=\"0\"/></Points></Piece></PolyData><AppendedData encoding=\"raw\">_" +
           std::string(reinterpret_cast<const char*>(head), sizeof head) + packed.substr(0, size) +
           "</AppendedData></VTKFile>";
}

TEST_F(MeshLimits, MeshesLargerThanTheMemoryAreRefused) {
    m_folder.write("machine/proc/meminfo", "MemAvailable: 16384 kB\n");
    const MemorySources small{m_folder / "machine", kUnlimited};
    const auto refused = [&](const std::string& name, const std::string& bytes) {
        const auto mesh = read(name, bytes);
        ASSERT_FALSE(mesh.ok()) << name;
        EXPECT_EQ(mesh.error().code, ErrorCode::LimitExceeded) << mesh.error().message;
        EXPECT_EQ(mesh.error().message,
                  (m_folder / name).string() + ": not enough memory to read it");
    };
    const std::string vtp = zlib_vtp(1000000);  // 3 kB for 24 MB of numbers
    EXPECT_LT(vtp.size(), 10000u);
    EXPECT_TRUE(read("a.vtp", vtp).ok());
    const UseMemorySources use(small);
    EXPECT_TRUE(read("b.vtp", zlib_vtp(100000)).ok());
    refused("a.vtp", vtp);
    refused("nodes.vtp", "<VTKFile type=\"PolyData\">" + repeated("<a/>", 300000) + "</VTKFile>");
    refused("long.stl", "solid a\n" + std::string(9 << 20, ' '));
}

TEST_F(MeshLimits, SmallFilesOfManyNumbersAreRefused) {
    const auto mesh = read("a.vtp", zlib_vtp(17'000'000));
    ASSERT_FALSE(mesh.ok());
    EXPECT_EQ(mesh.error().code, ErrorCode::LimitExceeded);
    EXPECT_NE(mesh.error().message.find("has 51000000 compressed numbers, expected up to 50331648"),
              std::string::npos)
        << mesh.error().message;
}

TEST_F(MeshLimits, NodesMoreThanTenMetresAwayAreRefused) {
    const auto obj = [](const std::string& node) {
        return "v 0 0 0\nv 0 1 0\nv " + node + "\nf 1 2 3\n";
    };
    EXPECT_TRUE(read("a.obj", obj("-6000 0 8000")).ok());
    for (const auto& [node, distance] :
         {std::pair("-6000 0 8000.01", "10000"), std::pair("0 65000 0", "65000"),
          std::pair("1e300 0 0", "1e+300")}) {
        const auto mesh = read("a.obj", obj(node));
        ASSERT_FALSE(mesh.ok()) << node;
        EXPECT_EQ(mesh.error().code, ErrorCode::LimitExceeded);
        EXPECT_EQ(mesh.error().message,
                  (m_folder / "a.obj").string() + ": node 2 is " + distance +
                      " mm from the origin, expected up to 10000; lengths are in millimetres");
    }
}

TEST_F(MeshLimits, DamagedFilesOfTheFirstVersionOfMshAreRefused) {
    const std::string nodes = "$NOD\n2\n1 0 0 0\n2 1 0 0\n$ENDNOD\n";
    const struct {
        std::string text, expected;
    } cases[] = {
        {"$NOD\n99\n1 0 0 0\n$ENDNOD\n", "shorter than it says"},
        {"$NOD\n1\n1 0 0\n$ENDNOD\n", "not finite"},
        {"$NOD\n1\n1 0 0 0\n$EndNOD\n", "'$NOD' has no end"},
        {nodes + "$ELM\n1\n1 1 0 0 3 1 2 1\n$ENDELM\n", "$ELM is damaged at element 0"},
        {nodes + "$ELM\n1\n1 5 0 0 8 1 2 1 2 1 2 1 2\n$ENDELM\n", "Gmsh's type 5"},
        {nodes + "$ELM\n1\n1 1 0 0 2 1 3\n$ENDELM\n", "names node 3"},
        {nodes + "$ELM\n1000\n1 1 0 0 2 1 2\n$ENDELM\n", "$ELM is shorter than it says"},
    };
    for (const auto& c : cases) {
        const auto mesh = read("a.msh", c.text);
        ASSERT_FALSE(mesh.ok()) << c.expected;
        EXPECT_NE(mesh.error().message.find(c.expected), std::string::npos) << mesh.error().message;
    }
}

TEST_F(MeshLimits, MessagesAreOneShortLine) {
    const std::string bell = "\x1b]0;owned\a", longest(200000, 'x');
    for (const std::string& word : {bell, longest, std::string("a\0b", 3)}) {
        expect_one_short_line("a.ply", "ply\nformat " + word + " 1.0\nend_header\n");
        expect_one_short_line("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET " + word);
        expect_one_short_line(
            "b.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 1 " + word +
                         "\n0 0 0\n");
        expect_one_short_line("a.msh", "$MeshFormat\n" + word + " 0 8\n$EndMeshFormat\n");
        expect_one_short_line("b.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$" + word + "\n");
        expect_one_short_line("a.vtp", "<VTKFile type=\"" + word + "\"></VTKFile>");
        expect_one_short_line("b.vtp",
                              "<VTKFile type=\"PolyData\" compressor=\"" + word + "\"></VTKFile>");
    }
}

}  // namespace
}  // namespace pliant
