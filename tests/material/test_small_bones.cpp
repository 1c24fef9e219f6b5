// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bone is a piece of bone: against a plain search of all pieces, and in every way in which an
// element's material is asked for.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "material/material_map.h"
#include "support/random.h"
#include "volume/boxes.h"

namespace pliant::test {
namespace {

constexpr double kBone_hu = 300;

/// Noise that is bone here and there, in clumps of all sizes.
Volume random_scan(Random& random, bool of_floats) {
    Volume volume;
    volume.grid.size = {random.whole(2, 21), random.whole(2, 17), random.whole(2, 19)};
    volume.grid.spacing_mm = {random.real(0.3, 2), random.real(0.3, 2), random.real(0.3, 2)};
    const double share = random.real(0.05, 0.6);
    std::vector<float> values(voxel_count(volume.grid));
    for (float& v : values) v = random.real(0, 1) < share ? 700.0f : 40.0f;
    if (of_floats) {
        values.front() = std::numeric_limits<float>::quiet_NaN();
        volume.voxels = std::move(values);
    } else {
        volume.voxels = std::vector<std::int16_t>(values.begin(), values.end());
    }
    return volume;
}

/// Volume of each voxel's piece [mm³]; infinite if the border cuts it or it touches a kept voxel,
/// 0 where no bone is.
std::vector<double> piece_mm3(const Volume& volume, const std::vector<bool>& is_kept) {
    const Grid& grid = volume.grid;
    std::vector<double> all(voxel_count(grid), 0);
    std::vector<bool> seen(all.size(), false);
    const auto is_bone = [&](Vec3i p) {
        return double(volume.at(p)) > kBone_hu || is_kept[voxel_index(grid, p)];
    };
    for_each_in(voxel_box(grid), [&](Vec3i seed) {
        if (!is_bone(seed) || seen[voxel_index(grid, seed)]) return;
        std::vector<Vec3i> piece{seed};
        seen[voxel_index(grid, seed)] = true;
        bool stays = false;
        for (std::size_t n = 0; n < piece.size(); ++n) {
            stays = stays || is_kept[voxel_index(grid, piece[n])];
            for (int side = 0; side < 6; ++side) {
                Vec3i next = piece[n];
                next[side / 2] += side % 2 ? 1 : -1;
                if (!contains(voxel_box(grid), next)) {
                    stays = true;
                } else if (is_bone(next) && !seen[voxel_index(grid, next)]) {
                    seen[voxel_index(grid, next)] = true;
                    piece.push_back(next);
                }
            }
        }
        const Vec3d h = grid.spacing_mm;
        const double mm3 = stays ? HUGE_VAL : double(piece.size()) * (h.x * h.y * h.z);
        for (const Vec3i p : piece) all[voxel_index(grid, p)] = mm3;
    });
    return all;
}

void expect_pieces(std::uint64_t seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Volume volume = random_scan(random, random.whole(0, 1));
    ChainMailSettings settings;
    settings.smallest_bone_mm3 = random.ratio(0.5, 60);
    std::vector<bool> is_kept(voxel_count(volume.grid), false);
    if (random.whole(0, 1)) {
        Volume labels;
        labels.grid = volume.grid;
        std::vector<std::int16_t> values(is_kept.size(), 0);
        for (std::size_t n = 0; n < is_kept.size(); ++n)
            if (random.whole(0, 30) == 0) values[n] = 7, is_kept[n] = true;
        labels.voxels = std::move(values);
        settings.labels = std::make_shared<const Volume>(std::move(labels));
        settings.label_materials = {{.values = {7}, .law = LabelLaw::Immobile}};
    }
    const MaterialMap map(volume, settings);
    const std::vector<double> pieces = piece_mm3(volume, is_kept);
    const auto material = [&](Vec3i p) { return map.table()[map.at(p)]; };
    // The hardest tissue that isn't bone.
    const ElementLimits hardest = draeger_limits(settings, settings.bone_threshold_hu);
    int small = 0, bone = 0;
    for_each_in(voxel_box(volume.grid), [&](Vec3i p) {
        const double mm3 = pieces[voxel_index(volume.grid, p)];
        const bool expected = mm3 > 0 && mm3 < settings.smallest_bone_mm3;
        ASSERT_EQ(map.is_small_bone(p), expected) << p.x << ' ' << p.y << ' ' << p.z << ' ' << mm3;
        EXPECT_EQ(map.limits_at(p).fixed, mm3 > 0 && !expected);
        EXPECT_EQ(material(p).fixed, mm3 > 0 && !expected);
        if (expected) {
            EXPECT_EQ(map.limits_at(p).shear, hardest.shear);
            EXPECT_EQ(map.limits_at(p).max_movement_mm, hardest.max_movement_mm);
            EXPECT_EQ(material(p).shear[1],
                      limit_units_from_mm(volume.grid.spacing_mm.y * hardest.shear.y / 2));
        }
        (expected ? small : bone) += mm3 > 0;
    });
    // Bricks of any size have the same.
    const int size = random.whole(0, 1) ? 8 : random.whole(2, 9);
    std::vector<MaterialId> ids(std::size_t(size) * std::size_t(size) * std::size_t(size));
    const Vec3i most{(volume.grid.size.x - 1) / size, (volume.grid.size.y - 1) / size,
                     (volume.grid.size.z - 1) / size};
    for_each_in({{-1, -1, -1}, most + Vec3i{2, 2, 2}}, [&](Vec3i coord) {
        const Vec3i first = size * coord;
        Box3i part = overlap({first, first + Vec3i{size, size, size}}, voxel_box(volume.grid));
        part = {part.begin - first, part.end - first};
        const bool is_one = map.fill(first, size, part, ids.data());
        for_each_in({{0, 0, 0}, {size, size, size}}, [&](Vec3i local) {
            const auto n = std::size_t(local.x + size * (local.y + size * local.z));
            ASSERT_EQ(ids[n], map.at(first + local));
            if (is_one && contains(part, local)) {
                EXPECT_EQ(ids[n], map.at(first + part.begin));
            }
        });
    });
    ::testing::Test::RecordProperty("small", small);
    ::testing::Test::RecordProperty("bone", bone);
}

TEST(SmallBones, AreLookedForInTheBlocksOfABoxOnly) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Grid grid{.size = {random.whole(9, 33), random.whole(9, 33), random.whole(9, 33)}};
        std::vector<bool> is_bone(voxel_count(grid), false);
        for (int n = 0; n < 3; ++n)
            is_bone[voxel_index(grid,
                                {random.whole(1, grid.size.x - 2), random.whole(1, grid.size.y - 2),
                                 random.whole(1, grid.size.z - 2)})] = true;
        const SmallBones bones(grid, 100, [&](int y, int z, BoneElement* row) {
            for (int x = 0; x < grid.size.x; ++x)
                row[x] = is_bone[voxel_index(grid, {x, y, z})] ? BoneElement::ByValue
                                                               : BoneElement::None;
            return true;
        });
        ASSERT_FALSE(bones.empty());
        for (int n = 0; n < 40; ++n) {
            Box3i box, blocks;  // with the whole blocks of 8³ around it
            for (int a = 0; a < 3; ++a) {
                box.begin[a] = random.whole(0, grid.size[a] - 1);
                box.end[a] = random.whole(box.begin[a] + 1, grid.size[a]);
                blocks.begin[a] = box.begin[a] / 8 * 8;
                blocks.end[a] = std::min((box.end[a] + 7) / 8 * 8, grid.size[a]);
            }
            bool any = false;
            for_each_in(blocks, [&](Vec3i p) { any |= is_bone[voxel_index(grid, p)]; });
            ASSERT_EQ(bones.may_be_in(box), any);
        }
    }
}

TEST(SmallBones, AreThePiecesThatAPlainSearchFinds) {
    for (std::uint64_t seed = 1; seed <= 120; ++seed) expect_pieces(seed);
}

TEST(SmallBones, AFleckMovesWithTheWallAndABoneStopsIt) {
    // Soft tissue with one voxel of 301 HU, or with a rod that is large enough.
    const auto push = [](bool rod, double smallest_mm3) {
        Volume volume;
        volume.grid.size = {40, 40, 40};
        std::vector<std::int16_t> values(40 * 40 * 40, 40);
        for (int z = rod ? 10 : 20; z <= (rod ? 29 : 20); ++z)
            for (int y = rod ? 17 : 20; y <= (rod ? 22 : 20); ++y)
                values[voxel_index(volume.grid, {23, y, z})] = 301;
        volume.voxels = std::move(values);
        const TaskArena arena(1);
        ChainMailSettings settings;
        settings.smallest_bone_mm3 = smallest_mm3;
        auto tissue = ChainMail::create(volume, settings, arena).value();
        const auto report = tissue.push({{20, 20, 20}, {4, 0, 0}, 2});
        EXPECT_TRUE(report.ok());
        EXPECT_EQ(tissue.state().max_violation_mm, 0);
        return std::pair(report.value(), tissue.displacement_mm({23, 20, 20}));
    };
    const auto [moved, fleck] = push(false, 100);
    EXPECT_EQ(moved.status, PushStatus::Applied);
    EXPECT_GT(fleck.x, 1) << "it moves along";
    EXPECT_FALSE(moved.bone_mm);
    const auto [thesis, still] = push(false, 0);
    EXPECT_EQ(thesis.limited_by, LimitedBy::Bone);
    EXPECT_EQ(norm(still), 0);
    ASSERT_TRUE(thesis.bone_mm);
    EXPECT_EQ(*thesis.bone_mm, (Vec3d{23, 20, 20}));
    const auto [stopped, bone] = push(true, 100);
    EXPECT_EQ(stopped.limited_by, LimitedBy::Bone);
    EXPECT_EQ(norm(bone), 0);
}

/// Every solver, and every way through the brick, gives the same bits with flecks about.
TEST(SmallBones, AreExactWithEverySolver) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Volume volume;
        volume.grid.size = {24, 22, 20};
        std::vector<std::int16_t> values(voxel_count(volume.grid));
        for (auto& v : values)
            v = std::int16_t(random.whole(0, 9) == 0 ? random.whole(301, 900)
                                                     : random.whole(-80, 250));
        volume.voxels = std::move(values);
        ChainMailSettings settings;
        settings.limits = random.whole(0, 1) ? LinkLimits::Box : LinkLimits::Rounded;
        settings.smallest_bone_mm3 = 12;
        const TaskArena arena(2);
        std::set<std::uint64_t> hashes;
        for (const auto solver :
             {ChainMailSolver::Sweep, ChainMailSolver::Heap, ChainMailSolver::PlainSweep}) {
            Random pushes(seed);
            settings.solver = solver;
            auto tissue = ChainMail::create(volume, settings, arena).value();
            for (int n = 0; n < 4; ++n)
                ASSERT_TRUE(tissue
                                .push({{pushes.real(6, 16), pushes.real(6, 14), pushes.real(6, 12)},
                                       pushes.vector(3),
                                       pushes.real(0, 3)})
                                .ok());
            const LatticeState state = tissue.state();
            EXPECT_EQ(state.max_violation_mm, 0);
            hashes.insert(tissue.hash());
        }
        EXPECT_EQ(hashes.size(), 1u);
    }
}

}  // namespace
}  // namespace pliant::test
