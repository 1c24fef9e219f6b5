// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Plain sweeps.inc: the scalar twin of sweeps_vector.cpp.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "elastic/sweeps.h"

#include <hwy/base.h>

namespace pliant {
namespace {

#include "elastic/sweeps.inc"

struct PlainOps {
    using V = float;
    static constexpr std::size_t kLanes = 1;

    static float load(const float* from) { return *from; }
    static void store(float v, float* to) { *to = v; }
    static float set(float v) { return v; }
    static float add(float a, float b) { return a + b; }
    static float sub(float a, float b) { return a - b; }
    static float mul(float a, float b) { return a * b; }
    static float div(float a, float b) { return a / b; }
    static float sqrt(float a) { return std::sqrt(a); }
    static float abs(float a) { return std::abs(a); }
    static float max(float a, float b) { return std::max(a, b); }
    static bool any_positive(float a) { return a > 0; }
    static float if_positive(float test, float value) { return test > 0 ? value : 0.0F; }
    static float unless_zero(float test, float value) {
        return std::bit_cast<std::uint32_t>(test) == 0 ? 0.0F : value;
    }
};

}  // namespace

void sweep_planes_plain(const LatticeSweep& sweep, int begin, int end, float* workspace) {
    sweep_with<PlainOps>(sweep, begin, end, workspace);
}
void turn_planes_plain(const LatticeSweep& sweep, const CellRotations& rotations, int steps,
                       int begin, int end) {
    turn_planes_with<PlainOps>(sweep, rotations, steps, begin, end);
}

}  // namespace pliant
