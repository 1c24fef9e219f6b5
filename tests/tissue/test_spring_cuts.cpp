// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts through scans with springs, and the depth that their tools need.
// Covers: tissue/spring_cut.cpp, tissue/spring_tissue.cpp, tissue/scan_network.cpp.

#include <gtest/gtest.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <vector>

#include "support/random.h"
#include "support/temporary_folder.h"
#include "tissue/shown_springs.h"

namespace pliant::test {
namespace {

constexpr int kCell = 4;

/// Soft tissue in a turned grid, left-handed for even seeds.
Volume soft_block(std::uint64_t seed) {
    Random random(seed);
    Volume volume;
    volume.grid = {{41, 37, 33}, {1, 1, 1}, {-20, 4, 7}, random.rotation(seed % 2 == 0)};
    std::vector<std::int16_t> voxels(voxel_count(volume.grid));
    for (auto& value : voxels) value = std::int16_t(random.whole(-60, 60));
    volume.voxels = std::move(voxels);
    return volume;
}

Vec3d at_voxel(const Volume& volume, Vec3d ijk) {
    return world_from_voxel(volume.grid, ijk);
}

/// The plane i = x + slant·j through the whole scan.
CutSurface plane_at(const Volume& volume, double x, double slant = 0) {
    return {.line_mm = {at_voxel(volume, {x - 9 * slant, -9, -9}),
                        at_voxel(volume, {x + 50 * slant, 50, -9})},
            .depth_mm = at_voxel(volume, {x, 0, 60}) - at_voxel(volume, {x, 0, 0})};
}

/// Distance from that plane along i [voxels].
double beyond(Vec3i ijk, double x, double slant) {
    return ijk.x - x - slant * ijk.y;
}

std::unique_ptr<SpringScanTissue> cuttable(const Volume& volume, const TaskArena& arena) {
    return std::move(SpringScanTissue::create(volume, {.cell_mm = kCell, .depth = 64}, arena))
        .value();
}

void let_settle(SpringScanTissue& tissue) {
    for (int n = 0; n < 5000 && !tissue.is_settled(); ++n)
        EXPECT_EQ(tissue.advance({.max_steps = 20}).value().message, "");
}

template <class Visit>
void for_each_element(const Volume& volume, const Visit& visit) {
    const Vec3i n = volume.grid.size;
    for (int k = 0; k < n.z; ++k)
        for (int j = 0; j < n.y; ++j)
            for (int i = 0; i < n.x; ++i) visit(Vec3i{i, j, k});
}

TEST(SpringCuts, APlaneThroughAllTissueSeparatesItsSides) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Volume volume = soft_block(seed);
        const double slant = seed > 2 ? 0.25 : 0;
        const double x = 18.6 - slant * 18;  // through no element
        const auto tissue = cuttable(volume, arena);
        const auto report = tissue->cut(plane_at(volume, x, slant));
        ASSERT_TRUE(report.ok()) << report.error().message;
        EXPECT_GT(report->cut_links, 100);
        EXPECT_TRUE(tissue->is_settled() || tissue->advance({.max_steps = 20})->settled);
        const ControlGrid& grid = control_of(*tissue).grid();
        const Box3i region{grid.first,
                           grid.first + kCell * (grid.size - Vec3i{1, 1, 1}) + Vec3i{1, 1, 1}};
        const Deformation& field = tissue->deformation();
        for_each_element(volume, [&](Vec3i p) {
            for (int a = 0; a < 3; ++a) {
                Vec3i q = p;
                ++q[a];
                if (!contains(region, p) || !contains(region, q)) continue;
                const bool crosses = (beyond(p, x, slant) < 0) != (beyond(q, x, slant) < 0);
                ASSERT_EQ(field.is_linked(p, a), !crosses);
            }
        });
        // A tool beyond the plane moves its side alone, all of its elements near the plane too.
        const Vec3d way = volume.grid.direction * Vec3d{3, 1, 0};
        const auto push = tissue->push(
            1, {.point_mm = at_voxel(volume, {22, 18, 16}), .push_mm = way, .sphere_radius_mm = 3});
        ASSERT_TRUE(push.ok());
        EXPECT_EQ(push->status, PushStatus::Applied) << push->message;
        let_settle(*tissue);
        (void)tissue->update_deformation();
        int still = 0, moved = 0;
        double opening = 1e9;
        for_each_element(volume, [&](Vec3i p) {
            const double side = beyond(p, x, slant);
            const Vec3d u = field.displacement_mm(p);
            if (side < 0) {
                ASSERT_EQ(u, (Vec3d{0, 0, 0})) << p.x << " " << p.y << " " << p.z;
                ++still;
            } else if (side < 1 && std::abs(p.y - 18) < 3 && std::abs(p.z - 16) < 3) {
                opening = std::min(opening, dot(u, volume.grid.direction.columns[0]));
                ++moved;
            }
        });
        EXPECT_GT(still, 1000);
        EXPECT_GT(moved, 10);
        EXPECT_GT(opening, 0.5);
    }
}

TEST(SpringCuts, ACutBesideAllSpringsChangesNothing) {
    const TaskArena arena(1);
    const Volume volume = soft_block(1);
    const auto tissue = cuttable(volume, arena), other = cuttable(volume, arena);
    const auto report = tissue->cut(
        {.line_mm = {at_voxel(volume, {17.2, 17.2, 16.3}), at_voxel(volume, {18.1, 18, 16.3})},
         .depth_mm = volume.grid.direction * Vec3d{0, 0, 0.5}});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->cut_links, 0);
    EXPECT_TRUE(tissue->control().cuts_mm().empty());
    EXPECT_EQ(tissue->deformation().hash(), other->deformation().hash());
    EXPECT_FALSE(tissue->cut({.line_mm = {{0, 0, 0}}, .depth_mm = {0, 0, 1}}).ok());
    EXPECT_FALSE(tissue->cut({.line_mm = {{0, 0, 0}, {0, 0, 1}}, .depth_mm = {0, 0, 1}}).ok());
    EXPECT_FALSE(tissue->cut({.line_mm = {{0, 0, 0}, {1e9, 0, 1}}, .depth_mm = {0, 0, 1}}).ok());
}

TEST(SpringCuts, ABladeCutsMovedTissueWhereItIsSeen) {
    const TaskArena arena(2);
    const Volume volume = soft_block(1);
    const auto tissue = cuttable(volume, arena);
    const Vec3d way = volume.grid.direction * Vec3d{4, 0, 0};
    ASSERT_TRUE(tissue->push(1, {.point_mm = at_voxel(volume, {18, 18, 16}), .push_mm = way}).ok());
    let_settle(*tissue);
    const std::vector<Vec3d> places = positions_of(*tissue);
    constexpr double kAt = 18.5;
    ASSERT_TRUE(tissue->cut(plane_at(volume, kAt)).ok());
    const auto x_of = [&](std::int32_t n) {
        return voxel_from_world(volume.grid, places[std::size_t(n)]).x - kAt;
    };
    const auto rest_x_of = [&](std::int32_t n) {
        return voxel_from_world(volume.grid, control_of(*tissue).node_mm(n)).x - kAt;
    };
    int cut = 0, moved_across = 0;
    for (std::int32_t n = 0; n + 1 < control_of(*tissue).node_count(); ++n) {
        if ((n + 1) % control_of(*tissue).grid().size.x == 0) continue;
        const double a = x_of(n), b = x_of(n + 1);
        if (std::min(std::abs(a), std::abs(b)) < 0.4) continue;  // the pieces are flat
        const bool is_cut = control_of(*tissue).is_cut(control_of(*tissue).node_mm(n),
                                                       control_of(*tissue).node_mm(n + 1));
        EXPECT_EQ(is_cut, (a < 0) != (b < 0)) << n;
        cut += is_cut;
        moved_across += (a < 0) != (rest_x_of(n) < 0);
    }
    EXPECT_GT(cut, 20);
    EXPECT_GT(moved_across, 0);
}

TEST(SpringCuts, AreUndoneSavedAndDoneAgain) {
    const TaskArena arena(2);
    const TemporaryFolder folder;
    const Volume volume = soft_block(2);
    const auto make_tissue = [&] {
        return std::move(make_springs(volume, {.cell_mm = kCell}, arena)).value();
    };
    const auto tissue = make_tissue();
    ASSERT_TRUE(tissue->traits().cuts);
    const auto voxels = [&](const Tissue& of) {
        return hash_volume(deform_volume(of).value().volume);
    };
    std::vector<std::uint64_t> hashes{tissue->hash()}, scans{voxels(*tissue)};
    const auto act = [&](const char* name, const auto& action) {
        tissue->begin_group(name);
        action();
        EXPECT_EQ(tissue->end_group(), 0);
        hashes.push_back(tissue->hash());
        scans.push_back(voxels(*tissue));
    };
    const CutSurface blade{
        .line_mm = {at_voxel(volume, {18.5, 9, 8}), at_voxel(volume, {18.5, 26, 8})},
        .depth_mm = volume.grid.direction * Vec3d{0, 0, 14}};
    const Push push{.point_mm = at_voxel(volume, {22, 18, 15}),
                    .push_mm = volume.grid.direction * Vec3d{3, 0, 0}};
    act("push", [&] { ASSERT_TRUE(tissue->push(1, push).ok()); });
    act("cut", [&] { ASSERT_GT(tissue->cut(blade)->cut_links, 0); });
    act("sweeps", [&] {
        for (int n = 0; n < 50; ++n) ASSERT_TRUE(tissue->sweep().ok());
    });
    act("cut", [&] { ASSERT_GT(tissue->cut(plane_at(volume, 9.5))->cut_links, 0); });
    for (std::size_t n = 1; n < hashes.size(); ++n) EXPECT_NE(hashes[n], hashes[n - 1]) << n;
    ASSERT_TRUE(tissue->save_state(folder / "cut.plst").ok());
    const auto other = make_tissue();
    ASSERT_TRUE(other->load_state(folder / "cut.plst").ok());
    EXPECT_EQ(other->hash(), hashes.back());
    EXPECT_EQ(voxels(*other), scans.back());
    for (std::size_t n = hashes.size() - 1; n-- > 0;) {
        ASSERT_TRUE(tissue->undo().ok());
        EXPECT_EQ(tissue->hash(), hashes[n]) << n;
        EXPECT_EQ(voxels(*tissue), scans[n]) << n;
    }
    for (std::size_t n = 1; n < hashes.size(); ++n) {
        ASSERT_TRUE(tissue->redo().ok());
        EXPECT_EQ(tissue->hash(), hashes[n]) << n;
        EXPECT_EQ(voxels(*tissue), scans[n]) << n;
    }
    // From the same state both go on alike.
    for (int n = 0; n < 30; ++n) ASSERT_TRUE(tissue->sweep().ok() && other->sweep().ok());
    EXPECT_EQ(tissue->hash(), other->hash());
    EXPECT_FALSE(dynamic_cast<NodeTissue&>(*tissue).set_state(std::vector<double>(7, 0)).ok());
}

TEST(SpringCuts, ACutThatIsUndoneLeavesNoTrace) {
    const TaskArena arena(1);
    const Volume volume = soft_block(3);
    const auto tissue = cuttable(volume, arena), other = cuttable(volume, arena);
    const std::vector<Vec3d> rest = positions_of(*tissue);
    ASSERT_GT(tissue->cut(plane_at(volume, 18.5))->cut_links, 0);
    ASSERT_TRUE(tissue->set_shape(rest, {}).ok());
    const Push push{.point_mm = at_voxel(volume, {22, 18, 15}), .push_mm = {2, 1, 0}};
    for (SpringScanTissue* own : {tissue.get(), other.get()}) {
        ASSERT_TRUE(own->push(1, push).ok());
        (void)own->advance({.max_steps = 200});
    }
    EXPECT_EQ(tissue->hash(), other->hash());
    EXPECT_EQ(tissue->deformation().hash(), other->deformation().hash());
}

TEST(SpringDepth, OneMoreLayerThanTheFoundOnesMovesNothingMuch) {
    const TaskArena arena(1);
    const Volume volume = soft_block(1);
    const auto shape_at = [&](std::int32_t depth) {
        const auto tissue =
            std::move(SpringScanTissue::create(volume, {.cell_mm = kCell, .depth = depth}, arena))
                .value();
        EXPECT_TRUE(tissue
                        ->push(1, {.point_mm = at_voxel(volume, {18, 18, 16}),
                                   .push_mm = volume.grid.direction * Vec3d{2, 0, 0}})
                        .ok());
        let_settle(*tissue);
        return displacements_of(*tissue);
    };
    const auto tissue = cuttable(volume, arena);
    EXPECT_EQ(tissue->find_depth(0.1, 20).error().code, ErrorCode::NotFound);
    ASSERT_TRUE(tissue
                    ->push(1, {.point_mm = at_voxel(volume, {18, 18, 16}),
                               .push_mm = volume.grid.direction * Vec3d{2, 0, 0}})
                    .ok());
    const std::uint64_t before = tissue->hash();
    constexpr double kWithin = 0.05;
    const auto found = tissue->find_depth(kWithin, 20);
    ASSERT_TRUE(found.ok()) << found.error().message;
    EXPECT_EQ(tissue->hash(), before);
    ASSERT_GT(found->depth, 1);
    ASSERT_LT(found->depth, 8);
    EXPECT_EQ(found->changes.size(), std::size_t(found->depth));
    // Compared with motions that came to rest, to the speed at which they end.
    for (std::int32_t depth = 1; depth <= found->depth; ++depth) {
        const auto fewer = shape_at(depth), more = shape_at(depth + 1);
        double change = 0;
        for (std::size_t n = 0; n < fewer.size(); ++n)
            change = std::max(change, norm(more[n] - fewer[n]));
        EXPECT_NEAR(change, found->changes[std::size_t(depth) - 1], 0.01) << depth;
        EXPECT_EQ(found->changes[std::size_t(depth) - 1] < kWithin, depth == found->depth);
    }
    EXPECT_EQ(tissue->find_depth(1e-3, 1)->depth, 0);
    EXPECT_FALSE(tissue->find_depth(0, 20).ok());
}

}  // namespace
}  // namespace pliant::test
