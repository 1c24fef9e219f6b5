// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan embedded in control nodes, against a map without cells: each node has a tent function, the
// product of max(0, 1 − |distance| / cell) along the axes, and the map is inverted by fixed-point
// iteration.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "resample/lattices.h"
#include "resample/scatter.h"
#include "support/broken_volumes.h"
#include "support/random.h"

namespace pliant::test {
namespace {

struct Instance {
    Volume volume;
    ControlGrid grid;
    std::vector<Vec3d> shifts;  ///< of nodes, along the lattice's axes [voxels]

    Vec3d shift_at(Vec3d x) const {
        Vec3d sum{0, 0, 0};
        std::size_t n = 0;
        for (int k = 0; k < grid.size.z; ++k)
            for (int j = 0; j < grid.size.y; ++j)
                for (int i = 0; i < grid.size.x; ++i, ++n) {
                    const Vec3i ijk{i, j, k};
                    double tent = 1;
                    for (int a = 0; a < 3; ++a) {
                        const double away = x[a] - (grid.first[a] + grid.cell[a] * ijk[a]);
                        tent *= std::max(0.0, 1 - std::abs(away) / grid.cell[a]);
                    }
                    if (tent > 0) sum = sum + tent * shifts[n];
                }
        return sum;
    }
    Vec3d came_from(Vec3d p) const {
        Vec3d x = p;
        for (int turn = 0; turn < 400; ++turn) {
            const Vec3d next = p - shift_at(x);
            if (next == x) break;
            x = next;
        }
        return x;
    }
    std::vector<Vec3d> displacements_mm() const {
        const Vec3d s = volume.grid.spacing_mm;
        std::vector<Vec3d> all;
        for (const Vec3d u : shifts)
            all.push_back(
                world_from_lattice_vector(volume.grid, {s.x * u.x, s.y * u.y, s.z * u.z}));
        return all;
    }
};

/// The outermost nodes stay, so that the map is continuous everywhere.
Instance make_instance(Random& random) {
    Instance made;
    Vec3i size;
    for (int a = 0; a < 3; ++a) {
        made.grid.first[a] = random.whole(0, 5);
        made.grid.cell[a] = random.whole(1, 7);
        made.grid.size[a] = random.whole(3, 6);
        size[a] =
            made.grid.first[a] + made.grid.cell[a] * (made.grid.size[a] - 1) + random.whole(1, 6);
    }
    made.volume = make_volume(size, {random.real(0.5, 2), random.real(0.5, 2), 1.3},
                              [&](Vec3d) { return float(random.real(-900, 900)); });
    made.volume.grid.direction = random.rotation(random.whole(0, 1) == 1);
    made.volume.grid.origin_mm = random.vector(100);
    for (int k = 0; k < made.grid.size.z; ++k)
        for (int j = 0; j < made.grid.size.y; ++j)
            for (int i = 0; i < made.grid.size.x; ++i) {
                const Vec3i ijk{i, j, k};
                Vec3d shift{0, 0, 0};
                for (int a = 0; a < 3; ++a) shift[a] = random.real(-0.15, 0.15) * made.grid.cell[a];
                for (int a = 0; a < 3; ++a)
                    if (ijk[a] == 0 || ijk[a] == made.grid.size[a] - 1) shift = {0, 0, 0};
                made.shifts.push_back(shift);
            }
    return made;
}

std::unique_ptr<ControlLattice> make_lattice(const Instance& instance, const TaskArena& arena) {
    return std::move(ControlLattice::create(instance.volume, instance.grid, arena)).value();
}

template <class Visit>
void for_each_voxel(const Grid& grid, const Visit& visit) {
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) visit(Vec3i{i, j, k});
}

TEST(ControlLattice, ApproachesInPartsAndArrivesWhereOneCallDoes) {
    const TaskArena arena(2);
    Instance instance;
    instance.grid = {.first = {2, 1, 3}, .cell = {7, 7, 7}, .size = {13, 12, 11}};
    instance.volume = make_volume({90, 80, 76}, {1, 1, 1}, [](Vec3d p) {
        return float(std::fmod(7 * p.x + 3 * p.y + p.z, 100));
    });
    Random random(5);
    for (std::size_t n = 0; n < dense_count(instance.grid.size); ++n)
        instance.shifts.push_back({random.real(-0.3, 0.3), random.real(-0.3, 0.3), 0});
    const std::vector<Vec3d> wanted = instance.displacements_mm();
    const auto whole = make_lattice(instance, arena), parts = make_lattice(instance, arena);
    ASSERT_TRUE(whole->place(wanted).ok());
    const std::int64_t all = deform_volume(*whole)->written_voxels;
    std::int64_t most = 0;
    int calls = 0;
    auto live = LiveDeformation::create(*parts);
    ASSERT_TRUE(live.ok());
    for (bool done = false; !done && calls < 100; ++calls) {
        const auto near = parts->approach(wanted, all / 10, 0);
        ASSERT_TRUE(near.ok());
        done = *near;
        most = std::max(most, live->update()->written_voxels);
    }
    EXPECT_GT(calls, 5);
    EXPECT_LT(calls, 100);
    EXPECT_LT(most, all / 2);
    EXPECT_EQ(hash_volume(live->volume()), hash_volume(deform_volume(*whole)->volume));
    // What lags by less than can be seen stays.
    std::vector<Vec3d> close = wanted;
    for (Vec3d& u : close) u.x += 0.01;
    EXPECT_FALSE(*parts->approach(close, all, 0.02));
    EXPECT_EQ(live->update()->written_voxels, 0);
    EXPECT_TRUE(*parts->approach(close, 100 * all, 0));
    ASSERT_TRUE(whole->place(close).ok());
    ASSERT_TRUE(live->update().ok());
    EXPECT_EQ(hash_volume(live->volume()), hash_volume(deform_volume(*whole)->volume));
}

TEST(ControlLattice, RandomLatticesResampleLikeTheInverseOfTheirTents) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Instance instance = make_instance(random);
        const auto lattice = make_lattice(instance, arena);
        ASSERT_TRUE(lattice->place(instance.displacements_mm()).ok());
        EXPECT_FALSE(lattice->folds(instance.displacements_mm()));
        const Deformed deformed = deform_volume(*lattice).value();
        EXPECT_EQ(deformed.gap_voxels, 0);
        double worst = 0;
        for_each_voxel(instance.volume.grid, [&](Vec3i p) {
            const Vec3d from = instance.came_from({double(p.x), double(p.y), double(p.z)});
            const double expected = double(sample_linear(instance.volume, from));
            worst = std::max(worst, std::abs(double(deformed.volume.at(p)) - expected));
        });
        // Values of neighbouring voxels differ by 1800; single precision leaves 10⁻⁵ voxels.
        EXPECT_LT(worst, 0.05);
    }
}

TEST(ControlLattice, CellsOfOneVoxelGiveTheBitsOfTheElementsMovedByHand) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Instance instance;
        instance.volume = make_volume({26, 22, 19}, {1, 0.75, 1.5},
                                      [&](Vec3d) { return std::int16_t(random.whole(-900, 900)); });
        instance.grid = {{3, 2, 1}, {1, 1, 1}, {20, 17, 16}};
        const Vec3d centre{13, 10, 8};
        const Vec3d push = random.vector(2);
        const auto moved = [&](Vec3d x) {
            const double r = norm(x - centre);
            return std::max(0.0, 1 - r / 6) * push;
        };
        for (int k = 0; k < 16; ++k)
            for (int j = 0; j < 17; ++j)
                for (int i = 0; i < 20; ++i)
                    instance.shifts.push_back(moved({i + 3.0, j + 2.0, k + 1.0}));
        const auto lattice = make_lattice(instance, arena);
        ASSERT_TRUE(lattice->place(instance.shifts).ok());  // here in mm
        const Box3i box{{3, 2, 1}, {23, 19, 17}};
        const Lattice by_hand = displaced_lattice(instance.volume, box, moved);
        const Deformed expected =
            deform_by_field(instance.volume, by_hand, Mapping::Cells, true, arena);
        const Deformed found = deform_volume(*lattice, Mapping::Cells, true).value();
        EXPECT_GT(expected.written_voxels, 500);
        EXPECT_EQ(found.volume.voxels, expected.volume.voxels);
        EXPECT_EQ(found.dirty_box, expected.dirty_box);
        EXPECT_EQ(found.inverse_mm, expected.inverse_mm);
    }
}

TEST(ControlLattice, UpdatesOnAnyNumberOfThreadsGiveTheBitsOfTheOneShotForm) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Instance instance = make_instance(random);
        std::vector<std::vector<Vec3d>> states;
        const std::vector<Vec3d> all = instance.displacements_mm();
        for (int state = 0; state < 6; ++state) {
            std::vector<Vec3d> some = all;
            // All nodes, then a few at a time, and finally none.
            for (Vec3d& u : some)
                if (state == 5 || (state > 0 && random.whole(0, 3) != 0)) u = {0, 0, 0};
            states.push_back(some);
        }
        std::vector<std::uint64_t> hashes;
        for (const int threads : {1, 2, 4}) {
            const TaskArena arena(threads);
            const auto lattice = make_lattice(instance, arena);
            LiveDeformation live = LiveDeformation::create(*lattice).value();
            std::size_t n = 0;
            for (const auto& state : states) {
                const Volume before = live.volume();
                ASSERT_TRUE(lattice->place(state).ok());
                const LiveUpdate update = live.update().value();
                ASSERT_EQ(live.volume().voxels, deform_volume(*lattice).value().volume.voxels);
                for_each_voxel(before.grid, [&](Vec3i p) {
                    if (before.at(p) == live.volume().at(p)) return;
                    EXPECT_TRUE(std::any_of(update.boxes.begin(), update.boxes.end(),
                                            [&](const Box3i& box) { return contains(box, p); }));
                });
                const std::uint64_t hash = hash_volume(live.volume());
                if (threads == 1) hashes.push_back(hash);
                EXPECT_EQ(hash, hashes[n++]);
            }
            EXPECT_EQ(live.volume().voxels, instance.volume.voxels);
            EXPECT_EQ(state_of(*lattice).value().resident_bricks, 0);
            EXPECT_TRUE(live.update().value().boxes.empty());
        }
        EXPECT_NE(hashes[0], hashes[5]);
    }
}

TEST(ControlLattice, EachNodeAloneMovesItsTentAndNothingElse) {
    const TaskArena arena(1);
    Instance instance;
    instance.grid = {.first = {3, 1, 2}, .cell = {8, 9, 7}, .size = {3, 4, 3}};
    instance.volume = make_volume({24, 32, 20}, {1, 1, 1}, [](Vec3d p) { return float(p.x); });
    const std::size_t nodes = dense_count(instance.grid.size);
    const Box3i region{{3, 1, 2}, {20, 29, 17}};
    for (std::size_t moved = 0; moved < nodes; ++moved) {
        SCOPED_TRACE("node " + std::to_string(moved));
        instance.shifts.assign(nodes, Vec3d{0, 0, 0});
        instance.shifts[moved] = {0.5, -1, 0.25};
        const auto lattice = make_lattice(instance, arena);
        ASSERT_TRUE(lattice->place(instance.displacements_mm()).ok());
        for_each_voxel(instance.volume.grid, [&](Vec3i p) {
            const Vec3d at{double(p.x), double(p.y), double(p.z)};
            const Vec3d tent = contains(region, p) ? instance.shift_at(at) : Vec3d{0, 0, 0};
            EXPECT_LT(norm(lattice->deformation().displacement_mm(p) - tent), 1e-5) << p.y;
        });
    }
}

TEST(ControlLattice, EachSideOfACutFollowsItsOwnNodes) {
    const TaskArena arena(1);
    for (int across = 0; across < 3; ++across) {
        SCOPED_TRACE(across);
        Instance instance;
        instance.grid = {.first = {0, 0, 0}, .cell = {4, 4, 4}, .size = {4, 4, 4}};
        instance.volume = make_volume({13, 13, 13}, {1, 1, 1}, [](Vec3d p) { return float(p.x); });
        // The sides go apart, by more where a voxel lies farther along the other two axes.
        const auto shift_of = [&](Vec3i p) {
            const double by = 1 + 0.1 * p[(across + 1) % 3] + 0.03 * p[(across + 2) % 3];
            Vec3d shift{0, 0, 0};
            shift[across] = p[across] > 6 ? by : -by;
            return shift;
        };
        for (int k = 0; k < 4; ++k)
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i)
                    instance.shifts.push_back(shift_of({4 * i, 4 * j, 4 * k}));
        const auto on_plane = [&](double u, double v) {
            Vec3d p{u, u, u};
            p[across] = 6.5;
            p[(across + 2) % 3] = v;
            return p;
        };
        const auto lattice = make_lattice(instance, arena);
        const std::vector<CutTriangle> plane{
            {on_plane(-50, -50), on_plane(50, -50), on_plane(-50, 50)},
            {on_plane(50, 50), on_plane(50, -50), on_plane(-50, 50)}};
        ASSERT_TRUE(lattice->set_cuts(plane).ok());
        ASSERT_TRUE(lattice->place(instance.displacements_mm()).ok());
        for_each_voxel(instance.volume.grid, [&](Vec3i p) {
            EXPECT_LT(norm(lattice->deformation().displacement_mm(p) - shift_of(p)), 1e-5)
                << p.x << " " << p.y << " " << p.z;
        });
    }
}

TEST(ControlLattice, FindsTheMaterialWhereItIsNow) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Instance instance = make_instance(random);
        const auto lattice = make_lattice(instance, arena);
        ASSERT_TRUE(lattice->place(instance.displacements_mm()).ok());
        for (int trial = 0; trial < 50; ++trial) {
            Vec3d x;
            for (int a = 0; a < 3; ++a)
                x[a] = instance.grid.first[a] +
                       random.real(0, 1) * instance.grid.cell[a] * (instance.grid.size[a] - 1);
            const Vec3d now = x + instance.shift_at(x);
            const auto found = lattice->find(world_from_voxel(instance.volume.grid, now));
            ASSERT_TRUE(found.has_value());
            const Vec3d low =
                voxel_from_world(instance.volume.grid, lattice->node_mm(found->nodes[0]));
            for (int a = 0; a < 3; ++a)
                EXPECT_NEAR(low[a] + found->at[a] * instance.grid.cell[a], x[a], 1e-6);
        }
        EXPECT_FALSE(
            lattice->find(world_from_voxel(instance.volume.grid, {-1.5, 0, 0})).has_value());
    }
}

TEST(ControlLattice, SaysWhetherCellsFold) {
    const TaskArena arena(1);
    const Volume volume = make_volume({21, 21, 21}, {2, 2, 2}, [](Vec3d) { return 0.0F; });
    auto lattice =
        std::move(ControlLattice::create(volume, {{0, 0, 0}, {5, 5, 5}, {5, 5, 5}}, arena)).value();
    std::vector<Vec3d> shifts(125, {0, 0, 0});
    EXPECT_FALSE(lattice->folds(shifts, 0.99));
    // The cells behind the node keep a part of their length, 10 mm.
    shifts[62] = {6, 0, 0};
    EXPECT_FALSE(lattice->folds(shifts, 0.39));
    EXPECT_TRUE(lattice->folds(shifts, 0.41));
    shifts[62] = {10.1, 0, 0};
    ASSERT_TRUE(lattice->place(shifts).ok());
    EXPECT_TRUE(lattice->folds(shifts));
    const DeformationState state = state_of(*lattice).value();
    EXPECT_GT(state.folded_cells, 0);
    EXPECT_EQ(state.moved_elements, 9 * 9 * 9);
    EXPECT_NEAR(state.max_movement_mm, 10.1, 1e-5);
}

TEST(ControlLattice, BadInputIsRefusedWithOneLineAndNothingChanges) {
    const TaskArena arena(1);
    const Volume volume = make_volume({20, 20, 20}, {1, 1, 1}, [](Vec3d) { return 0.0F; });
    const auto message = [&](ControlGrid grid) {
        return ControlLattice::create(volume, grid, arena).error().message;
    };
    EXPECT_EQ(message({{0, 0, 0}, {5, 5, 5}, {2, 1, 2}}),
              "control lattice size: expected at least 2 along axis 1, found 1");
    EXPECT_EQ(message({{0, 0, 0}, {5, 5, 0}, {2, 2, 2}}),
              "control lattice cell: expected at least 1 along axis 2, found 0");
    EXPECT_EQ(message({{-1, 0, 0}, {5, 5, 5}, {2, 2, 2}}),
              "control lattice first voxel: expected at least 0 along axis 0, found -1");
    EXPECT_EQ(message({{0, 0, 0}, {5, 5, 5}, {2, 5, 2}}),
              "control lattice: expected its last nodes at voxel 19 or before along axis 1, "
              "found 20");
    auto lattice =
        std::move(ControlLattice::create(volume, {{0, 0, 0}, {5, 5, 5}, {3, 3, 3}}, arena)).value();
    std::vector<Vec3d> shifts(27, {0, 0, 0});
    EXPECT_FALSE(lattice->place(std::span(shifts).first(26)).ok());
    shifts[13] = {0, 501, 0};
    EXPECT_FALSE(lattice->place(shifts).ok());
    shifts[13] = {0, std::numeric_limits<double>::quiet_NaN(), 0};
    shifts[12] = {1, 0, 0};
    EXPECT_FALSE(lattice->place(shifts).ok());
    EXPECT_EQ(state_of(*lattice).value().moved_elements, 0);
}

TEST(ControlLattice, AVolumeWithABrokenFieldIsRefused) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const BrokenVolume broken = broken_volume(random);
        expect_refused(ControlLattice::create(broken.volume, {.cell = {1, 1, 1}}, arena),
                       "volume." + broken.field);
    }
}

/// NaN values stay NaN at the positions to which they are carried, and occur nowhere else.
TEST(ControlLattice, StrangeValuesAreCarriedLikeOthers) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = volume_with_strange_values(random);
        auto lattice =
            ControlLattice::create(volume, {.cell = {1, 1, 1}, .size = {4, 4, 4}}, arena);
        ASSERT_TRUE(lattice.ok());
        std::vector<Vec3d> shifts(64);
        const double h = std::min(
            {volume.grid.spacing_mm.x, volume.grid.spacing_mm.y, volume.grid.spacing_mm.z});
        for (Vec3d& u : shifts) u = random.vector(0.2 * h);
        ASSERT_TRUE((*lattice)->place(shifts).ok());
        for (const Mapping mapping : {Mapping::Cells, Mapping::CellsScalar, Mapping::Tetrahedra}) {
            const Deformed deformed = deform_volume(**lattice, mapping).value();
            EXPECT_GT(deformed.written_voxels, 0);
            EXPECT_EQ(check_volume(deformed.volume).ok(), true);
        }
    }
}

}  // namespace
}  // namespace pliant::test
