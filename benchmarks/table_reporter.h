// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A readable table: one line per case, with the reference of the same run and the floor. Google
// Benchmark's own reporter writes the same numbers to a JSON file.

#pragma once

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

namespace pliant::bench {

class TableReporter : public benchmark::BenchmarkReporter {
  public:
    bool ReportContext(const Context& context) override;
    void ReportRuns(const std::vector<Run>& runs) override;

  private:
    std::string m_family;  ///< of the last line: a change starts a heading
};

}  // namespace pliant::bench
