// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each allocation fails once, without lasting effects.
// Covers: tissue/spring_tissue.cpp.

#include <gtest/gtest.h>

#include "base/errors.h"
#include "support/broken_volumes.h"
#include "support/temporary_folder.h"
#include "tissue/no_trace.h"
#include "tissue/spring_tissue.h"

namespace pliant::test {
namespace {

class SpringMemory : public testing::Test {
  protected:
    SpringMemory() {
        Random random(5);
        m_volume.grid = {{25, 25, 21}, {1, 1, 1.5}, {-20, 4, 7}, random.rotation(false)};
        std::vector<std::int16_t> voxels;
        for (int k = 0; k < 21; ++k)
            for (int n = 0; n < 25 * 25; ++n)
                voxels.push_back(std::int16_t(k < 5 ? 900 : random.whole(-60, 60)));
        m_volume.voxels = std::move(voxels);
        m_push = {.point_mm = world_from_voxel(m_volume.grid, {11.7, 12.2, 13.4}),
                  .push_mm = {0.8, -0.6, 0.4},
                  .sphere_radius_mm = 3};
        m_aside = m_push;
        m_aside.point_mm = world_from_voxel(m_volume.grid, {16.3, 12.2, 13.4});
    }
    std::unique_ptr<SpringScanTissue> make() const {
        auto tissue =
            SpringScanTissue::create(m_volume, {.cell_mm = 4, .depth = 2}, m_arena).value();
        touch(*tissue, m_push);
        return tissue;
    }
    /// An operation that ran out of memory has no effect until the tissue is at rest again.
    template <class Operation>
    void check(const Operation& operation, const char* name, int least) {
        expect_no_trace(
            name, [&] { return make(); }, operation, least, 500);
    }

    const TaskArena m_arena{1};
    Volume m_volume;
    Push m_push, m_aside;
};

TEST_F(SpringMemory, APushThatRanOutOfMemoryLeavesNoTrace) {
    check([&](SpringScanTissue& tissue) { return tissue.push(kFirstTool, m_push); }, "same tool",
          5);
    check([&](SpringScanTissue& tissue) { return tissue.push(kSecondTool, m_push); }, "its nodes",
          5);
    check([&](SpringScanTissue& tissue) { return tissue.push(kSecondTool, m_aside); }, "aside", 5);
    check([&](SpringScanTissue& tissue) { return tissue.grab(kSecondTool, m_aside, 5); }, "grab",
          5);
}

TEST_F(SpringMemory, ASweepThatRanOutOfMemoryLeavesNoTrace) {
    // Released nodes must be reachable again.
    const auto make = [&] {
        auto tissue = this->make();
        tissue->release(kFirstTool);
        return tissue;
    };
    const auto operation = [](SpringScanTissue& tissue) { return tissue.sweep(); };
    fail_each_allocation(make, operation, visible_state);
    // Each sweep that can fail does so, until rest.
    auto tissue = make(), twin = make();
    int failed = 0;
    for (int n = 0; n < 500; ++n) {
        bool ok = false;
        {
            const FailingAllocation failing(n % 3);
            ok = tissue->sweep().ok();
        }
        failed += !ok;
        if (!ok) {
            ASSERT_TRUE(tissue->sweep().ok());
        }
        ASSERT_TRUE(twin->sweep().ok());
        ASSERT_EQ(visible_state(*tissue), visible_state(*twin)) << "sweep " << n;
    }
    EXPECT_GT(failed, 0);
}

TEST_F(SpringMemory, StepsAreTakenBackOrNot) {
    const auto make = [&] { return this->make(); };
    fail_each_allocation(
        make, [](SpringScanTissue& tissue) { return attempt([&] { return tissue.undo(); }); },
        visible_state);
    fail_each_allocation(
        [&] {
            auto tissue = this->make();
            EXPECT_TRUE(tissue->undo().ok());
            return tissue;
        },
        [](SpringScanTissue& tissue) { return attempt([&] { return tissue.redo(); }); },
        visible_state);
    fail_each_allocation(
        make,
        [](SpringScanTissue& tissue) {
            return attempt([&]() -> Status {
                tissue.begin_group("next");
                return Ok{};
            });
        },
        visible_state);
    // A group ends without any memory.
    auto tissue = make();
    tissue->begin_group("next");
    ASSERT_TRUE(tissue->push(kSecondTool, m_aside).ok());
    const FailingAllocation failing(0);
    EXPECT_EQ(tissue->end_group(), 0);
    EXPECT_FALSE(failing.has_failed());
    EXPECT_EQ(tissue->undo_steps(), 2);
}

TEST_F(SpringMemory, AStateIsLoadedOrNot) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "state";
    auto other = make();
    ASSERT_TRUE(other->push(kSecondTool, m_aside).ok());
    ASSERT_TRUE(other->save_state(file).ok());
    fail_each_allocation(
        [&] { return this->make(); },
        [&](SpringScanTissue& tissue) { return attempt([&] { return tissue.load_state(file); }); },
        visible_state);
    fail_each_allocation(
        [&] { return this->make(); },
        [](SpringScanTissue& tissue) { return attempt([&] { return tissue.rest(); }); },
        visible_state);
}

TEST_F(SpringMemory, TheElementsFollowOrStay) {
    const auto volume_of = [&](const SpringScanTissue& tissue) {
        // After any failure, the nodes are unchanged.
        return hash_volume(deform_volume(tissue).value().volume);
    };
    fail_each_allocation([&] { return this->make(); },
                         [](SpringScanTissue& tissue) { return tissue.update_deformation(); },
                         visible_state);
    auto tissue = make(), twin = make();
    {
        const FailingAllocation failing(0);
        EXPECT_FALSE(deform_volume(*tissue).ok());
    }
    EXPECT_EQ(volume_of(*tissue), volume_of(*twin));
}

TEST_F(SpringMemory, ATissueIsMadeOrRefused) {
    fail_each_allocation([&] { return &m_volume; },
                         [&](const Volume& volume) {
                             return make_springs(volume, {.cell_mm = 4, .depth = 2}, m_arena);
                         },
                         [](const Volume&) { return 0; }, {.all_up_to = 100, .of_the_rest = 30});
}

}  // namespace
}  // namespace pliant::test
