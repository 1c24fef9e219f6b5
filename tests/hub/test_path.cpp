// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Ways through the lumen, asked for over a real connection.
// Covers: hub/path_*.cpp.

#include <gtest/gtest.h>
#include <pliant/render.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/volume.h>

#include <algorithm>
#include <optional>

#include "hub/test_client.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

class PathServerTest : public ::testing::Test {
  protected:
    void SetUp() override {
        auto phantom = make_phantom({.name = "airway", .size = {64, 64, 64}}, m_arena);
        ASSERT_TRUE(phantom.ok());
        m_scan = std::move(phantom->volume);
        ASSERT_TRUE(write_volume(m_folder / "airway.nrrd", m_scan).ok());
        auto server = Server::start({.file = (m_folder / "airway.nrrd").string()}, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        m_server.emplace(std::move(*server));
    }
    static Json question(int id, Vec3d from, Vec3d to) {
        return {{"do", "path"},
                {"id", id},
                {"from", {from.x, from.y, from.z}},
                {"to", {to.x, to.y, to.z}}};
    }
    static Json answer(TestClient& client, int id) {
        return client.until([id](const Json& m) {
            return m.value("id", 0) == id && (m["t"] == "path" || m["t"] == "error");
        });
    }

    const Vec3d kTrachea{0.3, -1.8, 38}, kLeft{22, 1, -20};
    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
    Volume m_scan;
    std::optional<Server> m_server;
};

TEST_F(PathServerTest, AreWhatTheLibraryFindsForAnyRole) {
    TestClient viewer(m_server->port(), m_server->view_link());
    const Json welcome = viewer.enter();
    EXPECT_EQ(welcome["role"], "view");
    const auto features = welcome["features"].get<std::vector<std::string>>();
    EXPECT_NE(std::find(features.begin(), features.end(), "path"), features.end());
    viewer.say(question(7, kTrachea, kLeft));
    const Json found = answer(viewer, 7);
    ASSERT_EQ(found["t"], "path") << found;
    EXPECT_EQ(found["volume"], welcome["volume"]["id"]);
    LumenPathSettings settings;
    settings.reach_mm = 5;
    settings.iso_hu = welcome["state"]["iso_hu"];
    const auto own = find_lumen_path(m_scan, kTrachea, kLeft, settings, m_arena);
    ASSERT_TRUE(own.ok());
    ASSERT_EQ(found["points"].size(), own->points_mm.size());
    ASSERT_EQ(found["radii"].size(), own->points_mm.size());
    for (std::size_t n = 0; n < own->points_mm.size(); ++n) {
        for (int a = 0; a < 3; ++a)
            EXPECT_NEAR(found["points"][n][std::size_t(a)], own->points_mm[n][a], 6e-4);
        EXPECT_NEAR(found["radii"][n], own->radius_mm[n], 6e-4);
    }
    EXPECT_NEAR(found["length_mm"], own->length_mm, 6e-4);
}

TEST_F(PathServerTest, FollowTheDeformedVolume) {
    TestClient a(m_server->port(), m_server->link());
    a.enter();
    a.say(question(900, kTrachea, kLeft));
    const Json before = answer(a, 900);
    ASSERT_EQ(before["t"], "path") << before;
    // A wall comes in from the side, so the middle of the rest is elsewhere.
    const Json pushed =
        a.command({{"do", "push"}, {"point", {-9, -5, 16}}, {"push", {6, 0, 0}}, {"radius", 5}});
    ASSERT_EQ(pushed["t"], "done") << pushed;
    ASSERT_GT(pushed["moved_elements"], 0) << pushed;
    a.checked_checksum();
    a.say(question(901, kTrachea, kLeft));
    const Json after = answer(a, 901);
    ASSERT_EQ(after["t"], "path") << after;
    EXPECT_GT(after["step"], before["step"]);
    EXPECT_NE(after["points"], before["points"]);
}

TEST_F(PathServerTest, ThatAreNotThereSayWhy) {
    TestClient a(m_server->port(), m_server->link());
    a.enter();
    Json wall = question(1, kTrachea, {40, 40, 40});
    wall["reach"] = 0;
    a.say(wall);
    const Json tissue = answer(a, 1);
    EXPECT_EQ(tissue["code"], "out_of_range");
    EXPECT_NE(
        tissue["message"].get<std::string>().find("path: to: expected a position in the lumen"),
        std::string::npos)
        << tissue;
    a.say(question(2, {1e4, 0, 0}, kLeft));
    EXPECT_EQ(answer(a, 2)["code"], "out_of_range");
    Json closed = question(3, kTrachea, kLeft);
    closed["iso_hu"] = -1001;
    a.say(closed);
    EXPECT_EQ(answer(a, 3)["t"], "error");
    closed["reach"] = 51;
    a.say(closed);
    EXPECT_EQ(answer(a, 3)["code"], "out_of_range");
}

TEST_F(PathServerTest, AreLookedForOneAtATimeAndEndWithTheirClient) {
    TestClient a(m_server->port(), m_server->link());
    a.enter();
    int found = 0, busy = 0;
    for (int n = 1; n <= 20; ++n) a.say(question(n, kTrachea, kLeft));
    for (int n = 1; n <= 20; ++n) {
        const Json said = a.until([](const Json& m) {
            return m.value("id", 0) > 0 && (m["t"] == "path" || m["t"] == "error");
        });
        ASSERT_FALSE(said.is_null());
        found += said["t"] == "path";
        busy += said.value("code", "") == "busy";
    }
    EXPECT_EQ(found + busy, 20);
    EXPECT_GE(found, 1);
    EXPECT_GE(busy, 1);
    for (int n = 0; n < 5; ++n) {
        TestClient gone(m_server->port(), m_server->link());
        gone.enter();
        gone.say(question(1, kTrachea, kLeft));
    }
    // The scene goes on, and searches of disconnected clients end soon.
    EXPECT_EQ(a.command({{"do", "iso"}, {"iso_hu", -450}})["t"], "done");
    Json last = Json::object();
    for (int n = 0; n < 200 && last.value("t", "") != "path"; ++n) {
        a.say(question(1000 + n, kTrachea, kLeft));
        last = answer(a, 1000 + n);
    }
    EXPECT_EQ(last["t"], "path") << last;
}

}  // namespace
}  // namespace pliant::test
