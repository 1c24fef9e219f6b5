// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of a drag as plain loops: the readable twin of drag_vector.cpp.

#include <algorithm>
#include <array>
#include <cstdint>

#include "propagate/drag_kernel.h"

namespace pliant {
namespace {

constexpr int kLine = 16;

DraggedBrick move(std::span<DraggedComponent> components, int count, bool /*known*/) {
    DraggedBrick result;
    std::array<Fixed, 3> lowest{INT32_MAX, INT32_MAX, INT32_MAX};
    for (int begin = 0; begin < count; begin += kLine) {
        const int end = std::min(begin + kLine, count);
        const bool may = std::any_of(components.begin(), components.end(), [&](const auto& c) {
            return *std::max_element(c.raised + begin, c.raised + end) - c.left > c.lowest;
        });
        result.has_wide_bounds |= !may;
        if (!may) continue;
        for (int n = begin; n < end; ++n) {
            bool rose = false;
            for (std::size_t k = 0; k < components.size(); ++k) {
                const DraggedComponent& c = components[k];
                const Fixed before = c.sign * c.u[n], position = c.raised[n] - c.left;
                rose |= position > before;
                c.u[n] = c.sign * std::max(before, position);
                lowest[k] = std::min(lowest[k], std::max(before, position));
            }
            result.moved += rose;
        }
    }
    // Skipped lines are not below the previous lowest.
    for (std::size_t k = 0; k < components.size(); ++k)
        if (!result.has_wide_bounds) components[k].lowest = lowest[k];
    return result;
}

LookAtFields look(const FieldsOfBrick& fields, int count) {
    LookAtFields found{{INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN}, 0};
    for (int n = 0; n < count; ++n) {
        bool reached = false;
        for (std::size_t d = 0; d < 6; ++d) {
            const Fixed u = fields.u[d / 2][n], value = fields.of[d][n];
            found.highest[d] = std::max(found.highest[d], value);
            reached |= value > (d % 2 ? u : -u) - fields.ahead[d];
        }
        found.reached += reached;
    }
    return found;
}

}  // namespace

LookAtBrick plain_look_at_fields() {
    return look;
}

MoveDragged plain_move_dragged() {
    return move;
}

}  // namespace pliant
