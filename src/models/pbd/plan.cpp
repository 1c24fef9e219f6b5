// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/plan.h"

#include <algorithm>
#include <cmath>

#include "pbd/packer.h"

namespace pliant::pbd {
namespace {

/// Offsets of the phases' domains, in domains. A constraint shorter than a quarter of a domain
/// crosses borders of at most one phase along each axis, so one of the four phases contains it.
constexpr double kShifts[] = {0, 0.5, 0.25, 0.75};
constexpr int kPhases = 4;
/// Smaller domains share packs, because they don't fill them alone.
constexpr std::size_t kSmallDomain = 1024;
constexpr std::int32_t kMaxCells = 1 << 16;  ///< along an axis
/// Particles per cache line, to avoid false sharing.
constexpr std::int32_t kLineParticles = 4;

struct Cells {
    Vec3d low{0, 0, 0}, per_length{0, 0, 0};
    Vec3i count{1, 1, 1};

    std::int64_t operator()(Vec3d position, int phase) const {
        std::int64_t cell = 0;
        for (int a = 2; a >= 0; --a) {
            std::int64_t along = 0;
            if (count[a] > 1)
                along = std::clamp<std::int64_t>(
                    std::int64_t((position[a] - low[a]) * per_length[a] + kShifts[phase]), 0,
                    count[a]);
            cell = cell * (count[a] + 1) + along;
        }
        return cell;
    }
};

/// Mean domain size seen by a particle.
double particles_of_domain(const Cells& cells, const std::vector<Vec3d>& positions,
                           std::vector<std::int64_t>& keys) {
    keys.resize(positions.size());
    for (std::size_t n = 0; n < positions.size(); ++n) keys[n] = cells(positions[n], 0);
    std::sort(keys.begin(), keys.end());
    double sum = 0;
    for (std::size_t n = 0, end = 0; n < keys.size(); n = end) {
        while (end < keys.size() && keys[end] == keys[n]) ++end;
        sum += double(end - n) * double(end - n);
    }
    return sum / double(keys.size());
}

Cells find_cells(const std::vector<Vec3d>& positions, std::int32_t domain_particles) {
    Vec3d low = positions[0], high = low;
    for (const Vec3d& p : positions)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const Vec3d extent = high - low;
    const double longest = std::max({extent.x, extent.y, extent.z});
    Cells cells{.low = low};
    if (!(longest > 0) || !std::isfinite(longest)) return cells;
    std::vector<std::int64_t> keys;
    for (;;) {
        for (int a = 0; a < 3; ++a)
            cells.per_length[a] = extent[a] > 0 ? cells.count[a] / extent[a] : 0;
        const double found = particles_of_domain(cells, positions, keys);
        int widest = 0;
        for (int a = 1; a < 3; ++a)
            if (extent[a] * cells.count[widest] > extent[widest] * cells.count[a]) widest = a;
        std::int32_t& count = cells.count[widest];
        if (found <= domain_particles || count >= kMaxCells) break;
        count += std::max(1, found > 3.0 * domain_particles ? count / 2 : 0);
    }
    return cells;
}

struct Member {
    std::int64_t cell;
    std::int32_t kind, constraint;
};

void number_particles(const Cells& cells, const PbdParts& parts, Plan& plan) {
    const auto count = parts.positions.size();
    std::vector<std::pair<std::int64_t, std::int32_t>> order(count);
    for (std::size_t n = 0; n < count; ++n)
        order[n] = {cells(parts.positions[n], 0), std::int32_t(n)};
    std::sort(order.begin(), order.end());
    plan.particle_of.resize(count);
    for (std::size_t n = 0; n < count; ++n)
        plan.particle_of[std::size_t(order[n].second)] = std::int32_t(n);
    plan.particle_count =
        std::int32_t((count + kLineParticles - 1) / kLineParticles) * kLineParticles;
}

/// Takes the members that lie completely in one domain of the phase, in the order of domains.
std::vector<Member> take_whole(const Cells& cells, const PbdParts& parts, int phase,
                               std::vector<Member>& members) {
    std::vector<Member> taken;
    std::size_t left = 0;
    for (const Member& member : members) {
        const auto nodes = nodes_of(parts, member.kind, std::size_t(member.constraint));
        const auto cell_of = [&](std::int32_t n) {
            return phase == kPhases ? 0 : cells(parts.positions[std::size_t(n)], phase);
        };
        const std::int64_t cell = cell_of(nodes[0]);
        const bool whole = std::all_of(nodes.begin(), nodes.end(),
                                       [&](std::int32_t n) { return cell_of(n) == cell; });
        if (whole)
            taken.push_back({cell, member.kind, member.constraint});
        else
            members[left++] = member;
    }
    members.resize(left);
    std::stable_sort(taken.begin(), taken.end(),
                     [](const Member& a, const Member& b) { return a.cell < b.cell; });
    return taken;
}

/// Ends of groups: one domain each, or several small ones.
std::vector<std::size_t> group_domains(const std::vector<Member>& members, bool join) {
    std::vector<std::size_t> ends;
    std::size_t begin = 0;
    for (std::size_t n = 0; n < members.size(); ++n) {
        const bool last = n + 1 == members.size();
        if (!last && members[n + 1].cell == members[n].cell) continue;
        if (!last && join && n + 1 - begin < kSmallDomain) continue;
        ends.push_back(begin = n + 1);
    }
    return ends;
}

}  // namespace

void find_slots(KindPlan& kind, std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot)
        if (const std::int32_t c = kind.constraints[slot]; c >= 0)
            kind.slots[std::size_t(c)] = std::int32_t(slot);
}

std::size_t constraint_count(const PbdParts& parts, int kind) {
    switch (PbdKind(kind)) {
        case PbdKind::Distance:
            return parts.distances.size();
        case PbdKind::Bend:
            return parts.bends.size();
        case PbdKind::Volume:
            return parts.volumes.size();
        case PbdKind::Solid:
            break;
    }
    return parts.solids.size();
}

std::span<const std::int32_t> nodes_of(const PbdParts& parts, int kind, std::size_t constraint) {
    switch (PbdKind(kind)) {
        case PbdKind::Distance:
            return parts.distances[constraint].nodes;
        case PbdKind::Bend:
            return parts.bends[constraint].nodes;
        case PbdKind::Volume:
            return parts.volumes[constraint].nodes;
        case PbdKind::Solid:
            break;
    }
    return parts.solids[constraint].nodes;
}

Plan make_plan(const PbdParts& parts, std::int32_t domain_particles) {
    Plan plan;
    if (parts.positions.empty()) return plan;
    const Cells cells = find_cells(parts.positions, domain_particles);
    number_particles(cells, parts, plan);
    std::vector<Member> left;
    for (int kind = 0; kind < kKinds; ++kind) {
        const std::size_t count = constraint_count(parts, kind);
        plan.kinds[kind].slots.resize(count);
        for (std::size_t c = 0; c < count; ++c) left.push_back({0, kind, std::int32_t(c)});
    }
    Packer packer(plan.particle_of, parts);
    std::vector<std::int32_t> constraints;
    std::int32_t most_domains = 0;
    for (int phase = 0; phase <= kPhases; ++phase) {
        const std::vector<Member> taken = take_whole(cells, parts, phase, left);
        if (taken.empty()) continue;
        const auto first = std::int32_t(plan.domains.size());
        std::size_t begin = 0;
        for (const std::size_t end : group_domains(taken, phase > 0)) {
            const auto number = std::int32_t(plan.domains.size()) - first;
            const std::int32_t spare = plan.particle_count + kLineParticles * number;
            Domain domain{};
            std::vector<Member> group(taken.begin() + std::ptrdiff_t(begin),
                                      taken.begin() + std::ptrdiff_t(end));
            std::stable_sort(group.begin(), group.end(),
                             [](const Member& a, const Member& b) { return a.kind < b.kind; });
            for (std::size_t m = 0; m < group.size();) {
                const int kind = group[m].kind;
                constraints.clear();
                for (; m < group.size() && group[m].kind == kind; ++m)
                    constraints.push_back(group[m].constraint);
                domain.packs[kind] = packer.pack(constraints, kind, spare, plan.kinds[kind]);
            }
            plan.domains.push_back(domain);
            plan.spares.push_back(spare);
            begin = end;
        }
        plan.phases.push_back({first, std::int32_t(plan.domains.size())});
        most_domains = std::max(most_domains, plan.phases.back().end - first);
    }
    plan.particle_count += kLineParticles * most_domains;
    for (KindPlan& kind : plan.kinds) find_slots(kind, 0, kind.constraints.size());
    return plan;
}

}  // namespace pliant::pbd
