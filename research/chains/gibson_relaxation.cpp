// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One sweep of Gibson's elastic relaxation. The report says that elements which do not satisfy
// their elastic constraints are adjusted to reduce the energy; the mean of the excesses and the
// threshold are those of the program published with it, whose author's lattice is a box of voxels.

#include <pliant/research/orderings.h>

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Signed distance of a value from −low…high.
float excess(float value, float low, float high) {
    return value > high ? value - high : value < -low ? value + low : 0.0f;
}

struct Sides {
    float compress, stretch, shear;  // [mm]
};

}  // namespace

std::int64_t relax_elastically(const ChainLattice& lattice, const ElasticLimits& limits,
                               std::span<const std::int32_t> held,
                               std::span<Vec3f> displacement_mm) {
    const Grid grid{.size = lattice.size};
    const auto threshold = float(limits.threshold_mm);
    Sides sides[3];
    for (int b = 0; b < 3; ++b)
        sides[b] = {float(lattice.spacing_mm[b] * limits.compress),
                    float(lattice.spacing_mm[b] * limits.stretch),
                    float(lattice.spacing_mm[b] * limits.shear)};
    const std::int32_t stride[3] = {1, grid.size.x, grid.size.x * grid.size.y};
    const auto is_there = [&](std::int32_t e) {
        return lattice.present.empty() || lattice.present[std::size_t(e)];
    };
    auto next_held = held.begin();
    std::int64_t moved = 0;
    std::int32_t e = -1;
    const auto relax_element = [&](Vec3i ijk) {
        const Vec3f u = displacement_mm[std::size_t(e)];
        Vec3f sum{0, 0, 0};
        int count = 0;
        const auto add = [&](int b, std::int32_t neighbour, bool neighbour_is_above) {
            if (!is_there(neighbour)) return;
            const Vec3f ahead = displacement_mm[std::size_t(neighbour)] - u;
            const Sides& side = sides[b];
            for (int a = 0; a < 3; ++a) {
                const float low =
                    a != b ? side.shear : (neighbour_is_above ? side.compress : side.stretch);
                const float high =
                    a != b ? side.shear : (neighbour_is_above ? side.stretch : side.compress);
                sum[a] += excess(ahead[a], low, high);
            }
            ++count;
        };
        for (int b = 0; b < 3; ++b) {
            if (ijk[b] > 0) add(b, e - stride[b], false);
            if (ijk[b] + 1 < grid.size[b]) add(b, e + stride[b], true);
        }
        if (count == 0) return;
        const Vec3f step = (1.0f / float(count)) * sum;
        if (std::max({std::abs(step.x), std::abs(step.y), std::abs(step.z)}) <= threshold) return;
        displacement_mm[std::size_t(e)] = u + step;
        ++moved;
    };
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) {
                ++e;
                if (next_held != held.end() && *next_held == e)
                    ++next_held;
                else if (is_there(e))
                    relax_element({i, j, k});
            }
    return moved;
}

}  // namespace pliant
