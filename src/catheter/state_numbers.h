// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A state as a row of numbers: the same functions write it and read it back, bit for bit.

#pragma once

#include <pliant/pbd_rod.h>
#include <pliant/vec.h>

#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace pliant::catheter {

class StateNumbers {
  public:
    StateNumbers() = default;  ///< writes
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
    void place(Vec3d& v) {
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
    /// As many as there are.
    void places(std::vector<Vec3d>& all) {
        for (Vec3d& v : all) place(v);
    }
    /// What is left is all that there is.
    template <class Whole>
    void wholes_to_the_end(std::vector<Whole>& all) {
        if (m_reads) all.assign(m_left.size(), 0);
        for (Whole& v : all) whole(v);
    }

    bool reads() const { return m_reads; }
    /// Nothing was missing, no number, beyond all bounds, or too much. @pre all has been read
    bool is_good() const { return m_good && m_left.empty(); }
    std::vector<double> take() { return std::move(m_numbers); }

  private:
    static constexpr double kLargest = 0x1p31;  ///< what is larger, no simulation comes to
    static constexpr double kFarthest = 1e6;    ///< [mm], also of a velocity [mm/s]
    static constexpr double kNotUnit = 1e-6;    ///< squared length of a rotation, less 1

    std::vector<double> m_numbers;
    std::span<const double> m_left;
    bool m_reads = false, m_good = true;
};

}  // namespace pliant::catheter
