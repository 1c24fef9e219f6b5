// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The program, run in a folder of its own, so that names are short.

#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "support/temporary_folder.h"

namespace pliant::test {

/// Its standard output and errors go to `.out` and `.err` there.
/// @returns its exit status; −1 where a signal ended it
inline int run_program(const std::filesystem::path& folder, const std::string& arguments) {
    const std::string command =
        "cd '" + folder.string() + "' && '" PLIANT_PROGRAM "' " + arguments + " >.out 2>.err";
    const int raw = std::system(command.c_str());
    return WIFEXITED(raw) ? WEXITSTATUS(raw) : -1;
}

/// Each test has a folder.
class ProgramInFolder : public ::testing::Test {
  protected:
    int run(const std::string& arguments) const { return run_program(m_folder.path(), arguments); }
    std::string out() const { return bytes_of(m_folder / ".out"); }
    std::string said() const { return bytes_of(m_folder / ".err"); }
    bool exists(const char* name) const { return std::filesystem::exists(m_folder / name); }
    void write(const char* name, const std::string& text) const {
        std::ofstream(m_folder / name, std::ios::binary) << text;
    }

    TemporaryFolder m_folder;
};

}  // namespace pliant::test
