// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "relax/relax_kernel.h"

#include "relax/relax_lanes.h"

namespace pliant {

Fixed relax_colour(const RelaxedBrick& brick, int colour, double over_relaxation) {
#if defined(__x86_64__)
    static const bool has_avx2 = __builtin_cpu_supports("avx2");
    if (has_avx2) return relax_colour_avx2(brick, colour, over_relaxation);
#endif
    return relax_colour_plain(brick, colour, over_relaxation);
}

Fixed relax_colour_plain(const RelaxedBrick& brick, int colour, double over_relaxation) {
    return move_brick(brick, colour, over_relaxation - 1);
}

}  // namespace pliant
