// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Active packs of a plan while part of a body is held: packs with a particle that may move.
// Optionally the constraints with such a particle are repacked domain by domain. In a vessel that
// moves only near the catheter, half of the lanes of the plan's packs are inactive. Repacking
// changes the order of the constraints, though, and results depend on the order if the sub-steps
// are too few for a load.
//
// A domain's packs keep their positions in the plan, in copies made on demand. The assignment of
// constraints to packs depends only on the held particles, not on the history.

#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/aligned_array.h"
#include "pbd/packer.h"

namespace pliant::pbd {

template <class Real>
class AwakePacks {
  public:
    /// @param numbers  of each kind, in the plan's packs. All arguments outlive the object
    AwakePacks(const PbdParts& parts, const Plan& plan, const AlignedVector<Real>* numbers,
               bool anew)
        : m_plan(plan), m_all_numbers(numbers) {
        if (!anew) return;
        m_packer.emplace(plan.particle_of, parts);
        for (const Domain& domain : plan.domains)
            for (int kind = 0; kind < kKinds; ++kind)
                m_states.push_back({domain.packs[kind], {}, true});
    }

    /// @param x  particles: x, y, z, inverse mass
    void update(const Real* x) {
        m_list.clear();
        m_ends.clear();
        for (std::size_t d = 0; d < m_plan.domains.size(); ++d) {
            for (int kind = 0; kind < kKinds; ++kind) {
                const PackRange all = m_plan.domains[d].packs[kind];
                if (m_packer && pack_anew(x, kind, all, d)) {
                    m_list.push_back({});
                    m_list.back().packs[kind] = m_states[d * kKinds + std::size_t(kind)].packs;
                } else {
                    leave_out(x, kind, {all.begin, all.paired_end}, 2);
                    leave_out(x, kind, {all.paired_end, all.end}, 1);
                }
            }
            m_ends.push_back(m_list.size());
        }
    }

    /// Active packs of one of the plan's domains, in sequence.
    std::span<const Domain> of_domain(std::size_t d) const {
        const std::size_t begin = d == 0 ? 0 : m_ends[d - 1];
        return std::span<const Domain>(m_list).subspan(begin, m_ends[d] - begin);
    }
    const std::uint32_t* corners(int kind) const {
        return m_copies[kind] ? m_copies[kind]->corners.data() : m_plan.kinds[kind].corners.data();
    }
    const Real* numbers(int kind) const {
        return m_copies[kind] ? m_numbers[kind].data() : m_all_numbers[kind].data();
    }
    /// Sets a number of a repacked kind; the caller owns the plan's numbers.
    void set_number(int kind, std::size_t at, Real number) {
        if (m_copies[kind]) m_numbers[kind][at] = number;
    }
    /// Slot of a constraint, or −1 if all of its particles are held.
    std::int32_t slot(int kind, std::int32_t constraint) const {
        const KindPlan& at = m_copies[kind] ? *m_copies[kind] : m_plan.kinds[kind];
        return at.slots[std::size_t(constraint)];
    }

  private:
    struct State {
        PackRange packs;
        std::vector<std::int32_t> members;  ///< repacked constraints; empty if none are
        bool is_as_planned;
    };

    /// Removes packs of held particles only, together with their pair.
    /// @param together  number of packs that are kept or removed together
    void leave_out(const Real* x, int kind, std::pair<std::int32_t, std::int32_t> packs,
                   std::int32_t together) {
        const auto corners_of = [&](std::int32_t pack) {
            return m_plan.kinds[kind].corners.begin() +
                   std::ptrdiff_t(pack) * (kCorners[kind] * kPack);
        };
        bool goes_on = false;
        for (std::int32_t pack = packs.first; pack < packs.second; pack += together) {
            const bool awake = std::any_of(corners_of(pack), corners_of(pack + together),
                                           [&](std::uint32_t corner) { return x[corner + 3] > 0; });
            if (awake) {
                if (!goes_on) {
                    m_list.push_back({});
                    m_list.back().packs[kind] = {pack, pack, pack};
                }
                PackRange& range = m_list.back().packs[kind];
                range.end = pack + together;
                if (together == 2) range.paired_end = range.end;
            }
            goes_on = awake;
        }
    }

    /// @returns false if the plan's packs are as good
    bool pack_anew(const Real* x, int kind, PackRange all, std::size_t d) {
        State& state = m_states[d * kKinds + std::size_t(kind)];
        find_members(x, kind, all);
        if (8 * m_members.size() > 7 * m_count) {
            if (!state.is_as_planned) restore(kind, all);
            state.is_as_planned = true;
            return false;
        }
        if (!state.is_as_planned && m_members == state.members) return true;
        state.members.reserve(m_members.size());  // if memory runs out, the state is unchanged
        state.is_as_planned = !repack(kind, all, m_plan.spares[d], state.packs);
        state.members = m_members;
        return !state.is_as_planned;
    }

    void find_members(const Real* x, int kind, PackRange range) {
        const KindPlan& plan = m_plan.kinds[kind];
        const auto corners = std::size_t(kCorners[kind]);
        m_members.clear();
        m_count = 0;
        for (auto pack = std::size_t(range.begin); pack < std::size_t(range.end); ++pack)
            for (std::size_t lane = 0; lane < kPack; ++lane) {
                const std::int32_t c = plan.constraints[pack * kPack + lane];
                if (c < 0) continue;
                ++m_count;
                bool moves = false;
                for (std::size_t n = 0; n < corners; ++n)
                    moves |= x[plan.corners[(pack * corners + n) * kPack + lane] + 3] > 0;
                if (moves) m_members.push_back(c);
            }
    }
    void make_copies(int kind) {
        if (m_copies[kind]) return;
        m_numbers[kind] = m_all_numbers[kind];
        m_copies[kind] = m_plan.kinds[kind];
    }
    void restore(int kind, PackRange range) {
        const KindPlan& from = m_plan.kinds[kind];
        const auto copy = [&](const auto& source, auto& target, std::size_t per_pack) {
            std::copy(source.begin() + std::ptrdiff_t(std::size_t(range.begin) * per_pack),
                      source.begin() + std::ptrdiff_t(std::size_t(range.end) * per_pack),
                      target.begin() + std::ptrdiff_t(std::size_t(range.begin) * per_pack));
        };
        copy(from.constraints, m_copies[kind]->constraints, kPack);
        copy(from.corners, m_copies[kind]->corners, std::size_t(kCorners[kind] * kPack));
        copy(m_all_numbers[kind], m_numbers[kind], std::size_t(kNumbers[kind] * kPack));
        find_slots(*m_copies[kind], std::size_t(range.begin) * kPack,
                   std::size_t(range.end) * kPack);
    }

    /// @returns false if that needs more packs, which has never occurred
    bool repack(int kind, PackRange all, std::int32_t spare, PackRange& packs) {
        make_copies(kind);
        KindPlan& to = *m_copies[kind];
        m_scratch.constraints.clear();
        m_scratch.corners.clear();
        const PackRange found = m_packer->pack(m_members, kind, spare, m_scratch);
        if (found.end > all.end - all.begin) {
            restore(kind, all);
            return false;
        }
        for (auto slot = std::size_t(all.begin) * kPack; slot < std::size_t(all.end) * kPack;
             ++slot)
            if (const std::int32_t c = m_plan.kinds[kind].constraints[slot]; c >= 0)
                to.slots[std::size_t(c)] = -1;
        const auto begin = std::size_t(all.begin), corners = std::size_t(kCorners[kind]) * kPack;
        std::copy(m_scratch.constraints.begin(), m_scratch.constraints.end(),
                  to.constraints.begin() + std::ptrdiff_t(begin * kPack));
        std::copy(m_scratch.corners.begin(), m_scratch.corners.end(),
                  to.corners.begin() + std::ptrdiff_t(begin * corners));
        find_slots(to, begin * kPack, (begin + std::size_t(found.end)) * kPack);
        for (std::size_t slot = 0; slot < m_scratch.constraints.size(); ++slot)
            if (const std::int32_t c = m_scratch.constraints[slot]; c >= 0)
                copy_numbers(kind, std::size_t(m_plan.kinds[kind].slots[std::size_t(c)]),
                             begin * kPack + slot);
        packs = {all.begin, all.begin + found.paired_end, all.begin + found.end};
        return true;
    }
    /// Empty lanes keep their old numbers, which are valid.
    void copy_numbers(int kind, std::size_t from, std::size_t to) {
        const auto count = std::size_t(kNumbers[kind]);
        for (std::size_t n = 0; n < count; ++n)
            m_numbers[kind][(to / kPack * count + n) * kPack + to % kPack] =
                m_all_numbers[kind][(from / kPack * count + n) * kPack + from % kPack];
    }

    const Plan& m_plan;
    const AlignedVector<Real>* m_all_numbers;
    std::optional<Packer> m_packer;
    std::vector<Domain> m_list;
    std::vector<std::size_t> m_ends;  ///< [domain] in m_list
    std::vector<State> m_states;      ///< [domain][kind]
    std::optional<KindPlan> m_copies[kKinds];
    AlignedVector<Real> m_numbers[kKinds];
    std::vector<std::int32_t> m_members;
    std::size_t m_count = 0;
    KindPlan m_scratch;
};

}  // namespace pliant::pbd
