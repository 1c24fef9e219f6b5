// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One `pliant serve` that scans are uploaded to, one after the other. It is started again where
// one of them ends it.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mutate/judge.h"
#include "mutate/runs.h"
#include "support/temporary_folder.h"

namespace pliant::mutate {

class UploadServer : public Target {
  public:
    /// Ends this program where the server doesn't start.
    UploadServer(Sources sources, bool judge_memory);
    /// Uploads, opens and, where it was opened, saves a scan.
    Outcome take(const Files& files, const std::string& command) override;
    /// Ends the server.
    std::vector<std::string> end() override;

  private:
    void start();
    std::string target(const std::string& path) const;
    Answer ask(const std::string& path, const std::string* body);
    /// @returns the last answer
    Answer upload(const Files& files, bool first_series, std::vector<std::string>& faults);
    Answer choose(const Answer& choice, bool first_series, std::vector<std::string>& faults);
    void judge(const Answer& answer, const std::vector<std::string>& expected,
               std::vector<std::string>& faults) const;
    void judge_server(bool is_silent, std::vector<std::string>& faults);
    void judge_leftovers(std::vector<std::string>& faults) const;

    Sources m_sources;
    bool m_judge_memory;
    test::TemporaryFolder m_folder;
    std::unique_ptr<Child> m_server;
    int m_port = 0;
    int m_uploads = 0;
    std::string m_token;
    std::size_t m_said = 0;  ///< bytes of standard error that were judged
};

}  // namespace pliant::mutate
