// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/research/objects.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "chainmail/chainmail_impl.h"
#include "chains/objects_guard.h"

namespace pliant {
namespace {

/// Longest push [mm]: added to a free object's largest distance from rest, it stays below the
/// range.
constexpr double kLongestPushMm = 300;
/// A free object's rest position follows it once an element is farther from rest than this [mm].
constexpr double kFarFromRestMm = 100;

Position units_of(Vec3d mm) {
    return {std::llround(mm.x * kUnitsPerMm), std::llround(mm.y * kUnitsPerMm),
            std::llround(mm.z * kUnitsPerMm)};
}

Vec3d mm_of(Position units) {
    return {double(units.x) / kUnitsPerMm, double(units.y) / kUnitsPerMm,
            double(units.z) / kUnitsPerMm};
}

/// The law without fixed values and movement limits.
MaterialLaw unbound(MaterialLaw law) {
    return [law = std::move(law)](int value_hu) {
        ElementLimits limits = law(value_hu);
        limits.fixed = false;
        limits.max_movement_mm = kMaxMovementMm;
        return limits;
    };
}

void make_air_void(Lattice& lattice, double threshold_hu) {
    const Vec3i bricks = lattice.brick_of(lattice.grid().size - Vec3i{1, 1, 1});
    for (int z = 0; z <= bricks.z; ++z)
        for (int y = 0; y <= bricks.y; ++y)
            for (int x = 0; x <= bricks.x; ++x) {
                BrickEdits edits(std::size_t(lattice.elements_per_brick()), 0);
                for (std::size_t n = 0; n < edits.size(); ++n) {
                    const Vec3i e = lattice.element_of({x, y, z}, int(n));
                    if (contains(voxel_box(lattice.grid()), e) &&
                        lattice.value_at(e) < threshold_hu)
                        edits[n] = kVoid;
                }
                lattice.set_edits({x, y, z}, std::move(edits));
            }
}

}  // namespace

struct ObjectSpace::Impl {
    struct Object {
        std::unique_ptr<Volume> volume;
        ChainMail tissue;
        bool free;
        Position base;    ///< of element (0,0,0) at rest, when it was added
        Position travel;  ///< of the rest position since then
    };

    explicit Impl(const TaskArena& a) : arena(a) {}

    PlacedLattice placed(const Object& object) const {
        return {&lattice_of(object.tissue), object.base + object.travel,
                half_extents(object.volume->grid)};
    }
    Vec3d travel_mm(const Object& object) const {
        return world_from_lattice_vector(object.volume->grid, mm_of(object.travel));
    }
    bool exists(int object) const { return object >= 0 && object < int(objects.size()); }

    Result<int> add_object(Volume volume, const ChainMailSettings& settings, bool free);
    Result<int> add_wall(const Wall& wall);
    /// Runs a push of an object, with arguments checked before.
    template <class Work>
    Result<ObjectPushReport> guarded(int number, double length_mm, const Work& work);
    void follow(Object& object) const;

    const TaskArena& arena;
    std::vector<Object> objects;
    std::vector<PlacedWall> walls;
};

ObjectSpace::ObjectSpace(const TaskArena& arena) : m_impl(std::make_unique<Impl>(arena)) {}
ObjectSpace::~ObjectSpace() = default;
ObjectSpace::ObjectSpace(ObjectSpace&&) noexcept = default;
ObjectSpace& ObjectSpace::operator=(ObjectSpace&&) noexcept = default;

Result<int> ObjectSpace::add_object(Volume volume, const ChainMailSettings& settings, bool free) {
    return attempt([&] { return m_impl->add_object(std::move(volume), settings, free); });
}

Result<int> ObjectSpace::Impl::add_object(Volume volume, const ChainMailSettings& settings,
                                          bool free) {
    const std::string name = "object " + std::to_string(int(objects.size()));
    if (Status s = check_volume(volume, name); !s.ok()) return s.error();
    if (!objects.empty() && volume.grid.direction != objects[0].tissue.volume().grid.direction)
        return invalid(name + ": expected the same directions as object 0, found others");
    const Vec3d origin_mm = lattice_from_world_vector(volume.grid, volume.grid.origin_mm);
    if (!(norm(origin_mm) < 1e5))
        return invalid(name + ": expected an origin within 100000 mm, found one farther away");
    auto own = std::make_unique<Volume>(std::move(volume));
    ChainMailSettings used = settings;
    used.bounded = true;
    used.history_max_steps = 0;  // undone motion could run into objects that have moved since
    if (free) used.custom_law = unbound(used.custom_law ? used.custom_law : draeger_law(used));
    auto tissue = ChainMail::create(*own, used, arena);
    if (!tissue.ok()) return Error{tissue.error().code, name + ": " + tissue.error().message};
    make_air_void(lattice_of(*tissue), used.air_threshold_hu);
    Impl::Object added{std::move(own), std::move(*tissue), free, units_of(origin_mm), {0, 0, 0}};
    const PlacedLattice own_place = placed(added);
    for (std::size_t n = 0; n < objects.size(); ++n)
        if (const auto e = find_overlap(own_place, placed(objects[n]), arena))
            return invalid(name + ": expected a position of its own, but element " + text_of(*e) +
                           " overlaps object " + std::to_string(n));
    for (std::size_t n = 0; n < walls.size(); ++n)
        if (const auto e = find_behind(own_place, walls[n]))
            return invalid(name + ": expected a position before the walls, but element " +
                           text_of(*e) + " is behind wall " + std::to_string(n));
    objects.push_back(std::move(added));
    return int(objects.size()) - 1;
}

Result<int> ObjectSpace::add_wall(const Wall& wall) {
    return attempt([&] { return m_impl->add_wall(wall); });
}

Result<int> ObjectSpace::Impl::add_wall(const Wall& wall) {
    const std::string name = "wall " + std::to_string(int(walls.size()));
    if (wall.axis < 0 || wall.axis > 2 || (wall.side != 1 && wall.side != -1))
        return invalid(name + ": expected an axis 0, 1 or 2 and a side +1 or -1, found " +
                       std::to_string(wall.axis) + " and " + std::to_string(wall.side));
    if (objects.empty())
        return invalid(name + ": expected an object before it, whose axes are those of the space");
    const Grid& grid = objects[0].tissue.volume().grid;
    const Vec3d point_mm = lattice_from_world_vector(grid, wall.point_mm);
    if (!(norm(point_mm) < 1e5))
        return invalid(name + ": expected a point within 100000 mm, found one farther away");
    const PlacedWall added{wall.axis, wall.side, units_of(point_mm)[wall.axis]};
    for (std::size_t n = 0; n < objects.size(); ++n)
        if (const auto e = find_behind(placed(objects[n]), added))
            return invalid(name + ": expected nothing behind it, found element " + text_of(*e) +
                           " of object " + std::to_string(n));
    walls.push_back(added);
    return int(walls.size()) - 1;
}

template <class Work>
Result<ObjectPushReport> ObjectSpace::Impl::guarded(int number, double length_mm,
                                                    const Work& work) {
    if (!exists(number))
        return about("push", ErrorCode::InvalidArgument,
                     "expected an object 0 to " + std::to_string(int(objects.size()) - 1) +
                         ", found " + std::to_string(number));
    if (!(length_mm * objects[std::size_t(number)].tissue.settings().scale <= kLongestPushMm))
        return about("push", ErrorCode::InvalidArgument,
                     "expected a length up to 300 mm after scaling, found more");
    Object& pushed = objects[std::size_t(number)];
    std::vector<ContactGuard::Other> others;
    for (std::size_t n = 0; n < objects.size(); ++n)
        if (int(n) != number) others.push_back({int(n), placed(objects[n])});
    ContactGuard guard(placed(pushed), others, walls, arena);
    ChainMailInside::of(pushed.tissue).guard = &guard;
    Result<PushReport> done = work(pushed);
    ChainMailInside::of(pushed.tissue).guard = nullptr;
    if (!done.ok()) return done.error();
    if (pushed.free) follow(pushed);
    ObjectPushReport report;
    report.push = std::move(*done);
    if (const auto& contact = guard.contact()) {
        report.object = contact->object;
        report.wall = contact->wall;
        report.element = contact->element;
        report.other_element = contact->other_element;
    }
    return report;
}

/// Moves the rest position of an object that has left it, by the common part of its displacements.
/// Doesn't allocate: the push is done already.
void ObjectSpace::Impl::follow(Object& object) const {
    Lattice& moved = lattice_of(object.tissue);
    Vec3<Fixed> low{INT32_MAX, INT32_MAX, INT32_MAX}, high{INT32_MIN, INT32_MIN, INT32_MIN};
    Fixed farthest = 0;
    moved.for_each_brick([&](const Brick& brick) {
        for (int a = 0; a < 3; ++a)
            farthest = std::max({farthest, brick.u_max[a], -brick.u_min[a]});
    });
    if (mm_from_units(farthest) < kFarFromRestMm) return;
    const auto include = [&](Vec3i, ElementRef element) {
        for (int a = 0; a < 3; ++a) {
            const Fixed u =
                element.brick < 0
                    ? 0
                    : moved.brick(element.brick).u[std::size_t(a)][std::size_t(element.index)];
            low[a] = std::min(low[a], u);
            high[a] = std::max(high[a], u);
        }
    };
    for_each_solid(placed(object), std::ref(include));
    Vec3<Fixed> common{};
    for (int a = 0; a < 3; ++a) common[a] = low[a] > 0 ? low[a] : high[a] < 0 ? high[a] : 0;
    if (common == Vec3<Fixed>{0, 0, 0}) return;
    moved.tick();
    const auto take_away = [&](Vec3i, ElementRef element) {
        if (element.brick < 0) return;
        for (int a = 0; a < 3; ++a)
            moved.brick(element.brick).u[std::size_t(a)][std::size_t(element.index)] -= common[a];
    };
    for_each_solid(placed(object), std::ref(take_away));
    for (int index = 0; index < moved.brick_index_bound(); ++index) {
        if (!moved.is_resident(index)) continue;
        moved.brick(index).changed_at = moved.clock();
        moved.update_bounds(index);
    }
    moved.drop_still_bricks();
    object.travel = moved_position(object.travel, common);
}

Result<ObjectPushReport> ObjectSpace::push(int object, const Push& push) {
    return attempt([&] {
        return m_impl->guarded(object, norm(push.push_mm), [&](Impl::Object& pushed) {
            Push own = push;
            own.point_mm = push.point_mm - m_impl->travel_mm(pushed);
            return pushed.tissue.push(own);
        });
    });
}

Result<ObjectPushReport> ObjectSpace::push_elements(int object, std::span<const Vec3i> elements,
                                                    Vec3d push_mm) {
    return attempt([&] {
        return m_impl->guarded(object, norm(push_mm), [&](Impl::Object& pushed) {
            return pushed.tissue.push_elements(elements, push_mm);
        });
    });
}

int ObjectSpace::object_count() const {
    return int(m_impl->objects.size());
}
int ObjectSpace::wall_count() const {
    return int(m_impl->walls.size());
}
const ChainMail& ObjectSpace::object(int object) const {
    PLIANT_ASSERT(m_impl->exists(object));
    return m_impl->objects[std::size_t(object)].tissue;
}
bool ObjectSpace::is_solid(int object, Vec3i ijk) const {
    return !lattice_of(this->object(object)).is_void(ijk);
}
Vec3d ObjectSpace::displacement_mm(int object, Vec3i ijk) const {
    const Impl::Object& own = m_impl->objects[std::size_t(object)];
    return this->object(object).displacement_mm(ijk) + m_impl->travel_mm(own);
}
Vec3d ObjectSpace::position_mm(int object, Vec3i ijk) const {
    const Grid& grid = this->object(object).volume().grid;
    return world_from_voxel(grid, {double(ijk.x), double(ijk.y), double(ijk.z)}) +
           displacement_mm(object, ijk);
}

}  // namespace pliant
