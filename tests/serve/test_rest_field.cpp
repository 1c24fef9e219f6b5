// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rest field as a client holds it, against that of the same scene played in this process and
// resampled at once.

#include <gtest/gtest.h>
#include <pliant/phantom.h>
#include <pliant/rest_field.h>
#include <pliant/serve.h>

#include "serve/commands.h"
#include "serve/scene.h"
#include "serve/test_client.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

class RestFieldTest : public ::testing::Test {
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

    struct Guest : TestClient {
        explicit Guest(const Server& server, const Json& hello = Json::object())
            : TestClient(server.port(), server.link()) {
            enter(hello);
        }
    };
    /// The server's scene and its twin do the same.
    void both(TestClient& client, const Json& command) {
        client.command(command);
        const auto parsed = serve::parse_message(command.dump());
        const auto* message = std::get_if<serve::Message>(&parsed);
        ASSERT_TRUE(message) << command;
        m_twin->carry_out(client.welcome["client"], message->action);
    }
    static Json json_of(Vec3d v) { return {v.x, v.y, v.z}; }
    Json random_command(Random& random) {
        const Vec3d at = random.vector(12), by = random.vector(5);
        switch (random.whole(0, 9)) {
            case 0:
                return {{"do", "undo"}};
            case 1:
                return {{"do", "redo"}};
            case 2:
                return {{"do", "carve"},
                        {"from", json_of(at)},
                        {"to", json_of(at + by)},
                        {"radius", 2.5}};
            case 3:
                return {{"do", "cut"},
                        {"line", Json::array({json_of(at), json_of(at + by)})},
                        {"depth", json_of(random.vector(9))}};
            case 4:
                if (random.whole(0, 2) == 0) return {{"do", "reset"}};
                [[fallthrough]];
            default:
                return {{"do", "push"},
                        {"point", json_of(at)},
                        {"push", json_of(by)},
                        {"radius", random.real(1, 5)}};
        }
    }
    RestField expected() const {
        const Deformed once = deform_volume(m_twin->tissue(), Mapping::Cells, true).value();
        return RestField::create(m_twin->tissue(), once).value();
    }
    /// What the client holds is made of the twin at once.
    void expect_same(TestClient& client) {
        const Json sums = client.checked_checksum();
        ASSERT_EQ(sums["tissue"], serve::hex_text(m_twin->tissue().hash(), 16));
        const RestField field = expected();
        ASSERT_EQ(client.rest_counts(), field.counts());
        std::vector<std::uint16_t> halves(client.rest.size());
        field.copy({{0, 0, 0}, field.counts()}, halves);
        ASSERT_EQ(client.rest, halves);
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
    std::unique_ptr<Server> m_server;
    std::unique_ptr<serve::Scene> m_twin;
};

TEST_F(RestFieldTest, ARandomSequenceOfEverythingLeavesItAsMadeAnew) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Guest a(*m_server), b(*m_server, {{"lz4", true}, {"role", "view"}}), c(*m_server);
        EXPECT_EQ(a.ask_rest(true)["t"], "done");
        EXPECT_EQ(a.ask_overlay("displacement")["t"], "done");  // both at once
        EXPECT_EQ(b.ask_rest(true)["t"], "done");               // who only looks may ask, too
        for (int n = 0; n < 30; ++n) {
            both(a, random_command(random));
            if (random.whole(0, 9) == 0) expect_same(a);
            if (random.whole(0, 14) == 0) {
                b.ask_rest(false);
                b.ask_rest(true);
            }
        }
        expect_same(a);
        expect_same(b);
        EXPECT_GT(a.rest_boxes, 0);
        EXPECT_EQ(c.rest_boxes, 0);
        // Of what is deformed already the whole field comes, once.
        Guest late(*m_server);
        late.ask_rest(true);
        expect_same(late);
        EXPECT_EQ(late.whole_rests, expected().at_rest() ? 0 : 1);
        both(a, {{"do", "reset"}});
        expect_same(late);
    }
}

TEST_F(RestFieldTest, ACutThatMovesNoVoxelIsSent) {
    Guest a(*m_server);
    a.ask_rest(true);
    both(a, {{"do", "cut"}, {"line", {{-9, 0, -9}, {9, 0, -9}}}, {"depth", {0, 0, 18}}});
    expect_same(a);
    EXPECT_FALSE(expected().at_rest());
    both(a, {{"do", "undo"}});
    expect_same(a);
    EXPECT_TRUE(expected().at_rest());
}

TEST_F(RestFieldTest, FollowsAnotherTissueAndSprings) {
    Guest a(*m_server);
    a.ask_rest(true);
    both(a, {{"do", "carve"}, {"from", {0, 0, 0}}, {"to", {0, 0, 3}}, {"radius", 4}});
    both(a, {{"do", "push"}, {"point", {6, 0, 0}}, {"push", {3, 0, 0}}, {"radius", 4}});
    expect_same(a);
    both(a, {{"do", "tissue"}, {"model", "springs"}, {"nodes", 6}});
    both(a, {{"do", "relax"}, {"on", false}});
    expect_same(a);
    both(a, {{"do", "push"}, {"point", {0, 0, 0}}, {"push", {3, 1, 0}}, {"radius", 8}});
    const RestField field = expected();
    expect_same(a);
    EXPECT_FALSE(field.at_rest());
    both(a, {{"do", "tissue"}, {"model", "chainmail"}});
    both(a, {{"do", "carve"}, {"from", {5, 0, 0}}, {"to", {5, 0, 3}}, {"radius", 4}});
    expect_same(a);
}

TEST_F(RestFieldTest, EndsWithItsConnectionAndWaitsForWhoDoesNotAnswer) {
    auto a = std::make_unique<TestClient>(m_server->port(), m_server->link());
    a->enter();
    a->sends_rest_seen = false;
    a->ask_rest(true);
    for (int n = 0; n < 6; ++n) {
        both(*a, {{"do", "push"}, {"point", {0, 0, 0}}, {"push", {0, 0.6, 0}}, {"radius", 5}});
        ASSERT_TRUE(a->until_up_to_date());
    }
    EXPECT_LE(a->whole_rests, 3);
    a->sends_rest_seen = true;
    a->say({{"do", "seen"}, {"step", a->rest_step}, {"format", 4}});
    expect_same(*a);
    const Json hello = {{"resume", a->welcome["resume"]}, {"step", a->step}};
    TestClient again(m_server->port(), m_server->link());
    again.voxels = a->voxels;
    a.reset();
    ASSERT_EQ(again.enter(hello)["resumed"], true);
    both(again, {{"do", "push"}, {"point", {5, 0, 0}}, {"push", {0, 2, 0}}, {"radius", 5}});
    again.checked_checksum();
    EXPECT_EQ(again.rest_boxes, 0);
    again.ask_rest(true);
    expect_same(again);
}

}  // namespace
}  // namespace pliant::test
