// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases with closed forms or published figures: expected and measured values, and the tolerance.
// The page shows them, and the tests check them, with the same numbering.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace pliant::results {

struct Case {
    int number = 0;
    std::string what;
    double expected = 0, measured = 0;
    double tolerance = 0;     ///< of the difference
    bool is_share = false;    ///< relative to the expected value
    bool is_at_most = false;  ///< smaller values pass too
};
using Cases = std::vector<Case>;

bool holds(const Case& c);
/// Columns: number, quantity, expected, measured, tolerance, passed.
std::vector<std::string> row_of(const Case& c);

Case within_share(int number, std::string what, double expected, double measured, double share);
Case within(int number, std::string what, double expected, double measured, double difference);
/// A quantity with the expected value 0.
Case at_most(int number, std::string what, double measured, double most);

Cases gradient_cases();      // 1
Cases momentum_cases();      // 2
Cases spring_cases();        // 3
Cases chain_cases();         // 4
Cases cantilever_cases();    // 5
Cases elastica_cases();      // 6
Cases joint_cases();         // 7
Cases arc_cases();           // 8
Cases ring_cases();          // 9
Cases falling_beam_cases();  // 10
Cases tube_cases();          // 11
Cases drop_cases();          // 12
Cases turned_cases();        // 13
Cases hash_cases();          // 14
Cases overlap_cases();       // 15

/// Random numbers that are identical on every machine.
class Numbers {
  public:
    explicit Numbers(std::uint64_t seed) : m_engine(seed) {}
    double real(double low, double high) {
        return low + (high - low) * (double(m_engine() >> 11) * 0x1p-53);
    }
    Vec3d vector(double most) {
        const double x = real(-most, most), y = real(-most, most), z = real(-most, most);
        return {x, y, z};
    }

  private:
    std::mt19937_64 m_engine;
};

inline const TaskArena& one_thread() {
    static const TaskArena arena(1);
    return arena;
}

}  // namespace pliant::results
