// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Materials by label and direction, changes of materials under a deformed lattice, and their fold
// certificates.
// Covers: chainmail/change_materials.cpp, material/certificate.cpp, material/labels.cpp,
// material/material*.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "chainmail/chainmail_impl.h"
#include "chainmail/oracle.h"
#include "chainmail/tissues.h"
#include "lattice/lattice.h"
#include "material/certificate.h"
#include "material/labels.h"

namespace pliant::test {
namespace {

ElementLimits isotropic(double fraction, double max_movement_mm = 500) {
    const Vec3d v{fraction, fraction, fraction};
    return {v, v, v, max_movement_mm, false};
}

std::shared_ptr<Volume> random_labels(Random& random, const Grid& grid, int highest) {
    auto labels = std::make_shared<Volume>();
    labels->grid = grid;
    std::vector<std::int16_t> voxels(voxel_count(grid));
    for (auto& v : voxels) v = std::int16_t(random.whole(0, highest));
    labels->voxels = voxels;
    return labels;
}

std::shared_ptr<VectorField> random_directions(Random& random, const Grid& grid) {
    auto field = std::make_shared<VectorField>();
    field->grid = grid;
    for (std::size_t n = 0; n < voxel_count(grid); ++n) {
        const Vec3d d = random.vector(1);
        field->vectors_mm.push_back({float(d.x), float(d.y), float(d.z)});
    }
    return field;
}

/// Label 1: constant along the lattice; label 2: along the direction; label 3: the law, scaled.
ChainMailSettings labelled_settings(Random& random, const Instance& instance) {
    ChainMailSettings settings;
    settings.custom_law = instance.law;
    const auto numbers = [&] {
        return Vec3d{random.ratio(0.01, 0.4), random.ratio(0.01, 0.4), random.ratio(0.01, 0.4)};
    };
    LabelMaterial constant{.values = {1}, .law = LabelLaw::Constant};
    constant.compress = numbers();
    constant.stretch = numbers();
    constant.shear = numbers();
    LabelMaterial fibres = constant;
    fibres.values = {2, 5};
    fibres.shear = numbers();
    fibres.along_direction = true;
    const LabelMaterial scaled{.values = {3}, .factor = numbers()};
    settings.label_materials = {constant, fibres, scaled};
    for (LabelMaterial& material : settings.label_materials) material.max_movement_mm = 500;
    settings.labels = random_labels(random, instance.volume.grid, 5);
    settings.directions = random_directions(random, instance.volume.grid);
    return settings;
}

/// Expected limits of one element with these settings, computed independently.
ElementLimits expected_limits(const ChainMailSettings& settings, const Volume& volume, Vec3i e) {
    if (!contains(voxel_box(volume.grid), e)) return settings.custom_law(kAirHu);
    const int label = int(settings.labels->at(e));
    const ElementLimits by_value = settings.custom_law(int(volume.at(e)));
    if (label == 0 || label == 4) return by_value;
    const LabelMaterial& m = settings.label_materials[label == 1 ? 0 : label == 3 ? 2 : 1];
    ElementLimits limits = by_value;
    if (label == 3) {
        for (int b = 0; b < 3; ++b) {
            limits.compress[b] *= m.factor[b];
            limits.stretch[b] *= m.factor[b];
            limits.shear[b] *= m.factor[b];
        }
        return limits;
    }
    int axis = 0;
    if (label != 1) {
        const Vec3f d = settings.directions->vectors_mm[voxel_index(volume.grid, e)];
        const Vec3d lattice = lattice_from_world_vector(volume.grid, {d.x, d.y, d.z});
        for (int a = 1; a < 3; ++a)
            if (std::abs(lattice[a]) > std::abs(lattice[axis])) axis = a;
    }
    limits = {.max_movement_mm = 500};
    for (int n = 0; n < 3; ++n) {
        limits.compress[(axis + n) % 3] = m.compress[n];
        limits.stretch[(axis + n) % 3] = m.stretch[n];
        limits.shear[(axis + n) % 3] = m.shear[n];
    }
    return limits;
}

TEST(Labels, LabelsAndDirectionsEqualTheOracleWithALawPerElement) {
    for (std::uint64_t seed = 500; seed < 540 && !::testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(2);
        Instance instance = random_instance(random, 4, 8, false);
        instance.volume.grid.direction = random.rotation(seed % 2 == 0);
        ChainMailSettings settings = labelled_settings(random, instance);
        settings.brick_size = random.whole(2, 9);
        settings.solver = seed % 3 ? ChainMailSolver::Sweep : ChainMailSolver::Heap;
        ChainMail tissue = tissue_of(instance.volume, arena, settings);
        const auto limits_at = [&](Vec3i e) {
            return expected_limits(settings, instance.volume, e);
        };
        Oracle<std::int64_t> exact(instance.volume.grid, limits_at, kInstanceMargin);
        for (int step = 0; step < 3; ++step) {
            const auto grabbed = random_grab(random, instance.volume.grid);
            const Vec3<Fixed> before = lattice_of(tissue).displacement_at(grabbed[0]);
            ASSERT_TRUE(
                tissue.push_elements(grabbed, random.vector(instance.push_limit_mm.x)).ok());
            const Vec3<Fixed> done = lattice_of(tissue).displacement_at(grabbed[0]) - before;
            exact.push(grabbed, Vec3<std::int64_t>{done.x, done.y, done.z});
            ASSERT_TRUE(exact.margin_at_rest());
            std::int64_t differing = 0;
            exact.for_each([&](Vec3i e) {
                const Vec3<Fixed> u = lattice_of(tissue).displacement_at(e);
                for (int a = 0; a < 3; ++a) differing += u[a] != exact.displacement(e, a);
            });
            EXPECT_EQ(differing, 0);
            EXPECT_LT(tissue.state().max_violation_mm, 1e-5);
        }
    }
}

TEST(Labels, ImmobileLabelStopsAPushLikeBone) {
    const Volume volume = block({20, 20, 20}, 40);
    const TaskArena arena(1);
    ChainMailSettings settings;
    auto labels = std::make_shared<Volume>(block({20, 20, 20}, 0));
    for (int n = 0; n < 400; ++n) std::get<0>(labels->voxels)[std::size_t(16 * 400 + n)] = 7;
    settings.labels = labels;
    settings.label_materials = {{.values = {7}, .law = LabelLaw::Immobile}};
    ChainMail tissue = tissue_of(volume, arena, settings);
    const auto report = tissue.push({.point_mm = {10.5, 10.5, 12.5}, .push_mm = {0, 0, 4}});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->limited_by, LimitedBy::Bone);
    EXPECT_EQ(tissue.displacement_mm({10, 10, 16}), (Vec3d{0, 0, 0}));
    EXPECT_GT(report->step_fraction, 0.05);
}

TEST(Labels, DominantAxisFollowsTheLatticeAndNotTheWorld) {
    Grid grid;
    EXPECT_EQ(dominant_axis(grid, {0.1, -0.9, 0.3}), 1);
    EXPECT_EQ(dominant_axis(grid, {0, 0, 0}), 0);
    // i, j, k point along y, z, x.
    grid.direction = {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}};
    EXPECT_EQ(dominant_axis(grid, {0.1, -0.9, 0.3}), 0);
    EXPECT_EQ(dominant_axis(grid, {5, 1, 1}), 2);
}

TEST(Labels, WrongLabelsAreRefusedInOneLine) {
    const Volume volume = block({8, 8, 8}, 40);
    const TaskArena arena(1);
    ChainMailSettings settings;
    settings.label_materials = {{.values = {1}, .along_direction = true}};
    const auto refused = [&](const char* what) {
        const auto tissue = ChainMail::create(volume, settings, arena);
        ASSERT_FALSE(tissue.ok()) << what;
        EXPECT_NE(tissue.error().message.find(what), std::string::npos) << tissue.error().message;
        EXPECT_EQ(tissue.error().message.find('\n'), std::string::npos);
    };
    refused("labels: expected a label volume for [[label]], found none");
    settings.labels = std::make_shared<Volume>(block({8, 8, 9}, 0));
    refused("labels: expected the scan's grid, 8 × 8 × 8 voxels, found 8 × 8 × 9");
    auto labels = std::make_shared<Volume>(block({8, 8, 8}, 0));
    labels->grid.origin_mm = {0, 0.5, 0};
    settings.labels = labels;
    refused("labels: expected the scan's grid, found one of the same size whose origin");
    settings.labels = std::make_shared<Volume>(block({8, 8, 8}, 0));
    refused("directions: expected a vector field");
    auto directions = std::make_shared<VectorField>();
    directions->grid = volume.grid;
    directions->grid.size.x = 7;
    settings.directions = directions;
    refused("directions: expected the scan's grid");
    settings.label_materials = {{.values = {}}};
    refused("[[label]] 1 values");
    settings.label_materials.clear();
    // 45 materials by value, each with limits of its own for 1300 values.
    for (int n = 1; n <= 60; ++n)
        settings.label_materials.push_back({.values = {n}, .offset = 0.1 + 0.01 * n});
    refused("expected up to 65535 different limits");
}

TEST(Labels, UntouchedPartsTakeNoMemory) {
    const Volume volume = block({64, 64, 64}, 40);
    const TaskArena arena(1);
    ChainMailSettings settings, plain;
    settings.labels = std::make_shared<Volume>(block({64, 64, 64}, 1));
    settings.label_materials = {{.values = {1}, .factor = {1, 1, 0.5}}};
    ChainMail labelled = tissue_of(volume, arena, settings), bare = tissue_of(volume, arena, plain);
    for (ChainMail* tissue : {&labelled, &bare}) {
        EXPECT_EQ(tissue->state().resident_bricks, 0);
        ASSERT_TRUE(tissue->push({.point_mm = {30, 30, 30}, .push_mm = {0.5, 0, 0}}).ok());
    }
    EXPECT_EQ(labelled.state().bytes_per_resident_element, bare.state().bytes_per_resident_element);
}

class ChangeTest : public ::testing::Test {
  protected:
    ChangeTest() { settings.air_enabled = false; }
    TaskArena arena{2};
    Volume volume = block({24, 24, 24}, 40);
    ChainMailSettings settings;
};

TEST_F(ChangeTest, NothingMovesAndLinksMayOnlyComeBack) {
    for (std::uint64_t seed = 900; seed < 920; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Instance instance = random_instance(random, 6, 9, false);
        ChainMailSettings soft;
        soft.custom_law = instance.law;
        soft.solver = seed % 2 ? ChainMailSolver::Sweep : ChainMailSolver::Heap;
        soft.brick_size = random.whole(2, 9);
        ChainMail tissue = tissue_of(instance.volume, arena, soft);
        const auto push = [&] {
            ASSERT_TRUE(tissue
                            .push_elements(random_grab(random, instance.volume.grid),
                                           random.vector(instance.push_limit_mm.x))
                            .ok());
        };
        for (int n = 0; n < 3; ++n) push();
        const std::uint64_t hash = tissue.hash();
        ChainMailSettings hard = soft;
        hard.custom_law = [law = instance.law](int value) {
            ElementLimits limits = law(value);
            for (Vec3d* v : {&limits.compress, &limits.stretch, &limits.shear}) *v = 0.3 * *v;
            return limits;
        };
        ASSERT_TRUE(tissue.set_materials(hard).ok());
        EXPECT_EQ(tissue.hash(), hash);
        std::int64_t excused = tissue.state().excused_links;
        EXPECT_GT(excused, 0);
        for (int n = 0; n < 6; ++n) {
            push();
            const LatticeState state = tissue.state();
            EXPECT_LT(state.max_violation_mm, 1e-5);
            EXPECT_LE(state.excused_links, excused);
            excused = state.excused_links;
        }
        // Back to the first law: no excuse is needed any more.
        ASSERT_TRUE(tissue.set_materials(soft).ok());
        EXPECT_EQ(tissue.state().excused_links, 0);
        EXPECT_FALSE(lattice_of(tissue).may_exceed_limits());
        EXPECT_LT(tissue.state().max_violation_mm, 1e-5);
    }
}

TEST_F(ChangeTest, TheCheckSeesALinkThatGotWorse) {
    settings.custom_law = [](int) { return isotropic(0.3); };
    ChainMail tissue = tissue_of(volume, arena, settings);
    const std::vector<Vec3i> one = {{12, 12, 12}};
    ASSERT_TRUE(tissue.push_elements(one, {1, 0, 0}).ok());
    ChainMailSettings hard = settings;
    hard.custom_law = [](int) { return isotropic(0.1); };
    ASSERT_TRUE(tissue.set_materials(hard).ok());
    EXPECT_LT(tissue.state().max_violation_mm, 1e-9);
    // Directly in the lattice, bypassing the solver: one link by 0.25 mm beyond its excused
    // difference.
    Lattice& lattice = lattice_of(tissue);
    const ElementRef element = lattice.ensure_element({12, 12, 12});
    lattice.brick(element.brick).u[0][std::size_t(element.index)] += units_from_mm(0.25);
    EXPECT_NEAR(tissue.state().max_violation_mm, 0.25, 1e-5);
}

TEST_F(ChangeTest, ExcusedLinksComeBackAndStayBack) {
    settings.custom_law = [](int) { return isotropic(0.3); };
    ChainMail tissue = tissue_of(volume, arena, settings);
    const std::vector<Vec3i> one = {{12, 12, 12}};
    ASSERT_TRUE(tissue.push_elements(one, {1, 0, 0}).ok());
    ChainMailSettings hard = settings;
    hard.custom_law = [](int) { return isotropic(0.1); };
    ASSERT_TRUE(tissue.set_materials(hard).ok());
    const std::int64_t at_first = tissue.state().excused_links;
    ASSERT_TRUE(tissue.push_elements(one, {-1, 0, 0}).ok());
    const std::int64_t then = tissue.state().excused_links;
    EXPECT_LT(then, at_first);
    // The links of the grabbed element are within the new limits permanently.
    ASSERT_TRUE(tissue.push_elements(one, {1, 0, 0}).ok());
    EXPECT_LE(tissue.state().excused_links, then);
    const double away =
        tissue.displacement_mm({12, 12, 12}).x - tissue.displacement_mm({13, 12, 12}).x;
    EXPECT_LE(away, 0.1 + 1e-5);
}

TEST_F(ChangeTest, MovementLimitCannotBeEludedByPushingElsewhereOrChangingTheLawToAndFro) {
    settings.max_movement_mm = 4;
    ChainMail tissue = tissue_of(volume, arena, settings);
    const double w = 1040 / 4095.0, limit = 4 * (1 - w * w);
    const std::vector<Vec3i> here = {{12, 12, 12}}, elsewhere = {{6, 18, 6}};
    const auto farthest = [&] { return tissue.state().max_movement_mm; };
    EXPECT_EQ(tissue.push_elements(here, {10, 0, 0})->limited_by, LimitedBy::Movement);
    EXPECT_NEAR(farthest(), limit, 1e-4);
    for (int n = 0; n < 6; ++n) {
        // Elsewhere and back, with another threshold, window or offset in between.
        ASSERT_TRUE(tissue.push_elements(elsewhere, {0, -1, 0}).ok());
        ChainMailSettings other = settings;
        other.offset = n % 2 ? 0.3 : 0.1;
        other.bone_threshold_hu = 200 + 100 * n;
        other.air_threshold_hu = n % 2 ? 0 : -800;
        other.air_enabled = false;
        ASSERT_TRUE(tissue.set_materials(other).ok());
        ASSERT_TRUE(tissue.push_elements(here, {3, 0, 0}).ok());
        ASSERT_TRUE(tissue.set_materials(settings).ok());
        ASSERT_TRUE(tissue.push_elements(here, {3, 0, 0}).ok());
        EXPECT_LE(farthest(), limit + 1e-6);
    }
    // A shorter limit: elements beyond it may come back, and not go farther.
    ChainMailSettings shorter = settings;
    shorter.max_movement_mm = 1;
    ASSERT_TRUE(tissue.set_materials(shorter).ok());
    const double beyond = tissue.displacement_mm({12, 12, 12}).x;
    EXPECT_EQ(tissue.push_elements(here, {1, 0, 0})->status, PushStatus::Rejected);
    EXPECT_EQ(tissue.push_elements(here, {-1, 0, 0})->status, PushStatus::Applied);
    EXPECT_NEAR(tissue.displacement_mm({12, 12, 12}).x, beyond - 1, 1e-5);
    ASSERT_TRUE(tissue.push_elements(here, {0.5, 0, 0}).ok());
    EXPECT_LE(tissue.displacement_mm({12, 12, 12}).x, beyond - 1 + 1e-5);
}

TEST_F(ChangeTest, ElementsThatBecomeBoneStayWhereTheyAre) {
    for (int n = 0; n < 24 * 24; ++n) std::get<0>(volume.voxels)[std::size_t(16 * 576 + n)] = 250;
    ChainMail tissue = tissue_of(volume, arena, settings);
    const std::vector<Vec3i> one = {{12, 12, 14}};
    ASSERT_TRUE(tissue.push_elements(one, {0, 0, 2}).ok());
    const Vec3d there = tissue.displacement_mm({12, 12, 16});
    EXPECT_GT(there.z, 1);
    ChainMailSettings bony = settings;
    bony.bone_threshold_hu = 200;
    ASSERT_TRUE(tissue.set_materials(bony).ok());
    for (const Vec3d& push : {Vec3d{0, 0, 2}, {0, 0, -4}, {1, 0, 0}}) {
        ASSERT_TRUE(tissue.push_elements(one, push).ok());
        EXPECT_EQ(tissue.displacement_mm({12, 12, 16}), there);
        EXPECT_LT(tissue.state().max_violation_mm, 1e-5);
    }
}

TEST_F(ChangeTest, ResidentBricksFollowAndBadSettingsChangeNothing) {
    ChainMail tissue = tissue_of(volume, arena, settings);
    const std::vector<Vec3i> one = {{12, 12, 12}};
    ASSERT_TRUE(tissue.push_elements(one, {1, 0, 0}).ok());
    ChainMailSettings changed = settings;
    changed.offset = 0.3;
    ASSERT_TRUE(tissue.set_materials(changed).ok());
    const Lattice& lattice = lattice_of(tissue);
    for (const int index : lattice.resident_bricks())
        for (int n = 0; n < lattice.elements_per_brick(); ++n) {
            const Brick& brick = lattice.brick(index);
            ASSERT_EQ(brick.material[n], lattice.material_at(lattice.element_of(brick.coord, n)));
        }
    const auto refused = [&](ChainMailSettings wrong, const char* what) {
        const Status status = tissue.set_materials(wrong);
        ASSERT_FALSE(status.ok());
        EXPECT_NE(status.error().message.find(what), std::string::npos) << status.error().message;
        EXPECT_EQ(tissue.settings().offset, 0.3);
    };
    ChainMailSettings wrong = changed;
    wrong.offset = 2;
    refused(wrong, "[material] offset");
    wrong = changed;
    wrong.brick_size = 16;
    refused(wrong, "[lattice] brick_size: expected 8 as at the start, found 16");
    wrong = changed;
    wrong.bounded = true;
    refused(wrong, "[lattice] bounded: expected false as at the start, found true");
    wrong = changed;
    wrong.label_materials = {{.values = {1}}};
    refused(wrong, "labels: expected a label volume");
}

ChainMailSettings settings_of(Vec3d compress, Vec3d stretch, Vec3d shear) {
    ChainMailSettings settings;
    settings.custom_law = [=](int) { return ElementLimits{compress, stretch, shear, 500, false}; };
    return settings;
}

/// The affine displacement −N·x of certificate.h appears in the cell below the pushed element.
Vec3d folding_push(const Grid& grid, Vec3d compress, Vec3d shear) {
    Vec3d push{};
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
            push[a] -= grid.spacing_mm[b] * (a == b ? compress[b] : shear[b]);
    return push;
}

TEST(Certificate, TablesThatHaveItNeverFoldAndTablesJustBeyondDo) {
    int certified = 0, folded = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Volume volume = block({10, 10, 10}, 0);
        for (int a = 0; a < 3; ++a) volume.grid.spacing_mm[a] = random.real(0.5, 3);
        const TaskArena arena(1);
        Vec3d compress{}, stretch{}, shear{};
        for (int b = 0; b < 3; ++b) {
            compress[b] = random.ratio(0.05, 1);
            stretch[b] = random.ratio(0.05, 3);
            shear[b] = random.ratio(0.05, 1);
        }
        // Just below the bound, or just above it.
        const bool below = seed % 2;
        const double scale = (below ? 0.999 : 1.01) / fold_number(compress, shear);
        compress = scale * compress;
        shear = scale * shear;
        ChainMail tissue = tissue_of(volume, arena, settings_of(compress, stretch, shear));
        EXPECT_EQ(tissue.fold_certificate().certified, below);
        const std::vector<Vec3i> one = {{5, 5, 5}};
        ASSERT_TRUE(tissue.push_elements(one, folding_push(volume.grid, compress, shear)).ok());
        if (!below) {
            EXPECT_GT(tissue.state().folded_cells, 0);
            ++folded;
            continue;
        }
        EXPECT_EQ(tissue.state().folded_cells, 0);
        for (int n = 0; n < 8; ++n) {
            ASSERT_TRUE(
                tissue.push_elements(random_grab(random, volume.grid), random.vector(2)).ok());
            EXPECT_EQ(tissue.state().folded_cells, 0);
        }
        ++certified;
    }
    EXPECT_EQ(certified, 30);
    EXPECT_EQ(folded, 30);
}

TEST(Certificate, NumberIsTheSpectralRadius) {
    EXPECT_NEAR(fold_number({.2, .2, .2}, {.2, .2, .2}), 0.6, 1e-9);
    EXPECT_NEAR(fold_number({.3, .3, .3}, {.1, .1, .1}), 0.5, 1e-9);
    EXPECT_NEAR(fold_number({.9, .1, .2}, {0, 0, 0}), 0.9, 1e-6);
    EXPECT_EQ(fold_number({0, 0, 0}, {0, 0, 0}), 0);
}

TEST(Certificate, DraegersLawHasItBelowAThirdAndAirNever) {
    const Volume volume = block({8, 8, 8}, 40);
    const TaskArena arena(1);
    ChainMailSettings settings;
    EXPECT_FALSE(tissue_of(volume, arena, settings).fold_certificate().certified);
    EXPECT_NEAR(tissue_of(volume, arena, settings).fold_certificate().tissue, 0.6, 1e-5);
    settings.air_enabled = false;
    EXPECT_TRUE(tissue_of(volume, arena, settings).fold_certificate().certified);
    settings.offset = 0.33;
    EXPECT_TRUE(tissue_of(volume, arena, settings).fold_certificate().certified);
    settings.offset = 0.34;
    EXPECT_FALSE(tissue_of(volume, arena, settings).fold_certificate().certified);
}

TEST(Certificate, IsGoneWhileLinksAreOutsideOfTheirLimits) {
    const Volume volume = block({16, 16, 16}, 40);
    const TaskArena arena(1);
    ChainMailSettings settings;
    settings.air_enabled = false;
    settings.offset = 0.3;
    ChainMail tissue = tissue_of(volume, arena, settings);
    const std::vector<Vec3i> one = {{8, 8, 8}};
    ASSERT_TRUE(tissue.push_elements(one, {1, 0, 0}).ok());
    EXPECT_TRUE(tissue.fold_certificate().certified);
    settings.offset = 0.1;
    ASSERT_TRUE(tissue.set_materials(settings).ok());
    EXPECT_FALSE(tissue.fold_certificate().certified);
    EXPECT_LT(tissue.fold_certificate().all, 1);
}

}  // namespace
}  // namespace pliant::test
