// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Calls that are given up at each of their loops: an error, and nothing has changed.
// Covers: tissue/chainmail_tissue.cpp, tissue/body_tissue.cpp, tissue/spring_tissue.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <cstdio>

namespace pliant::test {
namespace {

/// Gives up at the n-th loop from now; 0: never.
class Patience {
  public:
    TaskArena arena() {
        return TaskArena(HostJobs{.thread_count = 1, .run = {}, .give_up = [this] {
                                      return m_left > 0 && --m_left == 0;
                                  }});
    }
    void end_at(std::int64_t loop) { m_left = loop; }

  private:
    std::int64_t m_left = 0;
};

Volume scan() {
    Volume volume{{{32, 32, 32}, {1, 1, 1}, {0, 0, 0}, kIdentity3},
                  VoxelArray<std::int16_t>(32 * 32 * 32),
                  {},
                  kAirHu};
    auto& values = *std::get_if<0>(&volume.voxels);
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = std::int16_t(n * 7919 % 100);
    values.freeze();
    return volume;
}

template <class Make>
void give_up_at_each_loop(const Make& make, int least) {
    Patience patience;
    const TaskArena arena = patience.arena();
    const Volume volume = scan();
    const auto tissue = make(volume, arena);
    ASSERT_TRUE(tissue.ok()) << tissue.error().message;
    const Push push{
        .point_mm = {16.2, 15.7, 16.4}, .push_mm = {1.5, 0.5, 0}, .sphere_radius_mm = 4};
    const std::uint64_t before = (*tissue)->hash();
    std::int64_t loop = 1;
    for (;; ++loop) {
        patience.end_at(loop);
        const auto pushed = (*tissue)->push(1, push);
        patience.end_at(0);
        if (pushed.ok()) break;
        ASSERT_EQ(pushed.error().code, ErrorCode::LimitExceeded) << "loop " << loop;
        ASSERT_EQ((*tissue)->hash(), before) << "loop " << loop;
        ASSERT_FALSE((*tissue)->is_touched()) << "loop " << loop;
        ASSERT_LT(loop, 100'000);
    }
    std::printf("%ld loops\n", long(loop - 1));
    EXPECT_GE(loop - 1, least);
    const auto other = make(volume, arena);
    ASSERT_TRUE(other.ok());
    ASSERT_TRUE((*other)->push(1, push).ok());
    EXPECT_EQ((*tissue)->hash(), (*other)->hash());

    std::int64_t reads = 1;
    for (;; ++reads) {
        patience.end_at(reads);
        const auto deformed = deform_volume(**tissue);
        patience.end_at(0);
        if (deformed.ok()) break;
        ASSERT_EQ(deformed.error().code, ErrorCode::LimitExceeded);
        ASSERT_LT(reads, 1000);
    }
    EXPECT_GT(reads, 1);
}

TEST(GivingUp, ChainMailIsUnchanged) {
    give_up_at_each_loop([](const Volume& volume,
                            const TaskArena& arena) { return make_chainmail(volume, {}, arena); },
                         1);
}

TEST(GivingUp, SpringsAreUnchanged) {
    give_up_at_each_loop(
        [](const Volume& volume, const TaskArena& arena) {
            return make_springs(volume, {.cell_mm = 4}, arena);
        },
        0);
}

TEST(GivingUp, ABodyIsUnchanged) {
    const TetMesh block = five_tet_block({4, 4, 4}, 7);
    give_up_at_each_loop(
        [&](const Volume& volume, const TaskArena& arena) {
            return make_body(volume, block, {.fixed_hu = 1e4}, arena);
        },
        10);
}

}  // namespace
}  // namespace pliant::test
