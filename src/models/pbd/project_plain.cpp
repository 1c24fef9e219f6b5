// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/arithmetic.h"
#include "pbd/ogden.h"
#include "pbd/project.h"

namespace pliant::pbd {
namespace {

template <class Real>
Corner<Real> load(const Real* p) {
    return {{p[0], p[1], p[2]}, p[3]};
}
template <class Real>
void store(const Corner<Real>& c, Real* p) {
    p[0] = c.p.x;
    p[1] = c.p.y;
    p[2] = c.p.z;
}

/// Access to the numbers of one lane of a pack.
template <class Real, int Kind>
struct Lane {
    const PackArrays<Real>& arrays;
    std::size_t pack, lane;

    std::uint32_t corner(int n) const { return arrays.corners[at(kCorners[Kind], n)]; }
    Real number(int n) const { return arrays.numbers[at(kNumbers[Kind], n)]; }
    Real so_far(int n, bool first) const { return first ? Real(0) : multiplier(n); }
    Real& multiplier(int n) const { return arrays.multipliers[at(kMultipliers[Kind], n)]; }
    std::size_t at(int per_pack, int n) const {
        return (pack * std::size_t(per_pack) + std::size_t(n)) * kPack + lane;
    }
};

/// The same corner in double precision, in which Ogden's law is computed.
template <class Real>
Corner<double> widened(const Corner<Real>& c) {
    return {{double(c.p.x), double(c.p.y), double(c.p.z)}, double(c.w)};
}
template <class Real>
Triple<Real> narrowed(const Triple<double>& t) {
    return {Real(t.x), Real(t.y), Real(t.z)};
}

template <class Real>
OgdenSolid ogden_solid(const Lane<Real, int(PbdKind::Solid)>& lane) {
    OgdenSolid s{};
    for (int n = 0; n < 9; ++n) s.inverse[n / 3][n % 3] = double(lane.number(n));
    s.alpha = double(lane.number(kExponent));
    return s;
}

template <class Real>
void project_solid_lane(const ProjectArrays<Real>& a, const Lane<Real, int(PbdKind::Solid)>& lane,
                        Corner<Real> (&p)[4]) {
    Solid<Real> s{};
    for (int n = 0; n < 9; ++n) s.inverse[n / 3][n % 3] = lane.number(n);
    s.h_compliance = lane.number(9) * a.compliance_scale;
    s.e_compliance = lane.number(10) * a.compliance_scale;
    s.h_multiplier = lane.so_far(0, a.first);
    s.e_multiplier = lane.so_far(1, a.first);
    project_solid(p, s);
    lane.multiplier(0) = s.h_multiplier;
    lane.multiplier(1) = s.e_multiplier;
}

template <class Real>
void project_ogden_lane(const ProjectArrays<Real>& a, const Lane<Real, int(PbdKind::Solid)>& lane,
                        Corner<Real> (&p)[4]) {
    Corner<double> q[4];
    for (int n = 0; n < 4; ++n) q[n] = widened(p[n]);
    Solid<double> s{};
    s.h_compliance = double(lane.number(9)) * double(a.compliance_scale);
    s.e_compliance = double(lane.number(10)) * double(a.compliance_scale);
    s.h_multiplier = double(lane.so_far(0, a.first));
    s.e_multiplier = double(lane.so_far(1, a.first));
    project_both(q, ogden_constraints(q, ogden_solid(lane)), s);
    lane.multiplier(0) = Real(s.h_multiplier);
    lane.multiplier(1) = Real(s.e_multiplier);
    for (int n = 0; n < 4; ++n) p[n].p = narrowed<Real>(q[n].p);
}

template <class Real>
Real work_warm_ogden(const ProjectArrays<Real>& a, const Lane<Real, int(PbdKind::Solid)>& lane,
                     Corner<Real> (&p)[4], Balanced<Real>& forces, bool recall) {
    Corner<double> q[4];
    Balanced<double> f;
    for (int n = 0; n < 4; ++n) {
        q[n] = widened(p[n]);
        f[n] = {double(forces[n].x), double(forces[n].y), double(forces[n].z)};
    }
    WarmSolid<double> s{};
    s.h_stiffness = double(a.square_step) / double(lane.number(9));
    s.e_stiffness = double(a.square_step) / double(lane.number(10));
    const OgdenGradients c = ogden_gradients(q, ogden_solid(lane), s.e_stiffness);
    const double share = recall ? recall_along(q, c.gradients, s, c.shear, f)
                                : project_along(q, c.gradients, s, c.shear, f);
    for (int n = 0; n < 4; ++n) {
        p[n].p = narrowed<Real>(q[n].p);
        forces[n] = narrowed<Real>(f[n]);
    }
    return Real(c.share * share);
}

template <class Real, int Kind, bool Compliant>
void project_lane(const ProjectArrays<Real>& a, const Lane<Real, Kind>& lane) {
    constexpr int kCount = kCorners[Kind];
    Corner<Real> p[kCount];
    for (int n = 0; n < kCount; ++n) p[n] = load(a.particles + lane.corner(n));
    if constexpr (Kind == int(PbdKind::Solid)) {
        lane.number(kExponent) != 0 ? project_ogden_lane(a, lane, p)
                                    : project_solid_lane(a, lane, p);
    } else {
        Law<Real> law{lane.number(1), lane.so_far(0, a.first)};
        if constexpr (Compliant) law.number = law.number * a.compliance_scale;
        if constexpr (Kind == int(PbdKind::Distance))
            project_distance<Compliant>(p[0], p[1], lane.number(0), law);
        else if constexpr (Kind == int(PbdKind::Bend))
            project_gradients<Compliant>(p, bend_constraint(p, lane.number(0)), law);
        else
            project_gradients<Compliant>(p, volume_constraint(p, lane.number(0)), law);
        lane.multiplier(0) = law.multiplier;
    }
    for (int n = 0; n < kCount; ++n) store(p[n], a.particles + lane.corner(n));
}

template <class Real, int Kind, bool Compliant>
void project_packs(const ProjectArrays<Real>& a, PackRange range) {
    for (std::int32_t n = range.begin; n < range.end; ++n) {
        const std::int32_t pack = a.backward ? range.begin + range.end - 1 - n : n;
        for (std::size_t lane = 0; lane < kPack; ++lane)
            project_lane<Real, Kind, Compliant>(a, {a.kinds[Kind], std::size_t(pack), lane});
    }
}

template <class Real>
void work_warm_lane(const ProjectArrays<Real>& a, const Lane<Real, int(PbdKind::Solid)>& lane,
                    bool recall) {
    Corner<Real> p[4];
    for (int n = 0; n < 4; ++n) p[n] = load(a.particles + lane.corner(n));
    const WarmSolid<Real> s{lane.number(0),
                            lane.number(1),
                            lane.number(2),
                            lane.number(3),
                            lane.number(4),
                            lane.number(5),
                            lane.number(6),
                            lane.number(7) * a.square_step,
                            lane.number(8) * a.square_step};
    const auto kept = [&](int n) -> Real& { return a.forces[lane.at(kWarm, n)]; };
    Balanced<Real> f;
    for (int n = 0; n < 3; ++n) f[n + 1] = {kept(3 * n), kept(3 * n + 1), kept(3 * n + 2)};
    balance(f);
    Real share = lane.number(kExponent) != 0 ? work_warm_ogden(a, lane, p, f, recall)
                 : recall                    ? recall_solid(p, s, f)
                                             : project_warm(p, s, f);
    if (!a.last) share = 1;
    for (int n = 0; n < 4; ++n) {
        store(p[n], a.particles + lane.corner(n));
        f[n] = scaled(share, f[n]);
        if (n > 0) {
            kept(3 * n - 3) = f[n].x;
            kept(3 * n - 2) = f[n].y;
            kept(3 * n - 1) = f[n].z;
        }
        if (!a.last) continue;
        Corner<Real> moved = load(a.moves + lane.corner(n));
        moved.p = moved.p + scaled(signed_weight(p, n), f[n]);
        store(moved, a.moves + lane.corner(n));
    }
    kept(9) = share;
}
template <class Real>
void work_warm_packs(const ProjectArrays<Real>& a, PackRange range, bool recall) {
    for (std::int32_t n = range.begin; n < range.end; ++n) {
        const std::int32_t pack = a.backward ? range.begin + range.end - 1 - n : n;
        for (std::size_t lane = 0; lane < kPack; ++lane)
            work_warm_lane<Real>(a, {a.kinds[int(PbdKind::Solid)], std::size_t(pack), lane},
                                 recall);
    }
}
template <class Real>
void project_solids(const ProjectArrays<Real>& a, PackRange range) {
    a.forces ? work_warm_packs(a, range, false)
             : project_packs<Real, int(PbdKind::Solid), true>(a, range);
}
template <class Real>
void recall(const ProjectArrays<Real>& a, const Domain& domain) {
    work_warm_packs(a, domain.packs[int(PbdKind::Solid)], true);
}

template <class Real, bool Compliant>
void project_kinds(const ProjectArrays<Real>& a, const Domain& domain) {
    if (a.backward) project_solids(a, domain.packs[3]);
    if (a.backward) project_packs<Real, 2, Compliant>(a, domain.packs[2]);
    if (a.backward) project_packs<Real, 1, Compliant>(a, domain.packs[1]);
    project_packs<Real, 0, Compliant>(a, domain.packs[0]);
    if (a.backward) return;
    project_packs<Real, 1, Compliant>(a, domain.packs[1]);
    project_packs<Real, 2, Compliant>(a, domain.packs[2]);
    project_solids(a, domain.packs[3]);
}

template <class Real>
void project(const ProjectArrays<Real>& a, const Domain& domain) {
    a.compliant ? project_kinds<Real, true>(a, domain) : project_kinds<Real, false>(a, domain);
}

template <class Real>
void move(const MoveArrays<Real>& a, std::int64_t begin, std::int64_t end) {
    for (auto n = std::size_t(4 * begin); n < std::size_t(4 * end); ++n) {
        const bool moves = a.x[n | 3] > 0;
        const Real v = (a.v[n] + (a.x[n] - a.before[n]) * a.per_h) * a.keep + a.push[n % 4];
        a.v[n] = moves ? v : Real(0);
        a.x[n] = a.x[n] + a.h * a.v[n];
        a.before[n] = a.x[n];
        if (!a.moves) continue;
        a.x[n] = a.x[n] + a.moves[n];
        a.moves[n] = 0;
    }
}

}  // namespace

template <class Real>
Kernels<Real> plain_kernels() {
    return {project<Real>, move<Real>, recall<Real>};
}
template Kernels<float> plain_kernels<float>();
template Kernels<double> plain_kernels<double>();

void project_solid_pack(const ProjectArrays<float>& a, std::int32_t pack, bool recall) {
    const PackRange one{pack, pack, pack + 1};
    recall ? work_warm_packs(a, one, true) : project_solids(a, one);
}

}  // namespace pliant::pbd
