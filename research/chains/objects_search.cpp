// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chains/objects_search.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Motion of an element for the whole shift of the solve in progress, 0…|shift_a|.
/// @pre the solve is not a shared one
Vec3<Fixed> raise_of(const Brick& brick, std::size_t index, Vec3<Fixed> shift) {
    Vec3<Fixed> raise{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        if (shift[a] == 0 || !brick.reached[c]) continue;
        const Fixed u = brick.is_unplaced ? 0 : brick.u[c][index];
        raise[a] = brick.raised[c][index] - (shift[a] > 0 ? u : -u);
    }
    return raise;
}

}  // namespace

Position half_extents(const Grid& grid) {
    Position half{};
    for (int a = 0; a < 3; ++a)
        half[a] = std::llround(std::floor(grid.spacing_mm[a] * kUnitsPerMm / 2)) - 1;
    return half;
}

SolidBrick solid_elements(const PlacedLattice& object, Vec3i coord, const Vec3<Fixed>* shift) {
    const Lattice& lattice = *object.lattice;
    const int index = lattice.find_brick(coord);
    const BrickEdits* edits = lattice.edits_of(coord);
    SolidBrick solid;
    for (int n = 0; n < lattice.elements_per_brick(); ++n) {
        const auto i = std::size_t(n);
        const Vec3i e = lattice.element_of(coord, n);
        if (!contains(voxel_box(lattice.grid()), e)) continue;
        if (edits && ((*edits)[i] & kVoid)) continue;
        Vec3<Fixed> u{0, 0, 0}, raise{0, 0, 0};
        if (index >= 0) {
            const Brick& brick = lattice.brick(index);
            u = {brick.u[0][i], brick.u[1][i], brick.u[2][i]};
            if (shift) raise = raise_of(brick, i, *shift);
        }
        if (shift && raise == Vec3<Fixed>{0, 0, 0}) continue;
        const Position position = object.position_of(e, u);
        Position after = position;
        for (int a = 0; shift && a < 3; ++a) after[a] += (*shift)[a] > 0 ? raise[a] : -raise[a];
        if (solid.elements.empty()) solid.box = {position, position};
        for (int a = 0; a < 3; ++a) {
            solid.box.low[a] = std::min({solid.box.low[a], position[a], after[a]});
            solid.box.high[a] = std::max({solid.box.high[a], position[a], after[a]});
        }
        solid.elements.push_back({e, position, raise});
    }
    return solid;
}

void SolidSearch::for_each_brick(const PositionBox& box,
                                 const std::function<void(Vec3i coord)>& visit) const {
    const PositionBox own{box.low - m_object.base, box.high - m_object.base};
    m_search.for_each_brick(own, [&](Vec3i coord, const PositionBox&) { visit(coord); });
}

bool SolidSearch::range_in(Vec3i coord, const PositionBox& box, Vec3i& begin, Vec3i& end) const {
    const Lattice& lattice = *m_object.lattice;
    const Grid& grid = lattice.grid();
    const int index = lattice.find_brick(coord);
    for (int a = 0; a < 3; ++a) {
        const Fixed lowest = index < 0 ? 0 : lattice.brick(index).u_min[a];
        const Fixed highest = index < 0 ? 0 : lattice.brick(index).u_max[a];
        const double spacing = grid.spacing_mm[a] * kUnitsPerMm;
        // One extra unit for the rounding of rest positions.
        const auto low = double(box.low[a] - m_object.base[a] - highest - 1) / spacing;
        const auto high = double(box.high[a] - m_object.base[a] - lowest + 1) / spacing;
        const int first = lattice.brick_size() * coord[a];
        const int last = std::min(first + lattice.brick_size(), grid.size[a]) - 1;
        begin[a] = int(std::clamp(std::ceil(low), double(std::max(first, 0)), double(last + 1)));
        end[a] = int(std::clamp(std::floor(high), double(first - 1), double(last))) + 1;
        if (begin[a] >= end[a]) return false;
    }
    return true;
}

}  // namespace pliant
