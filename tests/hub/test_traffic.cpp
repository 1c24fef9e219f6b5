// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The depth that a line takes, on simulated lines: a server that ticks, updates whose bytes are a
// function of the depth, a queue with a rate and a delay, and a client that acknowledges.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "hub/traffic.h"
#include "support/random.h"

namespace pliant::serve {
namespace {

using test::Random;
using Bytes = std::function<double(int depth)>;

class Simulation {
  public:
    Simulation(Bytes bytes, double bytes_per_s, std::uint64_t seed)
        : rate(bytes_per_s), m_bytes(std::move(bytes)), m_random(seed) {}

    /// Lets time pass, as the hub does with a tissue that has time for any depth.
    void run(double seconds) {
        const double end = m_now + seconds;
        for (; m_now < end; m_now += 1 / server_hz) {
            while (!m_acks.empty() && m_acks.front().at <= m_now) {
                m_line.seen(m_acks.front().step, clock());
                m_acks.pop_front();
            }
            m_line.due(m_acks.size() < 3);
            if (m_acks.size() < 3) send();
            if (m_now < m_next_window) continue;
            m_next_window = m_now + 0.5;
            if (const auto sample = m_line.take(depth, clock())) {
                samples.push_back(*sample);
                m_traffic.take(*sample, wanted_hz);
            }
            const int most = std::max(depth, std::min(depth + 1, kMostLayers));
            const int next = std::max(std::min(most, m_traffic.limit()), kFewestLayers);
            changes += next != depth;
            falls += next < depth;
            depth = next;
            depths.push_back(depth);
        }
    }
    /// Deepest layers of which the line takes updates at a share of the wanted rate; 0: none.
    int best(double share = 1) const {
        int deepest = 0;
        for (int d = kFewestLayers; d <= kMostLayers; ++d)
            if (m_bytes(d) * wanted_hz * share <= rate) deepest = d;
        return deepest;
    }

    double rate;          ///< bytes per second
    double delay_s = 0;   ///< there and back
    double noise = 0.05;  ///< of the bytes
    double server_hz = 60, wanted_hz = 25;
    int depth = 10;
    int changes = 0, falls = 0;
    std::vector<int> depths;  ///< each half second
    std::vector<LineSample> samples;

  private:
    struct Ack {
        double at;
        std::uint32_t step;
    };
    Line::Clock::time_point clock() const {
        return Line::Clock::time_point(std::chrono::duration_cast<Line::Clock::duration>(
            std::chrono::duration<double>(1 + m_now)));
    }
    void send() {
        const double bytes = m_bytes(depth) * m_random.real(1 - noise, 1 + noise);
        m_line.sent(std::size_t(bytes), true, clock());
        m_line.ended_update(++m_step, depth);
        m_idle_at = std::max(m_idle_at, m_now) + bytes / rate;
        m_acks.push_back({m_idle_at + delay_s, m_step});
    }

    Bytes m_bytes;
    Random m_random;
    Line m_line;
    Traffic m_traffic;
    double m_now = 0, m_next_window = 0.5, m_idle_at = 0;
    std::uint32_t m_step = 0;
    std::deque<Ack> m_acks;
};

/// Bytes that rise with the depth: by the cube, evenly, or up to the end of a lattice.
Bytes random_bytes(Random& random) {
    const double scale = random.ratio(1e4, 1e6), least = random.real(0.02, 0.3);
    const double reach = random.real(3, 15);
    switch (random.whole(0, 2)) {
        case 0:
            return [=](int d) { return scale * (least + std::pow(d / 20.0, 3)); };
        case 1:
            return [=](int d) { return scale * (least + d / 20.0); };
        default:
            return [=](int d) { return scale * (least + 1 - std::exp(-d * d / (reach * reach))); };
    }
}

TEST(Traffic, EndsAtTheDeepestLayersThatMeetTheRate) {
    const std::uint64_t seed = 20261126;
    Random random(seed);
    for (int round = 0; round < 300; ++round) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
        const Bytes bytes = random_bytes(random);
        const int wanted = random.whole(3, 19);
        Simulation s(bytes, 25 * bytes(wanted) * random.real(1.001, 1.1), random.next());
        s.depth = random.whole(0, 1) ? 20 : 10;
        s.delay_s = random.real(0, 0.03);
        s.run(20);
        const int before = s.falls;
        s.run(40);
        // A hysteresis of 15 %, the noise of the bytes, and one layer.
        EXPECT_GE(s.depth, s.best(1.3) - 1);
        EXPECT_LE(s.depth, s.best(0.8));
        EXPECT_LE(s.falls - before, 4);
    }
}

TEST(Traffic, AFastLineHasNoEffect) {
    const std::uint64_t seed = 4;
    Random random(seed);
    for (int round = 0; round < 50; ++round) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
        const Bytes bytes = random_bytes(random);
        Simulation s(bytes, random.ratio(70, 1e4) * bytes(20), random.next());
        s.server_hz = random.whole(0, 1) ? 60 : 20;  // less than wanted: not by the line
        s.run(60);
        EXPECT_EQ(s.depth, 20);
        EXPECT_EQ(s.changes, 10);
        EXPECT_GT(s.samples.size(), 20U);
    }
}

TEST(Traffic, DoesntOscillate) {
    const std::uint64_t seed = 5;
    Random random(seed);
    for (int round = 0; round < 100; ++round) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
        const Bytes bytes = random_bytes(random);
        Simulation s(bytes, 25 * bytes(random.whole(1, 20)) * random.real(0.8, 1.2), random.next());
        s.server_hz = random.whole(0, 1) ? 60 : random.real(22, 30);
        s.delay_s = random.real(0, 0.05);
        s.run(120);
        const int before = s.falls;
        s.run(480);
        // A depth that has failed is tried again after pauses that double.
        EXPECT_LE(s.falls - before, 8);
    }
}

TEST(Traffic, ADepthThatSavesNothingIsKept) {
    const std::uint64_t seed = 6;
    Random random(seed);
    for (int round = 0; round < 100; ++round) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
        const double bytes = random.ratio(1e4, 1e6);
        Simulation s([=](int) { return bytes; }, bytes * random.real(3, 20), random.next());
        s.noise = 0.02;
        s.depth = 20;
        s.run(300);
        EXPECT_EQ(s.depth, 20);
        // It is tried once.
        const auto low =
            std::count_if(s.depths.begin(), s.depths.end(), [](int d) { return d < 20; });
        EXPECT_LE(low, 40);
        EXPECT_TRUE(
            std::all_of(s.depths.begin() + 100, s.depths.end(), [](int d) { return d == 20; }));
    }
}

TEST(Traffic, ALineThatMeetsTheRateAtNoDepthKeepsTheLayersThatCostNothing) {
    // Half the bytes are those of the tool itself; up to 6 layers cost little more.
    const Bytes bytes = [](int d) { return d <= 6 ? 1e5 : 1e5 + 2e4 * (d - 6); };
    Simulation s(bytes, 1e6, 7);
    s.noise = 0.01;
    s.run(60);
    EXPECT_GE(s.depth, 5);
    EXPECT_LE(s.depth, 7);
}

TEST(Traffic, RisesAgainWhenTheLineIsFree) {
    const std::uint64_t seed = 8;
    Random random(seed);
    for (int round = 0; round < 100; ++round) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
        const Bytes bytes = random_bytes(random);
        const double slow = 25 * bytes(random.whole(3, 8));
        Simulation s(bytes, slow, random.next());
        s.run(random.real(20, 200));
        EXPECT_LE(s.depth, s.best(0.8));
        s.rate = 100 * bytes(20);
        s.run(30);
        EXPECT_EQ(s.depth, 20);
        s.rate = slow;
        s.run(30);
        EXPECT_LE(s.depth, s.best(0.8));
    }
}

TEST(Traffic, ALongWayIsNoReasonForFewerLayers) {
    // Three updates are under way at once, so a delay of 0.4 s allows at most 7.5 of them a second.
    Simulation s([](int d) { return 1e4 * (1 + d); }, 1e8, 9);
    s.delay_s = 0.4;
    s.depth = 20;
    s.run(300);
    const auto low = std::count_if(s.depths.begin(), s.depths.end(), [](int d) { return d < 20; });
    EXPECT_EQ(s.depth, 20);
    EXPECT_LE(low, 100) << "of " << s.depths.size();
}

TEST(Traffic, TheMeasuredRateIsThatOfABusyLine) {
    for (const double rate : {2e5, 1e6, 4e6}) {
        Simulation s([](int) { return 1e5; }, rate, 10);
        s.noise = 0.2;
        s.delay_s = 0.02;
        s.run(60);
        ASSERT_GT(s.samples.size(), 3U);
        for (const LineSample& sample : s.samples) {
            EXPECT_NEAR(sample.bytes_per_s / rate, 1, 0.25);
            EXPECT_NEAR(sample.update_bytes, 1e5, 2e4);
            EXPECT_GT(sample.blocked, 0.2);
        }
    }
}

TEST(Traffic, UpdatesOfAnotherDepthDontCount) {
    Line line;
    const Line::Clock::time_point start{};
    const auto at = [&](int ms) { return start + std::chrono::milliseconds(1000 + ms); };
    EXPECT_FALSE(line.take(5, at(0)));
    for (int n = 0; n < 20; ++n) {
        line.sent(1000, true, at(10 * n));
        line.ended_update(std::uint32_t(n), n < 10 ? 4 : 5);
        line.seen(std::uint32_t(n), at(10 * n + 5));
        line.seen(7777, at(10 * n + 6));  // of another scan
    }
    const auto sample = line.take(5, at(300));
    ASSERT_TRUE(sample);
    EXPECT_EQ(sample->update_bytes, 1000);
    EXPECT_NEAR(sample->bytes_per_s, 200e3, 1);
    EXPECT_FALSE(line.take(5, at(400)));
}

}  // namespace
}  // namespace pliant::serve
