// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "relax/tool_contact.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace pliant {
namespace {

Vec3d in_lattice(const Grid& grid, Vec3d x_mm) {
    return lattice_from_world_vector(grid, x_mm - grid.origin_mm);
}

Vec3d rest_position(const Grid& grid, Vec3i ijk) {
    const Vec3d h = grid.spacing_mm;
    return {h.x * ijk.x, h.y * ijk.y, h.z * ijk.z};
}

Vec3d millimetres(Vec3<Fixed> u) {
    return {mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)};
}

/// Floor of the square root.
Fixed square_root(std::int64_t n) {
    if (n <= 0) return 0;
    auto root = std::int64_t(std::sqrt(double(n)));
    while (root * root > n) --root;
    while ((root + 1) * (root + 1) <= n) ++root;
    return Fixed(root);
}

std::int64_t square(Fixed n) {
    return std::int64_t(n) * n;
}

}  // namespace

double squared_distance_of_segments(Vec3d p0, Vec3d p1, Vec3d q0, Vec3d q1) {
    const Vec3d d = p1 - p0, e = q1 - q0, r = p0 - q0;
    const double dd = dot(d, d), ee = dot(e, e), er = dot(e, r);
    const double dr = dot(d, r), de = dot(d, e);
    double s = 0, t = 0;
    if (dd > 0 && ee > 0) {
        const double determinant = dd * ee - de * de;
        if (determinant > 0) s = std::clamp((de * er - dr * ee) / determinant, 0.0, 1.0);
        t = (de * s + er) / ee;
        if (t < 0 || t > 1) {
            t = std::clamp(t, 0.0, 1.0);
            s = std::clamp((de * t - dr) / dd, 0.0, 1.0);
        }
    } else if (ee > 0) {
        t = std::clamp(er / ee, 0.0, 1.0);
    } else if (dd > 0) {
        s = std::clamp(-dr / dd, 0.0, 1.0);
    }
    const Vec3d apart = r + s * d - t * e;
    return dot(apart, apart);
}

ToolContact::ToolContact(const Grid& grid, std::span<const RelaxTool> tools) {
    for (const RelaxTool& tool : tools)
        m_tools.push_back(
            {in_lattice(grid, tool.from_mm), in_lattice(grid, tool.to_mm), tool.radius_mm});
}

bool ToolContact::may_touch(Vec3d low_mm, Vec3d high_mm) const {
    return std::any_of(m_tools.begin(), m_tools.end(), [&](const RelaxTool& tool) {
        for (int a = 0; a < 3; ++a) {
            const auto [low, high] = std::minmax(tool.from_mm[a], tool.to_mm[a]);
            if (high + tool.radius_mm < low_mm[a] || low - tool.radius_mm > high_mm[a])
                return false;
        }
        return true;
    });
}

bool ToolContact::allows(Vec3d from_mm, Vec3d to_mm) const {
    return std::all_of(m_tools.begin(), m_tools.end(), [&](const RelaxTool& tool) {
        const auto to_axis = [&](Vec3d begin, Vec3d end) {
            return squared_distance_of_segments(begin, end, tool.from_mm, tool.to_mm);
        };
        const double radius2 = tool.radius_mm * tool.radius_mm;
        const double present = to_axis(from_mm, from_mm);
        if (present < radius2) return to_axis(to_mm, to_mm) >= present;
        // The end is also tested alone: the distance of segments has other roundings.
        return to_axis(from_mm, to_mm) >= radius2 && to_axis(to_mm, to_mm) >= radius2;
    });
}

Fixed BrickGuard::halved_until_allowed(Vec3d rest_mm, Vec3<Fixed> from, int axis, Fixed to) const {
    const Vec3d begin = rest_mm + millimetres(from);
    for (Fixed step = to - from[axis]; step != 0; step /= 2) {
        Vec3<Fixed> end = from;
        end[axis] += step;
        if (m_tools.allows(begin, rest_mm + millimetres(end))) return end[axis];
    }
    return from[axis];
}

Vec3<Fixed> BrickGuard::admit(int index, Vec3<Fixed> from, Vec3<Fixed> to) const {
    const std::int64_t limit = square(m_lattice.materials()[m_brick.material[index]].max_movement);
    const Vec3d rest_mm =
        rest_position(m_lattice.grid(), m_lattice.element_of(m_brick.coord, index));
    // Other elements of the brick determine whether the guard is called, and must not influence its
    // result. So a position within the limit is admitted even if the path to it, axis by axis, is
    // not.
    const bool is_inside = square(to.x) + square(to.y) + square(to.z) <= limit;
    Vec3<Fixed> position = from;
    for (int a = 0; a < 3; ++a) {
        const std::int64_t others =
            square(position.x) + square(position.y) + square(position.z) - square(position[a]);
        const Fixed most = std::max(square_root(limit - others), std::abs(from[a]));
        const Fixed end = is_inside ? to[a] : std::clamp(to[a], -most, most);
        position[a] = m_tools.empty() ? end : halved_until_allowed(rest_mm, position, a, end);
    }
    return position;
}

bool may_meet_tool(const Lattice& lattice, const Brick& brick, const ToolContact& tools) {
    if (tools.empty()) return false;
    Vec3<Fixed> low{0, 0, 0}, high{0, 0, 0};
    const auto include = [&](const Brick& other) {
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], other.u_min[a]);
            high[a] = std::max(high[a], other.u_max[a]);
        }
    };
    include(brick);
    for (const int index : brick.neighbours)
        if (index >= 0) include(lattice.brick(index));
    const int size = lattice.brick_size();
    Vec3d first = rest_position(lattice.grid(), size * brick.coord);
    Vec3d last = rest_position(lattice.grid(), size * brick.coord + Vec3i{size, size, size});
    for (int a = 0; a < 3; ++a) {
        // A step is at most twice the largest difference of neighbours.
        const double reach = 2 * (mm_from_units(high[a]) - mm_from_units(low[a]));
        first[a] += mm_from_units(low[a]) - reach;
        last[a] += mm_from_units(high[a]) + reach;
    }
    return tools.may_touch(first, last);
}

}  // namespace pliant
