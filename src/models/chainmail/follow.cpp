// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Motion that follows a given field (breathing, swelling) as far as links and bone allow.
//
// Functions that satisfy all links are closed under pointwise minimum and maximum. Component by
// component, the largest displacements that fixed elements and the box's outside allow are one such
// function D, −D another, and a field f·T that changes little from element to element a third. So
//
//     u = min( max( f·T, −D ), D )
//
// satisfies all links, is zero at bone, and equals f·T away from it. Limits are the tightest of all
// materials in the box: with them D is a city-block distance, found by one pass along each axis.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/operation.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

/// Work on the elements of a box, dense, i fastest.
class Following {
  public:
    Following(Lattice& lattice, const Box3i& box)
        : m_lattice(lattice), m_box(box), m_size(box.end - box.begin) {
        const std::size_t count = dense_count(m_size);
        m_fixed.assign(count, 0);
        for (auto& target : m_target) target.resize(count);
        for (auto& row : m_cost) row.fill(kUnlinked);
    }

    /// Creates bricks for the box, and reads their materials.
    void look_at_materials() {
        const Vec3i first = m_lattice.brick_of(m_box.begin);
        const Vec3i last = m_lattice.brick_of(m_box.end - Vec3i{1, 1, 1});
        m_max_movement.assign(dense_count(m_size), 0);
        for_each_in({first, last + Vec3i{1, 1, 1}},
                    [&](Vec3i coord) { m_bricks.push_back(m_lattice.ensure_brick(coord)); });
        for (const int index : m_bricks) look_at_brick(m_lattice.brick(index));
    }

    /// @returns false if a displacement isn't finite or is too long
    bool take_targets(const Grid& grid, const std::function<Vec3d(Vec3d)>& displacement_mm) {
        std::size_t n = 0;
        bool fit = true;
        for_each_in(m_box, [&](Vec3i e) {
            const Vec3d point = world_from_voxel(grid, {double(e.x), double(e.y), double(e.z)});
            const Vec3d u = lattice_from_world_vector(grid, displacement_mm(point));
            const bool fits = is_finite(u) && norm(u) <= kMaxMovementMm;
            fit &= fits;
            for (int a = 0; a < 3; ++a)
                m_target[std::size_t(a)][n] = fits ? units_from_mm(u[a]) : 0;
            ++n;
        });
        return fit;
    }

    /// Largest part of the targets that keeps all links and movement limits away from bone.
    double find_fraction() const {
        double fraction = 1;
        for (int b = 0; b < 3; ++b)
            for_each_link(b, [&](std::size_t low, std::size_t high) {
                if (m_fixed[low] || m_fixed[high]) return;
                for (std::size_t a = 0; a < 3; ++a) {
                    const double change =
                        std::abs(double(m_target[a][high]) - double(m_target[a][low]));
                    // Less one unit, since displacements are rounded towards zero.
                    const double limit = std::max(0, m_cost[a][std::size_t(b)] - 1);
                    if (fraction * change > limit) fraction = limit / change;
                }
            });
        for (std::size_t n = 0; n < m_fixed.size(); ++n) {
            if (m_fixed[n]) continue;
            const double length =
                norm({double(m_target[0][n]), double(m_target[1][n]), double(m_target[2][n])});
            if (fraction * length > m_max_movement[n]) fraction = m_max_movement[n] / length;
        }
        return fraction;
    }

    /// Replaces the targets by the displacements. @returns the number of held elements
    std::int64_t bound(double fraction) {
        std::vector<std::uint8_t> is_held(m_fixed.size(), 0);
        for (std::size_t a = 0; a < 3; ++a) {
            const std::vector<Fixed> room = find_room(m_cost[a]);
            for (std::size_t n = 0; n < room.size(); ++n) {
                const auto wished = Fixed(std::trunc(fraction * m_target[a][n]));
                const Fixed bounded = std::clamp(wished, -room[n], room[n]);
                is_held[n] |= bounded != wished;
                m_target[a][n] = bounded;
            }
        }
        return std::count(is_held.begin(), is_held.end(), 1);
    }

    /// Allocates all that write() needs.
    void reserve() {
        for (const int index : m_bricks) m_lattice.reserve_move(m_lattice.brick(index));
    }
    /// @returns the number of moved elements
    std::int64_t write() {
        std::int64_t moved = 0;
        for (const int index : m_bricks) {
            Brick& brick = m_lattice.brick(index);
            m_lattice.before_move(brick);
            for_each_element(brick, [&](int at, std::size_t n) {
                moved += (m_target[0][n] | m_target[1][n] | m_target[2][n]) != 0;
                for (std::size_t a = 0; a < 3; ++a) brick.u[a][at] = m_target[a][n];
            });
            brick.changed_at = m_lattice.clock();
            m_lattice.update_bounds(index);
        }
        m_lattice.drop_still_bricks(m_bricks);
        return moved;
    }

  private:
    /// Calls visit(index in the brick, index in the box) for a brick's elements in the box.
    template <class Visit>
    void for_each_element(const Brick& brick, const Visit& visit) const {
        for (int at = 0; at < m_lattice.elements_per_brick(); ++at) {
            const Vec3i e = m_lattice.element_of(brick.coord, at);
            if (contains(m_box, e)) visit(at, dense_index(e - m_box.begin, m_size));
        }
    }
    template <class Visit>
    void for_each_link(int b, const Visit& visit) const {
        Vec3i ends = m_size;
        --ends[b];
        const std::size_t step = step_of(b);
        for_each_in({{0, 0, 0}, ends}, [&](Vec3i p) {
            const std::size_t n = dense_index(p, m_size);
            visit(n, n + step);
        });
    }
    std::size_t step_of(int axis) const {
        return axis == 0   ? 1
               : axis == 1 ? std::size_t(m_size.x)
                           : std::size_t(m_size.x) * std::size_t(m_size.y);
    }

    void look_at_brick(const Brick& brick) {
        for_each_element(brick, [&](int at, std::size_t n) {
            const HalfLimits& half = m_lattice.materials()[brick.material[at]];
            m_fixed[n] = half.fixed;
            if (half.fixed) return;
            m_max_movement[n] = half.max_movement;
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) {
                    Fixed& cost = m_cost[std::size_t(a)][std::size_t(b)];
                    const Fixed limit =
                        a == b ? std::min(half.compress[b], half.stretch[b]) : half.shear[b];
                    cost = std::min(cost, 2 * limit);
                }
        });
    }

    /// Largest displacement beside elements at rest: bone, and the box's outside. A link to bone
    /// may have no more than the half of the movable end.
    std::vector<Fixed> find_room(const std::array<Fixed, 3>& cost) const {
        const Fixed first = (*std::max_element(cost.begin(), cost.end()) + 1) / 2;
        std::vector<Fixed> room(m_fixed.size());
        for_each_in({{0, 0, 0}, m_size}, [&](Vec3i p) {
            const std::size_t n = dense_index(p, m_size);
            std::int64_t most = 2 * units_from_mm(kMaxMovementMm);
            for (int a = 0; a < 3; ++a) {
                const std::int64_t away = 1 + std::min(p[a], m_size[a] - 1 - p[a]);
                most = std::min(most, away * cost[std::size_t(a)]);
            }
            room[n] = m_fixed[n] ? 0 : Fixed(most);
        });
        for (int b = 0; b < 3; ++b) {
            const Fixed step = cost[std::size_t(b)];
            const auto low_first = [&](std::size_t low, std::size_t high) {
                room[high] = std::min(room[high], room[low] + step);
            };
            for_each_link(b, low_first);
            // The same links from the far end.
            Vec3i ends = m_size;
            --ends[b];
            const std::size_t stride = step_of(b);
            for (int z = ends.z - 1; z >= 0; --z)
                for (int y = ends.y - 1; y >= 0; --y)
                    for (int x = ends.x - 1; x >= 0; --x) {
                        const std::size_t n = dense_index({x, y, z}, m_size);
                        room[n] = std::min(room[n], room[n + stride] + step);
                    }
        }
        for (Fixed& most : room) most = std::max(0, most - first);
        return room;
    }

    Lattice& m_lattice;
    Box3i m_box;
    Vec3i m_size;
    std::vector<int> m_bricks;
    std::vector<std::uint8_t> m_fixed;
    std::vector<Fixed> m_max_movement;
    std::array<std::vector<Fixed>, 3> m_target;
    /// Tightest limit of component a along axis b [a][b].
    std::array<std::array<Fixed, 3>, 3> m_cost;
};

Status check_following(const Lattice& lattice, const Box3i& box, std::int64_t max_elements) {
    if (is_empty(box))
        return about("follow", ErrorCode::InvalidArgument,
                     "expected a box of elements, found none");
    double count = 1;
    for (int a = 0; a < 3; ++a) count *= double(box.end[a]) - double(box.begin[a]);
    if (count > double(max_elements))
        return about("follow", ErrorCode::LimitExceeded,
                     "expected a box of up to max_elements, " + std::to_string(max_elements));
    if (lattice.may_have_gaps())
        return about("follow", ErrorCode::InvalidArgument,
                     "expected tissue without cut, carved or missing elements");
    bool is_moved = false;
    lattice.for_each_brick([&](const Brick& brick) { is_moved |= !is_at_rest(brick); });
    if (is_moved) return about("follow", ErrorCode::InvalidArgument, "expected tissue at rest");
    return Ok{};
}

}  // namespace

Result<FollowReport> ChainMail::Impl::follow(const Box3i& elements,
                                             const std::function<Vec3d(Vec3d)>& displacement_mm) {
    const Stopwatch watch;
    if (const Status s = check_following(lattice, elements, settings.max_elements); !s.ok())
        return s.error();
    Operation step(*this, {.step = "follow", .ends_drag = true, .has_copies = yields});
    Following following(lattice, elements);
    if (!following.take_targets(volume.grid, displacement_mm))
        return about("follow", ErrorCode::InvalidArgument,
                     "expected displacements of three numbers and up to 500 mm");
    following.look_at_materials();
    FollowReport report;
    report.fraction = following.find_fraction();
    report.held_elements = following.bound(report.fraction);
    following.reserve();
    // No allocations from here on.
    lattice.tick();
    report.moved_elements = following.write();
    if (report.moved_elements > 0) yield_to_push();
    allowance.shrink(lattice, arena);
    report.forgotten_steps = step.commit();
    report.solve_ms = watch.ms();
    return report;
}

Result<FollowReport> ChainMail::follow(const Box3i& elements,
                                       const std::function<Vec3d(Vec3d)>& displacement_mm) {
    return attempt([&] { return m_impl->follow(elements, displacement_mm); });
}

}  // namespace pliant
