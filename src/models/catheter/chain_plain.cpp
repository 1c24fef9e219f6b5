// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scalar version of chain_solve.inc.

#include "catheter/chain.h"

namespace pliant::catheter {
namespace {

#include "catheter/chain_solve.inc"

struct PlainChainOps {
    static constexpr int kLanes = 1;

    static double load(const double* from) { return *from; }
    static void store(double v, double* to) { *to = v; }
    static double set(double v) { return v; }
    static double sub(double a, double b) { return a - b; }
    static double mul(double a, double b) { return a * b; }
};

}  // namespace

void solve_chain_plain(ChainBlock<6>* diagonal, ChainBlock<6>* upper, std::size_t count) {
    solve_chain_of<PlainChainOps>(diagonal, upper, count);
}

}  // namespace pliant::catheter
