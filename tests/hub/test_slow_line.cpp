// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A client that acknowledges voxels no faster than a slow line would bring them.
// Covers: hub/publisher.cpp.

#include <gtest/gtest.h>
#include <pliant/serve.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "hub/test_client.h"

namespace pliant::test {
namespace {

constexpr int kDepth = 10;

/// Pushes springs to and fro, over a line of 0.2 MB/s, until a line has lowered the depth.
/// @param[out] deepest  of all depths
/// @returns the last state of the tissue
Json push_over_slow_line(int network_hz, int pushes, int& deepest) {
    const TaskArena arena{2};
    auto server = Server::start({.phantom_size = {64, 64, 64}, .network_hz = network_hz}, arena);
    if (!server.ok()) return {};
    TestClient a(server->port(), server->link());
    a.enter();
    const Json springs = {{"do", "tissue"}, {"model", "springs"}, {"nodes", 14},
                          {"cell_mm", 4},   {"fixed_hu", 3000},   {"depth", kDepth}};
    EXPECT_EQ(a.command(springs)["t"], "done");
    EXPECT_EQ(a.command({{"do", "depth"}, {"by_time", true}})["t"], "done");
    a.sends_seen = false;
    std::int64_t bytes = a.box_bytes;
    for (int n = 0; n < pushes; ++n) {
        const int depth = a.state["tissue"].value("depth", 0);
        deepest = std::max(deepest, depth);
        if (a.state["tissue"].contains("line_mb_s") && depth < deepest) break;
        const double way = n % 2 ? -1 : 1;
        a.say({{"do", "push"},
               {"id", 2 * n + 1000},
               {"point", {0, n % 2 ? 3 : 2, 0}},
               {"push", {0, way, 0}},
               {"radius", 6}});
        a.say({{"do", "ping"}, {"id", 2 * n + 1001}});
        if (a.until("pong").is_null()) break;
        std::this_thread::sleep_for(
            std::chrono::duration<double>(double(a.box_bytes - bytes) / 0.2e6));
        bytes = a.box_bytes;
        a.say({{"do", "seen"}, {"step", a.step}});
    }
    return a.state["tissue"];
}

TEST(SlowLine, LowersAnAutomaticDepth) {
    int deepest = 0;
    const Json tissue = push_over_slow_line(25, 2000, deepest);
    ASSERT_TRUE(tissue.contains("line_mb_s")) << tissue;
    EXPECT_GT(tissue["line_mb_s"], 0);
    EXPECT_LT(tissue["line_mb_s"], 2);
    EXPECT_LT(tissue["depth"], deepest);
    EXPECT_EQ(tissue["depth_by_time"], true);
}

TEST(SlowLine, HasNoEffectWithoutAWantedRate) {
    int deepest = 0;
    const Json tissue = push_over_slow_line(0, 40, deepest);
    ASSERT_TRUE(tissue.contains("depth")) << tissue;
    EXPECT_FALSE(tissue.contains("line_mb_s"));
}

}  // namespace
}  // namespace pliant::test
