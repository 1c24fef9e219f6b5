// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The passes through one material against the heap: alone, beside other materials, cuts, tissue
// that was moved before and borders, and in cases where they must give up.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "lattice/lattice.h"
#include "propagate/propagation.h"
#include "propagate/sweep_kernels.h"
#include "propagate/uniform_passes.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kUniformPassesSeed = 20261204;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kScenes = 20;
#else
constexpr std::uint64_t kScenes = 120;
#endif

/// Value 0 nearly everywhere; other values are islands, or have equal limits with another id.
ElementLimits limits_of(int value, Vec3d limit) {
    if (value == 1) limit = 0.3 * limit;
    if (value == 2)
        for (int a = 0; a < 3; ++a) limit[a] = std::min(2.5 * limit[a], 1.0);
    ElementLimits limits{{limit.x, limit.y, limit.z},
                         {limit.x, limit.y, limit.z},
                         {limit.x, limit.y, limit.z},
                         400,
                         false};
    if (value == 3) limits.max_movement_mm = 399;
    if (value == 4) limits.compress[1] *= 0.5;
    return limits;
}

class Scene {
  public:
    explicit Scene(std::uint64_t seed) : m_random(seed) {
        Grid& grid = m_volume.grid;
        for (int a = 0; a < 3; ++a) {
            grid.size[a] = m_random.whole(9, 34);
            grid.spacing_mm[a] = m_random.whole(0, 1) ? 1.0 : m_random.ratio(0.5, 2);
        }
        std::vector<std::int16_t> values(voxel_count(grid), 0);
        for (int n = m_random.whole(0, 2); n > 0; --n) add_island(values);
        m_volume.voxels = std::move(values);
        Vec3d limit{0.2, 0.2, 0.2};
        if (m_random.whole(0, 1))
            for (int a = 0; a < 3; ++a) limit[a] = m_random.ratio(0.02, 0.5);
        const int around = m_random.whole(0, 1);
        m_settings.custom_law = [=](int v) { return limits_of(v < 0 ? around : v, limit); };
        m_settings.bounded = m_random.whole(0, 1) != 0;
        m_settings.brick_size = std::array{8, 8, 5, 16}[std::size_t(m_random.whole(0, 3))];
        m_reach_mm = m_random.ratio(1, 24) * limit.x * grid.spacing_mm.x;
        make(ChainMailSolver::Heap, m_one);
        make(ChainMailSolver::Sweep, m_one);
        make(ChainMailSolver::Sweep, m_two);
        make(ChainMailSolver::PlainSweep, m_one);
        m_settings.brick_size = 7;
        make(ChainMailSolver::Sweep, m_two);
    }

    void push() {
        std::vector<Vec3i> grabbed;
        for (int n = m_random.whole(1, 3); n > 0; --n) add_grabbed(grabbed);
        Vec3d push_mm{0, 0, 0};
        for (int a = 0; a < 3; ++a) {
            const double length = m_random.real(-m_reach_mm, m_reach_mm);
            if (m_random.whole(0, 1)) push_mm[a] = length;
        }
        const auto expected = m_tissues[0].push_elements(grabbed, push_mm);
        ASSERT_TRUE(expected.ok());
        const std::uint64_t hash = m_tissues[0].hash();
        for (ChainMail& tissue : std::span(m_tissues).subspan(1)) {
            const auto report = tissue.push_elements(grabbed, push_mm);
            ASSERT_TRUE(report.ok());
            EXPECT_EQ(report->moved_elements, expected->moved_elements);
            EXPECT_EQ(tissue.hash(), hash);
        }
    }

    void edit() {
        if (m_random.whole(0, 3) != 0) return;
        const Vec3i e = random_element();
        const Vec3d at = world_from_voxel(m_volume.grid, {double(e.x), double(e.y), double(e.z)});
        for (ChainMail& tissue : m_tissues)
            ASSERT_TRUE(tissue.carve({at, at, 2 * m_volume.grid.spacing_mm.x, false}).ok());
    }

  private:
    Vec3i random_element() {
        Vec3i element;
        for (int a = 0; a < 3; ++a) element[a] = m_random.whole(0, m_volume.grid.size[a] - 1);
        return element;
    }
    void add_island(std::vector<std::int16_t>& values) {
        const Vec3i from = random_element();
        const auto value = std::int16_t(m_random.whole(1, 4));
        const int edge = m_random.whole(1, 12);
        const Vec3i size = m_volume.grid.size;
        for (int z = from.z; z < std::min(from.z + edge, size.z); ++z)
            for (int y = from.y; y < std::min(from.y + edge, size.y); ++y)
                for (int x = from.x; x < std::min(from.x + edge, size.x); ++x)
                    values[voxel_index(m_volume.grid, {x, y, z})] = value;
    }
    void add_grabbed(std::vector<Vec3i>& grabbed) {
        const Vec3i from = random_element();
        const int edge = m_random.whole(1, 4);
        for (int n = 0; n < edge * edge * edge; ++n) {
            const Vec3i e = from + Vec3i{n % edge, n / edge % edge, n / (edge * edge)};
            if (contains(voxel_box(m_volume.grid), e)) grabbed.push_back(e);
        }
    }
    void make(ChainMailSolver solver, const TaskArena& arena) {
        m_settings.solver = solver;
        m_tissues.push_back(std::move(ChainMail::create(m_volume, m_settings, arena)).value());
    }

    Random m_random;
    Volume m_volume;
    ChainMailSettings m_settings;
    double m_reach_mm = 0;
    TaskArena m_one{1}, m_two{2};
    std::vector<ChainMail> m_tissues;
};

TEST(UniformPasses, PushesAreThoseOfTheHeap) {
    for (std::uint64_t n = 0; n < kScenes && !HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kUniformPassesSeed + n));
        Scene scene(kUniformPassesSeed + n);
        scene.push();
        scene.edit();
        scene.push();
        scene.push();
    }
}

/// A lattice with one raised element in the middle of a brick, and the result of the passes.
struct OnePush {
    OnePush(int other_value, Vec3i where) {
        volume.grid.size = {48, 48, 48};
        std::vector<std::int16_t> values(voxel_count(volume.grid), 0);
        values[voxel_index(volume.grid, where)] = std::int16_t(other_value);
        volume.voxels = std::move(values);
    }
    bool run(double raise_mm, Vec3d limit, int max_bricks = 1000) const {
        const MaterialLaw law = [limit](int value) { return limits_of(value, limit); };
        Lattice lattice(volume, std::vector{law}, 8, true);
        SweepWork work;
        const ElementRef middle = lattice.ensure_element({28, 28, 28});
        Brick& brick = lattice.brick(middle.brick);
        std::fill_n(brick.raised[0], lattice.elements_per_brick(), 0);
        brick.raised[0][middle.index] = units_from_mm(raise_mm);
        brick.reached[0] = true;
        work.shared = true;
        work.touch(middle.brick, lattice.brick_index_bound());
        return UniformPasses(lattice, vector_sweep_kernels(), work).run(TaskArena(1), max_bricks);
    }
    Volume volume;
};

TEST(UniformPasses, GiveUpOnlyWhereOtherTissueIsNear) {
    const Vec3d limit{0.2, 0.2, 0.2};  // 4 mm reach 20 elements far
    EXPECT_TRUE(OnePush(0, {0, 0, 0}).run(4, limit));
    EXPECT_TRUE(OnePush(1, {1, 1, 24}).run(4, limit));
    EXPECT_FALSE(OnePush(1, {24, 24, 26}).run(4, limit));
    EXPECT_FALSE(OnePush(1, {24, 24, 42}).run(4, limit));
    EXPECT_FALSE(OnePush(4, {36, 24, 24}).run(4, limit));
    EXPECT_FALSE(OnePush(0, {0, 0, 0}).run(4, limit, 10));
}

TEST(UniformPasses, OtherTissueIsNotMissedAcrossAnEdge) {
    // The raise of 1.5 mm is 1.5 − 3·0.4 − 4·0.02 = 0.22 mm at (32, 28, 31). That is enough to
    // examine the next element along z, whose half may be arbitrarily small, but not to raise the
    // one beside (28, 28, 31). The brick there must be found for every axis.
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        Vec3d limit{0, 0, 0};
        limit[a] = 0.02, limit[b] = 0.1, limit[c] = 0.4;
        Vec3i where{28, 28, 28};
        where[a] = where[c] = 36;
        EXPECT_FALSE(OnePush(1, where).run(1.5, limit));
        EXPECT_TRUE(OnePush(1, where).run(1.45, limit));
    }
}

}  // namespace
}  // namespace pliant::test
