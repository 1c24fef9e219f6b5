// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "relax/relax_kernel.h"

#if defined(__x86_64__)
#define PLIANT_RELAX_FOR_AVX2
#include "relax/relax_lanes.h"

namespace pliant {

Fixed relax_colour_avx2(const RelaxedBrick& brick, int colour, double over_relaxation) {
    return move_brick(brick, colour, over_relaxation - 1);
}

}  // namespace pliant
#endif
