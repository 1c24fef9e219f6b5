// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The judge of mutated runs, with scripts in place of the program: each fault is found, and a run
// as it should be has none.

#include <gtest/gtest.h>

#include <csignal>

#include "mutate/child.h"
#include "mutate/judge.h"
#include "support/temporary_folder.h"

namespace pliant::mutate {
namespace {

constexpr Limits kShort{.cpu_s = 1, .wall_s = 2, .file_bytes = 1 << 20};

class Judge : public ::testing::Test {
  protected:
    Judge() {
        std::filesystem::create_directory(m_folder / ".tmp");
        m_folder.write("a.nrrd", "an input");
    }
    /// Faults of a shell script, as one text.
    std::string faults(const std::string& script, const Rules& rules = {}) {
        const Contents before = contents_of(m_folder.path());
        m_run = run_child("/bin/sh", {"-c", script}, m_folder.path(), kShort);
        std::string all;
        for (const std::string& fault :
             faults_of(m_run, before, contents_of(m_folder.path()), rules))
            all += fault + ";";
        return all;
    }

    test::TemporaryFolder m_folder;
    Ended m_run;
};

TEST_F(Judge, FindsNoFaultWhereAFileIsTakenOrRefusedInOneLine) {
    EXPECT_EQ(faults("echo '{\"a\": \"µ\"}'; echo x > out.nrrd", {.expects_json = true}), "");
    EXPECT_EQ(m_run.status, 0);
    EXPECT_EQ(faults("cat a.nrrd; echo 'pliant: a.nrrd: expected more' >&2; exit 2"), "");
    EXPECT_EQ(m_run.status, 2);
    EXPECT_EQ(m_run.out, "an input");
    EXPECT_EQ(m_run.err, "pliant: a.nrrd: expected more\n");
    EXPECT_GT(m_run.peak_mb, 0);
    // A table of series may follow, and nothing else.
    const std::string several = "echo 'pliant: d: holds 2 series' >&2; ";
    EXPECT_EQ(faults(several + "echo 'number  UID' >&2; echo '1       1.2' >&2; exit 2"), "");
    EXPECT_NE(faults(several + "echo 'and more' >&2; exit 2"), "");
}

TEST_F(Judge, SetsProgressAside) {
    const std::string slow = "echo 'pliant: deform: 0 % after 2 s' >&2; ";
    EXPECT_EQ(faults(slow + "echo done"), "");
    EXPECT_EQ(faults("echo 'pliant: gauss-newton: 91 % after 12 s' >&2"), "");
    EXPECT_EQ(faults(slow + slow + "echo 'pliant: a: b' >&2; exit 2"), "");
    EXPECT_EQ(faults(slow + "exit 2"), "expected one line on standard error, found 0;");
    EXPECT_EQ(faults("echo 'pliant: deform: 0 % of it' >&2"),
              "status 0, yet something on standard error;");
}

TEST_F(Judge, FindsCrashes) {
    EXPECT_EQ(faults("kill -SEGV $$"), "signal 11 (Segmentation fault);");
    EXPECT_EQ(faults("echo '*** buffer overflow' >&2; kill -ABRT $$"), "signal 6 (Aborted);");
    EXPECT_EQ(faults("exec head -c 2000000 /dev/zero > large"),
              "signal 25 (File size limit exceeded);");
}

TEST_F(Judge, FindsRunsWithoutEnd) {
    EXPECT_EQ(faults("sleep 60"), "ran until its time was up;");
    EXPECT_EQ(m_run.signal, SIGALRM);
    EXPECT_EQ(faults("while :; do :; done"), "ran until its time was up;");
    EXPECT_TRUE(m_run.too_long);
    EXPECT_EQ(faults("while :; do :; done", {.may_be_long = true}), "");
}

TEST_F(Judge, FindsWrongMessages) {
    EXPECT_EQ(faults("exit 1"), "exit status 1;");
    EXPECT_EQ(faults("exit 2"), "expected one line on standard error, found 0;");
    EXPECT_EQ(faults("echo a codec complains >&2; echo 'pliant: a: b' >&2; exit 2"),
              "expected one line on standard error, found 2;");
    EXPECT_EQ(faults("echo 'not ours' >&2; exit 2"),
              "expected one line on standard error, found 1;");
    EXPECT_EQ(faults("echo 'pliant: unfinished' >&2; echo done"),
              "status 0, yet something on standard error;");
    EXPECT_EQ(faults("printf 'pliant: %0500d\\n' 1 >&2; exit 2"), "a message of 508 bytes;");
    EXPECT_EQ(faults("printf 'pliant: \\033]0;x\\007\\n' >&2; exit 2"),
              "raw bytes in the message;");
    EXPECT_EQ(faults("printf 'pliant: \\377\\n' >&2; exit 2"), "raw bytes in the message;");
    EXPECT_EQ(faults("printf 'key \\033[2J\\n'"), "raw bytes on standard output;");
    EXPECT_EQ(faults("echo '{'", {.expects_json = true}), "expected JSON on standard output;");
}

TEST_F(Judge, FindsFilesThatAreLeftBehindOrTouched) {
    const std::string refuse = "; echo 'pliant: a: b' >&2; exit 2";
    EXPECT_EQ(faults("echo x > out.nrrd" + refuse), "left behind: out.nrrd;");
    EXPECT_EQ(faults("mkdir .pliant-1-2" + refuse), "left behind: .pliant-1-2/;");
    EXPECT_EQ(faults("mkdir .pliant-3-4"), "left behind: .pliant-3-4/;");
    EXPECT_EQ(faults("echo x > \"$TMPDIR/upload\""), "left behind: .tmp/upload;");
    EXPECT_EQ(faults("echo x > a.nrrd"), "the input a.nrrd has changed;");
    EXPECT_EQ(faults("rm a.nrrd" + refuse), "the input a.nrrd is gone;");
}

TEST_F(Judge, FindsTooMuchMemory) {
    Ended run;
    run.status = 0;
    run.peak_mb = 1500;
    EXPECT_EQ(faults_of(run, {}, {}, {}), std::vector<std::string>{"1500 MB of memory"});
    EXPECT_TRUE(faults_of(run, {}, {}, {.judge_memory = false}).empty());
}

TEST(JudgeOfAnswers, FindsNoFaultInOneLineOrAList) {
    const std::vector<std::string> expected{"200", "300", "400"};
    EXPECT_TRUE(faults_of({"200", "opened\n", 9}, expected, 10).empty());
    EXPECT_TRUE(faults_of({"400", std::string(400, 'x') + "\n"}, expected, 10).empty());
    EXPECT_TRUE(faults_of({"300", std::string(5000, 'x') + "\n"}, expected, 10).empty());
}

TEST(JudgeOfAnswers, FindsEachFault) {
    const auto only = [](const Answer& answer) {
        const auto faults = faults_of(answer, {"200", "300", "400"}, 10);
        return faults.size() == 1 ? faults.front() : std::to_string(faults.size()) + " faults";
    };
    EXPECT_EQ(only({"", ""}), "no answer");
    EXPECT_EQ(only({"503", "open: a\n"}), "status 503");
    EXPECT_EQ(only({"200", "opened\n", 11}), "an answer after 11 s");
    EXPECT_EQ(only({"400", ""}), "expected one line, found 0");
    EXPECT_EQ(only({"400", "a\nb\n"}), "expected one line, found 2");
    EXPECT_EQ(only({"400", "unfinished"}), "expected one line, found 0");
    EXPECT_EQ(only({"400", std::string(401, 'x') + "\n"}), "an answer of 402 bytes");
    EXPECT_EQ(only({"400", "a.nrrd: \033[2J\n"}), "raw bytes in the answer");
    EXPECT_EQ(only({"300", "\xff\n"}), "raw bytes in the answer");
}

}  // namespace
}  // namespace pliant::mutate
