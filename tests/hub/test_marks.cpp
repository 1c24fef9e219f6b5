// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks that clients share.
// Covers: hub/mark_feed.cpp.

#include "hub/twin_scene.h"

namespace pliant::test {
namespace {

using MarksTest = TwinSceneTest;

Json point(const std::string& key, const std::string& name, double x = 1) {
    return {{"do", "mark"},          {"key", key},   {"kind", "point"}, {"name", name},
            {"points", {{x, 2, 3}}}, {"shown", true}};
}
/// Asks for the marks. @returns their list
Json marks_of(TestClient& client) {
    EXPECT_EQ(client.command({{"do", "marks"}, {"on", true}})["t"], "done");
    return client.until("marks")["marks"];
}

TEST_F(MarksTest, AMarkReachesTheOtherClientsAndThoseThatComeLater) {
    Visitor anna(*m_server), ben(*m_server), viewer(*m_server, true);
    EXPECT_EQ(marks_of(anna).size(), 0U);
    EXPECT_EQ(marks_of(ben).size(), 0U);
    EXPECT_EQ(marks_of(viewer).size(), 0U);
    EXPECT_EQ(anna.command(point("a", "carina"))["t"], "done");
    for (TestClient* other : {static_cast<TestClient*>(&ben), static_cast<TestClient*>(&viewer)}) {
        const Json mark = other->until("mark");
        EXPECT_EQ(mark["key"], "a");
        EXPECT_EQ(mark["name"], "carina");
        EXPECT_EQ(mark["points"], Json::array({{1.0, 2.0, 3.0}}));
    }
    // A change replaces it; a deletion has no more fields.
    EXPECT_EQ(ben.command(point("a", "spur", 7))["t"], "done");
    EXPECT_EQ(anna.until("mark")["name"], "spur");
    EXPECT_EQ(ben.command(point("b", "other"))["t"], "done");
    EXPECT_EQ(anna.until("mark")["key"], "b");
    EXPECT_EQ(anna.command({{"do", "mark"}, {"key", "b"}, {"kind", "none"}})["t"], "done");
    const Json gone = ben.until("mark");
    EXPECT_EQ(gone["kind"], "none");
    EXPECT_EQ(gone["key"], "b");
    Visitor late(*m_server, true);
    const Json list = marks_of(late);
    ASSERT_EQ(list.size(), 1U);
    EXPECT_EQ(list[0]["name"], "spur");
}

TEST_F(MarksTest, ViewersAndTooManyMarksAreRefused) {
    Visitor anna(*m_server), viewer(*m_server, true);
    marks_of(viewer);
    EXPECT_EQ(viewer.command(point("v", "mine"))["code"], "view_only");
    for (int n = 0; n < 256; ++n)
        ASSERT_EQ(anna.command(point(std::to_string(n), "m"))["t"], "done");
    EXPECT_EQ(anna.command(point("256", "one more"))["code"], "limit");
    EXPECT_EQ(anna.command(point("17", "changed"))["t"], "done");
    EXPECT_EQ(marks_of(anna).size(), 256U);
}

TEST_F(MarksTest, MarksChangeNeitherTheSceneNorItsHistory) {
    Visitor anna(*m_server);
    const Json before = anna.checked_checksum();
    EXPECT_EQ(anna.command(point("a", "carina"))["t"], "done");
    EXPECT_EQ(anna.checked_checksum()["tissue"], before["tissue"]);
    EXPECT_EQ(anna.command({{"do", "undo"}})["code"], "nothing");
}

}  // namespace
}  // namespace pliant::test
