// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A server of a cube, and a scene in this process that carries out the same commands.

#pragma once

#include <gtest/gtest.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/volume.h>

#include "hub/test_client.h"
#include "protocol/commands.h"
#include "session/scene.h"
#include "support/temporary_folder.h"

namespace pliant::test {

class TwinSceneTest : public ::testing::Test {
  protected:
    void SetUp() override {
        auto phantom = make_phantom({.name = "cube", .size = {42, 36, 33}}, m_arena);
        ASSERT_TRUE(phantom.ok());
        // Its values would count as bone.
        phantom->volume.key_values.emplace_back("bone_threshold_hu", "3000");
        const std::string file = (m_folder / "cube.nrrd").string();
        ASSERT_TRUE(write_volume(file, phantom->volume).ok());
        auto server = Server::start({.file = file}, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        m_server = std::make_unique<Server>(std::move(*server));
        auto scene = serve::Scene::open({.file = file}, m_arena);
        ASSERT_TRUE(scene.ok());
        m_twin = std::move(*scene);
    }

    struct Visitor : TestClient {
        explicit Visitor(const Server& server, bool view = false,
                         const Json& hello = Json::object())
            : TestClient(server.port(), view ? server.view_link() : server.link()) {
            enter(hello);
        }
    };
    static Json json_of(Vec3d v) { return {v.x, v.y, v.z}; }
    static Json push_of(Vec3d point, Vec3d by, double radius) {
        return {
            {"do", "push"}, {"point", json_of(point)}, {"push", json_of(by)}, {"radius", radius}};
    }
    /// The server's scene and its twin do the same.
    void both(TestClient& client, const Json& command) {
        client.command(command);
        const auto parsed = serve::parse_message(command.dump());
        const auto* message = std::get_if<serve::Message>(&parsed);
        ASSERT_TRUE(message) << command;
        m_twin->carry_out(client.welcome["client"], message->action);
    }
    /// @returns whether the client's tissue is the twin's, once it is up to date
    testing::AssertionResult is_twin(TestClient& client) {
        const std::string found = client.checked_checksum()["tissue"];
        const std::string expected = serve::hex_text(m_twin->tissue().hash(), 16);
        if (found == expected) return testing::AssertionSuccess();
        return testing::AssertionFailure() << found << ", expected " << expected;
    }
    /// A new connection that goes on where a client ended, which is closed.
    std::unique_ptr<TestClient> resumed(std::unique_ptr<TestClient> client) {
        const Json hello = {{"resume", client->welcome["resume"]}, {"step", client->step}};
        auto again = std::make_unique<TestClient>(m_server->port(), m_server->link());
        again->voxels = client->voxels;
        client.reset();
        EXPECT_EQ(again->enter(hello)["resumed"], true);
        return again;
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
    std::unique_ptr<Server> m_server;
    std::unique_ptr<serve::Scene> m_twin;
};

}  // namespace pliant::test
