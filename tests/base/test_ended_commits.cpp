// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Processes that end in the middle of a commit: at each of its steps, and at each step of the
// recovery. Afterwards all files are old, or all are new.
// Covers: base/staging_*.cpp.

#include <gtest/gtest.h>
#include <pliant/core/files.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <map>

#include "base/staging_folder.h"
#include "support/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using Files = std::map<std::string, std::string>;

/// In memory if possible: otherwise each of hundreds of commits waits for the disk.
class EndedCommits : public ::testing::Test {
  protected:
    EndedCommits() {
        if (const char* before = std::getenv("TMPDIR")) m_before = before;
        if (::access("/dev/shm", W_OK) == 0) ::setenv("TMPDIR", "/dev/shm", 1);
    }
    ~EndedCommits() override {
        if (m_before.empty())
            ::unsetenv("TMPDIR");
        else
            ::setenv("TMPDIR", m_before.c_str(), 1);
    }

  private:
    std::string m_before;
};
using EndProcess = EndedCommits;

constexpr int kEndedEarly = 77;
int g_steps_left = 0;

void count_down() {
    if (g_steps_left-- == 0) ::_exit(kEndedEarly);
}

/// Does work in a process of its own that ends before step n.
/// @returns whether it ended early
bool ended_at(int n, const std::function<void()>& work) {
    const pid_t child = ::fork();
    if (child == 0) {
        g_steps_left = n;
        staging::g_before_step = count_down;
        work();
        ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status));
    return WEXITSTATUS(status) == kEndedEarly;
}

/// Everything in a folder, temporary files too.
Files files_of(const fs::path& folder) {
    Files files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (!entry.is_directory())
            files[entry.path().lexically_relative(folder).string()] = test::bytes_of(entry.path());
    return files;
}

void write_old(const test::TemporaryFolder& folder) {
    folder.write("a", "old a");
    folder.write("sub/c", "old c");
}
const Files kOld = {{"a", "old a"}, {"sub/c", "old c"}};
const Files kNew = {
    {"a", "new a"}, {"b.nhdr", "new b"}, {"b.raw", "data"}, {"sub/c", "new c"}, {"sub/d", "new d"}};

/// Files that are replaced and new ones, one with another beside it, in two folders.
void commit_new(const fs::path& folder) {
    StagedFiles files;
    const auto write = [&](const char* name, const char* text) {
        const auto staged = files.stage(folder / name);
        if (staged.ok()) std::ofstream(*staged, std::ios::binary) << text;
        return staged;
    };
    (void)write("a", "new a");
    const auto header = write("b.nhdr", "new b");
    std::ofstream(header->parent_path() / "b.raw", std::ios::binary) << "data";
    (void)write("sub/c", "new c");
    (void)write("sub/d", "new d");
    static_cast<void>(files.commit());
}

/// Stages like the next run, in one of the folders first.
void stage_again(const fs::path& folder, bool sub_first) {
    for (const bool sub : {sub_first, !sub_first})
        EXPECT_TRUE(StagedFiles().stage(folder / (sub ? "sub/x" : "x")).ok());
}

TEST_F(EndedCommits, LeaveAllOldOrAllNewAtEachStep) {
    std::map<bool, int> seen;
    for (int n = 0;; ++n) {
        const test::TemporaryFolder folder;
        write_old(folder);
        const bool early = ended_at(n, [&] { commit_new(folder.path()); });
        for (const auto& [name, text] : kOld)
            EXPECT_TRUE(fs::exists(folder / name)) << name << " is missing after step " << n;
        stage_again(folder.path(), n % 2);
        const Files found = files_of(folder.path());
        EXPECT_TRUE(found == kOld || found == kNew) << "ended before step " << n;
        ++seen[found == kNew];
        if (!early) {
            EXPECT_EQ(found, kNew);
            break;
        }
    }
    EXPECT_GT(seen[false], 20);
    EXPECT_GT(seen[true], 10);
}

TEST_F(EndedCommits, AreFinishedAlthoughTheNextRunIsEndedToo) {
    for (int n = 0;; n += 4) {
        bool early = false;
        for (int again = 0;; again += 3) {
            const test::TemporaryFolder folder;
            write_old(folder);
            early = ended_at(n, [&] { commit_new(folder.path()); });
            const bool early_again =
                ended_at(again, [&] { stage_again(folder.path(), again % 2 == 0); });
            stage_again(folder.path(), n % 2);
            const Files found = files_of(folder.path());
            EXPECT_TRUE(found == kOld || found == kNew) << n << ", then " << again;
            if (!early_again) break;
        }
        if (!early) break;
    }
}

TEST_F(EndedCommits, ThatFailAreTakenBackAtEachStep) {
    int taken_back = 0;
    for (int n = 0;; ++n) {
        const test::TemporaryFolder folder;
        folder.write("a", "old a");
        Files expected = {{"a", "old a"}};
        const bool early = ended_at(n, [&] {
            StagedFiles files;
            for (const char* name : {"a", "b", "c", "d"}) {
                const auto staged = files.stage(folder / name);
                std::ofstream(*staged, std::ios::binary) << "new";
            }
            // In the middle of the commit the place of the third becomes a folder.
            static const test::TemporaryFolder* in;
            in = &folder;
            staging::g_before_step = [] {
                if (test::bytes_of(*in / "a") == "new" && !fs::exists(*in / "c"))
                    in->write("c/in the way", "old");
                count_down();
            };
            static_cast<void>(files.commit());
        });
        EXPECT_TRUE(StagedFiles().stage(folder / "x").ok());
        if (fs::is_directory(folder / "c")) expected["c/in the way"] = "old";
        taken_back += fs::is_directory(folder / "c");
        const Files found = files_of(folder.path());
        // Ended before the place was taken: the commit is finished.
        if (found.contains("c"))
            expected = {{"a", "new"}, {"b", "new"}, {"c", "new"}, {"d", "new"}};
        EXPECT_EQ(found, expected) << "ended before step " << n;
        if (!early) break;
    }
    EXPECT_GT(taken_back, 5);
}

TEST_F(EndedCommits, AreToldInOneLine) {
    static std::string told;
    const RecoveryListener before = set_recovery_listener([](const char* line) { told += line; });
    std::map<std::string, int> lines;
    for (int n = 0;; ++n) {
        const test::TemporaryFolder folder;
        write_old(folder);
        const bool early = ended_at(n, [&] { commit_new(folder.path()); });
        told.clear();
        stage_again(folder.path(), n % 2);
        if (!told.empty()) {
            EXPECT_TRUE(told.starts_with(folder.path().string())) << told;
            EXPECT_EQ(files_of(folder.path()), kNew) << told;
        }
        ++lines[told.substr(0, told.find(':')).empty() ? "silent" : "told"];
        if (!early) break;
    }
    EXPECT_GT(lines["told"], 5);
    set_recovery_listener(before);
}

TEST_F(EndedCommits, LivingProcessesKeepTheirFolders) {
    const test::TemporaryFolder folder;
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        StagedFiles files;
        const auto staged = files.stage(folder / "a");
        std::ofstream(*staged) << "new";
        const std::string path = staged->string();
        static_cast<void>(!::write(ends[1], path.data(), path.size()));
        for (;;) ::pause();
    }
    char text[4096] = {};
    ASSERT_GT(::read(ends[0], text, sizeof text - 1), 0);
    const fs::path staged = text;
    EXPECT_TRUE(StagedFiles().stage(folder / "b").ok());
    EXPECT_EQ(test::bytes_of(staged), "new") << "its process lives";
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_TRUE(fs::exists(staged));
    EXPECT_TRUE(StagedFiles().stage(folder / "b").ok());
    EXPECT_EQ(files_of(folder.path()), Files());
    EXPECT_TRUE(fs::is_empty(folder.path()));
    for (const int end : ends) ::close(end);
}

TEST_F(EndedCommits, AJournalFromElsewhereReachesNoOtherFolder) {
    const auto text = [](std::initializer_list<std::string_view> words) {
        std::string joined;
        for (const auto word : words) joined.append(word).push_back('\0');
        return joined;
    };
    const std::string begin = text({"pliant outputs 1"});
    const std::string journals[] = {
        begin + text({"new", "0", "../victim", "end"}),
        begin + text({"new", "..", "f", "end"}),
        begin + text({"new", "0", "f"}),
        begin + text({"replace", "0", "..", "end"}),
        begin + text({"part", "/", "part", "..", "end"}),
        begin,
        "",
        std::string(100'000, 'x'),
    };
    for (const std::string& journal : journals) {
        const test::TemporaryFolder folder;
        folder.write("victim", "old");
        const fs::path leftover = folder / "in" / (std::string(staging::kPrefix) + "Xa81Qe");
        fs::create_directories(leftover / "0");
        fs::permissions(leftover, fs::perms::owner_all);
        std::ofstream(leftover / "0/f") << "new";
        std::ofstream(leftover / "redo", std::ios::binary) << journal;
        EXPECT_TRUE(StagedFiles().stage(folder / "in/x").ok());
        EXPECT_EQ(test::bytes_of(folder / "victim"), "old");
        EXPECT_FALSE(fs::exists(folder / "f") || fs::exists(folder / "in/f")) << journal;
    }
}

TEST_F(EndProcess, RemovesWhatIsStagedInAllFolders) {
    const test::TemporaryFolder folder;
    fs::create_directory(folder / "sub");
    folder.write("a", "old");
    const pid_t child = ::fork();
    if (child == 0) {
        StagedFiles files, more;
        std::ofstream(*files.stage(folder / "a")) << "new";
        std::ofstream(*files.stage(folder / "sub/b")) << "new";
        std::ofstream(*more.stage_folder(folder / "c/d") / "e") << "new";
        end_process(130);
        ::_exit(1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 130) << status;
    EXPECT_EQ(files_of(folder.path()), (Files{{"a", "old"}}));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2);
}

TEST_F(EndProcess, LeavesNoFolderAtAnyStepOfStaging) {
    int ended = 0;
    for (int n = 0;; ++n) {
        const test::TemporaryFolder folder;
        fs::create_directory(folder / "sub");
        const pid_t child = ::fork();
        if (child == 0) {
            g_steps_left = n;
            staging::g_before_step = [] {
                if (g_steps_left-- == 0) end_process(143);
            };
            {
                StagedFiles files;
                (void)files.stage(folder / "a");
                (void)files.stage(folder / "sub/b");
            }
            ::_exit(0);
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        for (const char* parent : {".", "sub"})
            for (const auto& entry : fs::directory_iterator(folder / parent))
                EXPECT_EQ(entry.path().filename(), "sub") << "asked to end at step " << n;
        ASSERT_TRUE(WIFEXITED(status)) << n;
        if (WEXITSTATUS(status) == 0) break;
        EXPECT_EQ(WEXITSTATUS(status), 143);
        ++ended;
    }
    EXPECT_GT(ended, 8);
}

TEST_F(EndProcess, WaitsForTheEndOfACommit) {
    bool was_old = false, was_new = false;
    for (int n = 0; !was_new || n < 200; ++n) {
        const test::TemporaryFolder folder;
        write_old(folder);
        const pid_t child = ::fork();
        if (child == 0) {
            g_steps_left = n;
            // As a signal does in the middle of anything.
            staging::g_before_step = [] {
                if (g_steps_left-- == 0) end_process(143);
            };
            commit_new(folder.path());
            ::_exit(0);
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        const Files found = files_of(folder.path());
        ASSERT_TRUE(found == kOld || found == kNew) << "asked to end at step " << n;
        (found == kOld ? was_old : was_new) = true;
        if (WEXITSTATUS(status) == 0) break;
        EXPECT_EQ(WEXITSTATUS(status), 143);
    }
    EXPECT_TRUE(was_old && was_new);
}

}  // namespace
}  // namespace pliant
