// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Serialises a state as numbers: the same functions write it and read it back, bit for bit.

#pragma once

#include <pliant/core/vec.h>
#include <pliant/models/pbd.h>

#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace pliant::catheter {

class StateNumbers {
  public:
    StateNumbers() = default;  ///< for writing
    explicit StateNumbers(std::span<const double> numbers) : m_left(numbers), m_reads(true) {}

    void value(double& v) {
        if (!m_reads) {
            m_numbers.push_back(v);
        } else if (m_left.empty() || !(std::abs(m_left[0]) <= kLargest)) {
            m_good = false;
        } else {
            v = m_left[0];
            m_left = m_left.subspan(1);
        }
    }
    template <class Whole>
    void whole(Whole& v) {
        auto number = double(v);
        value(number);
        if (!(std::abs(number) < kLargest)) m_good = false;
        if (m_good) v = Whole(number);
    }
    void position(Vec3d& v) {
        for (int c = 0; c < 3; ++c) {
            value(v[c]);
            if (!(std::abs(v[c]) <= kFarthest)) m_good = false;
        }
    }
    void turn(Rotation& q) {
        for (double* part : {&q.w, &q.x, &q.y, &q.z}) value(*part);
        const double square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
        if (!(std::abs(square - 1) <= kNotUnit)) m_good = false;
    }
    /// Exchanges all elements; the count is fixed.
    void positions(std::vector<Vec3d>& all) {
        for (Vec3d& v : all) position(v);
    }
    /// Exchanges all remaining numbers.
    template <class Whole>
    void wholes_to_the_end(std::vector<Whole>& all) {
        if (m_reads) all.assign(m_left.size(), 0);
        for (Whole& v : all) whole(v);
    }

    bool reads() const { return m_reads; }
    /// Whether all numbers were present, finite and in range, and none is left. @pre everything was
    /// read
    bool is_good() const { return m_good && m_left.empty(); }
    std::vector<double> take() { return std::move(m_numbers); }

  private:
    static constexpr double kLargest = 0x1p31;  ///< limit of all values
    static constexpr double kFarthest = 1e6;    ///< limit of positions [mm] and velocities [mm/s]
    static constexpr double kNotUnit = 1e-6;    ///< tolerance of a rotation's squared length

    std::vector<double> m_numbers;
    std::span<const double> m_left;
    bool m_reads = false, m_good = true;
};

}  // namespace pliant::catheter
