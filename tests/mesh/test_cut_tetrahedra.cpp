// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: mesh/cut_part.cpp.

#include <gtest/gtest.h>
#include <pliant/models/cut_mesh.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>

#include "support/count_allocations.h"
#include "support/random.h"

namespace pliant {
namespace {

using test::Random;

TetMesh block(int cells, double side_mm = 1) {
    return tet_mesh(
        {.size = {cells + 1, cells + 1, cells + 1}, .spacing_mm = {side_mm, side_mm, side_mm}});
}

/// A block whose inner nodes are moved at random.
TetMesh shaken_block(int cells, Random& random) {
    TetMesh mesh = block(cells);
    for (Vec3d& x : mesh.nodes_mm)
        for (int a = 0; a < 3; ++a)
            if (x[a] > 0 && x[a] < cells) x[a] += random.real(-0.15, 0.15);
    return mesh;
}

double volume_of(const TetMesh& mesh, std::size_t cell) {
    const auto& c = mesh.cells[cell];
    const auto at = [&](std::size_t k) { return mesh.nodes_mm[std::size_t(c[k])]; };
    return dot(cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)) / 6;
}

struct Plane {
    Vec3d normal;
    double level;
};

/// A ribbon along a plane that reaches 100 mm around its point next to `near`.
CutSurface ribbon_along(const Plane& plane, Vec3d near) {
    const Vec3d n = plane.normal;
    const Vec3d u =
        normalized(cross(n, std::abs(n.x) < 0.5 * norm(n) ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
    const Vec3d v = normalized(cross(n, u));
    const Vec3d o = near + ((plane.level - dot(n, near)) / dot(n, n)) * n;
    return {{o - 100.0 * u - 100.0 * v, o + 100.0 * u - 100.0 * v}, 200.0 * v};
}

Plane random_plane(Random& random, double side) {
    const Vec3d n = normalized(random.vector(1));
    const Vec3d through{random.real(0.25, 0.75) * side, random.real(0.25, 0.75) * side,
                        random.real(0.25, 0.75) * side};
    return {n, dot(n, through)};
}

/// Volume of the part of a cube [0, side]³ above a plane, by inclusion and exclusion.
double cube_above(Plane plane, double side) {
    Vec3d n = -plane.normal;
    double d = -plane.level;  // n·x < d
    for (int a = 0; a < 3; ++a)
        if (n[a] < 0) {
            d -= n[a] * side;
            n[a] = -n[a];
        }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double left = d, sign = 1;
        for (int a = 0; a < 3; ++a)
            if (corner >> a & 1) {
                left -= n[a] * side;
                sign = -sign;
            }
        sum += sign * std::pow(std::max(left, 0.0), 3);
    }
    return sum / (6 * n.x * n.y * n.z);
}

CutMesh cut_once(const TetMesh& mesh, const CutSurface& surface) {
    auto cut = cut_tetrahedra(mesh, mesh.nodes_mm, surface);
    EXPECT_TRUE(cut.ok()) << cut.error().message;
    return std::move(cut).value();
}
CutMesh cut_again(const CutMesh& before, const CutSurface& surface) {
    auto cut = cut_tetrahedra(before, before.mesh.nodes_mm, surface);
    EXPECT_TRUE(cut.ok()) << cut.error().message;
    return std::move(cut).value();
}

/// [piece] volume of its material.
std::vector<double> piece_volumes(const CutMesh& cut) {
    const auto piece = pieces(cut.mesh);
    std::vector<double> volumes(std::size_t(cut.pieces), 0);
    for (std::size_t c = 0; c < cut.mesh.cells.size(); ++c)
        volumes[std::size_t(piece[std::size_t(cut.mesh.cells[c][0])])] +=
            cut.shares[c] * volume_of(cut.mesh, c);
    return volumes;
}

/// Expects a closed polyhedron with the volume of the share.
void expect_polyhedron(const CutPart& part, double share, double tolerance) {
    std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
    double volume = 0;
    for (const CutPart::Face& face : part.faces) {
        const auto at = [&](std::int32_t n) {
            const auto& w =
                part.points[std::size_t(part.loops[std::size_t(face.begin + n)])].weights;
            return Vec3d{w[0], w[1], w[2]};
        };
        const std::int32_t size = face.end - face.begin;
        for (std::int32_t n = 0; n < size; ++n) {
            const std::int32_t a = part.loops[std::size_t(face.begin + n)];
            const std::int32_t b = part.loops[std::size_t(face.begin + (n + 1) % size)];
            edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
            if (n > 1) volume -= dot(at(0), cross(at(n - 1), at(n)));
        }
    }
    for (const auto& [edge, balance] : edges) EXPECT_EQ(balance, 0);
    EXPECT_NEAR(volume, share, tolerance);
}

/// Expects the properties of every mesh with cuts.
void expect_consistent(const CutMesh& cut, const TetMesh& uncut, double tolerance = 1e-6) {
    const std::size_t nodes = uncut.nodes_mm.size(), cells = uncut.cells.size();
    ASSERT_EQ(cut.uncut_node_of.size(), cut.mesh.nodes_mm.size());
    ASSERT_EQ(cut.node_of.size(), cut.mesh.nodes_mm.size());
    ASSERT_EQ(cut.cell_of.size(), cut.mesh.cells.size());
    std::vector<double> total(cells, 0);
    for (std::size_t c = 0; c < cut.mesh.cells.size(); ++c) {
        const auto old = std::size_t(cut.uncut_cell_of[c]);
        if (c < cells) {
            EXPECT_EQ(old, c);
        }
        total[old] += cut.shares[c];
        if (cut.part_of[c] >= 0)
            expect_polyhedron(cut.parts[std::size_t(cut.part_of[c])], cut.shares[c], tolerance);
        else
            EXPECT_EQ(cut.shares[c], 1);
        for (std::size_t k = 0; k < 4; ++k) {
            const auto n = std::size_t(cut.mesh.cells[c][k]);
            EXPECT_EQ(cut.uncut_node_of[n], uncut.cells[old][k]);
            EXPECT_EQ(cut.mesh.nodes_mm[n], uncut.nodes_mm[std::size_t(uncut.cells[old][k])]);
        }
    }
    for (std::size_t c = 0; c < cells; ++c) ASSERT_NEAR(total[c], 1, 1e-12) << c;
    for (std::size_t n = 0; n < nodes; ++n) EXPECT_EQ(cut.uncut_node_of[n], std::int32_t(n));
    const auto volumes = cut.node_volumes_mm3();
    double volume = 0;
    for (std::size_t c = 0; c < cells; ++c) volume += volume_of(uncut, c);
    EXPECT_NEAR(std::accumulate(volumes.begin(), volumes.end(), 0.0), volume, 1e-12 * volume);
    for (std::size_t n = 0; n < volumes.size(); ++n)
        EXPECT_GT(volumes[n], 0) << "unused node " << n;
    const auto piece = pieces(cut.mesh);
    EXPECT_EQ(*std::max_element(piece.begin(), piece.end()) + 1, cut.pieces);
}

std::array<double, 4> random_weights(Random& random, int count) {
    std::array<double, 4> w{};
    double sum = 0;
    for (int k = 0; k < count; ++k) sum += w[std::size_t(k)] = -std::log(random.real(1e-9, 1));
    for (double& x : w) x /= sum;
    return w;
}

Vec3d blend(const std::array<double, 4>& w, const std::array<Vec3d, 4>& x) {
    return w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3];
}

/// Brute force: within a tetrahedron the material with the same sides of all planes is convex, so
/// it is connected; it is connected with that of a neighbour if the common face, clipped by the
/// planes, has a region with these sides. Each plane is given by its levels at the nodes, in the
/// shape that it cut.
class Oracle {
  public:
    struct Sample {
        std::int32_t cell;
        Vec3d rest_mm;
        int component;
    };

    Oracle(const TetMesh& mesh, Random& random, const std::vector<std::vector<double>>& levels)
        : m_levels(levels) {
        std::map<std::array<std::int32_t, 3>, std::vector<std::int32_t>> at_face;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const auto& nodes = mesh.cells[c];
            for (std::size_t side = 0; side < 4; ++side) {
                std::array<std::int32_t, 3> face;
                for (std::size_t k = 0; k < 3; ++k) face[k] = nodes[(side + 1 + k) % 4];
                std::sort(face.begin(), face.end());
                at_face[face].push_back(std::int32_t(c));
            }
            std::array<Vec3d, 4> x;
            for (std::size_t k = 0; k < 4; ++k) x[k] = mesh.nodes_mm[std::size_t(nodes[k])];
            for (int n = 0; n < 20; ++n) {
                const auto w = random_weights(random, 4);
                int sides = 0;
                for (std::size_t p = 0; p < levels.size(); ++p) {
                    double level = 0;
                    for (std::size_t k = 0; k < 4; ++k)
                        level += w[k] * levels[p][std::size_t(nodes[k])];
                    sides |= int(level > 0) << p;
                }
                m_samples.push_back({std::int32_t(c), blend(w, x), id(c, sides)});
            }
        }
        for (const auto& [face, cells] : at_face)
            if (cells.size() == 2) connect(face, cells, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, 0, 0);
        for (Sample& sample : m_samples) sample.component = root(sample.component);
    }

    const std::vector<Sample>& samples() const { return m_samples; }

  private:
    /// Connects two tetrahedra through the regions of a polygon on their face, in barycentric
    /// coordinates, that the planes from `plane` on leave.
    void connect(const std::array<std::int32_t, 3>& face, const std::vector<std::int32_t>& cells,
                 const std::vector<Vec3d>& polygon, std::size_t plane, int sides) {
        double area = 0;
        for (std::size_t n = 1; n + 1 < polygon.size(); ++n)
            area += norm(cross(polygon[n] - polygon[0], polygon[n + 1] - polygon[0]));
        if (area < 1e-7) return;
        if (plane == m_levels.size()) {
            unite(id(std::size_t(cells[0]), sides), id(std::size_t(cells[1]), sides));
            return;
        }
        const auto& levels = m_levels[plane];
        const Vec3d at{levels[std::size_t(face[0])], levels[std::size_t(face[1])],
                       levels[std::size_t(face[2])]};
        for (const int above : {0, 1}) {
            std::vector<Vec3d> part;
            for (std::size_t n = 0; n < polygon.size(); ++n) {
                const Vec3d p = polygon[n], q = polygon[(n + 1) % polygon.size()];
                const double lp = dot(at, p), lq = dot(at, q);
                if ((lp > 0) == (above == 1)) part.push_back(p);
                if ((lp > 0) != (lq > 0)) part.push_back(p + (lp / (lp - lq)) * (q - p));
            }
            connect(face, cells, part, plane + 1, sides | above << plane);
        }
    }

    int id(std::size_t cell, int sides) {
        const auto [found, is_new] = m_ids.try_emplace({cell, sides}, int(m_parent.size()));
        if (is_new) m_parent.push_back(found->second);
        return found->second;
    }
    int root(int n) {
        while (m_parent[std::size_t(n)] != n) n = m_parent[std::size_t(n)];
        return n;
    }
    void unite(int a, int b) { m_parent[std::size_t(root(a))] = root(b); }

    const std::vector<std::vector<double>>& m_levels;
    std::map<std::pair<std::size_t, int>, int> m_ids;
    std::vector<int> m_parent;
    std::vector<Sample> m_samples;
};

/// Expects that samples are connected in the cut mesh if and only if the oracle says so.
void expect_like(const CutMesh& cut, const Oracle& oracle) {
    const auto piece = pieces(cut.mesh);
    std::map<int, int> piece_of;
    std::set<int> seen;
    int wrong = 0;
    for (const auto& sample : oracle.samples()) {
        const std::int32_t copy = cut.copy_of(sample.cell, sample.rest_mm);
        ASSERT_EQ(cut.uncut_cell_of[std::size_t(copy)], sample.cell);
        const int p = piece[std::size_t(cut.mesh.cells[std::size_t(copy)][0])];
        wrong += piece_of.try_emplace(sample.component, p).first->second != p;
        seen.insert(p);
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(piece_of.size(), seen.size());
    const auto volumes = piece_volumes(cut);
    double without_sample = 0;
    for (std::size_t p = 0; p < volumes.size(); ++p)
        if (!seen.contains(int(p))) without_sample += volumes[p];
    EXPECT_LT(without_sample, 0.05);  // 120 samples in a mm³
}

TEST(CutTetrahedra, APlaneSeparatesABlockIntoItsAnalyticHalves) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TetMesh mesh = shaken_block(6, random);
        const Plane plane = random_plane(random, 6);
        const CutMesh cut = cut_once(mesh, ribbon_along(plane, {3, 3, 3}));
        expect_consistent(cut, mesh);
        ASSERT_EQ(cut.pieces, 2);
        EXPECT_GT(cut.split_cells, 100);
        auto volumes = piece_volumes(cut);
        const double above = cube_above(plane, 6);
        if ((volumes[0] < volumes[1]) != (above < 216 - above)) std::swap(volumes[0], volumes[1]);
        EXPECT_NEAR(volumes[0], above, 1e-8 * 216);
        EXPECT_NEAR(volumes[1], 216 - above, 1e-8 * 216);
    }
}

TEST(CutTetrahedra, RandomPlanesConnectMaterialLikeBruteForce) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TetMesh mesh = shaken_block(4, random);
        // Each cut meets another smooth shape, in which the planes are curved at rest.
        std::vector<std::vector<double>> levels;
        std::optional<CutMesh> cut;
        for (int n = 0; n < 4; ++n) {
            Plane plane = random_plane(random, 4);
            const Vec3d a = random.vector(0.6), b = random.vector(1), shift = random.vector(5);
            const Mat3d turn = random.rotation(false);
            std::vector<Vec3d> shape;
            for (const Vec3d& x : mesh.nodes_mm)
                shape.push_back(turn * (x + std::sin(dot(b, x)) * a) + shift);
            const Vec3d middle = shape[shape.size() / 2];
            plane.level += dot(plane.normal, middle) - dot(plane.normal, Vec3d{2, 2, 2});
            std::vector<Vec3d> now = shape;
            if (cut)
                for (std::size_t k = now.size(); k < cut->mesh.nodes_mm.size(); ++k)
                    now.push_back(shape[std::size_t(cut->uncut_node_of[k])]);
            const CutSurface ribbon = ribbon_along(plane, middle);
            auto next = cut ? cut_tetrahedra(*cut, now, ribbon) : cut_tetrahedra(mesh, now, ribbon);
            ASSERT_TRUE(next.ok()) << next.error().message;
            cut = std::move(next).value();
            expect_consistent(*cut, mesh);
            auto& level = levels.emplace_back();
            for (const Vec3d& x : shape) level.push_back(dot(plane.normal, x) - plane.level);
            expect_like(*cut, Oracle(mesh, random, levels));
        }
        EXPECT_GT(cut->pieces, 4);
    }
}

TEST(CutTetrahedra, ACrossMakesFourPiecesWithTheVolumesOfTheQuarters) {
    const TetMesh mesh = block(5);
    const CutSurface first{{{-1, 2.3, -1}, {6, 2.3, -1}}, {0, 0, 9}};
    const CutSurface second{{{1.7, -1, -1}, {1.7, 6, -1}}, {0, 0, 9}};
    CutMesh cut = cut_once(mesh, first);
    EXPECT_EQ(cut.pieces, 2);
    const std::size_t nodes = cut.mesh.nodes_mm.size(), cells = cut.mesh.cells.size();
    const auto before = cut.mesh.cells;
    cut = cut_again(cut, second);
    expect_consistent(cut, mesh);
    ASSERT_EQ(cut.pieces, 4);
    for (std::size_t n = 0; n < nodes; ++n) EXPECT_EQ(cut.node_of[n], std::int32_t(n));
    for (std::size_t c = 0; c < cells; ++c) EXPECT_EQ(cut.cell_of[c], std::int32_t(c));
    for (std::size_t c = 0; c < cut.mesh.cells.size(); ++c)
        for (std::size_t k = 0; k < 4; ++k)
            EXPECT_EQ(cut.node_of[std::size_t(cut.mesh.cells[c][k])],
                      before[std::size_t(cut.cell_of[c])][k]);
    auto volumes = piece_volumes(cut);
    std::sort(volumes.begin(), volumes.end());
    const double expected[] = {1.7 * 2.3 * 5, 1.7 * 2.7 * 5, 3.3 * 2.3 * 5, 3.3 * 2.7 * 5};
    for (std::size_t n = 0; n < 4; ++n) EXPECT_NEAR(volumes[n], expected[n], 1e-6);
}

TEST(CutTetrahedra, ASlabThinnerThanACellIsAPieceOfItsOwn) {
    const TetMesh mesh = block(4);
    CutMesh cut = cut_once(mesh, {{{-1, 2.3, -1}, {5, 2.4, -1}}, {0, 0, 9}});
    cut = cut_again(cut, {{{-1, 2.5, -1}, {5, 2.6, -1}}, {0, 0, 9}});
    expect_consistent(cut, mesh);
    ASSERT_EQ(cut.pieces, 3);
    const auto volumes = piece_volumes(cut);
    EXPECT_NEAR(*std::min_element(volumes.begin(), volumes.end()), 0.2 * 16, 1e-6);
}

TEST(CutTetrahedra, BladesThroughNodesEdgesAndFacesLoseNothing) {
    const TetMesh mesh = block(6);
    for (int a = -2; a <= 2; ++a)
        for (int b = -2; b <= 2; ++b)
            for (int c = 0; c <= 2; ++c) {
                if (std::abs(a) + std::abs(b) + c == 0 || (c == 0 && a < 0)) continue;
                SCOPED_TRACE(testing::Message() << a << ' ' << b << ' ' << c);
                const Vec3d n{double(a), double(b), double(c)};
                const Plane plane{n, dot(n, Vec3d{3, 3, 3})};
                const CutMesh cut = cut_once(mesh, ribbon_along(plane, {3, 3, 3}));
                expect_consistent(cut, mesh);
                ASSERT_EQ(cut.pieces, 2);
                const auto volumes = piece_volumes(cut);
                EXPECT_NEAR(volumes[0], 108, 1e-4);
                EXPECT_NEAR(volumes[1], 108, 1e-4);
            }
}

TEST(CutTetrahedra, ABladeAlongFacesCopiesNodesOnly) {
    const TetMesh mesh = block(6);
    const CutMesh cut = cut_once(mesh, {{{-1, -1, 3}, {7, -1, 3}}, {0, 8, 0}});
    EXPECT_EQ(cut.pieces, 2);
    EXPECT_EQ(cut.split_cells, 0);
    EXPECT_EQ(cut.mesh.cells.size(), mesh.cells.size());
    EXPECT_EQ(cut.mesh.nodes_mm.size(), mesh.nodes_mm.size() + 49);
}

TEST(CutTetrahedra, TheSameCutAgainChangesNothing) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TetMesh mesh = seed % 2 ? block(5) : shaken_block(5, random);
        const Plane plane =
            seed % 3 ? random_plane(random, 5) : Plane{{1, 1, 0}, 5};  // through nodes
        const CutSurface ribbon = ribbon_along(plane, {2.5, 2.5, 2.5});
        const CutMesh once = cut_once(mesh, ribbon);
        const CutMesh twice = cut_again(once, ribbon);
        EXPECT_EQ(twice.split_cells, 0);
        EXPECT_EQ(twice.mesh.nodes_mm.size(), once.mesh.nodes_mm.size());
        EXPECT_EQ(twice.mesh.cells, once.mesh.cells);
        EXPECT_EQ(twice.pieces, 2);
    }
}

TEST(CutTetrahedra, ACutOutsideChangesNothing) {
    const TetMesh mesh = block(4);
    for (const CutSurface& surface :
         {CutSurface{{{-1, 5, -1}, {5, 5, -1}}, {0, 0, 9}},
          CutSurface{{{-3, 2, -1}, {-0.5, 2, -1}}, {0, 0, 9}},
          CutSurface{{{2.2, 2.2, 2.2}, {2.21, 2.2, 2.2}}, {0, 0.01, 0.01}}}) {
        const CutMesh cut = cut_once(mesh, surface);
        EXPECT_EQ(cut.mesh.cells, mesh.cells);
        EXPECT_EQ(cut.mesh.nodes_mm, mesh.nodes_mm);
        EXPECT_TRUE(cut.parts.empty());
        EXPECT_EQ(cut.pieces, 1);
        EXPECT_EQ(cut.split_cells, 0);
    }
}

/// [sample] piece, for material points all over a mesh.
std::vector<int> sampled_pieces(const CutMesh& cut, const TetMesh& uncut, std::uint64_t seed) {
    Random random(seed);
    const auto piece = pieces(cut.mesh);
    std::vector<int> result;
    for (std::size_t c = 0; c < uncut.cells.size(); ++c)
        for (int n = 0; n < 10; ++n) {
            std::array<Vec3d, 4> x;
            for (std::size_t k = 0; k < 4; ++k)
                x[k] = uncut.nodes_mm[std::size_t(uncut.cells[c][k])];
            const auto copy =
                std::size_t(cut.copy_of(std::int32_t(c), blend(random_weights(random, 4), x)));
            result.push_back(piece[std::size_t(cut.mesh.cells[copy][0])]);
        }
    return result;
}

TEST(CutTetrahedra, AStrokeInPartsSeparatesWhatOneStrokeDoes) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TetMesh mesh = shaken_block(5, random);
        const Plane plane = random_plane(random, 5);
        CutSurface whole = ribbon_along(plane, {2.5, 2.5, 2.5});
        const Vec3d a = whole.line_mm[0], b = whole.line_mm[1];
        const CutMesh at_once = cut_once(mesh, whole);
        CutMesh in_parts = cut_once(mesh, {{a, a + 0.4 * (b - a)}, whole.depth_mm});
        std::vector<double> ends{0.4};
        while (ends.back() < 0.6) ends.push_back(ends.back() + random.real(0.0005, 0.008));
        ends.push_back(1);
        int halfway = 0;
        for (std::size_t n = 0; n + 1 < ends.size(); ++n) {
            halfway += in_parts.pieces == 1 && in_parts.mesh.cells.size() > mesh.cells.size();
            in_parts = cut_again(
                in_parts, {{a + ends[n] * (b - a), a + ends[n + 1] * (b - a)}, whole.depth_mm});
            expect_consistent(in_parts, mesh);
        }
        EXPECT_GT(halfway, 3) << "the stroke isn't in parts";
        EXPECT_EQ(in_parts.pieces, 2);
        EXPECT_EQ(in_parts.mesh.cells.size(), at_once.mesh.cells.size());
        EXPECT_EQ(in_parts.mesh.nodes_mm.size(), at_once.mesh.nodes_mm.size());
        EXPECT_EQ(sampled_pieces(in_parts, mesh, seed), sampled_pieces(at_once, mesh, seed));
    }
}

TEST(CutTetrahedra, APartialCutLeavesOnePieceThatIsOpenAtTheBlade) {
    const TetMesh mesh = block(6);
    const CutMesh cut = cut_once(mesh, {{{-1, 3.3, -1}, {3.4, 3.3, -1}}, {0, 0, 9}});
    expect_consistent(cut, mesh);
    EXPECT_EQ(cut.pieces, 1);
    EXPECT_GT(cut.split_cells, 50);
    // Opposite lips have no node in common where the blade has passed.
    std::int32_t below = -1, above = -1;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const Vec3d low{0.5, 3.29, 0.45}, high{0.5, 3.31, 0.45};
        std::array<Vec3d, 4> x;
        for (std::size_t k = 0; k < 4; ++k) x[k] = mesh.nodes_mm[std::size_t(mesh.cells[c][k])];
        if (is_inside_tetrahedron(low, x)) below = cut.copy_of(std::int32_t(c), low);
        if (is_inside_tetrahedron(high, x)) above = cut.copy_of(std::int32_t(c), high);
    }
    for (const std::int32_t p : cut.mesh.cells[std::size_t(below)])
        for (const std::int32_t q : cut.mesh.cells[std::size_t(above)]) EXPECT_NE(p, q);
}

TEST(CutTetrahedra, ABentBladeSeparatesNodesByTheirSide) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TetMesh mesh = shaken_block(8, random);
        CutSurface blade{{}, {0, 0, 20}};
        std::vector<double> xs, ys;
        for (double x = -2; x < 11; x += random.real(1.2, 2.5)) {
            xs.push_back(x);
            ys.push_back(4 + 0.8 * std::sin(0.7 * x + double(seed)));
            blade.line_mm.push_back({x, ys.back(), -5});
        }
        const CutMesh cut = cut_once(mesh, blade);
        expect_consistent(cut, mesh);
        ASSERT_EQ(cut.pieces, 2);
        const auto piece = pieces(cut.mesh);
        std::array<std::set<int>, 2> sides;
        for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n) {
            const Vec3d x = mesh.nodes_mm[n];
            std::size_t k = 0;
            while (xs[k + 1] < x.x) ++k;
            const double t = (x.x - xs[k]) / (xs[k + 1] - xs[k]);
            sides[x.y > ys[k] + t * (ys[k + 1] - ys[k])].insert(piece[n]);
        }
        EXPECT_EQ(sides[0].size(), 1u);
        EXPECT_EQ(sides[1].size(), 1u);
        EXPECT_NE(sides[0], sides[1]);
    }
}

TEST(CutTetrahedra, RandomStrokesNeverJoinOrLoseMaterial) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TetMesh mesh = seed % 2 ? block(3) : shaken_block(3, random);
        std::optional<CutMesh> cut;
        std::int64_t pieces_before = 1;
        for (int n = 0; n < 30; ++n) {
            CutSurface stroke{{}, random.vector(4)};
            for (int k = random.whole(2, 5); k > 0; --k) {
                Vec3d x{random.real(-0.5, 3.5), random.real(-0.5, 3.5), random.real(-0.5, 3.5)};
                if (seed % 3 == 1) x = {std::round(x.x), std::round(x.y), std::round(x.z)};
                stroke.line_mm.push_back(x);
            }
            if (seed % 3 == 1) stroke.depth_mm = {double(n % 3) - 1, double(n % 5) - 2, 3};
            auto next = cut ? cut_tetrahedra(*cut, cut->mesh.nodes_mm, stroke)
                            : cut_tetrahedra(mesh, mesh.nodes_mm, stroke);
            if (!next.ok()) continue;  // a stroke along its depth
            cut = std::move(next).value();
            // Crossings of several strokes aren't in one plane; a cap between them may leave a part
            // that isn't convex.
            expect_consistent(*cut, mesh, 2e-3);
            EXPECT_GE(cut->pieces, pieces_before);
            pieces_before = cut->pieces;
        }
        EXPECT_GT(cut->mesh.cells.size(), 2 * mesh.cells.size());
    }
}

TEST(CutTetrahedra, PiecesThatWereMovedApartAreCutWhereTheyAre) {
    const TetMesh mesh = block(5);
    const CutMesh halves = cut_once(mesh, {{{-1, 2.3, -1}, {6, 2.3, -1}}, {0, 0, 9}});
    ASSERT_EQ(halves.pieces, 2);
    const auto piece = pieces(halves.mesh);
    std::vector<Vec3d> apart = halves.mesh.nodes_mm;
    for (std::size_t n = 0; n < apart.size(); ++n)
        if (piece[n] == 1) apart[n].y += 20;
    const CutSurface between{{{-1, 10, -1}, {6, 10, -1}}, {0, 0, 9}};
    auto same = cut_tetrahedra(halves, apart, between);
    ASSERT_TRUE(same.ok());
    EXPECT_EQ(same->mesh.cells, halves.mesh.cells);
    // One half alone, along x.
    auto three = cut_tetrahedra(halves, apart, {{{2.6, 15, -1}, {2.6, 30, -1}}, {0, 0, 9}});
    ASSERT_TRUE(three.ok());
    expect_consistent(*three, mesh);
    ASSERT_EQ(three->pieces, 3);
    auto volumes = piece_volumes(*three);
    std::sort(volumes.begin(), volumes.end());
    const bool is_upper = piece[std::size_t(node_index({.size = {6, 6, 6}}, {0, 5, 0}))] == 1;
    const double cut_half = is_upper ? 2.7 : 2.3;
    EXPECT_NEAR(volumes[0], 2.4 * cut_half * 5, 1e-6);
    EXPECT_NEAR(volumes[1], 2.6 * cut_half * 5, 1e-6);
    EXPECT_NEAR(volumes[2], (5 - cut_half) * 25, 1e-6);
}

TEST(CutTetrahedra, SharesAreTheFractionsOfTheMaterialPoints) {
    Random random(5);
    const TetMesh mesh{{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}}, {{0, 1, 2, 3}}};
    CutMesh cut = cut_once(mesh, ribbon_along({{1, 0.3, 0.2}, 0.8}, {1, 1, 1}));
    cut = cut_again(cut, ribbon_along({{-0.4, 1, 0.1}, 0.5}, {1, 1, 1}));
    cut = cut_again(cut, ribbon_along({{0.1, -0.2, 1}, 0.4}, {1, 1, 1}));
    expect_consistent(cut, mesh);
    ASSERT_GE(cut.pieces, 6);
    EXPECT_EQ(std::size_t(cut.pieces), cut.mesh.cells.size());
    std::vector<double> hits(cut.mesh.cells.size(), 0);
    constexpr int kPoints = 40'000;
    for (int n = 0; n < kPoints; ++n) {
        const auto w = random_weights(random, 4);
        hits[std::size_t(cut.copy_of(0, {3 * w[1], 3 * w[2], 3 * w[3]}))] += 1.0 / kPoints;
    }
    for (std::size_t c = 0; c < hits.size(); ++c) EXPECT_NEAR(hits[c], cut.shares[c], 0.01);
}

TEST(CutTetrahedra, BadInputIsNamed) {
    const TetMesh mesh = block(2);
    const auto code = [](const Result<CutMesh>& result) { return result.error().code; };
    const CutSurface good{{{-1, 1, -1}, {3, 1, -1}}, {0, 0, 9}};
    EXPECT_EQ(code(cut_tetrahedra(mesh, std::span(mesh.nodes_mm).first(3), good)),
              ErrorCode::InvalidArgument);
    std::vector<Vec3d> far = mesh.nodes_mm;
    far[3].x = std::nan("");
    EXPECT_EQ(code(cut_tetrahedra(mesh, far, good)), ErrorCode::InvalidArgument);
    for (const CutSurface& surface :
         {CutSurface{{{0, 0, 0}}, {0, 0, 9}}, CutSurface{{{0, 0, 0}, {0, 0, 1}}, {0, 0, 9}},
          CutSurface{{{0, 0, 0}, {2e5, 0, 1}}, {0, 0, 9}}})
        EXPECT_EQ(code(cut_tetrahedra(mesh, mesh.nodes_mm, surface)), ErrorCode::InvalidArgument);
    TetMesh inverted = mesh;
    std::swap(inverted.cells[1][0], inverted.cells[1][1]);
    EXPECT_EQ(code(cut_tetrahedra(inverted, mesh.nodes_mm, good)), ErrorCode::InvalidArgument);
}

TEST(CutTetrahedra, WithoutMemoryNothingIsReturned) {
    const TetMesh mesh = block(2);
    const CutSurface surface{{{-1, 1.1, -1}, {3, 1.2, -1}}, {0, 0, 9}};
    int failed = 0;
    for (int n = 0;; ++n) {
        test::FailingAllocation failing(n);
        const auto cut = cut_tetrahedra(mesh, mesh.nodes_mm, surface);
        if (cut.ok()) {
            EXPECT_EQ(cut->pieces, 2);
            break;
        }
        ASSERT_EQ(cut.error().code, ErrorCode::LimitExceeded);
        ++failed;
    }
    EXPECT_GT(failed, 100);
}

}  // namespace
}  // namespace pliant
