// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The order in which commands of several clients are carried out.
// Covers: hub/hub.cpp.

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "hub/hub.h"
#include "hub/random_session.h"
#include "support/temporary_folder.h"

namespace pliant::serve {
namespace {

/// A network without readers.
class Nobody : public Outlet {
  public:
    void send(ConnectionId, std::vector<Outgoing>) override {}
    void close(ConnectionId, int, const std::string&) override {}
    void taken(ConnectionId) override {}
};

TEST(Fairness, QuickCommandsDoNotWaitForAnotherClientsSlowOnes) {
    constexpr int kEach = 20;
    const test::TemporaryFolder folder;
    const auto session = folder.path() / "s.pls";
    const TaskArena arena(1);
    auto scene = Scene::open(kCube, arena).value();
    auto log = SessionLog::create(session, {kCube, scene->scan_hash()}).value();
    {
        Hub hub(std::move(scene), std::move(log), 200);
        for (const ConnectionId connection : {1U, 2U}) {
            hub.post({connection, Event::Opened{true}});
            hub.post({connection, Message{0, HelloMessage{.protocol = kProtocolVersion}}});
        }
        // Everything is there before the first step.
        for (std::uint32_t n = 1; n <= kEach; ++n) {
            const double way = n % 2 ? 2 : -2;
            hub.post({1, Message{n, PushCommand{.push = {{0, 0, 0}, {0, way, 0}, 6}}}});
        }
        for (std::uint32_t n = 1; n <= kEach; ++n)
            hub.post({2, Message{n, IsoCommand{.iso_hu = double(n)}}});
        Nobody nobody;
        std::jthread owner([&](const std::stop_token& stop) { hub.run(stop, nobody); });
        for (int n = 0; n < 400 && hub.ticks() < 40; ++n)
            std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    const auto file = read_session(session);
    ASSERT_TRUE(file.ok()) << file.error().message;
    int slow = 0, quick = 0, slow_before_last_quick = 0;
    for (const SessionRecord& record : file->records) {
        const auto* command = std::get_if<SessionCommand>(&record);
        if (!command) continue;
        if (std::holds_alternative<PushCommand>(command->action)) ++slow;
        if (!std::holds_alternative<IsoCommand>(command->action)) continue;
        ++quick;
        slow_before_last_quick = slow;
    }
    EXPECT_EQ(slow, kEach);
    EXPECT_EQ(quick, kEach);
    EXPECT_LE(slow_before_last_quick, kEach / 4);
}

}  // namespace
}  // namespace pliant::serve
