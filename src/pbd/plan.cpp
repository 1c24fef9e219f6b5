// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace pliant::pbd {
namespace {

/// How far the domains of a phase are moved, in domains. A constraint shorter than a quarter of a
/// domain crosses borders of at most one phase along each axis, so one of the four has it whole.
constexpr double kShifts[] = {0, 0.5, 0.25, 0.75};
constexpr int kPhases = 4;
/// Small domains share packs, since alone they don't fill them.
constexpr std::size_t kSmallDomain = 1024;
constexpr std::int32_t kMostCells = 1 << 16;  ///< along an axis
/// Particles of the size of a cache line, so that threads don't share one.
constexpr std::int32_t kLineParticles = 4;

struct Cells {
    Vec3d low{0, 0, 0}, per_length{0, 0, 0};
    Vec3i count{1, 1, 1};

    std::int64_t operator()(Vec3d place, int phase) const {
        std::int64_t cell = 0;
        for (int a = 2; a >= 0; --a) {
            std::int64_t along = 0;
            if (count[a] > 1)
                along = std::clamp<std::int64_t>(
                    std::int64_t((place[a] - low[a]) * per_length[a] + kShifts[phase]), 0,
                    count[a]);
            cell = cell * (count[a] + 1) + along;
        }
        return cell;
    }
};

/// In how large a domain a particle is, on the average.
double particles_of_domain(const Cells& cells, const std::vector<Vec3d>& places,
                           std::vector<std::int64_t>& keys) {
    keys.resize(places.size());
    for (std::size_t n = 0; n < places.size(); ++n) keys[n] = cells(places[n], 0);
    std::sort(keys.begin(), keys.end());
    double sum = 0;
    for (std::size_t n = 0, end = 0; n < keys.size(); n = end) {
        while (end < keys.size() && keys[end] == keys[n]) ++end;
        sum += double(end - n) * double(end - n);
    }
    return sum / double(keys.size());
}

Cells find_cells(const std::vector<Vec3d>& places, std::int32_t domain_particles) {
    Vec3d low = places[0], high = low;
    for (const Vec3d& p : places)
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
        const double found = particles_of_domain(cells, places, keys);
        int widest = 0;
        for (int a = 1; a < 3; ++a)
            if (extent[a] * cells.count[widest] > extent[widest] * cells.count[a]) widest = a;
        std::int32_t& count = cells.count[widest];
        if (found <= domain_particles || count >= kMostCells) break;
        count += std::max(1, found > 3.0 * domain_particles ? count / 2 : 0);
    }
    return cells;
}

struct Member {
    std::int64_t cell;
    std::int32_t kind, constraint;
};

/// Puts constraints into packs: each into the first one that none of its particles is in.
class Packer {
  public:
    Packer(Plan& plan, const PbdParts& parts) : m_plan(plan), m_parts(parts) {
        m_packs_of.assign(parts.places.size(), 0);
    }

    /// @param members  all of one kind. @param spare  the particle of empty lanes
    PackRange pack(std::span<const Member> members, int kind, std::int32_t spare) {
        KindPlan& plan = m_plan.kinds[kind];
        const auto first = std::int32_t(plan.constraints.size() / kPack);
        m_first = m_next = first;
        m_open = 0;
        for (const Member& member : members) add(plan, kind, member.constraint);
        while (m_first < m_next) forget_first(plan, kind);
        const std::int32_t pairs = pair_up(plan, kind, first);
        write_corners(plan, kind, first, spare);
        return {first, first + 2 * pairs, m_next};
    }

  private:
    static constexpr int kWindow = 64;  ///< packs that are looked at

    void add(KindPlan& plan, int kind, std::int32_t constraint) {
        const auto nodes = nodes_of(m_parts, kind, std::size_t(constraint));
        std::uint64_t taken = 0;
        for (const std::int32_t n : nodes) taken |= m_packs_of[std::size_t(n)];
        // In the order of their making: the oldest of the window is at its first bit.
        const int turn = m_first % kWindow;
        std::uint64_t free = std::rotr(m_open & ~taken, turn);
        if (free == 0) {
            if (m_next - m_first == kWindow) forget_first(plan, kind);
            m_open |= std::uint64_t(1) << (m_next % kWindow);
            m_used[m_next % kWindow] = 0;
            ++m_next;
            plan.constraints.insert(plan.constraints.end(), kPack, -1);
            free = std::uint64_t(1) << (m_next - 1 - m_first);
        }
        const std::int32_t pack = m_first + std::countr_zero(free);
        const int slot = pack % kWindow;
        const int lane = m_used[slot]++;
        if (lane == kPack - 1) m_open &= ~(std::uint64_t(1) << slot);
        plan.constraints[std::size_t(pack) * kPack + std::size_t(lane)] = constraint;
        for (const std::int32_t n : nodes) m_packs_of[std::size_t(n)] |= std::uint64_t(1) << slot;
    }

    void forget_first(const KindPlan& plan, int kind) {
        const std::uint64_t bit = std::uint64_t(1) << (m_first % kWindow);
        for (int lane = 0; lane < kPack; ++lane) {
            const std::int32_t c =
                plan.constraints[std::size_t(m_first) * kPack + std::size_t(lane)];
            if (c < 0) continue;
            for (const std::int32_t n : nodes_of(m_parts, kind, std::size_t(c)))
                m_packs_of[std::size_t(n)] &= ~bit;
        }
        m_open &= ~bit;
        ++m_first;
    }

    /// Puts packs that share no particle side by side, those that find no partner last. A pack's
    /// loads, sums and stores are longer than what a processor looks ahead; two at once fill its
    /// gaps.
    /// @returns the number of pairs
    std::int32_t pair_up(KindPlan& plan, int kind, std::int32_t first) {
        const auto pack_begin = [&](std::int32_t pack) {
            return plan.constraints.begin() + std::ptrdiff_t(pack) * kPack;
        };
        m_pair_of.assign(m_parts.places.size(), -1);
        const auto each_particle = [&](std::int32_t pack, const auto& work) {
            std::for_each(pack_begin(pack), pack_begin(pack + 1), [&](std::int32_t c) {
                if (c < 0) return;
                for (const std::int32_t n : nodes_of(m_parts, kind, std::size_t(c)))
                    work(m_pair_of[std::size_t(n)]);
            });
        };
        std::vector<std::int32_t> left, order, alone;
        for (std::int32_t pack = m_next; pack-- > first;) left.push_back(pack);
        std::int32_t pairs = 0;
        while (!left.empty()) {
            const std::int32_t pack = left.back();
            left.pop_back();
            each_particle(pack, [&](std::int32_t& pair) { pair = pairs; });
            const auto other =
                std::find_if(left.rbegin(), left.rend(), [&](std::int32_t candidate) {
                    bool meets = false;
                    each_particle(candidate, [&](std::int32_t& pair) { meets |= pair == pairs; });
                    return !meets;
                });
            if (other == left.rend()) {
                each_particle(pack, [&](std::int32_t& pair) { pair = -1; });
                alone.push_back(pack);
                continue;
            }
            order.insert(order.end(), {pack, *other});
            left.erase(std::next(other).base());
            ++pairs;
        }
        order.insert(order.end(), alone.begin(), alone.end());
        const std::vector<std::int32_t> packs(pack_begin(first), plan.constraints.end());
        for (std::size_t n = 0; n < order.size(); ++n)
            std::copy_n(packs.begin() + std::ptrdiff_t(order[n] - first) * kPack, kPack,
                        pack_begin(first + std::int32_t(n)));
        return pairs;
    }

    void write_corners(KindPlan& plan, int kind, std::int32_t first, std::int32_t spare) {
        const auto corners = std::size_t(kCorners[kind]);
        plan.corners.resize(std::size_t(m_next) * corners * kPack);
        for (auto pack = std::size_t(first); pack < std::size_t(m_next); ++pack)
            for (std::size_t lane = 0; lane < kPack; ++lane) {
                const std::int32_t c = plan.constraints[pack * kPack + lane];
                if (c >= 0) plan.slots[std::size_t(c)] = std::int32_t(pack * kPack + lane);
                for (std::size_t n = 0; n < corners; ++n) {
                    const std::int32_t particle = c < 0 ? spare
                                                        : m_plan.particle_of[std::size_t(nodes_of(
                                                              m_parts, kind, std::size_t(c))[n])];
                    plan.corners[(pack * corners + n) * kPack + lane] = 4 * std::uint32_t(particle);
                }
            }
    }

    Plan& m_plan;
    const PbdParts& m_parts;
    std::vector<std::uint64_t> m_packs_of;  ///< of each particle: packs of the window
    std::int32_t m_first = 0, m_next = 0;   ///< of the window
    std::uint64_t m_open = 0;
    int m_used[kWindow] = {};
    std::vector<std::int32_t> m_pair_of;  ///< of each particle
};

void number_particles(const Cells& cells, const PbdParts& parts, Plan& plan) {
    const auto count = parts.places.size();
    std::vector<std::pair<std::int64_t, std::int32_t>> order(count);
    for (std::size_t n = 0; n < count; ++n) order[n] = {cells(parts.places[n], 0), std::int32_t(n)};
    std::sort(order.begin(), order.end());
    plan.particle_of.resize(count);
    for (std::size_t n = 0; n < count; ++n)
        plan.particle_of[std::size_t(order[n].second)] = std::int32_t(n);
    plan.particle_count =
        std::int32_t((count + kLineParticles - 1) / kLineParticles) * kLineParticles;
}

/// Takes those of the members that are whole in one domain of the phase, in the order of domains.
std::vector<Member> take_whole(const Cells& cells, const PbdParts& parts, int phase,
                               std::vector<Member>& members) {
    std::vector<Member> taken;
    std::size_t left = 0;
    for (const Member& member : members) {
        const auto nodes = nodes_of(parts, member.kind, std::size_t(member.constraint));
        const auto cell_of = [&](std::int32_t n) {
            return phase == kPhases ? 0 : cells(parts.places[std::size_t(n)], phase);
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

/// Ends of groups: a domain each, or several small ones.
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
    if (parts.places.empty()) return plan;
    const Cells cells = find_cells(parts.places, domain_particles);
    number_particles(cells, parts, plan);
    std::vector<Member> left;
    for (int kind = 0; kind < kKinds; ++kind) {
        const std::size_t count = constraint_count(parts, kind);
        plan.kinds[kind].slots.resize(count);
        for (std::size_t c = 0; c < count; ++c) left.push_back({0, kind, std::int32_t(c)});
    }
    Packer packer(plan, parts);
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
            for (std::size_t m = 0, kind_end = 0; m < group.size(); m = kind_end) {
                while (kind_end < group.size() && group[kind_end].kind == group[m].kind) ++kind_end;
                domain.packs[group[m].kind] =
                    packer.pack(std::span(group).subspan(m, kind_end - m), group[m].kind, spare);
            }
            plan.domains.push_back(domain);
            begin = end;
        }
        plan.phases.push_back({first, std::int32_t(plan.domains.size())});
        most_domains = std::max(most_domains, plan.phases.back().end - first);
    }
    plan.particle_count += kLineParticles * most_domains;
    return plan;
}

}  // namespace pliant::pbd
