// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "field/writable_field.h"

#include <algorithm>

namespace pliant {

FieldBrick& WritableField::make_brick(std::byte* memory) {
    FieldBrick& made = m_made.emplace_back();
    for (Fixed*& array : made.u) array = next_array<Fixed>(memory);
    return made;
}

int WritableField::ensure_brick(Vec3i coord) {
    const int found = find_brick(coord);
    return found >= 0 ? found : add_brick(coord);
}

void WritableField::written(FieldBrick& brick, std::uint64_t now) const {
    update_bounds(brick);
    brick.is_unplaced = false;
    brick.changed_at = now;
}

std::unique_ptr<const WritableField> copy_of(const Field& field) {
    auto copy =
        std::make_unique<WritableField>(field.grid(), field.brick_size(), field.is_bounded());
    // Edits first: bricks read theirs at their creation.
    for (const auto& [coord, edits] : field.all_edits()) copy->set_edits(coord, edits);
    field.for_each_brick([&](const FieldBrick& brick) {
        if (is_at_rest(brick)) return;
        FieldBrick& made = copy->brick(copy->ensure_brick(brick.coord));
        if (brick.is_unplaced) {
            copy->place_at_rest(made);
            return;
        }
        for (std::size_t a = 0; a < 3; ++a)
            std::copy_n(brick.u[a], field.elements_per_brick(), made.u[a]);
        made.is_unplaced = false;
        made.u_min = brick.u_min;
        made.u_max = brick.u_max;
        made.changed_at = brick.changed_at;
    });
    return copy;
}

}  // namespace pliant
