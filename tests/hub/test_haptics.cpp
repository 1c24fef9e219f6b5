// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A device of a client over a real connection: permissions, effect on the tissue, states for other
// clients, stops, and an ordinary session.
// Covers: hub/device_*.cpp, hub/haptic_session.cpp, protocol/messages_json.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/volume.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <optional>
#include <thread>

#include "hub/haptic_session.h"
#include "hub/test_client.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

Json vector_of(Vec3d v) {
    return {v.x, v.y, v.z};
}

class HapticsServerTest : public ::testing::Test {
  protected:
    void SetUp() override {
        const auto phantom = make_phantom({.name = "airway", .size = {48, 48, 48}}, m_arena);
        ASSERT_TRUE(phantom.ok());
        const PhantomLandmark& mark = phantom->landmarks.front();
        const Vec3d way = mark.push_point_mm - mark.eye_mm;
        m_wall = RayCaster(phantom->volume, m_arena)
                     .first_hit(mark.eye_mm, way, -500, Polarity::Rising)
                     .value();
        // Ten millimetres into the wall, as a hand would go: a position each millisecond.
        std::ofstream replay(m_folder / "hand.txt");
        for (int k = 0; k < 1500; ++k)
            replay << k * 1'000'000 << " 0 0 " << -std::min(10.0, 0.01 * k) << "\n";
        replay.close();
        auto server =
            Server::start({.phantom_size = {48, 48, 48},
                           .session = m_folder / "felt.pls",
                           .haptic_devices = {"replay:" + (m_folder / "hand.txt").string(),
                                              PLIANT_SLOW_DEVICE ":" + m_awaited.string()}},
                          m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        m_server.emplace(std::move(*server));
    }
    /// 8 mm before the wall, and straight at it.
    Json start(const std::string& device) const {
        return {{"do", "haptics"},
                {"wish", "start"},
                {"device", device},
                {"position", vector_of(m_wall.point_mm + 8.0 * m_wall.normal)},
                {"look", vector_of(-m_wall.normal)},
                {"up", {0.1, 0.2, 0.9}},
                {"radius", 3}};
    }
    static Json news(TestClient& client, const std::function<bool(const Json&)>& holds) {
        return client.until([&](const Json& m) { return m["t"] == "haptics" && holds(m); });
    }
    static double newtons(const Json& news) {
        double sum = 0;
        for (const Json& n : news["force_n"]) sum += double(n) * double(n);
        return std::sqrt(sum);
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
    const std::filesystem::path m_awaited = m_folder / "awaited";  ///< by the slow device
    RayHit m_wall{};
    std::optional<Server> m_server;
};

TEST_F(HapticsServerTest, PushesTheTissueForAllToSeeAndStops) {
    TestClient hand(m_server->port(), m_server->link());
    TestClient other(m_server->port(), m_server->view_link());
    const Json welcome = hand.enter();
    other.enter();
    const auto devices = welcome["haptic_devices"].get<std::vector<std::string>>();
    EXPECT_NE(std::find(devices.begin(), devices.end(), "replay:hand.txt"), devices.end());
    const Json before = hand.checked_checksum();
    EXPECT_EQ(hand.command(start("replay:hand.txt"))["t"], "done");

    const Json felt = news(other, [](const Json& m) {
        return m.value("on", false) && m["contact"] == true && newtons(m) > 0.01 &&
               m["depth_mm"] > 1.0;
    });
    ASSERT_FALSE(felt.is_null());
    EXPECT_EQ(felt["device"], "replay:hand.txt");
    EXPECT_GT(felt["servo"]["rate_hz"], 0);
    // The force is against the way that the hand goes.
    double along = 0;
    for (int a = 0; a < 3; ++a) along += double(felt["force_n"][std::size_t(a)]) * m_wall.normal[a];
    EXPECT_GT(along, 0.5 * newtons(felt));
    const Json deep = news(other, [](const Json& m) { return m["depth_mm"] > 4.5; });
    ASSERT_FALSE(deep.is_null());

    EXPECT_EQ(hand.command({{"do", "haptics"}, {"wish", "stop"}})["t"], "done");
    const Json still = news(hand, [](const Json& m) { return m["stopped"] && newtons(m) == 0; });
    ASSERT_FALSE(still.is_null());
    EXPECT_EQ(hand.command({{"do", "haptics"}, {"wish", "end"}})["t"], "done");
    EXPECT_FALSE(news(other, [](const Json& m) { return m["on"] == false; }).is_null());

    const Json after = hand.checked_checksum();
    EXPECT_NE(after["tissue"], before["tissue"]);
    EXPECT_EQ(other.checked_checksum()["voxels"], after["voxels"]);
    // One contact is one step.
    EXPECT_EQ(hand.state["undo"]["steps"], 1);
    EXPECT_EQ(hand.state["undo"]["next"], "slide");
    EXPECT_EQ(hand.command({{"do", "undo"}})["t"], "done");
    EXPECT_EQ(hand.checked_checksum()["tissue"], before["tissue"]);

    m_server.reset();
    const auto again = replay_session(m_folder / "felt.pls", m_arena);
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_GT(again->commands, 20);
    EXPECT_GT(again->marks, 2);
}

/// A hand that goes straight ahead: still at first, then by steps of 0.25 mm. @returns its device
std::string write_hand(const std::filesystem::path& file, int steps) {
    constexpr int kStill_ms = 100, kStep_ms = 25;
    constexpr double kStep_mm = 0.25;
    std::ofstream replay(file);
    for (int k = 0; k < kStill_ms + steps * kStep_ms; ++k)
        replay << k * 1'000'000 << " 0 0 " << -kStep_mm * std::max(0, (k - kStill_ms) / kStep_ms)
               << "\n";
    return "replay:" + file.string();
}

TEST(HapticSession, ItsToolIsNeverInTissueOfThickSlices) {
    using namespace serve;
    constexpr std::uint32_t kClient = 1, kTool = 2;
    constexpr double kRadius_mm = 2.5, kAhead_mm = 3;
    const TaskArena arena(2);
    TemporaryFolder folder;
    const auto phantom = make_phantom(
        {.name = "airway", .size = {112, 112, 22}, .spacing_mm = {0.8, 0.8, 5}}, arena);
    ASSERT_TRUE(phantom.ok());
    ASSERT_TRUE(write_volume(folder / "thick.nrrd", phantom->volume).ok());
    auto scene = Scene::open({.file = (folder / "thick.nrrd").string()}, arena);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    // 40 steps at a wall, from 3 mm before it.
    const Vec3d look{1, 0, 0};
    const auto wall =
        RayCaster(phantom->volume, arena).first_hit({0, -1.6, 35}, look, -500, Polarity::Rising);
    ASSERT_TRUE(wall);
    const HapticDevices devices({write_hand(folder / "hand.txt", 40)});
    auto opened = devices.open("replay:hand.txt");
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    auto started =
        HapticSession::start({.wish = HapticWish::Start,
                              .device = "replay:hand.txt",
                              .position_mm = wall->point_mm - (kRadius_mm + kAhead_mm) * look,
                              .look = look,
                              .up = {0, 0, 1},
                              .radius_mm = kRadius_mm},
                             std::move(*opened), **scene, kClient, kTool);
    ASSERT_TRUE(started.ok()) << started.error().message;
    HapticSession& session = **started;
    const Volume& shown = (*scene)->deformed();
    int pushes = 0, free_looks = 0;
    double farthest_mm = 0;  // of the tissue's tool beyond the wall at rest
    const auto begin = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(1300)) {
        if (const auto action = session.next_push(**scene)) {
            const Outcome outcome = (*scene)->carry_out(kTool, *action);
            session.pushed(outcome);
            const auto update = (*scene)->update();
            ASSERT_TRUE(update.ok());
            session.changed(update->boxes);
            if (outcome.end_mm) {
                ++pushes;
                const Vec3d end = *outcome.end_mm;
                ASSERT_LT(sample_linear(shown, voxel_from_world(shown.grid, end)), -500)
                    << "push " << pushes;
                farthest_mm = std::max(farthest_mm, dot(end - wall->point_mm, look));
            }
        }
        const ToolPose pose = session.pose_of_tool();
        if (pose.kind == ToolKind::Sphere && !(*scene)->has_contact(kTool)) {
            const auto [x, y, z] = pose.position_mm;  // free: where the hand is
            ASSERT_LT(sample_linear(shown, voxel_from_world(shown.grid, {x, y, z})), -500);
            ++free_looks;
        }
        session.feel(**scene);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    EXPECT_GT(free_looks, 0);
    EXPECT_GT(pushes, 3);
    EXPECT_NE(hash_volume(shown), hash_volume(phantom->volume));
    EXPECT_GT(farthest_mm, 0);
}

TEST_F(HapticsServerTest, IsForThoseWhoControlAndEndsWithTheirConnection) {
    TestClient viewer(m_server->port(), m_server->view_link());
    viewer.enter();
    EXPECT_EQ(viewer.command(start("virtual:spring"))["code"], "view_only");
    TestClient other(m_server->port(), m_server->link());
    other.enter();
    EXPECT_EQ(other.command({{"do", "haptics"}, {"wish", "stop"}})["code"], "nothing");
    {
        TestClient hand(m_server->port(), m_server->link());
        hand.enter();
        // A file is for the command line to name.
        const Json file = hand.command(start("/usr/lib/libmaker.so"));
        EXPECT_EQ(file["t"], "error");
        EXPECT_NE(file["message"].get<std::string>().find("device: expected virtual:tap, "),
                  std::string::npos);
        EXPECT_EQ(hand.command(start("virtual:tap"))["t"], "done");
        ASSERT_FALSE(news(viewer, [](const Json& m) { return m["on"] == true; }).is_null());
        EXPECT_EQ(other.command(start("virtual:tap"))["code"], "held_by_other");
        // Every client with control may stop it, but only its owner may resume.
        EXPECT_EQ(other.command({{"do", "haptics"}, {"wish", "stop"}})["t"], "done");
        EXPECT_EQ(other.command({{"do", "haptics"}, {"wish", "go"}})["code"], "held_by_other");
    }
    const Json gone = news(viewer, [](const Json& m) { return m["on"] == false; });
    ASSERT_FALSE(gone.is_null());
    EXPECT_NE(gone["why"].get<std::string>().find("is gone"), std::string::npos);
}

TEST_F(HapticsServerTest, ABrowsersOwnDeviceIsWhereItSays) {
    TestClient hand(m_server->port(), m_server->link());
    hand.enter();
    EXPECT_EQ(hand.command(start("browser"))["t"], "done");
    ASSERT_FALSE(news(hand, [](const Json& m) { return m["on"] && m["lost"]; }).is_null());
    hand.say({{"do", "haptic_pose"}, {"position", {0, 0, -4}}});
    const Vec3d expected = m_wall.point_mm + 4.0 * m_wall.normal;
    const Json there = news(hand, [&](const Json& m) {
        return m["on"] && !m["lost"] && std::abs(double(m["place_mm"][0]) - expected.x) < 0.05 &&
               std::abs(double(m["place_mm"][1]) - expected.y) < 0.05 &&
               std::abs(double(m["place_mm"][2]) - expected.z) < 0.05;
    });
    ASSERT_FALSE(there.is_null());
    // Without messages the device is lost, and has no force.
    const Json lost = news(hand, [](const Json& m) { return m["lost"] == true; });
    ASSERT_FALSE(lost.is_null());
    EXPECT_EQ(newtons(lost), 0);
}

TEST_F(HapticsServerTest, ASlowDeviceIsOpenedWhileTheSceneGoesOn) {
    const std::string slow = "libslow_haptic_device.so:awaited";
    TestClient hand(m_server->port(), m_server->link());
    const Json welcome = hand.enter();
    const auto devices = welcome["haptic_devices"].get<std::vector<std::string>>();
    ASSERT_NE(std::find(devices.begin(), devices.end(), slow), devices.end()) << welcome.dump();
    constexpr std::uint32_t kAsked = 4000;
    Json question = start(slow);
    question["id"] = kAsked;
    hand.say(question);
    // It waits for the file, and the scene doesn't wait for it.
    EXPECT_EQ(hand.command({{"do", "iso"}, {"iso_hu", -400}})["t"], "done");
    EXPECT_EQ(hand.command(start("virtual:tap"))["code"], "busy");
    std::ofstream(m_awaited) << "now\n";
    EXPECT_EQ(hand.answer(kAsked)["t"], "done");
    ASSERT_FALSE(
        news(hand, [&](const Json& m) { return m["on"] && m["device"] == slow; }).is_null());
    // Another one in its place: this one is closed before.
    EXPECT_EQ(hand.command(start("virtual:tap"))["t"], "done");

    // A disconnected client gets none, and another client may then have one.
    std::filesystem::remove(m_awaited);
    {
        TestClient other(m_server->port(), m_server->link());
        other.enter();
        EXPECT_EQ(hand.command({{"do", "haptics"}, {"wish", "end"}})["t"], "done");
        other.say(start(slow));
        EXPECT_EQ(other.command({{"do", "iso"}, {"iso_hu", -500}})["t"], "done");
    }
    std::ofstream(m_awaited) << "now\n";
    Json answer;
    for (int n = 0; n < 500; ++n) {  // until the server has seen that it is gone
        answer = hand.command(start("virtual:tap"));
        if (answer["t"] == "done") break;
        EXPECT_EQ(answer["code"], "busy");
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(answer["t"], "done");
    EXPECT_FALSE(news(hand, [](const Json& m) {
                     return m["on"] && m["device"] == "virtual:tap";
                 }).is_null());
}

}  // namespace
}  // namespace pliant::test
