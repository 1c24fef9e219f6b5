// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The constraints for scalar numbers, float and double.

#pragma once

#include <cmath>

namespace pliant::pbd {

template <class V>
V constant(double number) {
    return V(number);
}
template <class V>
V root(V v) {
    return std::sqrt(v);
}
template <class V>
V larger(V a, V b) {
    return a > b ? a : b;
}
template <class V>
V smaller(V a, V b) {
    return a < b ? a : b;
}
template <class V>
V where_positive(V test, V yes, V no) {
    return test > V(0) ? yes : no;
}

#include "pbd/arc_tangent.inc"

inline double arc_tangent(double y, double x) {
    return std::atan2(y, x);
}
inline float arc_tangent(float y, float x) {
    return polynomial_arc_tangent(y, x);
}

#include "pbd/constraints.inc"

}  // namespace pliant::pbd
