// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/packer.h"

#include <algorithm>
#include <bit>

namespace pliant::pbd {

Packer::Packer(const std::vector<std::int32_t>& particle_of, const PbdParts& parts)
    : m_particle_of(particle_of),
      m_parts(parts),
      m_packs_of(parts.positions.size(), 0),
      m_pair_of(parts.positions.size(), -1) {}

PackRange Packer::pack(std::span<const std::int32_t> members, int kind, std::int32_t spare,
                       KindPlan& to) {
    const auto first = std::int32_t(to.constraints.size() / kPack);
    pack_all(members, kind, to);
    const std::int32_t pairs = pair_up(to, kind, first);
    write_corners(to, kind, first, spare);
    return {first, first + 2 * pairs, m_next};
}

/// Packs all members; if memory runs out, no particle is in a pack.
void Packer::pack_all(std::span<const std::int32_t> members, int kind, KindPlan& to) {
    m_first = m_next = std::int32_t(to.constraints.size() / kPack);
    m_open = 0;
    try {
        for (const std::int32_t constraint : members) add(to, kind, constraint);
    } catch (...) {
        std::fill(m_packs_of.begin(), m_packs_of.end(), 0);
        throw;
    }
    while (m_first < m_next) forget_first(to, kind);
}

void Packer::add(KindPlan& to, int kind, std::int32_t constraint) {
    const auto nodes = nodes_of(m_parts, kind, std::size_t(constraint));
    std::uint64_t taken = 0;
    for (const std::int32_t n : nodes) taken |= m_packs_of[std::size_t(n)];
    // In the order of creation: the oldest pack of the window is at its first bit.
    const int turn = m_first % kWindow;
    std::uint64_t free = std::rotr(m_open & ~taken, turn);
    if (free == 0) {
        if (m_next - m_first == kWindow) forget_first(to, kind);
        m_open |= std::uint64_t(1) << (m_next % kWindow);
        m_used[std::size_t(m_next % kWindow)] = 0;
        ++m_next;
        to.constraints.insert(to.constraints.end(), kPack, -1);
        free = std::uint64_t(1) << (m_next - 1 - m_first);
    }
    const std::int32_t pack = m_first + std::countr_zero(free);
    const int slot = pack % kWindow;
    const int lane = m_used[std::size_t(slot)]++;
    if (lane == kPack - 1) m_open &= ~(std::uint64_t(1) << slot);
    to.constraints[std::size_t(pack) * kPack + std::size_t(lane)] = constraint;
    for (const std::int32_t n : nodes) m_packs_of[std::size_t(n)] |= std::uint64_t(1) << slot;
}

void Packer::forget_first(const KindPlan& to, int kind) {
    const std::uint64_t bit = std::uint64_t(1) << (m_first % kWindow);
    for (int lane = 0; lane < kPack; ++lane) {
        const std::int32_t c = to.constraints[std::size_t(m_first) * kPack + std::size_t(lane)];
        if (c < 0) continue;
        for (const std::int32_t n : nodes_of(m_parts, kind, std::size_t(c)))
            m_packs_of[std::size_t(n)] &= ~bit;
    }
    m_open &= ~bit;
    ++m_first;
}

/// Puts packs without common particles side by side, packs without a partner last. The dependency
/// chain of a pack exceeds a processor's out-of-order window; two interleaved packs fill its gaps.
/// @returns the number of pairs
std::int32_t Packer::pair_up(KindPlan& to, int kind, std::int32_t first) {
    const auto pack_begin = [&](std::int32_t pack) {
        return to.constraints.begin() + std::ptrdiff_t(pack) * kPack;
    };
    const auto each_particle = [&](std::int32_t pack, const auto& work) {
        std::for_each(pack_begin(pack), pack_begin(pack + 1), [&](std::int32_t c) {
            if (c < 0) return;
            for (const std::int32_t n : nodes_of(m_parts, kind, std::size_t(c)))
                work(m_pair_of[std::size_t(n)]);
        });
    };
    m_left.clear();
    m_order.clear();
    m_alone.clear();
    for (std::int32_t pack = m_next; pack-- > first;) m_left.push_back(pack);
    std::int32_t pairs = 0;
    while (!m_left.empty()) {
        const std::int32_t pack = m_left.back();
        m_left.pop_back();
        ++m_pair;  // unused mark
        each_particle(pack, [&](std::int32_t& pair) { pair = m_pair; });
        const auto other =
            std::find_if(m_left.rbegin(), m_left.rend(), [&](std::int32_t candidate) {
                bool meets = false;
                each_particle(candidate, [&](std::int32_t& pair) { meets |= pair == m_pair; });
                return !meets;
            });
        if (other == m_left.rend()) {
            m_alone.push_back(pack);
            continue;
        }
        m_order.insert(m_order.end(), {pack, *other});
        m_left.erase(std::next(other).base());
        ++pairs;
    }
    m_order.insert(m_order.end(), m_alone.begin(), m_alone.end());
    m_packs.assign(pack_begin(first), to.constraints.end());
    for (std::size_t n = 0; n < m_order.size(); ++n)
        std::copy_n(m_packs.begin() + std::ptrdiff_t(m_order[n] - first) * kPack, kPack,
                    pack_begin(first + std::int32_t(n)));
    return pairs;
}

void Packer::write_corners(KindPlan& to, int kind, std::int32_t first, std::int32_t spare) const {
    const auto corners = std::size_t(kCorners[kind]);
    to.corners.resize(std::size_t(m_next) * corners * kPack);
    for (auto pack = std::size_t(first); pack < std::size_t(m_next); ++pack)
        for (std::size_t lane = 0; lane < kPack; ++lane) {
            const std::int32_t c = to.constraints[pack * kPack + lane];
            for (std::size_t n = 0; n < corners; ++n) {
                const std::int32_t particle =
                    c < 0 ? spare
                          : m_particle_of[std::size_t(nodes_of(m_parts, kind, std::size_t(c))[n])];
                to.corners[(pack * corners + n) * kPack + lane] = 4 * std::uint32_t(particle);
            }
        }
}

}  // namespace pliant::pbd
