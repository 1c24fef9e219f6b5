// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// States of the tissue: saved by a client, loaded by one, recorded, and given at the start.
// Covers: hub/hub.cpp, base/state_frame.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/data/session.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/volume.h>

#include "hub/files_test.h"

namespace pliant::test {
namespace {

using StatesTest = FilesTest;

TEST_F(StatesTest, AStateIsSavedLoadedAndRecorded) {
    const std::string session = (m_folder / "s.pls").string();
    start(session);
    Json loaded, last;
    std::string state;
    {
        TestClient a(port(), m_server->link()), b(port(), m_server->view_link());
        a.enter();
        b.enter();
        a.command(push({0, 0, 0}, {0, 2, 0}));
        a.command({{"do", "cut"}, {"line", {{-5, -5, 0.3}, {5, -5, 0.3}}}, {"depth", {0, 10, 0}}});
        loaded = a.checked_checksum();
        const std::string saved = save("state.plst", token_of(m_server->view_link()));
        ASSERT_EQ(status_of(saved), "200");
        EXPECT_NE(saved.find("filename=\"state.plst\""), std::string::npos);
        state = body_of(saved);
        a.command(push({4, 0, 0}, {0, 2, 1}));
        a.command({{"do", "grab"}, {"point", {0, 0, 0}}, {"radius", 5}});
        EXPECT_NE(a.checked_checksum()["tissue"], loaded["tissue"]);
        const std::string target = "/open/state?token=" + token() + "&name=cut.plst";
        EXPECT_EQ(line_of(post(target, state)), "loaded");
        const Json after = b.checked_checksum();
        EXPECT_EQ(after["volume"], loaded["volume"]);
        EXPECT_EQ(after["tissue"], loaded["tissue"]);
        // Nothing is held and nothing can be undone.
        EXPECT_EQ(a.command({{"do", "drag"}, {"offset", {0, 1, 0}}})["code"], "not_holding");
        EXPECT_EQ(a.command({{"do", "undo"}})["code"], "nothing");
        EXPECT_EQ(a.command(push({0, 3, 0}, {0, 1, 0}))["t"], "done");
        EXPECT_EQ(a.command({{"do", "undo"}})["t"], "done");
        EXPECT_EQ(a.checked_checksum()["tissue"], loaded["tissue"]);
        a.command(push({0, 3, 0}, {1, 1, 0}));
        last = a.checked_checksum();
        EXPECT_EQ(last, b.checked_checksum());
    }
    // A part that is taken home looks for the state beside it.
    m_folder.write("home/s.pls", body_of(save("session.pls")));
    const auto missing = replay_session(m_folder / "home/s.pls", m_arena);
    ASSERT_FALSE(missing.ok());
    EXPECT_NE(missing.error().message.find("home/cut.plst: "), std::string::npos)
        << missing.error().message;
    m_folder.write("home/cut.plst", state);
    EXPECT_TRUE(replay_session(m_folder / "home/s.pls", m_arena).ok());
    // Another state under its name is found out.
    TestClient c(port(), m_server->link());
    c.enter();
    m_folder.write("home/cut.plst", body_of(save("state.plst")));
    const auto other = replay_session(m_folder / "home/s.pls", m_arena);
    ASSERT_FALSE(other.ok());
    EXPECT_NE(other.error().message.find("cut.plst: expected the state "), std::string::npos)
        << other.error().message;
    m_server.reset();
    EXPECT_EQ(bytes_of(m_folder / "s.pls.scans/1/scan/cut.plst"), state);
    const auto report = replay_session(session, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    start(session);
    TestClient d(port(), m_server->link());
    d.enter();
    EXPECT_EQ(d.checked_checksum()["tissue"], last["tissue"]);
    // Watched forward, back to the begin, and forward again.
    m_server.reset();
    auto watched = Server::start({.replay = session}, m_arena);
    ASSERT_TRUE(watched.ok()) << watched.error().message;
    TestClient e(watched->port(), watched->link());
    e.enter();
    const auto at = [&](double ms) {
        e.command({{"do", "replay"}, {"at_ms", ms}, {"playing", false}});
        const Json news = e.until([&](const Json& t) {
            return t["t"] == "replay" && t["seeking"] == false &&
                   t["at_ms"] == (ms == 0 ? Json(0) : t["length_ms"]);
        });
        EXPECT_TRUE(news.is_object()) << ms;
        return e.checked_checksum()["tissue"];
    };
    EXPECT_EQ(at(1e6), last["tissue"]);
    EXPECT_NE(at(0), last["tissue"]);
    EXPECT_EQ(at(1e6), last["tissue"]);
}

TEST_F(StatesTest, AStateThatDoesntFitIsRefusedInOneLineAndChangesNothing) {
    start((m_folder / "s.pls").string());
    TestClient a(port(), m_server->link());
    a.enter();
    a.command(push({0, 0, 0}, {0, 2, 0}));
    a.command({{"do", "grab"}, {"point", {0, 0, 0}}, {"radius", 5}});
    a.command({{"do", "drag"}, {"offset", {0, 1, 0}}});
    const std::string state = body_of(save("state.plst"));
    a.command({{"do", "drag"}, {"offset", {0, 1.5, 0}}});
    const Json before = a.checked_checksum();
    const auto load = [&](const std::string& bytes, const std::string& used_token) {
        const std::string response =
            post("/open/state?token=" + used_token + "&name=x.plst", bytes);
        EXPECT_NE(status_of(response), "200");
        return line_of(response);
    };
    other_scan();
    const auto scan = read_volume(m_folder / "other.nrrd");
    ASSERT_TRUE(scan.ok());
    auto tissue = ChainMail::create(*scan, {}, m_arena);
    ASSERT_TRUE(tissue.ok());
    ASSERT_TRUE(tissue->save_state(m_folder / "other.plst").ok());
    EXPECT_EQ(load(bytes_of(m_folder / "other.plst"), token()),
              "x.plst: expected a state of this scan, found one of another: of 30 × 34 × 38 voxels "
              "instead of 48 × 40 × 44");
    EXPECT_TRUE(load("hello", token()).starts_with("x.plst: "));
    EXPECT_TRUE(load("", token()).starts_with("x.plst: "));
    EXPECT_TRUE(load(state.substr(0, state.size() / 2), token()).starts_with("x.plst: "));
    EXPECT_EQ(load(state, token_of(m_server->view_link())),
              "open: expected the link of those who may change the scene");
    const Json after = a.checked_checksum();
    EXPECT_EQ(after["volume"], before["volume"]);
    EXPECT_EQ(after["tissue"], before["tissue"]);
    EXPECT_EQ(a.command({{"do", "drag"}, {"offset", {0, 1, 0}}})["t"], "done") << "it is held";
    std::error_code error;
    std::filesystem::directory_iterator left(m_folder / "s.pls.scans", error);
    for (int n = 0; n < 300 && left != std::filesystem::directory_iterator(); ++n) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));  // removed after the answer
        left = std::filesystem::directory_iterator(m_folder / "s.pls.scans", error);
    }
    EXPECT_TRUE(left == std::filesystem::directory_iterator()) << left->path();
    // That of another tissue, both ways.
    a.command({{"do", "let_go"}});
    const Json chosen =
        a.command({{"do", "tissue"}, {"model", "springs"}, {"nodes", 6}, {"fixed_hu", 3000}});
    EXPECT_EQ(chosen["t"], "done") << chosen;
    EXPECT_NE(load(state, token()).find("found that of another"), std::string::npos);
    const std::string springs = body_of(save("state.plst"));
    EXPECT_EQ(a.command({{"do", "tissue"}, {"model", "chainmail"}})["t"], "done");
    EXPECT_EQ(load(springs, token()),
              "x.plst: expected a state of ChainMail, found that of another tissue");
}

TEST_F(StatesTest, AServerBeginsWithAState) {
    ChainMailSettings settings;
    settings.bone_threshold_hu = 3000;
    auto tissue = ChainMail::create(m_scan, settings, m_arena);
    ASSERT_TRUE(tissue.ok());
    ASSERT_TRUE(tissue->push({{0, 0, 0}, {0, 2, 0}, 4}).ok());
    const std::string state = (m_folder / "pushed.plst").string();
    ASSERT_TRUE(tissue->save_state(state).ok());
    const std::string session = (m_folder / "s.pls").string();
    ServerSettings wish{.file = (m_folder / "cube.nrrd").string(), .load_state = state};
    wish.session = session;
    Json last;
    for (const int start : {1, 2}) {  // the second time the session goes on
        SCOPED_TRACE(start);
        auto started = Server::start(wish, m_arena);
        ASSERT_TRUE(started.ok()) << started.error().message;
        m_server.emplace(std::move(*started));
        TestClient a(port(), m_server->link());
        a.enter();
        const Json sums = a.checked_checksum();
        char hash[17];
        std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(tissue->hash()));
        if (start == 1) {
            EXPECT_EQ(sums["tissue"], hash);
            EXPECT_EQ(body_of(save("state.plst")).size(), bytes_of(state).size());
        } else {
            EXPECT_EQ(sums["tissue"], last["tissue"]);
        }
        a.command(push({4, 0, 0}, {0, 2, 1}));
        last = a.checked_checksum();
        m_server.reset();
    }
    EXPECT_TRUE(replay_session(session, m_arena).ok());
    const auto refused = [&](const ServerSettings& settings_of) {
        const auto server = Server::start(settings_of, m_arena);
        EXPECT_FALSE(server.ok());
        return server.ok() ? "" : server.error().message;
    };
    std::filesystem::copy_file(state, m_folder / "second.plst");
    wish.load_state = (m_folder / "second.plst").string();
    EXPECT_NE(refused(wish).find("expected a new session, or one that began with"),
              std::string::npos);
    wish.session.clear();
    wish.load_state = (m_folder / "none.plst").string();
    EXPECT_TRUE(refused(wish).starts_with("load_state: ")) << refused(wish);
    wish = {.load_state = state};
    EXPECT_NE(refused(wish).find("expected a state of this scan"), std::string::npos);
    wish.replay = session;
    EXPECT_NE(refused(wish).find("expected none beside a session that is watched"),
              std::string::npos);
}

}  // namespace
}  // namespace pliant::test
