// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A progress bar on standard error; silent when that is no terminal.

#pragma once

#include <string>

namespace pliant::app {

class ProgressBar {
  public:
    explicit ProgressBar(std::string what);
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    /// @param fraction  0…1
    void show(double fraction);

  private:
    std::string m_what;
    int m_percent = -1;
    bool m_terminal;
};

}  // namespace pliant::app
