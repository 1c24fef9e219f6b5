// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A device that holds the catheter of a served vessel: insertion and rotation, forces, the state
// for other clients, and a replay.
// Covers: hub/haptic_session.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/serve.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <thread>

#include "hub/haptic_session.h"
#include "hub/test_client.h"
#include "support/temporary_folder.h"

namespace pliant::serve {
namespace {

using test::Json;
using test::TestClient;

/// A stiff wire in a soft bend, which it soon pushes.
const char* kBend =
    "[vessel]\nphantom = \"bend\"\nthickness_mm = 1.5\nlayers = 1\n"
    "[wall]\nsupport_pa_per_mm = 2000\ndensity_g_mm3 = 0.05\n"
    "[catheter]\nlength_mm = 150\nbend_n_mm2 = 200\ntip_bend_n_mm2 = 100\n"
    "[entry]\nplace_mm = [0, 0, 45]\ndirection = [0, 0, 1]\ninserted_mm = 27\n"
    "[simulation]\ntime_step_s = 0.004\n";

class HapticCatheter : public ::testing::Test {
  protected:
    void SetUp() override {
        // It waits until it surely holds the wire; then 12 mm ahead in a second, turned by a
        // quarter; and it stays there.
        std::ofstream replay(m_folder.path() / "hand.txt");
        constexpr int kWaits = 2000;
        for (int k = -kWaits; k <= 1000; ++k) {
            const double way = 1e-3 * std::max(k, 0);
            replay << (k + kWaits) * 1'000'000LL << " 0 0 " << -12 * way << ' ' << 1.5708 * way
                   << "\n";
        }
        replay.close();
        const auto scene = m_folder.write("bend.toml", kBend);
        auto server =
            Server::start({.file = scene.string(),
                           .session = m_session,
                           .haptic_devices = {"replay:" + (m_folder.path() / "hand.txt").string()}},
                          m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        m_server.emplace(std::move(*server));
    }
    static Json start(const std::string& device) {
        return {{"do", "haptics"},       {"wish", "start"},   {"device", device},
                {"position", {0, 0, 0}}, {"look", {0, 1, 0}}, {"up", {0, 0, 1}}};
    }
    /// A simulation takes its time where others use the machine as well.
    static Json patiently(TestClient& client, const std::function<bool(const Json&)>& holds) {
        Json found;
        for (int n = 0; n < 4 && found.is_null(); ++n) found = client.until(holds);
        return found;
    }
    static Json news(TestClient& client, const std::function<bool(const Json&)>& holds) {
        return patiently(client, [&](const Json& m) { return m["t"] == "haptics" && holds(m); });
    }
    static Json state(TestClient& client, const std::function<bool(const Json&)>& holds) {
        return patiently(client, [&](const Json& m) { return m["t"] == "state" && holds(m); });
    }

    const TaskArena m_arena{2};
    test::TemporaryFolder m_folder;
    const std::filesystem::path m_session = m_folder.path() / "held.pls";
    std::optional<Server> m_server;
};

TEST_F(HapticCatheter, IsInsertedTurnedFeltAndPlayedAgain) {
    TestClient hand(m_server->port(), m_server->link());
    hand.enter();
    EXPECT_EQ(hand.command(start("replay:hand.txt"))["t"], "done");
    {
        // Viewers are informed too.
        TestClient other(m_server->port(), m_server->view_link());
        other.enter();
        EXPECT_EQ(other.command(start("replay:hand.txt"))["code"], "view_only");
        EXPECT_FALSE(news(other, [](const Json& m) {
                         return m.value("holds", "") == "catheter";
                     }).is_null());
    }
    // It comes to where the coupling holds its force.
    Json last;
    const Json rest = state(hand, [&](const Json& m) {
        const Json& v = m["vessel"];
        last = m;
        return v["inserted_mm"] > 27 + 9 && v["rotated_deg"] > 89.8 && v["insert_mm_s"] == 0 &&
               v["rotate_deg_s"] == 0 && m["settled"] == true;
    });
    ASSERT_FALSE(rest.is_null()) << last.dump();
    const double force_n = rest["vessel"]["force_n"];
    EXPECT_GT(force_n, 0.005);
    EXPECT_LT(rest["vessel"]["inserted_mm"], 27 + 12);
    EXPECT_NEAR(rest["vessel"]["rotated_deg"], 90, 0.2);
    // The hand feels the force at the wire's base, against the way in: the vessel begins along z.
    const Json felt = news(hand, [&](const Json& m) {
        return m["on"] && std::abs(double(m["force_n"][2]) + force_n) < 0.002 + 0.02 * force_n;
    });
    ASSERT_FALSE(felt.is_null()) << force_n;
    EXPECT_NEAR(felt["force_n"][0], 0, 1e-6);
    EXPECT_NEAR(felt["force_n"][1], 0, 1e-6);
    EXPECT_NEAR(felt["depth_mm"], 27 + 12 - double(rest["vessel"]["inserted_mm"]), 0.1);
    EXPECT_LE(felt["force_n"][2], 0);

    EXPECT_EQ(hand.command({{"do", "haptics"}, {"wish", "stop"}})["t"], "done");
    ASSERT_FALSE(news(hand, [](const Json& m) {
                     return m["stopped"] == true && m["force_n"] == Json{0, 0, 0};
                 }).is_null());
    EXPECT_EQ(hand.command({{"do", "haptics"}, {"wish", "end"}})["t"], "done");
    const Json sums = hand.checked_checksum();
    m_server.reset();
    const auto again = replay_session(m_session, m_arena);
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_GT(again->commands, 10);
    EXPECT_GT(again->marks, 0);  // which are compared
}

TEST_F(HapticCatheter, EndsWithItsBrowserAndWithTheVessel) {
    TestClient other(m_server->port(), m_server->link());
    other.enter();
    {
        TestClient hand(m_server->port(), m_server->link());
        hand.enter();
        EXPECT_EQ(hand.command(start("browser"))["t"], "done");
        // Pushed on and on: without a hand it must stop.
        bool moves = false;
        for (int n = 1; n <= 500 && !moves; ++n) {
            hand.say({{"do", "haptic_pose"}, {"position", {0, 0, -0.5 * n}}, {"roll_deg", 6 * n}});
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            hand.say({{"do", "ping"}, {"id", 6}});
            ASSERT_FALSE(hand.until("pong").is_null());
            const Json& wire = hand.state["vessel"];
            moves = wire["insert_mm_s"] > 0 && wire["rotate_deg_s"] > 0;
        }
        EXPECT_TRUE(moves);
    }
    const Json gone = news(other, [](const Json& m) { return m["on"] == false && m["why"] != ""; });
    ASSERT_FALSE(gone.is_null());
    EXPECT_NE(gone["why"].get<std::string>().find("is gone"), std::string::npos);
    ASSERT_FALSE(state(other, [](const Json& m) {
                     return m["vessel"]["insert_mm_s"] == 0 && m["vessel"]["rotate_deg_s"] == 0;
                 }).is_null());
    EXPECT_EQ(other.command(start("virtual:tap"))["t"], "done");
    EXPECT_EQ(other.command({{"do", "tissue"}, {"model", "chainmail"}})["t"], "done");
    const Json ended = news(other, [](const Json& m) { return m["on"] == false; });
    ASSERT_FALSE(ended.is_null());
    EXPECT_NE(ended["why"].get<std::string>().find("another one"), std::string::npos);
}

/// The scene alone, so that each step is known.
TEST(CatheterGrip, LetsGoWhileTheButtonIsHeldAndHoldsAnewAfterAReset) {
    const test::TemporaryFolder folder;
    const TaskArena arena(2);
    auto opened = Scene::open({.file = folder.write("bend.toml", kBend).string()}, arena);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    Scene& scene = **opened;
    constexpr std::uint32_t kTool = 7;
    auto grip = CatheterGrip::create(*scene.tissue().drivable(), kTool, 1);
    ASSERT_TRUE(grip.ok());
    HapticRecord now;
    const auto go = [&](double ahead_mm, std::uint32_t buttons, int steps, bool stopped = false) {
        for (int n = 0; n < steps; ++n) {
            now.position_mm = {0, 0, 45 + ahead_mm};
            now.buttons = buttons;
            const auto action = grip->next(now, stopped, scene);
            EXPECT_TRUE(!action || scene.carry_out(kTool, *action).ok());
            for (int k = 0; k < 2 && scene.wants_sweep(); ++k) (void)scene.sweep();
        }
        return scene.tissue().drivable()->measures().inserted_mm;
    };
    go(0, 0, 2);
    EXPECT_NEAR(go(6, 0, 60), 27 + 6, 1);
    const double there = scene.tissue().drivable()->measures().inserted_mm;
    EXPECT_EQ(go(0, 1, 3), there);  // reaches back
    EXPECT_FALSE(scene.has_contact(kTool));
    EXPECT_FALSE(grip->model(now, *scene.tissue().drivable())->held);
    go(0, 0, 2);
    EXPECT_NEAR(go(6, 0, 60), there + 6, 1.5);
    const double stands = scene.tissue().drivable()->measures().inserted_mm;
    EXPECT_EQ(go(20, 0, 3, true), stands);
    EXPECT_FALSE(scene.has_contact(kTool));
    EXPECT_TRUE(scene.carry_out(1, ResetCommand{}).ok());
    EXPECT_NEAR(go(20, 0, 30), 27, 0.5);  // not 20 mm at once
    // No number of the device that isn't known turns it.
    EXPECT_EQ(scene.tissue().drivable()->measures().rotated_deg, 0);
}

}  // namespace
}  // namespace pliant::serve
