// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant serve and pliant replay as a user starts them, and as the machine may end them.
// Covers: pliant/run_serve.cpp, pliant/run_replay.cpp.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <thread>

#include "hub/test_client.h"
#include "support/program_in_folder.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

/// The program as a process of its own, until it is ended.
class Program {
  public:
    Program(const std::vector<std::string>& arguments, const std::filesystem::path& out)
        : m_out(out) {
        std::filesystem::remove(out);  // output of an earlier server
        m_pid = ::fork();
        if (m_pid == 0) {
            const int file = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
            ::dup2(file, 1);
            ::dup2(file, 2);
            std::vector<std::string> words = {PLIANT_PROGRAM};
            words.insert(words.end(), arguments.begin(), arguments.end());
            std::vector<char*> pointers;
            for (std::string& word : words) pointers.push_back(word.data());
            pointers.push_back(nullptr);
            ::execv(PLIANT_PROGRAM, pointers.data());
            ::_exit(127);
        }
    }
    ~Program() { end(SIGKILL); }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    /// @returns its exit status; −1 where a signal ended it
    int end(int signal) {
        if (m_pid <= 0) return m_status;
        ::kill(m_pid, signal);
        return wait();
    }
    int wait() {
        int raw = 0;
        ::waitpid(m_pid, &raw, 0);
        m_pid = 0;
        return m_status = WIFEXITED(raw) ? WEXITSTATUS(raw) : -1;
    }
    std::string said() const { return bytes_of(m_out); }
    /// The link that it prints; empty if it prints none.
    std::string link() const {
        for (int n = 0; n < 600; ++n) {
            const std::string text = said();
            const auto at = text.find("Open  ");
            const auto end = text.find('\n', at == std::string::npos ? 0 : at);
            if (at != std::string::npos && end != std::string::npos)
                return text.substr(at + 6, end - at - 6);
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        return {};
    }

  private:
    std::filesystem::path m_out;
    pid_t m_pid = 0;
    int m_status = 0;
};

int port_of(const std::string& link) {
    const auto at = link.find(":", 7);
    return at == std::string::npos ? 0 : std::stoi(link.substr(at + 1));
}

class ServeProgramTest : public ::testing::Test {
  protected:
    void SetUp() override {
        const TaskArena arena;
        const auto phantom = make_phantom({.name = "airway", .size = {48, 48, 48}}, arena);
        ASSERT_TRUE(phantom.ok());
        ASSERT_TRUE(write_volume(m_scan, phantom->volume).ok());
    }
    std::vector<std::string> serve() const {
        return {"serve",     m_scan.string(),    "--model",   "chainmail",    "--port", "0",
                "--session", m_session.string(), "--no-open", "--checkpoint", "0"};
    }
    Json replayed(const std::filesystem::path& session, bool from_checkpoint = false) {
        std::vector<std::string> arguments = {"replay", session.string(), "--json"};
        if (from_checkpoint) arguments.push_back("--from-checkpoint");
        Program replay(arguments, m_folder / "replay.txt");
        EXPECT_EQ(replay.wait(), 0) << replay.said();
        const Json report = Json::parse(without_progress(replay.said()), nullptr, false);
        if (report.is_object()) return report;
        ADD_FAILURE() << "pliant replay printed no JSON object: " << replay.said();
        return Json::object();
    }

    TemporaryFolder m_folder;
    const std::filesystem::path m_scan = m_folder / "airway.nrrd";
    const std::filesystem::path m_session = m_folder / "s.pls";
};

/// Sets a variable of the environment while one of these lives.
class Environment {
  public:
    Environment(const char* name, const std::string& value) : m_name(name) {
        if (const char* before = std::getenv(name)) m_before = before;
        ::setenv(name, value.c_str(), 1);
    }
    ~Environment() {
        if (m_before)
            ::setenv(m_name, m_before->c_str(), 1);
        else
            ::unsetenv(m_name);
    }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

  private:
    const char* m_name;
    std::optional<std::string> m_before;
};

TEST(ServeProgram, TheBrowserIsGivenNoSecretOnItsCommandLine) {
    namespace fs = std::filesystem;
    const TemporaryFolder folder;
    // Keeps its command line and the file that it was given.
    const fs::path opener = folder / "bin" / "xdg-open";
    fs::create_directories(opener.parent_path());
    std::ofstream(opener) << "#!/bin/sh\necho \"$@\" > '" << (folder / "words").string()
                          << "'\ncp \"$1\" '" << (folder / "page").string() << "'\n";
    fs::permissions(opener, fs::perms::owner_all);
    fs::create_directories(folder / "run" / "x");
    const char* const path = std::getenv("PATH");
    const Environment bin("PATH", opener.parent_path().string() + ":" + (path ? path : ""));
    const Environment display("DISPLAY", ":99");
    const Environment run("XDG_RUNTIME_DIR", (folder.path() / "run").string());
    Program program({"serve", "--port", "0"}, folder / "out");
    const std::string link = program.link();
    const std::string token = token_of(link);
    ASSERT_FALSE(token.empty()) << program.said();
    for (int n = 0; n < 200 && bytes_of(folder / "page").empty(); ++n)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(bytes_of(folder / "words").find(token), std::string::npos);
    EXPECT_NE(bytes_of(folder / "page").find(link), std::string::npos);
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path() / "run"))
        if (entry.path().filename() == "open.html") {
            ++files;
            const auto outside = fs::status(entry.path().parent_path()).permissions() &
                                 (fs::perms::group_all | fs::perms::others_all);
            EXPECT_EQ(outside, fs::perms::none);
        }
    EXPECT_EQ(files, 1);
    EXPECT_EQ(program.end(SIGTERM), 0);
    for (const auto& entry : fs::recursive_directory_iterator(folder.path() / "run"))
        EXPECT_NE(entry.path().filename(), "open.html");
}

TEST_F(ServeProgramTest, AfterKill9ASessionHasAllButTheLastSecond) {
    const std::uint64_t seed = 909;
    SCOPED_TRACE(seed);
    Random random(seed);
    Json before;
    for (int round = 0; round < 3; ++round) {
        Program server(serve(), m_folder / "serve.txt");
        const std::string link = server.link();
        ASSERT_FALSE(link.empty()) << server.said();
        TestClient client(port_of(link), link);
        client.enter();
        Json now = client.checked_checksum();
        ASSERT_TRUE(now.is_object()) << "round " << round << ": " << server.said();
        if (round > 0) {
            EXPECT_EQ(now["volume"], before["volume"]);
            EXPECT_EQ(now["tissue"], before["tissue"]);
        }
        for (int n = 0; n < 10; ++n) {
            const Vec3d at = random.vector(40), by = random.vector(6);
            client.command({{"do", "push"},
                            {"point", {at.x, at.y, at.z}},
                            {"push", {by.x, by.y, by.z}},
                            {"radius", 9}});
        }
        client.command({{"do", "relax"}, {"on", true}});
        client.until([](const Json& t) { return t["t"] == "state" && t["settled"] == true; });
        client.command({{"do", "relax"}, {"on", false}});
        client.command({{"do", "release"}});
        before = client.checked_checksum();
        ASSERT_TRUE(before.is_object()) << "round " << round << ": " << server.said();
        // Everything must be there a second later.
        std::this_thread::sleep_for(std::chrono::milliseconds(1000));
        client.say({{"do", "push"}, {"point", {0, 0, 0}}, {"push", {0, 0, 0}}, {"radius", 3}});
        server.end(SIGKILL);
        Json replay = replayed(m_session);
        EXPECT_EQ(replay["volume_hash"], before["volume"]);
        EXPECT_EQ(replay["tissue_hash"], before["tissue"]);
        EXPECT_EQ(replay["from_checkpoint"], 0);
        Json quick = replayed(m_session, true);
        EXPECT_EQ(quick["volume_hash"], before["volume"]);
        EXPECT_EQ(quick["tissue_hash"], before["tissue"]);
        if (round == 2) {
            EXPECT_GT(quick["from_checkpoint"], 0);
        }
        // The line that was being written may be there in part.
        std::ofstream(m_session, std::ios::app) << "0123456789abcdef {\"client\":1,\"do\":\"pu";
        EXPECT_GT(replayed(m_session)["cut_off_bytes"], 0);
    }
}

TEST_F(ServeProgramTest, AReplayWritesWhatTheSessionLeft) {
    Json left;
    {
        Program server(serve(), m_folder / "serve.txt");
        const std::string link = server.link();
        ASSERT_FALSE(link.empty()) << server.said();
        TestClient client(port_of(link), link);
        client.enter();
        client.command({{"do", "push"}, {"point", {10, 0, 0}}, {"push", {3, 0, 0}}, {"radius", 3}});
        client.command({{"do", "cut"}, {"line", {{-5, 9, 0}, {5, 9, 0}}}, {"depth", {0, 9, 0}}});
        client.command({{"do", "iso"}, {"iso_hu", -350}, {"polarity", "rising"}});
        left = client.checked_checksum();
        ASSERT_TRUE(left.is_object());
        EXPECT_EQ(server.end(SIGTERM), 0);
    }
    const auto file = [&](const char* name) { return (m_folder / name).string(); };
    Program replay({"replay", m_session.string(), "--out", file("left.nrrd"), "--displacement",
                    file("u.nrrd"), "--transform", file("t.nrrd"), "--save-state", file("s.plst"),
                    "--png", file("left.png"), "--style", "real"},
                   m_folder / "replay.txt");
    ASSERT_EQ(replay.wait(), 0) << replay.said();
    const auto hash_of = [](const std::string& name) {
        const auto volume = read_volume(name);
        EXPECT_TRUE(volume.ok());
        char text[17];
        std::snprintf(text, sizeof text, "%016lx",
                      static_cast<unsigned long>(volume.ok() ? hash_volume(*volume) : 0));
        return std::string(text);
    };
    EXPECT_EQ(hash_of(file("left.nrrd")), left["volume"]);
    // The same from the state alone.
    Program deform(
        {"deform", m_scan.string(), "--load-state", file("s.plst"), "--out", file("again.nrrd"),
         "--displacement", file("u2.nrrd"), "--transform", file("t2.nrrd"), "--png",
         file("again.png"), "--style", "real", "--iso", "-350", "--polarity", "rising"},
        m_folder / "deform.txt");
    ASSERT_EQ(deform.wait(), 0) << deform.said();
    EXPECT_EQ(hash_of(file("again.nrrd")), left["volume"]);
    for (const char* name : {"u", "t"})
        EXPECT_EQ(bytes_of(file((std::string(name) + ".nrrd").c_str())),
                  bytes_of(file((std::string(name) + "2.nrrd").c_str())));
    EXPECT_EQ(bytes_of(file("left.png")).substr(1, 3), "PNG");
    EXPECT_TRUE(bytes_of(file("left.png")) == bytes_of(file("again.png")))
        << "the threshold is the session's last one";
    Program other({"replay", m_session.string(), "--png", file("other.png"), "--look", "0,0,-1"},
                  m_folder / "other.txt");
    ASSERT_EQ(other.wait(), 0) << other.said();
    EXPECT_TRUE(bytes_of(file("other.png")) != bytes_of(file("left.png")));
    // A server begins with the state.
    {
        Program server(
            {"serve", m_scan.string(), "--load-state", file("s.plst"), "--no-open", "--port", "0"},
            m_folder / "loaded.txt");
        const std::string link = server.link();
        ASSERT_FALSE(link.empty()) << server.said();
        TestClient client(port_of(link), link);
        client.enter();
        EXPECT_EQ(client.checked_checksum()["tissue"], left["tissue"]);
        EXPECT_EQ(server.end(SIGTERM), 0);
    }
    // No session is replaced, and nothing is written if it can't be replayed.
    Program wrong({"replay", m_session.string(), "--out", m_session.string() + ".nrrd",
                   "--displacement", m_session.string()},
                  m_folder / "wrong.txt");
    EXPECT_EQ(wrong.wait(), 2);
    std::string bytes = bytes_of(m_session);
    bytes[bytes.size() / 2] ^= 1;
    std::ofstream(m_session, std::ios::binary) << bytes;
    Program damaged({"replay", m_session.string(), "--out", file("none.nrrd")},
                    m_folder / "damaged.txt");
    EXPECT_EQ(damaged.wait(), 2) << damaged.said();
    EXPECT_FALSE(std::filesystem::exists(file("none.nrrd")));
}

TEST_F(ServeProgramTest, TheChosenModelIsSaidAndKeptInTheSession) {
    // Which one is chosen depends on the machine's speed.
    for (const char* const wanted : {"auto", "elastic"}) {
        SCOPED_TRACE(wanted);
        const auto session = m_folder / (std::string(wanted) + ".pls");
        std::string recorded;
        // Begun, gone on with, and opened with the model that was chosen.
        for (int round = 0; round < 3; ++round) {
            SCOPED_TRACE("round " + std::to_string(round));
            std::vector<std::string> words = {"serve",     m_scan.string(),  "--port",   "0",
                                              "--session", session.string(), "--no-open"};
            if (round == 0) words.insert(words.end(), {"--model", wanted});
            if (round == 2) words.insert(words.end(), {"--model", recorded});
            Program server(words, m_folder / "serve.txt");
            const std::string link = server.link();
            ASSERT_FALSE(link.empty()) << server.said();
            EXPECT_EQ(server.said().find("pictures a second") != std::string::npos,
                      round == 0 && wanted == std::string("auto"))
                << server.said();
            TestClient client(port_of(link), link);
            client.enter();
            const std::string model = client.state["tissue"]["model"];
            if (round == 0) recorded = model;
            EXPECT_EQ(model, recorded);
            client.command(
                {{"do", "push"}, {"point", {10, 0, 0}}, {"push", {1, 0, 0}}, {"radius", 3}});
            EXPECT_TRUE(client.checked_checksum().is_object());
            EXPECT_EQ(server.end(SIGTERM), 0);
        }
        EXPECT_NE(bytes_of(session).find("\"model\":\"" + recorded + "\""), std::string::npos);
        EXPECT_GT(replayed(session)["commands"], 2);
    }
}

TEST_F(ServeProgramTest, EndsOnASignalAndSaysWhatIsWrong) {
    {
        Program server(serve(), m_folder / "serve.txt");
        const std::string link = server.link();
        ASSERT_FALSE(link.empty()) << server.said();
        TestClient client(port_of(link), link);
        client.enter();
        ::usleep(10'000);
        EXPECT_EQ(server.end(SIGTERM), 0);
        EXPECT_EQ(client.wait_for_close(), 1001);
    }
    const struct {
        std::vector<std::string> arguments;
        const char* expected;
    } wrong[] = {
        {{"serve", (m_folder / "none.nrrd").string(), "--no-open"}, "none.nrrd"},
        {{"serve", "--port", "70000"}, "--port"},
        {{"serve", "--session", m_scan.string(), "--no-open"}, "airway.nrrd: line 1"},
        {{"serve", m_scan.string(), "--load-state", m_scan.string(), "--no-open"},
         "--load-state: "},
        {{"replay", m_scan.string(), "--png", "x.jpg"}, "--png"},
        {{"replay", m_scan.string(), "--png", "x.png", "--look", "0,0,0"}, "--look"},
        {{"replay", (m_folder / "none.pls").string()}, "none.pls: expected a session"},
        {{"replay", m_scan.string()}, "airway.nrrd: line 1"},
    };
    for (const auto& c : wrong) {
        Program program(c.arguments, m_folder / "wrong.txt");
        EXPECT_EQ(program.wait(), 2) << c.expected;
        const std::string said = program.said();
        EXPECT_NE(said.find(c.expected), std::string::npos) << said;
        EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    }
}

}  // namespace
}  // namespace pliant::test
