// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Adaptive sub-steps. Contact moves the wall's particles by h² w F in a sub-step as if they were
// free; the constraints that hold them act in the next sub-steps only. So the dent of one sub-step
// must be small. Where it is too large, sub-steps get shorter at once and then longer gradually.

#pragma once

#include <algorithm>
#include <cmath>

namespace pliant::catheter {

class ContactPace {
  public:
    /// @param longest_s  a sub-step's, without contact
    explicit ContactPace(double longest_s) : m_longest(longest_s), m_wanted(longest_s) {}

    /// How many sub-steps of at most the wanted length a time takes.
    int sub_steps(double time_s) const {
        return std::max(1, int(std::ceil(time_s / m_wanted - kRounding)));
    }
    /// After a sub-step in which contact pushed a particle so far. @returns whether the next ones
    /// have to be shorter
    bool is_too_long_after(double h, double pushed_mm) {
        const double fits = pushed_mm > 0 ? h * std::sqrt(kMostPush_mm / pushed_mm) : m_longest;
        m_wanted = std::clamp(std::min(fits, kGrowth * m_wanted), kShortest * m_longest, m_longest);
        return h > kSlack * m_wanted;
    }

    double wanted_s() const { return m_wanted; }
    void set_wanted_s(double wanted_s) {
        m_wanted = std::clamp(wanted_s, kShortest * m_longest, m_longest);
    }

  private:
    static constexpr double kMostPush_mm = 0.03;
    static constexpr double kGrowth = 1.02, kSlack = 1.1, kShortest = 0.02, kRounding = 1e-9;

    double m_longest, m_wanted;
};

}  // namespace pliant::catheter
