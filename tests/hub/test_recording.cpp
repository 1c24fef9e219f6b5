// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The session's file where the disk is full or the file is taken away: clients are told, records
// are kept and written later.
// Covers: hub/hub_events.cpp, session/session_log.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/volume.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "hub/test_client.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

/// Files can't grow beyond a size while one of these lives, as on a full disk.
class FullDisk {
  public:
    explicit FullDisk(std::uint64_t bytes) {
        m_before = std::signal(SIGXFSZ, SIG_IGN);
        ::getrlimit(RLIMIT_FSIZE, &m_limit);
        rlimit low = m_limit;
        low.rlim_cur = rlim_t(bytes);
        ::setrlimit(RLIMIT_FSIZE, &low);
    }
    ~FullDisk() {
        ::setrlimit(RLIMIT_FSIZE, &m_limit);
        std::signal(SIGXFSZ, m_before);
    }
    FullDisk(const FullDisk&) = delete;
    FullDisk& operator=(const FullDisk&) = delete;

  private:
    rlimit m_limit{};
    void (*m_before)(int) = nullptr;
};

class Recording : public ::testing::Test {
  protected:
    Json push(double x) {
        return {{"do", "push"}, {"point", {x, 0, 0}}, {"push", {0, 0.1, 0}}, {"radius", 3}};
    }
    static bool is_recorded(const Json& t, bool recorded) {
        return t["t"] == "state" && t["recorded"] == recorded;
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
    const std::filesystem::path m_session = m_folder / "s.pls";
    const ServerSettings m_settings{.phantom_size = {32, 32, 32}, .session = m_session};
};

TEST_F(Recording, SpringsThatWereCutAreCutAgain) {
    Json last;
    {
        auto server = Server::start(m_settings, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient a(server->port(), server->link());
        a.enter();
        const auto done = [&](const Json& command) {
            const Json answer = a.command(command);
            EXPECT_EQ(answer["t"], "done") << answer;
            return answer;
        };
        done({{"do", "tissue"},
              {"model", "springs"},
              {"nodes", 6},
              {"cell_mm", 4},
              {"fixed_hu", 3000},
              {"poisson_ratio", 0.4}});
        done({{"do", "relax"}, {"on", false}});
        EXPECT_EQ(a.command({{"do", "depth"}, {"within_mm", 0.1}})["code"], "nothing");
        done({{"do", "push"}, {"point", {0, 2, 0}}, {"push", {0, 2, 0}}, {"radius", 3}});
        const Json blade = {
            {"do", "cut"}, {"line", {{-5, 0.3, -5}, {5, 0.3, -5}}}, {"depth", {0, 0, 10}}};
        EXPECT_GT(done(blade)["cut_links"], 0);
        done({{"do", "depth"}, {"within_mm", 0.1}});
        done({{"do", "undo"}});
        EXPECT_GT(done(blade)["cut_links"], 0);
        done({{"do", "depth"}, {"by_time", true}});
        last = a.checked_checksum();
    }
    const auto report = replay_session(m_session, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_GE(report->marks, 1);
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(report->volume_hash));
    EXPECT_EQ(last["volume"], hash);
}

TEST_F(Recording, AnAutomaticDepthIsReplayedBetweenTheSameSweeps) {
    constexpr int kDepth = 4;
    {
        auto server = Server::start(m_settings, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient a(server->port(), server->link());
        a.enter();
        const Json springs = {{"do", "tissue"}, {"model", "springs"}, {"nodes", 8},
                              {"cell_mm", 4},   {"fixed_hu", 3000},   {"depth", kDepth}};
        ASSERT_EQ(a.command(springs)["t"], "done");
        ASSERT_EQ(a.command({{"do", "depth"}, {"by_time", true}})["t"], "done");
        // After half a second of motion there is another depth, lower or higher.
        for (int n = 0; n < 200 && a.state["tissue"]["depth"] == kDepth; ++n) {
            a.command({{"do", "push"},
                       {"point", {0, n % 2 ? 3 : 2, 0}},
                       {"push", {0, n % 2 ? -1 : 1, 0}},
                       {"radius", 4}});
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        EXPECT_NE(a.state["tissue"]["depth"], kDepth);
        a.checked_checksum();
    }
    const auto report = replay_session(m_session, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_GE(report->marks, 1);
}

TEST_F(Recording, GoesOnOnceThereIsRoomOnTheDisk) {
    Json last;
    {
        auto server = Server::start(m_settings, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient a(server->port(), server->link());
        a.enter();
        EXPECT_EQ(a.welcome["state"]["recorded"], true);
        ASSERT_EQ(a.command(push(0))["t"], "done");
        {
            // The line that doesn't fit is broken off in its middle.
            const FullDisk full(std::filesystem::file_size(m_session) + 150);
            for (int n = 0; n < 8; ++n) EXPECT_EQ(a.command(push(n))["t"], "done");
            const auto is_lost = [](const Json& t) { return is_recorded(t, false); };
            const bool was_told = a.state["recorded"] == false;
            EXPECT_TRUE(was_told || !a.until(is_lost).is_null());
        }
        ASSERT_FALSE(a.until([](const Json& t) { return is_recorded(t, true); }).is_null());
        ASSERT_EQ(a.command(push(-2))["t"], "done");
        last = a.checked_checksum();
    }
    const auto report = replay_session(m_session, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_GE(report->commands, 10);  // and perhaps a release by the client that is gone
    EXPECT_EQ(report->cut_off_bytes, 0U);
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(report->volume_hash));
    EXPECT_EQ(last["volume"], hash);
}

TEST_F(Recording, SaysThatItsFileIsGone) {
    auto server = Server::start(m_settings, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    TestClient a(server->port(), server->link());
    a.enter();
    std::filesystem::rename(m_session, m_folder / "other.pls");
    EXPECT_FALSE(a.until([](const Json& t) { return is_recorded(t, false); }).is_null());
    std::filesystem::rename(m_folder / "other.pls", m_session);
    EXPECT_FALSE(a.until([](const Json& t) { return is_recorded(t, true); }).is_null());
}

TEST_F(Recording, AScanThatIsCutShortMeanwhileHarmsNobody) {
    // Large and raw, so that read_volume would map it.
    auto phantom = make_phantom({.name = "cube", .size = {96, 96, 96}}, m_arena);
    ASSERT_TRUE(phantom.ok());
    const auto file = m_folder / "scan.nrrd";
    ASSERT_TRUE(write_volume(file, phantom->volume, Encoding::Raw).ok());
    auto server = Server::start({.file = file.string()}, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    std::filesystem::resize_file(file, 100);
    TestClient a(server->port(), server->link());
    a.enter();
    EXPECT_EQ(a.command(push(0))["t"], "done");
    a.checked_checksum();
}

}  // namespace
}  // namespace pliant::test
