// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The program, run in a folder of its own, so that names are short.

#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>
#include <string>

#include "support/temporary_folder.h"

namespace pliant::test {

/// Removes progress lines, because a busy machine has more of them.
inline std::string without_progress(const std::string& text) {
    std::string rest;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.find(" % after ") == std::string::npos) rest += line + "\n";
    return rest;
}

/// Its standard output and errors go to `.out` and `.err` there.
/// @returns its exit status; −1 where a signal ended it
/// @param before  the shell does before it, as in "ulimit -f 8 &&"
inline int run_program(const std::filesystem::path& folder, const std::string& arguments,
                       const std::string& before = {}) {
    const std::string command = "cd '" + folder.string() + "' && ( " + before +
                                " '" PLIANT_PROGRAM "' " + arguments + " ) >.out 2>.err";
    const int raw = std::system(command.c_str());
    return WIFEXITED(raw) ? WEXITSTATUS(raw) : -1;
}

/// Each test has a folder.
class ProgramInFolder : public ::testing::Test {
  protected:
    int run(const std::string& arguments, const std::string& before = {}) const {
        return run_program(m_folder.path(), arguments, before);
    }
    std::string out() const { return bytes_of(m_folder / ".out"); }
    std::string said() const { return without_progress(bytes_of(m_folder / ".err")); }
    /// Names of all files in the folder, except the program's output.
    std::set<std::string> names() const {
        std::set<std::string> found;
        for (const auto& entry : std::filesystem::directory_iterator(m_folder.path()))
            found.insert(entry.path().filename().string());
        for (const char* own : {".out", ".err"}) found.erase(own);
        return found;
    }
    bool exists(const char* name) const { return std::filesystem::exists(m_folder / name); }
    void write(const char* name, const std::string& text) const {
        std::ofstream(m_folder / name, std::ios::binary) << text;
    }

    TemporaryFolder m_folder;
};

/// The tests of a suite share a folder. A suite that fills it does so in its own SetUpTestSuite(),
/// after that of this class.
class ProgramInSharedFolder : public ::testing::Test {
  protected:
    static void SetUpTestSuite() { s_folder = std::make_unique<TemporaryFolder>(); }
    static void TearDownTestSuite() { s_folder.reset(); }
    static int run(const std::string& arguments) {
        return run_program(s_folder->path(), arguments);
    }
    static std::filesystem::path file(const std::string& name) { return *s_folder / name; }
    static std::string out() { return bytes_of(file(".out")); }
    static std::string said() { return without_progress(bytes_of(file(".err"))); }

  private:
    static inline std::unique_ptr<TemporaryFolder> s_folder;
};

}  // namespace pliant::test
