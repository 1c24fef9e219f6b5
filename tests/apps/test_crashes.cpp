// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Damaged scans that once ended the process (tests/apps/data/crashes.tar.gz): with the command
// line, and uploaded to a server.
// Covers: pliant/main.cpp, hub/hub.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "hub/test_client.h"
#include "support/program_in_folder.h"
#include "support/running_program.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

class Crashes : public ProgramInFolder {
  protected:
    void SetUp() override {
        const std::string unpack =
            "tar -C '" + m_folder.path().string() + "' -xzf '" PLIANT_APPS_DATA "/crashes.tar.gz'";
        ASSERT_EQ(std::system(unpack.c_str()), 0);
        for (const auto& entry : fs::directory_iterator(m_folder.path()))
            m_cases.push_back(entry.path());
        std::sort(m_cases.begin(), m_cases.end());
        ASSERT_EQ(m_cases.size(), 25U);
    }
    /// The file that is opened: a folder of slices is opened as a whole.
    static fs::path scan_of(const fs::path& damaged) {
        if (!fs::is_directory(damaged)) return damaged;
        for (const auto& entry : fs::directory_iterator(damaged))
            if (entry.path().extension() == ".nhdr" || entry.path().filename() == "x.nrrd" ||
                entry.path().filename() == "lab.nrrd")
                return entry.path();
        return damaged;
    }

    std::vector<fs::path> m_cases;
};

TEST_F(Crashes, AreTakenOrRefusedInOneLine) {
    for (const fs::path& damaged : m_cases) {
        const std::string name = scan_of(damaged).lexically_relative(m_folder.path()).string();
        const int status = run("info " + name, "ulimit -c 0 && timeout 30");
        const std::string line = said();
        EXPECT_TRUE(status == 0 || status == 2) << name << ": " << status << ", " << line;
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), status == 2 ? 1 : 0)
            << name << ": " << line;
        EXPECT_TRUE(status == 0 || line.starts_with("pliant: " + damaged.filename().string()))
            << line;
    }
    const std::string labels = "labels.2.363.crash/";
    const int status =
        run("deform " + labels + "lab.nrrd --push 0,0,0:1,0,0 --out o.nrrd --config " + labels +
                "l.toml --labels " + labels + "lab.nrrd --directions " + labels + "dir.nrrd",
            "ulimit -c 0 && timeout 30");
    EXPECT_EQ(status, 2) << said();
    EXPECT_FALSE(exists("o.nrrd"));
}

TEST_F(Crashes, EndNoServerWhenUploaded) {
    const TemporaryFolder folder;
    RunningProgram server(folder.path(), {"serve", "--port", "0", "--no-open", "--threads", "2"});
    std::string link;
    ASSERT_TRUE(comes_about([&] {
        const std::string said = bytes_of(folder / ".out");
        const auto at = said.find("Open  "), end = said.find('\n', at == said.npos ? 0 : at);
        if (at == said.npos || end == said.npos) return false;
        link = said.substr(at + 6, end - at - 6);
        return true;
    }));
    const int port = std::stoi(link.substr(link.find(':', 6) + 1));
    const auto post = [&](const std::string& target, const std::string& body) {
        return RawConnection(port).post(target, body);
    };
    TestClient client(port, link);
    ASSERT_FALSE(client.enter().is_null());
    for (std::size_t n = 0; n < m_cases.size(); ++n) {
        const std::string who = "?token=" + token_of(link) + "&upload=u" + std::to_string(n);
        std::vector<fs::path> files = {m_cases[n]};
        if (fs::is_directory(m_cases[n])) {
            files.clear();
            for (const auto& entry : fs::directory_iterator(m_cases[n]))
                files.push_back(entry.path());
        }
        for (const fs::path& file : files) {
            const std::string taken =
                post("/open/part" + who + "&name=" + file.filename().string(), bytes_of(file));
            EXPECT_TRUE(taken.starts_with("HTTP/1.1 200")) << file << ": " << taken;
        }
        const std::string answer = post("/open/done" + who + "&name=scan", "");
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 200") || answer.starts_with("HTTP/1.1 4"))
            << m_cases[n] << ": " << answer;
    }
    TestClient newcomer(port, link);
    EXPECT_FALSE(newcomer.enter().is_null());
    EXPECT_EQ(newcomer.command({{"do", "iso"}, {"iso_hu", -400}})["t"], "done");
    EXPECT_EQ(server.end(SIGTERM), 0);
}

}  // namespace
}  // namespace pliant::test
