// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rest field as a client holds it, against that of the same scene played in this process and
// resampled at once.
// Covers: hub/rest_feed.cpp.

#include <pliant/resample.h>

#include "hub/twin_scene.h"
#include "support/random.h"

namespace pliant::test {
namespace {

class RestFieldTest : public TwinSceneTest {
  protected:
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
                return push_of(at, by, random.real(1, 5));
        }
    }
    RestField expected() const {
        const Deformed once = deform_volume(m_twin->tissue(), Mapping::Cells, true).value();
        return RestField::create(m_twin->tissue(), once).value();
    }
    /// The client's field is the one that is made of the twin at once.
    void expect_same(TestClient& client) {
        ASSERT_TRUE(is_twin(client));
        const RestField field = expected();
        ASSERT_EQ(client.rest_counts(), field.counts());
        std::vector<std::uint16_t> halves(client.rest.size());
        field.copy({{0, 0, 0}, field.counts()}, halves);
        ASSERT_EQ(client.rest, halves);
    }
};

TEST_F(RestFieldTest, ARandomSequenceOfEverythingLeavesItAsMadeAnew) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Visitor a(*m_server), b(*m_server, true, {{"lz4", true}}), c(*m_server);
        EXPECT_EQ(a.ask_rest(true)["t"], "done");
        EXPECT_EQ(a.ask_overlay("displacement")["t"], "done");  // both at once
        EXPECT_EQ(b.ask_rest(true)["t"], "done");               // a viewer may ask, too
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
        // A latecomer is sent the whole field, once.
        Visitor late(*m_server);
        late.ask_rest(true);
        expect_same(late);
        EXPECT_EQ(late.whole_rests, expected().at_rest() ? 0 : 1);
        both(a, {{"do", "reset"}});
        expect_same(late);
    }
}

TEST_F(RestFieldTest, ACutThatMovesNoVoxelIsSent) {
    Visitor a(*m_server);
    a.ask_rest(true);
    both(a, {{"do", "cut"}, {"line", {{-9, 0, -9}, {9, 0, -9}}}, {"depth", {0, 0, 18}}});
    expect_same(a);
    EXPECT_FALSE(expected().at_rest());
    both(a, {{"do", "undo"}});
    expect_same(a);
    EXPECT_TRUE(expected().at_rest());
}

TEST_F(RestFieldTest, FollowsAnotherTissueAndSprings) {
    Visitor a(*m_server);
    a.ask_rest(true);
    both(a, {{"do", "carve"}, {"from", {0, 0, 0}}, {"to", {0, 0, 3}}, {"radius", 4}});
    both(a, push_of({6, 0, 0}, {3, 0, 0}, 4));
    expect_same(a);
    both(
        a,
        {{"do", "tissue"}, {"model", "springs"}, {"nodes", 6}, {"cell_mm", 5}, {"fixed_hu", 3000}});
    ASSERT_EQ(m_twin->tissue().traits().model, "springs");
    both(a, {{"do", "relax"}, {"on", false}});
    expect_same(a);
    both(a, push_of({0, 0, 0}, {3, 1, 0}, 8));
    const RestField field = expected();
    expect_same(a);
    EXPECT_FALSE(field.at_rest());
    both(a, {{"do", "tissue"}, {"model", "chainmail"}});
    both(a, {{"do", "carve"}, {"from", {5, 0, 0}}, {"to", {5, 0, 3}}, {"radius", 4}});
    expect_same(a);
}

TEST_F(RestFieldTest, EndsWithItsConnectionAndWaitsForAnswers) {
    auto a = std::make_unique<TestClient>(m_server->port(), m_server->link());
    a->enter();
    a->sends_rest_seen = false;
    a->ask_rest(true);
    for (int n = 0; n < 6; ++n) {
        both(*a, push_of({0, 0, 0}, {0, 0.6, 0}, 5));
        ASSERT_TRUE(a->until_up_to_date());
    }
    EXPECT_LE(a->whole_rests, 3);
    a->sends_rest_seen = true;
    a->say({{"do", "seen"}, {"step", a->rest_step}, {"format", 4}});
    expect_same(*a);
    const auto resumed_client = resumed(std::move(a));
    TestClient& again = *resumed_client;
    both(again, push_of({5, 0, 0}, {0, 2, 0}, 5));
    again.checked_checksum();
    EXPECT_EQ(again.rest_boxes, 0);
    again.ask_rest(true);
    expect_same(again);
}

}  // namespace
}  // namespace pliant::test
