// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts, carving and walls that touch in the elastic scan.
// Covers: tissue/elastic_tissue.cpp, tissue/elastic_tissue_edits.cpp, elastic/levels.cpp,
// elastic/level.cpp.

#include <gtest/gtest.h>
#include <pliant/check_tissue.h>
#include <pliant/own_tissue.h>
#include <pliant/tissues.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "support/count_allocations.h"

namespace pliant::test {
namespace {

constexpr std::uint32_t kTool = 1;
constexpr std::int16_t kSoft = 40, kAir = -1000;

Volume scan_with(Vec3i size, const std::function<std::int16_t(Vec3i)>& value) {
    Volume scan;
    scan.grid = {size, {1, 1, 1}};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) voxels.push_back(value({i, j, k}));
    scan.voxels = std::move(voxels);
    return scan;
}

/// A block of soft tissue that its sides hold.
Volume block() {
    return scan_with({40, 36, 32}, [](Vec3i) { return kSoft; });
}

/// Two blocks with air of four voxels between them, at x = 18 … 21.
Volume two_walls() {
    return scan_with({40, 30, 28}, [](Vec3i at) { return at.x >= 18 && at.x < 22 ? kAir : kSoft; });
}

/// From y = 8 to 28 and z = 6 to 26, between the voxels of x = 19 and 20.
const CutSurface kBlade{.line_mm = {{19.5, 7.5, 5.5}, {19.5, 27.5, 5.5}}, .depth_mm = {0, 0, 20}};

class ElasticEdits : public testing::Test {
  protected:
    std::unique_ptr<Tissue> make(const Volume& scan) {
        auto made = make_elastic(scan, {}, m_arena);
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
    static void push(Tissue& tissue, Vec3d point_mm, Vec3d push_mm, double radius_mm = 3) {
        const auto report = tissue.push(
            kTool, {.point_mm = point_mm, .push_mm = push_mm, .sphere_radius_mm = radius_mm});
        ASSERT_TRUE(report.ok());
        EXPECT_EQ(report->step_fraction, 1) << report->message;
    }

    TaskArena m_arena{2};
};

TEST_F(ElasticEdits, TissueWithBladesKeepsTheRules) {
    const MakeTissue make = [](const Volume& scan, const TaskArena& arena) {
        return make_elastic(scan, {}, arena);
    };
    const Volume scan = block();
    const Status kept = check_tissue(
        make, scan, {.point_mm = {20, 18, 16}, .push_mm = {1, 0.5, 0}, .sphere_radius_mm = 3});
    EXPECT_TRUE(kept.ok()) << (kept.ok() ? "" : kept.error().field + ": " + kept.error().message);
}

TEST_F(ElasticEdits, ACutGapesWhenOneSideIsPulled) {
    const Volume scan = block();
    const auto pulled = [&](bool cut) {
        auto tissue = make(scan);
        if (cut) {
            EXPECT_EQ(tissue->cut(kBlade)->cut_links, 20 * 20);
        }
        push(*tissue, {25, 18, 16}, {2, 0, 0});
        settle(*tissue);
        return displacement(*tissue, {20, 18, 16}).x - displacement(*tissue, {19, 18, 16}).x;
    };
    EXPECT_LT(pulled(false), 0.3);
    EXPECT_GT(pulled(true), 1.2);
}

TEST_F(ElasticEdits, APressedCutTransmitsForceAsBefore) {
    const Volume scan = block();
    const auto pressed = [&](bool cut) {
        auto tissue = make(scan);
        if (cut) {
            EXPECT_GT(tissue->cut(kBlade)->cut_links, 0);
        }
        push(*tissue, {25, 18, 16}, {-2, 0, 0});
        settle(*tissue);
        return displacement(*tissue, {18, 18, 16}).x;
    };
    const double whole = pressed(false);
    EXPECT_LT(whole, -0.5);
    EXPECT_NEAR(pressed(true) / whole, 1, 0.15);
}

TEST_F(ElasticEdits, WallsThatMeetAcrossAirTouch) {
    const Volume scan = two_walls();
    auto tissue = make(scan);
    push(*tissue, {14, 15, 14}, {3, 0, 0});
    settle(*tissue);
    EXPECT_LT(displacement(*tissue, {22, 15, 14}).x, 0.2) << "the gap is still open";
    push(*tissue, {17, 15, 14}, {5, 0, 0});
    settle(*tissue);
    EXPECT_GT(displacement(*tissue, {22, 15, 14}).x, 2);
    double narrowest = 10;
    for (int k = 3; k < 25; ++k)
        for (int j = 3; j < 27; ++j) {
            const double left = 17 + displacement(*tissue, {17, j, k}).x;
            const double right = 22 + displacement(*tissue, {22, j, k}).x;
            narrowest = std::min(narrowest, right - left);
        }
    EXPECT_GT(narrowest, 0) << "walls pass through each other";
    tissue->release(kTool);
    settle(*tissue);
    ASSERT_TRUE(tissue->update_deformation().ok());
    EXPECT_EQ(tissue->deformation().moved_box(), Box3i{});
}

TEST_F(ElasticEdits, CarvedTissueIsGoneAndNoToolHoldsIt) {
    const Volume scan = block();
    const auto pushed = [&](bool carve) {
        auto tissue = make(scan);
        if (carve) {
            std::int64_t expected = 0;
            for (int k = 0; k < 32; ++k)
                for (int j = 0; j < 36; ++j)
                    for (int i = 0; i < 40; ++i)
                        expected += norm(Vec3d{i - 28.0, j - 18.0, k - 16.0}) <= 5;
            const auto report =
                tissue->carve({.from_mm = {28, 18, 16}, .to_mm = {28, 18, 16}, .radius_mm = 5});
            EXPECT_EQ(report->carved_elements, expected);
            EXPECT_EQ(state_of(*tissue)->carved_elements, expected);
            const auto none = tissue->push(
                kTool, {.point_mm = {28, 18, 16}, .push_mm = {1, 0, 0}, .sphere_radius_mm = 3});
            EXPECT_EQ(none->grabbed_elements, 0);
        }
        push(*tissue, {20, 18, 16}, {2, 0, 0});
        settle(*tissue);
        return -tissue->force_n(kTool).value().x;
    };
    const double whole = pushed(false), carved = pushed(true);
    EXPECT_GT(carved, 0.2 * whole);
    EXPECT_LT(carved, 0.9 * whole);
}

TEST_F(ElasticEdits, BoneIsSparedOrCarved) {
    const Volume scan =
        scan_with({30, 30, 30}, [](Vec3i at) { return at.x < 10 ? std::int16_t(900) : kSoft; });
    CarveTool drill{.from_mm = {9, 15, 15}, .to_mm = {9, 15, 15}, .radius_mm = 3};
    auto tissue = make(scan);
    drill.spare_fixed = true;
    const std::int64_t soft = tissue->carve(drill)->carved_elements;
    EXPECT_FALSE(tissue->deformation().is_void({9, 15, 15}));
    EXPECT_TRUE(tissue->deformation().is_void({10, 15, 15}));
    drill.spare_fixed = false;
    EXPECT_GT(tissue->carve(drill)->carved_elements, soft);
    EXPECT_TRUE(tissue->deformation().is_void({9, 15, 15}));
}

TEST_F(ElasticEdits, UndoneEditsLeaveNoTrace) {
    const Volume scan = block();
    auto fresh = make(scan), tissue = make(scan);
    const auto act = [&](Tissue& with, bool edit) {
        if (edit) {
            with.begin_group("edit");
            EXPECT_GT(with.cut(kBlade)->cut_links, 0);
            EXPECT_GT(with.carve({.from_mm = {12, 18, 16}, .to_mm = {12, 24, 16}, .radius_mm = 3})
                          ->carved_elements,
                      0);
            EXPECT_EQ(with.end_group(), 0);
        }
    };
    act(*tissue, true);
    const std::uint64_t edited = tissue->hash();
    ASSERT_TRUE(tissue->undo().ok());
    EXPECT_EQ(tissue->hash(), fresh->hash());
    EXPECT_EQ(state_of(*tissue)->cut_links + state_of(*tissue)->carved_elements, 0);
    const auto same = [&](Tissue& a, Tissue& b) {
        push(a, {24, 18, 16}, {2, 1, 0});
        push(b, {24, 18, 16}, {2, 1, 0});
        settle(a);
        settle(b);
        EXPECT_EQ(a.hash(), b.hash());
        a.release(kTool);
        b.release(kTool);
        settle(a);
        settle(b);
    };
    same(*tissue, *fresh);
    act(*tissue, true);
    act(*fresh, true);
    EXPECT_EQ(tissue->hash(), edited);
    same(*tissue, *fresh);
}

TEST_F(ElasticEdits, BadToolsAreRefusedWithOneLine) {
    const Volume scan = block();
    auto tissue = make(scan);
    EXPECT_EQ(tissue->cut({.line_mm = {{1, 1, 1}}, .depth_mm = {0, 0, 1}}).error().message,
              "cut: expected a line of two or more points, found 1");
    EXPECT_EQ(tissue->carve({.radius_mm = 0}).error().message,
              "carve: expected a radius above 0, up to 500 mm, found 0.000000");
    const CutSurface beside{.line_mm = {{-50, 0, 0}, {-50, 9, 0}}, .depth_mm = {0, 0, 9}};
    EXPECT_EQ(tissue->cut(beside)->cut_links, 0);
    EXPECT_EQ(state_of(*tissue)->cut_links, 0);
}

TEST_F(ElasticEdits, AnOperationThatRunsOutOfMemoryMovesNothing) {
    // Small allocations succeed, as they do in practice.
    constexpr std::size_t kLarge = 4096;
    const Volume scan = block();
    const TaskArena arena(1);
    const Push first{.point_mm = {12, 12, 12}, .push_mm = {1, 0, 0}, .sphere_radius_mm = 3};
    const Push far{.point_mm = {30, 28, 25}, .push_mm = {-1, 0.5, 0}, .sphere_radius_mm = 3};
    struct Operation {
        const char* name;
        std::function<bool(Tissue&)> act;
    };
    for (
        const Operation& operation : {
            Operation{"push", [&](Tissue& t) { return t.push(2, far).ok(); }},
            Operation{"slide",
                      [&](Tissue& t) {
                          return t.slide(2, far, {-2000, true}).ok();
                      }},
            Operation{"grab", [&](Tissue& t) { return t.grab(2, far, 3).ok(); }},
            Operation{"cut", [&](Tissue& t) { return t.cut(kBlade).ok(); }},
            Operation{
                "carve",
                [&](Tissue& t) {
                    return t.carve({.from_mm = {9, 9, 9}, .to_mm = {9, 9, 9}, .radius_mm = 4}).ok();
                }},
            Operation{"sweep", [&](Tissue& t) { return t.sweep().ok(); }},
        }) {
        SCOPED_TRACE(operation.name);
        int failures = 0;
        for (std::int64_t n = 0;; ++n) {
            auto made = make_elastic(scan, {.window_cells = 12}, arena);
            auto tissue = std::move(*made);
            ASSERT_TRUE(tissue->push(kTool, first).ok());
            ASSERT_FALSE(tissue->sweep()->settled);  // the push has had its solution
            const std::uint64_t before = tissue->hash();
            bool ok = false;
            {
                const FailingAllocation failing(n, kLarge);
                ok = operation.act(*tissue);
            }
            if (ok) break;
            ++failures;
            EXPECT_EQ(tissue->hash(), before) << "allocation " << n;
        }
        EXPECT_GT(failures, 0);
    }
}

}  // namespace
}  // namespace pliant::test
