// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Meshes as other programs write them.
// Covers: meshes/split_polygon.cpp, meshes/parse_off.cpp, mesh/cleaned.cpp.

#include <gtest/gtest.h>
#include <pliant/core/text.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "base/byte_order.h"
#include "meshes/file_numbers.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant {
namespace {

std::string complaint(const auto& result) {
    return result.ok() ? std::string() : result.error().message;
}

/// Little-endian numbers.
template <class T>
std::string bytes(std::vector<T> values) {
    for (T& value : values) value = little_endian(value);
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

using Triangles = std::vector<std::array<std::int32_t, 3>>;

TEST(MeshFiles, AnElementOfATextIsARow) {
    // A surplus number would shift all that follows.
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
    const std::string nodes = "0 0 0\n10 0 0 7\n\n0 10 0\n0 0 10\n";
    const std::string faces = "3 0 2 1 6 0.5 0.5\n3 0 1 3 6 0.25\n3 1 2 3\n3 0 3 2\n";
    const auto mesh = mesh::parse_mesh(head + nodes + faces, "");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->triangles, (Triangles{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}));
    EXPECT_EQ(mesh->notes, (std::vector<std::string>{
                               "rows of element 'vertex' have more numbers than its properties; "
                               "the last ones were ignored",
                               "rows of element 'face' have more numbers than its properties; the "
                               "last ones were ignored"}));
    const auto longer = mesh::parse_mesh(head + nodes + faces + "3 0 1 2\n", "");
    ASSERT_TRUE(longer.ok()) << longer.error().message;
    EXPECT_EQ(longer->triangles.size(), 4u);
    EXPECT_EQ(longer->notes.at(2), "the file is longer than its elements; the rest was ignored");
    EXPECT_EQ(complaint(mesh::parse_mesh(head + "0 0\n" + nodes + faces, "")),
              "element 'vertex' 0: its row has too few numbers");
    EXPECT_EQ(complaint(mesh::parse_mesh(head + nodes + "3 0 x 1\n" + faces, "")),
              "element 'face' 0: its row holds something that is no number");
    EXPECT_EQ(complaint(mesh::parse_mesh(head + nodes + "3 0 2 1\n", "")),
              "element 'face' has 1 rows, expected 4");
    EXPECT_EQ(complaint(mesh::parse_mesh(
                  "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0 9\n3 0 1 0\n"
                  "$EndNodes\n$Elements\n1\n1 2 0 1 2 3\n$EndElements\n",
                  "")),
              "$Nodes has more numbers than its rows should have");
}

TEST(MeshFiles, ParametersOfGmshsNodesAreSkipped) {
    const auto mesh = mesh::parse_mesh(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$ParametricNodes\n4\n1 0 0 0 0 1\n2 10 0 0 1 1 0.5\n"
        "3 0 10 0 2 1 0.5 0.5\n4 0 0 10 3 1\n$EndParametricNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 "
        "4\n$EndElements\n",
        "");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->nodes_mm, (std::vector<Vec3d>{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}}));
    EXPECT_EQ(mesh->tetrahedra, (std::vector<std::array<std::int32_t, 4>>{{0, 1, 2, 3}}));
}

TEST(MeshFiles, LinesOfAnObjGoOnAndHaveComments) {
    const auto mesh = mesh::parse_mesh(
        "v 0 0 0\nv 10 0 \\\n0 # right\nv 0 10 0\nv 0 0 10\nf 1 3 \\\r\n2\nf 1 2 4 # side\n",
        ".obj");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->triangles, (Triangles{{0, 2, 1}, {0, 1, 3}}));
    EXPECT_EQ(mesh->nodes_mm[1], (Vec3d{10, 0, 0}));
    const std::string node = "v 0 0 0\n";
    EXPECT_EQ(complaint(mesh::parse_mesh(node + "f 1 \\\n1 x\n", ".obj")),
              "line 3: expected the numbers of nodes, from 1, behind f, found 'x'");
    EXPECT_EQ(complaint(mesh::parse_mesh(node + "f 1 0 1\n", ".obj")),
              "line 2: expected the numbers of nodes, from 1, behind f, found '0'");
}

TEST(MeshFiles, StlOfOtherProgramsIsRead) {
    const auto capital = mesh::parse_mesh(
        "SOLID A\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 0\n"
        "ENDLOOP\nENDFACET\nENDSOLID\n",
        "");
    ASSERT_TRUE(capital.ok()) << capital.error().message;
    EXPECT_EQ(capital->triangles, (Triangles{{0, 1, 2}}));
    EXPECT_EQ(complaint(mesh::parse_mesh("solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n"
                                         "vertex 0 1 0\nendfacet\nfacet\nvertex 0 0 0\nvertex 1 0 "
                                         "0\nendfacet\n",
                                         ".stl")),
              "facet 1 has 1 vertices more than expected, which is 3");
    const auto binary = [](std::uint32_t count, std::size_t facets, std::string rest) {
        std::string file(80, ' ');
        file += bytes<std::uint32_t>({count});
        for (std::size_t f = 0; f < facets; ++f)
            file +=
                bytes<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, float(f)}) + std::string(2, '\0');
        return mesh::parse_mesh(file + rest, ".stl");
    };
    const auto padded = binary(2, 2, std::string(8, '\0'));
    ASSERT_TRUE(padded.ok()) << padded.error().message;
    EXPECT_EQ(padded->triangles.size(), 2u);
    EXPECT_EQ(padded->notes,
              (std::vector<std::string>{"the file is 8 bytes longer than its facets; the rest was "
                                        "ignored"}));
    const auto uncounted = binary(0, 3, "");
    ASSERT_TRUE(uncounted.ok()) << uncounted.error().message;
    EXPECT_EQ(uncounted->triangles.size(), 3u);
    EXPECT_EQ(
        uncounted->notes,
        (std::vector<std::string>{"the header says 0 facets, but 3 are there; all were read"}));
    EXPECT_EQ(complaint(binary(3, 2, "")),
              "the file ends at byte 184, expected 234 for its 3 facets");
}

/// Area of an OBJ's triangles, all of which must face along `normal`.
double area_facing(const MeshData& mesh, Vec3d normal) {
    double area = 0;
    for (const auto& t : mesh.triangles) {
        const auto at = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(t[n])]; };
        const Vec3d twice = cross(at(1) - at(0), at(2) - at(0));
        EXPECT_GT(dot(twice, normal), 0);
        area += norm(twice) / 2;
    }
    return area;
}

TEST(MeshFiles, ConcavePolygonsAreFilledAndNotFanned) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        // A star around the origin in a turned plane; its area is that of its sectors.
        const Vec3d n = random.vector(1) + Vec3d{0.1, 0.2, 2};
        const Vec3d u = cross(n, Vec3d{1, 0, 0}), v = cross(n, u);
        const int count = random.whole(4, 40);
        std::string nodes, face = "f";
        std::vector<std::array<double, 2>> corners;
        for (int c = 0; c < count; ++c) {
            const double angle = 6.283185307179586 * c / count, r = 1 + random.whole(0, 900) / 100.;
            corners.push_back({r * std::cos(angle), r * std::sin(angle)});
            const Vec3d p =
                (1 / norm(u)) * corners.back()[0] * u + (1 / norm(v)) * corners.back()[1] * v;
            nodes += "v " + text_of(p.x) + " " + text_of(p.y) + " " + text_of(p.z) + "\n";
            face += " " + std::to_string(c + 1);
        }
        double expected = 0;
        for (std::size_t c = 0; c < corners.size(); ++c) {
            const auto& a = corners[c];
            const auto& b = corners[(c + 1) % corners.size()];
            expected += (a[0] * b[1] - a[1] * b[0]) / 2;
        }
        const auto mesh = mesh::parse_mesh(nodes + face, ".obj");
        ASSERT_TRUE(mesh.ok()) << mesh.error().message;
        EXPECT_EQ(mesh->triangles.size(), std::size_t(count) - 2);
        EXPECT_TRUE(mesh->notes.empty());
        EXPECT_NEAR(area_facing(*mesh, cross(u, v)), expected, 1e-9 * expected);
    }
}

TEST(MeshFiles, PolygonsOfEachFormatAreSplitAlike) {
    // An L-shaped prism: 900 mm², 20 mm high.
    const std::vector<std::array<int, 2>> outline{{0, 0},   {40, 0},  {40, 15},
                                                  {20, 15}, {20, 30}, {0, 30}};
    std::string obj;
    for (const int z : {0, 20})
        for (const auto& p : outline)
            obj += "v " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " +
                   std::to_string(z) + "\n";
    obj += "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
    for (int n = 0; n < 6; ++n) {
        const int next = (n + 1) % 6;
        for (const int c : {n, next, next + 6, n + 6})
            obj += (c == n ? "f " : " ") + std::to_string(c + 1);
        obj += "\n";
    }
    const test::TemporaryFolder folder;
    const auto surface = read_surface(folder.write("l.obj", obj));
    ASSERT_TRUE(surface.ok()) << surface.error().message;
    EXPECT_DOUBLE_EQ(enclosed_volume_mm3(*surface), 18000);
    double area = 0;
    for (const auto& t : surface->cells) {
        const auto at = [&](std::size_t n) { return surface->nodes_mm[std::size_t(t[n])]; };
        area += norm(cross(at(1) - at(0), at(2) - at(0))) / 2;
    }
    EXPECT_DOUBLE_EQ(area, 4600);
    // A concave quadrilateral of VTK's type 9, whose fan from corner 0 is wrong.
    MeshData arrow;
    arrow.nodes_mm = {{0, 0, 0}, {2, -3, 0}, {0, 5, 0}, {-2, -3, 0}};
    const std::int64_t corners[] = {1, 2, 3, 0};
    ASSERT_TRUE(mesh::add_cell(arrow, 9, corners).ok());
    EXPECT_DOUBLE_EQ(area_facing(arrow, {0, 0, 1}), 10);
    // A crossing polygon has no ears left.
    MeshData crossed;
    crossed.nodes_mm = {{0, 0, 0}, {4, 0, 0}, {0, 3, 0}, {4, 4, 0}, {5, 0, 0}};
    const std::int64_t all[] = {0, 1, 2, 3, 4};
    ASSERT_TRUE(mesh::add_cell(crossed, 7, all).ok());
    EXPECT_EQ(crossed.triangles.size(), 3u);
    // The time for a concave polygon is bounded.
    MeshData large;
    std::vector<std::int64_t> ring;
    for (std::size_t n = 0; n <= mesh::kMaxConcaveCorners; ++n) {
        const double r = n % 2 ? 5 : 9, angle = 6.283185307179586 * double(n) / 1025;
        large.nodes_mm.push_back({r * std::cos(angle), r * std::sin(angle), 0});
        ring.push_back(std::int64_t(n));
    }
    EXPECT_EQ(complaint(mesh::add_cell(large, 7, ring)),
              "a concave polygon of 1025 corners, expected up to 1024");
    EXPECT_TRUE(mesh::add_cell(large, 7, std::span(ring).first(1000)).ok());
    EXPECT_EQ(large.triangles.size(), 998u);
}

TEST(MeshFiles, OffIsRead) {
    const auto mesh = mesh::parse_mesh(
        "OFF\n# a tetrahedron\n4 4 6\n0 0 0\n10 0 0 # right\n\n0 10 0\n0 0 10\n3 0 2 1\n3 0 1 3 "
        "255 0 0\n3 1 2 3 0.5\n3 0 3 2\n",
        ".off");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->nodes_mm, (std::vector<Vec3d>{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}}));
    EXPECT_EQ(mesh->triangles, (Triangles{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}));
    EXPECT_TRUE(mesh->notes.empty());
    const auto coloured = mesh::parse_mesh(
        "COFF 3 1 0\n0 0 0 1 0 0 1\n1 0 0 0 1 0 1\n0 1 0 0 0 1 1\n3 0 1 2\n9\n", "");
    ASSERT_TRUE(coloured.ok()) << coloured.error().message;
    EXPECT_EQ(coloured->triangles, (Triangles{{0, 1, 2}}));
    EXPECT_EQ(coloured->notes.at(0), "the file is longer than its elements; the rest was ignored");
    EXPECT_EQ(complaint(mesh::parse_mesh("OFF\n2 1 0\n0 0 0\n1 0\n3 0 1 1\n", "")),
              "vertex 1 of 2 has no three numbers");
    EXPECT_EQ(complaint(mesh::parse_mesh("OFF\n1 1 0\n0 0 0\n3 0 0\n", "")),
              "face 0 of 1 has no count and as many numbers of vertices");
    EXPECT_EQ(complaint(mesh::parse_mesh("OFF BINARY\n", "")), "binary OFF, expected text");
    EXPECT_EQ(complaint(mesh::parse_mesh("4OFF\n", "")), "'4OFF', expected OFF of three axes");
}

TEST(MeshFiles, MeditsMeshesAreRead) {
    const auto mesh = mesh::parse_mesh(
        "MeshVersionFormatted 2\n# Mmg\nDimension\n3\n\nVertices\n5\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 "
        "0 "
        "1 1\n1 1 1 1\nCorners\n2\n1\n2\n# comment\nTriangles 1\n1 3 2 7\nEdges 1\n1 2 0\n"
        "Tetrahedra\n2\n1 2 3 4 5\n2 3 4 5 6\nNormalAtVertices 1\n1 1\nEnd\n",
        ".mesh");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->nodes_mm.size(), 5u);
    EXPECT_EQ(mesh->tetrahedra,
              (std::vector<std::array<std::int32_t, 4>>{{0, 1, 2, 3}, {1, 2, 3, 4}}));
    EXPECT_EQ(mesh->triangles, (Triangles{{0, 2, 1}}));
    EXPECT_EQ(mesh->lines, (std::vector<std::vector<std::int32_t>>{{0, 1}}));
    const std::string head = "MeshVersionFormatted 1\nDimension 3\nVertices\n1\n0 0 0 0\n";
    EXPECT_EQ(complaint(mesh::parse_mesh(head + "Hexahedra\n1\n", "")),
              "Hexahedra, expected lines, polygons or linear tetrahedra");
    EXPECT_EQ(complaint(mesh::parse_mesh(head + "5 5 5\n", "")),
              "found '5', expected a keyword such as Vertices");
    EXPECT_EQ(complaint(mesh::parse_mesh(head + "Triangles 1\n1 1\n", "")),
              "Triangles: element 1 has no 3 numbers of nodes and a reference");
    EXPECT_EQ(complaint(mesh::parse_mesh("MeshVersionFormatted 1\nDimension 2\n", "")),
              "Dimension is 2, expected 3");
}

TEST(MeshFiles, OfSecondOrderTheCornersAreTaken) {
    std::string msh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n";
    const std::vector<Vec3d> nodes = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 0, 0},
                                      {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
    for (std::size_t n = 0; n < nodes.size(); ++n)
        msh += std::to_string(n + 1) + " " + text_of(nodes[n].x) + " " + text_of(nodes[n].y) + " " +
               text_of(nodes[n].z) + "\n";
    msh +=
        "$EndNodes\n$Elements\n2\n1 11 0 1 2 3 4 5 6 7 8 9 10\n2 9 0 1 3 2 7 6 5\n$EndElements\n";
    const auto mesh = mesh::parse_mesh(msh, "");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh->tetrahedra, (std::vector<std::array<std::int32_t, 4>>{{0, 1, 2, 3}}));
    EXPECT_EQ(mesh->triangles, (Triangles{{0, 2, 1}}));
    EXPECT_EQ(
        mesh->notes,
        (std::vector<std::string>{"of the cells of second order, only the corners were taken"}));
    MeshData vtk;
    vtk.nodes_mm = nodes;
    const std::int64_t all[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    ASSERT_TRUE(mesh::add_cell(vtk, 24, all).ok());
    EXPECT_EQ(vtk.tetrahedra, mesh->tetrahedra);
    EXPECT_EQ(complaint(mesh::add_cell(vtk, 24, std::span(all).first(9))),
              "a cell of type 24 has 9 nodes, expected 10");
}

TEST(MeshFiles, MirroredTetrahedraAreTurnedAndFoldedOnesStay) {
    const test::TemporaryFolder folder;
    const std::vector<Vec3d> nodes = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}, {10, 10, 10}};
    const auto file_of = [&](std::vector<std::array<int, 4>> cells, Vec3d last) {
        std::string text = "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n";
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            const Vec3d p = n == 4 ? last : nodes[n];
            text += text_of(p.x) + " " + text_of(p.y) + " " + text_of(p.z) + " 0\n";
        }
        text += "Tetrahedra\n" + std::to_string(cells.size()) + "\n";
        for (const auto& c : cells) {
            for (const int n : c) text += std::to_string(n + 1) + " ";
            text += "0\n";
        }
        return folder.write("t.mesh", text);
    };
    const auto volumes = [](const TetMesh& mesh) {
        return std::pair(tet_quality(mesh).inverted, tet_quality(mesh).volume_mm3);
    };
    const std::array<int, 4> a = {0, 1, 2, 3}, b = {1, 2, 3, 4}, a_mirrored = {1, 0, 2, 3},
                             b_mirrored = {2, 1, 3, 4};
    const auto right = read_tetrahedra(file_of({a, b}, nodes[4]));
    ASSERT_TRUE(right.ok()) << right.error().message;
    const auto good = volumes(*right);
    EXPECT_EQ(good.first, 0);
    const std::vector<std::vector<std::array<int, 4>>> orders = {
        {a_mirrored, b_mirrored}, {a, b_mirrored}, {a_mirrored, b}};
    for (const auto& cells : orders) {
        const auto turned = read_mesh(file_of(cells, nodes[4]));
        ASSERT_TRUE(turned.ok()) << turned.error().message;
        EXPECT_EQ(volumes({turned->nodes_mm, turned->tetrahedra}), good);
        ASSERT_EQ(turned->notes.size(), 1u);
        EXPECT_NE(turned->notes[0].find("of 2 tetrahedra have their corners in mirrored order"),
                  std::string::npos);
    }
    // Node 4 pushed a little through the face that both share: the second one is folded.
    const auto folded = read_mesh(file_of({a, b}, {3, 3, 3}));
    ASSERT_TRUE(folded.ok()) << folded.error().message;
    EXPECT_EQ(volumes({folded->nodes_mm, folded->tetrahedra}).first, 1);
    EXPECT_TRUE(folded->notes.empty());
}

TEST(MeshFiles, UnitsAreConvertedAndSmallMeshesRemarkedOn) {
    const test::TemporaryFolder folder;
    const auto file = folder.write("m.obj", "v 0 0 0\nv 0.03 0 0\nv 0 0.04 0\nf 1 2 3\n");
    const auto as_mm = read_mesh(file), as_m = read_mesh(file, 1000);
    ASSERT_TRUE(as_mm.ok() && as_m.ok());
    EXPECT_EQ(as_mm->nodes_mm[1], (Vec3d{0.03, 0, 0}));
    EXPECT_EQ(as_mm->notes,
              (std::vector<std::string>{"the mesh is 0.05 mm across: lengths are in millimetres, "
                                        "and --units m converts metres"}));
    EXPECT_EQ(as_m->nodes_mm[1], (Vec3d{30, 0, 0}));
    EXPECT_TRUE(as_m->notes.empty());
    const auto far = read_mesh(folder.write("f.obj", "v 0 0 20\n"), 1000);
    EXPECT_FALSE(far.ok());
}

TEST(CleanedSurfaces, NearCornersAreJoinedAndRepeatedTrianglesDropped) {
    // A tetrahedron whose triangles have corners of their own.
    const Vec3d p[] = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
    const Triangles faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    test::Random random(3);
    const auto soup = [&](double noise) {
        TriangleMesh mesh;
        for (const auto& f : faces) {
            const auto first = std::int32_t(mesh.nodes_mm.size());
            for (const std::int32_t n : f) {
                const Vec3d off{random.real(-noise, noise), random.real(-noise, noise),
                                random.real(-noise, noise)};
                mesh.nodes_mm.push_back(p[n] + off);
            }
            mesh.cells.push_back({first, first + 1, first + 2});
        }
        return mesh;
    };
    std::vector<std::string> notes;
    const TriangleMesh exact = cleaned(soup(0), &notes);
    EXPECT_TRUE(check_closed(exact).ok());
    EXPECT_TRUE(notes.empty());
    const TriangleMesh near = cleaned(soup(3e-5), &notes);
    EXPECT_TRUE(check_closed(near).ok());
    EXPECT_EQ(near.nodes_mm.size(), 4u);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_TRUE(notes[0].ends_with(": 0 open edges instead of 12")) << notes[0];
    // Too far apart, or a mesh so fine that triangles would collapse.
    notes.clear();
    EXPECT_EQ(cleaned(soup(0.01), &notes).nodes_mm.size(), 12u);
    TriangleMesh fine = soup(3e-5);
    fine.nodes_mm.push_back(fine.nodes_mm[0] + Vec3d{1e-5, 0, 0});
    fine.cells.push_back({0, 12, 1});
    EXPECT_EQ(cleaned(fine, &notes).nodes_mm.size(), 13u);
    EXPECT_TRUE(notes.empty());
    // Copies, whichever corner is first; a triangle that faces the other way is none.
    TriangleMesh twice = exact;
    twice.cells.push_back({exact.cells[0][1], exact.cells[0][2], exact.cells[0][0]});
    twice.cells.push_back(exact.cells[3]);
    const TriangleMesh once = cleaned(twice, &notes);
    EXPECT_EQ(once.cells, exact.cells);
    EXPECT_EQ(notes, (std::vector<std::string>{"2 repeated triangles were dropped"}));
    twice.cells = exact.cells;
    twice.cells.push_back({exact.cells[0][0], exact.cells[0][2], exact.cells[0][1]});
    EXPECT_EQ(cleaned(twice).cells.size(), 5u);
}

}  // namespace
}  // namespace pliant
