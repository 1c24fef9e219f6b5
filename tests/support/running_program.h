// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The program while it runs, to send signals to it.

#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace pliant::test {

class RunningProgram {
  public:
    /// Its standard output and errors go to `.out` and `.err` in the folder.
    RunningProgram(const std::filesystem::path& folder, std::vector<std::string> arguments) {
        m_process = ::fork();
        if (m_process != 0) return;
        for (const auto& [name, number] : {std::pair(".out", 1), std::pair(".err", 2)})
            ::dup2(::open((folder / name).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), number);
        std::vector<char*> words;
        arguments.insert(arguments.begin(), PLIANT_PROGRAM);
        for (std::string& argument : arguments) words.push_back(argument.data());
        words.push_back(nullptr);
        if (::chdir(folder.c_str()) == 0) ::execv(PLIANT_PROGRAM, words.data());
        ::_exit(127);
    }
    ~RunningProgram() {
        if (m_process > 0) end(SIGKILL);
    }
    RunningProgram(const RunningProgram&) = delete;
    RunningProgram& operator=(const RunningProgram&) = delete;

    /// @returns its exit status, or minus the signal that ended it
    int end(int signal) {
        ::kill(m_process, signal);
        int raw = 0;
        ::waitpid(m_process, &raw, 0);
        m_process = -1;
        return WIFEXITED(raw) ? WEXITSTATUS(raw) : -WTERMSIG(raw);
    }

  private:
    pid_t m_process = -1;
};

/// Waits for a condition, for half a minute at most. @returns whether it came about
template <class Condition>
bool comes_about(const Condition& condition) {
    for (int n = 0; n < 3000; ++n) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

}  // namespace pliant::test
