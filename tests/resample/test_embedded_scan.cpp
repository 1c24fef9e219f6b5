// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan that tetrahedra carry, against the weights of each voxel, found by brute force.
// Covers: resample/embedded_cuts.cpp.

#include <gtest/gtest.h>
#include <pliant/models/pbd.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "mesh/triangle_distance.h"
#include "resample/embedded_scan.h"
#include "resample/lattices.h"
#include "support/broken_volumes.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr double kUnit = 1.0 / (1 << 20);

struct EmbeddedInstance {
    Volume volume;
    TetMesh mesh;
    std::vector<std::int32_t> solids;
    std::vector<Vec3d> moved;
    double reach_mm = 0;
};

/// Two blocks side by side whose inner nodes are shaken, in an oblique scan.
EmbeddedInstance make_instance(Random& random) {
    EmbeddedInstance made;
    made.volume = make_volume({random.whole(18, 30), random.whole(17, 30), random.whole(15, 30)},
                              {random.real(0.7, 1.5), random.real(0.7, 1.5), 1.1},
                              [&](Vec3d) { return float(random.real(-900, 900)); });
    made.volume.grid.direction = random.rotation(random.whole(0, 1) == 1);
    made.volume.grid.origin_mm = random.vector(50);
    made.reach_mm = random.real(1, 5);
    const Vec3d middle = world_from_voxel(made.volume.grid, {8, 8, 8});
    for (int s = 0; s < 2; ++s) {
        const TetMesh block = five_tet_block({2, 2, 2}, 3);
        const auto first = std::int32_t(made.mesh.nodes_mm.size());
        for (const Vec3d& p : block.nodes_mm)
            made.mesh.nodes_mm.push_back(middle + p - Vec3d{3.2 * (1 - s) + 2.9 * (1 - s), 3, 3} +
                                         random.vector(0.3));
        for (auto cell : block.cells) {
            for (std::int32_t& n : cell) n += first;
            made.mesh.cells.push_back(cell);
            made.solids.push_back(s);
        }
    }
    for (const Vec3d& p : made.mesh.nodes_mm) made.moved.push_back(p + random.vector(1));
    return made;
}

std::array<double, 4> weights_of(Vec3d x, const TetMesh& mesh, std::size_t cell) {
    const auto at = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(mesh.cells[cell][n])]; };
    const Vec3d a = at(0), b = at(1) - a, c = at(2) - a, d = at(3) - a, p = x - a;
    const double v = dot(b, cross(c, d));
    const double u = dot(p, cross(c, d)) / v, w = dot(b, cross(p, d)) / v,
                 z = dot(b, cross(c, p)) / v;
    return {1 - u - w - z, u, w, z};
}

Vec3d shift_in(const EmbeddedInstance& instance, std::size_t cell, Vec3d x) {
    const auto weights = weights_of(x, instance.mesh, cell);
    Vec3d sum{0, 0, 0};
    for (std::size_t n = 0; n < 4; ++n) {
        const auto node = std::size_t(instance.mesh.cells[cell][n]);
        sum = sum + weights[n] * (instance.moved[node] - instance.mesh.nodes_mm[node]);
    }
    return sum;
}

/// Displacement of a voxel by the definition. @param solid  that carries it; −1: any
Vec3d expected_at(const EmbeddedInstance& instance, Vec3d x, std::int32_t solid) {
    const TetMesh& mesh = instance.mesh;
    const auto is_of = [&](std::size_t c) { return solid < 0 || instance.solids[c] == solid; };
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const auto w = weights_of(x, mesh, c);
        if (is_of(c) && *std::min_element(w.begin(), w.end()) >= -1e-9)
            return shift_in(instance, c, x);
    }
    double best = instance.reach_mm;
    Vec3d shift{0, 0, 0};
    for (std::int32_t s = 0; s < 2; ++s) {
        TetMesh part{mesh.nodes_mm, {}};
        std::vector<std::size_t> numbers;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c)
            if (instance.solids[c] == s && is_of(c)) {
                part.cells.push_back(mesh.cells[c]);
                numbers.push_back(c);
            }
        std::vector<std::int32_t> cells;
        const auto faces = boundary_faces(part, &cells);
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const auto node = [&](std::size_t n) {
                return mesh.nodes_mm[std::size_t(faces[f][n])];
            };
            const Vec3d q = mesh::nearest_on_triangle(x, node(0), node(1), node(2)).position;
            const double distance = norm(x - q);
            if (distance >= best) continue;
            best = distance;
            const double share = distance / instance.reach_mm;
            const double fade = (1 - share * share) * (1 - share * share);
            shift = fade * shift_in(instance, numbers[std::size_t(cells[f])], q);
        }
    }
    return shift;
}

TEST(EmbeddedScan, VoxelsMoveWithTheWeightsOfTheirTetrahedra) {
    const TaskArena arena(2);
    std::int64_t moved_voxels = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const EmbeddedInstance instance = make_instance(random);
        const bool by_label = seed % 2 == 0;
        const auto solid_at = [&](Vec3i p) {
            return by_label ? (p.x < 7 ? 0 : p.y < 12 ? 1 : -2) : -1;
        };
        auto scan = EmbeddedScan::create(
            instance.volume, instance.mesh,
            {.reach_mm = instance.reach_mm, .solids = instance.solids, .solid_at = solid_at},
            arena);
        ASSERT_TRUE(scan.ok()) << scan.error().message;
        ASSERT_TRUE((*scan)->place(instance.moved).ok());
        double worst = 0;
        const Vec3i size = instance.volume.grid.size;
        for (int k = 0; k < size.z; ++k)
            for (int j = 0; j < size.y; ++j)
                for (int i = 0; i < size.x; ++i) {
                    const Vec3i p{i, j, k};
                    const Vec3d x =
                        world_from_voxel(instance.volume.grid, {double(i), double(j), double(k)});
                    const std::int32_t solid = solid_at(p);
                    const Vec3d expected =
                        solid < -1 ? Vec3d{0, 0, 0} : expected_at(instance, x, solid);
                    const Vec3d found = (*scan)->deformation().displacement_mm(p);
                    moved_voxels += found != Vec3d{0, 0, 0};
                    worst = std::max(worst, norm(found - expected));
                }
        // Half a unit along each axis; the fades and nearest points are single precision.
        EXPECT_LT(worst, 2e-6);
    }
    EXPECT_GT(moved_voxels, 12 * 500);
}

TEST(EmbeddedScan, ManyMovesEqualOneAndRestIsRest) {
    for (const int threads : {1, 4}) {
        const TaskArena arena(threads);
        Random random(99);
        const EmbeddedInstance instance = make_instance(random);
        const EmbeddedScanSettings settings{.reach_mm = instance.reach_mm,
                                            .solids = instance.solids};
        auto once = EmbeddedScan::create(instance.volume, instance.mesh, settings, arena).value();
        auto often = EmbeddedScan::create(instance.volume, instance.mesh, settings, arena).value();
        auto way = instance.mesh.nodes_mm;
        for (std::size_t n = 0; n < way.size(); ++n) {
            way[n] = instance.moved[n];
            if (n % 5 == 0) {
                ASSERT_TRUE(often->place(way).ok());
            }
        }
        ASSERT_TRUE(often->place(instance.moved).ok());
        ASSERT_TRUE(once->place(instance.moved).ok());
        EXPECT_EQ(often->deformation().hash(), once->deformation().hash());
        EXPECT_NE(once->deformation().hash(),
                  Deformation::create(instance.volume.grid).value().hash());
        const Deformed deformed = deform_volume(*once).value();
        EXPECT_EQ(hash_volume(deformed.volume), hash_volume(deform_volume(*often)->volume));
        ASSERT_TRUE(often->place(instance.mesh.nodes_mm).ok());
        EXPECT_EQ(often->deformation().hash(),
                  Deformation::create(instance.volume.grid).value().hash());
        EXPECT_EQ(state_of(*often)->resident_bricks, 0);
    }
}

/// The two sides of a plane that cuts through all of a block are moved apart.
TEST(EmbeddedScan, LinksAcrossABladeAreCutAndVoxelsMoveWithTheirSide) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        EmbeddedInstance instance = make_instance(random);
        const TaskArena arena(seed % 2 == 0 ? 1 : 3);
        const Grid& grid = instance.volume.grid;
        Vec3d middle{0, 0, 0}, normal = normalized(random.vector(1));
        for (std::size_t n = 0; n < 27; ++n)
            middle = middle + (1.0 / 27) * instance.mesh.nodes_mm[n];
        instance.mesh.nodes_mm.resize(27);  // one of the blocks
        std::erase_if(instance.mesh.cells, [](const auto& cell) { return cell[0] >= 27; });
        // A blade through the centres of voxels, every third time.
        if (seed % 3 == 0) {
            normal = grid.direction.columns[seed % 2];
            const Vec3d at = voxel_from_world(grid, middle);
            middle = world_from_voxel(grid, {std::round(at.x), std::round(at.y), std::round(at.z)});
        }
        const Vec3d u = normalized(
                        cross(normal, std::abs(normal.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
                    v = cross(normal, u);
        const auto cut = cut_tetrahedra(
            instance.mesh, instance.mesh.nodes_mm,
            {{middle - 50.0 * u - 50.0 * v, middle + 50.0 * u - 50.0 * v}, 100.0 * v});
        ASSERT_TRUE(cut.ok()) << cut.error().message;
        ASSERT_EQ(cut->pieces, 2);
        const auto piece = pieces(cut->mesh);
        auto scan =
            EmbeddedScan::create(instance.volume, instance.mesh, {.reach_mm = 2}, arena).value();
        // Each piece moves by its own vector.
        const Vec3d by[2] = {random.vector(2), random.vector(2)};
        std::vector<Vec3d> moved = cut->mesh.nodes_mm;
        for (std::size_t n = 0; n < moved.size(); ++n)
            moved[n] = moved[n] + by[std::size_t(piece[n])];
        const auto cuts = scan->find_cuts(*cut);
        ASSERT_TRUE(scan->place(cuts, moved).ok());
        const Deformation& field = scan->deformation();
        const auto is_inside = [&](Vec3i p) {
            const Vec3d x = world_from_voxel(grid, {double(p.x), double(p.y), double(p.z)});
            for (std::size_t c = 0; c < instance.mesh.cells.size(); ++c) {
                const auto w = weights_of(x, instance.mesh, c);
                if (*std::min_element(w.begin(), w.end()) >= -1e-9) return true;
            }
            return false;
        };
        const auto level = [&](Vec3i p) {
            return dot(normal,
                       world_from_voxel(grid, {double(p.x), double(p.y), double(p.z)}) - middle);
        };
        int side_of_first = -1;
        std::int64_t cut_links = 0, across = 0;
        const Vec3i size = grid.size;
        for (int k = 0; k < size.z; ++k)
            for (int j = 0; j < size.y; ++j)
                for (int i = 0; i < size.x; ++i) {
                    const Vec3i p{i, j, k};
                    for (int a = 0; a < 3; ++a) cut_links += !field.is_linked(p, a);
                    if (!is_inside(p)) continue;
                    const Vec3d shift = field.displacement_mm(p);
                    const int side = norm(shift - by[0]) < norm(shift - by[1]) ? 0 : 1;
                    EXPECT_LT(norm(shift - by[side]), 2e-6) << "moves with one of the pieces";
                    if (std::abs(level(p)) > 1e-6) {
                        if (side_of_first < 0) side_of_first = level(p) > 0 ? side : 1 - side;
                        EXPECT_EQ(side, level(p) > 0 ? side_of_first : 1 - side_of_first);
                    }
                    for (int a = 0; a < 3; ++a) {
                        Vec3i q = p;
                        ++q[a];
                        if (!is_inside(q)) continue;
                        const Vec3d other = field.displacement_mm(q);
                        const bool apart = norm(other - shift) > 1e-5;
                        across += apart;
                        EXPECT_EQ(field.is_linked(p, a), !apart) << i << ' ' << j << ' ' << k;
                    }
                }
        EXPECT_GT(across, 10);
        EXPECT_GE(scan->cut_links(), across);
        EXPECT_EQ(scan->cut_links(), cut_links);

        // Without the cuts again, all is as it was.
        ASSERT_TRUE(scan->place(nullptr, instance.mesh.nodes_mm).ok());
        EXPECT_EQ(field.hash(), Deformation::create(grid).value().hash());
        EXPECT_EQ(scan->cut_links(), 0);
        EXPECT_EQ(scan->place(moved).error().code, ErrorCode::InvalidArgument);
        ASSERT_TRUE(scan->place(cuts, moved).ok());
        const auto hash = field.hash();
        ASSERT_TRUE(scan->place(cut->mesh.nodes_mm).ok());
        ASSERT_TRUE(scan->place(moved).ok());
        EXPECT_EQ(field.hash(), hash);
    }
}

TEST(EmbeddedScan, ATranslationIsExact) {
    const TaskArena arena(1);
    Random random(7);
    EmbeddedInstance instance = make_instance(random);
    const Vec3d by{64 * kUnit, -32 * kUnit, 1024 * kUnit};
    for (std::size_t n = 0; n < instance.moved.size(); ++n)
        instance.moved[n] =
            instance.mesh.nodes_mm[n] + world_from_lattice_vector(instance.volume.grid, by);
    auto scan =
        EmbeddedScan::create(instance.volume, instance.mesh, {.reach_mm = 1e-9}, arena).value();
    ASSERT_TRUE(scan->place(instance.moved).ok());
    std::int64_t moved = 0;
    const Vec3i size = instance.volume.grid.size;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) {
                const Vec3d u = scan->deformation().displacement_mm({i, j, k});
                if (u == Vec3d{0, 0, 0}) continue;
                ++moved;
                EXPECT_LT(norm(u - world_from_lattice_vector(instance.volume.grid, by)),
                          0.6 * kUnit);
            }
    EXPECT_EQ(moved, scan->voxel_count());
    EXPECT_GT(moved, 100);
}

TEST(EmbeddedScan, BadInputIsRefusedAndChangesNothing) {
    const TaskArena arena(1);
    Random random(3);
    EmbeddedInstance instance = make_instance(random);
    auto scan = EmbeddedScan::create(instance.volume, instance.mesh, {}, arena).value();
    ASSERT_TRUE(scan->place(instance.moved).ok());
    const auto hash = scan->deformation().hash();
    auto wrong = instance.moved;
    wrong.pop_back();
    EXPECT_EQ(scan->place(wrong).error().message,
              "embedded scan: expected positions of 54 nodes, found 53");
    wrong = instance.moved;
    wrong[4].x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(scan->place(wrong).error().code, ErrorCode::InvalidArgument);
    wrong[4] = instance.moved[4] + Vec3d{900, 900, 900};
    EXPECT_EQ(scan->place(wrong).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(scan->deformation().hash(), hash);
    for (Vec3d& p : instance.mesh.nodes_mm) p = p + Vec3d{1000, 0, 0};
    const auto beside = EmbeddedScan::create(instance.volume, instance.mesh, {}, arena);
    EXPECT_EQ(beside.error().message,
              "mesh: expected a body inside of the scan, found one beside it");
}

}  // namespace
}  // namespace pliant::test
