// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Adaptive sub-steps. In a sub-step, contact moves the wall's particles by h² w F as if they were
// free; the constraints that hold them act only in the next sub-steps. So the dent of one sub-step
// must be small. If it is too large, sub-steps shrink at once and grow again gradually.

#pragma once

#include <algorithm>
#include <cmath>

namespace pliant::catheter {

class ContactPace {
  public:
    /// @param longest_s  maximum length of a sub-step
    explicit ContactPace(double longest_s) : m_longest(longest_s), m_wanted(longest_s) {}

    /// Number of sub-steps of at most the wanted length in a time.
    int sub_steps(double time_s) const {
        return std::max(1, int(std::ceil(time_s / m_wanted - kRounding)));
    }
    /// Updates the wanted length after a sub-step. @param pushed_mm  largest displacement of a
    /// particle by contact. @returns whether the next sub-steps must be shorter
    bool is_too_long_after(double h, double pushed_mm) {
        const double fits = pushed_mm > 0 ? h * std::sqrt(kMaxPush_mm / pushed_mm) : m_longest;
        m_wanted = std::clamp(std::min(fits, kGrowth * m_wanted), kShortest * m_longest, m_longest);
        return h > kSlack * m_wanted;
    }

    double wanted_s() const { return m_wanted; }
    void set_wanted_s(double wanted_s) {
        m_wanted = std::clamp(wanted_s, kShortest * m_longest, m_longest);
    }

  private:
    static constexpr double kMaxPush_mm = 0.03;
    static constexpr double kGrowth = 1.02, kSlack = 1.1, kShortest = 0.02, kRounding = 1e-9;

    double m_longest, m_wanted;
};

}  // namespace pliant::catheter
