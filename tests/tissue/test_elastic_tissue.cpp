// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The elastic scan as a tissue: pushes, slides, limits, return, and the displacement that is shown.
// Covers: tissue/elastic_tissue.cpp, elastic/shown_displacement.cpp, elastic/settings_rows.cpp.

#include <gtest/gtest.h>
#include <pliant/check_tissue.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace pliant::test {
namespace {

constexpr std::uint32_t kProbe = 1;

/// Soft tissue with a lumen along k, and bone in the lowest slices of j.
Volume scan_with_lumen() {
    Volume scan;
    scan.grid = {{40, 38, 36}, {1, 1, 1}};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < 36; ++k)
        for (int j = 0; j < 38; ++j)
            for (int i = 0; i < 40; ++i) {
                const double r = std::hypot(i - 20.0, j - 20.0);
                voxels.push_back(std::int16_t(j < 4 ? 900 : r < 7 ? -1000 : 40));
            }
    scan.voxels = std::move(voxels);
    return scan;
}

/// A sphere at the lumen's wall, pushed into it.
const Push kWallPush{.point_mm = {28, 20, 18}, .push_mm = {1.5, 0.2, 0.3}, .sphere_radius_mm = 3};

class Elastic : public testing::Test {
  protected:
    std::unique_ptr<Tissue> make(const ElasticScanSettings& settings = {}) {
        auto made = make_elastic(m_scan, settings, m_arena);
        EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
        return std::move(*made);
    }
    static Vec3d displacement(Tissue& tissue, Vec3i ijk) {
        EXPECT_TRUE(tissue.update_deformation().ok());
        return tissue.deformation().displacement_mm(ijk);
    }
    static void settle(Tissue& tissue) {
        for (int n = 0; n < 400; ++n)
            if (tissue.sweep().value().settled) return;
        FAIL() << "expected a tissue at rest";
    }

    Volume m_scan = scan_with_lumen();
    TaskArena m_arena{2};
};

TEST_F(Elastic, KeepsTheRulesOfTissues) {
    const MakeTissue make = [](const Volume& scan, const TaskArena& arena) {
        return make_elastic(scan, {}, arena);
    };
    const Status kept = check_tissue(make, m_scan, kWallPush);
    EXPECT_TRUE(kept.ok()) << (kept.ok() ? "" : kept.error().field + ": " + kept.error().message);
}

TEST_F(Elastic, TheHeldTissueMovesWithTheTool) {
    auto tissue = make();
    const auto report = tissue->push(kProbe, kWallPush);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Applied);
    EXPECT_GT(report->grabbed_elements, 20);
    EXPECT_NEAR(norm(displacement(*tissue, {28, 20, 18}) - kWallPush.push_mm), 0, 1e-3);
    settle(*tissue);
    EXPECT_NEAR(norm(displacement(*tissue, {28, 20, 18}) - kWallPush.push_mm), 0, 1e-3);
    const Vec3d near = displacement(*tissue, {33, 20, 18});
    EXPECT_GT(near.x, 0.2);
    EXPECT_LT(near.x, 1.4);
    for (int i = 0; i < 40; ++i) EXPECT_EQ(displacement(*tissue, {i, 3, 18}), (Vec3d{0, 0, 0}));
}

TEST_F(Elastic, TheForceIsProportionalToSmallPushesAndToTheModulus) {
    const auto force = [&](double mm, double kpa) {
        ElasticScanSettings settings;
        settings.moduli_kpa = {{-950, 0}, {-500, kpa}};
        settings.held_above_hu = 300;
        auto tissue = make(settings);
        Push push = kWallPush;
        push.push_mm = {mm, 0, 0};
        EXPECT_TRUE(tissue->push(kProbe, push).ok());
        settle(*tissue);
        return tissue->force_n(kProbe).value();
    };
    const Vec3d small = force(0.1, 10), larger = force(0.2, 10), stiffer = force(0.1, 20);
    EXPECT_LT(small.x, 0);
    EXPECT_NEAR(larger.x / small.x, 2, 0.05);
    EXPECT_NEAR(stiffer.x / small.x, 2, 0.02);
}

TEST_F(Elastic, ReleasedTissueReturnsExponentiallyToRest) {
    ElasticScanSettings settings;
    settings.return_s = 0.1;
    auto tissue = make(settings);
    ASSERT_TRUE(tissue->push(kProbe, kWallPush).ok());
    settle(*tissue);
    tissue->release(kProbe);
    const double before = displacement(*tissue, {30, 20, 18}).x;
    for (int n = 0; n < 5; ++n) (void)tissue->sweep();  // 0.1 s
    EXPECT_NEAR(displacement(*tissue, {30, 20, 18}).x / before, std::exp(-1), 0.01);
    settle(*tissue);
    EXPECT_EQ(displacement(*tissue, {30, 20, 18}), (Vec3d{0, 0, 0}));
    EXPECT_EQ(tissue->deformation().moved_box(), Box3i{});
}

TEST_F(Elastic, ADragIsNearEquilibriumAtEachStep) {
    auto frames = make(), settled = make();
    for (Tissue* const tissue : {frames.get(), settled.get()})
        ASSERT_GT(tissue->grab(kProbe, kWallPush, 5)->grabbed_elements, 0);
    Vec3d offset{0, 0, 0};
    for (int n = 0; n < 12; ++n) {
        SCOPED_TRACE("step " + std::to_string(n));
        offset = offset + (n < 6 ? Vec3d{0.25, 0, 0} : Vec3d{0.05, 0.2, -0.1});  // it turns
        for (Tissue* const tissue : {frames.get(), settled.get()})
            ASSERT_EQ(tissue->drag_to(offset)->step_fraction, 1);
        settle(*settled);
        EXPECT_NEAR(norm(displacement(*frames, {28, 20, 18}) - offset), 0, 2e-3);
        double difference = 0, all = 0;
        for (int k = 0; k < 36; ++k)
            for (int j = 0; j < 38; ++j)
                for (int i = 0; i < 40; ++i) {
                    const Vec3d u = displacement(*settled, {i, j, k});
                    const Vec3d d = displacement(*frames, {i, j, k}) - u;
                    difference += dot(d, d);
                    all += dot(u, u);
                }
        EXPECT_LT(std::sqrt(difference / all), 0.08);
        const Vec3d force = settled->force_n(kProbe).value();
        EXPECT_LT(norm(frames->force_n(kProbe).value() - force), 0.1 * norm(force));
    }
    frames->let_go();
    EXPECT_FALSE(frames->is_touched());
    EXPECT_EQ(frames->drag_to(offset).error().message, "drag: expected a grab before it");
}

// Tissue ahead of the tool evades, however long its strides are. The top has a held patch, and a
// sphere that is nearly plane pushes the bottom up by more than a voxel, which was one stride.
TEST_F(Elastic, ALongPushIsManyShortOnes) {
    constexpr double kEdge = 2.5, kRadius = 1e5, kWay = 3;
    Volume scan;
    scan.grid = {{25, 25, 13}, {kEdge, kEdge, kEdge}};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < 13; ++k)
        for (int j = 0; j < 25; ++j)
            for (int i = 0; i < 25; ++i)
                voxels.push_back(k == 12 && std::max(std::abs(i - 12), std::abs(j - 12)) <= 4 ? 900
                                                                                              : 40);
    scan.voxels = std::move(voxels);
    ElasticScanSettings settings;
    settings.moduli_kpa = {{-1000, 0}, {-500, 5}};
    settings.held_above_hu = 500;
    settings.held_sides = std::vector<std::string>{};  // none
    settings.window_cells = 512;
    const auto moved = [&](int pushes) {
        auto tissue = std::move(make_elastic(scan, settings, m_arena)).value();
        const double part = kWay / pushes;
        for (int n = 0; n < pushes; ++n) {
            const auto report =
                tissue->push(kProbe, {.point_mm = {30, 30, 0.01 - kRadius + n * part},
                                      .push_mm = {0, 0, part},
                                      .sphere_radius_mm = kRadius});
            EXPECT_EQ(report->step_fraction, 1) << report->message;
        }
        settle(*tissue);
        return displacement(*tissue, {12, 12, 6}).z;
    };
    const double many = moved(6);
    EXPECT_GT(many, 1);
    EXPECT_NEAR(moved(1), many, 0.005 * kWay);
}

TEST_F(Elastic, ALongPushFoldsNoTissue) {
    auto tissue = make();
    Push push = kWallPush;
    push.sphere_radius_mm = 2;
    push.push_mm = {6, 1, 0};
    const auto report = tissue->push(kProbe, push);
    ASSERT_TRUE(report.ok());
    EXPECT_GT(report->step_fraction, 0.5);
    ASSERT_TRUE(tissue->update_deformation().ok());
    double least = 1;
    const auto tissue_at = [&](Vec3i at) { return m_scan.at(at) == 40; };
    for (int k = 0; k < 35; ++k)
        for (int j = 4; j < 37; ++j)
            for (int i = 0; i < 39; ++i) {
                const Vec3i o{i, j, k};
                if (!tissue_at(o) || !tissue_at(o + Vec3i{1, 1, 1})) continue;
                Mat3d f;
                for (int a = 0; a < 3; ++a) {
                    Vec3i next = o, unit{0, 0, 0};
                    next[a] += 1;
                    unit[a] = 1;
                    f.columns[a] = Vec3d{double(unit.x), double(unit.y), double(unit.z)} +
                                   tissue->deformation().displacement_mm(next) -
                                   tissue->deformation().displacement_mm(o);
                }
                least = std::min(least, determinant(f));
            }
    EXPECT_GT(least, 0);
}

TEST_F(Elastic, AToolStopsAtBone) {
    auto tissue = make();
    Push push = kWallPush;
    push.point_mm = {20, 6.9, 18};
    push.push_mm = {0, -1, 0};
    const auto report = tissue->push(kProbe, push);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->limited_by, LimitedBy::Bone);
    ASSERT_TRUE(report->bone_mm.has_value());
    EXPECT_EQ(report->bone_mm->y, 3);
    for (int i = 0; i < 40; ++i) EXPECT_EQ(displacement(*tissue, {i, 3, 18}), (Vec3d{0, 0, 0}));
}

TEST_F(Elastic, AToolInBoneHoldsNothing) {
    auto tissue = make();
    Push push = kWallPush;
    push.point_mm = {20, 0, 18};
    const auto report = tissue->push(kProbe, push);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Rejected);
    EXPECT_EQ(report->limited_by, LimitedBy::Bone);
    EXPECT_TRUE(report->bone_mm.has_value());
    EXPECT_FALSE(tissue->is_touched());
}

TEST_F(Elastic, ASlidingSphereLeavesNoTissueInside) {
    auto tissue = make();
    const Push way{.point_mm = {20, 20, 18}, .push_mm = {6, 0, 0}, .sphere_radius_mm = 3};
    const auto report = tissue->slide(kProbe, way, {});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->way_fraction, 1);
    EXPECT_GT(report->contacts, 5);
    settle(*tissue);
    ASSERT_TRUE(tissue->update_deformation().ok());
    const Vec3d centre{26, 20, 18};
    double deepest = 0;
    for (int k = 8; k < 28; ++k)
        for (int j = 8; j < 32; ++j)
            for (int i = 8; i < 40; ++i) {
                if (m_scan.at({i, j, k}) < -500) continue;
                const Vec3d now = Vec3d{i * 1.0, j * 1.0, k * 1.0} +
                                  tissue->deformation().displacement_mm({i, j, k});
                deepest = std::max(deepest, 3 - norm(now - centre));
            }
    EXPECT_LT(deepest, 0.15);
    const Vec3d force = tissue->force_n(kProbe).value();
    EXPECT_LT(force.x, 0);
    EXPECT_LT(std::hypot(force.y, force.z), 0.2 * std::abs(force.x));
}

TEST_F(Elastic, ASlidingSphereFeelsCoulombsFriction) {
    m_scan.grid.size = {48, 36, 24};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < 24; ++k)
        for (int n = 0; n < 48 * 36; ++n)
            voxels.push_back(std::int16_t(k < 2 ? 900 : k < 14 ? 40 : -1000));
    m_scan.voxels = std::move(voxels);
    for (const double friction : {0.0, 0.2, 0.5}) {
        SCOPED_TRACE(friction);
        auto tissue = make({.held_sides = std::vector<std::string>(), .friction = friction});
        constexpr double kRadius_mm = 7;
        Vec3d at{16, 18, 13 + kRadius_mm};
        const auto slide = [&](Vec3d way) {
            ASSERT_EQ(tissue->slide(kProbe, {at, way, kRadius_mm}, {})->way_fraction, 1);
            at = at + way;
        };
        slide({0, 0, -1.5});
        settle(*tissue);
        for (int n = 0; n < 12; ++n) {
            slide({0.75, 0, 0});
            for (int k = 0; k < 6; ++k) (void)tissue->sweep();
        }
        const Vec3d force = tissue->force_n(kProbe).value();
        EXPECT_GT(force.z, 0.01);
        EXPECT_NEAR(-force.x / force.z, friction, 0.05 + 0.15 * friction);
        EXPECT_LT(std::abs(force.y), 0.05 * force.z);
    }
}

TEST_F(Elastic, ReturningTissueStaysOutOfAnEye) {
    ElasticScanSettings settings;
    settings.return_s = 0.05;
    auto tissue = make(settings);
    Push push = kWallPush;
    push.push_mm = {3, 0, 0};
    ASSERT_TRUE(tissue->push(kProbe, push).ok());
    settle(*tissue);
    const Vec3d eye{25.5, 20, 18};  // the wall at rest is 1.5 mm inside
    constexpr double kEye_mm = 3;
    ASSERT_TRUE(tissue->place_eye(kProbe, eye, kEye_mm).ok());
    EXPECT_TRUE(tissue->has_eye(kProbe));
    tissue->release(kProbe);
    for (int n = 0; n < 60; ++n) (void)tissue->sweep();
    ASSERT_TRUE(tissue->update_deformation().ok());
    double deepest = 0;
    for (int k = 14; k < 23; ++k)
        for (int j = 16; j < 25; ++j)
            for (int i = 20; i < 36; ++i) {
                if (m_scan.at({i, j, k}) < -500) continue;
                const Vec3d now = Vec3d{i * 1.0, j * 1.0, k * 1.0} +
                                  tissue->deformation().displacement_mm({i, j, k});
                deepest = std::max(deepest, kEye_mm - norm(now - eye));
            }
    EXPECT_LT(deepest, 0.1);
    ASSERT_TRUE(tissue->place_eye(kProbe, eye, 0).ok());
    settle(*tissue);
    ASSERT_TRUE(tissue->update_deformation().ok());
    EXPECT_EQ(tissue->deformation().moved_box(), Box3i{});
}

TEST_F(Elastic, APictureShowsThePartsThatLagMost) {
    auto tissue = make();
    ASSERT_TRUE(tissue->push(kProbe, kWallPush).ok());
    settle(*tissue);
    EXPECT_FALSE(tissue->approach_deformation(512).value());
    const Box3i box = tissue->deformation().moved_box();
    for (int a = 0; a < 3; ++a) EXPECT_LE(box.end[a] - box.begin[a], 8);
    double largest = 0;
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j)
            for (int i = box.begin.x; i < box.end.x; ++i)
                largest = std::max(largest, norm(tissue->deformation().displacement_mm({i, j, k})));
    EXPECT_NEAR(largest, norm(kWallPush.push_mm), 1e-3);
    ASSERT_TRUE(tissue->update_deformation().ok());
    EXPECT_GT(state_of(*tissue)->resident_bricks, 8);
    EXPECT_TRUE(tissue->approach_deformation(512).value());
}

TEST_F(Elastic, PicturesOfTissueAtRestEndWithTheExactOne) {
    auto tissue = make(), exact = make();
    for (auto* const one : {&tissue, &exact}) {
        ASSERT_TRUE((*one)->push(kProbe, kWallPush).ok());
        settle(**one);
    }
    ASSERT_TRUE(exact->update_deformation().ok());
    int pictures = 1;
    while (pictures < 1000 && !tissue->approach_deformation(4 * 512).value()) ++pictures;
    EXPECT_GT(pictures, 2);
    EXPECT_LT(pictures, 1000);
    EXPECT_EQ(tissue->deformation().moved_box(), exact->deformation().moved_box());
    const Vec3i size = m_scan.grid.size;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                ASSERT_EQ(tissue->deformation().displacement_mm({i, j, k}),
                          exact->deformation().displacement_mm({i, j, k}));
}

TEST_F(Elastic, AThresholdOfBoneCountsWithoutATableOfModuli) {
    const Push push{.point_mm = {8, 6, 18}, .push_mm = {0, -1.5, 0}, .sphere_radius_mm = 2};
    EXPECT_EQ(make()->push(kProbe, push).value().limited_by, LimitedBy::Bone);
    EXPECT_NE(make({.held_above_hu = 2000})->push(kProbe, push).value().limited_by,
              LimitedBy::Bone);
}

TEST_F(Elastic, LabelsGiveModuliAndHold) {
    Volume labels{m_scan.grid, VoxelArray<std::int16_t>(voxel_count(m_scan.grid)), {}};
    auto& label = std::get<0>(labels.voxels);
    for (int k = 0; k < 36; ++k)
        for (int j = 8; j < 32; ++j)
            for (int i = 28; i < 40; ++i)
                label[voxel_index(m_scan.grid, {i, j, k})] = i < 34 ? 3 : 9;
    const auto settings_with = [&](double kpa) {
        ElasticScanSettings settings;
        settings.labels = std::make_shared<const Volume>(labels);
        settings.label_materials = {{.values = {3}, .elastic = ElasticPair{kpa, 0.3}},
                                    {.values = {9}, .law = LabelLaw::Immobile}};
        return settings;
    };
    const auto force = [&](const ElasticScanSettings& settings) {
        auto tissue = make(settings);
        Push push = kWallPush;
        push.push_mm = {0.3, 0, 0};
        EXPECT_TRUE(tissue->push(kProbe, push).ok());
        settle(*tissue);
        EXPECT_EQ(displacement(*tissue, {34, 20, 18}) == Vec3d(0, 0, 0),
                  !settings.label_materials.empty());
        return -tissue->force_n(kProbe).value().x;
    };
    // At 40 HU the table has 9 kPa.
    const double by_value = force({}), same = force(settings_with(9)),
                 stiff = force(settings_with(90));
    EXPECT_GT(same, by_value) << "behind the label everything is held";
    EXPECT_GT(stiff, 4 * same);
    EXPECT_LT(stiff, 10 * same);
    auto tissue = make(settings_with(9));
    Push push = kWallPush;
    push.push_mm = {9, 0, 0};
    EXPECT_EQ(tissue->push(kProbe, push)->limited_by, LimitedBy::Bone);
    ElasticScanSettings without = settings_with(9);
    without.labels = nullptr;
    const auto error = make_elastic(m_scan, without, m_arena);
    ASSERT_FALSE(error.ok());
    EXPECT_EQ(error.error().message, "labels: expected a label volume for [[label]], found none");
}

TEST_F(Elastic, BadSettingsAreNamed) {
    const auto error = [&](const ElasticScanSettings& settings) {
        auto made = make_elastic(m_scan, settings, m_arena);
        EXPECT_FALSE(made.ok());
        return made.ok() ? std::string() : made.error().message;
    };
    ElasticScanSettings settings;
    settings.poisson_ratio = 0.5;
    EXPECT_EQ(error(settings), "[elastic] poisson_ratio: expected 0 to 0.495, found 0.5");
    settings = {};
    settings.moduli_kpa = {{0, 1}, {0, 2}};
    EXPECT_EQ(error(settings), "[elastic] moduli_kpa: expected ascending values, found 0 after 0");
    settings.moduli_kpa = {{0, -1}};
    EXPECT_EQ(error(settings),
              "[elastic] moduli_kpa: expected values and moduli of 0 to 1e8 kPa, found 0, -1");
    settings.moduli_kpa = {{0, 0}};
    EXPECT_EQ(error(settings),
              "[elastic] moduli_kpa: expected a modulus above 0 kPa, found 0 kPa everywhere");
    settings = {};
    settings.held_sides.emplace({std::string("+w")});
    EXPECT_EQ(error(settings),
              "[elastic] held_sides: expected a list of \"-x\", \"+x\", \"-y\", \"+y\", \"-z\" or "
              "\"+z\", found [\"+w\"]");
    settings = {};
    settings.moduli_kpa = {{std::nan(""), 1}};
    EXPECT_EQ(error(settings),
              "[elastic] moduli_kpa: expected a list of pairs of numbers, found 1 pairs");
    settings = {};
    settings.window_cells = 33;
    EXPECT_EQ(error(settings), "[elastic] window_cells: expected an even number, found 33");
}

}  // namespace
}  // namespace pliant::test
