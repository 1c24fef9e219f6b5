// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/lattice_copy.h"

#include <algorithm>

namespace pliant {

std::unique_ptr<const Lattice> copy_of(const Lattice& lattice, const Volume& volume) {
    auto copy = std::make_unique<Lattice>(volume, lattice.material_map(), lattice.brick_size(),
                                          lattice.is_bounded());
    // Edits first: bricks find theirs when they are made.
    for (const auto& [coord, edits] : lattice.all_edits()) copy->set_edits(coord, edits);
    lattice.for_each_brick([&](const Brick& brick) {
        if (is_at_rest(brick)) return;
        Brick& made = copy->brick(copy->ensure_blank_brick(brick.coord));
        if (brick.is_unplaced) {
            copy->place_at_rest(made);
            return;
        }
        for (std::size_t a = 0; a < 3; ++a)
            std::copy_n(brick.u[a], lattice.elements_per_brick(), made.u[a]);
        made.is_unplaced = false;
        made.u_min = brick.u_min;
        made.u_max = brick.u_max;
        made.changed_at = brick.changed_at;
    });
    return copy;
}

}  // namespace pliant
