// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A progress bar on standard error. If that is not a terminal, a line every few seconds, from the
// second second on.

#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace pliant::app {

class ProgressBar {
  public:
    /// @param work  its name, as in "making airway"
    explicit ProgressBar(std::string work);
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    /// @param fraction  0…1
    void show(double fraction);

  private:
    void draw(int percent);
    void tell_at_times();

    std::string m_what;
    std::atomic<int> m_percent = 0;
    int m_drawn = -1;
    bool m_terminal;
    std::chrono::steady_clock::time_point m_start;
    std::mutex m_mutex;
    std::condition_variable m_over_changed;
    bool m_over = false;
    std::thread m_teller;  ///< updates during long steps too; absent if no thread is available
};

/// Clears the bar's line on a terminal, before a message.
void clear_progress_line() noexcept;

}  // namespace pliant::app
