// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scalar version of lattice_row.inc.

#include <hwy/base.h>

#include <cstddef>

#include "fem/lattice_stiffness.h"

namespace pliant {
namespace {

#include "fem/lattice_row.inc"

struct PlainOps {
    using V = double;
    static constexpr int kLanes = 1;

    static double load(const double* from) { return *from; }
    static void store(double v, double* to) { *to = v; }
    static double set(double v) { return v; }
    static double add(double a, double b) { return a + b; }
    static double sub(double a, double b) { return a - b; }
    static double mul(double a, double b) { return a * b; }
};

}  // namespace

void add_lattice_row_plain(const LatticeFactors& factors, const LatticeRow& row) {
    add_row<PlainOps>(factors, row);
}

}  // namespace pliant
