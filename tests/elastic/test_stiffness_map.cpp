// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each level of the stiffness map beside its definition: means of moduli, kinds of cells, sides
// that are held, and bone.
// Covers: elastic/stiffness_map.cpp, elastic/stiffness_map.h.

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <tuple>

#include "elastic/lattices.h"
#include "elastic/stiffness_map.h"
#include "support/random.h"

namespace pliant::test {
namespace {

struct Shape {
    Vec3i size;
    Vec3d spacing_mm;
};
// Edges that are whole coarse cells, and others; axes that are doubled later than others.
constexpr Shape kShapes[] = {{{33, 17, 25}, {1, 1, 1}},
                             {{30, 23, 19}, {1, 1, 1}},
                             {{21, 27, 23}, {2.5, 0.9, 1}},
                             {{27, 30, 14}, {0.7, 0.7, 2}}};

Vec3i corner(int c) {
    return {c & 1, c >> 1 & 1, c >> 2};
}

Vec3i times(Vec3i v, Vec3i step) {
    return {v.x << step.x, v.y << step.y, v.z << step.z};
}

template <class Visit>
void for_each_in(Vec3i size, const Visit& visit) {
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) visit(Vec3i{i, j, k});
}

std::size_t count_of(Vec3i size) {
    return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
}

std::size_t index_in(Vec3i size, Vec3i at) {
    return std::size_t(at.x) +
           std::size_t(size.x) * (std::size_t(at.y) + std::size_t(size.y) * std::size_t(at.z));
}

TEST(Map, ModuliAreMeansOfTheFinerOnesAndKindsFollowFromThem) {
    const TaskArena arena(2);
    constexpr double kNu = 0.4;
    for (const Shape& shape : kShapes) {
        Random random(1);
        // Modulus of voxels: value · 10 Pa; half of them are void.
        const Volume scan = scan_of(shape.size, shape.spacing_mm, [&](Vec3i at) {
            return at.x < 6 || random.whole(0, 9) == 0 ? 0 : random.whole(1, 9000);
        });
        const StiffnessMap map(scan, plain_settings(kNu), arena);
        const double per_pa = 1 / (2 * (1 + kNu)), nothing = double(map.void_mu());
        EXPECT_NEAR(nothing, 1e5 * per_pa / 2000, 1e-5);
        std::vector<double> finer;
        for (int level = 0; level < map.level_count(); ++level) {
            SCOPED_TRACE("level " + std::to_string(level));
            const Vec3i cells = map.cells(level);
            std::vector<float> mu(count_of(cells));
            std::vector<CellKind> kinds(count_of(cells));
            const Box3i box{{0, 0, 0}, cells};
            map.moduli(level, box, std::size_t(cells.x), std::size_t(cells.y), mu.data());
            map.kinds(level, box, std::size_t(cells.x), std::size_t(cells.y), kinds.data());
            std::vector<double> expected(count_of(cells));
            const Vec3i step = level > 0 ? map.shift(level) - map.shift(level - 1) : Vec3i{};
            for_each_in(cells, [&](Vec3i cell) {
                double sum = 0;
                bool is_tissue = true;
                if (level == 0) {
                    const Vec3i last = cell + Vec3i{1, 1, 1};
                    const bool inside = contains(Box3i{{0, 0, 0}, shape.size}, last);
                    for (int c = 0; c < 8 && inside; ++c) {
                        const double modulus = 10 * double(scan.at(cell + corner(c))) * per_pa;
                        sum += modulus / 8;
                        is_tissue = is_tissue && modulus > 8 * nothing;
                    }
                    is_tissue = is_tissue && inside;
                    sum = std::max(sum, nothing);
                } else {
                    const Vec3i size = times({1, 1, 1}, step);
                    for_each_in(size, [&](Vec3i part) {
                        sum += finer[index_in(map.cells(level - 1), times(cell, step) + part)];
                    });
                    sum /= double(count_of(size));
                    is_tissue = sum > 8 * nothing;
                }
                const std::size_t at = index_in(cells, cell);
                expected[at] = sum;
                ASSERT_NEAR(double(mu[at]), sum, 1e-5 * sum);
                ASSERT_EQ(kinds[at], is_tissue ? CellKind::Tissue : CellKind::Open);
            });
            finer = std::move(expected);
        }
    }
}

/// Whether nodes are bone by the definition: a coarser node is bone if the finer one at its place
/// is, or if finer nodes between coarser ones, none of whose other parents is bone, have an eighth
/// of its weight.
class BoneNodes {
  public:
    BoneNodes(const StiffnessMap& map, const Volume& scan, double above) : m_map(map) {
        m_is_bone.resize(std::size_t(map.level_count()));
        for_each_in(scan.grid.size, [&](Vec3i at) {
            if (double(scan.at(at)) > above) m_is_bone[0][key(at)] = true;
        });
        for (int level = 1; level < map.level_count(); ++level) coarsen(level);
    }
    bool at(int level, Vec3i node) const {
        return m_is_bone[std::size_t(level)].contains(key(node));
    }

  private:
    static std::tuple<int, int, int> key(Vec3i at) { return {at.x, at.y, at.z}; }

    void coarsen(int level) {
        const Vec3i step = m_map.shift(level) - m_map.shift(level - 1);
        for_each_in(m_map.cells(level) + Vec3i{1, 1, 1}, [&](Vec3i node) {
            const Vec3i place = times(node, step);
            double share = 0, all = 0;
            for_each_in(Vec3i{3, 3, 3}, [&](Vec3i n) {
                const Vec3i away = n - Vec3i{1, 1, 1};
                double weight = 1;
                for (int a = 0; a < 3; ++a)
                    if (away[a]) weight *= step[a] ? 0.5 : 0;
                all += weight;
                if (weight > 0 && at(level - 1, place + away) && is_left_out(level, place, away))
                    share += weight;
            });
            if (at(level - 1, place) || 8 * share >= all)
                m_is_bone[std::size_t(level)][key(node)] = true;
        });
    }
    bool is_left_out(int level, Vec3i place, Vec3i away) const {
        for (int c = 1; c < 8; ++c) {
            Vec3i parent = place;
            for (int a = 0; a < 3; ++a) parent[a] += 2 * corner(c)[a] * away[a];
            if (parent != place && at(level - 1, parent)) return false;
        }
        return true;
    }

    const StiffnessMap& m_map;
    std::vector<std::map<std::tuple<int, int, int>, bool>> m_is_bone;
};

TEST(Map, NodesAreBoneByTheDefinitionOnEachLevel) {
    const TaskArena arena(2);
    for (const Shape& shape : kShapes)
        for (const int one_in : {4, 15, 60}) {
            SCOPED_TRACE("one voxel in " + std::to_string(one_in));
            Random random{std::uint64_t(one_in)};
            const Volume scan = scan_of(shape.size, shape.spacing_mm, [&](Vec3i) {
                return random.whole(1, one_in) == 1 ? 5000 : 300;
            });
            auto settings = plain_settings(0.4);
            settings.held_above_hu = 4999;
            const StiffnessMap map(scan, settings, arena);
            const BoneNodes bone(map, scan, settings.held_above_hu);
            for (int level = 0; level < map.level_count(); ++level)
                for_each_in(map.cells(level) + Vec3i{1, 1, 1}, [&](Vec3i node) {
                    ASSERT_EQ(map.is_held(level, node), bone.at(level, node))
                        << level << ": " << node.x << " " << node.y << " " << node.z;
                });
        }
}

TEST(Map, LabelsHoldByTheirLaw) {
    const TaskArena arena(1);
    Random random(3);
    const Volume scan =
        scan_of({17, 17, 17}, {1, 1, 1}, [&](Vec3i) { return random.whole(0, 1) ? 2000 : 300; });
    const Volume labels =
        scan_of(scan.grid.size, {1, 1, 1}, [&](Vec3i) { return random.whole(0, 4); });
    auto settings = plain_settings(0.4);
    settings.held_above_hu = 1000;
    settings.labels = std::make_shared<const Volume>(labels);
    settings.label_materials = {{.values = {1}, .law = LabelLaw::Immobile},
                                {.values = {2}, .law = LabelLaw::Constant},
                                {.values = {3}},
                                {.values = {4}, .bone_threshold_hu = 200}};
    const StiffnessMap map(scan, settings, arena);
    for_each_in(scan.grid.size, [&](Vec3i p) {
        const int label = int(labels.at(p));
        const bool expected = label == 1 || label == 4 || (label != 2 && scan.at(p) > 1000);
        ASSERT_EQ(map.is_bone(p), expected) << label << ": " << scan.at(p);
        ASSERT_EQ(map.is_held(0, p), expected) << label << ": " << scan.at(p);
    });
}

TEST(Map, AHeldSideHoldsItsNodesOnEachLevel) {
    const TaskArena arena(1);
    const std::string sides[] = {"-x", "+x", "-y", "+y", "-z", "+z"};
    for (const Shape& shape : kShapes) {
        const Volume scan = scan_of(shape.size, shape.spacing_mm, [](Vec3i) { return 300; });
        for (int n = 0; n < 6; ++n) {
            SCOPED_TRACE(sides[n]);
            auto settings = plain_settings(0.4);
            settings.held_sides = {sides[n]};
            const StiffnessMap map(scan, settings, arena);
            const int axis = n / 2, last = shape.size[axis] - 1;
            for (int level = 0; level < map.level_count(); ++level) {
                const int size = 1 << map.shift(level)[axis];
                for_each_in(map.cells(level) + Vec3i{1, 1, 1}, [&](Vec3i node) {
                    // The node nearest to the last voxel, of two the first, and those beyond it.
                    const int voxel = size * node[axis];
                    const bool expected = n % 2 ? 2 * (last - voxel) < size : voxel == 0;
                    ASSERT_EQ(map.is_held(level, node), expected) << level << ": " << voxel;
                });
            }
        }
    }
}

}  // namespace
}  // namespace pliant::test
