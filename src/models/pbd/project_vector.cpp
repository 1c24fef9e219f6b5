// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vectorised inner loop, compiled for each instruction set and dispatched at run time. The
// scalar version is project_plain.cpp.
//
// A particle is sixteen bytes, x y z w, so one load reads all of it. Four particles in a vector
// register are transposed to x's, y's, z's and w's by shuffles within blocks of sixteen bytes. That
// is several times as fast as gathering each component.

#include <cstddef>
#include <cstdint>

#include "pbd/project.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pbd/project_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::pbd::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128

Kernels<float> kernels_of_target() {
    return plain_kernels<float>();
}

#else

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, kPack>;
using V = hn::Vec<D>;
constexpr std::size_t kLanes = hn::MaxLanes(D());

template <class U>
HWY_INLINE V constant(double number) {
    return hn::Set(D(), float(number));
}
HWY_INLINE V root(V v) {
    return hn::Sqrt(v);
}
/// Same as a > b ? a : b.
HWY_INLINE V larger(V a, V b) {
    return hn::IfThenElse(hn::Gt(a, b), a, b);
}
HWY_INLINE V smaller(V a, V b) {
    return hn::IfThenElse(hn::Lt(a, b), a, b);
}
HWY_INLINE V where_positive(V test, V yes, V no) {
    return hn::IfThenElse(hn::Gt(test, hn::Zero(D())), yes, no);
}

#include "pbd/arc_tangent.inc"

HWY_INLINE V arc_tangent(V y, V x) {
    return polynomial_arc_tangent(y, x);
}

#include "pbd/constraints.inc"

/// Loads particles 0, 4, 8, 12 of a list, one per block.
template <class Tag>
HWY_INLINE hn::Vec<Tag> load_every_fourth(Tag d, const float* particles,
                                          const std::uint32_t* list) {
    constexpr std::size_t kCount = hn::MaxLanes(Tag());
    if constexpr (kCount == 4) {
        return hn::LoadU(d, particles + list[0]);
    } else {
        const hn::Half<Tag> half;
        return hn::Combine(d, load_every_fourth(half, particles, list + kCount / 2),
                           load_every_fourth(half, particles, list));
    }
}
template <class Tag>
HWY_INLINE void store_every_fourth(Tag d, hn::Vec<Tag> v, float* particles,
                                   const std::uint32_t* list) {
    constexpr std::size_t kCount = hn::MaxLanes(Tag());
    if constexpr (kCount == 4) {
        hn::StoreU(v, d, particles + list[0]);
    } else {
        const hn::Half<Tag> half;
        store_every_fourth(half, hn::LowerHalf(half, v), particles, list);
        store_every_fourth(half, hn::UpperHalf(half, v), particles, list + kCount / 2);
    }
}

/// Transposes 4 × 4 within each block of sixteen bytes; involutory.
HWY_INLINE void transpose(V& a, V& b, V& c, V& d) {
    const D tag;
    const V ac_low = hn::InterleaveLower(tag, a, c), ac_high = hn::InterleaveUpper(tag, a, c);
    const V bd_low = hn::InterleaveLower(tag, b, d), bd_high = hn::InterleaveUpper(tag, b, d);
    a = hn::InterleaveLower(tag, ac_low, bd_low);
    b = hn::InterleaveUpper(tag, ac_low, bd_low);
    c = hn::InterleaveLower(tag, ac_high, bd_high);
    d = hn::InterleaveUpper(tag, ac_high, bd_high);
}

/// Adds to the particles of the list.
template <class Tag>
HWY_INLINE void add_every_fourth(Tag d, hn::Vec<Tag> v, float* particles,
                                 const std::uint32_t* list) {
    constexpr std::size_t kCount = hn::MaxLanes(Tag());
    if constexpr (kCount == 4) {
        hn::StoreU(hn::LoadU(d, particles + list[0]) + v, d, particles + list[0]);
    } else {
        const hn::Half<Tag> half;
        add_every_fourth(half, hn::LowerHalf(half, v), particles, list);
        add_every_fourth(half, hn::UpperHalf(half, v), particles, list + kCount / 2);
    }
}

HWY_INLINE Corner<V> load_corner(const float* particles, const std::uint32_t* list) {
    const D tag;
    V a = load_every_fourth(tag, particles, list), b = load_every_fourth(tag, particles, list + 1);
    V c = load_every_fourth(tag, particles, list + 2);
    V d = load_every_fourth(tag, particles, list + 3);
    transpose(a, b, c, d);
    return {{a, b, c}, d};
}
HWY_INLINE void store_corner(const Corner<V>& corner, float* particles, const std::uint32_t* list) {
    const D tag;
    V a = corner.p.x, b = corner.p.y, c = corner.p.z, d = corner.w;
    transpose(a, b, c, d);
    store_every_fourth(tag, a, particles, list);
    store_every_fourth(tag, b, particles, list + 1);
    store_every_fourth(tag, c, particles, list + 2);
    store_every_fourth(tag, d, particles, list + 3);
}

HWY_INLINE void add_to_corner(const Triple<V>& by, float* particles, const std::uint32_t* list) {
    const D tag;
    V a = by.x, b = by.y, c = by.z, d = hn::Zero(tag);
    transpose(a, b, c, d);
    add_every_fourth(tag, a, particles, list);
    add_every_fourth(tag, b, particles, list + 1);
    add_every_fourth(tag, c, particles, list + 2);
    add_every_fourth(tag, d, particles, list + 3);
}

/// Processing of a pack's lanes: load, project, store.
template <int Kind, bool Compliant>
struct Lanes {
    static constexpr int kCount = kCorners[Kind];

    HWY_INLINE Lanes(const ProjectArrays<float>& a, std::size_t pack, std::size_t lane)
        : particles(a.particles),
          lists(a.kinds[Kind].corners + pack * kCount * kPack + lane),
          numbers(a.kinds[Kind].numbers + pack * kNumbers[Kind] * kPack + lane),
          multipliers(a.kinds[Kind].multipliers + pack * kMultipliers[Kind] * kPack + lane),
          scale(a.compliance_scale),
          first(a.first) {}
    HWY_INLINE void load(Corner<V> (&p)[kCount]) const {
        for (int n = 0; n < kCount; ++n) p[n] = load_corner(particles, lists + n * kPack);
    }
    HWY_INLINE void store(const Corner<V> (&p)[kCount]) const {
        for (int n = 0; n < kCount; ++n) store_corner(p[n], particles, lists + n * kPack);
    }
    HWY_INLINE V number(int n) const { return hn::Load(D(), numbers + n * kPack); }
    HWY_INLINE V so_far(int n) const {
        return first ? hn::Zero(D()) : hn::Load(D(), multipliers + n * kPack);
    }
    HWY_INLINE void project(Corner<V> (&p)[kCount]) const {
        const D d;
        const V by_step = hn::Set(d, scale);
        if constexpr (Kind == int(PbdKind::Solid)) {
            Solid<V> s;
            for (int n = 0; n < 9; ++n) s.inverse[n / 3][n % 3] = number(n);
            s.h_compliance = hn::Mul(number(9), by_step);
            s.e_compliance = hn::Mul(number(10), by_step);
            s.h_multiplier = so_far(0);
            s.e_multiplier = so_far(1);
            project_solid(p, s);
            hn::Store(s.h_multiplier, d, multipliers);
            hn::Store(s.e_multiplier, d, multipliers + kPack);
        } else {
            Law<V> law{number(1), so_far(0)};
            if constexpr (Compliant) law.number = hn::Mul(law.number, by_step);
            if constexpr (Kind == int(PbdKind::Distance))
                project_distance<Compliant>(p[0], p[1], number(0), law);
            else if constexpr (Kind == int(PbdKind::Bend))
                project_gradients<Compliant>(p, bend_constraint(p, number(0)), law);
            else
                project_gradients<Compliant>(p, volume_constraint(p, number(0)), law);
            hn::Store(law.multiplier, d, multipliers);
        }
    }

    float* particles;
    const std::uint32_t* lists;
    const float* numbers;
    float* multipliers;
    float scale;
    bool first;
};

template <int Kind, bool Compliant>
void project_packs(const ProjectArrays<float>& a, PackRange range) {
    using Part = Lanes<Kind, Compliant>;
    const std::int32_t pairs = (range.paired_end - range.begin) / 2,
                       count = pairs + range.end - range.paired_end;
    for (std::int32_t n = 0; n < count; ++n) {
        const std::int32_t at = a.backward ? count - 1 - n : n;
        if (at >= pairs) {
            const auto pack = std::size_t(range.paired_end + at - pairs);
            for (std::size_t lane = 0; lane < kPack; lane += kLanes) {
                const Part one(a, pack, lane);
                Corner<V> p[Part::kCount];
                one.load(p);
                one.project(p);
                one.store(p);
            }
            continue;
        }
        const auto pack = std::size_t(range.begin + 2 * at);
        for (std::size_t lane = 0; lane < kPack; lane += kLanes) {
            const Part one(a, pack, lane), other(a, pack + 1, lane);
            Corner<V> p[Part::kCount], q[Part::kCount];
            one.load(p);
            other.load(q);
            one.project(p);
            other.project(q);
            one.store(p);
            other.store(q);
        }
    }
}

/// Lanes of solids with warm starts.
struct WarmLanes : Lanes<int(PbdKind::Solid), true> {
    HWY_INLINE WarmLanes(const ProjectArrays<float>& all, std::size_t pack, std::size_t lane)
        : Lanes(all, pack, lane), a(all), kept(all.forces + pack * kWarm * kPack + lane) {}
    HWY_INLINE WarmSolid<V> solid() const {
        const V step2 = hn::Set(D(), a.square_step);
        return {number(0), number(1), number(2),         number(3),        number(4),
                number(5), number(6), number(7) * step2, number(8) * step2};
    }
    HWY_INLINE V force(int n) const { return hn::Load(D(), kept + n * kPack); }
    HWY_INLINE void load_forces(Balanced<V>& f) const {
        for (int n = 0; n < 3; ++n) f[n + 1] = {force(3 * n), force(3 * n + 1), force(3 * n + 2)};
        balance(f);
    }
    HWY_INLINE void keep(const Corner<V> (&p)[4], Balanced<V>& f, V share) const {
        if (!a.last) share = constant<V>(1);
        for (int n = 0; n < 4; ++n) f[n] = scaled(share, f[n]);
        for (int n = 0; n < 3; ++n) {
            hn::Store(f[n + 1].x, D(), kept + 3 * n * kPack);
            hn::Store(f[n + 1].y, D(), kept + (3 * n + 1) * kPack);
            hn::Store(f[n + 1].z, D(), kept + (3 * n + 2) * kPack);
        }
        hn::Store(share, D(), kept + 9 * kPack);
        if (!a.last) return;
        for (int n = 0; n < 4; ++n)
            add_to_corner(scaled(signed_weight(p, n), f[n]), a.moves, lists + n * kPack);
    }

    const ProjectArrays<float>& a;
    float* kept;
};

void project_warm_packs(const ProjectArrays<float>& a, PackRange range) {
    for (std::int32_t n = range.begin; n < range.end; ++n) {
        const std::int32_t pack = a.backward ? range.begin + range.end - 1 - n : n;
        for (std::size_t lane = 0; lane < kPack; lane += kLanes) {
            const WarmLanes some(a, std::size_t(pack), lane);
            Corner<V> p[4];
            Balanced<V> f;
            some.load(p);
            some.load_forces(f);
            const V share = project_warm(p, some.solid(), f);
            some.store(p);
            some.keep(p, f, share);
        }
    }
}

void recall(const ProjectArrays<float>& a, const Domain& domain) {
    const PackRange range = domain.packs[int(PbdKind::Solid)];
    for (std::int32_t pack = range.begin; pack < range.end; ++pack) {
        if (a.ogden && has_ogden(a, pack)) {
            project_solid_pack(a, pack, true);
            continue;
        }
        for (std::size_t lane = 0; lane < kPack; lane += kLanes) {
            const WarmLanes some(a, std::size_t(pack), lane);
            Corner<V> p[4];
            Balanced<V> f;
            some.load(p);
            const V share = recall_solid(p, some.solid(), f);
            some.keep(p, f, share);
        }
    }
}

using ProjectPacks = void(const ProjectArrays<float>&, PackRange);
ProjectPacks* solids_projection(const ProjectArrays<float>& a) {
    return a.forces ? project_warm_packs : project_packs<3, true>;
}
/// Packs with a solid of Ogden's law are processed by the scalar code.
void project_mixed_packs(const ProjectArrays<float>& a, PackRange range) {
    for (std::int32_t n = range.begin; n < range.end; ++n) {
        const std::int32_t pack = a.backward ? range.begin + range.end - 1 - n : n;
        if (has_ogden(a, pack))
            project_solid_pack(a, pack, false);
        else
            solids_projection(a)(a, {pack, pack, pack + 1});
    }
}

template <bool Compliant>
void project_kinds(const ProjectArrays<float>& a, const Domain& domain) {
    ProjectPacks* const project_solids = a.ogden ? project_mixed_packs : solids_projection(a);
    if (a.backward) project_solids(a, domain.packs[3]);
    if (a.backward) project_packs<2, Compliant>(a, domain.packs[2]);
    if (a.backward) project_packs<1, Compliant>(a, domain.packs[1]);
    project_packs<0, Compliant>(a, domain.packs[0]);
    if (a.backward) return;
    project_packs<1, Compliant>(a, domain.packs[1]);
    project_packs<2, Compliant>(a, domain.packs[2]);
    project_solids(a, domain.packs[3]);
}

void project(const ProjectArrays<float>& a, const Domain& domain) {
    a.compliant ? project_kinds<true>(a, domain) : project_kinds<false>(a, domain);
}

void move(const MoveArrays<float>& a, std::int64_t begin, std::int64_t end) {
    const D d;
    const V h = hn::Set(d, a.h), per_h = hn::Set(d, a.per_h), keep = hn::Set(d, a.keep);
    const V push = hn::LoadDup128(d, a.push);
    for (std::int64_t n = 4 * begin; n < 4 * end; n += std::int64_t(kLanes)) {
        const V x = hn::Load(d, a.x + n), before = hn::Load(d, a.before + n);
        const auto moves = hn::Gt(hn::Broadcast<3>(x), hn::Zero(d));
        const V v = (hn::Load(d, a.v + n) + (x - before) * per_h) * keep + push;
        const V kept = hn::IfThenElseZero(moves, v);
        const V moved = x + h * kept;
        hn::Store(kept, d, a.v + n);
        hn::Store(moved, d, a.before + n);
        if (!a.moves) {
            hn::Store(moved, d, a.x + n);
            continue;
        }
        hn::Store(moved + hn::Load(d, a.moves + n), d, a.x + n);
        hn::Store(hn::Zero(d), d, a.moves + n);
    }
}

Kernels<float> kernels_of_target() {
    return {project, move, recall};
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::pbd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant::pbd {
HWY_EXPORT(kernels_of_target);
Kernels<float> vector_kernels() {
    return HWY_DYNAMIC_DISPATCH(kernels_of_target)();
}
}  // namespace pliant::pbd
#endif
