// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes from a formula, and lattices whose displacements are set by hand.

#pragma once

#include <cmath>
#include <vector>

#include "lattice/lattice.h"

namespace pliant::test {

template <class Value>
Volume make_volume(Vec3i size, Vec3d spacing_mm, Value value) {
    Volume volume;
    volume.grid.size = size;
    volume.grid.spacing_mm = spacing_mm;
    using T = decltype(value(Vec3d{}));
    std::vector<T> voxels;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                voxels.push_back(value(Vec3d{double(x), double(y), double(z)}));
    volume.voxels = voxels;
    return volume;
}

/// Displaces every element of a box [mm along the lattice's axes], as a solver would.
template <class Displacement>
void displace(Lattice& lattice, Box3i box, Displacement displacement) {
    const std::uint64_t now = lattice.tick();
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x) {
                const ElementRef element = lattice.ensure_element({x, y, z});
                const Vec3d u = displacement(Vec3d{double(x), double(y), double(z)});
                Brick& brick = lattice.brick(element.brick);
                for (int a = 0; a < 3; ++a)
                    brick.u[std::size_t(a)][element.index] = units_from_mm(u[a]);
                brick.changed_at = now;
            }
    for (const int brick : lattice.resident_bricks()) lattice.update_bounds(brick);
    lattice.drop_still_bricks();
}

template <class Displacement>
Lattice displaced_lattice(const Volume& volume, Box3i box, Displacement displacement) {
    Lattice lattice(volume, {draeger_law({})}, 8, false);
    displace(lattice, box, displacement);
    return lattice;
}

/// Flags of single elements, beside those that they have.
inline void edit(Lattice& lattice, Vec3i element, int flags) {
    const Vec3i coord = lattice.brick_of(element);
    const BrickEdits* now = lattice.edits_of(coord);
    BrickEdits edits = now ? *now : BrickEdits(std::size_t(lattice.elements_per_brick()), 0);
    auto& flag = edits[std::size_t(lattice.index_in_brick(element))];
    flag = std::uint8_t(flag | flags);
    lattice.set_edits(coord, std::move(edits));
}

/// φ(X) for a position X of the lattice at rest [voxels].
inline Vec3d deformed_place(const Field& lattice, Vec3d x) {
    const Vec3i low{int(std::floor(x.x)), int(std::floor(x.y)), int(std::floor(x.z))};
    Vec3d place = x;
    for (int c = 0; c < 8; ++c) {
        const Vec3i corner{c & 1, c >> 1 & 1, c >> 2};
        double weight = 1;
        for (int a = 0; a < 3; ++a) {
            const double t = x[a] - low[a];
            weight *= corner[a] ? t : 1 - t;
        }
        const Vec3<Fixed> u = lattice.displacement_at(low + corner);
        for (int a = 0; a < 3; ++a)
            place[a] += weight * mm_from_units(u[a]) / lattice.grid().spacing_mm[a];
    }
    return place;
}

inline double smooth_value(Vec3d p) {
    return 100 * std::sin(0.11 * p.x + 1) * std::cos(0.09 * p.y) + 60 * std::sin(0.1 * p.z);
}

}  // namespace pliant::test
