// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chains/objects_guard.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <tuple>

namespace pliant {
namespace {

/// Whether p is the earlier contact; ties are broken independently of the order.
bool is_before(const Contact& p, const Contact& q) {
    if (!(p.time == q.time)) return p.time < q.time;
    const auto key = [](const Contact& c) {
        return std::tie(c.object, c.wall, c.element.z, c.element.y, c.element.x, c.other_element.z,
                        c.other_element.y, c.other_element.x);
    };
    return key(p) < key(q);
}

PositionBox widened(const PositionBox& box, const Position& by) {
    return {box.low - by, box.high + by};
}

/// Whether two boxes overlap after `done` of the shift.
bool overlaps_after(const Position& distance, const Position& reach, Vec3<Fixed> raise,
                    Vec3<Fixed> shift, Vec3<Fixed> done) {
    for (int a = 0; a < 3; ++a) {
        const std::int64_t undone =
            std::abs(std::int64_t(shift[a])) - std::abs(std::int64_t(done[a]));
        const std::int64_t moved = std::max<std::int64_t>(0, raise[a] - undone);
        if (std::abs(distance[a] + (shift[a] > 0 ? moved : -moved)) >= reach[a]) return false;
    }
    return true;
}

Vec3i last_brick(const Lattice& lattice) {
    return lattice.brick_of(lattice.grid().size - Vec3i{1, 1, 1});
}

}  // namespace

ContactGuard::ContactGuard(const PlacedLattice& pushed, std::span<const Other> others,
                           std::span<const PlacedWall> walls, const TaskArena& arena)
    : m_pushed(pushed), m_walls(walls.begin(), walls.end()), m_arena(arena) {
    for (const Other& other : others) {
        m_numbers.push_back(other.number);
        m_others.emplace_back(other.lattice);
    }
}

StepGuard::Verdict ContactGuard::limit(std::span<const int> bricks, Vec3<Fixed> shift,
                                       Verdict so_far) {
    Found all;
    std::mutex mutex;
    m_arena.for_each(std::int64_t(bricks.size()), 4, [&](std::int64_t begin, std::int64_t end) {
        Found found;
        for (std::int64_t k = begin; k < end; ++k) {
            const Brick& brick = m_pushed.lattice->brick(bricks[std::size_t(k)]);
            const SolidBrick solid = solid_elements(m_pushed, brick.coord, &shift);
            if (solid.elements.empty()) continue;
            look_at_walls(solid, shift, found);
            for (std::size_t n = 0; n < m_others.size(); ++n)
                look_at_object(solid, n, shift, found);
        }
        const std::lock_guard lock(mutex);
        if (is_before(found.first, all.first)) all.first = found.first;
        all.near_misses.insert(all.near_misses.end(), found.near_misses.begin(),
                               found.near_misses.end());
    });
    if (all.first.time.value() < so_far.fraction) {
        so_far = {all.first.time.value(), ratio_of(shift, all.first.time), LimitedBy::Wall};
        m_contact = all.first;
    }
    // Each component of the executed part is rounded separately, which can make boxes overlap again
    // that have just passed. Going back to the time of separation is exact, and each round goes
    // back farther.
    const auto meets = [&](const NearMiss& pair) {
        return overlaps_after(pair.distance, pair.reach, pair.raise, shift, so_far.done);
    };
    for (;;) {
        const auto pair = std::find_if(all.near_misses.begin(), all.near_misses.end(), meets);
        if (pair == all.near_misses.end()) return so_far;
        so_far.fraction = std::min(so_far.fraction, pair->leave.value());
        so_far.done = ratio_of(shift, pair->leave);
        if (so_far.limited_by == LimitedBy::None) so_far.limited_by = LimitedBy::Wall;
    }
}

void ContactGuard::look_at_walls(const SolidBrick& solid, Vec3<Fixed> shift, Found& found) const {
    for (std::size_t n = 0; n < m_walls.size(); ++n) {
        const PlacedWall& wall = m_walls[n];
        const Position& nearest = wall.side > 0 ? solid.box.low : solid.box.high;
        if (wall.gap(nearest, m_pushed.half) >= 0) continue;
        for (const SolidBrick::Element& own : solid.elements) {
            const Ratio time = wall_time(wall.gap(own.position, m_pushed.half), wall.side,
                                         own.raise[wall.axis], shift[wall.axis]);
            const Contact contact{time, -1, int(n), own.ijk, {0, 0, 0}};
            if (time < Ratio{1, 1} && is_before(contact, found.first)) found.first = contact;
        }
    }
}

void ContactGuard::look_at_object(const SolidBrick& solid, std::size_t other, Vec3<Fixed> shift,
                                  Found& found) const {
    const SolidSearch& search = m_others[other];
    const Position reach = m_pushed.half + search.object().half;
    search.for_each_brick(widened(solid.box, reach), [&](Vec3i coord) {
        for (const SolidBrick::Element& own : solid.elements) {
            PositionBox swept{own.position, own.position};
            for (int a = 0; a < 3; ++a)
                (shift[a] > 0 ? swept.high[a] : swept.low[a]) +=
                    shift[a] > 0 ? own.raise[a] : -own.raise[a];
            search.for_each_element(coord, widened(swept, reach),
                                    [&](Vec3i e, const Position& position) {
                                        meet(own, other, e, position, shift, found);
                                    });
        }
    });
}

void ContactGuard::meet(const SolidBrick::Element& own, std::size_t other, Vec3i other_element,
                        const Position& other_position, Vec3<Fixed> shift, Found& found) const {
    const Position distance = own.position - other_position;
    const Position reach = m_pushed.half + m_others[other].object().half;
    const Impact impact = impact_of(distance, reach, own.raise, shift);
    if (impact.happens()) {
        const Ratio time = impact.enter < Ratio{0, 1} ? Ratio{0, 1} : impact.enter;
        const Contact contact{time, m_numbers[other], -1, own.ijk, other_element};
        if (is_before(contact, found.first)) found.first = contact;
        return;
    }
    if (!(impact.leave < Ratio{1, 1}) || !(impact.enter < Ratio{1, 1})) return;
    const double unit = 1.0 / std::abs(double(shift[impact.leave_axis]));
    if (impact.enter.value() - impact.leave.value() < unit * 1.001)
        found.near_misses.push_back({distance, reach, own.raise, impact.leave});
}

void for_each_solid(const PlacedLattice& object,
                    const std::function<void(Vec3i, ElementRef)>& visit) {
    const Lattice& lattice = *object.lattice;
    const Vec3i last = last_brick(lattice);
    for (int z = 0; z <= last.z; ++z)
        for (int y = 0; y <= last.y; ++y)
            for (int x = 0; x <= last.x; ++x) {
                const int brick = lattice.find_brick({x, y, z});
                const BrickEdits* edits = lattice.edits_of({x, y, z});
                for (int n = 0; n < lattice.elements_per_brick(); ++n) {
                    const Vec3i e = lattice.element_of({x, y, z}, n);
                    if (!contains(voxel_box(lattice.grid()), e)) continue;
                    if (edits && ((*edits)[std::size_t(n)] & kVoid)) continue;
                    visit(e, {brick, n});
                }
            }
}

std::optional<Vec3i> find_overlap(const PlacedLattice& object, const PlacedLattice& other,
                                  const TaskArena& arena) {
    const SolidSearch search(other);
    const Position reach = object.half + other.half;
    const Vec3i bricks = last_brick(*object.lattice) + Vec3i{1, 1, 1};
    std::vector<std::optional<Vec3i>> found(std::size_t(bricks.x) * std::size_t(bricks.y) *
                                            std::size_t(bricks.z));
    arena.for_each(std::int64_t(found.size()), 4, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t k = begin; k < end; ++k) {
            const int b = int(k);
            const Vec3i coord{b % bricks.x, b / bricks.x % bricks.y, b / (bricks.x * bricks.y)};
            const SolidBrick solid = solid_elements(object, coord, nullptr);
            if (solid.elements.empty()) continue;
            search.for_each_brick(widened(solid.box, reach), [&](Vec3i there) {
                for (const SolidBrick::Element& own : solid.elements)
                    search.for_each_element(
                        there, widened({own.position, own.position}, reach),
                        [&](Vec3i, const Position& position) {
                            const Vec3<Fixed> none{0, 0, 0};
                            if (overlaps_after(own.position - position, reach, none, none, none))
                                found[std::size_t(k)] = own.ijk;
                        });
            });
        }
    });
    for (const auto& element : found)
        if (element) return element;
    return std::nullopt;
}

std::optional<Vec3i> find_behind(const PlacedLattice& object, const PlacedWall& wall) {
    std::optional<Vec3i> found;
    for_each_solid(object, [&](Vec3i e, ElementRef) {
        const Position position = object.position_of(e, object.lattice->displacement_at(e));
        if (wall.gap(position, object.half) < 0) found = e;
    });
    return found;
}

}  // namespace pliant
