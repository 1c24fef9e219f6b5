// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Whether displacements from a file can result from pushes: in whole numbers, with the limits of
// the solvers.

#include <algorithm>

#include "chainmail/state_file.h"
#include "field/cell_block.h"

namespace pliant {
namespace {

bool link_holds(const HalfLimits& low, const HalfLimits& high, Vec3<Fixed> u, Vec3<Fixed> v,
                int b) {
    for (int a = 0; a < 3; ++a) {
        const std::int64_t difference = std::int64_t(v[a]) - u[a];
        const bool stretch = a == b;
        const std::int64_t most = stretch ? std::int64_t(low.stretch[b]) + high.stretch[b]
                                          : std::int64_t(low.shear[b]) + high.shear[b];
        const std::int64_t least = stretch ? std::int64_t(low.compress[b]) + high.compress[b]
                                           : std::int64_t(low.shear[b]) + high.shear[b];
        if (difference > most || difference < -least) return false;
    }
    return true;
}

const char* fault_of_element(const HalfLimits& half, bool is_void, Vec3<Fixed> u) {
    if (u == Vec3<Fixed>{0, 0, 0}) return "";
    if (is_void) return "an element that isn't there has moved";
    if (half.fixed) return "a fixed element has moved";
    const Vec3d away{double(u.x), double(u.y), double(u.z)};
    const double limit = half.max_movement;
    return dot(away, away) > limit * limit
               ? "an element is farther from its rest position than allowed"
               : "";
}

const char* fault_of_block(const Lattice& lattice, const CellBlock& block) {
    const Vec3i first = block.first_element();
    const auto limits = [&](Vec3i e) -> const HalfLimits& {
        return lattice.materials()[lattice.material_at(e)];
    };
    for (int z = 0; z < block.size(); ++z)
        for (int y = 0; y < block.size(); ++y)
            for (int x = 0; x < block.size(); ++x) {
                const int n = block.index(x, y, z);
                if (!block.is_touched(n)) continue;
                const Vec3i e = first + Vec3i{x, y, z};
                const Vec3<Fixed> u = block.displacement(n);
                const char* fault = fault_of_element(limits(e), lattice.is_void(e), u);
                if (*fault) return fault;
                for (int b = 0; b < 3; ++b) {
                    const Vec3i f = e + Vec3i{b == 0, b == 1, b == 2};
                    const Vec3<Fixed> v =
                        block.displacement(block.index(x + (b == 0), y + (b == 1), z + (b == 2)));
                    if (u == v || !lattice.is_linked(e, b)) continue;
                    if (!link_holds(limits(e), limits(f), u, v, b))
                        return "a link is outside of its limits";
                }
            }
    return "";
}

}  // namespace

std::string find_fault(const Lattice& lattice, const TaskArena& arena) {
    const std::vector<Vec3i> coords = cell_blocks(lattice);
    std::vector<const char*> faults(coords.size(), "");
    arena.for_each(std::int64_t(coords.size()), 4, [&](std::int64_t begin, std::int64_t end) {
        CellBlock block;
        for (auto k = std::size_t(begin); k < std::size_t(end); ++k) {
            block.load(lattice, coords[k]);
            faults[k] = fault_of_block(lattice, block);
        }
    });
    const auto found = std::find_if(faults.begin(), faults.end(), [](auto* text) { return *text; });
    return found == faults.end() ? "" : *found;
}

std::string find_imprint_fault(const Lattice& lattice, const PlasticRest& imprints) {
    const auto limits = [&](Vec3i e) -> const HalfLimits& {
        return lattice.materials()[lattice.material_at(e)];
    };
    for (const auto& [coord, brick] : imprints.bricks())
        for (int n = 0; n < lattice.elements_per_brick(); ++n) {
            const Vec3i e = lattice.element_of(coord, n);
            const auto k = std::size_t(n);
            const Vec3<Fixed> p{brick.imprint[0][k], brick.imprint[1][k], brick.imprint[2][k]};
            if (p == Vec3<Fixed>{0, 0, 0}) continue;
            if (lattice.is_void(e)) return "an element that isn't there has an imprint";
            if (limits(e).fixed) return "a fixed element has an imprint";
            for (int side = 0; side < 6; ++side) {
                const int b = side / 2;
                Vec3i f = e;
                f[b] += side % 2 ? 1 : -1;
                const Vec3<Fixed> q = imprints.imprint_at(lattice, f);
                const bool up = side % 2;
                if (p == q || !lattice.is_linked(up ? e : f, b)) continue;
                if (!link_holds(limits(up ? e : f), limits(up ? f : e), up ? p : q, up ? q : p, b))
                    return "an imprint is outside of a link's limits";
            }
        }
    return "";
}

}  // namespace pliant
