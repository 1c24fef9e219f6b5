// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: meshes/parse_*.cpp, meshes/read_mesh.cpp, meshes/write_surface.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <zlib.h>

#include <cstring>
#include <string>

#include "base/byte_order.h"
#include "meshes/file_numbers.h"
#include "support/random.h"
#include "support/temporary_folder.h"
#include "support/triangle_sheet.h"

namespace pliant {
namespace {

TriangleMesh random_surface(std::uint64_t seed) {
    test::Random random(seed);
    TriangleMesh s = test::triangle_sheet(5, 4, 1.3);
    for (Vec3d& p : s.nodes_mm) p = p + random.vector(0.3);
    return s;
}

std::string complaint(const auto& result) {
    return result.ok() ? std::string() : result.error().message;
}

TEST(MeshFiles, SurfacesAreReadBackAsTheyWereWritten) {
    const test::TemporaryFolder folder;
    const TriangleMesh surface = random_surface(3);
    for (const char* name : {"a.vtp", "a.vtu", "a.obj", "a.ply"}) {
        SCOPED_TRACE(name);
        ASSERT_TRUE(write_surface(folder / name, surface).ok());
        const auto read = read_mesh(folder / name);
        ASSERT_TRUE(read.ok()) << read.error().message;
        EXPECT_EQ(read->nodes_mm, surface.nodes_mm);
        EXPECT_EQ(read->triangles, surface.cells);
        // Each says that it is LPS; one that says RAS is turned.
        std::string bytes = test::bytes_of(folder / name);
        if (std::string_view(name) == "a.vtu") continue;
        const bool xml = name[2] == 'v';
        const auto at = xml ? bytes.find("76 80 83 0") : bytes.find("SPACE=LPS");
        ASSERT_NE(at, bytes.npos);
        bytes.replace(at, xml ? 10 : 9, xml ? "82 65 83 0" : "SPACE=RAS");
        const auto turned = mesh::parse_mesh(bytes, std::string(name).substr(1));
        ASSERT_TRUE(turned.ok()) << turned.error().message;
        for (std::size_t n = 0; n < surface.nodes_mm.size(); ++n) {
            const Vec3d p = surface.nodes_mm[n];
            EXPECT_EQ(turned->nodes_mm[n], (Vec3d{-p.x, -p.y, p.z}));
        }
    }
    // STL has single precision, and each triangle its own nodes.
    ASSERT_TRUE(write_surface(folder / "a.stl", surface).ok());
    const auto stl = read_surface(folder / "a.stl");
    ASSERT_TRUE(stl.ok()) << stl.error().message;
    EXPECT_EQ(stl->nodes_mm.size(), surface.nodes_mm.size());
    ASSERT_EQ(stl->cells.size(), surface.cells.size());
    for (std::size_t t = 0; t < surface.cells.size(); ++t)
        for (std::size_t n = 0; n < 3; ++n)
            EXPECT_LT(norm(stl->nodes_mm[std::size_t(stl->cells[t][n])] -
                           surface.nodes_mm[std::size_t(surface.cells[t][n])]),
                      1e-6);
    EXPECT_EQ(complaint(write_surface(folder / "a.xyz", surface)),
              (folder / "a.xyz").string() + ": expected the ending .vtp, .vtu, .stl, .obj or .ply");
}

TEST(MeshFiles, FieldsLinesAndTetrahedraAreReadBack) {
    const test::TemporaryFolder folder;
    const std::vector<Vec3d> nodes{{0, 0, 0}, {1, 0.1, 0}, {2, 0, 0.3}, {5, 5, 5}};
    const std::vector<std::vector<std::int32_t>> lines{{0, 1, 2}, {1, 3}};
    const std::vector<double> radius{1, 2, 3, 4.25};
    ASSERT_TRUE(
        write_lines(folder / "l.vtp", nodes, lines, {{{"u", nodes}}, {{"radius", radius}}}).ok());
    const auto read = read_mesh(folder / "l.vtp");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->lines, lines);
    ASSERT_NE(read->field("radius"), nullptr);
    EXPECT_EQ(read->field("radius")->values, radius);
    EXPECT_EQ(read->field("u")->components, 3u);
    EXPECT_EQ(read->field("u")->values[7], 0);
    EXPECT_EQ(read->field("no"), nullptr);

    const TetMesh block = tet_mesh({{3, 4, 5}, {1, 0.5, 0.3}});
    ASSERT_TRUE(write_vtu(folder / "t.vtu", block).ok());
    const auto tets = read_tetrahedra(folder / "t.vtu");
    ASSERT_TRUE(tets.ok()) << tets.error().message;
    EXPECT_EQ(tets->nodes_mm, block.nodes_mm);
    EXPECT_EQ(tets->cells, block.cells);
    const auto boundary = read_surface(folder / "t.vtu");
    ASSERT_TRUE(boundary.ok());
    EXPECT_NEAR(enclosed_volume_mm3(*boundary), 2 * 1.5 * 1.2, 1e-12);

    const SeriesFile series[] = {{0, "a_0000.vtp"}, {0.033, "a_0001.vtp"}};
    ASSERT_TRUE(write_pvd(folder / "s.pvd", series).ok());
    EXPECT_NE(test::bytes_of(folder / "s.pvd")
                  .find("timestep=\"0.033\" group=\"\" part=\"0\" "
                        "file=\"a_0001.vtp\""),
              std::string::npos);
}

/// The same two tetrahedra in every format and encoding, written down by the formats' rules.
std::string base64(const std::string& bytes) {
    static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t n = 0; n < bytes.size(); n += 3) {
        std::uint32_t word = 0;
        for (std::size_t b = 0; b < 3; ++b)
            word = word << 8 | (n + b < bytes.size() ? std::uint8_t(bytes[n + b]) : 0u);
        for (std::size_t d = 0; d < 4; ++d)
            text += n + d <= bytes.size() ? digits[word >> (18 - 6 * d) & 63] : '=';
    }
    return text;
}
template <class T>
std::string bytes(std::initializer_list<double> values, bool big_endian = false) {
    std::string text;
    for (const double v : values) {
        const T value = little_endian(T(v));
        char copy[sizeof value];
        std::memcpy(copy, &value, sizeof value);
        for (std::size_t b = 0; b < sizeof value; ++b)
            text += copy[big_endian ? sizeof value - 1 - b : b];
    }
    return text;
}
/// Blocks of `block` bytes, as VTK compresses them.
std::string compressed(const std::string& data, std::size_t block, bool apart) {
    std::string head, body;
    std::vector<std::uint32_t> lengths;
    for (std::size_t at = 0; at < data.size(); at += block) {
        const std::string part = data.substr(at, block);
        std::string packed(compressBound(part.size()), '\0');
        uLongf size = packed.size();
        compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                 reinterpret_cast<const Bytef*>(part.data()), part.size());
        lengths.push_back(std::uint32_t(size));
        body += packed.substr(0, size);
    }
    head +=
        bytes<std::uint32_t>({double(lengths.size()), double(block), double(data.size() % block)});
    for (const auto length : lengths) head += bytes<std::uint32_t>({double(length)});
    return apart ? base64(head) + base64(body) : head + body;
}

const std::initializer_list<double> kPlaces = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1.5};
const std::initializer_list<double> kNodes = {0, 1, 2, 3, 1, 2, 3, 4};

void expect_two_tetrahedra(const Result<MeshData>& mesh) {
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    ASSERT_EQ(mesh->nodes_mm.size(), 5u);
    EXPECT_EQ(mesh->nodes_mm[4], (Vec3d{1, 1, 1.5}));
    EXPECT_EQ(mesh->tetrahedra,
              (std::vector<std::array<std::int32_t, 4>>{{0, 1, 2, 3}, {1, 2, 3, 4}}));
}

enum class Way { Base64, Base64Apart, Zlib, AppendedRaw, AppendedZlib };

std::string vtu(Way way) {
    const bool appended = way == Way::AppendedRaw || way == Way::AppendedZlib;
    const bool zlib = way == Way::Zlib || way == Way::AppendedZlib;
    std::string data;
    const auto array = [&](const char* type, const char* name, const std::string& values) {
        const std::string length = bytes<std::uint32_t>({double(values.size())});
        const std::string offset = std::to_string(data.size());
        std::string inside;
        if (appended)
            data += zlib ? compressed(values, 32, false) : length + values;
        else if (zlib)
            inside = compressed(values, 32, true);
        else if (way == Way::Base64)
            inside = base64(length + values);
        else
            inside = base64(length) + base64(values);
        return std::string("<DataArray type=\"") + type + "\" Name=\"" + name +
               "\" NumberOfComponents=\"3\" format=\"" + (appended ? "appended" : "binary") +
               "\" offset=\"" + offset + "\">\n " + inside + "\n</DataArray>\n";
    };
    std::string text = std::string(
                           "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" "
                           "byte_order=\"LittleEndian\"") +
                       (zlib ? " compressor=\"vtkZLibDataCompressor\"" : "") +
                       ">\n<UnstructuredGrid><Piece NumberOfPoints=\"5\" NumberOfCells=\"2\">"
                       "<Points>" +
                       array("Float32", "Points", bytes<float>(kPlaces)) + "</Points><Cells>" +
                       array("Int64", "connectivity", bytes<std::int64_t>(kNodes)) +
                       array("Int32", "offsets", bytes<std::int32_t>({4, 8})) +
                       array("UInt8", "types", bytes<std::uint8_t>({10, 10})) +
                       "</Cells></Piece></UnstructuredGrid>\n";
    if (appended) text += "<AppendedData encoding=\"raw\">\n_" + data + "\n</AppendedData>\n";
    return text + "</VTKFile>\n";
}

std::string legacy(bool binary, bool five) {
    const auto positions =
        binary ? bytes<double>(kPlaces, true) : std::string("0 0 0 1 0 0 0 1 0\n0 0 1 1 1 1.5");
    std::string text = std::string("# vtk DataFile Version ") + (five ? "5.1" : "3.0") + "\ntwo\n" +
                       (binary ? "BINARY" : "ASCII") +
                       "\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n" + positions + "\n";
    if (five)
        text += "CELLS 3 8\nOFFSETS vtktypeint64\n" +
                (binary ? bytes<std::int64_t>({0, 4, 8}, true) : "0 4 8") +
                "\nCONNECTIVITY vtktypeint64\n" +
                (binary ? bytes<std::int64_t>(kNodes, true) : "0 1 2 3 1 2 3 4");
    else
        text += "CELLS 2 10\n" + (binary ? bytes<std::int32_t>({4, 0, 1, 2, 3, 4, 1, 2, 3, 4}, true)
                                         : "4 0 1 2 3\n4 1 2 3 4");
    text += "\nCELL_TYPES 2\n" + (binary ? bytes<std::int32_t>({10, 10}, true) : "10 10");
    return text + "\nPOINT_DATA 5\nSCALARS h float 1\nLOOKUP_TABLE default\n" +
           (binary ? bytes<float>({1, 2, 3, 4, 5}, true) : "1 2 3 4 5") + "\n";
}

std::string msh_1() {
    std::string text = "$NOD\n5\n";
    for (int n = 0; n < 5; ++n) {
        const double* p = kPlaces.begin() + 3 * n;
        text += std::to_string(10 + 3 * n) + " " + std::to_string(p[0]) + " " +
                std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
    }
    return text + "$ENDNOD\n$ELM\n2\n1 4 7 7 4 10 13 16 19\n2 4 7 7 4 13 16 19 22\n$ENDELM\n";
}

std::string msh_2(bool binary) {
    std::string text = std::string("$MeshFormat\n2.2 ") + (binary ? "1 8\n" : "0 8\n") +
                       (binary ? bytes<std::int32_t>({1}) + "\n" : "") +
                       "$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"all\"\n$EndPhysicalNames\n"
                       "$Nodes\n5\n";
    for (int n = 0; n < 5; ++n) {
        const double* p = kPlaces.begin() + 3 * n;
        if (binary)
            text += bytes<std::int32_t>({10.0 + 3 * n}) + bytes<double>({p[0], p[1], p[2]});
        else
            text += std::to_string(10 + 3 * n) + " " + std::to_string(p[0]) + " " +
                    std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
    }
    text += "\n$EndNodes\n$Elements\n2\n";
    if (binary)
        text += bytes<std::int32_t>({4, 2, 2, 1, 7, 7, 10, 13, 16, 19, 2, 7, 7, 13, 16, 19, 22});
    else
        text += "1 4 2 7 7 10 13 16 19\n2 4 2 7 7 13 16 19 22";
    return text + "\n$EndElements\n";
}

std::string msh_4(bool binary) {
    std::string text = std::string("$MeshFormat\n4.1 ") + (binary ? "1 8\n" : "0 8\n") +
                       (binary ? bytes<std::int32_t>({1}) + "\n" : "") + "$EndMeshFormat\n$Nodes\n";
    if (binary)
        text += bytes<std::uint64_t>({1, 5, 10, 22}) + bytes<std::int32_t>({3, 1, 0}) +
                bytes<std::uint64_t>({5, 10, 13, 16, 19, 22}) + bytes<double>(kPlaces);
    else
        text += "1 5 10 22\n3 1 0 5\n10\n13\n16\n19\n22\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1.5\n";
    text += "\n$EndNodes\n$Elements\n";
    if (binary)
        text += bytes<std::uint64_t>({1, 2, 1, 2}) + bytes<std::int32_t>({3, 1, 4}) +
                bytes<std::uint64_t>({2, 1, 10, 13, 16, 19, 2, 13, 16, 19, 22});
    else
        text += "1 2 1 2\n3 1 4 2\n1 10 13 16 19\n2 13 16 19 22\n";
    return text + "\n$EndElements\n";
}

std::string msh_4_0(bool binary) {
    std::string text = std::string("$MeshFormat\n4 ") + (binary ? "1 8\n" : "0 8\n") +
                       (binary ? bytes<std::int32_t>({1}) + "\n" : "") + "$EndMeshFormat\n$Nodes\n";
    // Two blocks: entity 9 of dimension 2 with one node, entity 1 of dimension 3 with four.
    if (binary)
        text += bytes<std::uint64_t>({2, 5});
    else
        text += "2 5\n";
    for (int n = 0; n < 5; ++n) {
        if (n < 2) {
            const double own = n == 0 ? 1 : 4, entity = n == 0 ? 9 : 1, dimension = n == 0 ? 2 : 3;
            text += binary
                        ? bytes<std::int32_t>({entity, dimension, 0}) + bytes<std::uint64_t>({own})
                    : n == 0 ? "9 2 0 1\n"
                             : "1 3 0 4\n";
        }
        const double* p = kPlaces.begin() + 3 * n;
        if (binary)
            text += bytes<std::int32_t>({10.0 + 3 * n}) + bytes<double>({p[0], p[1], p[2]});
        else
            text += std::to_string(10 + 3 * n) + " " + std::to_string(p[0]) + " " +
                    std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
    }
    text += "\n$EndNodes\n$Elements\n";
    if (binary)
        text += bytes<std::uint64_t>({1, 2}) + bytes<std::int32_t>({1, 3, 4}) +
                bytes<std::uint64_t>({2}) +
                bytes<std::int32_t>({1, 10, 13, 16, 19, 2, 13, 16, 19, 22});
    else
        text += "1 2\n1 3 4 2\n1 10 13 16 19\n2 13 16 19 22\n";
    return text + "\n$EndElements\n";
}

std::vector<std::string> all_formats() {
    std::vector<std::string> files;
    for (const Way way :
         {Way::Base64, Way::Base64Apart, Way::Zlib, Way::AppendedRaw, Way::AppendedZlib})
        files.push_back(vtu(way));
    files.push_back(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece "
        "NumberOfPoints=\"5\" NumberOfCells=\"2\"><Points><DataArray type=\"Float32\" "
        "format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1 1 1 1.5</DataArray></Points><Cells>"
        "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 1 2 "
        "3 4</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4 "
        "8</DataArray><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 10"
        "</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>");
    files.push_back(msh_1());
    for (const bool binary : {false, true}) {
        files.push_back(legacy(binary, false));
        files.push_back(legacy(binary, true));
        files.push_back(msh_2(binary));
        files.push_back(msh_4(binary));
        files.push_back(msh_4_0(binary));
    }
    return files;
}

TEST(MeshFiles, NumbersOfCellsAreThoseOfTheTetrahedraAmongThem) {
    const auto file = [](const std::string& cell_data) {
        return "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>"
               "<Piece NumberOfPoints=\"5\" NumberOfCells=\"3\"><Points>"
               "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">"
               "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1</DataArray></Points><Cells>"
               "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">"
               "0 1 2 3 0 1 2 1 4 2 3</DataArray>"
               "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4 7 11</DataArray>"
               "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 5 10</DataArray>"
               "</Cells><CellData>" +
               cell_data + "</CellData></Piece></UnstructuredGrid></VTKFile>";
    };
    const std::string label = "<DataArray type=\"Int16\" Name=\"label\" format=\"ascii\">";
    const auto mesh = mesh::parse_mesh(
        file(label + "7 8 9</DataArray>"
                     "<DataArray type=\"String\" Name=\"text\" format=\"ascii\">a</DataArray>"
                     "<DataArray type=\"Float32\" Name=\"flow\" NumberOfComponents=\"3\" "
                     "format=\"ascii\">1 2 3</DataArray>"),
        ".vtu");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    ASSERT_EQ(mesh->tetrahedra.size(), 2u);
    ASSERT_EQ(mesh->tetrahedron_fields.size(), 1u);
    ASSERT_TRUE(mesh->tetrahedron_field("label"));
    EXPECT_EQ(mesh->tetrahedron_field("label")->values, (std::vector<double>{7, 9}));
    EXPECT_FALSE(mesh->tetrahedron_field("flow"));
    const auto short_one = mesh::parse_mesh(file(label + "7 8</DataArray>"), ".vtu");
    EXPECT_EQ(complaint(short_one), "array 'label' has 2 numbers, expected 3");
    // As this library writes them.
    const test::TemporaryFolder folder;
    const TetMesh block = tet_mesh({.size = {3, 3, 3}});
    std::vector<double> numbers;
    for (std::size_t t = 0; t < block.cells.size(); ++t) numbers.push_back(double(t % 7) - 0.25);
    ASSERT_TRUE(write_vtu(folder / "b.vtu", block, {{}, {{"n", numbers}}}).ok());
    const auto back = read_mesh(folder / "b.vtu");
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->tetrahedron_field("n")->values, numbers);
}

TEST(MeshFiles, EachFormatAndEncodingHoldsTheSameMesh) {
    for (const std::string& file : all_formats()) {
        SCOPED_TRACE(file.substr(0, 120));
        expect_two_tetrahedra(mesh::parse_mesh(file, ""));
    }
    const auto fields = mesh::parse_mesh(legacy(true, true), "");
    ASSERT_NE(fields->field("h"), nullptr);
    EXPECT_EQ(fields->field("h")->values, (std::vector<double>{1, 2, 3, 4, 5}));
}

TEST(MeshFiles, SurfacesOfOthersAreRead) {
    const auto polygons = mesh::parse_mesh(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 5 float\n0 0 0 1 0 0 1 1 0 "
        "0 1 0 2 2 2\nPOLYGONS 1 5\n4 0 1 2 3\nTRIANGLE_STRIPS 1 5\n4 0 1 3 2\nLINES 1 3\n2 0 4\n",
        "");
    ASSERT_TRUE(polygons.ok()) << polygons.error().message;
    EXPECT_EQ(polygons->triangles, (std::vector<std::array<std::int32_t, 3>>{
                                       {0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {3, 1, 2}}));
    EXPECT_EQ(polygons->lines, (std::vector<std::vector<std::int32_t>>{{0, 4}}));
    const auto stl = mesh::parse_mesh(
        "solid a\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n"
        " vertex 1 0 0\n vertex 0 1 0\n endloop\n endfacet\nendsolid",
        ".stl");
    ASSERT_TRUE(stl.ok()) << stl.error().message;
    EXPECT_EQ(stl->triangles.size(), 1u);
    const auto obj =
        mesh::parse_mesh("v 0 0 0\nv 1 0 0\nvn 0 0 1\nv 0 1 0\nv 1 1 0\nf 1/1 2//3 -1 3\n", ".obj");
    ASSERT_TRUE(obj.ok()) << obj.error().message;
    EXPECT_EQ(obj->triangles, (std::vector<std::array<std::int32_t, 3>>{{0, 1, 3}, {0, 3, 2}}));
    const auto ply = mesh::parse_mesh(
        "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty uchar c\n"
        "property float y\nproperty float z\nelement face 1\nproperty list uchar short "
        "vertex_index\nend_header\n" +
            bytes<float>({1}, true) + "c" + bytes<float>({2, 3}, true) + bytes<float>({4}, true) +
            "c" + bytes<float>({5, 6}, true) + bytes<float>({7}, true) + "c" +
            bytes<float>({8, 9}, true) + "\3" + bytes<std::int16_t>({2, 1, 0}, true),
        "");
    ASSERT_TRUE(ply.ok()) << ply.error().message;
    EXPECT_EQ(ply->nodes_mm[1], (Vec3d{4, 5, 6}));
    EXPECT_EQ(ply->triangles, (std::vector<std::array<std::int32_t, 3>>{{2, 1, 0}}));
}

TEST(MeshFiles, DamageIsRefusedInOneLineOrLeavesASoundMesh) {
    auto files = all_formats();
    const test::TemporaryFolder folder;
    for (const char* name : {"a.stl", "a.obj", "a.ply", "a.vtp"}) {
        ASSERT_TRUE(write_surface(folder / name, random_surface(4)).ok());
        files.push_back(test::bytes_of(folder / name));
    }
    int refused = 0;
    const int rounds = 300;
    for (std::size_t f = 0; f < files.size(); ++f)
        for (int round = 0; round < rounds; ++round) {
            SCOPED_TRACE("file " + std::to_string(f) + ", seed " + std::to_string(round));
            test::Random random(1000 * f + std::uint64_t(round));
            std::string file = files[f];
            if (round % 3 == 0) file.resize(std::size_t(random.whole(0, int(file.size()) - 1)));
            for (int n = random.whole(0, 4); n > 0 && !file.empty(); --n)
                file[std::size_t(random.whole(0, int(file.size()) - 1))] =
                    char(random.whole(0, 3) ? random.whole('0', '9') : random.whole(0, 255));
            for (const char* ending : {".obj", ".stl"}) {
                const auto mesh = mesh::parse_mesh(file, ending);
                if (!mesh.ok()) {
                    ++refused;
                    EXPECT_FALSE(mesh.error().message.empty());
                    EXPECT_EQ(mesh.error().message.find('\n'), std::string::npos);
                    continue;
                }
                const auto inside = [&](const auto& cells) {
                    for (const auto& cell : cells)
                        for (const std::int32_t n : cell)
                            if (n < 0 || std::size_t(n) >= mesh->nodes_mm.size()) return false;
                    return true;
                };
                EXPECT_TRUE(inside(mesh->triangles) && inside(mesh->tetrahedra) &&
                            inside(mesh->lines));
                for (const Vec3d& p : mesh->nodes_mm) EXPECT_TRUE(is_finite(p));
                for (const auto& field : mesh->node_fields)
                    EXPECT_EQ(field.values.size(), field.components * mesh->nodes_mm.size());
            }
        }
    EXPECT_GT(refused, int(files.size()) * rounds / 3);
}

TEST(MeshFiles, WhatIsWrongIsSaid) {
    const test::TemporaryFolder folder;
    EXPECT_EQ(complaint(read_mesh(folder / "no.vtp")),
              (folder / "no.vtp").string() + ": expected a file, found none");
    EXPECT_EQ(complaint(read_mesh(folder.write("a.txt", "hello"))),
              (folder / "a.txt").string() +
                  ": expected VTP, VTU, VTK, MSH, STL, OBJ, PLY, OFF or MESH (Medit)");
    EXPECT_EQ(complaint(mesh::parse_mesh("$MeshFormat\n3 0 8\n$EndMeshFormat\n", "")),
              "MSH version '3', expected 2.2, 4.0 or 4.1");
    EXPECT_EQ(complaint(mesh::parse_mesh("v 0 0 0\nf 1 2 3\n", ".obj")),
              "a cell names node 1, expected 0…0");
    // A length that would need 16 GB.
    std::string huge = vtu(Way::Base64);
    huge.replace(huge.find("NumberOfPoints=\"5\""), 18, "NumberOfPoints=\"700000000\"");
    EXPECT_EQ(complaint(mesh::parse_mesh(huge, "")),
              "array 'Points' has 60 bytes, expected 8400000000");
    EXPECT_EQ(complaint(read_tetrahedra(folder.write("a.obj", "v 0 0 0\n"))),
              (folder / "a.obj").string() + ": found no tetrahedra");
}

TEST(MeshFiles, RealMeshesAreRead) {
    const std::filesystem::path data = PLIANT_SHARED_DATA;
    if (!std::filesystem::exists(data / "aorta_surface_segment1_vmtk.vtp"))
        GTEST_SKIP() << "no shared data";
    // Counts and volumes as their README gives them.
    const auto aorta = read_surface(data / "aorta_surface_segment1_vmtk.vtp");
    ASSERT_TRUE(aorta.ok()) << aorta.error().message;
    EXPECT_EQ(aorta->nodes_mm.size(), 6468u);
    EXPECT_EQ(aorta->cells.size(), 12932u);
    EXPECT_TRUE(check_closed(*aorta).ok());
    EXPECT_EQ(surface_topology(*aorta).euler, 2);
    const auto line = read_mesh(data / "aorta_centerline_vmtk.vtp");
    ASSERT_TRUE(line.ok()) << line.error().message;
    EXPECT_EQ(line->lines.size(), 2u);
    ASSERT_NE(line->field("MaximumInscribedSphereRadius"), nullptr);
    const auto liver = read_surface(data / "liver_set" / "liver.vtk");
    ASSERT_TRUE(liver.ok()) << liver.error().message;
    EXPECT_NEAR(std::abs(enclosed_volume_mm3(*liver)) / 1000, 2312, 6);
    const auto tets = read_tetrahedra(data / "liver_set" / "liver_tet.vtu");
    ASSERT_TRUE(tets.ok()) << tets.error().message;
    EXPECT_EQ(tets->nodes_mm.size(), 13311u);
    EXPECT_EQ(tets->cells.size(), 54789u);
    for (const char* name : {"arteries", "portal_vein", "hepatic_veins", "gallbladder"})
        EXPECT_TRUE(read_surface(data / "liver_set" / (std::string(name) + ".vtk")).ok()) << name;
}

}  // namespace
}  // namespace pliant
