// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Common parts of the tests of relaxation: simple tissues, and visits of every element and link.

#pragma once

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "chainmail/chainmail_impl.h"
#include "chainmail/tissues.h"
#include "lattice/lattice.h"
#include "relax/tool_contact.h"

namespace pliant::test {

inline bool before(Vec3i p, Vec3i q) {
    return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x);
}
struct Before {
    bool operator()(Vec3i p, Vec3i q) const { return before(p, q); }
};
using Displacements = std::map<Vec3i, Vec3<Fixed>, Before>;

/// Values of all elements with a brick.
inline Displacements displacements(const Lattice& lattice) {
    Displacements all;
    for (const int index : lattice.resident_bricks())
        for (int n = 0; n < lattice.elements_per_brick(); ++n) {
            const Vec3i e = lattice.element_of(lattice.brick(index).coord, n);
            all[e] = lattice.displacement_at(e);
        }
    return all;
}

inline Vec3i beside(Vec3i e, int side) {
    e[side / 2] += side % 2 ? 1 : -1;
    return e;
}

inline MaterialLaw one_material(double limit, double max_movement_mm = 500) {
    return [=](int) {
        return ElementLimits{{limit, limit, limit},
                             {limit, limit, limit},
                             {limit, limit, limit},
                             max_movement_mm,
                             false};
    };
}

inline RelaxReport relaxed(ChainMail& tissue, const RelaxOptions& options) {
    const auto report = tissue.relax(options);
    EXPECT_TRUE(report.ok()) << report.error().message;
    return *report;
}

/// Largest distance of a link from its limits [units], directly from the law.
inline std::int64_t worst_link(const ChainMail& tissue, const MaterialLaw& law) {
    const Lattice& lattice = lattice_of(tissue);
    const Grid& grid = lattice.grid();
    const auto half = [&](double fraction, int b) {
        return std::int64_t(std::floor(grid.spacing_mm[b] * fraction / 2 * (1 << 20)));
    };
    std::int64_t worst = 0;
    for (const auto& [e, u] : displacements(lattice))
        for (int side = 0; side < 6; ++side) {
            const int b = side / 2;
            const Vec3i f = beside(e, side), low = side % 2 ? e : f;
            const BrickEdits* edits =
                lattice.may_have_gaps() ? lattice.edits_of(lattice.brick_of(low)) : nullptr;
            if (edits && ((*edits)[std::size_t(lattice.index_in_brick(low))] & (kCutX << b)))
                continue;
            if (lattice.is_void(e) || lattice.is_void(f)) continue;
            const ElementLimits p = law(lattice.value_at(e)), q = law(lattice.value_at(f));
            const Vec3<Fixed> v = lattice.displacement_at(f);
            for (int a = 0; a < 3; ++a) {
                const std::int64_t up = (side % 2 ? 1 : -1) * (std::int64_t(v[a]) - u[a]);
                const auto& most = a == b ? &ElementLimits::stretch : &ElementLimits::shear;
                const auto& least = a == b ? &ElementLimits::compress : &ElementLimits::shear;
                worst = std::max(worst, up - half((p.*most)[b], b) - half((q.*most)[b], b));
                worst = std::max(worst, -up - half((p.*least)[b], b) - half((q.*least)[b], b));
            }
        }
    return worst;
}

inline double distance_to_tool(const Grid& grid, const Lattice& lattice, Vec3i e,
                               const RelaxTool& tool) {
    const Vec3<Fixed> u = lattice.displacement_at(e);
    const Vec3d h = grid.spacing_mm;
    const Vec3d x =
        world_from_voxel(grid, {e.x + mm_from_units(u.x) / h.x, e.y + mm_from_units(u.y) / h.y,
                                e.z + mm_from_units(u.z) / h.z});
    return std::sqrt(squared_distance_of_segments(x, x, tool.from_mm, tool.to_mm));
}

}  // namespace pliant::test
