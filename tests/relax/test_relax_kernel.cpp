// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "relax/relax_kernel.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/random.h"

namespace pliant::test {
namespace {

class NoGuard final : public MoveGuard {
  public:
    Vec3<Fixed> admit(int, Vec3<Fixed>, Vec3<Fixed> to) const override { return to; }
};

TEST(RelaxKernel, AnyProcessorGivesTheSameBits) {
#if defined(__x86_64__)
    if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "no AVX2";
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const int size = seed % 3 ? 8 * random.whole(1, 3) : random.whole(2, 19);
        const auto count = std::size_t(size * size * size);
        const int range = random.whole(0, 1) ? 1 << 29 : 1 << random.whole(1, 21);
        BrickLinks links;
        const bool symmetric = random.whole(0, 1);
        for (std::size_t b = 0; b < 3; ++b)
            for (std::size_t n = 0; n < std::size_t((size + 1) * size * size); ++n) {
                links.shear[b].push_back(random.whole(0, 1 << 22));
                links.weight[b].push_back(std::uint16_t(random.whole(0, 65534)));
                if (symmetric) continue;
                links.stretch[b].push_back(random.whole(0, 1 << 22));
                links.compress[b].push_back(random.whole(0, 1 << 22));
            }
        const auto value = [&] { return random.whole(0, 3) ? random.whole(-range, range) : 0; };
        std::vector<Fixed> plain[3], vectors[3], beside[3];
        for (int a = 0; a < 3; ++a)
            for (std::size_t n = 0; n < count; ++n) {
                plain[a].push_back(value());
                beside[a].push_back(random.whole(-range, range));
            }
        const NoGuard guard;
        RelaxedBrick brick{size, random.whole(0, 1), {}, {}, &links, {}, {}, {}, &guard, false,
                           1e17};
        for (std::size_t a = 0; a < 3; ++a) {
            vectors[a] = plain[a];
            for (std::size_t side = 0; side < 6; ++side)
                if (random.whole(0, 1)) brick.side[a][side] = beside[a].data();
        }
        for (int pass = 0; pass < 6; ++pass) {
            for (std::size_t a = 0; a < 3; ++a) brick.u[a] = plain[a].data();
            const Fixed step = relax_colour_plain(brick, pass % 2, 1.7);
            for (std::size_t a = 0; a < 3; ++a) brick.u[a] = vectors[a].data();
            ASSERT_EQ(relax_colour_avx2(brick, pass % 2, 1.7), step);
            for (std::size_t a = 0; a < 3; ++a) ASSERT_EQ(vectors[a], plain[a]);
        }
    }
#else
    GTEST_SKIP() << "another processor";
#endif
}

}  // namespace
}  // namespace pliant::test
