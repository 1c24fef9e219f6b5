// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "propagate/drag_fields.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "propagate/sweep_lags.h"
#include "propagate/sweep_rounds.h"
#include "propagate/uniform_passes.h"

namespace pliant {
namespace {

constexpr unsigned kAllFields = (1u << kDirections) - 1;
/// A brick's first arrays are its own; the others are allocated three at a time.
constexpr std::size_t kOwnArrays = 3, kMoreArrays = kDirections - kOwnArrays;
constexpr std::size_t kBricksPerSlab = 64;
/// Fields that all directions share start at the lowest of all floors. If reach and displacement
/// together exceed this, a frame's results may not fit into Fixed, and no array is shared.
constexpr double kMaxSharedMm = 750;

using News = std::array<std::uint8_t, 6>;

}  // namespace

class DragFields::Solver {
  public:
    Solver(DragFields& fields, Lattice& lattice, Fixed reach, const SweepKernels& kernels,
           SweepWork& work)
        : m_fields(fields),
          m_lattice(lattice),
          m_kernels(kernels),
          m_work(work),
          m_rounds(lattice, work),
          m_reach(reach) {
        const MaterialTable::Columns& columns = lattice.materials().columns();
        m_stretch_is_shear = columns.stretch == columns.shear;
        for (int a = 0; a < 3; ++a)
            for (const Fixed sign : {-1, 1}) m_pushes[direction_of(a, sign)] = {a, sign, reach};
    }

    void grab(std::span<const ElementRef> grabbed) {
        const bool alike = look_at_grabbed(grabbed);
        for (const ElementRef& element : grabbed) {
            const Brick& brick = m_lattice.brick(element.brick);
            BrickFields& fields = of(element.brick);
            if (!fields.of[0]) begin(brick, fields, alike && is_symmetric(brick));
            for (std::size_t d = 0; d < kDirections; ++d)
                fields.of[d][element.index] = m_reach + position(element, d) - m_fields.m_ahead[d];
            m_rounds.wake(element.brick, m_reach).own_news = kAllFields;
        }
    }

    bool run(const TaskArena& arena, int max_bricks) {
        if (m_at_rest) pass_through_uniform(arena, max_bricks);
        return m_rounds.run(
            m_reach, arena, max_bricks,
            [this](int index, SweepWork::Wakes& wakes) { visit(index, wakes); },
            [this](bool) { make_room(); });
    }

  private:
    using Wakes = SweepWork::Wakes;

    BrickFields& of(int index) { return m_fields.m_bricks[std::size_t(index)]; }
    void make_room() { m_fields.m_bricks.resize(std::size_t(m_lattice.brick_index_bound())); }
    static bool is_symmetric(const Brick& brick) { return !(brick.traits & kAsymmetric); }
    Fixed position(const ElementRef& element, std::size_t d) const {
        const Fixed* u = m_lattice.brick(element.brick).u[d / 2];
        return m_pushes[d].sign * u[element.index];
    }

    /// @returns whether all six fields start alike
    bool look_at_grabbed(std::span<const ElementRef> grabbed) {
        bool alike = true;
        m_at_rest = true;
        for (std::size_t d = 0; d < kDirections; ++d) {
            Fixed& ahead = m_fields.m_ahead[d];
            ahead = position(grabbed[0], d);
            for (const ElementRef& element : grabbed) {
                alike &= position(element, d) == position(grabbed[0], d);
                ahead = std::max(ahead, position(element, d));
            }
        }
        Fixed farthest = 0;
        for (const Fixed ahead : m_fields.m_ahead) farthest = std::max(farthest, std::abs(ahead));
        m_may_share = farthest + m_reach <= units_from_mm(kMaxSharedMm);
        for (const ElementRef& element : grabbed)
            m_at_rest &= is_at_rest(m_lattice.brick(element.brick));
        return alike;
    }

    /// Lowest floor of a brick's elements.
    Fixed floor_of(const Brick& brick, std::size_t d) const {
        const auto a = int(d / 2);
        return (m_pushes[d].sign > 0 ? brick.u_min[a] : -brick.u_max[a]) - m_fields.m_ahead[d];
    }
    Fixed floor_of(const Brick* brick) const {
        Fixed floor = INT32_MAX;
        for (std::size_t d = 0; d < kDirections; ++d)
            floor = std::min(floor, brick ? floor_of(*brick, d) : -m_fields.m_ahead[d]);
        return floor;
    }

    void begin(const Brick& brick, BrickFields& fields, bool alike) {
        const int count = m_lattice.elements_per_brick();
        fields.shared = m_may_share && alike;
        if (fields.shared) {
            fields.of.fill(brick.raised[0]);
            std::fill_n(brick.raised[0], count, floor_of(&brick));
            return;
        }
        take_arrays(brick, fields);
        for (std::size_t d = 0; d < kDirections; ++d)
            std::fill_n(fields.of[d], count, floor_of(brick, d));
    }

    void take_arrays(const Brick& brick, BrickFields& fields) {
        std::copy(brick.raised.begin(), brick.raised.end(), fields.of.begin());
        Fixed* more = m_fields.take_arrays(kMoreArrays);
        for (std::size_t d = kOwnArrays; d < kDirections; ++d)
            fields.of[d] = more + (d - kOwnArrays) * (m_fields.m_array_bytes / sizeof(Fixed));
    }

    /// Continues with each field separately.
    void split(const Brick& brick, BrickFields& fields) {
        take_arrays(brick, fields);
        for (std::size_t d = 1; d < kDirections; ++d)
            std::copy_n(fields.of[0], m_lattice.elements_per_brick(), fields.of[d]);
        fields.shared = false;
    }

    /// Skips the search in one material at rest, as a push does.
    void pass_through_uniform(const TaskArena& arena, int max_bricks) {
        for (const int index : m_work.touched) {
            if (!of(index).shared) return;
            m_lattice.brick(index).reached[0] = true;
        }
        const bool done = UniformPasses(m_lattice, m_kernels, m_work).run(arena, max_bricks);
        const bool passed = m_work.touched.size() > m_work.active.size();
        make_room();
        for (const int index : m_work.touched) {
            Brick& brick = m_lattice.brick(index);
            if (brick.reached[0]) {
                of(index).of.fill(brick.raised[0]);
                of(index).shared = true;
            }
            brick.reached = {};
            if (!done && passed) m_rounds.wake(index, m_reach).add_all_news(kAllFields);
        }
        if (done) m_work.active.clear();
    }

    /// Brings one brick to its fixed point. Reads the neighbours, writes only the brick.
    void visit(int index, Wakes& wakes) {
        static thread_local VisitLags lags;
        Brick& brick = m_lattice.brick(index);
        if (brick.is_blank) m_lattice.fill_in(brick);
        lags.begin(m_lattice, brick, m_kernels, false, m_stretch_is_shear);
        BrickFields& fields = of(index);
        if (!fields.of[0]) begin(brick, fields, is_symmetric(brick));
        SweepWork::Node& node = m_work.nodes[std::size_t(index)];
        const News news = std::exchange(node.news, {});
        const unsigned own_news = std::exchange(node.own_news, std::uint8_t(0));
        unsigned risen = 0;
        if (fields.shared) risen = raise_shared(brick, fields, news, own_news != 0, lags);
        if (!fields.shared)
            for (std::size_t d = 0; d < kDirections; ++d)
                if (raise(brick, fields.of[d], d, news, own_news >> d & 1, lags)) risen |= 1u << d;
        if (risen == 0) return;
        for (int side = 0; side < 6; ++side)
            if (fields.shared)
                offer_shared(brick, fields, side, lags, wakes);
            else
                offer(brick, fields.of, side, risen, lags, wakes);
    }

    std::uint32_t all_slices() const { return ~std::uint32_t(0) >> (32 - m_lattice.brick_size()); }

    /// Takes offers from bricks with one field for all first, then the other offers, as long as
    /// these are equal for all fields. Otherwise the brick is split. @returns the fields that rose
    /// before
    unsigned raise_shared(Brick& brick, BrickFields& fields, const News& news, bool own_news,
                          VisitLags& lags) {
        Fixed* v = fields.of[0];
        const Fixed floor = floor_of(&brick);
        std::uint32_t dirty = own_news ? all_slices() : 0;
        for (int side = 0; side < 6; ++side)
            if (news[std::size_t(side)] && is_shared_behind(brick, side))
                dirty |= take(brick, v, 0, side, lags);
        bool rose = relax(brick, v, 0, dirty, floor, lags);
        dirty = 0;
        for (int side = 0; side < 6 && fields.shared; ++side) {
            if (!news[std::size_t(side)] || is_shared_behind(brick, side)) continue;
            if (is_offered_alike(brick, v, side, lags))
                dirty |= take(brick, v, 0, side, lags);
            else
                split(brick, fields);
        }
        // Also after a split: the rest then starts from a fixed point.
        if (!fields.shared && dirty != 0)
            for (std::size_t d = 1; d < kDirections; ++d)
                relax(brick, fields.of[d], d, dirty, floor, lags);
        rose |= relax(brick, v, 0, dirty, floor, lags);
        return rose ? kAllFields : 0;
    }

    bool is_shared_behind(const Brick& brick, int side) {
        const int index = brick.neighbours[std::size_t(side)];
        return index >= 0 && of(index).shared;
    }

    /// Whether the neighbour's offers to the elements on a side are the same in all fields.
    bool is_offered_alike(const Brick& brick, const Fixed* v, int side, VisitLags& lags) {
        constexpr auto kMaxOnFace = std::size_t(kMaxBrickSize * kMaxBrickSize);
        alignas(64) std::array<Fixed, kMaxOnFace> own, theirs, first;
        const FieldArrays& there = of(brick.neighbours[std::size_t(side)]).of;
        const int size = m_lattice.brick_size(), face = size * size;
        m_kernels.copy_face(v, size, side, own.data());
        for (std::size_t d = 0; d < kDirections; ++d) {
            m_kernels.copy_face(there[d], size, side ^ 1, theirs.data());
            const Fixed* lag = lags.behind_neighbour(side, m_pushes[d]);
            Fixed differs = 0;
            for (std::size_t n = 0; n < std::size_t(face); ++n) {
                const Fixed asked = std::max(own[n], theirs[n] - lag[n]);
                if (d == 0) first[n] = asked;
                differs |= asked ^ first[n];
            }
            if (differs != 0) return false;
        }
        return true;
    }

    bool raise(const Brick& brick, Fixed* v, std::size_t d, const News& news, bool own_news,
               VisitLags& lags) {
        std::uint32_t dirty = own_news ? all_slices() : 0;
        for (int side = 0; side < 6; ++side)
            if (news[std::size_t(side)] >> d & 1) dirty |= take(brick, v, d, side, lags);
        return relax(brick, v, d, dirty, floor_of(brick, d), lags);
    }

    std::uint32_t take(const Brick& brick, Fixed* v, std::size_t d, int side, VisitLags& lags) {
        const int index = brick.neighbours[std::size_t(side)];
        if (index < 0 || !of(index).of[d]) return 0;
        return m_kernels.take(v, m_lattice.brick_size(), side, of(index).of[d],
                              lags.behind_neighbour(side, m_pushes[d]));
    }

    /// @returns whether anything was to be done
    bool relax(const Brick& brick, Fixed* v, std::size_t d, std::uint32_t dirty, Fixed floor,
               VisitLags& lags) const {
        if (dirty == 0) return false;
        const int size = m_lattice.brick_size();
        if (!lags.is_uniform()) {
            m_kernels.relax(v, size, lags.inside(m_pushes[d]), dirty);
            return true;
        }
        // Links at the border don't bind, unlike the others. But a shortest path inside a box never
        // has to leave it, and nothing enters from beyond, where all elements are at the floor.
        m_kernels.relax_uniform(v, size, lags.uniform(m_pushes[d]), dirty);
        if (brick.traits & kPartlyBeyond) m_lattice.set_beyond(brick, v, floor);
        return true;
    }

    /// Offers the raise of a brick with one field for all to the elements behind a side.
    void offer_shared(const Brick& brick, const BrickFields& fields, int side, VisitLags& lags,
                      Wakes& wakes) {
        const int index = brick.neighbours[std::size_t(side)];
        const Brick* there = index < 0 ? nullptr : &m_lattice.brick(index);
        const bool is_known = there && !there->is_blank;
        if (!there && m_lattice.is_beyond_border(coord_behind(brick, side))) return;
        const bool alike = !is_known || (of(index).of[0] ? of(index).shared : is_symmetric(*there));
        if (!alike) return offer(brick, fields.of, side, kAllFields, lags, wakes);
        const Fixed* lag = is_known ? lags.behind_face(side, m_pushes[0])
                                    : lags.behind_face_at_least(side, m_pushes[0]);
        wakes.offer(
            side,
            offer(fields.of[0], side, lag, there ? of(index).of[0] : nullptr, floor_of(there)),
            kAllFields);
    }

    void offer(const Brick& brick, const FieldArrays& fields, int side, unsigned risen,
               VisitLags& lags, Wakes& wakes) {
        const int index = brick.neighbours[std::size_t(side)];
        const Brick* there = index < 0 ? nullptr : &m_lattice.brick(index);
        const bool is_known = there && !there->is_blank;
        if (!there && m_lattice.is_beyond_border(coord_behind(brick, side))) return;
        for (std::size_t d = 0; d < kDirections; ++d) {
            if (!(risen >> d & 1)) continue;
            // For a brick with unknown materials, its floor suffices for a bound.
            const Fixed* lag = is_known ? lags.behind_face(side, m_pushes[d])
                                        : lags.behind_face_at_least(side, m_pushes[d]);
            const Fixed floor = there ? floor_of(*there, d) : -m_fields.m_ahead[d];
            wakes.offer(side, offer(fields[d], side, lag, there ? of(index).of[d] : nullptr, floor),
                        1u << d);
        }
    }

    Fixed offer(const Fixed* v, int side, const Fixed* lag, const Fixed* there, Fixed floor) const {
        return m_kernels.offer(v, m_lattice.brick_size(), side, lag, {there, nullptr, 1, floor});
    }

    DragFields& m_fields;
    Lattice& m_lattice;
    const SweepKernels& m_kernels;
    SweepWork& m_work;
    SweepRounds m_rounds;
    Fixed m_reach;
    std::array<ComponentPush, kDirections> m_pushes;
    bool m_at_rest = false;    ///< the bricks of the grabbed elements
    bool m_may_share = false;  ///< one array for all fields of a brick is allowed
    bool m_stretch_is_shear = false;
};

bool DragFields::solve(Lattice& lattice, std::span<const ElementRef> grabbed, Fixed reach,
                       const SweepKernels& kernels, const TaskArena& arena, int max_bricks,
                       SweepWork& work) {
    clear(lattice);
    Solver solver(*this, lattice, reach, kernels, work);
    solver.grab(grabbed);
    return solver.run(arena, max_bricks);
}

void DragFields::clear(const Lattice& lattice) {
    m_bricks.assign(std::size_t(lattice.brick_index_bound()), {});
    m_used = 0;
    const std::size_t count = std::size_t(lattice.elements_per_brick());
    m_array_bytes = (count * sizeof(Fixed) + 63) / 64 * 64;
}

Fixed* DragFields::take_arrays(std::size_t count) {
    const std::lock_guard lock(m_mutex);
    const std::size_t per_slab = kBricksPerSlab * count;
    if (m_used == m_slabs.size() * per_slab) {
        m_slabs.push_back(allocate_aligned<Fixed>(per_slab * m_array_bytes, 64));
    }
    const std::size_t slab = m_used / per_slab, position = m_used % per_slab;
    m_used += count;
    return m_slabs[slab].get() + position * (m_array_bytes / sizeof(Fixed));
}

}  // namespace pliant
