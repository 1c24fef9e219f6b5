// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans deformed by springs. Their equilibrium is compared with Newton's method on a network that
// is built here.
// Covers: tissue/spring_nodes.cpp, tissue/tissues.cpp.

#include <gtest/gtest.h>
#include <pliant/models/springs.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "support/broken_volumes.h"
#include "tissue/shown_springs.h"

namespace pliant::test {
namespace {

/// Tissue with different values in all voxels; a slab of bone at the bottom.
Volume block(std::uint64_t seed) {
    Random random(seed);
    Volume volume;
    volume.grid = {{41, 37, 33}, {1, 1, 1.5}, {-20, 4, 7}, random.rotation(seed % 2 == 0)};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < 33; ++k)
        for (int n = 0; n < 41 * 37; ++n)
            voxels.push_back(std::int16_t(k < 7 ? 900 : random.whole(-60, 60)));
    volume.voxels = std::move(voxels);
    return volume;
}

std::unique_ptr<SpringScanTissue> make(const Volume& volume, const TaskArena& arena,
                                       SpringDeformationSettings settings = {.cell_mm = 4}) {
    return std::move(SpringScanTissue::create(volume, settings, arena)).value();
}

Vec3d middle_mm(const Volume& volume) {
    return world_from_voxel(volume.grid, {19.7, 18.2, 18.4});
}

std::int64_t settle(SpringScanTissue& tissue) {
    std::int64_t steps = 0;
    while (!tissue.is_settled() && steps < 100'000) {
        const AdvanceReport motion = tissue.advance({.max_steps = 20}).value();
        EXPECT_EQ(motion.message, "");
        steps += motion.steps;
    }
    return steps;
}

TEST(SpringDeformation, TheToolCarriesTheMaterialUnderItAndNothingFarAwayMoves) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Volume volume = block(seed);
        const auto tissue = make(volume, arena, {.cell_mm = 4, .depth = 2});
        const Vec3d point = middle_mm(volume), way = Random(seed).vector(1.5);
        const auto before = control_of(*tissue).find(point);
        const auto report = tissue->push(7, {.point_mm = point, .push_mm = way});
        ASSERT_TRUE(report.ok());
        EXPECT_EQ(report->status, PushStatus::Applied);
        EXPECT_EQ(report->grabbed_elements, 8);
        std::int64_t moved_nodes = 0;
        const std::vector<Vec3d>& moves = displacements_of(*tissue);
        for (const Vec3d& u : moves) moved_nodes += u != Vec3d{0, 0, 0};
        EXPECT_EQ(report->moved_elements, moved_nodes);
        EXPECT_GT(moved_nodes, 8);
        EXPECT_GT(settle(*tissue), 0);
        const auto now = control_of(*tissue).find(point + way);
        ASSERT_TRUE(before && now);
        EXPECT_EQ(now->nodes, before->nodes);
        EXPECT_NEAR(norm(now->at - before->at), 0, 1e-6);
        // Layers count links, face diagonals too: two layers are two nodes away at most.
        const ControlGrid& grid = control_of(*tissue).grid();
        const auto place = [&](std::int32_t n) {
            return Vec3i{n % grid.size.x, n / grid.size.x % grid.size.y,
                         n / (grid.size.x * grid.size.y)};
        };
        int moved = 0;
        for (std::int32_t n = 0; n < control_of(*tissue).node_count(); ++n) {
            if (displacements_of(*tissue)[std::size_t(n)] == Vec3d{0, 0, 0}) continue;
            ++moved;
            const Vec3i low = place(n) - place(before->nodes[0]);
            for (int a = 0; a < 3; ++a) EXPECT_TRUE(low[a] >= -2 && low[a] <= 3);
        }
        EXPECT_GT(moved, 8);
    }
}

TEST(SpringDeformation, PicturesNearTheStateChangeNeitherTheStateNorTheLastPicture) {
    const TaskArena arena(2);
    const Volume volume = block(5);
    const SpringDeformationSettings settings{.cell_mm = 3, .depth = 6};
    const auto seen = make(volume, arena, settings), twin = make(volume, arena, settings);
    auto live = LiveDeformation::create(*seen);
    ASSERT_TRUE(live.ok());
    const Vec3d point = middle_mm(volume), way = volume.grid.direction * Vec3d{0.4, 0.2, 0.1};
    std::int64_t most = 0;
    int incomplete = 0;
    for (int n = 0; n < 6; ++n) {
        for (const auto& tissue : {seen.get(), twin.get()}) {
            const auto pushed =
                tissue->push(1, {.point_mm = point + double(n) * way, .push_mm = way});
            ASSERT_TRUE(pushed.ok());
            ASSERT_TRUE(tissue->advance({.max_steps = 20}).ok());
        }
        const auto update = live->approach(2000);
        ASSERT_TRUE(update.ok());
        incomplete += !update->is_complete;
        most = std::max(most, update->written_voxels);
        EXPECT_EQ(seen->hash(), twin->hash());
    }
    EXPECT_EQ(incomplete, 6);
    const Volume expected = deform_volume(*twin)->volume;
    EXPECT_LT(most, deform_volume(*twin)->written_voxels * 3 / 4);
    EXPECT_NE(hash_volume(live->volume()), hash_volume(expected));
    // Without more motion it arrives; so does an update at once.
    int updates = 0;
    for (bool done = false; !done && updates < 300; ++updates)
        done = live->approach(2000)->is_complete;
    EXPECT_GT(updates, 1);
    EXPECT_LT(updates, 300);
    EXPECT_EQ(hash_volume(live->volume()), hash_volume(expected));
    EXPECT_EQ(seen->deformation().hash(), twin->deformation().hash());
}

TEST(SpringDeformation, ThinBoneStaysWhereItIsThoughItsCellsAreMostlySoft) {
    const TaskArena arena(2);
    Volume volume = block(2);
    std::vector<std::int16_t> voxels;
    std::vector<Vec3i> plate;
    for (int k = 0; k < 33; ++k)
        for (int j = 0; j < 37; ++j)
            for (int i = 0; i < 41; ++i) {
                const bool is_bone = i == 26 && k > 10 && k < 26;
                voxels.push_back(is_bone ? 900 : 30);
                if (is_bone) plate.push_back({i, j, k});
            }
    volume.voxels = voxels;
    double moved[2] = {0, 0};
    for (const bool by_cells : {false, true}) {
        const auto tissue = make(volume, arena, {.cell_mm = 4, .fixed_share = by_cells ? 0.05 : 1});
        const auto place = [&](Vec3i p) {
            return control_of(*tissue).find(
                world_from_voxel(volume.grid, {double(p.x), double(p.y), double(p.z)}));
        };
        std::vector<ControlPosition> before;
        for (const Vec3i p : plate) before.push_back(*place(p));
        const auto report = tissue->push(
            1, {.point_mm = middle_mm(volume), .push_mm = volume.grid.direction * Vec3d{2, 0, 0}});
        ASSERT_TRUE(report.ok());
        EXPECT_EQ(report->status, PushStatus::Applied);
        settle(*tissue);
        for (std::size_t n = 0; n < plate.size(); ++n) {
            const auto now = place(plate[n]);
            ASSERT_TRUE(now.has_value());
            if (now->nodes == before[n].nodes)
                moved[by_cells] = std::max(moved[by_cells], norm(now->at - before[n].at));
            else
                moved[by_cells] = 1;
        }
    }
    EXPECT_GT(moved[0], 0.1);
    EXPECT_LT(moved[1], 1e-9);
}

TEST(SpringDeformation, ALabelEverywhereIsTheSameAsTheSettings) {
    const TaskArena arena(1);
    const Volume volume = block(3);
    auto labels = std::make_shared<Volume>(volume);
    labels->voxels = std::vector<std::int16_t>(voxel_count(volume.grid), 5);
    const auto hash = [&](const SpringDeformationSettings& settings) {
        const auto tissue = make(volume, arena, settings);
        EXPECT_TRUE(tissue->push(1, {.point_mm = middle_mm(volume), .push_mm = {1.5, 0, 1}}).ok());
        settle(*tissue);
        return tissue->hash();
    };
    const LabelMaterial soft{.values = {5}, .elastic = ElasticPair{3, 0.45}};
    const std::uint64_t expected =
        hash({.cell_mm = 4, .young_modulus_pa = 3000, .poisson_ratio = 0.45});
    EXPECT_EQ(hash({.cell_mm = 4, .label_materials = {soft}, .labels = labels}), expected);
    EXPECT_NE(hash({.cell_mm = 4, .young_modulus_pa = 3000}), expected);
    EXPECT_NE(hash({.cell_mm = 4, .poisson_ratio = 0.45}), expected);
    // Labels without a table follow the settings.
    LabelMaterial other = soft;
    other.values = {6};
    EXPECT_EQ(hash({.cell_mm = 4, .label_materials = {other}, .labels = labels}),
              hash({.cell_mm = 4}));
    const auto fixed = make(volume, arena,
                            {.cell_mm = 4,
                             .label_materials = {{.values = {5}, .law = LabelLaw::Immobile}},
                             .labels = labels});
    EXPECT_EQ(fixed->fixed_nodes(), control_of(*fixed).node_count());
    const auto message = [&](const SpringDeformationSettings& settings) {
        return SpringScanTissue::create(volume, settings, arena).error().message;
    };
    EXPECT_EQ(message({.cell_mm = 4, .fixed_hu = -2000}),
              "fixed_hu: expected a value that leaves nodes free, found -2000 HU, with which bone "
              "holds all of them");
    EXPECT_EQ(message({.cell_mm = 4, .label_materials = {soft}}),
              "labels: expected a label volume for [[label]], found none");
    LabelMaterial auxetic = soft;
    auxetic.elastic = ElasticPair{3, 0.2};
    EXPECT_EQ(message({.cell_mm = 4, .label_materials = {auxetic}, .labels = labels}),
              "[[label]] 1 elastic: expected a Poisson's ratio from 0.25, below 0.5, for springs, "
              "found 0.2");
}

TEST(SpringDeformation, ComesToRestWhereNewtonsMethodDoes) {
    const TaskArena arena(2);
    const Volume volume = block(1);
    const auto tissue = make(volume, arena, {.cell_mm = 4, .depth = 64});
    const Vec3d point = middle_mm(volume), way{1.1, -0.8, 0.9};
    ASSERT_TRUE(tissue->push(1, {.point_mm = point, .push_mm = way}).ok());
    settle(*tissue);
    const ControlGrid& grid = control_of(*tissue).grid();
    SpringScan scan{.region = {grid.first, {}}, .size = grid.size, .fixed_hu = 300};
    for (int a = 0; a < 3; ++a)
        scan.region.end[a] = grid.first[a] + grid.cell[a] * (grid.size[a] - 1) + 1;
    auto network = SpringNetwork::create(std::move(*springs_of_scan(volume, scan)));
    ASSERT_TRUE(network.ok());
    auto oracle = std::move(SpringTissue::create(std::move(*network), {.depth = 64})).value();
    const auto held = control_of(*tissue).find(point + way);
    ASSERT_TRUE(held.has_value());
    ASSERT_TRUE(oracle.hold(held->nodes).ok());
    ASSERT_TRUE(oracle.shift_held(way).ok());
    ASSERT_TRUE(oracle.find_equilibrium().ok());
    double worst = 0;
    for (std::int32_t n = 0; n < control_of(*tissue).node_count(); ++n)
        worst = std::max(worst,
                         norm(oracle.displacement(n) - displacements_of(*tissue)[std::size_t(n)]));
    EXPECT_LT(worst, 2e-3);
    const Vec3d force = tissue->force_n(1).value();
    const auto expected = oracle.reaction(held->nodes, ReactionLaw::Held);
    EXPECT_NEAR(norm(force - 1e-6 * expected->force), 0, 2e-3 * norm(force));
    EXPECT_LT(dot(force, way), 0);  // a resisting force
}

TEST(SpringDeformation, LetGoItComesBackBitForBit) {
    const TaskArena arena(2);
    const Volume volume = block(3);
    const auto tissue = make(volume, arena);
    const std::uint64_t at_rest = tissue->hash();
    LiveDeformation live = LiveDeformation::create(*tissue).value();
    ASSERT_TRUE(tissue->push(1, {.point_mm = middle_mm(volume), .push_mm = {2, 0, 1}}).ok());
    ASSERT_TRUE(tissue
                    ->push(1, {.point_mm = middle_mm(volume) + Vec3d{2, 0, 1},
                               .push_mm = {0, 2, 0},
                               .sphere_radius_mm = 5})
                    .ok());
    (void)live.update();
    EXPECT_NE(hash_volume(live.volume()), hash_volume(volume));
    EXPECT_TRUE(tissue->is_touched());
    (void)tissue->advance({.max_steps = 20});
    ASSERT_TRUE(tissue->set_depth(1).ok());  // most of the tissue is then out of reach
    tissue->release(1);
    EXPECT_FALSE(tissue->is_touched());
    EXPECT_GT(settle(*tissue), 0);
    (void)live.update();
    EXPECT_EQ(live.volume().voxels, volume.voxels);
    EXPECT_EQ(tissue->hash(), at_rest);
}

TEST(SpringDeformation, AnyNumberOfThreadsGivesTheSameBits) {
    const Volume volume = block(2);
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 4}) {
        const TaskArena arena(threads);
        const auto tissue = make(volume, arena);
        const Vec3d point = middle_mm(volume);
        ASSERT_TRUE(tissue->push(1, {.point_mm = point, .push_mm = {2, 1, 0}}).ok());
        (void)tissue->advance({.max_steps = 7});
        ASSERT_TRUE(
            tissue->push(2, {.point_mm = point + Vec3d{9, 0, 0}, .push_mm = {-1, 0, 2}}).ok());
        (void)tissue->advance({.max_steps = 30});
        tissue->release(1);
        ASSERT_TRUE(tissue->set_depth(4).ok());
        (void)tissue->advance({.max_steps = 30});
        hashes.push_back(tissue->hash() ^ hash_volume(deform_volume(*tissue).value().volume));
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(SpringDeformation, BoneStaysAndCannotBePushed) {
    const TaskArena arena(1);
    const Volume volume = block(1);
    const auto tissue = make(volume, arena);
    EXPECT_GT(tissue->fixed_nodes(), 0);
    const auto report = tissue->push(
        1, {.point_mm = world_from_voxel(volume.grid, {20, 18, 2}), .push_mm = {1, 1, 1}});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Rejected);
    EXPECT_EQ(report->limited_by, LimitedBy::Bone);
    EXPECT_EQ(report->step_fraction, 0);
    EXPECT_FALSE(tissue->is_touched());
    EXPECT_EQ(state_of(*tissue).value().moved_elements, 0);
    const Vec3d down = -1.5 * volume.grid.direction.columns[2];
    ASSERT_TRUE(tissue->push(1, {.point_mm = middle_mm(volume), .push_mm = down}).ok());
    settle(*tissue);
    const Deformed deformed = deform_volume(*tissue).value();
    for (int j = 0; j < 37; ++j)
        for (int i = 0; i < 41; ++i)
            for (int k = 0; k < 4; ++k)
                ASSERT_EQ(deformed.volume.at({i, j, k}), volume.at({i, j, k}));
    EXPECT_GT(deformed.written_voxels, 1000);
}

TEST(SpringDeformation, APushStopsBeforeACellFolds) {
    const TaskArena arena(1);
    const Volume volume = block(1);
    const auto tissue = make(volume, arena);
    const auto report = tissue->push(1, {.point_mm = middle_mm(volume), .push_mm = {30, 0, 0}});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Limited);
    EXPECT_EQ(report->limited_by, LimitedBy::Fold);
    EXPECT_GT(report->step_fraction, 0.05);
    EXPECT_LT(report->step_fraction, 1);
    EXPECT_FALSE(control_of(*tissue).folds(displacements_of(*tissue)));
    EXPECT_EQ(state_of(*tissue).value().folded_cells, 0);
    // It went on in finer strides than the twentieths of a cell with which it began.
    const double edge_mm = norm(control_of(*tissue).node_mm(1) - control_of(*tissue).node_mm(0));
    const double strides = report->step_fraction * std::ceil(30 / (edge_mm / 20));
    EXPECT_GT(std::abs(strides - std::round(strides)), 0.1) << strides;
    EXPECT_EQ(8 * strides, std::round(8 * strides)) << "not finer than an eighth";
}

TEST(SpringDeformation, AShapeCanBePutBack) {
    const TaskArena arena(1);
    const Volume volume = block(1);
    const auto tissue = make(volume, arena), other = make(volume, arena);
    ASSERT_TRUE(tissue->push(1, {.point_mm = middle_mm(volume), .push_mm = {2, 0, 0}}).ok());
    settle(*tissue);
    ASSERT_TRUE(other->set_positions(positions_of(*tissue)).ok());
    EXPECT_EQ(hash_volume(deform_volume(*other).value().volume),
              hash_volume(deform_volume(*tissue).value().volume));
    EXPECT_EQ(other->hash(), tissue->hash());
    EXPECT_FALSE(other->set_positions(std::vector<Vec3d>(3, {0, 0, 0})).ok());
    EXPECT_FALSE(other->is_settled());  // no tool holds it
    settle(*other);
    EXPECT_EQ(state_of(*other).value().moved_elements, 0);
    ASSERT_TRUE(tissue->reset().ok());
    EXPECT_EQ(state_of(*tissue).value().moved_elements, 0);
    EXPECT_EQ(tissue->hash(), other->hash());
}

TEST(SpringDeformation, BadInputIsRefusedWithOneLine) {
    const TaskArena arena(1);
    const Volume volume = block(1);
    const auto message = [&](const SpringDeformationSettings& settings) {
        return SpringScanTissue::create(volume, settings, arena).error().message;
    };
    EXPECT_EQ(message({.cell_mm = 0}), "cell_mm: expected above 0, up to 1000 mm, found 0");
    EXPECT_EQ(message({.cell_mm = 19}),
              "cell_mm: expected at most 18, so that two cells fit into the region along axis "
              "1, found 19");
    EXPECT_EQ(message({.region = {{0, 0, 0}, {42, 9, 9}}}),
              "region: expected a box of voxels inside of the scan");
    EXPECT_EQ(message({.cell_mm = 4, .young_modulus_pa = -1}),
              "young_modulus_pa: expected 1 to 1e9 Pa, found -1");
    EXPECT_EQ(message({.cell_mm = 4, .poisson_ratio = 0.5}),
              "poisson_ratio: expected 0.25 to 0.499, found 0.5");
    EXPECT_EQ(message({.cell_mm = 4, .depth = -1}),
              "depth: expected 0 to 1000000 layers, found -1");
    EXPECT_EQ(message({.cell_mm = 4, .damping_s = 0}),
              "damping_s: expected 0.0001 to 10000 s, found 0");
    const auto tissue = make(volume, arena);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(tissue->push(1, {.point_mm = {nan, 0, 0}, .push_mm = {1, 0, 0}}).ok());
    EXPECT_FALSE(tissue->push(1, {.point_mm = middle_mm(volume), .push_mm = {nan, 0, 0}}).ok());
    EXPECT_FALSE(tissue->push(1, {.point_mm = {500, 0, 0}, .push_mm = {1, 0, 0}}).ok());
    EXPECT_FALSE(tissue->set_depth(-1).ok());
    EXPECT_FALSE(tissue->is_touched());
    EXPECT_EQ(tissue->advance({.max_steps = 10}).value().steps, 0);
}

TEST(SpringDeformation, AVolumeWithABrokenFieldIsRefusedAndStrangeValuesArePushed) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const BrokenVolume broken = broken_volume(random);
        expect_refused(SpringScanTissue::create(broken.volume, {.cell_mm = 0.1}, arena),
                       "volume." + broken.field);
        expect_refused(springs_of_scan(broken.volume, {.size = {3, 3, 3}}),
                       "volume." + broken.field);
        if (seed > 20) continue;
        const Volume strange = volume_with_strange_values(random);
        auto tissue = SpringScanTissue::create(strange, {.cell_mm = 0.1}, arena);
        ASSERT_TRUE(tissue.ok()) << tissue.error().message;
        const Vec3d middle = control_of(**tissue).node_mm(control_of(**tissue).node_count() / 2);
        (void)(*tissue)->push(1, {.point_mm = middle, .push_mm = {0.02, 0, 0}});
        for (const Vec3d& u : displacements_of(*(*tissue))) ASSERT_TRUE(is_finite(u));
    }
}

}  // namespace
}  // namespace pliant::test
