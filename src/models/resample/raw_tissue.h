// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Distance of a position at rest from carved elements and cut links.

#pragma once

#include <algorithm>
#include <cmath>

#include "field/field.h"

namespace pliant {

class RawTissue {
  public:
    /// Keeps a reference: the lattice must stay as it is.
    explicit RawTissue(const Field& field) : m_field(field) {
        if (field.all_edits().empty()) return;
        const auto& edits = field.all_edits();
        m_bricks = {edits.begin()->first, edits.begin()->first};
        for (const auto& [coord, flags] : edits)
            for (int a = 0; a < 3; ++a) {
                m_bricks.begin[a] = std::min(m_bricks.begin[a], coord[a]);
                m_bricks.end[a] = std::max(m_bricks.end[a], coord[a] + 1);
            }
    }
    /// Whether there are no edits.
    bool is_empty() const { return m_field.all_edits().empty(); }

    /// Distance to the nearest of them in the maximum norm [voxels], or reach.
    /// @param x  continuous element index at rest
    double distance(Vec3d x, double reach) const {
        // Elements with a flag may have a cut link to an element that is 1 further.
        const double size = m_field.brick_size();
        for (int a = 0; a < 3; ++a)
            if (!(x[a] + reach >= size * m_bricks.begin[a] &&
                  x[a] - reach - 1 < size * m_bricks.end[a]))
                return reach;
        Box3i bricks;
        for (int a = 0; a < 3; ++a) {
            const double low = std::floor(x[a] - reach) - 1, high = std::floor(x[a] + reach);
            bricks.begin[a] = std::max(int(std::floor(low / size)), m_bricks.begin[a]);
            bricks.end[a] = std::min(int(std::floor(high / size)) + 1, m_bricks.end[a]);
        }
        // The brick that contains x first: others then have a small range to search.
        double nearest = reach;
        const auto look_in = [&](Vec3i brick) {
            if (const BrickEdits* edits = m_field.edits_of(brick))
                nearest = distance_in(brick, *edits, x, nearest);
        };
        const Vec3i own{int(std::floor(x.x / size)), int(std::floor(x.y / size)),
                        int(std::floor(x.z / size))};
        if (contains(bricks, own)) look_in(own);
        for (int k = bricks.begin.z; k < bricks.end.z; ++k)
            for (int j = bricks.begin.y; j < bricks.end.y; ++j)
                for (int i = bricks.begin.x; i < bricks.end.x && nearest > 0; ++i)
                    if (own != Vec3i{i, j, k}) look_in({i, j, k});
        return nearest;
    }

  private:
    double distance_in(Vec3i brick, const BrickEdits& edits, Vec3d x, double nearest) const {
        const int size = m_field.brick_size();
        const Vec3i first = size * brick;
        Box3i near;  // elements of the brick that may be nearer
        for (int a = 0; a < 3; ++a) {
            near.begin[a] = std::max(int(std::ceil(x[a] - nearest)) - 1 - first[a], 0);
            near.end[a] = std::min(int(std::floor(x[a] + nearest)) + 1 - first[a], size);
        }
        const auto is_beyond = [&](int axis, int element) {
            const double away = x[axis] - (first[axis] + element);
            return -away >= nearest || away - 1 >= nearest;
        };
        for (int k = near.begin.z; k < near.end.z; ++k) {
            if (is_beyond(2, k)) continue;
            for (int j = near.begin.y; j < near.end.y; ++j) {
                if (is_beyond(1, j)) continue;
                const std::uint8_t* row = edits.data() + size * (j + size * k);
                if (std::none_of(row + near.begin.x, row + std::max(near.end.x, near.begin.x),
                                 [](std::uint8_t flags) { return flags; }))
                    continue;
                for (int i = near.begin.x; i < near.end.x; ++i) {
                    const std::uint8_t flags = row[i];
                    if (!flags) continue;
                    const Vec3i e = first + Vec3i{i, j, k};
                    double away = 0;
                    for (int a = 0; a < 3; ++a) {
                        const double over = x[a] - e[a] - ((flags & kCutX << a) ? 1 : 0);
                        away = std::max({away, e[a] - x[a], over});
                    }
                    nearest = std::min(nearest, away);
                }
            }
        }
        return nearest;
    }

    const Field& m_field;
    Box3i m_bricks;  ///< box of all bricks with edits
};

}  // namespace pliant
