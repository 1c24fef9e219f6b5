// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <chrono>

namespace pliant {

/// Wall-clock time since it was made.
class Stopwatch {
  public:
    double ms() const { return 1e3 * s(); }
    double s() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    }

  private:
    std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

}  // namespace pliant
